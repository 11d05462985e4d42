// The forward path: the lookup inside a fragment shader, textures sampled by the device, as an engine would embed it.
// Shares igt.glsl, the attributes and the light with the deferred path; its bits differ from driver to driver.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "render/draw.glsl"
#include "render/known.glsl"

layout(std430, binding = 0) readonly buffer Draws { DrawRecord records[]; } draws;
layout(std430, binding = 1) readonly buffer Corners { uvec4 triangles[]; } corners;
layout(std430, binding = 4) readonly buffer AttributeTriangles { uvec4 quads[]; } attribute_triangles;
layout(std430, binding = 5) readonly buffer AttributeVertices { float words[]; } attribute_vertices;
layout(std430, binding = 6) readonly buffer Materials { uint words[]; } materials;
layout(std430, binding = 7) readonly buffer Textures { uint words[]; } textures;
layout(std430, binding = 8) readonly buffer IgtHashWords { uvec2 pairs[]; } igt_hash;
layout(std430, binding = 9) readonly buffer IgtListWords { uvec4 quads[]; } igt_list;
layout(std430, binding = 10) readonly buffer IgtTriangleWords { uvec4 quads[]; } igt_triangles;
// Textures of one size, format and sampler are layers of one array: no array of images is indexed by a variable.
layout(binding = 11) uniform sampler2DArray class_0;
layout(binding = 12) uniform sampler2DArray class_1;
layout(binding = 13) uniform sampler2DArray class_2;
layout(binding = 14) uniform sampler2DArray class_3;
layout(binding = 15) uniform sampler2DArray class_4;
layout(binding = 16) uniform sampler2DArray class_5;
layout(binding = 17) uniform sampler2DArray class_6;
layout(binding = 18) uniform sampler2DArray class_7;

layout(location = 0) flat in uvec3 triangle;
layout(location = 1) flat in ivec3 origin;
layout(location = 2) in vec3 along;
layout(location = 3) in vec3 barycentric;
layout(location = 4) in vec3 world;

// Linear RGBA; reference triangle, draw, barycentrics; fetches.
layout(location = 0) out vec4 colour;
layout(location = 1) out uvec4 ids;
layout(location = 2) out uint fetches;
layout(depth_greater) out float gl_FragDepth;

uvec4 igt_attribute_triangle(uint i) { return attribute_triangles.quads[2u * i]; }
uvec4 igt_attribute_uv(uint i) { return attribute_triangles.quads[2u * i + 1u]; }
float igt_attribute_float(uint i) { return attribute_vertices.words[i]; }
uint igt_material_word(uint i) { return materials.words[i]; }
uint igt_texture_word(uint i) { return textures.words[i]; }

uint igt_hash_base;
uint igt_list_base;
uint igt_triangle_base;
uvec2 igt_load_hash2(uint i) { return igt_hash.pairs[igt_hash_base + i]; }
uint igt_load_hash1(uint i) { return igt_hash.pairs[igt_hash_base + (i >> 1)][i & 1u]; }
uvec4 igt_load_list4(uint i) { return igt_list.quads[igt_list_base + i]; }
uint igt_load_list1(uint i) { return igt_list.quads[igt_list_base + (i >> 2)][i & 3u]; }
uvec4 igt_load_triangle4(uint i) { return igt_triangles.quads[igt_triangle_base + i]; }
uint igt_load_triangle1(uint i) { return igt_triangles.quads[igt_triangle_base + (i >> 2)][i & 3u]; }

#define IGT_SAMPLE_ELSEWHERE
#define RENDER_FORWARD
#include "common/igt.glsl"
#include "common/texture.glsl"

