// Solid matter is split, added and removed in mid-run. Nothing is lost, and no stale value is used.
#include "sim/fracture/fragments.h"

#include <gtest/gtest.h>

#include "pipeline/base/error.h"
#include "pipeline/geometry/shapes.h"
#include "sim/bonds/members.h"
#include "sim/bonds/weights.h"
#include "sim/stage/frame_output.h"
#include "tests/sim/identity.h"
#include "tests/sim/solid/rubber.h"

namespace thixo {
namespace {

using fixture::rubber_block_scene;

Shape left_half() { return plane(Vec3d(1, 0, 0), 0); }

struct Totals {
    double mass = 0;
    Vec3d momentum{0, 0, 0}, angular{0, 0, 0};
};
Totals totals(const Particles& p) {
    Totals t;
    for (const Real m : p.mass) t.mass += static_cast<double>(m);
    t.momentum = fixture::momentum(p);
    t.angular = fixture::angular_momentum(p);
    return t;
}

/// Adds a velocity to all matter of a body.
void throw_body(Simulation& s, std::size_t b, const Vec3d& by) {
    const SolidBody& body = s.solids.bodies[b];
    const Vec3 own = (body.turn.transpose() * by).cast<Real>();
    for (const Index i : body.elements) {
        s.solids.elements.velocity[i] = quad(xyz(s.solids.elements.velocity[i]) + own);
        s.particles.velocity[s.solids.particle_of[i]] += by.cast<Real>();
    }
}

Vec3d centre_of(const Simulation& s, std::size_t b) {
    Vec3d sum(0, 0, 0);
    double mass = 0;
    for (const Index i : s.solids.bodies[b].elements) {
        const Index k = s.solids.particle_of[i];
        sum += static_cast<double>(s.particles.mass[k]) * s.particles.position[k].cast<double>();
        mass += static_cast<double>(s.particles.mass[k]);
    }
    return sum / mass;
}

class Splits : public testing::TestWithParam<scene::SolidSteps> {};

TEST_P(Splits, LeaveMassAndMomentaAsTheyAreAndBothPartsGoOn) {
    scene::Scene scene = rubber_block_scene(GetParam());
    scene.bodies[0].velocity = {0.3, -0.2, 0.1};
    scene.bodies[0].angular_velocity = {2, 5, 1};
    Simulation s = make_simulation(scene);
    fixture::steps(s, 5, 1e-3);
    const Totals before = totals(s.particles);
    const std::vector<Vec3> places = s.particles.position;
    const std::size_t part = cut_body(0, left_half(), matter_of(s));

    ASSERT_EQ(s.solids.bodies.size(), 2u);
    const SolidBody &old = s.solids.bodies[0], &now = s.solids.bodies[part];
    EXPECT_EQ(now.parent, old.id);
    EXPECT_EQ(now.source, old.source);
    EXPECT_NE(now.id, old.id);
    EXPECT_EQ(old.size() + now.size(), s.particles.size());
    EXPECT_EQ(places, s.particles.position);
    const Totals after = totals(s.particles);
    EXPECT_EQ(after.mass, before.mass);
    EXPECT_EQ(after.momentum, before.momentum);
    EXPECT_EQ(after.angular, before.angular);

    // Nothing acts: each part keeps its own momentum. 1e-5 of the motion is rounding of 100 steps in single precision.
    throw_body(s, part, {-1, 0, 0});
    const Totals thrown = totals(s.particles);
    const double motion = fixture::motion(s.particles);
    const Vec3d way = -centre_of(s, part);
    fixture::steps(s, 100, 1e-3);
    EXPECT_LT((totals(s.particles).momentum - thrown.momentum).norm(), 1e-5 * motion);
    EXPECT_LT((totals(s.particles).angular - thrown.angular).norm(), 1e-4 * thrown.angular.norm());
    EXPECT_LT(centre_of(s, part).x() + way.x(), -0.05) << "what is thrown at 1 m/s goes its way";
    EXPECT_LT(s.solids.stretch2, 1.5);
}

TEST_P(Splits, PartsMeetAgainAtTheirNewFaces) {
    Simulation s = make_simulation(rubber_block_scene(GetParam()));
    fixture::steps(s, 2, 1e-3);
    const std::size_t part = cut_body(0, left_half(), matter_of(s));
    throw_body(s, part, {-1, 0, 0});
    fixture::steps(s, 20, 1e-3);
    ASSERT_GT(centre_of(s, 0).x() - centre_of(s, part).x(), 0.06 + 0.01);
    throw_body(s, part, {2, 0, 0});
    double closest = 1;
    const double motion = fixture::motion(s.particles);
    const Totals before = totals(s.particles);
    for (int k = 0; k < 100; ++k) {
        fixture::steps(s, 1, 1e-3);
        closest = std::min(closest, centre_of(s, 0).x() - centre_of(s, part).x());
    }
    // Both are 6 cm long. Two bodies of 0.1 MPa that meet at 1 m/s are compressed by a tenth, sqrt(rho/E) v. With twice
    // that they would enter each other.
    EXPECT_GT(closest, 0.06 * 0.8);
    EXPECT_LT((totals(s.particles).momentum - before.momentum).norm(), 1e-4 * motion);
    EXPECT_GT(centre_of(s, 0).x() - centre_of(s, part).x(), closest + 0.005) << "they part again";
}

TEST_P(Splits, AreTheSameAtAnyThreadCountAndAfterAResume) {
    fixture::expect_identity_after(rubber_block_scene(GetParam()), [](Simulation& s) {
        const std::size_t part = cut_body(0, left_half(), matter_of(s));
        throw_body(s, part, {0.2, 0.1, 0});
    });
}

INSTANTIATE_TEST_SUITE_P(Steps, Splits,
                         testing::Values(scene::SolidSteps::leapfrog, scene::SolidSteps::implicit_euler));

TEST(Fragments, StandInTheFrameWithIdParentAndSource) {
    Simulation s = make_simulation(rubber_block_scene());
    fixture::steps(s, 2, 1e-3);
    const std::size_t part = cut_body(0, left_half(), matter_of(s));
    cut_body(part, plane(Vec3d(0, 1, 0), 0), matter_of(s));
    refresh_surface(s);
    evaluate(s);
    const Frame frame = make_frame(s, {});
    ASSERT_EQ(frame.bodies.size(), 3u);
    EXPECT_EQ(frame.bodies[1].parent, 0);
    EXPECT_EQ(frame.bodies[2].parent, 1);
    EXPECT_EQ(frame.bodies[2].name, "block");
    EXPECT_TRUE(frame.bodies[2].trim.has_value());
    std::vector<std::size_t> surfels(3, 0);
    for (const std::int32_t body : s.surface.body) ++surfels[static_cast<std::size_t>(body)];
    for (const std::size_t count : surfels) EXPECT_GT(count, 100u);
    std::vector<std::int64_t> ids = s.surface.id;
    std::ranges::sort(ids);
    EXPECT_EQ(std::ranges::adjacent_find(ids), ids.end()) << "ids of surfels are unique";
}

TEST(Fragments, ANewFaceHasTheTemperatureOfItsOwnBody) {
    scene::Scene scene = rubber_block_scene();
    scene.bodies.push_back(scene.bodies[0]);
    scene.bodies[0].temperature = 20;
    scene.bodies[1].name = "hot";
    scene.bodies[1].shape.translate = {0.5, 0, 0};
    scene.bodies[1].temperature = 80;
    Simulation s = make_simulation(scene);
    fixture::steps(s, 2, 1e-3);
    const std::size_t before = s.embedded.size();
    const std::size_t part = cut_body(1, plane(Vec3d(1, 0, 0), 0.5), matter_of(s));
    ASSERT_GT(s.embedded.size(), before + 20) << "both sides of the cut have surfels";
    for (std::size_t i = before; i < s.embedded.size(); ++i) EXPECT_EQ(s.embedded.temperature[i], 80);
    refresh_surface(s);
    const std::int32_t cold = s.solids.bodies[0].id, hot = s.solids.bodies[1].id, cut = s.solids.bodies[part].id;
    for (std::size_t i = 0; i < s.surface.size(); ++i) {
        ASSERT_TRUE(s.surface.body[i] == cold || s.surface.body[i] == hot || s.surface.body[i] == cut);
        EXPECT_EQ(s.surface.temperature[i], s.surface.body[i] == cold ? 20 : 80);
    }
}

TEST(Fragments, ASplitThatLeavesASideEmptyIsRefusedAndChangesNothing) {
    Simulation s = make_simulation(rubber_block_scene());
    fixture::steps(s, 2, 1e-3);
    const std::string before = print_checkpoint(s, "hash");
    const auto nothing = [](const Vec3&) { return false; };
    const auto all = [](const Vec3&) { return true; };
    EXPECT_THROW(split_body(0, nothing, matter_of(s)), InputError);
    EXPECT_THROW(split_body(0, all, matter_of(s)), InputError);
    // A plane that misses the block on either side.
    EXPECT_THROW(cut_body(0, plane(Vec3d(1, 0, 0), -1), matter_of(s)), InputError);
    EXPECT_THROW(cut_body(0, plane(Vec3d(1, 0, 0), 1), matter_of(s)), InputError);
    EXPECT_EQ(s.solids.bodies.size(), 1u);
    EXPECT_TRUE(print_checkpoint(s, "hash") == before);
    fixture::steps(s, 2, 1e-3);

    scene::Scene bare = rubber_block_scene();
    bare.surface.enabled = false;
    Simulation without = make_simulation(bare);
    fixture::steps(without, 2, 1e-3);
    EXPECT_THROW(cut_body(0, left_half(), matter_of(without)), InputError);
}

bool names(const TrimNode& node, const std::vector<std::int32_t>& sheets) {
    if (node.op == TrimNode::Op::sheet) return std::ranges::binary_search(sheets, node.sheet);
    return std::ranges::all_of(node.parts, [&](const TrimNode& part) { return names(part, sheets); });
}

TEST(Fragments, AreTrimmedByNoSheetThatTheyHaveNoSurfelsOf) {
    // A block has a sheet a face. Half of it has no surfel of the face at the other end, before which no place lies.
    Simulation s = make_simulation(rubber_block_scene());
    fixture::steps(s, 2, 1e-3);
    cut_body(0, left_half(), matter_of(s));
    refresh_surface(s);
    evaluate(s);
    const Frame frame = make_frame(s, {});
    const auto sheets = sheets_of(s.embedded, 2);
    ASSERT_EQ(frame.bodies.size(), 2u);
    for (std::size_t b = 0; b < 2; ++b) {
        EXPECT_EQ(sheets[b].size(), 6u) << "five faces and the cut";
        ASSERT_TRUE(frame.bodies[b].trim.has_value());
        EXPECT_TRUE(names(*frame.bodies[b].trim, sheets[b]));
    }
}

TEST(Fragments, AnElementAddedInMidRunBelongsToItsBody) {
    scene::Scene scene = rubber_block_scene();
    scene.bodies[0].velocity = {1, 0, 0};
    Simulation s = make_simulation(scene);
    fixture::steps(s, 3, 1e-3);
    const Elements& e = s.solids.elements;
    const std::size_t before = e.size(), surfels = s.embedded.size();
    const Index host = s.solids.bodies[0].typical;
    const Index added = add_element(0,
                                    {.place = xyz(e.rest[host]) + Vec3(Real(0.004), 0, 0),
                                     .mass = e.mass[host] / 2,
                                     .volume = e.volume[host] / 2,
                                     .support = e.support[host],
                                     .depth = e.depth[host]},
                                    s.next_id++, matter_of(s));
    ASSERT_EQ(e.size(), before + 1);
    EXPECT_EQ(s.particles.size(), before + 1);
    EXPECT_EQ(s.embedded.size(), surfels);
    // Bonds go both ways, and the gradient H of a linear field u = B m is exactly B.
    Mat3 b;
    b << Real(0.01), Real(0.02), 0, 0, Real(-0.01), Real(0.03), Real(0.01), 0, Real(0.02);
    const std::vector<Quad> kept = e.displacement;
    for (std::size_t i = 0; i < e.size(); ++i) s.solids.elements.displacement[i] = quad(b * xyz(e.rest[i]));
    std::size_t bonds = 0;
    for (std::size_t i = 0; i < e.size(); ++i)
        for (std::size_t k = e.bonds.begin[i]; k < e.bonds.begin[i + 1]; ++k) {
            if (e.bonds.neighbour[k] != added || i == added) continue;
            ++bonds;
            EXPECT_LT((gradient_of(e, i) - b).norm(), 1e-4);
        }
    EXPECT_GT(bonds, 8u);
    EXPECT_LT((gradient_of(e, added) - b).norm(), 1e-4);
    s.solids.elements.displacement = kept;
    const Totals at = totals(s.particles);
    fixture::steps(s, 50, 1e-3);
    EXPECT_LT((totals(s.particles).momentum - at.momentum).norm(), 1e-5 * fixture::motion(s.particles));
    EXPECT_LT(s.solids.stretch2, 1.05) << "it lies where the matter about it does";
}

TEST(Fragments, AnElementRemovedInMidRunTakesItsMassAndNothingElse) {
    scene::Scene scene = rubber_block_scene();
    scene.bodies.push_back(scene.bodies[0]);
    scene.bodies[1].name = "other";
    scene.bodies[1].shape = fixture::shape_at({0.3, 0, 0}, scene::Sphere{0.04});
    Simulation s = make_simulation(scene);
    fixture::steps(s, 3, 1e-3);
    const Elements& e = s.solids.elements;
    const Index gone = s.solids.bodies[0].elements[10];
    const std::int64_t particle = e.id[gone];
    const double mass = totals(s.particles).mass, lost = static_cast<double>(e.mass[gone]);
    const std::size_t before = e.size();
    remove_element(gone, matter_of(s));
    ASSERT_EQ(e.size(), before - 1);
    EXPECT_NEAR(totals(s.particles).mass, mass - lost, 1e-6 * mass);
    EXPECT_EQ(s.solids.element(particle), kNone);
    for (std::size_t k = 0; k < s.particles.size(); ++k) {
        const Index i = s.solids.element(s.particles.id[k]);
        ASSERT_NE(i, kNone);
        EXPECT_EQ(e.id[i], s.particles.id[k]);
        EXPECT_EQ(s.solids.particle_of[i], k);
        EXPECT_EQ(s.solids.owner(i).id, s.particles.body[k]);
    }
    for (const Index j : e.bonds.neighbour) ASSERT_LT(j, e.size());
    for (const SurfelWeight& w : s.embedded.weight) ASSERT_LT(w.element, e.size());
    for (const Index i : s.solids.contacts.samples.weights.element) ASSERT_LT(i, e.size());
    fixture::steps(s, 20, 1e-3);
    EXPECT_LT(s.solids.stretch2, 1.001) << "a body at rest stays at rest";
    Simulation resumed = make_simulation(scene);
    parse_checkpoint(print_checkpoint(s, "hash"), "half", "hash", resumed);
    fixture::steps(s, 3, 1e-3);
    fixture::steps(resumed, 3, 1e-3);
    EXPECT_TRUE(print_checkpoint(s, "hash") == print_checkpoint(resumed, "hash"));
}

TEST(Fragments, ElementsInAnotherOrderAreTheSameMatter) {
    scene::Scene scene = rubber_block_scene();
    scene.bodies[0].angular_velocity = {0, 0, 20};
    Simulation s = make_simulation(scene), other = make_simulation(scene);
    std::vector<Index> rows(other.solids.elements.size());
    for (Index k = 0; k < rows.size(); ++k) rows[k] = static_cast<Index>(rows.size()) - 1 - k;
    select_elements(rows, other.solids);
    bind_matter({1}, matter_of(other));
    fixture::steps(s, 20, 1e-3);
    fixture::steps(other, 20, 1e-3);
    ASSERT_EQ(s.particles.id, other.particles.id);
    // Sums run in another order. Rounding is a millionth of the block's 0.1 m in each of 20 steps.
    for (std::size_t k = 0; k < s.particles.size(); ++k)
        EXPECT_LT((s.particles.position[k] - other.particles.position[k]).norm(), 20 * 1e-7f);
}

class Cracks : public testing::TestWithParam<scene::SolidSteps> {};

TEST_P(Cracks, NoForceGoesAcrossAPlaneThatHidesTheHalvesFromEachOther) {
    // The halves fly apart. Rates, diagonal and coarse matrix of the old bonds would hold them together, or let
    // Newton's method diverge. They are computed anew.
    Simulation s = make_simulation(rubber_block_scene(GetParam()));
    fixture::steps(s, 5, 1e-3);
    Elements& e = s.solids.elements;
    const std::uint64_t version = e.bonds.version;
    const auto left = [&](Index i) { return e.rest[i].x < 0; };
    set_visibility(e, [&](Index i, Index j) { return left(i) == left(j) ? Real(1) : Real(0); });
    EXPECT_GT(e.bonds.version, version);
    std::vector<std::int64_t> lefts;
    for (Index i = 0; i < e.size(); ++i) {
        const Vec3 by = left(i) ? Vec3(-1, 0, 0) : Vec3(1, 0, 0);
        e.velocity[i] = quad(xyz(e.velocity[i]) + by);
        s.particles.velocity[s.solids.particle_of[i]] += by;
        if (left(i)) lefts.push_back(e.id[i]);
    }
    const auto momentum_of_left = [&] {
        Vec3d sum(0, 0, 0);
        double mass = 0;
        for (const std::int64_t id : lefts) {
            const Index k = s.solids.particle_of[s.solids.element(id)];
            mass += static_cast<double>(s.particles.mass[k]);
            sum += static_cast<double>(s.particles.mass[k]) * s.particles.velocity[k].cast<double>();
        }
        return Vec3d(sum / mass);
    };
    fixture::steps(s, 50, 1e-3);
    EXPECT_EQ(s.stats.solid_unconverged, 0);
    // At 1 m/s for 50 ms each half moves by 5 cm. Only the solver's tolerance, 1e-3 of the forces, can slow it.
    EXPECT_LT((momentum_of_left() - Vec3d(-1, 0, 0)).norm(), 1e-3);
    EXPECT_LT(s.solids.stretch2, 1.01) << "each half is free of strain";
}

TEST_P(Cracks, LeaveNothingStaleOfWhatWasComputedForTheBondsOfBefore) {
    // One run keeps rates, diagonal and coarse matrix from step to step, the other forgets them. Their bits agree,
    // unless something was kept that the crack has changed.
    const auto run = [](bool forget) {
        scene::Scene scene = rubber_block_scene(GetParam());
        scene.bodies[0].angular_velocity = {0, 0, 10};
        Simulation s = make_simulation(scene);
        fixture::steps(s, 5, 1e-3);
        const Elements& e = s.solids.elements;
        set_visibility(s.solids.elements,
                       [&](Index i, Index j) { return (e.rest[i].x < 0) == (e.rest[j].x < 0) ? Real(1) : Real(0.25); });
        if (forget) {
            s.solid_scratch = {};
            s.solids.rates_version = 0;
            s.solids.rates.clear();
        }
        fixture::steps(s, 5, 1e-3);
        return print_checkpoint(s, "hash");
    };
    EXPECT_TRUE(run(false) == run(true));
}

INSTANTIATE_TEST_SUITE_P(Steps, Cracks,
                         testing::Values(scene::SolidSteps::leapfrog, scene::SolidSteps::implicit_euler));

TEST(Fragments, ABodyWithoutASceneShapeCollidesByItsSurfels) {
    const auto bounced = [](bool by_surfels) {
        scene::Scene scene = fixture::rubber_scene();
        scene.surface.enabled = true;
        scene.bodies = {fixture::body("a", fixture::shape_at({-0.05, 0, 0}, scene::Sphere{0.04}), {1, 0, 0}),
                        fixture::body("b", fixture::shape_at({0.05, 0, 0}, scene::Sphere{0.04}), {-1, 0, 0})};
        Simulation s = make_simulation(scene);
        if (by_surfels) {
            for (SolidBody& body : s.solids.bodies) body.scene_shape = false;
            s.solids.altered = true;
            bind_matter({1, 1}, matter_of(s));
        }
        fixture::steps(s, 80, 1e-3);
        return (centre_of(s, 1) - centre_of(s, 0)).x();
    };
    const double by_shape = bounced(false), by_surfels = bounced(true);
    EXPECT_GT(by_surfels, 0.08) << "they have not passed through each other";
    // The surfels represent the ball to a hundredth of its radius. The rebound differs by at most a tenth.
    EXPECT_NEAR(by_surfels, by_shape, 0.1 * by_shape);
}

}  // namespace
}  // namespace thixo
