/* render/surface_point.h - a place on a surface that a ray has found: where exactly, which way it
 * faces, what color it has, and from where a further ray may leave. */
#ifndef TULLE_RENDER_SURFACE_POINT_H
#define TULLE_RENDER_SURFACE_POINT_H

#include "render/geometry.h"

typedef struct render_point {
    uint32_t triangle; /* TULLE_NONE: the floor */
    double weights[3]; /* barycentric */
    double distance;   /* along the ray, in lengths of its direction */
    vec3 position;
    vec3 normal;         /* unit, of the triangle, towards where the ray came from */
    vec3 shading_normal; /* unit, the same side */
    bool is_front;
} render_point;

/* How far the ray through a pixel turns from one pixel to the next, across and down. */
typedef struct render_footprint {
    vec3 direction;    /* of the ray, as long as render_point.distance counts */
    vec3 across, down; /* change of it over one pixel */
} render_footprint;

/* The point where a ray meets a triangle, in double on the rounded vertices; always a point of the
 * triangle. */
void render_point_find(const render_geometry *geometry, uint32_t triangle, vec3 origin,
                       vec3 direction, render_point *point);
/* A point of the floor. */
void render_point_set_floor(double height, vec3 origin, vec3 direction, double distance,
                            render_point *point);

/* [m] How far from the surface, along point.normal, a ray must start so that rounding puts it on
 * the right side of the triangle and of those around it. */
double render_point_get_offset(const render_geometry *geometry, const render_point *point);

/* [m] From the point to the curved surface that the corner normals speak of, where that bulges out
 * of the triangle; zero elsewhere, and on flat parts. */
vec3 render_point_get_lift(const render_geometry *geometry, const render_point *point);

/* Share of the light that the surface sends back. footprint: of the pixel, for wires and patterns;
 * null: patterns are their mean and wires are left out. */
void render_point_get_color(const render_geometry *geometry, const render_point *point,
                            const render_footprint *footprint, double color[3]);

#endif
