#include "sim/sampling.h"

#include <cmath>

#include "pipeline/base/error.h"
#include "pipeline/base/parallel.h"

namespace thixo {
namespace {

constexpr double kMostSites = 2147483647.0;

int remainder2(int a) { return a & 1; }

// Sites from the first to the last that fit into `extent`, centred: the count and the coordinate of the first.
struct Row {
    int count;
    double first;
};
Row centred_row(double lower, double upper, double step) {
    const double fit = std::max(1.0, std::round((upper - lower) / step));
    if (fit > kMostSites) return {0x7fffffff, lower};
    return {static_cast<int>(fit), 0.5 * (lower + upper) - 0.5 * (fit - 1) * step};
}

}  // namespace

Real packing_layer(Real spacing) { return packing_distance(spacing) * std::sqrt(Real(2.0 / 3.0)); }

Vec3 packing_site(int i, int j, int k, Real spacing) {
    const Real a = packing_distance(spacing);
    const Real odd_layer = remainder2(k) ? Real(1) : Real(0);
    return a * Vec3(Real(i) + Real(0.5) * static_cast<Real>(remainder2(j + k)),
                    std::sqrt(Real(3)) / 2 * (Real(j) + odd_layer / 3), std::sqrt(Real(2.0 / 3.0)) * Real(k));
}

std::vector<Vec3> pack_shape(const Shape& shape, Real spacing, const std::function<bool(const Vec3&)>& allowed) {
    const auto bounds = shape.bounds();
    if (!bounds) throw InputError("a body's shape has no bounds; intersect it with a box");
    const double a = packing_distance(spacing);
    const Row x = centred_row(bounds->lower.x(), bounds->upper.x(), a);
    const Row y = centred_row(bounds->lower.y(), bounds->upper.y(), a * std::sqrt(3.0) / 2);
    const Row z = centred_row(bounds->lower.z(), bounds->upper.z(), packing_layer(spacing));
    if (static_cast<double>(x.count) * y.count * z.count > kMostSites)
        throw InputError("a body of {} x {} x {} particles is too many; raise solver.spacing", x.count, y.count,
                         z.count);
    // Odd rows stand half a site further along x, odd layers a third of a row along y: the mean of both keeps the
    // packing centred.
    const Vec3 origin(static_cast<Real>(x.first - 0.25 * a), static_cast<Real>(y.first - a * std::sqrt(3.0) / 12),
                      static_cast<Real>(z.first));
    std::vector<std::vector<Vec3>> layers(static_cast<std::size_t>(z.count));
    parallel_for(
        layers.size(),
        [&](std::size_t k) {
            for (int j = -1; j <= y.count; ++j)
                for (int i = -1; i <= x.count; ++i) {
                    const Vec3 site = origin + packing_site(i, j, static_cast<int>(k), spacing);
                    if (shape.distance(site) < 0 && allowed(site)) layers[k].push_back(site);
                }
        },
        1);
    std::vector<Vec3> sites;
    for (const auto& layer : layers) sites.insert(sites.end(), layer.begin(), layer.end());
    return sites;
}

}  // namespace thixo
