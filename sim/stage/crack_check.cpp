// What a checkpoint may say of cracks.
#include <algorithm>
#include <cmath>

#include "pipeline/base/error.h"
#include "sim/stage/checkpoint_check.h"

namespace thixo {
namespace {

struct CrackChecks {
    const std::string& file;
    const Cracks& cracks;

    void require(bool right, const char* what) const {
        if (!right) throw CacheError("{}: {}", file, what);
    }
    bool is_vertex(Index i) const { return i < cracks.vertex.size(); }
    bool is_crack(std::int32_t k) const { return k >= 0 && static_cast<std::size_t>(k) < cracks.cracks.size(); }
    static bool is_near(const Vec3& m) { return m.allFinite() && m.cwiseAbs().maxCoeff() < Real(1e9); }

    void frames(const std::vector<Breaking>& breaking) const {
        for (std::size_t k = 0; k < cracks.cracks.size(); ++k) {
            const Crack& c = cracks.cracks[k];
            require(std::ranges::find(breaking, c.source, &Breaking::frame) != breaking.end(),
                    "a crack is in a body that does not break");
            require(c.frame >= 0, "a crack is in no frame");
            require(c.strength > 0, "a crack has no strength");
            require(c.sheet == kFirstCrackSheet + 2 * static_cast<std::int32_t>(k), "a crack's sheets are not its own");
        }
    }
    void fronts() const {
        for (const CrackFront& front : cracks.fronts) {
            require(is_crack(front.crack), "a front is of no crack");
            require(front.closed == 0 || front.closed == 1, "a front is neither open nor closed");
            require(front.nodes.size() >= 2, "a front has fewer than two nodes");
            for (const CrackNode& node : front.nodes) {
                require(is_near(node.place) && is_near(node.advance) && node.heading.allFinite(),
                        "a node of a front is nowhere");
                require(is_vertex(node.vertex), "a node of a front is at no vertex");
                require(node.state <= NodeState::met, "a node of a front has no such state");
            }
        }
    }
    void blades(const std::vector<Blade>& blades) const {
        for (const Blade& blade : blades) {
            const std::size_t n = blade.row.empty() ? 0 : blade.edge.size();
            require(blade.crack == -1 || is_crack(blade.crack), "a blade cuts along no crack");
            require(
                blade.row.empty() || (blade.row.size() == n && blade.vertex.size() == n && blade.rim.size() + 1 == n),
                "a blade has as many points as another one");
            for (const Vec3& m : blade.row) require(is_near(m), "a blade is nowhere");
            for (const auto* vertices : {&blade.vertex, &blade.rim, &blade.side[0], &blade.side[1]})
                for (const Index v : *vertices) require(v == kNone || is_vertex(v), "a blade is at no vertex");
        }
    }
    void sheets() const {
        for (const Vec3& v : cracks.vertex) require(is_near(v), "a vertex of a crack is nowhere");
        const CrackTriangles& t = cracks.triangles;
        for_each_array(t, [&](const char*, const auto& array) {
            require(array.size() == t.size(), "triangles of cracks have columns of different lengths");
        });
        for (std::size_t k = 0; k < t.size(); ++k) {
            require(is_vertex(t.a[k]) && is_vertex(t.b[k]) && is_vertex(t.c[k]),
                    "a triangle of a crack has no such vertex");
            require(is_crack(t.crack[k]), "a triangle is of no crack");
            require(t.behind[k] >= 0, "a triangle of a crack is before its front");
        }
    }
    void crossings(std::size_t elements) const {
        const BondCrossings& c = cracks.crossings;
        require(c.second.size() == c.size() && c.triangle.size() == c.size(),
                "bonds across cracks have columns of different lengths");
        for (std::size_t k = 0; k < c.size(); ++k) {
            require(c.first[k] < c.second[k] && c.second[k] < elements, "a bond across a crack is between no elements");
            require(c.triangle[k] < cracks.triangles.size(), "a bond crosses no triangle of a crack");
        }
    }
};

}  // namespace

void check_cracks(const Simulation& sim, const std::string& file) {
    const CrackChecks check{file, sim.solids.cracks};
    check.frames(sim.solids.breaking);
    check.fronts();
    check.sheets();
    check.crossings(sim.solids.elements.size());
}

void check_blades(const Simulation& sim, const std::string& file) {
    CrackChecks{file, sim.solids.cracks}.blades(sim.solids.blades);
}

}  // namespace thixo
