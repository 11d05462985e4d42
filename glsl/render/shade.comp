// Pass shade: from triangle ids to colours. Twin of src/render/shade.rs.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "render/cover.glsl"
#include "render/known.glsl"
layout(local_size_x = 8, local_size_y = 8) in;

layout(std430, binding = 0) readonly buffer Draws { DrawRecord records[]; } draws;
layout(std430, binding = 1) readonly buffer Corners { uvec4 triangles[]; } corners;
layout(std430, binding = 2) readonly buffer ProjectedVertices { Projected vertices[]; } projected;
layout(std430, binding = 3) readonly buffer Positions { float words[]; } positions;
layout(std430, binding = 4) readonly buffer Constants { float words[]; } constants;
layout(std430, binding = 5) readonly buffer AttributeTriangles { uvec4 quads[]; } attribute_triangles;
layout(std430, binding = 6) readonly buffer AttributeVertices { float words[]; } attribute_vertices;
layout(std430, binding = 7) readonly buffer Materials { uint words[]; } materials;
layout(std430, binding = 8) readonly buffer Textures { uint words[]; } textures;
layout(std430, binding = 9) readonly buffer Texels0 { uint words[]; } texels_0;
layout(std430, binding = 10) readonly buffer Texels1 { uint words[]; } texels_1;
layout(std430, binding = 11) readonly buffer Texels2 { uint words[]; } texels_2;
layout(std430, binding = 12) readonly buffer Texels3 { uint words[]; } texels_3;
layout(std430, binding = 17) readonly buffer T3 { ivec4 points[]; } t3;
layout(std430, binding = 18) readonly buffer IgtHashWords { uvec2 pairs[]; } igt_hash;
layout(std430, binding = 19) readonly buffer IgtListWords { uvec4 quads[]; } igt_list;
layout(std430, binding = 20) readonly buffer IgtTriangleWords { uvec4 quads[]; } igt_triangles;
layout(std430, binding = 13) writeonly buffer Colour { uint words[]; } colour;
layout(std430, binding = 14) writeonly buffer Linear { vec4 pixels[]; } linear;
layout(std430, binding = 15) writeonly buffer Aov { uint words[]; } aov;
layout(binding = 16, r32ui) uniform readonly uimage2D ids;

uint igt_texture_word(uint i) { return textures.words[i]; }
float igt_srgb_decoded(uint code) { return constants.words[code]; }
uvec4 igt_attribute_triangle(uint i) { return attribute_triangles.quads[2u * i]; }
uvec4 igt_attribute_uv(uint i) { return attribute_triangles.quads[2u * i + 1u]; }
float igt_attribute_float(uint i) { return attribute_vertices.words[i]; }
uint igt_material_word(uint i) { return materials.words[i]; }

// A texel's address says its shard; no shard is larger than 128 MiB.
uint igt_texel_word(uint address) {
    uint at = address & 0x1ffffffu;
    if (known_shards == 1u) return texels_0.words[at];
    switch (address >> 25) {
        case 0u: return texels_0.words[at];
        case 1u: return texels_1.words[at];
        case 2u: return texels_2.words[at];
        default: return texels_3.words[at];
    }
}

// Where the tables of the draw at hand begin.
uint igt_hash_base;
uint igt_list_base;
uint igt_triangle_base;
uvec2 igt_load_hash2(uint i) { return igt_hash.pairs[igt_hash_base + i]; }
uint igt_load_hash1(uint i) { return igt_hash.pairs[igt_hash_base + (i >> 1)][i & 1u]; }
uvec4 igt_load_list4(uint i) { return igt_list.quads[igt_list_base + i]; }
uint igt_load_list1(uint i) { return igt_list.quads[igt_list_base + (i >> 2)][i & 3u]; }
uvec4 igt_load_triangle4(uint i) { return igt_triangles.quads[igt_triangle_base + i]; }
uint igt_load_triangle1(uint i) { return igt_triangles.quads[igt_triangle_base + (i >> 2)][i & 3u]; }

#include "common/igt.glsl"
#include "render/light.glsl"
#include "render/correspond.glsl"
#include "render/frame.glsl"

// The drawn triangle at the pixel's middle.
Drawn middle;

bool sample_moves() {
    return middle.has_bx && middle.has_by;
}

