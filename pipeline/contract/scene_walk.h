// Every shape of a scene, at any depth.
#pragma once

#include <string>

#include "pipeline/contract/scene.h"

namespace thixo::scene {

/// f(shape, path) for the shape and all in it; S is Shape or const Shape.
template <class S, class F>
void walk_shape(S& shape, const std::string& path, F&& f) {
    f(shape, path);
    for_each_shape_kind([&]<class K>(const ShapeKind<K>& kind) {
        if constexpr (std::is_base_of_v<ShapeList, K>) {
            auto* list = std::get_if<K>(&shape.kind);
            if (!list) return;
            for (std::size_t k = 0; k < list->shapes.size(); ++k)
                walk_shape(list->shapes[k], path + "." + std::string(kind.name) + ".shapes." + std::to_string(k), f);
        }
    });
}

template <class S, class F>
void walk_shapes(S& scene, F&& f) {
    for (auto& [name, shape] : scene.shapes) walk_shape(shape, "shapes." + name, f);
    for (auto& b : scene.world.boundaries) walk_shape(b.shape, "world.boundaries." + b.name + ".shape", f);
    for (auto& h : scene.world.heat_sources) walk_shape(h.region, "world.heat_sources." + h.name + ".region", f);
    for (auto& m : scene.surface.moulds) walk_shape(m.shape, "surface.moulds." + m.name + ".shape", f);
    for (auto& b : scene.bodies) walk_shape(b.shape, "bodies." + b.name + ".shape", f);
    for (auto& e : scene.emitters) walk_shape(e.shape, "emitters." + e.name + ".shape", f);
    for (auto& h : scene.handles) walk_shape(h.region, "handles." + h.name + ".region", f);
    for (auto& p : scene.probes) walk_shape(p.region, "probes." + p.name + ".region", f);
}

/// Whether a mesh file is among a shape's parts, by name too. The scene's named shapes do not go in circles.
inline bool holds_mesh(const Scene& scene, const Shape& shape) {
    bool found = false;
    walk_shape(shape, "", [&](const Shape& part, const std::string&) {
        found = found || std::holds_alternative<MeshFile>(part.kind);
        const auto* named = std::get_if<NamedShape>(&part.kind);
        for (const auto& [name, of_name] : scene.shapes)
            found = found || (named && name == named->name && holds_mesh(scene, of_name));
    });
    return found;
}

}  // namespace thixo::scene
