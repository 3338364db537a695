#include "pipeline/contract/vdb_points.h"

#include <fmt/core.h>
#include <openvdb/Exceptions.h>
#include <openvdb/io/Compression.h>
#include <openvdb/io/Stream.h>
#include <openvdb/openvdb.h>
#include <openvdb/points/PointDataGrid.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <set>
#include <span>
#include <sstream>
#include <streambuf>

#include "pipeline/contract/hash.h"

namespace thixo {
namespace {

/// A chunk of values begins with its length: above 0 of bytes by Blosc, whose header tells both lengths, else minus
/// that of plain bytes. OpenVDB reads the latter before it compares them with `bytes`, the room there is, and trusts the
/// header. Throws openvdb::IoError where a length is another; leaves the stream where it was.
void check_chunk(std::istream& in, std::size_t bytes) {
    constexpr std::size_t kHeader = 16;  // flags of 4 bytes, length of the values, of a block, of the chunk
    const auto begin = in.tellg();
    std::int64_t length = 0;
    in.read(reinterpret_cast<char*>(&length), sizeof length);
    bool right = false;
    if (length > 0) {
        std::array<char, kHeader> header{};
        in.read(header.data(), kHeader);
        std::uint32_t values = 0, chunk = 0;
        std::memcpy(&values, header.data() + 4, sizeof values);
        std::memcpy(&chunk, header.data() + 12, sizeof chunk);
        right = values == bytes && static_cast<std::int64_t>(chunk) == length && chunk <= bytes + kHeader;
    } else {
        right = length == -static_cast<std::int64_t>(bytes);
    }
    if (!right) throw openvdb::IoError("the values of a node have another length");
    in.seekg(begin);
}

}  // namespace
}  // namespace thixo

// The templates of grids call this for the values of their nodes.
namespace openvdb::OPENVDB_VERSION_NAME::io {

template <>
inline void readData<PointDataIndex32>(std::istream& in, PointDataIndex32* data, Index count, uint32_t compression,
                                       DelayedLoadMetadata*, size_t) {
    const std::size_t bytes = sizeof(PointDataIndex32) * count;
    if (data == nullptr || !(compression & COMPRESS_BLOSC) || (compression & COMPRESS_ZIP))
        throw IoError("the values of a node are stored in another way");
    thixo::check_chunk(in, bytes);
    bloscFromStream(in, reinterpret_cast<char*>(data), bytes);
}

}  // namespace openvdb::OPENVDB_VERSION_NAME::io

