#include "pipeline/geometry/surface_sampling.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "pipeline/base/parallel.h"
#include "pipeline/geometry/bounds.h"
#include "pipeline/geometry/even_points.h"
#include "pipeline/geometry/point_grid.h"
#include "pipeline/geometry/point_surfels.h"
#include "pipeline/geometry/shape_checks.h"
#include "pipeline/geometry/sheet_guides.h"

namespace thixo {
namespace {

constexpr int kSweeps = 12;
constexpr std::size_t kFew = 4096;  // surfels from which the area of a surface is estimated
constexpr double kWidest = 1.25;    // the points serve spacings up to this factor times the estimate
constexpr Real kCovered =
    Real(0.8);  // largest distance of a random point from a surfel, in radii, as other points may lie between them

/// The area of the faces up to `reach` beyond their edges.
double area_within(const SolidPoints& points, double reach) {
    std::size_t count = 0;
    for (const FacePoints& f : points.faces)
        count += static_cast<std::size_t>(
            std::count_if(f.beyond.begin(), f.beyond.end(), [&](Real b) { return static_cast<double>(b) < reach; }));
    return points.area * static_cast<double>(count);
}
double area_on_surface(const SolidPoints& points) { return area_within(points, 1e-30); }

/// Area of the surface where the solid is too thin for it [m^2].
double thin_area(const SolidPoints& points) {
    double thin = 0;
    for (const FacePoints& f : points.faces) thin += static_cast<double>(f.thin);
    return points.area * thin;
}

/// The spacing at which the area, with that beyond the edges, has one square for each of `count` surfels.
double spacing_for(const SolidPoints& points, std::size_t count, double widest) {
    double low = 0, high = widest;
    for (int i = 0; i < 50; ++i) {
        const double middle = (low + high) / 2;
        const bool room = area_within(points, kSheetReach * middle) > static_cast<double>(count) * square(middle);
        (room ? low : high) = middle;
    }
    return (low + high) / 2;
}

/// The spacing at which a box would have one square for each of `count` surfels.
double spacing_by_box(const Box3& bounds, std::size_t count) {
    const Vec3d size = (bounds.upper - bounds.lower).cast<double>();
    const double area = 2 * (size.x() * size.y() + size.y() * size.z() + size.z() * size.x());
    return std::sqrt(area / static_cast<double>(count));
}

bool mostly_thin(const SolidPoints& points) { return thin_area(points) > area_on_surface(points); }

[[noreturn]] void refuse_thin(double spacing) {
    throw InputError(
        "most of the shape is thinner than {:.3g} m, too thin for surfels {:.3g} m apart; make it thicker, or take "
        "more "
        "and smaller surfels",
        kThinnest * spacing, spacing);
}

/// Refuses at once what is in a box so flat that no part of it can be thick enough. Surfels by count stand apart by at
/// least a thirtieth of what their box gives.
void refuse_flat(const Box3& box, const SurfaceSampling& sampling) {
    const double thickest = static_cast<double>((box.upper - box.lower).minCoeff());
    const double apart = sampling.count > 0 ? spacing_by_box(box, sampling.count) : sampling.spacing;
    if (thickest < kThinnest * (sampling.count > 0 ? apart / 30 : apart)) refuse_thin(apart);
}

/// Random points, and the spacing that gives the wanted count, near a first guess. Where most of the solid is too thin
/// for that spacing, the points are of no use.
SolidPoints points_for_count(const FacedSolid& solid, const SurfaceSampling& sampling, double guess, double& spacing) {
    constexpr int kThirds = 3;  // a surface of less than a seven hundredth of its box's is none
    for (int i = 0, thirds = 0; i < 12 && thirds <= kThirds; ++i) {
        const double reach = kWidest * kSheetReach * guess;
        SolidPoints points = points_on_faces(solid, guess, reach, sampling.seed);
        if (mostly_thin(points)) {
            const double area = thin_area(points) + area_on_surface(points);
            spacing = std::sqrt(area / static_cast<double>(sampling.count));
            if (guess <= kWidest * spacing) return points;
            guess = spacing;
        } else if (area_on_surface(points) > 0) {
            spacing = spacing_for(points, sampling.count, 16 * guess);
            if (spacing > 0.75 * guess && spacing <= kWidest * guess) return points;
            guess = spacing;
        } else {
            guess /= 3;
            ++thirds;
        }
    }
    const Vec3d size = (solid.bounds.upper - solid.bounds.lower).cast<double>();
    throw InputError("a shape of the size {} x {} x {} m has no surface that {} surfels could cover", size.x(),
                     size.y(), size.z(), sampling.count);
}

/// Random points. `spacing` becomes the spacing that gives the wanted count.
SolidPoints find_points(const FacedSolid& solid, const SurfaceSampling& sampling, double& spacing) {
    if (sampling.spacing > 0) {
        spacing = sampling.spacing;
        return points_on_faces(solid, spacing, kSheetReach * spacing, sampling.seed);
    }
    double guess = spacing_by_box(solid.bounds, sampling.count);
    // A few points are enough to estimate the area.
    if (sampling.count >= 4 * kFew) {
        double few = 0;
        points_for_count(solid, {.count = kFew, .spacing = 0, .seed = sampling.seed},
                         spacing_by_box(solid.bounds, kFew), few);
        guess = few * std::sqrt(static_cast<double>(kFew) / static_cast<double>(sampling.count));
    }
    return points_for_count(solid, sampling, guess, spacing);
}

/// The number of surfels of each face, in proportion to area. The largest remainders are rounded up.
std::vector<std::size_t> shares(const std::vector<std::size_t>& points, std::size_t count) {
    const double total = static_cast<double>(std::accumulate(points.begin(), points.end(), std::size_t(0)));
    std::vector<std::size_t> share(points.size()), order(points.size());
    std::vector<double> rest(points.size());
    std::size_t given = 0;
    for (std::size_t k = 0; k < points.size(); ++k) {
        const double exact = static_cast<double>(count) * static_cast<double>(points[k]) / total;
        share[k] = static_cast<std::size_t>(exact);
        rest[k] = exact - std::floor(exact);
        given += share[k];
        order[k] = k;
    }
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return rest[a] > rest[b]; });
    for (std::size_t k = 0; given < count; ++given, ++k) ++share[order[k % order.size()]];
    return share;
}

