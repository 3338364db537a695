// Points of matter at a body's surface, that tell where what is painted there belongs.
#pragma once

#include <vector>

#include "sim/loop/simulation.h"

namespace thixo::gate {

/// Patches of matter at the surface that a body has at first, seven tracers each: one in the middle of a surfel, six in
/// a ring of half its radius. They go with the particles and with nothing else.
class Tracers {
  public:
    explicit Tracers(const Simulation& s);

    /// Moves them by a first-order fit of the particles' displacement since the last time. To be called after every
    /// step: they are moved every fourth, in which particles move by a hundredth of a spacing.
    void follow(const Simulation& s);

    struct Errors {
        std::vector<double> painted;   // distance from a surfel's m0 to where the matter beneath it was [m], ascending
        std::vector<double> own;       // the same of the middles of patches, told by the others: the measure's own [m]
        std::vector<double> off_body;  // of a surfel's m0 from the nearest first place of a tracer, of all surfels [m]
        double covered = 0;  // share of surfels with tracers of their side on all sides of them, and in `painted`
    };
    /// How far what is painted on surfels is from its matter. What was first at x is told by a first-order fit, along
    /// the surface, of the first places of the tracers about x whose patch faces the same way: exact where matter is
    /// stretched and sheared evenly. Surface that has grown past the tracers, and what is pressed into a fold, is not
    /// told.
    Errors errors(const Simulation& s) const;

  private:
    static constexpr Index kPatch = 7;
    struct Matter;
    std::vector<Vec3> first_, place_;
    std::vector<Vec3> before_;  // of the particles, by id
    int calls_ = 0;
    void note(const Simulation& s);
};

}  // namespace thixo::gate
