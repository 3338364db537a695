// The light of matter that glows by its heat.
#pragma once

#include "pipeline/base/math.h"

namespace thixo::render {

/// A black body of temperature T [K] as the eye of the CIE's observer of 1931 (2 degrees) sees it:
///
///   (X, Y, Z) = int (x, y, z)(l) B(l, T) dl   [W/(m^2 sr)]
///   B = 2 h c^2 / l^5 / (exp(h c/(k l T)) - 1)
///
/// over the wavelengths l from 380 to 780 nm. 683 Y is its luminance [cd/m^2]. Requires T > 0.
Vec3d black_body_xyz(double kelvin);

/// The radiance of a black body in linear Rec.709, in parts of the luminance of one at the reference temperature:
///
///   L = c(T) Y(T)/Y(reference)   [1]
///
/// c(T) is its colour with luminance 1. Below 1900 K that colour lies outside of Rec.709; what would be below 0, blue and
/// then green, is 0. From a table with a relative error of 1e-5. Below 250 K it is 0, from 1e5 K on constant.
Vec3f black_body_radiance(float kelvin, float reference);

}  // namespace thixo::render
