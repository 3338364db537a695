// Lets the sheets of a sampled solid tell inside from outside at every place where the trim tree evaluates them.
#pragma once

#include <vector>

#include "pipeline/geometry/face_points.h"
#include "pipeline/geometry/sheet_tree.h"

namespace thixo {

/// The surfels of one face.
struct Sheet {
    std::vector<Vec3> position, normal;
};

/// Makes the tree over the sheets. A face without surfels that has all other surfels on one side is dropped, and that
/// side takes its place. The nearest surfel of a sheet may put a surfel of another sheet on its wrong side. Where this
/// changes whether the surfel is kept, the sheet gets one more surfel at the foot point. These surfels are trimmed and
/// so never seen. `number` maps faces to sheets, with -1 for dropped faces.
SheetTree settle_sheets(const FacedSolid& solid, std::vector<Sheet>& sheets, Real spacing, std::vector<int>& number);

}  // namespace thixo
