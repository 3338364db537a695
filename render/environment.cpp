#include "render/environment.h"

#include <algorithm>

#include "pipeline/base/error.h"
#include "pipeline/base/parallel.h"

namespace thixo::render {
namespace {

/// The cell whose part of [0, 1) holds u, of those with a part; u becomes the place in it.
int choose(const float* ends, int count, float& u) {
    int i = int(std::upper_bound(ends, ends + count, u) - ends);
    // Rounding may leave the last end below one: then the last cell with a part takes the rest.
    if (i == count) i = int(std::lower_bound(ends, ends + count, ends[count - 1]) - ends);
    const float begin = i > 0 ? ends[i - 1] : 0;
    u = std::clamp((u - begin) / (ends[i] - begin), 0.0f, 0x1.fffffep-1f);
    return i;
}

}  // namespace

Environment::Environment(int width, int height, std::vector<Vec3f> radiance)
    : width_(width), height_(height), radiance_(std::move(radiance)) {
    THIXO_ASSERT(width > 0 && height > 0 && radiance_.size() == std::size_t(width) * std::size_t(height),
                 "{} values for {} x {} texels", radiance_.size(), width, height);
    for (int row = 0; row <= height; ++row) edge_.push_back(float(std::cos(kPi * row / height)));
    make_distribution();
}

const Vec3f& Environment::at(int column, int row) const {
    column = column < 0 ? column + width_ : column >= width_ ? column - width_ : column;
    row = std::clamp(row, 0, height_ - 1);
    return radiance_[std::size_t(row) * std::size_t(width_) + std::size_t(column)];
}

void Environment::make_distribution() {
    column_end_.resize(radiance_.size());
    std::vector<double> weight(static_cast<std::size_t>(height_));
    std::vector<Vec3d> mean(weight.size());
    parallel_for(weight.size(), [&](std::size_t r) {
        const int row = int(r);
        float* const ends = column_end_.data() + r * std::size_t(width_);
        const double share = 0.5 * double(edge_[r] - edge_[r + 1]) / width_;  // of the sphere
        double sum = 0;
        Vec3d light = Vec3d::Zero();
        // The mean of a bilinear function over a texel takes 3/4 of it and 1/8 of its neighbours, both ways.
        const auto across = [&](int column) {
            return Vec3f(0.125f * at(column, row - 1) + 0.75f * at(column, row) + 0.125f * at(column, row + 1));
        };
        std::vector<double> cell(static_cast<std::size_t>(width_));
        Vec3f before = across(-1), here = across(0);
        for (int column = 0; column < width_; ++column) {
            const Vec3f after = across(column + 1);
            const Vec3f c = 0.125f * before + 0.75f * here + 0.125f * after;
            light += c.cast<double>();
            sum += cell[std::size_t(column)] = double(luminance(c));
            before = here;
            here = after;
        }
        double so_far = 0;
        for (int column = 0; column < width_; ++column)
            ends[column] = sum > 0 ? float((so_far += cell[std::size_t(column)]) / sum) : 0.0f;
        weight[r] = sum * share;
        mean[r] = light * share;
    });
    double total = 0, so_far = 0;
    Vec3d light = Vec3d::Zero();
    for (std::size_t r = 0; r < weight.size(); ++r) {
        total += weight[r];
        light += mean[r];
    }
    mean_ = light.cast<float>();
    for (const double w : weight) row_end_.push_back(total > 0 ? float((so_far += w) / total) : 0.0f);
}

Environment::Place Environment::place(const Vec3f& d) const {
    const float u = 0.5f - std::atan2(d.y(), d.x()) / (2 * kPif), v = std::acos(std::clamp(d.z(), -1.0f, 1.0f)) / kPif;
    return {u * float(width_), v * float(height_)};
}

Vec3f Environment::radiance(const Vec3f& direction) const {
    const Place p = place(direction);
    const float x = p.column - 0.5f, y = p.row - 0.5f;
    const int column = int(std::floor(x)), row = int(std::floor(y));
    const float s = x - float(column), t = y - float(row);
    return (1 - t) * ((1 - s) * at(column, row) + s * at(column + 1, row)) +
           t * ((1 - s) * at(column, row + 1) + s * at(column + 1, row + 1));
}

float Environment::cell_share(int column, int row) const {
    const float* const ends = column_end_.data() + std::size_t(row) * std::size_t(width_);
    const float rows = row_end_[std::size_t(row)] - (row > 0 ? row_end_[std::size_t(row) - 1] : 0.0f),
                columns = ends[column] - (column > 0 ? ends[column - 1] : 0.0f);
    return rows * columns;
}

Environment::Sample Environment::sample(const Vec2f& u) const {
    if (!(row_end_.back() > 0)) return {};
    float along = u.x(), down = u.y();
    const int row = choose(row_end_.data(), height_, down);
    const int column = choose(column_end_.data() + std::size_t(row) * std::size_t(width_), width_, along);
    const float top = edge_[std::size_t(row)], bottom = edge_[std::size_t(row) + 1];
    const float z = top + down * (bottom - top), r = std::sqrt(std::max(0.0f, 1 - z * z));
    const float phi = 2 * kPif * (0.5f - (float(column) + along) / float(width_));
    return {{r * std::cos(phi), r * std::sin(phi), z},
            cell_share(column, row) * float(width_) / (2 * kPif * (top - bottom))};
}

float Environment::pdf(const Vec3f& direction) const {
    const Place p = place(direction);
    const int column = std::min(int(p.column), width_ - 1);
    // The row by its edges, as it is sampled: acos is coarse at the poles.
    const auto below = std::lower_bound(edge_.begin(), edge_.end(), direction.z(), std::greater<float>());
    const int row = std::clamp(int(below - edge_.begin()) - 1, 0, height_ - 1);
    return cell_share(std::max(column, 0), row) * float(width_) /
           (2 * kPif * (edge_[std::size_t(row)] - edge_[std::size_t(row) + 1]));
}

}  // namespace thixo::render
