// Checks shared by the constructors of shapes.
#pragma once

#include <cmath>

#include "pipeline/base/error.h"

namespace thixo {

inline double positive_size(double value, const char* what) {
    if (!(value > 0) || !std::isfinite(value))
        throw InputError("{} is {}; it must be a finite length above 0", what, value);
    return value;
}
inline double size_not_negative(double value, const char* what) {
    if (!(value >= 0) || !std::isfinite(value))
        throw InputError("{} is {}; it must be a finite length of 0 or more", what, value);
    return value;
}
inline double finite_number(double value, const char* what) {
    if (!std::isfinite(value)) throw InputError("{} is {}; it must be finite", what, value);
    return value;
}
template <class V>
const V& finite_vector(const V& value, const char* what) {
    for (int k = 0; k < value.size(); ++k) finite_number(static_cast<double>(value[k]), what);
    return value;
}

}  // namespace thixo
