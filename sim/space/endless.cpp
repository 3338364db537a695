#include "sim/space/endless.h"

#include <algorithm>
#include <cmath>

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

ShapeMoments section_moments(const ShapeMoments& moments, const Box3& box, const Periodic& periodic) {
    const Mat3d onto = onto_section(periodic);
    const Vec3d to = in_section(Vec3::Zero(), periodic).cast<double>();
    double part = 1;  // of the period that the shape takes
    for (int a = 0; a < 3; ++a)
        if (periodic.axis[static_cast<std::size_t>(a)].on)
            part *= static_cast<double>((box.upper[a] - box.lower[a]) / periodic.period(a));
    const double volume = moments.volume / part;
    // Of x' = P x + t.
    const Vec3d first = onto * moments.first / part;
    return {volume, first + volume * to,
            onto * moments.second * onto / part + first * to.transpose() + to * first.transpose() +
                volume * to * to.transpose()};
}

bool goes_through(const Shape& shape, const std::vector<Vec3>& sites, Real spacing, const Periodic& periodic) {
    return std::ranges::all_of(sites, [&](const Vec3& site) {
        for (int a = 0; a < 3; ++a) {
            const Periodic::Axis& axis = periodic.axis[static_cast<std::size_t>(a)];
            if (!axis.on) continue;
            const Real first = axis.from + spacing / 4, last = axis.to - spacing / 4;
            const int stations = std::max(2, static_cast<int>(std::ceil((last - first) / spacing)) + 1);
            Vec3 x = site;
            for (int k = 0; k < stations; ++k) {
                x[a] = first + Real(k) / static_cast<Real>(stations - 1) * (last - first);
                if (!(shape.distance(x) < 0)) return false;
            }
        }
        return true;
    });
}

}  // namespace thixo
