#include "sim/fracture/tension.h"

#include <Eigen/Eigenvalues>
#include <algorithm>

#include "pipeline/base/parallel.h"
#include "pipeline/geometry/kernels.h"
#include "sim/solid/elasticity.h"

namespace thixo {

Tension largest_tension(const Symmetric& stress) {
    Eigen::SelfAdjointEigenSolver<Mat3d> solver;
    solver.computeDirect(matrix(stress).cast<double>());
    return {static_cast<Real>(solver.eigenvalues()[2]), solver.eigenvectors().col(2).cast<Real>()};
}

void find_stress(const Solids& solids, std::vector<Symmetric>& stress) {
    const Elements& e = solids.elements;
    stress.assign(e.size(), {});
    parallel_for(e.size(), [&](std::size_t i) {
        if (e.strength[i] == kUnbreakable) return;
        stress[i] = stress_of_shape(solids.laws[static_cast<std::size_t>(e.owner[i])], e, i, solids.gradients[i]);
    });
}

namespace {

/// Whether the tension may reach the part of the strength that is watched: the norm bounds the largest eigenvalue.
bool is_watched(const Symmetric& stress, Real strength) { return norm(stress) > kWatched * strength; }

}  // namespace

Real load_of(const Symmetric& stress, Real strength) {
    return (is_watched(stress, strength) ? largest_tension(stress).value : norm(stress)) / strength;
}

void find_tension(const Elements& elements, const std::vector<Symmetric>& stress, std::vector<Tension>& tension) {
    tension.assign(elements.size(), {});
    parallel_for(elements.size(), [&](std::size_t i) {
        if (is_watched(stress[i], elements.strength[i])) tension[i] = largest_tension(stress[i]);
    });
}

double largest_load(const Elements& elements, const std::vector<Symmetric>& stress,
                    const std::vector<Tension>& tension) {
    return parallel_reduce(
        elements.size(), 0.0,
        [&](std::size_t i) {
            const Real load = is_watched(stress[i], elements.strength[i]) ? tension[i].value : norm(stress[i]);
            return static_cast<double>(load / elements.strength[i]);
        },
        [](double a, double b) { return std::max(a, b); });
}

CrackedMatter::CrackedMatter(const Solids& solids, const Breaking& breaking) : solids_(&solids), breaking_(&breaking) {
    for (const SolidBody& body : solids.bodies)
        if (body.frame == breaking.frame) elements_.insert(elements_.end(), body.elements.begin(), body.elements.end());
    std::vector<Vec3> place;
    for (const Index i : elements_) place.push_back(xyz(solids.elements.rest[i]));
    grid_.build(place, breaking.support);
    std::vector<Index> rows;
    for (Index k = 0; k < solids.cracks.triangles.size(); ++k) {
        const auto of = static_cast<std::size_t>(solids.cracks.triangles.crack[k]);
        if (solids.cracks.cracks[of].frame == breaking.frame) rows.push_back(k);
    }
    sheets_ = CrackTree(solids.cracks, rows);
}

bool CrackedMatter::hidden(const Vec3& from, const Vec3& to) const {
    return sheets_.any_crossing(
        from, to, [&](Index k, const Vec3&) { return solids_->cracks.triangles.behind[k] > breaking_->opaque / 2; });
}

CrackedMatter::Local CrackedMatter::at(const Vec3& m, const std::vector<Symmetric>& stress) const {
    const Poly6 kernel(breaking_->support);
    Real sum = 0;
    Local out;
    const auto add = [](Symmetric& to, Real w, const Symmetric& s) {
        to.xx += w * s.xx, to.yy += w * s.yy, to.zz += w * s.zz;
        to.xy += w * s.xy, to.yz += w * s.yz, to.zx += w * s.zx;
    };
    grid_.for_each_neighbour(m, breaking_->support, [&](Index near, Real r2) {
        const Index i = elements_[near];
        if (hidden(m, xyz(solids_->elements.rest[i]))) return;
        const Real w = kernel.value(r2);
        add(out.stress, w, stress[i]);
        out.strength += w * std::min(solids_->elements.strength[i], Real(1e30));
        sum += w;
    });
    if (!(sum > 0)) return {};
    const Symmetric total = std::exchange(out.stress, {});
    add(out.stress, 1 / sum, total);
    out.strength /= sum;
    return out;
}

}  // namespace thixo
