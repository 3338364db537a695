// What a cache and a picture depend on, as hashes of the scene.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "pipeline/contract/scene.h"

namespace thixo::scene {

/// Hash of every key the simulation's result depends on, mesh contents included. Not in it: name and title, frames.last
/// (a larger one continues), solver.checkpoint_every, the look, and where mesh files lie.
std::string simulation_hash(const Scene& scene);

/// Every key of the look with its value as text, image contents included. Not in it: output.film, which changes no
/// picture, and where image files lie.
std::vector<std::pair<std::string, std::string>> look_lines(const Look& look);
/// Their hash.
std::string look_hash(const Look& look);

/// Key paths (such as materials.water.viscosity) that simulation_hash depends on and that differ between the scenes. A
/// key that only one scene has differs too. They come in the order of the scene file. None where the hashes are equal.
std::vector<std::string> differing_keys(const Scene& a, const Scene& b);

}  // namespace thixo::scene
