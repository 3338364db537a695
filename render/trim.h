// Trimmed sheets: which crossings of a sheet bound the body (docs/surfels.md).
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "pipeline/contract/trim.h"
#include "render/sheet_field.h"
#include "render/shutter.h"

namespace thixo::render {

/// A crossing may stand out over a crease by this part of the surfels' radius. The field told here and the one the ray
/// walks in differ by less, so that no ray slips through between two sheets. A ray that cuts a corner there enters by
/// the one sheet and does not meet the other.
inline constexpr float kTrimOverlap = 1e-3f;

/// The trees of all objects, over layers. Sheets that are taken away from the body face the other way. They are turned,
/// so that every surfel's normal leads out of the body, and the trees are unions and intersections alone.
class Trims {
  public:
    Trims() = default;
    /// `tree` by object, its sheets being layers; `object` by layer; `layer` and `velocity` by surfel. Turns surfels of
    /// the cloud. Throws CacheError where a tree names one sheet both as kept and as taken away, or one of another
    /// object. Without velocities nothing moves.
    Trims(const std::vector<std::optional<TrimNode>>& tree, std::span<const Index> object,
          std::span<const std::uint32_t> layer, SurfelCloud& cloud, std::span<const Vec3f> velocity = {});

    /// How an object turns at the frame's own time [rad/s]; nothing where it has no tree or nothing moves.
    std::optional<Vec3f> angular(Index object) const {
        return trimmed(object) && !motion_.empty() ? std::optional(motion_[object].angular()) : std::nullopt;
    }
    bool trimmed(Index object) const { return object < trees_.size() && trees_[object].has_value(); }
    /// Whether a crossing of `layer` at a place bounds the object. The tree changes with the layer's side, and every
    /// other sheet's side is that of the place. Nearer to another sheet than `radius` times kTrimOverlap, either side of
    /// it will do. The place is that `seconds` after the frame's own time. All sheets of an object have moved there by
    /// one affine motion, which a rigid piece has exactly. So they still meet at their creases.
    bool keeps(Index object, std::uint32_t layer, const Vec3f& place, float radius, float seconds) const;

  private:
    /// Whether a sheet of the node has a surfel within `reach` of x.
    bool near(const TrimNode& node, const Vec3f& x, float reach) const;

    std::vector<std::optional<TrimNode>> trees_;
    std::vector<std::optional<SheetField>> fields_;  // by layer
    std::vector<AffineVelocity> motion_;             // by object; empty: nothing moves
};

}  // namespace thixo::render
