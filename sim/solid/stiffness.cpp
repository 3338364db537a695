#include "sim/solid/stiffness.h"

#include "pipeline/base/parallel.h"
#include "sim/bonds/stencil.h"

namespace thixo {
namespace {

constexpr std::size_t kTangents = 128;  // of one chunk

/// The tensile part of a stress.
Symmetric pulling(const Symmetric& stress) {
    Eigen::SelfAdjointEigenSolver<Mat3> eigen;
    eigen.computeDirect(matrix(stress));
    const Mat3& v = eigen.eigenvectors();
    return symmetric(Mat3(v * eigen.eigenvalues().cwiseMax(Real(0)).asDiagonal() * v.transpose()));
}

Stiffness::At tangent_of(const StressLaw& law, const Elements& e, std::size_t i, Tangent tangent) {
    const Mat3 h = gradient_of(e, i);
    Stiffness::At at;
    at.j = projection_of(e, i) + h;
    at.stress = total_stress(law, e, i, h);
    at.dilatation =
        law.volume_stiffness > 0 && e.bonds.moment[i].full && tangent == Tangent::exact ? dilatation(h) : Real(0);
    if (tangent == Tangent::definite) at.stress = pulling(at.stress);
    return at;
}

/// deps of the gradient dh.
Symmetric strain_change(const Mat3& j, const Mat3& dh) {
    const Mat3 turned = j.transpose() * dh;
    return symmetric(Mat3(Real(0.5) * (turned + turned.transpose())));
}

/// dP of element i for the gradient dh, with the dsigma that it makes.
Mat3 stress_change(const StressLaw& law, const Elements& e, const Stiffness::At& at, std::size_t i, const Mat3& dh,
                   const Symmetric& stress) {
    Mat3 change = dh * matrix(at.stress) + at.j * matrix(stress);
    if (law.volume_stiffness > 0 && e.bonds.moment[i].full) {
        const Mat3 cof = cofactors(at.j);
        change += law.volume_stiffness * cof.cwiseProduct(dh).sum() * cof;
        if (at.dilatation != 0)  // cof is of second degree in J
            change += law.volume_stiffness * at.dilatation * (cofactors(at.j + dh) - cof - cofactors(dh));
    }
    return change;
}

/// Adds, by way of one stencil with H = du b^T, how an element's displacement du changes the element's own force.
void add_block(const StressLaw& law, const Elements& e, std::size_t stencil, const Vec3& b, Mat3& block) {
    for (int a = 0; a < 3; ++a)
        block.col(a) +=
            e.quadrature[stencil] * (stress_change_at_rest(law, e, stencil, Vec3::Unit(a) * b.transpose()) * b);
}

/// Sum over the stencils with element i: its own, in which du moves the middle, and those it is a neighbour in.
Mat3 block_of(const std::vector<StressLaw>& laws, const Elements& e, std::size_t i, bool zero_energy) {
    Mat3 block = Mat3::Zero();
    const Vec3 b = -(matrix(e.bonds.moment[i].inverse) * e.bonds.moment[i].first);
    add_block(laws[e.law_of(i)], e, i, b, block);
    Real weights = 0, elsewhere = 0;
    for (std::size_t k = e.bonds.begin[i]; k < e.bonds.begin[i + 1]; ++k) {
        const Index j = e.bonds.neighbour[k];
        weights += e.bonds.weight[k];
        const Real w = e.bonds.weight_back[k];
        if (!(w > 0)) continue;
        const Vec3 r = -bond_vector(e, i, k).cast<Real>();
        const Vec3 c = w * (matrix(e.bonds.moment[j].inverse) * r);
        add_block(laws[e.law_of(j)], e, j, c, block);
        elsewhere += e.rest[j].w * (w - w * r.dot(c));
    }
    if (zero_energy) block.diagonal().array() += e.rest[i].w * (weights + e.bonds.moment[i].first.dot(b)) + elsewhere;
    return block;
}

}  // namespace

void linearise(const std::vector<StressLaw>& laws, const Elements& elements, double dt, Tangent tangent,
               Stiffness& stiffness) {
    stiffness.laws = laws;
    for (StressLaw& law : stiffness.laws) law.rate_modulus = static_cast<Real>(static_cast<double>(law.viscosity) / dt);
    stiffness.at.resize(elements.size());
    parallel_for(
        elements.size(),
        [&](std::size_t i) { stiffness.at[i] = tangent_of(laws[elements.law_of(i)], elements, i, tangent); },
        kTangents);
}

void multiply(const Elements& elements, Stiffness& stiffness, const std::vector<Quad>& du, std::vector<Vec3>& out) {
    const std::size_t n = elements.size();
    StressScratch& scratch = stiffness.scratch;
    scratch.stencil.resize(n);
    scratch.own.resize(n);
    parallel_for(
        n,
        [&](std::size_t i) {
            const Mat3 inverse = matrix(elements.bonds.moment[i].inverse);
            const Differences d = differences(elements, i, du.data());
            const Mat3 dh = d.outer * inverse;
            const StressLaw& law = stiffness.laws[elements.law_of(i)];
            const Stiffness::At& at = stiffness.at[i];
            const Symmetric stress = stress_of(law, elements, i, strain_change(at.j, dh));
            const Mat3 change = stress_change(law, elements, at, i, dh, stress);
            write_forces(elements, i, -elements.quadrature[i] * change * inverse, dh, d.sum, du[i], scratch);
        },
        kTangents);
    parallel_for(
        n, [&](std::size_t i) { out[i] = scratch.own[i] + force_of_neighbours(elements, scratch.stencil.data(), i); },
        kTangents);
}

Mat3 stress_change_at_rest(const StressLaw& law, const Elements& elements, std::size_t i, const Mat3& dh) {
    const Stiffness::At at{projection_of(elements, i), {}, 0};
    return stress_change(law, elements, at, i, dh, stress_of(law, elements, strain_change(at.j, dh)));
}

void find_diagonal(const std::vector<StressLaw>& laws, const Elements& elements, std::vector<Symmetric>& elastic,
                   std::vector<Symmetric>& viscous) {
    std::vector<StressLaw> still = laws, rates;
    bool any = false;
    for (StressLaw& law : still) {
        rates.push_back({.mu = law.viscosity});
        any = any || law.viscosity > 0;
    }
    elastic.resize(elements.size());
    viscous.assign(elements.size(), {});
    parallel_for(
        elements.size(),
        [&](std::size_t i) {
            elastic[i] = symmetric(block_of(still, elements, i, true));
            if (any) viscous[i] = symmetric(block_of(rates, elements, i, false));
        },
        kTangents);
}

}  // namespace thixo
