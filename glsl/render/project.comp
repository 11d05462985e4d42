// Pass project: vertices to pixels. Twin of src/render/project.rs.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "render/draw.glsl"
layout(local_size_x = 64) in;

layout(std430, binding = 0) readonly buffer Positions { float words[]; } positions;
layout(std430, binding = 1) readonly buffer Draws { DrawRecord records[]; } draws;
layout(std430, binding = 2) writeonly buffer ProjectedVertices { Projected vertices[]; } projected;

const float REACH = 2097152.0;

uint draw_of_vertex(uint vertex) {
    uint low = 0u;
    uint high = view.draw_count - 1u;
    while (low < high) {
        uint middle = (low + high + 1u) / 2u;
        if (draws.records[middle].projected_base <= vertex) {
            low = middle;
        } else {
            high = middle - 1u;
        }
    }
    return low;
}

void main() {
    uint index = (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * 64u + gl_LocalInvocationID.x;
    if (index >= view.vertex_count) {
        return;
    }
    uint draw = draw_of_vertex(index);
    uint vertex = draws.records[draw].vertex_base + (index - draws.records[draw].projected_base);
    vec3 p = vec3(positions.words[vertex * 3u], positions.words[vertex * 3u + 1u], positions.words[vertex * 3u + 2u]);
    vec3 world = vec3(affine(draws.records[draw].world[0], p), affine(draws.records[draw].world[1], p),
                      affine(draws.records[draw].world[2], p));
    Projected v;
    v.hx = affine(view.row_x, world);
    v.hy = affine(view.row_y, world);
    v.z = affine(view.row_z, world);
    v.w = affine(view.row_w, world);
    v.x = 0;
    v.y = 0;
    v.inverse_w = 0.0;
    v.ordinary = 0u;
    if (v.w > 1e-20) {
        precise float x = (v.hx / v.w) * 16.0 + 0.5;
        precise float y = (v.hy / v.w) * 16.0 + 0.5;
        if (x > -REACH && x < REACH && y > -REACH && y < REACH) {
            v.x = int(floor(x));
            v.y = int(floor(y));
            precise float inverse = 1.0 / v.w;
            v.inverse_w = inverse;
            v.ordinary = 1u;
        }
    }
    projected.vertices[index] = v;
}
