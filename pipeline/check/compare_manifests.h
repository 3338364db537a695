// What two manifests say beyond the frames and assets that they list.
#pragma once

#include <string>
#include <vector>

#include "pipeline/contract/manifest.h"

namespace thixo {

/// One line for each difference that does not make a check fail: scene name, resolved scene, simulation hash,
/// completeness. A check compares results, and equal results may come from different scene files. The format number is
/// left out, because it follows from the assets. Frames and assets are compared from their files.
std::vector<std::string> manifest_notes(const Manifest& a, const Manifest& b);

/// One line for each fact that differs between the entries of one frame. Only their times are compared. A reader has
/// verified the counts, sizes and checksums against the files. Checksums may differ between equal frames, because
/// points may be stored in another order.
std::vector<std::string> compare_entries(const ManifestFrame& a, const ManifestFrame& b);

}  // namespace thixo
