#version 460
// Writes the triangle's number + 1, and texel (0, 0) of a texture.
layout(binding = 1) uniform sampler2D paint;
layout(location = 0) flat in uint triangle;
layout(location = 0) out uint id;
layout(location = 1) out vec4 color;
layout(push_constant) uniform Push { float gain; } push;

void main() {
    id = triangle + 1;
    color = push.gain * textureLod(paint, vec2(0.5), 0.0);
}
