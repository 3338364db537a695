#include "render/ray_scene.h"

#include <embree3/rtcore.h>

#include <algorithm>

#include "pipeline/base/error.h"
#include "pipeline/base/parallel.h"
#include "render/surfel_blend.h"

namespace thixo::render {
namespace {

constexpr unsigned kSurfelGeometry = 0;
const Box3 kNothing{Vec3f::Constant(3e38f), Vec3f::Constant(-3e38f)};

/// A bound on the rounding of a position of this size [m]. A ray that leaves there must step over it.
float rounding(const Vec3f& position) { return 4e-6f * std::max(position.cwiseAbs().maxCoeff(), 1e-3f); }

/// Embree's ray context with what the surfel callback collects. The base comes first: Embree hands it back by address.
struct Query {
    RTCIntersectContext context;
    const Gathering* from;
    Candidates candidates;
};

void throw_if_failed(RTCDevice device) {
    const RTCError error = rtcGetDeviceError(device);
    if (error == RTC_ERROR_NONE) return;
    if (error == RTC_ERROR_OUT_OF_MEMORY)
        throw ResourceError("out of memory for the ray tracer; use a smaller scene or a machine with more");
    throw ResourceError("Embree failed with error {}; is this machine without AVX2?", int(error));
}

RTCDevice make_device() {
    // One instruction set on every machine: equal bytes. No thread count: Embree follows the limit of the process.
    RTCDevice device = rtcNewDevice("max_isa=avx2,start_threads=0");
    if (!device) throw ResourceError("Embree could not start (error {})", int(rtcGetDeviceError(nullptr)));
    return device;
}

template <class T>
void free_memory(std::vector<T>& v) {
    std::vector<T>().swap(v);  // v = {} would keep it
}

}  // namespace

struct RayScene::Impl {
    SurfelSet surfels;
    Trims trims;
    SurfelBlocks packed;
    std::vector<MeshObject> meshes;  // geometry id less one
    std::vector<Box3> bounds;        // by object
    Shutter shutter;
    RTCDevice device = nullptr;
    RTCScene scene = nullptr;

    Impl(SurfelSet surfel_set, std::vector<MeshObject> objects, const Shutter& open)
        : surfels(std::move(surfel_set)), meshes(std::move(objects)), shutter(open.moves() ? open : Shutter()) {
        MovingSurfels moving{surfels.cloud, surfels.velocity, shutter};
        trims = Trims(surfels.trim, surfels.object, surfels.layer, surfels.cloud,
                      moving.move() ? moving.velocity : std::span<const Vec3f>());
        find_bounds();
        device = make_device();
        scene = rtcNewScene(device);
        for (const Index object : surfels.object) moving.angular.push_back(trims.angular(object));
        packed = pack_surfels(moving, surfels.layer);
        // What is left of the cloud serves the attributes: axes and normals are in the blocks.
        for (std::vector<Vec3f>* v : {&surfels.cloud.axis1, &surfels.cloud.axis2, &surfels.cloud.normal})
            free_memory(*v);
        free_memory(surfels.layer);
        if (!packed.blocks().empty()) add_surfels();
        for (std::size_t i = 0; i < meshes.size(); ++i) add_mesh(meshes[i], unsigned(i) + 1);
        rtcCommitScene(scene);
        throw_if_failed(device);
    }
    ~Impl() {
        if (scene) rtcReleaseScene(scene);
        if (device) rtcReleaseDevice(device);
    }

    void grow(std::vector<Box3>& boxes, Index object, const Vec3f& x, const Vec3f& half) const {
        if (object >= boxes.size()) boxes.resize(object + 1, kNothing);
        boxes[object].lower = boxes[object].lower.cwiseMin(x - half);
        boxes[object].upper = boxes[object].upper.cwiseMax(x + half);
    }

    /// Of a surfel, `seconds` after the frame's own time [m].
    Vec3f place_of(Index surfel, float seconds) const {
        const Vec3f& x = surfels.cloud.position[surfel];
        if (seconds == 0 || surfels.velocity.empty() || !surfels.velocity[surfel].allFinite()) return x;
        return x + seconds * surfels.velocity[surfel];
    }

