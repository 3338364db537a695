#include <algorithm>
#include <cmath>

#include "pipeline/base/parallel.h"
#include "pipeline/base/random.h"
#include "sim/contact/contact.h"
#include "sim/state/solids.h"

namespace thixo {
namespace {

constexpr std::uint64_t kStartUse = 0x636f6e74;

void list_nodes(const ContactNodes& n, std::size_t elements, Contacts& c) {
    std::vector<Index> slot(elements, 0);
    for (const Index i : n.weights.element) ++slot[i];
    c.touched.clear();
    c.begin.assign(1, 0);
    for (Index i = 0; i < elements; ++i) {
        if (slot[i] == 0) continue;
        c.touched.push_back(i);
        c.begin.push_back(c.begin.back() + slot[i]);
        slot[i] = static_cast<Index>(c.begin[c.begin.size() - 2]);
    }
    c.node.resize(n.weights.element.size());
    c.weight.resize(n.weights.element.size());
    for (std::size_t k = 0; k < n.size(); ++k)
        for (std::size_t l = n.weights.begin[k]; l < n.weights.begin[k + 1]; ++l) {
            const Index to = slot[n.weights.element[l]]++;
            c.node[to] = static_cast<Index>(k);
            c.weight[to] = n.weights.weight[l];
        }
}

/// The largest eigenvalue of M^-1 K, by a few power iterations from below. K is that of all nodes' springs at once.
/// Springs are equally stiff along the normal and across, so that one number an element is enough.
double stiffest_of_contacts(const Solids& solids) {
    constexpr int kIterations = 10;
    const Contacts& c = solids.contacts;
    const ContactNodes& n = c.nodes;
    std::vector<Real> x(solids.elements.size(), 0), pull(n.size());
    for (const Index i : c.touched) x[i] = static_cast<Real>(random_unit(0, i, 0, kStartUse) - 0.5);
    double stiffest = 0;
    for (int it = 0; it < kIterations; ++it) {
        parallel_for(n.size(), [&](std::size_t k) {
            Real sum = 0;
            for (std::size_t l = n.weights.begin[k]; l < n.weights.begin[k + 1]; ++l)
                sum += n.weights.weight[l] * x[n.weights.element[l]];
            pull[k] = n.stiffness[k] * sum;
        });
        double work = 0, square = 0;
        for (std::size_t t = 0; t < c.touched.size(); ++t) {
            const Index i = c.touched[t];
            Real sum = 0;
            for (std::size_t l = c.begin[t]; l < c.begin[t + 1]; ++l) sum += c.weight[l] * pull[c.node[l]];
            work += static_cast<double>(sum * x[i]);
            square += static_cast<double>(solids.elements.mass[i] * x[i] * x[i]);
            x[i] = sum / solids.elements.mass[i];
        }
        if (!(square > 0)) break;
        stiffest = std::max(stiffest, work / square);
        const Real scale = static_cast<Real>(1 / std::sqrt(square));
        for (const Index i : c.touched) x[i] *= scale;
    }
    return stiffest;
}

/// Finds what contact adds to the fastest motions: the eigenvalue with a margin, at most the sums of rows
///     sum_s k_s |W_sj| sum_i |W_si|
/// These sums bound it body by body. They also give the masses that may be braked.
void find_rates(Solids& solids) {
    constexpr double kMargin = 1.2;
    Contacts& c = solids.contacts;
    ContactNodes& n = c.nodes;
    std::vector<Real> total(n.size(), 0), braked(n.size(), 0);
    double damped = 0;  // the largest c/k [s]
    for (std::size_t k = 0; k < n.size(); ++k) {
        for (std::size_t l = n.weights.begin[k]; l < n.weights.begin[k + 1]; ++l)
            total[k] += std::abs(n.weights.weight[l]);
        damped = std::max(damped, static_cast<double>(std::max(n.damping[k], n.drag[k]) / n.stiffness[k]));
    }
    c.rates.assign(solids.bodies.size(), {});
    for (std::size_t t = 0; t < c.touched.size(); ++t) {
        const Index i = c.touched[t];
        Real stiff = 0, area = 0;
        for (std::size_t l = c.begin[t]; l < c.begin[t + 1]; ++l) {
            const Real row = std::abs(c.weight[l]) * total[c.node[l]] / solids.elements.mass[i];
            stiff += row * n.stiffness[c.node[l]];
            area += row * n.area[c.node[l]];
        }
        for (std::size_t l = c.begin[t]; l < c.begin[t + 1]; ++l) braked[c.node[l]] = std::max(braked[c.node[l]], area);
        ContactRates& rates = c.rates[static_cast<std::size_t>(solids.elements.owner[i])];
        rates.stiffest = std::max(rates.stiffest, static_cast<double>(stiff));
    }
    const double stiffest = kMargin * stiffest_of_contacts(solids);
    for (ContactRates& rates : c.rates) {
        rates.stiffest = std::min(rates.stiffest, stiffest);
        rates.damping = damped * rates.stiffest;
    }
    n.brake.resize(n.size());
    for (std::size_t k = 0; k < n.size(); ++k) n.brake[k] = n.area[k] / braked[k];
}

}  // namespace

void list_by_element(Solids& solids) {
    list_nodes(solids.contacts.nodes, solids.elements.size(), solids.contacts);
    find_rates(solids);
}

}  // namespace thixo
