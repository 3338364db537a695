// A whole picture: 500 000 matt surfels (a wavy sheet, a ball over it) in sun and sky, 640 x 360 pixels, 16 samples, on
// all threads. Prints the seconds from the surfels in memory to the finished image, and the peak of memory.
// `picture_bench FILE.png` also writes the picture.
#include <fmt/core.h>
#include <sys/resource.h>

#include "pipeline/base/timer.h"
#include "pipeline/contract/image.h"
#include "render/film.h"
#include "render/view_transform.h"
#include "tests/bench/ray_sets.h"

namespace {

using namespace thixo;
using namespace thixo::render;

void light(World& world) {
    scene::Light sun, sky;
    sun.type = scene::LightType::sun;
    sun.strength = 2.5;
    sun.direction = {0.5, 0.6, -1};
    sun.angle = 5;
    sky.strength = 0.6;
    world.lights = {make_light(sun), make_light(sky)};
}

}  // namespace

int main(int argc, char** argv) {
    SurfelSet set = shapes::one_object(bench::sheet_and_ball(500000));
    set.cloud.normal = std::vector<Vec3f>();  // the renderer takes it from the axes
    const std::size_t n = set.cloud.size();
    const double begin = wall_seconds();
    World world;
    scene::Appearance matt;
    world.materials.push_back(make_material(matt));
    world.material_of = {0};
    light(world);
    world.settings.max_bounces = 4;  // the default of Cycles for matt surfaces
    world.rays = std::make_unique<RayScene>(std::move(set), std::vector<MeshObject>());
    scene::Camera camera;
    camera.position = {0, -2.6, 1.5};
    camera.look_at = {0, 0, 0.15};
    camera.fov = 45;
    world.camera = camera_at(camera, 0, 640, 360);
    const double ready = wall_seconds() - begin;
    FilmSettings film;
    film.samples = 16;
    const Image image = render::render(world, film);
    const double seconds = wall_seconds() - begin;
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    fmt::print("{} surfels, 640 x 360, 16 samples: ready in {:.3f} s, picture in {:.2f} s, peak {:.0f} MB\n", n, ready,
               seconds, double(usage.ru_maxrss) * 1024e-6);
    if (argc > 1) write_png(argv[1], to_display(image, scene::ViewTransform::filmic, 0));
}
