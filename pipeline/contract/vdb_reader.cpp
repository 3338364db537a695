#include "pipeline/contract/vdb_reader.h"

#include <blosc.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include "pipeline/contract/machine_memory.h"

namespace thixo {
namespace {

constexpr std::uint32_t kFileVersion = 224;
constexpr std::size_t kUuidLength = 36;
constexpr std::size_t kLeafCells = 512;
constexpr std::int32_t kFarthest = 1 << 23;           // voxels; vdb_points.cpp writes none beyond 8e6
constexpr std::uint16_t kPlain = 0xffff;              // a leaf's offsets are not packed
constexpr std::uint32_t kBloscAndActive = 0x4 | 0x2;  // io::COMPRESS_BLOSC | io::COMPRESS_ACTIVE_MASK
constexpr std::uint8_t kUniform = 0x2, kPaged = 0x8;  // of AttributeArray: one value for all points; stored in pages

/// Nodes between the root and the leaves, from above. Both numbers are powers of two: cells along an axis, and voxels
/// along an axis of a cell.
struct Level {
    int cells, child;
};
constexpr std::array<Level, 2> kLevels{{{5, 7}, {4, 3}}};
constexpr int kRootChild = 12;

using Voxel = Eigen::Vector3i;

/// The bytes that are left of a file.
class Bytes {
  public:
    Bytes(std::string_view bytes, const std::string& file) : left_(bytes), file_(file) {}

    void require(bool right, std::string_view what) const {
        if (!right) throw CacheError("'{}' is damaged: {}", file_, what);
    }
    std::string_view take(std::uint64_t length) {
        require(length <= left_.size(), "it ends too early");
        const std::string_view taken = left_.substr(0, length);
        left_.remove_prefix(length);
        return taken;
    }
    template <class T>
    T value() {
        T v;
        std::memcpy(&v, take(sizeof v).data(), sizeof v);
        return v;
    }
    std::string_view text() { return take(value<std::uint32_t>()); }
    bool at_end() const { return left_.empty(); }
    const std::string& file() const { return file_; }

  private:
    std::string_view left_;
    const std::string& file_;
};

template <class T>
T number_at(std::string_view bytes, std::size_t at) {
    T v;
    std::memcpy(&v, bytes.data() + at, sizeof v);
    return v;
}

/// Unpacks what Blosc has packed; `out` has room for `length` bytes. Blosc's header is 16 bytes: 4 of versions and
/// flags, then the lengths of the values, of a block and of the chunk. Blosc trusts that the chunk is so long.
void unpack(const Bytes& in, std::string_view chunk, char* out, std::size_t length) {
    constexpr std::size_t kHeader = 16, kLeast = 128;  // OpenVDB fills short arrays up
    const std::size_t packed = std::max(length, kLeast);
    in.require(chunk.size() >= kHeader && number_at<std::uint32_t>(chunk, 12) == chunk.size() &&
                   number_at<std::uint32_t>(chunk, 4) == packed,
               "a packed chunk has another length");
    std::string values(packed, '\0');
    const int unpacked = blosc_decompress_ctx(chunk.data(), values.data(), packed, 1);
    in.require(unpacked >= 0 && static_cast<std::size_t>(unpacked) == packed, "a packed chunk cannot be unpacked");
    std::memcpy(out, values.data(), length);
}

bool is_finite(float v) { return std::isfinite(v); }
bool is_finite(const Vec3f& v) { return v.allFinite(); }
bool is_finite(std::int32_t) { return true; }
bool is_finite(std::int64_t) { return true; }

std::size_t row_bytes(const Attribute& a) {
    return std::visit([](const auto& v) { return sizeof(v[0]); }, a.data);
}

/// The name that OpenVDB gives a type.
std::string_view vdb_type(const Attribute& a) {
    constexpr std::array<std::string_view, 4> names{"float", "vec3s", "int32", "int64"};
    return names[a.data.index()];
}

/// Values of one attribute that were packed together: whole leaves.
struct Page {
    std::size_t stored = 0;  // bytes in the file
    std::size_t length = 0;  // bytes of values
    bool packed = false;
};

class PointReader {
  public:
    PointReader(std::string_view bytes, const std::string& file) : in_(bytes, file), file_size_(bytes.size()) {}

    PointSet read() {
        read_header();
        read_facts();
        read_voxel_edge();
        read_tree();
        const auto passes = in_.value<std::uint16_t>();
        in_.require(passes == (corner_.empty() ? 0 : 2 * attributes() + 4), "it has another number of passes");
        if (!corner_.empty()) read_leaves();
        in_.require(points_.count == stated_count_, "it holds another number of points than it states");
        in_.require(in_.at_end(), "it is longer than its content");
        return std::move(points_);
    }

