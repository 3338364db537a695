// Scalars of a tree as numbers and truth values. Stricter than YAML readers commonly are: what one of them would take
// for another number (017, 0x1F, 1_000) or another type (yes) is refused with a hint.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "pipeline/contract/scene_value.h"

namespace thixo::scene {

template <class T>
struct Scalar {
    std::optional<T> value;
    std::string hint;  // where there is no value: what to do, or empty
};

/// A finite decimal number.
Scalar<double> to_number(const Value& value);
Scalar<std::int64_t> to_whole(const Value& value);
Scalar<std::uint64_t> to_unsigned(const Value& value);
/// true or false.
Scalar<bool> to_truth(const Value& value);

}  // namespace thixo::scene
