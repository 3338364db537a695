// Trimmed sheets: which crossings of a sheet bound the body (docs/surfels.md).
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "pipeline/contract/trim.h"
#include "render/sheet_field.h"

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
    /// `tree` by object, its sheets being layers; `object` by layer; `layer` by surfel. Turns surfels of the cloud.
    /// Throws CacheError where a tree names one sheet both as kept and as taken away, or one of another object.
    Trims(const std::vector<std::optional<TrimNode>>& tree, std::span<const Index> object,
          std::span<const std::uint32_t> layer, SurfelCloud& cloud);

    bool trimmed(Index object) const { return object < trees_.size() && trees_[object].has_value(); }
    /// Whether a crossing of `layer` at x bounds the object: the tree changes with the layer's side, every other
    /// sheet's side being that of x. Where x is nearer to another sheet than `radius` times kTrimOverlap, either side
    /// of it will do.
    bool keeps(Index object, std::uint32_t layer, const Vec3f& x, float radius) const;

  private:
    /// Whether a sheet of the node has a surfel within `reach` of x.
    bool near(const TrimNode& node, const Vec3f& x, float reach) const;

    std::vector<std::optional<TrimNode>> trees_;
    std::vector<std::optional<SheetField>> fields_;  // by layer
};

}  // namespace thixo::render