    void find_bounds() {
        constexpr std::size_t chunk = 1 << 16;
        const std::size_t n = surfels.cloud.size();
        std::vector<std::vector<Box3>> parts((n + chunk - 1) / chunk);
        parallel_chunks(
            n,
            [&](std::size_t begin, std::size_t end, std::size_t c) {
                for (std::size_t i = begin; i < end; ++i) {
                    const Vec3f half = surfels.cloud.axis1[i].cwiseAbs() + surfels.cloud.axis2[i].cwiseAbs();
                    if (!surfels.cloud.position[i].allFinite() || !half.allFinite()) continue;
                    for (int end = 0; end < (shutter.moves() ? 2 : 1); ++end)
                        grow(parts[c], surfels.object[surfels.layer[i]],
                             place_of(Index(i), end == 0 ? shutter.open : shutter.close), half);
                }
            },
            chunk);
        for (const std::vector<Box3>& part : parts)
            for (Index o = 0; o < part.size(); ++o) {
                if (o >= bounds.size()) bounds.resize(o + 1, kNothing);
                bounds[o].lower = bounds[o].lower.cwiseMin(part[o].lower);
                bounds[o].upper = bounds[o].upper.cwiseMax(part[o].upper);
            }
        for (const MeshObject& m : meshes)
            for (const Vec3f& v : m.mesh.vertices)
                for (int step = 0; step < steps_of(m); ++step)
                    grow(bounds, m.object, at_step(m, v, step), Vec3f::Constant(rounding(v)));
    }

    // ---- moving meshes ------------------------------------------------------------------------------------------------
    /// Between two steps Embree moves vertices straight. A chord is off the circle by s^2/8 of its radius, s = kTurn.
    static constexpr float kTurn = 0.05f;
    static constexpr int kMostSteps = RTC_MAX_TIME_STEP_COUNT;

    int steps_of(const MeshObject& m) const {
        if (!shutter.moves() || m.motion.still()) return 1;
        const float steps = std::ceil((shutter.close - shutter.open) * m.motion.angular.norm() / kTurn) + 1;
        return int(std::clamp(steps, 2.0f, float(kMostSteps)));
    }
    Vec3f at_step(const MeshObject& m, const Vec3f& x, int step) const {
        const int steps = steps_of(m);
        return steps == 1 ? x : m.motion.moved(x, shutter.seconds(float(step) / float(steps - 1)));
    }
    /// Where a vertex is at a ray's time, as Embree has it.
    Vec3f at_time(const MeshObject& m, const Vec3f& x, float time) const {
        const int steps = steps_of(m);
        if (steps == 1) return x;
        const float step = time * float(steps - 1);
        const int before = std::min(int(step), steps - 2);
        const float part = step - float(before);
        return (1 - part) * at_step(m, x, before) + part * at_step(m, x, before + 1);
    }
    Mat3f turn_at(const MeshObject& m, float time) const {
        return steps_of(m) == 1 ? Mat3f(Mat3f::Identity()) : m.motion.turn(shutter.seconds(time));
    }

    void add_surfels() {
        RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
        rtcSetGeometryUserPrimitiveCount(geometry, unsigned(packed.blocks().size()));
        if (packed.motion) rtcSetGeometryTimeStepCount(geometry, 2);
        rtcSetGeometryUserData(geometry, this);
        rtcSetGeometryBoundsFunction(geometry, &block_bounds, nullptr);
        rtcSetGeometryIntersectFunction(geometry, &meet_block);
        rtcCommitGeometry(geometry);
        rtcAttachGeometryByID(scene, geometry, kSurfelGeometry);
        rtcReleaseGeometry(geometry);
    }

