// Nested dielectrics.
#include "render/media.h"

#include <gtest/gtest.h>

#include "pipeline/geometry/primitive_mesh.h"
#include "tests/render/worlds.h"

namespace thixo::render {
namespace {

using namespace worlds;

scene::Appearance dielectric(double ior, int priority) {
    scene::Appearance a;
    a.type = scene::AppearanceType::dielectric;
    a.ior = ior;
    a.priority = priority;
    return a;
}

/// A ball of water (surfels, radius 0.55) reaching into the wall of a hollow ball of glass (mesh, 0.5 to 0.7).
World water_in_glass() {
    World world;
    const Index water = add_object(world, dielectric(1.33, 1)), glass = add_object(world, dielectric(1.5, 2));
    SurfelSet set = shapes::one_object(shapes::sphere(3000, 0.55f, Vec3f::Zero(), 0.2f));
    set.object = {water};
    MeshObject wall;
    wall.mesh = sphere_mesh(0.7, 96);
    TriangleMesh hollow = sphere_mesh(0.5, 96);
    const Index base = Index(wall.mesh.vertices.size());
    for (std::size_t i = 0; i < hollow.vertices.size(); ++i) {
        wall.mesh.vertices.push_back(hollow.vertices[i]);
        wall.mesh.normals.push_back(-hollow.normals[i]);
    }
    for (const auto& t : hollow.triangles) wall.mesh.triangles.push_back({base + t[0], base + t[2], base + t[1]});
    wall.object = glass;
    wall.solid = true;
    std::vector<MeshObject> meshes;
    meshes.push_back(std::move(wall));
    world.rays = std::make_unique<RayScene>(std::move(set), std::move(meshes));
    return world;
}

std::vector<float> indices_along(const World& world, Ray ray) {
    std::vector<float> indices{1.0f};
    Interior interior;
    Hit hit;
    for (int i = 0; i < 32 && nearest_hit(world, ray, interior, hit); ++i) {
        const Interface interface = interface_at(world, interior, hit);
        if (interface.real) indices.push_back(interface.after);
        interior = interface.behind;
        ray.origin = pass(hit, ray.direction);
    }
    return indices;
}

TEST(Media, WaterInAGlassIsMetWithoutAFilmOfAir) {
    const World world = water_in_glass();
    const std::vector<float> expected{1.0f, 1.5f, 1.33f, 1.5f, 1.0f};
    for (std::uint64_t i = 0; i < 5000; ++i) {
        const Vec3f from = 3 * shapes::on_sphere(i, 1), to = 0.45f * shapes::on_sphere(i, 2);
        const Ray ray{from, (to - from).normalized()};
        EXPECT_EQ(indices_along(world, ray), expected) << i;
    }
}

TEST(Media, EveryRefractedWayIntoTheGlassLeadsOut) {
    // Random walks by reflection and refraction from outside: when a ray goes off to infinity it is inside nothing.
    World world = water_in_glass();
    add_sky(world);
    int lost = 0;
    for (std::uint64_t i = 0; i < 20000; ++i) {
        const Vec3f from = 3 * shapes::on_sphere(i, 1),
                    to = 0.71f * shapes::on_sphere(i, 2) * float(std::cbrt(random_unit(1, i, 3, 0)));
        Ray ray{from, (to - from).normalized()};
        Interior interior;
        Hit hit;
        for (std::uint64_t bounce = 0; bounce < 64; ++bounce) {
            if (!nearest_hit(world, ray, interior, hit)) {
                lost += interior.count() > 0;
                break;
            }
            const Interface interface = interface_at(world, interior, hit);
            const Vec3f n = hit.entering ? hit.geometric : Vec3f(-hit.geometric);
            const float cosine = -n.dot(ray.direction), eta = interface.after / interface.before;
            const float k = 1 - (1 - cosine * cosine) / (eta * eta);
            if (!interface.real) {
                ray.origin = pass(hit, ray.direction);
                interior = interface.behind;
            } else if (k <= 0 || random_unit(2, i, bounce, 0) < 0.2) {
                const Vec3f r = (ray.direction + 2 * cosine * n).normalized();
                ray = {leave(hit, r), r};
            } else {
                const Vec3f t = (ray.direction / eta + (cosine / eta - std::sqrt(k)) * n).normalized();
                ray = {pass(hit, ray.direction), t};
                interior = interface.behind;
            }
        }
    }
    EXPECT_LE(lost, 2) << "of 20 000: faceted silhouettes of the glass mesh";
}

TEST(Media, TheHigherPriorityWinsAndAmongEqualsTheFirst) {
    World world;
    const Index a = add_object(world, dielectric(1.1, 0)), b = add_object(world, dielectric(1.2, 5)),
                c = add_object(world, dielectric(1.3, 5));
    Interior interior;
    EXPECT_EQ(medium_of(world, interior), kNone);
    interior.add(a);
    EXPECT_EQ(medium_of(world, interior), a);
    interior.add(c);
    interior.add(b);
    EXPECT_EQ(medium_of(world, interior), c);
    interior.remove(c);
    EXPECT_EQ(medium_of(world, interior), b);
}

TEST(Media, APointKnowsWhatItIsInside) {
    const World world = water_in_glass();
    EXPECT_EQ(interior_at(world, {0.1f, 0.05f, 0}).count(), 1);   // water
    EXPECT_EQ(interior_at(world, {0.6f, 0.05f, 0}).count(), 1);   // glass
    EXPECT_EQ(interior_at(world, {0.52f, 0.05f, 0}).count(), 2);  // water in the wall
    EXPECT_EQ(interior_at(world, {0.9f, 0.05f, 0}).count(), 0);
}

TEST(Media, AGlassThatStandsOnATableTouchesIt) {
    // Both faces in the plane z = 0, to the bit: the table is met, never the air between.
    World world;
    const Index glass = add_object(world, dielectric(1.5, 0)), table = add_object(world, scene::Appearance{});
    MeshObject block;
    block.mesh = cylinder_mesh(0.5, 0.25, 0, 64);
    for (Vec3f& v : block.mesh.vertices) v.z() += 0.25f;
    block.object = glass;
    block.solid = true;
    std::vector<MeshObject> meshes;
    meshes.push_back(std::move(block));
    meshes.push_back(ground(table));
    world.rays = std::make_unique<RayScene>(SurfelSet{}, std::move(meshes));
    Interior inside;
    inside.add(glass);
    for (std::uint64_t i = 0; i < 5000; ++i) {
        const Vec3f from(0.6f * float(random_unit(1, i, 0, 0)) - 0.3f, 0.6f * float(random_unit(1, i, 0, 1)) - 0.3f,
                         0.2f);
        const Vec3f to(0.6f * float(random_unit(1, i, 0, 2)) - 0.3f, 0.6f * float(random_unit(1, i, 0, 3)) - 0.3f, 0);
        Hit hit;
        ASSERT_TRUE(nearest_hit(world, {from, (to - from).normalized()}, inside, hit));
        EXPECT_EQ(hit.object, table) << i;
    }
}

}  // namespace
}  // namespace thixo::render
