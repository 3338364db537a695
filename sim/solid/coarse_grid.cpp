#include "sim/solid/coarse_grid.h"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <array>
#include <cmath>

#include "pipeline/base/parallel.h"
#include "sim/solid/stiffness.h"

namespace thixo {
namespace {

constexpr double kCell = 3;         // least size of a cell, in particle widths
constexpr double kMostNodes = 300;  // of a body: more nodes cost more time than they save
constexpr double kFewest = 64;      // elements of a body for which a grid pays
// Added to the diagonal, relative to it: rounding of the blocks leaves eigenvalues below zero. Ten times as much until
// the matrix has a factor.
constexpr double kShift = 1e-9, kMostShift = 1e-3;
constexpr std::size_t kCorners = 8;  // of a cell

using Sparse = Eigen::SparseMatrix<double>;

/// Neighbours of a node are no farther than this along each axis, as stencils reach no farther than a cell.
constexpr int kReach = 3, kSide = 2 * kReach + 1, kSlots = kSide * kSide * kSide;

struct Lattice {
    Vec3d origin{0, 0, 0};
    double cell = 0;  // [m]; 0: none
    std::array<int, 3> count{0, 0, 0};
    std::size_t first = 0;  // node
    std::size_t nodes() const { return static_cast<std::size_t>(count[0] * count[1] * count[2]); }
    std::array<int, 3> place(std::size_t node) const {
        const int k = static_cast<int>(node - first);
        return {k % count[0], k / count[0] % count[1], k / count[0] / count[1]};
    }
};

Lattice lattice_of(const SolidBody& body, const Elements& e, std::size_t first) {
    Lattice lattice;
    lattice.first = first;
    if (static_cast<double>(body.size()) < kFewest) return lattice;
    Vec3d lower = Vec3d::Constant(1e30), upper = -lower;
    double support = 0, volume = 0;
    for (const Index i : body.elements) {
        const Vec3d m = xyz(e.rest[i]).cast<double>();
        lower = lower.cwiseMin(m);
        upper = upper.cwiseMax(m);
        support = std::max(support, static_cast<double>(e.support[i]));
        volume += static_cast<double>(e.volume[i]);
    }
    const double width = std::cbrt(volume / static_cast<double>(body.size()));
    lattice.cell = std::max({kCell * width, support, std::cbrt(volume / kMostNodes)});
    for (int a = 0; a < 3; ++a)
        lattice.count[static_cast<std::size_t>(a)] =
            static_cast<int>(std::floor((upper[a] - lower[a]) / lattice.cell)) + 2;
    for (int a = 0; a < 3; ++a)  // about the middle
        lattice.origin[a] = (lower[a] + upper[a] - (lattice.count[static_cast<std::size_t>(a)] - 1) * lattice.cell) / 2;
    return lattice;
}

struct Corner {
    Index node = 0;
    Real weight = 0;
};

/// A symmetric matrix of 3x3 blocks, by nodes (rows) and the places of their neighbours (columns).
struct Blocks {
    std::vector<Index> slot;  // kSlots of every node: index of a block, or kNone
    std::vector<Mat3d> block;
    void start(std::size_t nodes) {
        slot.assign(nodes * kSlots, kNone);
        block.clear();
    }
    Mat3d& at(const Lattice& lattice, Index row, Index column) {
        const auto a = lattice.place(row), b = lattice.place(column);
        const int x = b[0] - a[0] + kReach, y = b[1] - a[1] + kReach, z = b[2] - a[2] + kReach;
        Index& k = slot[row * std::size_t(kSlots) + static_cast<std::size_t>((z * kSide + y) * kSide + x)];
        if (k == kNone) {
            k = static_cast<Index>(block.size());
            block.push_back(Mat3d::Zero());
        }
        return block[k];
    }
};

}  // namespace

struct CoarseGrid::State {
    // The state that the matrices were computed for.
    std::uint64_t version = 0;  // of the bonds
    std::vector<std::uint8_t> held;
    double dt = 0;
    bool bounded = false;
    // N: the eight corners of every element, and the elements of every node.
    std::vector<Lattice> lattice;
    std::size_t nodes = 0;
    std::vector<Corner> corner;
    std::vector<std::size_t> begin;
    std::vector<std::pair<Index, Real>> member;
    Sparse elastic, viscous, mass, matrix;
    Eigen::SimplicialLLT<Sparse> factor;
    bool usable = false;
    Eigen::VectorXd right, left;