  private:
    std::size_t attributes() const { return points_.attributes.size(); }
    std::size_t leaves() const { return corner_.size(); }

    void read_header() {
        in_.take(sizeof(std::int64_t));  // the magic number, which decode_points has seen
        in_.require(in_.value<std::uint32_t>() == kFileVersion, "it has another version of OpenVDB's format");
        in_.take(2 * sizeof(std::uint32_t));  // version of the library
        in_.require(in_.value<char>() == 0, "it has offsets of grids");
        in_.take(kUuidLength);
        read_metadata([](std::string_view, std::string_view, std::string_view) {});
        in_.require(in_.value<std::int32_t>() == 1, "it does not hold one grid");
        in_.text();  // the grid's name
        in_.require(in_.text() == "Tree_ptdataidx32_5_4_3", "its grid holds no points");
        in_.require(in_.text().empty(), "its grid is another's instance");
        in_.take(3 * sizeof(std::int64_t));  // positions in the file, unused in a stream
        in_.require(in_.value<std::uint32_t>() == kBloscAndActive, "it is packed in another way");
    }

    template <class Take>
    void read_metadata(Take take) {
        for (auto left = in_.value<std::uint32_t>(); left > 0; --left) {
            const std::string_view key = in_.text(), type = in_.text();
            take(key, type, in_.text());
        }
    }

    void read_facts() {
        bool counted = false, typed = false;
        read_metadata([&](std::string_view key, std::string_view type, std::string_view value) {
            if (key == kCountKey && type == "int64" && value.size() == sizeof(std::int64_t)) {
                stated_count_ = number_at<std::uint64_t>(value, 0);
                counted = true;
            } else if (key == kTypesKey && type == "string" && !typed) {
                read_types(value);
                typed = true;
            }
        });
        in_.require(counted && typed, "it does not state its points");
    }

    /// "P:vec3f id:int64 ...": empty arrays of these names and types.
    void read_types(std::string_view text) {
        while (!text.empty()) {
            const std::size_t end = std::min(text.find(' '), text.size()), colon = text.substr(0, end).rfind(':');
            in_.require(colon != std::string_view::npos && colon > 0, "it states an attribute without a type");
            Attribute a{std::string(text.substr(0, colon)), {}};
            const std::string_view type = text.substr(colon + 1, end - colon - 1);
            if (type == "float")
                a.data = std::vector<float>();
            else if (type == "vec3f")
                a.data = std::vector<Vec3f>();
            else if (type == "int32")
                a.data = std::vector<std::int32_t>();
            else if (type == "int64")
                a.data = std::vector<std::int64_t>();
            else
                in_.require(false, "it states an attribute of unknown type");
            points_.attributes.push_back(std::move(a));
            text.remove_prefix(std::min(end + 1, text.size()));
        }
    }

    void read_voxel_edge() {
        const std::string_view map_type = in_.text();
        const bool moved = map_type == "UniformScaleTranslateMap";
        in_.require(moved || map_type == "UniformScaleMap", "its voxels are no cubes");
        if (moved)
            for (double& v : points_.origin) v = in_.value<double>();
        in_.require(points_.origin.allFinite(), "its origin is not finite");
        std::array<double, 15> map{};  // scale, voxel edges, and what follows from these
        for (double& v : map) v = in_.value<double>();
        voxel_ = map[3];
        in_.require(voxel_ > 0 && voxel_ < 1e12, "its voxel edge is no length");
    }

    void read_tree() {
        in_.require(in_.value<std::int32_t>() == 1, "it has several trees");
        in_.require(in_.value<std::uint32_t>() == 0 && in_.value<std::uint32_t>() == 0, "its tree has tiles");
        for (auto left = in_.value<std::uint32_t>(); left > 0; --left) {
            const auto x = in_.value<std::int32_t>(), y = in_.value<std::int32_t>(), z = in_.value<std::int32_t>();
            for (const std::int32_t c : {x, y, z})
                in_.require(c >= -kFarthest && c < kFarthest && c % (1 << kRootChild) == 0, "a node has no place");
            read_node(0, {x, y, z});
        }
    }

