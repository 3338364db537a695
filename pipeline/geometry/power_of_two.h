// Units that keep products of many lengths within the range of a float.
#pragma once

#include <cmath>

namespace thixo {

/// The largest power of two that is at most x > 0. Numbers in this unit have the same bits but for the exponent, so that
/// results are the same wherever neither way leaves the range.
template <class T>
T power_of_two_below(T x) {
    return std::ldexp(T(1), std::ilogb(x));
}

}  // namespace thixo
