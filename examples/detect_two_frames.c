/* detect_two_frames - a square of cloth curls up within one time step; where does it first touch
 * itself on the way, with 1 mm of thickness? */
#include <tulle/tulle.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static tulle_error error;

static void require(tulle_status status) {
    if (status == TULLE_OK) return;
    fprintf(stderr, "%s: %s\n", tulle_status_text(status), error.message);
    exit(2);
}

/* The square bent to a cylinder by `angle` [rad] altogether. */
static double *bend(tulle_mesh_view square, double angle) {
    double *const bent = malloc(3 * square.vertex_count * sizeof *bent);
    for (size_t v = 0; bent && v < square.vertex_count; v++) {
        const double *const x = square.positions + 3 * v;
        bent[3 * v] = sin(angle * x[0]) / angle;
        bent[3 * v + 1] = x[1] * (1.0 + 0.1 * x[0]);
        bent[3 * v + 2] = (1.0 - cos(angle * x[0])) / angle;
    }
    return bent;
}

int main(void) {
    tulle_shape_def shape = tulle_shape_def_default(TULLE_SHAPE_RECTANGLE);
    shape.size[0] = shape.size[1] = 1.0;
    shape.resolution[0] = shape.resolution[1] = 40;
    tulle_mesh mesh = {0};
    require(tulle_shape_generate(&shape, &mesh, &error));
    tulle_mesh_view const square = tulle_mesh_get_view(&mesh);
    double *const start = bend(square, 5.5), *const end = bend(square, 7.0);
    if (!start || !end) return 2;

    tulle_detect_def def = tulle_detect_def_default();
    def.triangles = square.triangles;
    def.triangle_count = square.triangle_count;
    def.vertex_count = square.vertex_count;
    def.thickness = 1e-3;
    tulle_detector *detector = NULL;
    require(tulle_detector_create(&def, &detector, &error));
    tulle_detect_result result;
    require(tulle_detector_find_events(detector, start, end, &result, &error));
    for (size_t i = 0; i < result.event_count; i++) {
        const tulle_detect_event *const e = &result.events[i];
        if (e->time > result.earliest_time) continue;
        printf("first at t = %.4f: %s, vertices %u %u %u %u\n", e->time,
               e->kind == TULLE_DETECT_VERTEX_FACE ? "vertex/face" : "edge/edge", e->vertices[0],
               e->vertices[1], e->vertices[2], e->vertices[3]);
    }
    printf("%zu events\n", result.event_count);
    tulle_detector_destroy(detector);
    tulle_mesh_destroy(&mesh);
    free(start), free(end);
}
