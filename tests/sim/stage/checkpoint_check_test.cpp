// Checkpoints with the right checksum that are none of ours: every array in turn is emptied, shortened, lengthened and
// written over. What cannot be a state of the scene is refused, and the simulation stays as it was.
#include "sim/stage/checkpoint_check.h"

#include <gtest/gtest.h>

#include <cstring>
#include <ctime>
#include <set>
#include <stdexcept>

#include "pipeline/base/error.h"
#include "pipeline/geometry/shapes.h"
#include "tests/pipeline/contract/mutated.h"
#include "tests/sim/identity.h"
#include "tests/sim/phase/wax.h"
#include "tests/sim/solid/rubber.h"

namespace thixo {
namespace {

constexpr std::size_t kChecksum = 32;

/// An array in the bytes of a checkpoint: length of its name, name, bytes a row, rows, the rows.
struct StoredArray {
    std::string name;
    std::size_t rows_at = 0;  // of the number of rows
    std::size_t row_bytes = 0, rows = 0;
    std::size_t first() const { return rows_at + sizeof(std::uint64_t); }
    std::size_t end() const { return first() + rows * row_bytes; }
};

template <class T>
T number_at(const std::string& bytes, std::size_t at) {
    T value{};
    if (at + sizeof value <= bytes.size()) std::memcpy(&value, bytes.data() + at, sizeof value);
    return value;
}

std::vector<StoredArray> arrays_of(const std::string& bytes) {
    std::vector<StoredArray> found;
    for (std::size_t at = 0; at + kChecksum < bytes.size();) {
        const auto length = number_at<std::uint64_t>(bytes, at);
        const std::size_t name_at = at + sizeof length;
        ++at;
        if (length < 2 || length > 40) continue;
        const std::string name = bytes.substr(name_at, length);
        if (name.find_first_not_of("abcdefghijklmnopqrstuvwxyz_.0123456789") != std::string::npos) continue;
        StoredArray array{name, name_at + length + sizeof(std::uint32_t)};
        array.row_bytes = number_at<std::uint32_t>(bytes, name_at + length);
        array.rows = number_at<std::uint64_t>(bytes, array.rows_at);
        if (array.row_bytes == 0 || array.row_bytes > 64 || array.rows > bytes.size() / array.row_bytes) continue;
        if (array.end() + kChecksum > bytes.size()) continue;
        at = array.end();
        found.push_back(array);
    }
    return found;
}

/// The array with other rows.
std::string with_rows(const std::string& bytes, const StoredArray& a, const std::string& rows, std::uint64_t count) {
    std::string out = bytes;
    out.replace(a.first(), a.rows * a.row_bytes, rows);
    std::memcpy(out.data() + a.rows_at, &count, sizeof count);
    return test::sealed_tail(out);
}

class Damage {
  public:
    explicit Damage(Simulation& s)
        : scene_(s.problem.scene),
          bytes_(print_checkpoint(s, "hash")),
          untouched_(make_simulation(scene_)),
          simulation_(make_simulation(scene_)),
          start_(print_checkpoint(untouched_, "hash")),
          arrays_(arrays_of(bytes_)) {}
    const std::vector<StoredArray>& arrays() const { return arrays_; }
    std::string rows_of(const StoredArray& a) const { return bytes_.substr(a.first(), a.rows * a.row_bytes); }
    const std::string& bytes() const { return bytes_; }

    /// Whether it is refused. What is not is stepped on with: that may end in an error of ours, and in nothing else. It
    /// takes milliseconds of processor time, and five seconds at most.
    bool refused(const std::string& damaged, const std::string& what = "") {
        const std::clock_t begun = std::clock();
        const bool refused = is_refused(damaged);
        EXPECT_LT(static_cast<double>(std::clock() - begun) / CLOCKS_PER_SEC, 5) << what;
        return refused;
    }

  private:
    bool is_refused(const std::string& damaged) {
        try {
            parse_checkpoint(damaged, "the file", "hash", simulation_);
        } catch (const CacheError& e) {
            EXPECT_NE(std::string(e.what()).find("the file"), std::string::npos) << e.what();
            EXPECT_TRUE(print_checkpoint(simulation_, "hash") == start_) << e.what() << ": was read in part";
            return true;
        }
        try {
            fixture::steps(simulation_, 1, 1e-5);
        } catch (const Error&) {
        }
        start_again();
        return false;
    }

