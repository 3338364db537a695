#include "render/surfel_blocks.h"

#include <oneapi/tbb/parallel_invoke.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <bit>
#include <numeric>
#include <tuple>

#include "pipeline/base/error.h"
#include "pipeline/base/parallel.h"

namespace thixo::render {
namespace {

bool usable(const SurfelCloud& cloud, Index i) {
    const float area = cloud.axis1[i].cross(cloud.axis2[i]).norm();
    return cloud.position[i].allFinite() && std::isfinite(area) && area > 0;
}

struct alignas(16) Place {
    float x[3];
    Index surfel;
};

/// By coordinate, then by surfel: one order whatever was before.
struct Along {
    int axis;
    bool operator()(const Place& a, const Place& b) const {
        return a.x[axis] < b.x[axis] || (a.x[axis] == b.x[axis] && a.surfel < b.surfel);
    }
};

struct Extent {
    int axis;  // the longest
    float lower, length;
};
Extent extent(std::span<const Place> places) {
    FourFloats lower = FourFloats{} + 3e38f, upper = -lower;
    for (const Place& p : places) {
        FourFloats x;
        std::memcpy(&x, &p, sizeof x);
        lower = smaller(lower, x);
        upper = larger(upper, x);
    }
    int axis = 0;
    for (int k = 1; k < 3; ++k)
        if (upper[k] - lower[k] > upper[axis] - lower[axis]) axis = k;
    return {axis, lower[axis], upper[axis] - lower[axis]};
}

/// Up to here a histogram costs more than it saves.
constexpr std::size_t kSmall = 96;

/// As std::nth_element into `to`, but without a branch to guess. A histogram sorts into what is below, in, and above
/// the bin of the median, which alone is then sorted out.
void part(std::span<const Place> from, std::span<Place> to, std::size_t middle, const Extent& e) {
    constexpr int bins = 64;
    std::array<std::uint32_t, bins + 1> ends{};
    const float scale = (bins - 0.01f) / e.length;
    const auto bin = [&](const Place& p) { return int((p.x[e.axis] - e.lower) * scale); };
    for (const Place& p : from) ++ends[std::size_t(bin(p)) + 1];
    int median = 0;
    for (; ends[std::size_t(median) + 1] <= middle; ++median)
        ends[std::size_t(median) + 2] += ends[std::size_t(median) + 1];
    Place* out[3] = {to.data(), to.data() + ends[std::size_t(median)], to.data() + ends[std::size_t(median) + 1]};
    for (const Place& p : from) {
        const int k = bin(p);
        *out[(k >= median) + (k > median)]++ = p;
    }
    std::nth_element(to.data() + ends[std::size_t(median)], to.data() + middle,
                     to.data() + ends[std::size_t(median) + 1], Along{e.axis});
}

/// By place: the order in which surfels were given leaves no trace in the sums over a block.
void sort_block(std::span<Place> places) {
    std::sort(places.begin(), places.end(), [](const Place& a, const Place& b) {
        return std::tuple(a.x[0], a.x[1], a.x[2], a.surfel) < std::tuple(b.x[0], b.x[1], b.x[2], b.surfel);
    });
}

/// Splits at the median of the longest side, in whole blocks, down to single blocks. Patches that are about square make
/// boxes that overlap little: a ray tests about half as many blocks as along a space-filling curve. `places` are in
/// `spare` after every large split; they end where they began.
void split(std::span<Place> places, std::span<Place> spare, bool in_spare) {
    const std::size_t count = places.size();
    if (in_spare && count <= kSmall) {
        std::copy(spare.begin(), spare.end(), places.begin());
        in_spare = false;
    }
    if (count <= kFloatLanes) return sort_block(places);
    const std::size_t middle = (count + kFloatLanes - 1) / kFloatLanes / 2 * kFloatLanes;
    const std::span<Place> now = in_spare ? spare : places;
    const Extent e = extent(now);
    if (count <= kSmall || !(e.length > 1e-30f && e.length < 1e30f)) {
        std::nth_element(now.begin(), now.begin() + std::ptrdiff_t(middle), now.end(), Along{e.axis});
    } else {
        part(now, in_spare ? places : spare, middle, e);
        in_spare = !in_spare;
    }
    const auto left = [&] { split(places.first(middle), spare.first(middle), in_spare); };
    const auto right = [&] { split(places.subspan(middle), spare.subspan(middle), in_spare); };
    if (count > 4096)
        oneapi::tbb::parallel_invoke(left, right);
    else {
        left();
        right();
    }
}

/// Surfels that can be seen, neighbours together.
std::vector<Place> spatial_order(const SurfelCloud& cloud) {
    constexpr std::size_t chunk = 1 << 14;
    std::vector<std::size_t> first((cloud.size() + chunk - 1) / chunk + 1, 0);
    std::vector<std::uint8_t> seen(cloud.size());
    parallel_chunks(
        cloud.size(),
        [&](std::size_t begin, std::size_t end, std::size_t c) {
            for (std::size_t i = begin; i < end; ++i) first[c + 1] += seen[i] = usable(cloud, Index(i));
        },
        chunk);
    std::partial_sum(first.begin(), first.end(), first.begin());
    std::vector<Place> places(first.back()), spare(first.back());
    parallel_chunks(
        cloud.size(),
        [&](std::size_t begin, std::size_t end, std::size_t c) {
            std::size_t at = first[c];
            for (std::size_t i = begin; i < end; ++i) {
                const Vec3f& x = cloud.position[i];
                if (seen[i]) places[at++] = {{x.x(), x.y(), x.z()}, Index(i)};
            }
        },
        chunk);
    thread_arena().execute([&] { split(places, spare, false); });
    return places;
}

/// Half of the box about a support.
Vec3f half_box(const Vec3f& t1, const Vec3f& t2, const Vec3f& n, float height) {
    return (square(kReach) * (t1.cwiseAbs2() + t2.cwiseAbs2()) + square(height) * n.cwiseAbs2()).cwiseSqrt();
}

void include(Box3& bounds, const Vec3f& centre, const Vec3f& half) {
    bounds.lower = bounds.lower.cwiseMin(centre - half);
    bounds.upper = bounds.upper.cwiseMax(centre + half);
}

/// Adds the support's box to `bounds`.
void set_lane(SurfelBlock& block, int lane, const SurfelCloud& cloud, Index i, std::uint32_t layer, const Vec3f& centre,
              Box3& bounds) {
    const Vec3f &t1 = cloud.axis1[i], &t2 = cloud.axis2[i];
    const Vec3f across = t1.cross(t2);
    const float area = across.norm(), height = kHeight * std::sqrt(t1.norm() * t2.norm());
    const Vec3f n = across / area;
    // Rows of the inverse of (kReach t1, kReach t2, height n): right also where t1 and t2 are not at right angles.
    const Vec3f to_unit[3] = {t2.cross(n) / (kReach * area), n.cross(t1) / (kReach * area), n / height};
    for (int k = 0; k < 3; ++k) {
        block.centre[k][lane] = centre[k];
        for (int row = 0; row < 3; ++row) block.to_unit[row][k][lane] = to_unit[row][k];
    }
    block.height[lane] = height;
    block.layer[lane] = layer;
    block.source[lane] = i;
    include(bounds, centre, half_box(t1, t2, n, height));
}

void clear_lane(SurfelBlock& block, int lane) {
    for (int k = 0; k < 3; ++k) {
        block.centre[k][lane] = 1e15f;  // nothing gets there
        for (int row = 0; row < 3; ++row) block.to_unit[row][k][lane] = row == k ? 1.0f : 0.0f;
    }
    block.height[lane] = 1;
    block.layer[lane] = 0;
    block.source[lane] = kNone;
}

BlockSummary summarise(const SurfelBlock& block, int lanes) {
    const auto normal = [&](int lane) {
        return Vec3f(block.height[lane] *
                     Vec3f(block.to_unit[2][0][lane], block.to_unit[2][1][lane], block.to_unit[2][2][lane]));
    };
    Vec3f lower = normal(0), upper = lower;
    std::uint32_t layer = block.layer[0];
    for (int lane = 1; lane < lanes; ++lane) {
        lower = lower.cwiseMin(normal(lane));
        upper = upper.cwiseMax(normal(lane));
        if (block.layer[lane] != layer) layer = kNone;
    }
    const Vec3f centre = 0.5f * (lower + upper);
    float radius2 = 0;
    for (int lane = 0; lane < lanes; ++lane) radius2 = std::max(radius2, (normal(lane) - centre).squaredNorm());
    // With room for the rounding of n.d and of what it is compared with.
    return {{centre.x(), centre.y(), centre.z()}, std::sqrt(radius2) + 1e-5f, layer};
}

/// How a patch of surfels turns by their velocities [rad/s]: its normal as the slope of the velocity has it, and itself
/// about that. Surfels that are not one patch, because they are far apart for their radii, tell nothing.
Vec3f angular_velocity(std::span<const Vec3f> place, std::span<const Vec3f> velocity, float radius) {
    constexpr float kFar = 2;  // radii, the root of their mean square from the middle
    if (place.size() < 4) return Vec3f::Zero();
    const auto mean = [](std::span<const Vec3f> v) {
        Vec3f sum = Vec3f::Zero();
        for (const Vec3f& x : v) sum += x;
        return Vec3f(sum / float(v.size()));
    };
    const Vec3f centre = mean(place), drift = mean(velocity);
    Mat3f spread = Mat3f::Zero(), product = Mat3f::Zero();
    for (std::size_t k = 0; k < place.size(); ++k) {
        spread += (place[k] - centre) * (place[k] - centre).transpose();
        product += (velocity[k] - drift) * (place[k] - centre).transpose();
    }
    Eigen::SelfAdjointEigenSolver<Mat3f> axes;
    axes.computeDirect(spread);
    const Vec3f &s = axes.eigenvalues(), n = axes.eigenvectors().col(0), a = axes.eigenvectors().col(1),
                b = axes.eigenvectors().col(2);
    if (!(s[2] < square(kFar * radius) * float(place.size()))) return Vec3f::Zero();
    if (!(s[1] > 1e-3f * s[2])) return Vec3f::Zero();  // in a line: nothing tells how it turns about that
    const Vec3f along_a = product * a / s[1], along_b = product * b / s[2];  // derivatives of the velocity
    const Vec3f tilting = -n.dot(along_a) * a - n.dot(along_b) * b;          // of the normal
    const float side = a.cross(b).dot(n) < 0 ? -1.0f : 1.0f;
    const Vec3f turn = n.cross(tilting) + side * 0.5f * (b.dot(along_a) - a.dot(along_b)) * n;
    return turn.allFinite() ? turn : Vec3f(Vec3f::Zero());
}

const Box3 kEmpty{Vec3f::Constant(3e38f), Vec3f::Constant(-3e38f)};

/// Packs the surfels of one block.
class Packing {
  public:
    Packing(const MovingSurfels& surfels, std::span<const std::uint32_t> layer, std::span<const Place> order,
            SurfelBlocks& packed)
        : surfels_(surfels), layer_(layer), order_(order), packed_(packed), moves_(surfels.move()) {}

