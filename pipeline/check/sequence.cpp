#include "pipeline/check/sequence.h"

#include <algorithm>
#include <cmath>

#include "pipeline/base/math.h"
#include "pipeline/check/flip.h"

namespace thixo {

std::optional<PictureMeasures> Sequence::next(const Image& a, const Image& b) {
    constexpr std::array<const char*, 3> kColours{"R", "G", "B"};
    const bool follows = difference_[0].size() == a.pixels();
    double sum_a = 0, sum_b = 0, change = 0;
    std::size_t finite = 0;
    for (std::size_t c = 0; c < kColours.size(); ++c) {
        const ImageChannel *of_a = a.find(kColours[c]), *of_b = b.find(kColours[c]);
        if (!of_a || !of_b) {
            interrupt();
            return {};
        }
        std::vector<float> difference(a.pixels());
        for (std::size_t i = 0; i < difference.size(); ++i) {
            const float x = of_a->values[i], y = of_b->values[i];
            difference[i] = x - y;
            if (!std::isfinite(x) || !std::isfinite(y)) continue;
            sum_a += double(x);
            sum_b += double(y);
            if (!follows || !std::isfinite(difference_[c][i])) continue;
            ++finite;
            change += square(double(difference[i]) - double(difference_[c][i])) / (square(double(y)) + 0.01);
        }
        difference_[c] = std::move(difference);
    }
    PictureMeasures measures;
    const auto differs = [](const std::vector<float>& d) {
        return std::ranges::any_of(d, [](float x) { return x != 0; });
    };
    measures.flip = std::ranges::any_of(difference_, differs) ? mean_flip(a, b) : 0;
    measures.brightness = sum_a == sum_b ? 1 : sum_a / sum_b;
    if (follows) measures.flicker = finite > 0 ? change / double(finite) : 0;
    return measures;
}

}  // namespace thixo
