// Helpers that the tests of caches share: temporary folders, sample frames, child processes that are killed.
#pragma once

#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "pipeline/base/error.h"
#include "pipeline/base/random.h"
#include "pipeline/contract/atomic_file.h"
#include "pipeline/contract/cache.h"
#include "pipeline/contract/hash.h"

namespace thixo::test {

namespace fs = std::filesystem;

/// An empty folder that goes with its owner.
class TemporaryFolder {
  public:
    TemporaryFolder() {
        std::string name = (fs::temp_directory_path() / "thixo-test-XXXXXX").string();
        if (!::mkdtemp(name.data())) throw std::runtime_error("mkdtemp");
        path_ = name;
    }
    ~TemporaryFolder() {
        std::error_code ignored;
        fs::remove_all(path_, ignored);
    }
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;
    const fs::path& path() const { return path_; }
    fs::path operator/(const std::string& name) const { return path_ / name; }

  private:
    fs::path path_;
};

/// n points in a box of (-1, 1)^3 with ids in no spatial order; values are functions of (seed, id).
inline PointSet sample_points(std::size_t n, std::uint64_t seed) {
    std::vector<Vec3f> position(n), velocity(n);
    std::vector<std::int64_t> id(n);
    std::vector<float> temperature(n);
    std::vector<std::int32_t> body(n);
    for (std::size_t i = 0; i < n; ++i) {
        const auto unit = [&](std::uint64_t use) { return static_cast<float>(2 * random_unit(seed, i, 0, use) - 1); };
        id[i] = static_cast<std::int64_t>(i) + (std::int64_t(1) << 40);
        position[i] = {unit(0), unit(1), unit(2)};
        velocity[i] = {unit(3), unit(4), unit(5)};
        temperature[i] = 20 + 4 * unit(6);  // 4: exact, so that contraction to fma cannot change the sum
        body[i] = static_cast<std::int32_t>(i % 3);
    }
    PointSet points;
    points.count = n;
    points.add("id", std::move(id));
    points.add("P", std::move(position));
    points.add("v", std::move(velocity));
    points.add("temperature", std::move(temperature));
    points.add("body", std::move(body));
    return points;
}

inline Frame sample_frame(int number, std::size_t particles = 300, std::size_t surfels = 200) {
    Frame frame;
    frame.number = number;
    frame.time = number / 24.0;
    frame.spacing = 0.05;
    frame.particles = sample_points(particles, static_cast<std::uint64_t>(number));
    frame.surfels = sample_points(surfels, static_cast<std::uint64_t>(number) + 1000);
    frame.bodies = {{0, -1, "pour", "water"}, {3, 0, "drop \"3\"", "water"}};
    FrameObstacle glass;
    glass.name = "glass";
    glass.look = "glass";
    glass.transform[3] = 0.1 * number;
    glass.velocity = {0.1, 0, 0};
    frame.obstacles = {glass};
    frame.totals.mass = 1.0 / 3;
    frame.totals.momentum = {0, 0.25, -1e-9};
    frame.totals.kinetic_energy = 2;
    frame.totals.potential_energy = -0.5;
    frame.totals.particle_volume = 3e-4;
    frame.totals.surface_volume = 4e-4;
    frame.totals.air = 7;
    frame.totals.virtual_particles = 11;
    return frame;
}

inline CacheIdentity sample_identity() {
    return {"pour", "scene: {name: pour}\nframes: {first: 1, last: 3}\n", "0123456789abcdef"};
}

/// Frames 1 to last with one asset, finished.
inline void write_sample_cache(const fs::path& out, int last) {
    CacheWriter writer = CacheWriter::create(out, sample_identity());
    const std::string glass = writer.add_asset("ply\nthe mesh of a glass\n");
    for (int n = 1; n <= last; ++n) {
        Frame frame = sample_frame(n);
        frame.obstacles[0].asset = glass;
        writer.write_frame(frame);
    }
    writer.finish();
}

/// Every file below a folder by its relative name.
inline std::map<std::string, std::string> contents(const fs::path& folder) {
    std::map<std::string, std::string> files;
    for (const auto& entry : fs::recursive_directory_iterator(folder))
        if (entry.is_regular_file()) files[fs::relative(entry.path(), folder).string()] = read_whole(entry.path());
    return files;
}

/// Row numbers by ascending id.
inline std::vector<std::size_t> by_id(const PointSet& points) {
    const auto& id = points.get<std::int64_t>("id");
    std::vector<std::size_t> order(points.count);
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return id[a] < id[b]; });
    return order;
}

/// Expects that both sets hold the same points with the same bits, in whatever order.
inline void expect_same_points(const PointSet& a, const PointSet& b) {
    ASSERT_EQ(a.count, b.count);
    ASSERT_EQ(a.attributes.size(), b.attributes.size());
    if (a.count == 0) return;
    const auto row_a = by_id(a), row_b = by_id(b);
    for (const Attribute& x : a.attributes) {
        const Attribute* y = b.find(x.name);
        ASSERT_NE(y, nullptr) << x.name;
        ASSERT_EQ(x.data.index(), y->data.index()) << x.name;
        std::visit(
            [&](const auto& values) {
                const auto& others = std::get<std::decay_t<decltype(values)>>(y->data);
                ASSERT_EQ(values.size(), others.size()) << x.name;
                for (std::size_t k = 0; k < values.size(); ++k)
                    ASSERT_EQ(values[row_a[k]], others[row_b[k]]) << x.name << " of row " << k;
            },
            x.data);
    }
}

/// The message of the Error that f throws, "" where it throws none.
template <class F>
std::string message_of(F&& f, ExitCode code) {
    try {
        f();
    } catch (const Error& e) {
        EXPECT_EQ(e.code(), code) << e.what();
        return e.what();
    }
    return "";
}

/// Runs f in a child process under THIXO_WRITE_FAULT=fault and returns how it ended (of waitpid). The child exits with
/// f's result.
template <class F>
int in_child(const std::string& fault, F&& f) {
    const pid_t child = ::fork();
    if (child == 0) {
        ::setenv("THIXO_WRITE_FAULT", fault.c_str(), 1);
        int result = 99;
        try {
            result = f();
        } catch (const Error& e) {
            result = e.code();
        }
        ::_exit(result);
    }
    int status = 0;
    ::waitpid(child, &status, 0);
    return status;
}

}  // namespace thixo::test
