// A picture: samples of pixels, summed.
#pragma once

#include <functional>
#include <vector>

#include "pipeline/contract/image.h"
#include "render/passes.h"

namespace thixo::render {

struct FilmSettings {
    int samples = 16;                    // at most, where there is a noise target
    float noise = 0;                     // visible noise at which a tile has enough; 0: all samples
    std::uint64_t seed = 1;              // frame number included
    int x0 = 0, y0 = 0, x1 = 0, y1 = 0;  // pixels to render; x1 = 0: all of the camera's
    Strategy strategy = Strategy::both;
    bool denoise = false;  // needs two samples
};

/// Renders with all threads. A pixel is a function of scene, seed, samples, noise target and its own coordinates. It
/// has the same bits at any thread count and for any crop, since tiles are those of the whole picture. The channels are
/// those of kPasses. Denoised, R, G and B have no noise left, and `noisy` holds them as they were. A crop is rendered with
/// a margin of kDenoiseReach pixels then. `progress` is called with pixels done out of all from any thread. It returns false to stop; then
/// InterruptedError is thrown.
Image render(const World& world, const FilmSettings& settings, const std::function<bool(int, int)>& progress = {});

}  // namespace thixo::render
