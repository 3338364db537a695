// Matter that keeps a shape: the elastic attributes of particles, and the bonds between them. Elements are ordered by
// body, and within a body by the cells of its rest shape. Rest neighbourhoods stay, and so does this order, whatever
// the order of the particles.
#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "pipeline/base/lanes.h"
#include "pipeline/base/math.h"
#include "sim/state/phase.h"
#include "sim/state/table.h"

namespace thixo {

/// Symmetric 3x3 tensor.
struct Symmetric {
    Real xx = 0, yy = 0, zz = 0, xy = 0, yz = 0, zx = 0;
};
inline Mat3 matrix(const Symmetric& s) {
    Mat3 m;
    m << s.xx, s.xy, s.zx, s.xy, s.yy, s.yz, s.zx, s.yz, s.zz;
    return m;
}
inline Symmetric symmetric(const Mat3& m) { return {m(0, 0), m(1, 1), m(2, 2), m(0, 1), m(1, 2), m(2, 0)}; }
/// Frobenius norm.
inline Real norm(const Symmetric& s) {
    return std::sqrt(square(s.xx) + square(s.yy) + square(s.zz) + 2 * (square(s.xy) + square(s.yz) + square(s.zx)));
}

/// C of sigma = C eps, symmetric, in Voigt's order xx yy zz xy yz zx with engineering shear, 2 eps_xy.
using Stiffness6 = Eigen::Matrix<Real, 6, 6>;

/// Moments of an element's rest neighbourhood, r_ij = m_j - m_i.
struct RestMoment {
    Symmetric inverse;    // A+, pseudo-inverse of A = sum_j w_ij r_ij r_ij^T [1/m^2]
    Vec3 first{0, 0, 0};  // sum_j w_ij r_ij [m]
    Real trace = 0;       // of A [m^2]
    bool full = true;     // A has rank 3, and P = A A+ is the identity
};

/// The bonds of all elements, by element: the neighbours j with their weights, and values that follow from these:
///     w = base x visibility x solidity
/// The base depends on the distance in the rest shape, visibility on cracks between the two, solidity on melting. The
/// factors are stored apart where a scene needs them. Empty `base`: w is the base. Empty `visibility`: all bonds are
/// visible.
struct Bonds {
    // Each list is padded to a multiple of kLanes with the element itself, of weight 0.
    std::vector<std::size_t> begin;  // of each element's list, then the end
    std::vector<Index> neighbour;
    std::vector<Real> weight;           // w_ij [1], of i's own stencil
    std::vector<Real> weight_back;      // w_ji, of j's stencil
    std::vector<Real> base, base_back;  // of the rest shape alone [1]
    std::vector<Real> visibility;       // the same in both directions: 1 visible, 0 behind a full crack [1]
    // The periods that a bond goes across, along x, y, z [m]. Empty where no body goes on through periodic faces.
    std::array<std::vector<Real>, 3> across;
    std::vector<RestMoment> moment;
    // Elements without rank 3, ascending, and their projection P = A A+.
    std::vector<std::pair<Index, Symmetric>> flat;
    // Raised by every change of a list, a base, a visibility or a law. Values computed from bonds store the version
    // that they were computed for.
    std::uint64_t version = 1;
    // The same, raised by changes of solidity as well.
    std::uint64_t weights_version = 1;
    // How many of the last versions, up to this one, are of bonds that cracks have weakened and of nothing else.
    std::uint64_t weakened = 0;

