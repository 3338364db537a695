// The geometry that surfaces and bodies evaluate most, each beside a reference in the same run:
//     projection onto F            one evaluation of the same sums; a projection takes a few of them
//     winding number by clusters   the sum over all triangles
//     sampled shape                the exact signed distance to a mesh of that shape
#include <benchmark/benchmark.h>

#include "pipeline/base/random.h"
#include "pipeline/geometry/implicit_surface.h"
#include "pipeline/geometry/mesh_query.h"
#include "pipeline/geometry/primitive_mesh.h"
#include "pipeline/geometry/sampled_shape.h"
#include "pipeline/geometry/shapes.h"
#include "tests/pipeline/geometry/sampled_surfaces.h"

namespace {

using namespace thixo;

constexpr double kRadius = 1, kTube = 0.3;

/// Places at random within `reach` of the torus' surface.
std::vector<Vec3> places(std::size_t n, double reach) {
    std::vector<Vec3> at;
    for (std::uint64_t i = 0; i < n; ++i) {
        const double u = 2 * kPi * random_unit(1, i, 0, 0), v = 2 * kPi * random_unit(1, i, 0, 1);
        const double tube = kTube + reach * (2 * random_unit(1, i, 0, 2) - 1), ring = kRadius + tube * std::cos(v);
        at.push_back(Vec3d(ring * std::cos(u), ring * std::sin(u), tube * std::sin(v)).cast<Real>());
    }
    return at;
}

struct Surfels {
    ImplicitSurface surface;
    std::vector<Vec3> start;
    Surfels() {
        const fixture::Samples samples = fixture::torus(0.01, kRadius, kTube);
        surface.build(samples.position, samples.normal, Real(0.03));
        start = places(10'000, 0.008);
    }
};
const Surfels& surfels() {
    static const Surfels s;
    return s;
}

template <class F>
void over_all(benchmark::State& state, const std::vector<Vec3>& at, F&& f) {
    double sum = 0;
    for (auto _ : state)
        for (const Vec3& x : at) sum += static_cast<double>(f(x));
    benchmark::DoNotOptimize(sum);
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(at.size()));
}

void projection_almost_orthogonal(benchmark::State& state) {
    const Surfels& s = surfels();
    over_all(state, s.start, [&](const Vec3& x) { return s.surface.project_almost_orthogonal(x).position.x(); });
}
void projection_orthogonal(benchmark::State& state) {
    const Surfels& s = surfels();
    over_all(state, s.start, [&](const Vec3& x) { return s.surface.project_orthogonal(x).position.x(); });
}
void reference_one_evaluation(benchmark::State& state) {
    const Surfels& s = surfels();
    over_all(state, s.start, [&](const Vec3& x) {
        const auto sample = s.surface.evaluate(x);
        return sample ? sample->value : Real(0);
    });
}

const MeshQuery& mesh() {
    static const MeshQuery m(torus_mesh(kRadius, kTube, 128));
    return m;
}

void winding_number(benchmark::State& state) {
    over_all(state, places(2'000, 0.25), [](const Vec3& x) { return mesh().winding_number(x); });
}
void reference_all_solid_angles(benchmark::State& state) {
    const TriangleMesh& m = mesh().mesh();
    over_all(state, places(100, 0.25), [&](const Vec3& x) {
        // van Oosterom & Strackee 1983.
        double sum = 0;
        for (const auto& t : m.triangles) {
            const Vec3d a = (m.vertices[t[0]] - x.cast<float>()).cast<double>(),
                        b = (m.vertices[t[1]] - x.cast<float>()).cast<double>(),
                        c = (m.vertices[t[2]] - x.cast<float>()).cast<double>();
            const double la = a.norm(), lb = b.norm(), lc = c.norm();
            sum += std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
        }
        return sum / (2 * kPi);
    });
}

void sampled_distance(benchmark::State& state) {
    static const Shape shape = sampled(torus(Real(kRadius), Real(kTube)), 0.02, 0.1);
    over_all(state, places(10'000, 0.08), [](const Vec3& x) { return shape.distance(x); });
}
void reference_exact_distance(benchmark::State& state) {
    over_all(state, places(10'000, 0.08), [](const Vec3& x) { return mesh().signed_distance(x); });
}

BENCHMARK(projection_almost_orthogonal)->Unit(benchmark::kMillisecond);
BENCHMARK(projection_orthogonal)->Unit(benchmark::kMillisecond);
BENCHMARK(reference_one_evaluation)->Unit(benchmark::kMillisecond);
BENCHMARK(winding_number)->Unit(benchmark::kMillisecond);
BENCHMARK(reference_all_solid_angles)->Unit(benchmark::kMillisecond);
BENCHMARK(sampled_distance)->Unit(benchmark::kMillisecond);
BENCHMARK(reference_exact_distance)->Unit(benchmark::kMillisecond);

}  // namespace
