#include "sim/fracture/blades.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "pipeline/base/error.h"
#include "pipeline/geometry/kernels.h"
#include "sim/fracture/crack_events.h"
#include "sim/fracture/fronts.h"
#include "sim/fracture/painted.h"
#include "sim/space/scene_shapes.h"

namespace thixo {
namespace {

/// Carries places of the world into the material frame of a scene body, by the elements about them:
///     m(x) = sum_j w_poly6(x - x_j, h) (m_j + F_j^-1 (x - x_j)) / sum_j w_poly6(x - x_j, h)
/// The sum is over the piece of the nearest element, and there over those between which and their own m no sheet stands.
/// Where all are hidden the place is in a crack that gapes. Beyond the reach of all, the body goes on as at the nearest.
class MaterialPlaces {
  public:
    MaterialPlaces(const Solids& solids, const CrackedMatter& matter) : solids_(solids), matter_(matter) {
        const std::vector<BodyPose> poses = poses_of(solids.bodies);
        const Elements& e = solids.elements;
        for (const Index i : matter.elements()) {
            const BodyPose& pose = poses[static_cast<std::size_t>(e.owner[i])];
            place_.push_back(pose.turn * (xyz(e.rest[i]) + xyz(e.displacement[i])) + pose.place);
        }
        grid_.build(place_, matter.breaking().support);
    }

    struct Found {
        Vec3 m{0, 0, 0};         // [m]
        Vec3 velocity{0, 0, 0};  // of the nearest element, in the world [m/s]
        Mat3 turn;               // from its material frame to the world
        Real away = 0;           // distance of that element [m]
        bool gapes = false;      // it is between the faces of a crack, where no matter is: m means little
    };
    Found at(const Vec3& x) const {
        const Elements& e = solids_.elements;
        std::vector<std::pair<Real, Index>> near;
        grid_.nearest(x, 1, std::numeric_limits<Real>::max(), near);
        const Index nearest = matter_.elements()[near.front().second];
        const std::int32_t owner = e.owner[nearest];
        Found found;
        found.turn = solids_.bodies[static_cast<std::size_t>(owner)].turn.cast<Real>();
        found.velocity = found.turn * xyz(e.velocity[nearest]);
        found.away = std::sqrt(near.front().first);
        found.m = xyz(e.rest[nearest]) + found.turn.transpose() * (x - place_[near.front().second]);
        const Poly6 w(grid_.cell());
        Real weight = 0;
        Vec3 sum(0, 0, 0);
        bool hidden = false;
        grid_.for_each_neighbour(x, grid_.cell(), [&](Index k, Real r2) {
            const Index j = matter_.elements()[k];
            if (e.owner[j] != owner) return;
            const Vec3 own = xyz(e.rest[j]), m = own + unstretched(j, found.turn.transpose() * (x - place_[k]));
            if (matter_.hidden(own, m)) {
                hidden = true;
                return;
            }
            const Real a = w.value(r2);
            weight += a;
            sum += a * m;
        });
        if (weight > 0) found.m = sum / weight;
        // Beyond a face of the crack lies, in the material frame, what is of another piece by now.
        near.clear();
        matter_.grid().nearest(found.m, 1, std::numeric_limits<Real>::max(), near);
        const bool foreign = e.owner[matter_.elements()[near.front().second]] != owner;
        found.gapes = foreign || (hidden && !(weight > 0));
        return found;
    }

  private:
    /// A way from an element to a place, before the deformation. Where matter tears, moving least squares give stretches
    /// without bound: the way becomes at most twice as long.
    Vec3 unstretched(Index j, const Vec3& way) const {
        const Mat3 stretch = Mat3::Identity() + solids_.gradients[j];
        const Vec3 before = stretch.inverse() * way;
        const Real longest = 2 * way.norm(), length = before.norm();
        if (!(length < std::numeric_limits<Real>::max())) return way;
        return length > longest ? Vec3(longest / length * before) : before;
    }

