#include "pipeline/contract/scene_build.h"

#include <fmt/format.h>

namespace thixo::scene {
namespace {

Value scalar(std::string text) {
    Value value;
    value.type = Value::Type::scalar;
    value.text = std::move(text);
    return value;
}

template <class V>
Value list_of(const V& numbers) {
    Value value;
    value.type = Value::Type::list;
    for (const double number : numbers) value.items.push_back(to_value(number));
    return value;
}

}  // namespace

// The shortest text that reads back to the same number.
Value to_value(double number) { return scalar(fmt::format("{}", number)); }
Value to_value(int number) { return scalar(fmt::format("{}", number)); }
Value to_value(std::uint64_t number) { return scalar(fmt::format("{}", number)); }
Value to_value(bool truth) { return scalar(truth ? "true" : "false"); }
Value to_value(const std::string& text) {
    Value value = scalar(text);
    value.quoted = true;
    return value;
}
Value to_value(const Vec2d& v) { return list_of(v); }
Value to_value(const Vec3d& v) { return list_of(v); }
Value to_value(const std::vector<Vec2d>& points) {
    Value value;
    value.type = Value::Type::list;
    for (const Vec2d& p : points) value.items.push_back(to_value(p));
    return value;
}

Value to_value(const Shape& shape) {
    Builder builder;
    for_each_shape_kind([&]<class K>(const ShapeKind<K>& kind) {
        if (const K* k = std::get_if<K>(&shape.kind)) builder.put(kind.name, to_block(*k));
    });
    visit(builder, const_cast<Shape&>(shape));
    return std::move(builder.map);
}

void Builder::shapes(const char* name, const std::vector<Shape>& member, Check, const char*) {
    Value items;
    items.type = Value::Type::list;
    for (const Shape& shape : member) items.items.push_back(to_value(shape));
    put(name, std::move(items));
}

void Builder::named_shapes(const char* name, const std::vector<std::pair<std::string, Shape>>& member, const char*) {
    Builder inner;
    for (const auto& [label, s] : member) inner.put(label, to_value(s));
    put(name, std::move(inner.map));
}

void Builder::put(std::string_view name, Value value) {
    map.labels.push_back({std::string(name), {}});
    map.items.push_back(std::move(value));
}

}  // namespace thixo::scene
