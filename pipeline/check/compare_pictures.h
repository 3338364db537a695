// Two pictures, bit by bit and by size of error.
#pragma once

#include "pipeline/check/report.h"
#include "pipeline/contract/image.h"

namespace thixo {

/// A against the reference B. Problems: another size, channels missing, extra or stored in another type, values that
/// are not finite (in either), and bits that differ; with max_rel_mse > 0 differing bits pass while no channel's relMSE
/// is above it. Header texts are not compared: they name what a frame was made from.
FrameReport compare_pictures(const std::string& name, const Image& a, const Image& b, double max_rel_mse);

}  // namespace thixo
