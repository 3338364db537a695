// The surface between surfels: what the discs a ray crosses blend to (docs/surfels.md).
#pragma once

#include <span>

#include "render/surfel_gather.h"
#include "render/surfel_hit.h"
#include "render/trim.h"

namespace thixo::render {

/// First crossing in [ray.tmin, end] of the surface the candidates blend to:
///   w_i(x) = (1 - |M_i (x - s_i)|^2)^3 where positive, M_i into surfel i's support;
///   f(x) = u_c with the algebraic sphere u_c + u_l.y + u_q y.y (y = point - x) that fits the weighted points and
///   normals (Guennebaud & Gross 2007, beta = 1): it is exact where the surfels lie on a plane or a sphere.
/// Only surfels of one layer whose normals agree blend. Crossings that the object's trim tree does not keep are none. A
/// ray outside an object meets f going from + to -, one inside (named in `interior`) from - to +: what it has entered
/// it leaves, and nothing else. False: no crossing in this window.
bool first_crossing(std::span<const SurfelBlock> blocks, const Ray& ray, const Interior& interior,
                    std::span<const Index> object, const Trims& trims, Candidates& candidates, float end,
                    bool want_weights, SurfelHit& hit);

}  // namespace thixo::render
