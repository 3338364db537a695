#include "render/path.h"

#include "render/media.h"

namespace thixo::render {
namespace {

/// How the ray came here since the last shaded surface: one that is no mirror and no clear interface.
///
/// - direct: straight
/// - clear: through smooth dielectrics alone
/// - clear_reflected: by smooth dielectrics, of which at least one reflected it
/// - mirrored: at least one smooth metal or coat reflected it
enum class Chain { direct, clear, clear_reflected, mirrored };

struct State {
    Ray ray;
    Interior interior;
    Vec3f throughput{1, 1, 1};
    Vec3f radiance{0, 0, 0};
    float compression = 1;  // product of (n after / n before)^2: throughput times this is what roulette goes by
    int shaded = 0;         // surfaces that are neither mirror nor clear, so far
    int bounces = 0;
    float travelled = 0;  // along the path [m]
    Chain chain = Chain::direct;
    float pdf = std::numeric_limits<float>::infinity();  // of the direction, at the last shaded surface
    Vec3f position{0, 0, 0}, normal{0, 0, 0};            // there
    float albedo = 0;                                    // there [1]
    int looked_for = 0;                                  // lights
    bool seen = false;                                   // FirstHit::seen is set
    float total_strength = 0;                            // of those lights; 0: each gets a sample
};

/// Fresnel reflection of light that goes straight through an interface. It is that met from the side with the lower
/// index, whichever way the light goes. So a slab costs the same as with refraction, and nothing is reflected totally.
float straight_reflectance(const Interface& interface, const Hit& hit, const Vec3f& direction) {
    const float high = std::max(interface.before, interface.after), low = std::min(interface.before, interface.after);
    return fresnel(std::min(1.0f, std::abs(hit.normal.dot(direction))), high / low);
}

/// Albedo from which on a surface looks for the sky by its own samples alone. Measured on a matt sheet and ball in sun
/// and sky: processor time times squared error is less from 0.42 on.
constexpr float kBright = 0.4f;

class Path {
  public:
    Path(const World& world, const Ray& ray, Sampler& sampler, FirstHit& first, Strategy strategy,
         std::span<Vec3d> groups)
        : world_(world), sampler_(sampler), first_(first), strategy_(strategy), groups_(groups) {
        s_.ray = ray;
        s_.interior = world.camera_interior;
    }

    Vec3f follow() {
        // Clear passages and total reflections do not count as bounces, since nothing is lost at them. Glass is dark
        // where light guided along its walls is cut. The larger limit ends rays that are caught.
        for (int segments = 0; segments < 16 * (world_.settings.max_bounces + 2); ++segments) {
            Hit hit;
            const bool found = nearest_hit(world_, s_.ray, s_.interior, hit);
            if (area_light_before(found ? hit.t : kInfinity)) break;
            if (!found) {
                s_.throughput = s_.throughput.cwiseProduct(absorb(world_, s_.interior, s_.ray, 0, kInfinity));
                escape();
                break;
            }
            s_.throughput = s_.throughput.cwiseProduct(absorb(world_, s_.interior, s_.ray, 0, hit.t));
            const Material& material = world_.material(hit);
            note_footprint(hit);
            if (material.bump.amplitude > 0) hit.normal = bumped_normal(material.bump, hit);
            note_first(hit, material);
            if (material.dielectric() ? !interact(hit, material) : !shade(hit, material)) break;
            if (!roulette()) break;
        }
        return s_.radiance;
    }

  private:
    void note_footprint(Hit& hit) {
        constexpr float kGrazing = 1e-3f;
        hit.footprint = (s_.travelled += hit.t) * world_.camera.pixel_angle();
        const Vec3f& d = s_.ray.direction;
        const float along = hit.geometric.dot(d);
        hit.slant = hit.footprint / std::max(std::abs(along), kGrazing) * (d - along * hit.geometric);
        Vec3f a, b;
        orthonormal_basis(hit.normal, a, b);  // as of the attributes: before bumps
        hit.rest_slant = a.dot(hit.slant) * hit.attributes.rest_a + b.dot(hit.slant) * hit.attributes.rest_b;
    }

    void note_first(const Hit& hit, const Material& material) {
        if (s_.bounces > 0 || first_.found) return;
        first_.found = true;
        first_.hit = hit;
        first_.place = world_.origin + hit.position.cast<double>();
        const Camera camera = world_.camera_then(s_.ray.time);
        first_.depth = (hit.position - camera.position).dot(camera.forward);
        first_.normal = hit.normal.dot(s_.ray.direction) < 0 ? hit.normal : Vec3f(-hit.normal);
        first_.albedo = material.dielectric() ? Vec3f(Vec3f::Ones()) : material.colour_at(hit);
        if (world_.labels.empty()) return;
        first_.label = &world_.labels[hit.object];
        if (world_.passes.motion) first_.motion = motion_at(hit);
    }

