// Two frames of caches.
#pragma once

#include "pipeline/check/report.h"
#include "pipeline/contract/frame.h"

namespace thixo {

/// Compares A with the reference B bit for bit. This takes in number, time, spacing, bodies with their trim trees,
/// obstacles, totals, and every attribute of particles and surfels. Points are paired in ascending order of their
/// attribute `id`, or in stored order where both sides have none. The order of stored points and of their attributes is
/// not compared. Attributes with values that are not finite fail even where they agree.
FrameReport compare_frames(const std::string& name, const Frame& a, const Frame& b);

}  // namespace thixo
