// Sheets trimmed by boolean trees: sharp-edged bodies against their exact shape.
#include "render/trim.h"

#include <gtest/gtest.h>

#include <functional>

#include "pipeline/base/error.h"
#include "pipeline/base/parallel.h"
#include "tests/render/surfel_shapes.h"

namespace thixo::render {
namespace {

using shapes::on_sphere;
using Op = TrimNode::Op;

TrimNode sheet(int k) { return {Op::sheet, k, {}}; }

/// A body under construction: sheets that reach past the creases, and the signed distance of the exact solid.
struct Body {
    SurfelCloud cloud;
    std::vector<std::uint32_t> layer;
    std::uint32_t sheets = 0;
    TrimNode tree;
    std::function<double(const Vec3d&)> solid;  // < 0 inside; its zero is exact, its size a bound of the distance
    float radius = 0.05f;

    int begin_sheet() { return int(sheets++); }
    void disc(const Vec3f& x, const Vec3f& n) {
        if (!near_patch(x.cast<double>(), n.cast<double>())) return;
        shapes::add_disc(cloud, x, n, radius);
        layer.push_back(sheets - 1);
    }
    /// Whether the solid's surface runs along the sheet within two and a half radii.
    bool near_patch(const Vec3d& x, const Vec3d& n) const {
        Vec3d a, b;
        orthonormal_basis(n, a, b);
        for (int k = 0; k <= 40; ++k) {
            const double r = k == 0 ? 0 : double(radius) * 0.5 * (1 + (k - 1) / 8), phi = k * kPi / 4;
            const Vec3d p = x + r * (std::cos(phi) * a + std::sin(phi) * b);
            const double step = 0.3 * double(radius);
            if ((solid(p + step * n) < 0) != (solid(p - step * n) < 0)) return true;
        }
        return false;
    }
    /// A square lattice in the plane n.x = offset.
    int plane(const Vec3f& n, float offset) {
        const int k = begin_sheet();
        Vec3f a, b;
        orthonormal_basis(n, a, b);
        const float step = radius;
        for (float u = -1.6f; u < 1.6f; u += step)
            for (float v = -1.6f; v < 1.6f; v += step) disc(offset * n + (u + 0.3f * step) * a + v * b, n);
        return k;
    }
    int sphere(const Vec3f& centre, float r) {
        const int k = begin_sheet();
        const auto n = std::size_t(4 * kPi * double(r * r) / double(radius * radius));
        for (std::size_t i = 0; i < n; ++i) disc(centre + r * shapes::fibonacci(i, n), shapes::fibonacci(i, n));
        return k;
    }
    int cylinder(float r) {  // about z
        const int k = begin_sheet();
        const int columns = int(2 * kPi * double(r / radius)) + 1;
        for (float z = -1.2f; z < 1.2f; z += radius)
            for (int i = 0; i < columns; ++i) {
                const float u = float(2 * kPi * (i + 0.31) / columns);
                const Vec3f out(std::cos(u), std::sin(u), 0);
                disc(r * out + Vec3f(0, 0, z), out);
            }
        return k;
    }
    SurfelSet set() const {
        SurfelSet s;
        s.cloud = cloud;
        s.layer = layer;
        s.object.assign(sheets, 0);
        s.trim = {tree};
        return s;
    }
};

double box_distance(const Vec3d& x, const Vec3d& half) { return (x.cwiseAbs() - half).maxCoeff(); }

Body cube(float radius) {
    Body b;
    b.radius = radius;
    b.solid = [](const Vec3d& x) { return box_distance(x, {0.5, 0.5, 0.5}); };
    b.tree.op = Op::all;
    for (int axis = 0; axis < 3; ++axis)
        for (const float side : {1.0f, -1.0f}) b.tree.parts.push_back(sheet(b.plane(side * Vec3f::Unit(axis), 0.5f)));
    return b;
}

Body lens(float radius) {
    Body b;
    b.radius = radius;
    b.solid = [](const Vec3d& x) {
        return std::max((x - Vec3d(0, 0, 0.6)).norm() - 0.8, (x + Vec3d(0, 0, 0.6)).norm() - 0.8);
    };
    b.tree = {Op::all, 0, {sheet(b.sphere({0, 0, 0.6f}, 0.8f)), sheet(b.sphere({0, 0, -0.6f}, 0.8f))}};
    return b;
}

/// A cylinder from which a sphere and a slanted plane have taken their part.
Body cut_cylinder(float radius) {
    Body b;
    b.radius = radius;
    const Vec3f slant = Vec3f(0.5f, 0, 1).normalized();
    b.solid = [slant](const Vec3d& x) {
        return std::max({std::hypot(x.x(), x.y()) - 0.5, -x.z() - 0.5, slant.cast<double>().dot(x) - 0.3,
                         0.3 - (x - Vec3d(0.5, 0, -0.2)).norm()});
    };
    const int side = b.cylinder(0.5f), floor = b.plane({0, 0, -1}, 0.5f), top = b.plane(slant, 0.3f),
              bite = b.sphere({0.5f, 0, -0.2f}, 0.3f);
    b.tree = {Op::except, 0, {{Op::all, 0, {sheet(side), sheet(floor), sheet(top)}}, sheet(bite)}};
    return b;
}

/// A wheel with eight slots: a cylinder between planes, less wedges of three planes each.
Body gear(float radius) {
    constexpr int teeth = 8;
    Body b;
    b.radius = radius;
    const auto turned = [](int k, const Vec3d& x) -> Vec3d {
        return Eigen::AngleAxisd(-2 * kPi * k / teeth, Vec3d::UnitZ()) * x;
    };
    b.solid = [turned](const Vec3d& x) {
        double d = std::max(std::hypot(x.x(), x.y()) - 0.8, std::abs(x.z()) - 0.2);
        for (int k = 0; k < teeth; ++k) {
            const Vec3d y = turned(k, x);
            d = std::max(d, -std::max({0.55 - y.x(), y.y() - 0.13, -y.y() - 0.13}));
        }
        return d;
    };
    TrimNode wheel{
        Op::all, 0, {sheet(b.cylinder(0.8f)), sheet(b.plane({0, 0, 1}, 0.2f)), sheet(b.plane({0, 0, -1}, 0.2f))}};
    b.tree = {Op::except, 0, {wheel}};
    for (int k = 0; k < teeth; ++k) {
        const Eigen::AngleAxisf turn(float(2 * kPi * k / teeth), Vec3f::UnitZ());
        b.tree.parts.push_back(
            {Op::all,
             0,
             {sheet(b.plane(turn * Vec3f(-1, 0, 0), -0.55f)), sheet(b.plane(turn * Vec3f(0, 1, 0), 0.13f)),
              sheet(b.plane(turn * Vec3f(0, -1, 0), 0.13f))}});
    }
    return b;
}

/// First entry of a ray into the exact solid by marching along its (never too large) distance and bisection; < 0:
/// missed.
double exact_entry(const Body& body, const Ray& ray) {
    const Vec3d o = ray.origin.cast<double>(), d = ray.direction.cast<double>();
    double t = 0;
    for (int i = 0; i < 3000 && t < 6; ++i) {
        const double f = body.solid(o + t * d);
        if (f < 1e-9) return t;
        t += std::max(f, 1e-7);
    }
    return -1;
}

Ray ray_to(std::uint64_t i, float within) {
    const Vec3f from = 3 * on_sphere(i, 5), to = on_sphere(i, 6) * float(within * std::cbrt(random_unit(1, i, 7, 0)));
    return {from, (to - from).normalized()};
}

struct Outcome {
    std::int64_t hits = 0, missed = 0, phantom = 0, beyond = 0, odd = 0;
    double depth = 0, normal = 0;
    Outcome operator+(const Outcome& o) const {
        return {hits + o.hits, missed + o.missed, phantom + o.phantom, beyond + o.beyond,
                odd + o.odd,   depth + o.depth,   normal + o.normal};
    }
};

/// Rays at the body: holes, hits where there is nothing, hits that stand out, and whether what enters leaves.
Outcome probe(const Body& body, std::size_t rays, float within = 0.9f) {
    const RayScene scene(body.set(), {});
    const double tolerance = 0.1 * double(body.radius);
    return parallel_sum<Outcome>(
        rays,
        [&](std::size_t i) {
            Outcome o;
            Ray ray = ray_to(i, within);
            const double exact = exact_entry(body, ray);
            Interior interior;
            Hit hit;
            const bool found = scene.intersect(ray, interior, hit);
            if (!found) {
                // A ray that only grazes the solid by less than the tolerance may miss it.
                double deepest = 0;
                for (double t = std::max(exact, 0.0); exact >= 0 && t < exact + 3; t += 0.002)
                    deepest = std::min(deepest, body.solid((ray.origin + float(t) * ray.direction).cast<double>()));
                o.missed = deepest < -0.5 * tolerance;
                return o;
            }
            o.hits = 1;
            const double off = body.solid(hit.position.cast<double>());
            o.beyond = off > tolerance;
            if (exact < 0)
                o.phantom = off > tolerance;
            else
                o.depth = std::abs(off);
            o.odd = shapes::stays_inside(scene, ray, hit, interior);
            return o;
        },
        Outcome{});
}

class Trimmed : public testing::TestWithParam<std::pair<const char*, Body (*)(float)>> {};

TEST_P(Trimmed, IsTheExactSolidToATenthOfARadius) {
    // Flat and round sheets are met exactly by the fit; at creases a crossing may stand out by kTrimOverlap. Rays that
    // cut a corner by less than that enter and do not leave: one in ten thousand.
    const Outcome o = probe(GetParam().second(0.06f), 100000);
    EXPECT_GT(o.hits, 20000);
    EXPECT_EQ(o.missed, 0);
    EXPECT_EQ(o.phantom, 0);
    EXPECT_EQ(o.beyond, 0);
    // Odd rays pass edges within the overlap; the gear has several times as many edges as the others.
    EXPECT_LE(o.odd, std::string(GetParam().first) == "gear" ? 20 : 10) << "rays that do not leave what they entered";
    EXPECT_LT(o.depth / double(o.hits), 0.005 * 0.06);
}

TEST_P(Trimmed, DepthErrorFallsWithTheRadius) {
    // All error is at the creases. The share of rays that meet a crease falls with the radius, and so does their error.
    // Together that is second order. A factor of 2.5 for half the radius leaves room for the lattice.
    const Outcome coarse = probe(GetParam().second(0.08f), 20000), fine = probe(GetParam().second(0.04f), 20000);
    EXPECT_LT(fine.depth / double(fine.hits), coarse.depth / double(coarse.hits) / 2.5 + 1e-6);
}

INSTANTIATE_TEST_SUITE_P(Bodies, Trimmed,
                         testing::Values(std::pair("cube", &cube), std::pair("lens", &lens),
                                         std::pair("cut_cylinder", &cut_cylinder), std::pair("gear", &gear)),
                         [](const auto& info) { return std::string(info.param.first); });

TEST(Trims, OfASpinningBodyHaveNoHoleAtAnyTime) {
    // It flies, and turns by 0.2 radians while the shutter is open. Its faces stay flat to within a hundredth of a
    // radian squared, so that rays to its inner half meet it and leave it again. As of a body at rest, one in ten
    // thousand may not leave.
    const Shutter shutter{-0.5f, 0.5f};
    const Vec3f velocity(2, 1, -1), angular = 0.2f * Vec3f(1, -2, 2).normalized();
    for (const auto& make : {&cube, &lens}) {
        SurfelSet set = make(0.06f).set();
        for (const Vec3f& x : set.cloud.position) set.velocity.push_back(velocity + angular.cross(x));
        const RayScene scene(std::move(set), {}, shutter);
        constexpr std::size_t kRays = 50000;
        const Outcome o = parallel_sum<Outcome>(
            kRays,
            [&](std::size_t i) {
                Ray ray = ray_to(i, 0.15f);
                ray.time = float(random_unit(1, i, 9, 0));
                ray.origin += shutter.seconds(ray.time) * velocity;
                Hit hit;
                Outcome one;
                one.missed = !scene.intersect(ray, {}, hit);
                one.odd = !one.missed && shapes::stays_inside(scene, ray, hit, {});
                return one;
            },
            Outcome{});
        EXPECT_EQ(o.missed, 0);
        EXPECT_LE(o.odd, 5);
    }
}

TEST(Trims, ALampInATrimmedShellIsDarkOutside) {
    // The rays of a lamp inside a cube, straight to the sky: all meet the cube, also in its corners.
    const RayScene scene(cube(0.06f).set(), {});
    Interior inside;
    inside.add(0);
    const auto leaks = parallel_sum<double>(300000, [&](std::size_t i) {
        Hit hit;
        return scene.intersect({Vec3f(0.1f, -0.05f, 0.2f), on_sphere(i, 8)}, inside, hit) ? 0.0 : 1.0;
    });
    EXPECT_EQ(leaks, 0);
}

TEST(Trims, AFaceThatGoesOnInsideIsNotSeenWhereItComesToAnother) {
    // A box less a quarter: the quarter's faces go on inside the material. Where they come to the top of the box,
    // nearer than the overlap, the top alone is the surface.
    Body b;
    b.radius = 0.06f;
    const Vec3f up(0, 0, 1), along(1, 0, 0);
    b.solid = [](const Vec3d& x) { return std::max(box_distance(x, {0.5, 0.5, 0.5}), -std::max(-x.x(), x.y())); };
    TrimNode box{Op::all, 0, {}};
    for (int axis = 0; axis < 3; ++axis)
        for (const float side : {1.0f, -1.0f}) box.parts.push_back(sheet(b.plane(side * Vec3f::Unit(axis), 0.5f)));
    // Taken away: x > 0 and y < 0. Both faces go on past the edge where they meet, into the material.
    const TrimNode slot{Op::all, 0, {sheet(b.plane(-along, 0)), sheet(b.plane({0, 1, 0}, 0))}};
    b.tree = {Op::except, 0, {box, slot}};
    const RayScene scene(b.set(), {});
    int wrong = 0;
    for (int i = 0; i < 20000; ++i) {
        // Straight down onto the top along the line where the first face goes on inside.
        const float x = 2e-4f * float(2 * random_unit(2, std::uint64_t(i), 0, 0) - 1),
                    y = 0.02f + 0.1f * float(random_unit(2, std::uint64_t(i), 0, 1));
        Hit hit;
        if (scene.intersect({Vec3f(x, y, 2), -up}, {}, hit)) wrong += hit.normal.dot(up) < 0.9f;
    }
    EXPECT_EQ(wrong, 0);
}

TEST(Trims, ASheetThatIsKeptAndTakenAwayIsRefused) {
    Body b = lens(0.1f);
    b.tree = {Op::except, 0, {sheet(0), sheet(0)}};
    EXPECT_THROW(RayScene(b.set(), {}), CacheError);
    b.tree = sheet(7);
    EXPECT_THROW(RayScene(b.set(), {}), CacheError);
}

}  // namespace
}  // namespace thixo::render
