#include "pipeline/contract/info.h"

#include <fmt/core.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>

#include "pipeline/base/error.h"
#include "pipeline/contract/atomic_file.h"
#include "pipeline/contract/cache.h"
#include "pipeline/contract/cache_shortfalls.h"
#include "pipeline/contract/image.h"
#include "pipeline/contract/json_fields.h"
#include "pipeline/contract/shortfall_json.h"
#include "pipeline/contract/vdb_points.h"

namespace thixo {
namespace fs = std::filesystem;
namespace {

/// Minimum, mean and maximum of component c of n values.
struct Range {
    double least = 0, mean = 0, most = 0;
};

template <class F>
Range range_of(std::size_t n, F&& value) {
    Range r;
    if (n == 0) return r;
    r.least = r.most = value(0);
    double sum = 0;
    for (std::size_t i = 0; i < n; ++i) {
        const double v = value(i);
        r.least = std::min(r.least, v);
        r.most = std::max(r.most, v);
        sum += v;
    }
    r.mean = sum / static_cast<double>(n);
    return r;
}

template <class T>
Json range_json(const char* type, const std::vector<T>& v) {
    const Range r = range_of(v.size(), [&](std::size_t i) { return static_cast<double>(v[i]); });
    return {{"type", type}, {"min", r.least}, {"mean", r.mean}, {"max", r.most}};
}
Json describe_values(const std::vector<float>& v, const Vec3d&) { return range_json("float", v); }
Json describe_values(const std::vector<std::int32_t>& v, const Vec3d&) { return range_json("int32", v); }
Json describe_values(const std::vector<std::int64_t>& v, const Vec3d&) { return range_json("int64", v); }
/// Places are told in the world: they count from `origin` [m].
Json describe_values(const std::vector<Vec3f>& v, const Vec3d& origin) {
    Json json = {{"type", "vec3f"}, {"min", Json::array()}, {"mean", Json::array()}, {"max", Json::array()}};
    for (int c = 0; c < 3; ++c) {
        const Range r = range_of(v.size(), [&](std::size_t i) { return origin[c] + static_cast<double>(v[i][c]); });
        json["min"].push_back(r.least);
        json["mean"].push_back(r.mean);
        json["max"].push_back(r.most);
    }
    return json;
}

Json attributes_json(const PointSet& points) {
    Json json = Json::object();
    for (const Attribute& a : points.attributes)
        json[a.name] = std::visit([&](const auto& v) { return describe_values(v, points.origin_of(a.name)); }, a.data);
    return json;
}

Json frame_json(const ManifestFrame& entry, const Frame& facts) {
    const FrameTotals& t = facts.totals;
    return {{"frame", entry.number},
            {"time", entry.time},
            {"particles", entry.particles},
            {"surfels", entry.surfels},
            {"bodies", facts.bodies.size()},
            {"air", t.air},
            {"virtual", t.virtual_particles},
            {"mass", t.mass},
            {"momentum", t.momentum},
            {"energy", t.kinetic_energy + t.potential_energy},
            {"volume", entry.surfels > 0 ? t.surface_volume : t.particle_volume},
            {"sha", entry.hash()}};
}

Json cache_json(const CacheReader& reader) {
    const Manifest& m = reader.manifest();
    Json json = {{"scene", m.scene}, {"format", m.format}, {"complete", m.complete}, {"frames", Json::array()}};
    for (const ManifestFrame& f : m.frames) json["frames"].push_back(frame_json(f, reader.load_facts(f.number)));
    json["shortfalls"] = shortfalls_json(shortfalls_of(reader));
    return json;
}

fs::path folder_of(const fs::path& path) { return path.has_parent_path() ? path.parent_path() : fs::path("."); }

Json frame_file_json(const fs::path& path, const FrameFileName& file) {
    const CacheReader reader(folder_of(path));
    const ManifestFrame* entry = reader.manifest().find(file.frame);
    if (!entry) throw CacheError("'{}' is not listed in the manifest of its cache", path.string());
    Json json = frame_json(*entry, reader.load_facts(file.frame));
    if (file.kind == FrameFileName::surfels) {
        json["attributes"] = attributes_json(reader.load_surfels(file.frame));
    } else {
        json["attributes"] = attributes_json(reader.load_particles(file.frame));
        if (file.kind == FrameFileName::facts)
            json["surfel_attributes"] = attributes_json(reader.load_surfels(file.frame));
    }
    return json;
}

/// A point file that stands alone: its own checksum protects it.
Json stray_points_json(const fs::path& path) {
    const PointSet points = decode_points(read_whole(path), path.string());
    return {{"points", points.count}, {"attributes", attributes_json(points)}};
}

Json picture_json(const fs::path& path) {
    const Image image = read_exr(path);
    Json json = {{"width", image.width},
                 {"height", image.height},
                 {"attributes", Json::object()},
                 {"header", Json(image.attributes)}};
    for (const ImageChannel& c : image.channels)
        json["attributes"][c.name] = range_json(c.half ? "half" : "float", c.values);
    return json;
}

Json document(const fs::path& path) {
    std::error_code ignored;
    if (fs::is_directory(path, ignored) || path.filename() == "manifest.json") return cache_json(CacheReader(path));
    if (path.extension() == ".exr") return picture_json(path);
    const std::optional<FrameFileName> file = parse_frame_file_name(path.filename().string());
    if (file && (file->kind == FrameFileName::facts || CacheReader::exists(folder_of(path))))
        return frame_file_json(path, *file);
    if (path.extension() == ".vdb") return stray_points_json(path);
    throw CacheError("'{}' is not a cache, a frame or a picture of Thixo", path.string());
}

// ---- text for a person
// ------------------------------------------------------------------------------------------------------------

std::string number_text(const Json& value) {
    if (value.is_array()) {
        std::string text = "(";
        for (const Json& v : value) text += (text.size() > 1 ? ", " : "") + number_text(v);
        return text + ")";
    }
    return value.is_number_float() ? fmt::format("{:.6g}", value.get<double>()) : value.dump();
}

std::string attributes_text(const Json& attributes) {
    std::string text;
    for (const auto& [name, a] : attributes.items())
        text += fmt::format("  {:<14} {:<6} min {}  mean {}  max {}\n", name, a["type"].get<std::string>(),
                            number_text(a["min"]), number_text(a["mean"]), number_text(a["max"]));
    return text;
}

std::string cache_text(const Json& json) {
    std::string text = fmt::format("cache of scene '{}', format {}, {} frames, {}\n", json["scene"].get<std::string>(),
                                   json["format"].get<int>(), json["frames"].size(),
                                   json["complete"].get<bool>() ? "complete" : "not complete");
    if (!json["frames"].empty())
        text += fmt::format("{:>6} {:>10} {:>10} {:>10} {:>7} {:>12} {:>12} {:>12}\n", "frame", "time [s]", "particles",
                            "surfels", "bodies", "mass [kg]", "energy [J]", "volume [m^3]");
    for (const Json& f : json["frames"])
        text += fmt::format("{:>6} {:>10.4f} {:>10} {:>10} {:>7} {:>12.6g} {:>12.6g} {:>12.6g}\n",
                            f["frame"].get<int>(), f["time"].get<double>(), f["particles"].get<std::uint64_t>(),
                            f["surfels"].get<std::uint64_t>(), f["bodies"].get<std::uint64_t>(),
                            f["mass"].get<double>(), f["energy"].get<double>(), f["volume"].get<double>());
    if (!json["shortfalls"].empty()) text += "what the run could not do:\n";
    for (const Json& s : json["shortfalls"]) text += "  " + s["text"].get<std::string>() + "\n";
    return text;
}

std::string facts_text(const Json& json) {
    std::string text;
    for (const auto& [key, value] : json.items()) {
        if (key == "attributes" || key == "surfel_attributes")
            text += key + ":\n" + attributes_text(value);
        else if (value.is_object())
            for (const auto& [name, entry] : value.items())
                text += fmt::format("{}: {}\n", name, entry.get<std::string>());
        else
            text += fmt::format("{}: {}\n", key, value.is_string() ? value.get<std::string>() : number_text(value));
    }
    return text;
}

}  // namespace

bool describes(const fs::path& path) {
    std::error_code ignored;
    return fs::is_directory(path, ignored) || path.filename() == "manifest.json" || path.extension() == ".exr" ||
           path.extension() == ".vdb" || parse_frame_file_name(path.filename().string()).has_value();
}

std::string describe(const fs::path& path, bool json) {
    const Json d = document(path);
    if (json)
        return d.dump(2, ' ', false, Json::error_handler_t::replace) +
               "\n";  // header text of a foreign picture may be anything
    return d.contains("frames") ? cache_text(d) : facts_text(d);
}

}  // namespace thixo
