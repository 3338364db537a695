#include "render/black_body.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "render/warp.h"

namespace thixo::render {
namespace {

// The colour matching functions x, y, z of the CIE's standard observer of 1931 (ISO/CIE 11664-1), every 10 nm.
constexpr double kFirst = 380, kStep = 10;  // nm
constexpr std::array<std::array<double, 3>, 41> kObserver{{
    {0.001368, 0.000039, 0.006450}, {0.004243, 0.000120, 0.020050}, {0.014310, 0.000396, 0.067850},
    {0.043510, 0.001210, 0.207400}, {0.134380, 0.004000, 0.645600}, {0.283900, 0.011600, 1.385600},
    {0.348280, 0.023000, 1.747060}, {0.336200, 0.038000, 1.772110}, {0.290800, 0.060000, 1.669200},
    {0.195360, 0.090980, 1.287640}, {0.095640, 0.139020, 0.812950}, {0.032010, 0.208020, 0.465180},
    {0.004900, 0.323000, 0.272000}, {0.009300, 0.503000, 0.158200}, {0.063270, 0.710000, 0.078250},
    {0.165500, 0.862000, 0.042160}, {0.290400, 0.954000, 0.020300}, {0.433450, 0.994950, 0.008750},
    {0.594500, 0.995000, 0.003900}, {0.762100, 0.952000, 0.002100}, {0.916300, 0.870000, 0.001650},
    {1.026300, 0.757000, 0.001100}, {1.062200, 0.631000, 0.000800}, {1.002600, 0.503000, 0.000340},
    {0.854450, 0.381000, 0.000190}, {0.642400, 0.265000, 0.000050}, {0.447900, 0.175000, 0.000020},
    {0.283500, 0.107000, 0.000000}, {0.164900, 0.061000, 0.000000}, {0.087400, 0.032000, 0.000000},
    {0.046770, 0.017000, 0.000000}, {0.022700, 0.008210, 0.000000}, {0.011359, 0.004102, 0.000000},
    {0.005790, 0.002091, 0.000000}, {0.002899, 0.001047, 0.000000}, {0.001440, 0.000520, 0.000000},
    {0.000690, 0.000249, 0.000000}, {0.000332, 0.000120, 0.000000}, {0.000166, 0.000060, 0.000000},
    {0.000083, 0.000030, 0.000000}, {0.000042, 0.000015, 0.000000},
}};
constexpr double kRadiation1 = 1.191042972e-16;  // 2 h c^2 [W m^2/sr]
constexpr double kRadiation2 = 0.01438776877;    // h c/k [m K]

/// Linear Rec.709 (primaries of Rec.709, white D65) of a colour, with luminance 1 and nothing below 0.
Vec3d rec709(const Vec3d& xyz) {
    Mat3d m;
    m << 3.2404542, -1.5371385, -0.4985314, -0.9692660, 1.8760108, 0.0415560, 0.0556434, -0.2040259, 1.0572252;
    const Vec3d colour = (m * xyz / xyz.y()).cwiseMax(0.0);
    return colour / double(luminance(colour.cast<float>()));
}

/// ln Y and colour, evenly over 1/sqrt(T): over that ln Y bends little, for hot matter and for cold.
class Table {
  public:
    struct Light {
        double log_luminance;
        Vec3d colour;
    };
    Table() {
        for (int k = 0; k <= kCells; ++k) {
            const Vec3d xyz = black_body_xyz(1 / square(kFirstCell + k * kCell));
            lights_.push_back({std::log(xyz.y()), rec709(xyz)});
        }
    }
    Light at(double kelvin) const {
        const double x = std::clamp((1 / std::sqrt(kelvin) - kFirstCell) / kCell, 0.0, double(kCells));
        const int k = std::min(int(x), kCells - 1);
        const Light &a = lights_[std::size_t(k)], &b = lights_[std::size_t(k) + 1];
        const double part = x - k;
        return {(1 - part) * a.log_luminance + part * b.log_luminance, (1 - part) * a.colour + part * b.colour};
    }
    static constexpr double kColdest = 250;  // K

  private:
    static constexpr int kCells = 4096;
    // 1/sqrt(K): of 1e5 K, and from there on
    static constexpr double kFirstCell = 0.0031622776601683795, kCell = (0.06324555320336758 - kFirstCell) / kCells;
    std::vector<Light> lights_;
};

}  // namespace

Vec3d black_body_xyz(double kelvin) {
    Vec3d xyz = Vec3d::Zero();
    for (std::size_t k = 0; k < kObserver.size(); ++k) {
        const double l = 1e-9 * (kFirst + kStep * double(k));
        const double radiance = kRadiation1 / (square(square(l)) * l) / std::expm1(kRadiation2 / (l * kelvin));
        xyz += 1e-9 * kStep * radiance * Vec3d(kObserver[k].data());
    }
    return xyz;
}

Vec3f black_body_radiance(float kelvin, float reference) {
    static const Table table;
    if (!(double(kelvin) >= Table::kColdest)) return {0, 0, 0};
    const Table::Light light = table.at(double(kelvin));
    const double ratio = std::exp(light.log_luminance - table.at(double(reference)).log_luminance);
    return (ratio * light.colour).cast<float>();
}

}  // namespace thixo::render
