// What of an implicit step is smooth over many elements, solved at once on a coarse grid: the second level of the
// preconditioner. Multigrid's coarse correction after Brandt 1977; two levels added after Bramble, Pasciak & Xu 1990.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "sim/solid/elasticity.h"
#include "sim/state/bodies.h"

namespace thixo {

/// Displacements N U of a grid of nodes about each body, trilinear between them, and the matrix they see,
///   A_c = N^T (M/dt^2 + K + B) N = M_c/dt^2 + K_c + N^T B N
/// K at rest in the bodies' frames, B the blocks that contact and walls add on the diagonal. A 3x3-block-sparse matrix,
/// factored by Cholesky's method. Copies share what they have: scratch of one simulation at a time.
class CoarseGrid {
  public:
    /// Makes N, M_c and K_c, if the bonds' version or what is held (`held[i]` not 0) has changed.
    void prepare(const std::vector<StressLaw>& laws, const std::vector<SolidBody>& bodies, const Elements& elements,
                 const std::vector<std::uint8_t>& held);
    /// Factors A_c for steps of dt [s]; `boundary`: B, by element; empty: none.
    void factor(double dt, const std::vector<Symmetric>& boundary);
    /// z += N A_c^-1 N^T r
    void add_correction(const std::vector<Vec3>& r, std::vector<Vec3>& z);
    /// Of the grid [1], of all it holds [bytes].
    std::size_t nodes() const;
    std::size_t bytes() const;

  private:
    struct State;
    std::shared_ptr<State> state_;
};

}  // namespace thixo
