// GLSL sources of the preview. All of them work in display colours: a shade factor applied to an encoded colour is the
// encoded factor. Eye space has the camera at the origin, looking along -z. Depth is near/distance along the view (1 at
// the near plane, 0 at infinity).
#pragma once

namespace thixo::preview {

inline constexpr char kCommonGlsl[] = R"(#version 450 core
uniform mat4 to_eye;      // world -> eye
uniform vec2 tan_half;    // half the picture's width and height at distance 1
uniform float near_plane;
vec4 clip(vec3 p) { return vec4(p.x / tan_half.x, p.y / tan_half.y, near_plane, -p.z); }
)";

// The light of the preview: a broad sky from above in the world, a soft key light from the upper left of the picture.
inline constexpr char kShadeGlsl[] = R"(
uniform vec3 sky;         // the world's z axis in eye space
float shade(vec3 n) {
    float dome = 0.5 + 0.5 * dot(n, sky);
    float key = max(0.25 + 0.75 * dot(n, normalize(vec3(-0.45, 0.55, 0.70))), 0.0);
    return min(0.42 + 0.26 * dome + 0.44 * key, 1.0);
}
)";

// Three vertices a splat, pulled from buffers by the vertex number: the triangle around the unit circle. Vertices, not
// pixels, are what hundreds of thousands of splats cost.
inline constexpr char kSplatInputsGlsl[] = R"(
layout(std430, binding = 0) readonly buffer Centres { vec4 centres[]; };
layout(std430, binding = 1) readonly buffer Colours { uint colours[]; };
const vec2 corners[3] = vec2[](vec2(-1.7320509, -1), vec2(1.7320509, -1), vec2(0, 2));
)";

// A triangle through the centre, square to the line of sight. It surrounds the circle where the sphere's cone meets it,
// of radius
//   d r / sqrt(d^2 - r^2).
inline constexpr char kSphereVertexGlsl[] = R"(
flat out vec4 sphere;
flat out vec3 colour;
out vec3 ray;
void main() {
    uint i = uint(gl_VertexID) / 3u;
    vec2 corner = corners[uint(gl_VertexID) % 3u];
    vec3 c = (to_eye * vec4(centres[i].xyz, 1)).xyz;
    float r = centres[i].w;
    float d2 = dot(c, c), cone2 = d2 - r * r;
    sphere = vec4(c, r);
    colour = unpackUnorm4x8(colours[i]).rgb;
    ray = c;
    gl_Position = vec4(0, 0, -2, 1);              // clipped away: the camera is inside
    if (!(cone2 > 1e-6 * d2)) return;
    vec3 u = normalize(vec3(-c.z, 0, c.x)), v = cross(c, u) * inversesqrt(d2);
    ray = c + (corner.x * u + corner.y * v) * (r * sqrt(d2 / cone2));
    gl_Position = clip(ray);
}
)";

inline constexpr char kSphereFragmentGlsl[] = R"(
flat in vec4 sphere;
flat in vec3 colour;
in vec3 ray;
out vec4 pixel;
void main() {
    vec3 d = normalize(ray);
    float along = dot(d, sphere.xyz);
    vec3 miss = sphere.xyz - along * d;           // the closest approach; |c|^2 - along^2 would cancel
    float h2 = sphere.w * sphere.w - dot(miss, miss);
    if (h2 < 0.0) discard;
    vec3 hit = (along - sqrt(h2)) * d;
    gl_FragDepth = near_plane / max(-hit.z, near_plane);
    pixel = vec4(colour * shade((hit - sphere.xyz) / sphere.w), 1);
}
)";

inline constexpr char kDiscVertexGlsl[] = R"(
layout(std430, binding = 2) readonly buffer Axes { vec4 axes[]; };
flat out vec3 shaded;
out vec2 place;
void main() {
    uint i = uint(gl_VertexID) / 3u;
    place = corners[uint(gl_VertexID) % 3u];
    mat3 turn = mat3(to_eye);
    vec3 c = (to_eye * vec4(centres[i].xyz, 1)).xyz;
    vec3 t1 = turn * axes[2u * i].xyz, t2 = turn * axes[2u * i + 1u].xyz;
    vec3 n = normalize(cross(t1, t2));
    float behind = dot(n, c) > 0.0 ? 0.72 : 1.0;  // the inner side of a surface, a little darker
    shaded = unpackUnorm4x8(colours[i]).rgb * shade(behind < 1.0 ? -n : n) * behind;
    gl_Position = clip(c + place.x * t1 + place.y * t2);
}
)";

inline constexpr char kDiscFragmentGlsl[] = R"(
flat in vec3 shaded;
in vec2 place;
out vec4 pixel;
void main() {
    if (dot(place, place) > 1.0) discard;
    pixel = vec4(shaded, 1);
}
)";

// One triangle over the whole picture.
inline constexpr char kPictureVertexGlsl[] = R"(#version 450 core
void main() { gl_Position = vec4(gl_VertexID == 1 ? 3 : -1, gl_VertexID == 2 ? 3 : -1, 0, 1); }
)";