    /// All that a checkpoint holds is as the scene makes it.
    void start_again() {
        simulation_.clock = untouched_.clock;
        simulation_.next_id = untouched_.next_id;
        simulation_.emitters = untouched_.emitters;
        simulation_.particles = untouched_.particles;
        simulation_.solids = untouched_.solids;
        simulation_.embedded = untouched_.embedded;
        simulation_.mixed_surface = untouched_.mixed_surface;
        simulation_.surface = untouched_.surface;
    }
    scene::Scene scene_;
    std::string bytes_;
    Simulation untouched_, simulation_;
    std::string start_;
    std::vector<StoredArray> arrays_;
};

/// Arrays that may have another length in a state of the same scene. Some are empty where nothing is known or needed;
/// others may have any length.
const std::set<std::string> kAnyLength = {"lift",         "mixed.lift",      "surface.lift", "body.cuts",
                                          "solid.anchor", "solid.laws",      "solid.rates",  "bonds.visibility",
                                          "bonds.base",   "bonds.base_back", "cracks.vertex"};

void expect_other_lengths_to_be_refused(Damage& damage) {
    for (const StoredArray& a : damage.arrays()) {
        const std::string rows = damage.rows_of(a);
        const std::string last = a.rows > 0 ? rows.substr(rows.size() - a.row_bytes) : std::string(a.row_bytes, '\0');
        const bool longer = damage.refused(with_rows(damage.bytes(), a, rows + last, a.rows + 1));
        EXPECT_TRUE(longer || kAnyLength.contains(a.name)) << a.name << " with a row more";
        if (a.rows == 0) continue;
        const bool shorter =
            damage.refused(with_rows(damage.bytes(), a, rows.substr(0, rows.size() - a.row_bytes), a.rows - 1));
        EXPECT_TRUE(shorter || kAnyLength.contains(a.name)) << a.name << " without its last row";
        const bool empty = damage.refused(with_rows(damage.bytes(), a, "", 0));
        EXPECT_TRUE(empty || kAnyLength.contains(a.name)) << a.name << " emptied";
        const bool beyond = damage.refused(with_rows(damage.bytes(), a, rows, UINT64_MAX / 2));
        EXPECT_TRUE(beyond) << a.name << " with more rows than the file has";
    }
}

/// Rows of ones, of large and of negative numbers, first and last. Indices of rows that are not there.
void expect_other_values_to_do_no_harm(Damage& damage) {
    const std::set<std::string> indices = {"material",        "body",          "contact.partner", "solid.owner",
                                           "bonds.neighbour", "body.elements", "embedded.owner",  "zombie.body",
                                           "zombie.component"};
    for (const StoredArray& a : damage.arrays())
        for (const char byte : {'\x7f', '\xff', '\x01'})
            for (const std::size_t row : {std::size_t(0), a.rows - 1}) {
                if (a.rows == 0) break;
                std::string rows = damage.rows_of(a);
                rows.replace(row * a.row_bytes, a.row_bytes, a.row_bytes, byte);
                if (rows == damage.rows_of(a)) continue;
                const bool refused = damage.refused(with_rows(damage.bytes(), a, rows, a.rows), a.name);
                EXPECT_TRUE(refused || byte == '\x01' || !indices.contains(a.name)) << a.name << ", row " << row;
            }
}

/// Water that falls into a tank, and a jet.
Simulation splash() {
    scene::Scene s = fixture::tank({0.08, 0.08, 0.12}, 0.03, 0.01);
    scene::Emitter spout;
    spout.name = "spout";
    spout.material = "water";
    spout.position = {0.02, 0.02, 0.08};
    spout.radius = 0.012;
    s.emitters = {spout};
    s.surface.enabled = true;
    s.frames.fps = 300;
    Simulation run = make_simulation(s);
    advance_frame(run);
    return run;
}

/// A block of wax that melts beside one of rubber, and wax that flows out of a source.
Simulation melting() {
    scene::Scene s = fixture::rubber_scene();
    s.materials[0].name = "rubber";
    scene::Material wax = s.materials[0];
    wax.name = "wax";
    wax.viscosity = 20;
    wax.melting.from = 40;
    wax.melting.to = 60;
    wax.melting.liquid.viscosity = 1;
    wax.thermal.heat_capacity = 1000;
    s.materials.push_back(wax);
    s.bodies = {fixture::body("candle", fixture::shape_at({0, 0, 0}, scene::BoxShape{{0.05, 0.05, 0.05}, 0})),
                fixture::body("toy", fixture::shape_at({0.048, 0, 0}, scene::BoxShape{{0.04, 0.04, 0.04}, 0}))};
    s.bodies[0].material = "wax";
    s.bodies[0].temperature = 50;
    s.bodies[1].material = "rubber";
    for (scene::Body& b : s.bodies) b.surfels = 200;
    s.emitters = {fixture::melting::hot_spout()};
    s.surface.enabled = true;
    s.frames.fps = 200;
    Simulation run = make_simulation(s);
    advance_frame(run);
    return run;
}

/// A block that was cut in two.
Simulation cut() {
    scene::Scene s = fixture::rubber_scene();
    s.surface.enabled = true;
    s.bodies = {fixture::body("block", fixture::shape_at({0, 0, 0}, scene::BoxShape{{0.08, 0.04, 0.04}, 0}))};
    s.bodies[0].surfels = 200;
    s.frames.fps = 200;
    Simulation run = make_simulation(s);
    advance_frame(run);
    cut_body(0, plane(Vec3d(1, 0, 0), 0), matter_of(run));
    advance_frame(run);
    return run;
}

class CraftedCheckpoints : public testing::TestWithParam<Simulation (*)()> {};
INSTANTIATE_TEST_SUITE_P(Scenes, CraftedCheckpoints, testing::Values(splash, melting, cut));

TEST_P(CraftedCheckpoints, AnArrayOfAnotherLengthIsRefused) {
    Simulation s = GetParam()();
    Damage damage(s);
    ASSERT_GT(damage.arrays().size(), 20u);
    EXPECT_FALSE(damage.refused(damage.bytes())) << "the undamaged one is read";
    expect_other_lengths_to_be_refused(damage);
}

TEST_P(CraftedCheckpoints, OtherValuesAreRefusedOrDoNoHarm) {
    Simulation s = GetParam()();
    Damage damage(s);
    expect_other_values_to_do_no_harm(damage);
}

TEST_P(CraftedCheckpoints, AChangedFileIsRefusedOrDoesNoHarm) {
    Simulation s = GetParam()();
    Damage damage(s);
    const std::uint64_t rounds = test::fuzz_rounds(200);
    for (std::uint64_t k = 0; k < rounds; ++k)
        damage.refused(test::sealed_tail(test::mutated(damage.bytes(), 20260101, k)), fmt::format("round {}", k));
}

}  // namespace
}  // namespace thixo
