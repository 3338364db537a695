#include "pipeline/contract/hash.h"

#include <fmt/core.h>
#include <xxhash.h>

#include <memory>
#include <new>

#include "pipeline/base/error.h"

namespace thixo {
namespace {

struct FreeState {
    void operator()(XXH3_state_t* state) const { XXH3_freeState(state); }
};

std::string digits(XXH128_hash_t h) {
    return fmt::format("{:016x}{:016x}", static_cast<unsigned long long>(h.high64),
                       static_cast<unsigned long long>(h.low64));
}

}  // namespace

std::string hash_hex(std::string_view bytes) { return digits(XXH3_128bits(bytes.data(), bytes.size())); }

std::string hash_hex_without(std::string_view bytes, std::size_t offset, std::size_t length) {
    THIXO_ASSERT(offset <= bytes.size() && length <= bytes.size() - offset, "{} + {} of {} bytes", offset, length,
                 bytes.size());
    const std::unique_ptr<XXH3_state_t, FreeState> state(XXH3_createState());
    if (!state) throw std::bad_alloc();
    const std::string zeros(length, '0');
    XXH3_128bits_reset(state.get());
    XXH3_128bits_update(state.get(), bytes.data(), offset);
    XXH3_128bits_update(state.get(), zeros.data(), zeros.size());
    XXH3_128bits_update(state.get(), bytes.data() + offset + length, bytes.size() - offset - length);
    return digits(XXH3_128bits_digest(state.get()));
}

bool ends_with_checksum(std::string_view bytes) {
    constexpr std::size_t kDigits = 32;
    return bytes.size() >= kDigits &&
           hash_hex(bytes.substr(0, bytes.size() - kDigits)) == bytes.substr(bytes.size() - kDigits);
}

}  // namespace thixo
