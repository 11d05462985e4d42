#version 460
// sum[i] = scale * (a[i] + b[i]) + offset for i < count.
layout(local_size_x = 64) in;
layout(constant_id = 0) const uint scale = 1;

layout(std430, binding = 0) readonly buffer A { uint words[]; } a;
layout(std430, binding = 1) readonly buffer B { uint words[]; } b;
layout(std430, binding = 2) writeonly buffer Sum { uint words[]; } sum;
layout(push_constant) uniform Push { uint count; uint offset; } push;

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i < push.count) {
        sum.words[i] = scale * (a.words[i] + b.words[i]) + push.offset;
    }
}
