// Pictures of things that move while the shutter is open.
#include <gtest/gtest.h>

#include "pipeline/geometry/shapes.h"
#include "render/surfel_blocks.h"
#include "tests/render/worlds.h"

namespace thixo::render {
namespace {

constexpr int kWidth = 40, kHeight = 30, kTile = 5;
const Shutter kShutter{-0.5f, 0.5f};  // [s]
// One that does not hold the frame's own time as well.
const Shutter kShutters[] = {kShutter, {0.25f, 0.75f}, {-1, -0.5f}};

/// A red ball of surfels that flies, and a grey box that flies and turns, on a ground.
struct Moving {
    Vec3f velocity{0.8f, 0.2f, 0};
    SteadyMotion box{{-1, 0.6f, 0.5f}, {0.1f, -0.5f, 0}, {0, 0, 1.2f}};
    double camera_speed = 0;  // along x [m/s]
};

MeshObject box_at(const SteadyMotion& motion) {
    MeshObject box;
    box.mesh = *thixo::box({0.8, 0.4, 0.6}).node().exact_mesh(4);
    for (Vec3f& v : box.mesh.vertices) v += motion.pivot;
    box.object = 2;
    return box;
}

scene::Appearance coloured(const Vec3d& colour) {
    scene::Appearance a;
    a.colour = colour;
    return a;
}

World lit(const Moving& moving, double camera_after) {
    World world;
    worlds::add_object(world, coloured({0.8, 0.1, 0.1}));
    worlds::add_object(world, coloured({0.3, 0.5, 0.3}));
    worlds::add_object(world, coloured({0.2, 0.3, 0.8}));
    worlds::add_sky(world);
    scene::Light sun;
    sun.type = scene::LightType::sun;
    sun.direction = {0.3, 0.4, -1};
    sun.strength = 2;
    world.lights.push_back(make_light(sun));
    const double x = moving.camera_speed * camera_after;
    worlds::look(world, {x, -2, 6}, {x, 0, 0}, 40, kWidth, kHeight);
    return world;
}

/// With the shutter open.
World blurred(const Moving& moving) {
    World world = lit(moving, 0);
    SurfelSet ball = shapes::one_object(shapes::sphere(3000, 0.5f, {0.3f, -0.4f, 0.6f}));
    ball.velocity.assign(ball.cloud.size(), moving.velocity);
    MeshObject box = box_at(moving.box);
    box.motion = moving.box;
    world.rays = std::make_unique<RayScene>(std::move(ball), std::vector{worlds::ground(1), box}, kShutter);
    world.shutter = kShutter;
    world.moving_camera = {lit(moving, double(kShutter.open)).camera, lit(moving, double(kShutter.close)).camera};
    return world;
}

/// At one instant, where everything stands still.
World frozen(const Moving& moving, float seconds) {
    World world = lit(moving, double(seconds));
    SurfelSet ball =
        shapes::one_object(shapes::sphere(3000, 0.5f, Vec3f(0.3f, -0.4f, 0.6f) + seconds * moving.velocity));
    MeshObject box = box_at(moving.box);
    for (Vec3f& v : box.mesh.vertices) v = moving.box.moved(v, seconds);
    world.rays = std::make_unique<RayScene>(std::move(ball), std::vector{worlds::ground(1), box});
    return world;
}

/// Mean and variance of the green of tiles.
struct Tiles {
    std::vector<double> mean, variance;
    explicit Tiles(const Image& image) {
        const auto& green = image.get("G");
        const auto& noise = image.get("variance.G");
        for (int ty = 0; ty < kHeight / kTile; ++ty)
            for (int tx = 0; tx < kWidth / kTile; ++tx) {
                double sum = 0, error = 0;
                for (int y = ty * kTile; y < (ty + 1) * kTile; ++y)
                    for (int x = tx * kTile; x < (tx + 1) * kTile; ++x) {
                        sum += double(green[std::size_t(y * kWidth + x)]);
                        error += double(noise[std::size_t(y * kWidth + x)]);
                    }
                mean.push_back(sum / (kTile * kTile));
                variance.push_back(error / square(double(kTile * kTile)));
            }
    }
};

/// Largest difference of any tile in standard errors, as Welch's test has it. A thousandth of the value is allowed for
/// the finite number of instants.
double largest_difference(const Tiles& a, const Tiles& b) {
    double largest = 0;
    for (std::size_t k = 0; k < a.mean.size(); ++k)
        largest = std::max(largest, std::abs(a.mean[k] - b.mean[k]) /
                                        std::sqrt(a.variance[k] + b.variance[k] + square(1e-3 * a.mean[k])));
    return largest;
}

Image picture(const World& world, int samples, std::uint64_t seed) {
    FilmSettings film;
    film.samples = samples;
    film.seed = seed;
    return render(world, film);
}

/// The mean of instants in the middles of equal parts of the shutter's time.
Tiles mean_of_instants(const Moving& moving, int instants, int samples) {
    Tiles sum(picture(frozen(moving, kShutter.seconds(0.5f / float(instants))), samples, 1));
    for (int k = 1; k < instants; ++k) {
        const Tiles now(picture(frozen(moving, kShutter.seconds((float(k) + 0.5f) / float(instants))), samples,
                                std::uint64_t(k + 1)));
        for (std::size_t i = 0; i < sum.mean.size(); ++i) {
            sum.mean[i] += now.mean[i];
            sum.variance[i] += now.variance[i];
        }
    }
    for (std::size_t i = 0; i < sum.mean.size(); ++i) {
        sum.mean[i] /= instants;
        sum.variance[i] /= square(double(instants));
    }
    return sum;
}

// Of 48 tiles none differs by more than 4.5 standard errors, but for one run in three thousand; the seeds are fixed.
constexpr double kNone = 4.5;

TEST(MotionBlur, IsTheMeanOfTheInstantsWhileTheShutterIsOpen) {
    const Moving moving;
    const Tiles blur(picture(blurred(moving), 256, 99)), mean = mean_of_instants(moving, 48, 8);
    EXPECT_LT(largest_difference(blur, mean), kNone);
    // It is another picture than that of the middle.
    EXPECT_GT(largest_difference(Tiles(picture(frozen(moving, 0), 256, 7)), mean), 5 * kNone);
}

TEST(MotionBlur, OfAMovingCameraIsTheMeanOfItsPlaces) {
    const Moving moving{{0, 0, 0}, {{-1, 0.6f, 0.5f}}, 0.7};
    const Tiles blur(picture(blurred(moving), 256, 98)), mean = mean_of_instants(moving, 48, 8);
    EXPECT_LT(largest_difference(blur, mean), kNone);
    EXPECT_GT(largest_difference(Tiles(picture(frozen(moving, 0), 256, 7)), mean), 5 * kNone);
}

TEST(MotionBlur, ThatNothingMovesInIsTheSharpPicture) {
    const Moving still{{0, 0, 0}, {{-1, 0.6f, 0.5f}}, 0};
    EXPECT_LT(largest_difference(Tiles(picture(blurred(still), 64, 98)), Tiles(picture(frozen(still, 0), 64, 7))),
              kNone);
}

TEST(MotionBlur, MeetsSurfelsWhereTheyAreAtTheRaysTime) {
    // Of a ball that flies a ray meets what it would meet of a ball at rest, seen from a place that flies along.
    const Vec3f velocity(3, -2, 1);
    for (const Shutter& shutter : kShutters) {
        SurfelSet still = shapes::one_object(shapes::sphere(2000)), flying = still;
        still.rest = flying.rest = still.cloud.position;
        flying.velocity.assign(flying.cloud.size(), velocity);
        const RayScene at_rest(std::move(still), {}), in_flight(std::move(flying), {}, shutter);
        EXPECT_EQ(in_flight.whirling_surfels(), 0u);
        int met = 0;
        for (std::uint64_t i = 0; i < 2000; ++i) {
            const Vec3f from = 3 * shapes::on_sphere(i, 5), to = 0.9f * shapes::on_sphere(i, 6);
            Ray ray{from, (to - from).normalized()};
            Hit rest, flight;
            const bool there = at_rest.intersect(ray, {}, rest, true);
            ray.time = float(random_unit(1, i, 8, 0));
            const Vec3f way = shutter.seconds(ray.time) * velocity;
            ray.origin += way;
            ASSERT_EQ(in_flight.intersect(ray, {}, flight, true), there) << i;
            if (!there) continue;
            ++met;
            EXPECT_LT((flight.position - way - rest.position).norm(), 2e-5) << i;
            EXPECT_LT((flight.normal - rest.normal).norm(), 1e-3) << i;
            EXPECT_LT((flight.attributes.rest - rest.attributes.rest).norm(), 1e-4) << i;
        }
        EXPECT_GT(met, 1500);
    }
}

TEST(MotionBlur, TurnsSurfelsAsTheirVelocitiesHaveIt) {
    // A ball that turns about its middle: nothing says so but the velocities of its surfels. It stays a ball. Centres go
    // straight and not on circles: it grows by the square of 0.2 radians in two, at most.
    const Vec3f angular = 0.2f * Vec3f(1, 2, -2).normalized();
    for (const Shutter& shutter : kShutters) {
        SurfelSet turning = shapes::one_object(shapes::sphere(4000));
        for (const Vec3f& x : turning.cloud.position) turning.velocity.push_back(angular.cross(x));
        const RayScene spinning(std::move(turning), {}, shutter);
        double worst = 0;
        for (std::uint64_t i = 0; i < 2000; ++i) {
            const Vec3f from = 3 * shapes::on_sphere(i, 5), to = 0.5f * shapes::on_sphere(i, 6);
            Ray ray{from, (to - from).normalized()};
            Hit spin;
            ray.time = float(i % 3) / 2;
            ASSERT_TRUE(spinning.intersect(ray, {}, spin)) << i;
            worst = std::max(worst, double((spin.normal - spin.position.normalized()).norm()));
        }
        EXPECT_LT(worst, 0.02);  // surfels that stood still would be up to 0.2 off
    }
}

TEST(MotionBlur, OfDropsThatPassEachOtherTurnsNoDisc) {
    // They are so near that a block holds surfels of both. Each flies straight: no disc turns.
    constexpr std::size_t kSurfels = 60;
    SurfelSet set = shapes::one_object(shapes::sphere(kSurfels, 0.1f, {-0.15f, 0, 0}));
    const SurfelCloud other = shapes::sphere(kSurfels, 0.1f, {0.15f, 0, 0});
    set.velocity.assign(kSurfels, {0, 0.1f, 0});
    for (std::size_t k = 0; k < kSurfels; ++k) {
        shapes::add_disc(set.cloud, other.position[k], other.normal[k], other.axis1[k].norm());
        set.velocity.push_back({0, -0.1f, 0});
        set.layer.push_back(0);
    }
    const SurfelBlocks packed = pack_surfels({set.cloud, set.velocity, kShutter}, set.layer);
    int of_both = 0;
    for (std::size_t b = 0; b < packed.bounds.size(); ++b) {
        of_both += packed.bounds[b].lower.x() < 0 && packed.bounds[b].upper.x() > 0;
        for (const FloatLanes& w : packed.motion[b].angular)
            for (int lane = 0; lane < kFloatLanes; ++lane) EXPECT_LT(std::abs(w[lane]), 1e-3f) << b;
    }
    EXPECT_GT(of_both, 0);
}

TEST(MotionBlur, TellsOfSurfelsThatWhirl) {
    SurfelSet whirling = shapes::one_object(shapes::sphere(500));
    for (const Vec3f& x : whirling.cloud.position) whirling.velocity.push_back(Vec3f(0, 0, 3).cross(x));
    const RayScene scene(std::move(whirling), {}, kShutter);
    EXPECT_GT(scene.whirling_surfels(), 400u);
}

}  // namespace
}  // namespace thixo::render
