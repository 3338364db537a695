// The visitor that turns the scene's structs into a tree: the way back from BlockReader.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "pipeline/contract/scene.h"
#include "pipeline/contract/scene_value.h"

namespace thixo::scene {

Value to_value(double number);
Value to_value(int number);
Value to_value(std::uint64_t number);
Value to_value(bool truth);
Value to_value(const std::string& text);
Value to_value(const Vec2d& v);
Value to_value(const Vec3d& v);
Value to_value(const std::vector<Vec2d>& points);
Value to_value(const Shape& shape);
template <class E>
requires std::is_enum_v<E> Value to_value(E word) {
    return to_value(std::string(Words<E>::list[static_cast<std::size_t>(word)]));
}
template <class T>
requires std::is_class_v<T> Value to_block(const T& block);

class Builder {
  public:
    Builder() { map.type = Value::Type::map; }
    Value map;

    template <class T>
    void key(const char* name, const T& member, const char*, Check, const char*) {
        put(name, to_value(member));
    }
    /// What is left out stays so.
    void key(const char* name, const std::optional<Vec3d>& member, const char*, Check, const char*) {
        if (member) put(name, to_value(*member));
    }
    void reference(const char* name, const std::string& member, Refers, Check, const char*) {
        put(name, to_value(member));
    }
    void file(const char* name, const std::string& member, Check, const char*) { put(name, to_value(member)); }
    template <class F>
    void group(const char* name, const char*, F&& f) {
        Builder inner;
        f(inner);
        put(name, std::move(inner.map));
    }
    template <class T>
    void block(const char* name, const T& member, const char*) {
        put(name, to_block(member));
    }
    template <class T>
    void named(const char* name, const std::vector<T>& member, const char*) {
        Builder inner;
        for (const T& entry : member) inner.put(entry.name, to_block(entry));
        put(name, std::move(inner.map));
    }
    template <class T>
    void list(const char* name, const std::vector<T>& member, const char*) {
        Value items;
        items.type = Value::Type::list;
        for (const T& entry : member) items.items.push_back(to_block(entry));
        put(name, std::move(items));
    }
    void shape(const char* name, const Shape& member, Check, const char*) {
        if (!std::holds_alternative<std::monostate>(member.kind)) put(name, to_value(member));
    }
    void shapes(const char* name, const std::vector<Shape>& member, Check, const char*);
    void named_shapes(const char* name, const std::vector<std::pair<std::string, Shape>>& member, const char*);
    void put(std::string_view name, Value value);
};

/// The block with every key. (visit takes what it visits as mutable; this visitor only reads.)
template <class T>
requires std::is_class_v<T> Value to_block(const T& block) {
    Builder builder;
    visit(builder, const_cast<T&>(block));
    return std::move(builder.map);
}

}  // namespace thixo::scene
