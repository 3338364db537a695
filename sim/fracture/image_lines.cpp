#include "sim/fracture/image_lines.h"

#include <algorithm>
#include <array>
#include <numeric>

namespace thixo {
namespace {

struct Pixel {
    int x = 0, y = 0;
    bool operator==(const Pixel&) const = default;
};

/// The eight pixels about one, clockwise from the one above: P2 to P9 of the paper.
constexpr std::array<Pixel, 8> kAround{{{0, -1}, {1, -1}, {1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}}};

std::size_t row_of(const LineMask& mask, const Pixel& p) {
    return static_cast<std::size_t>(p.y) * static_cast<std::size_t>(mask.width) + static_cast<std::size_t>(p.x);
}
std::array<bool, 8> around(const LineMask& mask, const Pixel& p) {
    std::array<bool, 8> dark{};
    for (std::size_t k = 0; k < 8; ++k) dark[k] = mask.at(p.x + kAround[k].x, p.y + kAround[k].y);
    return dark;
}
template <class F>
void for_each_dark(const LineMask& mask, F&& f) {
    for (int y = 0; y < mask.height; ++y)
        for (int x = 0; x < mask.width; ++x)
            if (mask.at(x, y)) f(Pixel{x, y});
}

/// The two conditions of the paper that hold in both of its passes. A pixel has two to six dark neighbours, and around it
/// there is one change from light to dark.
bool is_border(const std::array<bool, 8>& n) {
    const auto dark = std::ranges::count(n, true);
    int changes = 0;
    for (std::size_t k = 0; k < 8; ++k) changes += !n[k] && n[(k + 1) % 8] ? 1 : 0;
    return dark >= 2 && dark <= 6 && changes == 1;
}

/// One pass. The first takes pixels off the lower right side and corners of the upper left, the second the others.
bool thin_once(LineMask& mask, bool second) {
    std::vector<std::size_t> gone;
    for_each_dark(mask, [&](const Pixel& p) {
        const std::array<bool, 8> n = around(mask, p);
        const bool above = n[0], right = n[2], below = n[4], left = n[6];
        const bool side = second ? !(above && right && left) && !(above && below && left)
                                 : !(above && right && below) && !(right && below && left);
        if (side && is_border(n)) gone.push_back(row_of(mask, p));
    });
    for (const std::size_t row : gone) mask.dark[row] = 0;
    return !gone.empty();
}

/// Takes out corners of stairs. They have a neighbour above or below, and one at their left or right. On the other sides
/// they have none.
void take_out_stairs(LineMask& mask) {
    for_each_dark(mask, [&](const Pixel& p) {
        const std::array<bool, 8> n = around(mask, p);
        for (std::size_t k = 0; k < 8; k += 2) {
            const auto at = [&](std::size_t turn) { return n[(k + turn) % 8]; };
            if (at(0) && at(2) && !at(4) && !at(5) && !at(6)) {
                mask.dark[row_of(mask, p)] = 0;
                return;
            }
        }
    });
}

/// The pixels of a thinned picture as a graph. Two that touch at a corner are joined only where no pixel beside both is
/// dark: a way then goes by that one.
class PixelGraph {
  public:
    explicit PixelGraph(const LineMask& mask) : mask_(mask), junction_(mask.dark.size(), -1) {
        for_each_dark(mask, [&](const Pixel& p) {
            if (joined(p).size() < 3 || junction_[row_of(mask_, p)] >= 0) return;
            gather(p);
        });
    }

    std::vector<Pixel> joined(const Pixel& p) const {
        const std::array<bool, 8> n = around(mask_, p);
        std::vector<Pixel> out;
        for (std::size_t k = 0; k < 8; ++k) {
            const bool corner = k % 2 == 1;
            if (n[k] && !(corner && (n[k - 1] || n[(k + 1) % 8])))
                out.push_back({p.x + kAround[k].x, p.y + kAround[k].y});
        }
        return out;
    }
    std::size_t row(const Pixel& p) const { return row_of(mask_, p); }
    int junction(const Pixel& p) const { return junction_[row(p)]; }
    const std::vector<std::vector<Pixel>>& junctions() const { return members_; }
    /// Where a line through this pixel goes: its middle, or that of its junction.
    Vec2d place(const Pixel& p) const {
        const auto middle = [](const Pixel& q) { return Vec2d(q.x + 0.5, q.y + 0.5); };
        const int j = junction(p);
        if (j < 0) return middle(p);
        const std::vector<Pixel>& members = members_[static_cast<std::size_t>(j)];
        Vec2d sum(0, 0);
        for (const Pixel& q : members) sum += middle(q);
        return sum / static_cast<double>(members.size());
    }

  private:
    void gather(const Pixel& first) {
        const auto number = static_cast<int>(members_.size());
        std::vector<Pixel>& members = members_.emplace_back();
        const auto take = [&](const Pixel& p) {
            junction_[row_of(mask_, p)] = number;
            members.push_back(p);
        };
        take(first);
        for (std::size_t k = 0; k < members.size(); ++k)
            for (const Pixel& q : joined(Pixel(members[k])))
                if (junction_[row_of(mask_, q)] < 0 && joined(q).size() >= 3) take(q);
    }

