/* Times pictures of a 99 x 99 cloth in folds over a ball (25,000 triangles) on a floor, 640 x 360:
 * with few samples, at the default quality, and with more bounces. Prints samples of pixels a
 * second beside minimum and median times [s] as CSV; a sample follows up to 2 + 2 * bounces rays.
 * Usage: bench_render [rounds [threads]] */
#include "base/sort.h"
#include "base/timer.h"
#include "render/render.h"

#include "tulle/mesh.h"
#include "tulle/shapes.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { SIDE = 99, WIDTH = 640, HEIGHT = 360, ROUNDS_MAX = 101 };

typedef struct quality {
    const char *name;
    uint32_t samples, bounces;
} quality;

static const quality qualities[] = {
    {"one sample", 1, 2}, {"no bounce", 32, 0}, {"one bounce", 32, 1}, {"default", 32, 2}};

/* A cloth of 2 m laid over a ball of radius 0.5 m, its rest hanging in folds. */
static void drape(tulle_mesh *cloth) {
    double const radius = 0.51, quarter = 0.5 * 3.14159265358979323846 * radius;
    for (size_t v = 0; v < cloth->vertex_count; v++) {
        double *const p = cloth->positions + 3 * v;
        double const reach = hypot(p[0], p[1]), angle = atan2(p[1], p[0]);
        double const on_ball = fmin(reach, quarter) / radius, drop = fmax(reach - quarter, 0.0);
        double const around = radius * sin(on_ball) + 0.4 * drop * sin(11.0 * angle);
        p[0] = around * cos(angle);
        p[1] = around * sin(angle);
        p[2] = 0.8 + radius * cos(on_ball) - 0.9 * drop;
    }
}

static int make_surfaces(tulle_mesh meshes[2], render_surface surfaces[2]) {
    tulle_shape_def sheet = tulle_shape_def_default(TULLE_SHAPE_RECTANGLE);
    sheet.size[0] = sheet.size[1] = 2.0;
    sheet.resolution[0] = sheet.resolution[1] = SIDE;
    tulle_shape_def ball = tulle_shape_def_default(TULLE_SHAPE_SPHERE);
    ball.radius = 0.5;
    ball.resolution[0] = 17;
    if (tulle_shape_generate(&sheet, &meshes[0], NULL) != TULLE_OK ||
        tulle_shape_generate(&ball, &meshes[1], NULL) != TULLE_OK)
        return 0;
    drape(&meshes[0]);
    for (size_t v = 0; v < meshes[1].vertex_count; v++) meshes[1].positions[3 * v + 2] += 0.8;
    for (int i = 0; i < 2; i++)
        surfaces[i] = (render_surface){.mesh = tulle_mesh_get_view(&meshes[i]),
                                       .front_color = {0.45f, 0.07f, 0.06f},
                                       .back_color = {0.72f, 0.5f, 0.3f},
                                       .crease_angle = i == 0 ? (double)INFINITY : 0.6};
    return 1;
}

static void time_quality(render_context *context, render_frame_def *def, const quality *q,
                         int rounds, float *radiance) {
    double times[ROUNDS_MAX];
    def->samples = q->samples;
    def->lighting.bounces = q->bounces;
    for (int round = 0; round < rounds; round++) {
        double const start = timer_now();
        if (render_trace(context, def, radiance, NULL) != TULLE_OK) exit(1);
        times[round] = timer_now() - start;
    }
    qsort(times, (size_t)rounds, sizeof *times, compare_doubles);
    printf("%s,%u,%u,%.3f,%.3f,%.2f\n", q->name, q->samples, q->bounces, times[0],
           times[rounds / 2], 1e-6 * WIDTH * HEIGHT * q->samples / times[0]);
    fflush(stdout);
}

int main(int argc, char **argv) {
    int rounds = argc > 1 ? atoi(argv[1]) : 3;
    if (rounds < 1 || rounds > ROUNDS_MAX) rounds = 3;
    render_context *context;
    tulle_error error;
    tulle_mesh meshes[2];
    render_surface surfaces[2];
    float *const radiance = calloc(3 * WIDTH * HEIGHT, sizeof *radiance);
    if (render_context_create(&context, &error) != TULLE_OK) {
        fprintf(stderr, "%s\n", error.message);
        return 1;
    }
    if (!radiance || !make_surfaces(meshes, surfaces)) return 1;
    double const low[3] = {-0.8, -0.8, 0.0}, high[3] = {0.8, 0.8, 1.3};
    render_frame_def def = {.surfaces = surfaces,
                            .surface_count = 2,
                            .camera = render_camera_frame(low, high, -1.05, 0.4, 16.0 / 9.0),
                            .lighting = render_lighting_default(),
                            .width = WIDTH,
                            .height = HEIGHT,
                            .threads = argc > 2 ? atoi(argv[2]) : 0};
    printf("quality,samples,bounces,min_s,median_s,msamples_per_s\n");
    for (size_t i = 0; i < sizeof qualities / sizeof *qualities; i++)
        time_quality(context, &def, &qualities[i], rounds, radiance);
    for (int i = 0; i < 2; i++) tulle_mesh_destroy(&meshes[i]);
    render_context_destroy(context);
    free(radiance);
    return 0;
}
