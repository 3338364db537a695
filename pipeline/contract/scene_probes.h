// What the simulation measures while it runs: the scene file's block `probes`.
#pragma once

#include <string>

#include "pipeline/base/math.h"
#include "pipeline/contract/scene_key.h"
#include "pipeline/contract/scene_shapes.h"

namespace thixo::scene {

enum class Measure { point, mean, total, extent, flux, follow, wall_force, wall_pressure, bodies, crack_area, fronts };
template <>
struct Words<Measure> {
    static constexpr std::array<std::string_view, 11> list{"point",  "mean",       "total",      "extent",
                                                           "flux",   "follow",     "wall_force", "wall_pressure",
                                                           "bodies", "crack_area", "fronts"};
};

enum class Quantity {
    one,
    volume,
    density,
    pressure,
    temperature,
    speed,
    energy,
    velocity_x,
    velocity_y,
    velocity_z,
    x,
    y,
    z,
    angular_x,
    angular_y,
    angular_z,
    elastic_energy
};
template <>
struct Words<Quantity> {
    static constexpr std::array<std::string_view, 17> list{
        "one",        "volume",     "density",       "pressure", "temperature", "speed", "energy",
        "velocity_x", "velocity_y", "velocity_z",    "x",        "y",           "z",     "angular_x",
        "angular_y",  "angular_z",  "elastic_energy"};
};

struct Probe {
    std::string name;
    Measure measure = Measure::mean;
    Quantity quantity = Quantity::one;
    std::string material;     // empty: all
    Shape region;             // no kind: everywhere
    Vec3d position{0, 0, 0};  // m
    Vec3d direction{0, 0, 1};
    double radius = 1e9;  // m
    double quantile = 1;  // 1
};
template <class V>
void visit(V& v, Probe& p) {
    v.key("measure", p.measure, "", required(),
          "point: `quantity` at `position`, interpolated; mean, total: of `quantity` over the mass in `region`; "
          "extent: how far "
          "particle centres reach along `direction` [m]; flux: mass a second through a disc [kg/s], mean since the "
          "frame before; follow: `quantity` of the particle that was nearest to `position` at the start. wall_force: "
          "with which liquids in `region` press on walls along `direction`, without drag [N]; wall_pressure: the same "
          "over a disc on a wall [Pa]; both are means since the frame before. bodies: "
          "number of "
          "pieces of solid matter; crack_area: of all cracks within bodies [m^2]; fronts: number of fronts of cracks");
    v.key("quantity", p.quantity, "", any(),
          "one: 1 (its total is the mass); volume: 1/density at rest [m^3/kg]; density [kg/m^3]; pressure [Pa]; "
          "temperature [degC]; "
          "speed and velocity [m/s]; energy: kinetic [J/kg]; x, y, z: position [m]. angular: (x - "
          "position) x velocity [m^2/s]; elastic_energy: of solids [J/kg]. A total is summed over mass: of velocity, "
          "momentum");
    v.reference("material", p.material, Refers::material, any(), "counts this material only; left out: all");
    v.shape("region", p.region, any(),
            "mean, total, extent, follow, wall_force: counts particles in this shape only; left out: everywhere");
    v.key("position", p.position, "m", any(), "point, follow, angular: where; flux, wall_pressure: centre of the disc");
    v.key("direction", p.direction, "", direction(),
          "extent: which way; flux: the side that counts as forward; "
          "wall_force: which component; wall_pressure: out of the wall. Any length");
    v.key("radius", p.radius, "m", above(0), "flux, wall_pressure: radius of the disc");
    v.key("quantile", p.quantile, "1", between(0, 1),
          "extent: share of the mass that reaches less far; 1: the farthest particle, 0: the nearest");
}

}  // namespace thixo::scene
