// The shape of a hanging drop, by which its surface tension is measured.
#pragma once

#include <string>
#include <vector>

namespace thixo::pendant {

/// The part of a drop below a level.
struct Below {
    double height;  // of the level [m]
    double volume;  // [m^3]
};

/// A hanging drop at rest, by three numbers.
struct Drop {
    double bottom;            // height of its lowest point [m]
    double radius;            // of curvature there [m]
    double capillary_length;  // sqrt(gamma/(rho g)) [m]
};

/// The volumes below ascending levels, each above the drop's bottom. Equation of Young and Laplace for a body of
/// revolution (Bashforth & Adams 1883). With the arc s from the bottom, the slope angle phi and z from the bottom:
///     dr/ds = cos phi,   dz/ds = sin phi,   dphi/ds = 2/b - z/l^2 - sin(phi)/r
std::vector<Below> volumes(const Drop& drop, const std::vector<double>& heights);

/// The drop whose volumes are nearest to the given ones, by least squares from a first guess (Levenberg & Marquardt).
Drop fit(const std::vector<Below>& measured, const Drop& guess);

struct Hanging {
    Drop drop;
    double misfit = 0;   // largest, of the drop's volume [1]
    double tension = 0;  // by the shape, over the scene's [1]
};
/// Hangs the drop of gates/pendant_drop.yaml, with keys changed as by --set, and fits its mean shape at rest.
Hanging hang(const std::vector<std::string>& set);

}  // namespace thixo::pendant
