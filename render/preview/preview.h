// Quick pictures of a cache frame by offscreen OpenGL on the CPU: particles or surfels, obstacles as translucent
// meshes.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>

#include "pipeline/contract/frame.h"
#include "pipeline/contract/image.h"
#include "pipeline/contract/scene.h"
#include "pipeline/geometry/mesh.h"
#include "render/preview/splats.h"

namespace thixo {
struct RenderArgs;
}

namespace thixo::preview {

/// Background from the top to the bottom of the picture, display colours.
inline const Vec3f kBackgroundTop{0.945f, 0.950f, 0.955f};
inline const Vec3f kBackgroundBottom{0.835f, 0.840f, 0.850f};

struct PreviewOptions {
    int width = 0, height = 0;        // pixels; 0: those of the look
    std::string what = "auto";        // particles, surfels, auto
    std::string attribute;            // empty: Cd, else material colours
    std::optional<ValueRange> range;  // of the colours; empty: the frame's
    std::optional<View> view;         // empty: the camera of the look
    bool grid = true;                 // lines on the plane z = 0
    bool labels = true;               // legend, frame, time, counts
    int samples_per_axis = 0;         // antialiasing: 1 none, 2 good; 0: 2 up to 200k splats, else 1
};

/// Meshes of obstacles by asset hash, in asset space.
using Meshes = std::map<std::string, TriangleMesh>;

/// The box around a frame's particles, surfels and obstacles, for fitting_view.
Bounds frame_bounds(const Frame& frame, const Meshes& meshes);

/// True where the look's camera sees no point of the frame's particles or surfels.
bool misses(const View& view, const Frame& frame);

/// Draws frames; owns the OpenGL context and its programs. Throws ResourceError where there is no OpenGL 4.5. One
/// thread at a time.
class Previewer {
  public:
    Previewer();
    ~Previewer();
    Previewer(const Previewer&) = delete;
    Previewer& operator=(const Previewer&) = delete;

    /// The picture of a frame. Obstacles whose asset is not among the meshes are not drawn. Same machine, same input:
    /// same bytes. Throws InputError (unknown attribute, unusable camera), CacheError (points without P, pscale, t1,
    /// t2), ResourceError (picture too large).
    void draw(const Frame& frame, const scene::Look& look, const Meshes& meshes, const PreviewOptions& options,
              Image8& out);

  private:
    struct Device;
    std::unique_ptr<Device> device_;
};

}  // namespace thixo::preview

namespace thixo {

/// The stage: reads args.out/cache and writes args.out/preview/<what>.<attribute>.NNNN.png for the frames asked for.
/// Without an attribute the file name says `material`. The colours of an attribute mean the same in all frames of one
/// run. The scene is the one the caller resolved (its own or the cache's, with look file and --set). Throws what
/// Previewer and CacheReader throw, and InterruptedError.
int run_preview(const RenderArgs& args, const scene::Scene& scene);

}  // namespace thixo
