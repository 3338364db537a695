// How a key of the scene file is declared: once, beside its struct, in visit(V&, Struct&). Reader, validation, printer,
// hash, docs/scene.md, the JSON Schema and --set are visitors of these declarations. A key's default is its member's
// initialiser.
//
// A visitor V has these functions, each for one kind of key:
//
//     key(name, member, unit, check, meaning)         a value (below)
//     reference(name, text, refers, check, meaning)   name of another entry of the scene
//     file(name, text, check, meaning)                path of a file, relative to the scene file that names it
//     group(name, meaning, f)                         block; f(V&) declares its keys
//     block(name, struct, meaning)                    block that is a struct with a visit of its own
//     named(name, vector, meaning)                    map from names to blocks that have a member `name`, order kept
//     list(name, vector, meaning)                     list of blocks
//     shape(name, shape, check, meaning)              one shape
//     shapes(name, vector, check, meaning)            list of shapes
//     named_shapes(name, vector, meaning)             map from names to shapes, order kept
//
// A value is a number, a whole number, true or false, a text, a word (of an enum), a vector, a colour or a profile.
#pragma once

#include <array>
#include <string_view>

namespace thixo::scene {

/// What a value must satisfy; for a vector, each of its components. Every number must be finite in any case.
struct Check {
    double low = -1e12, high = 1e12;
    bool open_low = false, open_high = false;  // the end itself is not allowed
    bool nonzero = false;                      // a vector that must have a direction
    bool required = false;
};

constexpr Check any() { return {}; }
constexpr Check above(double low) { return {.low = low, .open_low = true}; }
constexpr Check at_least(double low) { return {.low = low}; }
constexpr Check between(double low, double high) { return {.low = low, .high = high}; }
/// Above low, and at most high.
constexpr Check above_to(double low, double high) { return {.low = low, .high = high, .open_low = true}; }
/// Above low and below high.
constexpr Check inside(double low, double high) {
    return {.low = low, .high = high, .open_low = true, .open_high = true};
}
constexpr Check direction() { return {.nonzero = true}; }
constexpr Check required(Check check = {}) {
    check.required = true;
    return check;
}

/// Units that say more than a unit: a colour is shown and documented as [r, g, b].
inline constexpr const char* kColour = "rgb";

enum class Refers { material, appearance, shape, body };

/// The words of an enum as users write them; word k stands for the enumerator of value k.
template <class E>
struct Words;

}  // namespace thixo::scene