    /// What all clear and mirroring surfaces so far show, its colour and glow times what they leave of it.
    void note_seen(const Vec3f& colour) {
        if (s_.seen) return;
        s_.seen = true;
        const Vec3f share = (s_.compression * s_.throughput).cwiseMin(1.0f);
        first_.seen = share.cwiseProduct(colour).cwiseMin(1.0f);
        first_.way = share.mean() * s_.ray.direction;
    }

    /// The point goes on along its velocity, straight; its picture moves with it and with the camera.
    Eigen::Vector4f motion_at(const Hit& hit) const {
        const ObjectLabel& label = world_.labels[hit.object];
        const Neighbours& n = world_.neighbours;
        const float seconds = world_.shutter.seconds(s_.ray.time);
        const SteadyMotion motion{label.origin, label.velocity, label.angular_velocity};
        const Vec3f place = hit.blended ? Vec3f(hit.position - seconds * hit.attributes.velocity)
                                        : motion.before(hit.position, seconds);
        const Vec3f velocity = hit.blended ? hit.attributes.velocity
                                           : Vec3f(label.velocity + label.angular_velocity.cross(place - label.origin));
        const Vec2f here = world_.camera.pixel(place), next = n.after.pixel(place + n.seconds * velocity) - here,
                    last = n.before.pixel(place - n.seconds * velocity) - here;
        return {next.x(), -next.y(), last.x(), -last.y()};
    }

    /// Adds what comes from light i. What took more than one scattering is limited, since single samples of it can be
    /// arbitrarily bright.
    void add(std::size_t i, const Vec3f& light, bool indirect) {
        add_to(groups_.empty() ? 0 : world_.light_groups.of_light[i], light, indirect);
    }
    void add_to(std::size_t group, const Vec3f& light, bool indirect) {
        Vec3f c = s_.throughput.cwiseProduct(light);
        if (!c.allFinite()) return;
        const float largest = c.maxCoeff();
        if (indirect && world_.settings.clamp > 0 && largest > world_.settings.clamp)
            c *= world_.settings.clamp / largest;
        s_.radiance += c;
        if (!groups_.empty()) groups_[group] += c.cast<double>();
    }

    /// Whether the last shaded surface looks for light i by samples of its own, beside meeting it by chance. A sky
    /// fills half of all directions. What stands before it sends back about the albedo's part of its light. So a
    /// direction that the surface chooses brings much the same light whatever it meets. Samples of the sky beside it
    /// then cost more than they gain. They pay on dark surfaces alone, where no other light has to share with them.
    bool looks_for(std::size_t i) const {
        if (strategy_ != Strategy::both) return strategy_ == Strategy::lights;
        return world_.lights[i].type != scene::LightType::sky || (s_.shaded == 1 && s_.albedo < kBright);
    }

    /// The share of samples that light i gets at the last shaded surface. It is never zero, because light_strength does
    /// not know everything.
    float share(std::size_t i) const {
        if (s_.total_strength <= 0) return 1;
        return 0.9f * light_strength(world_.lights[i], s_.position) / s_.total_strength + 0.1f / float(s_.looked_for);
    }

    /// Weight of light i met by chance in the ray's direction.
    float chance_weight(std::size_t i, float distance) const {
        if (s_.shaded == 0 || !looks_for(i)) return 1;
        // With straight shadows the refracted light is counted by shadow rays. What clear surfaces reflect of small
        // lights is left out: it is the noise that straight shadows are to avoid.
        const bool small = !world_.lights[i].surrounds();
        if (world_.settings.straight_shadows &&
            (s_.chain == Chain::clear || (s_.chain == Chain::clear_reflected && small)))
            return 0;
        if (s_.chain != Chain::direct) return 1;
        if (strategy_ == Strategy::lights) return 0;
        return surface_weight(i, s_.pdf, share(i) * light_pdf(world_.lights[i], s_.normal, s_.ray.direction, distance));
    }

