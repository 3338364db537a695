#include "render/frame_world.h"

#include <algorithm>

#include "pipeline/base/error.h"
#include "pipeline/contract/frame_looks.h"
#include "pipeline/contract/scene_origin.h"
#include "render/cryptomatte.h"
#include "render/media.h"

namespace thixo::render {
namespace {

class Appearances {
  public:
    Appearances(World& world, const scene::Look& look, const Pictures& pictures, std::vector<std::string>& missing)
        : world_(world), look_(look), pictures_(pictures), missing_(missing) {}

    /// A new object that looks like the appearance of this name.
    Index add_object(const std::string& name) {
        const Index outside = material_of(name);
        const auto found = std::ranges::find(look_.appearances, name, &scene::Appearance::name);
        const bool same = found == look_.appearances.end() || found->inside.empty();
        world_.inside_of.push_back(same ? outside : material_of(found->inside));
        world_.material_of.push_back(outside);
        return Index(world_.material_of.size() - 1);
    }

    const std::string& name_of(Index material) const { return names_[material]; }

  private:
    Index material_of(const std::string& name) {
        const auto known = index_.find(name);
        if (known != index_.end()) return known->second;
        const auto found = std::find_if(look_.appearances.begin(), look_.appearances.end(),
                                        [&](const auto& a) { return a.name == name; });
        scene::Appearance appearance;
        appearance.name = name;
        appearance.colour = {0.5, 0.5, 0.5};
        if (found != look_.appearances.end())
            appearance = *found;
        else
            missing_.push_back(name);
        index_[name] = Index(world_.materials.size());
        names_.push_back(name);
        world_.materials.push_back(make_material(
            appearance, appearance.image.file.empty() ? nullptr : pictures_.textures.at(appearance.image.content)));
        return index_[name];
    }