namespace thixo {
namespace {

namespace vdb = openvdb;
namespace vp = openvdb::points;
using Descriptor = vp::AttributeSet::Descriptor;
using Leaf = vp::PointDataTree::LeafNodeType;

// 8 bytes magic, 4 file version, 8 library version, 1 flag; then 36 characters of UUID.
constexpr std::size_t kUuidAt = 21, kUuidLength = 36;
constexpr double kFarthest = 8e6;  // voxels from the origin: beyond, float positions are coarser than a voxel
constexpr const char* kTypesKey = "thixo_attributes";
constexpr const char* kCountKey = "thixo_count";

/// How an attribute type is stored, and its name in docs/cache_format.md.
template <class T>
struct Stored;
template <>
struct Stored<float> {
    using Type = float;
    static constexpr const char* name = "float";
};
template <>
struct Stored<Vec3f> {
    using Type = vdb::Vec3f;
    static constexpr const char* name = "vec3f";
};
template <>
struct Stored<std::int32_t> {
    using Type = std::int32_t;
    static constexpr const char* name = "int32";
};
template <>
struct Stored<std::int64_t> {
    using Type = std::int64_t;
    static constexpr const char* name = "int64";
};
template <class T>
using StoredArray = vp::TypedAttributeArray<typename Stored<T>::Type>;
template <class V>
using Element = typename std::decay_t<V>::value_type;

template <class T>
T store(const T& value) {
    return value;
}
vdb::Vec3f store(const Vec3f& v) { return {v.x(), v.y(), v.z()}; }
template <class T>
T restore(const T& value) {
    return value;
}
Vec3f restore(const vdb::Vec3f& v) { return {v.x(), v.y(), v.z()}; }

bool finite(float v) { return std::isfinite(v); }
bool finite(const Vec3f& v) { return v.allFinite(); }
bool finite(std::int32_t) { return true; }
bool finite(std::int64_t) { return true; }

std::string point_name(const PointSet& points, std::size_t i) {
    const Attribute* id = points.find("id");
    const auto* ids = id ? std::get_if<std::vector<std::int64_t>>(&id->data) : nullptr;
    return ids && i < ids->size() ? fmt::format("id {}", (*ids)[i]) : fmt::format("number {}", i);
}

void check(const PointSet& points) {
    std::set<std::string_view> names;
    for (const Attribute& a : points.attributes) {
        THIXO_ASSERT(names.insert(a.name).second, "attribute '{}' is there twice", a.name);
        std::visit(
            [&](const auto& values) {
                THIXO_ASSERT(values.size() == points.count, "attribute '{}' has {} values for {} points", a.name,
                             values.size(), points.count);
                for (std::size_t i = 0; i < values.size(); ++i)
                    if (!finite(values[i]))
                        throw DivergedError("attribute {} of the point {} is not finite; use a smaller time step",
                                            a.name, point_name(points, i));
            },
            a.data);
    }
    THIXO_ASSERT(points.count == 0 || names.contains("P"), "points without the attribute P");
}

/// A point's place in the file: its leaf, its voxel in the leaf, then its place in the set.
struct Place {
    std::uint64_t leaf;
    std::uint32_t voxel;
    std::uint32_t point;
    bool operator<(const Place& o) const {
        if (leaf != o.leaf) return leaf < o.leaf;
        if (voxel != o.voxel) return voxel < o.voxel;
        return point < o.point;
    }
};

vdb::Coord voxel_of(const Vec3f& p, double voxel_size) {
    const auto round = [&](float v) { return static_cast<std::int32_t>(std::floor(double(v) / voxel_size + 0.5)); };
    return {round(p.x()), round(p.y()), round(p.z())};
}

std::vector<Place> places(const PointSet& points, const std::vector<Vec3f>& positions, double voxel_size) {
    THIXO_ASSERT(positions.size() < kNone, "{} points", positions.size());
    std::vector<Place> order(positions.size());
    for (std::size_t i = 0; i < positions.size(); ++i) {
        if (!(positions[i].cwiseAbs().maxCoeff() / voxel_size < kFarthest))
            throw DivergedError(
                "the point {} is {} m away from the origin, too far for its spacing; add a boundary that holds it",
                point_name(points, i), positions[i].norm());
        const vdb::Coord ijk = voxel_of(positions[i], voxel_size);
        const auto axis = [](std::int32_t v) { return static_cast<std::uint64_t>((v >> Leaf::LOG2DIM) + (1 << 20)); };
        order[i] = {axis(ijk.x()) << 42 | axis(ijk.y()) << 21 | axis(ijk.z()), Leaf::coordToOffset(ijk),
                    static_cast<std::uint32_t>(i)};
    }
    std::sort(order.begin(), order.end());
    return order;
}

/// Attributes as they are stored: P first, then the others in their order.
std::vector<const Attribute*> stored_attributes(const PointSet& points) {
    std::vector<const Attribute*> list;
    for (const Attribute& a : points.attributes) list.push_back(&a);
    std::stable_partition(list.begin(), list.end(), [](const Attribute* a) { return a->name == "P"; });
    return list;
}

std::string type_list(const std::vector<const Attribute*>& attributes) {
    std::string text;
    for (const Attribute* a : attributes)
        std::visit(
            [&](const auto& v) {
                text += fmt::format("{}{}:{}", text.empty() ? "" : " ", a->name, Stored<Element<decltype(v)>>::name);
            },
            a->data);
    return text;
}

Descriptor::Ptr make_descriptor(const std::vector<const Attribute*>& attributes) {
    Descriptor::Ptr d = Descriptor::create(StoredArray<Vec3f>::attributeType());
    for (std::size_t i = 1; i < attributes.size(); ++i)
        std::visit(
            [&](const auto& v) {
                d = d->duplicateAppend(attributes[i]->name, StoredArray<Element<decltype(v)>>::attributeType());
            },
            attributes[i]->data);
    return d;
}

template <class T, class F>
void fill(vp::AttributeArray& array, std::size_t count, F&& value) {
    auto& typed = StoredArray<T>::cast(array);
    typed.expand();
    for (std::size_t k = 0; k < count; ++k) typed.setUnsafe(static_cast<vdb::Index>(k), store(value(k)));
    typed.compact();  // one value where all are equal
}

void fill_leaf(Leaf& leaf, const Descriptor::Ptr& descriptor, const std::vector<const Attribute*>& attributes,
               std::span<const Place> order, double voxel_size) {
    auto* set = new vp::AttributeSet(descriptor, static_cast<vdb::Index>(order.size()));
    leaf.replaceAttributeSet(set, true);  // takes ownership
    const auto& positions = std::get<std::vector<Vec3f>>(attributes[0]->data);
    fill<Vec3f>(*set->get(0), order.size(), [&](std::size_t k) -> Vec3f {
        const Vec3f& p = positions[order[k].point];
        const vdb::Coord ijk = voxel_of(p, voxel_size);
        return (p.cast<double>() / voxel_size - Vec3d(ijk.x(), ijk.y(), ijk.z())).cast<float>();
    });
    for (std::size_t a = 1; a < attributes.size(); ++a)
        std::visit(
            [&](const auto& v) {
                fill<Element<decltype(v)>>(*set->get(a), order.size(),
                                           [&](std::size_t k) { return v[order[k].point]; });
            },
            attributes[a]->data);
    std::vector<vdb::PointDataIndex32> ends(Leaf::SIZE);
    std::size_t k = 0;
    for (vdb::Index voxel = 0; voxel < Leaf::SIZE; ++voxel) {
        while (k < order.size() && order[k].voxel == voxel) ++k;
        ends[voxel] = static_cast<std::uint32_t>(k);
    }
    leaf.setOffsets(ends);
}

vp::PointDataGrid::Ptr make_grid(const PointSet& points, double voxel_size) {
    auto tree = std::make_shared<vp::PointDataTree>();
    if (points.count == 0) return vp::PointDataGrid::create(tree);
    const std::vector<const Attribute*> attributes = stored_attributes(points);
    const auto& positions = points.get<Vec3f>("P");
    const Descriptor::Ptr descriptor = make_descriptor(attributes);
    const std::vector<Place> order = places(points, positions, voxel_size);
    for (std::size_t begin = 0; begin < order.size();) {
        std::size_t end = begin;
        while (end < order.size() && order[end].leaf == order[begin].leaf) ++end;
        Leaf* leaf = tree->touchLeaf(voxel_of(positions[order[begin].point], voxel_size));
        fill_leaf(*leaf, descriptor, attributes, std::span(order).subspan(begin, end - begin), voxel_size);
        begin = end;
    }
    return vp::PointDataGrid::create(tree);
}

std::string as_uuid(const std::string& hash) {
    return fmt::format("{}-{}-{}-{}-{}", hash.substr(0, 8), hash.substr(8, 4), hash.substr(12, 4), hash.substr(16, 4),
                       hash.substr(20, 12));
}

/// Reads from memory without a copy.
class MemoryBuffer : public std::streambuf {
  public:
    explicit MemoryBuffer(std::string_view bytes) {
        char* first = const_cast<char*>(bytes.data());  // a get area is never written to
        setg(first, first, first + bytes.size());
    }

