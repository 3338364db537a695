#include "sim/space/sampling.h"

#include <array>
#include <cmath>

#include "pipeline/base/error.h"
#include "pipeline/base/parallel.h"

namespace thixo {
namespace {

constexpr double kMostSites = 2147483647.0;

// A centred row of sites within `extent`: their count, and the coordinate of the first.
struct Row {
    int count;
    double first;
};
Row centred_row(double lower, double upper, double step) {
    const double fit = std::max(1.0, std::round((upper - lower) / step));
    if (fit > kMostSites) return {0x7fffffff, lower};
    return {static_cast<int>(fit), 0.5 * (lower + upper) - 0.5 * (fit - 1) * step};
}

// Rows and layers repeat after two.
int sites_in_period(const Periodic& periodic, int a, double step) {
    const double period = periodic.period(a);
    return a == 0 ? std::max(1, static_cast<int>(std::lround(period / step)))
                  : 2 * std::max(1, static_cast<int>(std::lround(period / (2 * step))));
}

}  // namespace

Vec3d packing_stretch(Real spacing, const Periodic& periodic) {
    const Vec3d steps = packing_steps(spacing);
    Vec3d stretch(1, 1, 1);
    for (int a = 0; a < 3; ++a)
        if (periodic.axis[static_cast<std::size_t>(a)].on)
            stretch[a] = static_cast<double>(periodic.period(a)) / (sites_in_period(periodic, a, steps[a]) * steps[a]);
    return stretch;
}

std::vector<Vec3> pack_shape(const Shape& shape, Real spacing, const std::function<bool(const Vec3&)>& allowed,
                             const Periodic& periodic) {
    const auto bounds = shape.bounds();
    if (!bounds) throw InputError("a body's shape has no bounds; intersect it with a box");
    const Vec3d stretch = packing_stretch(spacing, periodic);
    const Vec3d steps = packing_steps(spacing).cwiseProduct(stretch);
    std::array<int, 3> outside{1, 1, 0};  // sites beyond the box's rows that odd rows and layers may bring into it
    const auto row = [&](int a) {
        const Periodic::Axis& axis = periodic.axis[static_cast<std::size_t>(a)];
        if (!axis.on) return centred_row(bounds->lower[a], bounds->upper[a], steps[a]);
        outside[static_cast<std::size_t>(a)] = 0;
        return Row{sites_in_period(periodic, a, packing_steps(spacing)[a]),
                   static_cast<double>(axis.from) + 0.5 * steps[a]};
    };
    const Row x = row(0), y = row(1), z = row(2);
    if (static_cast<double>(x.count) * y.count * z.count > kMostSites)
        throw InputError("a body of {} x {} x {} particles is too many; raise solver.spacing", x.count, y.count,
                         z.count);
    // Odd rows stand half a site further along x, odd layers a third of a row along y. The mean of both keeps the
    // packing centred.
    const Vec3 origin(static_cast<Real>(x.first - 0.25 * steps.x()), static_cast<Real>(y.first - steps.y() / 6),
                      static_cast<Real>(z.first));
    const Vec3 scale = stretch.cast<Real>();
    std::vector<std::vector<Vec3>> layers(static_cast<std::size_t>(z.count));
    parallel_for(
        layers.size(),
        [&](std::size_t k) {
            for (int j = -outside[1]; j < y.count + outside[1]; ++j)
                for (int i = -outside[0]; i < x.count + outside[0]; ++i) {
                    const Vec3 site = origin + scale.cwiseProduct(packing_site(i, j, static_cast<int>(k), spacing));
                    if (shape.distance(site) < 0 && allowed(site)) layers[k].push_back(site);
                }
        },
        1);
    std::vector<Vec3> sites;
    for (const auto& layer : layers) sites.insert(sites.end(), layer.begin(), layer.end());
    return sites;
}

}  // namespace thixo
