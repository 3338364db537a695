// Makes the sheets of a sampled solid tell inside from outside wherever the trim tree asks them.
#pragma once

#include <vector>

#include "pipeline/geometry/face_points.h"
#include "pipeline/geometry/sheet_tree.h"

namespace thixo {

/// The surfels of one face.
struct Sheet {
    std::vector<Vec3> position, normal;
};

/// The tree over the sheets. Where a face has no surfels and is on one side of all others', that side takes its place
/// and it is dropped. Where the nearest surfel of a sheet would put a surfel of another on the wrong side of it, so
/// that what is kept there changes, the sheet gets one more surfel at the foot point: none of these is seen, they are
/// trimmed themselves. Returns face -> sheet in `number`, -1 for those that are dropped.
SheetTree settle_sheets(const FacedSolid& solid, std::vector<Sheet>& sheets, Real spacing, std::vector<int>& number);

}  // namespace thixo
