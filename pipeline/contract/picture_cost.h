// What rendering a look will need, counted before it starts.
#pragma once

#include "pipeline/contract/cache.h"
#include "pipeline/contract/scene.h"

namespace thixo::scene {

struct PictureCost {
    double memory = 0;          // of one picture on its way to disk, and of the look's images [bytes]
    double disk_per_frame = 0;  // EXR and PNG [bytes]
};

/// Counts pixels: of the picture, and of every image as its header states them. Images are taken from the cache where
/// it has them. Throws as image_bytes.
PictureCost picture_cost(const Look& look, const CacheReader* cache);

}  // namespace thixo::scene
