/* render/render.h - ray traced pictures of triangle surfaces: what to draw, from where, in what
 * light, and the call that makes a picture of it.
 *
 * The picture is a function of the input alone: the same bits for any number of threads, run after
 * run on one machine. On another machine single samples may differ (sine and cosine of its C
 * library, divisions of its processor in the ray tracer). Lengths in metres, angles in radians,
 * colors linear RGB in 0 .. 1. */
#ifndef TULLE_RENDER_RENDER_H
#define TULLE_RENDER_RENDER_H

#include "render/image.h"

#include <stdbool.h>

typedef enum render_pattern {
    RENDER_PATTERN_PLAIN,
    RENDER_PATTERN_WEAVE, /* two threads over and under, fine enough to read as cloth */
    RENDER_PATTERN_CHECK  /* squares of pattern_size, so that stretch and slip can be seen */
} render_pattern;

typedef struct render_surface {
    tulle_mesh_view mesh;
    /* [m] 2 * vertex_count: where each vertex lies in the flat cloth at rest; null: plain. */
    const double *rest_coordinates;
    const float *vertex_colors;   /* 3 * vertex_count, in place of the material; null: material */
    const float *triangle_colors; /* 3 * triangle_count, the same; null: material */
    float front_color[3];         /* of the side from which a triangle turns counter-clockwise */
    float back_color[3];          /* of the other side */
    render_pattern pattern;
    double pattern_size; /* [m] of a square, or from one thread to the next */
    double crease_angle; /* [rad] edges whose triangles turn by more are sharp; 0: all, INFINITY:
                            none but open ones */
    bool has_wire;       /* its edges are drawn as thin lines */
} render_surface;

/* A ball that marks a place, drawn in its color without shading. */
typedef struct render_mark {
    double position[3], radius;
    float color[3];
} render_mark;

typedef struct render_camera {
    double position[3], target[3], up[3];
    double field_of_view; /* [rad] of the picture's height, 0 .. pi */
} render_camera;

typedef struct render_lighting {
    double light_direction[3]; /* to the middle of the light; z is up */
    double light_angle;        /* [rad] radius of the light as seen from the scene: softness */
    float light_radiance[3];   /* irradiance of a surface that faces the light, over pi */
    float sky_color[3], horizon_color[3]; /* radiance of what surrounds the scene */
    /* An endless floor. It fades into the horizon from as far beyond the camera's target as the
     * camera is from it. A surface that lies in it hides it. */
    bool has_floor;
    double floor_height; /* [m] z of it */
    float floor_color[3];
    uint32_t bounces; /* diffuse bounces that are followed; beyond them the sky is taken as seen */
} render_lighting;
render_lighting render_lighting_default(void);

typedef struct render_frame_def {
    const render_surface *surfaces;
    size_t surface_count;
    const render_mark *marks;
    size_t mark_count;
    render_camera camera;
    render_lighting lighting;
    uint32_t width, height; /* [pixels] */
    uint32_t samples;       /* of each pixel, 1 .. 65536 */
    int threads;            /* 0: one per processor */
    uint64_t seed;
} render_frame_def;

/* Keeps what pictures of a film share. */
typedef struct render_context render_context;

/* Whether the program was built with the ray tracer; else render_context_create fails with
 * TULLE_ERROR_UNSUPPORTED and a message that says how to build it. */
bool render_is_available(void);
tulle_status render_context_create(render_context **context, tulle_error *error);
void render_context_destroy(render_context *context); /* null is fine */

/* Radiance of each pixel, 3 * width * height floats, rows from the top. Errors:
 * TULLE_ERROR_INVALID_ARGUMENT (what is wrong with the def), TULLE_ERROR_OUT_OF_MEMORY. */
tulle_status render_trace(render_context *context, const render_frame_def *def, float *radiance,
                          tulle_error *error);
/* How much of some surfaces a camera sees, in pixels. */
typedef struct render_sight {
    render_camera camera;
    size_t covered;    /* pixels in which they would be if nothing stood before them */
    size_t seen;       /* those in which they are */
    size_t *hidden_by; /* of the others, how many each surface hides, and last the floor:
                          surface_count + 1; null: not asked */
} render_sight;
/* Looks from each camera at the first wanted_count surfaces of the def, whose width and height say
 * how finely, and adds to the numbers. The def's own camera, marks and samples have no
 * part. Errors as of render_trace. */
tulle_status render_find_sights(render_context *context, const render_frame_def *def,
                                size_t wanted_count, render_sight *sights, size_t sight_count,
                                tulle_error *error);
/* Radiance to sRGB by a curve that rises everywhere and stays below white: nothing clips, and
 * frames of a film do not flicker. */
void render_expose(const float *radiance, double exposure, render_image *image);

/* A camera that sees the box whole at this aspect ratio (width over height), from the direction of
 * azimuth (from +x towards +y) and elevation [rad]. */
render_camera render_camera_frame(const double bounds_min[3], const double bounds_max[3],
                                  double azimuth, double elevation, double aspect);

#endif
