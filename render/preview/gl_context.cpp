#include "render/preview/gl_context.h"

#include <GL/osmesa.h>

#include "pipeline/base/error.h"

namespace thixo::preview {

GlContext::GlContext() {
    const int attributes[] = {OSMESA_FORMAT,
                              OSMESA_RGBA,
                              OSMESA_DEPTH_BITS,
                              0,
                              OSMESA_PROFILE,
                              OSMESA_CORE_PROFILE,
                              OSMESA_CONTEXT_MAJOR_VERSION,
                              4,
                              OSMESA_CONTEXT_MINOR_VERSION,
                              5,
                              0,
                              0};
    context_ = OSMesaCreateContextAttribs(attributes, nullptr);
    if (!context_)
        throw ResourceError(
            "preview: OSMesa gives no OpenGL 4.5 core context; install the package libosmesa6 of Mesa 22 or newer");
    if (!OSMesaMakeCurrent(static_cast<OSMesaContext>(context_), window_, GL_UNSIGNED_BYTE, 16, 16)) {
        OSMesaDestroyContext(static_cast<OSMesaContext>(context_));
        throw ResourceError("preview: OSMesa cannot make its context current; free some memory and run again");
    }
    // OSMesaGetProcAddress answers unknown names too, so the version decides whether the functions are there.
#define X(type, name) gl_.name = reinterpret_cast<type>(OSMesaGetProcAddress("gl" #name));
    THIXO_GL_FUNCTIONS(X)
#undef X
    int major = 0, minor = 0;
    gl_.GetIntegerv(GL_MAJOR_VERSION, &major);
    gl_.GetIntegerv(GL_MINOR_VERSION, &minor);
    if (10 * major + minor < 45) {
        OSMesaDestroyContext(static_cast<OSMesaContext>(context_));
        throw ResourceError("preview: OSMesa gives OpenGL {}.{}, the preview needs 4.5; install Mesa 22 or newer",
                            major, minor);
    }
}

GlContext::~GlContext() {
    OSMesaMakeCurrent(nullptr, nullptr, GL_UNSIGNED_BYTE, 0, 0);
    OSMesaDestroyContext(static_cast<OSMesaContext>(context_));
}

const Gl& GlContext::current() {
    if (!OSMesaMakeCurrent(static_cast<OSMesaContext>(context_), window_, GL_UNSIGNED_BYTE, 16, 16))
        throw ResourceError("preview: OSMesa cannot make its context current; free some memory and run again");
    return gl_;
}

namespace {

unsigned compile(const Gl& gl, const char* name, GLenum stage, const std::string& source) {
    const unsigned shader = gl.CreateShader(stage);
    const char* text = source.c_str();
    gl.ShaderSource(shader, 1, &text, nullptr);
    gl.CompileShader(shader);
    int ok = 0;
    gl.GetShaderiv(shader, GL_COMPILE_STATUS, &ok);
    char log[2048] = "";
    if (!ok) gl.GetShaderInfoLog(shader, sizeof log, nullptr, log);
    THIXO_ASSERT(ok, "shader '{}' does not compile: {}", name, log);
    return shader;
}

}  // namespace

unsigned make_program(const Gl& gl, const char* name, const std::string& vertex, const std::string& fragment) {
    const unsigned v = compile(gl, name, GL_VERTEX_SHADER, vertex);
    const unsigned f = compile(gl, name, GL_FRAGMENT_SHADER, fragment);
    const unsigned program = gl.CreateProgram();
    gl.AttachShader(program, v);
    gl.AttachShader(program, f);
    gl.LinkProgram(program);
    gl.DeleteShader(v);
    gl.DeleteShader(f);
    int ok = 0;
    gl.GetProgramiv(program, GL_LINK_STATUS, &ok);
    char log[2048] = "";
    if (!ok) gl.GetProgramInfoLog(program, sizeof log, nullptr, log);
    THIXO_ASSERT(ok, "program '{}' does not link: {}", name, log);
    return program;
}

}  // namespace thixo::preview