    void pack(std::size_t b) const {
        const std::size_t first = b * kFloatLanes, lanes = std::min<std::size_t>(kFloatLanes, order_.size() - first);
        SurfelBlock& block = packed_.storage[b];
        packed_.bounds[b] = kEmpty;
        for (std::size_t lane = 0; lane < kFloatLanes; ++lane) {
            if (lane >= lanes) {
                clear_lane(block, int(lane));
                continue;
            }
            const Index i = order_[first + lane].surfel;
            const Vec3f place = surfels_.cloud.position[i] + surfels_.shutter.open * velocity(i);
            set_lane(block, int(lane), surfels_.cloud, i, layer_[i], place, packed_.bounds[b]);
        }
        packed_.summary[b] = summarise(block, int(lanes));
        if (moves_) set_moving(b, order_.subspan(first, lanes));
    }

  private:
    Vec3f velocity(Index i) const {
        return moves_ && surfels_.velocity[i].allFinite() ? surfels_.velocity[i] : Vec3f(0, 0, 0);
    }

    Vec3f normal(Index i) const { return surfels_.cloud.axis1[i].cross(surfels_.cloud.axis2[i]).normalized(); }

    /// How a surfel turns, by those of its block that may blend with it: of its layer, with normals within 60 degrees of
    /// its own.
    Vec3f angular(Index i, std::span<const Place> places) const {
        const std::uint32_t layer = layer_[i];
        if (layer < surfels_.angular.size() && surfels_.angular[layer]) return *surfels_.angular[layer];
        std::array<Vec3f, kFloatLanes> place, speed;
        std::size_t count = 0;
        float radius = 0;
        for (const Place& p : places) {
            if (layer_[p.surfel] != layer || normal(p.surfel).dot(normal(i)) < 0.5f) continue;
            place[count] = surfels_.cloud.position[p.surfel];
            speed[count++] = velocity(p.surfel);
            radius = std::max(radius, surfels_.cloud.axis1[p.surfel].norm());
        }
        return angular_velocity(std::span(place).first(count), std::span(speed).first(count), radius);
    }

