// The time that a run has reached.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace thixo {

struct Clock {
    int frame = 0;          // the last frame reached
    std::int64_t step = 0;  // steps made since the start
    double time = 0;        // t [s]
    double last_dt = 0;     // the step that led to t; 0: none yet [s]
    double next_frame = 0;  // time of frame + 1 [s]
};

}  // namespace thixo
