#include "sim/sources/emitter.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "pipeline/base/error.h"
#include "pipeline/base/random.h"
#include "pipeline/geometry/tessellate.h"
#include "sim/sources/spread.h"
#include "sim/space/sampling.h"
#include "sim/space/scene_shapes.h"

namespace thixo {
namespace {

constexpr double kPatience = 4;  // layers that may be due before one is given up
constexpr int kShorter = 8;      // flights tried for a layer that meets others, down to none
constexpr int kTries = 12;       // positions of the packing along each axis of its cell
enum RandomUse : std::uint64_t { kJitterRadius = 0x656d6974, kJitterAngle };

// Depth of a place, in the emitter's own frame, outside of the opening's edge [m]; for a shape as good as its distance.
struct Edge {
    const Opening& opening;
    const Mat3d& turn;
    const Vec3d& centre;
    Real operator()(const Vec3& own) const {
        if (!opening.shape) return std::hypot(own.x(), own.y()) - static_cast<Real>(opening.radius);
        return opening.shape->distance((centre + turn * Vec3d(own.x(), own.y(), 0)).cast<Real>());
    }
};

// Calls f(site) for every site of packing layer k (0 or 1) within the opening, the packing shifted by (dx, dy).
template <class F>
void for_each_site_in(const Edge& edge, Real spacing, int k, Real dx, Real dy, F&& f) {
    const double radius = edge.opening.radius;
    const int reach = static_cast<int>(radius / static_cast<double>(packing_distance(spacing)) * 1.2) + 3;
    for (int j = -reach; j <= reach; ++j)
        for (int i = -reach; i <= reach; ++i) {
            Vec3 s = packing_site(i, j, k, spacing) + Vec3(dx, dy, 0);
            s.z() = 0;
            if (s.squaredNorm() < static_cast<Real>(square(radius)) && (!edge.opening.shape || edge(s) < 0)) f(s);
        }
}

// The own frame of what flows along a direction: z is the direction.
Mat3d frame_along(const Vec3d& direction) {
    const Vec3d n = direction.normalized();
    Vec3d a, b;
    orthonormal_basis(n, a, b);
    Mat3d turn;
    turn << a, b, n;
    return turn;
}

// What an emitter's sites are checked against: the particles that were there, and those made before them in this layer.
class FreeRoom {
  public:
    explicit FreeRoom(Real least) : least2_(square(least)) {}
    FreeRoom(const Particles& particles, const Periodic& periodic, const Vec3& centre, Real reach, Real least)
        : least2_(square(least)) {
        for (const Vec3& x : particles.position)
            if (const Vec3 image = periodic.nearest_image(x, centre); (image - centre).squaredNorm() < square(reach))
                near_.push_back(image);
    }
    bool free(const Vec3& x) const {
        return std::ranges::none_of(near_, [&](const Vec3& y) { return (x - y).squaredNorm() < least2_; });
    }
    void take(const Vec3& x) { near_.push_back(x); }

  private:
    std::vector<Vec3> near_;
    Real least2_;
};

// What one emitter does at one time.
struct Emission {
    const scene::Emitter& emitter;
    const EmitterLayout& layout;
    const Smoothing& smoothing;
    const Walls& walls;
    const Vec3d gravity;
    const Periodic& periodic;

    // The disc at a time: its pose, its own motion, the velocity of what leaves it.
    struct Disc {
        RigidPose pose;
        RigidVelocity moving;
        Vec3d jet, axis, centre;
        Vec3d own_velocity(const Vec3d& x) const { return moving.linear + moving.angular.cross(x - pose.translation); }
        Vec3d flow(const Vec3d& x) const { return jet + moving.linear + moving.angular.cross(x - pose.translation); }
    };
    Disc disc(double time) const {
        Disc d{layout.motion.pose(time), layout.motion.velocity(time), {}, {}, {}};
        d.jet = d.pose.rotation * Vec3d(layout.turn.col(2) * layout.speed);
        d.axis = d.jet.normalized();
        d.centre = d.pose.apply(layout.centre);
        return d;
    }

