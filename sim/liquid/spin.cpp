#include "sim/liquid/spin.h"

#include <algorithm>

#include "pipeline/base/parallel.h"

namespace thixo {
namespace {

/// Sums over the liquid of a body or emitter, and then its correction.
struct Turn {
    double mass = 0;                                   // [kg]
    Vec3d first = Vec3d::Zero();                       // sum of m x [kg m]
    Mat3d second = Mat3d::Zero();                      // sum of m x x^T [kg m^2]
    Vec3d gained = Vec3d::Zero();                      // angular momentum by the shift [kg m^2/s]
    bool bound = false;                                // it touches a wall
    Vec3d centre = Vec3d::Zero(), by = Vec3d::Zero();  // c [m], w [1/s]

    void add(const Turn& other) {
        mass += other.mass;
        first += other.first;
        second += other.second;
        gained += other.gained;
        bound = bound || other.bound;
    }
    void resolve() {
        if (bound || !(mass > 0) || gained.isZero()) return;
        centre = first / mass;
        const Mat3d about = second - mass * centre * centre.transpose();
        const Mat3d inertia = about.trace() * Mat3d::Identity() - about;
        // A particle by itself, or some in one line, cannot be turned about every axis.
        constexpr double kSlender = 1e-6;
        if (!(inertia.determinant() > kSlender * cube(about.trace()))) return;
        by = -inertia.inverse() * gained;
    }
};

}  // namespace

void keep_spin(const std::vector<WallEffect>& walls, const std::vector<Vec3>& shift, Particles& particles) {
    const std::size_t n = particles.size();
    if (n == 0) return;
    const auto group = [&](std::size_t i) { return static_cast<std::size_t>(particles.body[i]); };
    const std::size_t groups = static_cast<std::size_t>(std::ranges::max(particles.body)) + 1;
    constexpr std::size_t kChunk = 4096;
    std::vector<std::vector<Turn>> parts((n + kChunk - 1) / kChunk, std::vector<Turn>(groups));
    parallel_chunks(
        n,
        [&](std::size_t begin, std::size_t end, std::size_t chunk) {
            for (std::size_t i = begin; i < end; ++i) {
                Turn& sum = parts[chunk][group(i)];
                const double m = static_cast<double>(particles.mass[i]);
                const Vec3d dx = shift[i].cast<double>(), x = particles.position[i].cast<double>() + dx;
                sum.mass += m;
                sum.first += m * x;
                sum.second += m * x * x.transpose();
                sum.gained += m * dx.cross(particles.velocity[i].cast<double>());
                sum.bound = sum.bound || walls[i].share > 0;
            }
        },
        kChunk);
    std::vector<Turn> turns(groups);
    for (const auto& part : parts)
        for (std::size_t g = 0; g < groups; ++g) turns[g].add(part[g]);
    for (Turn& turn : turns) turn.resolve();
    if (std::ranges::all_of(turns, [](const Turn& t) { return t.by.isZero(); })) return;
    parallel_for(
        n,
        [&](std::size_t i) {
            const Turn& turn = turns[group(i)];
            const Vec3d y = particles.position[i].cast<double>() + shift[i].cast<double>() - turn.centre;
            particles.velocity[i] += turn.by.cross(y).cast<Real>();
        },
        kChunk);
}

}  // namespace thixo
