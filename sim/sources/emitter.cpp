#include "sim/sources/emitter.h"

#include <algorithm>
#include <cmath>

#include "pipeline/base/error.h"
#include "pipeline/base/random.h"
#include "sim/space/sampling.h"
#include "sim/space/scene_shapes.h"

namespace thixo {
namespace {

constexpr Real kFreeRoom = Real(0.7);  // spacings to the next particle; two sites of the packing are 1.12 apart
constexpr Real kWallRoom = Real(0.3);  // spacings to a wall
constexpr int kTries = 12;             // positions of the packing along each axis of its cell
enum RandomUse : std::uint64_t { kJitterRadius = 0x656d6974, kJitterAngle };

// Calls f(site) for every site of packing layer k (0 or 1) within the disc, the packing shifted by (dx, dy).
template <class F>
void for_each_site_in_disc(double radius, Real spacing, int k, Real dx, Real dy, F&& f) {
    const int reach = static_cast<int>(radius / static_cast<double>(packing_distance(spacing)) * 1.2) + 3;
    for (int j = -reach; j <= reach; ++j)
        for (int i = -reach; i <= reach; ++i) {
            Vec3 s = packing_site(i, j, k, spacing) + Vec3(dx, dy, 0);
            s.z() = 0;
            if (s.squaredNorm() < static_cast<Real>(square(radius))) f(s);
        }
}

// What an emitter's sites are checked against: the particles that were there, and those made before them in this call.
class FreeRoom {
  public:
    FreeRoom(const Particles& particles, const Periodic& periodic, const Vec3& centre, Real reach, Real least)
        : least2_(square(least)) {
        for (const Vec3& x : particles.position)
            if (const Vec3 image = periodic.nearest_image(x, centre); (image - centre).squaredNorm() < square(reach))
                near_.push_back(image);
    }
    bool take(const Vec3& x) {
        for (const Vec3& y : near_)
            if ((x - y).squaredNorm() < least2_) return false;
        near_.push_back(x);
        return true;
    }