    // How far ahead of the disc a layer starts [m]: the least distance at which all of it is clear of walls.
    std::optional<double> start_beyond_wall(const Disc& d, const std::vector<Vec3>& layer) const {
        constexpr int kSteps = 10;  // up to one spacing
        for (int k = 0; k <= kSteps; ++k) {
            const double ahead = static_cast<double>(smoothing.spacing) * k / kSteps;
            const Vec3d from = d.centre + ahead * d.axis;
            if (std::ranges::all_of(layer, [&](const Vec3& site) {
                    const Vec3d x = from + d.pose.rotation * (layout.turn * site.cast<double>());
                    return wall_distance(walls, periodic.wrapped(x.cast<Real>())) >= kRoomToWall * smoothing.spacing;
                }))
                return ahead;
        }
        return std::nullopt;
    }

    // How far ahead of the disc a layer starts, and how near to walls its sites may be [m].
    struct Standing {
        double ahead;
        Real wall_room;
    };
    Standing stand_back(const Disc& d, const std::vector<Vec3>& layer) const {
        const std::optional<double> clear = start_beyond_wall(d, layer);
        return {clear.value_or(0), clear ? kRoomToWall * smoothing.spacing : Real(0)};
    }
    std::int64_t sites_in_walls(const Disc& d, const std::vector<Vec3>& layer) const {
        const Standing standing = stand_back(d, layer);
        const Vec3d from = d.centre + standing.ahead * d.axis;
        return std::ranges::count_if(layer, [&](const Vec3& site) {
            const Vec3d x = from + d.pose.rotation * (layout.turn * site.cast<double>());
            return wall_distance(walls, periodic.wrapped(x.cast<Real>())) < standing.wall_room;
        });
    }

    struct Placed {
        Vec3 in;         // within the domain [m]
        Vec3d velocity;  // [m/s]
    };
    // The particles of a layer that left the disc `age` [s] ago. Those that walls or the layer's own particles hinder are
    // left out. Nothing where another particle stands in the way of any of them.
    std::optional<std::vector<Placed>> place(const std::vector<Vec3>& layer, const Disc& d, double age, double last_dt,
                                             std::uint64_t seed, const Particles& particles,
                                             std::int64_t next_id) const {
        const double spacing = smoothing.spacing;
        const auto [ahead, wall_room] = stand_back(d, layer);
        const Vec3d now = d.centre + age * d.flow(d.centre) + 0.5 * square(age) * gravity;
        FreeRoom others(particles, periodic, now.cast<Real>(), static_cast<Real>(layout.opening.radius + 3 * spacing),
                        kRoomToParticle * smoothing.spacing);
        FreeRoom own(kRoomToParticle * smoothing.spacing);
        std::vector<Placed> placed;
        for (const Vec3& site : layer) {
            const auto id = static_cast<std::uint64_t>(next_id) + placed.size();
            const double radius = emitter.jitter * spacing * std::sqrt(random_unit(seed, id, 0, kJitterRadius));
            const double angle = 2 * kPi * random_unit(seed, id, 0, kJitterAngle);
            const Vec3d shaken = site.cast<double>() + radius * Vec3d(std::cos(angle), std::sin(angle), 0);
            const Vec3d at = d.centre + d.pose.rotation * (layout.turn * shaken);
            const Vec3d flow = d.flow(at);
            Vec3d x = at + age * flow + 0.5 * square(age) * gravity;
            if (ahead > 0) x += ahead * d.axis;
            const Vec3 in = periodic.wrapped(x.cast<Real>());
            if (wall_distance(walls, in) < wall_room || !own.free(x.cast<Real>())) continue;
            if (!others.free(x.cast<Real>())) return std::nullopt;
            own.take(x.cast<Real>());
            placed.push_back({in, flow + (age - 0.5 * last_dt) * gravity});
        }
        return placed;
    }

