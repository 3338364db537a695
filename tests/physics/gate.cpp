#include "tests/physics/gate.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>

#include "pipeline/contract/scene_io.h"
#include "sim/stage/probes.h"

namespace thixo::gate {
namespace {

namespace fs = std::filesystem;

/// Writes a tab-separated line to a file of the running test, because tests run side by side.
void record(const std::string& line) {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    const fs::path folder = fs::path(THIXO_BIN_DIR) / ".." / "gates";
    fs::create_directories(folder);
    const fs::path file = folder / fmt::format("{}.{}.tsv", test->test_suite_name(), test->name());
    static std::string begun;  // this process's file: its first line replaces that of an earlier run
    std::ofstream out(file, begun == file.string() ? std::ios::app : std::ios::trunc);
    begun = file.string();
    out << line << '\n';
}

}  // namespace

std::vector<double> Series::of(const std::string& name) const {
    for (std::size_t k = 0; k < names.size(); ++k) {
        if (names[k] != name) continue;
        std::vector<double> column;
        for (const std::vector<double>& row : rows) column.push_back(row[k]);
        return column;
    }
    throw std::out_of_range("no probe " + name);
}

double Series::rate(const std::string& name, std::size_t from) const {
    const std::vector<double> values = of(name);
    return (values.back() - values.at(from)) / (time.back() - time.at(from));
}

scene::Scene load(const std::string& name, const std::vector<std::string>& set) {
    return scene::load_scene(fmt::format("{}/tests/physics/gates/{}.yaml", THIXO_SOURCE_DIR, name), set, false);
}

Series run(Simulation& s) {
    Series series;
    for (const scene::Probe& p : s.problem.scene.probes) series.names.push_back(p.name);
    const auto note = [&] {
        series.time.push_back(s.clock.time);
        auto& row = series.rows.emplace_back();
        for (const std::optional<double>& value : measure(s))
            row.push_back(value.value_or(std::numeric_limits<double>::quiet_NaN()));
    };
    evaluate(s);
    note();
    while (s.clock.frame < s.problem.scene.frames.last) {
        advance_frame(s);
        note();
    }
    return series;
}

void expect(const Outcome& o) {
    const bool good = std::abs(o.measured - o.reference) <= o.tolerance;
    fmt::print("[ gate     ] {}: {} = {:.6g} {}, reference {:.6g}, tolerance {:.3g} ({}){}\n", o.law, o.quantity,
               o.measured, o.unit, o.reference, o.tolerance, o.source, good ? "" : " MISSED");
    record(fmt::format("{}\t{}\t{}\t{:.4g}\t{:.4g}\t{:.3g}\t{}", o.law, o.quantity, o.unit, o.measured, o.reference,
                       o.tolerance, o.source));
    EXPECT_TRUE(good) << o.law << ": " << o.quantity;
}

void report(const std::string& law, const std::string& quantity, const std::string& unit, double measured) {
    fmt::print("[ gate     ] {}: {} = {:.6g} {}\n", law, quantity, measured, unit);
    record(fmt::format("{}\t{}\t{}\t{:.4g}\t\t\t", law, quantity, unit, measured));
}

void report_budgets(const std::string& law, const Particles& p) {
    double mass = 0, kinetic = 0, inertia = 0;
    Vec3d momentum(0, 0, 0), moment(0, 0, 0), angular(0, 0, 0);
    for (std::size_t i = 0; i < p.size(); ++i) {
        const double m = static_cast<double>(p.mass[i]);
        mass += m;
        momentum += m * p.velocity[i].cast<double>();
        moment += m * p.position[i].cast<double>();
        kinetic += 0.5 * m * static_cast<double>(p.velocity[i].squaredNorm());
    }
    const Vec3d centre = moment / mass;
    for (std::size_t i = 0; i < p.size(); ++i) {
        const Vec3d arm = p.position[i].cast<double>() - centre;
        const double m = static_cast<double>(p.mass[i]);
        angular += m * arm.cross(p.velocity[i].cast<double>());
        inertia += m * arm.squaredNorm();
    }
    const double of_speed = std::sqrt(2 * kinetic * mass), of_spin = std::sqrt(2 * kinetic * inertia);
    report(law, "momentum at the end over that of its rms speed", "1", momentum.norm() / of_speed);
    report(law, "angular momentum at the end over that of its rms speed", "1", angular.norm() / of_spin);
    report(law, "kinetic energy at the end", "J", kinetic);
}

}  // namespace thixo::gate
