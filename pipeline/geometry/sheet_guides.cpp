#include "pipeline/geometry/sheet_guides.h"

#include <algorithm>
#include <limits>
#include <optional>

#include "pipeline/base/log.h"
#include "pipeline/base/parallel.h"
#include "pipeline/geometry/point_grid.h"

namespace thixo {
namespace {

constexpr int kRounds = 4;
constexpr std::size_t kMostProbes = 30000;
constexpr Real kFar = std::numeric_limits<Real>::max();

/// For faces without surfels: the side on which the surfels of all other faces lie, if it is one side.
using Sides = std::vector<std::optional<bool>>;

/// The side of a sheet from its nearest surfel. Trimming uses this far from the sheet.
class NearestPlane {
  public:
    NearestPlane(const Sheet& sheet, Real extent) : sheet_(sheet), extent_(extent) {
        const std::size_t n = sheet.position.size();
        if (n == 0) return;
        flat_ = std::all_of(sheet.normal.begin(), sheet.normal.end(),
                            [&](const Vec3& normal) { return (normal - sheet.normal[0]).squaredNorm() < Real(1e-10); });
        if (!flat_) grid_.build(sheet.position, extent / 24);
    }
    Real distance(const Vec3& x) const {
        if (sheet_.position.empty()) return kFar;
        if (flat_) return sheet_.normal[0].dot(x - sheet_.position[0]);
        std::vector<std::pair<Real, Index>> found;
        grid_.nearest(x, 1, 4 * extent_, found);
        const Index i = found.empty() ? 0 : found[0].second;
        return sheet_.normal[i].dot(x - sheet_.position[i]);
    }

