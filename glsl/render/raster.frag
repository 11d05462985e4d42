// Pass raster: the exact coverage test and depth of one pixel; writes the number of the picture's triangle. The triangle
// comes as flat inputs, which cost a driver less than loads in each fragment.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "render/cover.glsl"

layout(location = 0) flat in uint triangle;
layout(location = 1) flat in vec2 handed_slack;
// Of each vertex x, y and whether it is ordinary; z, w, hx, hy; 1 / w of all three.
layout(location = 2) flat in ivec3 fixed0;
layout(location = 3) flat in ivec3 fixed1;
layout(location = 4) flat in ivec3 fixed2;
layout(location = 5) flat in vec4 clip0;
layout(location = 6) flat in vec4 clip1;
layout(location = 7) flat in vec4 clip2;
layout(location = 8) flat in vec3 inverse_w;
layout(location = 0) out uint id;

Projected vertex(ivec3 at, vec4 clip, float inverse) {
    return Projected(at.x, at.y, clip.x, clip.y, clip.z, clip.w, inverse, uint(at.z));
}

void main() {
    Projected v0 = vertex(fixed0, clip0, inverse_w.x);
    Projected v1 = vertex(fixed1, clip1, inverse_w.y);
    Projected v2 = vertex(fixed2, clip2, inverse_w.z);
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
    id = triangle;
}
