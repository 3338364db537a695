#include "sim/bonds/weights.h"

#include <algorithm>

#include "pipeline/base/parallel.h"
#include "sim/bonds/rest_shape.h"

namespace thixo {

void keep_bases(Bonds& bonds) {
    bonds.base = bonds.weight;
    bonds.base_back = bonds.weight_back;
}

void weigh_bonds(Elements& e, double flat) {
    Bonds& bonds = e.bonds;
    std::vector<std::uint8_t> changed(e.size(), 0);
    parallel_for(e.size(), [&](std::size_t i) {
        const Real own = e.solidity(i);
        for (std::size_t k = bonds.begin[i]; k < bonds.begin[i + 1]; ++k) {
            Real left = std::min(own, e.solidity(bonds.neighbour[k]));
            if (!bonds.visibility.empty()) left *= bonds.visibility[k];
            const Real w = left * bonds.base[k], back = left * bonds.base_back[k];
            if (w != bonds.weight[k] || back != bonds.weight_back[k]) changed[i] = 1;
            bonds.weight[k] = w;
            bonds.weight_back[k] = back;
        }
    });
    if (std::ranges::none_of(changed, [](std::uint8_t c) { return c != 0; })) return;
    measure_moments(e, &changed, flat);
    ++bonds.weights_version;
}

void weaken_bonds(const std::vector<WeakBond>& weak, Elements& e) {
    Bonds& bonds = e.bonds;
    if (bonds.base.empty()) keep_bases(bonds);
    if (bonds.visibility.empty()) bonds.visibility.assign(bonds.neighbour.size(), 1);
    bool any = false;
    const auto lower = [&](Index i, Index j, Real to) {
        for (std::size_t k = bonds.begin[i]; k < bonds.begin[i + 1]; ++k) {
            if (bonds.neighbour[k] != j || !(to < bonds.visibility[k])) continue;
            bonds.visibility[k] = to;
            any = true;
        }
    };
    for (const WeakBond& bond : weak) {
        lower(bond.first, bond.second, bond.visibility);
        lower(bond.second, bond.first, bond.visibility);
    }
    if (!any) return;
    bonds.changed_by_cracks();
    weigh_bonds(e, flatness(e));
}

void set_visibility(Elements& e, const std::function<Real(Index, Index)>& of) {
    Bonds& bonds = e.bonds;
    if (bonds.base.empty()) keep_bases(bonds);
    bonds.visibility.assign(bonds.neighbour.size(), 1);
    parallel_for(e.size(), [&](std::size_t i) {
        for (std::size_t k = bonds.begin[i]; k < bonds.begin[i + 1]; ++k)
            if (const Index j = bonds.neighbour[k]; j != i) bonds.visibility[k] = of(static_cast<Index>(i), j);
    });
    bonds.changed();
    weigh_bonds(e, flatness(e));
}

}  // namespace thixo
