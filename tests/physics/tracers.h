// Points of matter at a body's surface. They show to which matter a painted place belongs.
#pragma once

#include <vector>

#include "sim/loop/simulation.h"

namespace thixo::gate {

/// Patches of matter at the first surface of a body. A patch has seven tracers: one in the middle of a surfel, and six
/// in a ring of half its radius. They move with the particles alone.
class Tracers {
  public:
    explicit Tracers(const Simulation& s);

    /// Moves the tracers by a first-order fit of the particles' displacement since the last move. Call it after every
    /// step: the tracers move at every fourth step, in which particles move by a hundredth of a spacing.
    void follow(const Simulation& s);

    struct Errors {
        std::vector<double> painted;   // distance from a surfel's m0 to where the matter beneath it was [m], ascending
        std::vector<double> own;       // error of the measure: the same for middles of patches, by the others [m]
        std::vector<double> off_body;  // of a surfel's m0 from the nearest first place of a tracer, of all surfels [m]
        double covered = 0;  // share of surfels with tracers of their side on all sides of them, and in `painted`
    };
    /// The distance of what is painted on surfels from its matter. The first place of the matter at x comes from a
    /// first-order fit along the surface. It takes the first places of the tracers around x whose patch faces the same
    /// way. The fit is exact where matter is stretched and sheared evenly. It knows nothing of surface beyond the
    /// tracers and in folds.
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
