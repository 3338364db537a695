#include "render/denoise/regression.h"

#include "render/denoise/patch_weights.h"

namespace thixo::render {
namespace {

constexpr int kSide = 2 * kWindow + 1, kOffsets = kSide * kSide, kTile = kTileWidth * kTileHeight;
constexpr int kTerms = kFeatures + 1, kModel = 3 * kTerms;
static_assert(Planes::kBorder >= 2 * kWindow + kPatch || Planes::kBorder >= kWindow + kPatch + kFloatLanes);

constexpr float kColourWidth = 0.7f;
/// Differences of features at which two pixels have little to do with each other any more.
constexpr std::array<float, kFeatures> kFeatureWidth{0.5f, 0.5f, 0.5f, 0.6f, 0.6f, 0.6f, 0.6f, 0.2f};
/// What the fit is held to where the window says little. It is as if so many pixels, with features of size one, had
/// said that colours do not depend on features.
constexpr float kHold = 0.02f, kRelativeHold = 1e-3f;

struct Offset {
    int x, y;
    explicit Offset(int k) : x(k % kSide - kWindow), y(k / kSide - kWindow) {}
};

/// Squared distance of features, in widths.
FloatLanes feature_distance(const Planes& features, int x, int y, const Offset& o) {
    FloatLanes d{};
    for (int k = 0; k < kFeatures; ++k) {
        const FloatLanes u = lanes_at(features.at(k, x, y)) - lanes_at(features.at(k, x + o.x, y + o.y));
        d += u * u * (1 / square(kFeatureWidth[std::size_t(k)]));
    }
    return d;
}

class Fit {
  public:
    Fit(const Guides& guides, std::size_t half)
        : guides_(guides),
          width_(guides.features.width()),
          height_(guides.features.height()),
          metric_{guides.light[1 - half], guides.variance[1 - half], 0, 3, kColourWidth},
          inside_(1, width_, height_),
          data_{&guides.light[half]} {
        for (int y = 0; y < height_; ++y) std::fill_n(inside_.at(0, 0, y), width_, 1.0f);
        for (const std::array<Planes, 2>& group : guides.groups) data_.push_back(&group[half]);
        models_.assign(data_.size(), Planes(kModel, width_, height_));
    }

    void fit_models() {
        for_each_tile(width_, height_, [&](int x, int y) {
            std::vector<float> weights(std::size_t(kOffsets * kTile));
            for (int k = 0; k < kOffsets; ++k) weigh(x, y, Offset(k), Offset(k), &weights[std::size_t(k * kTile)]);
            for (std::size_t d = 0; d < data_.size(); ++d)
                for (int i = 0; i < kTile; i += kFloatLanes)
                    fit(d, x + i % kTileWidth, y + i / kTileWidth, &weights[std::size_t(i)]);
        });
    }

    std::vector<Planes> collaborate() const {
        std::vector<Planes> out(data_.size(), Planes(3, width_, height_));
        for_each_tile(width_, height_, [&](int x, int y) {
            std::vector<float> weights(std::size_t(kOffsets * kTile));
            for (int k = 0; k < kOffsets; ++k) {
                const Offset o(k);
                weigh(x - o.x, y - o.y, o, {0, 0}, &weights[std::size_t(k * kTile)]);
            }
            for (std::size_t d = 0; d < data_.size(); ++d)
                for (int i = 0; i < kTile; i += kFloatLanes)
                    gather(guides_.features, models_[d], out[d], x + i % kTileWidth, y + i / kTileWidth,
                           &weights[std::size_t(i)]);
        });
        return out;
    }

  private:
    struct Shift {
        int x, y;
        Shift(int x_, int y_) : x(x_), y(y_) {}
        Shift(const Offset& o) : x(o.x), y(o.y) {}
    };

    /// w_pq for the pixels p of a tile and q = p + o. The one of the two that may lie outside of the picture, p +
    /// `other`, then has no weight.
    void weigh(int x, int y, const Offset& o, const Shift& other, float* weights) const {
        patch_distances(metric_, x, y, o.x, o.y, weights);
        for (int i = 0; i < kTile; i += kFloatLanes) {
            const int column = x + i % kTileWidth, row = y + i / kTileWidth;
            const FloatLanes w = kernel(lanes_at(weights + i)) *
                                 kernel(feature_distance(guides_.features, column, row, o)) *
                                 lanes_at(inside_.at(0, column + other.x, row + other.y));
            put_lanes(w, weights + i);
        }
    }