    /// Weight of light i where the surface's own sample meets it; the light's sample has the rest. Both densities are
    /// those of one direction [1/sr].
    ///   w = b p_s^2 / (b p_s^2 + (1 - b) p_l^2)
    /// b = 1/2 is the power heuristic (Veach 1997). A sky and what stands before it differ by 1 - albedo of the light,
    /// about. For p_s = p_l the noise of both samples together is then least at
    ///   b = (1 + albedo) / 2.
    float surface_weight(std::size_t i, float surface_pdf, float light_pdf) const {
        if (!std::isfinite(surface_pdf)) return 1;
        const float b = world_.lights[i].type == scene::LightType::sky ? 0.5f * (1 + s_.albedo) : 0.5f;
        const float surface = b * square(surface_pdf), light = (1 - b) * square(light_pdf);
        return surface + light > 0 ? surface / (surface + light) : 0;
    }

    /// Light met by chance is indirect unless it is seen directly or by the first shaded surface.
    bool indirect_chance() const { return s_.bounces > 0 && !(s_.shaded == 1 && s_.chain == Chain::direct); }

    bool area_light_before(float limit) {
        std::size_t nearest = 0;
        float t = limit;
        for (std::size_t i = 0; i < world_.lights.size(); ++i) {
            if (world_.lights[i].infinite()) continue;
            const float ti = hit_area(world_.lights[i], s_.ray.origin, s_.ray.direction);
            if (ti < t) {
                t = ti;
                nearest = i;
            }
        }
        if (t >= limit) return false;
        if (s_.bounces == 0) first_.found = true;
        const float weight = chance_weight(nearest, t);
        const Vec3f left = absorb(world_, s_.interior, s_.ray, 0, t);
        note_seen(world_.lights[nearest].radiance.cwiseProduct(left));
        if (weight > 0) add(nearest, weight * world_.lights[nearest].radiance.cwiseProduct(left), indirect_chance());
        return true;
    }

    /// Out of the scene.
    void escape() {
        if (s_.bounces == 0 && world_.settings.transparent_background) return;
        bool sky = false;
        Vec3f all(0, 0, 0);
        for (std::size_t i = 0; i < world_.lights.size(); ++i) {
            if (!world_.lights[i].infinite()) continue;
            sky |= world_.lights[i].surrounds();
            const Vec3f light = infinite_radiance(world_.lights[i], s_.ray.direction);
            if (light.maxCoeff() <= 0) continue;
            all += light;
            const float weight = chance_weight(i, kInfinity);
            if (weight > 0) add(i, weight * light, indirect_chance());
        }
        note_seen(sky ? all : Vec3f(all + world_.background));
        if (!sky && s_.shaded == 0) add_to(LightGroups::kBackground, world_.background, false);
    }

    /// The path's next ray, at the same time as the one before.
    void go_on(const Vec3f& origin, const Vec3f& direction, bool bounced = false) {
        s_.ray = {origin, direction, 0, kInfinity, bounced, s_.ray.time};
    }
    void bounce(const Hit& hit, const Vec3f& direction) { go_on(leave(hit, direction), direction, true); }

    /// A dielectric: reflects or refracts by chance. False: the path ends.
    bool interact(const Hit& hit, const Material& material) {
        const Interface interface = interface_at(world_, s_.interior, hit);
        if (!interface.real) {
            s_.interior = interface.behind;
            go_on(pass(hit, s_.ray.direction), s_.ray.direction);
            return true;
        }
        if (!material.clear())
            return ++s_.bounces <= world_.settings.max_bounces && scatter_rough(hit, material, interface);
        const float choose = sampler_.next();
        // The smooth normal decides unless it sends the ray to the wrong side of the surface; then the surface itself
        // does.
        if (!refract(hit, interface, hit.normal, choose)) refract(hit, interface, hit.geometric, choose);
        return s_.bounces <= world_.settings.max_bounces;
    }

    bool refract(const Hit& hit, const Interface& interface, const Vec3f& outward, float choose) {
        const Vec3f d = s_.ray.direction;
        const bool front = hit.geometric.dot(d) < 0;
        const Vec3f n = front ? outward : Vec3f(-outward), side = front ? hit.geometric : Vec3f(-hit.geometric);
        const float cosine = std::min(1.0f, -n.dot(d));
        if (cosine <= 0) return false;
        const float eta = interface.after / interface.before;
        float cos_t;
        const float reflectance = fresnel(cosine, eta, cos_t);
        if (choose < reflectance) {
            const Vec3f r = d + 2 * cosine * n;
            if (side.dot(r) <= 0 && outward != hit.geometric) return false;
            go_on(leave(hit, r), r.normalized(), true);
            if (s_.chain != Chain::mirrored) s_.chain = Chain::clear_reflected;
            if (reflectance < 1) ++s_.bounces;
            return true;
        }
        const Vec3f t = d / eta + (cosine / eta - cos_t) * n;
        if (side.dot(t) >= 0 && outward != hit.geometric) return false;
        go_on(pass(hit, d), t.normalized());
        s_.interior = interface.behind;
        ++s_.bounces;
        if (s_.chain == Chain::direct) s_.chain = Chain::clear;
        s_.throughput /= eta * eta;  // radiance is densest where the index is highest
        s_.compression *= eta * eta;
        return true;
    }

