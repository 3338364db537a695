#include "sim/bonds/gradients.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "pipeline/base/parallel.h"
#include "sim/bonds/stencil.h"

namespace thixo {
namespace {

constexpr std::size_t kElements = 128;  // of one chunk

/// The rotation nearest to m.
Mat3d rotation_of(const Mat3d& m) {
    const Eigen::JacobiSVD<Mat3d> svd(m, Eigen::ComputeFullU | Eigen::ComputeFullV);
    const double side = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
    return svd.matrixU() * Vec3d(1, 1, side).asDiagonal() * svd.matrixV().transpose();
}

}  // namespace

Mat3 gradient_of(const Elements& elements, std::size_t i) {
    return differences(elements, i, elements.displacement.data()).outer * matrix(elements.bonds.moment[i].inverse);
}

void find_gradients(const Elements& elements, std::vector<Mat3>& gradients) {
    gradients.resize(elements.size());
    parallel_for(
        elements.size(), [&](std::size_t i) { gradients[i] = gradient_of(elements, i); }, kElements);
}

Real volume_ratio(const Elements& elements, std::size_t i, const Mat3& gradient) {
    const Mat3 one = Mat3::Identity();
    if (elements.bonds.moment[i].full) return (one + gradient).determinant();
    const Mat3 p = projection_of(elements, i), j = p + gradient;
    return std::sqrt(std::max(Mat3(j.transpose() * j + one - p).determinant(), Real(0)));
}

void complete_gradients(const Elements& e, std::vector<Mat3>& gradients) {
    constexpr int kPasses = 4;  // a limb's last few elements may all be flat: each takes R' from the one before it
    std::vector<std::uint8_t> done(e.bonds.flat.size(), 0);
    const auto is_complete = [&](Index j) {
        if (e.bonds.moment[j].full) return true;
        const auto at = std::lower_bound(e.bonds.flat.begin(), e.bonds.flat.end(), j,
                                         [](const auto& a, Index b) { return a.first < b; });
        return done[static_cast<std::size_t>(at - e.bonds.flat.begin())] != 0;
    };
    for (int pass = 0; pass < kPasses; ++pass) {
        std::vector<std::size_t> finished;
        for (std::size_t k = 0; k < e.bonds.flat.size(); ++k) {
            if (done[k]) continue;
            const auto& [i, projection] = e.bonds.flat[k];
            Mat3d sum = Mat3d::Zero();
            int count = 0;
            for (std::size_t l = e.bonds.begin[i]; l < e.bonds.begin[i + 1]; ++l)
                if (const Index j = e.bonds.neighbour[l]; j != i && is_complete(j)) {
                    sum += gradients[j].cast<double>();
                    ++count;
                }
            if (count == 0 && pass + 1 < kPasses) continue;
            const Mat3d one = Mat3d::Identity(), p = matrix(projection).cast<double>(), missing = one - p;
            const Mat3d near = rotation_of(one + sum / std::max(count, 1));
            const Mat3d turn = rotation_of(p + gradients[i].cast<double>() + near * missing);
            gradients[i] += ((turn - one) * missing).cast<Real>();
            finished.push_back(k);
        }
        for (const std::size_t k : finished) done[k] = 1;
    }
}

}  // namespace thixo
