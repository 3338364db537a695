// Embree's own oriented discs: the reference of the surfel benchmarks. Circles only, nothing is blended.
#pragma once

#include <embree3/rtcore.h>

#include "pipeline/geometry/surfel.h"

namespace thixo::bench {

class NativeDiscs {
  public:
    /// `filtered`: the contexts of rays may have a filter.
    explicit NativeDiscs(const SurfelCloud& cloud, bool filtered = false)
        : device_(rtcNewDevice("max_isa=avx2,start_threads=0")), scene_(rtcNewScene(device_)) {
        if (filtered) rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION);
        RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_ORIENTED_DISC_POINT);
        auto* points = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0,
                                                                   RTC_FORMAT_FLOAT4, 4 * sizeof(float), cloud.size()));
        auto* normals = static_cast<float*>(rtcSetNewGeometryBuffer(
            geometry, RTC_BUFFER_TYPE_NORMAL, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), cloud.size()));
        for (std::size_t i = 0; i < cloud.size(); ++i) {
            for (int k = 0; k < 3; ++k) {
                points[4 * i + std::size_t(k)] = cloud.position[i][k];
                normals[3 * i + std::size_t(k)] = cloud.normal[i][k];
            }
            points[4 * i + 3] = cloud.axis1[i].norm();
        }
        rtcCommitGeometry(geometry);
        rtcAttachGeometry(scene_, geometry);
        rtcReleaseGeometry(geometry);
        rtcCommitScene(scene_);
    }
    ~NativeDiscs() {
        rtcReleaseScene(scene_);
        rtcReleaseDevice(device_);
    }
    NativeDiscs(const NativeDiscs&) = delete;
    NativeDiscs& operator=(const NativeDiscs&) = delete;

    /// `context` may have a filter; without one the result is the nearest disc.
    bool intersect(const Vec3f& origin, const Vec3f& direction, float& t,
                   RTCIntersectContext* context = nullptr) const {
        RTCIntersectContext plain;
        if (!context) rtcInitIntersectContext(context = &plain);
        RTCRayHit ray;
        ray.ray = {origin.x(), origin.y(),  origin.z(), 0, direction.x(), direction.y(), direction.z(), 0,
                   1e30f,      0xffffffffu, 0,          0};
        ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        ray.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
        rtcIntersect1(scene_, context, &ray);
        t = ray.ray.tfar;
        return ray.hit.geomID != RTC_INVALID_GEOMETRY_ID;
    }

  private:
    RTCDevice device_;
    RTCScene scene_;
};

}  // namespace thixo::bench
