// Where two pictures differ, to look at.
#pragma once

#include "pipeline/contract/image.h"

namespace thixo {

/// Three panels side by side: A, B, and their difference, the largest over all channels, as a heat map from dark red
/// (any differing bit) by the square root of the difference to white (the largest). A and B are shown by R, G, B (or
/// their first channel), clamped to [0, 1]. Requires equal sizes.
Image8 difference_picture(const Image& a, const Image& b);

}  // namespace thixo
