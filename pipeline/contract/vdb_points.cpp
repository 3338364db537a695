#include "pipeline/contract/vdb_points.h"

#include <fmt/core.h>
#include <openvdb/io/Stream.h>
#include <openvdb/openvdb.h>
#include <openvdb/points/PointDataGrid.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <set>
#include <span>
#include <sstream>

#include "pipeline/contract/hash.h"
#include "pipeline/contract/vdb_reader.h"

namespace thixo {
namespace {

namespace vdb = openvdb;
namespace vp = openvdb::points;
using Descriptor = vp::AttributeSet::Descriptor;
using Leaf = vp::PointDataTree::LeafNodeType;

// 8 bytes magic, 4 file version, 8 library version, 1 flag; then 36 characters of UUID.
constexpr std::size_t kUuidAt = 21, kUuidLength = 36;
constexpr double kFarthest = 8e6;  // voxels from the origin: beyond, float positions are coarser than a voxel

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
                point_name(points, i), (points.origin + positions[i].cast<double>()).norm());
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
    constexpr int kSmallest = -16;  // OpenVDB takes voxels of less than 3e-15 m^3 for none
    return std::ldexp(1.0, std::max(std::ilogb(2 * spacing), kSmallest));
}

std::string encode_points(const PointSet& points, const std::string& name, double voxel_size) {
    THIXO_ASSERT(voxel_size > 0, "voxel size {}", voxel_size);
    check(points);
    vdb::initialize();
    const vp::PointDataGrid::Ptr grid = make_grid(points, voxel_size);
    grid->setName(name);
    grid->setTransform(vdb::math::Transform::createLinearTransform(voxel_size));
    // Without one the map stays a mere scale, and the bytes those of all caches before there were origins.
    const Vec3d& o = points.origin;
    if (!o.isZero()) grid->transform().postTranslate({o.x(), o.y(), o.z()});
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
    return read_vdb_points(bytes, file);
}

}  // namespace thixo