Sheet sample_face(const Face& face, const FacePoints& points, const std::vector<Index>& within, std::size_t count,
                  Real spacing) {
    std::vector<Vec3> position, normal;
    for (const Index i : within) {
        position.push_back(points.position[i]);
        normal.push_back(points.normal[i]);
    }
    Sheet sheet;
    std::vector<char> fixed;
    for (const Index i : even_subset(position, normal, count, spacing)) {
        sheet.position.push_back(position[i]);
        sheet.normal.push_back(normal[i]);
        fixed.push_back(points.beyond[within[i]] > static_cast<Real>(kSheetReach - 0.6) * spacing);
    }
    relax(face, sheet.position, sheet.normal, fixed, spacing, kSweeps);
    return sheet;
}

/// Radii of a sheet's discs: the spacing, and more where it is needed to cover every random point of the surface.
std::vector<Real> radii_of(const Sheet& sheet, const FacePoints& points, Real spacing) {
    std::vector<Real> radius(sheet.position.size(), spacing);
    PointGrid grid;
    grid.build(sheet.position, 2 * spacing);
    std::vector<std::pair<Real, Index>> nearest(points.position.size(), {0, kNone});
    parallel_for(points.position.size(), [&](std::size_t i) {
        if (points.beyond[i] > 0) return;
        Real best = square(2 * spacing);
        grid.for_each_neighbour(points.position[i], 2 * spacing, [&](Index j, Real r2) {
            if (r2 < best && points.normal[i].dot(sheet.normal[j]) > 0) {
                best = r2;
                nearest[i] = {std::sqrt(r2), j};
            }
        });
    });
    for (const auto& [distance, j] : nearest)
        if (j != kNone) radius[j] = std::max(radius[j], distance / kCovered);
    return radius;
}

