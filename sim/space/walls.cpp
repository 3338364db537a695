#include "sim/space/walls.h"

#include <cmath>
#include <limits>
#include <numeric>
#include <set>

#include "pipeline/base/parallel.h"
#include "pipeline/geometry/shapes.h"
#include "sim/space/scene_shapes.h"

namespace thixo {

namespace {
Real adhesion_of(double contact_angle) {
    return contact_angle >= 180 ? Real(0) : static_cast<Real>(0.5 + 0.5 * std::cos(contact_angle * kPi / 180));
}
}  // namespace

Walls make_walls(const scene::Scene& scene, const Smoothing& smoothing, const Strategy& strategy) {
    Walls walls;
    const auto map_of = [&](Shape solid) {
        return strategy.incompressible ? WallMap(std::move(solid), smoothing.wall)
                                       : WallMap(std::move(solid), smoothing.support);
    };
    struct Surface {  // slippery ones first, then by contact angle, then by temperature
        bool no_slip;
        double angle;
        std::optional<double> temperature;
        auto operator<=>(const Surface&) const = default;
    };
    const auto surface_of = [](const scene::Boundary& b) {
        return Surface{b.no_slip, b.contact_angle, b.isothermal ? std::optional(b.temperature) : std::nullopt};
    };
    const auto add = [&](Shape solid, RigidMotion motion, const Surface& surface) {
        walls.list.emplace_back(map_of(std::move(solid)), std::move(motion), surface.no_slip,
                                adhesion_of(surface.angle), surface.temperature);
    };
    std::set<Surface> surfaces;
    for (const scene::Boundary& b : scene.world.boundaries)
        if (b.motion.size() < 2) surfaces.insert(surface_of(b));
    for (const Surface& surface : surfaces) {
        std::vector<Shape> at_rest;
        for (const scene::Boundary& b : scene.world.boundaries)
            if (b.motion.size() < 2 && surface_of(b) == surface) at_rest.push_back(wall_solid_at_rest(scene, b));
        add(at_rest.size() == 1 ? at_rest[0] : union_of(at_rest), RigidMotion(), surface);
    }
    for (const scene::Boundary& b : scene.world.boundaries)
        if (b.motion.size() >= 2) add(wall_solid(scene, b), motion_of(scene, b.motion), surface_of(b));
    move_walls(walls, 0);
    return walls;
}

void move_walls(Walls& walls, double time) {
    for (Wall& w : walls.list) {
        if (!w.motion.moves()) continue;
        const RigidPose pose = w.motion.pose(time);
        const RigidVelocity velocity = w.motion.velocity(time);
        w.turn = pose.rotation.toRotationMatrix().cast<Real>();
        w.shift = pose.translation.cast<Real>();
        w.velocity = velocity.linear.cast<Real>();
        w.spin = velocity.angular.cast<Real>();
    }
}

Real wall_distance(const Walls& walls, const Vec3& x) {
    Real nearest = std::numeric_limits<Real>::max();
    Vec3 normal;
    for (const Wall& w : walls.list) nearest = std::min(nearest, w.map.distance(w.to_wall(x), normal));
    return nearest;
}

WallContact wall_contact(const Walls& walls, const Vec3& x) {
    WallContact contact{std::numeric_limits<Real>::max(), Vec3::Zero(), Vec3::Zero()};
    for (const Wall& w : walls.list) {
        Vec3 normal;
        const Real d = w.map.distance(w.to_wall(x), normal);
        if (d >= contact.distance) continue;
        contact = {d, w.turn * normal, w.velocity_at(x)};
    }
    return contact;
}

WallEffect wall_effect(const Walls& walls, const Vec3& x, WallCursor& cursor) {
    WallEffect effect;
    for (std::size_t k = 0; k < walls.list.size(); ++k) {
        const Wall& w = walls.list[k];
        const WallIntegrals in = w.map.at(w.to_wall(x), cursor.at[k]);
        effect.distance = std::min(effect.distance, in.distance);
        if (in.share <= 0) continue;
        effect.share += in.share;
        const Vec3 gradient = w.turn * in.gradient;
        effect.gradient += gradient;
        effect.inflow += gradient.dot(w.velocity_at(x));
        if (!w.no_slip) continue;
        effect.drag += in.laplacian;
        effect.drag_velocity += in.laplacian * w.velocity_at(x);
    }
    return effect;
}

void find_wall_effects(const Walls& walls, const std::vector<Vec3>& points, std::vector<WallEffect>& effects) {
    effects.resize(points.size());
    parallel_chunks(
        points.size(),
        [&](std::size_t begin, std::size_t end, std::size_t) {
            WallCursor cursor(walls);
            for (std::size_t i = begin; i < end; ++i) effects[i] = wall_effect(walls, points[i], cursor);
        },
        256);
}

namespace {
/// Whether the straight way to x, taken with velocity v [m/s] against the wall in dt [s], crosses the wall's inside. The
/// way about a round obstacle cuts it by less than a tenth of its length. Distances of the tables err by less than a
/// twentieth of the support.
bool leads_through(const Wall& w, const Vec3& x, const Vec3& v, double dt, WallMap::Cursor& cursor) {
    const Vec3 way = static_cast<Real>(dt) * (v - w.velocity_at(x));
    const Real deep = -(way.norm() / 10 + w.map.support() / 20);
    Vec3 normal;
    if (w.map.distance(w.to_wall(x - way), normal, cursor) < 0) return false;  // it came from within
    constexpr int kParts = 4;
    for (int k = 1; k < kParts; ++k)
        if (w.map.distance(w.to_wall(x - way * Real(k) / kParts), normal, cursor) < deep) return true;
    return false;
}
}  // namespace

std::int64_t hold_off_walls(const Walls& walls, Particles& particles, Real least, const std::vector<WallEffect>& before,
                            double dt, double wall_speed) {
    auto& x = particles.position;
    auto& v = particles.velocity;
    if (walls.list.empty()) return 0;
    std::vector<std::int64_t> passed((particles.size() + kChunk - 1) / kChunk, 0);
    const auto hold_off = [&](std::size_t i, WallCursor& cursor) {
        if (is_elastic(particles.phase[i])) return false;  // their own steps keep them out
        // Distances of the tables err by less than a twentieth of the support beside an edge.
        const Real came = static_cast<Real>(dt) * (v[i].norm() + static_cast<Real>(wall_speed));
        if (before[i].distance > least + came + walls.list[0].map.support() / 20) return false;
        // One wall after the other, so that a particle in a corner of two walls obeys both.
        bool through = false;
        for (std::size_t k = 0; k < walls.list.size(); ++k) {
            const Wall& w = walls.list[k];
            Vec3 normal;
            const Real d = w.map.distance(w.to_wall(x[i]), normal, cursor.at[k]);
            if (d >= 0 && leads_through(w, x[i], v[i], dt, cursor.at[k])) through = true;
            if (d >= least) continue;
            normal = w.turn * normal;
            const Vec3 from = x[i] - static_cast<Real>(dt) * v[i];
            x[i] += (least - d) * normal;
            // From deep in a thin wall the nearest side is the other one.
            if (d < 0 && normal.dot(from - x[i]) < -2 * least) through = true;
            const Real inward = (v[i] - w.velocity_at(x[i])).dot(normal);
            if (inward < 0) v[i] -= inward * normal;
        }
        return through;
    };
    parallel_chunks(particles.size(), [&](std::size_t begin, std::size_t end, std::size_t chunk) {
        WallCursor cursor(walls);
        for (std::size_t i = begin; i < end; ++i) passed[chunk] += hold_off(i, cursor) ? 1 : 0;
    });
    return std::accumulate(passed.begin(), passed.end(), std::int64_t(0));
}

double largest_wall_speed(const Walls& walls, const std::vector<Vec3>& points) {
    double fastest = 0;
    for (const Wall& w : walls.list) {
        if (w.velocity.isZero() && w.spin.isZero()) continue;
        const double here = parallel_reduce(
            points.size(), 0.0, [&](std::size_t i) { return static_cast<double>(w.velocity_at(points[i]).norm()); },
            [](double a, double b) { return std::max(a, b); });
        fastest = std::max(fastest, here);
    }
    return fastest;
}

}  // namespace thixo
