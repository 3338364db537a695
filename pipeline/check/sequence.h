// What can be said of a picture by its look and by the frame before it.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "pipeline/check/report.h"
#include "pipeline/contract/image.h"

namespace thixo {

/// Follows two sequences frame by frame.
class Sequence {
  public:
    /// The measures of the next pair, of equal sizes; nothing where R, G or B is missing. Pixels that are not finite
    /// enter no mean. A pair of another size than the one before begins a new sequence.
    std::optional<PictureMeasures> next(const Image& a, const Image& b);
    /// A frame that only one side has: what follows is no sequence with what was before.
    void interrupt() { difference_[0].clear(); }

  private:
    std::array<std::vector<float>, 3> difference_;  // a - b of the frame before, by colour
};

}  // namespace thixo
