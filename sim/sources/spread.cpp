#include "sim/sources/spread.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "pipeline/base/error.h"
#include "pipeline/geometry/point_grid.h"
#include "pipeline/geometry/surface_sampling.h"
#include "sim/space/sampling.h"
#include "sim/space/scene_shapes.h"

namespace thixo {
namespace {

constexpr Real kOnSurface = Real(0.1);  // spacings; points that a face has beyond its edges are farther off
constexpr double kPatienceOfSites = 4;  // particles that may be due before one is given up

/// Neighbouring sites take turns far apart: the golden part of the list, with no divisor in common.
std::size_t stride_of(std::size_t sites) {
    auto stride = std::max<std::size_t>(1, static_cast<std::size_t>(0.618 * static_cast<double>(sites)));
    while (std::gcd(stride, sites) != 1) ++stride;
    return stride;
}

/// A source at one instant.
class Spread {
  public:
    Spread(const Sources& sources, std::size_t emitter, double time)
        : sources_(sources),
          layout_(sources.layouts[emitter]),
          pose_(layout_.motion.pose(time)),
          moving_(layout_.motion.velocity(time)) {}

    Vec3d place(const SpreadSite& site) const { return pose_.apply(site.at.cast<double>()); }
    Vec3d flow(const SpreadSite& site) const {
        const Vec3d jet = layout_.speed * (pose_.rotation * site.along.cast<double>());
        return jet + moving_.linear + moving_.angular.cross(place(site) - pose_.translation);
    }
    bool in_wall(const Vec3d& x) const {
        const Vec3 in = sources_.periodic.wrapped(x.cast<Real>());
        return wall_distance(sources_.walls, in) < kRoomToWall * sources_.smoothing.spacing;
    }

  private:
    const Sources& sources_;
    const EmitterLayout& layout_;
    RigidPose pose_;
    RigidVelocity moving_;
};

/// The particles that were there, and those made since.
class Taken {
  public:
    Taken(const Particles& particles, Real spacing) : reach_(kRoomToParticle * spacing) {
        grid_.build(particles.position, spacing);
    }
    bool free(const Vec3& x) const {
        bool taken = std::ranges::any_of(made_, [&](const Vec3& y) { return (x - y).squaredNorm() < square(reach_); });
        if (!taken) grid_.for_each_neighbour(x, reach_, [&](Index, Real) { taken = true; });
        return !taken;
    }
    void take(const Vec3& x) { made_.push_back(x); }

  private:
    Real reach_;
    PointGrid grid_;
    std::vector<Vec3> made_;
};

}  // namespace

std::vector<SpreadSite> spread_sites(const scene::Emitter& emitter, const Shape& shape, Real spacing) {
    std::vector<SpreadSite> sites;
    if (emitter.source == scene::SourceForm::volume) {
        const Vec3 along = emitter.direction.normalized().cast<Real>();
        for (const Vec3& x : pack_shape(
                 shape, spacing, [](const Vec3&) { return true; }, Periodic{}))
            sites.push_back({x, along});
    } else {
        const SurfelCloud points = named_in_scene(emitter.shape, "emitter", emitter.name, [&] {
            return sample_surface(shape, {.spacing = static_cast<double>(spacing)}).surfels;
        });
        for (std::size_t i = 0; i < points.size(); ++i) {
            const Vec3 x = points.position[i].cast<Real>(), n = points.normal[i].cast<Real>();
            if (std::abs(shape.distance(x)) < kOnSurface * spacing) sites.push_back({x + spacing / 2 * n, n});
        }
    }
    if (sites.empty())
        throw InputError("{}: the shape of emitter '{}' holds no particle at a spacing of {} m; lower solver.spacing",
                         emitter.shape.where, emitter.name, spacing);
    return sites;
}

void emit_spread(const Sources& sources, std::size_t emitter, const EmissionTime& time, EmitterState& state,
                 Particles& particles, std::int64_t& next_id) {
    const scene::Emitter& source = sources.emitters[emitter];
    const EmitterLayout& layout = sources.layouts[emitter];
    if (state.next > time.now || state.next >= source.stop) return;
    const std::vector<SpreadSite>& sites = layout.spread;
    const std::size_t stride = stride_of(sites.size());
    const double interval = layout.mass / layout.flow;
    const Vec3d gravity = sources.gravity.cast<double>();
    const Spread spread(sources, emitter, time.now);
    Taken taken(particles, sources.smoothing.spacing);
    // From the site whose turn it is, the first that is free.
    const auto release = [&](double age) {
        for (std::size_t k = 0; k < sites.size(); ++k) {
            const SpreadSite& site = sites[(static_cast<std::size_t>(state.layer) * stride + k) % sites.size()];
            const Vec3d from = spread.place(site), flow = spread.flow(site);
            const Vec3d x = from + age * flow + 0.5 * square(age) * gravity;
            const Vec3 in = sources.periodic.wrapped(x.cast<Real>());
            if (spread.in_wall(from) || spread.in_wall(x) || !taken.free(in)) continue;
            taken.take(in);
            add_emitted(sources, emitter, in, flow + (age - 0.5 * time.last_dt) * gravity, next_id++, particles);
            return true;
        }
        return false;
    };
    while (state.next <= time.now && state.next < source.stop) {
        const double age = time.now - state.next;
        const bool made = release(age) || release(0);
        if (!made && age < kPatienceOfSites * interval) break;  // it waits; else it is given up
        ++state.due;
        if (!made) ++state.blocked;
        state.next = flow_time_after(source, state.next, interval);
        ++state.layer;
    }
}

OpeningRoom room_of_spread(const Sources& sources, std::size_t emitter, double time) {
    const Spread spread(sources, emitter, time);
    const std::vector<SpreadSite>& sites = sources.layouts[emitter].spread;
    const auto blocked =
        std::ranges::count_if(sites, [&](const SpreadSite& s) { return spread.in_wall(spread.place(s)); });
    return {static_cast<std::int64_t>(sites.size()), blocked};
}

}  // namespace thixo
