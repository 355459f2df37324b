/* detect/detector/detector.c - the life of a detector and its calls, see tulle/detect.h. Everything
 * that a def points to is copied; all memory comes from the def's allocator. */
#include "base/error.h"
#include "base/parallel.h"
#include "base/timer.h"
#include "detect/detector/detector_parts.h"

#include <math.h>
#include <string.h>

enum { STREAM_BATCH = 1024 }; /* events; as promised in tulle/detect.h */

static tulle_status out_of_memory(tulle_error *error, const char *what) {
    return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory left for %s", what);
}

/* The first edge whose smaller vertex is not below `vertex`. */
static uint32_t find_edge(const topology *topo, uint32_t vertex) {
    size_t low = 0, high = topo->edge_count;
    while (low < high) {
        size_t const middle = low + (high - low) / 2;
        if (topo->edges[2 * middle] < vertex)
            low = middle + 1;
        else
            high = middle;
    }
    return (uint32_t)low;
}

static surface_range make_range(const topology *topo, const tulle_detect_surface *surface) {
    return (surface_range){
        .vertex_begin = surface->vertex_begin,
        .vertex_end = surface->vertex_end,
        .edge_begin = find_edge(topo, surface->vertex_begin),
        .edge_end = find_edge(topo, surface->vertex_end),
        .triangle_begin = surface->triangle_begin,
        .triangle_end = surface->triangle_end,
        .is_obstacle = surface->is_obstacle != 0,
        .is_present = true,
        .ignores_self = surface->ignores_self != 0 || surface->is_obstacle != 0,
        .is_static = surface->is_static != 0,
    };
}

/* Surface s of the def; all there is, when the def has none. */
static tulle_detect_surface get_surface(const tulle_detect_def *def, size_t s) {
    if (def->surfaces) return def->surfaces[s];
    return (tulle_detect_surface){.vertex_end = (uint32_t)def->vertex_count,
                                  .triangle_end = (uint32_t)def->triangle_count,
                                  .thickness = def->thickness};
}

/* Separations of all pairs of surfaces, and what trees and patches must know of them, rounded
 * upward. */
static void compute_separations(tulle_detector *detector, const tulle_detect_def *def) {
    size_t const count = detector->set.surface_count;
    for (size_t a = 0; a < count; a++)
        for (size_t b = 0; b < count; b++) {
            double const sum = get_surface(def, a).thickness + get_surface(def, b).thickness;
            double const separation = 0.5 * sum + def->minimum_separation;
            double const above = separation > 0.0 ? nextafter(separation, (double)INFINITY) : 0.0;
            detector->separations[a * count + b] = separation;
            if (!surfaces_may_meet(&detector->set, a, b)) continue;
            detector->margin = fmax(detector->margin, above);
            if (a == b) detector->reach = fmax(detector->reach, 0.5 * above);
        }
}

static bool reserve_parts(tulle_detector *detector, const tulle_detect_def *def, size_t count) {
    memory *const heap = &detector->heap;
    detector->surfaces = memory_allocate_zeroed(heap, count, sizeof *detector->surfaces);
    detector->separations = memory_allocate(heap, count * count * sizeof *detector->separations);
    bool is_complete = detector->surfaces && detector->separations;
    if (def->collides) {
        detector->collides = memory_allocate(heap, count * count);
        is_complete = is_complete && detector->collides;
    }
    if (count > 1) {
        size_t const bytes = def->vertex_count * sizeof *detector->vertex_surface;
        detector->vertex_surface = memory_allocate(heap, bytes);
        is_complete = is_complete && detector->vertex_surface;
    }
    for (size_t s = 0; s < count; s++) {
        tulle_detect_surface const surface = get_surface(def, s);
        if (surface.is_static)
            detector->static_vertex_count += surface.vertex_end - surface.vertex_begin;
    }
    if (detector->static_vertex_count > 0) {
        size_t const bytes = 3 * detector->static_vertex_count * sizeof(double);
        detector->static_positions = memory_allocate(heap, bytes);
        is_complete = is_complete && detector->static_positions;
    }
    return is_complete;
}

