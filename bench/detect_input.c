/* bench/detect_input.c - reads states of a recorded run and makes its cloth finer. */
#include "detect_input.h"

#include "tulle/mesh.h"
#include "tulle_io/run.h"
#include "tulle_io/subdivision.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { PATH_MAX_LENGTH = 1024 };

/* A body of the run as it goes into the input. */
typedef struct input_body {
    size_t index; /* in the run */
    size_t coarse_count, vertex_count, triangle_count;
    tulle_mesh_view mesh;
    tulle_subdivision *subdivision; /* null: as it is */
} input_body;

static void fail(const char *name, const char *what) {
    fprintf(stderr, "bench_detect: %s: %s\n", name, what);
    exit(2);
}

static void *allocate(size_t count, size_t size) {
    void *const memory = calloc(count ? count : 1, size);
    if (!memory) fail("input", "no memory left");
    return memory;
}

static tulle_run_reader *open_run(const char *runs, const input_source *source) {
    char path[PATH_MAX_LENGTH];
    tulle_run_reader *reader = NULL;
    snprintf(path, sizeof path, "%s/%s", runs, source->run);
    if (!tulle_run_is_directory(path)) return NULL;
    return tulle_run_reader_open(path, &reader, NULL) == TULLE_OK ? reader : NULL;
}

int input_exists(const char *runs, const input_source *source) {
    tulle_run_reader *const reader = open_run(runs, source);
    int const exists = reader && tulle_run_reader_get_info(reader)->frame_count > source->frame;
    if (reader) tulle_run_reader_close(reader);
    return exists;
}

/* The bodies that take part: cloths, and obstacles that are there in all three states. */
static size_t choose_bodies(tulle_run_reader *reader, const input_source *source,
                            input_body *bodies) {
    const tulle_run_info *const info = tulle_run_reader_get_info(reader);
    size_t count = 0;
    for (size_t i = 0; i < info->body_count; i++) {
        input_body body = {.index = i, .coarse_count = info->bodies[i].vertex_count};
        int is_present = 1;
        for (uint32_t f = source->frame - 2; f <= source->frame; f++)
            is_present &= tulle_run_reader_is_present(reader, f, i);
        if (!is_present || (info->bodies[i].is_obstacle && !source->has_obstacles)) continue;
        if (count == INPUT_SURFACES_MAX) fail(source->name, "too many bodies");
        if (tulle_run_reader_get_mesh(reader, i, &body.mesh, NULL) != TULLE_OK)
            fail(source->name, "a mesh of the run cannot be read");
        tulle_subdivision_def def = tulle_subdivision_def_default();
        def.levels = source->levels;
        if (source->levels > 0 && !info->bodies[i].is_obstacle &&
            tulle_subdivision_create(body.mesh, &def, &body.subdivision, NULL) != TULLE_OK)
            fail(source->name, "a cloth cannot be subdivided");
        const tulle_subdivision *const made = body.subdivision;
        body.vertex_count =
            made ? tulle_subdivision_get_vertex_count(made) : body.mesh.vertex_count;
        body.triangle_count =
            made ? tulle_subdivision_get_triangle_count(made) : body.mesh.triangle_count;
        bodies[count++] = body;
    }
    return count;
}

/* Positions of a body at a frame (is_rest: as its mesh file has them), made finer, to `to`. */
static void read_positions(tulle_run_reader *reader, const input_body *body, int is_rest,
                           uint32_t frame, double *to) {
    double *const coarse = allocate(3 * body->coarse_count, sizeof *coarse);
    if (is_rest)
        memcpy(coarse, body->mesh.positions, 3 * body->coarse_count * sizeof *coarse);
    else if (tulle_run_reader_read_positions(reader, frame, body->index, coarse, NULL) != TULLE_OK)
        fail("input", "a frame of the run cannot be read");
    if (!body->subdivision)
        memcpy(to, coarse, 3 * body->coarse_count * sizeof *coarse);
    else if (tulle_subdivision_apply(body->subdivision, coarse, 3, to, NULL) != TULLE_OK)
        fail("input", "positions cannot be subdivided");
    free(coarse);
}

static void add_triangles(const input_body *body, uint32_t base, uint32_t *to) {
    const uint32_t *const from = body->subdivision
                                     ? tulle_subdivision_get_triangles(body->subdivision)
                                     : body->mesh.triangles;
    for (size_t i = 0; i < 3 * body->triangle_count; i++) to[i] = base + from[i];
}

static void fill_bodies(tulle_run_reader *reader, const input_source *source,
                        const input_body *bodies, detect_input *input) {
    const tulle_run_info *const info = tulle_run_reader_get_info(reader);
    uint32_t vertex = 0, triangle = 0;
    for (size_t i = 0; i < input->surface_count; i++) {
        const input_body *const body = &bodies[i];
        read_positions(reader, body, 1, 0, input->rest + 3 * (size_t)vertex);
        for (uint32_t k = 0; k < 3; k++)
            read_positions(reader, body, 0, source->frame - 2 + k,
                           input->states[k] + 3 * (size_t)vertex);
        add_triangles(body, vertex, input->triangles + 3 * (size_t)triangle);
        input->surfaces[i] =
            (tulle_detect_surface){.vertex_begin = vertex,
                                   .vertex_end = vertex + (uint32_t)body->vertex_count,
                                   .triangle_begin = triangle,
                                   .triangle_end = triangle + (uint32_t)body->triangle_count,
                                   .is_obstacle = info->bodies[body->index].is_obstacle,
                                   .is_static = info->bodies[body->index].is_static};
        vertex = input->surfaces[i].vertex_end;
        triangle = input->surfaces[i].triangle_end;
    }
}

