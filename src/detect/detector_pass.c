/* detect/detector_pass.c - one pass: patches, trees, candidates, times of impact, raw events. */
#include "base/error.h"
#include "base/timer.h"
#include "detect/detector_parts.h"
#include "detect/pair_tests.h"

static broad_phase_method get_broad_method(tulle_detect_method method) {
    return method == TULLE_DETECT_BVOX ? BROAD_PHASE_BVOX : BROAD_PHASE_REFIT;
}

static tulle_status explain(tulle_status status, tulle_error *error) {
    if (status == TULLE_ERROR_LIMIT)
        return error_set(error, status, "there are more than 2^32 candidate pairs");
    if (status == TULLE_ERROR_INVALID_ARGUMENT)
        return error_set(error, status,
                         "positions or separations are too far beyond the extent of the rest shape "
                         "for doubles; make a detector with a rest shape of their size");
    return error_set(error, status, "no memory left for the search");
}

tulle_status detector_shape_trees(tulle_detector *detector, const double *rest,
                                  tulle_error *error) {
    tulle_status const status =
        broad_phase_create(&detector->heap, &detector->set, rest,
                           get_broad_method(detector->def.method), &detector->broad);
    return status == TULLE_OK ? status : explain(status, error);
}

void detector_destroy_stages(tulle_detector *detector) {
    broad_phase_destroy(detector->broad);
    ARRAY_FREE(&detector->heap, &detector->raw);
}

static double get_separation(void *context, feature_kind kind, feature_pair pair,
                             const vec3 start[4]) {
    (void)start;
    const tulle_detector *const detector = context;
    uint32_t vertices[4];
    feature_pair_vertices(&detector->topo, kind, pair, vertices);
    size_t const first = detector->vertex_surface ? detector->vertex_surface[vertices[0]] : 0;
    size_t const second = detector->vertex_surface ? detector->vertex_surface[vertices[3]] : 0;
    return detector->separations[first * detector->set.surface_count + second];
}

static tulle_status search(tulle_detector *detector, detector_pass *pass) {
    memory *const heap = &detector->heap;
    pair_list pairs = {0};
    event_list events = {0};
    arena scratch = arena_make(heap);
    pair_test_counts counts = {0};
    tulle_status status =
        find_pairs(detector->broad, &detector->set, detector->threads, &pairs, NULL);
    pair_test_input const input = {.topo = &detector->topo,
                                   .x0 = pass->start,
                                   .x1 = pass->end,
                                   .pairs = &pairs,
                                   .pair_separation = get_separation,
                                   .separation_context = detector,
                                   .threads = detector->threads};
    if (status == TULLE_OK) status = test_pairs(&input, heap, &scratch, &events, &counts);
    detector->raw.count = 0;
    if (status == TULLE_OK && !ARRAY_RESERVE(heap, &detector->raw, events.events.count))
        status = TULLE_ERROR_OUT_OF_MEMORY;
    for (size_t i = 0; status == TULLE_OK && i < events.events.count; i++) {
        const impact_event *const event = &events.events.data[i];
        detector->raw.data[detector->raw.count++] =
            (raw_event){.key = (uint64_t)event->pair.first << 32 | event->pair.second,
                        .time = event->result.lower_bound,
                        .kind = (uint8_t)event->kind,
                        .state = (uint8_t)event->result.state};
    }
    pass->events = detector->raw.data;
    pass->event_count = detector->raw.count;
    pass->statistics.box_pairs = counts.candidate_count;
    pass->statistics.filtered_pairs = pass->statistics.tested_pairs = counts.tested_count;
    ARRAY_FREE(heap, &pairs.vertex_triangle);
    ARRAY_FREE(heap, &pairs.edge_edge);
    ARRAY_FREE(heap, &events.events);
    arena_destroy(&scratch);
    return status;
}

tulle_status detector_run_pass(tulle_detector *detector, detector_pass *pass, tulle_error *error) {
    if (detector->def.method == TULLE_DETECT_PAPER)
        return error_set(error, TULLE_ERROR_UNSUPPORTED, "the paper's trees are not built in");
    double const start = timer_now();
    if (!detector->broad) {
        tulle_status const status = detector_shape_trees(detector, pass->start, error);
        if (status != TULLE_OK) return status;
    }
    tulle_status status = build_trees(detector->broad, &detector->set, pass->start, pass->end,
                                      detector->margin, detector->threads);
    double const built = timer_now();
    pass->statistics.tree_seconds = built - start;
    if (status == TULLE_OK) status = search(detector, pass);
    pass->statistics.search_seconds = timer_now() - built;
    return status == TULLE_OK ? status : explain(status, error);
}
