#include "sim/stage/probes.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <numeric>
#include <sstream>

#include "pipeline/base/error.h"
#include "pipeline/base/log.h"
#include "pipeline/base/parallel.h"
#include "pipeline/contract/atomic_file.h"
#include "pipeline/contract/ownership.h"
#include "sim/fracture/sheets.h"
#include "sim/loop/simulation.h"
#include "sim/loop/step.h"
#include "sim/solid/elasticity.h"
#include "sim/space/scene_shapes.h"
#include "sim/stage/frame_lines.h"

namespace thixo {
namespace {

using scene::Measure;
using scene::Quantity;

const char* const kFile = "probes.csv";

double elastic_energy(const Simulation& sim, std::size_t i) {
    const Solids& solids = sim.solids;
    const Index element = solids.element(sim.particles.id[i]);
    if (element == kNone || solids.laws.empty()) return 0;
    const StressLaw& law = solids.laws[static_cast<std::size_t>(solids.elements.owner[element])];
    return elastic_energy_of(law, solids.elements, element) / static_cast<double>(sim.particles.mass[i]);
}

Vec3d velocity(const Simulation& sim, std::size_t i) {
    const Quad& v = sim.sweep.motion[i];
    return {v.x, v.y, v.z};
}

/// Of a unit of mass, about a place [m^2/s].
Vec3d angular_momentum(const Simulation& sim, const Vec3d& about, std::size_t i) {
    return (sim.particles.position[i].cast<double>() - about).cross(velocity(sim, i));
}

double quantity(const Simulation& sim, const scene::Probe& probe, std::size_t i) {
    const Particles& p = sim.particles;
    switch (probe.quantity) {
        case Quantity::one:
            return 1;
        case Quantity::volume:
            return static_cast<double>(p.rest_volume[i] / p.mass[i]);
        case Quantity::density:
            return static_cast<double>(p.density[i]);
        case Quantity::pressure:
            return static_cast<double>(shown_pressure(sim, i));
        case Quantity::temperature:
            return static_cast<double>(p.temperature[i]);
        case Quantity::speed:
            return velocity(sim, i).norm();
        case Quantity::energy:
            return 0.5 * velocity(sim, i).squaredNorm();
        case Quantity::velocity_x:
            return velocity(sim, i).x();
        case Quantity::velocity_y:
            return velocity(sim, i).y();
        case Quantity::velocity_z:
            return velocity(sim, i).z();
        case Quantity::x:
            return sim.problem.scene.origin.x() + static_cast<double>(p.position[i].x());
        case Quantity::y:
            return sim.problem.scene.origin.y() + static_cast<double>(p.position[i].y());
        case Quantity::z:
            return sim.problem.scene.origin.z() + static_cast<double>(p.position[i].z());
        case Quantity::angular_x:
            return angular_momentum(sim, probe.position, i).x();
        case Quantity::angular_y:
            return angular_momentum(sim, probe.position, i).y();
        case Quantity::angular_z:
            return angular_momentum(sim, probe.position, i).z();
        case Quantity::elastic_energy:
            return elastic_energy(sim, i);
    }
    return 0;
}

bool counts(const Probes::Entry& e, const Particles& p, std::size_t i) {
    if (e.material >= 0 && p.material[i] != e.material) return false;
    return !e.region || e.region->distance(p.position[i]) <= 0;
}

std::optional<double> at_point(const Simulation& sim, const Probes::Entry& e) {
    const Smoothing& smoothing = sim.problem.smoothing;
    const Vec3 x = e.probe.position.cast<Real>();
    double weight = 0, sum = 0;
    sim.grid.for_each_neighbour(x, smoothing.support, [&](Index j, Real r2) {
        if (j >= sim.particles.size()) j = sim.sweep.ghosts.source[j - sim.particles.size()];
        if (e.material >= 0 && sim.particles.material[j] != e.material) return;
        const double w = static_cast<double>(sim.particles.rest_volume[j] * smoothing.density.value(r2));
        weight += w;
        sum += w * quantity(sim, e.probe, j);
    });
    if (!(weight > 0)) return std::nullopt;
    return sum / weight;
}

struct Moment {
    double mass = 0, sum = 0;
    Moment operator+(const Moment& b) const { return {mass + b.mass, sum + b.sum}; }
};
Moment moment(const Simulation& sim, const Probes::Entry& e) {
    return parallel_sum<Moment>(
        sim.particles.size(),
        [&](std::size_t i) {
            if (!counts(e, sim.particles, i)) return Moment{};
            const double m = static_cast<double>(sim.particles.mass[i]);
            return Moment{m, m * quantity(sim, e.probe, i)};
        },
        Moment{});
}

std::optional<double> extent(const Simulation& sim, const Probes::Entry& e) {
    const Vec3d direction = e.probe.direction.normalized();
    std::vector<std::pair<double, double>> reach;  // coordinate, mass
    double mass = 0;
    for (std::size_t i = 0; i < sim.particles.size(); ++i) {
        if (!counts(e, sim.particles, i)) continue;
        const Vec3d place = sim.problem.scene.origin + sim.particles.position[i].cast<double>();
        reach.emplace_back(direction.dot(place), sim.particles.mass[i]);
        mass += reach.back().second;
    }
    if (reach.empty()) return std::nullopt;
    std::sort(reach.begin(), reach.end());
    double below = 0;
    for (const auto& [coordinate, m] : reach)
        if ((below += m) >= e.probe.quantile * mass * (1 - 1e-12)) return coordinate;
    return reach.back().first;
}

std::optional<double> of_followed(const Simulation& sim, const Probes::Entry& e) {
    const auto& id = sim.particles.id;
    const auto at = std::ranges::find(id, e.followed);
    if (e.followed < 0 || at == id.end()) return std::nullopt;
    return quantity(sim, e.probe, static_cast<std::size_t>(at - id.begin()));
}

/// The particle nearest to the probe's position; of equals that of the lowest id. -1 where there is none.
std::int64_t nearest_id(const Probes::Entry& e, const Particles& p) {
    std::int64_t found = -1;
    double nearest = std::numeric_limits<double>::max();
    for (std::size_t i = 0; i < p.size(); ++i) {
        if (!counts(e, p, i)) continue;
        const double r2 = (p.position[i].cast<double>() - e.probe.position).squaredNorm();
        if (r2 > nearest || (r2 == nearest && p.id[i] > found)) continue;
        nearest = r2;
        found = p.id[i];
    }
    return found;
}

/// What passed since the frame before, a second.
double mean_rate(const Simulation& sim, double counted) {
    const scene::Frames& frames = sim.problem.scene.frames;
    const double span = sim.clock.frame > frames.first ? sim.clock.time - frame_time(frames, sim.clock.frame - 1) : 0;
    return span > 0 ? counted / span : 0;
}

std::optional<double> of_wall(const Simulation& sim, const scene::Probe& p, double counted) {
    if (!(sim.probes.pressed > 0)) return std::nullopt;
    const double force = counted / sim.probes.pressed;
    if (p.measure == Measure::wall_force) return force;
    return -force / pressed_area(p.radius, static_cast<double>(sim.problem.smoothing.support));
}

double count_of(const Simulation& sim, Measure what) {
    const Solids& solids = sim.solids;
    if (what == Measure::crack_area) return area_of_sheets(solids);
    if (what == Measure::fronts) return static_cast<double>(solids.cracks.fronts.size());
    return static_cast<double>(std::ranges::count_if(solids.bodies, [](const SolidBody& b) { return !b.empty(); }));
}

std::string header(const Probes& probes) {
    std::string line = "frame,time";
    for (const Probes::Entry& e : probes.list) line += "," + e.probe.name;
    return line + "\n";
}

/// A run that continues does not measure past frames again. Tells the first frame up to `last` whose line is not there,
/// or has not as many cells as the head of the table.
void warn_of_gap(const std::filesystem::path& file, const std::string& table, int first, int last) {
    std::istringstream lines(table);
    std::string line;
    std::getline(lines, line);
    const auto commas = std::ranges::count(line, ',');
    for (int frame = first; frame <= last; ++frame)
        if (!std::getline(lines, line) || !line.starts_with(fmt::format("{},", frame)) ||
            std::ranges::count(line, ',') != commas) {
            log_warning("{}: has no whole line for frame {}; simulate with --restart to measure it again",
                        file.string(), frame);
            return;
        }
}

}  // namespace

Probes make_probes(const scene::Scene& scene, const Particles& particles) {
    Probes probes;
    for (const scene::Probe& p : scene.probes) {
        Probes::Entry e;
        e.probe = p;
        for (std::size_t m = 0; m < scene.materials.size(); ++m)
            if (scene.materials[m].name == p.material) e.material = static_cast<std::int32_t>(m);
        if (!std::holds_alternative<std::monostate>(p.region.kind)) e.region = make_shape(scene, p.region);
        if (p.measure == Measure::follow) e.followed = nearest_id(e, particles);
        probes.list.push_back(std::move(e));
    }
    probes.counted.assign(probes.list.size(), 0);
    return probes;
}

std::vector<std::optional<double>> measure(Simulation& sim) {
    Probes& probes = sim.probes;
    std::vector<std::optional<double>> values;
    for (std::size_t k = 0; k < probes.list.size(); ++k) {
        const Probes::Entry& e = probes.list[k];
        switch (e.probe.measure) {
            case Measure::point:
                values.push_back(at_point(sim, e));
                break;
            case Measure::extent:
                values.push_back(extent(sim, e));
                break;
            case Measure::total:
                values.push_back(moment(sim, e).sum);
                break;
            case Measure::mean: {
                const Moment m = moment(sim, e);
                values.push_back(m.mass > 0 ? std::optional(m.sum / m.mass) : std::nullopt);
                break;
            }
            case Measure::flux:
                values.push_back(mean_rate(sim, probes.counted[k]));
                break;
            case Measure::wall_force:
            case Measure::wall_pressure:
                values.push_back(of_wall(sim, e.probe, probes.counted[k]));
                break;
            case Measure::follow:
                values.push_back(of_followed(sim, e));
                break;
            case Measure::bodies:
            case Measure::crack_area:
            case Measure::fronts:
                values.push_back(count_of(sim, e.probe.measure));
                break;
        }
    }
    std::fill(probes.counted.begin(), probes.counted.end(), 0.0);
    probes.pressed = 0;
    return values;
}

void begin_probe_file(const std::filesystem::path& out, const Simulation& sim, int frame) {
    if (sim.probes.list.empty()) return;
    require_own(out / kFile, [](std::string_view bytes) { return bytes.starts_with("frame,time"); });
    std::string text = header(sim.probes);
    if (std::ifstream old(out / kFile); old) {
        std::string line;
        std::getline(old, line);
        if (line + "\n" == text) text += lines_of_frames(old, "", frame);
    }
    warn_of_gap(out / kFile, text, sim.problem.scene.frames.first, frame);
    make_folder(out);
    write_whole(out / kFile, text);
}

void append_probes(const std::filesystem::path& out, Simulation& sim) {
    if (sim.probes.list.empty()) return;
    std::string line = fmt::format("{},{}", sim.clock.frame, sim.clock.time);
    for (const std::optional<double>& value : measure(sim)) line += value ? fmt::format(",{}", *value) : ",";
    if (!append_line(out / kFile, line)) throw ResourceError("{}: cannot be written", (out / kFile).string());
}

}  // namespace thixo