    void add_mesh(const MeshObject& object, unsigned id) {
        const TriangleMesh& mesh = object.mesh;
        if (mesh.triangles.empty()) return;
        RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
        const int steps = steps_of(object);
        rtcSetGeometryTimeStepCount(geometry, unsigned(steps));
        std::vector<Vec3f*> vertices;
        for (int step = 0; step < steps; ++step)
            vertices.push_back(
                static_cast<Vec3f*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, unsigned(step),
                                                            RTC_FORMAT_FLOAT3, sizeof(Vec3f), mesh.vertices.size())));
        auto* triangles = static_cast<std::array<Index, 3>*>(rtcSetNewGeometryBuffer(
            geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, sizeof(std::array<Index, 3>), mesh.triangles.size()));
        throw_if_failed(device);
        for (int step = 0; step < steps; ++step)
            std::ranges::transform(mesh.vertices, vertices[std::size_t(step)],
                                   [&](const Vec3f& x) { return at_step(object, x, step); });
        std::copy(mesh.triangles.begin(), mesh.triangles.end(), triangles);
        if (object.solid) {
            rtcSetGeometryUserData(geometry, this);
            rtcSetGeometryIntersectFilterFunction(geometry, &keep_own_side);
        }
        rtcCommitGeometry(geometry);
        rtcAttachGeometryByID(scene, geometry, id);
        rtcReleaseGeometry(geometry);
    }

    static void block_bounds(const RTCBoundsFunctionArguments* args) {
        const SurfelBlocks& packed = static_cast<const Impl*>(args->geometryUserPtr)->packed;
        const Box3& b = (args->timeStep == 0 ? packed.bounds : packed.last_bounds)[args->primID];
        *args->bounds_o = {b.lower.x(), b.lower.y(), b.lower.z(), 0, b.upper.x(), b.upper.y(), b.upper.z(), 0};
    }

    /// Collects the discs of a block. What they blend to is found when the whole window is known. Only the end of the
    /// search moves.
    static void meet_block(const RTCIntersectFunctionNArguments* args) {
        if (!args->valid[0]) return;
        Query& query = *reinterpret_cast<Query*>(args->context);
        gather(*query.from, args->primID, query.candidates);
        float& tfar = reinterpret_cast<RTCRayHit*>(args->rayhit)->ray.tfar;
        tfar = std::min(tfar, query.candidates.end);
    }

    /// Drops hits of a solid that a ray on this side of it cannot have.
    static void keep_own_side(const RTCFilterFunctionNArguments* args) {
        const Impl& impl = *static_cast<const Impl*>(args->geometryUserPtr);
        const Query& query = *reinterpret_cast<const Query*>(args->context);
        const RTCHit& hit = *reinterpret_cast<const RTCHit*>(args->hit);
        const MeshObject& object = impl.meshes[hit.geomID - 1];
        const Ray& ray = query.from->ray;
        const bool entering = impl.face_normal(object, hit.primID, ray.time).dot(ray.direction) < 0;
        if (entering == query.from->interior.contains(object.object)) args->valid[0] = 0;
    }

    /// Normal of a triangle at a ray's time, not of unit length.
    Vec3f face_normal(const MeshObject& m, Index triangle, float time) const {
        const auto& [a, b, c] = m.mesh.triangles[triangle];
        const Vec3f first = at_time(m, m.mesh.vertices[a], time);
        return (at_time(m, m.mesh.vertices[b], time) - first).cross(at_time(m, m.mesh.vertices[c], time) - first);
    }

    bool intersect(const Ray& ray, const Interior& interior, Hit& hit, bool attributes) const;
    void surfel_hit(const Ray& ray, const Interior& interior, const SurfelHit& found, Hit& hit) const;
    void blend_attributes(const SurfelHit& found, float time, Hit& hit) const;
    Vec3f blend_colours(const SurfelHit& found) const;
    void mesh_hit(const Ray& ray, const RTCRayHit& found, Hit& hit) const;
};

void RayScene::Impl::surfel_hit(const Ray& ray, const Interior& interior, const SurfelHit& found, Hit& hit) const {
    hit.t = found.t;
    hit.position = ray.origin + found.t * ray.direction;
    hit.object = surfels.object[found.layer];
    hit.sheet = surfels.sheet.empty() ? 0 : surfels.sheet[found.layer];
    hit.entering = !interior.contains(hit.object);
    // At silhouettes the fitted normal may lean to the other side by its error; the side of the ray decides.
    constexpr float grazing = 1e-3f;
    const float along = found.normal.dot(ray.direction),
                limited = hit.entering ? std::min(along, -grazing) : std::max(along, grazing);
    hit.normal = hit.geometric =
        along == limited ? found.normal : (found.normal + (limited - along) * ray.direction).normalized();
    hit.blended = true;
    hit.rounding = rounding(hit.position);
    hit.offset = 2e-3f * found.radius + hit.rounding;
}

