// The part of an implicit step that is smooth over many elements, solved on a coarse grid: the second level of the
// preconditioner. Multigrid's coarse correction after Brandt 1977; two levels added after Bramble, Pasciak & Xu 1990.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "sim/solid/elasticity.h"
#include "sim/state/bodies.h"

namespace thixo {

/// A grid of nodes about each body, displacements N U trilinear between its nodes, and the matrix of these
/// displacements:
///     A_c = N^T (M/dt^2 + K + B) N = M_c/dt^2 + K_c + N^T B N      [N/m]
/// K is the stiffness of the rest shape in the bodies' frames. B holds the diagonal blocks that contact and walls add.
/// A_c is sparse, of 3x3 blocks, and factored by Cholesky's method. Copies share their state: one simulation at a time.
class CoarseGrid {
  public:
    /// Computes N, M_c and K_c, if the bonds' version or `held` (not 0: held) has changed.
    void prepare(const std::vector<StressLaw>& laws, const std::vector<SolidBody>& bodies, const Elements& elements,
                 const std::vector<std::uint8_t>& held);
    /// Factors A_c for steps of dt [s]. `boundary` holds B by element; empty: none.
    void factor(double dt, const std::vector<Symmetric>& boundary);
    /// z += N A_c^-1 N^T r
    void add_correction(const std::vector<Vec3>& r, std::vector<Vec3>& z);
    /// Number of the grid's nodes [1], and memory of all fields [bytes].
    std::size_t nodes() const;
    std::size_t bytes() const;

  private:
    struct State;
    std::shared_ptr<State> state_;
};

}  // namespace thixo
