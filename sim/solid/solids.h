// All solid bodies of a simulation and how they move on.
#pragma once

#include <optional>
#include <vector>

#include "pipeline/contract/scene.h"
#include "pipeline/geometry/keyframes.h"
#include "pipeline/geometry/shape.h"
#include "sim/particles.h"
#include "sim/solid/contact.h"
#include "sim/solid/elasticity.h"
#include "sim/solid/elements.h"
#include "sim/solid/implicit.h"
#include "sim/solid/phases.h"
#include "sim/walls.h"

namespace thixo {

/// A part of a body that is held, moved or pulled.
struct Grip {
    RigidMotion motion;
    Vec3d force{0, 0, 0};         // [N]; not zero: pulls in place of holding
    double start = 0, stop = 0;   // [s]
    std::vector<Index> elements;  // ascending
    double mass = 0;              // of them [kg]
    // State.
    std::vector<Vec3d> anchor;  // where they are taken from, in the world at `start` [m]; empty: not yet
    bool active(double time) const { return time >= start && time < stop; }
    bool pulls() const { return !force.isZero(); }
};

/// How the matter about an element moves, to first order: what surfels sum up. A line of the cache in single precision.
struct alignas(16 * sizeof(Real)) AffineMotion {
    Real value[16];  // H by columns, u - H m [m], v [m/s], 0
};

struct Solids {
    std::vector<SolidBody> bodies;
    Elements elements;
    std::vector<Grip> grips;
    Contacts contacts;
    double last_dt = 0;   // the last sub-step; 0: none yet [s]
    double stretch2 = 1;  // largest squared stretch of any element in it [1]
    // Of the present time.
    std::vector<StressLaw> laws;      // by body
    std::vector<FastestRates> rates;  // by body, for `laws`
    std::vector<Index> element_of;    // by particle id; kNone where the particle has none
    Phases phases;                    // of what melts, freezes or flows
    // Scratch.
    StressScratch stress;
    std::vector<Vec3> force;         // [N]
    std::vector<Vec3> external;      // acceleration that is held over the sub-steps, material frame [m/s^2]
    std::vector<std::uint8_t> held;  // 1 + the grip that holds an element; 0: free
    std::vector<Mat3> gradients;
    std::vector<AffineMotion> motions;  // what surfels and the contact surface are displaced by
    ImplicitScratch implicit;
    bool empty() const { return bodies.empty(); }
    Index element(std::int64_t id) const {
        return static_cast<std::size_t>(id) < element_of.size() ? element_of[static_cast<std::size_t>(id)] : kNone;
    }
};

/// The law of a material at `time` [s], with the changes the scene makes to it: E, nu and the others go over linearly.
StressLaw law_at(const scene::Scene& scene, std::size_t material, double time);

/// The law of a material that melts, between its ends (6.16).
class MeltingLaw {
  public:
    MeltingLaw(const scene::Scene& scene, std::size_t material, double time);
    /// At melt fraction b [1]; at(0) is law_at. What damps the elastic vibrations goes with the solid's share.
    StressLaw at(double b) const;

  private:
    scene::Elastic cold_;
    scene::Melting melting_;
    double viscosity_;
};

/// Whether the matter of this material keeps any shape at melt fraction b.
inline bool keeps_shape(const scene::Material& m, double b) {
    return m.elastic.solid() && (b < 1 || !m.melting.any() || m.melting.liquid.youngs_modulus > 0);
}

/// What sub-steps did, for stats.jsonl.
struct SolidReport {
    int sub_steps = 0;
    int newton = 0, iterations = 0, unconverged = 0;  // of implicit steps
    double smallest_dt = 1e30;                        // [s]
    double contact_seconds = 0;
};

/// C of an orthotropic material whose axes 1, 2, 3 are the columns of `axes` [Pa]: the inverse of its compliance,
///   eps_aa = sigma_aa/E_a - nu_ba sigma_bb/E_b - nu_ca sigma_cc/E_c,  2 eps_ab = sigma_ab/G_ab,  nu_ab/E_a = nu_ba/E_b
Stiffness6 orthotropic_stiffness(const scene::Orthotropic& o, const Mat3d& axes);

/// From t to t + dt [s]: sub-steps of leapfrog within what explicit integration bears, or implicit ones (solver.solids)
/// as long as contact is foreseen, with walls, grips and the particles' other accelerations (here gravity [m/s^2])
/// acting; then plastic flow, and the rest shapes follow the
/// bodies. Walls are left at t + dt.
SolidReport advance_solids(const scene::Scene& scene, const Vec3& gravity, double time, double dt, Walls& walls,
                           Solids& solids);

/// Writes place, velocity v(t), density rho0/|J| and pressure -tr(sigma)/3 of every solid's particle.
void write_particles(Solids& solids, Particles& particles);

}  // namespace thixo
