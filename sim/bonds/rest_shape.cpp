#include "sim/bonds/rest_shape.h"

#include <algorithm>

#include "pipeline/base/error.h"
#include "pipeline/base/parallel.h"
#include "pipeline/geometry/kernels.h"
#include "pipeline/geometry/point_grid.h"

namespace thixo {
namespace {

struct Neighbour {
    Index element;
    Vec3 across;  // periods on the way to it [m]
};

/// The images of an endless body's elements across periodic faces, within `reach` [m] of them.
Ghosts images_of(const SolidBody& body, const std::vector<Vec3>& rest, Real reach, const Periodic& periodic) {
    Ghosts images;
    if (!body.endless) return images;
    THIXO_ASSERT(periodic.any(), "body {} would lose its bonds across periodic faces", body.id);
    std::vector<Vec3> place = rest;
    for (Vec3& x : place) x += body.origin;
    find_ghosts(periodic, place, reach, images);
    return images;
}

/// Appends the neighbours of the elements of one body to `lists`, from the body's first element on.
void list_body(const SolidBody& body, const Elements& elements, const Periodic& periodic,
               const std::function<bool(Index, Index, const Vec3&)>& hang_together,
               std::vector<std::vector<Neighbour>>& lists) {
    if (!body.shaped() || body.empty()) return;
    std::vector<Vec3> place = rest_places(body, elements);
    Real widest = 0;
    for (const Index i : body.elements) widest = std::max(widest, elements.support[i]);
    const Ghosts images = images_of(body, place, widest, periodic);
    for (std::size_t g = 0; g < images.size(); ++g) place.push_back(place[images.source[g]] + images.shift[g]);
    PointGrid grid;
    grid.build(place, widest);
    parallel_for(body.size(), [&](std::size_t k) {
        const Index i = body.elements[k];
        grid.for_each_neighbour(place[k], widest, [&](Index near, Real r2) {
            const bool image = near >= body.size();
            const Index j = body.elements[image ? images.source[near - body.size()] : near];
            if (j == i || !(r2 < square((elements.support[i] + elements.support[j]) / 2))) return;
            const Vec3 way = place[near] - place[k];
            if (hang_together && !hang_together(std::min(i, j), std::max(i, j), i < j ? way : Vec3(-way))) return;
            lists[i].push_back({j, image ? images.shift[near - body.size()] : Vec3(0, 0, 0)});
        });
    });
}

Mat3d moment_matrix(const Elements& elements, std::size_t i, Vec3d& first) {
    Mat3d a = Mat3d::Zero();
    first.setZero();
    for (std::size_t k = elements.bonds.begin[i]; k < elements.bonds.begin[i + 1]; ++k) {
        const Vec3d r = bond_vector(elements, i, k);
        const double w = static_cast<double>(elements.bonds.weight[k]);
        a += w * r * r.transpose();
        first += w * r;
    }
    return a;
}

}  // namespace

Real rest_weight(Real hi, Real hj, Real r) { return weight_unit(hi) * (cube(hj / hi) * Spiky((hi + hj) / 2).value(r)); }

void find_rest_neighbours(const std::vector<SolidBody>& bodies, Elements& elements, const HangTogether& hang_together,
                          const Periodic& periodic) {
    const std::size_t n = elements.size();
    std::vector<std::vector<Neighbour>> lists(n);
    for (std::size_t b = 0; b < bodies.size(); ++b)
        list_body(bodies[b], elements, periodic,
                  hang_together ? [&](Index i, Index j, const Vec3& way) { return hang_together(b, i, j, way); }
                                : std::function<bool(Index, Index, const Vec3&)>(),
                  lists);
    Bonds& bonds = elements.bonds;
    bonds.changed();
    bonds.begin.assign(n + 1, 0);
    for (std::size_t i = 0; i < n; ++i)
        bonds.begin[i + 1] = bonds.begin[i] + (lists[i].size() + kLanes - 1) / kLanes * kLanes;
    bonds.neighbour.resize(bonds.begin[n]);
    bonds.weight.assign(bonds.begin[n], 0);
    bonds.weight_back.assign(bonds.begin[n], 0);
    const bool wrap = std::ranges::any_of(bodies, &SolidBody::endless);
    for (auto& array : bonds.across) array.assign(wrap ? bonds.begin[n] : 0, 0);
    parallel_for(n, [&](std::size_t i) {
        std::size_t k = bonds.begin[i];
        for (const auto& [j, across] : lists[i]) {
            const Real r = (xyz(elements.rest[j]) + across - xyz(elements.rest[i])).norm();
            bonds.weight[k] = rest_weight(elements.support[i], elements.support[j], r);
            bonds.weight_back[k] = rest_weight(elements.support[j], elements.support[i], r);
            if (wrap)
                for (int a = 0; a < 3; ++a) bonds.across[static_cast<std::size_t>(a)][k] = across[a];
            bonds.neighbour[k++] = j;
        }
        while (k < bonds.begin[i + 1]) bonds.neighbour[k++] = static_cast<Index>(i);
    });
}

HangTogether hang_together_in_shapes(const Solids& solids) {
    constexpr Real kOutside = Real(0.25);
    return [&solids](std::size_t b, Index i, Index j, const Vec3& way) {
        const Elements& e = solids.elements;
        const SolidBody& body = solids.bodies[b];
        if (!body.shape) return true;
        const Vec3 from = xyz(e.rest[i]);
        const Real outside = kOutside * std::cbrt(e.volume[i]);
        // The depth changes by no more than the way: most pairs lie too deep to leave the shape between them.
        if (e.depth[i] + e.depth[j] + 2 * outside >= way.norm()) return true;
        for (const Real part : {Real(0.5), Real(0.25), Real(0.75)})
            if (body.shape->distance(from + part * way + body.origin) > outside) return false;
        return true;
    };
}

void measure_moments(Elements& elements, const std::vector<std::uint8_t>* which, double flat) {
    const std::size_t n = elements.size();
    elements.bonds.moment.resize(n);
    std::vector<Symmetric> projection(n);
    for (const auto& [i, flat_projection] : elements.bonds.flat) projection[i] = flat_projection;
    parallel_for(n, [&](std::size_t i) {
        if (which && !(*which)[i]) return;
        Vec3d first;
        const Mat3d a = moment_matrix(elements, i, first);
        const Eigen::SelfAdjointEigenSolver<Mat3d> eigen(a);
        const Vec3d& value = eigen.eigenvalues();
        Mat3d inverse = Mat3d::Zero(), onto = Mat3d::Zero();
        int rank = 0;
        for (int c = 0; c < 3; ++c) {
            if (!(value[c] > flat * value[2])) continue;
            const Vec3d v = eigen.eigenvectors().col(c);
            inverse += v * v.transpose() / value[c];
            onto += v * v.transpose();
            ++rank;
        }
        elements.bonds.moment[i] = {symmetric(inverse.cast<Real>()), first.cast<Real>(), static_cast<Real>(a.trace()),
                                    rank == 3};
        projection[i] = symmetric(onto.cast<Real>());
    });
    elements.bonds.flat.clear();
    for (Index i = 0; i < n; ++i)
        if (!elements.bonds.moment[i].full) elements.bonds.flat.emplace_back(i, projection[i]);
}

}  // namespace thixo
