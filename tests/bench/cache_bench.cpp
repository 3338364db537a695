// Writing and reading a frame of a million particles, beside raw files of the same bytes in the same run.
#include <benchmark/benchmark.h>
#include <stdlib.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <string>

#include "pipeline/base/random.h"
#include "pipeline/contract/atomic_file.h"
#include "pipeline/contract/cache.h"
#include "pipeline/contract/vdb_points.h"

namespace {

using namespace thixo;
namespace fs = std::filesystem;

constexpr std::size_t kCount = 1'000'000;
constexpr double kSpacing = 0.01;

/// A jittered lattice with a smooth velocity: what a fluid looks like to a compressor.
const Frame& frame() {
    static const Frame made = [] {
        std::vector<Vec3f> position(kCount), velocity(kCount);
        std::vector<std::int64_t> id(kCount);
        std::vector<float> density(kCount), temperature(kCount);
        for (std::size_t i = 0; i < kCount; ++i) {
            const auto noise = [&](std::uint64_t use) { return static_cast<float>(random_unit(1, i, 0, use)); };
            const auto step = static_cast<float>(kSpacing);
            position[i] = step * (Vec3f(static_cast<float>(i % 100), static_cast<float>(i / 100 % 100),
                                        static_cast<float>(i / 10'000)) +
                                  0.2f * Vec3f(noise(0), noise(1), noise(2)));
            velocity[i] = Vec3f(position[i].y(), -position[i].x(), 0.1f) + 0.01f * Vec3f(noise(3), noise(4), noise(5));
            id[i] = static_cast<std::int64_t>(i);
            density[i] = 1000 + noise(6);
            temperature[i] = 20 + position[i].z();
        }
        Frame f;
        f.spacing = kSpacing;
        f.particles.count = kCount;
        f.particles.add("P", std::move(position));
        f.particles.add("v", std::move(velocity));
        f.particles.add("id", std::move(id));
        f.particles.add("density", std::move(density));
        f.particles.add("temperature", std::move(temperature));
        return f;
    }();
    return made;
}

/// The arrays one after another, as a program without a format would store them.
const std::string& raw_bytes() {
    static const std::string made = [] {
        std::string bytes;
        for (const Attribute& a : frame().particles.attributes)
            std::visit(
                [&](const auto& v) { bytes.append(reinterpret_cast<const char*>(v.data()), v.size() * sizeof(v[0])); },
                a.data);
        return bytes;
    }();
    return made;
}

struct Folder {
    fs::path path;
    Folder() {
        std::string name = (fs::temp_directory_path() / "thixo-bench-XXXXXX").string();
        path = ::mkdtemp(name.data());
    }
    ~Folder() { fs::remove_all(path); }
};

void rates(benchmark::State& state, std::size_t stored) {
    state.counters["particles/s"] =
        benchmark::Counter(static_cast<double>(kCount), benchmark::Counter::kIsIterationInvariantRate);
    state.counters["MB"] = static_cast<double>(stored) / 1e6;
}

void raw_write(benchmark::State& state) {
    const Folder folder;
    const std::string& bytes = raw_bytes();
    for (auto _ : state) {
        std::FILE* file = std::fopen((folder.path / "raw").c_str(), "wb");
        std::fwrite(bytes.data(), 1, bytes.size(), file);
        std::fflush(file);
        ::fsync(::fileno(file));  // as the cache does
        std::fclose(file);
    }
    rates(state, bytes.size());
}

void cache_write(benchmark::State& state) {
    const Folder folder;
    CacheWriter writer = CacheWriter::create(folder.path, {"bench", "", "0"});
    frame();
    for (auto _ : state) writer.write_frame(frame());
    rates(state, writer.manifest().bytes());
}

void encode(benchmark::State& state) {
    std::size_t size = 0;
    frame();
    for (auto _ : state) size = encode_points(frame().particles, "particles", voxel_size_for(kSpacing)).size();
    rates(state, size);
}

void raw_read(benchmark::State& state) {
    const Folder folder;
    write_whole(folder.path / "raw", raw_bytes());
    for (auto _ : state) {
        std::string bytes(raw_bytes().size(), '\0');
        std::FILE* file = std::fopen((folder.path / "raw").c_str(), "rb");
        benchmark::DoNotOptimize(std::fread(bytes.data(), 1, bytes.size(), file));
        std::fclose(file);
        benchmark::ClobberMemory();
    }
    rates(state, raw_bytes().size());
}

void cache_read(benchmark::State& state) {
    const Folder folder;
    CacheWriter writer = CacheWriter::create(folder.path, {"bench", "", "0"});
    writer.write_frame(frame());
    const CacheReader reader(folder.path);
    for (auto _ : state) benchmark::DoNotOptimize(reader.load_particles(1));
    rates(state, writer.manifest().bytes());
}

BENCHMARK(raw_write)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(cache_write)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(encode)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(raw_read)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(cache_read)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
