// Cracks painted by a picture that is projected onto a body. Dissertation 5.6.6.
#pragma once

#include <vector>

#include "pipeline/contract/scene_solids.h"
#include "sim/state/cracks.h"

namespace thixo {

/// The lines of a picture on the surface of the body, in its material frame, for paint_crack [m]. Dark strokes are thinned
/// and traced (image_lines.h). Points in steps of a row go straight ahead from the picture to where they first meet the body. Parts of
/// a line that miss the body are left out. So are steps of the surface that the picture does not see: the line is
/// parted there. Throws InputError where the file is missing, damaged, or another one.
/// So it does where no line is in it, where one misses the body wholly, and where the picture stands within the body.
std::vector<std::vector<Vec3>> lines_of_image(const scene::CrackImage& image, const Breaking& breaking);

}  // namespace thixo