static void fill_parts(tulle_detector *detector, const tulle_detect_def *def) {
    size_t const count = detector->set.surface_count;
    for (size_t s = 0; s < count; s++) {
        tulle_detect_surface const surface = get_surface(def, s);
        detector->surfaces[s] = make_range(&detector->topo, &surface);
        for (uint32_t v = surface.vertex_begin; detector->vertex_surface && v < surface.vertex_end;
             v++)
            detector->vertex_surface[v] = (uint32_t)s;
    }
    if (def->collides) memcpy(detector->collides, def->collides, count * count);
    compute_separations(detector, def);
}

static tulle_status make_parts(tulle_detector *detector, const tulle_detect_def *def,
                               tulle_error *error) {
    size_t const surface_count = def->surfaces ? def->surface_count : 1;
    detector->set.surface_count = surface_count;
    if (!reserve_parts(detector, def, surface_count))
        return out_of_memory(error, "the surfaces of the detector");
    tulle_status const status = topology_build_small(
        &detector->heap, def->triangles, def->triangle_count, def->vertex_count, &detector->topo);
    if (status == TULLE_ERROR_LIMIT)
        return error_set(error, status, "%zu triangles are too many: their edges cannot be counted",
                         def->triangle_count);
    if (status != TULLE_OK) return out_of_memory(error, "the edges of the mesh");
    detector->set.topo = &detector->topo;
    detector->set.surfaces = detector->surfaces;
    detector->set.collides = detector->collides;
    fill_parts(detector, def);
    return def->rest ? detector_shape_trees(detector, def->rest, error) : TULLE_OK;
}

tulle_status tulle_detector_create(const tulle_detect_def *def, tulle_detector **detector,
                                   tulle_error *error) {
    if (!detector)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "no place for the detector");
    *detector = NULL;
    tulle_status status = detect_def_check(def, error);
    if (status != TULLE_OK) return status;
    memory heap = {.allocator = def->allocator};
    tulle_detector *const made = memory_allocate_zeroed(&heap, 1, sizeof *made);
    if (!made) return out_of_memory(error, "the detector");
    made->heap = heap;
    made->def = *def;
    made->def.triangles = NULL;
    made->def.rest = NULL;
    made->def.surfaces = NULL;
    made->def.collides = NULL;
    made->threads = parallel_resolve_threads(def->threads);
    status = make_parts(made, def, error);
    if (status != TULLE_OK) {
        tulle_detector_destroy(made);
        return status;
    }
    *detector = made;
    return TULLE_OK;
}

void tulle_detector_destroy(tulle_detector *detector) {
    if (!detector) return;
    memory *const heap = &detector->heap;
    size_t const count = detector->set.surface_count;
    detector_destroy_stages(detector);
    ARRAY_FREE(heap, &detector->events);
    if (detector->set.topo) topology_destroy(heap, &detector->topo);
    memory_release(heap, detector->surfaces, count * sizeof *detector->surfaces);
    memory_release(heap, detector->separations, count * count * sizeof *detector->separations);
    memory_release(heap, detector->collides, count * count);
    memory_release(heap, detector->vertex_surface,
                   detector->def.vertex_count * sizeof *detector->vertex_surface);
    memory_release(heap, detector->static_positions,
                   3 * detector->static_vertex_count * sizeof(double));
    memory last = detector->heap;
    memory_release(&last, detector, sizeof *detector);
}

static tulle_status check_call(tulle_detector *detector, const detector_pass *pass,
                               const tulle_detect_result *result, tulle_error *error) {
    if (!detector || !result)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "the %s is null",
                         detector ? "result" : "detector");
    if (detector->is_streaming)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "the detector was called from a receiver of its own events; call it after "
                         "the stream has ended");
    detector->labels = NULL;
    return detector_check_positions(detector, pass->start, pass->end, error);
}

