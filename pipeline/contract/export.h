// Frames of a cache for other tools.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "pipeline/contract/cache.h"

namespace thixo {

enum class ExportFormat { ply, vtp, csv };
enum class ExportWhat { particles, surfels };

/// "ply", "vtp", "csv"; "particles", "surfels". Throws InputError.
ExportFormat parse_export_format(std::string_view text);
ExportWhat parse_export_what(std::string_view text);

/// Points of one frame as the bytes of a file, in ascending id where they have one.
///
/// - ply: binary, little endian. It holds x y z, nx ny nz (from N), radius (from pscale), then every other attribute. A
///   vector v becomes v_x v_y v_z, and 64-bit integers become doubles.
/// - vtp: VTK XML poly data, raw appended. Every attribute is point data, and ids are 64-bit integers.
/// - csv: a header of attribute names, then one row a point. A vector v becomes v.x,v.y,v.z. Numbers read back to the
///   same bits.
std::string export_points(const PointSet& points, ExportFormat format);

/// <what>.NNNN.<format> for every frame, into out_dir; for vtp also <what>.pvd, the collection with times. Returns the
/// files written. Throws CacheError (a frame is not in the cache, or damaged) and ResourceError.
std::vector<std::filesystem::path> export_cache(const CacheReader& reader, const std::vector<int>& frames,
                                                ExportFormat format, ExportWhat what,
                                                const std::filesystem::path& out_dir);

}  // namespace thixo