  private:
    std::vector<Vec3> near_;
    Real least2_;
};

}  // namespace

double sites_of_emitter(const scene::Emitter& emitter, double spacing) {
    const double site = cube(spacing) / static_cast<double>(packing_layer(static_cast<Real>(spacing)));
    return kPi * square(emitter.radius) / site;
}

EmitterLayout lay_out_emitter(const scene::Emitter& emitter, const MaterialParams& material, Real spacing) {
    EmitterLayout layout;
    const double area = kPi * square(emitter.radius);
    layout.mass = static_cast<double>(material.density) * cube(static_cast<double>(spacing));
    layout.flow = static_cast<double>(material.density) * area * emitter.speed;
    layout.centre = emitter.position;
    layout.motion = motion_of(emitter.motion);
    Vec3d a, b;
    const Vec3d n = emitter.direction.normalized();
    orthonormal_basis(n, a, b);
    layout.turn << a, b, n;

    const double wanted = 2 * sites_of_emitter(emitter, static_cast<double>(spacing));
    double best = 1e300;
    Real best_dx = 0, best_dy = 0;
    const Real step = packing_distance(spacing) / kTries;
    for (int q = 0; q < kTries; ++q)
        for (int p = 0; p < kTries; ++p) {
            const Real dx = step * Real(p), dy = step * Real(q);
            // Between equals the one centred best: a jet that leans to one side would bend.
            Vec3 lean(0, 0, 0);
            std::size_t sites[2] = {0, 0};
            for (const int k : {0, 1})
                for_each_site_in_disc(emitter.radius, spacing, k, dx, dy, [&](const Vec3& s) {
                    lean += s;
                    ++sites[k];
                });
            const auto count = static_cast<double>(sites[0] + sites[1]);
            const double cost =
                std::abs(count - wanted) + 0.1 * static_cast<double>(lean.norm() / spacing) / std::max(1.0, count);
            if (sites[0] == 0 || sites[1] == 0 || cost >= best) continue;
            best = cost;
            best_dx = dx;
            best_dy = dy;
        }
    if (best == 1e300)
        throw InputError(
            "emitter '{}' has a radius of {} m, too thin for particles {} m apart; raise its radius or lower "
            "solver.spacing",
            emitter.name, emitter.radius, spacing);
    for (const int k : {0, 1})
        for_each_site_in_disc(emitter.radius, spacing, k, best_dx, best_dy,
                              [&](const Vec3& s) { layout.layers[k].push_back(s); });
    return layout;
}

void emit_particles(const std::vector<scene::Emitter>& emitters, const std::vector<EmitterLayout>& layouts,
                    const Smoothing& smoothing, const Walls& walls, const Vec3& gravity, const Periodic& periodic,
                    std::uint64_t seed, double time, double last_dt, std::vector<EmitterState>& states,
                    Particles& particles, std::int64_t& next_id) {
    const double d = smoothing.spacing;
    for (std::size_t e = 0; e < emitters.size(); ++e) {
        const scene::Emitter& emitter = emitters[e];
        const EmitterLayout& layout = layouts[e];
        EmitterState& state = states[e];
        while (state.next <= time && state.next < emitter.stop) {
            const std::vector<Vec3>& layer = layout.layers[state.layer & 1];
            const RigidPose pose = layout.motion.pose(state.next);
            const RigidVelocity moving = layout.motion.velocity(state.next);
            const double age = time - state.next;
            const Vec3d fall = gravity.cast<double>();
            const Vec3d jet = pose.rotation * Vec3d(layout.turn.col(2) * emitter.speed);
            const Vec3d centre = pose.apply(layout.centre);
            const Vec3d drift = jet + moving.linear + moving.angular.cross(centre - pose.translation);
            const Vec3d now = centre + age * drift + 0.5 * square(age) * fall;
            FreeRoom room(particles, periodic, now.cast<Real>(), static_cast<Real>(emitter.radius + 2 * d),
                          kFreeRoom * smoothing.spacing);
            for (const Vec3& site : layer) {
                const std::int64_t id = next_id;
                const double radius =
                    emitter.jitter * d * std::sqrt(random_unit(seed, static_cast<std::uint64_t>(id), 0, kJitterRadius));
                const double angle = 2 * kPi * random_unit(seed, static_cast<std::uint64_t>(id), 0, kJitterAngle);
                const Vec3d shaken = site.cast<double>() + radius * Vec3d(std::cos(angle), std::sin(angle), 0);
                const Vec3d at = centre + pose.rotation * (layout.turn * shaken);
                const Vec3d flow = jet + moving.linear + moving.angular.cross(at - pose.translation);
                const Vec3d x = at + age * flow + 0.5 * square(age) * fall;
                const Vec3 in = periodic.wrapped(x.cast<Real>());
                if (wall_distance(walls, in) < kWallRoom * smoothing.spacing || !room.take(x.cast<Real>())) {
                    ++state.blocked;
                    continue;
                }
                const Index i = append_row(particles);
                particles.id[i] = next_id++;
                particles.position[i] = in;
                if (particles.has.surface) particles.surface_position[i] = in;
                particles.velocity[i] = (flow + (age - 0.5 * last_dt) * fall).cast<Real>();
                particles.acceleration[i] = gravity;
                particles.mass[i] = static_cast<Real>(layout.mass);
                particles.rest_volume[i] = cube(smoothing.spacing);
                particles.density[i] = static_cast<Real>(layout.mass / cube(d));
                particles.temperature[i] = emitter.temperature;
                particles.material[i] = layout.material;
                particles.body[i] = layout.body;
                particles.melt[i] = 1;
                particles.phase[i] = Phase::liquid;
            }
            state.next += static_cast<double>(layer.size()) * layout.mass / layout.flow;
            ++state.layer;
        }
    }
}

}  // namespace thixo
