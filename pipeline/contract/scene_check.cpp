#include "pipeline/contract/scene_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "pipeline/contract/scene_checker.h"
#include "pipeline/contract/scene_walk.h"

namespace thixo::scene {
namespace {

void check_heat(const Scene& scene, const Checker& check) {
    for (const Material& m : scene.materials)
        check.require(m.thermal.latent_heat <= 0 || m.thermal.liquidus > m.thermal.solidus,
                      fmt::format("materials.{}.latent_heat", m.name),
                      "\"latent_heat\" needs a \"liquidus\" above the \"solidus\"");
    for (const Material& m : scene.materials)
        check.require(!m.melting.any() || m.elastic.solid(), fmt::format("materials.{}.melting", m.name),
                      "only a solid can melt: the material's own keys are those of its cold end",
                      "give it a \"youngs_modulus\" above 0");
    for (const HeatSource& source : scene.world.heat_sources)
        check.require(source.to > source.from, fmt::format("world.heat_sources.{}.to", source.name),
                      fmt::format("\"to\" ({}) is not after \"from\" ({})", source.to, source.from));
}

void check_kind(const BoxShape& box, const std::string& path, const Checker& check) {
    check.require(box.rounding <= 0.5 * box.size.minCoeff(), path + ".box.rounding",
                  "\"rounding\" is more than half the shortest edge");
}
void check_kind(const Cylinder& cylinder, const std::string& path, const Checker& check) {
    check.require(cylinder.rounding <= std::min(cylinder.radius, 0.5 * cylinder.height), path + ".cylinder.rounding",
                  "\"rounding\" is more than the radius or half the height");
}
void check_kind(const Capsule& capsule, const std::string& path, const Checker& check) {
    check.require((capsule.to - capsule.from).norm() > 0, path + ".capsule",
                  "the two ends of the capsule are the same point", "a ball is a sphere");
}
void check_kind(const RoundedCone& cone, const std::string& path, const Checker& check) {
    check.require(cone.height > std::abs(cone.radius1 - cone.radius2), path + ".rounded_cone",
                  "one sphere of the rounded cone holds the other");
}
void check_kind(const Torus& torus, const std::string& path, const Checker& check) {
    check.require(torus.tube <= torus.radius, path + ".torus.tube", "\"tube\" is more than the radius of the ring");
}
void check_kind(const Revolve& revolve, const std::string& path, const Checker& check) {
    const std::string key = path + ".revolve.profile";
    if (revolve.profile.empty() && check.context.where.find(key) == check.context.where.end())
        return;  // missing: already a problem
    check.require(revolve.profile.size() >= 3, key,
                  fmt::format("\"profile\" needs at least 3 points, not {}", revolve.profile.size()));
    for (const Vec2d& p : revolve.profile)
        if (p.x() < 0)
            return check.require(false, key, fmt::format("a point of \"profile\" has r = {}, below 0", p.x()));
    double area = 0;
    for (std::size_t k = 0; k < revolve.profile.size(); ++k) {
        const Vec2d &a = revolve.profile[k], &b = revolve.profile[(k + 1) % revolve.profile.size()];
        area += 0.5 * (a.x() * b.y() - b.x() * a.y());
    }
    check.require(revolve.profile.size() < 3 || std::abs(area) > 1e-18, key,
                  "the points of \"profile\" enclose nothing");
}
void check_kind(const MeshFile& mesh, const std::string& path, const Checker& check) {
    check.require((mesh.scale > 0) != (mesh.height > 0), path + ".mesh", "a mesh needs either \"scale\" or \"height\"",
                  "a file's units carry no size");
}
void check_kind(const Difference& difference, const std::string& path, const Checker& check) {
    check.require(difference.shapes.size() != 1, path + ".difference", "a difference needs at least two shapes");
}
void check_kind(const Sweep& sweep, const std::string& path, const Checker& check) {
    check.require(sweep.points.size() >= (sweep.closed ? 3u : 2u), path + ".sweep",
                  fmt::format("a sweep needs at least {} points", sweep.closed ? 3 : 2));
}
template <class K>
void check_kind(const K&, const std::string&, const Checker&) {}

constexpr double kMostShapes = 100'000;
constexpr int kDeepestShapes = 256;

struct Extent {
    double count = 1;
    int depth = 1;
    bool endless = false;  // contains itself
    void add(const Extent& inner) {
        count += inner.count;
        depth = std::max(depth, inner.depth + 1);
        endless = endless || inner.endless;
    }
};

/// How large shapes become with named ones put in their place: thirty names that each use the next one twice make a
/// thousand million.
class Extents {
  public:
    explicit Extents(const Scene& scene) {
        for (const auto& [name, shape] : scene.shapes) shapes_[name] = &shape;
    }
    Extent of(const Shape& shape) {
        Extent extent;
        std::visit(
            [&]<class K>(const K& kind) {
                if constexpr (std::is_base_of_v<ShapeList, K>)
                    for (const Shape& shape : kind.shapes) extent.add(of(shape));
                if constexpr (std::is_same_v<K, NamedShape>) extent.add(of_name(kind.name));
            },
            shape.kind);
        return extent;
    }
    Extent of_name(const std::string& name) {
        if (const auto found = known_.find(name); found != known_.end()) return found->second;
        const auto shape = shapes_.find(name);
        if (shape == shapes_.end()) return {};  // unknown: told elsewhere
        if (open_.count(name)) return {.endless = true};
        if (open_.size() > kDeepestShapes) return {.depth = kDeepestShapes + 1};
        open_.insert(name);
        const Extent extent = of(*shape->second);
        open_.erase(name);
        return known_[name] = extent;
    }

