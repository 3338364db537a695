#include "sim/tension.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "pipeline/base/parallel.h"
#include "sim/sampling.h"

namespace thixo {
namespace {

/// sum_j q_j grad w(r_ij): the pull of the neighbours on particle i over its own charge.
Vec3 pull_of_neighbours(std::size_t i, std::span<const Index> neighbours, const Sweep& sweep, const CohesionKernel& kernel,
                        const std::vector<Real>& charge) {
    const Quad at = sweep.place[i];
    Lanes fx{}, fy{}, fz{};
    for_each_run(neighbours, sweep.nobody(), [&](const Index* j) {
        Lanes x, y, z, unused, q;
        gather(sweep.place.data(), j, x, y, z, unused);
        for (std::size_t l = 0; l < kLanes; ++l) q[l] = charge[j[l]];
        x -= at.x;
        y -= at.y;
        z -= at.z;
        const Lanes s = root(x * x + y * y + z * z) * kernel.h_inv, near = positive(1 - s);
        const Lanes along = near > 0 ? kernel.slope * q * (s * s) * (near * near * near) : Lanes{};
        fx += along * x;
        fy += along * y;
        fz += along * z;
    });
    return {sum_of(fx), sum_of(fy), sum_of(fz)};
}

/// sum over walls of b integral of grad w_spiky.
Vec3 pull_of_walls(const Walls& walls, const Vec3& x, WallCursor& cursor) {
    Vec3 sum(0, 0, 0);
    for (std::size_t k = 0; k < walls.list.size(); ++k) {
        const Wall& w = walls.list[k];
        if (w.adhesion > 0) sum += w.adhesion * (w.turn * w.map.at(w.to_wall(x), cursor.at[k]).gradient);
    }
    return sum;
}

}  // namespace

Real packed_tension(const Smoothing& smoothing) {
    // A pair whose distance along the normal is n layers is cut by n of the planes between layers: summed over the
    // pairs of one site this is the energy of one site's area, counted from both ends.
    const CohesionKernel kernel(smoothing.support);
    const double d = smoothing.spacing, layer = packing_layer(smoothing.spacing);
    const int reach = 2 * (static_cast<int>(smoothing.support / packing_distance(smoothing.spacing)) + 2);
    double sum = 0;
    for (int k = -reach; k <= reach; ++k)
        for (int j = -reach; j <= reach; ++j)
            for (int i = -reach; i <= reach; ++i) {
                const Vec3 x = packing_site(i, j, k, smoothing.spacing);
                sum += static_cast<double>(kernel.value(x.norm())) * std::abs(k);
            }
    return static_cast<Real>(0.25 * sum * cube(d) * layer);
}

Real attraction_for(Real surface_tension, Real density, const Smoothing& smoothing) {
    return surface_tension / (square(density) * packed_tension(smoothing));
}

Real packed_adhesion(const Smoothing& smoothing) {
    // Integral of w_spiky over the half-space beyond the distance z: over planes 30/h (p^4/4 - p^5/5) with p = 1 - z/h,
    // and over depth 30 (p^5/20 - p^6/30).
    const double layer = packing_layer(smoothing.spacing), h = smoothing.support;
    double work = 0;
    for (double z = layer / 2; z < h; z += layer) {
        const double p = 1 - z / h;
        work += layer * 30 * (std::pow(p, 5) / 20 - std::pow(p, 6) / 30);
    }
    return static_cast<Real>(2 * static_cast<double>(packed_tension(smoothing)) / work);
}

void add_tension(Particles& particles, const NeighbourLists& neighbours, const Walls& walls, const Smoothing& smoothing,
                 const std::vector<MaterialParams>& materials, const Sweep& sweep, TensionScratch& scratch) {
    if (std::ranges::all_of(materials, [](const MaterialParams& m) { return m.attraction <= 0; })) return;
    const bool wet = std::ranges::any_of(walls.list, [](const Wall& w) { return w.adhesion > 0; });
    const CohesionKernel kernel(smoothing.support);
    const Real adhesion = packed_adhesion(smoothing);
    const auto material = [&](std::size_t i) { return materials[static_cast<std::size_t>(particles.material[i])]; };
    resize_packed(sweep.ghosts, scratch.charge, Real(0));
    parallel_for(
        particles.size(),
        [&](std::size_t i) {
            scratch.charge[i] = std::sqrt(particles.melt[i] * material(i).attraction) * particles.mass[i];
        },
        2048);
    refresh_ghosts(sweep.ghosts, scratch.charge);
    parallel_chunks(
        particles.size(),
        [&](std::size_t begin, std::size_t end, std::size_t) {
            WallCursor cursor(walls);
            for (std::size_t i = begin; i < end; ++i) {
                const Real root_k = scratch.charge[i] / particles.mass[i];
                Vec3 pull = pull_of_neighbours(i, neighbours[i], sweep, kernel, scratch.charge);
                if (wet && sweep.walls[i].share > 0)
                    pull += root_k * material(i).density * adhesion *
                            pull_of_walls(walls, particles.position[i], cursor);
                particles.acceleration[i] += root_k * pull;
            }
        },
        256);
}

}  // namespace thixo