  protected:
    pos_type seekoff(off_type offset, std::ios_base::seekdir from, std::ios_base::openmode) override {
        const off_type base = from == std::ios_base::beg   ? 0
                              : from == std::ios_base::cur ? gptr() - eback()
                                                           : egptr() - eback();
        const off_type target = base + offset;
        if (target < 0 || target > egptr() - eback()) return pos_type(off_type(-1));
        setg(eback(), eback() + target, egptr());
        return pos_type(target);
    }
    pos_type seekpos(pos_type target, std::ios_base::openmode mode) override {
        return seekoff(off_type(target), std::ios_base::beg, mode);
    }
};

/// Appends a leaf's values of one attribute.
template <class T>
void append(std::vector<T>& out, const vp::AttributeArray& array, std::size_t count) {
    if (!array.isType<StoredArray<T>>() || array.size() != count)
        throw std::runtime_error("an attribute has another type or length");
    const auto& typed = StoredArray<T>::cast(array);
    typed.loadData();
    for (std::size_t k = 0; k < count; ++k) out.push_back(restore(typed.getUnsafe(static_cast<vdb::Index>(k))));
}

/// Voxel-relative to world, for the points of one leaf that were appended last.
void to_world(std::vector<Vec3f>& positions, std::size_t first, const Leaf& leaf, double voxel_size) {
    std::size_t k = first;
    for (vdb::Index voxel = 0; voxel < Leaf::SIZE; ++voxel) {
        const vdb::Coord ijk = leaf.offsetToGlobalCoord(voxel);
        const Vec3d corner(ijk.x(), ijk.y(), ijk.z());
        for (const std::size_t end = first + leaf.getValue(voxel); k < end; ++k)
            positions[k] = ((corner + positions[k].cast<double>()) * voxel_size).cast<float>();
    }
}

/// Empty arrays of the names and types the file states; these are known even where there is no point.
std::vector<Attribute> parse_type_list(const std::string& text) {
    std::vector<Attribute> list;
    std::istringstream words(text);
    for (std::string word; words >> word;) {
        const std::size_t colon = word.rfind(':');
        const std::string type = colon == std::string::npos ? "" : word.substr(colon + 1);
        Attribute a{word.substr(0, colon), {}};
        if (type == Stored<float>::name)
            a.data = std::vector<float>();
        else if (type == Stored<Vec3f>::name)
            a.data = std::vector<Vec3f>();
        else if (type == Stored<std::int32_t>::name)
            a.data = std::vector<std::int32_t>();
        else if (type == Stored<std::int64_t>::name)
            a.data = std::vector<std::int64_t>();
        else
            throw std::runtime_error("an attribute of unknown type");
        list.push_back(std::move(a));
    }
    return list;
}

PointSet read_grid(const vp::PointDataGrid& grid) {
    const auto count = static_cast<std::size_t>(grid.metaValue<std::int64_t>(kCountKey));
    const double voxel_size = grid.voxelSize()[0];
    PointSet points;
    points.attributes = parse_type_list(grid.metaValue<std::string>(kTypesKey));
    if (count > 0 && (points.attributes.empty() || points.attributes[0].name != "P"))
        throw std::runtime_error("points without positions");
    std::size_t found = 0;
    for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf) found += leaf->getLastValue();
    if (found != count) throw std::runtime_error("another number of points than stated");
    for (Attribute& a : points.attributes) std::visit([&](auto& v) { v.reserve(count); }, a.data);
    for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf) {
        leaf->validateOffsets();
        const std::size_t in_leaf = leaf->getLastValue();
        for (Attribute& a : points.attributes)
            std::visit([&](auto& v) { append(v, leaf->constAttributeArray(a.name), in_leaf); }, a.data);
        to_world(std::get<std::vector<Vec3f>>(points.attributes[0].data), points.count, *leaf, voxel_size);
        points.count += in_leaf;
    }
    return points;
}

