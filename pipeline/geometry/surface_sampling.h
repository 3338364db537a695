// Surfels on the surface of a shape: evenly spread, one sheet for every smooth face, with the tree that trims them.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "pipeline/geometry/shape.h"
#include "pipeline/geometry/sheet_tree.h"
#include "pipeline/geometry/surfel.h"

namespace thixo {

/// The density of surfels: either count or spacing. With neither there is a surfel for every point or mesh vertex.
struct SurfaceSampling {
    std::size_t count = 0;   // all surfels, those beyond edges included
    double spacing = 0;      // [m]; every surfel has a square of this edge
    std::uint64_t seed = 1;  // of the random points
};

/// Surfels of a body's surface. Rest places m0 are their positions.
struct SampledSurface {
    SurfelCloud surfels;              // normals out of the body; round discs unless said otherwise
    std::vector<std::int32_t> sheet;  // of each surfel, from 0 on, ascending
    std::vector<Vec3f> colour;        // linear, of each surfel, from vertex colours; empty where there are none
    int sheets = 1;
    std::optional<SheetTree> trim{};  // over the sheets; none: one sheet without edges
    double area = 0;                  // of the body's surface, without the parts beyond edges [m^2], to about a percent
    double spacing = 0;               // [m]
};

/// Thickness in spacings below which a solid of several faces is too thin for surfels.
inline constexpr double kThinnest = 0.02;

/// How far a sheet extends beyond its edges, in spacings, so that its blend has full support there.
inline constexpr double kSheetReach = 1.75;

/// Samples a bounded shape. Every face (Shape::Node::faces) becomes a sheet: a box has six, a cylinder three, and a
/// combination has those of its operands. Smooth combinations, swept tubes and meshes have one. Exactly `count` surfels
/// are distributed by area. Random points on the faces are thinned to them (sample elimination, Yuksel 2015) and then
/// pushed apart along the surface. Normals are gradients of the distance. Radii are the spacing, or more where that
/// would leave a gap: every point of the surface lies under a disc of its sheet. The same arguments give the same bits
/// at any thread count. Throws InputError where the shape is unbounded, has no surface, or is mostly too thin for its
/// surfels. It also throws where both count and spacing are given, or neither and the shape has no points of its own.
SampledSurface sample_surface(const Shape& shape, const SurfaceSampling& sampling);

}  // namespace thixo