    void fit(std::size_t d, int x, int y, const float* weights) {
        FloatLanes normal[kTerms][kTerms]{}, right[kTerms][3]{};
        for (int k = 0; k < kOffsets; ++k) {
            const FloatLanes w = lanes_at(weights + k * kTile);
            if (bits(w > 0) == 0) continue;
            const Offset o(k);
            FloatLanes t[kTerms], c[3];
            t[0] = float_lanes(1);
            for (int f = 0; f < kFeatures; ++f)
                t[f + 1] = lanes_at(guides_.features.at(f, x + o.x, y + o.y)) - lanes_at(guides_.features.at(f, x, y));
            for (int f = 0; f < 3; ++f) c[f] = lanes_at(data_[d]->at(f, x + o.x, y + o.y));
            for (int a = 0; a < kTerms; ++a) {
                const FloatLanes wt = w * t[a];
                for (int b = 0; b <= a; ++b) normal[a][b] = multiply_add(wt, t[b], normal[a][b]);
                for (int f = 0; f < 3; ++f) right[a][f] = multiply_add(wt, c[f], right[a][f]);
            }
        }
        for (int a = 1; a < kTerms; ++a) normal[a][a] += kRelativeHold * normal[a][a] + kHold;
        solve(normal, right);
        for (int a = 0; a < kTerms; ++a)
            for (int f = 0; f < 3; ++f) put_lanes(right[a][f], models_[d].at(3 * a + f, x, y));
    }

    /// A x = b by the Cholesky factors L D L^T of A, whose lower half is given. x takes the place of b.
    static void solve(FloatLanes (&a)[kTerms][kTerms], FloatLanes (&b)[kTerms][3]) {
        for (int j = 0; j < kTerms; ++j) {
            for (int k = 0; k < j; ++k) a[j][j] -= a[j][k] * a[j][k] * a[k][k];
            a[j][j] = larger(a[j][j], float_lanes(1e-12f));
            for (int i = j + 1; i < kTerms; ++i) {
                for (int k = 0; k < j; ++k) a[i][j] -= a[i][k] * a[j][k] * a[k][k];
                a[i][j] /= a[j][j];
            }
        }
        for (int c = 0; c < 3; ++c) {
            for (int i = 0; i < kTerms; ++i)
                for (int k = 0; k < i; ++k) b[i][c] -= a[i][k] * b[k][c];
            for (int i = 0; i < kTerms; ++i) b[i][c] /= a[i][i];
            for (int i = kTerms - 1; i >= 0; --i)
                for (int k = i + 1; k < kTerms; ++k) b[i][c] -= a[k][i] * b[k][c];
        }
    }

    /// What the windows that hold eight pixels say of them.
    static void gather(const Planes& features, const Planes& models, Planes& out, int x, int y, const float* weights) {
        FloatLanes sum[3]{}, total{};
        for (int k = 0; k < kOffsets; ++k) {
            const FloatLanes w = lanes_at(weights + k * kTile);
            if (bits(w > 0) == 0) continue;
            const Offset o(k);
            const int px = x - o.x, py = y - o.y;
            FloatLanes c[3];
            for (int f = 0; f < 3; ++f) c[f] = lanes_at(models.at(f, px, py));
            for (int a = 1; a < kTerms; ++a) {
                const FloatLanes t = lanes_at(features.at(a - 1, x, y)) - lanes_at(features.at(a - 1, px, py));
                for (int f = 0; f < 3; ++f) c[f] = multiply_add(t, lanes_at(models.at(3 * a + f, px, py)), c[f]);
            }
            total += w;
            for (int f = 0; f < 3; ++f) sum[f] = multiply_add(w, c[f], sum[f]);
        }
        for (int f = 0; f < 3; ++f) put_lanes(sum[f] / larger(total, float_lanes(1e-12f)), out.at(f, x, y));
    }

    const Guides& guides_;
    int width_, height_;
    PatchMetric metric_;
    Planes inside_;                    // 1 in the picture, 0 around it
    std::vector<const Planes*> data_;  // what is filtered
    std::vector<Planes> models_;       // of each: a_p and the rows of B_p
};

}  // namespace

std::vector<Planes> regress(const Guides& guides, int half) {
    Fit fit(guides, std::size_t(half));
    fit.fit_models();
    return fit.collaborate();
}

}  // namespace thixo::render
