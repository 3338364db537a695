// The visitor that lists the keys themselves: what docs/scene.md and the JSON Schema are made from.
#pragma once

#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "pipeline/contract/scene.h"
#include "pipeline/contract/scene_build.h"

namespace thixo::scene {

struct KeyInfo {
    enum class Type {
        number,
        whole,
        truth,
        text,
        word,
        vector2,
        vector3,
        colour,
        profile,
        reference,
        file,  // values
        block,
        named,
        list,
        shape,
        shapes,
        named_shapes  // more keys inside
    };
    std::string name;
    Type type = Type::block;
    std::string unit;
    Check check;
    std::string meaning;
    Value default_value;             // of values
    std::vector<std::string> words;  // of word
    std::vector<KeyInfo> keys;       // of block, named, list
};

KeyInfo::Type type_of(double, const char* unit);
KeyInfo::Type type_of(int, const char* unit);
KeyInfo::Type type_of(std::uint64_t, const char* unit);
KeyInfo::Type type_of(bool, const char* unit);
KeyInfo::Type type_of(const std::string&, const char* unit);
KeyInfo::Type type_of(const Vec2d&, const char* unit);
KeyInfo::Type type_of(const Vec3d&, const char* unit);
KeyInfo::Type type_of(const std::vector<Vec2d>&, const char* unit);

class Describer {
  public:
    std::vector<KeyInfo> keys;

    template <class T>
    void key(const char* name, const T& member, const char* unit, Check check, const char* meaning) {
        if constexpr (std::is_enum_v<T>)
            keys.push_back({name,
                            KeyInfo::Type::word,
                            unit,
                            check,
                            meaning,
                            to_value(member),
                            {Words<T>::list.begin(), Words<T>::list.end()},
                            {}});
        else
            keys.push_back({name, type_of(member, unit), unit, check, meaning, to_value(member), {}, {}});
    }
    void key(const char* name, const std::optional<Vec3d>&, const char* unit, Check check, const char* meaning) {
        keys.push_back({name, type_of(Vec3d(), unit), unit, check, meaning, {}, {}, {}});
    }
    void reference(const char* name, const std::string& member, Refers, Check check, const char* meaning) {
        keys.push_back({name, KeyInfo::Type::reference, "", check, meaning, to_value(member), {}, {}});
    }
    void file(const char* name, const std::string& member, Check check, const char* meaning) {
        keys.push_back({name, KeyInfo::Type::file, "", check, meaning, to_value(member), {}, {}});
    }
    template <class F>
    void group(const char* name, const char* meaning, F&& f) {
        Describer inner;
        f(inner);
        nested(name, KeyInfo::Type::block, any(), meaning, std::move(inner.keys));
    }
    template <class T>
    void block(const char* name, T& member, const char* meaning) {
        group(name, meaning, [&](Describer& d) { visit(d, member); });
    }
    template <class T>
    void named(const char* name, const std::vector<T>&, const char* meaning) {
        nested(name, KeyInfo::Type::named, any(), meaning, keys_of<T>());
    }
    template <class T>
    void list(const char* name, const std::vector<T>&, const char* meaning) {
        nested(name, KeyInfo::Type::list, any(), meaning, keys_of<T>());
    }
    void shape(const char* name, const Shape&, Check check, const char* meaning) {
        nested(name, KeyInfo::Type::shape, check, meaning, {});
    }
    void shapes(const char* name, const std::vector<Shape>&, Check check, const char* meaning) {
        nested(name, KeyInfo::Type::shapes, check, meaning, {});
    }
    void named_shapes(const char* name, const std::vector<std::pair<std::string, Shape>>&, const char* meaning) {
        nested(name, KeyInfo::Type::named_shapes, any(), meaning, {});
    }

    /// The keys of a struct, with its initialisers as defaults.
    template <class T>
    static std::vector<KeyInfo> keys_of() {
        T defaults;
        Describer inner;
        visit(inner, defaults);
        return std::move(inner.keys);
    }

  private:
    void nested(const char* name, KeyInfo::Type type, Check check, const char* meaning, std::vector<KeyInfo> inner) {
        keys.push_back({name, type, "", check, meaning, {}, {}, std::move(inner)});
    }
};

struct ShapeKindInfo {
    std::string name, short_key, meaning;
    std::vector<KeyInfo> keys;
};

std::vector<KeyInfo> describe_scene();
std::vector<ShapeKindInfo> describe_shape_kinds();
/// The keys that may stand beside a shape's kind.
std::vector<KeyInfo> describe_shape_modifiers();

}  // namespace thixo::scene