  private:
    const Sheet& sheet_;
    Real extent_;
    bool flat_ = false;
    PointGrid grid_;
};

struct Probe {
    int sheet;
    Vec3 x;
};

std::vector<Probe> probes_of(const std::vector<Sheet>& sheets) {
    std::size_t total = 0, count = 0;
    for (const Sheet& sheet : sheets) total += sheet.position.size();
    const std::size_t stride = total / kMostProbes + 1;
    std::vector<Probe> probes;
    for (std::size_t k = 0; k < sheets.size(); ++k)
        for (const Vec3& x : sheets[k].position)
            if (count++ % stride == 0) probes.push_back({static_cast<int>(k), x});
    return probes;
}

/// The foot point on the face of a place far from it.
bool foot_point(const Face& face, Real spacing, Vec3& x, Vec3& normal) {
    for (int i = 0; i < 100; ++i) {
        const Real d = face.distance(x);
        if (std::abs(d) < spacing) break;
        x -= d * face.gradient(x, Real(0.05) * spacing);
    }
    return project_onto(face, spacing, x, normal);
}

/// The sheets whose surfels put the probe on the wrong side, so that it is wrongly kept or wrongly cut.
std::vector<int> misled(const FacedSolid& solid, const std::vector<NearestPlane>& planes, const Sides& sides,
                        const Probe& p, Real spacing) {
    const Real tolerance = Real(1e-3) * spacing;
    const auto exact = [&](int k) { return solid.faces[static_cast<std::size_t>(k)].distance(p.x); };
    const auto seen = [&](int k) {
        const auto& side = sides[static_cast<std::size_t>(k)];
        return side ? (*side ? -kFar : kFar) : planes[static_cast<std::size_t>(k)].distance(p.x);
    };
    if (bounds_solid(solid.tree, p.sheet, tolerance, exact) == bounds_solid(solid.tree, p.sheet, tolerance, seen))
        return {};
    std::vector<int> wrong;
    for (int k = 0; k < static_cast<int>(planes.size()); ++k) {
        if (k == p.sheet) continue;
        const Real d = exact(k);
        if (std::abs(d) > Real(0.5) * spacing && (seen(k) < 0) != (d < 0)) wrong.push_back(k);
    }
    return wrong;
}

/// One round of additions. Returns the number of probes that are still on a wrong side.
std::size_t add_guides(const FacedSolid& solid, std::vector<Sheet>& sheets, const Sides& sides, Real spacing,
                       Real extent) {
    std::vector<NearestPlane> planes;
    planes.reserve(sheets.size());
    for (const Sheet& sheet : sheets) planes.emplace_back(sheet, extent);
    const std::vector<Probe> probes = probes_of(sheets);
    std::vector<std::vector<int>> wrong(probes.size());
    parallel_for(probes.size(), [&](std::size_t i) { wrong[i] = misled(solid, planes, sides, probes[i], spacing); });
    std::vector<Sheet> guides(sheets.size());
    std::size_t count = 0;
    for (std::size_t i = 0; i < probes.size(); ++i) {
        count += !wrong[i].empty();
        for (const int k : wrong[i]) {
            const std::size_t number = static_cast<std::size_t>(k);
            Vec3 x = probes[i].x, normal;
            if (!foot_point(solid.faces[number], spacing, x, normal)) continue;
            const auto near = [&](const Vec3& y) { return (x - y).squaredNorm() < square(spacing); };
            if (std::any_of(guides[number].position.begin(), guides[number].position.end(), near)) continue;
            guides[number].position.push_back(x);
            guides[number].normal.push_back(normal);
        }
    }
    for (std::size_t number = 0; number < sheets.size(); ++number) {
        Sheet &to = sheets[number], &from = guides[number];
        to.position.insert(to.position.end(), from.position.begin(), from.position.end());
        to.normal.insert(to.normal.end(), from.normal.begin(), from.normal.end());
    }
    return count;
}

/// The side of an empty sheet's face on which all surfels lie; none where they lie on both.
std::optional<bool> common_side(const Face& face, const std::vector<Sheet>& sheets) {
    std::optional<bool> side;
    for (const Sheet& sheet : sheets)
        for (const Vec3& x : sheet.position) {
            const bool inside = face.distance(x) < 0;
            if (side && *side != inside) return std::nullopt;
            side = inside;
        }
    return side;
}

/// The tree with constants in place of some faces: a tree, everything, or nothing.
struct Reduced {
    std::optional<bool> constant;
    SheetTree tree;
};
Reduced reduce(const FaceTree& tree, const Sides& sides, const std::vector<int>& number) {
    if (tree.op == FaceTree::Op::face) {
        const std::size_t k = static_cast<std::size_t>(tree.number);
        if (number[k] < 0) return {*sides[k], {}};
        return {std::nullopt, {SheetTree::Op::sheet, number[k], {}}};
    }
    const bool any = tree.op == FaceTree::Op::any;
    SheetTree result{any ? SheetTree::Op::any : SheetTree::Op::all};
    for (const FaceTree& part : tree.parts) {
        Reduced r = reduce(part, sides, number);
        if (r.constant == any) return {any, {}};
        if (!r.constant) result.parts.push_back(std::move(r.tree));
    }
    if (result.parts.empty()) return {!any, {}};
    return {std::nullopt, result.parts.size() == 1 ? std::move(result.parts[0]) : std::move(result)};
}

}  // namespace

SheetTree settle_sheets(const FacedSolid& solid, std::vector<Sheet>& sheets, Real spacing, std::vector<int>& number) {
    const Real extent = (solid.bounds.upper - solid.bounds.lower).maxCoeff();
    Sides sides(sheets.size());
    for (std::size_t k = 0; k < sheets.size(); ++k)
        if (sheets[k].position.empty()) sides[k] = common_side(solid.faces[k], sheets);
    std::size_t wrong = 1;
    for (int round = 0; round < kRounds && wrong > 0 && !solid.single(); ++round)
        wrong = add_guides(solid, sheets, sides, spacing, extent);
    if (wrong > 0 && !solid.single())
        log_warning("sharp edges of a sampled shape: its sheets contradict each other at {} surfels", wrong);
    number.assign(sheets.size(), -1);
    int next = 0;
    for (std::size_t k = 0; k < sheets.size(); ++k)
        if (sheets[k].position.empty())
            sides[k] = sides[k].value_or(true);  // no kept surfel depends on it, or the sheet would have got surfels
        else
            number[k] = next++;
    return reduce(solid.tree, sides, number).tree;
}

}  // namespace thixo