    void set_moving(std::size_t b, std::span<const Place> places) const {
        const Shutter& shutter = surfels_.shutter;
        const float duration = shutter.close - shutter.open;
        const float longest = std::max(std::abs(shutter.open), std::abs(shutter.close));
        const SurfelBlock& block = packed_.storage[b];
        BlockMotion& motion = packed_.motion[b] = {};
        float most = 0, widest = 0;
        for (std::size_t lane = 0; lane < places.size(); ++lane) {
            const Index i = places[lane].surfel;
            const Vec3f speed = velocity(i), turning = angular(i, places);
            for (int a = 0; a < 3; ++a) {
                motion.way[a][int(lane)] = duration * speed[a];
                motion.angular[a][int(lane)] = turning[a];
            }
            most = std::max(most, longest * turning.norm());
            widest = std::max({widest, kReach * surfels_.cloud.axis1[i].norm(), kReach * surfels_.cloud.axis2[i].norm(),
                               block.height[int(lane)]});
        }
        packed_.summary[b].radius += most;
        // The ends of axes that turn lie in a ball about the centre.
        const Vec3f room = Vec3f::Constant(most > 0 ? widest : 0.0f);
        Box3& first = packed_.bounds[b];
        Box3& last = packed_.last_bounds[b] = kEmpty;
        for (const Place& p : places) {
            const Vec3f &t1 = surfels_.cloud.axis1[p.surfel], &t2 = surfels_.cloud.axis2[p.surfel];
            const Vec3f& x = surfels_.cloud.position[p.surfel];
            const Vec3f half =
                half_box(t1, t2, t1.cross(t2).normalized(), kHeight * std::sqrt(t1.norm() * t2.norm())).cwiseMax(room);
            include(first, x + shutter.open * velocity(p.surfel), half);
            include(last, x + shutter.close * velocity(p.surfel), half);
        }
    }