    const Solids& solids_;
    const CrackedMatter& matter_;
    std::vector<Vec3> place_;
    PointGrid grid_;
};

/// How far outside of the level where sheets end [m].
Real beyond_end(const Breaking& breaking, const Vec3& m) { return breaking.distance(m) - kEndLevel * breaking.row; }

/// The edge of a blade in the material frame.
struct Edge {
    std::vector<Vec3> place;
    std::vector<Real> beyond;    // beyond_end [m]
    std::vector<Real> progress;  // since the last row, along the direction of the cut; 0 where it does not go on [m]
    std::vector<Vec3> ahead;     // unit, the direction of the cut
    std::vector<std::uint8_t> gapes;  // where it is in a crack that gapes
    Real fastest = 0;                 // relative to the matter, near it [m/s]
    bool near = false, leaps = false;
    bool outside() const {
        return std::ranges::all_of(beyond, [](Real b) { return b > 0; });
    }
};

/// A point of the edge holds its row where there is no matter. It does so too where the matter is not that which it has
/// cut last. Faces of a stretched body draw back, and the edge meets them elsewhere. Where all of it does, it leaps.
void hold_back(const Blade& blade, const Breaking& breaking, Edge& edge) {
    constexpr Real kAside = 1, kAhead = 3;  // rows
    const std::size_t n = edge.place.size();
    bool any = false, all = true;  // leap; leap, wait or are outside
    for (std::size_t k = 0; k < n; ++k) {
        const Vec3 way = edge.place[k] - blade.row[k];
        const Vec3 along = blade.row[std::min(k + 1, n - 1)] - blade.row[k > 0 ? k - 1 : 0];
        const Real aside = std::abs(along.cross(edge.ahead[k]).normalized().dot(way));
        const bool outside = edge.beyond[k] > 0, gapes = edge.gapes[k] != 0;
        const bool leaps =
            !gapes && !outside && (aside > kAside * breaking.row || edge.progress[k] > kAhead * breaking.row);
        any = any || leaps;
        all = all && (leaps || gapes || outside);
        if (leaps || gapes) edge.progress[k] = 0;
    }
    edge.leaps = any && all;
}

Edge edge_of(double time, const Blade& blade, const MaterialPlaces& places, const Breaking& breaking) {
    constexpr Real kNear = 4;  // supports
    const RigidPose pose = blade.motion.pose(time);
    const RigidVelocity moving = blade.motion.velocity(time);
    const Vec3 direction = (pose.rotation * blade.direction).cast<Real>();
    Edge edge;
    for (std::size_t k = 0; k < blade.edge.size(); ++k) {
        const Vec3d x = pose.apply(blade.edge[k]);
        const MaterialPlaces::Found found = places.at(x.cast<Real>());
        edge.place.push_back(found.m);
        edge.beyond.push_back(beyond_end(breaking, found.m));
        if (found.away < kNear * breaking.support) {
            const Vec3d own = moving.linear + moving.angular.cross(x - pose.translation);
            edge.near = true;
            edge.fastest = std::max(edge.fastest, (own.cast<Real>() - found.velocity).norm());
        }
        const Vec3 ahead = found.turn.transpose() * direction;
        edge.progress.push_back(blade.row.empty() ? Real(0) : ahead.dot(found.m - blade.row[k]));
        edge.ahead.push_back(ahead);
        edge.gapes.push_back(found.gapes);
    }
    if (!blade.row.empty()) hold_back(blade, breaking, edge);
    return edge;
}

/// The longest next step in which the edge goes no farther than `reach` [m] by its own motion, to a factor of two [s].
double step_within(double reach, double time, const Blade& blade) {
    constexpr int kSamples = 8;
    constexpr double kLongest = 0.1, kShortest = 1e-9;  // s
    const RigidPose now = blade.motion.pose(time);
    const auto goes_within = [&](double step) {
        for (int k = 1; k <= kSamples; ++k) {
            const RigidPose then = blade.motion.pose(time + step * k / kSamples);
            for (const Vec3d& x : {blade.edge.front(), blade.edge.back()})
                if ((then.apply(x) - now.apply(x)).norm() > reach) return false;
        }
        return true;
    };
    double step = kLongest;
    while (step > kShortest && !goes_within(step)) step /= 2;
    return step;
}

/// Begins a new cut where the edge is.
void begin_row(const Edge& edge, Blade& blade, Cracks& cracks) {
    const std::size_t n = edge.place.size();
    blade.crack = -1;
    blade.row = edge.place;
    blade.side = {};
    blade.vertex.assign(n, kNone);
    blade.rim.assign(n - 1, kNone);
    for (std::size_t k = 0; k < n; ++k)
        if (edge.beyond[k] <= 0) blade.vertex[k] = add_vertex(edge.place[k], cracks);
}

Index add_crossing(const Vec3& a, Real beyond_a, const Vec3& b, Real beyond_b, Cracks& cracks) {
    return add_vertex(a + beyond_a / (beyond_a - beyond_b) * (b - a), cracks);
}

/// Joins the last row to the edge of now, cell by cell: between two points and two rows. Cells are cut off where the body
/// ends. Neighbours share the vertices on their common side, so that the sheet has no holes.
void lay_cut_row(const Edge& edge, Blade& blade, const Breaking& breaking, Cracks& cracks) {
    const std::size_t n = edge.place.size();
    const auto inside = [&](std::size_t k) { return blade.vertex[k] != kNone; };
    std::vector<Vec3> to = edge.place;
    std::vector<Index> vertex(n, kNone), rim(n - 1, kNone), track(n, kNone);
    std::vector<Real> before(n), beyond = edge.beyond;
    std::vector<std::uint8_t> stays(n);
    for (std::size_t k = 0; k < n; ++k) {
        before[k] = beyond_end(breaking, blade.row[k]);
        stays[k] = edge.progress[k] <= 0;
        if (stays[k]) {
            to[k] = blade.row[k];
            vertex[k] = blade.vertex[k];
            beyond[k] = before[k];
            continue;
        }
        if (beyond[k] <= 0) vertex[k] = add_vertex(to[k], cracks);
        if (inside(k) != (vertex[k] != kNone))
            track[k] = add_crossing(blade.row[k], before[k], to[k], beyond[k], cracks);
    }
    const auto new_crack = [&] {
        blade.crack = static_cast<std::int32_t>(cracks.cracks.size());
        cracks.cracks.push_back({.source = breaking.source,
                                 .frame = breaking.frame,
                                 .sheet = kFirstCrackSheet + 2 * blade.crack,
                                 .strength = kUnbreakable});
    };
    for (std::size_t k = 0; k + 1 < n; ++k) {
        if ((vertex[k] != kNone) != (vertex[k + 1] != kNone))
            rim[k] = stays[k] && stays[k + 1] ? blade.rim[k]
                                              : add_crossing(to[k], beyond[k], to[k + 1], beyond[k + 1], cracks);
        const Index around[8] = {blade.vertex[k], blade.rim[k], blade.vertex[k + 1], track[k + 1],
                                 vertex[k + 1],   rim[k],       vertex[k],           track[k]};
        std::vector<Index> corners;
        for (const Index v : around)
            if (v != kNone && (corners.empty() || corners.back() != v)) corners.push_back(v);
        if (corners.size() < 3) continue;
        if (blade.crack < 0) new_crack();
        const Vec3 along = blade.row[k + 1] - blade.row[k], ahead = to[k] - blade.row[k] + to[k + 1] - blade.row[k + 1];
        for (std::size_t c = 1; c + 1 < corners.size(); ++c)
            add_triangle(blade.crack, {corners[0], corners[c], corners[c + 1]}, along, ahead, cracks);
    }
    blade.row = std::move(to);
    blade.vertex = std::move(vertex);
    blade.rim = std::move(rim);
}

CrackNode node_at(Index vertex, NodeState state, const Cracks& cracks) {
    return {.place = cracks.vertex[vertex], .vertex = vertex, .state = state};
}

void add_front(std::int32_t crack, std::vector<CrackNode> nodes, Cracks& cracks) {
    if (nodes.size() > 1) cracks.fronts.push_back({.crack = crack, .closed = 0, .nodes = std::move(nodes)});
}

/// The fronts of a cut: where the matter still holds, along the edge and the ways of its ends.
void set_fronts(Blade& blade, Cracks& cracks) {
    if (blade.crack < 0) return;
    std::erase_if(cracks.fronts, [&](const CrackFront& f) { return f.crack == blade.crack; });
    const std::size_t n = blade.vertex.size();
    std::vector<CrackNode> nodes;
    for (std::size_t k = 0; k < n; ++k) {
        if (blade.vertex[k] != kNone) nodes.push_back(node_at(blade.vertex[k], NodeState::inside, cracks));
        if (k + 1 < n && blade.rim[k] != kNone) nodes.push_back(node_at(blade.rim[k], NodeState::surface, cracks));
        if (k + 1 == n || (blade.rim[k] != kNone && blade.vertex[k] != kNone))
            add_front(blade.crack, std::exchange(nodes, {}), cracks);
    }
    for (std::size_t s = 0; s < 2; ++s) {
        std::vector<Index>& side = blade.side[s];
        const Index end = s == 0 ? blade.vertex.front() : blade.vertex.back();
        if (side.empty() || side.back() != end) side.push_back(end);
        nodes.clear();
        for (const Index v : side) {
            if (v != kNone)
                nodes.push_back(node_at(v, NodeState::inside, cracks));
            else
                add_front(blade.crack, std::exchange(nodes, {}), cracks);
        }
        add_front(blade.crack, std::move(nodes), cracks);
    }
}

void advance_blade(const Edge& edge, Blade& blade, const Breaking& breaking, Cracks& cracks) {
    constexpr Real kDue = Real(0.7);  // rows
    const bool cuts = std::ranges::any_of(blade.vertex, [](Index v) { return v != kNone; });
    const bool due = std::ranges::max(edge.progress) > kDue * breaking.row;
    if (due) {
        lay_cut_row(edge, blade, breaking, cracks);
        set_fronts(blade, cracks);
    }
    if (edge.leaps || (edge.outside() && (due || !cuts || std::ranges::max(edge.progress) <= 0)))
        begin_row(edge, blade, cracks);
}

}  // namespace

double advance_blades(double time, const CrackedMatter& matter, const Solids& solids, std::vector<Blade>& blades,
                      Cracks& cracks) {
    const Breaking& breaking = matter.breaking();
    const auto cuts = [&](const Blade& b) { return b.source == breaking.source && b.active(time); };
    if (matter.elements().empty() || std::ranges::none_of(blades, cuts)) return 1e30;
    const MaterialPlaces places(solids, matter);
    double longest = 1e30;
    for (Blade& blade : blades) {
        if (!cuts(blade)) continue;
        const Edge edge = edge_of(time, blade, places, breaking);
        const Real reach = edge.near ? breaking.row / 2 : 2 * breaking.support;
        longest = std::min(longest, step_within(static_cast<double>(reach), time, blade));
        if (edge.fastest > 0) longest = std::min(longest, static_cast<double>(breaking.row / (2 * edge.fastest)));
        if (!edge.near)
            blade.row.clear();
        else if (blade.row.empty())
            begin_row(edge, blade, cracks);
        else
            advance_blade(edge, blade, breaking, cracks);
    }
    return longest;
}

namespace {

/// Whether the straight way from a to b crosses the triangle p, q, r.
bool crosses(const Vec3& a, const Vec3& b, const Vec3& p, const Vec3& q, const Vec3& r) {
    const auto side = [](const Vec3& u, const Vec3& v, const Vec3& w) { return u.dot(v.cross(w)) > 0; };
    const Vec3 across = (q - p).cross(r - p);
    if (((a - p).dot(across) > 0) == ((b - p).dot(across) > 0)) return false;
    const bool first = side(b - a, p - a, q - a);
    return side(b - a, q - a, r - a) == first && side(b - a, r - a, p - a) == first;
}

}  // namespace

std::vector<WeakBond> severed_bonds(double time, double dt, const CrackedMatter& matter, const Solids& solids) {
    constexpr Real kLong = 2;  // lengths at rest
    const Elements& e = solids.elements;
    const std::vector<BodyPose> poses = poses_of(solids.bodies);
    std::vector<WeakBond> severed;
    for (const Blade& blade : solids.blades) {
        if (blade.source != matter.breaking().source || !blade.active(time) || blade.row.empty()) continue;
        const RigidPose before = blade.motion.pose(time - dt), now = blade.motion.pose(time);
        const auto passes = [&](Index i, Index j) {
            const BodyPose& pose = poses[static_cast<std::size_t>(e.owner[i])];
            const auto place = [&](Index k) -> Vec3 {
                return pose.turn * (xyz(e.rest[k]) + xyz(e.displacement[k])) + pose.place;
            };
            const Vec3 a = place(i), b = place(j);
            // As the bond sees it: it moves itself.
            const Vec3 moved = static_cast<Real>(dt) / 2 * (pose.turn * (xyz(e.velocity[i]) + xyz(e.velocity[j])));
            for (std::size_t k = 0; k + 1 < blade.edge.size(); ++k) {
                const Vec3 p = before.apply(blade.edge[k]).cast<Real>() + moved;
                const Vec3 q = before.apply(blade.edge[k + 1]).cast<Real>() + moved;
                const Vec3 r = now.apply(blade.edge[k]).cast<Real>(), s = now.apply(blade.edge[k + 1]).cast<Real>();
                if (crosses(a, b, p, q, r) || crosses(a, b, q, r, s)) return true;
            }
            return false;
        };
        for (const Index i : matter.elements())
            for (std::size_t k = e.bonds.begin[i]; k < e.bonds.begin[i + 1]; ++k) {
                const Index j = e.bonds.neighbour[k];
                if (j <= i || !(e.bonds.weight[k] > 0)) continue;
                const Vec3 r = xyz(e.rest[j]) - xyz(e.rest[i]), u = xyz(e.displacement[j]) - xyz(e.displacement[i]);
                if ((r + u).squaredNorm() > square(kLong) * r.squaredNorm() && passes(i, j))
                    severed.push_back({i, j, 0});
            }
    }
    return severed;
}

std::vector<Blade> make_blades(const scene::Scene& scene, const std::vector<Breaking>& breaking) {
    std::vector<Blade> blades;
    for (const scene::Blade& given : scene.blades) {
        const auto of = std::ranges::find_if(breaking, [&](const Breaking& b) {
            return scene.bodies[static_cast<std::size_t>(b.source)].name == given.body;
        });
        if (of == breaking.end()) throw InputError("blades.{}: body '{}' has no matter to cut", given.name, given.body);
        std::vector<Vec3> line;
        for (const scene::EdgePoint& point : given.edge) line.push_back(point.at.cast<Real>());
        Blade blade{.source = of->source,
                    .direction = given.direction.normalized(),
                    .motion = motion_of(scene, given.motion),
                    .start = given.start,
                    .stop = given.stop};
        for (const Vec3& x : even_steps(line, of->row, false)) blade.edge.push_back(x.cast<double>());
        blades.push_back(std::move(blade));
    }
    return blades;
}

}  // namespace thixo