  private:
    std::map<std::string, const Shape*> shapes_;
    std::map<std::string, Extent> known_;
    std::set<std::string> open_;
};

void check_extents(const Scene& scene, const Checker& check) {
    Extents extents(scene);
    double total = 0;
    const auto good = [&](const Extent& extent, const std::string& path) {
        total += extent.count;
        check.require(!extent.endless, path, "the shape contains itself", "by named shapes that refer to each other");
        if (extent.endless) return false;
        check.require(extent.depth <= kDeepestShapes, path,
                      fmt::format("shapes are nested more than {} deep", kDeepestShapes));
        check.require(total <= kMostShapes, path,
                      fmt::format("more than {} shapes, named ones counted where they are used", kMostShapes));
        return extent.depth <= kDeepestShapes && total <= kMostShapes;
    };
    // One such problem is enough: the others follow from it.
    for (const auto& [name, shape] : scene.shapes)
        if (!good(extents.of_name(name), "shapes." + name)) return;
    for (const Boundary& b : scene.world.boundaries)
        if (!good(extents.of(b.shape), "world.boundaries." + b.name + ".shape")) return;
    for (const Body& b : scene.bodies)
        if (!good(extents.of(b.shape), "bodies." + b.name + ".shape")) return;
    for (const Emitter& e : scene.emitters)
        if (!good(extents.of(e.shape), "emitters." + e.name + ".shape")) return;
    for (const Handle& h : scene.handles)
        if (!good(extents.of(h.region), "handles." + h.name + ".region")) return;
    for (const Probe& p : scene.probes)
        if (!good(extents.of(p.region), "probes." + p.name + ".region")) return;
    for (const HeatSource& h : scene.world.heat_sources)
        if (!good(extents.of(h.region), "world.heat_sources." + h.name + ".region")) return;
    for (const Mould& m : scene.surface.moulds)
        if (!good(extents.of(m.shape), "surface.moulds." + m.name + ".shape")) return;
}

void check_shapes(const Scene& scene, const Checker& check) {
    std::vector<std::string> names;
    for (const auto& [name, shape] : scene.shapes) names.push_back(name);
    walk_shapes(scene, [&](const Shape& shape, const std::string& path) {
        std::visit([&](const auto& kind) { check_kind(kind, path, check); }, shape.kind);
        if (const auto* named = std::get_if<NamedShape>(&shape.kind))
            check.refer(named->name, names, path + ".named", "shape");
    });
    check_extents(scene, check);
}

void check_periodic(const Scene& scene, const Checker& check) {
    const std::vector<PeriodicAxis>& list = scene.world.periodic;
    // Nearer together than two supports, a particle would meet two images of another.
    const double least = 2 * scene.solver.support * scene.solver.spacing;
    for (std::size_t k = 0; k < list.size(); ++k) {
        const std::string path = fmt::format("world.periodic.{}", k);
        const auto same = [&](const PeriodicAxis& other) { return other.axis == list[k].axis; };
        check.require(std::none_of(list.begin(), list.begin() + static_cast<std::ptrdiff_t>(k), same), path + ".axis",
                      fmt::format("axis {} is periodic already", "xyz"[static_cast<int>(list[k].axis)]));
        check.require(list[k].to - list[k].from >= least * (1 - 1e-9), path + ".to",
                      fmt::format("\"to\" must be at least two supports, {} m, above \"from\", not {} m", least,
                                  list[k].to - list[k].from),
                      "a smaller solver.spacing has a smaller support");
    }
    check.require(list.empty() || !scene.surface.enabled, "world.periodic",
                  "a scene with periodic axes cannot have a surface: surfels do not cross periodic faces",
                  "write surface: {enabled: false}");
}

void check_elastic(const Scene& scene, const Checker& check) {
    const auto find = [&](const std::string& name) {
        return std::find_if(scene.materials.begin(), scene.materials.end(),
                            [&](const Material& m) { return m.name == name; });
    };
    for (const Material& m : scene.materials) {
        double before = -1;
        for (std::size_t k = 0; k < m.elastic.changes.size(); ++k) {
            const MaterialChange& c = m.elastic.changes[k];
            const std::string path = fmt::format("materials.{}.changes.{}", m.name, k);
            check.refer(c.material, names_of(scene.materials), path + ".material", "material");
            const auto other = find(c.material);
            check.require(other == scene.materials.end() || m.elastic.solid() == other->elastic.solid(),
                          path + ".material", fmt::format("\"{}\" and \"{}\" are not both solids", m.name, c.material),
                          "give both a youngs_modulus above 0; what melts has a block \"melting\"");
            check.require(
                c.time - c.duration >= before, path + ".time",
                fmt::format("the change begins at {} s, before the one above it is complete", c.time - c.duration));
            before = c.time;
        }
    }
}

/// The compliance of normal strains must be positive definite, or the material would give energy away.
bool stable(const Orthotropic& o) {
    const Vec3d &e = o.youngs_modulus, &nu = o.poisson_ratio;
    Mat3d compliance;
    compliance << 1 / e[0], -nu[0] / e[0], -nu[2] / e[2], -nu[0] / e[0], 1 / e[1], -nu[1] / e[1], -nu[2] / e[2],
        -nu[1] / e[1], 1 / e[2];
    const Vec3d root = e.cwiseSqrt();
    const Mat3d scaled = root.asDiagonal() * compliance * root.asDiagonal();
    return Eigen::SelfAdjointEigenSolver<Mat3d>(scaled, Eigen::EigenvaluesOnly).eigenvalues()[0] > 1e-6;
}

void check_orthotropic(const Scene& scene, const Checker& check) {
    for (const Material& m : scene.materials) {
        const Orthotropic& o = m.elastic.orthotropic;
        if (!o.any()) continue;
        const std::string path = fmt::format("materials.{}.orthotropic", m.name);
        const bool positive = o.youngs_modulus.minCoeff() > 0 && o.shear_modulus.minCoeff() > 0;
        check.require(positive, path, "an orthotropic material needs three moduli above 0 of each kind",
                      "youngs_modulus: [E1, E2, E3], shear_modulus: [G12, G23, G31]");
        check.require(!positive || stable(o), path + ".poisson_ratio",
                      "no material has these ratios with these moduli: it would give energy away when it is strained",
                      "nu_ab^2 < E_a/E_b for every pair, and not all three near that");
        check.require(m.elastic.solid(), path, "only a solid can be orthotropic",
                      "give the material a \"youngs_modulus\" above 0");
        check.require(!m.melting.any(), path, "an orthotropic material that melts is not supported yet");
        check.require(m.elastic.changes.empty(), path, "changes of an orthotropic material are not supported yet");
    }
    for (const Material& m : scene.materials)
        for (std::size_t k = 0; k < m.elastic.changes.size(); ++k)
            for (const Material& other : scene.materials)
                check.require(other.name != m.elastic.changes[k].material || !other.elastic.orthotropic.any(),
                              fmt::format("materials.{}.changes.{}.material", m.name, k),
                              "a change to an orthotropic material is not supported yet");
}

void check_fracture(const Scene& scene, const Checker& check) {
    for (const Material& m : scene.materials) {
        const std::string path = fmt::format("materials.{}.fracture", m.name);
        check.require(m.fracture.any() || m.fracture.scores.empty(), path + ".scores",
                      "scores do nothing in a material that never breaks", "give it a \"strength\" above 0");
        const auto& warm = m.fracture.by_temperature;
        check.require(m.fracture.any() || warm.empty(), path + ".by_temperature",
                      "it does nothing in a material that never breaks", "give it a \"strength\" above 0");
        for (std::size_t k = 1; k < warm.size(); ++k)
            check.require(warm[k].temperature > warm[k - 1].temperature,
                          fmt::format("{}.by_temperature.{}.temperature", path, k),
                          fmt::format("{} degC is not above the one before it", warm[k].temperature));
        if (!m.fracture.any()) continue;
        check.require(m.elastic.solid(), path, "only a solid can break",
                      "give the material a \"youngs_modulus\" above 0");
    }
    for (const Body& b : scene.bodies)
        for (std::size_t k = 0; k < b.cracks.size(); ++k) {
            const std::string path = fmt::format("bodies.{}.cracks.{}", b.name, k);
            const auto& points = b.cracks[k].points;
            const auto of = std::ranges::find(scene.materials, b.material, &Material::name);
            check.require(of == scene.materials.end() || of->fracture.any(), path, "the body's material never breaks",
                          "give it a block \"fracture\" with a \"strength\"");
            const CrackImage& image = b.cracks[k].image;
            check.require(image.file.empty() || points.empty(), path,
                          "a crack is painted by \"points\" or by an \"image\"", "leave one of the two out");
            check.require(!image.file.empty() || points.size() >= 2, path + ".points", "a line has at least two points",
                          "or give an \"image\" with a \"file\"");
            check.require(image.across.cross(image.up).norm() > 1e-6 * image.across.norm() * image.up.norm(),
                          path + ".image", "\"across\" and \"up\" span no picture",
                          "give two vectors that are not parallel");
            for (std::size_t i = 1; i < points.size(); ++i)
                check.require(points[i].at != points[i - 1].at, fmt::format("{}.points.{}", path, i),
                              "the point is the same as the one before it", "leave it out");
        }
}

void check_handles(const Scene& scene, const Checker& check) {
    for (const Handle& h : scene.handles) {
        const std::string path = "handles." + h.name;
        check.refer(h.body, names_of(scene.bodies), path + ".body", "body");
        check_motion(h.motion, path + ".motion", check);
        check.require(h.stop > h.start, path + ".stop", fmt::format("\"stop\" is {} s, not after \"start\"", h.stop));
        check.require(h.motion.empty() || h.force.isZero(), path + ".force",
                      "a handle either moves its part or pulls at it", "leave out \"motion\" or \"force\"");
        for (const Body& b : scene.bodies)
            for (const Material& m : scene.materials)
                check.require(b.name != h.body || m.name != b.material || m.elastic.solid(), path + ".body",
                              fmt::format("\"{}\" is liquid and cannot be held", b.name),
                              "a solid is of a material with a youngs_modulus above 0");
    }
}

void check_blades(const Scene& scene, const Checker& check) {
    for (const Blade& b : scene.blades) {
        const std::string path = "blades." + b.name;
        check.refer(b.body, names_of(scene.bodies), path + ".body", "body");
        check_motion(b.motion, path + ".motion", check);
        check.require(b.stop > b.start, path + ".stop", fmt::format("\"stop\" is {} s, not after \"start\"", b.stop));
        check.require(b.edge.size() >= 2, path, "an edge has at least two points", "give it \"edge\"");
        for (std::size_t i = 1; i < b.edge.size(); ++i) {
            const Vec3d way = b.edge[i].at - b.edge[i - 1].at;
            const std::string point = fmt::format("{}.edge.{}", path, i);
            check.require(!way.isZero(), point, "the point is the same as the one before it", "leave it out");
            check.require(way.isZero() || way.cross(b.direction).norm() > 0.1 * way.norm() * b.direction.norm(), point,
                          "the edge runs along the direction of its cut", "turn \"direction\" across it");
        }
        for (const Body& body : scene.bodies)
            for (const Material& m : scene.materials) {
                const bool own = body.name == b.body && m.name == body.material;
                check.require(!own || m.elastic.solid(), path + ".body",
                              fmt::format("\"{}\" is liquid and cannot be cut", body.name),
                              "a solid is of a material with a youngs_modulus above 0");
                check.require(!own || !m.melting.any(), path + ".body",
                              "to cut a material that melts is not supported yet");
            }
    }
}

/// An octree's particles differ in size, which elements know of and smoothing kernels do not.
void check_sampling(const Scene& scene, const Checker& check) {
    const auto flows = [](const Material& m) { return !m.elastic.solid() || m.melting.any(); };
    const auto conducts = [](const Material& m) { return m.thermal.conductivity > 0; };
    const auto any_body = [&](auto&& is) {
        return std::ranges::any_of(scene.bodies, [&](const Body& b) {
            return std::ranges::any_of(scene.materials,
                                       [&](const Material& m) { return m.name == b.material && is(m); });
        });
    };
    for (const Body& b : scene.bodies) {
        if (b.sampling.lattice == Lattice::hexagonal) continue;
        const std::string path = "bodies." + b.name + ".sampling.lattice";
        const std::string remedy = "write lattice: hexagonal";
        for (const Material& m : scene.materials)
            check.require(m.name != b.material || !flows(m), path,
                          "what is liquid or melts is sampled by a hexagonal lattice alone", remedy);
        if (b.sampling.lattice != Lattice::octree) continue;
        check.require(scene.emitters.empty() && !any_body(flows), path,
                      "solids sampled by an octree in a scene with liquids are not supported yet", remedy);
        check.require(!any_body(conducts), path, "heat in a solid sampled by an octree is not supported yet",
                      remedy + ", or leave out \"conductivity\"");
    }
}

/// A solid that goes on through periodic faces moves there as its images do: it cannot turn about any other axis.
template <class Find>
void check_turning(const Scene& scene, const Find& find, const Checker& check) {
    constexpr const char* kWhy = "the images of a solid in a periodic domain would move apart at the faces";
    for (const PeriodicAxis& periodic : scene.world.periodic) {
        const Vec3d axis = Vec3d::Unit(static_cast<int>(periodic.axis));
        for (const Body& b : scene.bodies) {
            if (const auto m = find(b.material); m == scene.materials.end() || !m->elastic.solid()) continue;
            const std::string path = "bodies." + b.name;
            check.require(b.angular_velocity.cross(axis).isZero(0), path + ".angular_velocity", kWhy);
            check.require((b.velocity_gradient.matrix() * axis).isZero(0), path + ".velocity_gradient", kWhy);
        }
        for (const Handle& h : scene.handles)
            for (std::size_t k = 0; k < h.motion.size(); ++k)
                check.require(h.motion[k].rotate.cross(axis).isZero(0),
                              fmt::format("handles.{}.motion.{}.rotate", h.name, k), kWhy);
    }
}

/// What solids in a periodic domain cannot do yet. They are one prism without ends (sim/space/endless.h).
template <class Find>
void check_endless(const Scene& scene, const Find& find, const Checker& check) {
    if (scene.world.periodic.empty()) return;
    const auto refuse = [&](bool has, const std::string& path, const std::string& what) {
        check.require(!has, path, what + " in a periodic domain is not supported yet");
    };
    int solids = 0;
    for (const Body& b : scene.bodies) {
        const auto m = find(b.material);
        if (m == scene.materials.end() || !m->elastic.solid()) continue;
        const std::string path = "bodies." + b.name;
        refuse(++solids > 1, path + ".material", "a second solid");
        refuse(m->melting.any(), path + ".material", "a solid that melts");
        refuse(m->fracture.any(), path + ".material", "a solid that breaks");
        refuse(b.sampling.lattice != Lattice::hexagonal, path + ".sampling.lattice", "a solid on such a lattice");
    }
    for (const Emitter& e : scene.emitters)
        if (const auto m = find(e.material); m != scene.materials.end() && (m->elastic.solid() || m->melting.any()))
            refuse(true, "emitters." + e.name + ".material", "matter that is not liquid from an emitter");
    if (solids > 0) check_turning(scene, find, check);
    refuse(solids > 0 && !scene.blades.empty(), "world.periodic", "a blade");
    refuse(solids > 0 && scene.solver.solids != SolidSteps::leapfrog, "solver.solids", "a solid in implicit steps");
}

/// What solids cannot do yet, told before anything is computed.
void check_solids(const Scene& scene, const Checker& check) {
    const auto find = [&](const std::string& material) {
        return std::find_if(scene.materials.begin(), scene.materials.end(),
                            [&](const Material& m) { return m.name == material; });
    };
    bool solids = false, flows = false;
    const auto count = [&](const std::string& material) {
        const auto m = find(material);
        if (m == scene.materials.end()) return;
        solids = solids || m->elastic.solid();
        flows = flows || !m->elastic.solid() || m->melting.any();
    };
    for (const Body& b : scene.bodies) count(b.material);
    for (const Emitter& e : scene.emitters) {
        count(e.material);
        flows = true;
    }
    if (!solids) return;
    check.require(!flows || scene.solver.pressure == Pressure::eos, "solver.pressure",
                  "solids together with liquids, and what melts, are not supported by \"dfsph\" yet",
                  "write pressure: eos");
    check.require(!flows || scene.solver.solids == SolidSteps::leapfrog, "solver.solids",
                  "implicit solids together with liquids, emitters and what melts are not supported yet",
                  "write solids: leapfrog");
    check_endless(scene, find, check);
}

void check_emitter(const Emitter& e, const std::vector<std::string>& materials, const Checker& check) {
    const std::string path = "emitters." + e.name;
    check.refer(e.material, materials, path + ".material", "material");
    check.require(e.stop > e.start, path + ".stop", fmt::format("\"stop\" is {} s, not after \"start\"", e.stop));
    const bool volume = e.source == SourceForm::volume;
    check.require(e.source == SourceForm::cut || !std::holds_alternative<std::monostate>(e.shape.kind),
                  path + ".source", "a surface or a volume needs a \"shape\"");
    check.require(!volume || e.rate > 0, path + ".source", "a volume fills by a \"rate\" above 0");
    check.require(volume || e.speed == 0 || e.rate == 0, path + ".rate",
                  fmt::format("\"rate\" ({}) and \"speed\" ({}) both say how much flows out", e.rate, e.speed),
                  "leave one of them out");
    check.require(e.speed > 0 || e.rate > 0, path + ".speed", "an emitter needs a \"speed\" or a \"rate\" above 0",
                  "\"switches\" turn it off");
    for (std::size_t k = 1; k < e.switches.size(); ++k)
        check.require(e.switches[k].time > e.switches[k - 1].time, fmt::format("{}.switches.{}.time", path, k),
                      fmt::format("the switch at {} s is not after the one above it", e.switches[k].time));
    check_motion(e.motion, path + ".motion", check);
}

}  // namespace

void check_scene(const Scene& scene, ReadContext& context) {
    const Checker check{context};
    check.require(scene.name.empty() || is_name(scene.name), "scene.name",
                  fmt::format("\"{}\" is no name for a scene", shown(scene.name)),
                  "letters, digits, _ and -, at most 64");
    check.require(scene.frames.last >= scene.frames.first, "frames.last",
                  fmt::format("\"last\" is {}, before \"first\", which is {}", scene.frames.last, scene.frames.first));
    check_shapes(scene, check);
    const std::vector<std::string> materials = names_of(scene.materials),
                                   appearances = names_of(scene.look.appearances);
    for (const Boundary& b : scene.world.boundaries) {
        check.refer(b.look, appearances, "world.boundaries." + b.name + ".look", "appearance");
        check_motion(b.motion, "world.boundaries." + b.name + ".motion", check);
    }
    for (const Material& m : scene.materials)
        check.refer(m.look, appearances, "materials." + m.name + ".look", "appearance");
    for (const Body& b : scene.bodies) {
        check.refer(b.material, materials, "bodies." + b.name + ".material", "material");
        check.refer(b.look, appearances, "bodies." + b.name + ".look", "appearance");
    }
    for (const Emitter& e : scene.emitters) check_emitter(e, materials, check);
    for (const Probe& p : scene.probes) {
        check.refer(p.material, materials, "probes." + p.name + ".material", "material");
        check.require(p.measure != Measure::wall_pressure || p.radius < Probe().radius, "probes." + p.name + ".radius",
                      "the mean pressure on a disc needs its size", "give the disc a \"radius\"");
        check.require(p.quantity != Quantity::elastic_energy ||
                          std::ranges::none_of(scene.materials, [](const Material& m) { return m.melting.any(); }),
                      "probes." + p.name + ".quantity", "the elastic energy of matter that melts is not measured yet");
    }
    check_heat(scene, check);
    check_periodic(scene, check);
    check_elastic(scene, check);
    check_fracture(scene, check);
    check_orthotropic(scene, check);
    check_handles(scene, check);
    check_blades(scene, check);
    check_solids(scene, check);
    check_sampling(scene, check);
    check_look(scene.look, context);
    check_wearers(scene, check);
}

}  // namespace thixo::scene
