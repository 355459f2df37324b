/* step/ties/place_ties.c - where on a surface a vertex is attached.
 *
 * A place is barycentric coordinates of the vertex' foot in the plane of a triangle, and its height
 * over that plane. A foot beyond the triangle's border has coordinates below 0. */
#include "geom/distance.h"
#include "step/ties/ties.h"

#include <math.h>

/* [m^2 over edge^2] twice the area of a triangle below this share of its longest edge squared has
 * no plane. */
static const double FLAT = 1e-12;

typedef struct corner_frame {
    vec3 corner, along, beside, normal; /* first corner, two edges, unit normal */
    bool is_flat;                       /* and the normal is zero */
} corner_frame;

static corner_frame make_frame(const uint32_t corners[3], const double *positions) {
    vec3 const a = vec3_load(positions, corners[0]);
    vec3 const along = vec3_sub(vec3_load(positions, corners[1]), a);
    vec3 const beside = vec3_sub(vec3_load(positions, corners[2]), a);
    vec3 const area = vec3_cross(along, beside);
    double const size = vec3_norm(area);
    bool const is_flat = !(size > FLAT * (vec3_norm2(along) + vec3_norm2(beside)));
    vec3 const zero = {0.0, 0.0, 0.0};
    return (corner_frame){a, along, beside, is_flat ? zero : vec3_scale(area, 1.0 / size), is_flat};
}

vec3 step_get_tie_place(const world_tie *tie, const double *positions) {
    if (tie->corners[0] == TULLE_NONE) return vec3_load(tie->point, 0);
    corner_frame const frame = make_frame(tie->corners, positions);
    vec3 place = vec3_add_scaled(frame.corner, frame.along, tie->weights[1]);
    place = vec3_add_scaled(place, frame.beside, tie->weights[2]);
    return vec3_add_scaled(place, frame.normal, tie->height);
}

void step_get_tie_tilt(const world_tie *tie, const double *positions, row_tilt *tilt) {
    corner_frame const frame = make_frame(tie->corners, positions);
    vec3 const area = vec3_cross(frame.along, frame.beside);
    double const factor = frame.is_flat ? 0.0 : tie->height / vec3_norm(area);
    /* the gradient of a corner's coordinate is n x (the edge that faces it) / |area| */
    tilt->normal = frame.normal;
    tilt->arms[1] = vec3_scale(vec3_cross(frame.beside, frame.normal), factor);
    tilt->arms[2] = vec3_scale(vec3_cross(frame.normal, frame.along), factor);
    tilt->arms[0] = vec3_scale(vec3_add(tilt->arms[1], tilt->arms[2]), -1.0);
}

static void load_corners(const step_model *model, uint32_t triangle, uint32_t corners[3]) {
    for (size_t k = 0; k < 3; k++) corners[k] = model->topo.triangles[3 * (size_t)triangle + k];
}

void step_set_tie_place(const step_model *model, step_work *work, uint32_t vertex,
                        uint32_t triangle, const double weights[3], world_tie *tie) {
    const double *const positions = work->start->positions;
    load_corners(model, triangle, tie->corners);
    corner_frame const frame = make_frame(tie->corners, positions);
    vec3 const way = vec3_sub(vec3_load(positions, vertex), frame.corner);
    for (int k = 0; k < 3; k++) tie->weights[k] = weights[k];
    tie->height = vec3_dot(way, frame.normal);
}

/* Coordinates of the vertex' own foot. */
static void set_own_place(const step_model *model, step_work *work, uint32_t vertex,
                          uint32_t triangle, const closest_points *closest, world_tie *tie) {
    uint32_t corners[3];
    load_corners(model, triangle, corners);
    corner_frame const frame = make_frame(corners, work->start->positions);
    double weights[3] = {-closest->weights[1], -closest->weights[2], -closest->weights[3]};
    if (!frame.is_flat) {
        vec3 const way = vec3_sub(vec3_load(work->start->positions, vertex), frame.corner);
        double const aa = vec3_norm2(frame.along), bb = vec3_norm2(frame.beside);
        double const ab = vec3_dot(frame.along, frame.beside), determinant = aa * bb - ab * ab;
        double const a = vec3_dot(way, frame.along), b = vec3_dot(way, frame.beside);
        weights[1] = (bb * a - ab * b) / determinant;
        weights[2] = (aa * b - ab * a) / determinant;
        weights[0] = 1.0 - weights[1] - weights[2];
    }
    step_set_tie_place(model, work, vertex, triangle, weights, tie);
}

bool step_find_tie_place(const step_model *model, step_work *work, uint32_t vertex,
                         uint32_t surface, double distance, world_tie *tie) {
    const double *const positions = work->start->positions;
    const surface_range *const range = &work->surfaces[surface];
    vec3 const x = vec3_load(positions, vertex);
    double least2 = distance * distance; /* may be infinite */
    uint32_t nearest = TULLE_NONE;
    closest_points found = {0};
    for (uint32_t t = range->triangle_begin; t < range->triangle_end; t++) {
        uint32_t corners[3];
        load_corners(model, t, corners);
        if (corners[0] == vertex || corners[1] == vertex || corners[2] == vertex) continue;
        vec3 const a = vec3_load(positions, corners[0]), b = vec3_load(positions, corners[1]);
        vec3 const c = vec3_load(positions, corners[2]);
        closest_points const closest = closest_vertex_triangle((const vec3[4]){x, a, b, c});
        if (closest.distance2 > least2 || (nearest != TULLE_NONE && closest.distance2 == least2))
            continue;
        least2 = closest.distance2;
        nearest = t;
        found = closest;
    }
    if (nearest == TULLE_NONE) return false;
    set_own_place(model, work, vertex, nearest, &found, tie);
    return true;
}
