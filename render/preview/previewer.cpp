#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "pipeline/base/error.h"
#include "render/preview/colour_map.h"
#include "render/preview/gl_context.h"
#include "render/preview/mesh_corners.h"
#include "render/preview/overlay.h"
#include "render/preview/preview.h"
#include "render/preview/shaders.h"

namespace thixo::preview {

namespace {

// Both keep every buffer below the 128 MB that any OpenGL 4.5 takes. Corners in sixes: whole triangles, whole lines.
constexpr std::size_t kSplatsPerDraw = std::size_t(1) << 20;
constexpr std::size_t kCornersPerDraw = 6 * kSplatsPerDraw;

using Mat4f = Eigen::Matrix4f;  // column-major, as OpenGL wants it

struct Program {
    const Gl* gl = nullptr;
    unsigned id = 0;
    void use() const { gl->UseProgram(id); }
    int at(const char* name) const { return gl->GetUniformLocation(id, name); }
    void set(const char* name, int x) const { gl->Uniform1i(at(name), x); }
    void set(const char* name, float x) const { gl->Uniform1f(at(name), x); }
    void set(const char* name, float x, float y) const { gl->Uniform2f(at(name), x, y); }
    void set(const char* name, const Vec3f& x) const { gl->Uniform3f(at(name), x.x(), x.y(), x.z()); }
    void set(const char* name, const Mat4f& m) const { gl->UniformMatrix4fv(at(name), 1, GL_FALSE, m.data()); }
};

// A colour picture, with a depth picture of its own, shared or none.
struct Target {
    unsigned framebuffer = 0, colour = 0, depth = 0;
};

struct Canvas {
    int width = 0, height = 0, samples = 0;
    Target splats, shaded, reduced;
};

struct GpuMesh {
    unsigned positions = 0, normals = 0, lines = 0;
    int corners = 0, ends = 0;
};

Mat4f eye_matrix(const View& view, const Mat3d& turn, const Vec3d& shift) {
    Mat3d axes;
    axes << view.right.transpose(), view.up.transpose(), -view.forward.transpose();
    Mat4f m = Mat4f::Identity();
    m.topLeftCorner<3, 3>() = (axes * turn).cast<float>();
    m.topRightCorner<3, 1>() = (axes * (shift - view.position)).cast<float>();
    return m;
}

Mat3d turn_of(const FrameObstacle& o) {
    const auto& t = o.transform;
    Mat3d m;
    m << t[0], t[1], t[2], t[4], t[5], t[6], t[8], t[9], t[10];
    return m;
}
Vec3d shift_of(const FrameObstacle& o) { return {o.transform[3], o.transform[7], o.transform[11]}; }

const scene::Appearance* appearance_of(const scene::Look& look, const std::string& name) {
    for (const scene::Appearance& a : look.appearances)
        if (a.name == name) return &a;
    return nullptr;
}

bool is_glass(const scene::Appearance* a) { return a && a->type == scene::AppearanceType::dielectric; }

Vec3f tint_of(const scene::Appearance* a) {
    if (is_glass(a)) return {0.62f, 0.68f, 0.72f};
    return a ? encode_srgb(a->colour) : Vec3f(0.75f, 0.75f, 0.75f);
}

unsigned make_texture(const Gl& gl, GLenum format, int width, int height) {
    unsigned texture = 0;
    gl.GenTextures(1, &texture);
    gl.BindTexture(GL_TEXTURE_2D, texture);
    gl.TexStorage2D(GL_TEXTURE_2D, 1, format, width, height);
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    return texture;
}

Target make_target(const Gl& gl, int width, int height, unsigned depth) {
    Target target;
    target.colour = make_texture(gl, GL_RGBA8, width, height);
    target.depth = depth;
    gl.GenFramebuffers(1, &target.framebuffer);
    gl.BindFramebuffer(GL_FRAMEBUFFER, target.framebuffer);
    gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, target.colour, 0);
    if (depth) gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, depth, 0);
    if (gl.CheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
        throw ResourceError("preview: no memory for a picture of {} x {} pixels; ask for a smaller one", width, height);
    return target;
}

}  // namespace

struct Previewer::Device {
    GlContext context;
    const Gl& gl;
    Program spheres, discs, depth_shade, mesh_tint, mesh_gloss, mesh_lines, grid, reduce;
    unsigned vertex_array = 0;  // empty: all vertices are pulled from buffers
    Canvas canvas;
    std::map<std::string, std::vector<GpuMesh>> gpu_meshes;  // by asset, in parts

