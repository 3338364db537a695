// Checksums of files and of text: XXH3, 128 bits (xxhash.com), the same on every machine.
#pragma once

#include <string>
#include <string_view>

namespace thixo {

/// XXH3-128 of the bytes as 32 lower-case hexadecimal digits, most significant first.
std::string hash_hex(std::string_view bytes);

/// XXH3-128 of `bytes` as if the `length` bytes at `offset` were all '0': the checksum of a file that carries its own
/// checksum there. Requires offset + length <= bytes.size().
std::string hash_hex_without(std::string_view bytes, std::size_t offset, std::size_t length);

/// Whether the last 32 bytes are hash_hex of those before them.
bool ends_with_checksum(std::string_view bytes);

}  // namespace thixo
