// Gates: scenes with probes whose outcome is known, and the record of what was measured, for docs/gates.md.
#pragma once

#include <string>
#include <vector>

#include "sim/loop/step.h"
#include "sim/stage/setup.h"

namespace thixo::gate {

/// What the probes of a scene gave: a row a frame, in the order of the scene; NaN where a probe had no value.
struct Series {
    std::vector<double> time;  // [s]
    std::vector<std::string> names;
    std::vector<std::vector<double>> rows;
    /// A probe's values by frame. Throws std::out_of_range for a name the scene has not.
    std::vector<double> of(const std::string& name) const;
    double last(const std::string& name) const { return of(name).back(); }
    /// A probe's mean rate of change from row `from` to the last [1/s of its unit].
    double rate(const std::string& name, std::size_t from) const;
};

/// The scene tests/physics/gates/<name>.yaml, with keys changed as by --set.
scene::Scene load(const std::string& name, const std::vector<std::string>& set = {});

/// Simulates a scene to its last frame. `s` is the state there.
Series run(Simulation& s);

/// One measured law.
struct Outcome {
    std::string law, quantity, unit;
    double measured, reference, tolerance;  // all in `unit`
    std::string source;                     // of the reference
};

/// Prints measured value, reference and tolerance, writes them to gates/ beside the test programs' folder, and fails
/// the test where |measured - reference| > tolerance. A reference of 0 with a tolerance is an upper bound of the
/// magnitude.
void expect(const Outcome& outcome);
/// The same without a verdict: budgets and figures that are reported only.
void report(const std::string& law, const std::string& quantity, const std::string& unit, double measured);
/// Momentum, angular momentum about the centre of mass and kinetic energy of all particles as they stand: the momenta
/// beside those of a body of the same mass, rms radius and rms speed (1 for a body in flight or spin, 0 for what stays
/// in place).
void report_budgets(const std::string& law, const Particles& particles);

}  // namespace thixo::gate