Drawn middle_moved(vec2 at) {
    Drawn r = middle;
    precise vec3 x = middle.bx - middle.b;
    precise vec3 y = middle.by - middle.b;
    precise vec3 way = x * at.x + y * at.y;
    precise vec3 b = middle.b + way * share_within(middle.b, way);
    precise vec3 bx = b + x;
    precise vec3 by = b + y;
    r.b = b;
    r.bx = bx;
    r.by = by;
    return r;
}

Correspondence sample_at(uint draw, vec2 at) {
    Drawn drawn = middle;
    if (at != vec2(0.0)) drawn = middle_moved(at);
    return correspond(draw, drawn);
}

uint sample_asker() {
    return middle.asker;
}

bool sample_queries(uint draw, out ivec3 query, out ivec3 query_x, out ivec3 query_y) {
    ivec3 v0 = t3.points[middle.vertex.x].xyz;
    ivec3 v1 = t3.points[middle.vertex.y].xyz;
    ivec3 v2 = t3.points[middle.vertex.z].xyz;
    query = query_point(v0, v1, v2, middle.b);
    query_x = query_point(v0, v1, v2, middle.bx);
    query_y = query_point(v0, v1, v2, middle.by);
    return sample_moves();
}

bool sample_within(uint draw, vec2 at, Correspondence centre, out vec3 b) {
    return within(draw, middle_moved(at), centre.corners, b);
}

#include "render/filter.glsl"

const uint NOTHING = 0xffffffffu;
const uint THRESHOLDS_AT = 256u;
const uint PALETTE_AT = 512u;
const int PALETTE_STOPS = 17;
const uint OUTPUT_NORMALS = 2u;
const uint OUTPUT_FETCHES = 3u;
const uint FLAG_WIREFRAME = 4u;
const uint FLAG_DATA = 128u;
const vec3 LINE = vec3(0.004, 0.006, 0.012);

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

// The 8-bit sRGB code of a linear value: how many thresholds it reaches.
uint srgb_encode(float value) {
    uint code = 0u;
    for (uint step = 128u; step > 0u; step >>= 1) {
        if (value >= constants.words[THRESHOLDS_AT + code + step]) {
            code += step;
        }
    }
    return code;
}

float palette_blend(uint at, float f) {
    precise float r = constants.words[at] * (1.0 - f) + constants.words[at + 3u] * f;
    return r;
}

vec3 palette(float t) {
    precise float x = min(max(t, 0.0), 1.0) * float(PALETTE_STOPS - 1);
    float low = min(floor(x), float(PALETTE_STOPS - 2));
    precise float f = x - low;
    uint at = PALETTE_AT + 3u * uint(int(low));
    return vec3(palette_blend(at, f), palette_blend(at + 1u, f), palette_blend(at + 2u, f));
}

float wire_edge(float value, float doubled_area, vec2 direction) {
    precise float squared = direction.x * direction.x + direction.y * direction.y;
    precise float length16 = max(sqrt(squared), 1e-6) * 16.0;
    precise float distance = abs(value) / length16;
    precise float height = doubled_area / length16;
    precise float fade = (height - 1.0) * 0.25;
    precise float inside = 1.1 - distance;
    precise float line = min(max(inside, 0.0), 1.0) * min(max(fade, 0.15), 1.0);
    return line;
}

// How much of a pixel the lines along the drawn triangle's edges cover.
float wire(Edges e) {
    precise float doubled_area = abs(e.value.x + e.value.y + e.value.z);
    float line = max(wire_edge(e.value.x, doubled_area, e.step0), wire_edge(e.value.y, doubled_area, e.step1));
    precise float r = max(line, wire_edge(e.value.z, doubled_area, e.step2)) * 0.85;
    return r;
}

vec3 position_of(uint v) {
    return vec3(positions.words[v * 3u], positions.words[v * 3u + 1u], positions.words[v * 3u + 2u]);
}

vec3 world_position(uint draw, uvec3 vertex, vec3 b) {
    precise vec3 p = b.x * position_of(vertex.x) + b.y * position_of(vertex.y) + b.z * position_of(vertex.z);
    return vec3(affine(draws.records[draw].world[0], p), affine(draws.records[draw].world[1], p),
                affine(draws.records[draw].world[2], p));
}

struct Shaded {
    vec4 value;
    uint code;
    uint triangle;
    uint draw;
    vec2 b;
    uint fetches;
    float depth;
};

const Shaded UNCOVERED = Shaded(vec4(0.0), 0u, NOTHING, NOTHING, vec2(0.0), 0u, 1.0);

