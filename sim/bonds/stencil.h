// What the sweeps over rest neighbourhoods share: sums over a stencil, and the forces of all stencils on one element.
#pragma once

#include <algorithm>
#include <vector>

#include "sim/state/elements.h"

namespace thixo {

/// What the force sweep reads of a neighbour. It fills one cache line in single precision.
struct alignas(16 * sizeof(Real)) StencilForce {
    Quad row[3];  // rows of T = F + c H [N/m], and u_x, u_y, u_z [m]
    Quad place;   // m [m], c [N/m]
};

/// Scratch of a force computation. Nothing of it lives longer than a sub-step.
struct StressScratch {
    std::vector<StencilForce> stencil;
    std::vector<Vec3> own;  // [N]
};

/// Adds the periods that bonds k, k + 1, ... go across.
inline void add_periods(const Bonds& bonds, std::size_t k, Lanes& x, Lanes& y, Lanes& z) {
    x += load(bonds.across[0].data() + k);
    y += load(bonds.across[1].data() + k);
    z += load(bonds.across[2].data() + k);
}

/// sum_j w_ij (a_j - a_i) r_ij^T and sum_j w_ij (a_j - a_i) of a vector field.
struct Differences {
    Mat3 outer;
    Vec3 sum;
};
inline Differences differences(const Elements& e, std::size_t i, const Quad* field) {
    const Quad m = e.rest[i], a = field[i];
    const bool wrap = e.bonds.wrap();
    Lanes s[3][3]{}, t[3]{};
    for (std::size_t k = e.bonds.begin[i]; k < e.bonds.begin[i + 1]; k += kLanes) {
        const Index* j = e.bonds.neighbour.data() + k;
        Lanes x, y, z, ax, ay, az, unused;
        gather(e.rest.data(), j, x, y, z, unused);
        gather(field, j, ax, ay, az, unused);
        const Lanes w = load(e.bonds.weight.data() + k);
        x -= m.x;
        y -= m.y;
        z -= m.z;
        if (wrap) add_periods(e.bonds, k, x, y, z);
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

/// |J| - 1 of J = 1 + H, computed without a difference of large numbers.
inline Real dilatation(const Mat3& h) {
    const Real minors = h(0, 0) * h(1, 1) - h(0, 1) * h(1, 0) + h(1, 1) * h(2, 2) - h(1, 2) * h(2, 1) +
                        h(0, 0) * h(2, 2) - h(0, 2) * h(2, 0);
    return h.trace() + minors + h.determinant();
}
inline Mat3 cofactors(const Mat3& j) {
    Mat3 c;
    c.col(0) = j.col(1).cross(j.col(2));
    c.col(1) = j.col(2).cross(j.col(0));
    c.col(2) = j.col(0).cross(j.col(1));
    return c;
}

/// The force on element i from all stencils in which it is a neighbour [N].
inline Vec3 force_of_neighbours(const Elements& e, const StencilForce* stencil, std::size_t i) {
    const StencilForce& own = stencil[i];
    const Quad* first = stencil->row;
    const bool wrap = e.bonds.wrap();
    Lanes fx{}, fy{}, fz{};
    alignas(32) Index at[kLanes];
    for (std::size_t k = e.bonds.begin[i]; k < e.bonds.begin[i + 1]; k += kLanes) {
        for (std::size_t l = 0; l < kLanes; ++l) at[l] = 4 * e.bonds.neighbour[k + l];
        Lanes x, y, z, c, tx, ty, tz, u;
        gather(first + 3, at, x, y, z, c);
        const Lanes w = load(e.bonds.weight_back.data() + k);
        x -= own.place.x;
        y -= own.place.y;
        z -= own.place.z;
        if (wrap) add_periods(e.bonds, k, x, y, z);
        gather(first, at, tx, ty, tz, u);
        fx += w * (c * (u - own.row[0].w) - (tx * x + ty * y + tz * z));
        gather(first + 1, at, tx, ty, tz, u);
        fy += w * (c * (u - own.row[1].w) - (tx * x + ty * y + tz * z));
        gather(first + 2, at, tx, ty, tz, u);
        fz += w * (c * (u - own.row[2].w) - (tx * x + ty * y + tz * z));
    }
    return {sum_of(fx), sum_of(fy), sum_of(fz)};
}

/// Writes the stencil of element i: its F and H, sum_j w_ij (u_j - u_i), and u.
inline void write_forces(const Elements& e, std::size_t i, const Mat3& force, const Mat3& h, const Vec3& sum,
                         const Quad& shift, StressScratch& out) {
    const Real c = e.rest[i].w;
    const Mat3 t = force + c * h;
    out.own[i] = c * sum - t * e.bonds.moment[i].first;
    out.stencil[i] = {{{t(0, 0), t(0, 1), t(0, 2), shift.x},
                       {t(1, 0), t(1, 1), t(1, 2), shift.y},
                       {t(2, 0), t(2, 1), t(2, 2), shift.z}},
                      e.rest[i]};
}

inline Mat3 projection_of(const Elements& e, std::size_t i) {
    if (e.bonds.moment[i].full) return Mat3::Identity();
    const auto at = std::lower_bound(e.bonds.flat.begin(), e.bonds.flat.end(), i,
                                     [](const auto& a, std::size_t b) { return a.first < b; });
    return matrix(at->second);
}

}  // namespace thixo
