// Boundaries as they are drawn.
#pragma once

#include <optional>

#include "pipeline/contract/scene.h"
#include "pipeline/geometry/mesh.h"

namespace thixo {

/// The surface of a boundary in its own frame; a room shows its inner side, a plane reaches from horizon to horizon.
/// Empty, with a warning, where the boundary is unbounded and no plane. Throws InputError that begins with the
/// place in the scene where it cannot be tessellated. So too where an appearance maps an image by texture coordinates
/// that it lacks.
std::optional<TriangleMesh> boundary_mesh(const scene::Scene& scene, const scene::Boundary& boundary);

/// Throws what boundary_mesh would throw, and takes less time.
void require_drawable(const scene::Scene& scene, const scene::Boundary& boundary);

}  // namespace thixo