void write(uint pixel, Shaded s) {
    colour.words[pixel] = s.code;
    linear.pixels[pixel] = s.value;
    aov.words[pixel * 6u] = s.triangle;
    aov.words[pixel * 6u + 1u] = s.draw;
    aov.words[pixel * 6u + 2u] = floatBitsToUint(s.b.x);
    aov.words[pixel * 6u + 3u] = floatBitsToUint(s.b.y);
    aov.words[pixel * 6u + 4u] = s.fetches;
    aov.words[pixel * 6u + 5u] = floatBitsToUint(s.depth);
}

// The pixel, then its neighbours in x and in y; false where the triangle does not cover the pixel.
bool drawn_at(Projected v0, Projected v1, Projected v2, ivec2 at, out Drawn drawn, out Edges here, out int sense) {
    for (int k = 0; k < 3; k++) {
        Edges e = edges_at(v0, v1, v2, at.x + int(k == 1), at.y + int(k == 2));
        if (k == 0) {
            here = e;
            sense = covers(e);
        }
        vec3 b;
        bool seen = barycentric_of(e, sense, b);
        if (k == 0 && !seen) {
            return false;
        }
        if (k == 0) {
            drawn.b = b;
        } else if (k == 1) {
            drawn.bx = b;
            drawn.has_bx = seen;
        } else {
            drawn.by = b;
            drawn.has_by = seen;
        }
    }
    return true;
}

// What is written of a surface: a picture of numbers, or its light.
void colour_of(inout Shaded s, IgtSurface surface, uint draw, Drawn drawn, Edges here) {
    uint kind = view.flags & 3u;
    bool data = (view.flags & FLAG_DATA) != 0u;
    precise vec3 rgb;
    if (kind == OUTPUT_NORMALS || kind == OUTPUT_FETCHES || data) {
        if (kind == OUTPUT_NORMALS) {
            rgb = surface.normal * 0.5 + vec3(0.5);
        } else if (data) {
            rgb = surface.base.xyz;
        } else {
            precise float t = float(int(s.fetches)) / max(float(int(view.flags >> 8 & 0xffffu)), 1.0);
            rgb = palette(t);
        }
        s.code = igt_unit_encode(rgb.x) | (igt_unit_encode(rgb.y) << 8) | (igt_unit_encode(rgb.z) << 16) | 0xff000000u;
    } else {
        rgb = radiance(surface, world_position(draw, drawn.vertex, drawn.b));
        if ((view.flags & FLAG_WIREFRAME) != 0u) {
            float line = wire(here);
            rgb = rgb * (1.0 - line) + LINE * line;
        }
        s.code = srgb_encode(rgb.x) | (srgb_encode(rgb.y) << 8) | (srgb_encode(rgb.z) << 16) | 0xff000000u;
    }
    s.value = vec4(rgb, 1.0);
}

Shaded shaded(uint id, ivec2 at) {
    Shaded s = UNCOVERED;
    uint draw = draw_of_triangle(id);
    uint local = id - draws.records[draw].first_triangle;
    uvec4 corner = corners.triangles[draws.records[draw].corner_base + local];
    uvec3 seen = corner.xyz - draws.records[draw].vertex_base + draws.records[draw].projected_base;
    Projected v0 = projected.vertices[seen.x];
    Projected v1 = projected.vertices[seen.y];
    Projected v2 = projected.vertices[seen.z];
    Edges here;
    int sense = 0;
    Drawn drawn;
    if (!drawn_at(v0, v1, v2, at, drawn, here, sense)) {
        return s;
    }
    drawn.local = local;
    drawn.vertex = corner.xyz;
    drawn.asker = corner.w;
    middle = drawn;
    Frame frame = frame_at(draw, corner.xyz - draws.records[draw].vertex_base, drawn.b);
    precise float turned = float(sense) * frame.normal[0].w;
    Gathered found = gather(draw, frame, turned);
    s.draw = draw;
    s.fetches = found.fetches;
    s.depth = depth_at(v0, v1, v2, drawn.b, 0.0);
    if (found.centre.known) {
        s.triangle = found.centre.point.triangle - draws.records[draw].attribute_base;
        s.b = found.centre.point.b.yz;
    }
    if (!found.surface.masked) {
        colour_of(s, found.surface, draw, drawn, here);
    }
    return s;
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (at.x >= int(view.width) || at.y >= int(view.height)) {
        return;
    }
    uint id = imageLoad(ids, at).x;
    Shaded s = UNCOVERED;
    if (id != NOTHING) {
        s = shaded(id, at);
    }
    write(uint(at.y) * view.width + uint(at.x), s);
}