/// Weighted means over the surfels of the hit. The mean of m0 holds at the mean place of the surfels. It is carried
/// from there to the hit by the derivatives of m0 in the tangent plane, which least squares fit to the surfels. An
/// affine m0 is met exactly, so textures do not swim.
void RayScene::Impl::blend_attributes(const SurfelHit& found, float time, Hit& hit) const {
    const float seconds = shutter.seconds(time);
    Attributes& at = hit.attributes = {};
    Vec3f a, b;
    orthonormal_basis(hit.normal, a, b);
    Vec2f mean = Vec2f::Zero();
    for (int i = 0; i < found.count; ++i) {
        const Index k = found.source[i];
        const Vec3f offset = place_of(k, seconds) - hit.position;
        mean += found.weight[i] * Vec2f(a.dot(offset), b.dot(offset));
        if (!surfels.rest.empty()) at.rest += found.weight[i] * surfels.rest[k];
        if (!surfels.velocity.empty()) at.velocity += found.weight[i] * surfels.velocity[k];
        if (!surfels.temperature.empty()) at.temperature += found.weight[i] * surfels.temperature[k];
    }
    if (!surfels.colour.empty()) at.colour = blend_colours(found);
    if (surfels.rest.empty()) return;
    Eigen::Matrix2f spread = Eigen::Matrix2f::Zero();
    Eigen::Matrix<float, 3, 2> product = Eigen::Matrix<float, 3, 2>::Zero();
    for (int i = 0; i < found.count; ++i) {
        const Index k = found.source[i];
        const Vec3f offset = place_of(k, seconds) - hit.position;
        const Vec2f flat = Vec2f(a.dot(offset), b.dot(offset)) - mean;
        spread += found.weight[i] * flat * flat.transpose();
        product += found.weight[i] * (surfels.rest[k] - at.rest) * flat.transpose();
    }
    // Too few surfels, or all in a line, tell nothing across: m0 then has the metric of the surface.
    if (spread.determinant() < 1e-3f * square(spread.trace())) return;
    const Eigen::Matrix<float, 3, 2> slope = product * spread.inverse();
    at.rest_a = slope.col(0);
    at.rest_b = slope.col(1);
    at.rest -= slope * mean;
}

/// Of a body that is a mesh in part the discs without a colour do not count.
Vec3f RayScene::Impl::blend_colours(const SurfelHit& found) const {
    Vec3f sum = Vec3f::Zero();
    float weight = 0;
    for (int i = 0; i < found.count; ++i) {
        const Vec3f& colour = surfels.colour[found.source[i]];
        if (colour.minCoeff() < 0) continue;
        sum += found.weight[i] * colour;
        weight += found.weight[i];
    }
    return weight > 0 ? Vec3f(sum / weight) : Attributes{}.colour;
}