    const MovingSurfels& surfels_;
    std::span<const std::uint32_t> layer_;
    std::span<const Place> order_;
    SurfelBlocks& packed_;
    bool moves_;
};

/// Surfels that turn by more than kMostTurn from the frame's own time to when the shutter opens or closes.
std::size_t count_whirling(const SurfelBlocks& packed) {
    const float longest = std::max(std::abs(packed.shutter.open), std::abs(packed.shutter.close));
    return parallel_sum<std::size_t>(
        packed.bounds.size(),
        [&](std::size_t b) {
            const FloatLanes(&w)[3] = packed.motion[b].angular;
            const FloatLanes square = w[0] * w[0] + w[1] * w[1] + w[2] * w[2];
            return std::size_t(std::popcount(bits(square > kMostTurn * kMostTurn / (longest * longest))));
        },
        std::size_t(0));
}

}  // namespace

const SurfelBlock& SurfelBlocks::moved(Index block, float time, SurfelBlock& room) const {
    const BlockMotion& m = motion[block];
    room = storage[block];
    FloatLanes turn[3];
    for (int k = 0; k < 3; ++k) {
        room.centre[k] = multiply_add(m.way[k], float_lanes(time), room.centre[k]);
        turn[k] = m.angular[k] * shutter.seconds(time);
    }
    for (auto& row : room.to_unit) turn_by(turn, row);
    return room;
}

SurfelBlocks pack_surfels(const MovingSurfels& surfels, std::span<const std::uint32_t> layer) {
    const SurfelCloud& cloud = surfels.cloud;
    const bool moves = surfels.move();
    THIXO_ASSERT(layer.size() == cloud.size() && cloud.axis1.size() == cloud.size() &&
                     cloud.axis2.size() == cloud.size() && (!moves || surfels.velocity.size() == cloud.size()),
                 "{} surfels, {} layers, {} velocities", cloud.size(), layer.size(), surfels.velocity.size());
    const std::vector<Place> order = spatial_order(cloud);
    SurfelBlocks packed;
    packed.dropped = cloud.size() - order.size();
    packed.shutter = surfels.shutter;
    packed.bounds.resize((order.size() + kFloatLanes - 1) / kFloatLanes);
    packed.storage = std::make_unique_for_overwrite<SurfelBlock[]>(packed.bounds.size());
    packed.summary = std::make_unique_for_overwrite<BlockSummary[]>(packed.bounds.size());
    if (moves) {
        packed.motion = std::make_unique_for_overwrite<BlockMotion[]>(packed.bounds.size());
        packed.last_bounds.resize(packed.bounds.size());
    }
    const Packing packing(surfels, layer, order, packed);
    parallel_for(packed.bounds.size(), [&](std::size_t b) { packing.pack(b); });
    if (moves) packed.whirling = count_whirling(packed);
    return packed;
}

}  // namespace thixo::render
