#include "pipeline/contract/scene_describe.h"

#include <string_view>

namespace thixo::scene {

KeyInfo::Type type_of(double, const char*) { return KeyInfo::Type::number; }
KeyInfo::Type type_of(int, const char*) { return KeyInfo::Type::whole; }
KeyInfo::Type type_of(std::uint64_t, const char*) { return KeyInfo::Type::whole; }
KeyInfo::Type type_of(bool, const char*) { return KeyInfo::Type::truth; }
KeyInfo::Type type_of(const std::string&, const char*) { return KeyInfo::Type::text; }
KeyInfo::Type type_of(const Vec2d&, const char*) { return KeyInfo::Type::vector2; }
KeyInfo::Type type_of(const Vec3d&, const char* unit) {
    return unit == std::string_view(kColour) ? KeyInfo::Type::colour : KeyInfo::Type::vector3;
}
KeyInfo::Type type_of(const std::vector<Vec2d>&, const char*) { return KeyInfo::Type::profile; }

std::vector<KeyInfo> describe_scene() { return Describer::keys_of<Scene>(); }
std::vector<KeyInfo> describe_shape_modifiers() { return Describer::keys_of<Shape>(); }

std::vector<ShapeKindInfo> describe_shape_kinds() {
    std::vector<ShapeKindInfo> kinds;
    for_each_shape_kind([&]<class K>(const ShapeKind<K>& kind) {
        kinds.push_back(
            {std::string(kind.name), std::string(kind.short_key), std::string(kind.meaning), Describer::keys_of<K>()});
    });
    return kinds;
}

}  // namespace thixo::scene
