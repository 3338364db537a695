// Small scenes that several tests share.
#pragma once

#include "sim/loop/step.h"
#include "sim/stage/setup.h"

namespace thixo::fixture {

inline scene::Material water() {
    scene::Material m;
    m.name = "water";
    return m;
}

inline scene::Shape shape_at(const Vec3d& where, auto kind) {
    scene::Shape s;
    s.kind = std::move(kind);
    s.translate = where;
    return s;
}

/// A scene without walls, gravity and surface, with particles 1 cm apart.
inline scene::Scene empty_space() {
    scene::Scene s;
    s.name = "test";
    s.frames = {1, 100, 24};
    s.world.gravity = {0, 0, 0};
    s.materials = {water()};
    s.solver.spacing = 0.01;
    s.surface.enabled = false;
    return s;
}

inline scene::Body body(const std::string& name, scene::Shape shape, const Vec3d& velocity = {0, 0, 0}) {
    scene::Body b;
    b.name = name;
    b.material = "water";
    b.shape = std::move(shape);
    b.velocity = velocity;
    return b;
}

/// The half-space below z [m].
inline scene::Boundary floor_at(double z) {
    scene::Boundary floor;
    floor.name = "floor";
    floor.shape = shape_at({0, 0, z}, scene::Plane{});
    return floor;
}

/// A room of this size that stands on z = 0, with water of this depth.
inline scene::Scene tank(const Vec3d& room, double depth, double spacing) {
    scene::Scene s = empty_space();
    s.world.gravity = {0, 0, -9.81};
    s.solver.spacing = spacing;
    scene::Boundary walls;
    walls.name = "tank";
    walls.inside = true;
    walls.shape = shape_at({0, 0, room.z() / 2}, scene::BoxShape{room, 0});
    s.world.boundaries = {walls};
    s.bodies = {body("pool", shape_at({0, 0, depth / 2}, scene::BoxShape{{room.x(), room.y(), depth}, 0}))};
    return s;
}

inline Vec3d momentum(const Particles& p) {
    Vec3d sum(0, 0, 0);
    for (std::size_t i = 0; i < p.size(); ++i) sum += static_cast<double>(p.mass[i]) * p.velocity[i].cast<double>();
    return sum;
}
/// Angular momentum about the origin.
inline Vec3d angular_momentum(const Particles& p) {
    Vec3d sum(0, 0, 0);
    for (std::size_t i = 0; i < p.size(); ++i)
        sum += static_cast<double>(p.mass[i]) * p.position[i].cast<double>().cross(p.velocity[i].cast<double>());
    return sum;
}
/// The sum of m |v|, with which a momentum is compared.
inline double motion(const Particles& p) {
    double sum = 0;
    for (std::size_t i = 0; i < p.size(); ++i) sum += static_cast<double>(p.mass[i] * p.velocity[i].norm());
    return sum;
}

/// Makes steps of a fixed size that never end on a frame.
inline void steps(Simulation& s, int count, double dt) {
    s.problem.scene.solver.time_step.fixed = dt;
    for (int k = 0; k < count; ++k) {
        s.clock.next_frame = s.clock.time + 1000 * dt;
        step(s);
    }
}

}  // namespace thixo::fixture
