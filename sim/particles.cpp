#include "sim/particles.h"

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
    for_each_array(p, [&]<class T>(const char*, std::vector<T>& array) {
        auto& sorted = std::get<std::vector<T>>(scratch);
        sorted.resize(order.size(), zero<T>());
        parallel_for(
            order.size(), [&](std::size_t k) { sorted[k] = array[order[k]]; }, 4096);
        array.swap(sorted);
    });
}

Index add_particle(Particles& p, std::int64_t id) {
    const std::size_t i = p.size();
    resize(p, i + 1);
    p.id[i] = id;
    return static_cast<Index>(i);
}

}  // namespace thixo
