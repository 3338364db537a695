// How cracks weaken what acts across them: transparency weights. Dissertation 5.6.2.
#pragma once

#include "sim/bonds/weights.h"
#include "sim/fracture/tension.h"
#include "sim/surface/embedded_surface.h"

namespace thixo {

/// The share of a weight that is left across a crack, with the distance `behind` of the crossing to the front [m]:
///     q = r/h,   q' = q + (2 behind/(kappa h))^2
///     w(q')/w(q) = ((1 - q')/(1 - q))^3,   0 where q' >= 1
/// `opaque` is kappa h/2 [m]. It is 1 at the front, and 0 far behind it.
Real transparency(Real q, Real behind, Real opaque);

/// Updates the distance of triangles to the fronts of their cracks. It never falls. Cracks without a front are parted.
void follow_fronts(const std::vector<Breaking>& breaking, Cracks& cracks);

/// Notes the bonds that cross triangles from row `first` on.
void find_crossings(const CrackedMatter& matter, const Elements& elements, Index first, Cracks& cracks);

/// Places of a frame's sheets where they gape: a bond that still reaches across is longer than the strain at its ends explains,
///     |u_j - u_i - (H_i + H_j)/2 r_ij| > |r_ij|/2
/// Requires Solids::gradients of the present time.
std::vector<Vec3> gaping_places(const Solids& solids, std::int32_t frame);

/// Bonds beside cracks that gape, though they cross no sheet: they pass where sheets of several cracks meet and leave a
/// pinhole. Their opening is that of gaping_places, beyond twice the strain that the strength allows, strength over
/// lambda + 2 mu, or half of their length. They come nearer to a sheet than a row: far from sheets, matter that is bent
/// a great deal strains as unevenly. They are to part. Requires gradients and laws of the present time.
std::vector<WeakBond> pinhole_bonds(const CrackedMatter& matter, const Solids& solids);

/// All bonds of elements that cracks have left less than 3/20 of their weights: they are to part. Moving least squares of
/// a few weak bonds gives strains without bound. Where such an element is pressed, as under an impact, it would burst.
std::vector<WeakBond> loose_bonds(const Elements& elements);

/// The visibility of all bonds that cross sheets. Bonds that have parted are forgotten. Near a front an element may hang
/// on weakened bonds alone, and moving least squares would have them bear what whole ones do. So a bond that crosses a
/// sheet parts where the tension at an end is three times the strength. Without `tension`, of elements, none does.
std::vector<WeakBond> weak_bonds(const std::vector<Breaking>& breaking, const Elements& elements,
                                 const std::vector<Tension>& tension, Cracks& cracks);

/// What cracks leave of the way between two places [1]. It is the least transparency of the triangles that the way
/// crosses, at q = r/h with the support h [m].
Real share_left(const CrackTree& sheets, const Cracks& cracks, const Vec3& from, const Vec3& to, Real support,
                Real opaque);

/// The share of its weight with which an element moves a surfel, by the cracks between the two. A surfel looks from
/// just below the surface, so that those of a sheet see their own side.
class CrackSight {
  public:
    explicit CrackSight(const Solids& solids);
    bool empty() const { return matter_.empty(); }
    /// The shares of these elements in their order [1]. False where nothing is in between: all are 1.
    bool shares(const Vec3& m, const Vec3& normal, std::span<const Index> elements, std::vector<Real>& share) const;
    /// Whether a way from a surfel to an element that moves it crosses one of these triangles of its body's cracks.
    bool crosses(const CrackTree& triangles, const EmbeddedSurface& embedded, Index surfel) const;
    /// The nearest element that a place on the surface sees; the nearest of all where it sees none. The frame has matter.
    Index nearest_seen(std::int32_t frame, const Vec3& m, const Vec3& normal) const;
    const CrackedMatter* matter_of(std::int32_t frame) const;

  private:
    Real share(const CrackedMatter& matter, const CrackTree& sheets, const Vec3& from, Index element) const;

    const Solids* solids_;
    std::vector<CrackedMatter> matter_;
};

}  // namespace thixo
