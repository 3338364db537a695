// The header of a PLY file (Turk 1994).
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace thixo {

enum class PlyFormat { text, little, big };
enum class PlyType { i8, u8, i16, u16, i32, u32, f32, f64 };

std::size_t ply_size(PlyType type);

struct PlyProperty {
    std::string name;
    PlyType type = PlyType::f32;
    bool list = false;
    PlyType count_type = PlyType::u8;  // of a list's length
};
struct PlyElement {
    std::string name;
    std::uint64_t count = 0;
    std::vector<PlyProperty> properties;
    /// Index of the property of this name, -1 where there is none.
    int find(std::string_view property) const;
};
struct PlyHeader {
    PlyFormat format = PlyFormat::text;
    std::vector<PlyElement> elements;
    std::size_t size = 0;  // bytes up to the data
    std::size_t lines = 0;
};

/// Throws InputError on anything a PLY header does not allow.
PlyHeader parse_ply_header(std::string_view bytes, const std::string& name);

}  // namespace thixo
