#include "sim/solid/elasticity.h"

#include <algorithm>

#include "pipeline/base/parallel.h"
#include "sim/solid/plasticity.h"

namespace thixo {
namespace {

constexpr std::size_t kElements = 128;  // of one chunk

/// An upper bound of the largest eigenvalue.
Real largest_row_sum(const Mat3& m) { return m.cwiseAbs().rowwise().sum().maxCoeff(); }

StretchBounds bounds_of(const StressLaw& law, const Symmetric& plastic, const Mat3& j) {
    const Mat3 c = j.transpose() * j;
    const Real stretch2 = largest_row_sum(c);
    if (!is_reshaped(law, plastic)) return {stretch2, stiffening_of(stretch2, 1)};
    const Mat3 inverse = inverse_metric(plastic);
    return {stretch2, stiffening_of(largest_row_sum(inverse * c), largest_row_sum(inverse))};
}

Symmetric elastic_strain(const Elements& e, std::size_t i, const Mat3& h) {
    const Symmetric strain = strain_of(e, i, h), &p = e.plastic[i];
    return {strain.xx - p.xx, strain.yy - p.yy, strain.zz - p.zz, strain.xy - p.xy, strain.yz - p.yz, strain.zx - p.zx};
}

/// Writes the stencil of element i, and calls flow(law, i, H, time) before and after its stress is taken. Where the
/// first call says that nothing is left to flow, there is no second one. Returns its bounds.
template <class Flow>
StretchBounds write_stencil(const StressLaw& law, const Elements& e, std::size_t i, const Flow& flow,
                            StressScratch& out) {
    const RestMoment& moment = e.bonds.moment[i];
    const Mat3 inverse = matrix(moment.inverse);
    const Differences u = differences(e, i, e.displacement.data());
    const Mat3 h = u.outer * inverse, j = projection_of(e, i) + h;
    const bool flows_on = flow(law, i, h, &FlowTimes::before);
    const Mat3 stress = matrix(total_stress(law, e, i, h));
    if (flows_on) flow(law, i, h, &FlowTimes::after);
    Mat3 piola = j * stress;
    if (law.volume_stiffness > 0 && moment.full) piola += law.volume_stiffness * dilatation(h) * cofactors(j);
    const Mat3 force = -e.quadrature[i] * piola * inverse;
    write_forces(e, i, force, h, u.sum, e.displacement[i], out);
    return bounds_of(law, e.plastic[i], j);
}

template <class Flow>
StretchBounds sweep(const std::vector<StressLaw>& laws, const Elements& elements, const Flow& flow,
                    StressScratch& scratch, std::vector<Vec3>& force) {
    const std::size_t n = elements.size();
    if (n == 0) return {};
    scratch.stencil.resize(n);
    scratch.own.resize(n);
    std::vector<StretchBounds> chunk((n + kElements - 1) / kElements, {0, 0});
    force.resize(n);
    parallel_chunks(
        n,
        [&](std::size_t begin, std::size_t end, std::size_t c) {
            for (std::size_t i = begin; i < end; ++i)
                chunk[c].add(write_stencil(laws[elements.law_of(i)], elements, i, flow, scratch));
        },
        kElements);
    parallel_for(
        n, [&](std::size_t i) { force[i] = scratch.own[i] + force_of_neighbours(elements, scratch.stencil.data(), i); },
        kElements);
    StretchBounds all{0, 0};
    for (const StretchBounds& b : chunk) all.add(b);
    return all;
}

Symmetric strain_beyond_shape(const StressLaw& law, const Elements& e, std::size_t i, const Mat3& h) {
    const Symmetric elastic = elastic_strain(e, i, h);
    return is_reshaped(law, e.plastic[i]) ? strain_of_shape(elastic, e.plastic[i]) : elastic;
}

/// Returns whether the element may flow on.
bool flow_element(const StressLaw& law, double dt, const Mat3& gradient, std::size_t i, Elements& e) {
    if (!(law.creep > 0)) return false;
    if (!(dt > 0)) return true;
    Real none = 0;
    return flow_plastically(law, static_cast<Real>(dt), strain_of(e, i, gradient), e.plastic[i],
                            e.hardens ? e.hardened[i] : none);
}

}  // namespace

void set_zero_energy(const std::vector<StressLaw>& laws, Elements& elements) {
    parallel_for(elements.size(), [&](std::size_t i) {
        const Real trace = elements.bonds.moment[i].trace;
        const Real modulus = laws[elements.law_of(i)].zero_energy;
        elements.rest[i].w = trace > 0 ? modulus * elements.quadrature[i] / trace : Real(0);
    });
}

StretchBounds find_stress_forces(const std::vector<StressLaw>& laws, const Elements& elements, StressScratch& scratch,
                                 std::vector<Vec3>& force) {
    return sweep(
        laws, elements, [](const StressLaw&, std::size_t, const Mat3&, auto) { return false; }, scratch, force);
}

StretchBounds flow_and_find_stress_forces(const std::vector<StressLaw>& laws, const FlowTimes& times,
                                          Elements& elements, StressScratch& scratch, std::vector<Vec3>& force) {
    const auto flow = [&](const StressLaw& law, std::size_t i, const Mat3& h, auto when) {
        return flow_element(law, times.*when, h, i, elements);
    };
    return sweep(laws, elements, flow, scratch, force);
}

void flow_plastically(const std::vector<StressLaw>& laws, double dt, const std::vector<Mat3>& gradients,
                      Elements& elements) {
    parallel_for(elements.size(),
                 [&](std::size_t i) { flow_element(laws[elements.law_of(i)], dt, gradients[i], i, elements); });
}

/// (P H + H^T P + H^T H)/2
Symmetric strain_of(const Elements& elements, std::size_t i, const Mat3& gradient) {
    const Mat3 linear = projection_of(elements, i) * gradient;
    return symmetric(Mat3(Real(0.5) * (linear + linear.transpose() + gradient.transpose() * gradient)));
}

KeptStrains::KeptStrains(const std::vector<StressLaw>& laws, const Elements& e, const std::vector<Mat3>& gradients) {
    if (std::ranges::none_of(laws, [](const StressLaw& law) { return law.creep > 0; })) return;
    elastic_.resize(e.size());
    inverse_.resize(e.size());
    parallel_for(e.size(), [&](std::size_t i) {
        const StressLaw& law = laws[e.law_of(i)];
        if (!(law.creep > 0)) return;
        elastic_[i] = strain_beyond_shape(law, e, i, gradients[i]);
        inverse_[i] = e.bonds.moment[i].inverse;
    });
}

void KeptStrains::restore(const std::vector<StressLaw>& laws, Elements& e) const {
    parallel_for(elastic_.size(), [&](std::size_t i) {
        const StressLaw& law = laws[e.law_of(i)];
        if (!(law.creep > 0) || matrix(inverse_[i]) == matrix(e.bonds.moment[i].inverse)) return;
        e.plastic[i] = plastic_beside(law, strain_of(e, i, gradient_of(e, static_cast<Index>(i))), elastic_[i]);
    });
}

Symmetric total_stress(const StressLaw& law, const Elements& e, std::size_t i, const Mat3& h) {
    const Symmetric stress = stress_of(law, e, i, elastic_strain(e, i, h));
    if (!(law.viscosity > 0)) return stress;
    const Mat3 rate = differences(e, i, e.velocity.data()).outer * matrix(e.bonds.moment[i].inverse);
    const Mat3 turned = (projection_of(e, i) + h).transpose() * rate;
    return symmetric(Mat3(matrix(stress) + law.viscosity * (turned + turned.transpose())));
}

double elastic_energy_of(const StressLaw& law, const Elements& e, std::size_t i) {
    const Mat3 h = gradient_of(e, static_cast<Index>(i));
    const Symmetric elastic = elastic_strain(e, i, h);
    const Mat3 stress = matrix(stress_of(law, e, i, elastic));
    double density = 0.5 * static_cast<double>(stress.cwiseProduct(matrix(elastic)).sum());
    if (law.volume_stiffness > 0 && e.bonds.moment[i].full)
        density += 0.5 * static_cast<double>(law.volume_stiffness * square(dilatation(h)));
    double residual = 0;
    for (std::size_t k = e.bonds.begin[i]; k < e.bonds.begin[i + 1]; ++k) {
        const Index j = e.bonds.neighbour[k];
        const Vec3 u = xyz(e.displacement[j]) - xyz(e.displacement[i]);
        residual += static_cast<double>(e.bonds.weight[k] * (u - h * bond_vector(e, i, k).cast<Real>()).squaredNorm());
    }
    return static_cast<double>(e.quadrature[i]) * density + 0.5 * static_cast<double>(e.rest[i].w) * residual;
}

Symmetric stress_of_shape(const StressLaw& law, const Elements& elements, std::size_t i, const Mat3& gradient) {
    return stress_of(law, elements, strain_beyond_shape(law, elements, i, gradient));
}

Symmetric stress_of(const StressLaw& law, const Elements& elements, std::size_t i, const Symmetric& e) {
    const Symmetric& plastic = elements.plastic[i];
    if (!is_reshaped(law, plastic)) return stress_of(law, elements, e);
    if (law.anisotropy != kNone) {
        const Symmetric stress = stress_of(law, elements, strain_of_shape(e, plastic));
        return strain_of_shape(stress, plastic);  // U_p^-1 on both sides, as of a strain
    }
    // lambda (C_p^-1 : e) C_p^-1 + 2 mu C_p^-1 e C_p^-1. Viscosity is that of the rest shape.
    const Mat3 inverse = inverse_metric(plastic), strain = matrix(e);
    const Real pressure = law.lambda * inverse.cwiseProduct(strain).sum();
    return symmetric(
        Mat3(pressure * inverse + 2 * law.mu * inverse * strain * inverse + 2 * law.rate_modulus * strain));
}

Symmetric stress_of(const StressLaw& law, const Elements& elements, const Symmetric& e) {
    if (law.anisotropy == kNone) return stress_of(law, e);
    Eigen::Matrix<Real, 6, 1> strain;
    strain << e.xx, e.yy, e.zz, 2 * e.xy, 2 * e.yz, 2 * e.zx;
    const Eigen::Matrix<Real, 6, 1> stress = elements.anisotropic[law.anisotropy] * strain;
    const Real shear = 2 * law.rate_modulus;
    return {stress[0] + shear * e.xx, stress[1] + shear * e.yy, stress[2] + shear * e.zz,
            stress[3] + shear * e.xy, stress[4] + shear * e.yz, stress[5] + shear * e.zx};
}

}  // namespace thixo
