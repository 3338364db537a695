#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "pipeline/geometry/colour_code.h"
#include "pipeline/geometry/mesh_io.h"
#include "pipeline/geometry/ply_header.h"
#include "pipeline/geometry/polygon.h"
#include "pipeline/geometry/text_cursor.h"

namespace thixo {
namespace {

static_assert(std::endian::native == std::endian::little);

/// Numbers from the words of a text body.
class TextSource {
  public:
    TextSource(std::string_view body, const std::string& name, std::size_t line) : text_(body, name, line) {}
    double number(PlyType) { return text_.number(text_.word()); }
    static std::size_t smallest(PlyType) { return 2; }  // a digit and a blank
    std::size_t left() const { return text_.left() + 1; }
    std::string place() const { return fmt::format("line {}", text_.line()); }

  private:
    TextCursor text_;
};

/// Numbers from the bytes of a binary body.
class BinarySource {
  public:
    BinarySource(std::string_view bytes, std::size_t begin, bool swap, const std::string& name)
        : bytes_(bytes), at_(begin), swap_(swap), name_(name) {}
    double number(PlyType type) {
        switch (type) {
            case PlyType::i8:
                return get<std::int8_t>();
            case PlyType::u8:
                return get<std::uint8_t>();
            case PlyType::i16:
                return get<std::int16_t>();
            case PlyType::u16:
                return get<std::uint16_t>();
            case PlyType::i32:
                return get<std::int32_t>();
            case PlyType::u32:
                return get<std::uint32_t>();
            case PlyType::f32:
                return get<float>();
            case PlyType::f64:
                return get<double>();
        }
        return 0;
    }
    static std::size_t smallest(PlyType type) { return ply_size(type); }
    std::size_t left() const { return bytes_.size() - at_; }
    std::string place() const { return fmt::format("byte {}", at_); }

  private:
    template <class T>
    double get() {
        if (left() < sizeof(T))
            throw InputError("{}: byte {}: the file ends too early; it is cut short: copy or export it again", name_,
                             at_);
        char raw[sizeof(T)];
        for (std::size_t k = 0; k < sizeof(T); ++k) raw[k] = bytes_[at_ + (swap_ ? sizeof(T) - 1 - k : k)];
        at_ += sizeof(T);
        T value;
        std::memcpy(&value, raw, sizeof(T));
        return static_cast<double>(value);
    }
    std::string_view bytes_;
    std::size_t at_;
    bool swap_;
    const std::string& name_;
};

double full_scale(PlyType type) { return type == PlyType::u8 ? 255 : type == PlyType::u16 ? 65535 : 1; }

template <class Source>
class PlyReader {
  public:
    PlyReader(const PlyHeader& header, Source source, const std::string& name)
        : header_(header), source_(std::move(source)), name_(name) {}

    TriangleMesh read(Vec3d* origin) {
        const PlyElement* vertices = nullptr;
        for (const PlyElement& e : header_.elements)
            if (e.name == "vertex") vertices = &e;
        if (!vertices || vertices->count == 0) fail("no vertices");
        vertex_count_ = vertices->count;
        for (const PlyElement& e : header_.elements) read_element(e);
        set_vertices(mesh_, places_, origin);
        faces_.cut_into(mesh_);
        for (const auto& t : mesh_.triangles)
            for (const Index v : t)
                if (v >= mesh_.vertices.size()) fail("a face names vertex {} of {}", v, mesh_.vertices.size());
        if (mesh_.uvs.empty() && vertex_uvs_.size() == mesh_.vertices.size())
            for (const auto& [a, b, c] : mesh_.triangles)
                mesh_.uvs.push_back({vertex_uvs_[a], vertex_uvs_[b], vertex_uvs_[c]});
        if (mesh_.uvs.size() != mesh_.triangles.size()) mesh_.uvs.clear();
        return std::move(mesh_);
    }

  private:
    template <class... A>
    [[noreturn]] void fail(fmt::format_string<A...> f, A&&... a) const {
        throw InputError("{}: {}: {}; the file is damaged or of another kind: export it again", name_, source_.place(),
                         fmt::format(f, std::forward<A>(a)...));
    }

    void read_element(const PlyElement& e) {
        std::size_t smallest = 0;
        for (const PlyProperty& p : e.properties) smallest += Source::smallest(p.list ? p.count_type : p.type);
        if (smallest == 0) {
            if (e.name == "vertex") fail("vertices without properties");
            return;
        }
        // This comes before any allocation: a damaged count must not exhaust the memory.
        if (e.count > source_.left() / smallest || e.count > std::size_t(std::numeric_limits<std::int32_t>::max()))
            fail("{} elements '{}' do not fit in the {} bytes left", e.count, TextCursor::shown(e.name),
                 source_.left());
        if (e.name == "vertex") return read_vertices(e);
        const int list = std::max(e.find("vertex_indices"), e.find("vertex_index"));
        const bool strips = e.name == "tristrips", faces = e.name == "face";
        if ((strips || faces) && list < 0) fail("element '{}' has no list vertex_indices", TextCursor::shown(e.name));
        for (std::uint64_t k = 0; k < e.count; ++k) {
            read_row(e, strips || faces ? list : -1, faces ? e.find("texcoord") : -1);
            if (faces) note_face();
            if (strips) add_strip();
        }
    }

