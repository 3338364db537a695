#include "render/materials/albedo_table.h"

namespace thixo::render {

Vec2f lattice(int i, int n) {
    const double g = double(i) * 0.6180339887498949;
    return {float((i + 0.5) / n), float(g - std::floor(g))};
}

void add_mean(AlbedoTable& table) {
    double sum = 0;
    const double step = 1.0 / AlbedoTable::kSteps;
    for (int k = 0; k < AlbedoTable::kSteps; ++k) {
        const double a = table.at[k], b = table.at[k + 1], m = k * step;
        sum += 2 * step * (0.5 * m * (a + b) + step * (a / 6 + b / 3));
    }
    table.mean = float(sum);
}

}  // namespace thixo::render
