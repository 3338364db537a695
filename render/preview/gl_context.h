// An offscreen OpenGL 4.5 core context on the CPU (OSMesa, llvmpipe) and the few functions the preview calls. Needs no
// display.
#pragma once

// glcorearb.h first: osmesa.h pulls gl.h, after which the function types of GL 1.x would be missing.
#include <GL/glcorearb.h>

#include <memory>
#include <span>
#include <string>

namespace thixo::preview {

// clang-format off
#define THIXO_GL_FUNCTIONS(X) \
    X(PFNGLGETINTEGERVPROC, GetIntegerv) X(PFNGLGETERRORPROC, GetError) X(PFNGLENABLEPROC, Enable) \
    X(PFNGLDISABLEPROC, Disable) X(PFNGLVIEWPORTPROC, Viewport) X(PFNGLCLEARPROC, Clear) \
    X(PFNGLCLEARCOLORPROC, ClearColor) X(PFNGLCLEARDEPTHFPROC, ClearDepthf) X(PFNGLDEPTHFUNCPROC, DepthFunc) \
    X(PFNGLDEPTHMASKPROC, DepthMask) X(PFNGLCLIPCONTROLPROC, ClipControl) X(PFNGLBLENDFUNCPROC, BlendFunc) \
    X(PFNGLCREATESHADERPROC, CreateShader) X(PFNGLSHADERSOURCEPROC, ShaderSource) \
    X(PFNGLCOMPILESHADERPROC, CompileShader) X(PFNGLGETSHADERIVPROC, GetShaderiv) \
    X(PFNGLGETSHADERINFOLOGPROC, GetShaderInfoLog) X(PFNGLDELETESHADERPROC, DeleteShader) \
    X(PFNGLCREATEPROGRAMPROC, CreateProgram) X(PFNGLATTACHSHADERPROC, AttachShader) \
    X(PFNGLLINKPROGRAMPROC, LinkProgram) X(PFNGLGETPROGRAMIVPROC, GetProgramiv) \
    X(PFNGLGETPROGRAMINFOLOGPROC, GetProgramInfoLog) X(PFNGLUSEPROGRAMPROC, UseProgram) \
    X(PFNGLGETUNIFORMLOCATIONPROC, GetUniformLocation) X(PFNGLUNIFORM1IPROC, Uniform1i) \
    X(PFNGLUNIFORM1FPROC, Uniform1f) X(PFNGLUNIFORM2FPROC, Uniform2f) X(PFNGLUNIFORM3FPROC, Uniform3f) \
    X(PFNGLUNIFORMMATRIX4FVPROC, UniformMatrix4fv) X(PFNGLGENBUFFERSPROC, GenBuffers) \
    X(PFNGLDELETEBUFFERSPROC, DeleteBuffers) X(PFNGLBINDBUFFERPROC, BindBuffer) X(PFNGLBUFFERDATAPROC, BufferData) \
    X(PFNGLBINDBUFFERBASEPROC, BindBufferBase) X(PFNGLGENVERTEXARRAYSPROC, GenVertexArrays) \
    X(PFNGLBINDVERTEXARRAYPROC, BindVertexArray) X(PFNGLDRAWARRAYSPROC, DrawArrays) \
    X(PFNGLGENTEXTURESPROC, GenTextures) X(PFNGLDELETETEXTURESPROC, DeleteTextures) \
    X(PFNGLBINDTEXTUREPROC, BindTexture) X(PFNGLTEXSTORAGE2DPROC, TexStorage2D) \
    X(PFNGLTEXPARAMETERIPROC, TexParameteri) X(PFNGLACTIVETEXTUREPROC, ActiveTexture) \
    X(PFNGLGENFRAMEBUFFERSPROC, GenFramebuffers) X(PFNGLDELETEFRAMEBUFFERSPROC, DeleteFramebuffers) \
    X(PFNGLBINDFRAMEBUFFERPROC, BindFramebuffer) X(PFNGLFRAMEBUFFERTEXTURE2DPROC, FramebufferTexture2D) \
    X(PFNGLCHECKFRAMEBUFFERSTATUSPROC, CheckFramebufferStatus) X(PFNGLREADPIXELSPROC, ReadPixels) \
    X(PFNGLPIXELSTOREIPROC, PixelStorei)
// clang-format on

/// The functions by name without their gl prefix, valid while the context that loaded them is current.
struct Gl {
#define X(type, name) type name = nullptr;
    THIXO_GL_FUNCTIONS(X)
#undef X
};

/// Owns one context. Throws ResourceError where OSMesa gives no OpenGL 4.5. Not for use by two threads at once.
class GlContext {
  public:
    GlContext();
    ~GlContext();
    GlContext(const GlContext&) = delete;
    GlContext& operator=(const GlContext&) = delete;

    /// Makes the context current on this thread and returns its functions.
    const Gl& current();

  private:
    void* context_ = nullptr;
    unsigned char window_[4 * 16 * 16] = {};  // OSMesa wants a drawable; all drawing goes to framebuffer objects
    Gl gl_;
};

/// A linked program of a vertex and a fragment shader. A shader that fails to compile is a broken promise of ours: it
/// asserts.
unsigned make_program(const Gl& gl, const char* name, const std::string& vertex, const std::string& fragment);

/// A buffer object of the target, filled with the elements.
template <class T>
unsigned make_buffer(const Gl& gl, GLenum target, std::span<const T> elements) {
    unsigned buffer = 0;
    gl.GenBuffers(1, &buffer);
    gl.BindBuffer(target, buffer);
    gl.BufferData(target, static_cast<GLsizeiptr>(elements.size_bytes()), elements.data(), GL_STATIC_DRAW);
    return buffer;
}

}  // namespace thixo::preview
