#include "sim/space/wall_map.h"

#include <cmath>
#include <limits>

#include "pipeline/base/error.h"
#include "pipeline/geometry/kernels.h"

namespace thixo {
namespace {

// Blocks have 21 bits an axis. Places beyond are folded onto the outermost block. No scene of metres comes near.
constexpr std::int32_t kLimit = (1 << 20) - 1;
std::int32_t block_coordinate(Real v) {
    const Real f = std::floor(v);
    return static_cast<std::int32_t>(f > Real(-kLimit) ? (f < Real(kLimit) ? f : Real(kLimit)) : Real(-kLimit));
}
std::uint64_t block_key(std::int32_t i, std::int32_t j, std::int32_t k) {
    const auto part = [](std::int32_t v) { return static_cast<std::uint64_t>(v + kLimit + 1); };
    return part(k) << 42 | part(j) << 21 | part(i);
}

// A solid is flat where its distance is linear to this part of the support. The error of the integrals is then smaller
// than that of the tables. To the second part of it, it is a plane, and a block needs no more than the plane.
constexpr Real kFlatness = Real(1e-3);
constexpr Real kPlaneness = Real(2e-5);

// Radius, in supports, of concave edges of the implicit solver's walls. In a sharp edge a particle has the full share
// of each wall. Its neighbours hold it too tightly to come to rest, and it shakes all others. A square tank at rest
// then has 11 mm/s. With the edges rounded to one spacing, which is less than the particles resolve, it has less than 2
// mm/s.
constexpr Real kFillet = Real(0.5);

}  // namespace

WallIntegrals half_space_integrals(Real distance, Real support) {
    // The kernels' densities along the normal, m(z), are integrals over planes. With q = |distance|/h and p = 1 - q:
    //     poly6: 315/(256 h) (1 - q^2)^4    spiky: 30/h (p^4/4 - p^5/5)    lap visc: 90/h^3 (1/6 - q^2/2 + q^3/3)
    WallIntegrals w;
    w.distance = distance;
    const Real q = std::abs(distance) / support;
    if (q >= 1) {
        if (distance < 0) {
            w.share = 1;
            w.laplacian = 15 / square(support);
        }
        return w;
    }
    const Real p = 1 - q, q2 = q * q;
    const auto primitive = [](Real z) {
        const Real z2 = z * z;
        return z * (1 + z2 * (Real(-4.0 / 3) + z2 * (Real(6.0 / 5) + z2 * (Real(-4.0 / 7) + z2 / 9))));
    };
    const Real beyond = Real(315.0 / 256) * (primitive(1) - primitive(q));
    const Real laplacian = 90 / square(support) * (Real(1.0 / 12) - q / 6 + q2 * q / 6 - q2 * q2 / 12);
    w.share = distance < 0 ? 1 - beyond : beyond;
    w.laplacian = distance < 0 ? 15 / square(support) - laplacian : laplacian;
    w.gradient = Vec3(0, 0, -30 / support * p * p * p * p * (Real(0.25) - p / 5));
    return w;
}

WallMap::WallMap(Shape solid, Real support)
    : solid_(std::move(solid)),
      support_(support),
      cell_(support / kCells),
      sample_(support / kReach),
      pages_(std::make_unique<Table>()) {
    static_assert(kFine * kCells == kReach, "a block is one support wide");
    make_stencil();
}

WallMap::WallMap(Shape solid, const WallKernel& kernel) : WallMap(std::move(solid), kernel.support) {
    kernel_ = kernel;
}

void WallMap::make_stencil() {
    const Poly6 poly6(support_);
    const Spiky spiky(support_);
    const ViscosityKernel viscosity(support_);
    const Real volume = cube(sample_);
    double total = 0, laplacian_total = 0;
    for (int z = -kReach; z < kReach; ++z)
        for (int y = -kReach; y < kReach; ++y) {
            StencilRow row{y, z, 0, 0, weights_.size()};
            for (int x = -kReach; x < kReach; ++x) {
                const Vec3 r = -sample_ * Vec3(Real(x) + Real(0.5), Real(y) + Real(0.5),
                                               Real(z) + Real(0.5));  // from sample to node
                const Real length = r.norm();
                if (length >= support_) continue;
                if (row.x1 == row.x0) row.x0 = x;
                row.x1 = x + 1;
                const Vec3 g = spiky.derivative(length) / length * r;
                weights_.push_back({poly6.value(length * length) * volume, g.x() * volume, g.y() * volume,
                                    g.z() * volume, viscosity.laplacian(length) * volume});
                total += weights_.back().share;
                laplacian_total += weights_.back().laplacian;
            }
            if (row.x1 > row.x0) rows_.push_back(row);
        }
    // The sums of a filled ball are known exactly: 1 and 15/h^2.
    for (Weight& w : weights_) {
        w.share = static_cast<Real>(w.share / total);
        w.laplacian = static_cast<Real>(w.laplacian * (15.0 / square(static_cast<double>(support_))) / laplacian_total);
    }
}

WallMap::Page::~Page() {
    for (const auto& block : blocks) delete block.load();
}

/// The deviation of the distance from a linear function, within the kernel's reach of a block [m].
Real WallMap::unevenness(const Vec3& centre, Real& distance, Vec3& normal) const {
    const Real reach = support_ * Real(1.5);  // half a block and the kernel
    distance = solid_.distance(centre);
    normal = solid_.gradient(centre, support_ / 4);
    Real worst = 0;
    for (int z = -1; z <= 1; ++z)
        for (int y = -1; y <= 1; ++y)
            for (int x = -1; x <= 1; ++x) {
                const Vec3 offset = reach * Vec3(Real(x), Real(y), Real(z));
                worst = std::max(worst, std::abs(solid_.distance(centre + offset) - distance - normal.dot(offset)));
            }
    return worst;
}

std::vector<Real> WallMap::occupancy(const Vec3& origin) const {
    // Samples are taken in cubes of 4^3. A cube whose centre is farther from the surface than its corners is full or
    // empty.
    constexpr int kCube = 4;
    static_assert(kSide % kCube == 0);
    std::vector<Real> filled(static_cast<std::size_t>(kSide) * kSide * kSide);
    const Vec3 first = origin - Vec3::Constant(sample_ * kReach);
    const Real reach = sample_ * (kCube * Real(0.8661) + 1);
    for (int z = 0; z < kSide; z += kCube)
        for (int y = 0; y < kSide; y += kCube)
            for (int x = 0; x < kSide; x += kCube) {
                const Real d = solid_.distance(
                    first + sample_ * (Vec3(Real(x), Real(y), Real(z)) + Vec3::Constant(Real(kCube) / 2)));
                for (int c = z; c < z + kCube; ++c)
                    for (int b = y; b < y + kCube; ++b)
                        for (int a = x; a < x + kCube; ++a) {
                            Real part = d < 0 ? Real(1) : Real(0);
                            if (std::abs(d) <= reach) {
                                const Vec3 s =
                                    first + sample_ * (Vec3(Real(a), Real(b), Real(c)) + Vec3::Constant(Real(0.5)));
                                part = clamp01(Real(0.5) - solid_.distance(s) / sample_);
                            }
                            filled[static_cast<std::size_t>((c * kSide + b) * kSide + a)] = part;
                        }
            }
    return filled;
}

WallIntegrals WallMap::sum(const std::vector<Real>& filled, int i, int j, int k) const {
    const int cx = kReach + kFine * i, cy = kReach + kFine * j, cz = kReach + kFine * k;
    WallIntegrals out;
    for (const StencilRow& row : rows_) {
        const Real* f = filled.data() + ((cz + row.z) * kSide + cy + row.y) * kSide + cx + row.x0;
        const Weight* w = weights_.data() + row.first;
        for (int x = 0; x < row.x1 - row.x0; ++x) {
            out.share += f[x] * w[x].share;
            out.gradient += f[x] * Vec3(w[x].x, w[x].y, w[x].z);
            out.laplacian += f[x] * w[x].laplacian;
        }
    }
    return out;
}

WallMap::Block WallMap::make_block(const Vec3& origin) const {
    Block b;
    const Vec3 centre = origin + Vec3::Constant(support_ / 2);
    const Real half_diagonal = Real(0.8661) * support_;
    const Real d = solid_.distance(centre);
    if (d - half_diagonal >= support_) {
        b.far = d - half_diagonal;
        return b;
    }
    Real centre_distance = 0, nearest = std::numeric_limits<Real>::max();
    Vec3 normal;
    const Real uneven = unevenness(centre, centre_distance, normal);
    // Distances far from the origin are rounded more coarsely.
    const Real rounding = 16 * std::numeric_limits<Real>::epsilon() * centre.cwiseAbs().maxCoeff();
    if (uneven <= kPlaneness * support_ + rounding) {
        b.normal = normal;
        b.offset = centre_distance - normal.dot(centre);
        return b;
    }
    b.nodes.resize(kNodes * kNodes * kNodes);
    const bool half_space = uneven <= kFlatness * support_;
    b.flat = half_space;
    const std::vector<Real> filled = half_space ? std::vector<Real>{} : occupancy(origin);
    for (int k = 0; k < kNodes; ++k)
        for (int j = 0; j < kNodes; ++j)
            for (int i = 0; i < kNodes; ++i) {
                const Vec3 x = origin + cell_ * Vec3(Real(i), Real(j), Real(k));
                const Real distance = solid_.distance(x);
                WallIntegrals w = half_space ? half_space_integrals(distance, support_) : sum(filled, i, j, k);
                if (half_space) w.gradient = w.gradient.z() * normal;
                b.nodes[static_cast<std::size_t>((k * kNodes + j) * kNodes + i)] = {
                    {distance, w.share, w.laplacian, w.gradient.x(), w.gradient.y(), w.gradient.z(), 0, 0}};
                nearest = std::min(nearest, distance);
            }
    if (nearest >= support_) {
        b.far = std::max(support_, nearest - cell_ / 8);
        b.nodes = {};
    }
    return b;
}

/// The block that holds x. `inside` becomes the place of x in it, in blocks.
const WallMap::Block& WallMap::block_at(const Vec3& x, Cursor& cursor, Vec3& inside) const {
    const Vec3 s = x / support_;
    const std::int32_t i = block_coordinate(s.x()), j = block_coordinate(s.y()), k = block_coordinate(s.z());
    const Vec3 corner{Real(i), Real(j), Real(k)};
    inside = s - corner;
    const std::uint64_t key = block_key(i >> kPageBits, j >> kPageBits, k >> kPageBits);
    if (key != cursor.key) {
        auto found = pages_->find(key);
        if (found == pages_->end()) found = pages_->emplace(key, std::make_unique<Page>()).first;
        cursor.key = key;
        cursor.page = found->second.get();
    }
    constexpr int mask = kPage - 1;
    auto& slot = cursor.page->blocks[static_cast<std::size_t>(((k & mask) * kPage + (j & mask)) * kPage + (i & mask))];
    const Block* block = slot.load(std::memory_order_acquire);
    if (block) return *block;
    // Two threads may make the same block: both blocks are equal, and the second is dropped.
    auto made = std::make_unique<const Block>(make_block(support_ * corner));
    if (slot.compare_exchange_strong(block, made.get(), std::memory_order_acq_rel)) block = made.release();
    return *block;
}

WallMap::Place WallMap::place(const Vec3& inside) {
    Place p{};
    for (int a = 0; a < 3; ++a) {
        const Real v = inside[a] * Real(kCells);
        const Real clamped = v > 0 ? std::min(v, Real(kCells)) : Real(0);  // NaN too: the health check names it
        p.cell[static_cast<std::size_t>(a)] = std::min(static_cast<int>(clamped), kCells - 1);
        p.part[a] = clamped - static_cast<Real>(p.cell[static_cast<std::size_t>(a)]);
    }
    return p;
}

WallIntegrals WallMap::at(const Vec3& x, Cursor& cursor) const {
    WallIntegrals out;
    if ((x - cursor.centre).squaredNorm() < cursor.radius2) {
        out.distance = support_;
        return out;
    }
    Vec3 inside;
    const Block& block = block_at(x, cursor, inside);
    if (block.far > 0) {
        out.distance = block.far;
        cursor.centre = x;
        cursor.radius2 = square(Real(0.999) * (block.far - support_));
        return out;
    }
    if (block.plane()) {
        const Real d = block.normal.dot(x) + block.offset;
        out = half_space_integrals(d, support_);
        out.gradient = out.gradient.z() * block.normal;
        if (kernel_ && d < support_) {
            out.share = kernel_->share(d);
            out.gradient = kernel_->slope(d) * block.normal;
        }
        return out;
    }
    const Place p = place(inside);
    const Node* corner = block.nodes.data() + (p.cell[2] * kNodes + p.cell[1]) * kNodes + p.cell[0];
    Node sum{};
    for (int c = 0; c < 8; ++c) {
        const int i = c & 1, j = c >> 1 & 1, k = c >> 2;
        const Real weight =
            (i ? p.part.x() : 1 - p.part.x()) * (j ? p.part.y() : 1 - p.part.y()) * (k ? p.part.z() : 1 - p.part.z());
        const Node& n = corner[(k * kNodes + j) * kNodes + i];
        for (int a = 0; a < 8; ++a) sum.value[a] += weight * n.value[a];
    }
    WallIntegrals w{sum.value[0], sum.value[1], Vec3(sum.value[3], sum.value[4], sum.value[5]), sum.value[2]};
    if (kernel_) take_rounded_planes(x, block, w);
    return w;
}

/// The shortest u that moves x to at least `radius` from every plane:
///     n_k.u >= radius - d_k      [m]
/// It is a least squares problem with bounds. The active planes are tried one, two, three at a time.
Vec3 WallMap::way_off(const Planes& planes, Real radius) {
    Vec3 best = Vec3::Zero();
    Real shortest = std::numeric_limits<Real>::max();
    const auto plane = [&](int k) -> const Plane& { return planes.list[static_cast<std::size_t>(k)]; };
    const auto missing = [&](int k) { return radius - plane(k).distance; };
    const auto consider = [&](const Vec3& u) {
        const Real slack = Real(1e-4) * radius;
        for (int k = 0; k < planes.count; ++k)
            if (plane(k).normal.dot(u) < missing(k) - slack) return;
        if (u.squaredNorm() < shortest) {
            shortest = u.squaredNorm();
            best = u;
        }
    };
    consider(Vec3::Zero());
    for (int a = 0; a < planes.count; ++a) {
        const Vec3& na = plane(a).normal;
        consider(missing(a) * na);
        for (int b = a + 1; b < planes.count; ++b) {
            const Vec3& nb = plane(b).normal;
            const Real c = na.dot(nb), sine2 = 1 - c * c;
            if (sine2 < Real(1e-4)) continue;
            consider(((missing(a) - c * missing(b)) * na + (missing(b) - c * missing(a)) * nb) / sine2);
        }
    }
    if (planes.count == 3) {
        Mat3 normals;
        Vec3 e;
        for (int k = 0; k < 3; ++k) {
            normals.row(k) = plane(k).normal.transpose();
            e[k] = missing(k);
        }
        if (std::abs(normals.determinant()) > Real(1e-2)) consider(normals.inverse() * e);
    }
    return best;
}

void WallMap::take_rounded_planes(const Vec3& x, const Block& block, WallIntegrals& w) const {
    const Planes near = planes_near(block, x, w.distance, w.gradient);
    w.share = 0;
    w.gradient.setZero();
    const Real radius = kFillet * support_;
    const Vec3 u = way_off(near, radius);
    const Real length = u.norm();
    if (length > 0) {
        w.share = kernel_->share(radius - length);
        w.gradient = kernel_->slope(radius - length) * u / length;
    } else if (near.count > 0) {
        const Plane& nearest = near.list[0];
        w.share = kernel_->share(nearest.distance);
        w.gradient = kernel_->slope(nearest.distance) * nearest.normal;
    }
}

/// The face nearest to x, whose distance is `distance` [m]; its normal is not a number where there is none. As far from
/// two faces, differences give a mean of their normals, which is that of no wall. Then one of the two is taken, as it is
/// seen from beside.
WallMap::Plane WallMap::nearest_face(const Vec3& x, Real distance) const {
    const Real step = support_ / 512,
               rounding = 4 * std::numeric_limits<Real>::epsilon() * x.cwiseAbs().maxCoeff();  // of distances [m]
    Vec3 slope;
    const auto differs = [&](const Vec3& at, Real d) {  // whether slopes before and behind a place differ
        Real bend = 0;
        for (int k = 0; k < 3; ++k) {
            const Vec3 way = step * Vec3::Unit(k);
            const Real ahead = solid_.distance(at + way), behind = solid_.distance(at - way);
            slope[k] = ahead - behind;
            bend = std::max(bend, std::abs(ahead + behind - 2 * d));
        }
        slope.normalize();
        return !slope.allFinite() || bend > Real(0.004) * step + rounding;
    };
    if (!differs(x, distance)) return {distance, slope};
    const Vec3 between = slope;
    for (int k = 0; k < 6; ++k) {
        const Vec3 aside = (k < 3 ? 4 : -4) * step * Vec3::Unit(k % 3);
        const Real there = solid_.distance(x + aside);
        if (!differs(x + aside, there)) return {there - slope.dot(aside), slope};
    }
    return {distance, between};
}

/// The planes of the wall near x. `distance` and `gradient` (of the share, away from the room) are those of the table.
/// They are exact enough where the wall is flat.
WallMap::Planes WallMap::planes_near(const Block& block, const Vec3& x, Real distance, const Vec3& gradient) const {
    const Real h = support_;
    Planes out;
    const auto add = [&](Real d, const Vec3& normal) {
        if (d < h) out.list[static_cast<std::size_t>(out.count++)] = {d, normal};
    };
    if (block.flat) {
        const Vec3 towards =
            -gradient.normalized();  // of a flat wall the normal; not a number where the gradient is zero
        if (towards.allFinite()) add(distance, towards);
        return out;
    }
    const Real nearest = solid_.distance(x);
    if (nearest >= h) return out;
    const auto [d1, n1] = nearest_face(x, nearest);
    if (!n1.allFinite()) return out;
    add(d1, n1);
    // Where no other wall is nearer a support farther on, the wall has no concave edge within reach.
    const Real margin = h / 64;
    const Vec3 beyond = x + h * n1;
    const Real second = solid_.distance(beyond);
    if (second >= d1 + h - margin) return out;
    const auto [seen, n2] = nearest_face(beyond, second);
    const Real along = n1.dot(n2), d2 = seen - h * along;
    if (!n2.allFinite()) return out;
    add(d2, n2);
    if (along < Real(-0.9) || d2 >= h) return out;
    const Vec3 edge = (n1 + n2) / (1 + along);
    const Vec3 corner = x + h * edge;
    const Real third = solid_.distance(corner);
    if (third >= std::min(d1, d2) + h - margin) return out;
    const auto [left, n3] = nearest_face(corner, third);
    if (n3.allFinite()) add(left - h * edge.dot(n3), n3);
    return out;
}

Real WallMap::distance(const Vec3& x, Vec3& normal, Cursor& cursor) const {
    Vec3 inside;
    const Block& block = block_at(x, cursor, inside);
    normal = block.normal;  // zero where there is no plane
    if (block.far > 0) return block.far;
    if (block.plane()) return block.normal.dot(x) + block.offset;
    const Place p = place(inside);
    Real distance = 0;
    for (int c = 0; c < 8; ++c) {
        const int i = c & 1, j = c >> 1 & 1, k = c >> 2;
        const Real wx = i ? p.part.x() : 1 - p.part.x(), wy = j ? p.part.y() : 1 - p.part.y(),
                   wz = k ? p.part.z() : 1 - p.part.z();
        const Real d =
            block.nodes[static_cast<std::size_t>(((p.cell[2] + k) * kNodes + p.cell[1] + j) * kNodes + p.cell[0] + i)]
                .value[0];
        distance += wx * wy * wz * d;
        normal += d * Vec3(i ? wy * wz : -wy * wz, j ? wx * wz : -wx * wz, k ? wx * wy : -wx * wy);
    }
    const Real length = normal.norm();
    if (length > 0) normal /= length;
    if (distance > support_ / 4) return distance;
    // Close to the surface the shape itself gives the distance: between nodes on the two sides of a thin wall the table
    // has no surface.
    const Vec3 exact_normal = solid_.gradient(x, support_ / 64);
    if (!exact_normal.isZero()) normal = exact_normal;
    return solid_.distance(x);
}

}  // namespace thixo
