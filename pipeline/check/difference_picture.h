// A picture that shows where two pictures differ.
#pragma once

#include "pipeline/contract/image.h"

namespace thixo {

/// Three panels side by side: A, B, and a heat map of the largest difference over all channels. The heat map goes from
/// dark red (any differing bit) to white (the largest difference), by the square root of the difference. A and B are
/// shown by R, G, B, or by their first channel, clamped to [0, 1]. Requires equal sizes.
Image8 difference_picture(const Image& a, const Image& b);

}  // namespace thixo
