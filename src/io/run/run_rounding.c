/* io/run/run_rounding.c - see run_rounding.h. */
#include "io/run/run_rounding.h"

#include "base/error.h"

#include "tulle/check.h"

#include <math.h>
#include <string.h>

enum { SURFACES_MAX = 4096 /* of a detector; more bodies are one surface there */ };

/* The first pair of features that rounding may bring together. */
typedef struct rounding_search {
    const run_rounding *rounding;
    const int *is_present; /* of each body; null: all are */
    bool has_event;
    uint32_t vertices[4];
    size_t bodies[2];
} rounding_search;

bool run_rounding_make(run_rounding *rounding, memory *heap, const tulle_run_def *def) {
    size_t const count = def->body_count;
    *rounding =
        (run_rounding){.heap = heap,
                       .unit = "m",
                       .body_count = count,
                       .threads = def->threads >= 1 && def->threads <= 256 ? def->threads : 0};
    for (size_t i = 0; i < count; i++) {
        rounding->vertex_count += def->bodies[i].mesh.vertex_count;
        rounding->triangle_count += def->bodies[i].mesh.triangle_count;
    }
    rounding->surfaces = memory_allocate_zeroed(heap, count, sizeof *rounding->surfaces);
    rounding->triangles =
        memory_allocate_zeroed(heap, 3 * rounding->triangle_count, sizeof(uint32_t));
    rounding->exact = memory_allocate_zeroed(heap, 3 * rounding->vertex_count, sizeof(double));
    rounding->rounded = memory_allocate_zeroed(heap, 3 * rounding->vertex_count, sizeof(double));
    if (!rounding->surfaces || !rounding->triangles || !rounding->exact || !rounding->rounded)
        return false;
    uint32_t vertex = 0, triangle = 0;
    for (size_t i = 0; i < count; i++) {
        const tulle_run_body *const body = &def->bodies[i];
        tulle_mesh_view const mesh = body->mesh;
        bool const is_body = body->is_obstacle && body->is_dynamic;
        rounding->surfaces[i] = (tulle_detect_surface){
            .vertex_begin = vertex,
            .vertex_end = vertex + (uint32_t)mesh.vertex_count,
            .triangle_begin = triangle,
            .triangle_end = triangle + (uint32_t)mesh.triangle_count,
            .is_obstacle = body->is_obstacle && !is_body,
            .is_static = body->is_static,
            .ignores_self = is_body,
        };
        for (size_t k = 0; k < 3 * mesh.triangle_count; k++)
            rounding->triangles[3 * (size_t)triangle + k] = vertex + mesh.triangles[k];
        memcpy(rounding->exact + 3 * (size_t)vertex, mesh.positions,
               3 * mesh.vertex_count * sizeof(double));
        vertex += (uint32_t)mesh.vertex_count;
        triangle += (uint32_t)mesh.triangle_count;
    }
    memcpy(rounding->rounded, rounding->exact, 3 * rounding->vertex_count * sizeof(double));
    return true;
}

void run_rounding_release(run_rounding *rounding) {
    tulle_detector_destroy(rounding->detector);
    memory *const heap = rounding->heap;
    if (!heap) return;
    memory_release(heap, rounding->surfaces, rounding->body_count * sizeof *rounding->surfaces);
    memory_release(heap, rounding->triangles, 3 * rounding->triangle_count * sizeof(uint32_t));
    memory_release(heap, rounding->exact, 3 * rounding->vertex_count * sizeof(double));
    memory_release(heap, rounding->rounded, 3 * rounding->vertex_count * sizeof(double));
    *rounding = (run_rounding){0};
}

/* Where the bodies are and where their caches will have them. False where nothing is rounded, or
 * where float holds a coordinate not at all, which writing refuses. */
static bool take_positions(run_rounding *rounding, const tulle_run_frame *frame,
                           const double *const *written) {
    bool is_rounded = false;
    for (size_t i = 0; i < rounding->body_count; i++) {
        const tulle_detect_surface *const body = &rounding->surfaces[i];
        size_t const count = 3 * (size_t)(body->vertex_end - body->vertex_begin);
        if (body->is_static) continue;
        double *const exact = rounding->exact + 3 * (size_t)body->vertex_begin;
        double *const rounded = rounding->rounded + 3 * (size_t)body->vertex_begin;
        for (size_t k = 0; k < count; k++) {
            exact[k] = frame->positions[i][k];
            rounded[k] = written && written[i] ? written[i][k] : (double)(float)exact[k];
            if (!isfinite(rounded[k])) return false;
            is_rounded = is_rounded || rounded[k] != exact[k];
        }
    }
    return is_rounded;
}

static size_t find_body(const run_rounding *rounding, uint32_t vertex) {
    size_t low = 0, high = rounding->body_count - 1;
    while (low < high) {
        size_t const middle = low + (high - low) / 2;
        if (vertex < rounding->surfaces[middle].vertex_end)
            high = middle;
        else
            low = middle + 1;
    }
    return low;
}

