// Two pictures of one thing that differ in their noise: whether they differ in anything else.
#pragma once

#include <string>
#include <vector>

#include "pipeline/check/report.h"
#include "pipeline/contract/image.h"

namespace thixo {

/// How often a check of two results that differ in noise alone fails all the same.
inline constexpr double kFalseAlarms = 1e-3;

/// Tests the means of R, G and B over the whole picture, over regions of 64 x 64 pixels and over tiles of 16 x 16 by
/// Welch's test. The variance pass tells how much noise there is. Each of the three levels has a third of
/// `false_alarms`, divided equally among its tests (Bonferroni). Of each level the least probable test that fails is a
/// problem. So are pictures without variance pass, with one sample a pixel, or with values that are not finite. Requires
/// equal sizes.
NoiseDifference compare_noisy(const Image& a, const Image& b, double false_alarms, std::vector<std::string>& problems);

}  // namespace thixo
