// Reads the point files of a cache byte by byte. OpenVDB's own reader trusts the lengths that it finds in a file: a
// wrong one ends in an assertion, or in memory of others. Here every length is compared with the file's size, with the
// number of points and with the other lengths, before anything is allocated or copied.
#pragma once

#include <string>
#include <string_view>

#include "pipeline/contract/point_set.h"

namespace thixo {

/// Metadata of the grid: names and types of the attributes in their order ("P:vec3f id:int64 ..."), and how many points.
inline constexpr const char* kTypesKey = "thixo_attributes";
inline constexpr const char* kCountKey = "thixo_count";

/// A point file may hold this many times its own size in values. Blosc's LZ4 packs 255 times at most. An attribute that
/// is equal all over a leaf of the densest lattice of particles packs 800 times.
inline constexpr std::size_t kLargestExpansion = 1100;

/// The points of a .vdb file, in the layout that encode_points (vdb_points.h) writes: OpenVDB's file version 224, one
/// point grid, Blosc pages. "P" [m] comes first, points in voxel order. `file` is named in messages. Throws CacheError
/// where a byte is none that encode_points could write there, if what is read depends on that byte. Throws
/// ResourceError where the values exceed the machine's memory. Does not look at the checksum.
PointSet read_vdb_points(std::string_view bytes, const std::string& file);

}  // namespace thixo
