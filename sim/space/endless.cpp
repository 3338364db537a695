#include "sim/space/endless.h"

#include <algorithm>

namespace thixo {
namespace {

double middle(const Periodic::Axis& axis) {
    return 0.5 * (static_cast<double>(axis.from) + static_cast<double>(axis.to));
}

struct Endless final : Shape::Node {
    Endless(Shape s, const Periodic& p) : shape(std::move(s)), periodic(p) {}
    Real distance(const Vec3& x) const override { return shape.distance(in_section(x, periodic)); }
    std::optional<Box3> bounds() const override { return std::nullopt; }
    Shape shape;
    Periodic periodic;
};

}  // namespace

Vec3 in_section(const Vec3& x, const Periodic& periodic) {
    Vec3 out = x;
    for (int a = 0; a < 3; ++a)
        if (const Periodic::Axis& axis = periodic.axis[static_cast<std::size_t>(a)]; axis.on)
            out[a] = static_cast<Real>(middle(axis));
    return out;
}

Mat3d onto_section(const Periodic& periodic) {
    Vec3d across;
    for (int a = 0; a < 3; ++a) across[a] = periodic.axis[static_cast<std::size_t>(a)].on ? 0 : 1;
    return across.asDiagonal();
}

Shape endless(Shape shape, const Periodic& periodic) {
    return Shape(std::make_shared<Endless>(std::move(shape), periodic));
}

ShapeMoments section_moments(const ShapeMoments& moments, const Periodic& periodic) {
    const Mat3d onto = onto_section(periodic);
    const Vec3d to = in_section(Vec3::Zero(), periodic).cast<double>();
    // Of x' = P x + t.
    const Vec3d first = onto * moments.first;
    return {moments.volume, first + moments.volume * to,
            onto * moments.second * onto + first * to.transpose() + to * first.transpose() +
                moments.volume * to * to.transpose()};
}

bool goes_through(const Shape& shape, const std::vector<Vec3>& sites, Real spacing, const Periodic& periodic) {
    constexpr int kStations = 9;  // from face to face
    return std::ranges::all_of(sites, [&](const Vec3& site) {
        for (int a = 0; a < 3; ++a) {
            const Periodic::Axis& axis = periodic.axis[static_cast<std::size_t>(a)];
            if (!axis.on) continue;
            const Real first = axis.from + spacing / 4, last = axis.to - spacing / 4;
            Vec3 x = site;
            for (int k = 0; k < kStations; ++k) {
                x[a] = first + Real(k) / (kStations - 1) * (last - first);
                if (!(shape.distance(x) < 0)) return false;
            }
        }
        return true;
    });
}

}  // namespace thixo
