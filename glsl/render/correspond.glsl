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
    uint asker;
};

struct Correspondence {
    IgtSurfacePoint point;
    bool known;
    uint fetches;
    IgtTriangle corners; // of the triangle, where it was looked up
};

int query_coordinate(int v0, int v1, int v2, vec3 b) {
    precise float offset = b.y * float((v1 - v0) << QUERY_SHIFT) + b.z * float((v2 - v0) << QUERY_SHIFT);
    precise float rounded = floor(offset + 0.5);
    int i = int(min(max(rounded, -1.5e9), 1.5e9));
    return (v0 << QUERY_SHIFT) + i;
}

// T3 at barycentrics b of a drawn triangle, on the query grid; possibly outside the domain.
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
    if (!(area > 1e-32)) {
        return false;
    }
    // Where the line grazes the plane, the plane's normal takes its place.
    precise float grazing = area * igt_dot3(d, d) * 0.04;
    precise float steepness2 = steepness * steepness;
    bool grazed = steepness2 <= grazing;
    precise float along = igt_dot3(n, w) / (grazed ? area : steepness);
    precise vec3 r = w + (grazed ? n : d) * -along;
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
    r.point.taps = 1u;
    r.corners = IgtTriangle(ivec3(0), ivec3(0), ivec3(0));
    r.known = true;
    r.fetches = 0u;
    return r;
}

// Of what was not looked up.
Correspondence nowhere() {
    Correspondence r;
    r.point = IgtSurfacePoint(0u, vec3(0.0), vec3(0.0), vec3(0.0), false, false, 1u);
    r.known = false;
    r.fetches = 0u;
    r.corners = IgtTriangle(ivec3(0), ivec3(0), ivec3(0));
    return r;
}

IgtTables tables_of(uint draw) {
    IgtTables tables = igt_tables(uvec4(draws.records[draw].igt[4], draws.records[draw].igt[5], draws.records[draw].igt[6], draws.records[draw].igt[7]),
                                  uvec2(draws.records[draw].igt[8], draws.records[draw].igt[9]));
    return igt_known(tables, known_line, known_layout, known_record);
}

// Whether the line of `query` meets a triangle, and where.
bool within_at(uint draw, ivec3 query, IgtTriangle c, out vec3 b) {
    uvec3 sides[3];
    uint region;
    query = clamp(query, ivec3(-QUERY_MAX), ivec3(QUERY_MAX));
    bool hit = igt_hit(tables_of(draw).line, query, c.v0, c.v1, c.v2, sides, region) != 0;
    b = igt_barycentric(sides);
    return hit;
}

// Through the inverse geometric texture: the reference point of `query`, and its way to the points of the neighbouring
// pixels' queries.
Correspondence inverse_at(uint draw, uint asker, ivec3 query, ivec3 query_x, ivec3 query_y, bool has_x, bool has_y) {
    igt_hash_base = draws.records[draw].igt[1];
    igt_list_base = draws.records[draw].igt[2];
    igt_triangle_base = draws.records[draw].igt[3];
    IgtTables tables = tables_of(draw);
    query = clamp(query, ivec3(-QUERY_MAX), ivec3(QUERY_MAX));
    IgtFound found = igt_lookup(tables, query, asker, true);
    Correspondence r;
    r.fetches = found.fetches;
    r.known = found.triangle != IGT_NOTHING;
    r.point.triangle = 0u;
    r.point.b = found.barycentric;
    r.point.dx = vec3(0.0);
    r.point.dy = vec3(0.0);
    r.point.has_dx = false;
    r.point.has_dy = false;
    r.point.taps = 1u;
    r.corners = found.corners;
    if (!r.known) {
        return r;
    }
    r.point.triangle = draws.records[draw].attribute_base + found.triangle;
    IgtTriangle c = found.corners;
    vec3 here = vec3(0.0);
    for (int k = 0; k < 3; k++) {
        ivec3 q = k == 0 ? query : (k == 1 ? query_x : query_y);
        bool has = k == 0 || (k == 1 ? has_x : has_y);
        vec3 moved;
        has = projected_into(tables.line, q, c.v0, c.v1, c.v2, moved) && has;
        precise vec3 step = moved - here;
        if (k == 0) {
            here = moved;
            if (!has) {
                return r;
            }
        } else if (k == 1) {
            r.point.dx = step;
            r.point.has_dx = has;
        } else {
            r.point.dy = step;
            r.point.has_dy = has;
        }
    }
    return r;
}

#ifndef RENDER_FORWARD
Correspondence correspond(uint draw, Drawn drawn) {
    if (known_correspondence == 1u) {
        return identity(draw, drawn);
    }
    if (known_correspondence == 3u && draws.records[draw].correspondence == 0u) {
        return identity(draw, drawn);
    }
    ivec3 v0 = t3.points[drawn.vertex.x].xyz;
    ivec3 v1 = t3.points[drawn.vertex.y].xyz;
    ivec3 v2 = t3.points[drawn.vertex.z].xyz;
    ivec3 query = query_point(v0, v1, v2, drawn.b);
    ivec3 query_x = query_point(v0, v1, v2, drawn.bx);
    ivec3 query_y = query_point(v0, v1, v2, drawn.by);
    return inverse_at(draw, drawn.asker, query, query_x, query_y, drawn.has_bx, drawn.has_by);
}

// Whether the point at b of a drawn triangle lies in a triangle of the reference, and where.
bool within(uint draw, Drawn drawn, IgtTriangle corners, out vec3 b) {
    ivec3 query = query_point(t3.points[drawn.vertex.x].xyz, t3.points[drawn.vertex.y].xyz, t3.points[drawn.vertex.z].xyz, drawn.b);
    return within_at(draw, query, corners, b);
}
#endif

// How much of the way from b lies in the drawn triangle.
float share_within(vec3 b, vec3 way) {
    float share = 1.0;
    for (int i = 0; i < 3; i++) {
        precise float there = b[i] + way[i];
        precise float part = max(b[i], 0.0) / -way[i];
        if (there < 0.0) share = min(share, part);
    }
    return share;
}

#endif
