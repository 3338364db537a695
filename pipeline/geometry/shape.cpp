#include "pipeline/geometry/shape.h"

namespace thixo {

Vec3 Shape::gradient(const Vec3& x, Real step) const {
    Vec3 g;
    for (int k = 0; k < 3; ++k) {
        Vec3 e = Vec3::Zero();
        e[k] = step;
        g[k] = distance(x + e) - distance(x - e);
    }
    const Real length = g.norm();
    return length > 0 ? Vec3(g / length) : Vec3::Zero();
}

}  // namespace thixo