void RayScene::Impl::mesh_hit(const Ray& ray, const RTCRayHit& found, Hit& hit) const {
    const MeshObject& object = meshes[found.hit.geomID - 1];
    const TriangleMesh& mesh = object.mesh;
    const auto& [a, b, c] = mesh.triangles[found.hit.primID];
    const float u = found.hit.u, v = found.hit.v;
    hit.t = found.ray.tfar;
    // From the triangle, not along the ray: the error is then that of the position alone.
    const auto place = [&](Index i) { return at_time(object, mesh.vertices[i], ray.time); };
    const Vec3f own_place = (1 - u - v) * mesh.vertices[a] + u * mesh.vertices[b] + v * mesh.vertices[c];
    const Mat3f turn = turn_at(object, ray.time);
    hit.position = (1 - u - v) * place(a) + u * place(b) + v * place(c);
    hit.geometric = face_normal(object, found.hit.primID, ray.time).normalized();
    hit.normal = hit.geometric;
    if (!mesh.normals.empty()) {
        const Vec3f smooth = turn * ((1 - u - v) * mesh.normals[a] + u * mesh.normals[b] + v * mesh.normals[c]);
        if (smooth.dot(hit.geometric) > 0) hit.normal = smooth.normalized();
    }
    hit.object = object.object;
    hit.sheet = -1;
    hit.entering = hit.geometric.dot(ray.direction) < 0;
    hit.blended = false;
    hit.rounding = hit.offset = rounding(hit.position);
    Vec3f a_axis, b_axis;
    orthonormal_basis(hit.normal, a_axis, b_axis);
    hit.attributes = {};
    hit.attributes.rest = object.to_own * own_place + object.own_shift;
    hit.attributes.rest_a = object.to_own * turn.transpose() * a_axis;
    hit.attributes.rest_b = object.to_own * turn.transpose() * b_axis;
    if (!mesh.colours.empty())
        hit.attributes.colour = (1 - u - v) * mesh.colours[a] + u * mesh.colours[b] + v * mesh.colours[c];
    if (mesh.uvs.empty()) return;
    const auto& [uv_a, uv_b, uv_c] = mesh.uvs[found.hit.primID];
    hit.attributes.uv = (1 - u - v) * uv_a + u * uv_b + v * uv_c;
    const Vec2f p = uv_b - uv_a, q = uv_c - uv_a;
    const float area = face_normal(object, found.hit.primID, ray.time).norm();
    hit.attributes.uv_per_metre = area > 0 ? std::sqrt(std::abs(p.x() * q.y() - p.y() * q.x()) / area) : 0;
}

bool RayScene::Impl::intersect(const Ray& ray, const Interior& interior, Hit& hit, bool attributes) const {
    Ray window = ray;
    const Gathering from{packed, window, interior, surfels.object};
    // A window that held discs but no surface ends at most a support's length on. A ray that never gets through a
    // thousand of them is inside damaged data, and is let go.
    for (int windows = 0; windows < 1000; ++windows) {
        Query query;
        rtcInitIntersectContext(&query.context);
        query.from = &from;
        query.candidates.begin = ray.tmin;
        RTCRayHit found;
        found.ray = {ray.origin.x(),
                     ray.origin.y(),
                     ray.origin.z(),
                     window.tmin,
                     ray.direction.x(),
                     ray.direction.y(),
                     ray.direction.z(),
                     ray.time,
                     ray.tmax,
                     0xffffffffu,
                     0,
                     0};
        found.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        found.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
        rtcIntersect1(scene, &query.context, &found);
        const bool faced = complete(from, query.candidates);
        const float window_end = query.candidates.end;
        const bool mesh_found = found.hit.geomID != RTC_INVALID_GEOMETRY_ID && found.ray.tfar < window_end;
        const float end = std::min(mesh_found ? found.ray.tfar : ray.tmax, window_end);
        SurfelHit surfel;
        if (faced && first_crossing(from, trims, query.candidates, end, attributes, surfel)) {
            surfel_hit(ray, interior, surfel, hit);
            if (attributes) blend_attributes(surfel, ray.time, hit);
            return true;
        }
        if (mesh_found) {
            mesh_hit(ray, found, hit);
            return true;
        }
        if (window_end >= ray.tmax) return false;
        window.bounced = false;
        window.tmin = std::max(window_end, std::nextafter(window.tmin, kInfinity));
    }
    return false;
}

RayScene::RayScene(SurfelSet surfels, std::vector<MeshObject> meshes, const Shutter& shutter)
    : impl_(std::make_unique<Impl>(std::move(surfels), std::move(meshes), shutter)) {}
RayScene::~RayScene() = default;

bool RayScene::intersect(const Ray& ray, const Interior& interior, Hit& hit, bool attributes) const {
    return impl_->intersect(ray, interior, hit, attributes);
}
std::size_t RayScene::dropped_surfels() const { return impl_->packed.dropped; }
std::size_t RayScene::whirling_surfels() const { return impl_->packed.whirling; }

const Box3& RayScene::bounds(Index object) const {
    static const Box3 nothing = kNothing;
    return object < impl_->bounds.size() ? impl_->bounds[object] : nothing;
}

}  // namespace thixo::render
