// A surface that knows its own points: quicker to sample than by a distance, and with its own normals.
#pragma once

#include "pipeline/base/math.h"

namespace thixo {

class DirectSurface {
  public:
    virtual ~DirectSurface() = default;
    virtual double area() const = 0;  // [m^2]
    /// The point at the part u of the area (in the surface's own order) and places v, w across: even by area where u, v
    /// and w are even in [0, 1).
    virtual void point(double u, double v, double w, Vec3& x, Vec3& normal) const = 0;
    /// x brought to the closest point, with the normal there.
    virtual void project(Vec3& x, Vec3& normal) const = 0;
};

}  // namespace thixo
