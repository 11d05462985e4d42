// From a drawn triangle to the point of the reference it stands for. Twin of src/render/correspond.rs.
#ifndef RENDER_CORRESPOND
#define RENDER_CORRESPOND

const float UNIT = 1.0 / 536870912.0;
const int QUERY_SHIFT = 6;
const int QUERY_MAX = 536870911;

// The drawn triangle at a pixel: barycentrics there and, where they mean something, one pixel further.
struct Drawn {
    vec3 b;
    vec3 bx;
    vec3 by;
    bool has_bx;
    bool has_by;
    uint local;
    uvec3 vertex;
    uint layer;
};

struct Correspondence {
    IgtSurfacePoint point;
    bool known;
    uint fetches;
};

int query_coordinate(int v0, int v1, int v2, vec3 b) {
    precise float offset = b.y * float((v1 - v0) << QUERY_SHIFT) + b.z * float((v2 - v0) << QUERY_SHIFT);
    precise float rounded = floor(offset + 0.5);
    int i = int(min(max(rounded, -1.0e9), 1.0e9));
    return min(max((v0 << QUERY_SHIFT) + i, -QUERY_MAX), QUERY_MAX);
}

// T3 at barycentrics b of a drawn triangle, on the query grid.
ivec3 query_point(ivec3 v0, ivec3 v1, ivec3 v2, vec3 b) {
    return ivec3(query_coordinate(v0.x, v1.x, v2.x, b), query_coordinate(v0.y, v1.y, v2.y, b), query_coordinate(v0.z, v1.z, v2.z, b));
}

vec3 unit_of(ivec3 v) {
    precise vec3 r = vec3(float(v.x), float(v.y), float(v.z)) * UNIT;
    return r;
}

// Barycentrics, in the plane of a reference triangle, of the point where the line of `query` meets it.
bool projected_into(uint line, ivec3 query, ivec3 c0, ivec3 c1, ivec3 c2, out vec3 b) {
    vec3 e1 = unit_of((c1 - c0) << QUERY_SHIFT);
    vec3 e2 = unit_of((c2 - c0) << QUERY_SHIFT);
    vec3 w = unit_of(query - (c0 << QUERY_SHIFT));
    vec3 q = unit_of(query);
    vec3 d = line == 0u ? vec3(0.0, 0.0, 1.0) : (line == 1u ? vec3(q.x, q.y, 0.0) : q);
    vec3 n = igt_cross3(e1, e2);
    float steepness = igt_dot3(n, d);
    float area = igt_dot3(n, n);
    b = vec3(0.0);
    if (!(abs(steepness) > 1e-25 && area > 1e-32)) {
        return false;
    }
    precise float along = igt_dot3(n, w) / steepness;
    precise vec3 r = w + d * -along;
    precise float b1 = igt_dot3(igt_cross3(r, e2), n) / area;
    precise float b2 = igt_dot3(igt_cross3(e1, r), n) / area;
    precise float b0 = 1.0 - b1 - b2;
    b = vec3(b0, b1, b2);
    return true;
}

Correspondence identity(uint draw, Drawn drawn) {
    Correspondence r;
    precise vec3 dx = drawn.bx - drawn.b;
    precise vec3 dy = drawn.by - drawn.b;
    r.point.triangle = draws.records[draw].attribute_base + drawn.local;
    r.point.b = drawn.b;
    r.point.dx = dx;
    r.point.dy = dy;
    r.point.has_dx = drawn.has_bx;
    r.point.has_dy = drawn.has_by;
    r.known = true;
    r.fetches = 0u;
    return r;
}

Correspondence correspond(uint draw, Drawn drawn) {
    return identity(draw, drawn);
}

#endif
