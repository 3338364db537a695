// Rigid bodies in the steps of elastic ones: small fragments go on so. Dissertation 5.9.1.
#pragma once

#include <vector>

#include "sim/solid/rigid_rates.h"
#include "sim/state/solids.h"

namespace thixo {

/// The rigid bodies during one step. Their elements are moved as all others, by gravity, walls and contact: stress in
/// them has no force. Each body then gets the rigid motion that has their momenta. So contact and walls need not know
/// which bodies are rigid.
///
/// Momentum and angular momentum are those that the forces give, to rounding. Free flight keeps them at any spin.
class RigidPieces {
  public:
    /// At the start of a step: the bodies keep the shapes that they have now.
    explicit RigidPieces(const Solids& solids);

    /// After a sub-step of leapfrog over `drift`, with velocities that were kicked over `kick` [s]. A body turns by its
    /// spin at half the sub-step. Walls that moved elements out of them move the body by the mean of it.
    void follow(double drift, double kick, Solids& solids);

    /// After an implicit step: the shapes are fitted to where the elements have come.
    void fit(Solids& solids);

    /// At the end of a step: poses take over the motion, and displacements are again those of the start.
    void end(Solids& solids) const;

  private:
    struct Piece {
        std::size_t body;
        std::vector<Vec3d> shape{};             // places about the centre, in the frame of the start [m]
        std::vector<Quad> displacement{};       // at the start [m]
        RigidRates rates{};                     // inertia and spin in the frame that turns with the piece
        Mat3d turn = Mat3d::Identity();         // since the start
        Vec3d start{0, 0, 0}, centre{0, 0, 0};  // of mass: at the start, now, in the body's frame [m]

        Vec3d place(std::size_t k) const { return centre + turn * shape[k]; }
    };

    void set_motion(const Piece& piece, double kick, Solids& solids) const;

    std::vector<Piece> pieces_;
};

}  // namespace thixo
