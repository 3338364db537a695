#include "sim/surface/contact_surface.h"

#include <algorithm>

#include "pipeline/base/parallel.h"
#include "sim/bonds/element_fit.h"
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
        if ((x.array() < box.lower.array()).any() || (x.array() > box.upper.array()).any()) return false;
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

std::vector<DrawnBody> drawn_bodies(const EmbeddedSurface& embedded, Solids& solids) {
    Contacts& c = solids.contacts;
    const Elements& e = solids.elements;
    const std::vector<BodyPose> poses = poses_of(solids.bodies);
    c.place.resize(e.size());
    c.grid.resize(solids.bodies.size());
    std::vector<DrawnBody> bodies;
    for (std::size_t b = 0; b < solids.bodies.size(); ++b) {
        const SolidBody& body = solids.bodies[b];
        Box3 box{Vec3::Constant(std::numeric_limits<Real>::max()), Vec3::Constant(std::numeric_limits<Real>::lowest())};
        std::vector<Vec3> place;
        place.reserve(body.size());
        for (const Index i : body.elements) {
            place.push_back(c.place[i] = poses[b].turn * (xyz(e.rest[i]) + xyz(e.displacement[i])) + poses[b].place);
            box.lower = box.lower.cwiseMin(c.place[i]);
            box.upper = box.upper.cwiseMax(c.place[i]);
        }
        const Real width = std::cbrt(e.volume[body.typical]);
        const Real reach = width * static_cast<Real>(std::sqrt(std::max(1.0, solids.stretch2)));
        box.lower.array() -= reach;
        box.upper.array() += reach;
        c.grid[b].build(place, e.support[body.typical]);
        const StressLaw& law = solids.laws[b];
        const Real modulus = law.mu * (3 * law.lambda + 2 * law.mu) / (law.lambda + law.mu);
        bodies.push_back({embedded, solids, b, poses[b], width, modulus, box});
    }
    return bodies;
}

struct Drawn {
    Vec3 place, normal;
    bool past_edge;  // of a sheet that reaches past its body's edge
};

/// The part of a sheet beyond its edge trims it, and must stay in its plane. Only surfels that face the surface they
/// are laid on move with the others.
bool stays(const Drawn& surfel, const Vec3& outward) {
    return surfel.past_edge && surfel.normal.dot(outward) > Real(-0.5);
}

/// The new place of a surfel of body a that has entered b; none where it has not.
std::optional<Drawn> on_contact_surface(const DrawnBody& a, const DrawnBody& b, const Drawn& surfel, ElementFit& fit) {
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
    return Drawn{place, n.squaredNorm() > 0 ? Vec3(n.normalized()) : surfel.normal, surfel.past_edge};
}

/// The new place of a surfel that has entered a wall: a wall does not give way, and its surface is the contact surface.
/// The surfel is `off` [m] before it, so that no two drawn surfaces coincide: through glass both are seen.
std::optional<Drawn> on_wall(const Wall& wall, const Drawn& surfel, Real off, WallMap::Cursor& cursor) {
    Vec3 n;
    const Real d = wall.map.distance(wall.to_wall(surfel.place), n, cursor);
    if (!(d < 0) || n.isZero()) return std::nullopt;
    n = wall.turn * n;
    if (stays(surfel, n)) return std::nullopt;
    return Drawn{surfel.place + (off - d) * n, -n, surfel.past_edge};
}

/// Moves a surfel. Faces that meet the surface at an edge go as far as it and keep their direction.
void move_surfel(const Drawn& to, std::size_t i, SurfelCloud& cloud) {
    cloud.position[i] = to.place;
    if (to.normal.dot(cloud.normal[i]) < Real(0.5)) return;
    const auto turn = Eigen::Quaternion<Real>::FromTwoVectors(cloud.normal[i], to.normal);
    cloud.axis1[i] = turn * cloud.axis1[i];
    cloud.axis2[i] = turn * cloud.axis2[i];
    cloud.normal[i] = to.normal;
}

/// The walls and bodies that a group of surfels may have entered.
struct Near {
    std::vector<std::size_t> walls, bodies;
};
void find_near(const std::vector<Vec3>& place, std::size_t begin, std::size_t end, const Walls& walls,
               const std::vector<DrawnBody>& bodies, WallCursor& cursor, Near& near) {
    Box3 box{place[begin], place[begin]};
    for (std::size_t i = begin + 1; i < end; ++i) {
        box.lower = box.lower.cwiseMin(place[i]);
        box.upper = box.upper.cwiseMax(place[i]);
    }
    const Vec3 middle = (box.lower + box.upper) / 2;
    const Real reach = (box.upper - box.lower).norm() / 2;
    near.walls.clear();
    near.bodies.clear();
    for (std::size_t w = 0; w < walls.list.size(); ++w) {
        const Wall& wall = walls.list[w];
        Vec3 n;
        // Distances are exact beside the wall alone.
        const Real d = wall.map.distance(wall.to_wall(middle), n, cursor.at[w]);
        if (!(d > reach + Real(0.1) * wall.map.support())) near.walls.push_back(w);
    }
    for (std::size_t b = 0; b < bodies.size(); ++b)
        if ((box.upper.array() >= bodies[b].box.lower.array()).all() &&
            (box.lower.array() <= bodies[b].box.upper.array()).all())
            near.bodies.push_back(b);
}

}  // namespace

void draw_contacts(const EmbeddedSurface& embedded, const std::vector<Index>& source, const Walls& walls,
                   Solids& solids, SurfaceState& surface) {
    const bool meet = solids.bodies.size() > 1 && !solids.laws.empty();
    if (!meet && walls.list.empty()) return;
    const std::vector<DrawnBody> bodies = meet ? drawn_bodies(embedded, solids) : std::vector<DrawnBody>{};
    SurfelCloud& cloud = surface.surfels;
    parallel_chunks(
        source.size(),
        [&](std::size_t begin, std::size_t end, std::size_t) {
            ElementFit fit;
            WallCursor cursor(walls);
            // Most surfels, and their neighbours, are far from all other matter.
            Near near;
            find_near(cloud.position, begin, end, walls, bodies, cursor, near);
            if (near.walls.empty() && near.bodies.empty()) return;
            for (std::size_t i = begin; i < end; ++i) {
                const Index root = source[i];
                const auto owner = static_cast<std::size_t>(embedded.owner[root]);
                const Real width = std::cbrt(solids.elements.volume[solids.bodies[owner].typical]);
                std::optional<bool> past_edge;
                const auto drawn = [&] {
                    if (!past_edge)
                        past_edge =
                            embedded.beyond[root] &&
                            std::abs(solids.bodies[owner].shape->distance(embedded.first[root])) > kOwnSurface * width;
                    return Drawn{cloud.position[i], cloud.normal[i], *past_edge};
                };
                for (const std::size_t b : near.bodies) {
                    const DrawnBody& other = bodies[b];
                    if (other.number == owner || !other.may_hold(cloud.position[i])) continue;
                    if (const auto to = on_contact_surface(bodies[owner], other, drawn(), fit))
                        move_surfel(*to, i, cloud);
                }
                for (const std::size_t w : near.walls) {
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
