// Flows with known solutions, with one viscosity or two, by the implicit solver.
#include <fmt/core.h>
#include <gtest/gtest.h>

#include "pipeline/base/random.h"
#include "sim/space/sampling.h"
#include "tests/physics/gate.h"
#include "tests/sim/fixture.h"

namespace thixo {
namespace {

void expect(const std::string& what, double measured, double reference, double tolerance) {
    gate::expect({"viscous flow", what, "", measured, reference, tolerance, "analytic"});
}

// A liquid between two no-slip plates at z = 0 and z = height, periodic along x and y, `layers` layers of particles.
struct Channel {
    double height = 0.1, nu = 0.01;  // m, m^2/s
    int layers = 20;
    Vec3d force{0, 0, 0};  // m/s^2
    double plate = 0;      // speed of the upper plate along x [m/s]
    double spacing() const { return height / layers / static_cast<double>(packing_layer(1)); }
};

scene::Scene channel_scene(const Channel& c) {
    scene::Scene s = fixture::empty_space();
    s.solver.spacing = c.spacing();
    const double a = c.spacing() * static_cast<double>(packing_distance(1)), length = 4 * a,
                 width = 6 * a * std::sqrt(3.0) / 2;
    s.world.gravity = c.force;
    s.world.periodic = {{scene::Axis::x, 0, length}, {scene::Axis::y, 0, width}};
    scene::Boundary floor, ceiling;
    floor.name = "floor";
    floor.shape.kind = scene::Plane{{0, 0, 1}, 0};
    ceiling.name = "ceiling";
    ceiling.shape.kind = scene::Plane{{0, 0, -1}, -c.height};
    floor.no_slip = ceiling.no_slip = true;
    if (c.plate != 0)  // from the second key on at constant speed
        for (int k = 0; k < 100; ++k) ceiling.motion.push_back({double(k), {c.plate * k, 0, 0}, {0, 0, 0}});
    s.world.boundaries = {floor, ceiling};
    s.bodies = {fixture::body("liquid", fixture::shape_at({length / 2, width / 2, c.height / 2},
                                                          scene::BoxShape{{length, width, c.height}, 0}))};
    s.materials[0].viscosity = c.nu * 1000;
    s.solver.expected_speed = 0.1;
    s.solver.artificial_viscosity = 0;
    s.solver.viscosity = scene::Viscosity::implicit_solve;
    s.solver.viscosity_tolerance = 1e-4;
    return s;
}

// The largest difference of the layers' mean velocities from u(z), over `scale`.
template <class Profile>
double profile_error(const Simulation& s, const Channel& c, double scale, Profile&& u) {
    std::vector<double> sum(static_cast<std::size_t>(c.layers), 0), reference = sum, count = sum;
    const Particles& p = s.particles;
    for (std::size_t i = 0; i < p.size(); ++i) {
        const double z = p.position[i].z();
        const auto k = static_cast<std::size_t>(std::clamp(int(z / c.height * c.layers), 0, c.layers - 1));
        sum[k] += static_cast<double>(p.velocity[i].x());
        reference[k] += u(z);
        ++count[k];
    }
    double worst = 0;
    for (std::size_t k = 0; k < sum.size(); ++k)
        worst = std::max(worst, std::abs(sum[k] - reference[k]) / (count[k] * scale));
    return worst;
}

// Advances to `time` in steps of about dt.
void advance_to(Simulation& s, double time, double dt) {
    const double rest = time - s.clock.time;
    const int count = std::max(1, static_cast<int>(std::lround(rest / dt)));
    fixture::steps(s, count, rest / count);
}

TEST(ViscousFlow, PoiseuilleStartsUpAndStays) {
    Channel c;
    const double d = c.height / 2, largest = 0.01;
    c.force = {2 * c.nu * largest / (d * d), 0, 0};
    Simulation s = make_simulation(channel_scene(c));
    for (const double tau : {0.1, 0.25, 0.5, 1.0, 4.0}) {
        advance_to(s, tau * d * d / c.nu, 1e-3);
        const double error = profile_error(s, c, largest, [&](double z) {
            const double xi = (z - d) / d;
            double u = 1 - xi * xi;
            for (int n = 0; n < 20; ++n) {
                const double odd = 2 * n + 1;
                u -= 32 * (n % 2 ? -1 : 1) / std::pow(odd * kPi, 3) * std::cos(odd * kPi * xi / 2) *
                     std::exp(-square(odd * kPi / 2) * tau);
            }
            return largest * u;
        });
        expect(fmt::format("Poiseuille, nu t/d^2 = {}, largest error over U_max", tau), error, 0, 0.02);
    }
    gate::report_budgets("Poiseuille", s.particles);
}

TEST(ViscousFlow, CouetteStartsUpAndStays) {
    Channel c;
    c.plate = 0.01;
    Simulation s = make_simulation(channel_scene(c));
    const double start = s.clock.time = 2;  // the plate moves at constant speed
    for (const double tau : {0.02, 0.1, 0.3, 1.0}) {
        advance_to(s, start + tau * square(c.height) / c.nu, 1e-3);
        const double error = profile_error(s, c, c.plate, [&](double z) {
            double u = z / c.height;
            for (int n = 1; n < 30; ++n)
                u += 2 / (n * kPi) * (n % 2 ? -1 : 1) * std::exp(-square(n * kPi) * tau) *
                     std::sin(n * kPi * z / c.height);
            return c.plate * u;
        });
        expect(fmt::format("Couette, nu t/H^2 = {}, largest error over U", tau), error, 0, 0.02);
    }
    gate::report_budgets("Couette", s.particles);
}

TEST(ViscousFlow, TwoLiquidsInShearShareTheStress) {
    // The lower liquid is ten times as viscous, and du/dz is ten times smaller there. The tolerance is 2 % of the
    // plate's speed. The interface lies between two layers. There it is half a layer of the thin liquid's gradient: 5 %
    // / 1.1.
    Channel c;
    c.plate = 0.01;
    scene::Scene scene = channel_scene(c);
    scene.materials.push_back(scene.materials[0]);
    scene.materials[1].viscosity *= 10;
    Simulation s = make_simulation(scene);
    for (std::size_t i = 0; i < s.particles.size(); ++i)
        s.particles.material[i] = s.particles.position[i].z() < static_cast<Real>(c.height / 2);
    s.clock.time = 2;
    advance_to(s, 2 + 1.5 * square(c.height) / c.nu, 2e-3);
    const double error = profile_error(s, c, c.plate, [&](double z) {
        const double at = 1 / 11.0, half = c.height / 2;  // speed of the interface
        return c.plate * (z < half ? at * z / half : at + (1 - at) * (z - half) / half);
    });
    expect("two liquids in shear, largest error over U", error, 0, 0.02);
}

TEST(ViscousFlow, TaylorGreenVortexDecays) {
    // The flow distorts the packing: 5 % of the decay. With Re = 10 in a box of 1 m, and U = 1 m/s:
    //     v ~ exp(-8 pi^2 t/Re)
    scene::Scene scene = fixture::empty_space();
    const double d = scene.solver.spacing = 1.0 / 32, half = 0.5, depth = 5 * d;
    scene.world.periodic = {
        {scene::Axis::x, -half, half}, {scene::Axis::y, -half, half}, {scene::Axis::z, -depth / 2, depth / 2}};
    scene.bodies = {fixture::body("block", fixture::shape_at({0, 0, 0}, scene::BoxShape{{1, 1, depth}, 0}))};
    scene.materials[0].viscosity = 100;
    scene.solver.expected_speed = 1;
    scene.solver.artificial_viscosity = 0;
    scene.solver.viscosity = scene::Viscosity::implicit_solve;
    Simulation s = make_simulation(scene);
    const auto field = [](const Vec3& x) {
        const double a = 2 * kPi * static_cast<double>(x.x()), b = 2 * kPi * static_cast<double>(x.y());
        return Vec3d(-std::cos(a) * std::sin(b), std::sin(a) * std::cos(b), 0);
    };
    for (std::size_t i = 0; i < s.particles.size(); ++i)
        s.particles.velocity[i] = field(s.particles.position[i]).cast<Real>();
    const auto amplitude = [&] {  // of the field in the velocities
        double sum = 0, norm = 0;
        for (std::size_t i = 0; i < s.particles.size(); ++i) {
            const Vec3d u = field(s.particles.position[i]);
            sum += u.dot(s.particles.velocity[i].cast<double>());
            norm += u.squaredNorm();
        }
        return sum / norm;
    };
    const double before = amplitude();
    advance_to(s, 0.2, 1e-3);
    const double rate = -std::log(amplitude() / before) / 0.2, expected = 8 * square(kPi) / 10;
    expect("Taylor-Green, decay rate [1/s]", rate, expected, 0.05 * expected);
    gate::report_budgets("Taylor-Green", s.particles);
}

TEST(ViscousFlow, ASheetOfShearDiffuses) {
    // A periodic block whose upper half moves against its lower half. Its longest sine wave decays with the rate nu
    // k^2.
    scene::Scene scene = fixture::empty_space();
    const double d = scene.solver.spacing = 0.01, layer = static_cast<double>(packing_layer(1)) * d;
    const double edge = 6 * static_cast<double>(packing_distance(1)) * d, wide = 6 * edge / 6 * std::sqrt(3.0) / 2,
                 high = 40 * layer;
    scene.world.periodic = {
        {scene::Axis::x, 0, edge}, {scene::Axis::y, 0, wide}, {scene::Axis::z, -high / 2, high / 2}};
    scene.bodies = {
        fixture::body("block", fixture::shape_at({edge / 2, wide / 2, 0}, scene::BoxShape{{edge, wide, high}, 0}))};
    scene.materials[0].viscosity = 50;
    scene.solver.artificial_viscosity = 0;
    scene.solver.viscosity = scene::Viscosity::implicit_solve;
    scene.solver.viscosity_tolerance = 1e-4;
    Simulation s = make_simulation(scene);
    const double k = 2 * kPi / high, nu = 0.05;
    for (std::size_t i = 0; i < s.particles.size(); ++i)
        s.particles.velocity[i].x() = s.particles.position[i].z() > 0 ? Real(0.01) : Real(-0.01);
    const auto amplitude = [&] {
        double sum = 0;
        for (std::size_t i = 0; i < s.particles.size(); ++i)
            sum += static_cast<double>(s.particles.velocity[i].x()) *
                   std::sin(k * static_cast<double>(s.particles.position[i].z()));
        return sum;
    };
    const double before = amplitude(), time = 1 / (nu * k * k);
    fixture::steps(s, 100, time / 100);
    const double decayed = -std::log(amplitude() / before);
    // Backward Euler decays by log(1 + 0.01) a step, 0.5 % less than 0.01.
    expect("sheet of shear, nu k^2 t", decayed, 1, 0.02);
}

TEST(ViscousFlow, ASpinningBlobKeepsSpinning) {
    // A drop as viscous as honey makes a quarter turn in free space. The force mu lap v has a torque at a free surface
    // and would stop it in some hundredths of a second:
    //     rho R^2/(15 mu)  [s]
    // Only rounding remains: 1e-3 of the angular momentum.
    scene::Scene scene = fixture::empty_space();
    scene.bodies = {fixture::body("blob", fixture::shape_at({0, 0, 0}, scene::Sphere{0.08}))};
    scene.bodies[0].angular_velocity = {0, 0, 2};
    scene.materials[0].viscosity = 100;
    scene.solver.artificial_viscosity = 0;
    Simulation s = make_simulation(scene);
    ASSERT_GT(s.problem.materials[0].implicit_viscosity, 0);
    const auto angular = [&] { return fixture::angular_momentum(s.particles).z(); };
    const double before = angular();
    advance_to(s, kPi / 4, 2e-3);
    expect("spinning blob, angular momentum kept", angular() / before, 1, 1e-3);
}

TEST(ViscousFlow, ASlabSpreadsOverTheFloorItSticksTo) {
    // Half of a slab is released on a no-slip floor. The plane of symmetry is a slip wall. Steps are 20 times the
    // explicit limit. A thin layer of volume q per width reaches (Huppert 1982)
    //     x = 1.411 (g q^3/(3 nu))^(1/5) t^(1/5)  [m]
    const double w = 0.12, g = 9.81, nu = 1.2 * std::sqrt(g * w * w * w), d = w / 12;
    scene::Scene scene = fixture::empty_space();
    scene.solver.spacing = d;
    const double deep = 6 * d * static_cast<double>(packing_distance(1)) * std::sqrt(3.0) / 2;
    scene.world.gravity = {0, 0, -g};
    scene.world.periodic = {{scene::Axis::y, 0, deep}};
    scene::Boundary floor, mirror;
    floor.name = "floor";
    floor.shape.kind = scene::Plane{{0, 0, 1}, 0};
    floor.no_slip = true;
    mirror.name = "mirror";
    mirror.shape.kind = scene::Plane{{1, 0, 0}, 0};
    scene.world.boundaries = {floor, mirror};
    scene.bodies = {
        fixture::body("slab", fixture::shape_at({w / 2, deep / 2, w / 2}, scene::BoxShape{{w, deep, w}, 0}))};
    scene.materials[0].viscosity = 1000 * nu;
    scene.solver.artificial_viscosity = 0;
    scene.solver.expected_speed = std::sqrt(0.2 * g * w);  // 5 % compression under its own weight
    Simulation s = make_simulation(scene);
    ASSERT_GT(s.problem.materials[0].implicit_viscosity, 0);
    const double h = s.problem.smoothing.support, limit = h * h / (40 * nu);
    const double c = s.problem.materials[0].sound_speed, step = 0.35 * h / c;
    gate::report("viscous flow", "slab, step over the explicit limit", "", step / limit);
    EXPECT_GT(step, 20 * limit);
    double volume = 0;
    for (const Real v : s.particles.rest_volume) volume += static_cast<double>(v);
    const double q = volume / deep;
    for (const double wide : {2.5, 3.0}) {
        const double time = std::pow(wide * w / 1.411, 5) * 3 * nu / (g * q * q * q);
        advance_to(s, time, step);
        double front = 0;
        for (const Vec3& x : s.particles.position) front = std::max(front, static_cast<double>(x.x()));
        front += d / 2;
        expect(fmt::format("slab, front after {:.2f} s [m]", time), front, wide * w, 0.1 * wide * w);
    }
    gate::report_budgets("viscous slab", s.particles);
}

}  // namespace
}  // namespace thixo
