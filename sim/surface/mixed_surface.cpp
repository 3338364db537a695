#include "sim/surface/mixed_surface.h"

#include <algorithm>

#include "pipeline/base/parallel.h"
#include "sim/surface/fit_discs.h"
#include "sim/surface/interpolate.h"

namespace thixo {
namespace {

/// Sets the temperatures of solids' surfels that have changed: the normalised interpolation of the body's particles.
void take_temperatures(const Particles& particles, Real support, const EmbeddedSurface& embedded,
                       const std::vector<Index>& source, SurfaceState& shown) {
    std::vector<Real> first;  // by body
    for (std::size_t i = 0; i < source.size(); ++i) {
        const auto body = static_cast<std::size_t>(shown.body[i]);
        if (first.size() <= body) first.resize(body + 1, 0);
        first[body] = embedded.temperature[source[i]];
    }
    const auto changed = [&](std::size_t k) {
        const auto body = static_cast<std::size_t>(particles.body[k]);
        return body < first.size() && static_cast<Real>(particles.temperature[k]) != first[body];
    };
    bool any = false;
    for (std::size_t k = 0; k < particles.size() && !any && !source.empty(); ++k) any = changed(k);
    if (!any) return;
    interpolate(
        shown.surfels.position, particles, support,
        [&](std::size_t i, Index k) { return particles.body[k] == shown.body[i]; },
        [&](Index k) { return particles.temperature[k]; },
        [&](std::size_t i, double temperature) { shown.temperature[i] = static_cast<Real>(temperature); });
}

/// Whether any matter of a body has begun to melt.
bool melts(const Solids& solids, const SolidBody& body) {
    if (!solids.softening.any) return false;
    return !body.shaped() ||
           std::ranges::any_of(body.elements, [&](Index i) { return solids.elements.solidity(i) < 1; });
}

/// Hands the present surfels of bodies that begin to melt over to the animated surface. `newly_melting` marks these
/// bodies.
void take_over(const EmbeddedSurface& embedded, Solids& solids, const SurfaceState& shown,
               const std::vector<Index>& source, MixedSurface& state, std::vector<std::uint8_t>& newly_melting) {
    newly_melting.assign(solids.bodies.size(), 0);
    bool any = false;
    for (std::size_t b = 0; b < solids.bodies.size(); ++b) {
        SolidBody& body = solids.bodies[b];
        if (body.skin != Skin::embedded || !melts(solids, body)) continue;
        body.skin = Skin::animated;
        newly_melting[b] = 1;
        any = true;
    }
    if (!any) return;
    SurfaceState& to = state.animated;
    for (std::size_t i = 0; i < source.size(); ++i) {
        const Index root = source[i];
        const EdgeCut& cut = embedded.edge[root];
        // Pieces of a disc that has split need not reach the edge.
        const bool unsplit = (i == 0 || source[i - 1] != root) && (i + 1 == source.size() || source[i + 1] != root);
        const bool past = embedded.beyond[root] != 0;
        if (!newly_melting[static_cast<std::size_t>(embedded.owner[root])] || (past && (cut.along == 0 || !unsplit)))
            continue;
        for_each_pair(to, shown, [&](auto& array, const auto& from) { array.push_back(from[i]); });
        to.id.back() = to.next_id++;
        Vec3 &a = to.surfels.axis1.back(), &b = to.surfels.axis2.back();
        if (past) {
            const Real c = cut.shift * std::cos(cut.shift_angle), s = cut.shift * std::sin(cut.shift_angle);
            to.surfels.position.back() += c * a + s * b;
            to.rest.back() += c * embedded.rest.axis1[root] + s * embedded.rest.axis2[root];
        }
        const SolidBody& body = solids.bodies[static_cast<std::size_t>(embedded.owner[root])];
        add_zombie(to.surfels, to.size() - 1, to.rest.back(), body.material, to.body.back(), state.zombies);
        const Real c = std::cos(cut.angle), s = std::sin(cut.angle);
        const Vec3 along = c * a + s * b, across = c * b - s * a;
        const bool corner = cut.along < 1 && cut.across < 1;
        a = past_edge(cut.along, corner) * along;
        b = past_edge(cut.across, corner) * across;
    }
}

}  // namespace

SurfaceReport update_mixed_surface(const EmbeddedSurface& embedded, Solids& solids, Particles& particles,
                                   const SurfaceSetting& setting, MixedSurface& state, SurfaceState& shown,
                                   std::vector<Index>& source) {
    if (state.animated.next_id < kFirstAnimated) state.animated.next_id = kFirstAnimated;
    displace_embedded(embedded, solids, shown, source);
    release_thawed(solids, state.animated, state.zombies);
    std::vector<std::uint8_t> newly_melting;
    take_over(embedded, solids, shown, source, state, newly_melting);
    std::vector<Index> remaining;
    for (Index i = 0; i < source.size(); ++i)
        if (!newly_melting[static_cast<std::size_t>(embedded.owner[source[i]])]) remaining.push_back(i);
    if (remaining.size() < source.size()) {
        keep_table_rows(shown, remaining);
        keep_rows(source, remaining);
    }

    take_temperatures(particles, setting.support, embedded, source, shown);

    std::vector<Index> members;  // the particles that have an animated surface
    for (Index k = 0; k < particles.size(); ++k) {
        const Index i = solids.element(particles.id[k]);
        const auto owner = i == kNone ? 0 : static_cast<std::size_t>(solids.elements.owner[i]);
        if (i != kNone && solids.bodies[owner].skin == Skin::embedded) continue;
        members.push_back(k);
        // Its surfels are already at their present places.
        if (i != kNone && newly_melting[owner]) particles.surface_position[k] = particles.position[k];
    }
    SurfaceReport report;
    if (!members.empty() || state.animated.size() > 0)
        report = update_surface(state.animated, particles, setting, &state.zombies, &members);
    else
        particles.surface_position = particles.position;
    follow_refrozen(solids, particles, setting.support, state.animated, state.refrozen, state.zombies);
    for_each_pair(shown, state.animated,
                  [](auto& array, const auto& from) { array.insert(array.end(), from.begin(), from.end()); });
    shown.next_id = state.animated.next_id;
    return report;
}

}  // namespace thixo
