#include "sim/stage/stats.h"

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "pipeline/base/log.h"
#include "pipeline/base/parallel.h"
#include "pipeline/contract/atomic_file.h"
#include "pipeline/contract/ownership.h"
#include "sim/stage/frame_lines.h"

namespace thixo {
namespace {

constexpr const char* kFile = "stats.jsonl";
constexpr const char* kLead = "{\"frame\":";

nlohmann::ordered_json solves(const SolveStats& solve) {
    return {{"iterations", solve.solves ? static_cast<double>(solve.iterations) / solve.solves : 0},
            {"iterations_max", solve.most},
            {"residual_max", solve.residual},
            {"cut_off", solve.cut_off}};
}

}  // namespace

void begin_stats_file(const std::filesystem::path& out, int frame) {
    require_own(out / kFile, [](std::string_view bytes) { return bytes.find(kLead) != bytes.npos; });
    if (std::ifstream old(out / kFile); old) write_whole(out / kFile, lines_of_frames(old, kLead, frame));
}

void append_stats(const std::filesystem::path& out, const Simulation& sim, const FrameTotals& totals, double seconds) {
    const StepStats& t = sim.stats;
    std::int64_t blocked = 0;
    for (const EmitterState& e : sim.emitters) blocked += e.blocked;
    nlohmann::ordered_json line = {
        {"frame", sim.clock.frame},
        {"time", sim.clock.time},
        {"particles", sim.particles.size()},
        {"surfels", sim.surface.size()},
        {"steps", t.steps},
        {"dt_min", t.steps ? t.smallest_dt : 0},
        {"dt_max", t.largest_dt},
        {"limit", t.limit},
        {"fastest", t.fastest},
        {"density_error", totals.density_error},
        {"neighbours", t.particle_steps ? static_cast<double>(t.pairs) / static_cast<double>(t.particle_steps) : 0},
        {"blocked", blocked},
        {"threads", thread_count()},
        {"seconds",
         {{"all", seconds},
          {"neighbours", t.neighbours_seconds},
          {"density", t.density_seconds},
          {"forces", t.forces_seconds},
          {"viscosity", t.viscosity_seconds},
          {"heat", t.heat_seconds},
          {"pressure", t.pressure_seconds},
          {"integration", t.integration_seconds},
          {"surface", t.surface_seconds}}},
        {"viscosity",
         {{"iterations", t.viscosity_iterations},
          {"residual", t.viscosity_residual},
          {"unconverged", t.viscosity_unconverged}}},
        {"heat_steps", t.heat_steps},
        {"surface",
         {{"updates", t.surface_updates},
          {"inserted", t.surface.inserted},
          {"deleted", t.surface.deleted},
          {"iterations", t.surface.iterations},
          {"largest_move", t.surface.largest_move},
          {"unconverged", t.surface.unconverged},
          {"volume", totals.surface_volume},
          {"particle_volume", totals.particle_volume}}},
    };
    if (sim.problem.strategy.incompressible)
        line["solves"] = {{"density", solves(t.density)}, {"divergence", solves(t.divergence)}};
    if (!sim.solids.empty()) {
        line["solids"] = {{"sub_steps", t.solid_sub_steps},
                          {"stretch", std::sqrt(sim.solids.stretch2)},
                          {"contact_nodes", sim.solids.contacts.nodes.size()}};
        if (sim.problem.strategy.implicit_solids)
            line["solids"].update(
                {{"newton", t.solid_newton}, {"iterations", t.solid_iterations}, {"unconverged", t.solid_unconverged}});
        line["seconds"]["solids"] = t.solids_seconds;
        line["seconds"]["contact"] = t.contact_seconds;
    }
    if (!sim.solids.breaking.empty()) {
        line["cracks"] = {{"begun", t.cracks_begun},
                          {"fragments", t.fragments},
                          {"fronts", sim.solids.cracks.fronts.size()},
                          {"bodies", sim.solids.bodies.size()}};
        line["seconds"]["cracks"] = t.cracks_seconds;
    }
    if (!append_line(out / kFile, line.dump()))
        log_warning("{}: cannot be written; the run goes on without statistics", (out / kFile).string());
}

}  // namespace thixo