    const LineMask& mask_;
    std::vector<int> junction_;  // of each pixel; -1: none
    std::vector<std::vector<Pixel>> members_;
};

/// A branch as pixels, with both of its ends.
struct Branch {
    std::vector<Pixel> pixels;
    bool ring = false;
};

/// Goes on from `from` over `to` up to an end or a junction, and marks the pixels between.
Branch walk(const PixelGraph& graph, const Pixel& from, const Pixel& to, std::vector<std::uint8_t>& seen) {
    Branch branch{{from, to}};
    while (true) {
        const Pixel here = branch.pixels.back(), before = branch.pixels[branch.pixels.size() - 2];
        const std::vector<Pixel> next = graph.joined(here);
        if (graph.junction(here) >= 0 || next.size() < 2) return branch;
        seen[graph.row(here)] = 1;
        const Pixel& ahead = next[next[0] == before ? 1 : 0];
        branch.pixels.push_back(ahead);
        if (ahead == branch.pixels.front() && graph.junction(ahead) < 0) {
            branch.ring = true;
            return branch;
        }
    }
}

std::vector<Branch> branches_of(const LineMask& mask, const PixelGraph& graph) {
    std::vector<Branch> branches;
    std::vector<std::uint8_t> seen(mask.dark.size(), 0);
    // From junctions: a way that ends at one is found from both of its ends, and walked once.
    for (const std::vector<Pixel>& members : graph.junctions())
        for (const Pixel& from : members)
            for (const Pixel& to : graph.joined(from)) {
                if (graph.junction(to) == graph.junction(from) || seen[graph.row(to)]) continue;
                if (graph.junction(to) >= 0 && graph.junction(to) < graph.junction(from)) continue;
                branches.push_back(walk(graph, from, to, seen));
                seen[graph.row(branches.back().pixels.back())] = graph.junction(branches.back().pixels.back()) < 0;
            }
    // Lines between two free ends, then rings, which have none.
    for (const bool rings : {false, true})
        for_each_dark(mask, [&](const Pixel& p) {
            const std::vector<Pixel> next = graph.joined(p);
            if (seen[graph.row(p)] || graph.junction(p) >= 0 || next.size() != (rings ? 2u : 1u)) return;
            seen[graph.row(p)] = 1;
            branches.push_back(walk(graph, p, next[0], seen));
            seen[graph.row(branches.back().pixels.back())] = 1;
        });
    return branches;
}

double length_of(const PixelLine& line) {
    double length = 0;
    for (std::size_t k = 1; k < line.size(); ++k) length += (line[k] - line[k - 1]).norm();
    return length;
}

PixelLine line_of(const Branch& branch, const PixelGraph& graph) {
    PixelLine line;
    for (const Pixel& p : branch.pixels) line.push_back(graph.place(p));
    return line;
}

/// Takes the pixels of spurs out; whether there were any.
bool take_out_spurs(double shortest, LineMask& mask) {
    const PixelGraph graph(mask);
    std::vector<std::size_t> gone;
    for (const Branch& branch : branches_of(mask, graph)) {
        const bool spur = graph.junction(branch.pixels.front()) >= 0 && graph.junction(branch.pixels.back()) < 0;
        if (!spur || branch.ring || length_of(line_of(branch, graph)) >= shortest) continue;
        for (const Pixel& p : branch.pixels)
            if (graph.junction(p) < 0) gone.push_back(graph.row(p));
    }
    for (const std::size_t row : gone) mask.dark[row] = 0;
    return !gone.empty();
}

}  // namespace

LineMask thinned(LineMask mask) {
    bool thinner = true;
    while (thinner) {
        const bool first = thin_once(mask, false);
        thinner = thin_once(mask, true) || first;
    }
    take_out_stairs(mask);
    return mask;
}

std::vector<PixelLine> trace_lines(const LineMask& thin, double shortest) {
    LineMask mask = thin;
    while (take_out_spurs(shortest, mask)) take_out_stairs(mask);
    const PixelGraph graph(mask);
    std::vector<PixelLine> lines;
    for (const Branch& branch : branches_of(mask, graph)) lines.push_back(line_of(branch, graph));
    return lines;
}

PixelLine simplified(const PixelLine& line, double off) {
    std::vector<std::uint8_t> kept(line.size(), 0);
    std::vector<std::pair<std::size_t, std::size_t>> parts;
    const auto keep = [&](std::size_t k) { kept[k] = 1; };
    const auto farthest = [&](std::size_t a, std::size_t b) {
        std::pair<std::size_t, double> most{a, -1};
        for (std::size_t k = a + 1; k < b; ++k) {
            const Vec2d along = line[b] - line[a];
            const double part = along.squaredNorm() > 0
                                    ? std::clamp((line[k] - line[a]).dot(along) / along.squaredNorm(), 0.0, 1.0)
                                    : 0;
            const double d = (line[k] - line[a] - part * along).norm();
            if (d > most.second) most = {k, d};
        }
        return most;
    };
    keep(0);
    keep(line.size() - 1);
    parts.emplace_back(0, line.size() - 1);
    while (!parts.empty()) {
        const auto [a, b] = parts.back();
        parts.pop_back();
        const auto [k, d] = farthest(a, b);
        if (!(d > off)) continue;
        keep(k);
        parts.emplace_back(a, k);
        parts.emplace_back(k, b);
    }
    PixelLine out;
    for (std::size_t k = 0; k < line.size(); ++k)
        if (kept[k]) out.push_back(line[k]);
    return out;
}

}  // namespace thixo
