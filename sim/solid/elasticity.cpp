#include "sim/solid/elasticity.h"

#include <algorithm>
#include <cstring>

#include "pipeline/base/parallel.h"

namespace thixo {
namespace {

constexpr std::size_t kElements = 128;  // of one chunk

Lanes load(const Real* from) {
    Lanes a;
    std::memcpy(&a, from, sizeof a);
    return a;
}

/// sum_j w_ij (a_j - a_i) r_ij^T and sum_j w_ij (a_j - a_i) of a vector field.
struct Differences {
    Mat3 outer;
    Vec3 sum;
};
Differences differences(const Elements& e, std::size_t i, const Quad* field) {
    const Quad m = e.rest[i], a = field[i];
    Lanes s[3][3]{}, t[3]{};
    for (std::size_t k = e.begin[i]; k < e.begin[i + 1]; k += kLanes) {
        const Index* j = e.neighbour.data() + k;
        Lanes x, y, z, ax, ay, az, unused;
        gather(e.rest.data(), j, x, y, z, unused);
        gather(field, j, ax, ay, az, unused);
        const Lanes w = load(e.weight.data() + k);
        x -= m.x;
        y -= m.y;
        z -= m.z;
        const Lanes d[3] = {w * (ax - a.x), w * (ay - a.y), w * (az - a.z)};
        for (int c = 0; c < 3; ++c) {
            s[c][0] += d[c] * x;
            s[c][1] += d[c] * y;
            s[c][2] += d[c] * z;
            t[c] += d[c];
        }
    }
    Differences out;
    for (int c = 0; c < 3; ++c) {
        for (int d = 0; d < 3; ++d) out.outer(c, d) = sum_of(s[c][d]);
        out.sum[c] = sum_of(t[c]);
    }
    return out;
}

/// |J| - 1 of J = 1 + H, without the difference.
Real dilatation(const Mat3& h) {
    const Real minors = h(0, 0) * h(1, 1) - h(0, 1) * h(1, 0) + h(1, 1) * h(2, 2) - h(1, 2) * h(2, 1) +
                        h(0, 0) * h(2, 2) - h(0, 2) * h(2, 0);
    return h.trace() + minors + h.determinant();
}
Mat3 cofactors(const Mat3& j) {
    Mat3 c;
    c.col(0) = j.col(1).cross(j.col(2));
    c.col(1) = j.col(2).cross(j.col(0));
    c.col(2) = j.col(0).cross(j.col(1));
    return c;
}

/// Largest absolute row sum of J^T J.
Real squared_stretch(const Mat3& j) {
    const Mat3 c = j.transpose() * j;
    return c.cwiseAbs().rowwise().sum().maxCoeff();
}

/// (P H + H^T P + H^T H)/2
Mat3 green(const Mat3& p, const Mat3& h) {
    const Mat3 linear = p * h;
    return Real(0.5) * (linear + linear.transpose() + h.transpose() * h);
}

/// Writes the stencil of element i; returns its squared stretch.
Real write_stencil(const StressLaw& law, const Elements& e, const Mat3& projection, std::size_t i, StressScratch& out) {
    const RestMoment& moment = e.moment[i];
    const Mat3 inverse = matrix(moment.inverse);
    const Differences u = differences(e, i, e.displacement.data());
    const Mat3 h = u.outer * inverse, j = projection + h;
    const Symmetric p = e.plastic[i];
    Symmetric strain = symmetric(green(projection, h));
    strain = {strain.xx - p.xx, strain.yy - p.yy, strain.zz - p.zz,
              strain.xy - p.xy, strain.yz - p.yz, strain.zx - p.zx};
    Mat3 stress = matrix(stress_of(law, strain));
    if (law.viscosity > 0) {
        const Mat3 rate = differences(e, i, e.velocity.data()).outer * inverse;
        const Mat3 turned = j.transpose() * rate;
        stress += law.viscosity * (turned + turned.transpose());
    }
    Mat3 piola = j * stress;
    if (law.volume_stiffness > 0 && moment.full) piola += law.volume_stiffness * dilatation(h) * cofactors(j);
    const Mat3 force = -e.volume[i] * piola * inverse;
    const Real c = e.rest[i].w;
    const Mat3 t = force + c * h;
    out.own[i] = c * u.sum - t * moment.first;
    const Quad shift = e.displacement[i];
    out.stencil[i] = {{{t(0, 0), t(0, 1), t(0, 2), shift.x},
                       {t(1, 0), t(1, 1), t(1, 2), shift.y},
                       {t(2, 0), t(2, 1), t(2, 2), shift.z}},
                      e.rest[i]};
    return squared_stretch(j);
}

/// Of all stencils that i is a neighbour in.
Vec3 force_of_neighbours(const Elements& e, const StencilForce* stencil, std::size_t i) {
    const StencilForce& own = stencil[i];
    const Quad* first = stencil->row;
    Lanes fx{}, fy{}, fz{};
    alignas(32) Index at[kLanes];
    for (std::size_t k = e.begin[i]; k < e.begin[i + 1]; k += kLanes) {
        for (std::size_t l = 0; l < kLanes; ++l) at[l] = 4 * e.neighbour[k + l];
        Lanes x, y, z, c, tx, ty, tz, u;
        gather(first + 3, at, x, y, z, c);
        const Lanes w = load(e.weight_back.data() + k);
        x -= own.place.x;
        y -= own.place.y;
        z -= own.place.z;
        gather(first, at, tx, ty, tz, u);
        fx += w * (c * (u - own.row[0].w) - (tx * x + ty * y + tz * z));
        gather(first + 1, at, tx, ty, tz, u);
        fy += w * (c * (u - own.row[1].w) - (tx * x + ty * y + tz * z));
        gather(first + 2, at, tx, ty, tz, u);
        fz += w * (c * (u - own.row[2].w) - (tx * x + ty * y + tz * z));
    }
    return {sum_of(fx), sum_of(fy), sum_of(fz)};
}

Mat3 projection_of(const Elements& e, std::size_t i) {
    if (e.moment[i].full) return Mat3::Identity();
    const auto at =
        std::lower_bound(e.flat.begin(), e.flat.end(), i, [](const auto& a, std::size_t b) { return a.first < b; });
    return matrix(at->second);
}

}  // namespace

void set_zero_energy(const std::vector<StressLaw>& laws, Elements& elements) {
    parallel_for(elements.size(), [&](std::size_t i) {
        const Real trace = elements.moment[i].trace;
        const Real modulus = laws[elements.law_of(i)].zero_energy;
        elements.rest[i].w = trace > 0 ? modulus * elements.volume[i] / trace : Real(0);
    });
}

Mat3 gradient_of(const Elements& elements, std::size_t i) {
    return differences(elements, i, elements.displacement.data()).outer * matrix(elements.moment[i].inverse);
}

void find_gradients(const Elements& elements, std::vector<Mat3>& gradients) {
    gradients.resize(elements.size());
    parallel_for(elements.size(), [&](std::size_t i) { gradients[i] = gradient_of(elements, i); }, kElements);
}

Real find_stress_forces(const std::vector<StressLaw>& laws, const Elements& elements, StressScratch& scratch,
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
                const StressLaw& law = laws[elements.law_of(i)];
                const Real stretch = write_stencil(law, elements, projection_of(elements, i), i, scratch);
                scratch.chunk[c] = std::max(scratch.chunk[c], stretch);
            }
        },
        kElements);
    parallel_for(
        n, [&](std::size_t i) { force[i] = scratch.own[i] + force_of_neighbours(elements, scratch.stencil.data(), i); },
        kElements);
    return *std::max_element(scratch.chunk.begin(), scratch.chunk.end());
}

