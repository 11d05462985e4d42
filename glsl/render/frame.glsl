// The frame that directions of the reference are turned by at a drawn point. Twin of src/render/frame.rs. The includer
// defines the draws and what surface.glsl asks for.
#ifndef RENDER_FRAME
#define RENDER_FRAME

struct Frame {
    vec4 world[3];
    vec4 normal[3];
};

// The frame at barycentrics b of a draw's triangle; `vertex` counts from the draw's first one.
Frame frame_at(uint draw, uvec3 vertex, vec3 b) {
    Frame frame;
    uint frames = draws.records[draw].frames;
    if (known_rigid || frames == 0u) {
        frame.world = draws.records[draw].world;
        frame.normal = draws.records[draw].normal;
        return frame;
    }
    uvec4 at = uvec4(uvec3(frames - 1u) + vertex * 9u, 0u);
    vec3 x = igt_weighted3(at, 0u, b);
    vec3 y = igt_weighted3(at, 3u, b);
    vec3 z = igt_weighted3(at, 6u, b);
    vec3 yz = igt_cross3(y, z);
    float handed = igt_dot3(x, yz) < 0.0 ? -1.0 : 1.0;
    precise vec3 n0 = yz * handed;
    precise vec3 n1 = igt_cross3(z, x) * handed;
    precise vec3 n2 = igt_cross3(x, y) * handed;
    frame.world = vec4[3](vec4(x, 0.0), vec4(y, 0.0), vec4(z, 0.0));
    frame.normal = vec4[3](vec4(n0, handed), vec4(n1, 0.0), vec4(n2, 0.0));
    return frame;
}

#endif