void add_colours(const Shape& shape, SampledSurface& surface) {
    std::vector<std::optional<Vec3f>> found(surface.surfels.size());
    parallel_for(found.size(), [&](std::size_t i) { found[i] = shape.node().colour(surface.surfels.position[i]); });
    if (std::none_of(found.begin(), found.end(), [](const auto& c) { return c.has_value(); })) return;
    for (const auto& c : found) surface.colour.push_back(c.value_or(Vec3f::Ones()));
}

SampledSurface one_for_every_point(const Shape& shape) {
    const auto points = shape.node().own_surfels();
    if (!points)
        throw InputError("a surface needs a count of surfels or their spacing, unless it is a mesh or a set of points");
    SampledSurface result;
    result.surfels = points->surfels;
    result.colour = points->colour;
    result.sheet.assign(result.surfels.size(), 0);
    result.area = points->area;
    result.spacing = std::sqrt(points->area / static_cast<double>(result.surfels.size()));
    return result;
}

}  // namespace

SampledSurface sample_surface(const Shape& shape, const SurfaceSampling& sampling) {
    size_not_negative(sampling.spacing, "surfel spacing");
    if (sampling.count > 0 && sampling.spacing > 0)
        throw InputError("a surface is sampled by a count of surfels or by their spacing; give one of the two");
    if (sampling.count == 0 && sampling.spacing == 0) return one_for_every_point(shape);
    const auto box = shape.bounds();
    if (!box) throw InputError("an unbounded shape has no closed surface to sample; intersect it with a box");
    refuse_flat(*box, sampling);
    const FacedSolid solid(shape, *box, sampling.count > 0 ? spacing_by_box(*box, sampling.count) : sampling.spacing);
    SampledSurface result;
    const SolidPoints points = find_points(solid, sampling, result.spacing);
    result.area = area_on_surface(points);
    if (mostly_thin(points)) refuse_thin(result.spacing);
    if (!(result.area > 0))
        throw InputError("a shape has no surface that surfels {} m apart could cover", result.spacing);
    const Real spacing = static_cast<Real>(result.spacing);

    std::vector<std::vector<Index>> within(points.faces.size());
    std::vector<std::size_t> found;
    for (std::size_t k = 0; k < within.size(); ++k) {
        for (Index i = 0; i < points.faces[k].beyond.size(); ++i)
            if (points.faces[k].beyond[i] < static_cast<Real>(kSheetReach) * spacing) within[k].push_back(i);
        found.push_back(within[k].size());
    }
    const double total = area_within(points, kSheetReach * result.spacing);
    const std::vector<std::size_t> share =
        shares(found, sampling.count > 0 ? sampling.count
                                         : static_cast<std::size_t>(std::lround(total / square(result.spacing))));
    std::vector<Sheet> sheets;
    for (std::size_t k = 0; k < within.size(); ++k)
        sheets.push_back(sample_face(solid.faces[k], points.faces[k], within[k], share[k], spacing));

    std::vector<int> number;
    SheetTree tree = settle_sheets(solid, sheets, spacing, number);
    for (std::size_t k = 0; k < sheets.size(); ++k) {
        const std::vector<Real> radius = radii_of(sheets[k], points.faces[k], spacing);
        for (std::size_t i = 0; i < radius.size(); ++i) {
            const Vec3& n = sheets[k].normal[i];
            Vec3 a, b;
            orthonormal_basis(n, a, b);
            result.surfels.position.push_back(sheets[k].position[i]);
            result.surfels.normal.push_back(n);
            result.surfels.axis1.push_back(radius[i] * a);
            result.surfels.axis2.push_back(radius[i] * b);
            result.sheet.push_back(number[k]);
        }
    }
    result.sheets = 1 + *std::max_element(number.begin(), number.end());
    if (result.sheets > 1) result.trim = std::move(tree);
    add_colours(shape, result);
    return result;
}

}  // namespace thixo
