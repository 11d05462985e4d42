// Pass raster: six vertices for each triangle, the rectangle of pixels it may cover. Its corners lie on pixel corners,
// half a pixel from every centre, so no driver's sub-pixel rules can matter; raster.frag decides what is covered.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "render/cover.glsl"

layout(std430, binding = 0) readonly buffer Draws { DrawRecord records[]; } draws;
layout(std430, binding = 1) readonly buffer Corners { uvec4 triangles[]; } corners;
layout(std430, binding = 2) readonly buffer ProjectedVertices { Projected vertices[]; } projected;

layout(location = 0) flat out uint triangle;
layout(location = 1) flat out vec2 handed_slack;
layout(location = 2) flat out ivec3 fixed0;
layout(location = 3) flat out ivec3 fixed1;
layout(location = 4) flat out ivec3 fixed2;
layout(location = 5) flat out vec4 clip0;
layout(location = 6) flat out vec4 clip1;
layout(location = 7) flat out vec4 clip2;
layout(location = 8) flat out vec3 inverse_w;

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

ivec3 fixed_part(Projected v) {
    return ivec3(v.x, v.y, int(v.ordinary));
}

vec4 clip_part(Projected v) {
    return vec4(v.z, v.w, v.hx, v.hy);
}

void main() {
    uint id = uint(gl_VertexIndex) / 6u;
    uint corner = uint(gl_VertexIndex) - id * 6u;
    uint draw = draw_of_triangle(id);
    uint shift = draws.records[draw].projected_base - draws.records[draw].vertex_base;
    uvec3 v = corners.triangles[draws.records[draw].corner_base + id - draws.records[draw].first_triangle].xyz + shift;
    Projected v0 = projected.vertices[v.x];
    Projected v1 = projected.vertices[v.y];
    Projected v2 = projected.vertices[v.z];
    triangle = id;
    fixed0 = fixed_part(v0);
    fixed1 = fixed_part(v1);
    fixed2 = fixed_part(v2);
    clip0 = clip_part(v0);
    clip1 = clip_part(v1);
    clip2 = clip_part(v2);
    inverse_w = vec3(v0.inverse_w, v1.inverse_w, v2.inverse_w);
    handed_slack = vec2(draws.records[draw].normal[0].w, draws.records[draw].normal[1].w);
    ivec4 box;
    if (!bounds_of(v0, v1, v2, box)) {
        gl_Position = vec4(-2.0, -2.0, 0.0, 1.0);
        return;
    }
    bool right = corner == 1u || corner == 2u || corner == 4u;
    bool bottom = corner == 2u || corner == 4u || corner == 5u;
    precise float x = float(right ? box.y + 1 : box.x) * 2.0 / float(int(view.width)) - 1.0;
    precise float y = float(bottom ? box.w + 1 : box.z) * 2.0 / float(int(view.height)) - 1.0;
    gl_Position = vec4(x, y, 0.0, 1.0);
}
