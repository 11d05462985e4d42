// The forward path: a LoD drawn as an engine would, T3 as a varying. See forward.frag.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "render/draw.glsl"

layout(std430, binding = 0) readonly buffer Draws { DrawRecord records[]; } draws;
layout(std430, binding = 1) readonly buffer Corners { uvec4 triangles[]; } corners;
layout(std430, binding = 2) readonly buffer Positions { float words[]; } positions;
layout(std430, binding = 3) readonly buffer T3 { ivec4 points[]; } t3;

// Number of the triangle in its draw, the draw, the asker.
layout(location = 0) flat out uvec3 triangle;
// T3 of the triangle's first vertex, on the query grid; and the way from there, which is small enough for floats.
layout(location = 1) flat out ivec3 origin;
layout(location = 2) out vec3 along;
layout(location = 3) out vec3 barycentric;
layout(location = 4) out vec3 world;

uint draw_of_triangle(uint id) {
    uint low = 0u;
    uint high = view.draw_count - 1u;
    while (low < high) {
        uint middle = (low + high + 1u) / 2u;
        if (draws.records[middle].first_triangle <= id) {
            low = middle;
        } else {
            high = middle - 1u;
        }
    }
    return low;
}

void main() {
    uint id = uint(gl_VertexIndex) / 3u;
    uint corner = uint(gl_VertexIndex) - id * 3u;
    uint draw = draw_of_triangle(id);
    uint local = id - draws.records[draw].first_triangle;
    uvec4 vertices = corners.triangles[draws.records[draw].corner_base + local];
    uint v = corner == 0u ? vertices.x : (corner == 1u ? vertices.y : vertices.z);
    vec3 p = vec3(positions.words[v * 3u], positions.words[v * 3u + 1u], positions.words[v * 3u + 2u]);
    world = vec3(affine(draws.records[draw].world[0], p), affine(draws.records[draw].world[1], p),
                 affine(draws.records[draw].world[2], p));
    // Snapped to sixteenths of a pixel as in the deferred path, so that both draw the same outline.
    float w = affine(view.row_w, world);
    vec2 h = vec2(affine(view.row_x, world), affine(view.row_y, world));
    if (w > 1e-20 && abs(h.x) < w * 131072.0 && abs(h.y) < w * 131072.0) {
        h = floor(h / w * 16.0 + 0.5) / 16.0 * w;
    }
    vec2 clip = h * 2.0 / vec2(view.width, view.height) - w;
    gl_Position = vec4(clip, affine(view.row_z, world), w);
    ivec3 first = t3.points[vertices.x].xyz;
    ivec3 way = (t3.points[v].xyz - first) << 6;
    triangle = uvec3(local, draw, vertices.w);
    origin = first << 6;
    along = vec3(way);
    barycentric = vec3(corner == 0u, corner == 1u, corner == 2u);
}
