#include "pipeline/contract/manifest.h"

#include <fmt/core.h>

#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>

#include "pipeline/base/error.h"
#include "pipeline/contract/hash.h"
#include "pipeline/contract/json_fields.h"
#include "pipeline/contract/scene_reader.h"

namespace thixo {
namespace {

constexpr std::string_view kHead = "{\n  \"checksum\": \"";  // what every manifest starts with; the digits follow
constexpr std::size_t kDigits = 32;

bool is_hash(std::string_view text) {
    return text.size() == kDigits && text.find_first_not_of("0123456789abcdef") == std::string_view::npos;
}

Json file_json(const CacheFile& f) { return {{"name", f.name}, {"size", f.size}, {"hash", f.hash}}; }

Json frame_json(const ManifestFrame& f) {
    return {{"frame", f.number},
            {"time", f.time},
            {"particles", f.particles},
            {"surfels", f.surfels},
            {"files", {file_json(f.particle_file), file_json(f.surfel_file), file_json(f.facts_file)}}};
}

CacheFile parse_file(const Json& json, const JsonPlace& place) {
    object_or_fail(json, place);
    CacheFile f;
    f.name = text_at(json, "name", place);
    f.size = static_cast<std::uint64_t>(integer_at(json, "size", 0, INT64_MAX, place));
    f.hash = text_at(json, "hash", place);
    if (!is_hash(f.hash))
        throw CacheError("'{}' is damaged: \"{}\" is not a checksum", place.file, place.in("hash").path);
    return f;
}

/// A file of a frame has exactly one possible name, so no manifest can lead out of its folder.
CacheFile parse_named_file(const Json& json, const std::string& name, const JsonPlace& place) {
    CacheFile f = parse_file(json, place);
    if (f.name != name)
        throw CacheError("'{}' is damaged: \"{}\" is not \"{}\"", place.file, place.in("name").path, name);
    return f;
}

ManifestFrame parse_frame(const Json& json, const JsonPlace& place) {
    object_or_fail(json, place);
    ManifestFrame f;
    f.number = static_cast<int>(integer_at(json, "frame", 0, kLargestFrameNumber, place));
    f.time = number_at(json, "time", place);
    f.particles = static_cast<std::uint64_t>(integer_at(json, "particles", 0, INT64_MAX, place));
    f.surfels = static_cast<std::uint64_t>(integer_at(json, "surfels", 0, INT64_MAX, place));
    const Json& files = array_at(json, "files", place);
    if (files.size() != 3)
        throw CacheError("'{}' is damaged: \"{}\" does not list three files", place.file, place.in("files").path);
    f.particle_file = parse_named_file(files[0], particle_file_name(f.number), place.in("files"));
    f.surfel_file = parse_named_file(files[1], surfel_file_name(f.number), place.in("files"));
    f.facts_file = parse_named_file(files[2], facts_file_name(f.number), place.in("files"));
    return f;
}

bool is_asset(const CacheFile& f, int format) {
    return std::any_of(kAssetExtensions.begin(), kAssetExtensions.begin() + asset_kinds(format),
                       [&](std::string_view extension) { return f.name == asset_file_name(f.hash, extension); });
}

void parse_lists(const Json& json, const JsonPlace& place, Manifest& m) {
    for (const Json& j : array_at(json, "assets", place)) {
        CacheFile f = parse_file(j, place.in("assets"));
        if (!is_asset(f, m.format))
            throw CacheError("'{}' is damaged: \"assets\" lists '{}' under another hash", place.file, f.name);
        if (!m.assets.empty() && m.assets.back().name >= f.name)
            throw CacheError("'{}' is damaged: \"assets\" is not in ascending order at '{}'", place.file, f.name);
        m.assets.push_back(std::move(f));
    }
    for (const Json& j : array_at(json, "frames", place)) {
        ManifestFrame f = parse_frame(j, place.in("frames"));
        if (!m.frames.empty() && m.frames.back().number >= f.number)
            throw CacheError("'{}' is damaged: frame {} follows frame {}", place.file, f.number,
                             m.frames.back().number);
        m.frames.push_back(std::move(f));
    }
}

/// Throws CacheError where the manifest has a newer format. The number is looked for in the text, before any parsing. A
/// newer format may keep its checksum in another way, and text whose checksum does not match is never parsed. Every
/// manifest has the number near its start.
void refuse_newer_format(std::string_view text, const std::string& file) {
    constexpr std::size_t kStart = 1024;
    constexpr std::string_view key = "\"format\":";
    std::string_view rest = text.substr(0, kStart);
    const std::size_t at = rest.find(key);
    if (at == rest.npos) return;
    rest.remove_prefix(at + key.size());
    rest.remove_prefix(std::min(rest.find_first_not_of(" \n"), rest.size()));
    std::uint64_t format = 0;
    const auto [end, failure] = std::from_chars(rest.data(), rest.data() + rest.size(), format);
    if (failure == std::errc() && format > static_cast<std::uint64_t>(kCacheFormat))
        throw CacheError("'{}' has cache format {}, this program reads 1 to {}; use a newer thixo", file, format,
                         kCacheFormat);
}

bool checksum_matches(std::string_view text) {
    if (!text.starts_with(kHead) || text.size() < kHead.size() + kDigits) return false;
    return text.substr(kHead.size(), kDigits) == hash_hex_without(text, kHead.size(), kDigits);
}

}  // namespace

std::string ManifestFrame::hash() const { return hash_hex(particle_file.hash + surfel_file.hash + facts_file.hash); }

const ManifestFrame* Manifest::find(int number) const {
    const auto it = std::lower_bound(frames.begin(), frames.end(), number,
                                     [](const ManifestFrame& f, int n) { return f.number < n; });
    return it != frames.end() && it->number == number ? &*it : nullptr;
}

std::uint64_t Manifest::bytes() const {
    std::uint64_t sum = 0;
    for (const CacheFile& a : assets) sum += a.size;
    for (const ManifestFrame& f : frames) sum += f.particle_file.size + f.surfel_file.size + f.facts_file.size;
    return sum;
}

bool Manifest::lists(std::string_view name) const {
    const auto named = [&](const CacheFile& f) { return f.name == name; };
    if (std::any_of(assets.begin(), assets.end(), named)) return true;
    const std::optional<FrameFileName> parsed = parse_frame_file_name(name);
    return parsed && find(parsed->frame) != nullptr;
}

std::string particle_file_name(int frame) { return fmt::format("particles.{:04}.vdb", frame); }
std::string surfel_file_name(int frame) { return fmt::format("surfels.{:04}.vdb", frame); }
std::string facts_file_name(int frame) { return fmt::format("frame.{:04}.json", frame); }
std::string asset_file_name(std::string_view hash, std::string_view extension) {
    return fmt::format("{}/{}{}", kAssetFolder, hash, extension);
}

std::optional<FrameFileName> parse_frame_file_name(std::string_view name) {
    const std::size_t dot = name.find('.');
    int number = -1;
    if (dot == std::string_view::npos) return std::nullopt;
    std::from_chars(name.data() + dot + 1, name.data() + name.size(), number);
    if (number < 0 || number > kLargestFrameNumber) return std::nullopt;
    if (name == particle_file_name(number)) return FrameFileName{FrameFileName::particles, number};
    if (name == surfel_file_name(number)) return FrameFileName{FrameFileName::surfels, number};
    if (name == facts_file_name(number)) return FrameFileName{FrameFileName::facts, number};
    return std::nullopt;
}

bool is_asset_file_name(std::string_view name) {
    const std::size_t slash = name.rfind('/'), dot = name.rfind('.');
    if (slash == std::string_view::npos || dot == std::string_view::npos || dot < slash) return false;
    const std::string_view hash = name.substr(slash + 1, dot - slash - 1);
    return is_hash(hash) && std::any_of(kAssetExtensions.begin(), kAssetExtensions.end(),
                                        [&](std::string_view e) { return name == asset_file_name(hash, e); });
}

std::string print_manifest(const Manifest& m) {
    Json json = {{"checksum", std::string(kDigits, '0')},
                 {"format", m.format},
                 {"scene", m.scene},
                 {"simulation_hash", m.simulation_hash},
                 {"complete", m.complete},
                 {"totals", {{"frames", m.frames.size()}, {"bytes", m.bytes()}}},
                 {"scene_text", m.scene_text},
                 {"assets", Json::array()},
                 {"frames", Json::array()}};
    for (const CacheFile& a : m.assets) json["assets"].push_back(file_json(a));
    for (const ManifestFrame& f : m.frames) json["frames"].push_back(frame_json(f));
    std::string text = print_json(json, "scene '" + m.scene + "'");
    text.replace(kHead.size(), kDigits, hash_hex(text));
    return text;
}

Manifest parse_manifest(std::string_view text, const std::string& file) {
    refuse_newer_format(text, file);
    if (!checksum_matches(text))
        throw CacheError("'{}' is damaged: its checksum does not match; simulate again with --restart", file);
    const Json json = parse_json(text, file);
    const JsonPlace place{file, ""};
    object_or_fail(json, place);
    Manifest m;
    m.format = static_cast<int>(integer_at(json, "format", 1, kCacheFormat, place));
    m.scene = text_at(json, "scene", place);
    if (!scene::is_name(m.scene))  // files are named after it
        throw CacheError("'{}' is damaged: its scene is called '{}', which is no name", file, scene::shown(m.scene));
    m.simulation_hash = text_at(json, "simulation_hash", place);
    m.complete = bool_at(json, "complete", place);
    m.scene_text = text_at(json, "scene_text", place);
    parse_lists(json, place, m);
    const Json& totals = object_at(json, "totals", place);
    const auto frames = integer_at(totals, "frames", 0, INT64_MAX, place.in("totals"));
    if (static_cast<std::size_t>(frames) != m.frames.size())
        throw CacheError("'{}' is damaged: its totals disagree with its frames", file);
    return m;
}

}  // namespace thixo
