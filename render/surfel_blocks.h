// Surfels as the ray tracer holds them: blocks of eight near neighbours.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "pipeline/base/lanes.h"
#include "pipeline/geometry/shape.h"
#include "pipeline/geometry/surfel.h"
#include "render/shutter.h"

namespace thixo::render {

/// A surfel's support is the ellipsoid around its disc with half-axes kReach t1, kReach t2 and kHeight sqrt(|t1||t2|)
/// n. Its weight falls from centre to rim, and only there may it take part in the surface (docs/surfels.md).
inline constexpr float kReach = 1.25f;
inline constexpr float kHeight = 1.1f;

/// One lane is one surfel.
struct SurfelBlock {
    FloatLanes centre[3];      // s [m], as the shutter opens
    FloatLanes to_unit[3][3];  // rows map x - s into the support's unit ball [1/m]; row 2 is along the normal
    FloatLanes height;         // half-axis along the normal [m]; unit normal = height * row 2
    IndexLanes layer;          // only surfels of one layer blend: a body, or a sheet of a body
    IndexLanes source;         // index in the cloud; kNone in an unused lane
};

/// What saves most rays a look into a block. Its unit normals lie in this ball, so that n.d is within radius of
/// centre.d.
struct BlockSummary {
    float centre[3], radius;
    std::uint32_t layer;  // of all its surfels; kNone: of several
};

/// How surfels move: the centres straight and evenly, while the shutter is open [m]; the axes turn [rad/s].
struct BlockMotion {
    FloatLanes way[3], angular[3];
};

inline constexpr float kMostTurn = 0.5f;  // [rad]: centres go straight, and leave the circle by an eighth

struct SurfelBlocks {
    std::unique_ptr<SurfelBlock[]> storage;  // not a vector: it is first touched by the threads that fill it
    std::unique_ptr<BlockSummary[]> summary;
    std::unique_ptr<BlockMotion[]> motion;  // null: nothing moves
    std::vector<Box3> bounds;               // of each block's supports, as the shutter opens
    std::vector<Box3> last_bounds;          // the same as it closes; empty: nothing moves
    Shutter shutter;
    std::size_t dropped = 0;  // surfels with no finite frame of their own: they cannot be seen
    std::size_t whirling =
        0;  // surfels that turn by more than kMostTurn while the shutter is open: their surface gapes
    std::span<const SurfelBlock> blocks() const { return {storage.get(), bounds.size()}; }

    /// A block at a ray's time. `room` is for one that has moved.
    const SurfelBlock& at(Index block, float time, SurfelBlock& room) const {
        return motion ? moved(block, time, room) : storage[block];
    }

  private:
    const SurfelBlock& moved(Index block, float time, SurfelBlock& room) const;
};

/// Surfels that move while the shutter is open. Without velocities, or where it is open for no time, none do.
struct MovingSurfels {
    const SurfelCloud& cloud;
    std::span<const Vec3f> velocity{};  // [m/s]
    Shutter shutter{};
    // By layer: how its object turns, which moves as one [rad/s]. Others turn as the velocities of near surfels have it.
    std::vector<std::optional<Vec3f>> angular{};
    bool move() const { return shutter.moves() && !velocity.empty(); }
};

/// Sorts surfels so that neighbours come together and packs them into blocks. layer[k] belongs to surfel k. Requires
/// arrays of equal size. A velocity that is not finite counts as none.
SurfelBlocks pack_surfels(const MovingSurfels& surfels, std::span<const std::uint32_t> layer);

}  // namespace thixo::render
