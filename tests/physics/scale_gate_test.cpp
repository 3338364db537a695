// Laws that hold at any size.
#include <fmt/core.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/physics/gate.h"

namespace thixo {
namespace {

/// The dam of a column of width `size` [m], by `across` spacings, in steps of `cfl` spacings. By Froude's law every
/// place is in proportion to the size, and every time to its square root.
gate::Series dam(double size, double across, double cfl) {
    scene::Scene scene = gate::load("dam_of_any_size");
    const double slower = std::sqrt(size);
    scene.frames.fps /= slower;
    // The slab holds two supports, of two spacings each.
    const double wide = std::max(1.0, 16 / across);
    for (scene::PeriodicAxis& p : scene.world.periodic) p.from *= wide * size, p.to *= wide * size;
    scene::Shape& shape = scene.bodies[0].shape;
    std::get<scene::BoxShape>(shape.kind).size *= size;
    std::get<scene::BoxShape>(shape.kind).size.y() *= wide;
    shape.translate *= size;
    scene.solver.spacing = size / across;
    scene.solver.time_step.cfl = cfl;
    scene.solver.time_step.maximum = std::min(1.0, slower * scene.solver.time_step.maximum);
    Simulation s = make_simulation(scene);
    gate::Series series = gate::run(s);
    for (std::vector<double>& row : series.rows)
        for (double& value : row) value /= size;
    return series;
}

double largest_difference(const gate::Series& a, const gate::Series& b, const std::string& probe) {
    const std::vector<double> of_a = a.of(probe), of_b = b.of(probe);
    double most = 0;
    for (std::size_t k = 0; k < of_a.size(); ++k) most = std::max(most, std::abs(of_a[k] - of_b[k]));
    return most;
}

TEST(Dam, CollapsesAlikeAtAnySize) {
    // From the finest spacing that a scene may have, a micrometre, to a hundred kilometres. Rounding differs, and a
    // splash multiplies it. The front is where a few particles are: it is held to a spacing. The centre of mass is held
    // to a hundredth.
    struct Case {
        double across, cfl;
    };
    for (const Case& c : {Case{16, 0.4}, Case{16, 0.2}, Case{8, 0.4}}) {
        const gate::Series metre = dam(1, c.across, c.cfl);
        for (const double spacing : {1.0001e-6, 1.25e-5, 1e5}) {
            const gate::Series other = dam(spacing * c.across, c.across, c.cfl);
            const std::string law = fmt::format("dam, spacing {:g} m, {} across, cfl {}", spacing, c.across, c.cfl);
            gate::expect({law, "front against that of 1 m", "L", largest_difference(metre, other, "front"), 0,
                          1 / c.across, "Froude; a spacing"});
            gate::expect({law, "mean place against that of 1 m", "L",
                          std::max(largest_difference(metre, other, "x"), largest_difference(metre, other, "z")), 0,
                          0.01, "Froude"});
        }
    }
}

}  // namespace
}  // namespace thixo
