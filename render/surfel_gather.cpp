#include "render/surfel_gather.h"

#include <algorithm>
#include <bit>

#include "render/lanes.h"

namespace thixo::render {
namespace {

/// Rim of the disc in the support's unit ball, squared.
constexpr float kDisc2 = 1.0f / (kReach * kReach);

/// Keeps the candidates that begin first; the window ends where the first dropped one begins. Of more than that many
/// which all hold the window's beginning (surfels heaped up in one place), those of the lowest index do for all.
void insert(Candidates& found, const Candidate& candidate, float tmin) {
    if (found.count < Candidates::kCapacity) {
        found.list[found.count++] = candidate;
        return;
    }
    const auto begin = [&](const Candidate& c) { return std::max(c.enter, tmin); };
    const auto later = [&](const Candidate& a, const Candidate& b) {
        return begin(a) > begin(b) || (begin(a) == begin(b) && a.surfel > b.surfel);
    };
    int last = 0;
    for (int i = 1; i < found.count; ++i)
        if (later(found.list[i], found.list[last])) last = i;
    Candidate dropped = candidate;
    if (later(found.list[last], candidate)) std::swap(dropped, found.list[last]);
    if (begin(dropped) > tmin) found.end = std::min(found.end, begin(dropped));
}

/// Lanes whose supports the ray crosses within [tmin, end]; `disc`: whose discs it hits. Fills all of the row but block
/// and lanes.
unsigned cross(const SurfelBlock& block, const Ray& ray, float end, Row& row, unsigned& disc) {
    const __m256 dx = _mm256_set1_ps(ray.direction.x()), dy = _mm256_set1_ps(ray.direction.y()),
                 dz = _mm256_set1_ps(ray.direction.z());
    const __m256* const normal = reinterpret_cast<const __m256*>(block.to_unit[2]);
    const __m256 along = _mm256_fmadd_ps(normal[0], dx, _mm256_fmadd_ps(normal[1], dy, _mm256_mul_ps(normal[2], dz)));
    row.facing = _mm256_mul_ps(along, _mm256_load_ps(block.height));
    __m256 x = _mm256_sub_ps(_mm256_load_ps(block.centre[0]), _mm256_set1_ps(ray.origin.x()));
    __m256 y = _mm256_sub_ps(_mm256_load_ps(block.centre[1]), _mm256_set1_ps(ray.origin.y()));
    __m256 z = _mm256_sub_ps(_mm256_load_ps(block.centre[2]), _mm256_set1_ps(ray.origin.z()));
    // Measured from the ray's nearest point to the centre: far origins would cost all the digits of the discriminant.
    const __m256 near = _mm256_fmadd_ps(x, dx, _mm256_fmadd_ps(y, dy, _mm256_mul_ps(z, dz)));
    x = _mm256_fnmadd_ps(near, dx, x);
    y = _mm256_fnmadd_ps(near, dy, y);
    z = _mm256_fnmadd_ps(near, dz, z);
    __m256 p[3], e[3];  // centre and direction in the support's unit space
    e[2] = along;
    for (int k = 0; k < 3; ++k) {
        const __m256 mx = _mm256_load_ps(block.to_unit[k][0]), my = _mm256_load_ps(block.to_unit[k][1]),
                     mz = _mm256_load_ps(block.to_unit[k][2]);
        p[k] = _mm256_fmadd_ps(mx, x, _mm256_fmadd_ps(my, y, _mm256_mul_ps(mz, z)));
        if (k < 2) e[k] = _mm256_fmadd_ps(mx, dx, _mm256_fmadd_ps(my, dy, _mm256_mul_ps(mz, dz)));
    }
    const __m256 one = _mm256_set1_ps(1.0f);
    const __m256 a = _mm256_fmadd_ps(e[0], e[0], _mm256_fmadd_ps(e[1], e[1], _mm256_mul_ps(e[2], e[2])));
    const __m256 b = _mm256_fmadd_ps(e[0], p[0], _mm256_fmadd_ps(e[1], p[1], _mm256_mul_ps(e[2], p[2])));
    const __m256 c =
        _mm256_sub_ps(_mm256_fmadd_ps(p[0], p[0], _mm256_fmadd_ps(p[1], p[1], _mm256_mul_ps(p[2], p[2]))), one);
    const __m256 discriminant = _mm256_fnmadd_ps(a, c, _mm256_mul_ps(b, b));
    const __m256 crossed = _mm256_cmp_ps(discriminant, _mm256_setzero_ps(), _CMP_GT_OQ);
    if (bits(crossed) == 0) return 0;
    const __m256 root = _mm256_sqrt_ps(_mm256_max_ps(discriminant, _mm256_setzero_ps()));
    const __m256 inverse = _mm256_div_ps(one, a);
    row.enter = _mm256_fmadd_ps(_mm256_sub_ps(b, root), inverse, near);
    row.leave = _mm256_fmadd_ps(_mm256_add_ps(b, root), inverse, near);
    row.near = near;
    row.a = a;
    row.b = b;
    row.c = c;
    const __m256 plane = _mm256_div_ps(p[2], e[2]);  // inf or NaN for a ray in the plane: compares false below
    const __m256 u = _mm256_fnmadd_ps(plane, e[0], p[0]), v = _mm256_fnmadd_ps(plane, e[1], p[1]);
    const __m256 rim = _mm256_fmadd_ps(u, u, _mm256_mul_ps(v, v));
    row.plane = _mm256_add_ps(near, plane);
    disc = bits(_mm256_and_ps(_mm256_cmp_ps(rim, _mm256_set1_ps(kDisc2), _CMP_LT_OQ),
                              _mm256_cmp_ps(row.plane, _mm256_set1_ps(ray.tmin), _CMP_GE_OQ)));
    return bits(_mm256_and_ps(crossed, _mm256_and_ps(_mm256_cmp_ps(row.leave, _mm256_set1_ps(ray.tmin), _CMP_GE_OQ),
                                                     _mm256_cmp_ps(row.enter, _mm256_set1_ps(end), _CMP_LE_OQ))));
}

/// Lanes whose object the ray is inside of.
unsigned inside_lanes(const Gathering& from, Index block) {
    if (from.interior.count() == 0) return 0;
    const auto inside = [&](std::uint32_t layer) { return from.interior.contains(from.object[layer]); };
    const std::uint32_t layer = from.packed.summary[block].layer;
    if (layer != kNone) return inside(layer) ? 0xffu : 0;
    unsigned lanes = 0;
    for (int lane = 0; lane < kLanes; ++lane)
        if (inside(from.packed.storage[block].layer[lane])) lanes |= 1u << lane;
    return lanes;
}

/// No more than this n.d have the normals of a block, measured towards the side the ray is going to, of those that look
/// most against it.
float most_facing(const BlockSummary& block, const Vec3f& d, bool inside) {
    const float along = block.centre[0] * d.x() + block.centre[1] * d.y() + block.centre[2] * d.z();
    return (inside ? -along : along) - block.radius;
}

void add_to_list(Candidates& found, const Row& row, float tmin) {
    alignas(32) float enter[kLanes], leave[kLanes];
    _mm256_store_ps(enter, row.enter);
    _mm256_store_ps(leave, row.leave);
    for (unsigned lanes = row.lanes; lanes != 0; lanes &= lanes - 1) {
        const int lane = std::countr_zero(lanes);
        if (enter[lane] <= found.end) insert(found, {row.block * kLanes + Index(lane), enter[lane], leave[lane]}, tmin);
    }
}

}  // namespace

void Candidates::make_list(float tmin) {
    if (listed) return;
    listed = true;
    for (int i = 0; i < row_count; ++i) add_to_list(*this, rows[i], tmin);
    row_count = 0;
}

namespace {

void gather_lanes(const Gathering& from, Index block_index, unsigned inside, Candidates& found) {
    const SurfelBlock& block = from.packed.storage[block_index];
    const Ray& ray = from.ray;
    if (!found.listed && found.row_count == Candidates::kRows) found.make_list(ray.tmin);
    Row beyond;
    Row& row = found.listed ? beyond : found.rows[found.row_count];
    unsigned disc = 0;
    row.lanes = cross(block, ray, std::min(ray.tmax, found.end), row, disc);
    if (row.lanes == 0) return;
    // A ray outside an object can only enter it, one inside only leave it: n.d towards the side it is going to.
    const __m256 zero = _mm256_setzero_ps();
    unsigned facing = row.lanes & bits(_mm256_cmp_ps(row.facing, zero, _CMP_LT_OQ));
    if (inside != 0)
        facing = (facing & ~inside) | (row.lanes & inside & bits(_mm256_cmp_ps(row.facing, zero, _CMP_GT_OQ)));
    found.faced |= facing != 0;
    if ((disc & facing) != 0) found.end = std::min(found.end, least(row.leave, disc & facing));
    row.block = block_index;
    if (found.listed)
        add_to_list(found, row, ray.tmin);
    else
        ++found.row_count;
}

}  // namespace

void gather(const Gathering& from, Index block, Candidates& found) {
    const unsigned inside = inside_lanes(from, block);
    const BlockSummary& summary = from.packed.summary[block];
    if (inside == 0 || summary.layer != kNone) {
        const float facing = most_facing(summary, from.ray.direction, inside != 0);
        // What a ray has just bounced off is met by most of them and serves few.
        if (facing >= 0 && found.averted_count < Candidates::kAverted) {
            found.averted[found.averted_count++] = block;
            return;
        }
    }
    gather_lanes(from, block, inside, found);
}

bool complete(const Gathering& from, Candidates& found) {
    if (!found.faced) return false;
    for (int i = 0; i < found.averted_count; ++i)
        gather_lanes(from, found.averted[i], inside_lanes(from, found.averted[i]), found);
    int candidates = 0;
    for (int i = 0; i < found.row_count; ++i) candidates += std::popcount(found.rows[i].lanes);
    if (candidates > Candidates::kCapacity) found.make_list(from.ray.tmin);
    return true;
}

}  // namespace thixo::render
