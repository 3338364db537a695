// Bodies that go on through periodic faces: prisms without ends along the periodic axes, as in plane strain.
#pragma once

#include "pipeline/geometry/shapes.h"
#include "sim/space/periodic.h"

namespace thixo {

/// The place with the same coordinates across the periodic axes, in the middle between their faces.
Vec3 in_section(const Vec3& x, const Periodic& periodic);

/// The projection onto the section: 1 along the axes across the periodic ones.
Mat3d onto_section(const Periodic& periodic);

/// The prism without ends that has the shape's section in the middle between the periodic faces. Unbounded.
Shape endless(Shape shape, const Periodic& periodic);

/// The moments of the prism's matter in one period, moved to the middle between the periodic faces: those of its section
/// alone. In: the shape's own, and its box. It may end a little before the faces, or beyond them.
ShapeMoments section_moments(const ShapeMoments& moments, const Box3& box, const Periodic& periodic);

/// Whether the prism through all of these places lies in the shape. It may end a quarter of a spacing [m] before the
/// periodic faces. Of a body's sites this tells that its section is the same everywhere.
bool goes_through(const Shape& shape, const std::vector<Vec3>& sites, Real spacing, const Periodic& periodic);

}  // namespace thixo
