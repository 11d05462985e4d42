#version 460
// Pulls one vertex (clip space) and hands on the number of its triangle.
struct ClipVertex { vec4 position; };
layout(std430, binding = 0) readonly buffer Vertices { ClipVertex list[]; } vertices;
layout(location = 0) flat out uint triangle;

void main() {
    gl_Position = vertices.list[gl_VertexIndex].position;
    triangle = gl_VertexIndex / 3;
}
