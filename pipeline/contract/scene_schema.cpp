#include <nlohmann/json.hpp>

#include "pipeline/contract/scene_describe.h"
#include "pipeline/contract/scene_reference.h"
#include "pipeline/contract/scene_scalar.h"

namespace thixo::scene {
namespace {

using Json = nlohmann::ordered_json;
constexpr const char* kNamePattern = "^[A-Za-z0-9_][A-Za-z0-9_-]{0,63}$";

Json value_of(const Value& value) {
    if (value.type == Value::Type::list) {
        Json list = Json::array();
        for (const Value& item : value.items) list.push_back(value_of(item));
        return list;
    }
    if (value.quoted) return value.text;
    if (const auto truth = to_truth(value); truth.value) return *truth.value;
    if (const auto whole = to_whole(value); whole.value) return *whole.value;
    return to_number(value).value.value_or(0.0);
}

void add_range(Json& schema, const Check& check) {
    const auto number = [](double v) {
        return v == static_cast<double>(static_cast<std::int64_t>(v)) ? Json(static_cast<std::int64_t>(v)) : Json(v);
    };
    if (check.low != any().low) schema[check.open_low ? "exclusiveMinimum" : "minimum"] = number(check.low);
    if (check.high != any().high) schema[check.open_high ? "exclusiveMaximum" : "maximum"] = number(check.high);
}

Json numbers(int count, const Check& check) {
    Json number{{"type", "number"}};
    add_range(number, check);
    return {{"type", "array"}, {"items", number}, {"minItems", count}, {"maxItems", count}};
}

Json object_of(const std::vector<KeyInfo>& keys);

Json schema_of(const KeyInfo& key) {
    using Type = KeyInfo::Type;
    switch (key.type) {
        case Type::number:
        case Type::whole: {
            Json schema{{"type", key.type == Type::number ? "number" : "integer"}};
            add_range(schema, key.check);
            return schema;
        }
        case Type::truth:
            return {{"type", "boolean"}};
        case Type::text:
        case Type::file:
        case Type::reference:
            return {{"type", "string"}};
        case Type::word:
            return {{"enum", key.words}};
        case Type::vector2:
            return numbers(2, key.check);
        case Type::vector3:
        case Type::colour:
            return numbers(3, key.check);
        case Type::profile:
            return {{"type", "array"}, {"items", numbers(2, any())}, {"minItems", 3}};
        case Type::block:
            return object_of(key.keys);
        case Type::list:
            return {{"type", "array"}, {"items", object_of(key.keys)}};
        case Type::shape:
            return {{"$ref", "#/$defs/shape"}};
        case Type::shapes:
            return {{"type", "array"}, {"items", {{"$ref", "#/$defs/shape"}}}, {"minItems", 1}};
        case Type::named:
        case Type::named_shapes: {
            const Json entry = key.type == Type::named ? object_of(key.keys) : Json{{"$ref", "#/$defs/shape"}};
            return {{"type", {"object", "null"}},
                    {"additionalProperties", false},
                    {"patternProperties", {{kNamePattern, entry}}}};
        }
    }
    return {};
}

Json property(const KeyInfo& key) {
    Json schema = schema_of(key);
    const bool has_unit = !key.unit.empty() && key.unit != "1" && key.unit != kColour;
    schema["description"] =
        (key.check.required ? "(required) " : "") + key.meaning + (has_unit ? " [" + key.unit + "]" : "");
    const bool is_value = key.default_value.type != Value::Type::null;
    const bool is_empty =
        key.default_value.type == Value::Type::list ? key.default_value.items.empty() : key.default_value.text.empty();
    if (is_value && !key.check.required && !is_empty) schema["default"] = value_of(key.default_value);
    return schema;
}

void add_properties(const std::vector<KeyInfo>& keys, Json& object) {
    for (const KeyInfo& key : keys) object["properties"][key.name] = property(key);
}

Json object_of(const std::vector<KeyInfo>& keys) {
    // Nothing is required: a file that extends another writes only what differs, down to an empty block.
    Json object{{"type", {"object", "null"}}, {"additionalProperties", false}, {"properties", Json::object()}};
    add_properties(keys, object);
    return object;
}

Json shape_schema() {
    Json shape{{"type", "object"},
               {"additionalProperties", false},
               {"description", "one kind, and modifiers"},
               {"properties", Json::object()}};
    Json one_of = Json::array();
    for (const ShapeKindInfo& kind : describe_shape_kinds()) {
        Json schema = object_of(kind.keys);
        for (const KeyInfo& key : kind.keys)
            if (key.name == kind.short_key) schema = Json{{"anyOf", {schema_of(key), schema}}};
        schema["description"] = kind.meaning;
        shape["properties"][kind.name] = schema;
        one_of.push_back({{"required", {kind.name}}});
    }
    add_properties(describe_shape_modifiers(), shape);
    // At most one kind: none where a file that extends another changes a modifier.
    const Json kinds = one_of;
    one_of.push_back({{"not", {{"anyOf", kinds}}}});
    shape["oneOf"] = one_of;
    return shape;
}

}  // namespace

std::string scene_schema() {
    Json schema{{"$schema", "https://json-schema.org/draft/2020-12/schema"}, {"title", "Thixo scene"}};
    schema.update(object_of(describe_scene()));
    schema["properties"]["extends"] = {
        {"type", "string"}, {"description", "another scene file, relative to this one, which this one is laid over"}};
    schema["$defs"]["shape"] = shape_schema();
    return schema.dump(1) + "\n";
}

}  // namespace thixo::scene