/* Where a frame has several steps: three states one step apart on the way from the frame before to
 * the last. */
static void shorten_to_steps(detect_input *input, uint32_t steps) {
    for (size_t i = 0; steps > 1 && i < 3 * input->vertex_count; i++) {
        double const begin = input->states[1][i], move = input->states[2][i] - begin;
        for (int k = 0; k < 3; k++) input->states[k][i] = begin + k * move / steps;
    }
}

/* Turns all by 40 degrees about (1, 2, 3). */
static void turn_askew(detect_input *input) {
    double const axis[3] = {1.0 / sqrt(14.0), 2.0 / sqrt(14.0), 3.0 / sqrt(14.0)};
    double const angle = 0.6981317, cosine = cos(angle), sine = sin(angle);
    double *const arrays[] = {input->rest, input->states[0], input->states[1], input->states[2]};
    for (size_t i = 0; i < 4 * input->vertex_count; i++) {
        double *const x = arrays[i / input->vertex_count] + 3 * (i % input->vertex_count);
        double const from[3] = {x[0], x[1], x[2]};
        double const along = axis[0] * x[0] + axis[1] * x[1] + axis[2] * x[2];
        for (int k = 0; k < 3; k++) {
            int const next = (k + 1) % 3, last = (k + 2) % 3;
            x[k] = cosine * from[k] + (1.0 - cosine) * along * axis[k] +
                   sine * (axis[next] * from[last] - axis[last] * from[next]);
        }
    }
}

static double get_distance(const double *a, const double *b) {
    return sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) +
                (a[2] - b[2]) * (a[2] - b[2]));
}

/* Mean edge length and motion of the cloth. */
static void measure_motion(detect_input *input) {
    double edge = 0.0, motion = 0.0;
    size_t edges = 0, vertices = 0;
    for (size_t s = 0; s < input->surface_count; s++) {
        const tulle_detect_surface *const surface = &input->surfaces[s];
        if (surface->is_obstacle) continue;
        for (size_t v = surface->vertex_begin; v < surface->vertex_end; v++, vertices++)
            motion += get_distance(input->states[1] + 3 * v, input->states[2] + 3 * v);
        for (size_t t = surface->triangle_begin; t < surface->triangle_end; t++) {
            const uint32_t *const corners = input->triangles + 3 * t;
            for (int k = 0; k < 3; k++, edges++)
                edge += get_distance(input->states[1] + 3 * (size_t)corners[k],
                                     input->states[1] + 3 * (size_t)corners[(k + 1) % 3]);
        }
    }
    input->edge = edge / (double)edges;
    input->motion = motion / (double)vertices / input->edge;
}

/* Both steps by the same factor, around the state between them. */
static void scale_motion(detect_input *input, double wanted) {
    if (!(wanted > 0.0) || !(input->motion > 0.0)) return;
    double const factor = wanted / input->motion;
    for (size_t i = 0; i < 3 * input->vertex_count; i++) {
        double const middle = input->states[1][i];
        for (int k = 0; k < 3; k += 2)
            input->states[k][i] = middle + factor * (input->states[k][i] - middle);
    }
    input->motion = wanted;
}

void input_load(const char *runs, const input_source *source, detect_input *input) {
    tulle_run_reader *const reader = open_run(runs, source);
    if (!reader) fail(source->name, "no such run; make it with bench/make_inputs.sh");
    if (source->frame < 2 || tulle_run_reader_get_info(reader)->frame_count <= source->frame)
        fail(source->name, "the run has too few frames");
    input_body *const bodies = allocate(INPUT_SURFACES_MAX, sizeof *bodies);
    *input = (detect_input){.name = source->name};
    input->surface_count = choose_bodies(reader, source, bodies);
    for (size_t i = 0; i < input->surface_count; i++) {
        input->vertex_count += bodies[i].vertex_count;
        input->triangle_count += bodies[i].triangle_count;
    }
    input->rest = allocate(3 * input->vertex_count, sizeof *input->rest);
    for (int k = 0; k < 3; k++)
        input->states[k] = allocate(3 * input->vertex_count, sizeof *input->rest);
    input->triangles = allocate(3 * input->triangle_count, sizeof *input->triangles);
    fill_bodies(reader, source, bodies, input);
    shorten_to_steps(input, tulle_run_reader_get_info(reader)->steps_per_frame);
    if (source->is_turned) turn_askew(input);
    measure_motion(input);
    scale_motion(input, source->motion);
    for (size_t i = 0; i < input->surface_count; i++)
        tulle_subdivision_destroy(bodies[i].subdivision);
    free(bodies);
    tulle_run_reader_close(reader);
}

void input_destroy(detect_input *input) {
    free(input->rest);
    for (int k = 0; k < 3; k++) free(input->states[k]);
    free(input->triangles);
    *input = (detect_input){0};
}