    Device() : gl(context.current()) {
        const auto program = [&](const char* name, const std::string& vertex, const std::string& fragment) {
            return Program{&gl, make_program(gl, name, vertex, fragment)};
        };
        const std::string common = kCommonGlsl, shade = kShadeGlsl, inputs = kSplatInputsGlsl;
        spheres = program("spheres", common + inputs + kSphereVertexGlsl, common + shade + kSphereFragmentGlsl);
        discs = program("discs", common + shade + inputs + kDiscVertexGlsl, common + kDiscFragmentGlsl);
        depth_shade = program("depth shade", kPictureVertexGlsl, kDepthShadeFragmentGlsl);
        mesh_tint = program("mesh tint", common + kMeshVertexGlsl, common + shade + kMeshTintFragmentGlsl);
        mesh_gloss = program("mesh gloss", common + kMeshVertexGlsl, common + kMeshGlossFragmentGlsl);
        mesh_lines = program("mesh lines", common + kLineVertexGlsl, kPlainFragmentGlsl);
        grid = program("grid", common + kGridVertexGlsl, common + kGridFragmentGlsl);
        reduce = program("reduce", kPictureVertexGlsl, kReduceFragmentGlsl);
        gl.GenVertexArrays(1, &vertex_array);
        gl.BindVertexArray(vertex_array);
        // Depth runs from 1 (near) to 0 (infinity): floating point is as fine far away as close by.
        gl.ClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
        gl.DepthFunc(GL_GREATER);
        gl.PixelStorei(GL_PACK_ALIGNMENT, 1);
    }

    void delete_target(Target& t) {
        gl.DeleteFramebuffers(1, &t.framebuffer);
        gl.DeleteTextures(1, &t.colour);
        t = {};
    }

    void resize(int width, int height, int samples) {
        if (canvas.width == width && canvas.height == height && canvas.samples == samples) return;
        int largest = 0;
        gl.GetIntegerv(GL_MAX_TEXTURE_SIZE, &largest);
        if (width < 1 || height < 1 || std::max(width, height) * samples > largest)
            throw InputError("preview: a picture of {} x {} pixels; between 1 and {} a side are possible", width,
                             height, largest / samples);
        if (canvas.splats.depth) gl.DeleteTextures(1, &canvas.splats.depth);
        delete_target(canvas.splats);
        delete_target(canvas.shaded);
        delete_target(canvas.reduced);
        canvas = {};
        const int w = width * samples, h = height * samples;
        const unsigned depth = make_texture(gl, GL_DEPTH_COMPONENT32F, w, h);
        canvas.splats = make_target(gl, w, h, depth);
        canvas.shaded = make_target(gl, w, h, depth);
        canvas.reduced = make_target(gl, width, height, 0);
        canvas.width = width, canvas.height = height, canvas.samples = samples;
    }

    void set_view(const Program& p, const View& view, float near_plane, const Mat4f& to_eye) const {
        p.use();
        p.set("to_eye", to_eye);
        p.set("tan_half", static_cast<float>(view.tan_x), static_cast<float>(view.tan_y));
        p.set("near_plane", near_plane);
        p.set("sky", Vec3f(Vec3d(view.right.z(), view.up.z(), -view.forward.z()).cast<float>()));
    }

