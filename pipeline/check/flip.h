// How different two pictures look when one flips from one to the other: the measure FLIP (P. Andersson et al.,
// "FLIP: A Difference Evaluator for Alternating Images", Proc. ACM Comput. Graph. Interact. Tech. 3(2), 2020).
#pragma once

#include <vector>

#include "pipeline/contract/image.h"

namespace thixo {

/// FLIP of every pixel, from 0 (no difference) to 1. R, G and B are taken as scene-linear Rec.709 and clamped to
/// [0, 1]; values that are not finite count as 1. The screen has 67 pixels a degree, as the paper supposes (0.7 m from
/// a 0.7 m wide screen of 3840 pixels). Requires equal sizes and the channels R, G, B.
std::vector<float> flip_map(const Image& a, const Image& b);

/// The mean of flip_map.
double mean_flip(const Image& a, const Image& b);

}  // namespace thixo
