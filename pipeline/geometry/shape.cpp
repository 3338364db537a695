#include "pipeline/geometry/shape.h"

#include <array>

#include "pipeline/geometry/sloped_shape.h"

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

Real SlopedShape::by_differences(const Node& node, const Vec3& x, Real step, Vec3& slope) {
    const std::array<Vec3, 4> corner{Vec3(1, -1, -1), Vec3(-1, -1, 1), Vec3(-1, 1, -1), Vec3(1, 1, 1)};
    Real mean = 0;
    slope.setZero();
    for (const Vec3& c : corner) {
        const Real d = node.distance(x + step * c);
        slope += d * c;
        mean += d / 4;
    }
    slope /= 4 * step;
    return mean;
}

}  // namespace thixo