    void read_node(std::size_t level, const Voxel& corner) {
        const auto [log, child] = kLevels[level];
        const std::size_t cells = std::size_t(1) << (3 * log);
        const std::string_view children = in_.take(cells / 8), active = in_.take(cells / 8);
        in_.require(active.find_first_not_of('\0') == std::string_view::npos && in_.value<char>() == 0,
                    "a node holds values");
        const auto length = in_.value<std::int64_t>();  // of no values: nothing, or a header of Blosc's alone
        in_.require(length == 0 || length == 16, "the values of a node have another length");
        in_.take(static_cast<std::uint64_t>(length));
        for (std::size_t cell = 0; cell < cells; ++cell) {
            if (!(static_cast<unsigned char>(children[cell / 8]) >> cell % 8 & 1)) continue;
            const auto axis = [&](int shift) {
                return static_cast<std::int32_t>(cell >> shift & ((std::size_t(1) << log) - 1)) * (1 << child);
            };
            const Voxel at = corner + Voxel(axis(2 * log), axis(log), axis(0));
            if (level + 1 < kLevels.size())
                read_node(level + 1, at);
            else
                read_leaf_topology(at);
        }
    }

    void read_leaf_topology(const Voxel& corner) {
        in_.take(kLeafCells / 8);  // which voxels have points: the offsets tell it too
        corner_.push_back(corner);
    }

    /// The passes of OpenVDB over all leaves: sizes of offsets, layout, page headers, offsets, values.
    void read_leaves() {
        for (std::size_t l = 0; l < leaves(); ++l) offset_bytes_.push_back(in_.value<std::uint16_t>());
        read_descriptor();
        for (std::size_t l = 0; l < leaves(); ++l) read_layout();
        require_room();
        std::vector<std::vector<Page>> pages;
        for (std::size_t a = 0; a < attributes(); ++a) pages.push_back(read_pages(a));
        for (std::size_t l = 0; l < leaves(); ++l) read_offsets(l);
        for (std::size_t a = 0; a < attributes(); ++a)
            std::visit([&](auto& values) { read_values(a, pages[a], values); }, points_.attributes[a].data);
        to_world();
    }

    /// Types by place, then places by name. They are those that the metadata state.
    void read_descriptor() {
        in_.require(in_.value<std::uint8_t>() == 1, "its leaves have different attributes");
        in_.require(in_.value<std::uint64_t>() == attributes() && attributes() > 0 &&
                        points_.attributes[0].name == "P" &&
                        std::holds_alternative<std::vector<Vec3f>>(points_.attributes[0].data),
                    "its attributes are others than it states");
        for (const Attribute& a : points_.attributes)
            in_.require(in_.text() == vdb_type(a) && in_.text() == "null", "an attribute has another type");
        std::vector<bool> named(attributes(), false);
        for (std::size_t k = 0; k < attributes(); ++k) {
            const std::string_view name = in_.text();
            const auto at = in_.value<std::uint64_t>();
            in_.require(at < attributes() && !named[at] && points_.attributes[at].name == name,
                        "an attribute has another name");
            named[at] = true;
        }
        in_.require(in_.value<std::uint64_t>() == 0, "its points have groups");
        in_.require(in_.value<std::uint32_t>() == 0, "its attributes have default values");
    }

    /// How the attributes of one leaf are stored.
    void read_layout() {
        std::uint32_t count = 0;
        for (std::size_t a = 0; a < attributes(); ++a) {
            const auto length = in_.value<std::uint64_t>();
            in_.take(sizeof(std::uint8_t));  // how OpenVDB shows the array
            const auto stored = in_.value<std::uint8_t>();
            const auto size = in_.value<std::uint32_t>();
            if (a == 0) count = size;
            const bool uniform = (stored & kUniform) != 0;
            in_.require((stored & ~kUniform) == kPaged && size == count && size > 0, "an attribute has another layout");
            // 6: two bytes of flags and four of the size count too.
            in_.require(length == 6 + (uniform ? 1 : std::uint64_t(size)) * row_bytes(points_.attributes[a]),
                        "an attribute has another length");
            uniform_.push_back(uniform);
        }
        count_.push_back(count);
        points_.count += count;
    }

    /// Before memory is taken.
    void require_room() const {
        std::uint64_t bytes = 0;
        for (const Attribute& a : points_.attributes) bytes += points_.count * row_bytes(a);
        in_.require(
            points_.count <= std::numeric_limits<std::uint32_t>::max() && bytes <= kLargestExpansion * file_size_,
            "it holds more points than fit into its size");
        require_memory(static_cast<double>(bytes), fmt::format("reading '{}'", in_.file()),
                       "use a machine with more memory");
    }