    std::size_t size() const { return begin.empty() ? 0 : begin.size() - 1; }
    bool wrap() const { return !across[0].empty(); }
    void changed() { ++version, ++weights_version, weakened = 0; }
    void changed_by_cracks() { ++version, ++weights_version, ++weakened; }
};

/// Structure of arrays; row e of every array is element e. Places and vectors are in their body's material frame.
struct Elements {
    bool softens = false;  // some matter changes its phase: law, phase and melt have rows; otherwise all is solid
    bool breaks = false;   // some matter can crack: strength has rows
    bool hardens = false;  // some matter hardens: hardened has rows
    // The rest shape.
    std::vector<std::int64_t> id;     // of its particle
    std::vector<std::int32_t> owner;  // index of its SolidBody
    std::vector<Index> law;           // index of its own law; empty: its owner's
    std::vector<Quad> rest;  // m [m]; stiffness c of the zero-energy modes [N/m], rewritten when materials change
    std::vector<Real> mass, volume;  // [kg], V of the rest shape [m^3]
    // The volume by which the element integrates stress [m^3]. In a body it differs from V, so that bending is as stiff as
    // it should be (solid_setup.h). 0: stress in it has no force, as in rigid bodies.
    std::vector<Real> quadrature;
    std::vector<Real> support;  // h [m]
    std::vector<Real> depth;    // of the particle below the body's surface, in the rest shape [m]
    // Tension at which a crack begins; the largest number: it never does. At the present temperature, and without it.
    std::vector<Real> strength, own_strength;  // [Pa]
    // Copies of its particle's fields, written with them.
    std::vector<Phase> phase;
    std::vector<Real> melt;  // b [1]

    // The state.
    std::vector<Quad> displacement;  // u = x - m [m]; -
    std::vector<Quad> velocity;      // at t - dt/2 between sub-steps [m/s]; -
    std::vector<Vec3> acceleration;  // of the last sub-step [m/s^2]
    std::vector<Symmetric> plastic;  // eps^p [1]
    std::vector<Real> hardened;      // size of all plastic flow so far [1]; only where `hardens`

    // By body, not by element: C of anisotropic laws, in the material frame [Pa]; rewritten with the laws.
    std::vector<Stiffness6> anisotropic;
    Bonds bonds;

    std::size_t size() const { return id.size(); }
    std::size_t law_of(std::size_t i) const {
        return static_cast<std::size_t>(law.empty() ? static_cast<Index>(owner[i]) : law[i]);
    }
    Phase phase_of(std::size_t i) const { return softens ? phase[i] : Phase::solid; }
    /// The share of the element that is bound to the rest shape [1].
    Real solidity(std::size_t i) const { return !softens ? Real(1) : phase[i] == Phase::solid ? 1 - melt[i] : Real(0); }
};

/// r_ij of bond k of element i in the rest shape [m]: to its neighbour, or to the neighbour's image across periodic faces.
inline Vec3d bond_vector(const Elements& e, std::size_t i, std::size_t k) {
    const Vec3d r = xyz(e.rest[e.bonds.neighbour[k]]).cast<double>() - xyz(e.rest[i]).cast<double>();
    const auto& across = e.bonds.across;
    return e.bonds.wrap() ? Vec3d(r + Vec3(across[0][k], across[1][k], across[2][k]).cast<double>()) : r;
}

template <class E, class F>
void for_each_field(E& e, F&& f) requires requires {
    e.displacement;
}
{
    f("solid.id", Life::made, e.id);
    f("solid.owner", Life::made, e.owner);
    if (e.softens) f("solid.law", Life::made, e.law);
    f("solid.rest", Life::made, e.rest);
    f("solid.mass", Life::made, e.mass);
    f("solid.volume", Life::made, e.volume);
    f("solid.quadrature", Life::made, e.quadrature);
    f("solid.support", Life::made, e.support);
    f("solid.depth", Life::made, e.depth);
    if (e.breaks) {
        f("solid.strength", Life::made, e.strength);
        f("solid.own_strength", Life::made, e.own_strength);
    }
    if (e.softens) {
        f("solid.phase", Life::state, e.phase);
        f("solid.melt", Life::state, e.melt);
    }
    f("solid.displacement", Life::state, e.displacement);
    f("solid.velocity", Life::state, e.velocity);
    f("solid.acceleration", Life::state, e.acceleration);
    f("solid.plastic", Life::state, e.plastic);
    if (e.hardens) f("solid.hardened", Life::state, e.hardened);
}

}  // namespace thixo
