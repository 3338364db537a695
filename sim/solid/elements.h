// Bodies that keep a shape: the elastic attribute group of their particles. Elements stand body by body and within a
// body in the cell order of its rest shape; as rest neighbourhoods stay, so does this order, whatever the particles'
// is.
#pragma once

#include <cstdint>
#include <vector>

#include "pipeline/base/lanes.h"
#include "pipeline/base/math.h"

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

/// A solid body. Its material frame is the first rest shape about its centre of mass; the rest shape of now, rotated
/// and moved to fit the deformed one (dissertation 5.4.3), is that frame in the pose x = R m + t. So the material frame
/// holds all that is bound to the matter, and nothing in it is ever turned.
struct SolidBody {
    std::int32_t body =
        0;  // index into Scene::bodies, and Particles::body; -1: what emitters release, without rest shape
    std::int32_t material = 0;  // index into Scene::materials
    Index begin = 0, end = 0;   // its elements
    Index typical = 0;          // one whose width and support are those at its surface
    Index lightest = 0;
    Mat3d turn = Mat3d::Identity();  // R
    Vec3d place{0, 0, 0};            // t [m]
};

/// Moments of an element's rest neighbourhood, r_ij = m_j - m_i.
struct RestMoment {
    Symmetric inverse;    // A+, pseudo-inverse of A = sum_j w_ij r_ij r_ij^T [1/m^2]
    Vec3 first{0, 0, 0};  // sum_j w_ij r_ij [m]
    Real trace = 0;       // of A [m^2]
    bool full = true;     // A has rank 3, and P = A A+ is one
};

/// Structure of arrays; element e of every array is element e. Places and vectors are in their body's material frame.
struct Elements {
    // The rest shape; made once.
    std::vector<std::int64_t> id;     // of its particle
    std::vector<std::int32_t> owner;  // index of its SolidBody
    std::vector<Index> law;           // index of its law; empty: its owner's
    std::vector<Quad> rest;  // m [m]; stiffness c of the zero-energy modes [N/m], rewritten when materials change
    std::vector<Real> mass, volume;  // [kg], V at rest [m^3]
    std::vector<Real> support;       // h [m]
    std::vector<Real> depth;         // of the particle below the body's surface, at rest [m]
    std::vector<RestMoment> moment;
    std::vector<Stiffness6>
        anisotropic;  // C of laws that have one, in the material frame [Pa]; rewritten with the laws
    std::vector<std::pair<Index, Symmetric>> flat;  // elements without rank 3, ascending, and their projection P = A A+
    // Neighbours: all j with |r_ij| below the mean of h_i and h_j. Each list is filled up with i itself, of weight 0, to a multiple
    // of kLanes.
    std::vector<std::size_t> begin;  // one more than elements
    std::vector<Index> neighbour;
    std::vector<Real> weight;       // w_ij [1/m^3], of i's own stencil
    std::vector<Real> weight_back;  // w_ji, of j's stencil

    // The state; part of a checkpoint.
    std::vector<Quad> displacement;  // u = x - m; - [m]
    std::vector<Quad> velocity;      // at t - dt/2 between sub-steps; - [m/s]
    std::vector<Vec3> acceleration;  // of the last sub-step [m/s^2]
    std::vector<Symmetric> plastic;  // eps^p [1]

    std::size_t size() const { return id.size(); }
    std::size_t law_of(std::size_t i) const {
        return static_cast<std::size_t>(law.empty() ? static_cast<Index>(owner[i]) : law[i]);
    }
};

/// f(name, array) for the state's arrays.
template <class E, class F>
void for_each_array(E& e, F&& f) requires requires {
    e.displacement;
}
{
    f("solid.displacement", e.displacement);
    f("solid.velocity", e.velocity);
    f("solid.acceleration", e.acceleration);
    f("solid.plastic", e.plastic);
}

inline Vec3 xyz(const Quad& q) { return {q.x, q.y, q.z}; }
inline Quad quad(const Vec3& v, Real w = 0) { return {v.x(), v.y(), v.z(), w}; }

}  // namespace thixo
