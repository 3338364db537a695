// Gates: scenes with probes whose outcome is known, and a record of the measured values for docs/gates.md.
#pragma once

#include <string>
#include <vector>

#include "sim/loop/step.h"
#include "sim/stage/setup.h"

namespace thixo::gate {

/// The values of a scene's probes: one row per frame, in the order of the scene; NaN where a probe had no value.
struct Series {
    std::vector<double> time;  // [s]
    std::vector<std::string> names;
    std::vector<std::vector<double>> rows;
    /// A probe's values by frame. Throws std::out_of_range where the scene has no probe of this name.
    std::vector<double> of(const std::string& name) const;
    double last(const std::string& name) const { return of(name).back(); }
    /// A probe's mean rate of change from row `from` to the last [1/s of its unit].
    double rate(const std::string& name, std::size_t from) const;
};

/// The scene tests/physics/gates/<name>.yaml, with keys changed as by --set.
scene::Scene load(const std::string& name, const std::vector<std::string>& set = {});

/// Simulates a scene to its last frame. `s` is the state there.
Series run(Simulation& s);

/// Steps until `done`, or the scene's last frame.
template <class F>
void step_until(Simulation& s, F&& done) {
    while (s.clock.frame < s.problem.scene.frames.last && !done()) {
        s.clock.next_frame = frame_time(s.problem.scene.frames, s.clock.frame + 1);
        step(s);
        if (s.clock.time >= s.clock.next_frame) ++s.clock.frame;
    }
}

/// One measured law.
struct Outcome {
    std::string law, quantity, unit;
    double measured, reference, tolerance;  // all in `unit`
    std::string source;                     // of the reference: a law, a publication, a need, or kBoundOnChange
};

/// The source of a bound that neither a law nor a need gives. It lies a little above what was measured when the gate
/// was made, and tells only that something has changed.
inline constexpr const char* kBoundOnChange = "bound on change, not a law";

/// Prints measured value, reference and tolerance, writes them to gates/ beside the test programs' folder, and fails
/// the test where |measured - reference| > tolerance. A reference of 0 with a tolerance is an upper bound of the
/// magnitude.
void expect(const Outcome& outcome);
/// Records budgets and figures that are reported without a verdict.
void report(const std::string& law, const std::string& quantity, const std::string& unit, double measured);
/// Reports momentum, angular momentum about the centre of mass, and kinetic energy of all particles. The momenta are
/// relative to those of a body of the same mass, rms radius and rms speed. They are 1 for a body in flight or spin and
/// 0 for matter at rest.
void report_budgets(const std::string& law, const Particles& particles);

}  // namespace thixo::gate
