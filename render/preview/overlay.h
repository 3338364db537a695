// Words and legends on a finished picture.
#pragma once

#include <string>

#include "pipeline/contract/frame.h"
#include "pipeline/contract/image.h"
#include "render/preview/splats.h"

namespace thixo::preview {

/// Writes text with its top left corner at (x, y), `scale` pixels a dot of the 5 x 7 font. What falls outside is cut
/// off. Characters the font lacks become boxes. Returns the x where the text ends.
int draw_text(Image8& picture, int x, int y, int scale, const Vec3f& colour, const std::string& text);
int text_width(const std::string& text, int scale);

/// Top left: frame, time, count. Bottom left: the legend with the values at both ends.
void draw_labels(Image8& picture, const Legend& legend, const Frame& frame, std::size_t count, const char* what);

}  // namespace thixo::preview
