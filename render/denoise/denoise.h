// A denoiser of our own: it takes the noise from a picture that few samples leave, led by what is seen without noise.
#pragma once

#include "render/denoise/guides.h"

namespace thixo::render {

/// How far a pixel looks around itself [pixels].
inline constexpr int kDenoiseReach = 40;

struct Denoised {
    Planes light;                // radiance, three planes
    std::vector<Planes> groups;  // of each light group
};

/// The radiance of every pixel without its noise. The two halves are filtered with each other's weights
/// and averaged. A pixel depends on what is given within kDenoiseReach of it alone. So a part of a picture with such a
/// margin has the bits of the whole. Light groups are filtered by the weights of the picture. Hence they still add
/// up to it, but where it would have fallen below zero.
Denoised denoise(Guides guides);

}  // namespace thixo::render
