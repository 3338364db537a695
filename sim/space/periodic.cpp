#include "sim/space/periodic.h"

#include <cmath>
#include <limits>

#include "pipeline/base/error.h"

namespace thixo {
namespace {

/// Distance of neighbouring floats of the size of `largest`: every multiple of it up to there is a float.
double grain_at(double largest) { return std::ldexp(1.0, std::ilogb(largest) + 1 - std::numeric_limits<Real>::digits); }

// The images of a particle near a face. Along each axis they are itself, and those beyond the faces within reach.
struct Images {
    std::array<std::array<Real, 3>, 3> offset;  // per axis
    std::array<int, 3> count;
    int ghosts() const { return count[0] * count[1] * count[2] - 1; }
};

Images images_of(const Periodic& periodic, const Vec3& x, Real reach) {
    Images images{};
    for (int a = 0; a < 3; ++a) {
        const auto k = static_cast<std::size_t>(a);
        const Periodic::Axis& axis = periodic.axis[k];
        images.count[k] = 1;
        if (!axis.on) continue;
        if (x[a] < axis.from + reach)
            images.offset[k][static_cast<std::size_t>(images.count[k]++)] = periodic.period(a);
        if (x[a] >= axis.to - reach)
            images.offset[k][static_cast<std::size_t>(images.count[k]++)] = -periodic.period(a);
    }
    return images;
}

}  // namespace

Periodic make_periodic(const scene::World& world, Real support) {
    Periodic periodic;
    for (const scene::PeriodicAxis& entry : world.periodic) {
        Periodic::Axis& axis = periodic.axis[static_cast<std::size_t>(entry.axis)];
        const double far = std::max(std::abs(entry.from), std::abs(entry.to)) + static_cast<double>(support);
        const double grain = grain_at(far);
        const auto rounded = [&](double v) { return static_cast<Real>(std::round(v / grain) * grain); };
        axis = {true, rounded(entry.from), rounded(entry.to), static_cast<Real>(grain)};
        THIXO_ASSERT(axis.to - axis.from >= 2 * support * Real(0.999), "a period of {} m for a support of {} m",
                     axis.to - axis.from, support);
    }
    return periodic;
}

Vec3 Periodic::wrapped(const Vec3& x) const {
    Vec3 in = x;
    for (int a = 0; a < 3; ++a) {
        const Axis& span = axis[static_cast<std::size_t>(a)];
        if (!span.on || !std::isfinite(x[a])) continue;
        const double length = static_cast<double>(period(a)), grain = static_cast<double>(span.grain);
        double v = std::nearbyint(static_cast<double>(x[a]) / grain) * grain;
        v -= length * std::floor((v - static_cast<double>(span.from)) / length);
        if (v >= static_cast<double>(span.to)) v = static_cast<double>(span.from);  // floor of a rounded quotient
        in[a] = static_cast<Real>(v);
    }
    return in;
}

Vec3 Periodic::nearest_image(const Vec3& x, const Vec3& about) const {
    Vec3 image = x;
    for (int a = 0; a < 3; ++a)
        if (axis[static_cast<std::size_t>(a)].on) image[a] -= period(a) * std::round((x[a] - about[a]) / period(a));
    return image;
}

void wrap_particles(const Periodic& periodic, Particles& particles) {
    if (!periodic.any()) return;
    parallel_for(
        particles.size(),
        [&](std::size_t i) {
            const Vec3 x = particles.position[i], in = periodic.wrapped(x);
            particles.position[i] = in;
            if (particles.has.surface) particles.surface_position[i] += in - x;
        },
        2048);
}

void find_ghosts(const Periodic& periodic, const std::vector<Vec3>& position, Real support, Ghosts& ghosts) {
    ghosts.particles = position.size();
    ghosts.source.clear();
    ghosts.shift.clear();
    if (!periodic.any()) return;
    const Real reach = support * Real(1 + 1e-5);  // so that rounding loses no pair
    std::vector<std::size_t> begin((position.size() + kChunk - 1) / kChunk + 1, 0);
    parallel_chunks(position.size(), [&](std::size_t first, std::size_t last, std::size_t chunk) {
        for (std::size_t i = first; i < last; ++i)
            begin[chunk + 1] += static_cast<std::size_t>(images_of(periodic, position[i], reach).ghosts());
    });
    for (std::size_t c = 1; c < begin.size(); ++c) begin[c] += begin[c - 1];
    ghosts.source.resize(begin.back());
    ghosts.shift.resize(begin.back());
    parallel_chunks(position.size(), [&](std::size_t first, std::size_t last, std::size_t chunk) {
        std::size_t k = begin[chunk];
        for (std::size_t i = first; i < last; ++i) {
            const Images images = images_of(periodic, position[i], reach);
            for (int c = 1; c <= images.ghosts(); ++c) {  // 0 is the particle itself
                const int x = c % images.count[0], y = c / images.count[0] % images.count[1],
                          z = c / (images.count[0] * images.count[1]);
                ghosts.source[k] = static_cast<Index>(i);
                ghosts.shift[k] =
                    Vec3(images.offset[0][static_cast<std::size_t>(x)], images.offset[1][static_cast<std::size_t>(y)],
                         images.offset[2][static_cast<std::size_t>(z)]);
                ++k;
            }
        }
    });
}

void append_ghosts(const Ghosts& ghosts, const std::vector<Vec3>& position, std::vector<Vec3>& all) {
    all.resize(position.size() + ghosts.size());
    parallel_for(
        all.size(),
        [&](std::size_t k) {
            all[k] = k < position.size()
                         ? position[k]
                         : Vec3(position[ghosts.source[k - position.size()]] + ghosts.shift[k - position.size()]);
        },
        2048);
}

}  // namespace thixo
