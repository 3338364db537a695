#include <bit>
#include <cmath>
#include <cstring>

#include "pipeline/geometry/mesh_io.h"
#include "pipeline/geometry/mesh_repair.h"
#include "pipeline/geometry/text_cursor.h"

namespace thixo {
namespace {

static_assert(std::endian::native == std::endian::little);
constexpr std::size_t kHeader = 84, kFacet = 50;

void add_triangle(TriangleMesh& mesh) {
    const Index last = static_cast<Index>(mesh.vertices.size());
    mesh.triangles.push_back({last - 3, last - 2, last - 1});
}

TriangleMesh parse_binary(std::string_view bytes, std::size_t count, const std::string& name) {
    if ((bytes.size() - kHeader) / kFacet < count)
        throw InputError(
            "{}: byte {}: the file ends within triangle {} of {}; it is cut short: copy or export it again", name,
            bytes.size(), (bytes.size() - kHeader) / kFacet + 1, count);
    TriangleMesh mesh;
    mesh.vertices.reserve(3 * count);
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
            mesh.vertices.push_back(v);
        }
        add_triangle(mesh);
    }
    return mesh;
}

TriangleMesh parse_text(std::string_view bytes, const std::string& name) {
    TextCursor text(bytes, name);
    TriangleMesh mesh;
    int corners = 0;
    for (std::string_view word; !(word = text.word()).empty();) {
        if (word == "vertex") {
            Vec3f v;
            for (int k = 0; k < 3; ++k) v[k] = text.coordinate(text.word());
            mesh.vertices.push_back(v);
            ++corners;
        } else if (word == "endloop") {
            if (corners != 3) text.fail("a facet with {} corners", corners);
            add_triangle(mesh);
            corners = 0;
        }
    }
    if (corners != 0) text.fail("the file ends within a facet");
    return mesh;
}

}  // namespace

TriangleMesh parse_stl(std::string_view bytes, const std::string& name) {
    std::uint32_t count = 0;
    if (bytes.size() >= kHeader) std::memcpy(&count, bytes.data() + 80, 4);
    // Binary files may begin with "solid" too. Their size shows that they are binary.
    const bool binary_size = bytes.size() >= kHeader && bytes.size() - kHeader == count * std::uint64_t(kFacet);
    const bool text = !binary_size && bytes.substr(0, 5) == "solid";
    if (!text && bytes.size() < kHeader)
        throw InputError(
            "{}: byte {}: the file ends within its header; it is no STL file or cut short: export it again", name,
            bytes.size());
    const TriangleMesh corners = text ? parse_text(bytes, name) : parse_binary(bytes, count, name);
    if (corners.triangles.empty()) throw InputError("{}: no triangles; export the mesh again", name);
    return welded(corners);
}

}  // namespace thixo
