// Sharp-edged and smooth bodies with random points of their exact surface, for tests of sampling and of trimming.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "pipeline/base/random.h"
#include "pipeline/geometry/shapes.h"

namespace thixo::exact {

struct SurfacePoint {
    Vec3d position, normal;
};

/// A body: its shape, an exact formula of the solid by other code, and patches that cover its whole surface. The
/// formula is < 0 inside and never larger than the distance. A patch maps [0,1]^2 to points and normals. Only points on
/// the solid count.
struct Body {
    std::string name;
    Shape shape;
    std::function<double(const Vec3d&)> solid;
    std::vector<std::function<SurfacePoint(double, double)>> patches;
    int sheets;
    bool on_surface(const SurfacePoint& p) const {
        return solid(p.position + 1e-5 * p.normal) > 0 && solid(p.position - 1e-5 * p.normal) < 0;
    }
};

using Patch = std::function<SurfacePoint(double, double)>;

inline Patch sphere_patch(const Vec3d& centre, double r, double side = 1) {
    return [=](double u, double v) {
        const double z = 2 * u - 1, s = std::sqrt(std::max(0.0, 1 - z * z));
        const Vec3d n(s * std::cos(2 * kPi * v), s * std::sin(2 * kPi * v), z);
        return SurfacePoint{centre + r * n, side * n};
    };
}
/// A square of half width `half` in the plane n.x = offset.
inline Patch plane_patch(const Vec3d& n, double offset, double half) {
    Vec3d a, b;
    orthonormal_basis(n, a, b);
    return [=](double u, double v) { return SurfacePoint{offset * n + half * ((2 * u - 1) * a + (2 * v - 1) * b), n}; };
}
inline Patch tube_patch(double r, double half) {  // about z
    return [=](double u, double v) {
        const Vec3d n(std::cos(2 * kPi * u), std::sin(2 * kPi * u), 0);
        return SurfacePoint{r * n + Vec3d(0, 0, half * (2 * v - 1)), n};
    };
}
inline double box_solid(const Vec3d& x, const Vec3d& half) { return (x.cwiseAbs() - half).maxCoeff(); }
inline double round_solid(const Vec3d& x, double r) { return std::hypot(x.x(), x.y()) - r; }

inline std::vector<Patch> box_patches(const Vec3d& half) {
    std::vector<Patch> patches;
    for (int axis = 0; axis < 3; ++axis)
        for (const double side : {1.0, -1.0}) patches.push_back(plane_patch(side * Vec3d::Unit(axis), half[axis], 1));
    return patches;
}

inline Body ball() {
    return {"sphere", sphere(0.5), [](const Vec3d& x) { return x.norm() - 0.5; }, {sphere_patch({0, 0, 0}, 0.5)}, 1};
}
inline Body ring() {
    const auto patch = [](double u, double v) {
        // Even by area: a share (0.5 + 0.2 cos) of the turn about the tube.
        double phi = 2 * kPi * v;
        for (int i = 0; i < 30; ++i) phi -= (phi + 0.4 * std::sin(phi) - 2 * kPi * v) / (1 + 0.4 * std::cos(phi));
        const Vec3d out(std::cos(2 * kPi * u), std::sin(2 * kPi * u), 0);
        const Vec3d n = std::cos(phi) * out + std::sin(phi) * Vec3d::UnitZ();
        return SurfacePoint{0.5 * out + 0.2 * n, n};
    };
    return {"torus",
            torus(0.5, 0.2),
            [](const Vec3d& x) { return std::hypot(std::hypot(x.x(), x.y()) - 0.5, x.z()) - 0.2; },
            {patch},
            1};
}
inline Body drum() {
    return {"cylinder",
            cylinder(0.5, 0.8),
            [](const Vec3d& x) { return std::max(round_solid(x, 0.5), std::abs(x.z()) - 0.4); },
            {tube_patch(0.5, 0.5), plane_patch({0, 0, 1}, 0.4, 0.6), plane_patch({0, 0, -1}, 0.4, 0.6)},
            3};
}
/// Thinner than the surfels are wide.
inline Body plate() {
    const Vec3d half(0.5, 0.4, 0.015);
    return {"plate", box(2 * half), [half](const Vec3d& x) { return box_solid(x, half); }, box_patches(half), 6};
}
inline Body cube() {
    const Vec3d half(0.5, 0.5, 0.5);
    return {"cube", box(2 * half), [half](const Vec3d& x) { return box_solid(x, half); }, box_patches(half), 6};
}
/// A box less a corner and a round bite.
inline Body cut_cube() {
    const Vec3d half(0.5, 0.4, 0.3), slant = Vec3d(1, 1, 1).normalized(), bite(-0.5, 0, 0.3);
    auto patches = box_patches(half);
    patches.push_back(plane_patch(slant, 0.4, 1));
    patches.push_back(sphere_patch(bite, 0.25, -1));
    return {"cut_cube",
            difference_of({intersection_of({box(2 * half), plane(slant, 0.4)}), translated(sphere(0.25), bite)}),
            [=](const Vec3d& x) {
                return std::max({box_solid(x, half), slant.dot(x) - 0.4, 0.25 - (x - bite).norm()});
            },
            patches, 8};
}
inline Body lens() {
    const Vec3d up(0, 0, 0.6);
    return {"lens",
            intersection_of({translated(sphere(0.8), up), translated(sphere(0.8), -up)}),
            [up](const Vec3d& x) { return std::max((x - up).norm(), (x + up).norm()) - 0.8; },
            {sphere_patch(up, 0.8), sphere_patch(-up, 0.8)},
            2};
}
/// A cylinder from which a sphere and a slanted plane have taken their part.
inline Body cut_cylinder() {
    const Vec3d slant = Vec3d(0.5, 0, 1).normalized(), bite(0.5, 0, -0.2);
    return {"cut_cylinder",
            difference_of({intersection_of({translated(cylinder(0.5, 2), {0, 0, 0.5}), plane(slant, 0.3)}),
                           translated(sphere(0.3), bite)}),
            [=](const Vec3d& x) {
                return std::max({round_solid(x, 0.5), -x.z() - 0.5, slant.dot(x) - 0.3, 0.3 - (x - bite).norm()});
            },
            {tube_patch(0.5, 0.7), plane_patch({0, 0, -1}, 0.5, 0.6), plane_patch(slant, 0.3, 0.7),
             sphere_patch(bite, 0.3, -1)},
            4};
}
/// Three sheets of one body that meet in a point: where three balls overlap.
inline Body junction() {
    std::vector<Vec3d> centres;
    std::vector<Shape> balls;
    std::vector<Patch> patches;
    for (int k = 0; k < 3; ++k) {
        const double a = 2 * kPi * k / 3;
        centres.push_back(0.3 * Vec3d(std::cos(a), std::sin(a), 0));
        balls.push_back(translated(sphere(0.5), centres.back()));
        patches.push_back(sphere_patch(centres.back(), 0.5));
    }
    return {"junction", union_of(balls),
            [centres](const Vec3d& x) {
                return std::min({(x - centres[0]).norm(), (x - centres[1]).norm(), (x - centres[2]).norm()}) - 0.5;
            },
            patches, 3};
}
/// A wheel with eight slots: a cylinder less boxes.
inline Body gear() {
    constexpr int teeth = 8;
    std::vector<Shape> shapes{cylinder(0.8, 0.4)};
    std::vector<Patch> patches{tube_patch(0.8, 0.3), plane_patch({0, 0, 1}, 0.2, 0.9),
                               plane_patch({0, 0, -1}, 0.2, 0.9)};
    std::vector<Vec3d> out;
    for (int k = 0; k < teeth; ++k) {
        const double a = 2 * kPi * k / teeth;
        out.emplace_back(std::cos(a), std::sin(a), 0);
        shapes.push_back(
            transformed(box({1, 0.26, 1}), 1, Quatd(Eigen::AngleAxisd(a, Vec3d::UnitZ())), 1.05 * out[std::size_t(k)]));
        const Vec3d side = Vec3d::UnitZ().cross(out.back());
        patches.push_back(plane_patch(out.back(), 0.55, 0.5));
        patches.push_back(plane_patch(side, -0.13, 1));
        patches.push_back(plane_patch(-side, -0.13, 1));
    }
    return {"gear", difference_of(shapes),
            [out](const Vec3d& x) {
                double d = std::max(round_solid(x, 0.8), std::abs(x.z()) - 0.2);
                for (const Vec3d& o : out) {
                    const double along = o.dot(x), across = Vec3d::UnitZ().cross(o).dot(x);
                    d = std::max(d, -std::max({0.55 - along, across - 0.13, -across - 0.13}));
                }
                return d;
            },
            patches, 3 + 3 * teeth};
}
/// Sharp corners outwards and inwards: a cup with a foot, turned.
inline std::vector<Vec2d> cup_profile() {
    return {{0, -0.5},  {0.4, -0.5}, {0.4, -0.4}, {0.1, -0.35}, {0.1, -0.1},
            {0.5, 0.1}, {0.5, 0.5},  {0.4, 0.5},  {0.4, 0.2},   {0, 0.05}};
}
inline Body cup() {
    const std::vector<Vec2d> profile = cup_profile();
    Body body{"cup", revolve(profile), {}, {}, int(profile.size()) - 1};
    body.solid = [profile](const Vec3d& x) {
        // Slow and simple: the crossings of a line outwards with the profile, and the nearest edge.
        const Vec2d p(std::hypot(x.x(), x.y()), x.z());
        double best = 1e9;
        bool inside = false;
        for (std::size_t k = 0; k < profile.size(); ++k) {
            const Vec2d a = profile[k], b = profile[(k + 1) % profile.size()];
            if ((a.y() <= p.y()) != (b.y() <= p.y()) &&
                p.x() < a.x() + (p.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x()))
                inside = !inside;
            if (a.x() == 0 && b.x() == 0) continue;
            const double t = clamp01((p - a).dot(b - a) / (b - a).squaredNorm());
            best = std::min(best, (p - a - t * (b - a)).norm());
        }
        return inside ? -best : best;
    };
    for (std::size_t k = 0; k + 1 < profile.size(); ++k) {
        const Vec2d a = profile[k], b = profile[k + 1];
        body.patches.push_back([a, b](double u, double v) {
            const double t =
                a.x() == b.x() ? v : (std::sqrt((1 - v) * a.x() * a.x() + v * b.x() * b.x()) - a.x()) / (b.x() - a.x());
            const Vec2d p = a + t * (b - a), n = Vec2d((b - a).y(), -(b - a).x()).normalized();
            const double c = std::cos(2 * kPi * u), s = std::sin(2 * kPi * u);
            return SurfacePoint{{p.x() * c, p.x() * s, p.y()}, {n.x() * c, n.x() * s, n.y()}};
        });
    }
    return body;
}

inline std::vector<Body> bodies() {
    return {ball(), ring(), drum(), plate(), cube(), cut_cube(), lens(), cut_cylinder(), junction(), gear(), cup()};
}

/// Random point i of a patch.
inline SurfacePoint random_point(const Body& body, std::size_t patch, std::uint64_t i) {
    return body.patches[patch](random_unit(3, i, patch, 0), random_unit(3, i, patch, 1));
}

}  // namespace thixo::exact
