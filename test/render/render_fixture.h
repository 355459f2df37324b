/* Scenes for tests of the ray tracer: a picture as floats, rectangles, boxes, and a skip where the
 * program has no ray tracer. */
#ifndef TULLE_TEST_RENDER_FIXTURE_H
#define TULLE_TEST_RENDER_FIXTURE_H

#include "support/test_support.h"

#include "render/render.h"

#include "math/vec3.h"
#include "tulle/mesh.h"
#include "tulle/shapes.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SKIPPED = 77 };

/* For main: exit code of a test program that cannot run here, or 0. */
static inline int skip_without_ray_tracer(void) {
    if (render_is_available()) return 0;
    printf("skipped: this build has no ray tracer (Embree)\n");
    return SKIPPED;
}

static inline tulle_mesh make_sphere(uint32_t resolution, double radius) {
    tulle_shape_def def = tulle_shape_def_default(TULLE_SHAPE_SPHERE);
    def.radius = radius;
    def.resolution[0] = resolution;
    tulle_mesh sphere;
    assert_int_equal(tulle_shape_generate(&def, &sphere, NULL), TULLE_OK);
    return sphere;
}

/* A mesh that a test fills by hand. */
typedef struct small_mesh {
    double positions[3 * 64];
    uint32_t triangles[3 * 64];
    size_t vertex_count, triangle_count;
} small_mesh;

static inline tulle_mesh_view small_mesh_view(const small_mesh *mesh) {
    return (tulle_mesh_view){mesh->positions, mesh->vertex_count, mesh->triangles,
                             mesh->triangle_count};
}

/* A quadrilateral, corners in turn. */
static inline void add_quad(small_mesh *mesh, vec3 a, vec3 b, vec3 c, vec3 d) {
    uint32_t const v = (uint32_t)mesh->vertex_count;
    uint32_t const corners[6] = {v, v + 1, v + 2, v, v + 2, v + 3};
    vec3_store(mesh->positions, v, a);
    vec3_store(mesh->positions, v + 1, b);
    vec3_store(mesh->positions, v + 2, c);
    vec3_store(mesh->positions, v + 3, d);
    memcpy(mesh->triangles + 3 * mesh->triangle_count, corners, sizeof corners);
    mesh->vertex_count += 4;
    mesh->triangle_count += 2;
}

/* A rectangle at height z, seen from above counter-clockwise. */
static inline void add_rectangle(small_mesh *mesh, double x0, double y0, double x1, double y1,
                                 double z) {
    add_quad(mesh, vec3_make(x0, y0, z), vec3_make(x1, y0, z), vec3_make(x1, y1, z),
             vec3_make(x0, y1, z));
}

/* A box that shares its eight vertices, turned outwards. */
static inline small_mesh make_box(vec3 low, vec3 high) {
    static const uint32_t triangles[36] = {0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4,
                                           2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5};
    small_mesh mesh = {.vertex_count = 8, .triangle_count = 12};
    for (unsigned i = 0; i < 8; i++)
        vec3_store(
            mesh.positions, i,
            vec3_make(i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z));
    memcpy(mesh.triangles, triangles, sizeof triangles);
    return mesh;
}

/* A surface of one gray on both sides. */
static inline render_surface make_surface(tulle_mesh_view mesh, float gray) {
    return (render_surface){
        .mesh = mesh, .front_color = {gray, gray, gray}, .back_color = {gray, gray, gray}};
}

/* No light at all, no floor, no bounces; the test turns on what it is about. */
static inline render_lighting make_dark(void) {
    return (render_lighting){.light_direction = {0.0, 0.0, 1.0}};
}

static inline void set_gray(float color[3], float gray) { color[0] = color[1] = color[2] = gray; }

static inline render_frame_def make_frame(const render_surface *surfaces, size_t surface_count) {
    return (render_frame_def){
        .surfaces = surfaces,
        .surface_count = surface_count,
        .camera = {.position = {0.0, 0.0, 10.0}, .up = {0.0, 1.0, 0.0}, .field_of_view = 0.5},
        .lighting = make_dark(),
        .width = 48,
        .height = 27,
        .samples = 16,
        .threads = 2,
        .seed = 1};
}

/* The picture, 3 * width * height floats; the caller frees it. */
static inline float *trace(const render_frame_def *def) {
    render_context *context;
    tulle_error error = {0};
    if (render_context_create(&context, &error) != TULLE_OK) fail_msg("%s", error.message);
    float *const radiance = calloc(3 * (size_t)def->width * def->height, sizeof *radiance);
    assert_non_null(radiance);
    if (render_trace(context, def, radiance, &error) != TULLE_OK) fail_msg("%s", error.message);
    render_context_destroy(context);
    return radiance;
}

/* The ray through a place of the picture, in pixels from the top left corner; not normalized. */
static inline vec3 get_view_ray(const render_frame_def *def, double column, double row) {
    const render_camera *const camera = &def->camera;
    vec3 const forward =
        vec3_normalize(vec3_sub(vec3_load(camera->target, 0), vec3_load(camera->position, 0)));
    vec3 const right = vec3_normalize(vec3_cross(forward, vec3_load(camera->up, 0)));
    vec3 const up = vec3_cross(right, forward);
    double const pixel = 2.0 * tan(0.5 * camera->field_of_view) / def->height;
    return vec3_add_scaled(vec3_add_scaled(forward, right, pixel * (column - 0.5 * def->width)), up,
                           pixel * (0.5 * def->height - row));
}

/* Place `index` of `count` of the picture's filter: a tent of this half width, cut into parts of
 * the same weight. */
#define FILTER_RADIUS 0.9
static inline double get_filter_place(int index, int count) {
    double const u = (index + 0.5) / count;
    return FILTER_RADIUS * (u < 0.5 ? sqrt(2.0 * u) - 1.0 : 1.0 - sqrt(2.0 - 2.0 * u));
}

#endif