    std::vector<SolidBody> bodies;
};

namespace {

void place_corners(const Lattice& lattice, const SolidBody& body, const Elements& e,
                   const std::vector<std::uint8_t>& held, std::vector<Corner>& corner) {
    if (!(lattice.cell > 0)) return;
    parallel_for(body.size(), [&](std::size_t k) {
        const std::size_t i = body.elements[k];
        const Vec3d at = (xyz(e.rest[i]).cast<double>() - lattice.origin) / lattice.cell;
        std::array<int, 3> cell{};
        Vec3d part;
        for (int a = 0; a < 3; ++a) {
            const auto c = static_cast<std::size_t>(a);
            cell[c] = std::clamp(static_cast<int>(std::floor(at[a])), 0, lattice.count[c] - 2);
            part[a] = at[a] - cell[c];
        }
        for (int c = 0; c < 8; ++c) {
            const int dx = c & 1, dy = c >> 1 & 1, dz = c >> 2;
            const double weight =
                (dx ? part[0] : 1 - part[0]) * (dy ? part[1] : 1 - part[1]) * (dz ? part[2] : 1 - part[2]);
            const int node = ((cell[2] + dz) * lattice.count[1] + cell[1] + dy) * lattice.count[0] + cell[0] + dx;
            corner[kCorners * i + static_cast<std::size_t>(c)] = {
                static_cast<Index>(lattice.first) + static_cast<Index>(node),
                held[i] ? Real(0) : static_cast<Real>(weight)};
        }
    });
}

/// Lists the elements of every node.
void list_members(const std::vector<Corner>& corner, std::size_t nodes, std::vector<std::size_t>& begin,
                  std::vector<std::pair<Index, Real>>& member) {
    begin.assign(nodes + 1, 0);
    for (const Corner& c : corner)
        if (c.weight > 0) ++begin[c.node + 1];
    for (std::size_t n = 0; n < nodes; ++n) begin[n + 1] += begin[n];
    member.resize(begin[nodes]);
    std::vector<std::size_t> next(begin.begin(), begin.end() - 1);
    for (std::size_t k = 0; k < corner.size(); ++k)
        if (corner[k].weight > 0) member[next[corner[k].node]++] = {static_cast<Index>(k / kCorners), corner[k].weight};
}

/// How one stencil depends on the displacements of the nodes about it.
struct Seen {
    std::vector<Index> node;
    std::vector<Vec3d> moment;   // q_n = sum_j w_ij (N_n(j) - N_n(i)) r_ij
    std::vector<Vec3d> slope;    // g_n = A+ q_n: H = sum_n U_n g_n^T
    std::vector<double> square;  // sum_j w_ij (N_n(j) - N_n(i)) (N_m(j) - N_m(i)), n m
    std::size_t find(Index n) {
        for (std::size_t k = 0; k < node.size(); ++k)
            if (node[k] == n) return k;
        node.push_back(n);
        return node.size() - 1;
    }
};

void see(const Elements& e, const std::vector<Corner>& corner, std::size_t i, Seen& seen) {
    seen.node.clear();
    const auto corners = [&](std::size_t j) { return corner.data() + kCorners * j; };
    const Corner* own = corners(i);
    for (std::size_t k = e.bonds.begin[i]; k < e.bonds.begin[i + 1]; ++k)
        for (std::size_t c = 0; c < kCorners; ++c)
            if (corners(e.bonds.neighbour[k])[c].weight > 0) seen.find(corners(e.bonds.neighbour[k])[c].node);
    for (std::size_t c = 0; c < kCorners; ++c)
        if (own[c].weight > 0) seen.find(own[c].node);
    const std::size_t n = seen.node.size();
    seen.moment.assign(n, Vec3d::Zero());
    seen.square.assign(n * n, 0);
    std::vector<double> difference(n);
    for (std::size_t k = e.bonds.begin[i]; k < e.bonds.begin[i + 1]; ++k) {
        const double w = static_cast<double>(e.bonds.weight[k]);
        if (!(w > 0)) continue;
        const Index j = e.bonds.neighbour[k];
        std::fill(difference.begin(), difference.end(), 0.0);
        for (std::size_t c = 0; c < kCorners; ++c) {
            if (corners(j)[c].weight > 0)
                difference[seen.find(corners(j)[c].node)] += static_cast<double>(corners(j)[c].weight);
            if (own[c].weight > 0) difference[seen.find(own[c].node)] -= static_cast<double>(own[c].weight);
        }
        const Vec3d r = bond_vector(e, i, k);
        for (std::size_t a = 0; a < n; ++a) {
            if (difference[a] == 0) continue;
            seen.moment[a] += w * difference[a] * r;
            for (std::size_t b = 0; b < n; ++b) seen.square[a * n + b] += w * difference[a] * difference[b];
        }
    }
    const Mat3d inverse = matrix(e.bonds.moment[i].inverse).cast<double>();
    seen.slope.resize(n);
    for (std::size_t a = 0; a < n; ++a) seen.slope[a] = inverse * seen.moment[a];
}

/// Adds the stencil's stiffness to the blocks of all pairs of its nodes.
void add_stencil(const StressLaw& law, const Elements& e, std::size_t i, bool zero_energy, const Lattice& lattice,
                 const Seen& seen, Blocks& to) {
    const std::size_t n = seen.node.size();
    for (std::size_t b = 0; b < n; ++b) {
        std::array<Mat3d, 3> change;
        for (int a = 0; a < 3; ++a)
            change[static_cast<std::size_t>(a)] =
                static_cast<double>(e.quadrature[i]) *
                stress_change_at_rest(law, e, i, Vec3::Unit(a) * seen.slope[b].cast<Real>().transpose()).cast<double>();
        for (std::size_t a = 0; a < n; ++a) {
            Mat3d& block = to.at(lattice, seen.node[a], seen.node[b]);
            for (int c = 0; c < 3; ++c) block.col(c) += change[static_cast<std::size_t>(c)] * seen.slope[a];
            if (zero_energy)
                block.diagonal().array() +=
                    static_cast<double>(e.rest[i].w) * (seen.square[a * n + b] - seen.moment[a].dot(seen.slope[b]));
        }
    }
}

Sparse sparse(const Blocks& blocks, const std::vector<Lattice>& lattices, std::size_t nodes) {
    std::vector<Eigen::Triplet<double>> list;
    for (const Lattice& lattice : lattices)
        for (std::size_t row = lattice.first; row < lattice.first + lattice.nodes(); ++row)
            for (int k = 0; k < kSlots; ++k) {
                const Index at = blocks.slot[row * std::size_t(kSlots) + static_cast<std::size_t>(k)];
                if (at == kNone) continue;
                const int dx = k % kSide - kReach, dy = k / kSide % kSide - kReach, dz = k / kSide / kSide - kReach;
                const auto column = static_cast<std::size_t>(static_cast<int>(row) +
                                                             (dz * lattice.count[1] + dy) * lattice.count[0] + dx);
                for (int a = 0; a < 3; ++a)
                    for (int b = 0; b < 3; ++b)
                        list.emplace_back(static_cast<int>(3 * row) + a, static_cast<int>(3 * column) + b,
                                          blocks.block[at](a, b));
            }
    const int n = static_cast<int>(3 * nodes);
    for (int k = 0; k < n; ++k) list.emplace_back(k, k, 0.0);  // the diagonal is there, whatever is on it
    Sparse out(n, n);
    out.setFromTriplets(list.begin(), list.end());
    return out;
}

/// Adds N^T B N for blocks B on the diagonal.
template <class F>
void add_elements(const Lattice& lattice, const SolidBody& body, const std::vector<Corner>& corner, F&& block,
                  Blocks& to) {
    if (!(lattice.cell > 0)) return;
    for (const Index i : body.elements) {
        const Mat3d b = block(i);
        if (b.isZero(0)) continue;
        const Corner* own = corner.data() + kCorners * i;
        for (std::size_t c = 0; c < kCorners; ++c)
            for (std::size_t d = 0; d < kCorners; ++d)
                if (own[c].weight * own[d].weight > 0)
                    to.at(lattice, own[c].node, own[d].node) += static_cast<double>(own[c].weight * own[d].weight) * b;
    }
}

}  // namespace

void CoarseGrid::prepare(const std::vector<StressLaw>& laws, const std::vector<SolidBody>& bodies, const Elements& e,
                         const std::vector<std::uint8_t>& held) {
    if (state_ && state_->version == e.bonds.weights_version && state_->held == held) return;
    state_ = std::make_shared<State>();
    State& state = *state_;
    state.version = e.bonds.weights_version;
    state.held = held;
    for (const SolidBody& body : bodies) {
        state.lattice.push_back(lattice_of(body, e, state.nodes));
        state.nodes += state.lattice.back().nodes();
    }
    if (state.nodes == 0) return;
    state.corner.assign(kCorners * e.size(), {});
    for (std::size_t b = 0; b < bodies.size(); ++b) place_corners(state.lattice[b], bodies[b], e, held, state.corner);
    list_members(state.corner, state.nodes, state.begin, state.member);
    std::vector<StressLaw> rates;
    bool viscous = false;
    for (const StressLaw& law : laws) {
        rates.push_back({.mu = law.viscosity});
        viscous = viscous || law.viscosity > 0;
    }
    Blocks elastic, viscosity, mass;
    for (Blocks* b : {&elastic, &viscosity, &mass}) b->start(state.nodes);
    Seen seen;
    for (std::size_t b = 0; b < bodies.size(); ++b) {
        const Lattice& lattice = state.lattice[b];
        if (!(lattice.cell > 0)) continue;
        for (const Index i : bodies[b].elements) {
            see(e, state.corner, i, seen);
            add_stencil(laws[e.law_of(i)], e, i, true, lattice, seen, elastic);
            if (viscous) add_stencil(rates[e.law_of(i)], e, i, false, lattice, seen, viscosity);
        }
        add_elements(
            lattice, bodies[b], state.corner,
            [&](std::size_t i) { return Mat3d(static_cast<double>(e.mass[i]) * Mat3d::Identity()); }, mass);
    }
    state.elastic = sparse(elastic, state.lattice, state.nodes);
    state.viscous = sparse(viscosity, state.lattice, state.nodes);
    state.mass = sparse(mass, state.lattice, state.nodes);
    state.matrix = state.elastic + state.viscous + state.mass;
    state.factor.analyzePattern(state.matrix);
    state.right.resize(static_cast<Eigen::Index>(3 * state.nodes));
    state.bodies = bodies;
}

void CoarseGrid::factor(double dt, const std::vector<Symmetric>& boundary) {
    State& state = *state_;
    if (state.nodes == 0 || (state.usable && state.dt == dt && !state.bounded && boundary.empty())) return;
    state.dt = dt;
    state.bounded = !boundary.empty();
    state.matrix = state.elastic + (1 / dt) * state.viscous + (1 / square(dt)) * state.mass;
    if (state.bounded) {
        Blocks walls;
        walls.start(state.nodes);
        for (std::size_t b = 0; b < state.lattice.size(); ++b)
            add_elements(
                state.lattice[b], state.bodies[b], state.corner,
                [&](std::size_t i) { return Mat3d(matrix(boundary[i]).cast<double>()); }, walls);
        state.matrix += sparse(walls, state.lattice, state.nodes);
    }
    state.usable = false;
    for (double shift = kShift; !state.usable && shift <= kMostShift; shift *= 10) {
        for (Eigen::Index k = 0; k < state.matrix.rows(); ++k) {
            double& d = state.matrix.coeffRef(k, k);
            d = d > 0 ? (1 + shift) * d : 1;
        }
        state.factor.factorize(state.matrix);
        state.usable = state.factor.info() == Eigen::Success;
    }
}

void CoarseGrid::add_correction(const std::vector<Vec3>& r, std::vector<Vec3>& z) {
    State& state = *state_;
    if (!state.usable) return;
    parallel_for(
        state.nodes,
        [&](std::size_t n) {
            Vec3d sum(0, 0, 0);
            for (std::size_t k = state.begin[n]; k < state.begin[n + 1]; ++k)
                sum += static_cast<double>(state.member[k].second) * r[state.member[k].first].cast<double>();
            state.right.segment<3>(static_cast<Eigen::Index>(3 * n)) = sum;
        },
        64);
    state.left = state.factor.solve(state.right);
    parallel_for(
        z.size(),
        [&](std::size_t i) {
            Vec3d sum(0, 0, 0);
            for (std::size_t c = 0; c < kCorners; ++c) {
                const Corner& at = state.corner[kCorners * i + c];
                sum += static_cast<double>(at.weight) * state.left.segment<3>(3 * static_cast<Eigen::Index>(at.node));
            }
            z[i] += sum.cast<Real>();
        },
        1024);
}

std::size_t CoarseGrid::nodes() const { return state_ ? state_->nodes : 0; }

std::size_t CoarseGrid::bytes() const {
    if (nodes() == 0) return 0;
    const State& state = *state_;
    constexpr std::size_t kEntry = sizeof(double) + sizeof(int);
    std::size_t entries = static_cast<std::size_t>(state.elastic.nonZeros() + state.viscous.nonZeros() +
                                                   state.mass.nonZeros() + state.matrix.nonZeros());
    entries += static_cast<std::size_t>(state.factor.matrixL().nestedExpression().nonZeros());
    return entries * kEntry + state.corner.size() * sizeof(Corner) + state.member.size() * sizeof(state.member[0]);
}

}  // namespace thixo
