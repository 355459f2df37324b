/* detect/detector/detector_pass.c - one pass over a detector's surfaces: patches, trees,
 * candidates, times of impact.
 *
 * Candidates go from the trees to the tests in batches and are never stored. Where there are more
 * events than there is room for, room is made and the search is repeated; patches and trees stay.
 */
#include "base/error.h"
#include "base/parallel.h"
#include "base/timer.h"
#include "detect/detector/detector_parts.h"

static broad_phase_method get_broad_method(tulle_detect_method method) {
    if (method == TULLE_DETECT_PAPER) return BROAD_PHASE_PAPER;
    return method == TULLE_DETECT_BVOX ? BROAD_PHASE_BVOX : BROAD_PHASE_REFIT;
}

static tulle_status explain(tulle_status status, tulle_error *error) {
    if (status == TULLE_ERROR_INVALID_ARGUMENT)
        return error_set(error, status,
                         "positions or separations are too far beyond the extent of the rest shape "
                         "for doubles; make a detector with a rest shape of their size");
    return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory left for the search");
}

static tulle_status make_stages(tulle_detector *detector, const double *rest) {
    memory *const heap = &detector->heap;
    tulle_detect_method const method = detector->def.method;
    bool const has_patches = method == TULLE_DETECT_PATCHES || method == TULLE_DETECT_PAPER;
    tulle_status status = TULLE_OK;
    if (!detector->narrow) status = narrow_phase_create(heap, &detector->narrow);
    if (status == TULLE_OK && has_patches && !detector->patches)
        status = kept_patches_create(heap, &detector->set, NULL, &detector->patches);
    if (status == TULLE_OK)
        status = broad_phase_create(heap, &detector->set, rest, get_broad_method(method),
                                    &detector->broad);
    if (status == TULLE_OK)
        broad_phase_configure(detector->broad, (broad_phase_options){.following = PATHS_ALWAYS});
    return status;
}

tulle_status detector_shape_trees(tulle_detector *detector, const double *rest,
                                  tulle_error *error) {
    tulle_status const status = make_stages(detector, rest);
    if (status != TULLE_OK) return explain(status, error);
    /* only voxel trees look at what meets where again */
    if (get_broad_method(detector->def.method) == BROAD_PHASE_REFIT)
        topology_keep_corners(&detector->heap, &detector->topo);
    return TULLE_OK;
}

void detector_destroy_stages(tulle_detector *detector) {
    broad_phase_destroy(detector->broad);
    kept_patches_destroy(detector->patches);
    narrow_phase_destroy(detector->narrow);
}

/* Updates the patches and takes their labels: pairs within a patch need no search. To grow patches
 * takes longer than they save in one call, so those that are kept come with the second one. */
static tulle_status prepare_patches(tulle_detector *detector, detector_pass *pass) {
    const tulle_detect_def *const def = &detector->def;
    detector->labels = NULL;
    if (!detector->patches) return TULLE_OK;
    bool const waits = def->method == TULLE_DETECT_PATCHES && def->has_certificate &&
                       !def->grows_patches_anew && !detector->keeps_all_patches;
    if (waits && detector->call_count == 0) return TULLE_OK;
    /* Growth takes much memory, and with patches most boxes are not needed. */
    if (waits && detector->call_count == 1) broad_phase_release_blocks(detector->broad);
    patch_rules const rules = {
        .cone = def->cone == TULLE_CONE_PAPER ? CONE_PAPER : CONE_BERNSTEIN,
        .max_angle = def->max_angle,
        .has_certificate = def->has_certificate != 0,
        .grows_anew = def->grows_patches_anew != 0 || def->method == TULLE_DETECT_PAPER,
        .reach = detector->reach,
        .keeps_all = detector->keeps_all_patches,
    };
    patch_counts counts;
    patch_step const step = {&detector->set, pass->start, pass->end, detector->threads};
    tulle_status const status = update_patches(detector->patches, &step, &rules, &counts);
    if (status != TULLE_OK) return status;
    detector->labels = kept_patches_get_labels(detector->patches).labels;
    tulle_detect_statistics *const statistics = &pass->statistics;
    statistics->patch_count = counts.patch_count;
    statistics->uncertified_count = counts.dissolved_count;
    statistics->patch_triangles = counts.triangle_count;
    statistics->certified_by_star = counts.star_count;
    statistics->certified_by_contour = counts.contour_count;
    statistics->checked_again = counts.kept_count;
    statistics->uses_patches = counts.patch_count > 0;
    return TULLE_OK;
}