vec4 igt_sample(uint id, IgtUvGradient at) {
    vec3 uv = vec3(at.uv, float(textures.words[id * IGT_TEXTURE_WORDS + 7u]));
    switch (textures.words[id * IGT_TEXTURE_WORDS + 6u]) {
        case 0u: return textureGrad(class_0, uv, at.dx, at.dy);
        case 1u: return textureGrad(class_1, uv, at.dx, at.dy);
        case 2u: return textureGrad(class_2, uv, at.dx, at.dy);
        case 3u: return textureGrad(class_3, uv, at.dx, at.dy);
        case 4u: return textureGrad(class_4, uv, at.dx, at.dy);
        case 5u: return textureGrad(class_5, uv, at.dx, at.dy);
        case 6u: return textureGrad(class_6, uv, at.dx, at.dy);
        default: return textureGrad(class_7, uv, at.dx, at.dy);
    }
}

#include "render/light.glsl"
#include "render/correspond.glsl"
#include "render/frame.glsl"

ivec3 query_of(vec3 way) {
    ivec3 step = ivec3(floor(clamp(way, vec3(-1.5e9), vec3(1.5e9)) + 0.5));
    return origin + step;
}

// Derivatives, taken in uniform control flow.
vec3 along_x, along_y, b_x, b_y;

bool sample_moves() {
    return true;
}

// What is interpolated, at a place of the pixel.
vec3 along_at(vec2 at) {
    return along + (along_x * at.x + along_y * at.y) * share_within(barycentric, b_x * at.x + b_y * at.y);
}

Correspondence sample_at(uint draw, vec2 at) {
    if (known_correspondence == 1u || (known_correspondence == 3u && draws.records[draw].correspondence == 0u)) {
        Correspondence found;
        found.point = IgtSurfacePoint(draws.records[draw].attribute_base + triangle.x, barycentric, b_x, b_y, true, true, 1u);
        found.known = true;
        found.fetches = 0u;
        return found;
    }
    vec3 here = along_at(at);
    return inverse_at(draw, triangle.z, query_of(here), query_of(here + along_x), query_of(here + along_y), true, true);
}

uint sample_asker() {
    return triangle.z;
}

bool sample_queries(uint draw, out ivec3 query, out ivec3 query_x, out ivec3 query_y) {
    query = query_of(along);
    query_x = query_of(along + along_x);
    query_y = query_of(along + along_y);
    return true;
}

bool sample_within(uint draw, vec2 at, Correspondence centre, out vec3 b) {
    return within_at(draw, query_of(along_at(at)), centre.corners, b);
}

#include "render/filter.glsl"

void main() {
    along_x = dFdx(along);
    along_y = dFdy(along);
    b_x = dFdx(barycentric);
    b_y = dFdy(barycentric);
    uint draw = triangle.y;
    uvec3 vertices = corners.triangles[draws.records[draw].corner_base + triangle.x].xyz;
    Frame frame = frame_at(draw, vertices - draws.records[draw].vertex_base, barycentric);
    // Counter-clockwise is the front; a mirroring transform turns it.
    int sense = gl_FrontFacing ? -1 : 1;
    vec2 handed_slack = vec2(draws.records[draw].normal[0].w, draws.records[draw].normal[1].w);
    Gathered found = gather(draw, frame, float(sense) * frame.normal[0].w);
    IgtSurface surface = found.surface;
    fetches = found.fetches;
    ids = uvec4(0xffffffffu, draw, 0u, 0u);
    if (found.centre.known) {
        uint reference = found.centre.point.triangle - draws.records[draw].attribute_base;
        ids = uvec4(reference, draw, floatBitsToUint(found.centre.point.b.y), floatBitsToUint(found.centre.point.b.z));
    }
    if (surface.masked) {
        discard;
    }
    // As the deferred path has it, from z / w and 1 / w. No step, no arithmetic: fronts keep their depth to the bit.
    float back = step_back(sense, handed_slack);
    gl_FragDepth = gl_FragCoord.z;
    if (back > 0.0) {
        float stepped = (gl_FragCoord.z + back * view.away_z * gl_FragCoord.w) / (1.0 + back * view.away_w * gl_FragCoord.w);
        gl_FragDepth = max(gl_FragCoord.z, min(stepped, 1.0));
    }
    colour = (view.flags & 3u) == 2u ? vec4(surface.normal * 0.5 + 0.5, 1.0) : vec4(radiance(surface, world), 1.0);
}
