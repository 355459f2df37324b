/* contact/resolve_impacts.c - stage 10, see resolve_impacts.h.
 *
 * Each hit becomes a row with the frame of its time of impact, added after those that are there: a
 * pair may own several rows, since the impulse of a row acts along the weights it was made with.
 * Then impulses are projected over all rows (or velocities, by the paper's response), and only
 * pairs with a vertex that moved differently are tested again. Before the paths are called clean
 * every pair is tested on them once. */
#include "contact/resolve_impacts.h"

#include "contact/body_paths.h"
#include "contact/contact_rows.h"
#include "contact/path_test.h"
#include "contact/project_impulses.h"
#include "contact/respond_by_paper.h"

#include <string.h>

typedef struct impact_work {
    const contact_scene *scene;
    pair_source *source;
    row_list *list;
    double *u, *x1;
    impact_report *report;
    bool *has_changed; /* vertices whose end moved since the last test */
    double *x1_tested;
    bool is_partial; /* the next test may skip pairs without a changed vertex */
} impact_work;

static tulle_status append_rows(impact_work *work, const pair_events *hits) {
    const contact_scene *const scene = work->scene;
    row_list *const list = work->list;
    if (!ARRAY_RESERVE(scene->heap, &list->rows, hits->count)) return TULLE_ERROR_OUT_OF_MEMORY;
    for (size_t i = 0; i < hits->count; i++) {
        contact_row *const row = &list->rows.data[list->rows.count];
        if (!make_contact_row(scene, work->x1, &hits->events[i], row)) continue;
        list->rows.count++;
        work->report->impact_count++;
    }
    return TULLE_OK;
}

/* New paths, and which vertices they move. */
static void renew_paths(impact_work *work) {
    const contact_scene *const scene = work->scene;
    memcpy(work->x1_tested, work->x1, 3 * scene->vertex_count * sizeof(double));
    set_body_lifts(scene, work->list);
    propose_paths(scene, work->u, work->x1);
    for (size_t i = 0; i < scene->vertex_count; i++)
        work->has_changed[i] =
            memcmp(work->x1 + 3 * i, work->x1_tested + 3 * i, 3 * sizeof(double)) != 0;
}

/* Finds hits on the present paths; a partial test without hits is followed by a full one. */
static tulle_status test_paths(impact_work *work, pair_events *hits) {
    uint64_t const renew_count = work->source->renew_count;
    tulle_status status = ensure_pairs_cover(work->scene, work->source, work->x1);
    if (status != TULLE_OK) return status;
    bool const is_partial = work->is_partial && work->source->renew_count == renew_count;
    status = find_hits(work->scene, work->source->pairs, work->x1,
                       is_partial ? work->has_changed : NULL, hits);
    work->report->tested_pairs += hits->measured_count;
    work->report->turning_pairs += hits->turning_count;
    if (status != TULLE_OK || !is_partial || hits->count > 0) return status;
    status = find_hits(work->scene, work->source->pairs, work->x1, NULL, hits);
    work->report->tested_pairs += hits->measured_count;
    work->report->turning_pairs += hits->turning_count;
    return status;
}

/* New velocities, after rows from first_new on were added. */
static tulle_status respond(impact_work *work, size_t first_new) {
    if (work->scene->paper)
        return respond_to_impacts_by_paper(work->scene, work->list, first_new, work->u);
    project_impulses(work->scene, work->list->rows.data, work->list->rows.count, work->u);
    return TULLE_OK;
}

static tulle_status run_rounds(impact_work *work) {
    const contact_scene *const scene = work->scene;
    for (int round = 0;; round++) {
        arena_mark const mark = arena_get_mark(scene->scratch);
        pair_events hits = {0};
        tulle_status status = test_paths(work, &hits);
        work->report->is_clean = status == TULLE_OK && hits.count == 0;
        size_t const row_count = work->list->rows.count;
        bool const is_last = hits.count == 0 || round >= scene->settings.impact_rounds;
        if (status == TULLE_OK && !is_last) status = append_rows(work, &hits);
        arena_release(scene->scratch, mark);
        if (status != TULLE_OK || is_last) return status;
        work->report->rounds++;
        status = respond(work, row_count);
        if (status != TULLE_OK) return status;
        renew_paths(work);
        work->is_partial = true;
    }
}

tulle_status resolve_impacts(const contact_scene *scene, pair_source *source, row_list *list,
                             double *u, double *x1, impact_report *report) {
    *report = (impact_report){0};
    arena_mark const mark = arena_get_mark(scene->scratch);
    impact_work work = {.scene = scene,
                        .source = source,
                        .list = list,
                        .u = u,
                        .x1 = x1,
                        .report = report,
                        .has_changed = ARENA_NEW(scene->scratch, bool, scene->vertex_count),
                        .x1_tested = ARENA_NEW(scene->scratch, double, 3 * scene->vertex_count)};
    tulle_status const status =
        work.has_changed && work.x1_tested ? run_rounds(&work) : TULLE_ERROR_OUT_OF_MEMORY;
    arena_release(scene->scratch, mark);
    return status;
}
