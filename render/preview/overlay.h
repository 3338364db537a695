// Words and legends on a finished picture.
#pragma once

#include <string>

#include "pipeline/contract/frame.h"
#include "pipeline/contract/image.h"
#include "render/preview/splats.h"
#include "render/preview/view.h"

namespace thixo::preview {

/// Writes text with its top left corner at (x, y), `scale` pixels a dot of the 5 x 7 font. What falls outside is cut
/// off. Characters the font lacks become boxes. Returns the x where the text ends.
int draw_text(Image8& picture, int x, int y, int scale, const Vec3f& colour, const std::string& text);
int text_width(const std::string& text, int scale);

/// The colour of fronts of cracks: a warm red that no scale has.
inline const Vec3f kFrontColour{0.85f, 0.13f, 0.10f};

/// Draws the fronts of the frame's cracks as lines over all else, with a dot at each node. Nodes are at points less the
/// origin, as points are. What lies behind the camera is left out.
void draw_fronts(Image8& picture, const View& view, const std::vector<FrameFront>& fronts);

/// Top left: frame, time, count. Bottom left: the legend with the values at both ends.
void draw_labels(Image8& picture, const Legend& legend, const Frame& frame, std::size_t count, const char* what);

}  // namespace thixo::preview
