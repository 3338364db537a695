// Axes of the domain that are periodic: what leaves through one face comes back through the opposite one.
//
// How a sweep sees across a face: particles within one support of a periodic face have ghosts, copies shifted by the
// period (across edges and corners too). In every packed array that sweeps gather from, n particles come first, then
// the g ghosts, last one filler:
//     [0, n)  particles     [n, n + g)  ghosts     [n + g]  filler, of which a sweep makes nothing
// Neighbour lists exist for the particles alone and name particles and ghosts alike, so a sweep needs no branch. It
// must not use an index from a list in an array of Particles, which has no ghosts.
//
// A solver with packed arrays of its own (pressures, search directions, ...):
//   1. once a step      resize_packed(s.sweep.ghosts, array, filler_value);   room for n + g + 1, filler set
//   2. each iteration   write array[i] for i < n (parallel_for over n = s.particles.size(), as ever)
//   3. before a sweep gathers from it      refresh_ghosts(s.sweep.ghosts, array);   ghosts copy what they are images of
//   4. in the sweep     for_each_run(s.neighbours[i], s.sweep.nobody(), ...)        the filler, wherever it is
// A value that holds a place must go through refresh_places, which adds the shift. Sums and residuals run over i < n.
// Without periodic axes g = 0 and 1, 3 cost nothing; the same code serves both.
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

/// The periodic axes of a scene, in the numbers of the state. Along a periodic axis places are multiples of `grain`,
/// the distance of neighbouring floats at the domain's far end, and so is the period: then a shift by the period and
/// any difference of two places are exact, a pair across a face feels bit for bit what it would feel elsewhere, and
/// momentum is conserved as without periodic axes.
struct Periodic {
    struct Axis {
        bool on = false;
        Real from = 0, to = 0;  // [m], from <= x < to
        Real grain = 0;         // [m]
    };
    std::array<Axis, 3> axis;

    bool any() const { return axis[0].on || axis[1].on || axis[2].on; }
    Real period(int a) const { return axis[static_cast<std::size_t>(a)].to - axis[static_cast<std::size_t>(a)].from; }
    /// The image of x in the domain, rounded to the grain. What is not finite stays.
    Vec3 wrapped(const Vec3& x) const;
    /// The image of x nearest to `about`.
    Vec3 nearest_image(const Vec3& x, const Vec3& about) const;
};

/// The periodic axes of a checked scene: each at least two supports [m] long, so that no particle meets two images of
/// another.
Periodic make_periodic(const scene::World& world, Real support);

/// Brings every particle into the domain; what else is a place of the particle is shifted along.
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
            const Vec3& s = ghosts.shift[k];
            array[ghosts.particles + k] = {q.x + s.x(), q.y + s.y(), q.z + s.z(), q.w};
        },
        2048);
}

}  // namespace thixo