typedef struct flush_context {
    narrow_phase *narrow;
    const pair_tables *tables;
} flush_context;

static void flush_worker(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)begin, (void)end, (void)worker;
    const flush_context *const flush = context;
    narrow_phase_flush(flush->narrow, flush->tables, (int)chunk);
}

/* Finds and tests candidates in one loop, and again where the events found no room. */
static tulle_status search(tulle_detector *detector, detector_pass *pass) {
    narrow_phase_input const input = {.set = &detector->set,
                                      .separations = detector->separations,
                                      .vertex_surface = detector->vertex_surface,
                                      .only_earliest = pass->only_earliest,
                                      .threads = detector->threads};
    flush_context flush = {detector->narrow, broad_phase_get_tables(detector->broad)};
    tulle_status status;
    do {
        search_counts counts;
        status = narrow_phase_start(detector->narrow, &input);
        if (status == TULLE_OK)
            status = search_pairs(detector->broad, &detector->set, detector->threads, consume_pairs,
                                  detector->narrow, &counts);
        if (status != TULLE_OK) return status;
        parallel_for((size_t)detector->threads, 1, detector->threads, flush_worker, &flush);
        pass->statistics.leaf_pairs = counts.leaf_pair_count;
        if (detector->patches)
            kept_patches_tell_search(detector->patches, counts.leaf_pair_count,
                                     counts.near_pair_count);
    } while (!narrow_phase_finish(detector->narrow, &status) && status == TULLE_OK);
    return status;
}

static tulle_status run_stages(tulle_detector *detector, detector_pass *pass) {
    tulle_detect_statistics *const statistics = &pass->statistics;
    double const began = timer_now();
    tulle_status status = prepare_patches(detector, pass);
    double const patched = timer_now();
    statistics->patch_seconds = patched - began;
    if (status != TULLE_OK) return status;
    patch_labels patches = {0};
    if (statistics->uses_patches) patches = kept_patches_get_labels(detector->patches);
    broad_phase_set_patches(detector->broad, patches);
    status = build_trees(detector->broad, &detector->set, pass->start, pass->end, detector->margin,
                         detector->threads);
    double const built = timer_now();
    statistics->tree_seconds += built - patched;
    if (status == TULLE_OK) status = search(detector, pass);
    if (status != TULLE_OK) return status;
    if (detector->call_count < 2) detector->call_count++;
    statistics->search_seconds = timer_now() - built;

    /* What it took, and what came of it. */
    narrow_phase_counts const counts = narrow_phase_get_counts(detector->narrow);
    statistics->box_pairs = counts.candidate_count;
    statistics->filtered_pairs = counts.pooled_count;
    statistics->tested_pairs = counts.tested_count;
    statistics->filter_seconds = counts.filter_seconds / detector->threads;
    statistics->impact_seconds = counts.impact_seconds / detector->threads;
    double const rest =
        statistics->search_seconds - statistics->filter_seconds - statistics->impact_seconds;
    statistics->traversal_seconds = rest > 0.0 ? rest : 0.0;
    pass->events = narrow_phase_get_events(detector->narrow, &pass->event_count);
    return TULLE_OK;
}

tulle_status detector_run_pass(tulle_detector *detector, detector_pass *pass, tulle_error *error) {
    double const began = timer_now();
    tulle_status status = TULLE_OK;
    if (!detector->broad) status = detector_shape_trees(detector, pass->start, error);
    if (status != TULLE_OK) return status;
    pass->statistics.tree_seconds = timer_now() - began;
    status = run_stages(detector, pass);
    if (status == TULLE_OK) return status;
    detector->labels = NULL;
    return explain(status, error);
}
