// Pass raster: the exact coverage test and depth of one pixel; writes the number of the picture's triangle.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "render/cover.glsl"

layout(std430, binding = 2) readonly buffer ProjectedVertices { Projected vertices[]; } projected;

layout(location = 0) flat in uvec4 triangle;
layout(location = 1) flat in vec2 handed_slack;
layout(location = 0) out uint id;

void main() {
    Projected v0 = projected.vertices[triangle.x];
    Projected v1 = projected.vertices[triangle.y];
    Projected v2 = projected.vertices[triangle.z];
    Edges e = edges_at(v0, v1, v2, int(gl_FragCoord.x), int(gl_FragCoord.y));
    int sense = covers(e);
    vec3 b;
    if (sense == 0 || !barycentric_of(e, sense, b)) {
        discard;
    }
    float depth = depth_at(v0, v1, v2, b, step_back(sense, handed_slack));
    if (depth < 0.0) {
        discard;
    }
    gl_FragDepth = depth;
    id = triangle.w;
}