    void draw_splats(const Splats& splats, const View& view, float near_plane) {
        gl.BindFramebuffer(GL_FRAMEBUFFER, canvas.splats.framebuffer);
        gl.Viewport(0, 0, canvas.width * canvas.samples, canvas.height * canvas.samples);
        gl.DepthMask(GL_TRUE);
        gl.ClearColor(0, 0, 0, 1);
        gl.ClearDepthf(0);
        gl.Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
        gl.Enable(GL_DEPTH_TEST);
        gl.Disable(GL_BLEND);
        const bool is_disc = !splats.axes.empty();
        set_view(is_disc ? discs : spheres, view, near_plane, eye_matrix(view, Mat3d::Identity(), Vec3d::Zero()));
        for (std::size_t begin = 0; begin < splats.centre.size(); begin += kSplatsPerDraw) {
            const std::size_t n = std::min(kSplatsPerDraw, splats.centre.size() - begin);
            std::array<unsigned, 3> buffers{};
            buffers[0] = make_buffer(gl, GL_SHADER_STORAGE_BUFFER, std::span(splats.centre).subspan(begin, n));
            buffers[1] = make_buffer(gl, GL_SHADER_STORAGE_BUFFER, std::span(splats.colour).subspan(begin, n));
            if (is_disc)
                buffers[2] =
                    make_buffer(gl, GL_SHADER_STORAGE_BUFFER, std::span(splats.axes).subspan(2 * begin, 2 * n));
            for (unsigned k = 0; k < (is_disc ? 3u : 2u); ++k)
                gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, k, buffers[k]);
            gl.DrawArrays(GL_TRIANGLES, 0, static_cast<int>(3 * n));
            gl.DeleteBuffers(3, buffers.data());
        }
    }

    void draw_depth_shade(float cap) {
        gl.BindFramebuffer(GL_FRAMEBUFFER, canvas.shaded.framebuffer);
        gl.Disable(GL_DEPTH_TEST);
        gl.DepthMask(GL_FALSE);
        depth_shade.use();
        depth_shade.set("step_length", static_cast<float>(canvas.samples) *
                                           std::max(1.0f, static_cast<float>(canvas.height) / 600.0f));
        depth_shade.set("cap", cap);
        depth_shade.set("top", kBackgroundTop);
        depth_shade.set("bottom", kBackgroundBottom);
        depth_shade.set("height", static_cast<float>(canvas.height * canvas.samples));
        gl.ActiveTexture(GL_TEXTURE1);
        gl.BindTexture(GL_TEXTURE_2D, canvas.splats.depth);
        gl.ActiveTexture(GL_TEXTURE0);
        gl.BindTexture(GL_TEXTURE_2D, canvas.splats.colour);
        gl.DrawArrays(GL_TRIANGLES, 0, 3);
        gl.ActiveTexture(GL_TEXTURE1);
        gl.BindTexture(GL_TEXTURE_2D, 0);
        gl.ActiveTexture(GL_TEXTURE0);
    }

    void draw_grid(const View& view, float near_plane) {
        gl.Enable(GL_DEPTH_TEST);
        gl.Enable(GL_BLEND);
        gl.BlendFunc(GL_ZERO, GL_SRC_COLOR);
        set_view(grid, view, near_plane, eye_matrix(view, Mat3d::Identity(), Vec3d::Zero()));
        // By the camera alone, so that the lines stay while the fluid spreads.
        const double width = 2 * view.tan_x * view.distance;
        grid.set("grid_centre", static_cast<float>(view.focus().x()), static_cast<float>(view.focus().y()));
        grid.set("dots", static_cast<float>(canvas.samples));
        grid.set("reach", static_cast<float>(1.8 * width));
        grid.set("cell", static_cast<float>(std::pow(10, std::floor(std::log10(width) - 0.7))));
        gl.DrawArrays(GL_TRIANGLE_STRIP, 0, 4);
    }

    const std::vector<GpuMesh>& gpu_mesh(const std::string& asset, const TriangleMesh& mesh) {
        const auto known = gpu_meshes.find(asset);
        if (known != gpu_meshes.end()) return known->second;
        const MeshCorners corners = mesh_corners(mesh);
        std::vector<GpuMesh>& parts = gpu_meshes[asset];
        const std::size_t length = std::max(corners.positions.size(), corners.lines.size());
        for (std::size_t begin = 0; begin < length; begin += kCornersPerDraw) {
            const auto buffer = [&](const std::vector<std::array<float, 4>>& all, int& count) {
                const std::size_t first = std::min(begin, all.size()),
                                  n = std::min(kCornersPerDraw, all.size() - first);
                count = static_cast<int>(n);
                return make_buffer(gl, GL_SHADER_STORAGE_BUFFER, std::span(all).subspan(first, n));
            };
            GpuMesh part;
            part.positions = buffer(corners.positions, part.corners);
            part.normals = buffer(corners.normals, part.corners);
            part.lines = buffer(corners.lines, part.ends);
            parts.push_back(part);
        }
        return parts;
    }

    void draw_obstacle(const FrameObstacle& o, const GpuMesh& mesh, const scene::Look& look, const View& view,
                       float near_plane) {
        const scene::Appearance* appearance = appearance_of(look, o.look);
        const Mat4f to_eye = eye_matrix(view, turn_of(o), shift_of(o));
        gl.BlendFunc(GL_ZERO, GL_SRC_COLOR);
        set_view(mesh_tint, view, near_plane, to_eye);
        mesh_tint.set("tint", tint_of(appearance));
        mesh_tint.set("density", is_glass(appearance) ? 0.05f : 0.35f);
        gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, mesh.positions);
        gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, mesh.normals);
        gl.DrawArrays(GL_TRIANGLES, 0, mesh.corners);
        set_view(mesh_lines, view, near_plane, to_eye);
        mesh_lines.set("tint", Vec3f(0.72f, 0.74f, 0.76f));
        gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, mesh.lines);
        gl.DrawArrays(GL_LINES, 0, mesh.ends);
    }

    void draw_gloss(const FrameObstacle& o, const GpuMesh& mesh, const View& view, float near_plane) {
        set_view(mesh_gloss, view, near_plane, eye_matrix(view, turn_of(o), shift_of(o)));
        gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, mesh.positions);
        gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, mesh.normals);
        gl.DrawArrays(GL_TRIANGLES, 0, mesh.corners);
    }

    void draw_obstacles(const Frame& frame, const scene::Look& look, const Meshes& meshes, const View& view,
                        float near_plane) {
        gl.Enable(GL_DEPTH_TEST);
        gl.Enable(GL_BLEND);
        for (const FrameObstacle& o : frame.obstacles)
            if (const auto mesh = meshes.find(o.asset); mesh != meshes.end())
                for (const GpuMesh& part : gpu_mesh(o.asset, mesh->second))
                    draw_obstacle(o, part, look, view, near_plane);
        gl.BlendFunc(GL_ONE, GL_ONE);
        for (const FrameObstacle& o : frame.obstacles)
            if (const auto mesh = meshes.find(o.asset); mesh != meshes.end() && is_glass(appearance_of(look, o.look)))
                for (const GpuMesh& part : gpu_mesh(o.asset, mesh->second)) draw_gloss(o, part, view, near_plane);
    }

    void read_back(Image8& out) {
        gl.Disable(GL_BLEND);
        gl.Disable(GL_DEPTH_TEST);
        gl.BindFramebuffer(GL_FRAMEBUFFER, canvas.reduced.framebuffer);
        gl.Viewport(0, 0, canvas.width, canvas.height);
        reduce.use();
        reduce.set("factor", canvas.samples);
        gl.BindTexture(GL_TEXTURE_2D, canvas.shaded.colour);
        gl.DrawArrays(GL_TRIANGLES, 0, 3);
        const std::size_t row = 3 * static_cast<std::size_t>(canvas.width),
                          rows = static_cast<std::size_t>(canvas.height);
        std::vector<std::uint8_t> bottom_up(row * rows);
        gl.ReadPixels(0, 0, canvas.width, canvas.height, GL_RGB, GL_UNSIGNED_BYTE, bottom_up.data());
        const GLenum failure = gl.GetError();
        if (failure == GL_OUT_OF_MEMORY)
            throw ResourceError("preview: out of memory in OpenGL; draw a smaller picture or fewer points");
        THIXO_ASSERT(failure == GL_NO_ERROR, "preview: OpenGL error 0x{:04x}", failure);
        out.width = canvas.width, out.height = canvas.height, out.channels = 3;
        out.values.resize(bottom_up.size());
        for (std::size_t y = 0; y < rows; ++y)
            std::copy_n(bottom_up.data() + (rows - 1 - y) * row, row, out.values.data() + y * row);
    }
};

