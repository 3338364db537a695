#include <bit>
#include <cctype>
#include <cmath>
#include <cstring>

#include "pipeline/geometry/mesh_io.h"
#include "pipeline/geometry/mesh_repair.h"
#include "pipeline/geometry/text_cursor.h"

namespace thixo {
namespace {

static_assert(std::endian::native == std::endian::little);
constexpr std::size_t kHeader = 84, kFacet = 50;

/// The corners of all triangles, one after the other.
std::vector<Vec3d> parse_binary(std::string_view bytes, std::size_t count, const std::string& name) {
    if ((bytes.size() - kHeader) / kFacet < count)
        throw InputError(
            "{}: byte {}: the file ends within triangle {} of {}; it is cut short: copy or export it again", name,
            bytes.size(), (bytes.size() - kHeader) / kFacet + 1, count);
    std::vector<Vec3d> corners;
    corners.reserve(3 * count);
    for (std::size_t k = 0; k < count; ++k) {
        float values[9];
        const std::size_t at = kHeader + k * kFacet + 12;  // behind the facet's normal
        std::memcpy(values, bytes.data() + at, sizeof values);
        for (int i = 0; i < 3; ++i) {
            const Vec3f v(values[3 * i], values[3 * i + 1], values[3 * i + 2]);
            if (!v.allFinite())
                throw InputError(
                    "{}: byte {}: a corner of triangle {} is not finite; the file is damaged: export it again", name,
                    at + 12 * i, k + 1);
            corners.push_back(v.cast<double>());
        }
    }
    return corners;
}

std::string lower_case(std::string_view word) {
    std::string out(word);
    for (char& c : out) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return out;
}

/// Texts begin with "solid" and have no zero bytes.
bool is_text(std::string_view bytes, const std::string& name) {
    if (bytes.find('\0') != std::string_view::npos) return false;
    return lower_case(TextCursor(bytes.substr(0, 200), name).word()) == "solid";
}

std::vector<Vec3d> parse_text(std::string_view bytes, const std::string& name) {
    TextCursor text(bytes, name);
    std::vector<Vec3d> corners;
    std::size_t facets = 0;
    for (std::string word; !(word = lower_case(text.word())).empty();) {
        if (word == "solid" || word == "endsolid") {
            text.next_line();  // what follows is a name, which may be any word
        } else if (word == "vertex") {
            Vec3d v;
            for (int k = 0; k < 3; ++k) v[k] = text.coordinate(text.word());
            corners.push_back(v);
        } else if (word == "endloop") {
            if (corners.size() != 3 * ++facets)
                text.fail("a facet with {} corners",
                          static_cast<std::int64_t>(corners.size()) - 3 * static_cast<std::int64_t>(facets - 1));
        }
    }
    if (corners.size() != 3 * facets) text.fail("the file ends within a facet");
    return corners;
}

}  // namespace

TriangleMesh parse_stl(std::string_view bytes, const std::string& name, Vec3d* origin) {
    std::uint32_t count = 0;
    if (bytes.size() >= kHeader) std::memcpy(&count, bytes.data() + 80, 4);
    // The count and the size tell, for binary files may begin with "solid" too. Four letters in the place of the count
    // would be more than 150 million triangles: no text is as long as those. Bytes behind the last triangle do no harm.
    const bool holds_count = bytes.size() >= kHeader && (bytes.size() - kHeader) / kFacet >= count;
    const bool text = !(holds_count && count > 0) && is_text(without_byte_order_mark(bytes, name), name);
    if (!text && bytes.size() < kHeader)
        throw InputError(
            "{}: byte {}: the file ends within its header; it is no STL file or cut short: export it again", name,
            bytes.size());
    const std::vector<Vec3d> corners =
        text ? parse_text(without_byte_order_mark(bytes, name), name) : parse_binary(bytes, count, name);
    if (corners.empty()) throw InputError("{}: no triangles; export the mesh again", name);
    TriangleMesh mesh;
    set_vertices(mesh, corners, origin);
    for (Index k = 0; k < corners.size(); k += 3) mesh.triangles.push_back({k, k + 1, k + 2});
    return welded(mesh);
}

}  // namespace thixo
