// Small solid bodies for tests, without a scene around them.
#pragma once

#include <Eigen/Eigenvalues>
#include <cmath>

#include "pipeline/base/random.h"
#include "sim/bonds/rest_shape.h"
#include "sim/solid/elasticity.h"

namespace thixo::fixture {

inline constexpr Real kDistance = Real(0.01);  // between particles

/// A turn about no axis of the blocks.
inline Mat3 turn() { return Eigen::AngleAxis<Real>(Real(1.1), Vec3(1, 2, -1).normalized()).toRotationMatrix(); }

/// A block of nx ny nz particles a distance apart, each shifted at random by up to `jitter` distances.
inline Elements block(int nx, int ny, int nz, Real distance, Real jitter, Real density = 1000) {
    Elements e;
    for (int k = 0; k < nz; ++k)
        for (int j = 0; j < ny; ++j)
            for (int i = 0; i < nx; ++i) {
                const auto id = static_cast<std::uint64_t>(e.size());
                const auto shift = [&](std::uint64_t a) {
                    return jitter * static_cast<Real>(2 * random_unit(7, id, a, 1) - 1);
                };
                e.id.push_back(static_cast<std::int64_t>(id));
                e.owner.push_back(0);
                e.rest.push_back({distance * (Real(i) + shift(0)), distance * (Real(j) + shift(1)),
                                  distance * (Real(k) + shift(2)), 0});
                e.volume.push_back(cube(distance));
                e.quadrature.push_back(cube(distance));
                e.mass.push_back(density * cube(distance));
                e.support.push_back(2 * distance);
                e.depth.push_back(distance / 2);
            }
    const std::size_t n = e.size();
    e.displacement.assign(n, Quad{0, 0, 0, 0});
    e.velocity.assign(n, Quad{0, 0, 0, 0});
    e.acceleration.assign(n, Vec3::Zero());
    e.plastic.assign(n, Symmetric{});
    return e;
}

inline std::vector<SolidBody> one_body(const Elements& e) {
    std::vector<SolidBody> bodies(1);
    for (Index i = 0; i < e.size(); ++i) bodies[0].elements.push_back(i);
    return bodies;
}

/// Neighbours and moments, for a law.
inline Elements prepared(Elements e, const StressLaw& law) {
    find_rest_neighbours(one_body(e), e);
    measure_moments(e);
    set_zero_energy({law}, e);
    return e;
}

/// Displaces every particle to f(m).
template <class F>
void move(Elements& e, F&& f) {
    for (std::size_t i = 0; i < e.size(); ++i) {
        const Vec3 m = xyz(e.rest[i]);
        e.displacement[i] = quad(f(m) - m);
    }
}
/// A smooth deformation with strains of about `size`, plus a random one as large.
inline void shake(Elements& e, Real distance, Real size) {
    move(e, [&](const Vec3& m) {
        const Vec3 q = m / (6 * distance);
        return Vec3(m + size * 3 * distance *
                            Vec3(std::sin(q.y() + 2 * q.z()), std::cos(q.x() - q.z()), std::sin(q.x() + q.y())));
    });
    for (std::size_t i = 0; i < e.size(); ++i)
        for (std::uint64_t a = 0; a < 3; ++a)
            (&e.displacement[i].x)[a] += size * distance * static_cast<Real>(random_unit(3, i, a, 2) - 0.5);
}

/// The energy as elasticity.h states it, neighbour by neighbour with plain matrices: readable, not fast.
inline Real energy(const std::vector<StressLaw>& laws, const Elements& e) {
    Real total = 0;
    for (std::size_t i = 0; i < e.size(); ++i) {
        const StressLaw& law = laws[e.law_of(i)];
        const auto neighbours = [&](auto&& f) {
            for (std::size_t k = e.bonds.begin[i]; k < e.bonds.begin[i + 1]; ++k) {
                const Index j = e.bonds.neighbour[k];
                f(e.bonds.weight[k], Vec3(xyz(e.rest[j]) - xyz(e.rest[i])),
                  Vec3(xyz(e.displacement[j]) - xyz(e.displacement[i])));
            }
        };
        Mat3 a = Mat3::Zero(), b = Mat3::Zero();
        neighbours([&](Real w, const Vec3& r, const Vec3& u) {
            a += w * r * r.transpose();
            b += w * (r + u) * r.transpose();
        });
        const Mat3 inverse = matrix(e.bonds.moment[i].inverse), j = b * inverse;
        Mat3 strain = Real(0.5) * (j.transpose() * j - a * inverse) - matrix(e.plastic[i]);
        if (law.keeps_volume) {  // elasticity refers to the permanent shape
            Eigen::SelfAdjointEigenSolver<Mat3> shape(Mat3::Identity() + 2 * matrix(e.plastic[i]));
            strain = shape.operatorInverseSqrt() * strain * shape.operatorInverseSqrt();
        }
        const Mat3 stress = law.lambda * strain.trace() * Mat3::Identity() + 2 * law.mu * strain;
        total += e.quadrature[i] / 2 * strain.cwiseProduct(stress).sum();
        if (e.bonds.moment[i].full) total += e.quadrature[i] / 2 * law.volume_stiffness * square(j.determinant() - 1);
        if (!(a.trace() > 0)) continue;
        const Real c = law.zero_energy * e.quadrature[i] / a.trace();
        neighbours([&](Real w, const Vec3& r, const Vec3& u) {
            total += c / 2 * w * (r + u - j * r - (r - a * inverse * r)).squaredNorm();
        });
    }
    return total;
}

inline std::vector<Vec3> forces(const StressLaw& law, const Elements& e) {
    StressScratch scratch;
    std::vector<Vec3> force;
    find_stress_forces({law}, e, scratch, force);
    return force;
}

inline StressLaw rubber() {
    const Real modulus = 1e5, nu = Real(0.3);
    return {.lambda = modulus * nu / ((1 + nu) * (1 - 2 * nu)),
            .mu = modulus / (2 * (1 + nu)),
            .zero_energy = modulus / 10};
}

}  // namespace thixo::fixture
