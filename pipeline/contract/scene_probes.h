// What the simulation measures while it runs: the scene file's block `probes`.
#pragma once

#include <string>

#include "pipeline/base/math.h"
#include "pipeline/contract/scene_key.h"
#include "pipeline/contract/scene_shapes.h"

namespace thixo::scene {

enum class Measure { point, mean, total, extent, flux };
template <>
struct Words<Measure> {
    static constexpr std::array<std::string_view, 5> list{"point", "mean", "total", "extent", "flux"};
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
    z
};
template <>
struct Words<Quantity> {
    static constexpr std::array<std::string_view, 13> list{"one",   "volume", "density",    "pressure",   "temperature",
                                                           "speed", "energy", "velocity_x", "velocity_y", "velocity_z",
                                                           "x",     "y",      "z"};
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
          "frame before");
    v.key("quantity", p.quantity, "", any(),
          "one: 1 (its total is the mass); volume: 1/density at rest [m^3/kg]; density [kg/m^3]; pressure [Pa]; "
          "temperature [degC]; "
          "speed and velocity [m/s]; energy: kinetic [J/kg]; x, y, z: position [m]. A total is summed over mass: of "
          "velocity, momentum");
    v.reference("material", p.material, Refers::material, any(), "counts this material only; left out: all");
    v.shape("region", p.region, any(),
            "mean, total, extent: counts particles in this shape only; left out: everywhere");
    v.key("position", p.position, "m", any(), "point: where; flux: centre of the disc");
    v.key("direction", p.direction, "", direction(),
          "extent: which way; flux: the side that counts as forward. Any length");
    v.key("radius", p.radius, "m", above(0), "flux: radius of the disc");
    v.key("quantile", p.quantile, "1", between(0, 1),
          "extent: share of the mass that reaches less far; 1: the farthest particle, 0: the nearest");
}

}  // namespace thixo::scene
