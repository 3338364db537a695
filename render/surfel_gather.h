// Which surfels a ray may meet: the ones whose supports it crosses up to the end of a window behind the first disc it
// hits.
#pragma once

#include <algorithm>
#include <span>

#include "render/ray.h"
#include "render/surfel_blocks.h"

namespace thixo::render {

/// A surfel whose support the ray crosses in [enter, leave].
struct Candidate {
    Index surfel;  // block * kFloatLanes + lane
    float enter, leave;
};

/// The eight surfels of a block as the ray crosses them:
///   1 - |M (x - s)|^2 = 2 b u - a u^2 - c,   u = t - near.
struct Row {
    FloatLanes enter, leave;
    FloatLanes plane;   // where the ray meets the disc's plane
    FloatLanes facing;  // n.d
    FloatLanes near, a, b, c;
    Index block;
    unsigned lanes;  // a bit for each that is a candidate
};

/// Candidates of one window [ray.tmin, end]. Once it is complete, every surfel whose support begins before `end` is
/// here. The window ends where the ray leaves the support of the first disc that it hits from its own side. So the
/// surface is met before the end, or not in this window.
struct Candidates {
    static constexpr int kCapacity = 64, kRows = 12, kAverted = 32;
    Row rows[kRows];
    int row_count = 0;
    Index averted[kAverted];  // blocks that look away from the ray: nothing is met there unless another faces it,
                              // and is cut off by them where it goes on past their edge
    int averted_count = 0;
    bool listed = false;  // the rows became too many: `list` holds the candidates, and there are no rows
    Candidate list[kCapacity];
    int count = 0;
    float begin = 0;  // of the ray's first window
    float end = kInfinity;
    bool faced = false;  // one at least faces the ray; none: it cannot cross the surface in this window

    /// Makes the list of the rows. Where there are more candidates than it holds, the first are kept, and the window
    /// ends where the first dropped one begins. The result does not depend on the order of the rows.
    void make_list(float tmin);

    /// From where on crossings are of this window. Seams of windows overlap. The fits before and after a seam use other
    /// candidates. They differ by less than a thousandth of a radius, and what is crossed between them would be in
    /// neither window.
    float start(const Ray& ray, float radius) const { return std::max(begin, ray.tmin - kSeam * radius); }
    static constexpr float kSeam = 0.02f;
};

/// Normals that take part in one surface are within this of their mean (weights fade from kFullCosine on).
inline constexpr float kLimitCosine = 0.57357644f;  // 55 degrees
inline constexpr float kFullCosine = 0.81915204f;   // 35 degrees

/// The surfels a ray outside of all but the objects of `interior` goes by. `object` is indexed by layer.
struct Gathering {
    const SurfelBlocks& packed;
    const Ray& ray;
    const Interior& interior;
    std::span<const Index> object;
    /// From the frame's own time to the ray's [s].
    float seconds() const { return packed.motion ? packed.shutter.seconds(ray.time) : 0; }
};

/// Adds the surfels of one block to the candidates and draws the window's end in. The result does not depend on the
/// order of calls.
void gather(const Gathering& from, Index block, Candidates& found);

/// To be called after all blocks: adds what was left aside, makes the list where the window's end depends on it. False:
/// nothing faces the ray, so that it cannot cross the surface in this window; its end may then be later than need be.
bool complete(const Gathering& from, Candidates& found);

}  // namespace thixo::render
