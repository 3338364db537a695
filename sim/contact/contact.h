// Contact between solids, and of a solid with itself. Dissertation 5.8, 5.9; Keiser et al. 2004.
//
// What is kept of the dissertation: nodes between two surfaces that pass through each other, a penalty with damping and
// friction by the nodes' areas, forces spread over the particles of both bodies by w_poly6. Three things are done
// otherwise, and sounder:
// - Depth and normal come from the signed distance of the rest shape, asked at the place that a least-squares fit of
// the
//   deformed particles about the node maps to. It holds for any depth and for edges, where averaged surfels stand for
//   no surface, and it is the robust inside test of 5.8 at the same time.
// - Nodes are found once a step, or more often where bodies are fast, and penalties followed from sub-step to sub-step.
//   Those near a surface but not yet in it take part, so that no contact is late.
// - Friction follows the normal force of a while and not that of the instant. An elastic body that slides by Coulomb's
//   law to the letter flutters at high coefficients (Adams 1995): it jumps down a slope on which it would rest. That
//   friction answers a change of pressure gradually is what Prakash & Clifton 1993 measured, and what ends the flutter
//   (Ranjith & Rice 2001). In the mean it is Coulomb's.
// - Both bodies feel a node's force at one place when it is found, by weights that reproduce linear fields. Linear
//   momentum is conserved to rounding; angular momentum but for what the places slide apart until nodes are found
//   again, at most a quarter of a particle's width.
#pragma once

#include "pipeline/contract/scene.h"
#include "sim/space/walls.h"
#include "sim/state/solids.h"

namespace thixo {

/// Samples of all bodies' surfaces, three to a particle's width. Warns of bodies that start in one another.
void make_contacts(const scene::Scene& scene, Solids& solids);

/// Samples the bodies marked by 1 anew; those of others stay. A body without a shape has none. Nodes that remember a
/// sample of such a body must go (forget_nodes).
void sample_bodies(const std::vector<std::uint8_t>& which, std::uint64_t seed, Solids& solids);

/// Finds all nodes at `time` [s] for at most the next `dt` [s]: those of before go on with what they remember. Broad
/// phase by the bodies' boxes; narrow phase: the place m of a sample in the partner's rest shape by a fit of its
/// elements about it, the gap by the shape's signed distance D there,
///   gap = D(m)/|G^T grad D|,  normal = unit(G^T grad D),  G = dm/dx         to first order in the world
/// Until `next` no surface comes nearer to another than the margin to which gaps are listed.
void find_contacts(double time, double dt, Solids& solids);

/// Adds the nodes' forces to solids.force, for the sub-step dt [s] to come:
///   f_n = max(k (excess - gap) - c v_n, 0),  k = k_1 k_2/(k_1 + k_2) |G^T grad D|^2 area/2
/// as each surface has its own nodes, with k_i the bodies' contact_pressure. Without damping and gap to spare that is
/// minus the gradient of K D^2/2, K = k_1 k_2/(k_1 + k_2) area/2: it depends on where the matter is alone, and contact
/// without damping and friction gives back all it took, although matter is pressed flat meanwhile. And friction by a
/// spring and damper that slip (Kelvin and Voigt's, returned to the cone within the sub-step: only what is there is
/// given back),
///   f_t = -k slip - c_t d(slip)/dt,  |f_t| <= mu p,   dp/dt = (f_n - p)/min(a, a_m)
/// p the mean of f_n over the last a seconds of contact, at most a_m = kMemory radians of the contact's spring (4 ms in
/// rubber of 1 MPa and particles of 10 mm). So bodies stick, without creeping. What is deeper than a quarter of a
/// particle's width and goes on inwards is
/// braked as hard as the sub-step bears: soft bodies give way to fast ones slower than those come. That takes energy
/// alone. Depth that no approach explains (bodies placed into each other, a fold of the distance) is left unanswered,
/// but for kUnexplained widths, and pushed out at no more than kOutwards widths a second: no body is ever launched by
/// it.
void press_contacts(double dt, Solids& solids);

/// Lists the nodes by element, and finds what they add to the fastest motions (`rates`) and how hard they may brake: of
/// new nodes, before the next sub-step.
void list_by_element(Solids& solids);

/// False where a body has no element so near that x could lie in its surface or a margin before it. Quick: most places
/// are far. `grid` as in Contacts.
bool near_matter(const Solids& solids, const SolidBody& body, const PointGrid& grid, const Vec3& x);

/// Takes the last sub-step's motion over into the springs of friction: before frames change or nodes are found again.
void follow_contacts(Solids& solids);

inline constexpr Real kOutwards = 4;                // [1/s]
inline constexpr Real kUnexplained = Real(0.02);    // depth that is answered though no speed explains it, in widths
inline constexpr Real kContactMargin = Real(0.25);  // in particle widths

}  // namespace thixo
