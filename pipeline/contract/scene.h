// The scene file in memory. SI units, degrees Celsius, z up. Every key is declared once, beside its struct (scene_key.h
// says how).
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "pipeline/contract/scene_key.h"
#include "pipeline/contract/scene_look.h"
#include "pipeline/contract/scene_probes.h"
#include "pipeline/contract/scene_shapes.h"
#include "pipeline/contract/scene_simulation.h"

namespace thixo::scene {

struct Scene {
    std::string name;
    std::string title;
    Frames frames;
    std::vector<std::pair<std::string, Shape>> shapes;  // named sub-shapes
    World world;
    std::vector<Material> materials;
    std::vector<Body> bodies;
    std::vector<Emitter> emitters;
    std::vector<Handle> handles;
    std::vector<Blade> blades;
    Solver solver;
    Surface surface;
    std::vector<Probe> probes;
    Look look;
    Vec3d origin{0, 0, 0};  // m, the world's place of the scene's zero; no key, see scene_origin.h
};
template <class V>
void visit(V& v, Scene& s) {
    v.group("scene", "what the scene is called", [&](auto& g) {
        g.key("name", s.name, "", any(),
              "letters, digits, _ and -; names the output folder; left out: the file's name");
        g.key("title", s.title, "", any(), "a line for people");
    });
    v.block("frames", s.frames, "which instants become pictures");
    v.block("world", s.world, "gravity and what does not give way");
    v.named_shapes("shapes", s.shapes, "shapes for use in other shapes by `named`");
    v.named("materials", s.materials, "what bodies and emitters are made of");
    v.named("bodies", s.bodies, "matter that is there at the start");
    v.named("emitters", s.emitters, "openings that matter flows out of");
    v.named("handles", s.handles, "what holds, moves or pulls parts of solids");
    v.named("blades", s.blades, "edges that cut solids");
    v.block("solver", s.solver, "how the simulation computes");
    v.block("surface", s.surface, "the surface of surfels around the particles");
    v.named("probes", s.probes, "what is measured at every frame, for probes.csv");
    v.block("look", s.look, "what the renderer reads; a change here never simulates again");
}

}  // namespace thixo::scene
