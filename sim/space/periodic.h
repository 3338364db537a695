// Periodic axes of the domain: matter that leaves through one face returns through the opposite one.
//
// Sweeps across a face use ghosts. A ghost is a copy of a particle within one support of a periodic face, shifted by
// the period (across edges and corners too). Every packed array that sweeps gather from holds n particles, then g
// ghosts, then one filler:
//     [0, n)  particles     [n, n + g)  ghosts     [n + g]  filler, which adds nothing to a sum
// Only particles have neighbour lists. The lists name particles and ghosts alike, so that a sweep needs no branch.
// Arrays of Particles have no ghosts: an index from a list must not be used there.
//
// A solver with packed arrays of its own (pressures, search directions, ...) does this:
//     1. once a step      resize_packed(s.sweep.ghosts, array, filler_value);   room for n + g + 1, filler set
//     2. each iteration   write array[i] for i < n (parallel_for over n = s.particles.size(), as ever)
//     3. before a gather  refresh_ghosts(s.sweep.ghosts, array);                ghosts copy their particles
//     4. in the sweep     for_each_run(s.neighbours[i], s.sweep.nobody(), ...)  pads with the filler
// A value that holds a place must go through refresh_places, which adds the shift. Sums and residuals run over i < n.
// Without periodic axes g = 0, and 1 and 3 cost nothing: the same code serves both.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "pipeline/base/lanes.h"
#include "pipeline/base/math.h"
#include "pipeline/base/parallel.h"
#include "pipeline/contract/scene.h"
#include "sim/state/particles.h"

namespace thixo {

/// The periodic axes of a scene, in the numbers of the state. Along a periodic axis places and the period are multiples
/// of `grain`, the distance of neighbouring floats at the domain's far end. A shift by the period and any difference of
/// two places are then exact. A pair across a face has the same forces, bit for bit, as elsewhere, and momentum is
/// conserved.
struct Periodic {
    struct Axis {
        bool on = false;
        Real from = 0, to = 0;  // [m], from <= x < to
        Real grain = 0;         // [m]
    };
    std::array<Axis, 3> axis;

    bool any() const { return axis[0].on || axis[1].on || axis[2].on; }
    Real period(int a) const { return axis[static_cast<std::size_t>(a)].to - axis[static_cast<std::size_t>(a)].from; }
    /// The image of x in the domain, rounded to the grain. A place that is not finite stays.
    Vec3 wrapped(const Vec3& x) const;
    /// The image of x nearest to `about`.
    Vec3 nearest_image(const Vec3& x, const Vec3& about) const;
};

/// The periodic axes of a checked scene. Each is at least two supports [m] long, so that no particle meets two images
/// of another.
Periodic make_periodic(const scene::World& world, Real support);

/// Moves every particle into the domain. Its other places are shifted with it.
void wrap_particles(const Periodic& periodic, Particles& particles);

/// The ghosts of this step: ghost k stands for particle source[k] at its place + shift[k].
struct Ghosts {
    std::size_t particles = 0;  // n, where ghosts begin in a packed array
    std::vector<Index> source;
    std::vector<Vec3> shift;  // [m]
    std::size_t size() const { return source.size(); }
};

/// Finds the ghosts within `support` [m] of the periodic faces, in the order of their particles. Scratch of a step.
void find_ghosts(const Periodic& periodic, const std::vector<Vec3>& position, Real support, Ghosts& ghosts);

/// The places of particles and ghosts together [m].
void append_ghosts(const Ghosts& ghosts, const std::vector<Vec3>& position, std::vector<Vec3>& all);

template <class T>
void resize_packed(const Ghosts& ghosts, std::vector<T>& array, const T& filler) {
    array.resize(ghosts.particles + ghosts.size() + 1);
    array.back() = filler;
}

template <class T>
void refresh_ghosts(const Ghosts& ghosts, std::vector<T>& array) {
    parallel_for(
        ghosts.size(), [&](std::size_t k) { array[ghosts.particles + k] = array[ghosts.source[k]]; }, 2048);
}

/// The same for an array whose x, y, z are a place.
inline void refresh_places(const Ghosts& ghosts, std::vector<Quad>& array) {
    parallel_for(
        ghosts.size(),
        [&](std::size_t k) {
            const Quad& q = array[ghosts.source[k]];
            const Vec3& shift = ghosts.shift[k];
            array[ghosts.particles + k] = {q.x + shift.x(), q.y + shift.y(), q.z + shift.z(), q.w};
        },
        2048);
}

}  // namespace thixo
