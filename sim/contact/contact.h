// Contact between solids, and of a solid with itself. Dissertation 5.8, 5.9; Keiser et al. 2004.
//
// Most of the dissertation's method is kept. Nodes stand between two surfaces that pass through each other. They have a
// penalty with damping and friction by their areas. Their forces are spread over the particles of both bodies by
// w_poly6. Four things are done otherwise:
// - Depth and normal come from the signed distance of the rest shape. It is taken at the place that a least-squares fit
//   of the deformed particles about the node maps to. It holds for any depth and at edges, where averaged surfels form
//   no surface. It is also the robust inside test of 5.8.
// - Nodes are found once a step, or more often where bodies are fast. Penalties follow from sub-step to sub-step. Nodes
//   near a surface but not in it take part, so that no contact is late.
// - Friction follows the normal force averaged over a while. An elastic body that slides by Coulomb's law to the letter
//   flutters at high coefficients (Adams 1995). It jumps down a slope on which it should stick. Prakash & Clifton 1993
//   measured that friction answers a change of pressure gradually. This ends the flutter (Ranjith & Rice 2001). In the
//   mean the friction is Coulomb's.
// - Both bodies receive a node's force at one place when it is found, by weights that reproduce linear fields. Linear
//   momentum is conserved to rounding. Angular momentum changes by the sliding of the places until nodes are found
//   again, at most a quarter of a particle's width.
#pragma once

#include "pipeline/contract/scene.h"
#include "pipeline/geometry/surface_sampling.h"
#include "sim/space/walls.h"
#include "sim/state/solids.h"

namespace thixo {

/// Samples the surfaces of all bodies that can meet others or walls, three samples to a particle's width. Warns of
/// bodies that overlap at the start.
void make_contacts(const scene::Scene& scene, Solids& solids);

/// How densely those of a body stand. `seed` of their random numbers.
SurfaceSampling contact_sampling(const SolidBody& body, const Elements& elements, std::uint64_t seed);

/// Samples the bodies marked by 1 anew. Samples of other bodies stay. A body without a shape has none. The caller
/// removes nodes that remember a sample of a marked body (forget_nodes). Returns the samples of before.
ContactSamples sample_bodies(const std::vector<std::uint8_t>& which, std::uint64_t seed, Solids& solids);

/// Finds all nodes at `time` [s] for at most the next `dt` [s]. Nodes that existed before keep their state. The broad
/// phase compares the bodies' boxes. The narrow phase maps a sample to the place m in the partner's rest shape, by a
/// fit of the partner's elements about it. The shape's signed distance D there gives, to first order,
///     gap = D(m)/|G^T grad D|      [m], in the world
///     normal = unit(G^T grad D),   G = dm/dx
/// Until `next` no surface comes nearer to another than the margin up to which gaps are listed.
/// A wall is a partner that is infinitely stiff and heavy. The gap of a sample is the wall's signed distance there.
/// Bodies that others meet by their elements meet walls so too (push_off_walls).
void find_contacts(const Walls& walls, double time, double dt, Solids& solids);

/// Adds the nodes' forces to solids.force, for the sub-step dt [s] to come. The normal force is
///     f_n = max(k (excess - gap) - c v_n, 0)      [N]
///     k = k_1 k_2/(k_1 + k_2) |G^T grad D|^2 area/2
/// Half of the area, as each surface has its own nodes, but all of it at a wall. k_i are the bodies' contact_pressure.
/// Without damping and excess this is minus the gradient of an energy that depends on the places of matter alone:
///     E = K D^2/2,   K = k_1 k_2/(k_1 + k_2) area/2      [J]
/// Contact without damping and friction therefore returns all its energy, even where matter is flattened meanwhile.
/// Friction is a spring and damper (Kelvin and Voigt's), returned to the cone within the sub-step:
///     f_t = -k slip - c_t d(slip)/dt,   |f_t| <= mu p      [N]
///     dp/dt = (f_n - p)/min(a, a_m)
/// p is the mean of f_n over the last a seconds of contact. The memory a_m is kMemory radians of the contact's spring,
/// 4 ms in rubber of 1 MPa with particles of 10 mm. Bodies therefore stick without creeping. The spring only returns
/// the energy that it still holds. Inward motion deeper than a quarter of a particle's width is braked as hard as the
/// sub-step permits. Soft bodies give way more slowly than fast ones come. Braking only takes energy. Depth that no
/// approach explains has no force, but for kUnexplained widths: bodies placed into each other, or a fold of the
/// distance. It is pushed out at no more than kOutwards widths a second, so that no body is ever launched by it.
void add_contact_forces(const Walls& walls, double dt, Solids& solids);

/// Lists the nodes by element. Finds what they add to the fastest motions (`rates`), and how hard they may brake. It
/// must follow each change of the nodes, before the next sub-step.
void list_by_element(Solids& solids);

/// False where every element of a body is too far for x to lie in its surface or in the margin before it. The test is
/// quick: most places are far. `grid` as in Contacts.
bool near_matter(const Solids& solids, const SolidBody& body, const PointGrid& grid, const Vec3& x);

/// Adds the last sub-step's motion to the slip of friction. It is called before frames change or nodes are found again.
void follow_contacts(const Walls& walls, Solids& solids);

inline constexpr Real kOutwards = 4;                // speed of unexplained depth, in widths a second [1/s]
inline constexpr Real kUnexplained = Real(0.02);    // unexplained depth that still has a force, in widths
inline constexpr Real kContactMargin = Real(0.25);  // in particle widths

}  // namespace thixo
