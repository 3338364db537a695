// The surface between surfels: what the discs a ray crosses blend to (docs/surfels.md).
#pragma once

#include "render/surfel_gather.h"
#include "render/surfel_hit.h"
#include "render/trim.h"

namespace thixo::render {

/// First crossing in [ray.tmin, end] of the surface that the candidates blend to. At each x an algebraic sphere
///
///     u_c + u_l.y + u_q y.y,   y = point - x   [m]
///
/// is fitted to the points and normals with weights w_i (surfel_fit.h; Guennebaud & Gross 2007, beta = 1). The surface
/// is where
///
///     f(x) = u_c   [m]
///
/// is zero. It is exact where the surfels lie on a plane or a sphere. Only surfels of one layer whose normals agree
/// blend. Crossings that the object's trim tree does not keep do not count. A ray outside an object meets f going from
/// + to -. A ray inside, where `from.interior` names the object, meets f going from - to +: it can only leave what it
/// has entered. False: no crossing in this window.
bool first_crossing(const Gathering& from, const Trims& trims, Candidates& candidates, float end, bool want_sources,
                    SurfelHit& hit);

}  // namespace thixo::render