    std::size_t bytes_of(std::size_t a, std::size_t leaf) const {
        const bool uniform = uniform_[leaf * attributes() + a];
        return (uniform ? 1 : count_[leaf]) * row_bytes(points_.attributes[a]);
    }

    Page read_page_header() {
        const std::int64_t stored = in_.value<std::int32_t>();
        in_.require(stored != 0, "a page is empty");
        const std::int64_t length = stored > 0 ? in_.value<std::int32_t>() : -stored;
        in_.require(length > 0, "a page is empty");
        return {static_cast<std::size_t>(std::abs(stored)), static_cast<std::size_t>(length), stored > 0};
    }

    std::vector<Page> read_pages(std::size_t a) {
        std::vector<Page> pages;
        std::size_t room = 0;
        for (std::size_t l = 0; l < leaves(); ++l) {
            if (room == 0) room = pages.emplace_back(read_page_header()).length;
            in_.require(bytes_of(a, l) <= room, "a page is shorter than its leaves");
            room -= bytes_of(a, l);
        }
        in_.require(room == 0, "a page is longer than its leaves");
        return pages;
    }

    /// Where in the leaf's list each voxel's points end.
    void read_offsets(std::size_t leaf) {
        in_.take(kLeafCells / 8);
        std::array<std::uint32_t, kLeafCells> ends{};
        const auto stored = in_.value<std::uint16_t>();
        in_.require(stored == offset_bytes_[leaf], "the offsets of a leaf have another length");
        if (stored == kPlain)
            std::memcpy(ends.data(), in_.take(sizeof ends).data(), sizeof ends);
        else
            unpack(in_, in_.take(stored), reinterpret_cast<char*>(ends.data()), sizeof ends);
        in_.require(std::ranges::is_sorted(ends) && ends.back() == count_[leaf], "a leaf has another number of points");
        ends_.insert(ends_.end(), ends.begin(), ends.end());
    }

    template <class T>
    void read_values(std::size_t a, const std::vector<Page>& pages, std::vector<T>& out) {
        out.reserve(points_.count);
        std::size_t leaf = 0;
        for (const Page& page : pages) {
            std::string values(page.length, '\0');
            const std::string_view stored = in_.take(page.stored);
            if (page.packed)
                unpack(in_, stored, values.data(), page.length);
            else
                std::memcpy(values.data(), stored.data(), page.length);
            for (std::size_t at = 0; at < page.length; ++leaf) {
                const std::size_t length = bytes_of(a, leaf);
                T first;
                std::memcpy(static_cast<void*>(&first), values.data() + at, sizeof first);
                out.resize(out.size() + count_[leaf], first);
                std::memcpy(static_cast<void*>(&out[out.size() - count_[leaf]]), values.data() + at, length);
                at += length;
            }
        }
        in_.require(std::ranges::all_of(out, [](const T& v) { return is_finite(v); }), "a value is not finite");
    }

    /// Positions are stored relative to the centre of their voxel, in voxels.
    void to_world() {
        auto& positions = std::get<std::vector<Vec3f>>(points_.attributes[0].data);
        std::size_t k = 0;
        for (std::size_t l = 0; l < leaves(); ++l) {
            const std::size_t first = k;
            for (std::size_t cell = 0; cell < kLeafCells; ++cell) {
                const Voxel voxel = corner_[l] + Voxel(int(cell >> 6), int(cell >> 3 & 7), int(cell & 7));
                for (const std::size_t end = first + ends_[l * kLeafCells + cell]; k < end; ++k) {
                    in_.require(positions[k].cwiseAbs().maxCoeff() <= 1, "a point lies outside its voxel");
                    positions[k] = ((voxel.cast<double>() + positions[k].cast<double>()) * voxel_).cast<float>();
                }
            }
        }
    }

    Bytes in_;
    std::size_t file_size_;
    PointSet points_;
    std::uint64_t stated_count_ = 0;
    double voxel_ = 0;  // [m]
    // Of each leaf:
    std::vector<Voxel> corner_;                // lowest voxel
    std::vector<std::uint16_t> offset_bytes_;  // length of its packed offsets
    std::vector<std::uint32_t> count_;         // points
    std::vector<std::uint32_t> ends_;          // 512 offsets
    std::vector<bool> uniform_;                // leaf by leaf: each attribute has one value there
};

}  // namespace

PointSet read_vdb_points(std::string_view bytes, const std::string& file) { return PointReader(bytes, file).read(); }

}  // namespace thixo
