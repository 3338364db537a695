// Compares two pictures bit by bit, or by the size of the error.
#pragma once

#include "pipeline/check/report.h"
#include "pipeline/contract/image.h"

namespace thixo {

/// Compares A with the reference B. Problems are another size, and channels that are missing, extra or stored in
/// another type. So are values in A or B that are not finite, and bits that differ. With max_rel_mse > 0, bits may
/// differ as long as no channel's relMSE is above it. Header texts are not compared: they name what a frame was made
/// from.
FrameReport compare_pictures(const std::string& name, const Image& a, const Image& b, double max_rel_mse);

/// The picture with its channels A, Z, N, albedo, P, motion, body and Cryptomatte alone. These tell of the first surface
/// and carry no noise of light. Equal seeds and samples give these the same bits, however light is sampled.
Image without_noise(const Image& image);

}  // namespace thixo
