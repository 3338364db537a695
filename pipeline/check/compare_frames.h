// Two frames of caches.
#pragma once

#include "pipeline/check/report.h"
#include "pipeline/contract/frame.h"

namespace thixo {

/// A against the reference B: time, spacing, bodies, obstacles, totals, and every attribute of particles and surfels,
/// all bit for bit. Points are paired in ascending id (attribute `id`), or in stored order where both have none.
/// Attributes with values that are not finite fail even where they agree.
FrameReport compare_frames(const std::string& name, const Frame& a, const Frame& b);

}  // namespace thixo