void flow_plastically(const std::vector<StressLaw>& laws, double dt, const std::vector<Mat3>& gradients,
                      Elements& elements) {
    parallel_for(elements.size(), [&](std::size_t i) {
        const StressLaw& law = laws[elements.law_of(i)];
        if (!(law.creep > 0)) return;
        Symmetric& p = elements.plastic[i];
        const Symmetric s = strain_of(elements, i, gradients[i]);
        const Symmetric e{s.xx - p.xx, s.yy - p.yy, s.zz - p.zz, s.xy - p.xy, s.yz - p.yz, s.zx - p.zx};
        if (!(norm(e) > law.yield)) return;
        const Real part = std::min(static_cast<Real>(dt) * law.creep, Real(1));
        p = {p.xx + part * e.xx, p.yy + part * e.yy, p.zz + part * e.zz,
             p.xy + part * e.xy, p.yz + part * e.yz, p.zx + part * e.zx};
        const Real size = norm(p);
        if (!(law.most_plastic > 0) || size <= law.most_plastic) return;
        const Real back = law.most_plastic / size;
        p = {back * p.xx, back * p.yy, back * p.zz, back * p.xy, back * p.yz, back * p.zx};
    });
}

Symmetric strain_of(const Elements& elements, std::size_t i, const Mat3& gradient) {
    return symmetric(green(projection_of(elements, i), gradient));
}

Symmetric stress_of(const StressLaw& law, const Symmetric& e) {
    const Real pressure = law.lambda * (e.xx + e.yy + e.zz), shear = 2 * law.mu;
    return {pressure + shear * e.xx,
            pressure + shear * e.yy,
            pressure + shear * e.zz,
            shear * e.xy,
            shear * e.yz,
            shear * e.zx};
}

}  // namespace thixo