    // Liquid beside the opening does not flow into the room that the next layer comes to: the jet is there without a gap.
    // Openings that a shape gives have no such rim yet.
    void hold_back(const Disc& d, const Vec3d& x, Vec3& velocity) const {
        const double spacing = smoothing.spacing, ahead = d.axis.dot(x - d.centre);
        const Vec3d across = x - d.centre - ahead * d.axis;
        if (ahead < -0.5 * spacing || ahead > spacing || across.norm() > layout.opening.radius + 1.5 * spacing) return;
        const Vec3d out = across.normalized();
        const double through = out.dot(velocity.cast<double>() - d.own_velocity(x));
        if (through < 0) velocity -= (through * out).cast<Real>();
    }

    // Notes the liquid at the opening, and gives it the speed of the flow; keeps what is behind the disc behind it.
    void drive(const Disc& d, Particles& particles, std::vector<Index>& driven) const {
        const double spacing = smoothing.spacing, wide2 = square(layout.opening.radius + 0.5 * spacing);
        const Edge edge{layout.opening, layout.turn, layout.centre};
        for (std::size_t i = 0; i < particles.size(); ++i) {
            if (particles.phase[i] != Phase::liquid) continue;
            const Vec3d x = periodic.nearest_image(particles.position[i], d.centre.cast<Real>()).cast<double>();
            const double ahead = d.axis.dot(x - d.centre);
            if (ahead < -1.5 * spacing || ahead > 2 * spacing) continue;
            if ((x - d.centre).squaredNorm() - square(ahead) > wide2) {
                if (!layout.opening.shape) hold_back(d, x, particles.velocity[i]);
                continue;
            }
            if (layout.opening.shape) {
                const Vec3d own = layout.turn.transpose() * (d.pose.rotation.conjugate() * (x - d.centre));
                if (edge(own.cast<Real>()) > smoothing.spacing / 2) continue;
            }
            if (ahead > 0) {
                driven.push_back(static_cast<Index>(i));
                particles.velocity[i] = d.flow(x).cast<Real>();
                continue;
            }
            particles.acceleration[i].setZero();
            // What is too near for the next layer makes way backwards.
            const double most = ahead > -0.8 * spacing ? -layout.speed : 0;
            const double through = d.axis.dot(particles.velocity[i].cast<double>() - d.own_velocity(x));
            if (through > most) particles.velocity[i] -= ((through - most) * d.axis).cast<Real>();
        }
    }
};

double area_of(const TriangleMesh& mesh) {
    double twice = 0;
    for (const auto& [a, b, c] : mesh.triangles) {
        const Vec3d from = mesh.vertices[a].cast<double>();
        twice += (mesh.vertices[b].cast<double>() - from).cross(mesh.vertices[c].cast<double>() - from).norm();
    }
    return twice / 2;
}

}  // namespace

void add_emitted(const Sources& sources, std::size_t emitter, const Vec3& place, const Vec3d& velocity, std::int64_t id,
                 Particles& particles) {
    const EmitterLayout& layout = sources.layouts[emitter];
    const Index i = append_row(particles);
    particles.id[i] = id;
    particles.position[i] = place;
    if (particles.has.surface) particles.surface_position[i] = place;
    particles.velocity[i] = velocity.cast<Real>();
    particles.acceleration[i] = sources.gravity;
    particles.mass[i] = static_cast<Real>(layout.mass);
    particles.rest_volume[i] = cube(sources.smoothing.spacing);
    particles.density[i] = static_cast<Real>(layout.mass / cube(static_cast<double>(sources.smoothing.spacing)));
    particles.temperature[i] = sources.emitters[emitter].temperature;
    particles.material[i] = layout.material;
    particles.body[i] = layout.body;
    particles.melt[i] = 1;
    particles.phase[i] = Phase::liquid;
}

Opening opening_of(const scene::Scene& scene, const scene::Emitter& emitter) {
    Opening opening;
    opening.radius = emitter.radius;
    opening.area = kPi * square(emitter.radius);
    if (std::holds_alternative<std::monostate>(emitter.shape.kind)) return opening;
    opening.shape = make_shape(scene, emitter.shape);
    const auto box = opening.shape->bounds();
    if (!box)
        throw InputError("{}: the shape of emitter '{}' has no bounds; intersect it with a box", emitter.shape.where,
                         emitter.name);
    if (emitter.source == scene::SourceForm::surface)
        opening.area = named_in_scene(emitter.shape, "emitter", emitter.name,
                                      [&] { return area_of(tessellate(*opening.shape, scene.solver.spacing / 4)); });
    if (emitter.source == scene::SourceForm::volume) opening.area = 0;
    const Vec3 centre = emitter.position.cast<Real>();
    const Vec3 farthest = (box->lower - centre).cwiseAbs().cwiseMax((box->upper - centre).cwiseAbs());
    opening.radius = static_cast<double>(farthest.norm());
    if (emitter.source != scene::SourceForm::cut) return opening;
    const Mat3d turn = frame_along(emitter.direction);
    const double cell = std::max(scene.solver.spacing / 8, opening.radius / 256);
    const int reach = static_cast<int>(std::ceil(opening.radius / cell));
    const Edge edge{opening, turn, emitter.position};
    double cells = 0, widest = 0;
    for (int j = -reach; j < reach; ++j)
        for (int i = -reach; i < reach; ++i) {
            const Vec3d own(cell * (i + 0.5), cell * (j + 0.5), 0);
            const double part = clamp01(0.5 - static_cast<double>(edge(own.cast<Real>())) / cell);
            cells += part;
            if (part > 0) widest = std::max(widest, own.norm());
        }
    opening.area = square(cell) * cells;
    opening.radius = widest + cell;
    if (cells == 0)
        throw InputError(
            "{}: the shape of emitter '{}' does not meet the plane through its position across its direction",
            emitter.shape.where, emitter.name);
    return opening;
}

double flow_time_after(const scene::Emitter& emitter, double from, double interval) {
    double at = from + interval, off = from;
    bool on = true;
    for (const scene::Switch& s : emitter.switches) {
        if (s.time <= from) {
            on = s.on;
        } else if (on && !s.on) {
            if (s.time > at) return at;
            off = s.time;
            on = false;
        } else if (!on && s.on) {
            at += s.time - off;
            on = true;
        }
    }
    return on ? at : std::max(at, emitter.stop);
}

double flow_seconds(const scene::Emitter& emitter, double end) {
    const double last = std::min(end, emitter.stop);
    double seconds = 0, from = emitter.start;
    bool on = true;
    const auto until = [&](double time) {
        const double to = std::clamp(time, from, std::max(from, last));
        if (on) seconds += to - from;
        from = to;
    };
    for (const scene::Switch& s : emitter.switches) {
        until(s.time);
        on = s.on;
    }
    until(last);
    return seconds;
}

double sites_of_opening(double area, double spacing) {
    return area / (cube(spacing) / static_cast<double>(packing_layer(static_cast<Real>(spacing))));
}

EmitterLayout lay_out_emitter(const scene::Scene& scene, const scene::Emitter& emitter,
                              const ResolvedMaterial& material, Real spacing) {
    EmitterLayout layout;
    layout.opening = opening_of(scene, emitter);
    const double area = layout.opening.area;
    layout.speed = flow_speed(emitter, area);
    layout.mass = static_cast<double>(material.density) * cube(static_cast<double>(spacing));
    layout.flow = static_cast<double>(material.density) * flow_rate(emitter, area);
    layout.centre = emitter.position;
    layout.motion = motion_of(scene, emitter.motion);
    layout.turn = frame_along(emitter.direction);
    if (emitter.source != scene::SourceForm::cut) {
        layout.spread = spread_sites(emitter, *layout.opening.shape, spacing);
        return layout;
    }

    const Edge edge{layout.opening, layout.turn, layout.centre};
    const double wanted = 2 * sites_of_opening(area, static_cast<double>(spacing));
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
                for_each_site_in(edge, spacing, k, dx, dy, [&](const Vec3& s) {
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
            "emitter '{}' has an opening of {:.4g} m^2, too small for particles {} m apart; make it wider or lower "
            "solver.spacing",
            emitter.name, area, spacing);
    for (const int k : {0, 1})
        for_each_site_in(edge, spacing, k, best_dx, best_dy, [&](const Vec3& s) { layout.layers[k].push_back(s); });
    return layout;
}

OpeningRoom room_at_opening(const Sources& sources, std::size_t emitter, double time) {
    const Emission emission{
        sources.emitters[emitter], sources.layouts[emitter], sources.smoothing, sources.walls, Vec3d::Zero(),
        sources.periodic};
    if (emission.emitter.source != scene::SourceForm::cut) return room_of_spread(sources, emitter, time);
    OpeningRoom room;
    for (const std::vector<Vec3>& layer : sources.layouts[emitter].layers) {
        room.sites += static_cast<std::int64_t>(layer.size());
        room.blocked += emission.sites_in_walls(emission.disc(time), layer);
    }
    return room;
}

std::vector<Index> drive_openings(const Sources& sources, double time, const std::vector<EmitterState>& states,
                                  Particles& particles) {
    std::vector<Index> driven;
    for (std::size_t e = 0; e < sources.emitters.size(); ++e) {
        const scene::Emitter& emitter = sources.emitters[e];
        if (emitter.source != scene::SourceForm::cut || !states[e].pushing || time >= emitter.stop ||
            flow_time_after(emitter, time, 0) > time)
            continue;
        const Emission emission{sources.emitters[e], sources.layouts[e], sources.smoothing,
                                sources.walls,       Vec3d::Zero(),      sources.periodic};
        emission.drive(emission.disc(time), particles, driven);
    }
    return driven;
}

void emit_particles(const Sources& sources, double time, double last_dt, std::vector<EmitterState>& states,
                    Particles& particles, std::int64_t& next_id) {
    for (std::size_t e = 0; e < sources.emitters.size(); ++e) {
        const scene::Emitter& emitter = sources.emitters[e];
        const EmitterLayout& layout = sources.layouts[e];
        EmitterState& state = states[e];
        if (emitter.source != scene::SourceForm::cut) {
            emit_spread(sources, e, {time, last_dt}, state, particles, next_id);
            continue;
        }
        const Emission emission{
            emitter, layout, sources.smoothing, sources.walls, sources.gravity.cast<double>(), sources.periodic};
        while (state.next <= time && state.next < emitter.stop) {
            const std::vector<Vec3>& layer = layout.layers[state.layer & 1];
            const double interval = static_cast<double>(layer.size()) * layout.mass / layout.flow;
            std::optional<std::vector<Emission::Placed>> placed;
            for (int k = 0; k <= kShorter && !placed; ++k) {
                const double left_at = state.next + (time - state.next) * k / kShorter;
                placed = emission.place(layer, emission.disc(left_at), time - left_at, last_dt, sources.seed, particles,
                                        next_id);
            }
            if (!placed) {
                state.pushing = true;
                if (state.next + kPatience * interval > time) break;  // it waits; else it is given up
            }
            const std::size_t count = placed ? placed->size() : 0;
            for (std::size_t k = 0; k < count; ++k)
                add_emitted(sources, e, (*placed)[k].in, (*placed)[k].velocity, next_id++, particles);
            state.due += static_cast<std::int64_t>(layer.size());
            state.blocked += static_cast<std::int64_t>(layer.size() - count);
            state.next = flow_time_after(emitter, state.next, interval);
            ++state.layer;
        }
    }
}

}  // namespace thixo
