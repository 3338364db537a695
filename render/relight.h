// A finished picture under the same lights with other strengths and colours: its light groups mixed anew.
#pragma once

#include <map>
#include <set>
#include <string>

#include "pipeline/contract/image.h"
#include "pipeline/contract/scene.h"

namespace thixo::render {

/// What the light of a picture depends on, as JSON (docs/cache_format.md). It has the light groups with what gives their
/// light, and all other keys of the look.
std::string light_record(const scene::Scene& scene, std::uint64_t seed);

struct Relighting {
    std::string reason;                   // why the picture has to be rendered; empty: it need not be
    std::map<std::string, Vec3d> factor;  // of each light group
    std::set<std::string> gone;           // groups of which the other look has nothing
    /// True where no light has changed: the picture has its colours already.
    bool is_same() const;
};

/// From the records of a picture and of the look that it shall have. Light is linear in the strength times the colour of
/// its source. A group can be mixed where all its lights change by one factor.
Relighting relighting(const std::string& stored, const std::string& wanted);

bool has_light_groups(const Image& image);

/// The colours become the sum of the light groups times their factors, and the groups follow. What is no longer true of
/// the picture is left out: `noisy`, `variance` and groups that are gone. Throws CacheError where it lacks a group.
Image relit(Image image, const Relighting& mix);

}  // namespace thixo::render
