// The surface between surfels: what the discs a ray crosses blend to (docs/surfels.md).
#pragma once

#include "render/surfel_gather.h"
#include "render/surfel_hit.h"
#include "render/trim.h"

namespace thixo::render {

/// First crossing in [ray.tmin, end] of the surface the candidates blend to. With weights w_i (surfel_fit.h) the
/// algebraic sphere
///   u_c + u_l.y + u_q y.y,   y = point - x,
/// fits the weighted points and normals (Guennebaud & Gross 2007, beta = 1), and the surface is where
///   f(x) = u_c
/// is zero: exact where the surfels lie on a plane or a sphere.
/// Only surfels of one layer whose normals agree blend. Crossings that the object's trim tree does not keep are none. A
/// ray outside an object meets f going from + to -. A ray inside, where `from.interior` names the object, meets f going
/// from - to +: what it has entered it leaves, and nothing else. False: no crossing in this window.
bool first_crossing(const Gathering& from, const Trims& trims, Candidates& candidates, float end, bool want_sources,
                    SurfelHit& hit);

}  // namespace thixo::render
