#include "sim/particles.h"

#include <cstddef>
#include <cstring>
#include <type_traits>

#include "pipeline/base/parallel.h"

namespace thixo {
namespace {

template <class T>
T zero() {
    if constexpr (std::is_same_v<T, Vec3>)
        return Vec3::Zero();
    else
        return T{};
}

}  // namespace

void resize(Particles& p, std::size_t count) {
    for_each_array(p, [&]<class T>(const char*, std::vector<T>& array) { array.resize(count, zero<T>()); });
}

void reorder(Particles& p, const std::vector<Index>& order, ReorderScratch& scratch) {
    constexpr std::size_t kGrain = 4096;
    const std::size_t n = order.size();
    scratch.resize(n, Vec3::Zero());
    for_each_array(p, [&]<class T>(const char*, std::vector<T>& array) {
        if constexpr (std::is_same_v<T, Vec3>) {
            parallel_for(
                n, [&](std::size_t k) { scratch[k] = array[order[k]]; }, kGrain);
            array.swap(scratch);
        } else {
            static_assert(sizeof(T) <= sizeof(Vec3) && std::is_trivially_copyable_v<T>);
            auto* sorted = reinterpret_cast<std::byte*>(scratch.data());
            parallel_for(
                n, [&](std::size_t k) { std::memcpy(sorted + k * sizeof(T), &array[order[k]], sizeof(T)); }, kGrain);
            parallel_for(
                n, [&](std::size_t k) { std::memcpy(&array[k], sorted + k * sizeof(T), sizeof(T)); }, kGrain);
        }
    });
}

Index add_particle(Particles& p, std::int64_t id) {
    const std::size_t i = p.size();
    resize(p, i + 1);
    p.id[i] = id;
    return static_cast<Index>(i);
}

}  // namespace thixo
