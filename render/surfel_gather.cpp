#include "render/surfel_gather.h"

#include <immintrin.h>

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

struct Crossing {  // of eight supports, in t
    __m256 enter, leave;
    __m256 plane;   // where the ray meets the disc's plane
    __m256 facing;  // n.d
    int hit;        // bit per lane: the support is crossed
    int disc;       // bit per lane: the disc itself is hit
};

Crossing cross(const SurfelBlock& block, const Ray& ray) {
    const __m256 dx = _mm256_set1_ps(ray.direction.x()), dy = _mm256_set1_ps(ray.direction.y()),
                 dz = _mm256_set1_ps(ray.direction.z());
    __m256 x = _mm256_sub_ps(_mm256_load_ps(block.centre[0]), _mm256_set1_ps(ray.origin.x()));
    __m256 y = _mm256_sub_ps(_mm256_load_ps(block.centre[1]), _mm256_set1_ps(ray.origin.y()));
    __m256 z = _mm256_sub_ps(_mm256_load_ps(block.centre[2]), _mm256_set1_ps(ray.origin.z()));
    // Measured from the ray's nearest point to the centre: far origins would cost all the digits of the discriminant.
    const __m256 near = _mm256_fmadd_ps(x, dx, _mm256_fmadd_ps(y, dy, _mm256_mul_ps(z, dz)));
    x = _mm256_fnmadd_ps(near, dx, x);
    y = _mm256_fnmadd_ps(near, dy, y);
    z = _mm256_fnmadd_ps(near, dz, z);
    __m256 p[3], e[3];  // centre and direction in the support's unit space
    for (int row = 0; row < 3; ++row) {
        const __m256 mx = _mm256_load_ps(block.to_unit[row][0]), my = _mm256_load_ps(block.to_unit[row][1]),
                     mz = _mm256_load_ps(block.to_unit[row][2]);
        p[row] = _mm256_fmadd_ps(mx, x, _mm256_fmadd_ps(my, y, _mm256_mul_ps(mz, z)));
        e[row] = _mm256_fmadd_ps(mx, dx, _mm256_fmadd_ps(my, dy, _mm256_mul_ps(mz, dz)));
    }
    const __m256 one = _mm256_set1_ps(1.0f);
    const __m256 a = _mm256_fmadd_ps(e[0], e[0], _mm256_fmadd_ps(e[1], e[1], _mm256_mul_ps(e[2], e[2])));
    const __m256 b = _mm256_fmadd_ps(e[0], p[0], _mm256_fmadd_ps(e[1], p[1], _mm256_mul_ps(e[2], p[2])));
    const __m256 c =
        _mm256_sub_ps(_mm256_fmadd_ps(p[0], p[0], _mm256_fmadd_ps(p[1], p[1], _mm256_mul_ps(p[2], p[2]))), one);
    const __m256 discriminant = _mm256_fnmadd_ps(a, c, _mm256_mul_ps(b, b));
    Crossing crossing;
    crossing.hit = _mm256_movemask_ps(_mm256_cmp_ps(discriminant, _mm256_setzero_ps(), _CMP_GT_OQ));
    if (crossing.hit == 0) return crossing;
    const __m256 root = _mm256_sqrt_ps(_mm256_max_ps(discriminant, _mm256_setzero_ps()));
    const __m256 inverse = _mm256_div_ps(one, a);
    crossing.enter = _mm256_fmadd_ps(_mm256_sub_ps(b, root), inverse, near);
    crossing.leave = _mm256_fmadd_ps(_mm256_add_ps(b, root), inverse, near);
    const __m256 plane = _mm256_div_ps(p[2], e[2]);  // inf or NaN for a ray in the plane: compares false below
    const __m256 u = _mm256_fnmadd_ps(plane, e[0], p[0]), v = _mm256_fnmadd_ps(plane, e[1], p[1]);
    const __m256 rim = _mm256_fmadd_ps(u, u, _mm256_mul_ps(v, v));
    crossing.disc = crossing.hit & _mm256_movemask_ps(_mm256_cmp_ps(rim, _mm256_set1_ps(kDisc2), _CMP_LT_OQ));
    crossing.plane = _mm256_add_ps(near, plane);
    crossing.facing = _mm256_mul_ps(e[2], _mm256_load_ps(block.height));
    const __m256 in_window = _mm256_and_ps(_mm256_cmp_ps(crossing.leave, _mm256_set1_ps(ray.tmin), _CMP_GE_OQ),
                                           _mm256_cmp_ps(crossing.enter, _mm256_set1_ps(ray.tmax), _CMP_LE_OQ));
    crossing.hit &= _mm256_movemask_ps(in_window);
    return crossing;
}

}  // namespace

void gather(const SurfelBlock& block, Index block_index, const Ray& ray, const Interior& interior,
            std::span<const Index> object, Candidates& found) {
    const Crossing crossing = cross(block, ray);
    if (crossing.hit == 0) return;
    alignas(32) float enter[kLanes], leave[kLanes], plane[kLanes], facing[kLanes];
    _mm256_store_ps(enter, crossing.enter);
    _mm256_store_ps(leave, crossing.leave);
    _mm256_store_ps(plane, crossing.plane);
    _mm256_store_ps(facing, crossing.facing);
    for (unsigned lanes = crossing.hit; lanes != 0; lanes &= lanes - 1) {
        const int lane = std::countr_zero(lanes);
        if (enter[lane] > found.end) continue;
        // A ray outside an object can only enter it, one inside only leave it: n.d towards the side it is going to.
        const bool inside = interior.count() > 0 && interior.contains(object[block.layer[lane]]);
        const float away = inside ? -facing[lane] : facing[lane];
        if (away > kLimitSine) continue;
        insert(found, {block_index * kLanes + Index(lane), enter[lane], leave[lane]}, ray.tmin);
        found.faced |= away < 0;
        if ((crossing.disc >> lane & 1) && away < 0 && plane[lane] >= ray.tmin)
            found.end = std::min(found.end, leave[lane]);
    }
}

}  // namespace thixo::render
