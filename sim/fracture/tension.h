// Stress where cracks begin and run: at elements, and at places between them. Dissertation 5.6.4.
#pragma once

#include <vector>

#include "pipeline/geometry/point_grid.h"
#include "sim/fracture/crack_tree.h"
#include "sim/state/solids.h"

namespace thixo {

/// The largest principal stress, and its axis [Pa].
struct Tension {
    Real value = 0;
    Vec3 axis{0, 0, 0};  // unit; it has no sign of its own
};
Tension largest_tension(const Symmetric& stress);

/// The stress of the elements that can break, in their material frames, zero for others [Pa]. Where nothing is permanent
/// it is the second Piola-Kirchhoff stress, else that of the permanent shape (stress_of_shape). It does not fall because
/// matter was drawn out. Requires Solids::gradients and laws of the present time.
void find_stress(const Solids& solids, std::vector<Symmetric>& stress);

/// The part of the strength from which on a tension is watched [1].
inline constexpr Real kWatched = Real(0.5);

/// The largest tension of these elements where it may reach that part of their strength; no tension elsewhere.
void find_tension(const Elements& elements, const std::vector<Symmetric>& stress, std::vector<Tension>& tension);

/// The largest principal stress over the strength [1]. Below kWatched it is a bound, the norm of the stress.
Real load_of(const Symmetric& stress, Real strength);

/// The largest tension over strength [1]. Below kWatched it is a bound, the norm of the stress.
double largest_load(const Elements& elements, const std::vector<Symmetric>& stress,
                    const std::vector<Tension>& tension);

/// The matter of one scene body, as its cracks see it. All its pieces share its material frame.
class CrackedMatter {
  public:
    CrackedMatter(const Solids& solids, const Breaking& breaking);

    const Breaking& breaking() const { return *breaking_; }
    const std::vector<Index>& elements() const { return elements_; }
    const PointGrid& grid() const { return grid_; }  // of them, by rest place, in their order
    const CrackTree& sheets() const { return sheets_; }
    /// Whether an opaque part of a sheet stands between two places.
    bool hidden(const Vec3& from, const Vec3& to) const;

    /// Stress and strength at a place, by the elements that are visible from it:
    ///     a(m) = sum_j w_poly6(m - m_j, h) a_j / sum_j w_poly6(m - m_j, h)
    /// No stress where none is visible.
    struct Local {
        Symmetric stress{};
        Real strength = 0;
    };
    Local at(const Vec3& m, const std::vector<Symmetric>& stress) const;

  private:
    const Solids* solids_;
    const Breaking* breaking_;
    std::vector<Index> elements_;
    PointGrid grid_;
    CrackTree sheets_;
};

}  // namespace thixo
