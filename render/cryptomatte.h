// Cryptomatte (Friedman & Jones 2015, specification 1.2.0): mattes by name that keep the share of every object in a
// pixel.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace thixo::render {

/// MurmurHash3, 32 bits, seed 0, of the name's bytes; with the exponent changed where it would make no ordinary float.
std::uint32_t cryptomatte_id(std::string_view name);
/// Its hash as Austin Appleby published it, before that change.
std::uint32_t murmur3(std::string_view bytes);

/// How many samples of a pixel have seen what an id stands for.
struct Coverage {
    std::uint32_t id = 0;
    int samples = 0;
};
void count(std::vector<Coverage>& coverage, std::uint32_t id);
/// Most samples first; among equals the lower id.
void sort_by_rank(std::vector<Coverage>& coverage);

/// Adds what the file's header says of a layer: its name, hash, conversion, and the manifest from names to ids.
void describe_cryptomatte(const std::string& layer, const std::vector<std::string>& names,
                          std::map<std::string, std::string>& attributes);

}  // namespace thixo::render
