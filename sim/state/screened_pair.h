// Heat that does not flow where cracks part matter.
#pragma once

#include "pipeline/base/math.h"

namespace thixo {

/// A part of the heat between two particles that does not flow: a crack is between them.
struct ScreenedPair {
    Index first, second;  // each pair once
    Real part;            // [1]
};

}  // namespace thixo