static tulle_detect_result make_result(const detector_pass *pass, double call_start) {
    tulle_detect_result result = {
        .event_count = pass->event_count, .earliest_time = 1.0, .statistics = pass->statistics};
    for (size_t i = 0; i < pass->event_count; i++)
        result.earliest_time = fmin(result.earliest_time, pass->events[i].time);
    result.statistics.total_seconds = timer_now() - call_start;
    return result;
}

/* Makes room for events of a pass that is done; without it the call has failed. */
static bool reserve_events(tulle_detector *detector, size_t count) {
    detector->events.count = 0;
    if (ARRAY_RESERVE(&detector->heap, &detector->events, count)) return true;
    detector->labels = NULL;
    return false;
}

tulle_status tulle_detector_find_events(tulle_detector *detector, const double *start,
                                        const double *end, tulle_detect_result *result,
                                        tulle_error *error) {
    double const call_start = timer_now();
    detector_pass pass = {.start = start, .end = end};
    tulle_status status = check_call(detector, &pass, result, error);
    if (status == TULLE_OK) status = detector_run_pass(detector, &pass, error);
    if (status != TULLE_OK) return status;
    double const events_start = timer_now();
    if (!reserve_events(detector, pass.event_count)) return out_of_memory(error, "the events");
    detector->events.count = pass.event_count;
    detector_fill_events(detector, &pass, 0, pass.event_count, detector->events.data);
    pass.statistics.event_seconds += timer_now() - events_start;
    *result = make_result(&pass, call_start);
    result->events = detector->events.data;
    return TULLE_OK;
}

tulle_status tulle_detector_stream_events(tulle_detector *detector, const double *start,
                                          const double *end, tulle_detect_receiver receiver,
                                          tulle_detect_result *result, tulle_error *error) {
    double const call_start = timer_now();
    detector_pass pass = {.start = start, .end = end};
    if (!receiver.receive)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "the receiver has no function");
    tulle_status status = check_call(detector, &pass, result, error);
    if (status == TULLE_OK) status = detector_run_pass(detector, &pass, error);
    if (status != TULLE_OK) return status;
    if (!reserve_events(detector, STREAM_BATCH)) return out_of_memory(error, "a batch of events");
    double const events_start = timer_now();
    for (size_t begin = 0; begin < pass.event_count; begin += STREAM_BATCH) {
        size_t const rest = pass.event_count - begin;
        size_t const count = rest < STREAM_BATCH ? rest : STREAM_BATCH;
        detector_fill_events(detector, &pass, begin, begin + count, detector->events.data);
        detector->is_streaming = true;
        int const stops = receiver.receive(receiver.context, detector->events.data, count);
        detector->is_streaming = false;
        if (stops != 0)
            return error_set(error, TULLE_ERROR_INTERRUPTED, "the receiver asked to stop");
    }
    pass.statistics.event_seconds += timer_now() - events_start;
    *result = make_result(&pass, call_start);
    return TULLE_OK;
}

tulle_status tulle_detector_find_earliest(tulle_detector *detector, const double *start,
                                          const double *end, tulle_detect_result *result,
                                          tulle_error *error) {
    double const call_start = timer_now();
    detector_pass pass = {.start = start, .end = end, .only_earliest = true};
    tulle_status status = check_call(detector, &pass, result, error);
    if (status == TULLE_OK) status = detector_run_pass(detector, &pass, error);
    if (status != TULLE_OK) return status;
    if (!reserve_events(detector, 1)) return out_of_memory(error, "an event");
    size_t earliest = 0;
    for (size_t i = 1; i < pass.event_count; i++)
        if (pass.events[i].time < pass.events[earliest].time) earliest = i;
    if (pass.event_count > 0) {
        pass.events += earliest;
        pass.event_count = 1;
        detector->events.count = 1;
        detector_fill_events(detector, &pass, 0, 1, detector->events.data);
    }
    *result = make_result(&pass, call_start);
    result->events = detector->events.data;
    return TULLE_OK;
}

const uint32_t *tulle_detector_get_patches(const tulle_detector *detector) {
    return detector ? detector->labels : NULL;
}
