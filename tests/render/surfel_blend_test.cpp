// The blended surface: exact on spheres, converging on others, without holes, and with as many ways out as in.
#include "render/surfel_blend.h"

#include <gtest/gtest.h>
#include <time.h>

#include <numeric>

#include "tests/render/surfel_shapes.h"

namespace thixo::render {
namespace {

using shapes::on_sphere;

/// A ray from outside to a point evenly within the unit ball, 1.02 wide: silhouettes included.
Ray random_ray(std::uint64_t i) {
    const Vec3f from = 3 * on_sphere(i, 5), to = on_sphere(i, 6) * float(1.02 * std::cbrt(random_unit(1, i, 7, 0)));
    return {from, (to - from).normalized()};
}

float impact(const Ray& ray) { return ray.direction.cross(ray.origin).norm(); }

struct Errors {
    double position = 0, normal = 0;  // means over hits [m, radians]
    double largest = 0;               // of the position
    int hits = 0;
};

template <class Distance>
Errors errors(const SurfelCloud& cloud, Distance&& distance, int rays) {
    const RayScene scene(shapes::one_object(cloud), {});
    Errors e;
    for (int i = 0; i < rays; ++i) {
        Hit hit;
        if (!scene.intersect(random_ray(std::uint64_t(i)), {}, hit)) continue;
        Vec3f normal;
        const double d = std::abs(distance(hit.position, normal));
        e.position += d;
        e.largest = std::max(e.largest, d);
        e.normal += std::atan2(double(hit.normal.cross(normal).norm()), double(hit.normal.dot(normal)));
        ++e.hits;
    }
    e.position /= e.hits;
    e.normal /= e.hits;
    return e;
}

float sphere_distance(const Vec3f& x, Vec3f& normal) {
    normal = x.normalized();
    return x.norm() - 1;
}

TEST(SurfelBlend, ASphereOfSurfelsIsTheSphere) {
    // The fit reproduces spheres: what is left is the root's tolerance of 1e-5 radii and float rounding (1e-6), at any
    // number of surfels.
    for (const std::size_t n : {200u, 1000u, 5000u}) {
        const double r = shapes::even_spacing(4 * kPi, n);
        const Errors e = errors(shapes::sphere(n, 1, Vec3f::Zero(), 0.2f), sphere_distance, 20000);
        EXPECT_LT(e.position, 1e-5 * r + 1e-6) << n;
        EXPECT_LT(e.normal, 1e-3) << n;
        EXPECT_LT(e.largest, 0.1 * r) << n << ": also where the sampling is at its worst";
    }
}

TEST(SurfelBlend, ErrorsOnATorusFallWithTheSurfels) {
    // A torus is smooth, but nowhere a sphere. A fit that is exact on spheres has position errors of second order in
    // the spacing and normal errors of first order. Four times as many surfels halve the spacing, which gives factors
    // of 4 and 2. The bounds of 3 and 1.7 leave room for the lattice.
    constexpr float R = 0.7f, a = 0.3f;
    const auto distance = [&](const Vec3f& x, Vec3f& normal) {
        const float q = std::hypot(x.x(), x.y());
        const Vec3f centre(x.x() / q * R, x.y() / q * R, 0);
        normal = (x - centre).normalized();
        return (x - centre).norm() - a;
    };
    Errors before = errors(shapes::torus(1600, R, a), distance, 20000);
    for (const std::size_t n : {6400u, 25600u}) {
        const Errors e = errors(shapes::torus(n, R, a), distance, 20000);
        EXPECT_LT(e.position, before.position / 3) << n;
        EXPECT_LT(e.normal, before.normal / 1.7) << n;
        before = e;
    }
}

TEST(SurfelBlend, HasNoHolesAndARayThatEntersLeaves) {
    // Surfels are uneven: positions are shifted by up to 30 % of their distance. Every ray towards the sphere, inside
    // its rim, meets it. There it is refracted as by water, and it must find the way out.
    const RayScene scene(shapes::one_object(shapes::sphere(5000, 1, Vec3f::Zero(), 0.3f)), {});
    constexpr int rays = 400000;
    int holes = 0, lost = 0, phantoms = 0;
    for (int i = 0; i < rays; ++i) {
        const Ray ray = random_ray(std::uint64_t(i));
        Hit hit;
        if (!scene.intersect(ray, {}, hit)) {
            holes += impact(ray) < 0.9995f;
            continue;
        }
        phantoms += impact(ray) > 1.0005f;
        EXPECT_LT(hit.normal.dot(ray.direction), 0);
        const Vec3f refracted = shapes::refracted_into_water(hit, ray.direction);
        Interior inside;
        inside.add(0);
        Hit out;
        lost += !scene.intersect({pass(hit, ray.direction), refracted}, inside, out);
    }
    EXPECT_EQ(holes, 0);
    EXPECT_EQ(lost, 0);
    EXPECT_EQ(phantoms, 0);
}

TEST(SurfelBlend, NoisySurfelsStillCloseTheSurface) {
    // 5 % of a radius in place, 5 degrees in normal, as a moving fluid's surfels have. No hole; parity may fail for a
    // few rays in a million that only touch the rim.
    SurfelCloud cloud = shapes::sphere(2000, 1, Vec3f::Zero(), 0.3f);
    const float r = cloud.axis1[0].norm();
    for (std::size_t i = 0; i < cloud.size(); ++i) {
        const Vec3f n = (cloud.normal[i] + 0.087f * on_sphere(i, 21)).normalized();
        Vec3f a, b;
        orthonormal_basis(n, a, b);
        cloud.position[i] += 0.05f * r * on_sphere(i, 20);
        cloud.axis1[i] = r * a;
        cloud.axis2[i] = r * b;
        cloud.normal[i] = n;
    }
    const RayScene scene(shapes::one_object(cloud), {});
    int holes = 0, odd = 0;
    for (int i = 0; i < 100000; ++i) {
        Ray ray = random_ray(std::uint64_t(i));
        const bool central = impact(ray) < 0.98f;
        Interior interior;
        Hit hit;
        int crossings = 0;
        while (crossings < 32 && scene.intersect(ray, interior, hit)) {
            ++crossings;
            hit.entering ? interior.add(0) : interior.remove(0);
            ray.origin = pass(hit, ray.direction);
        }
        holes += central && crossings == 0;
        odd += crossings % 2;
    }
    EXPECT_EQ(holes, 0);
    EXPECT_LE(odd, 10);
}

TEST(SurfelBlend, AThinSheetNeverBlendsFrontWithBack) {
    // Two layers of opposite normals, a tenth of a radius apart: rays from above meet the upper one, from below the
    // lower one, to rounding.
    SurfelCloud cloud;
    constexpr float gap = 0.01f, r = 0.1f;
    for (int j = -15; j <= 15; ++j)
        for (int i = -15; i <= 15; ++i)
            for (const float side : {1.0f, -1.0f})
                shapes::add_disc(cloud, {0.1f * float(i), 0.1f * float(j), side * gap / 2}, {0, 0, side}, r);
    const RayScene scene(shapes::one_object(cloud), {});
    for (int i = 0; i < 2000; ++i) {
        const float side = i % 2 ? 1.0f : -1.0f;
        const Vec3f target(float(random_unit(1, std::uint64_t(i), 0, 0)) - 0.5f,
                           float(random_unit(1, std::uint64_t(i), 0, 1)) - 0.5f, 0);
        const Vec3f from = target + Vec3f(0.7f, -0.4f, side);
        Hit hit;
        ASSERT_TRUE(scene.intersect({from, (target - from).normalized()}, {}, hit));
        EXPECT_NEAR(hit.position.z(), side * gap / 2, 2e-6f);
        EXPECT_NEAR(hit.normal.z(), side, 1e-5f);
    }
}

TEST(SurfelBlend, AnEdgeIsSharp) {
    // Two planes of one layer that make a convex edge of 90 degrees: z = 0 for x < 0 and x = 0 for z < 0. Discs reach
    // over the edge, the surface does not, but for the overlap of 0.05 radii; up to there it is whole.
    SurfelCloud cloud;
    constexpr float r = 0.1f;
    for (int j = -15; j <= 15; ++j)
        for (int i = 0; i < 15; ++i) {
            shapes::add_disc(cloud, {-r * (float(i) + 0.5f), r * float(j), 0}, {0, 0, 1}, r);
            shapes::add_disc(cloud, {0, r * float(j), -r * (float(i) + 0.5f)}, {1, 0, 0}, r);
        }
    const RayScene scene(shapes::one_object(cloud), {});
    for (std::uint64_t i = 0; i < 8000; ++i) {
        const float x = r * (3 * float(random_unit(1, i, 0, 0)) - 1.5f), y = float(random_unit(1, i, 0, 1)) - 0.5f;
        const Vec3f off(0.2f * float(random_unit(1, i, 0, 2)) - 0.1f, 0.2f * float(random_unit(1, i, 0, 3)) - 0.1f, 0);
        // From above, and in half of the rays past a silhouette: the other plane looks straight away.
        const Vec3f d = (off + (i < 4000 ? Vec3f(0, 0, -1) : Vec3f(1, 0, -0.4f))).normalized();
        Hit hit;
        const bool found = scene.intersect({Vec3f(x, y, 0) - d, d}, {}, hit) && hit.normal.z() > 0.9f;
        if (x < 0 || x > 0.1f * r) {
            EXPECT_EQ(found, x < 0) << x / r;
        }
    }
}

TEST(SurfelBlend, LayersDoNotBlend) {
    // Two crossing planes of one object but two layers: on each, hits lie on its own plane up to the very crossing.
    SurfelSet set;
    for (int layer = 0; layer < 2; ++layer)
        for (int j = -10; j <= 10; ++j)
            for (int i = -10; i <= 10; ++i) {
                const Vec3f n = Vec3f(layer == 0 ? 0.3f : -0.3f, 0, 1).normalized(), u = Vec3f(n.z(), 0, -n.x());
                shapes::add_disc(set.cloud, 0.1f * float(i) * u + Vec3f(0, 0.1f * float(j), 0), n, 0.1f);
                set.layer.push_back(std::uint32_t(layer));
            }
    set.object = {0, 0};
    const RayScene scene(std::move(set), {});
    for (int i = 0; i < 1000; ++i) {
        const float x = float(random_unit(1, std::uint64_t(i), 0, 0)) - 0.5f,
                    y = float(random_unit(1, std::uint64_t(i), 0, 1)) - 0.5f;
        Hit hit;
        ASSERT_TRUE(scene.intersect({{x, y, 2}, {0, 0, -1}}, {}, hit));
        EXPECT_NEAR(hit.position.z(), 0.3f * std::abs(x), 1e-5f);
    }
}

TEST(SurfelBlend, AttributesTakeTheWeightsOfTheHit) {
    // Constants are exact. A linear field has the error of the uneven weights around the hit. The place m0 is
    // exact to first order along the surface, so that a texture does not swim. Its error there is a hundredth of a
    // radius.
    SurfelSet set = shapes::one_object(shapes::sphere(5000));
    for (const Vec3f& p : set.cloud.position) {
        set.temperature.push_back(20 + 10 * p.x());
        set.velocity.push_back({1, 2, 3});
        set.rest.push_back(p);
    }
    const float r = set.cloud.axis1[0].norm();
    const RayScene scene(std::move(set), {});
    for (int i = 0; i < 2000; ++i) {
        Hit hit;
        if (!scene.intersect(random_ray(std::uint64_t(i)), {}, hit, true)) continue;
        const Attributes& a = hit.attributes;
        EXPECT_NEAR(a.velocity.y(), 2, 1e-5);
        EXPECT_NEAR(a.temperature, 20 + 10 * hit.position.x(), 10 * 0.35f * r);
        const Vec3f off = a.rest - hit.position;
        EXPECT_LT((off - hit.normal * hit.normal.dot(off)).norm(), 0.01f * r);
        EXPECT_LT(off.norm(), 0.35f * r);
        Vec3f u, v;
        orthonormal_basis(hit.normal, u, v);
        EXPECT_LT((a.rest_a - u).norm() + (a.rest_b - v).norm(), 0.2f) << "the derivatives of x are the tangents";
    }
}

TEST(SurfelBlend, TheOrderOfTheSurfelsDoesNotMatter) {
    const SurfelCloud cloud = shapes::sphere(3000, 1, Vec3f::Zero(), 0.3f);
    SurfelCloud shuffled;
    for (std::size_t k = 0; k < cloud.size(); ++k) {
        const std::size_t i = k * 1237 % cloud.size();  // coprime: a permutation
        shuffled.position.push_back(cloud.position[i]);
        shuffled.axis1.push_back(cloud.axis1[i]);
        shuffled.axis2.push_back(cloud.axis2[i]);
        shuffled.normal.push_back(cloud.normal[i]);
    }
    const RayScene a(shapes::one_object(cloud), {}), b(shapes::one_object(shuffled), {});
    for (int i = 0; i < 5000; ++i) {
        Hit x, y;
        const bool hit = a.intersect(random_ray(std::uint64_t(i)), {}, x);
        ASSERT_EQ(hit, b.intersect(random_ray(std::uint64_t(i)), {}, y));
        if (!hit) continue;
        EXPECT_EQ(x.t, y.t);
        EXPECT_EQ(x.normal, y.normal);
    }
}

TEST(SurfelBlend, DamagedSurfelsAreLeftOutAndCounted) {
    SurfelCloud cloud = shapes::sphere(500);
    const float nan = std::numeric_limits<float>::quiet_NaN();
    shapes::add_disc(cloud, {nan, 0, 0}, {0, 0, 1}, 1);
    shapes::add_disc(cloud, {0, 0, 0}, {0, 0, 1}, 0);
    for (int i = 0; i < 500; ++i)
        shapes::add_disc(cloud, {0, 0, 1}, {0, 0, 1}, 0.1f);  // many in one place are no error
    const RayScene scene(shapes::one_object(cloud), {});
    EXPECT_EQ(scene.dropped_surfels(), 2u);
    Hit hit;
    ASSERT_TRUE(scene.intersect({{0, 0, 3}, {0, 0, -1}}, {}, hit));
    EXPECT_NEAR(hit.position.z(), 1, 0.01);
}

TEST(SurfelBlend, AnEmptySceneIsMissed) {
    const RayScene scene({}, {});
    Hit hit;
    EXPECT_FALSE(scene.intersect({{0, 0, 3}, {0, 0, -1}}, {}, hit));
}

TEST(SurfelBlend, TheShortWayFindsTheSurfaceOfTheGeneralOne) {
    // The same candidates come as rows and as a list; the list always takes the walk. Rays start outside and inside of
    // the object. The tolerance is twice that of a root, 1e-5 radii, over the least slope of the short way, 0.1.
    // Rounding of t is added.
    for (const SurfelCloud& cloud : {shapes::sphere(3000, 1, Vec3f::Zero(), 0.3f), shapes::torus(3000, 0.7f, 0.3f)}) {
        const SurfelSet set = shapes::one_object(cloud);
        const SurfelBlocks packed = pack_surfels({set.cloud}, set.layer);
        const float radius = set.cloud.axis1[0].norm();
        int compared = 0;
        for (std::uint64_t i = 0; i < 3000; ++i) {
            const bool within = i % 3 == 0;
            const Vec3f from = within ? Vec3f(0.7f * on_sphere(i, 0)) : Vec3f(2 * on_sphere(i, 0));
            Ray ray{from, (0.9f * on_sphere(i, 1) - from).normalized()};
            Interior interior;
            if (within) interior.add(0);
            const Gathering gathering{packed, ray, interior, set.object};
            Candidates rows;
            for (Index b = 0; b < packed.blocks().size(); ++b) gather(gathering, b, rows);
            if (!complete(gathering, rows) || rows.listed) continue;
            Candidates list = rows;
            list.make_list(ray.tmin);
            SurfelHit a, b;
            const bool found = first_crossing(gathering, {}, rows, rows.end, true, a);
            ASSERT_EQ(found, first_crossing(gathering, {}, list, list.end, true, b)) << i;
            if (!found) continue;
            ++compared;
            EXPECT_NEAR(a.t, b.t, 2e-4f * radius + 1e-6f) << i;
            EXPECT_LT((a.normal - b.normal).norm(), 1e-3f) << i;
            ASSERT_EQ(a.count, b.count);
            for (int k = 0; k < a.count; ++k) EXPECT_NEAR(a.weight[k], b.weight[k], 2e-3f);
        }
        EXPECT_GT(compared, 1500);
    }
}

double seconds_of_rays(const RayScene& scene, const std::vector<Ray>& rays) {
    timespec begin{}, end{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &begin);
    for (const Ray& ray : rays) {
        Hit hit;
        EXPECT_TRUE(scene.intersect(ray, {}, hit));
    }
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &end);
    return double(end.tv_sec - begin.tv_sec) + 1e-9 * double(end.tv_nsec - begin.tv_nsec);
}

TEST(SurfelBlend, RadiiOverFiveOrdersOfMagnitudeAreMetAndCostNoMore) {
    // The plane is met to a hundredth of the local radius, and the rounding of the ray's origin. It takes at most three
    // times as long as surfels of one radius. (It was measured to take as long.) Both take turns, the best of five
    // counts.
    const RayScene graded(shapes::one_object(shapes::graded_plane(60000)), {}),
        even(shapes::one_object(shapes::even_plane(245)), {});
    const std::vector<Ray> to_graded = shapes::rays_down(20000, true), to_even = shapes::rays_down(20000, false);
    for (const Ray& ray : to_graded) {
        Hit hit;
        ASSERT_TRUE(graded.intersect(ray, {}, hit));
        const float radius = float(shapes::kGradedSlope) * hit.position.norm();
        EXPECT_LT(std::abs(hit.position.z()), 0.01f * radius + 1e-6f * ray.origin.norm()) << hit.position.transpose();
        EXPECT_GT(hit.normal.z(), 0.999f);
    }
    double slow = 1e30, fast = 1e30;
    for (int turn = 0; turn < 5; ++turn) {
        slow = std::min(slow, seconds_of_rays(graded, to_graded));
        fast = std::min(fast, seconds_of_rays(even, to_even));
    }
    EXPECT_LT(slow, 3 * fast);
}

}  // namespace
}  // namespace thixo::render
