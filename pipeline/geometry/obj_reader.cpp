#include <limits>
#include <vector>

#include "pipeline/geometry/colour_code.h"
#include "pipeline/geometry/mesh_io.h"
#include "pipeline/geometry/polygon.h"
#include "pipeline/geometry/text_cursor.h"

namespace thixo {
namespace {

constexpr std::size_t kMaxElements = std::numeric_limits<std::int32_t>::max();

/// An OBJ index counts from 1, or backwards from the last element where it is negative.
Index resolve(const TextCursor& text, std::string_view word, std::size_t count, const char* what) {
    const std::int64_t given = text.integer(word);
    const std::int64_t index = given > 0 ? given - 1 : static_cast<std::int64_t>(count) + given;
    if (given == 0 || index < 0 || index >= static_cast<std::int64_t>(count))
        text.fail("{} {} of {}", what, given, count);
    return static_cast<Index>(index);
}

class ObjReader {
  public:
    ObjReader(std::string_view bytes, const std::string& name) : text_(bytes, name) {}

    TriangleMesh read(Vec3d* origin) {
        do {
            const std::string_view key = text_.word_in_line();
            if (key == "v")
                vertex();
            else if (key == "vn")
                normals_.push_back(vector().cast<float>());
            else if (key == "vt")
                texture();
            else if (key == "f")
                face();
        } while (text_.next_line());
        if (places_.empty()) text_.fail("no vertices");
        set_vertices(mesh_, places_, origin);
        faces_.cut_into(mesh_);
        if (mesh_.colours.size() != mesh_.vertices.size()) mesh_.colours.clear();
        if (mesh_.uvs.size() != mesh_.triangles.size()) mesh_.uvs.clear();
        attach_normals();
        return std::move(mesh_);
    }

  private:
    Vec3d vector() {
        Vec3d v;
        for (int k = 0; k < 3; ++k) v[k] = text_.coordinate(text_.word_in_line());
        return v;
    }

    void texture() {
        const double u = text_.coordinate(text_.word_in_line());
        const std::string_view second = text_.word_in_line();
        const double v = second.empty() || second[0] == '#' ? 0 : text_.coordinate(second);
        textures_.push_back(Vec2d(u, v).cast<float>());
    }

    void vertex() {
        if (places_.size() >= kMaxElements) text_.fail("more than {} vertices", kMaxElements);
        places_.push_back(vector());
        double extra[4];
        int count = 0;
        for (std::string_view w; count < 4 && !(w = text_.word_in_line()).empty() && w[0] != '#';)
            extra[count++] = text_.number(w);
        if (count >= 3)
            mesh_.colours.push_back(linear_from_srgb(Vec3f(float(extra[0]), float(extra[1]), float(extra[2]))));
    }

    /// "v", "v/t", "v//n" or "v/t/n"
    void face() {
        corners_.clear();
        uvs_.clear();
        for (std::string_view w; !(w = text_.word_in_line()).empty() && w[0] != '#';) {
            const std::size_t slash = w.find('/');
            const Index v = resolve(text_, w.substr(0, slash), places_.size(), "a face names vertex");
            corners_.push_back(v);
            const std::size_t end = slash == std::string_view::npos ? slash : w.find('/', slash + 1);
            if (slash != std::string_view::npos && slash + 1 < std::min(end, w.size()))
                note_texture(text_.integer(w.substr(slash + 1, std::min(end, w.size()) - slash - 1)));
            if (end != std::string_view::npos && end + 1 < w.size())
                note_normal(v, resolve(text_, w.substr(end + 1), normals_.size(), "a face names normal"));
        }
        if (corners_.size() < 3) text_.fail("a face with {} corners", corners_.size());
        faces_.add(corners_, uvs_);
    }

    /// Some programs refer to texture coordinates that they do not write. Such a mesh has none.
    void note_texture(std::int64_t given) {
        const auto count = static_cast<std::int64_t>(textures_.size());
        const std::int64_t index = given > 0 ? given - 1 : count + given;
        if (given != 0 && index >= 0 && index < count) uvs_.push_back(textures_[static_cast<std::size_t>(index)]);
    }

    void note_normal(Index vertex, Index normal) {
        if (normal_of_.size() <= vertex) normal_of_.resize(vertex + 1, kNone);
        if (normal_of_[vertex] != kNone && normals_[normal_of_[vertex]] != normals_[normal]) one_normal_each_ = false;
        normal_of_[vertex] = normal;
    }

    /// Normals per vertex, where no vertex has two. In a point set every vertex must have one.
    void attach_normals() {
        if (mesh_.triangles.empty() && normals_.size() == mesh_.vertices.size()) {
            mesh_.normals = normals_;
        } else {
            if (!one_normal_each_ || normal_of_.size() != mesh_.vertices.size()) return;
            for (const Index n : normal_of_)
                if (n == kNone) return;
            for (const Index n : normal_of_) mesh_.normals.push_back(normals_[n]);
        }
        for (Vec3f& n : mesh_.normals) n = n.stableNormalized();
    }

    TextCursor text_;
    TriangleMesh mesh_;
    std::vector<Vec3d> places_;
    std::vector<Vec3f> normals_;
    PolygonList faces_;
    std::vector<Vec2f> textures_, uvs_;
    std::vector<Index> normal_of_, corners_;
    bool one_normal_each_ = true;
};

}  // namespace

TriangleMesh parse_obj(std::string_view bytes, const std::string& name, Vec3d* origin) {
    return ObjReader(without_byte_order_mark(bytes, name), name).read(origin);
}

}  // namespace thixo
