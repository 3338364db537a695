#include "sim/solid/rigid_fit.h"

#include "pipeline/base/parallel.h"

namespace thixo {
namespace {

struct Sums {
    double mass = 0;
    Vec3d rest{0, 0, 0}, shift{0, 0, 0};  // sums of mass times m, u
    Mat3d spread = Mat3d::Zero();         // of mass times m (m + u)^T
    Sums operator+(const Sums& o) const { return {mass + o.mass, rest + o.rest, shift + o.shift, spread + o.spread}; }
};

}  // namespace

Mat3d fitting_rotation(const Mat3d& spread) {
    constexpr double kNoPlane = 1e-4;
    // Of what is no number the library leaves all results unset. Such a state has diverged, and is told of as that.
    if (!spread.allFinite()) return Mat3d::Identity();
    const Eigen::JacobiSVD<Mat3d> svd(spread, Eigen::ComputeFullU | Eigen::ComputeFullV);
    const Vec3d extent = svd.singularValues();
    if (!(extent[0] > 0)) return Mat3d::Identity();  // one element: nothing tells how it turns
    // Elements on a line: it turns the shortest way, and not about itself.
    if (extent[1] < kNoPlane * extent[0])
        return Quatd::FromTwoVectors(svd.matrixU().col(0), svd.matrixV().col(0)).toRotationMatrix();
    Vec3d sign(1, 1, 1);
    sign.z() = (svd.matrixV() * svd.matrixU().transpose()).determinant() < 0 ? -1 : 1;
    return svd.matrixV() * sign.asDiagonal() * svd.matrixU().transpose();
}

void fit_rest_shapes(std::vector<SolidBody>& bodies, Elements& elements, const std::vector<Real>* share) {
    for (SolidBody& body : bodies) {
        if (body.rigid) continue;
        const std::vector<Index>& list = body.elements;
        const std::size_t n = list.size();
        const Sums sum = parallel_sum<Sums>(
            n,
            [&](std::size_t k) {
                const Index i = list[k];
                const double mass = share ? elements.mass[i] * (*share)[i] : elements.mass[i];
                const Vec3d m = xyz(elements.rest[i]).cast<double>(), u = xyz(elements.displacement[i]).cast<double>();
                return Sums{mass, mass * m, mass * u, mass * m * (m + u).transpose()};
            },
            Sums{});
        if (!(sum.mass > 0)) continue;
        const Vec3d mbar = sum.rest / sum.mass, ybar = mbar + sum.shift / sum.mass;
        const Mat3d turn =
            body.endless ? Mat3d::Identity().eval() : fitting_rotation(sum.spread - sum.mass * mbar * ybar.transpose());
        // The new pose (turn, shift) within the old frame: y = turn m' + shift.
        const Vec3d shift = ybar - turn * mbar;
        const Mat3d back = turn.transpose(), change = back - Mat3d::Identity();
        parallel_for(
            n,
            [&](std::size_t k) {
                const Index i = list[k];
                Quad &u = elements.displacement[i], &v = elements.velocity[i];
                const Vec3d m = xyz(elements.rest[i]).cast<double>();
                u = quad((back * (xyz(u).cast<double>() - shift) + change * m).cast<Real>());
                v = quad((back * xyz(v).cast<double>()).cast<Real>());
                Vec3& a = elements.acceleration[i];
                a = (back * a.cast<double>()).cast<Real>();
            },
            2048);
        body.place += body.turn * shift;
        body.turn = body.turn * turn;
        // Rounding of many steps must not make the matrix anything but a rotation.
        body.turn = Quatd(body.turn).normalized().toRotationMatrix();
    }
}

}  // namespace thixo