// Darkens what lies deeper than its surroundings, in two widths (eye-dome lighting, Boucheny 2009): crevices, outlines,
// a sense of depth. Background where nothing was drawn.
inline constexpr char kDepthShadeFragmentGlsl[] = R"(#version 450 core
layout(binding = 0) uniform sampler2D colours;
layout(binding = 1) uniform sampler2D depths;
uniform float step_length;     // pixels
uniform float cap;             // largest step of log2 depth that counts
uniform vec3 top, bottom;      // background
uniform float height;
out vec4 pixel;
const vec2 ring[8] = vec2[](vec2(1, 0), vec2(0.7, 0.7), vec2(0, 1), vec2(-0.7, 0.7), vec2(-1, 0), vec2(-0.7, -0.7), vec2(0, -1), vec2(0.7, -0.7));
float deeper(float own, float radius) {
    float sum = 0.0;
    ivec2 last = textureSize(depths, 0) - 1;
    for (int k = 0; k < 8; ++k) {
        ivec2 at = clamp(ivec2(gl_FragCoord.xy + radius * ring[k]), ivec2(0), last);
        float other = texelFetch(depths, at, 0).r;
        if (other > own) sum += min(log2(other / own), cap);
    }
    return sum / (8.0 * cap);
}
void main() {
    ivec2 at = ivec2(gl_FragCoord.xy);
    float own = texelFetch(depths, at, 0).r;
    pixel = vec4(mix(bottom, top, gl_FragCoord.y / height), 1);
    if (own <= 0.0) return;
    float dark = 0.55 * deeper(own, step_length) + 0.45 * deeper(own, 4.0 * step_length);
    pixel = vec4(texelFetch(colours, at, 0).rgb * exp(-0.8 * dark), 1);
}
)";

inline constexpr char kMeshVertexGlsl[] = R"(
layout(std430, binding = 0) readonly buffer Vertices { vec4 vertices[]; };
layout(std430, binding = 1) readonly buffer Normals { vec4 normals[]; };
out vec3 at;
out vec3 normal;
void main() {
    at = (to_eye * vec4(vertices[gl_VertexID].xyz, 1)).xyz;
    normal = mat3(to_eye) * normals[gl_VertexID].xyz;
    gl_Position = clip(at);
}
)";

// Layers of a translucent mesh multiply what is behind them: any order of layers gives the same picture. Faces seen at
// a slant take more, so that the outline shows and the inside does not vanish.
inline constexpr char kMeshTintFragmentGlsl[] = R"(
uniform vec3 tint;
uniform float density;     // share of the tint, face on
in vec3 at;
in vec3 normal;
out vec4 pixel;
void main() {
    vec3 n = normalize(normal);
    float facing = abs(dot(n, normalize(at)));
    float slant = pow(1.0 - facing, 2.5);
    float take = density + (0.72 - density) * slant;
    pixel = vec4(mix(vec3(1), tint * shade(dot(n, at) > 0.0 ? -n : n), take), 1);
}
)";

// Its highlights are added; sums do not depend on the order either.
inline constexpr char kMeshGlossFragmentGlsl[] = R"(
in vec3 at;
in vec3 normal;
out vec4 pixel;
void main() {
    vec3 d = normalize(at), n = normalize(normal);
    if (dot(n, d) > 0.0) discard;
    float mirror = max(dot(reflect(d, n), normalize(vec3(-0.45, 0.62, 0.64))), 0.0);
    pixel = vec4(vec3(0.30 * pow(mirror, 48.0) + 0.05 * pow(mirror, 6.0)), 1);
}
)";

inline constexpr char kLineVertexGlsl[] = R"(
layout(std430, binding = 0) readonly buffer Ends { vec4 ends[]; };
void main() { gl_Position = clip((to_eye * vec4(ends[gl_VertexID].xyz, 1)).xyz); }
)";

inline constexpr char kPlainFragmentGlsl[] = R"(#version 450 core
uniform vec3 tint;
out vec4 pixel;
void main() { pixel = vec4(tint, 1); }
)";

// The plane z = 0 with lines every `cell` metres (every tenth stronger), as factors; lines thinner than a pixel fade.
inline constexpr char kGridVertexGlsl[] = R"(
uniform vec2 grid_centre;
uniform float reach;
out vec2 ground;
void main() {
    vec2 corner = vec2((gl_VertexID & 1) * 2 - 1, (gl_VertexID & 2) - 1);
    ground = grid_centre + reach * corner;
    gl_Position = clip((to_eye * vec4(ground, 0, 1)).xyz);
}
)";

inline constexpr char kGridFragmentGlsl[] = R"(
uniform vec2 grid_centre;
uniform float reach, cell;
uniform float dots;        // samples per pixel and axis
in vec2 ground;
out vec4 pixel;
float lines(float edge, float width) {
    vec2 x = ground / edge, pixels = max(fwidth(x), vec2(1e-6));
    vec2 off = abs(fract(x - 0.5) - 0.5) / pixels;
    vec2 line = clamp(width * dots + 0.5 - off, 0.0, 1.0) * clamp(0.35 / (dots * pixels) - 0.5, 0.0, 1.0);
    return max(line.x, line.y);
}
void main() {
    float fade = 1.0 - smoothstep(0.15, 1.0, length(ground - grid_centre) / reach);
    float dark = max(0.15 * lines(cell, 0.2), 0.28 * lines(10.0 * cell, 0.35));
    pixel = vec4(vec3(1.0 - fade * dark), 1);
}
)";

// Mean over squares of `factor` x `factor` pixels.
inline constexpr char kReduceFragmentGlsl[] = R"(#version 450 core
layout(binding = 0) uniform sampler2D colours;
uniform int factor;
out vec4 pixel;
void main() {
    ivec2 base = ivec2(gl_FragCoord.xy) * factor;
    vec3 sum = vec3(0);
    for (int y = 0; y < factor; ++y)
        for (int x = 0; x < factor; ++x) sum += texelFetch(colours, base + ivec2(x, y), 0).rgb;
    pixel = vec4(sum / float(factor * factor), 1);
}
)";

}  // namespace thixo::preview
