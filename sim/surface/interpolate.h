// Interpolation of particles' attributes at places among them.
#pragma once

#include "pipeline/base/parallel.h"
#include "pipeline/geometry/kernels.h"
#include "pipeline/geometry/point_grid.h"
#include "sim/state/particle_rows.h"

namespace thixo {

/// Calls act(i, A(x_i)) for every place x_i with particles of its own in reach, in parallel. A is the normalised
/// interpolation (dissertation 2.24)
///     A(x) = sum_j V0_j A_j w_poly6(x - x_j, h) / sum_j V0_j w_poly6(x - x_j, h)
/// over the particles j with own(i, j), A_j = value(j); j is a row of the table. Sums are in double: temperatures change slowly. `support` h
/// [m].
template <class Own, class Value, class Act>
void interpolate(const std::vector<Vec3>& places, const ParticleRows& particles, Real support, Own&& own, Value&& value,
                 Act&& act) {
    PointGrid grid;
    std::vector<Vec3> scratch;
    grid.build(particles.values(particles.table().position, scratch), support);
    const Poly6 w(support);
    parallel_for(places.size(), [&](std::size_t i) {
        double weight = 0, sum = 0;
        grid.for_each_neighbour(places[i], support, [&](Index member, Real r2) {
            const Index j = particles.row(member);
            if (!own(i, j)) return;
            const double a = static_cast<double>(particles.table().rest_volume[j] * w.value(r2));
            weight += a;
            sum += a * static_cast<double>(value(j));
        });
        if (weight > 0) act(i, sum / weight);
    });
}

}  // namespace thixo
