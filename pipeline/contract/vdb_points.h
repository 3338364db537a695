// A PointSet as the bytes of an OpenVDB point grid, the form Houdini and other tools read.
#pragma once

#include <string>
#include <string_view>

#include "pipeline/contract/point_set.h"

namespace thixo {

/// The voxel edge for points `spacing` [m] apart: the largest power of two not above twice the spacing, and 2^-16 m at
/// least. For a power of two "P" survives the voxel-relative storage without any rounding.
double voxel_size_for(double spacing);

/// The bytes of a .vdb file with one point grid called `name`. Voxel edge [m]: `voxel_size`, stored as the grid's
/// transform, which carries the origin of the points too. Values are float32 and integers, Blosc-compressed, lossless: where voxel_size is a power of two the
/// positions too, else to 1e-7 voxel and one rounding. Equal point sets give equal bytes: the header's UUID is the
/// checksum of the file. Requires the attribute "P" (Vec3f) where count > 0, all arrays of `count`, different names.
/// Throws DivergedError where a value is not finite or lies too far from the origin to be resolved (8e6 voxels), naming
/// attribute and point.
std::string encode_points(const PointSet& points, const std::string& name, double voxel_size);

/// The points in voxel order, "P" first. Verifies the file's own checksum before it parses; `file` is named in
/// messages. Throws CacheError.
PointSet decode_points(std::string_view bytes, const std::string& file);

/// Whether the bytes are a .vdb file that carries its own checksum, as encode_points writes it.
bool is_own_points(std::string_view bytes);

}  // namespace thixo
