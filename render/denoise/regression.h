// First-order regression of a noisy picture on its features.
#pragma once

#include "render/denoise/guides.h"

namespace thixo::render {

inline constexpr int kWindow = 8;  // pixels to each side that a pixel is fitted to

/// One half of the samples, filtered with weights that the other half gives. Around each pixel p, the colour is a
/// linear function of the features f:
///
///   c_p(q) = a_p + B_p (f_q - f_p)
///
/// It is fitted to the window by weights w_pq. The result at q is the mean of what all windows say of it,
///   sum_p w_pq c_p(q) / sum_p w_pq.
/// Bitterli et al. 2016, "Nonlinearly weighted first-order regression for denoising Monte Carlo renderings", with the
/// features in `guides` already filtered. First the picture, then every light group, by the weights of the picture.
std::vector<Planes> regress(const Guides& guides, int half);

}  // namespace thixo::render
