// What a run could not do of what its scene says: the list at its end, in frame.NNNN.json and in `thixo info`.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace thixo {

/// Kinds of shortfall, and what `count`, `of` and `worst` of each mean.
enum class Lack {
    blocked,    ///< of an emitter: particles that found no place, since the start; of: all that were due
    cut_off,    ///< of a solver: solves that ended before they reached their tolerance; of: all solves
    passed,     ///< particles that a step carried through a wall
    inside,     ///< particles deeper than half a spacing inside a wall; of: all particles
    crushed,    ///< of a solid: particles below half their volume, or turned inside out; of: all of the body
    runaway,    ///< surfels of liquids on walls, more than kMostSurfels a particle; of: the particles there
    long_step,  ///< fixed steps above the limit that is named; of: all steps; worst: step over limit
    energy,     ///< worst: energy that motion gained from nowhere [J]; count: frames that show it
};
inline constexpr std::array<std::string_view, 8> kLackWords{"blocked", "cut_off", "passed",    "inside",
                                                            "crushed", "runaway", "long_step", "energy"};
inline constexpr double kMostSurfels = 10;  // a particle; a smooth liquid has one in five particles

struct Shortfall {
    Lack lack = Lack::blocked;
    std::string name;  // of the emitter, body, solver or limit; empty: of the whole
    std::int64_t count = 0, of = 0;
    double worst = 0;

    bool operator==(const Shortfall&) const = default;
};

/// What a frame's list adds to that of the frames before it. Counts of what happened in a frame's steps (cut_off,
/// passed, long_step) add up; of what a state shows the largest is kept. `list` stays in the order of kind and name.
void merge_shortfalls(const std::vector<Shortfall>& frame, std::vector<Shortfall>& list);

/// One sentence: what, how much, and the cure.
std::string shortfall_text(const Shortfall& shortfall);

}  // namespace thixo
