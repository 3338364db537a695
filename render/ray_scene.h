// What rays can hit in one frame: blended surfels and triangle meshes, in one Embree scene.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "pipeline/contract/trim.h"
#include "pipeline/geometry/mesh.h"
#include "pipeline/geometry/shape.h"
#include "pipeline/geometry/surfel.h"
#include "render/ray.h"
#include "render/shutter.h"

namespace thixo::render {

/// Surfels of all bodies. Arrays of attributes are empty or as long as the cloud.
struct SurfelSet {
    SurfelCloud cloud;
    std::vector<std::uint32_t> layer;           // per surfel: only surfels of one layer blend
    std::vector<Index> object;                  // per layer: the object it bounds
    std::vector<std::int32_t> sheet;            // per layer: which sheet of the object; none: 0
    std::vector<std::optional<TrimNode>> trim;  // per object, or none: over its layers
    std::vector<Vec3f> rest, velocity, colour;  // colour: of a mesh's vertices, linear; below 0 where there is none
    std::vector<float> temperature;
};

/// A mesh in world space. Vertex normals, where there are any, smooth the shading.
struct MeshObject {
    TriangleMesh mesh;
    Index object = 0;
    Mat3f to_own = Mat3f::Identity();  // world -> the mesh's own frame, with own_shift: for textures
    Vec3f own_shift{0, 0, 0};
    bool solid = false;  // closed and transparent: hit from outside by rays outside it, from inside by rays inside, as
                         // surfels are
    SteadyMotion motion;
};

/// Immutable after construction; intersect may be called from any number of threads.
class RayScene {
  public:
    /// Builds the acceleration structure on all threads. Throws ResourceError where Embree cannot, CacheError for a bad
    /// trim tree. While the shutter is open, surfels go on straight with their velocities and meshes turn with theirs.
    RayScene(SurfelSet surfels, std::vector<MeshObject> meshes, const Shutter& shutter = {});
    ~RayScene();
    RayScene(const RayScene&) = delete;
    RayScene& operator=(const RayScene&) = delete;

    /// The nearest hit in [tmin, tmax]. `interior` names the objects the ray is inside of. Surfels and solid meshes of
    /// those are hit from inside only, all others from outside only (docs/surfels.md). So rays may start a little
    /// before the surface they leave through. Finds the attributes where they are asked for.
    bool intersect(const Ray& ray, const Interior& interior, Hit& hit, bool attributes = false) const;

    /// Surfels left out because they have no finite, non-zero frame.
    std::size_t dropped_surfels() const;
    /// Surfels that turn too far while the shutter is open: their surface gapes (kMostTurn).
    std::size_t whirling_surfels() const;
    /// Box around the object's vertices and surfel discs, and a little more; lower > upper where it has none.
    const Box3& bounds(Index object) const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace thixo::render
