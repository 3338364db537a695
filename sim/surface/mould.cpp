#include "sim/surface/mould.h"

namespace thixo {

MouldPull pull_of_moulds(const std::vector<Mould>& moulds, const Vec3& x, const Vec3& n, Real step) {
    constexpr Real kFaces = Real(0.5);  // least cosine between a surfel's normal and that of the face it takes on
    MouldPull pull;
    for (const Mould& mould : moulds) {
        const Real d = mould.shape.distance(x);
        if (!(std::abs(d) < mould.reach)) continue;
        const Vec3 slope = mould.shape.gradient(x, step);
        const Real along = n.dot(slope);
        if (std::abs(along) < kFaces) continue;
        pull.weight += mould.weight;
        pull.force -= mould.weight * d * slope;
        pull.outward += (along > 0 ? mould.weight : -mould.weight) * slope;
    }
    if (pull.weight > 0) {
        pull.force /= pull.weight;
        pull.outward /= pull.weight;
    }
    return pull;
}

}  // namespace thixo
