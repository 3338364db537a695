// Heat: what materials and boundaries say about it, and where it is made.
#pragma once

#include <string>

#include "pipeline/contract/scene_key.h"
#include "pipeline/contract/scene_shapes.h"

namespace thixo::scene {

struct Thermal {
    double conductivity = 0;           // W/(m K)
    double heat_capacity = 4180;       // J/(kg K)
    double latent_heat = 0;            // J/kg, taken up between solidus and liquidus
    double solidus = 0, liquidus = 0;  // degC
};
template <class V>
void visit(V& v, Thermal& t) {
    v.key("conductivity", t.conductivity, "W/(m K)", between(0, 1e9), "heat conductivity; water 0.6; 0: no heat flows");
    v.key("heat_capacity", t.heat_capacity, "J/(kg K)", above_to(0, 1e9), "specific heat");
    v.key("latent_heat", t.latent_heat, "J/kg", between(0, 1e12),
          "heat taken up by melting, evenly from `solidus` to `liquidus`; water 334000");
    v.key("solidus", t.solidus, "degC", between(-273.15, 1e5), "temperature at which melting begins");
    v.key("liquidus", t.liquidus, "degC", between(-273.15, 1e5), "temperature at which it ends");
}

struct HeatSource {
    std::string name;
    Shape region;
    double power = 0;           // W/m^3 of matter at rest density
    double from = 0, to = 1e9;  // s
};
template <class V>
void visit(V& v, HeatSource& s) {
    v.shape("region", s.region, required(), "heats matter in this shape");
    v.key("power", s.power, "W/m^3", required(between(-1e15, 1e15)),
          "heat made in matter at rest density; negative: cools");
    v.key("from", s.from, "s", between(0, 1e9), "when it is turned on");
    v.key("to", s.to, "s", between(0, 1e9), "when it is turned off");
}

}  // namespace thixo::scene