/* Takes the first pair of bodies that are there and may not meet. */
static int take_event(void *context, const tulle_detect_event *events, size_t count) {
    rounding_search *const search = context;
    for (size_t i = 0; i < count && !search->has_event; i++) {
        size_t const a = find_body(search->rounding, events[i].vertices[0]);
        size_t const b = find_body(search->rounding, events[i].vertices[3]);
        const tulle_detect_surface *const first = &search->rounding->surfaces[a];
        if (first->is_obstacle && search->rounding->surfaces[b].is_obstacle) continue;
        if (a == b && first->ignores_self) continue;
        if (search->is_present && (!search->is_present[a] || !search->is_present[b])) continue;
        search->has_event = true;
        search->bodies[0] = a;
        search->bodies[1] = b;
        memcpy(search->vertices, events[i].vertices, sizeof search->vertices);
    }
    return search->has_event;
}

/* *is_clean: nothing intersects before it is rounded. */
static tulle_status judge_exact(const run_rounding *rounding, const tulle_run_frame *frame,
                                bool *is_clean, tulle_error *error) {
    size_t const size = rounding->body_count * sizeof(tulle_check_body);
    tulle_check_body *const bodies = memory_allocate(rounding->heap, size);
    if (!bodies) return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "out of memory for the frame");
    size_t count = 0;
    for (size_t i = 0; i < rounding->body_count; i++) {
        const tulle_detect_surface *const body = &rounding->surfaces[i];
        if (frame->is_present && !frame->is_present[i]) continue;
        bodies[count++] =
            (tulle_check_body){.mesh = {rounding->exact, rounding->vertex_count,
                                        rounding->triangles + 3 * (size_t)body->triangle_begin,
                                        body->triangle_end - body->triangle_begin},
                               .is_obstacle = body->is_obstacle || body->ignores_self};
    }
    tulle_check_result result = {0};
    tulle_status status =
        tulle_check_intersections(bodies, count, rounding->threads, &result, error);
    *is_clean = status == TULLE_OK && result.pair_count == 0;
    if (status == TULLE_ERROR_LIMIT) status = TULLE_OK; /* too many pairs to list */
    tulle_check_result_destroy(&result);
    memory_release(rounding->heap, bodies, size);
    return status;
}

/* How far rounding moves a vertex [m]. */
static double measure_rounding(const run_rounding *rounding, uint32_t vertex) {
    const double *const from = rounding->exact + 3 * (size_t)vertex;
    const double *const to = rounding->rounded + 3 * (size_t)vertex;
    return sqrt((to[0] - from[0]) * (to[0] - from[0]) + (to[1] - from[1]) * (to[1] - from[1]) +
                (to[2] - from[2]) * (to[2] - from[2]));
}

static tulle_status refuse(const rounding_search *search,
                           const char *(*get_name)(const void *context, size_t body),
                           const void *context, tulle_error *error) {
    const run_rounding *const rounding = search->rounding;
    uint32_t vertex = search->vertices[0];
    for (int k = 1; k < 4; k++)
        if (measure_rounding(rounding, search->vertices[k]) > measure_rounding(rounding, vertex))
            vertex = search->vertices[k];
    size_t const body = find_body(rounding, vertex);
    size_t const other = search->bodies[0] == body ? search->bodies[1] : search->bodies[0];
    const double *const x = rounding->exact + 3 * (size_t)vertex;
    return error_set(error, TULLE_ERROR_LIMIT,
                     "move vertex %u of '%s' at (%.6g, %.6g, %.6g) %s by %.2g %s, and so through "
                     "%s%s%s",
                     vertex - rounding->surfaces[body].vertex_begin, get_name(context, body), x[0],
                     x[1], x[2], rounding->unit, measure_rounding(rounding, vertex), rounding->unit,
                     other == body ? "itself" : "'", other == body ? "" : get_name(context, other),
                     other == body ? "" : "'");
}

tulle_status run_rounding_judge(run_rounding *rounding, const tulle_run_frame *frame,
                                const double *const *written,
                                const char *(*get_name)(const void *context, size_t body),
                                const void *context, tulle_error *error) {
    if (!take_positions(rounding, frame, written)) return TULLE_OK;
    tulle_status status = TULLE_OK;
    if (!rounding->detector) {
        tulle_detect_def def = tulle_detect_def_default();
        def.triangles = rounding->triangles;
        def.triangle_count = rounding->triangle_count;
        def.vertex_count = rounding->vertex_count;
        if (rounding->body_count <= SURFACES_MAX) {
            def.surfaces = rounding->surfaces;
            def.surface_count = rounding->body_count;
        }
        def.threads = rounding->threads;
        status = tulle_detector_create(&def, &rounding->detector, error);
    }
    rounding_search search = {.rounding = rounding, .is_present = frame->is_present};
    tulle_detect_receiver const receiver = {take_event, &search};
    tulle_detect_result result;
    if (status == TULLE_OK)
        status = tulle_detector_stream_events(rounding->detector, rounding->exact,
                                              rounding->rounded, receiver, &result, error);
    if (status != TULLE_ERROR_INTERRUPTED || !search.has_event) return status;
    bool is_clean = false;
    status = judge_exact(rounding, frame, &is_clean, error);
    if (status != TULLE_OK || !is_clean) return status;
    return refuse(&search, get_name, context, error);
}
