#include "sim/space/sampling.h"

#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "pipeline/base/error.h"
#include "pipeline/base/parallel.h"
#include "pipeline/geometry/shapes.h"
#include "sim/space/endless.h"

namespace thixo {
namespace {

constexpr double kMostSites = 2147483647.0;
constexpr double kVolumeCell = 0.25;   // of the cells that a shape's volume is summed over [spacings]
constexpr double kVolumeError = 1e-3;  // of a packing's volume, that is sought
constexpr double kScaleStep = 2.5e-3;  // from one scale of a packing to the next
constexpr int kScales = 16;            // to either side: four per cent
// Steps from the outermost rows of a solid to its faces along x, y, z, a row's own shift to and fro apart.
const Vec3d kSolidMargin(0.3, 0.25, 0.2);
const Vec3d kLiquidMargin(0.5, 0.5, 0.5);

// A centred row of sites whose outermost stand `margin` steps inside: their count, and the coordinate of the first.
struct Row {
    int count;
    double first;
};
Row centred_row(double lower, double upper, double step, double margin) {
    const double fit = std::max(1.0, std::round((upper - lower) / step + 1 - 2 * margin));
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

namespace {

/// How a packing lies in a shape's box.
struct Fit {
    Vec3d stretch{1, 1, 1};  // along each axis
    Vec3d margin = kLiquidMargin;
};

/// The sites of a stretched packing in the shape, and how many more stand where they are not allowed.
struct Sites {
    std::vector<Vec3> position;
    std::size_t refused = 0;
    std::size_t count() const { return position.size() + refused; }
};

Sites sites_in(const Shape& shape, Real spacing, const Fit& fit, const std::function<bool(const Vec3&)>& allowed,
               const Periodic& periodic) {
    const auto bounds = shape.bounds();
    if (!bounds) throw InputError("a body's shape has no bounds; intersect it with a box");
    const Vec3d steps = packing_steps(spacing).cwiseProduct(fit.stretch);
    std::array<int, 3> outside{1, 1, 0};  // sites beyond the box's rows that odd rows and layers may bring into it
    const auto row = [&](int a) {
        const Periodic::Axis& axis = periodic.axis[static_cast<std::size_t>(a)];
        if (!axis.on) return centred_row(bounds->lower[a], bounds->upper[a], steps[a], fit.margin[a]);
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
    const Vec3 scale = fit.stretch.cast<Real>();
    std::vector<Sites> layers(static_cast<std::size_t>(z.count));
    parallel_for(
        layers.size(),
        [&](std::size_t k) {
            for (int j = -outside[1]; j < y.count + outside[1]; ++j)
                for (int i = -outside[0]; i < x.count + outside[0]; ++i) {
                    const Vec3 site = origin + scale.cwiseProduct(packing_site(i, j, static_cast<int>(k), spacing));
                    if (!(shape.distance(site) < 0)) continue;
                    if (allowed(site))
                        layers[k].position.push_back(site);
                    else
                        ++layers[k].refused;
                }
        },
        1);
    Sites all;
    for (const Sites& layer : layers) {
        all.position.insert(all.position.end(), layer.position.begin(), layer.position.end());
        all.refused += layer.refused;
    }
    return all;
}

/// The stretch by which rows fill the box up to the margin; that of the period along periodic axes. Along each axis there
/// are two numbers of rows next to what would fit. Those are taken that change a site's volume least, and then its
/// proportions. With `even`, layers are stretched alike along x and y, as the shorter of the two asks. A site then has its
/// neighbours evenly about it. So a uniform stress has no force in the packing.
Fit fit_to_box(const Box3& box, Real spacing, const Vec3d& margin, const Periodic& periodic, bool even) {
    const Vec3d steps = packing_steps(spacing), size = (box.upper - box.lower).cast<double>();
    const int longer = size.y() < size.x() ? 0 : 1;
    std::vector<int> axes;
    for (int a = 0; a < 3; ++a)
        if (!periodic.axis[static_cast<std::size_t>(a)].on && !(even && a == longer)) axes.push_back(a);
    Fit best{packing_stretch(spacing, periodic), margin};
    double least = std::numeric_limits<double>::infinity();
    for (int choice = 0; choice < 1 << axes.size(); ++choice) {
        Fit fit{packing_stretch(spacing, periodic), margin};
        for (std::size_t k = 0; k < axes.size(); ++k) {
            const int a = axes[k];
            const double between = 2 * margin[a] - 1;  // steps across the box over rows
            const double rows = std::floor(size[a] / steps[a] - between) + (choice >> k & 1);
            if (rows > 1 || between == 0)
                fit.stretch[a] = size[a] / ((std::max(1.0, rows) + between) * steps[a]);
            else
                fit.margin[a] = 0.5;  // a single row stands in the middle
        }
        if (even) fit.stretch[longer] = fit.stretch[1 - longer];
        if (even) fit.margin[longer] = 0.5;
        const Vec3d logarithm = fit.stretch.array().log();
        const double change = 4 * square(logarithm.sum()) + logarithm.squaredNorm();
        if (!(change < least)) continue;
        least = change;
        best = fit;
    }
    return best;
}

/// The rotation that lays the short side of a flat box along z.
Quatd upright(const Box3& box) {
    const Vec3 size = box.upper - box.lower;
    const auto turned = [](int times) {
        return Quatd(Eigen::AngleAxisd(times * 2 * kPi / 3, Vec3d(1, 1, 1).normalized()));
    };
    constexpr Real kShorter = Real(0.5);  // of both others
    if (size.x() < kShorter * std::min(size.y(), size.z())) return turned(2);
    if (size.y() < kShorter * std::min(size.x(), size.z())) return turned(1);
    return Quatd::Identity();
}

}  // namespace

std::vector<Vec3> pack_shape(const Shape& shape, Real spacing, const std::function<bool(const Vec3&)>& allowed,
                             const Periodic& periodic) {
    return sites_in(shape, spacing, {.stretch = packing_stretch(spacing, periodic)}, allowed, periodic).position;
}

FittedPacking fit_packing(const Shape& shape, Real spacing, const std::function<bool(const Vec3&)>& allowed,
                          const Periodic& periodic) {
    const auto box = shape.bounds();
    if (!box) throw InputError("a body's shape has no bounds; intersect it with a box");
    const Fit fitted = fit_to_box(*box, spacing, kLiquidMargin, periodic, false);
    const double site = cube(static_cast<double>(spacing)) * fitted.stretch.prod();
    Sites sites = sites_in(shape, spacing, fitted, allowed, periodic);
    const double volume = thixo::volume(shape, kVolumeCell * static_cast<double>(spacing));
    FittedPacking best;
    double least = std::numeric_limits<double>::infinity();
    for (int k = 0; least > kVolumeError; ++k) {
        const double scale = 1 + kScaleStep * ((k + 1) / 2) * (k % 2 ? 1 : -1);
        if (k > 0) sites = sites_in(shape, spacing, {.stretch = scale * fitted.stretch}, allowed, periodic);
        const auto count = static_cast<double>(sites.count());
        if (const double off = std::abs(count * site * cube(scale) / volume - 1); count > 0 && off < least) {
            least = off;
            best = {std::move(sites.position), volume / count};
        }
        if (k == 2 * kScales || periodic.any()) break;
    }
    return best;
}

SampledVolume pack_solid(const Shape& shape, Real spacing, const Periodic& periodic) {
    const auto anywhere = [](const Vec3&) { return true; };
    const auto box = shape.bounds();
    if (!box) throw InputError("a body's shape has no bounds; intersect it with a box");
    const Quatd turn = periodic.any() ? Quatd::Identity() : upright(*box);
    const Vec3d centre = (0.5 * (box->lower + box->upper)).cast<double>();
    const Shape lying = periodic.any() ? shape : transformed(shape, 1, turn, turn * -centre);
    const Fit fit = fit_to_box(*lying.bounds(), spacing, kSolidMargin, periodic, !periodic.any());
    const Vec3d cell = packing_steps(spacing).cwiseProduct(fit.stretch);
    const Shape filled = periodic.any() ? endless(shape, periodic) : lying;
    SampledVolume sites;
    sites.position = sites_in(lying, spacing, fit, anywhere, periodic).position;
    sites.spacing.assign(sites.position.size(), spacing);
    sites.volume.resize(sites.position.size());
    parallel_for(sites.position.size(), [&](std::size_t k) {
        sites.volume[k] = static_cast<Real>(volume_inside(filled, sites.position[k], cell));
    });
    if (periodic.any()) return sites;
    for (Vec3& x : sites.position) x = (turn.conjugate() * x.cast<double>() + centre).cast<Real>();
    return sites;
}

}  // namespace thixo
