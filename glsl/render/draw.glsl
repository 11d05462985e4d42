// What is drawn, as src/render/draw.rs lays it out, and the view.
#ifndef RENDER_DRAW
#define RENDER_DRAW

struct DrawRecord {
    vec4 world[3];
    vec4 normal[3];
    uint first_triangle;
    uint triangle_count;
    uint corner_base;
    uint projected_base;
    uint vertex_base;
    uint vertex_count;
    uint attribute_base;
    uint correspondence;
    uint igt[15];
    uint frames;
};

struct Projected {
    int x;
    int y;
    float z;
    float w;
    float hx;
    float hy;
    float inverse_w;
    uint ordinary;
};

layout(push_constant) uniform View {
    vec4 row_x;
    vec4 row_y;
    vec4 row_z;
    vec4 row_w;
    vec4 eye;
    vec4 light;
    uint width;
    uint height;
    uint flags;
    uint draw_count;
    uint vertex_count;
    float away_z;
    float away_w;
    float time;
} view;

// Twin of DrawRecord::step_back: how far a triangle seen with `sense` steps back before depths are compared, given the
// handedness and the slack of its draw.
float step_back(int sense, vec2 handed_slack) {
    precise float turned = float(sense) * handed_slack.x;
    return turned > 0.0 ? handed_slack.y : 0.0;
}

// row . (p, 1), summed from x on.
float affine(vec4 row, vec3 p) {
    precise float r = row.x * p.x + row.y * p.y + row.z * p.z + row.w;
    return r;
}

#endif
