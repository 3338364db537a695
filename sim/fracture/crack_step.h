// Cracks in a step of the animation loop: they begin, run, part the matter, and make bodies of its pieces.
// Dissertation 5.6.
#pragma once

#include <memory>

#include "pipeline/geometry/neighbour_lists.h"
#include "sim/fracture/fragments.h"
#include "sim/fracture/tension.h"
#include "sim/state/materials.h"
#include "sim/state/screened_pair.h"

namespace thixo {

/// What a step did, for stats.jsonl.
struct CrackReport {
    std::size_t begun = 0, fragments = 0;
};

/// Scratch. The matter of each scene body as its cracks see it is kept from step to step. It is made anew where sheets
/// have grown or elements have changed.
struct CrackScratch {
    std::vector<Symmetric> stress;
    std::vector<Tension> tension;
    std::vector<CrackedMatter> matter;
    // When it was made.
    std::size_t triangles = 0;
    std::vector<std::int64_t> elements;  // ids
    std::vector<std::int32_t> frames;    // by element, where matter may freeze
};

/// Advances the cracks by dt [s] to `time` [s], and the cuts of blades. Requires stresses of the present time: it follows write_particles. Sets Cracks::step,
/// the longest next step. In it no front runs farther than half a row. Where a tension is above half of the strength, a
/// crack at its speed would pass a quarter of a particle.
CrackReport advance_cracks(double time, double dt, std::uint64_t step, const Matter& matter, CrackScratch& scratch);

/// The largest tension over strength of any element at present [1], as largest_load (tension.h) gives it. It keeps no
/// stresses, and looks at each element once. Where the largest stretch of the last sub-step allows no load that is
/// watched, it gives that bound and looks at none.
double load_now(const Solids& solids);

/// The heat that cracks hold up: between particles of one scene body, in places of which a sheet hides one from the
/// other. What is left of it is what is left of a bond between them (transparency, sight.h); none between pieces.
/// Those that have come together at other places conduct as bodies do that touch. Requires the particles' present
/// neighbours.
std::vector<ScreenedPair> screened_heat(const Particles& particles, const NeighbourLists& neighbours,
                                        const Solids& solids, CrackScratch& scratch);

/// How every scene body breaks that can, and the strength of each element. A body of a material that never breaks can be
/// cut by a blade. Requires the bodies' elements; surfels too, where the scene has them. Throws InputError.
void make_breaking(const scene::Scene& scene, const Materials& materials, const EmbeddedSurface& surface,
                   const Particles& particles, Solids& solids);

/// Cuts the cracks that the scene's bodies have from the start (painted.h): sheets, faces and bonds. Pieces become bodies
/// in the first steps. Requires make_breaking. Throws InputError.
void cut_painted_cracks(const scene::Scene& scene, const Matter& matter);

}  // namespace thixo
