// A surface that gives its own points and normals. Sampling it is quicker than sampling by a distance.
#pragma once

#include "pipeline/base/math.h"

namespace thixo {

class DirectSurface {
  public:
    virtual ~DirectSurface() = default;
    virtual double area() const = 0;  // [m^2]
    /// The point of the parameters u, v, w in [0, 1). The parameter u is the part of the area that comes before the
    /// point, in the surface's own order; v and w run across. Even parameters give points that are even by area.
    virtual void point(double u, double v, double w, Vec3& x, Vec3& normal) const = 0;
    /// The point of the surface that is closest to x, with its normal.
    virtual void project(Vec3& x, Vec3& normal) const = 0;
};

}  // namespace thixo
