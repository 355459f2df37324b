/* render/surface_point.c - where a ray meets a triangle, and how far the next ray must keep from
 * it.
 *
 * The offset is a bound, not a guess. With u = 2^-24, the unit roundoff of single precision:
 *   - the point itself lies on the triangle to double precision;
 *   - its coordinates are rounded to single: by at most u |x| each, u (|x| + |y| + |z|) along any
 *     direction, and the same again for the offset vector;
 *   - the ray tracer decides on which side of a plane the ray starts. It uses the vertices relative
 *     to the start, rounded by u of their distance, which is at most the reach of the triangles
 *     around. A cross and a dot product of such vectors lose less than 8 u of their size.
 * For a scene of 6 m it is some micrometres at most, far less than a contact's thickness. The
 * triangle that a ray leaves is left out by its number as well, which also holds for slivers, whose
 * plane is less certain.
 *
 * Based on: Carsten Wächter and Nikolaus Binder, A fast and robust method for avoiding
 *           self-intersection, 2019 (the idea; here with a bound and without the triangle left);
 *           Johannes Hanika, Hacking the shadow terminator, 2021 (the lift). */
#include "render/surface_point.h"

static const double unit_roundoff = 0x1p-24;
static const double position_roundings = 2.0; /* see above */
static const double plane_roundings = 8.0;

static void clamp_weights(double w[3]) {
    for (int i = 0; i < 3; i++) w[i] = fmax(w[i], 0.0);
    double const sum = w[0] + w[1] + w[2];
    for (int i = 0; i < 3; i++) w[i] = sum > 0.0 ? w[i] / sum : 1.0 / 3.0;
}

static vec3 load_float3(const float *v) {
    return vec3_make((double)v[0], (double)v[1], (double)v[2]);
}

static vec3 compute_shading_normal(const render_geometry *geometry, uint32_t triangle,
                                   const double weights[3], vec3 normal) {
    if (!geometry->parts[geometry->part_index[triangle]].is_smooth) return normal;
    const float *const corners = geometry->corner_normals + 9 * (size_t)triangle;
    vec3 sum = {0};
    for (int i = 0; i < 3; i++)
        sum = vec3_add_scaled(sum, load_float3(corners + 3 * i), weights[i]);
    sum = vec3_normalize(sum);
    return vec3_dot(sum, normal) > 0.0 ? sum : normal;
}

void render_point_find(const render_geometry *geometry, uint32_t triangle, vec3 origin,
                       vec3 direction, render_point *point) {
    const uint32_t *const corners = geometry->triangles + 3 * (size_t)triangle;
    vec3 const a = render_geometry_get_vertex(geometry, corners[0]);
    vec3 const ab = vec3_sub(render_geometry_get_vertex(geometry, corners[1]), a);
    vec3 const ac = vec3_sub(render_geometry_get_vertex(geometry, corners[2]), a);
    vec3 const cross = vec3_cross(ab, ac);
    double const area2 = vec3_norm2(cross), slope = vec3_dot(cross, direction);
    vec3 const to_plane = vec3_sub(a, origin);
    point->triangle = triangle;
    /* A ray in the plane, or a triangle without area: the middle is as good as any point of it. */
    double w[3] = {1.0, 1.0, 1.0};
    if (slope != 0.0 && area2 > 0.0) {
        vec3 const q = vec3_sub(vec3_scale(direction, vec3_dot(cross, to_plane) / slope), to_plane);
        w[1] = vec3_dot(vec3_cross(q, ac), cross) / area2;
        w[2] = vec3_dot(vec3_cross(ab, q), cross) / area2;
        w[0] = 1.0 - w[1] - w[2];
    }
    clamp_weights(w);
    for (int i = 0; i < 3; i++) point->weights[i] = w[i];
    point->position = vec3_add_scaled(vec3_add_scaled(a, ab, w[1]), ac, w[2]);
    point->distance =
        vec3_dot(vec3_sub(point->position, origin), direction) / vec3_norm2(direction);
    vec3 const normal =
        area2 > 0.0 ? vec3_scale(cross, 1.0 / sqrt(area2)) : vec3_normalize(vec3_neg(direction));
    vec3 const shading_normal = compute_shading_normal(geometry, triangle, w, normal);
    point->is_front = slope < 0.0;
    point->normal = point->is_front ? normal : vec3_neg(normal);
    point->shading_normal = point->is_front ? shading_normal : vec3_neg(shading_normal);
}

void render_point_set_floor(double height, vec3 origin, vec3 direction, double distance,
                            render_point *point) {
    vec3 const normal = vec3_make(0.0, 0.0, direction.z < 0.0 ? 1.0 : -1.0);
    *point = (render_point){.triangle = TULLE_NONE,
                            .distance = distance,
                            .position = vec3_add_scaled(origin, direction, distance),
                            .normal = normal,
                            .shading_normal = normal,
                            .is_front = true};
    point->position.z = height;
}

vec3 render_point_get_lift(const render_geometry *geometry, const render_point *point) {
    vec3 lift = {0};
    uint32_t const t = point->triangle;
    if (t == TULLE_NONE || !geometry->parts[geometry->part_index[t]].is_smooth) return lift;
    for (int i = 0; i < 3; i++) {
        vec3 const vertex =
            render_geometry_get_vertex(geometry, geometry->triangles[3 * (size_t)t + (size_t)i]);
        vec3 normal = load_float3(geometry->corner_normals + 9 * (size_t)t + 3 * (size_t)i);
        if (!point->is_front) normal = vec3_neg(normal);
        double const height = vec3_dot(vec3_sub(vertex, point->position), normal);
        if (height > 0.0) lift = vec3_add_scaled(lift, normal, point->weights[i] * height);
    }
    return lift;
}

double render_point_get_offset(const render_geometry *geometry, const render_point *point) {
    double const size = fabs(point->position.x) + fabs(point->position.y) + fabs(point->position.z);
    double const reach =
        point->triangle == TULLE_NONE ? 0.0 : (double)geometry->reach[point->triangle];
    return unit_roundoff * (position_roundings * size + plane_roundings * reach);
}
