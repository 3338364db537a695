#include "render/cryptomatte.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <nlohmann/json.hpp>

namespace thixo::render {

std::uint32_t murmur3(std::string_view bytes) {
    std::uint32_t hash = 0;
    const auto mixed = [](std::uint32_t k) { return std::rotl(k * 0xcc9e2d51u, 15) * 0x1b873593u; };
    const auto byte = [&](std::size_t i) { return std::uint32_t(static_cast<unsigned char>(bytes[i])); };
    std::size_t at = 0;
    for (; at + 4 <= bytes.size(); at += 4) {
        const std::uint32_t k = byte(at) | byte(at + 1) << 8 | byte(at + 2) << 16 | byte(at + 3) << 24;
        hash = std::rotl(hash ^ mixed(k), 13) * 5 + 0xe6546b64u;
    }
    std::uint32_t tail = 0;
    for (std::size_t i = bytes.size(); i > at; --i) tail = tail << 8 | byte(i - 1);
    hash ^= mixed(tail) ^ std::uint32_t(bytes.size());
    hash = (hash ^ hash >> 16) * 0x85ebca6bu;
    hash = (hash ^ hash >> 13) * 0xc2b2ae35u;
    return hash ^ hash >> 16;
}

std::uint32_t cryptomatte_id(std::string_view name) {
    const std::uint32_t hash = murmur3(name), exponent = std::clamp(hash >> 23 & 255u, 1u, 254u);
    return (hash & 0x807fffffu) | exponent << 23;
}

void count(std::vector<Coverage>& coverage, std::uint32_t id) {
    const auto known = std::find_if(coverage.begin(), coverage.end(), [&](const Coverage& c) { return c.id == id; });
    if (known != coverage.end())
        ++known->samples;
    else
        coverage.push_back({id, 1});
}

void sort_by_rank(std::vector<Coverage>& coverage) {
    std::sort(coverage.begin(), coverage.end(), [](const Coverage& a, const Coverage& b) {
        return a.samples > b.samples || (a.samples == b.samples && a.id < b.id);
    });
}

void describe_cryptomatte(const std::string& layer, const std::vector<std::string>& names,
                          std::map<std::string, std::string>& attributes) {
    nlohmann::json manifest = nlohmann::json::object();
    for (const std::string& name : names) manifest[name] = fmt::format("{:08x}", cryptomatte_id(name));
    const std::string key = fmt::format("cryptomatte/{:.7}/", fmt::format("{:08x}", cryptomatte_id(layer)));
    attributes[key + "name"] = layer;
    attributes[key + "hash"] = "MurmurHash3_32";
    attributes[key + "conversion"] = "uint32_to_float32";
    attributes[key + "manifest"] = manifest.dump();
}

}  // namespace thixo::render
