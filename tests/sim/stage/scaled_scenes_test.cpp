// Scenes at the ends of the range of solver.spacing: the same as at everyday sizes, in units of the spacing.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <regex>

#include "pipeline/contract/scene_io.h"
#include "sim/stage/frame_output.h"
#include "tests/sim/fixture.h"

namespace thixo {
namespace {

/// Units of a scene that is 4^k times as large. By Froude's law the same gravity moves it alike, 2^k times as slowly. All
/// factors are powers of two: nothing but over- and underflow can tell the scenes apart.
struct Scale {
    int k = 0;
    double length() const { return std::ldexp(1, 2 * k); }
    /// Factor of a quantity of the unit kg^a m^b s^c K^d. Densities stay as they are.
    double of(int mass, int metres, int seconds) const {
        return std::ldexp(1, (3 * mass + metres) * 2 * k + seconds * k);
    }
};

/// A scene's text at this scale. Numbers that end in `_m` are lengths in spacings, those in `_v` speeds and those in
/// `_f` frequencies of the scale 0.
std::string scaled_text(const std::string& text, double spacing, const Scale& scale) {
    static const std::regex kNumber("(-?[0-9.]+)_([mvf])");
    const std::map<std::string, double> factor{
        {"m", spacing * scale.length()}, {"v", scale.of(0, 1, -1)}, {"f", scale.of(0, 0, -1)}};
    std::string out;
    auto from = text.begin();
    for (std::sregex_iterator m(text.begin(), text.end(), kNumber), end; m != end; ++m) {
        out.append(from, text.begin() + m->position());
        out += fmt::format("{}", std::stod((*m)[1]) * factor.at((*m)[2]));
        from = text.begin() + m->position() + m->length();
    }
    return out.append(from, text.end());
}

/// The scene of a text at this scale; its materials are those of the scale 0.
scene::Scene scene_at(const std::string& text, double spacing, const Scale& scale) {
    scene::Scene s = scene::parse_scene(scaled_text(text, spacing, scale), "scene.yaml");
    s.solver.time_step.maximum *= scale.of(0, 0, 1);
    const double stress = scale.of(1, -1, -2), viscosity = scale.of(1, -1, -1), tension = scale.of(1, 0, -2);
    for (scene::Material& m : s.materials) {
        m.elastic.youngs_modulus *= stress;
        m.elastic.volume_stiffness *= stress;
        m.melting.liquid.youngs_modulus *= stress;
        m.melting.liquid.creep *= scale.of(0, 0, -1);
        m.fracture.strength *= stress;
        m.viscosity *= viscosity;
        m.melting.liquid.viscosity *= viscosity;
        m.surface_tension *= tension;
        m.melting.liquid.surface_tension *= tension;
        m.thermal.conductivity *= scale.of(1, 1, -3);
        m.thermal.heat_capacity *= scale.of(0, 2, -2);
        m.thermal.latent_heat *= scale.of(0, 2, -2);
    }
    return s;
}

Frame last_frame(const scene::Scene& scene) {
    Simulation sim = make_simulation(scene);
    refresh_surface(sim);
    evaluate(sim);
    while (sim.clock.frame < scene.frames.last) EXPECT_TRUE(advance_frame(sim));
    return make_frame(sim, {});
}

/// The unit of an attribute at this scale, over that of the scale 0.
double unit_of(const std::string& attribute, const Scale& scale) {
    static const std::map<std::string, std::array<int, 3>> kUnits{
        {"P", {0, 1, 0}},  {"rest", {0, 1, 0}},   {"t1", {0, 1, 0}},         {"t2", {0, 1, 0}},
        {"v", {0, 1, -1}}, {"pscale", {0, 1, 0}}, {"pressure", {1, -1, -2}}, {"von_mises", {1, -1, -2}},
    };
    const auto at = kUnits.find(attribute);
    return at == kUnits.end() ? 1 : scale.of(at->second[0], at->second[1], at->second[2]);
}

/// The numbers of an attribute, in the order of ids: memory is in the order of cells.
std::vector<double> numbers_of(const PointSet& points, const Attribute& attribute) {
    const auto& ids = points.get<std::int64_t>("id");
    std::vector<std::size_t> order(points.count);
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::ranges::sort(order, {}, [&](std::size_t k) { return ids[k]; });
    std::vector<double> numbers;
    std::visit(
        [&](const auto& values) {
            for (const std::size_t k : order)
                if constexpr (requires { values[k].x(); })
                    for (int a = 0; a < 3; ++a) numbers.push_back(static_cast<double>(values[k][a]));
                else
                    numbers.push_back(static_cast<double>(values[k]));
        },
        attribute.data);
    return numbers;
}

/// The largest difference between numbers and numbers in units of `unit`. Axes of discs have no sign: where rounding
/// decides it, t1 and t2 may turn round.
double worst_of(const std::string& attribute, const std::vector<double>& a, const std::vector<double>& b, double unit) {
    const bool axis = attribute == "t1" || attribute == "t2";
    const std::size_t group = axis ? 3 : 1;
    double worst = 0;
    for (std::size_t k = 0; k + group <= a.size(); k += group) {
        double along = 0, against = 0;
        for (std::size_t l = k; l < k + group; ++l) {
            along = std::max(along, std::abs(a[l] - b[l] / unit));
            against = std::max(against, std::abs(a[l] + b[l] / unit));
        }
        worst = std::max(worst, axis ? std::min(along, against) : along);
    }
    return worst;
}

/// t1 x t2 of every disc: both turn round, or neither.
std::vector<Vec3d> sides_of(const PointSet& points) {
    std::vector<Vec3d> sides;
    if (!points.find("t1")) return sides;
    const std::vector<double> t1 = numbers_of(points, *points.find("t1")), t2 = numbers_of(points, *points.find("t2"));
    for (std::size_t k = 0; k < t1.size(); k += 3)
        sides.push_back(Vec3d(t1[k], t1[k + 1], t1[k + 2]).cross(Vec3d(t2[k], t2[k + 1], t2[k + 2])));
    return sides;
}

/// Every number of both point sets agrees to a part in 10^5 of the largest one of its attribute.
void expect_alike(const PointSet& usual, const PointSet& scaled, const Scale& scale, const std::string& what) {
    ASSERT_EQ(usual.count, scaled.count) << what;
    for (const Attribute& attribute : usual.attributes) {
        const std::vector<double> a = numbers_of(usual, attribute),
                                  b = numbers_of(scaled, *scaled.find(attribute.name));
        const double unit = unit_of(attribute.name, scale);
        double largest = 0;
        for (std::size_t k = 0; k < a.size(); ++k) {
            EXPECT_TRUE(std::isfinite(b[k])) << what << ' ' << attribute.name << ' ' << k;
            largest = std::max(largest, std::abs(a[k]));
        }
        EXPECT_LE(worst_of(attribute.name, a, b, unit), 1e-5 * largest) << what << ' ' << attribute.name;
    }
    const std::vector<Vec3d> a = sides_of(usual), b = sides_of(scaled);
    for (std::size_t k = 0; k < a.size(); ++k) EXPECT_GT(a[k].normalized().dot(b[k].normalized()), 0.99) << what << k;
}

/// The ends of the range of solver.spacing, and everyday sizes that are powers of 4 away from them.
struct End {
    double spacing;
    Scale scale;
};
constexpr End kEnds[] = {{0.016384, {-7}}, {1e6 / (1 << 26), {13}}};

void expect_the_same_at(const End& end, const std::string& name, const std::string& text) {
    const std::string what = fmt::format("{} at {:g} m", name, end.spacing * end.scale.length());
    const Frame usual = last_frame(scene_at(text, end.spacing, {0}));
    const Frame scaled = last_frame(scene_at(text, end.spacing, end.scale));
    expect_alike(usual.particles, scaled.particles, end.scale, what + ", particles");
    expect_alike(usual.surfels, scaled.surfels, end.scale, what + ", surfels");
    EXPECT_GT(usual.surfels.count, 50u) << what;
}

void expect_the_same_at_the_ends(const std::string& name, const std::string& text) {
    for (const End& end : kEnds) expect_the_same_at(end, name, text);
}

const std::string kFrames = "frames: {first: 1, last: 3, fps: 100_f}\n";
std::string solver(const std::string& keys) { return "solver: {spacing: 1_m, expected_speed: 1_v" + keys + "}\n"; }
const std::string kTank =
    "world: {boundaries: {tank: {inside: true, shape: {box: {size: [9_m, 9_m, 20_m]}, translate: [0, 0, 10_m]}}}}\n";
const std::string kPool =
    "bodies: {pool: {material: m, shape: {box: {size: [9_m, 5_m, 6_m]}, translate: [0, 0, 3_m]}}}\n";

TEST(ScaledScenes, LiquidsWithASurface) {
    for (const std::string keys : {"", ", pressure: dfsph", ", pressure: dfsph, viscosity: implicit"})
        expect_the_same_at_the_ends("liquid" + keys,
                                    kFrames + kTank + "materials: {m: {viscosity: 0.0001}}\n" + kPool + solver(keys));
}

TEST(ScaledScenes, DropsWithSurfaceTension) {
    expect_the_same_at_the_ends("drop", kFrames +
                                            "world: {gravity: [0, 0, 0]}\nmaterials: {m: {surface_tension: 0.07}}\n"
                                            "bodies: {b: {material: m, shape: {box: {size: [7_m, 6_m, 5_m]}}}}\n" +
                                            solver(""));
}

TEST(ScaledScenes, FilmsOnWalls) {
    expect_the_same_at_the_ends(
        "film",
        kFrames + kTank +
            "materials: {m: {viscosity: 0.0001}}\n"
            "bodies: {film: {material: m, shape: {box: {size: [9_m, 9_m, 1.2_m]}, translate: [0, 0, 0.6_m]}}}\n" +
            solver(""));
}

TEST(ScaledScenes, JetsOfEmitters) {
    expect_the_same_at_the_ends(
        "jet", kFrames + kTank + "materials: {m: {}}\n" + kPool +
                   "emitters: {e: {material: m, position: [0, 0, 12_m], radius: 2.5_m, speed: 1_v}}\n" + solver(""));
}

TEST(ScaledScenes, SolidsInContact) {
    for (const std::string keys : {"", ", solids: implicit"})
        expect_the_same_at_the_ends(
            "solids" + keys,
            kFrames +
                "world: {boundaries: {floor: {shape: {plane: {}}}}}\n"
                "materials: {soft: {youngs_modulus: 2.0e4}, putty: {youngs_modulus: 1.0e4, yield_strain: 0.01, creep: "
                "100_f}}\n"
                "bodies:\n  low: {material: soft, shape: {box: {size: [6_m, 6_m, 4_m]}, translate: [0, 0, 2.05_m]}}\n"
                "  high: {material: putty, shape: {sphere: {radius: 2.5_m}, translate: [1_m, 0, 6.7_m]}, velocity: [0, "
                "0, -1_v]}\n" +
                solver(keys));
}

TEST(ScaledScenes, SolidsInLiquids) {
    expect_the_same_at_the_ends(
        "jelly in water",
        kFrames + kTank +
            "materials: {water: {}, jelly: {youngs_modulus: 1.0e4}}\n"
            "bodies:\n  cube: {material: jelly, shape: {box: {size: [4_m, 4_m, 4_m]}, translate: [0, 0, 3_m]}}\n"
            "  pool: {material: water, shape: {box: {size: [9_m, 9_m, 5_m]}, translate: [0, 0, 2.5_m]}}\n" +
            solver(""));
}

TEST(ScaledScenes, MatterThatMelts) {
    const auto wax = [](const std::string& conductivity) {
        return kFrames +
               "world: {boundaries: {plate: {shape: {plane: {}}, isothermal: true, temperature: 90}}}\n"
               "materials: {wax: {youngs_modulus: 1.0e4, melting: {from: 40, to: 60, liquid: {viscosity: 0.01}}, "
               "heat_capacity: 100, conductivity: " +
               conductivity +
               "}}\nbodies: {b: {material: wax, temperature: 45, "
               "shape: {box: {size: [6_m, 6_m, 4_m]}, translate: [0, 0, 2_m]}}}\n" +
               solver("");
    };
    // A conductivity in proportion would be far above what the key permits, where the spacing is a thousand kilometres.
    expect_the_same_at(kEnds[0], "wax", wax("200"));
    expect_the_same_at(kEnds[1], "wax", wax("1.0e-11"));
}

TEST(ScaledScenes, SolidsThatBreak) {
    // One frame: what breaks later magnifies every difference.
    expect_the_same_at_the_ends(
        "plate",
        "frames: {first: 1, last: 2, fps: 100_f}\n"
        "world: {gravity: [0, 0, 0]}\nmaterials: {glass: {youngs_modulus: 1.0e5, fracture: {strength: 1000}}}\n"
        "bodies: {b: {material: glass, shape: {box: {size: [10_m, 6_m, 3_m]}}, velocity_gradient: {x: [8_f, 0, "
        "0]}}}\n" +
            solver(""));
}

}  // namespace
}  // namespace thixo