Previewer::Previewer() : device_(std::make_unique<Device>()) {}
Previewer::~Previewer() = default;

Bounds frame_bounds(const Frame& frame, const Meshes& meshes) {
    Bounds box;
    for (const char* what : {"particles", "surfels"}) {
        const Bounds points = make_splats(frame, {}, what, "", std::nullopt).bounds;
        if (points.empty()) continue;
        box.add(points.lower);
        box.add(points.upper);
    }
    for (const FrameObstacle& o : frame.obstacles)
        if (const auto mesh = meshes.find(o.asset); mesh != meshes.end())
            for (const Vec3f& v : mesh->second.vertices) box.add(turn_of(o) * v.cast<double>() + shift_of(o));
    return box;
}

bool misses(const View& view, const Frame& frame) {
    const auto any_inside = [&](const PointSet& points) {
        if (points.count == 0) return false;
        for (const Vec3f& x : points.get<Vec3f>("P")) {
            if (view.to_eye(x.cast<double>()).z() >= 0) continue;
            const Vec2d at = view.project(x.cast<double>());
            if (at.minCoeff() >= 0 && at.maxCoeff() <= 1) return true;
        }
        return false;
    };
    return frame.particles.count + frame.surfels.count > 0 && !any_inside(frame.particles) &&
           !any_inside(frame.surfels);
}

void Previewer::draw(const Frame& frame, const scene::Look& look, const Meshes& meshes, const PreviewOptions& options,
                     Image8& out) {
    Device& d = *device_;
    d.context.current();
    const int width = options.width ? options.width : look.output.width,
              height = options.height ? options.height : look.output.height;
    const Splats splats = make_splats(frame, look, options.what, options.attribute, options.range);
    const View view = options.view ? *options.view : look_view(look.camera, frame.time, width, height);
    const int samples = options.samples_per_axis ? options.samples_per_axis : (splats.centre.size() <= 200'000 ? 2 : 1);
    d.resize(width, height, samples);

    const float near_plane = static_cast<float>(1e-4 * view.distance);
    const double step = frame.spacing > 0 ? frame.spacing : splats.typical_radius;
    d.draw_splats(splats, view, near_plane);
    d.draw_depth_shade(static_cast<float>(6 * std::max(step, 1e-4 * view.distance) / view.distance));
    if (options.grid) d.draw_grid(view, near_plane);
    d.draw_obstacles(frame, look, meshes, view, near_plane);
    d.read_back(out);
    draw_fronts(out, view, frame.fronts);
    if (options.labels)
        draw_labels(out, splats.legend, frame, splats.centre.size(), splats.axes.empty() ? "particles" : "surfels");
}

}  // namespace thixo::preview