    /// A rough interface: light from the lights on both its sides, then on in a direction of its choice.
    bool scatter_rough(const Hit& hit, const Material& material, const Interface& interface) {
        const RoughInterface rough = material.dielectric()->interface(interface.before, interface.after);
        const Frame3 frame = frame_at(hit);
        const Vec3f wo = frame.local(-s_.ray.direction);
        const auto f = [&](const Vec3f& wi, float& pdf) { return Vec3f(Vec3f::Constant(rough.evaluate(wo, wi, pdf))); };
        note_seen(Vec3f::Ones());
        begin_shading(hit, frame.n, 0);
        light_up(hit, frame, frame.side, s_.interior, f);
        light_up(hit, frame, -frame.side, interface.behind, f);
        const float choose = sampler_.next();
        const Scatter scattered = rough.scatter(wo, choose, sampler_.next2());
        if (scattered.weight.maxCoeff() <= 0) return false;
        const Vec3f direction = frame.world(scattered.direction);
        const bool through = scattered.direction.z() < 0;
        if ((frame.side.dot(direction) < 0) != through) return false;
        s_.throughput = s_.throughput.cwiseProduct(scattered.weight);
        s_.pdf = scattered.pdf;
        s_.chain = Chain::direct;
        if (!through) {
            bounce(hit, direction);
            return true;
        }
        s_.normal = -frame.n;
        go_on(pass(hit, direction), direction);
        s_.interior = interface.behind;
        s_.compression *= square(rough.eta);
        return true;
    }

    /// An opaque surface: its own light, light from the lights, then on in a direction of its choice. False: the path
    /// ends.
    bool shade(const Hit& hit, const Material& material) {
        const Vec3f glow = material.glow.any() ? material.glow.at(hit) : Vec3f(0, 0, 0);
        if (material.glow.any()) add_to(world_.light_groups.of_glow, glow, indirect_chance());
        if (++s_.bounces > world_.settings.max_bounces) return false;
        const Frame3 frame = frame_at(hit);
        const Vec3f wo = frame.local(-s_.ray.direction), colour = material.colour_at(hit);
        begin_shading(hit, frame.n, luminance(material.albedo(colour, wo.z())));
        light_up(hit, frame, frame.side, s_.interior,
                 [&](const Vec3f& wi, float& pdf) { return material.evaluate(colour, wo, wi, pdf); });
        const float choose = sampler_.next();
        const Scatter scattered = material.scatter(colour, wo, choose, sampler_.next2());
        if (!scattered.mirror()) note_seen(colour + glow);
        if (scattered.weight.maxCoeff() <= 0) return false;
        const Vec3f direction = frame.world(scattered.direction);
        if (frame.side.dot(direction) <= 0) return false;
        s_.throughput = s_.throughput.cwiseProduct(scattered.weight);
        s_.pdf = scattered.pdf;
        s_.chain = Chain::direct;
        if (scattered.mirror()) {  // no shadow ray could have brought what comes this way
            --s_.shaded;
            s_.chain = Chain::mirrored;
        }
        bounce(hit, direction);
        return true;
    }

    /// The frame in which directions of scattering are given. `n` is the smooth normal on the side that the ray comes
    /// from. Where it leans away from the ray, n is `side`, the surface's own normal on that side.
    struct Frame3 {
        Vec3f a, b, n, side;
        Vec3f local(const Vec3f& w) const { return {w.dot(a), w.dot(b), w.dot(n)}; }
        Vec3f world(const Vec3f& w) const { return (w.x() * a + w.y() * b + w.z() * n).normalized(); }
    };
    Frame3 frame_at(const Hit& hit) const {
        const Vec3f out = -s_.ray.direction;
        Frame3 frame;
        frame.side = hit.geometric.dot(out) > 0 ? hit.geometric : Vec3f(-hit.geometric);
        frame.n = hit.normal.dot(frame.side) > 0 ? hit.normal : Vec3f(-hit.normal);
        if (frame.n.dot(out) < 1e-3f) frame.n = frame.side;
        orthonormal_basis(frame.n, frame.a, frame.b);
        return frame;
    }

