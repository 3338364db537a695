#include "render/noise.h"

namespace thixo::render {

Vec3f bumped_normal(const Bump& bump, const Hit& hit) {
    const NoiseSample noise = fractal_noise(hit.attributes.rest / bump.scale, bump.octaves);
    const Vec3f gradient = bump.amplitude / bump.scale * noise.gradient;
    Vec3f a, b;
    orthonormal_basis(hit.normal, a, b);
    const Vec3f n =
        (hit.normal - gradient.dot(hit.attributes.rest_a) * a - gradient.dot(hit.attributes.rest_b) * b).normalized();
    return n.dot(hit.geometric) > 0.05f ? n : hit.normal;
}

}  // namespace thixo::render