    /// Reads one element's values: scalars into row_, the list `wanted` into list_, the list `texture` into texture_.
    void read_row(const PlyElement& e, int wanted, int texture = -1) {
        row_.clear();
        texture_.clear();
        for (int k = 0; k < static_cast<int>(e.properties.size()); ++k) {
            const PlyProperty& p = e.properties[k];
            if (!p.list) {
                row_.push_back(source_.number(p.type));
                continue;
            }
            row_.push_back(0);
            const double count = source_.number(p.count_type);
            if (!(count >= 0) || count != std::floor(count) ||
                count > double(source_.left() / Source::smallest(p.type)))
                fail("a list of {} values in the {} bytes left", count, source_.left());
            if (k == wanted) list_.clear();
            for (std::size_t i = 0; i < std::size_t(count); ++i) {
                const double value = source_.number(p.type);
                if (k == wanted) list_.push_back(value);
                if (k == texture) texture_.push_back(value);
            }
        }
    }

    void read_vertices(const PlyElement& e) {
        if (!places_.empty()) fail("two elements named vertex");
        const int x[3] = {e.find("x"), e.find("y"), e.find("z")}, n[3] = {e.find("nx"), e.find("ny"), e.find("nz")},
                  c[3] = {e.find("red"), e.find("green"), e.find("blue")};
        if (x[0] < 0 || x[1] < 0 || x[2] < 0) fail("vertices without x, y and z");
        int uv[2] = {-1, -1};
        for (const auto& [u, v] :
             {std::pair("s", "t"), {"u", "v"}, {"texture_u", "texture_v"}, {"texture_s", "texture_t"}})
            if (e.find(u) >= 0 && e.find(v) >= 0) uv[0] = e.find(u), uv[1] = e.find(v);
        const bool normals = n[0] >= 0 && n[1] >= 0 && n[2] >= 0, colours = c[0] >= 0 && c[1] >= 0 && c[2] >= 0;
        places_.reserve(e.count);
        for (std::uint64_t k = 0; k < e.count; ++k) {
            read_row(e, -1);
            const auto vector = [&](const int* at) { return Vec3d(row_[at[0]], row_[at[1]], row_[at[2]]); };
            const Vec3d p = vector(x);
            if (!(p.cwiseAbs().maxCoeff() < 1e30) || !p.allFinite())
                fail("vertex {} is at ({}, {}, {})", k, p.x(), p.y(), p.z());
            places_.push_back(p);
            if (normals) {
                const Vec3d normal = vector(n).stableNormalized();
                if (!normal.allFinite()) fail("the normal of vertex {} is not finite", k);
                mesh_.normals.push_back(normal.cast<float>());
            }
            if (uv[0] >= 0) vertex_uvs_.push_back(texture_place(row_[uv[0]], row_[uv[1]]));
            if (colours) {
                const Vec3d colour = vector(c) / full_scale(e.properties[c[0]].type);
                mesh_.colours.push_back(
                    linear_from_srgb(Vec3f(float(colour.x()), float(colour.y()), float(colour.z()))));
            }
        }
    }

    Vec2f texture_place(double u, double v) const {
        if (!(std::abs(u) < 1e6) || !(std::abs(v) < 1e6)) fail("a texture coordinate is ({}, {})", u, v);
        return {float(u), float(v)};
    }

    Index vertex(double value) const {
        if (!(value >= 0 && value < double(vertex_count_)) || value != std::floor(value))
            fail("a face names vertex {} of {}", value, vertex_count_);
        return static_cast<Index>(value);
    }

    /// Polygons are cut when all is read: faces may stand before the vertices.
    void note_face() {
        corners_.clear();
        uvs_.clear();
        for (const double v : list_) corners_.push_back(vertex(v));
        for (std::size_t k = 0; 2 * k + 1 < texture_.size(); ++k)
            uvs_.push_back(texture_place(texture_[2 * k], texture_[2 * k + 1]));
        faces_.add(corners_, uvs_);
    }

    /// The triangles of a strip; -1 starts a new one. Every other triangle is reversed. Triangles with a repeated
    /// corner only lead the strip to another place and are left out.
    void add_strip() {
        std::size_t length = 0;
        Index a = 0, b = 0;
        for (const double value : list_) {
            if (value == -1) {
                length = 0;
                continue;
            }
            const Index c = vertex(value);
            if (length >= 2 && a != b && b != c && c != a)
                length % 2 == 0 ? mesh_.triangles.push_back({a, b, c}) : mesh_.triangles.push_back({b, a, c});
            a = b, b = c, ++length;
        }
    }

    const PlyHeader& header_;
    Source source_;
    const std::string& name_;
    TriangleMesh mesh_;
    std::uint64_t vertex_count_ = 0;
    std::vector<double> row_, list_, texture_;
    std::vector<Vec3d> places_;
    std::vector<Vec2f> vertex_uvs_, uvs_;
    std::vector<Index> corners_;
    PolygonList faces_;
};

}  // namespace

TriangleMesh parse_ply(std::string_view given, const std::string& name, Vec3d* origin) {
    const std::string_view bytes = without_byte_order_mark(given, name);
    const PlyHeader header = parse_ply_header(bytes, name);
    if (header.format == PlyFormat::text)
        return PlyReader(header, TextSource(bytes.substr(header.size), name, header.lines), name).read(origin);
    return PlyReader(header, BinarySource(bytes, header.size, header.format == PlyFormat::big, name), name)
        .read(origin);
}

}  // namespace thixo
