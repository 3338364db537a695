#include "sim/fracture/crack_step.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "pipeline/base/error.h"
#include "pipeline/base/parallel.h"
#include "pipeline/base/random.h"
#include "sim/bonds/gradients.h"
#include "sim/fracture/blades.h"
#include "sim/fracture/fronts.h"
#include "sim/fracture/image_cracks.h"
#include "sim/fracture/painted.h"
#include "sim/fracture/sheets.h"
#include "sim/fracture/sight.h"
#include "sim/solid/elasticity.h"
#include "sim/solid/laws.h"
#include "sim/solid/unevenness.h"
#include "sim/space/scene_shapes.h"

namespace thixo {
namespace {

constexpr std::uint64_t kScatter = 0x73636174746572;  // use of random numbers

/// Linear between the entries, constant beyond the first and last.
double factor_at(const std::vector<StrengthFactor>& table, double temperature) {
    const auto above = std::ranges::upper_bound(table, temperature, {}, &StrengthFactor::temperature);
    if (above == table.begin()) return table.front().factor;
    if (above == table.end()) return table.back().factor;
    const StrengthFactor &a = *(above - 1), &b = *above;
    return a.factor + (temperature - a.temperature) / (b.temperature - a.temperature) * (b.factor - a.factor);
}

/// Whether cracks run in a body now: not in rigid ones, and not where matter melts or has no surface yet.
bool may_break(const Solids& solids, const SolidBody& body) {
    return !body.empty() && !body.rigid && body.skin == Skin::embedded && solids.solid_throughout(body) &&
           std::ranges::find(solids.breaking, body.frame, &Breaking::frame) != solids.breaking.end();
}

/// Strengths at the present temperatures and phases.
void refresh_strengths(const Particles& particles, Solids& solids) {
    Elements& e = solids.elements;
    for (const SolidBody& body : solids.bodies) {
        const auto breaking = std::ranges::find(solids.breaking, body.frame, &Breaking::frame);
        const bool warms = breaking != solids.breaking.end() && !breaking->by_temperature.empty();
        if (!warms && !e.softens) continue;
        const bool breaks = may_break(solids, body);
        parallel_for(body.elements.size(), [&](std::size_t k) {
            const Index i = body.elements[k];
            e.strength[i] = breaks ? e.own_strength[i] : kUnbreakable;
            if (!warms || e.strength[i] == kUnbreakable) return;
            const double temperature = particles.temperature[solids.particle_of[i]];
            e.strength[i] *= static_cast<Real>(factor_at(breaking->by_temperature, temperature));
        });
    }
}

/// Fronts end in matter that has begun to melt: of the body about their middle node. Their sheets stay as they are.
void stop_melting_fronts(const CrackedMatter& matter, Solids& solids) {
    if (!solids.elements.softens) return;
    std::vector<std::pair<Real, Index>> near;
    std::erase_if(solids.cracks.fronts, [&](const CrackFront& front) {
        if (solids.cracks.cracks[static_cast<std::size_t>(front.crack)].frame != matter.breaking().frame) return false;
        if (matter.elements().empty()) return true;
        matter.grid().nearest(front.nodes[front.nodes.size() / 2].tip(), 1, std::numeric_limits<Real>::max(), near);
        return !solids.solid_throughout(solids.owner(matter.elements()[near.front().second]));
    });
}

/// The frame of every element, where matter may leave its own by freezing.
std::vector<std::int32_t> frames_of(const Solids& solids) {
    std::vector<std::int32_t> frames(solids.elements.softens ? solids.elements.size() : 0);
    for (std::size_t i = 0; i < frames.size(); ++i) frames[i] = solids.owner(i).frame;
    return frames;
}

void see_matter(const Solids& solids, CrackScratch& scratch) {
    std::vector<std::int32_t> frames = frames_of(solids);
    if (scratch.matter.size() == solids.breaking.size() && scratch.triangles == solids.cracks.triangles.size() &&
        scratch.elements == solids.elements.id && scratch.frames == frames)
        return;
    scratch.frames = std::move(frames);
    scratch.matter.clear();
    for (const Breaking& breaking : solids.breaking) scratch.matter.emplace_back(solids, breaking);
    scratch.triangles = solids.cracks.triangles.size();
    scratch.elements = solids.elements.id;
}

/// The most uneven stencil of matter that breaks.
double most_uneven(const Elements& e) {
    return parallel_reduce(
        e.size(), 0.0, [&](std::size_t i) { return e.strength[i] < kUnbreakable ? unevenness(e, i) : 0.0; },
        [](double a, double b) { return std::max(a, b); });
}

/// Parts bonds across the sheets as far as fronts have gone.
void part_matter(double time, double dt, const CrackScratch& scratch, Index first, Solids& solids) {
    follow_fronts(solids.breaking, solids.cracks);
    for (const CrackedMatter& matter : scratch.matter) find_crossings(matter, solids.elements, first, solids.cracks);
    std::vector<WeakBond> weak = weak_bonds(solids.breaking, solids.elements, scratch.tension, solids.cracks);
    for (const CrackedMatter& matter : scratch.matter)
        for (const auto& more : {pinhole_bonds(matter, solids), severed_bonds(time, dt, matter, solids)})
            weak.insert(weak.end(), more.begin(), more.end());
    const KeptStrains strains(solids.laws, solids.elements, solids.gradients);
    const double uneven = most_uneven(solids.elements);
    weaken_bonds(weak, solids.elements);
    const std::vector<WeakBond> loose = loose_bonds(solids.elements);
    weaken_bonds(loose, solids.elements);
    strains.restore(solids.laws, solids.elements);
    // What is beside a crack or a loose element may have become stiffer than sub-steps allow for.
    constexpr double kStiffer = 1.02;
    if (!loose.empty() || most_uneven(solids.elements) > kStiffer * uneven) solids.elements.bonds.changed();
}

/// Stresses and tensions of the gradients, and the largest tension over strength [1].
double load_of(const Solids& solids, CrackScratch& scratch) {
    find_stress(solids, scratch.stress);
    find_tension(solids.elements, scratch.stress, scratch.tension);
    return largest_load(solids.elements, scratch.stress, scratch.tension);
}

/// The most that the load can be by the largest stretch s of the last sub-step. The largest principal strain is e, and the
/// trace is at most three times as large:
///     e = (s^2 - 1)/2,   load <= (3 lambda + 2 mu) e/strength      [1]
/// No bound where laws are anisotropic, or matter has flowed or may have frozen strained: then it is unlimited.
double bound_of_load(const Solids& solids) {
    const Elements& e = solids.elements;
    if (e.softens) return std::numeric_limits<double>::infinity();
    double modulus = 0;
    for (const StressLaw& law : solids.laws) {
        if (law.anisotropy != kNone || law.creep > 0 || law.lambda < 0) return std::numeric_limits<double>::infinity();
        modulus = std::max(modulus, static_cast<double>(3 * law.lambda + 2 * law.mu));
    }
    const double weakest = parallel_reduce(
        e.size(), static_cast<double>(kUnbreakable), [&](std::size_t i) { return static_cast<double>(e.strength[i]); },
        [](double a, double b) { return std::min(a, b); });
    return modulus * std::max(solids.stretch2 - 1, 0.0) / 2 / weakest;
}

std::size_t make_fragments(const Matter& matter) {
    Solids& solids = matter.solids;
    std::vector<std::uint8_t> marks;
    for (const SolidBody& body : solids.bodies) {
        const bool breaks = body.rigid || may_break(solids, body);
        marks.push_back(breaks && has_come_apart(body, solids.elements));
    }
    if (std::ranges::none_of(marks, [](std::uint8_t m) { return m != 0; })) return 0;
    const CrackSight sight(solids);
    lay_sheets(sight, matter);
    const EmbeddedSurface& s = matter.embedded;
    return part_fragments(
        marks,
        [&](Index surfel) {
            const SolidBody& body = solids.bodies[static_cast<std::size_t>(s.owner[surfel])];
            return sight.nearest_seen(body.frame, s.rest.position[surfel], s.rest.normal[surfel]);
        },
        matter);
}

/// The step in which a load that grows as it did in the last one stays below a strength [s].
double step_to_the_strength(double before, double now, double dt) {
    constexpr double kReached = 0.75;
    const double growth = (now - before) / dt;
    return now < static_cast<double>(kWatched) && growth > 0 ? (kReached - now) / growth : 1e30;
}

/// Where a crack that is there from the start is cut, in the material frame [m].
std::vector<std::vector<Vec3>> painted_lines(const scene::PaintedCrack& painted, const Breaking& breaking) {
    if (!painted.image.file.empty()) return lines_of_image(painted.image, breaking);
    std::vector<std::vector<Vec3>> lines(1);
    for (const scene::CrackPoint& point : painted.points) lines[0].push_back(point.at.cast<Real>() - breaking.origin);
    return lines;
}

double longest_step(const Breaking& breaking, Real fastest, Real load) {
    double longest = 1e30;
    if (fastest > 0) longest = static_cast<double>(breaking.row / (2 * fastest));
    if (load > kWatched) longest = std::min(longest, static_cast<double>(breaking.width / (4 * breaking.speed)));
    return longest;
}

}  // namespace

double load_now(const Solids& solids) {
    const Elements& e = solids.elements;
    if (const double bound = bound_of_load(solids); bound < static_cast<double>(kWatched)) return bound;
    return parallel_reduce(
        e.size(), 0.0,
        [&](std::size_t i) {
            if (e.strength[i] == kUnbreakable) return 0.0;
            const StressLaw& law = solids.laws[static_cast<std::size_t>(e.owner[i])];
            return static_cast<double>(load_of(stress_of_shape(law, e, i, gradient_of(e, i)), e.strength[i]));
        },
        [](double a, double b) { return std::max(a, b); });
}

CrackReport advance_cracks(double time, double dt, std::uint64_t step, const Matter& matter, CrackScratch& scratch) {
    Solids& solids = matter.solids;
    Cracks& cracks = solids.cracks;
    CrackReport report;
    if (solids.breaking.empty()) return report;
    refresh_strengths(matter.particles, solids);
    const double loaded = std::exchange(cracks.load, load_of(solids, scratch));
    cracks.step = step_to_the_strength(loaded, cracks.load, dt);
    see_matter(solids, scratch);
    for (const CrackedMatter& own : scratch.matter) stop_melting_fronts(own, solids);
    const auto first = static_cast<Index>(cracks.triangles.size());
    const std::size_t before = cracks.cracks.size();
    for (const CrackedMatter& own : scratch.matter) {
        PointGrid gaps;
        gaps.build(gaping_places(solids, own.breaking().frame), 2 * own.breaking().row);
        const FrontStep now{own, scratch.stress, scratch.tension, gaps, dt};
        const Real load = begin_cracks(now, matter.seed, step, solids.elements, cracks);
        const Real fastest = move_fronts(now, cracks);
        if (row_is_due(own.breaking(), cracks)) lay_rows(own, cracks);
        cracks.step = std::min({cracks.step, longest_step(own.breaking(), fastest, load),
                                advance_blades(time, own, solids, solids.blades, cracks)});
    }
    report.begun = cracks.cracks.size() - before;
    solids.altered = solids.altered || !cracks.vertex.empty();
    if (!cracks.any()) return report;
    part_matter(time, dt, scratch, first, solids);
    // Pieces need no body of their own at once, and bodies are dear to make: those of a few steps are made together.
    constexpr std::uint64_t kTogether = 8;
    if (step % kTogether == 0) report.fragments = make_fragments(matter);
    return report;
}

std::vector<ScreenedPair> screened_heat(const Particles& particles, const NeighbourLists& neighbours,
                                        const Solids& solids, CrackScratch& scratch) {
    if (!solids.cracks.any()) return {};
    see_matter(solids, scratch);
    constexpr Real kTogether = Real(1.5);  // supports: how near to each other pieces were in one body
    const Elements& e = solids.elements;
    const auto part = [&](const CrackedMatter& matter, Index i, Index j) {
        const Vec3 from = xyz(e.rest[i]), to = xyz(e.rest[j]);
        const Real h = (e.support[i] + e.support[j]) / 2;
        if ((to - from).norm() > kTogether * h) return Real(0);
        if (e.phase_of(i) != Phase::solid && e.phase_of(j) != Phase::solid) return Real(0);
        if (e.owner[i] != e.owner[j]) return Real(1);
        return 1 - share_left(matter.sheets(), solids.cracks, from, to, h, matter.breaking().opaque);
    };
    std::vector<ScreenedPair> pairs;
    for (const CrackedMatter& matter : scratch.matter) {
        const std::vector<Index>& elements = matter.elements();
        constexpr std::size_t kElements = 64;
        std::vector<std::vector<ScreenedPair>> found((elements.size() + kElements - 1) / kElements);
        parallel_chunks(
            elements.size(),
            [&](std::size_t begin, std::size_t end, std::size_t c) {
                for (std::size_t n = begin; n < end; ++n) {
                    const Index i = elements[n], k = solids.particle_of[i];
                    if (!matter.sheets().nearest(xyz(e.rest[i]), kTogether * e.support[i], [](Index) { return true; }))
                        continue;
                    for (const Index l : neighbours[k]) {
                        const Index j = solids.element(particles.id[l]);
                        if (l <= k || j == kNone || solids.owner(j).frame != matter.breaking().frame) continue;
                        if (const Real a = part(matter, i, j); a > 0) found[c].push_back({k, l, a});
                    }
                }
            },
            kElements);
        for (const auto& some : found) pairs.insert(pairs.end(), some.begin(), some.end());
    }
    return pairs;
}

void make_breaking(const scene::Scene& scene, const Materials& materials, const EmbeddedSurface& surface,
                   const Particles& particles, Solids& solids) {
    Elements& e = solids.elements;
    if (!e.breaks) return;
    e.strength.assign(e.size(), kUnbreakable);
    for (std::size_t b = 0; b < solids.bodies.size(); ++b) {
        const SolidBody& body = solids.bodies[b];
        const ResolvedMaterial& material = materials[static_cast<std::size_t>(body.material)];
        const scene::Fracture& keys = material.fracture;
        const scene::Body& own = scene.bodies[static_cast<std::size_t>(std::max(body.source, 0))];
        const bool cut = std::ranges::find(scene.blades, own.name, &scene::Blade::body) != scene.blades.end();
        if (!(keys.any() || cut) || !body.shaped()) continue;
        const double speed = keys.speed > 0 ? keys.speed
                                            : 0.25 * std::sqrt(material.elastic.front().elastic.youngs_modulus /
                                                               static_cast<double>(material.density));
        // The first step has none before it to foresee the load by: what stretches is watched from the start.
        const Mat3d flow = own.velocity_gradient.matrix();
        const double stretching = (flow + flow.transpose()).norm() / 2;
        const double modulus = static_cast<double>(law_at(material, 0).wave_modulus());
        if (stretching > 0 && keys.any())
            solids.cracks.step = std::min(solids.cracks.step, keys.strength / (4 * modulus * stretching));
        const Real h = e.support[body.typical], width = std::cbrt(e.volume[body.typical]);
        const auto surfel = std::ranges::find(surface.owner, static_cast<std::int32_t>(b));
        const Real radius = surfel == surface.owner.end()
                                ? Real(0)
                                : surface.rest.axis1[static_cast<std::size_t>(surfel - surface.owner.begin())].norm();
        solids.breaking.push_back({.source = body.source,
                                   .frame = body.frame,
                                   .arrest = static_cast<Real>(keys.arrest),
                                   .speed = static_cast<Real>(speed),
                                   .history = static_cast<Real>(keys.history),
                                   .opaque = static_cast<Real>(keys.opacity) * h / 2,
                                   .support = h,
                                   .width = width,
                                   .row = width / 2,
                                   .surfel = radius,
                                   .shape = *body.shape,
                                   .origin = body.origin});
        if (!keys.any()) continue;
        for (const scene::StrengthAt& at : keys.by_temperature)
            solids.breaking.back().by_temperature.push_back({at.temperature, at.factor});
        std::vector<Shape> scored;
        for (const scene::Score& score : keys.scores) scored.push_back(make_shape(scene, score.region));
        for (const Index i : body.elements) {
            const double u = 2 * random_unit(scene.solver.seed, static_cast<std::uint64_t>(e.id[i]), 0, kScatter) - 1;
            double strength = keys.strength * (1 + keys.scatter * u);
            for (std::size_t k = 0; k < scored.size(); ++k)
                if (scored[k].distance(xyz(e.rest[i]) + body.origin) <= 0) strength *= keys.scores[k].factor;
            e.strength[i] = static_cast<Real>(strength);
        }
    }
    e.own_strength = e.strength;
    refresh_strengths(particles, solids);
    solids.blades = make_blades(scene, solids.breaking);
}

void cut_painted_cracks(const scene::Scene& scene, const Matter& matter) {
    Solids& solids = matter.solids;
    for (const Breaking& breaking : solids.breaking) {
        const scene::Body& body = scene.bodies[static_cast<std::size_t>(breaking.source)];
        for (std::size_t k = 0; k < body.cracks.size(); ++k) {
            const scene::PaintedCrack& painted = body.cracks[k];
            try {
                for (const std::vector<Vec3>& line : painted_lines(painted, breaking))
                    paint_crack(line, {static_cast<Real>(painted.depth), static_cast<Real>(painted.strength)}, breaking,
                                solids);
            } catch (const InputError& e) {
                throw InputError("bodies.{}.cracks.{}: {}", body.name, k, e.what());
            }
        }
    }
    if (!solids.cracks.any()) return;
    follow_fronts(solids.breaking, solids.cracks);
    for (const Breaking& breaking : solids.breaking)
        find_crossings(CrackedMatter(solids, breaking), solids.elements, 0, solids.cracks);
    weaken_bonds(weak_bonds(solids.breaking, solids.elements, {}, solids.cracks), solids.elements);
    lay_sheets(CrackSight(solids), matter);
}

}  // namespace thixo
