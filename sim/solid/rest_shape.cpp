#include "sim/solid/rest_shape.h"

#include <algorithm>

#include "pipeline/base/parallel.h"
#include "pipeline/geometry/kernels.h"
#include "pipeline/geometry/point_grid.h"

namespace thixo {
namespace {

/// Neighbours of the elements of one body, appended to `lists` from its first element on.
void list_body(const SolidBody& body, const Elements& elements, const std::function<bool(Index, Index)>& hang_together,
               std::vector<std::vector<Index>>& lists) {
    const std::size_t n = body.body < 0 ? 0 : body.end - body.begin;
    if (n == 0) return;
    std::vector<Vec3> place(n);
    Real widest = 0;
    for (std::size_t k = 0; k < n; ++k) {
        place[k] = xyz(elements.rest[body.begin + k]);
        widest = std::max(widest, elements.support[body.begin + k]);
    }
    PointGrid grid;
    grid.build(place, widest);
    parallel_for(n, [&](std::size_t k) {
        const Index i = body.begin + static_cast<Index>(k);
        grid.for_each_neighbour(place[k], widest, [&](Index near, Real r2) {
            const Index j = body.begin + near;
            if (j == i || !(r2 < square((elements.support[i] + elements.support[j]) / 2))) return;
            if (!hang_together || hang_together(std::min(i, j), std::max(i, j))) lists[i].push_back(j);
        });
    });
}

/// Of an element of support h_j in the stencil of one of support h_i.
Real weight(Real hi, Real hj, Real r) { return cube(hj / hi) * Spiky((hi + hj) / 2).value(r); }

Mat3d moment_matrix(const Elements& elements, std::size_t i, Vec3d& first) {
    Mat3d a = Mat3d::Zero();
    first.setZero();
    const Vec3d m = xyz(elements.rest[i]).cast<double>();
    for (std::size_t k = elements.begin[i]; k < elements.begin[i + 1]; ++k) {
        const Vec3d r = xyz(elements.rest[elements.neighbour[k]]).cast<double>() - m;
        const double w = static_cast<double>(elements.weight[k]);
        a += w * r * r.transpose();
        first += w * r;
    }
    return a;
}

}  // namespace

void find_rest_neighbours(const std::vector<SolidBody>& bodies, Elements& elements, const HangTogether& hang_together) {
    const std::size_t n = elements.size();
    std::vector<std::vector<Index>> lists(n);
    for (std::size_t b = 0; b < bodies.size(); ++b)
        list_body(bodies[b], elements,
                  hang_together ? [&](Index i, Index j) { return hang_together(b, i, j); }
                                : std::function<bool(Index, Index)>(),
                  lists);
    elements.begin.assign(n + 1, 0);
    for (std::size_t i = 0; i < n; ++i)
        elements.begin[i + 1] = elements.begin[i] + (lists[i].size() + kLanes - 1) / kLanes * kLanes;
    elements.neighbour.resize(elements.begin[n]);
    elements.weight.assign(elements.begin[n], 0);
    elements.weight_back.assign(elements.begin[n], 0);
    parallel_for(n, [&](std::size_t i) {
        std::size_t k = elements.begin[i];
        for (const Index j : lists[i]) {
            const Real r = (xyz(elements.rest[j]) - xyz(elements.rest[i])).norm();
            elements.weight[k] = weight(elements.support[i], elements.support[j], r);
            elements.weight_back[k] = weight(elements.support[j], elements.support[i], r);
            elements.neighbour[k++] = j;
        }
        while (k < elements.begin[i + 1]) elements.neighbour[k++] = static_cast<Index>(i);
    });
}

void measure_moments(Elements& elements, const std::vector<std::uint8_t>* which, double flat) {
    const std::size_t n = elements.size();
    elements.moment.resize(n);
    std::vector<Symmetric> projection(n);
    for (const auto& [i, kept] : elements.flat) projection[i] = kept;
    parallel_for(n, [&](std::size_t i) {
        if (which && !(*which)[i]) return;
        Vec3d first;
        const Mat3d a = moment_matrix(elements, i, first);
        const Eigen::SelfAdjointEigenSolver<Mat3d> eigen(a);
        const Vec3d& value = eigen.eigenvalues();
        Mat3d inverse = Mat3d::Zero(), kept = Mat3d::Zero();
        int rank = 0;
        for (int c = 0; c < 3; ++c) {
            if (!(value[c] > flat * value[2])) continue;
            const Vec3d v = eigen.eigenvectors().col(c);
            inverse += v * v.transpose() / value[c];
            kept += v * v.transpose();
            ++rank;
        }
        elements.moment[i] = {symmetric(inverse.cast<Real>()), first.cast<Real>(), static_cast<Real>(a.trace()),
                              rank == 3};
        projection[i] = symmetric(kept.cast<Real>());
    });
    elements.flat.clear();
    for (Index i = 0; i < n; ++i)
        if (!elements.moment[i].full) elements.flat.emplace_back(i, projection[i]);
}

}  // namespace thixo
