// Step 2 of the animated surface: the potentials' forces move surfels to equilibrium. Dissertation 6.6.2.
#pragma once

#include <vector>

#include "pipeline/contract/scene.h"
#include "sim/surface/liquid_shape.h"
#include "sim/surface/resample.h"
#include "sim/surface/surface.h"

namespace thixo {

/// The result for a surfel. A surfel is lost where no particle is in reach, or where its side of the body has vanished.
/// A buried one is inside the body.
enum class Fate : char { stays = 0, lost, buried };

/// Surfels while they are relaxed: the fields of SurfaceState that the potentials need, and notes of the update.
struct WorkingSurfels {
    std::vector<Vec3>& position;
    std::vector<Vec3>& normal;
    const std::vector<std::int32_t>& component;
    const std::vector<Real>& radius;     // r_s of each [m]
    const std::vector<Real>& curvature;  // LiquidShape::curvature at each [1/m]
    std::vector<WallNote>& wall;         // beside each
    std::vector<ColourNote>& colour;     // at each
    SurfelLists& lists;                  // written
    const std::vector<Real>& melt;       // melt fraction of the matter about it; 0: the surfel stays [1]
    std::vector<char>& lost;             // Fate of each
    std::size_t size() const { return position.size(); }
};

struct RelaxReport {
    int iterations = 0;
    Real largest_move = 0;  // [m], of the last iteration
};

/// Iterates over all surfels at once (Jacobi), with a factor a that falls from 1:
///     s <- s + a (f_n + f_t)
///     n <- unit(k_guide n_guide + k_smooth n_smooth)
///     f_n = n n.(k_guide f_guide + k_attract f_attract + k_smooth f_smooth + k_ext f_ext)
///     f_t = f_repel - n n.f_repel
///     f_guide   = psi_I(s) - s
///     f_attract = (mean of the particles in reach - s) + 0.246 h n
///     f_smooth  = (psi_orth(s) - s) - its mean over the neighbours
///     f_repel   = 1/10 sum over the ten nearest neighbours of (l - |s - s_j|) (s - s_j)/|s - s_j|
///     f_ext     = - d grad d of the moulds in reach (MouldPull)
/// It ends when the largest move is below a hundredth of the spacing, after at most `params.iterations`.
/// - The guiding force is one Newton step of each iteration.
/// - The attracting force is that of 6.6 less its constant part, the mean's distance at a flat surface. That part would
///   hold the whole surface inside the iso-surface. The force pulls tips in and lifts hollows, as the surface of Zhu &
///   Bridson 2005 does.
/// - The difference in the smoothing force leaves an even curvature alone. Without it psi_orth shrinks every drop: the
///   volume drift of which 6.8 complains. Neighbours are those within h_s whose normals agree within 45 degrees.
/// - In the repelling force l is the distance of the tenth neighbour. Lengths are in radii of the pair. With l = h_s,
///   as 6.6 has it, the force jumps whenever the set of ten changes, and surfels never come to rest.
/// - Where moulds are in reach and the weights exceed one, each is divided by their sum.
///
/// Where the surface bends within a surfel's support (drops of a few particles, threads, rims), its average has little
/// meaning. There k_smooth and k_attract fall from their full values at h_s times curvature = 0.9 to zero at 1.4.
/// Afterwards no surfel is outside the iso-value I_min = 0.6 I.
RelaxReport relax(WorkingSurfels surfels, const LiquidShape& shape, const scene::Surface& params,
                  const std::vector<Mould>& moulds = {});

}  // namespace thixo
