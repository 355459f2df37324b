/* contact/commit/resolve_impacts.c - stage 10, see resolve_impacts.h.
 *
 * Each hit becomes a row with the frame of its time of impact, against an obstacle with the normal
 * nearest to it in the normal cone of the feature that is hit, added after those that are there: a
 * pair may own several rows, since the impulse of a row acts along the weights it was made with.
 * Then the response answers to all rows, and only pairs with a vertex that moved differently are
 * tested again. Before the paths are called clean every pair is tested on them once. */
#include "contact/commit/resolve_impacts.h"

#include "contact/pairs/body_paths.h"
#include "contact/pairs/path_test.h"
#include "contact/response.h"
#include "contact/rows/contact_rows.h"

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

/* The earliest impact of a cloth vertex with an obstacle in a round. */
typedef struct first_hit {
    double time;
    vec3 normal; /* towards the cloth; zero: none */
} first_hit;

/* The normal towards the cloth of a row between it and an obstacle; zero for others. */
static vec3 find_cloth_normal(const contact_scene *scene, const contact_row *row) {
    bool const is_first = row->frame.vertices[0] >= scene->cloth_vertex_count;
    bool const is_second = row->frame.vertices[3] >= scene->cloth_vertex_count;
    if (is_first == is_second || row->frame.has_body) return vec3_make(0.0, 0.0, 0.0);
    return is_first ? vec3_neg(row->frame.normal) : row->frame.normal;
}

static void note_first_hits(const contact_scene *scene, const contact_row *row, double time,
                            first_hit *firsts) {
    vec3 const normal = find_cloth_normal(scene, row);
    if (vec3_norm2(normal) == 0.0) return;
    for (int k = 0; k < 4; k++) {
        uint32_t const v = row->frame.vertices[k];
        if (v >= scene->cloth_vertex_count || row->frame.weights[k] == 0.0) continue;
        if (vec3_norm2(firsts[v].normal) == 0.0 || time < firsts[v].time)
            firsts[v] = (first_hit){time, normal};
    }
}

static bool comes_from_behind(const contact_scene *scene, const contact_row *row, double time,
                              const first_hit *firsts) {
    vec3 const normal = find_cloth_normal(scene, row);
    for (int k = 0; k < 4; k++) {
        uint32_t const v = row->frame.vertices[k];
        if (v < scene->cloth_vertex_count && row->frame.weights[k] != 0.0 &&
            firsts[v].time < time && vec3_dot(firsts[v].normal, normal) < 0.0)
            return true;
    }
    return false;
}

/* Drops rows, from `first_new` on, of cloth that would have passed through the obstacle by then and
 * come to it from behind: an earlier impact of one of its vertices pushes the other way. What is
 * still hit once that one is resolved comes back in the next round. */
static tulle_status drop_hits_from_behind(const impact_work *work, size_t first_new,
                                          const double *times) {
    const contact_scene *const scene = work->scene;
    row_list *const list = work->list;
    first_hit *const firsts =
        ARENA_NEW_ZEROED(scene->scratch, first_hit, scene->cloth_vertex_count);
    if (!firsts) return TULLE_ERROR_OUT_OF_MEMORY;
    for (size_t i = first_new; i < list->rows.count; i++)
        note_first_hits(scene, &list->rows.data[i], times[i - first_new], firsts);
    size_t kept = first_new;
    for (size_t i = first_new; i < list->rows.count; i++)
        if (!comes_from_behind(scene, &list->rows.data[i], times[i - first_new], firsts))
            list->rows.data[kept++] = list->rows.data[i];
    list->rows.count = kept;
    return TULLE_OK;
}

static tulle_status append_rows(impact_work *work, const pair_events *hits) {
    const contact_scene *const scene = work->scene;
    row_list *const list = work->list;
    if (!ARRAY_RESERVE(scene->heap, &list->rows, hits->count)) return TULLE_ERROR_OUT_OF_MEMORY;
    size_t const first_new = list->rows.count;
    double *const times = ARENA_NEW(scene->scratch, double, hits->count);
    if (!times) return TULLE_ERROR_OUT_OF_MEMORY;
    for (size_t i = 0; i < hits->count; i++) {
        contact_row *const row = &list->rows.data[list->rows.count];
        if (!make_contact_row(scene, work->x1, &hits->events[i], row)) continue;
        straighten_impact(scene, work->x1, hits->events[i].time, row);
        times[list->rows.count++ - first_new] = hits->events[i].time;
    }
    tulle_status const status =
        scene->response->fits_rows ? drop_hits_from_behind(work, first_new, times) : TULLE_OK;
    work->report->impact_count += list->rows.count - first_new;
    return status;
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

/* Finds hits on the present paths; a partial test without hits is followed by a full one. Pairs
 * that were found anew are no reason for a full one: what was tested on paths that are still the
 * same was complete for them, and so hits do not depend on when pairs are searched. */
static tulle_status test_paths(impact_work *work, pair_events *hits) {
    tulle_status status = ensure_pairs_cover(work->scene, work->source, work->x1);
    if (status != TULLE_OK) return status;
    bool const is_partial = work->is_partial;
    status =
        find_hits(work->scene, work->source, work->x1, is_partial ? work->has_changed : NULL, hits);
    work->report->tested_pairs += hits->measured_count;
    work->report->turning_pairs += hits->turning_count;
    if (status != TULLE_OK || !is_partial || hits->count > 0) return status;
    status = find_hits(work->scene, work->source, work->x1, NULL, hits);
    work->report->tested_pairs += hits->measured_count;
    work->report->turning_pairs += hits->turning_count;
    return status;
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
        status = scene->response->answer_impacts(scene, work->list, row_count, work->u);
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
