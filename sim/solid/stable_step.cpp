#include "sim/solid/stable_step.h"

#include <algorithm>
#include <cmath>

#include "pipeline/base/parallel.h"
#include "pipeline/base/random.h"
#include "sim/contact/stiffness.h"
#include "sim/solid/elasticity.h"

namespace thixo {
namespace {

constexpr int kIterations = 40;
constexpr double kUsed = 0.64;       // part of the stability limit
constexpr Real kSmall = Real(1e-4);  // displacement in supports: strains this small are linear
constexpr std::uint64_t kStartUse = 0x736f6c69;

/// Scales the field of one body so that its largest component is `small`.
void normalise(const SolidBody& body, Real small, std::vector<Quad>& field) {
    Real largest = 0;
    for (const Index i : body.elements) largest = std::max(largest, xyz(field[i]).cwiseAbs().maxCoeff());
    const Real factor = largest > 0 ? small / largest : Real(0);
    for (const Index i : body.elements) field[i] = quad(factor * xyz(field[i]));
}

}  // namespace

std::vector<double> find_stiffest(const std::vector<StressLaw>& laws, const std::vector<SolidBody>& bodies,
                                  Elements& elements) {
    std::vector<StressLaw> still = laws;
    for (StressLaw& law : still) law.viscosity = 0;
    const std::size_t n = elements.size();
    std::vector<Quad> field(n), moved;
    std::vector<Symmetric> plastic(n);
    for (std::size_t i = 0; i < n; ++i) {
        const auto id = static_cast<std::uint64_t>(elements.id[i]);
        const auto random = [&](std::uint64_t axis) {
            return static_cast<Real>(random_unit(0, id, axis, kStartUse) - 0.5);
        };
        field[i] = quad(Vec3(random(0), random(1), random(2)));
    }
    elements.plastic.swap(plastic);
    StressScratch scratch;
    std::vector<Vec3> force;
    std::vector<double> stiffest(bodies.size(), 0);
    for (int k = 0; k < kIterations; ++k) {
        for (const SolidBody& body : bodies)
            if (!body.empty()) normalise(body, kSmall * elements.support[body.typical], field);
        elements.displacement.swap(field);
        find_stress_forces(still, elements, scratch, force);
        elements.displacement.swap(field);
        for (std::size_t b = 0; b < bodies.size(); ++b) {
            double work = 0, square = 0;
            for (const Index i : bodies[b].elements) {
                const Vec3d u = xyz(field[i]).cast<double>();
                work -= u.dot(force[i].cast<double>());
                square += static_cast<double>(elements.mass[i]) * u.squaredNorm();
            }
            stiffest[b] = square > 0 ? std::max(stiffest[b], work / square) : 0;
        }
        parallel_for(n, [&](std::size_t i) { field[i] = quad(-force[i] / elements.mass[i]); });
    }
    elements.plastic.swap(plastic);
    return stiffest;
}

std::vector<FastestRates> find_fastest_rates(const std::vector<StressLaw>& laws, const std::vector<SolidBody>& bodies,
                                             Elements& elements) {
    std::vector<FastestRates> rates(bodies.size());
    const std::vector<double> stiffest = find_stiffest(laws, bodies, elements);
    for (std::size_t b = 0; b < bodies.size(); ++b) rates[b].stiffest = stiffest[b];
    if (std::ranges::none_of(laws, [](const StressLaw& law) { return law.viscosity > 0; })) return rates;
    std::vector<StressLaw> viscous;
    for (const StressLaw& law : laws) viscous.push_back({.mu = law.viscosity});
    set_zero_energy(viscous, elements);
    const std::vector<double> damping = find_stiffest(viscous, bodies, elements);
    set_zero_energy(laws, elements);
    for (std::size_t b = 0; b < bodies.size(); ++b) rates[b].damping = damping[b];
    return rates;
}

double stable_sub_step(const Solids& solids, bool walls) {
    const double growth = std::max(1.0, solids.stiffening);
    double shortest = 1e30;
    const Softening& softening = solids.softening;
    for (std::size_t b = 0; b < solids.bodies.size(); ++b) {
        if (solids.bodies[b].empty()) continue;
        const StressLaw& law = solids.laws[b];
        const Index lightest = solids.bodies[b].lightest;
        const FastestRates rates{std::max(solids.rates[b].stiffest, softening.rates.stiffest),
                                 std::max(solids.rates[b].damping, softening.rates.damping)};
        double omega2 = rates.stiffest * growth;
        double damping = rates.damping * std::max(1.0, solids.stretch2);
        if (b < solids.contacts.rates.size()) {
            omega2 += solids.contacts.rates[b].stiffest;
            damping += solids.contacts.rates[b].damping;
        }
        const bool by_samples = b < solids.contacts.by_samples.size() && solids.contacts.by_samples[b];
        if (walls && !by_samples) {
            const double spring =
                contact_stiffness(law, solids.elements.volume[lightest], solids.elements.mass[lightest]);
            omega2 += spring;
            damping += 2 * static_cast<double>(law.contact_damping) * std::sqrt(spring);
        }
        shortest =
            std::min(shortest, 2 * kUsed / (damping / 2 + std::sqrt(square(damping / 2) + kUsed * omega2) + 1e-30));
    }
    return shortest;
}

}  // namespace thixo
