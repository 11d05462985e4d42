#version 460
// target[i] = a[i] + b[i] + offset for i < count; i runs over all workgroups of x, then of y.
layout(local_size_x = 64) in;

layout(std430, binding = 0) readonly buffer A { uint words[]; } a;
layout(std430, binding = 1) readonly buffer B { uint words[]; } b;
layout(std430, binding = 2) writeonly buffer Sum { uint words[]; } sum;
layout(push_constant) uniform Push { uint count; uint offset; } push;

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i < push.count) {
        sum.words[i] = a.words[i] + b.words[i] + push.offset;
    }
}