    World& world_;
    const scene::Look& look_;
    const Pictures& pictures_;
    std::vector<std::string>& missing_;
    std::map<std::string, Index> index_;
    std::vector<std::string> names_;  // by material
};

template <class T>
std::vector<T> optional_attribute(const PointSet& points, const char* name) {
    return points.find(name) ? points.get<T>(name) : std::vector<T>();
}

using Layers = std::map<std::pair<int, int>, std::uint32_t>;  // of (body, sheet)

void add_sheets(Layers& layers, int body, const TrimNode& node) {
    if (node.op == TrimNode::Op::sheet) layers.emplace(std::pair(body, node.sheet), 0u);
    for (const TrimNode& part : node.parts) add_sheets(layers, body, part);
}

TrimNode over_layers(TrimNode node, int body, const Layers& layers) {
    if (node.op == TrimNode::Op::sheet) node.sheet = int(layers.at({body, node.sheet}));
    for (TrimNode& part : node.parts) part = over_layers(std::move(part), body, layers);
    return node;
}

/// Layers are the pairs (body, sheet) in ascending order, those that only a trim tree names included.
void set_layers(SurfelSet& set, const PointSet& points, const std::vector<FrameBody>& bodies,
                const std::map<int, Index>& object_of_body) {
    const std::vector<std::int32_t> body = optional_attribute<std::int32_t>(points, "body");
    const std::vector<std::int32_t> sheet = optional_attribute<std::int32_t>(points, "sheet");
    Layers layers;
    const auto key = [&](std::size_t i) {
        return std::pair(body.empty() ? object_of_body.begin()->first : body[i], sheet.empty() ? 0 : sheet[i]);
    };
    for (std::size_t i = 0; i < points.count; ++i) layers.emplace(key(i), 0u);
    for (const FrameBody& b : bodies)
        if (b.trim) add_sheets(layers, b.id, *b.trim);
    for (auto& [pair, layer] : layers) {
        const auto object = object_of_body.find(pair.first);
        if (object == object_of_body.end())
            throw CacheError("surfels belong to body {}, which the frame does not list", pair.first);
        layer = std::uint32_t(set.object.size());
        set.object.push_back(object->second);
        set.sheet.push_back(pair.second);
    }
    set.layer.resize(points.count);
    for (std::size_t i = 0; i < points.count; ++i) set.layer[i] = layers.at(key(i));
    for (const FrameBody& b : bodies) {
        if (!b.trim) continue;
        const Index o = object_of_body.at(b.id);
        if (set.trim.size() <= o) set.trim.resize(o + 1);
        set.trim[o] = over_layers(*b.trim, b.id, layers);
    }
}

SurfelSet surfels_of(const Frame& frame, const std::map<int, Index>& object_of_body) {
    SurfelSet set;
    const PointSet& points = frame.surfels;
    if (points.count == 0) return set;
    if (object_of_body.empty()) throw CacheError("frame {} has surfels but lists no body", frame.number);
    set.cloud.position = points.get<Vec3f>("P");
    set.cloud.axis1 = points.get<Vec3f>("t1");
    set.cloud.axis2 = points.get<Vec3f>("t2");
    set.rest = optional_attribute<Vec3f>(points, "rest");
    set.velocity = optional_attribute<Vec3f>(points, "v");
    set.colour = optional_attribute<Vec3f>(points, "Cd");
    set.temperature = optional_attribute<float>(points, "temperature");
    set_layers(set, points, frame.bodies, object_of_body);
    return set;
}

ObjectLabel label_of(const std::string& name, const std::string& appearance) {
    ObjectLabel label;
    label.name = name;
    label.appearance = appearance;
    label.object_id = cryptomatte_id(name);
    label.material_id = cryptomatte_id(appearance);
    return label;
}
ObjectLabel label_of(const FrameBody& body, const std::string& appearance) {
    const std::string name = body.parent < 0 ? body.name : fmt::format("{}.{}", body.name, body.id);
    ObjectLabel label = label_of(name, appearance);
    label.body = body.id;
    return label;
}
ObjectLabel label_of(const FrameObstacle& obstacle, const Vec3d& origin, const std::string& appearance) {
    ObjectLabel label = label_of(obstacle.name, appearance);
    for (int k = 0; k < 3; ++k) {
        const auto i = std::size_t(k);
        label.origin[k] = float(obstacle.transform[4 * i + 3] - origin[k]);
        label.velocity[k] = float(obstacle.velocity[i]);
        label.angular_velocity[k] = float(obstacle.angular_velocity[i]);
    }
    return label;
}

/// Open for no time, it shows the frame's own.
Shutter shutter_of(const scene::Camera& camera, double fps) {
    if (camera.shutter_close == camera.shutter_open) return {};
    return {float(camera.shutter_open / fps), float(camera.shutter_close / fps)};
}

MeshObject placed(const TriangleMesh& mesh, const FrameObstacle& obstacle, const Vec3d& origin) {
    Eigen::Matrix4d m;
    for (int k = 0; k < 16; ++k) m(k / 4, k % 4) = obstacle.transform[std::size_t(k)];
    const Mat3d linear = m.topLeftCorner<3, 3>(), normals = linear.inverse().transpose();
    const Vec3d shift = m.topRightCorner<3, 1>() - origin;
    MeshObject object;
    object.to_own = linear.inverse().cast<float>();
    object.own_shift = (-linear.inverse() * shift).cast<float>();
    object.motion.pivot = shift.cast<float>();
    for (int k = 0; k < 3; ++k) {
        object.motion.velocity[k] = float(obstacle.velocity[std::size_t(k)]);
        object.motion.angular[k] = float(obstacle.angular_velocity[std::size_t(k)]);
    }
    object.mesh.triangles = mesh.triangles;
    object.mesh.uvs = mesh.uvs;
    object.mesh.colours = mesh.colours;
    for (const Vec3f& v : mesh.vertices)
        object.mesh.vertices.push_back((linear * v.cast<double>() + shift).cast<float>());
    for (const Vec3f& n : mesh.normals)
        object.mesh.normals.push_back((normals * n.cast<double>()).normalized().cast<float>());
    return object;
}

}  // namespace

World make_world(const Frame& frame, const AssetMeshes& meshes, const Pictures& pictures, const scene::Scene& scene,
                 const scene::Look& look_in_world, std::vector<std::string>& missing) {
    World world;
    world.origin = frame.surfels.origin;
    const scene::Look look = scene::relative_to(look_in_world, world.origin);
    Appearances appearances(world, look, pictures, missing);
    const auto require_uv = [&](Index object, bool has, const std::string& appearance, const std::string& of) {
        if (!has && world.material(object).image.by_uv())
            throw InputError("look.appearances.{}.image: {} has no texture coordinates; choose another mapping than uv",
                             appearance, of);
    };
    const auto require_temperature = [&](Index material, bool has, const std::string& of) {
        if (!has && world.materials[material].glow.by_temperature())
            throw InputError("look.appearances.{}.glow.black_body: {} has no temperatures that it could glow by",
                             appearances.name_of(material), of);
    };
    const bool warm = frame.surfels.count == 0 || frame.surfels.find("temperature");
    std::map<int, Index> object_of_body;
    for (const FrameBody& b : frame.bodies) {
        const std::string name = look_of_body(scene, b);
        object_of_body[b.id] = appearances.add_object(name);
        world.labels.push_back(label_of(b, name));
        require_uv(object_of_body[b.id], false, name, fmt::format("the body '{}' is made of surfels, and", b.name));
        for (const auto* side : {&world.material_of, &world.inside_of})
            require_temperature(side->back(), warm, fmt::format("the body '{}' of this cache", b.name));
    }
    std::vector<MeshObject> placed_meshes;
    for (const FrameObstacle& o : frame.obstacles) {
        const auto mesh = meshes.find(o.asset);
        if (o.asset.empty() || mesh == meshes.end()) continue;
        placed_meshes.push_back(placed(mesh->second, o, world.origin));
        const std::string name = look_of_obstacle(scene, o);
        placed_meshes.back().object = appearances.add_object(name);
        world.labels.push_back(label_of(o, world.origin, name));
        require_uv(placed_meshes.back().object, !mesh->second.uvs.empty(), name,
                   fmt::format("the mesh of the boundary '{}'", o.name));
        require_temperature(world.material_of.back(), false, fmt::format("the boundary '{}'", o.name));
        placed_meshes.back().solid = world.material(placed_meshes.back().object).dielectric();
    }
    world.shutter = shutter_of(look.camera, scene.frames.fps);
    SurfelSet surfels = surfels_of(frame, object_of_body);
    if (world.shutter.moves() && surfels.velocity.empty() && surfels.cloud.size() > 0)
        throw CacheError(
            "frame {}: its surfels have no velocities (v), which an open shutter needs; without "
            "look.camera.shutter_open and shutter_close it is drawn sharp",
            frame.number);
    world.rays = std::make_unique<RayScene>(std::move(surfels), std::move(placed_meshes), world.shutter);
    for (const scene::Light& l : look.lights)
        world.lights.push_back(
            make_light(l, l.type == scene::LightType::environment ? pictures.environments.at(l.content) : nullptr));
    if (look.output.passes.lights) world.light_groups = light_groups(look.lights, scene::glows(look));
    world.attributes = std::any_of(world.materials.begin(), world.materials.end(),
                                   [](const Material& m) { return m.reads_attributes(); });
    world.passes = look.output.passes;
    world.attributes |= world.passes.motion;  // the velocity is one
    world.background = look.background.cast<float>();
    const scene::Output& output = look.output;
    world.settings = {output.max_bounces, output.straight_shadows, float(output.clamp), output.transparent_background};
    const auto camera_then = [&](double after) {
        return camera_at(look.camera, frame.time + after, output.width, output.height);
    };
    world.camera = camera_then(0);
    world.moving_camera = {camera_then(world.shutter.open), camera_then(world.shutter.close)};
    if (world.passes.motion) {
        const double seconds = 1 / scene.frames.fps;
        world.neighbours = {camera_then(-seconds), camera_then(seconds), float(seconds)};
    }
    world.camera_interior = interior_at(world, world.camera_then(world.shutter.frame_time()).position);
    return world;
}

}  // namespace thixo::render
