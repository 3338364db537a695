#include "sim/solid/elasticity.h"

#include <algorithm>

#include "pipeline/base/parallel.h"
#include "sim/solid/plasticity.h"

namespace thixo {
namespace {

constexpr std::size_t kElements = 128;  // of one chunk

/// Largest absolute row sum of J^T J.
Real squared_stretch(const Mat3& j) {
    const Mat3 c = j.transpose() * j;
    return c.cwiseAbs().rowwise().sum().maxCoeff();
}

/// Writes the stencil of element i, and calls flow(law, i, H, time) before and after its stress is taken. Where the
/// first call says that nothing is left to flow, there is no second one. Returns its squared stretch.
template <class Flow>
Real write_stencil(const StressLaw& law, const Elements& e, std::size_t i, const Flow& flow, StressScratch& out) {
    const RestMoment& moment = e.bonds.moment[i];
    const Mat3 inverse = matrix(moment.inverse);
    const Differences u = differences(e, i, e.displacement.data());
    const Mat3 h = u.outer * inverse, j = projection_of(e, i) + h;
    const bool flows_on = flow(law, i, h, &FlowTimes::before);
    const Mat3 stress = matrix(total_stress(law, e, i, h));
    if (flows_on) flow(law, i, h, &FlowTimes::after);
    Mat3 piola = j * stress;
    if (law.volume_stiffness > 0 && moment.full) piola += law.volume_stiffness * dilatation(h) * cofactors(j);
    const Mat3 force = -e.volume[i] * piola * inverse;
    write_forces(e, i, force, h, u.sum, e.displacement[i], out);
    return squared_stretch(j);
}

template <class Flow>
Real sweep(const std::vector<StressLaw>& laws, const Elements& elements, const Flow& flow, StressScratch& scratch,
           std::vector<Vec3>& force) {
    const std::size_t n = elements.size();
    if (n == 0) return 1;
    scratch.stencil.resize(n);
    scratch.own.resize(n);
    scratch.chunk.assign((n + kElements - 1) / kElements, 0);
    force.resize(n);
    parallel_chunks(
        n,
        [&](std::size_t begin, std::size_t end, std::size_t c) {
            for (std::size_t i = begin; i < end; ++i) {
                const Real stretch = write_stencil(laws[elements.law_of(i)], elements, i, flow, scratch);
                scratch.chunk[c] = std::max(scratch.chunk[c], stretch);
            }
        },
        kElements);
    parallel_for(
        n, [&](std::size_t i) { force[i] = scratch.own[i] + force_of_neighbours(elements, scratch.stencil.data(), i); },
        kElements);
    return *std::max_element(scratch.chunk.begin(), scratch.chunk.end());
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
        elements.rest[i].w = trace > 0 ? modulus * elements.volume[i] / trace : Real(0);
    });
}

Real find_stress_forces(const std::vector<StressLaw>& laws, const Elements& elements, StressScratch& scratch,
                        std::vector<Vec3>& force) {
    return sweep(
        laws, elements, [](const StressLaw&, std::size_t, const Mat3&, auto) { return false; }, scratch, force);
}

Real flow_and_find_stress_forces(const std::vector<StressLaw>& laws, const FlowTimes& times, Elements& elements,
                                 StressScratch& scratch, std::vector<Vec3>& force) {
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

Symmetric total_stress(const StressLaw& law, const Elements& e, std::size_t i, const Mat3& h) {
    const Symmetric strain = strain_of(e, i, h), &p = e.plastic[i];
    Symmetric stress = stress_of(
        law, e,
        {strain.xx - p.xx, strain.yy - p.yy, strain.zz - p.zz, strain.xy - p.xy, strain.yz - p.yz, strain.zx - p.zx});
    if (!(law.viscosity > 0)) return stress;
    const Mat3 rate = differences(e, i, e.velocity.data()).outer * matrix(e.bonds.moment[i].inverse);
    const Mat3 turned = (projection_of(e, i) + h).transpose() * rate;
    return symmetric(Mat3(matrix(stress) + law.viscosity * (turned + turned.transpose())));
}

double elastic_energy_of(const StressLaw& law, const Elements& e, std::size_t i) {
    const Mat3 h = gradient_of(e, static_cast<Index>(i));
    const Symmetric strain = strain_of(e, i, h), &p = e.plastic[i];
    const Symmetric elastic{strain.xx - p.xx, strain.yy - p.yy, strain.zz - p.zz,
                            strain.xy - p.xy, strain.yz - p.yz, strain.zx - p.zx};
    const Mat3 stress = matrix(stress_of(law, e, elastic));
    double density = 0.5 * static_cast<double>(stress.cwiseProduct(matrix(elastic)).sum());
    if (law.volume_stiffness > 0 && e.bonds.moment[i].full)
        density += 0.5 * static_cast<double>(law.volume_stiffness * square(dilatation(h)));
    double residual = 0;
    for (std::size_t k = e.bonds.begin[i]; k < e.bonds.begin[i + 1]; ++k) {
        const Index j = e.bonds.neighbour[k];
        const Vec3 r = xyz(e.rest[j]) - xyz(e.rest[i]), u = xyz(e.displacement[j]) - xyz(e.displacement[i]);
        residual += static_cast<double>(e.bonds.weight[k] * (u - h * r).squaredNorm());
    }
    return static_cast<double>(e.volume[i]) * density + 0.5 * static_cast<double>(e.rest[i].w) * residual;
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
