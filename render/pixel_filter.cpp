#include "render/pixel_filter.h"

#include <cmath>
#include <vector>

namespace thixo::render {

PixelFilter::PixelFilter() {
    constexpr int fine = 8192;
    std::vector<double> sum(fine + 1, 0.0);
    for (int i = 0; i < fine; ++i) {
        const double t = 2 * kPi * (i + 0.5) / fine;
        sum[i + 1] = sum[i] + 0.35875 - 0.48829 * std::cos(t) + 0.14128 * std::cos(2 * t) - 0.01168 * std::cos(3 * t);
    }
    int i = 0;
    for (int k = 0; k <= kSteps; ++k) {
        const double goal = sum[fine] * k / kSteps;
        while (i + 1 < fine && sum[i + 1] < goal) ++i;
        const double within = (goal - sum[i]) / (sum[i + 1] - sum[i]);
        inverse_[k] = float(kRadius * (2 * (i + clamp01(within)) / fine - 1));
    }
}

}  // namespace thixo::render
