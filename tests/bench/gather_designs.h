// Two ways to collect the surfels that a ray blends, without the blend.
#pragma once

#include <embree3/rtcore.h>

#include <memory>

#include "render/surfel_gather.h"
#include "tests/bench/native_discs.h"

namespace thixo::bench {

/// Embree's oriented discs, as wide as the supports. A filter notes every disc that is hit and shortens the search
/// behind the first. Discs are circles, and a ray that crosses a support beside its disc does not find it. So the speed
/// is an upper bound for a complete blend by this way.
class FilterGather {
  public:
    explicit FilterGather(SurfelCloud cloud) {
        for (Vec3f& axis : cloud.axis1) axis *= render::kReach;
        radius_.reserve(cloud.size());
        for (const Vec3f& axis : cloud.axis1) radius_.push_back(axis.norm());
        discs_ = std::make_unique<NativeDiscs>(cloud, true);
    }

    struct Query {
        RTCIntersectContext context;
        const float* radius;
        int count = 0;
        unsigned disc[64];
        float t[64];
    };

    /// Number of discs within the window of the first.
    int gather(const Vec3f& origin, const Vec3f& direction, Query& query) const {
        rtcInitIntersectContext(&query.context);
        query.context.filter = &note;
        query.radius = radius_.data();
        query.count = 0;
        float t;
        discs_->intersect(origin, direction, t, &query.context);
        return query.count;
    }

  private:
    static void note(const RTCFilterFunctionNArguments* args) {
        Query& query = *reinterpret_cast<Query*>(args->context);
        auto* ray = reinterpret_cast<RTCRay*>(args->ray);
        const auto* hit = reinterpret_cast<const RTCHit*>(args->hit);
        if (query.count == 64) return;
        query.disc[query.count] = hit->primID;
        query.t[query.count++] = ray->tfar;
        // The search may end later than an accepted hit, because the window extends behind the nearest disc.
        float end = 1e30f;
        for (int i = 0; i < query.count; ++i) end = std::min(end, query.t[i] + 2 * query.radius[query.disc[i]]);
        ray->tfar = end;
    }

    std::vector<float> radius_;
    std::unique_ptr<NativeDiscs> discs_;
};

/// Blocks of eight surfels as primitives of a user geometry, as the renderer collects them.
class BlockGather {
  public:
    explicit BlockGather(const SurfelCloud& cloud)
        : packed_(render::pack_surfels({cloud}, std::vector<std::uint32_t>(cloud.size(), 0))),
          device_(rtcNewDevice("max_isa=avx2,start_threads=0")),
          scene_(rtcNewScene(device_)) {
        RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_USER);
        rtcSetGeometryUserPrimitiveCount(geometry, unsigned(packed_.bounds.size()));
        rtcSetGeometryUserData(geometry, this);
        rtcSetGeometryBoundsFunction(geometry, &bounds, nullptr);
        rtcSetGeometryIntersectFunction(geometry, &meet);
        rtcCommitGeometry(geometry);
        rtcAttachGeometry(scene_, geometry);
        rtcReleaseGeometry(geometry);
        rtcCommitScene(scene_);
    }
    ~BlockGather() {
        rtcReleaseScene(scene_);
        rtcReleaseDevice(device_);
    }
    BlockGather(const BlockGather&) = delete;
    BlockGather& operator=(const BlockGather&) = delete;

    /// Number of blocks with candidates in the first window.
    int gather(const render::Ray& ray) const {
        const render::Interior nothing;
        const render::Gathering from{packed_, ray, nothing, {}};
        Query query;
        rtcInitIntersectContext(&query.context);
        query.from = &from;
        RTCRayHit found;
        found.ray = {ray.origin.x(),
                     ray.origin.y(),
                     ray.origin.z(),
                     0,
                     ray.direction.x(),
                     ray.direction.y(),
                     ray.direction.z(),
                     0,
                     1e30f,
                     0xffffffffu,
                     0,
                     0};
        found.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        found.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
        rtcIntersect1(scene_, &query.context, &found);
        render::complete(from, query.candidates);
        return query.candidates.row_count;
    }

  private:
    struct Query {
        RTCIntersectContext context;
        const render::Gathering* from;
        render::Candidates candidates;
    };
    static void bounds(const RTCBoundsFunctionArguments* args) {
        const Box3& b = static_cast<const BlockGather*>(args->geometryUserPtr)->packed_.bounds[args->primID];
        *args->bounds_o = {b.lower.x(), b.lower.y(), b.lower.z(), 0, b.upper.x(), b.upper.y(), b.upper.z(), 0};
    }
    static void meet(const RTCIntersectFunctionNArguments* args) {
        Query& query = *reinterpret_cast<Query*>(args->context);
        render::gather(*query.from, args->primID, query.candidates);
        float& tfar = reinterpret_cast<RTCRayHit*>(args->rayhit)->ray.tfar;
        tfar = std::min(tfar, query.candidates.end);
    }

    render::SurfelBlocks packed_;
    RTCDevice device_;
    RTCScene scene_;
};

}  // namespace thixo::bench
