#include "sim/heat/heat.h"

#include <algorithm>
#include <cmath>

#include "pipeline/base/error.h"
#include "pipeline/base/parallel.h"
#include "pipeline/geometry/power_of_two.h"
#include "sim/space/scene_shapes.h"

namespace thixo {

double enthalpy(double temperature, const scene::Thermal& m) {
    const double melted =
        m.liquidus > m.solidus ? std::clamp((temperature - m.solidus) / (m.liquidus - m.solidus), 0.0, 1.0) : 0.0;
    return m.heat_capacity * temperature + m.latent_heat * melted;
}

double temperature_of(double heat, const scene::Thermal& m) {
    const double c = m.heat_capacity, below = c * m.solidus;
    if (m.latent_heat <= 0 || heat <= below) return heat / c;
    const double above = c * m.liquidus + m.latent_heat;
    if (heat >= above) return (heat - m.latent_heat) / c;
    return m.solidus + (heat - below) / (above - below) * (m.liquidus - m.solidus);
}

Real wall_conduction(Real distance, Real support, Real least) {
    // The Laplacian of the viscosity kernel, integrated over the plane at z = q h, is
    //     90/h^3 (1/6 - q^2/2 + q^3/3)
    // Its first moment beyond q is below.
    const Real q = clamp01(distance / support);
    const Real moment = 90 / support * (Real(0.025) - q * q * (Real(1.0 / 12) - q * q * (Real(0.125) - q / 15)));
    return std::max(moment, Real(0)) / std::max(distance, least);
}

HeatDrive make_heat(const scene::Scene& scene, const Materials& materials) {
    HeatDrive heat;
    for (std::size_t k = 0; k < materials.size(); ++k) {
        const ResolvedMaterial& m = materials[k];
        const double diffusivity = m.thermal.conductivity / (static_cast<double>(m.density) * m.thermal.heat_capacity);
        if (diffusivity <= heat.fastest) continue;
        heat.fastest = diffusivity;
        heat.fastest_material = scene.materials[k].name;
    }
    for (const scene::HeatSource& source : scene.world.heat_sources)
        heat.sources.push_back({make_shape(scene, source.region), source.power, source.from, source.to});
    return heat;
}

namespace {

constexpr double kMostSteps = 1e6;  // of conduction within one step of the simulation
// The largest sum of the Laplacian over a packing with a wall at half a layer, times h^2. The factor kRoom allows for
// particles that are closer than the packing.
constexpr double kMostNeighbours = 15 + 7, kRoom = 1.5;

int stable_steps(const Materials& materials, const HeatDrive& drive, Real support, double dt) {
    const double unlike = materials.size() > 1 ? 2 : 1;  // k_ij is at most twice the smaller
    const double rate = unlike * drive.fastest * kMostNeighbours * kRoom / square(static_cast<double>(support));
    if (!(rate * dt <= kMostSteps))
        throw InputError(
            "materials.{}: heat spreads too fast for explicit steps: one of {:.3g} s would take {:.3g}; lower the "
            "conductivity, raise heat_capacity or solver.spacing",
            drive.fastest_material, dt, std::ceil(rate * dt));
    return std::max(1, static_cast<int>(std::ceil(rate * dt)));
}

class Conduction {
  public:
    Conduction(Particles& particles, const SweepInput& input, const HeatPaths& paths, HeatScratch& scratch)
        : p_(particles),
          neighbours_(input.neighbours),
          walls_(input.walls),
          smoothing_(input.smoothing),
          paths_(paths),
          sweep_(input.sweep),
          per_volume_(1 / cube(power_of_two_below(input.smoothing.support))),
          laplacian_(2 * input.smoothing.viscosity.laplacian_scale / square(per_volume_)),
          s_(scratch) {
        const Sweep& sweep = input.sweep;
        resize_packed(sweep.ghosts, s_.place, Quad{Real(1e9), Real(1e9), Real(1e9), 0});
        resize_packed(sweep.ghosts, s_.matter, Quad{0, 0, 0, 0});
        s_.gain.resize(p_.size());
        parallel_for(p_.size(), [&](std::size_t i) {
            const Vec3& x = p_.position[i];
            s_.place[i] = {x.x(), x.y(), x.z(), 0};
            s_.matter[i] = {static_cast<Real>(material(i).conductivity), sweep.motion[i].w * per_volume_, 0, 0};
        });
        refresh_places(sweep.ghosts, s_.place);
        refresh_ghosts(sweep.ghosts, s_.matter);
    }

