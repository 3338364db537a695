#include "pipeline/geometry/ply_header.h"

#include <utility>

#include "pipeline/geometry/text_cursor.h"

namespace thixo {
namespace {

PlyType type_of(const TextCursor& text, std::string_view word) {
    static constexpr std::pair<std::string_view, PlyType> names[] = {
        {"char", PlyType::i8},   {"int8", PlyType::i8},     {"uchar", PlyType::u8},   {"uint8", PlyType::u8},
        {"short", PlyType::i16}, {"int16", PlyType::i16},   {"ushort", PlyType::u16}, {"uint16", PlyType::u16},
        {"int", PlyType::i32},   {"int32", PlyType::i32},   {"uint", PlyType::u32},   {"uint32", PlyType::u32},
        {"float", PlyType::f32}, {"float32", PlyType::f32}, {"double", PlyType::f64}, {"float64", PlyType::f64}};
    for (const auto& [name, type] : names)
        if (name == word) return type;
    text.fail("'{}' is no PLY type", TextCursor::shown(word));
}

PlyFormat format_of(const TextCursor& text, std::string_view word) {
    if (word == "ascii") return PlyFormat::text;
    if (word == "binary_little_endian") return PlyFormat::little;
    if (word == "binary_big_endian") return PlyFormat::big;
    text.fail("'{}' is no PLY format", TextCursor::shown(word));
}

PlyProperty property_of(TextCursor& text) {
    PlyProperty p;
    std::string_view word = text.word_in_line();
    if (word == "list") {
        p.list = true;
        p.count_type = type_of(text, text.word_in_line());
        if (p.count_type == PlyType::f32 || p.count_type == PlyType::f64)
            text.fail("a list whose length is no whole number");
        word = text.word_in_line();
    }
    p.type = type_of(text, word);
    p.name = text.word_in_line();
    return p;
}

/// Whether lines end with CR alone. Behind such a header a byte of the data may look like the LF of a CR LF.
bool lone_returns(std::string_view bytes) {
    const std::size_t first = bytes.find_first_of("\r\n");
    return first != std::string_view::npos && bytes[first] == '\r' && bytes.substr(first + 1, 1) != "\n";
}

}  // namespace

std::size_t ply_size(PlyType type) {
    static constexpr std::size_t sizes[] = {1, 1, 2, 2, 4, 4, 4, 8};
    return sizes[static_cast<int>(type)];
}

int PlyElement::find(std::string_view property) const {
    for (std::size_t k = 0; k < properties.size(); ++k)
        if (properties[k].name == property) return static_cast<int>(k);
    return -1;
}

PlyHeader parse_ply_header(std::string_view bytes, const std::string& name) {
    TextCursor text(bytes, name);
    PlyHeader header;
    if (text.word_in_line() != "ply") text.fail("the first line is not 'ply'");
    bool format = false;
    while (text.next_line()) {
        const std::string_view key = text.word_in_line();
        if (key == "format") {
            header.format = format_of(text, text.word_in_line());
            format = true;
        } else if (key == "element") {
            PlyElement e;
            e.name = text.word_in_line();
            const std::int64_t count = text.integer(text.word_in_line());
            if (count < 0) text.fail("element {} counts {}", TextCursor::shown(e.name), count);
            e.count = static_cast<std::uint64_t>(count);
            header.elements.push_back(std::move(e));
        } else if (key == "property") {
            if (header.elements.empty()) text.fail("a property before the first element");
            header.elements.back().properties.push_back(property_of(text));
        } else if (key == "end_header") {
            if (!format) text.fail("no format line before end_header");
            text.next_line();
            header.size = text.position();
            if (lone_returns(bytes) && bytes[header.size - 1] == '\n') --header.size;
            header.lines = text.line();
            return header;
        } else if (!key.empty() && key != "comment" && key != "obj_info") {
            text.fail("'{}' is no PLY header key", TextCursor::shown(key));
        }
    }
    text.fail("the header has no end_header");
}

}  // namespace thixo
