#include "pipeline/check/welch.h"

#include <cmath>

#include "pipeline/base/error.h"
#include "pipeline/base/math.h"

namespace thixo {
namespace {

/// The continued fraction of the incomplete beta function, by Lentz's method (DLMF 8.17.22). It converges quickly for
/// x < (a + 1)/(a + b + 2).
double beta_fraction(double a, double b, double x) {
    constexpr int kTerms = 10'000;
    constexpr double kTiny = 1e-300, kPrecise = 1e-14;
    const auto kept = [](double v) { return std::abs(v) < kTiny ? kTiny : v; };
    double c = 1, d = 1 / kept(1 - (a + b) * x / (a + 1)), sum = d;
    for (int m = 1; m < kTerms; ++m) {
        const double even = m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m));
        d = 1 / kept(1 + even * d);
        c = kept(1 + even / c);
        sum *= d * c;
        const double odd = -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1));
        d = 1 / kept(1 + odd * d);
        c = kept(1 + odd / c);
        sum *= d * c;
        if (std::abs(d * c - 1) < kPrecise) break;
    }
    return sum;
}

/// I_x(a, b), the regularised incomplete beta function.
double incomplete_beta(double a, double b, double x) {
    if (x <= 0 || x >= 1) return x <= 0 ? 0 : 1;
    const double front =
        std::exp(std::lgamma(a + b) - std::lgamma(a) - std::lgamma(b) + a * std::log(x) + b * std::log1p(-x));
    if (x < (a + 1) / (a + b + 2)) return front * beta_fraction(a, b, x) / a;
    return 1 - front * beta_fraction(b, a, 1 - x) / b;
}

}  // namespace

double student_tail(double t, double freedom) {
    THIXO_ASSERT(freedom > 0, "{} degrees of freedom", freedom);
    constexpr double kNormal = 1e5;  // from here on the normal distribution is as good to four digits
    if (freedom > kNormal) return std::erfc(std::abs(t) / std::sqrt(2.0));
    return incomplete_beta(freedom / 2, 0.5, freedom / (freedom + square(t)));
}

void WelchSum::add_variance(double estimated, double freedom, double known) {
    variance += estimated + known;
    squares += square(estimated) / freedom;
}

double WelchSum::probability() const {
    if (variance <= 0) return difference == 0 ? 1 : 0;
    const double t = difference / std::sqrt(variance);
    return squares > 0 ? student_tail(t, square(variance) / squares) : std::erfc(std::abs(t) / std::sqrt(2.0));
}

}  // namespace thixo
