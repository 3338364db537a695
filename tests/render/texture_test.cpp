// Pictures on surfaces: exact at texel centres, endless, the mean where they are small, laid as their mapping says.
#include "render/texture.h"

#include <gtest/gtest.h>

#include "pipeline/base/random.h"
#include "pipeline/contract/image.h"
#include "pipeline/geometry/colour_code.h"
#include "render/pictures.h"
#include "tests/render/worlds.h"

namespace thixo::render {
namespace {

float uniform(std::uint64_t i, std::uint64_t use) { return float(random_unit(31, i, use, 0)); }

std::vector<Vec3f> coloured(int count) {
    std::vector<Vec3f> colours;
    for (int k = 0; k < count; ++k)
        colours.push_back({uniform(std::uint64_t(k), 0), uniform(std::uint64_t(k), 1), uniform(std::uint64_t(k), 2)});
    return colours;
}

constexpr int kWidth = 7, kHeight = 5;

TEST(Texture, IsExactAtTexelCentresAndRepeatsWithoutEnd) {
    const std::vector<Vec3f> colours = coloured(kWidth * kHeight);
    const Texture texture(kWidth, kHeight, colours);
    for (int row = 0; row < kHeight; ++row)
        for (int column = 0; column < kWidth; ++column)
            for (const Vec2f& shift : {Vec2f(0, 0), Vec2f(3, 0), Vec2f(-2, 5), Vec2f(-1, -1)}) {
                const Vec2f uv((float(column) + 0.5f) / kWidth, 1 - (float(row) + 0.5f) / kHeight);
                EXPECT_LT((texture.colour(uv + shift, {0, 0}) - colours[std::size_t(row * kWidth + column)]).norm(),
                          2e-5f);
            }
}

TEST(Texture, IsContinuousAcrossItsSeams) {
    const Texture texture(kWidth, kHeight, coloured(kWidth * kHeight));
    for (int k = 0; k < 50; ++k) {
        const float at = uniform(std::uint64_t(k), 3);
        EXPECT_LT((texture.colour({1e-5f, at}, {0, 0}) - texture.colour({-1e-5f, at}, {0, 0})).norm(), 1e-3f);
        EXPECT_LT((texture.colour({at, 1e-5f}, {0, 0}) - texture.colour({at, -1e-5f}, {0, 0})).norm(), 1e-3f);
    }
}

TEST(Texture, SeenSmallIsItsMean) {
    for (const auto& [width, height] : {std::pair(8, 8), {7, 5}, {1, 13}, {16, 3}}) {
        const std::vector<Vec3f> colours = coloured(width * height);
        Vec3f mean = Vec3f::Zero();
        for (const Vec3f& c : colours) mean += c / float(colours.size());
        const Texture texture(width, height, colours);
        EXPECT_LT((texture.colour({0.3f, 0.8f}, {16, 16}) - mean).norm(), 1e-5f) << width << " x " << height;
    }
}

TEST(Texture, AFootprintOfTwoTexelsTakesTheMeanOfFour) {
    const std::vector<Vec3f> colours = coloured(64);
    const Texture texture(8, 8, colours);
    const Vec3f mean = (colours[0] + colours[1] + colours[8] + colours[9]) / 4;
    EXPECT_LT((texture.colour({1.0f / 8, 7.0f / 8}, {0.25f, 0.25f}) - mean).norm(), 1e-5f);
}

TEST(Texture, APngIsDecodedFromSrgb) {
    Image8 png{2, 1, 3, {188, 0, 255, 10, 128, 64}};
    const auto texture = make_texture(encode_png(png), "two.png");
    const Vec3f left = texture->colour({0.25f, 0.5f}, {0, 0});
    EXPECT_NEAR(left.x(), 0.5029f, 2e-4f);  // ((188/255 + 0.055) / 1.055)^2.4
    EXPECT_EQ(left.y(), 0);
    EXPECT_NEAR(left.z(), 1, 1e-6f);
    EXPECT_NEAR(texture->colour({0.75f, 0.5f}, {0, 0}).x(), 10.0f / 255 / 12.92f, 1e-6f);
}

TEST(Texture, AnExrIsTakenAsItIs) {
    Image exr(1, 1);
    exr.add("R", false)[0] = 0.125f;
    exr.add("G", false)[0] = 0.25f;
    exr.add("B", false)[0] = 1;
    const auto texture = make_texture(encode_exr(exr), "one.exr");
    EXPECT_EQ(texture->colour({0.1f, 0.9f}, {0, 0}), Vec3f(0.125f, 0.25f, 1));
}

/// Texel (column, row from below) of 8 x 8 has the colour (column, row, 0) / 8.
std::shared_ptr<const Texture> numbered() {
    std::vector<Vec3f> colours;
    for (int row = 7; row >= 0; --row)
        for (int column = 0; column < 8; ++column) colours.push_back({float(column) / 8, float(row) / 8, 0});
    return std::make_shared<const Texture>(8, 8, std::move(colours));
}

Material laid(scene::Mapping mapping, scene::Axis axis, scene::Space space = scene::Space::world) {
    scene::Appearance a;
    a.image.file = "numbered";
    a.image.mapping = mapping;
    a.image.axis = axis;
    a.image.size = {2, 4};
    a.image.origin = {10, 20, 30};
    a.space = space;
    return make_material(a, numbered());
}

Hit at(const Vec3f& position, const Vec3f& normal = {0, 0, 1}) {
    Hit hit;
    hit.position = position;
    hit.normal = hit.geometric = normal;
    return hit;
}

/// A place on the picture as a colour of `numbered`, to the nearest texel.
Vec3f texel(int column, int row) { return {float(column) / 8, float(row) / 8, 0}; }

TEST(ImageMap, APlanarOneLooksAlongItsAxis) {
    // Texel (1, 2) has its centre at 1.5/8 of the width 2 m and 2.5/8 of the height 4 m.
    const float right = 1.5f / 8 * 2, up = 2.5f / 8 * 4;
    using scene::Axis;
    EXPECT_LT((laid(scene::Mapping::planar, Axis::z).colour_at(at({10 + right, 20 + up, 77})) - texel(1, 2)).norm(),
              1e-4f);
    EXPECT_LT((laid(scene::Mapping::planar, Axis::y).colour_at(at({10 + right, 77, 30 + up})) - texel(1, 2)).norm(),
              1e-4f);
    EXPECT_LT((laid(scene::Mapping::planar, Axis::x).colour_at(at({77, 20 + right, 30 + up})) - texel(1, 2)).norm(),
              1e-4f);
}

TEST(ImageMap, ABoxReadsTheRightWayFromEverySide) {
    const Material m = laid(scene::Mapping::box, scene::Axis::z);
    const Vec3f centre(10, 20, 30), up_z(0, 0, 1), up_y(0, 1, 0);
    for (const Vec3f& n :
         {Vec3f(1, 0, 0), Vec3f(-1, 0, 0), Vec3f(0, 1, 0), Vec3f(0, -1, 0), Vec3f(0, 0, 1), Vec3f(0, 0, -1)}) {
        const Vec3f up = std::abs(n.z()) > 0.5f ? up_y : up_z, right = up.cross(n);  // as seen from outside
        const Vec3f x = centre + right * (1.5f / 8 * 2) + up * (2.5f / 8 * 4) + 5 * n;
        const Vec3f tilted = (n + 0.3f * right + 0.2f * up).normalized();
        EXPECT_LT((m.colour_at(at(x, tilted)) - texel(1, 2)).norm(), 1e-4f) << n.transpose();
    }
}

TEST(ImageMap, ACylinderIsWoundOnceAndReadsTheRightWay) {
    for (const auto axis : {scene::Axis::x, scene::Axis::y, scene::Axis::z}) {
        const Material m = laid(scene::Mapping::cylinder, axis);
        const int k = int(axis), a = (k + 1) % 3, b = (k + 2) % 3;
        for (const float radius : {0.1f, 3.0f}) {
            // The picture's middle is at the first of the other axes; to the right is towards the second.
            const float angle = (2.5f / 8 - 0.5f) * 2 * float(kPi);
            Vec3f x(10, 20, 30);
            x[a] += radius * std::cos(angle);
            x[b] += radius * std::sin(angle);
            x[k] += 6.5f / 8 * 4;
            EXPECT_LT((m.colour_at(at(x)) - texel(2, 6)).norm(), 1e-4f);
        }
    }
}

TEST(ImageMap, InRestSpaceMovesWithTheMaterial) {
    const Material m = laid(scene::Mapping::box, scene::Axis::z, scene::Space::rest);
    EXPECT_TRUE(m.reads_attributes());
    // The piece has been turned by 90 degrees about x: what was its top now faces -y.
    Hit hit = at({1, 2, 3}, {0, -1, 0});
    hit.attributes.rest = {10 + 1.5f / 8 * 2, 20 + 2.5f / 8 * 4, 31};
    hit.attributes.rest_a = {1, 0, 0};
    hit.attributes.rest_b = {0, 1, 0};
    EXPECT_LT((m.colour_at(hit) - texel(1, 2)).norm(), 1e-4f);
}

TEST(ImageMap, ByUvIsThatOfTheMeshAtTheHit) {
    // A square of 2 m whose uv run over a half of the picture, seen by rays.
    World world;
    scene::Appearance a;
    a.image.file = "numbered";
    a.image.mapping = scene::Mapping::uv;
    world.materials.push_back(make_material(a, numbered()));
    world.material_of = {0};
    EXPECT_TRUE(world.materials[0].reads_attributes());
    MeshObject square = worlds::ground(0, 1);
    const auto uv = [](const Vec3f& x) { return Vec2f(0.25f * x.x() + 0.25f, 0.5f * x.y() + 0.5f); };
    for (const auto& [p, q, r] : square.mesh.triangles)
        square.mesh.uvs.push_back(
            {uv(square.mesh.vertices[p]), uv(square.mesh.vertices[q]), uv(square.mesh.vertices[r])});
    const RayScene rays({}, {square});
    for (std::uint64_t i = 0; i < 200; ++i) {
        const Vec3f x(1.9f * uniform(i, 0) - 0.95f, 1.9f * uniform(i, 1) - 0.95f, 0);
        Hit hit;
        ASSERT_TRUE(rays.intersect({x + Vec3f(0, 0, 3), {0, 0, -1}}, {}, hit, true));
        EXPECT_LT((hit.attributes.uv - uv(x)).norm(), 1e-5f);
        EXPECT_NEAR(hit.attributes.uv_per_metre, std::sqrt(0.125f), 1e-5f);  // 0.5 of uv's area on 4 m^2
        EXPECT_EQ(world.materials[0].colour_at(hit), numbered()->colour(hit.attributes.uv, {0, 0}));
    }
}

TEST(ImageMap, FarAwayAPictureIsSmooth) {
    // A chequered floor to the horizon: a row of pixels far off has the mean of the picture, with four samples a pixel.
    std::vector<Vec3f> colours;
    for (int k = 0; k < 64 * 64; ++k) colours.push_back(Vec3f::Constant(((k / 64 + k % 64) & 1) ? 1.0f : 0.0f));
    scene::Appearance a;
    a.image.file = "chequers";
    World world;
    world.materials.push_back(make_material(a, std::make_shared<const Texture>(64, 64, std::move(colours))));
    world.material_of = {0};
    world.rays = std::make_unique<RayScene>(SurfelSet{}, std::vector<MeshObject>{worlds::ground(0, 5000)});
    worlds::look(world, {0, 0, 30}, {0, 10, 0}, 20, 32, 8);
    FilmSettings film;
    film.samples = 4;
    const Image image = render(world, film);
    for (const float v : image.get("albedo.R")) EXPECT_NEAR(v, 0.5f, 0.01f);
}

}  // namespace
}  // namespace thixo::render
