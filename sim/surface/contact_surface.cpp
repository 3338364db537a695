#include "sim/surface/contact_surface.h"

#include <algorithm>

#include "pipeline/base/parallel.h"
#include "sim/bonds/element_fit.h"
#include "sim/contact/broad.h"
#include "sim/contact/contact.h"

namespace thixo {
namespace {

constexpr Real kExact = Real(1e-4);     // error of places, in particle widths
constexpr Real kOffWall = Real(0.005);  // in particle widths
constexpr Real kOwnSurface =
    Real(0.1);  // distance of a surfel from its body's shape beyond which it is past an edge, in widths

struct Distance {
    Real value = 0;        // < 0 inside [m]
    Vec3 normal{0, 0, 0};  // outward
};

/// A body deformed as it is drawn.
struct DrawnBody {
    const EmbeddedSurface& embedded;
    const Solids& solids;
    std::size_t number;
    BodyPose pose;
    Real width, modulus;  // of an element [m], E [Pa]
    Box3 box;             // holds all of it

    /// Solves m + u(m) = x in the body's frame, by Newton's method with the fit's slope.
    Vec3 material(const Vec3& x, ElementFit& fit) const {
        const SolidBody& body = solids.bodies[number];
        const Elements& e = solids.elements;
        const Real support = e.support[body.typical];
        fit_elements<std::vector<Vec3>>({body, e, solids.contacts.place, solids.contacts.grid[number], pose.turn},
                                        support, x, fit);
        Vec3 m = fit.material;
        for (int k = 0; k < 8; ++k) {
            const auto u = displacement_at(embedded, solids, number, m, support);
            if (!u) break;
            const Vec3 step = fit.slope * (x - pose.turn * (m + *u) - pose.place);
            m += step;
            if (!(step.squaredNorm() > square(kExact * width))) break;
        }
        return m + body.origin;
    }
    /// False where no element is near enough for x to lie inside.
    bool may_hold(const Vec3& x) const {
        if (gap_of(box, {x, x}) > 0) return false;
        return near_matter(solids, solids.bodies[number], solids.contacts.grid[number], x);
    }
    bool holds(const Vec3& x, ElementFit& fit) const {
        return solids.bodies[number].shape->distance(material(x, fit)) < 0;
    }
    Distance distance(const Vec3& x, ElementFit& fit) const {
        const Shape& shape = *solids.bodies[number].shape;
        const Vec3 m = material(x, fit);
        const Vec3 slope = fit.slope.transpose() * shape.gradient(m, width / 64);
        const Real steep = slope.norm();
        if (!(steep > 0)) return {shape.distance(m), Vec3(0, 0, 0)};
        return {shape.distance(m) / steep, slope / steep};
    }
};

/// All bodies, in the order of the solids. A body without elements or without a shape holds nothing: its box is empty.
std::vector<DrawnBody> drawn_bodies(const EmbeddedSurface& embedded, Solids& solids) {
    Contacts& c = solids.contacts;
    const Elements& e = solids.elements;
    const std::vector<BodyPose> poses = poses_of(solids.bodies);
    c.place.resize(e.size());
    c.grid.resize(solids.bodies.size());
    const Real stretch = static_cast<Real>(std::sqrt(std::max(1.0, solids.stretch2)));
    std::vector<DrawnBody> bodies;
    for (std::size_t b = 0; b < solids.bodies.size(); ++b) {
        const SolidBody& body = solids.bodies[b];
        DrawnBody drawn{embedded, solids, b, poses[b], 0, 0, {Vec3::Constant(1), Vec3::Constant(-1)}};
        if (!body.empty() && body.shape) {
            const Extent extent = extent_of(body, poses[b], e, c.place);
            const StressLaw& law = solids.laws[b];
            drawn.width = extent.width;
            drawn.modulus = law.mu * (3 * law.lambda + 2 * law.mu) / (law.lambda + law.mu);
            const Real reach = extent.width * stretch;
            drawn.box = {extent.box.lower.array() - reach, extent.box.upper.array() + reach};
        }
        bodies.push_back(drawn);
    }
    return bodies;
}

/// The bodies that may hold a surfel of each body: the boxes of the one's surfels and of the other's matter touch.
/// Builds the grids of bodies that have partners.
Partners drawn_partners(const std::vector<DrawnBody>& bodies, const EmbeddedSurface& embedded,
                        const std::vector<Index>& source, const SurfelCloud& cloud, Solids& solids) {
    std::vector<Box3> boxes;
    for (const DrawnBody& body : bodies) boxes.push_back(body.box);
    for (std::size_t i = 0; i < source.size(); ++i) {
        const auto owner = static_cast<std::size_t>(embedded.owner[source[i]]);
        if (boxes[owner].lower.x() > boxes[owner].upper.x()) continue;
        boxes[owner].lower = boxes[owner].lower.cwiseMin(cloud.position[i]);
        boxes[owner].upper = boxes[owner].upper.cwiseMax(cloud.position[i]);
    }
    const Partners partners = touching_partners(boxes);
    for (std::size_t b = 0; b < bodies.size(); ++b)
        if (!partners.of(b).empty()) build_grid(static_cast<std::int32_t>(b), solids);
    return partners;
}

struct Laid {
    Vec3 place, normal;
    bool past_edge;  // of a sheet that reaches past its body's edge
};

/// The part of a sheet beyond its edge trims it, and must stay in its plane. Only surfels that face the surface they
/// are laid on move with the others.
bool stays(const Laid& surfel, const Vec3& outward) {
    return surfel.past_edge && surfel.normal.dot(outward) > Real(-0.5);
}

/// The new place of a surfel of body a that has entered b; none where it has not.
std::optional<Laid> on_contact_surface(const DrawnBody& a, const DrawnBody& b, const Laid& surfel, ElementFit& fit) {
    if (!b.holds(surfel.place, fit)) return std::nullopt;
    const Distance entered = b.distance(surfel.place, fit);
    if (entered.normal.isZero() || stays(surfel, entered.normal)) return std::nullopt;
    // psi_b, the way out.
    Vec3 out = surfel.place;
    Distance left = entered;
    for (int k = 0; k < 4 && std::abs(left.value) > kExact * b.width; ++k) {
        out -= left.value * left.normal;
        left = b.distance(out, fit);
    }
    // Past its body's edge the plane of the sheet takes the place of the body.
    const auto own = [&](const Vec3& x) {
        return surfel.past_edge ? Distance{surfel.normal.dot(x - surfel.place), surfel.normal} : a.distance(x, fit);
    };
    const auto potential = [&](Real t) {
        const Vec3 x = surfel.place + t * (out - surfel.place);
        return b.modulus * b.distance(x, fit).value - a.modulus * own(x).value;
    };
    Real low = 0, high = 1, at_low = potential(0), at_high = potential(1);
    if (!(at_low < 0)) high = 0;
    if (!(at_high > 0)) low = 1;
    // Regula falsi, by halves where one end stays (Illinois).
    const Real length = (out - surfel.place).norm();
    Real t = at_low < 0 ? 1 : 0;
    for (int k = 0; k < 20 && (high - low) * length > kExact * b.width; ++k) {
        t = low - at_low * (high - low) / (at_high - at_low);
        const Real at = potential(t);
        if (std::abs(at) <= kExact * b.width * (a.modulus + b.modulus)) break;
        if (at < 0) {
            low = t, at_low = at;
            at_high /= 2;
        } else {
            high = t, at_high = at;
            at_low /= 2;
        }
    }
    const Vec3 place = surfel.place + t * (out - surfel.place);
    const Vec3 n = a.modulus * own(place).normal - b.modulus * b.distance(place, fit).normal;
    return Laid{place, n.squaredNorm() > 0 ? Vec3(n.normalized()) : surfel.normal, surfel.past_edge};
}

/// The new place of a surfel that has entered a wall: a wall does not give way, and its surface is the contact surface.
/// The surfel is `off` [m] before it, so that no two drawn surfaces coincide: through glass both are seen.
std::optional<Laid> on_wall(const Wall& wall, const Laid& surfel, Real off, WallMap::Cursor& cursor) {
    Vec3 n;
    const Real d = wall.map.distance(wall.to_wall(surfel.place), n, cursor);
    if (!(d < 0) || n.isZero()) return std::nullopt;
    n = wall.turn * n;
    if (stays(surfel, n)) return std::nullopt;
    return Laid{surfel.place + (off - d) * n, -n, surfel.past_edge};
}

/// Moves a surfel. Faces that meet the surface at an edge go as far as it and keep their direction.
void move_surfel(const Laid& to, std::size_t i, SurfelCloud& cloud) {
    cloud.position[i] = to.place;
    if (to.normal.dot(cloud.normal[i]) < Real(0.5)) return;
    const auto turn = Eigen::Quaternion<Real>::FromTwoVectors(cloud.normal[i], to.normal);
    cloud.axis1[i] = turn * cloud.axis1[i];
    cloud.axis2[i] = turn * cloud.axis2[i];
    cloud.normal[i] = to.normal;
}

Box3 box_of(const std::vector<Vec3>& place, std::size_t begin, std::size_t end) {
    Box3 box{place[begin], place[begin]};
    for (std::size_t i = begin + 1; i < end; ++i) {
        box.lower = box.lower.cwiseMin(place[i]);
        box.upper = box.upper.cwiseMax(place[i]);
    }
    return box;
}
/// Finds the walls near a box.
void find_near_walls(const Box3& box, const Walls& walls, WallCursor& cursor, std::vector<std::size_t>& near) {
    const Vec3 middle = (box.lower + box.upper) / 2;
    const Real reach = (box.upper - box.lower).norm() / 2;
    near.clear();
    for (std::size_t w = 0; w < walls.list.size(); ++w) {
        const Wall& wall = walls.list[w];
        Vec3 n;
        // Distances are exact beside the wall alone.
        const Real d = wall.map.distance(wall.to_wall(middle), n, cursor.at[w]);
        if (!(d > reach + Real(0.1) * wall.map.support())) near.push_back(w);
    }
}
/// Finds the bodies near a box that touch one of the owners of its surfels, ascending. `owner(i)` is that of surfel i.
template <class Owner>
void find_near_bodies(const Box3& box, std::size_t begin, std::size_t end, Owner&& owner, const Partners& partners,
                      const std::vector<DrawnBody>& bodies, std::vector<std::size_t>& near) {
    near.clear();
    for (std::size_t i = begin; i < end; ++i) {
        if (i > begin && owner(i) == owner(i - 1)) continue;
        for (const std::int32_t b : partners.of(owner(i)))
            if (gap_of(box, bodies[static_cast<std::size_t>(b)].box) <= 0) near.push_back(static_cast<std::size_t>(b));
    }
    std::ranges::sort(near);
    near.erase(std::ranges::unique(near).begin(), near.end());
}

}  // namespace

void draw_contacts(const EmbeddedSurface& embedded, const std::vector<Index>& source, const Walls& walls,
                   Solids& solids, SurfaceState& surface) {
    const bool meet = solids.bodies.size() > 1 && !solids.laws.empty();
    if (!meet && walls.list.empty()) return;
    SurfelCloud& cloud = surface.surfels;
    const auto owner_of = [&](std::size_t i) { return static_cast<std::size_t>(embedded.owner[source[i]]); };
    const std::vector<DrawnBody> bodies = meet ? drawn_bodies(embedded, solids) : std::vector<DrawnBody>{};
    const Partners partners = meet ? drawn_partners(bodies, embedded, source, cloud, solids) : Partners{};
    parallel_chunks(
        source.size(),
        [&](std::size_t begin, std::size_t end, std::size_t) {
            ElementFit fit;
            WallCursor cursor(walls);
            // Most surfels, and their neighbours, are far from all other matter.
            const Box3 box = box_of(cloud.position, begin, end);
            std::vector<std::size_t> near_walls, near_bodies;
            find_near_walls(box, walls, cursor, near_walls);
            if (meet) find_near_bodies(box, begin, end, owner_of, partners, bodies, near_bodies);
            if (near_walls.empty() && near_bodies.empty()) return;
            for (std::size_t i = begin; i < end; ++i) {
                const Index root = source[i];
                const std::size_t owner = owner_of(i);
                const Real width = std::cbrt(solids.elements.volume[solids.bodies[owner].typical]);
                std::optional<bool> past_edge;
                const auto drawn = [&] {
                    if (!past_edge)
                        past_edge =
                            embedded.beyond[root] && solids.bodies[owner].shape &&
                            std::abs(solids.bodies[owner].shape->distance(embedded.first[root])) > kOwnSurface * width;
                    return Laid{cloud.position[i], cloud.normal[i], *past_edge};
                };
                for (const std::size_t b : near_bodies) {
                    const DrawnBody& other = bodies[b];
                    if (b == owner || partners.of(owner).empty() || !other.may_hold(cloud.position[i])) continue;
                    if (const auto to = on_contact_surface(bodies[owner], other, drawn(), fit))
                        move_surfel(*to, i, cloud);
                }
                for (const std::size_t w : near_walls) {
                    const Wall& wall = walls.list[w];
                    Vec3 n;
                    if (!(wall.map.distance(wall.to_wall(cloud.position[i]), n, cursor.at[w]) < 0)) continue;
                    if (const auto to = on_wall(wall, drawn(), kOffWall * width, cursor.at[w]))
                        move_surfel(*to, i, cloud);
                }
            }
        },
        128);
}

}  // namespace thixo
