#include "sim/phase/melt_stencils.h"

#include <algorithm>
#include <numeric>

#include "pipeline/base/parallel.h"
#include "pipeline/geometry/kernels.h"
#include "pipeline/geometry/packing.h"
#include "sim/bonds/gradients.h"
#include "sim/bonds/rest_shape.h"
#include "sim/bonds/weights.h"
#include "sim/solid/elasticity.h"
#include "sim/solid/laws.h"
#include "sim/solid/plasticity.h"
#include "sim/solid/stable_step.h"
#include "sim/solid/unevenness.h"

namespace thixo {
namespace {

constexpr Real kLost = 3;             // squared stretch beyond which melting matter has left its rest shape
constexpr Real kCrushed = Real(0.2);  // |J| below which it has
constexpr double kUneven = 1.5;       // margin of the rates

/// Whether the element has a stencil in D.
bool flows(const Softening& softening, std::size_t i) { return softening.flow_law[i].mu > 0; }

Symmetric minus(const Symmetric& a, const Symmetric& b) {
    return {a.xx - b.xx, a.yy - b.yy, a.zz - b.zz, a.xy - b.xy, a.yz - b.yz, a.zx - b.zx};
}
Symmetric times(Real f, const Symmetric& a) { return {f * a.xx, f * a.yy, f * a.zz, f * a.xy, f * a.yz, f * a.zx}; }

/// The fastest rates of the elements that have softened or flow.
FastestRates soft_rates(const Solids& solids) {
    const Softening& softening = solids.softening;
    const auto larger = [](const FastestRates& a, const FastestRates& b) {
        return FastestRates{std::max(a.stiffest, b.stiffest), std::max(a.damping, b.damping)};
    };
    return parallel_reduce(
        solids.elements.size(), FastestRates{},
        [&](std::size_t i) {
            FastestRates sum;
            const Phase phase = solids.elements.phase[i];
            if (phase == Phase::liquid || (phase == Phase::solid && solids.elements.melt[i] == 0)) return sum;
            const auto add = [&](const Elements& e, const StressLaw& law) {
                if (!(law.mu > 0)) return;
                const double uneven = kUneven * unevenness(e, i);
                sum.stiffest +=
                    softening.stiffest_per * uneven * static_cast<double>(law.wave_modulus() + law.volume_stiffness);
                sum.damping += softening.damping_per * uneven * static_cast<double>(law.viscosity);
            };
            add(solids.elements, softening.rest_law[i]);
            if (softening.flows) add(softening.flow, softening.flow_law[i]);
            return sum;
        },
        larger);
}

/// Laws of all elements, from the particles' materials and melt fractions.
void set_laws(const Materials& materials, double time, const Particles& particles, Solids& solids) {
    Softening& softening = solids.softening;
    const std::size_t n = solids.elements.size();
    for (auto* laws : {&softening.law, &softening.rest_law, &softening.flow_law}) laws->resize(n);
    std::vector<ElasticValues> cold;
    for (const ResolvedMaterial& m : materials) cold.push_back(elastic_at(m, time));
    parallel_for(
        particles.size(),
        [&](std::size_t k) {
            const Index i = solids.element(particles.id[k]);
            if (i == kNone) return;
            const double b = static_cast<double>(particles.melt[k]);
            const Real solidity = solids.elements.solidity(i);
            const auto m = static_cast<std::size_t>(particles.material[k]);
            softening.law[i] = melting_law(materials[m].melting, cold[m], b);
            softening.rest_law[i] = scaled(softening.law[i], solidity);
            softening.flow_law[i] = scaled(softening.law[i], is_elastic(particles.phase[k]) ? 1 - solidity : Real(0));
            softening.flow_law[i].keeps_volume = 0;  // liquid matter has no permanent shape
        },
        1024);
}

/// Lists the neighbours in D. Every list holds what either end needs. A softer neighbour has less weight: firm matter
/// is bound by itself, and not by the liquid about it.
void list_flow(const Particles& particles, const NeighbourLists& neighbours, const Solids& solids, Elements& flow) {
    const Softening& softening = solids.softening;
    const std::vector<Index>& particle_of = solids.particle_of;
    const std::size_t n = flow.size();
    const auto partner = [&](std::size_t i, Index k) -> Index {
        if (!is_elastic(particles.phase[k]) || particles.material[k] != particles.material[particle_of[i]])
            return kNone;
        const Index j = solids.element(particles.id[k]);
        return flows(softening, i) || flows(softening, j) ? j : kNone;
    };
    flow.bonds.begin.assign(n + 1, 0);
    std::vector<Index> count(n, 0);
    parallel_for(n, [&](std::size_t i) {
        if (!is_elastic(solids.elements.phase[i])) return;
        for (const Index k : neighbours[particle_of[i]]) count[i] += partner(i, k) != kNone;
    });
    for (std::size_t i = 0; i < n; ++i)
        flow.bonds.begin[i + 1] = flow.bonds.begin[i] + (count[i] + kLanes - 1) / kLanes * kLanes;
    flow.bonds.neighbour.resize(flow.bonds.begin[n]);
    flow.bonds.weight.assign(flow.bonds.begin[n], 0);
    flow.bonds.weight_back.assign(flow.bonds.begin[n], 0);
    parallel_for(n, [&](std::size_t i) {
        std::size_t at = flow.bonds.begin[i];
        if (count[i] > 0)
            for (const Index k : neighbours[particle_of[i]]) {
                const Index j = partner(i, k);
                if (j == kNone) continue;
                const Real r = (xyz(flow.rest[j]) - xyz(flow.rest[i])).norm();
                const Real own = softening.law[i].mu, other = softening.law[j].mu;
                if (flows(softening, i))
                    flow.bonds.weight[at] =
                        rest_weight(flow.support[i], flow.support[i], r) * std::min(Real(1), other / own);
                if (flows(softening, j))
                    flow.bonds.weight_back[at] =
                        rest_weight(flow.support[j], flow.support[j], r) * std::min(Real(1), own / other);
                flow.bonds.neighbour[at++] = j;
            }
        while (at < flow.bonds.begin[i + 1]) flow.bonds.neighbour[at++] = static_cast<Index>(i);
    });
}

/// Builds D at the present places.
void build_flow(const Particles& particles, const NeighbourLists& neighbours, Solids& solids) {
    Softening& softening = solids.softening;
    Elements& flow = softening.flow;
    const Elements& e = solids.elements;
    const std::size_t n = e.size();
    flow.id = e.id;
    flow.owner.assign(n, 0);
    flow.law = e.law;
    flow.volume = flow.quadrature = e.volume;
    flow.mass = e.mass;
    flow.support = e.support;
    flow.rest.resize(n);
    flow.displacement.assign(n, quad(Vec3::Zero()));
    flow.velocity.assign(n, quad(Vec3::Zero()));
    for (std::size_t i = 0; i < n; ++i) flow.rest[i] = quad(particles.position[solids.particle_of[i]]);
    list_flow(particles, neighbours, solids, flow);
    std::vector<std::uint8_t> which(n);
    flow.bonds.moment.assign(n, RestMoment{.inverse = {}, .full = false});
    flow.bonds.flat.clear();
    for (std::size_t i = 0; i < n; ++i) which[i] = flows(softening, i);
    for (Index i = 0; i < n; ++i)
        if (!which[i]) flow.bonds.flat.emplace_back(i, Symmetric{});
    measure_moments(flow, &which, kThin);
    set_zero_energy(softening.flow_law, flow);
}

}  // namespace

Mat3 rotation_of(const Mat3& j) {
    Mat3 q = j;
    for (int k = 0; k < 8; ++k) {
        if (!(std::abs(q.determinant()) > Real(0.05))) return Mat3::Identity();
        const Mat3 next = Real(0.5) * (q + q.inverse().transpose());
        const bool rests = (next - q).cwiseAbs().maxCoeff() < Real(1e-6);
        q = next;
        if (rests) break;
    }
    return q.determinant() > 0 ? q : Mat3::Identity();
}

void calibrate_rates(const Smoothing& smoothing, Softening& phases) {
    Elements e;
    constexpr int kReach = 3;
    for (int k = -kReach; k <= kReach; ++k)
        for (int j = -kReach; j <= kReach; ++j)
            for (int i = -kReach; i <= kReach; ++i) {
                e.id.push_back(static_cast<std::int64_t>(e.size()));
                e.owner.push_back(0);
                e.rest.push_back(quad(packing_site(i, j, k, smoothing.spacing)));
                e.volume.push_back(cube(smoothing.spacing));
                e.quadrature.push_back(e.volume.back());
                e.mass.push_back(cube(smoothing.spacing));
                e.support.push_back(smoothing.support);
            }
    const std::size_t n = e.size();
    e.displacement.assign(n, quad(Vec3::Zero()));
    e.velocity = e.displacement;
    e.plastic.assign(n, {});
    std::vector<SolidBody> body(1);
    body[0].elements.resize(n);
    std::iota(body[0].elements.begin(), body[0].elements.end(), Index(0));
    find_rest_neighbours(body, e);
    measure_moments(e);
    double largest = 0;
    for (std::size_t i = 0; i < n; ++i) largest = std::max(largest, unevenness(e, i));
    const StressLaw law{.lambda = 1, .mu = 1, .viscosity = 1, .zero_energy = Real(0.3)};
    set_zero_energy({law}, e);
    const FastestRates rates = find_fastest_rates({law}, body, e)[0];
    phases.stiffest_per = rates.stiffest / (largest * static_cast<double>(law.wave_modulus()));
    phases.damping_per = rates.damping / largest;
}

void seed_flow(const std::vector<std::uint8_t>& which, Solids& solids) {
    if (std::ranges::none_of(which, [](std::uint8_t w) { return w != 0; })) return;
    const Elements& e = solids.elements;
    find_gradients(e, solids.gradients);
    parallel_for(e.size(), [&](std::size_t i) {
        if (!which[i]) return;
        const Mat3& h = solids.gradients[i];
        const Mat3 turn =
            solids.bodies[static_cast<std::size_t>(e.owner[i])].turn.cast<Real>() * rotation_of(Mat3::Identity() + h);
        const Mat3 elastic = matrix(minus(strain_of(e, i, h), e.plastic[i]));
        solids.softening.flow.plastic[i] = symmetric(-(turn * elastic * turn.transpose()));
    });
}

void prepare_stencils(const Materials& materials, double time, const Particles& particles,
                      const NeighbourLists& neighbours, Solids& solids) {
    Softening& softening = solids.softening;
    if (!softening.any) return;
    set_laws(materials, time, particles, solids);
    weigh_bonds(solids.elements, kThin);
    set_zero_energy(softening.rest_law, solids.elements);
    softening.flows = std::ranges::any_of(softening.flow_law, [](const StressLaw& law) { return law.mu > 0; });
    if (softening.flows) build_flow(particles, neighbours, solids);
    softening.rates = soft_rates(solids);
}

Real flow_pressure(const Solids& solids, std::size_t i) {
    const Softening& softening = solids.softening;
    if (softening.law.size() <= i) return 0;
    const Symmetric& e = softening.flow.plastic[i];
    return (softening.law[i].lambda + 2 * softening.law[i].mu / 3) * (e.xx + e.yy + e.zz);
}

StretchBounds add_flow_forces(Solids& solids, StressScratch& scratch) {
    Softening& softening = solids.softening;
    if (!softening.flows) return {};
    const Elements& e = solids.elements;
    std::vector<Mat3> turn;
    for (const SolidBody& body : solids.bodies) turn.push_back(body.turn.cast<Real>());
    const auto owner = [&](std::size_t i) { return static_cast<std::size_t>(e.owner[i]); };
    parallel_for(
        e.size(), [&](std::size_t i) { softening.flow.velocity[i] = quad(turn[owner(i)] * xyz(e.velocity[i])); }, 1024);
    const StretchBounds bounds = find_stress_forces(softening.flow_law, softening.flow, scratch, softening.force);
    parallel_for(
        e.size(), [&](std::size_t i) { solids.force[i] += turn[owner(i)].transpose() * softening.force[i]; }, 1024);
    return bounds;
}

void drift_flow(double dt, Solids& solids) {
    Softening& softening = solids.softening;
    if (!softening.flows) return;
    const Elements& e = solids.elements;
    std::vector<Mat3> turn;
    for (const SolidBody& body : solids.bodies) turn.push_back(body.turn.cast<Real>());
    const Real drift = static_cast<Real>(dt);
    parallel_for(
        e.size(),
        [&](std::size_t i) {
            const Vec3 v = turn[static_cast<std::size_t>(e.owner[i])] * xyz(e.velocity[i]);
            softening.flow.displacement[i] = quad(xyz(softening.flow.displacement[i]) + drift * v);
        },
        1024);
}

void absorb_flow(double dt, Particles& particles, Solids& solids) {
    Softening& softening = solids.softening;
    Elements& e = solids.elements;
    if (softening.flows) {
        find_gradients(softening.flow, softening.gradients);
        parallel_for(e.size(), [&](std::size_t i) {
            if (!flows(softening, i)) return;
            const Mat3& h = softening.gradients[i];
            const Mat3 q = softening.flow.bonds.moment[i].full ? rotation_of(Mat3::Identity() + h) : Mat3::Identity();
            Symmetric elastic = minus(strain_of(softening.flow, i, h), softening.flow.plastic[i]);
            const StressLaw& law = softening.flow_law[i];
            elastic = times(remaining_part(law, static_cast<Real>(dt), norm(elastic), 0), elastic);
            softening.flow.plastic[i] = symmetric(-(q * matrix(elastic) * q.transpose()));
        });
    }
    parallel_for(e.size(), [&](std::size_t i) {
        if (e.phase[i] != Phase::solid || !(e.melt[i] > 0)) return;
        const Mat3 j = Mat3::Identity() + solids.gradients[i];
        const Real stretch = (j.transpose() * j).cwiseAbs().rowwise().sum().maxCoeff();
        if (stretch < kLost && j.determinant() > kCrushed) return;
        e.depth[i] = surface_depth(e, i);
        set_phase(Phase::viscoelastic, e.melt[i], solids.particle_of[i], static_cast<Index>(i), particles, e);
    });
}

}  // namespace thixo
