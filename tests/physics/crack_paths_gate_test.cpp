// Where cracks run to, by the geometry of their sheets.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <vector>

#include "tests/physics/gate.h"

namespace thixo {
namespace {

/// The place of a vertex of the sheets, in the world at time 0 [m].
Vec3d vertex_of(const Simulation& s, Index vertex) {
    return (s.solids.cracks.vertex[vertex] + s.solids.breaking[0].origin).cast<double>();
}
double across(const Vec3d& x) { return std::hypot(x.x(), x.y()); }

TEST(ShearedPlate, CracksFromItsNotchTowardsTheTensionSide) {
    // The tip of the notch is at the origin. In uniform shear a crack across the tension goes down by 45 degrees. At a
    // sharp tip the largest tangential stress asks for 70.5 (Erdogan & Sih 1963). A blunt notch lies between the two.
    constexpr double kUniform = 45, kTip = 70.5, kNear = 0.005, kFar = 0.04;  // degrees; m
    for (const double spacing : {0.008, 0.006, 0.0045}) {
        const std::string law = fmt::format("sheared plate, spacing {} m", spacing);
        Simulation s = make_simulation(gate::load("sheared_plate", {fmt::format("solver.spacing={}", spacing)}));
        gate::step_until(s, [&] { return s.solids.cracks.any(); });
        ASSERT_TRUE(s.solids.cracks.any()) << law;
        const Vec3d begun = vertex_of(s, 0);
        // The notch is two half widths of 5 mm wide, and no particle stands nearer to it than half a spacing.
        EXPECT_LT(across(begun), 0.005 + 1.5 * spacing) << law;
        gate::step_until(s, [&] { return s.solids.bodies.size() > 1; });
        Vec3d sum(0, 0, 0);
        double lowest = 0, highest = 0;
        const CrackTriangles& t = s.solids.cracks.triangles;
        for (std::size_t k = 0; k < t.size(); ++k)
            for (const Index v : {t.a[k], t.b[k], t.c[k]}) {
                if (t.crack[k] != 0) continue;
                const Vec3d way = vertex_of(s, v) - begun;
                lowest = std::min(lowest, way.y());
                highest = std::max(highest, way.y());
                if (across(way) > kNear && across(way) < kFar) sum += way / across(way);
            }
        EXPECT_LT(lowest, -kFar * std::sin(kUniform * kPi / 180)) << law << ": it stops on the tension side";
        EXPECT_LT(highest, 2 * spacing) << law << ": it runs to the compression side too";
        gate::expect({law, "kink of the crack over 5 to 40 mm", "degrees", std::atan2(-sum.y(), sum.x()) * 180 / kPi,
                      (kTip + kUniform) / 2, (kTip - kUniform) / 2, "uniform shear 45, at a sharp tip 70.5"});
    }
}

/// A part of the sheets between two radii about the z axis that goes from the inner one to the outer one.
struct Arm {
    Vec3d from{0, 0, 0}, to{0, 0, 0};  // mean places near the inner and near the outer radius [m]
    double off_radial() const {        // degrees
        const double cosine = (to - from).dot(from) / ((to - from).norm() * from.norm());
        return std::acos(std::clamp(cosine, -1.0, 1.0)) * 180 / kPi;
    }
};

/// The arms of all cracks. Triangles of one crack that share vertices are of one part. Its ends are means over two rows.
std::vector<Arm> arms_of(const Simulation& s, double inner, double outer) {
    const CrackTriangles& t = s.solids.cracks.triangles;
    std::vector<Index> head(s.solids.cracks.vertex.size());
    std::iota(head.begin(), head.end(), 0);
    const auto find = [&](Index v) {
        while (head[v] != v) v = head[v] = head[head[v]];
        return v;
    };
    for (std::size_t k = 0; k < t.size(); ++k) {
        const std::array<Index, 3> corners{t.a[k], t.b[k], t.c[k]};
        const bool within = std::ranges::all_of(corners, [&](Index v) {
            const double r = across(vertex_of(s, v));
            return r > inner && r < outer;
        });
        if (!within) continue;
        for (const Index v : corners) head[find(v)] = find(corners[0]);
    }
    struct Part {
        Vec3d from{0, 0, 0}, to{0, 0, 0};
        int inner = 0, outer = 0;
    };
    std::map<Index, Part> parts;
    const double rows = 2 * static_cast<double>(s.solids.breaking[0].row);
    for (Index v = 0; v < head.size(); ++v) {
        Vec3d x = vertex_of(s, v);
        const double r = across(x);
        if (!(r > inner && r < outer)) continue;
        x.z() = 0;
        Part& part = parts[find(v)];
        if (r < inner + rows) part.from += x, ++part.inner;
        if (r > outer - rows) part.to += x, ++part.outer;
    }
    std::vector<Arm> arms;
    for (const auto& [vertex, part] : parts)
        if (part.inner > 0 && part.outer > 0) arms.push_back({part.from / part.inner, part.to / part.outer});
    return arms;
}

TEST(StruckPane, CracksAlongRadiiFromTheHit) {
    // The ball touches within 5 mm of the middle. Hoop tension of the bent pane opens cracks that run outwards.
    constexpr double kInner = 0.012, kOuter = 0.03;  // m; three supports of a particle lie in between
    Simulation s = make_simulation(gate::load("struck_pane", {"surface.enabled=false"}));
    gate::step_until(s, [&] { return s.clock.time > 4.7e-4; });
    int radial = 0;
    double farthest = 0;
    for (const Arm& arm : arms_of(s, kInner, kOuter)) {
        radial += arm.off_radial() < 45 ? 1 : 0;
        farthest = std::max(farthest, arm.off_radial());
    }
    EXPECT_GE(radial, 4);
    gate::report("struck pane", "arms within 45 degrees of radial", "1", radial);
    gate::report("struck pane", "arm farthest from radial", "degrees", farthest);
}

}  // namespace
}  // namespace thixo