    void begin_shading(const Hit& hit, const Vec3f& n, float albedo) {
        ++s_.shaded;
        s_.position = hit.position;
        s_.normal = n;
        s_.albedo = albedo;
        s_.looked_for = 0;
        s_.total_strength = 0;
        for (std::size_t i = 0; i < world_.lights.size(); ++i) {
            if (!looks_for(i)) continue;
            ++s_.looked_for;
            if (s_.shaded > 1) s_.total_strength += light_strength(world_.lights[i], hit.position);
        }
    }

    /// Next-event estimation on one side of the surface. The first shaded surface samples every light that it looks
    /// for. Later ones sample one of them, chosen by its share. f(wi, pdf) is what is scattered of light from the local
    /// direction wi.
    template <class F>
    void light_up(const Hit& hit, const Frame3& frame, const Vec3f& side, const Interior& interior, F&& f) {
        if (s_.looked_for == 0) return;
        const bool all = s_.shaded == 1;
        float u = all ? 0 : sampler_.next();
        std::size_t chosen = 0;
        for (std::size_t i = 0; i < world_.lights.size(); ++i) {
            if (!looks_for(i)) continue;
            chosen = i;
            if (all) light_from(i, hit, frame, side, interior, f);
            if (!all && u < share(i)) break;
            u -= share(i);
        }
        if (!all) light_from(chosen, hit, frame, side, interior, f);
    }

    template <class F>
    void light_from(std::size_t i, const Hit& hit, const Frame3& frame, const Vec3f& side, const Interior& interior,
                    F&& f) {
        const bool behind = side.dot(frame.side) < 0;
        const LightSample light =
            sample_light(world_.lights[i], hit.position, behind ? Vec3f(-frame.n) : frame.n, sampler_.next2());
        if (light.pdf <= 0 || side.dot(light.direction) <= 0) return;
        float pdf = 0;
        const Vec3f scattered = f(frame.local(light.direction), pdf);
        if (scattered.maxCoeff() <= 0) return;
        const Ray shadow{behind ? pass(hit, light.direction) : leave(hit, light.direction),
                         light.direction,
                         0,
                         light.distance * (1 - 1e-4f),
                         !behind,
                         s_.ray.time};
        for (std::size_t j = 0; j < world_.lights.size();
             ++j)  // rectangles stand in each other's light, as they do for a ray that meets them
            if (j != i && !world_.lights[j].infinite() &&
                hit_area(world_.lights[j], shadow.origin, shadow.direction) < shadow.tmax)
                return;
        bool through = false;
        const Vec3f left = transmittance(world_, shadow, interior, through);
        if (left.maxCoeff() <= 0) return;
        const float chance = share(i) * light.pdf;
        // Light that came through a dielectric cannot be met by chance (chance_weight).
        const bool alone = through || strategy_ == Strategy::lights || world_.lights[i].sizeless();
        const float weight = alone ? 1 : 1 - surface_weight(i, pdf, chance);
        add(i, scattered.cwiseProduct(light.radiance).cwiseProduct(left) * (weight / chance), s_.shaded > 1);
    }

    bool roulette() {
        if (s_.bounces < 4) return true;
        const float survive = std::min(0.95f, s_.throughput.maxCoeff() * s_.compression);
        if (survive >= 0.95f) return true;
        if (sampler_.next() >= survive) return false;
        s_.throughput /= survive;
        return true;
    }

    const World& world_;
    Sampler& sampler_;
    FirstHit& first_;
    Strategy strategy_;
    std::span<Vec3d> groups_;
    State s_;
};

}  // namespace

Vec3f transmittance(const World& world, Ray ray, Interior interior, bool& through) {
    Vec3f left = Vec3f::Ones();
    float from = 0;
    for (int surfaces = 0; surfaces < 64; ++surfaces) {
        Hit hit;
        const bool found = world.rays->intersect(ray, interior, hit);
        if (found && !world.material(hit).dielectric()) return Vec3f::Zero();
        const float to = found ? hit.t : ray.tmax;
        left = left.cwiseProduct(absorb(world, interior, ray, from, to));
        if (!found) return left;
        const Interface interface = interface_at(world, interior, hit);
        if (interface.real) {
            if (!world.settings.straight_shadows || !world.material(hit).clear()) return Vec3f::Zero();
            through = true;
            left *= 1 - straight_reflectance(interface, hit, ray.direction);
        }
        interior = interface.behind;
        ray.tmin = from = hit.t;
        ray.bounced = false;
    }
    return left;
}

Vec3f radiance(const World& world, const Ray& camera_ray, Sampler& sampler, FirstHit& first, Strategy strategy,
               std::span<Vec3d> groups) {
    return Path(world, camera_ray, sampler, first, strategy, groups).follow();
}

}  // namespace thixo::render
