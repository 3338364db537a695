// The narrow phase of contact: the places where two bodies meet, or where one meets itself.
#pragma once

#include <tuple>
#include <vector>

#include "sim/contact/broad.h"
#include "sim/space/walls.h"

namespace thixo {

inline std::size_t at(std::int32_t body) { return static_cast<std::size_t>(body); }

/// Identifies a node from one time to the next: its sample and partner, or its two elements.
using NodeKey = std::tuple<Index, std::int32_t, Index, Index>;

/// A node just found.
struct Found {
    Index sample = kNone, first = kNone, second = kNone;
    std::int32_t owner = 0, partner = 0;
    NodeKey key() const { return {sample, partner, first, second}; }
    Vec3 normal{0, 0, 0};
    Real gap = 0;
    Real area = 0;
    Real steepness = 1;  // change of the distance in the rest shape per distance in the world [1]
    bool slides = true;
    std::vector<Index> element;  // those of the owner, then, from `middle` on, of the partner
    std::vector<Real> weight;
    std::size_t middle = 0;
    Vec3 place{0, 0, 0}, anchor{0, 0, 0};  // as in ContactNodes
    Real explained = 0;                    // most depth that the bodies' speeds can have made in the last sub-step [m]
};

/// The state from which nodes are found.
struct View {
    const Solids& solids;
    const std::vector<BodyPose>& poses;
    const std::vector<Extent>& extents;
    Real reach(std::int32_t body) const {  // how far the body's surface may lie from its elements' box
        const double stretch = std::sqrt(std::max(1.0, solids.stretch2));
        return extents[at(body)].width * static_cast<Real>(stretch);
    }
    Vec3 place_of(Index sample) const {
        const ContactSamples& samples = solids.contacts.samples;
        Vec3 m = samples.rest[sample];
        for (std::size_t k = samples.weights.begin[sample]; k < samples.weights.begin[sample + 1]; ++k)
            m += samples.weights.weight[k] * xyz(solids.elements.displacement[samples.weights.element[k]]);
        const BodyPose& pose = poses[at(samples.owner[sample])];
        return pose.turn * m + pose.place;
    }
};

/// Finds the samples of one body that meet another one, ascending. Each node found gets `explained` [m].
void find_samples(const View& view, std::int32_t owner, std::int32_t partner, Real explained,
                  std::vector<Found>& found);

/// Finds the samples of a body that meet a wall, ascending. Each node found gets `explained` [m]. Returns a lower bound
/// of the way from the wall to all samples that are not nodes, at least the margin [m].
Real find_samples_at_wall(const View& view, std::int32_t owner, const Walls& walls, std::size_t wall, Real explained,
                          std::vector<Found>& found);

/// Finds elements of two bodies, or of one (5.9), that are near and are not neighbours in a rest shape. Each node found
/// gets `explained` [m].
void find_elements(const View& view, std::int32_t owner, std::int32_t partner, Real explained,
                   std::vector<Found>& found);

}  // namespace thixo
