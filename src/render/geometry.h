/* render/geometry.h - all surfaces of a picture as one list of triangles, as the ray tracer wants
 * it: single precision about a center, with normals at the corners.
 *
 * The rounded vertices are the surface from here on: hits are computed on them in double, so a hit
 * and the rays that leave it mean the same triangles. */
#ifndef TULLE_RENDER_GEOMETRY_H
#define TULLE_RENDER_GEOMETRY_H

#include "render/render.h"

#include "math/vec3.h"

typedef struct render_part {
    const render_surface *surface;
    uint32_t first_vertex, first_triangle;
    bool is_smooth; /* corner normals hold */
} render_part;

typedef struct render_geometry {
    vec3 center;          /* [m] what the coordinates below are relative to */
    double radius;        /* [m] of a ball about the center that holds everything; 0: empty */
    float *vertices;      /* 3 * vertex_count and one float of padding */
    uint32_t *triangles;  /* 3 * triangle_count */
    uint32_t *part_index; /* triangle_count */
    /* [m] triangle_count: the longest edge of any triangle that shares a vertex with it. */
    float *reach;
    float *corner_normals; /* 9 * triangle_count, unit; null when no part is smooth */
    render_part *parts;    /* part_count */
    size_t vertex_count, triangle_count, part_count;
    memory heap;
} render_geometry;

/* Rounds, joins and prepares. The def is valid. Errors: TULLE_ERROR_OUT_OF_MEMORY. */
tulle_status render_geometry_build(const render_frame_def *def, render_geometry *geometry,
                                   tulle_error *error);
void render_geometry_destroy(render_geometry *geometry);

/* Normals of corners, 9 * triangle_count. The normal of a corner is the mean, weighted by angle, of
 * triangles about its vertex: of those that are reached from its own over smooth edges. An edge is
 * smooth if it has exactly two triangles, both turned the same way round, and they meet at an angle
 * of crease_angle at most. False when memory is short. */
bool render_compute_corner_normals(memory *heap, tulle_mesh_view mesh, double crease_angle,
                                   float *corner_normals);

static inline vec3 render_geometry_get_vertex(const render_geometry *geometry, uint32_t vertex) {
    const float *const v = geometry->vertices + 3 * (size_t)vertex;
    return vec3_make((double)v[0], (double)v[1], (double)v[2]);
}

#endif
