// What a cache frame holds: points with named attributes. Names are those of docs/cache_format.md (P, v, id, pscale, N,
// ...).
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "pipeline/base/error.h"
#include "pipeline/base/math.h"

namespace thixo {

struct Attribute {
    using Data =
        std::variant<std::vector<float>, std::vector<Vec3f>, std::vector<std::int32_t>, std::vector<std::int64_t>>;
    std::string name;
    Data data;
};

/// `count` points; every attribute has `count` elements. The places P and rest count from `origin` [m], which is 0 but
/// far from the world's origin: there single precision would not hold them.
struct PointSet {
    std::size_t count = 0;
    Vec3d origin{0, 0, 0};
    std::vector<Attribute> attributes;

    const Attribute* find(std::string_view name) const {
        for (const Attribute& a : attributes)
            if (a.name == name) return &a;
        return nullptr;
    }
    /// The attribute's array; a CacheError names it where it is missing or of another type.
    template <class T>
    const std::vector<T>& get(std::string_view name) const {
        const Attribute* a = find(name);
        if (!a) throw CacheError("the cache frame has no attribute '{}'", name);
        const auto* v = std::get_if<std::vector<T>>(&a->data);
        if (!v) throw CacheError("attribute '{}' of the cache frame has an unexpected type", name);
        return *v;
    }
    /// What an attribute's values count from: `origin` of places, 0 of all others.
    Vec3d origin_of(std::string_view name) const {
        return name == "P" || name == "rest" ? origin : Vec3d(Vec3d::Zero());
    }
    template <class T>
    void add(std::string name, std::vector<T> values) {
        attributes.push_back({std::move(name), std::move(values)});
    }
};

}  // namespace thixo