    void step(double t, double dt) {
        set_temperatures();
        parallel_chunks(p_.size(), [&](std::size_t begin, std::size_t end, std::size_t) {
            WallCursor cursor(walls_);
            for (std::size_t i = begin; i < end; ++i)
                s_.gain[i] = from_neighbours(i) + from_walls(i, cursor) + from_sources(i, t);
        });
        for (const ScreenedPair& pair : paths_.screened) {
            const double flux = static_cast<double>(pair.part) * flux_between(pair.first, pair.second);
            s_.gain[pair.first] -= flux;
            s_.gain[pair.second] += flux;
        }
        parallel_for(p_.size(), [&](std::size_t i) {
            const double heat =
                enthalpy(p_.temperature[i], material(i)) + dt * s_.gain[i] / static_cast<double>(p_.mass[i]);
            p_.temperature[i] = temperature_of(heat, material(i));
        });
    }

  private:
    const scene::Thermal& material(std::size_t i) const {
        return paths_.materials[static_cast<std::size_t>(p_.material[i])].thermal;
    }

    void set_temperatures() {
        parallel_for(
            p_.size(), [&](std::size_t i) { s_.place[i].w = static_cast<Real>(p_.temperature[i]); }, 4096);
        const Ghosts& ghosts = sweep_.ghosts;
        for (std::size_t g = 0; g < ghosts.size(); ++g) s_.place[ghosts.particles + g].w = s_.place[ghosts.source[g]].w;
    }

    double from_neighbours(std::size_t i) const {
        const Quad at = s_.place[i], own = s_.matter[i];
        if (own.x <= 0) return 0;
        Lanes sum{};
        for_each_run(neighbours_[i], sweep_.nobody(), [&](const Index* j) {
            Lanes x, y, z, t, k, volume, unused;
            gather(s_.place.data(), j, x, y, z, t);
            gather(s_.matter.data(), j, k, volume, unused, unused);
            x = at.x - x;
            y = at.y - y;
            z = at.z - z;
            const Lanes q = positive(1 - root(x * x + y * y + z * z) * smoothing_.pressure.h_inv);
            sum += own.x * k / (own.x + k) * (own.y * volume) * q * (t - at.w);
        });
        return static_cast<double>(laplacian_ * sum_of(sum));
    }

    /// What flows from particle j to particle i [W].
    double flux_between(Index i, Index j) const {
        const Quad a = s_.matter[i], b = s_.matter[j];
        if (a.x <= 0 || b.x <= 0) return 0;
        const Real r = (p_.position[i] - p_.position[j]).norm();
        const Real q = std::max(1 - r * smoothing_.pressure.h_inv, Real(0));
        const Real k = a.x * b.x / (a.x + b.x) * a.y * b.y;
        return static_cast<double>(laplacian_ * k * q) * (p_.temperature[j] - p_.temperature[i]);
    }

    double from_walls(std::size_t i, WallCursor& cursor) const {
        if (sweep_.walls[i].distance >= smoothing_.support || s_.matter[i].x <= 0) return 0;
        double sum = 0;
        for (std::size_t k = 0; k < walls_.list.size(); ++k) {
            const Wall& wall = walls_.list[k];
            if (!wall.temperature) continue;
            Vec3 normal;
            const Real d = wall.map.distance(wall.to_wall(p_.position[i]), normal, cursor.at[k]);
            if (d >= smoothing_.support) continue;
            const Real a = wall_conduction(d, smoothing_.support, smoothing_.spacing / 4);
            sum += static_cast<double>(a) * (*wall.temperature - p_.temperature[i]);
        }
        return static_cast<double>(s_.matter[i].x * (s_.matter[i].y / per_volume_)) * sum;
    }

    double from_sources(std::size_t i, double t) const {
        double sum = 0;
        for (const HeatSourceRegion& source : paths_.drive.sources)
            if (t >= source.from && t < source.to && source.region.distance(p_.position[i]) <= 0)
                sum += source.power * static_cast<double>(p_.rest_volume[i]);
        return sum;
    }

    Particles& p_;
    const NeighbourLists& neighbours_;
    const Walls& walls_;
    const Smoothing& smoothing_;
    const HeatPaths& paths_;
    const Sweep& sweep_;
    // Volumes are in units of a power of two near h^3, as in the solve of viscosity: products of two stay in range.
    Real per_volume_;
    Real laplacian_;  // twice the scale of the Laplacian, for these volumes
    HeatScratch& s_;
};

}  // namespace

int conduct_heat(Particles& particles, const SweepInput& input, const HeatPaths& paths, double t, double dt,
                 HeatScratch& scratch) {
    if (!paths.drive.any() || particles.size() == 0) return 0;
    const int steps = stable_steps(paths.materials, paths.drive, input.smoothing.support, dt);
    Conduction conduction(particles, input, paths, scratch);
    for (int k = 0; k < steps; ++k) conduction.step(t + k * dt / steps, dt / steps);
    return steps;
}

}  // namespace thixo