bool is_vdb(std::string_view bytes) {
    const vdb::Int64 magic = vdb::OPENVDB_MAGIC;
    return bytes.size() >= kUuidAt + kUuidLength && std::memcmp(bytes.data(), &magic, 4) == 0;
}

void verify(std::string_view bytes, const std::string& file) {
    if (!is_vdb(bytes)) throw CacheError("'{}' is damaged: it is not a .vdb file", file);
    if (!is_own_points(bytes))
        throw CacheError("'{}' is damaged or was not written by Thixo: its own checksum does not match", file);
}

}  // namespace

double voxel_size_for(double spacing) {
    THIXO_ASSERT(spacing > 0 && std::isfinite(spacing), "spacing {}", spacing);
    return std::ldexp(1.0, std::ilogb(2 * spacing));
}

std::string encode_points(const PointSet& points, const std::string& name, double voxel_size) {
    THIXO_ASSERT(voxel_size > 0, "voxel size {}", voxel_size);
    check(points);
    vdb::initialize();
    const vp::PointDataGrid::Ptr grid = make_grid(points, voxel_size);
    grid->setName(name);
    grid->setTransform(vdb::math::Transform::createLinearTransform(voxel_size));
    grid->insertMeta(kTypesKey, vdb::StringMetadata(type_list(stored_attributes(points))));
    grid->insertMeta(kCountKey, vdb::Int64Metadata(static_cast<std::int64_t>(points.count)));
    std::ostringstream out(std::ios::binary);
    out.exceptions(std::ios::badbit | std::ios::failbit);
    vdb::io::Stream(out).write(vdb::GridCPtrVec{grid});
    std::string bytes = std::move(out).str();
    const std::string uuid = as_uuid(hash_hex_without(bytes, kUuidAt, kUuidLength));
    bytes.replace(kUuidAt, kUuidLength, uuid);
    return bytes;
}

bool is_own_points(std::string_view bytes) {
    return is_vdb(bytes) &&
           bytes.substr(kUuidAt, kUuidLength) == as_uuid(hash_hex_without(bytes, kUuidAt, kUuidLength));
}

PointSet decode_points(std::string_view bytes, const std::string& file) {
    verify(bytes, file);
    vdb::initialize();
    try {
        MemoryBuffer buffer(bytes);
        std::istream in(&buffer);
        in.exceptions(std::ios::badbit | std::ios::failbit | std::ios::eofbit);
        vdb::io::Stream stream(in, false);
        const vdb::GridPtrVecPtr grids = stream.getGrids();
        const auto grid = grids && grids->size() == 1 ? vdb::gridPtrCast<vp::PointDataGrid>(grids->front()) : nullptr;
        if (!grid) throw std::runtime_error("not one point grid");
        return read_grid(*grid);
    } catch (const std::exception& e) {  // OpenVDB throws its own types, bad_alloc and ios failures on damage
        throw CacheError("'{}' is damaged: {}", file, e.what());
    }
}

}  // namespace thixo
