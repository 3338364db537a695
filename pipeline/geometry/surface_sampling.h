// Surfels on the surface of a shape: evenly spread, one sheet for every smooth face, with the tree that trims them.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "pipeline/geometry/shape.h"
#include "pipeline/geometry/sheet_tree.h"
#include "pipeline/geometry/surfel.h"

namespace thixo {

/// How densely: one of count and spacing; neither: a surfel for every point of a point set or vertex of a mesh.
struct SurfaceSampling {
    std::size_t count = 0;   // surfels in all, those that reach past edges included
    double spacing = 0;      // [m]; every surfel has a square of this edge
    std::uint64_t seed = 1;  // of the places tried
};

/// Surfels of a body's surface. Rest places m0 are their positions.
struct SampledSurface {
    SurfelCloud surfels;              // normals out of the body; round discs unless said otherwise
    std::vector<std::int32_t> sheet;  // of each surfel, from 0 on, ascending
    std::vector<Vec3f> colour;        // linear, of each surfel, from vertex colours; empty where there are none
    int sheets = 1;
    std::optional<SheetTree> trim{};  // over the sheets; none: one sheet without edges
    double area = 0;     // of the body's surface, without what reaches past edges [m^2], to about a percent
    double spacing = 0;  // [m]
};

/// The part of the spacing by which a sheet reaches past its edges, so that its blend has full support there.
inline constexpr double kSheetReach = 1.75;

/// Samples a bounded shape. Every face (Shape::Node::faces) becomes a sheet: a box six, a cylinder three, a combination
/// those of its operands; smooth combinations, swept tubes and meshes are one. `count` surfels, exactly, are shared out
/// by area; random points on the faces are thinned to them (sample elimination, Yuksel 2015), then pushed apart along
/// the surface. Normals are gradients of the distance. Radii are the spacing, more where that leaves a gap: every point
/// of the surface lies under a disc of its sheet. The same arguments give the same bits at any thread count. Throws
/// InputError where the shape is unbounded or no surface is found, both count and spacing are given, or neither and the
/// shape has no points of its own.
SampledSurface sample_surface(const Shape& shape, const SurfaceSampling& sampling);

}  // namespace thixo
