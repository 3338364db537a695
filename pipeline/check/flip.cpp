#include "pipeline/check/flip.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "pipeline/base/error.h"
#include "pipeline/base/math.h"
#include "pipeline/base/parallel.h"

namespace thixo {
namespace {

constexpr double kPixelsPerDegree = 67;
constexpr double kColourPower = 0.7, kFeaturePower = 0.5;  // q_c and q_f of the paper
constexpr double kTurn = 0.4, kTurned = 0.95;              // p_c and p_t: where the map of colour errors bends
constexpr double kFeatureWidth = 0.082;                    // of edges and points [degree]

using Plane = std::vector<float>;
using Kernel = std::vector<double>;  // 2r + 1 weights
using Planes = std::array<Plane, 3>;

struct Size {
    int width, height;
};

/// Linear Rec.709 to XYZ over the white of D65.
const Mat3d& xyz_of_rgb() {
    static const Mat3d over_white = [] {
        Mat3d m;
        m << 0.4124564, 0.3575761, 0.1804375, 0.2126729, 0.7151522, 0.0721750, 0.0193339, 0.1191920, 0.9503041;
        const Vec3d white = m * Vec3d::Ones();
        return Mat3d(white.cwiseInverse().asDiagonal() * m);
    }();
    return over_white;
}

/// Opponent colours in which the eye's filters act: linear in light.
Vec3d to_opponent(const Vec3d& rgb) {
    const Vec3d v = xyz_of_rgb() * rgb;
    return {116 * v.y() - 16, 500 * (v.x() - v.y()), 200 * (v.y() - v.z())};
}
Vec3d from_opponent(const Vec3d& c) {
    const double y = (c.x() + 16) / 116;
    static const Mat3d rgb_of_xyz = xyz_of_rgb().inverse();
    return rgb_of_xyz * Vec3d(y + c.y() / 500, y, y - c.z() / 200);
}

/// CIE L*a*b*, with a and b less important in the dark (Hunt).
Vec3d to_hunt_lab(const Vec3d& rgb) {
    const Vec3d xyz = xyz_of_rgb() * rgb;
    const Vec3d f = xyz.unaryExpr([](double t) {
        constexpr double d = 6.0 / 29;
        return t > d * d * d ? std::cbrt(t) : t / (3 * d * d) + 4.0 / 29;
    });
    const double l = 116 * f.y() - 16;
    return {l, 0.01 * l * 500 * (f.x() - f.y()), 0.01 * l * 200 * (f.y() - f.z())};
}

/// Distance of large colour differences: lightness by its size, hue and chroma together.
double hyab(const Vec3d& a, const Vec3d& b) {
    const Vec3d d = a - b;
    return std::abs(d.x()) + std::hypot(d.y(), d.z());
}

/// Convolution along rows or columns; the border is repeated.
Plane filtered(const Plane& in, Size size, const Kernel& kernel, bool rows) {
    Plane out(in.size());
    const int radius = static_cast<int>(kernel.size() / 2);
    parallel_for(static_cast<std::size_t>(size.height), [&](std::size_t row) {
        const int y = static_cast<int>(row);
        for (int x = 0; x < size.width; ++x) {
            double sum = 0;
            for (int k = -radius; k <= radius; ++k) {
                const int u = rows ? std::clamp(x + k, 0, size.width - 1) : x;
                const int v = rows ? y : std::clamp(y + k, 0, size.height - 1);
                sum += kernel[static_cast<std::size_t>(k + radius)] *
                       double(in[static_cast<std::size_t>(v) * static_cast<std::size_t>(size.width) +
                                 static_cast<std::size_t>(u)]);
            }
            out[row * static_cast<std::size_t>(size.width) + static_cast<std::size_t>(x)] = static_cast<float>(sum);
        }
    });
    return out;
}
Plane filtered(const Plane& in, Size size, const Kernel& along_rows, const Kernel& along_columns) {
    return filtered(filtered(in, size, along_rows, true), size, along_columns, false);
}

Kernel sampled(int radius, const std::function<double(double)>& value) {
    Kernel kernel;
    for (int k = -radius; k <= radius; ++k) kernel.push_back(value(k));
    return kernel;
}
Kernel normalised(Kernel kernel) {
    double sum = 0;
    for (const double w : kernel) sum += w;
    for (double& w : kernel) w /= sum;
    return kernel;
}

/// A Gaussian of the eye's contrast sensitivity, of the form
///     sqrt(pi/b) exp(-pi^2 x^2/b)      x in degrees
Kernel sensitivity(double b, int radius) {
    return sampled(radius, [b](double x) { return std::exp(-square(kPi * x / kPixelsPerDegree) / b); });
}

/// Filters of the three opponent channels. Blue against yellow needs two Gaussians; each is separable, and their sum is
/// not.
Planes seen(const Planes& opponent, Size size) {
    constexpr double kWidest = 0.04;
    const int radius = static_cast<int>(std::ceil(3 * std::sqrt(kWidest / (2 * kPi * kPi)) * kPixelsPerDegree));
    Planes out;
    const std::array<double, 2> b{0.0047, 0.0053};
    for (std::size_t c = 0; c < 2; ++c) {
        const Kernel kernel = normalised(sensitivity(b[c], radius));
        out[c] = filtered(opponent[c], size, kernel, kernel);
    }
    const std::array<double, 2> a{34.1, 13.5}, width{0.04, 0.025};
    std::array<Kernel, 2> kernels;
    std::array<double, 2> weight{};
    for (std::size_t k = 0; k < 2; ++k) {
        const Kernel raw = sensitivity(width[k], radius);
        double sum = 0;
        for (const double w : raw) sum += w;
        weight[k] = a[k] * std::sqrt(kPi / width[k]) * square(sum);
        kernels[k] = normalised(raw);
    }
    const Plane first = filtered(opponent[2], size, kernels[0], kernels[0]);
    const Plane second = filtered(opponent[2], size, kernels[1], kernels[1]);
    out[2].resize(first.size());
    for (std::size_t i = 0; i < first.size(); ++i)
        out[2][i] = static_cast<float>((weight[0] * double(first[i]) + weight[1] * double(second[i])) /
                                       (weight[0] + weight[1]));
    return out;
}

/// How much of an edge and of a point there is at each pixel, of the lightness.
std::array<Plane, 2> features(const Plane& lightness, Size size) {
    const double sigma = 0.5 * kFeatureWidth * kPixelsPerDegree;
    const int radius = static_cast<int>(std::ceil(3 * sigma));
    const auto gauss = [sigma](double x) { return std::exp(-square(x) / (2 * square(sigma))); };
    const Kernel smooth = normalised(sampled(radius, gauss));
    // Positive weights add up to 1, negative ones to -1.
    const auto balanced = [](Kernel kernel) {
        double above = 0, below = 0;
        for (const double w : kernel) (w > 0 ? above : below) += std::abs(w);
        for (double& w : kernel) w /= w > 0 ? above : below;
        return kernel;
    };
    const Kernel first = balanced(sampled(radius, [&](double x) { return -x * gauss(x); }));
    const Kernel second = balanced(sampled(radius, [&](double x) { return (square(x / sigma) - 1) * gauss(x); }));
    std::array<Plane, 2> out;
    for (std::size_t k = 0; k < 2; ++k) {
        const Kernel& kernel = k == 0 ? first : second;
        const Plane x = filtered(lightness, size, kernel, smooth), y = filtered(lightness, size, smooth, kernel);
        out[k].resize(x.size());
        for (std::size_t i = 0; i < x.size(); ++i) out[k][i] = std::hypot(x[i], y[i]);
    }
    return out;
}

/// A picture as the eye has it.
struct View {
    Planes colours;  // Hunt's L*a*b* after the eye's filters
    std::array<Plane, 2> features;
};

View view_of(const Image& image) {
    const Size size{image.width, image.height};
    const std::array<const Plane*, 3> rgb{&image.get("R"), &image.get("G"), &image.get("B")};
    Planes opponent;
    for (Plane& plane : opponent) plane.resize(image.pixels());
    Plane lightness(image.pixels());
    for (std::size_t i = 0; i < image.pixels(); ++i) {
        Vec3d c;
        for (int k = 0; k < 3; ++k) {
            const double v = double((*rgb[static_cast<std::size_t>(k)])[i]);
            c[k] = std::isfinite(v) ? std::clamp(v, 0.0, 1.0) : 0;
        }
        const Vec3d o = to_opponent(c);
        for (int k = 0; k < 3; ++k) opponent[static_cast<std::size_t>(k)][i] = static_cast<float>(o[k]);
        lightness[i] = static_cast<float>((o.x() + 16) / 116);
    }
    View view{seen(opponent, size), features(lightness, size)};
    for (std::size_t i = 0; i < image.pixels(); ++i) {
        const Vec3d light = from_opponent({view.colours[0][i], view.colours[1][i], view.colours[2][i]});
        const Vec3d lab = to_hunt_lab(light.cwiseMax(0.0).cwiseMin(1.0));
        for (int k = 0; k < 3; ++k) view.colours[static_cast<std::size_t>(k)][i] = static_cast<float>(lab[k]);
    }
    return view;
}

/// Colour errors from 0 to 1. Small ones take most of the range.
double bent(double error) {
    static const double most = std::pow(hyab(to_hunt_lab({0, 1, 0}), to_hunt_lab({0, 0, 1})), kColourPower);
    const double turn = kTurn * most;
    return error < turn ? kTurned / turn * error : kTurned + (error - turn) / (most - turn) * (1 - kTurned);
}

bool is_finite(const Image& image, std::size_t i) {
    return std::ranges::all_of(std::array{"R", "G", "B"},
                               [&](const char* name) { return std::isfinite(image.get(name)[i]); });
}

}  // namespace

std::vector<float> flip_map(const Image& a, const Image& b) {
    THIXO_ASSERT(a.width == b.width && a.height == b.height, "pictures of {} x {} and {} x {}", a.width, a.height,
                 b.width, b.height);
    const View of_a = view_of(a), of_b = view_of(b);
    const auto colour = [](const View& v, std::size_t i) {
        return Vec3d(v.colours[0][i], v.colours[1][i], v.colours[2][i]);
    };
    std::vector<float> map(a.pixels());
    for (std::size_t i = 0; i < map.size(); ++i) {
        const double colours = std::min(bent(std::pow(hyab(colour(of_a, i), colour(of_b, i)), kColourPower)), 1.0);
        double feature = 0;
        for (std::size_t k = 0; k < 2; ++k)
            feature = std::max(feature, std::abs(double(of_a.features[k][i]) - double(of_b.features[k][i])));
        feature = std::clamp(std::pow(feature / std::sqrt(2.0), kFeaturePower), 0.0, 1.0);
        map[i] = is_finite(a, i) && is_finite(b, i) ? static_cast<float>(std::pow(colours, 1 - feature)) : 1.0f;
    }
    return map;
}

double mean_flip(const Image& a, const Image& b) {
    const std::vector<float> map = flip_map(a, b);
    double sum = 0;
    for (const float v : map) sum += double(v);
    return map.empty() ? 0 : sum / double(map.size());
}

}  // namespace thixo
