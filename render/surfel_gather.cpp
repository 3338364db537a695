#include "render/surfel_gather.h"

#include <algorithm>
#include <bit>

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

/// Product of a row of M, or of the normal, with a vector.
FloatLanes dot(const FloatLanes (&m)[3], FloatLanes x, FloatLanes y, FloatLanes z) {
    return multiply_add(m[0], x, multiply_add(m[1], y, m[2] * z));
}

/// Lanes whose supports the ray crosses within [tmin, end]; `disc`: whose discs it hits. Fills all of the row but block
/// and lanes.
unsigned cross(const SurfelBlocks& packed, Index index, const Ray& ray, float end, Row& row, unsigned& disc) {
    SurfelBlock room;
    const SurfelBlock& block = packed.at(index, ray.time, room);
    const FloatLanes dx = float_lanes(ray.direction.x()), dy = float_lanes(ray.direction.y()),
                     dz = float_lanes(ray.direction.z());
    FloatLanes e[3];  // direction in the support's unit space
    e[2] = dot(block.to_unit[2], dx, dy, dz);
    row.facing = e[2] * block.height;
    FloatLanes x = block.centre[0] - float_lanes(ray.origin.x()), y = block.centre[1] - float_lanes(ray.origin.y()),
               z = block.centre[2] - float_lanes(ray.origin.z());
    // Measured from the ray's nearest point to the centre: far origins would cost all the digits of the discriminant.
    row.near = multiply_add(x, dx, multiply_add(y, dy, z * dz));
    x = negative_multiply_add(row.near, dx, x);
    y = negative_multiply_add(row.near, dy, y);
    z = negative_multiply_add(row.near, dz, z);
    FloatLanes p[3];  // centre in the support's unit space
    for (int k = 0; k < 3; ++k) {
        p[k] = dot(block.to_unit[k], x, y, z);
        if (k < 2) e[k] = dot(block.to_unit[k], dx, dy, dz);
    }
    row.a = multiply_add(e[0], e[0], multiply_add(e[1], e[1], e[2] * e[2]));
    row.b = multiply_add(e[0], p[0], multiply_add(e[1], p[1], e[2] * p[2]));
    row.c = multiply_add(p[0], p[0], multiply_add(p[1], p[1], p[2] * p[2])) - 1.0f;
    const FloatLanes discriminant = negative_multiply_add(row.a, row.c, row.b * row.b);
    const LaneMask crossed = discriminant > 0;
    if (bits(crossed) == 0) return 0;
    const FloatLanes half = root(positive(discriminant)), inverse = 1.0f / row.a;
    row.enter = multiply_add(row.b - half, inverse, row.near);
    row.leave = multiply_add(row.b + half, inverse, row.near);
    const FloatLanes plane = p[2] / e[2];  // inf or NaN for a ray in the plane: compares false below
    const FloatLanes u = negative_multiply_add(plane, e[0], p[0]), v = negative_multiply_add(plane, e[1], p[1]);
    row.plane = row.near + plane;
    disc = bits((multiply_add(u, u, v * v) < kDisc2) & (row.plane >= ray.tmin));
    return bits(crossed & (row.leave >= ray.tmin) & (row.enter <= end));
}

/// Lanes whose object the ray is inside of.
unsigned inside_lanes(const Gathering& from, Index block) {
    if (from.interior.count() == 0) return 0;
    const auto inside = [&](std::uint32_t layer) { return from.interior.contains(from.object[layer]); };
    const std::uint32_t layer = from.packed.summary[block].layer;
    if (layer != kNone) return inside(layer) ? 0xffu : 0;
    unsigned lanes = 0;
    for (int lane = 0; lane < kFloatLanes; ++lane)
        if (inside(from.packed.storage[block].layer[lane])) lanes |= 1u << lane;
    return lanes;
}

/// A bound of n.d, measured towards the side the ray is going to: no normal of the block has less.
float most_facing(const BlockSummary& block, const Vec3f& d, bool inside) {
    const float along = block.centre[0] * d.x() + block.centre[1] * d.y() + block.centre[2] * d.z();
    return (inside ? -along : along) - block.radius;
}

void add_to_list(Candidates& found, const Row& row, float tmin) {
    for (unsigned lanes = row.lanes; lanes != 0; lanes &= lanes - 1) {
        const int lane = std::countr_zero(lanes);
        if (row.enter[lane] <= found.end)
            insert(found, {row.block * kFloatLanes + Index(lane), row.enter[lane], row.leave[lane]}, tmin);
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
    const Ray& ray = from.ray;
    if (!found.listed && found.row_count == Candidates::kRows) found.make_list(ray.tmin);
    Row beyond;
    Row& row = found.listed ? beyond : found.rows[found.row_count];
    unsigned disc = 0;
    row.lanes = cross(from.packed, block_index, ray, std::min(ray.tmax, found.end), row, disc);
    if (row.lanes == 0) return;
    // A ray outside an object can only enter it, one inside only leave it: n.d towards the side it is going to.
    unsigned facing = row.lanes & bits(row.facing < 0);
    if (inside != 0) facing = (facing & ~inside) | (row.lanes & inside & bits(row.facing > 0));
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
