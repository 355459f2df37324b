/* contact/commit/resolve_impacts.c - stage 8, see resolve_impacts.h.
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
    bool is_partial;   /* the next test may skip pairs without a changed vertex */
} impact_work;

/* Finds hits on the present paths; a partial test without hits is followed by a full one. Pairs
 * that were found anew are no reason for a full one: what was tested on paths that are still the
 * same was complete for them, and so hits do not depend on when pairs are searched. */
static tulle_status test_paths(impact_work *work, pair_events *hits) {
    tulle_status status = ensure_pairs_cover(work->scene, work->source, work->x1);
    for (bool is_partial = work->is_partial; status == TULLE_OK; is_partial = false) {
        status = find_hits(work->scene, work->source, work->x1,
                           is_partial ? work->has_changed : NULL, hits);
        work->report->tested_pairs += hits->measured_count;
        work->report->turning_pairs += hits->turning_count;
        if (!is_partial || hits->count > 0) break;
    }
    return status;
}

/* The earliest impact of a cloth vertex with an obstacle in a round. */
typedef struct first_hit {
    double time;
    vec3 normal; /* towards the cloth; zero: none */
} first_hit;

/* The normal towards the cloth of a row between it and an obstacle; zero for others. */
static vec3 get_cloth_normal(const contact_scene *scene, const contact_row *row) {
    bool const is_first = row->frame.vertices[0] >= scene->cloth_vertex_count;
    bool const is_second = row->frame.vertices[3] >= scene->cloth_vertex_count;
    if (is_first == is_second || row->frame.has_body) return vec3_make(0.0, 0.0, 0.0);
    return is_first ? vec3_neg(row->frame.normal) : row->frame.normal;
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
    for (size_t i = first_new; i < list->rows.count; i++) {
        const row_frame *const frame = &list->rows.data[i].frame;
        vec3 const normal = get_cloth_normal(scene, &list->rows.data[i]);
        double const time = times[i - first_new];
        for (int k = 0; k < 4 && vec3_norm2(normal) != 0.0; k++) {
            uint32_t const v = frame->vertices[k];
            if (v >= scene->cloth_vertex_count || frame->weights[k] == 0.0) continue;
            if (vec3_norm2(firsts[v].normal) == 0.0 || time < firsts[v].time)
                firsts[v] = (first_hit){time, normal};
        }
    }
    size_t kept = first_new;
    for (size_t i = first_new; i < list->rows.count; i++) {
        const row_frame *const frame = &list->rows.data[i].frame;
        vec3 const normal = get_cloth_normal(scene, &list->rows.data[i]);
        bool is_from_behind = false;
        for (int k = 0; k < 4 && !is_from_behind; k++) {
            uint32_t const v = frame->vertices[k];
            is_from_behind = v < scene->cloth_vertex_count && frame->weights[k] != 0.0 &&
                             firsts[v].time < times[i - first_new] &&
                             vec3_dot(firsts[v].normal, normal) < 0.0;
        }
        if (!is_from_behind) list->rows.data[kept++] = list->rows.data[i];
    }
    list->rows.count = kept;
    return TULLE_OK;
}

static tulle_status append_rows(impact_work *work, const pair_events *hits) {
    const contact_scene *const scene = work->scene;
    row_list *const list = work->list;
    size_t const first_new = list->rows.count;
    double *const times = ARENA_NEW(scene->scratch, double, hits->count);
    if (!times || !ARRAY_RESERVE(scene->heap, &list->rows, hits->count))
        return TULLE_ERROR_OUT_OF_MEMORY;
    for (size_t i = 0; i < hits->count; i++) {
        contact_row *const row = &list->rows.data[list->rows.count];
        begin_contact_row(scene, work->x1, &hits->events[i], row);
        if (!finish_contact_row(scene, row)) continue;
        straighten_row(scene, work->x1, hits->events[i].time, true, row);
        times[list->rows.count++ - first_new] = hits->events[i].time;
    }
    tulle_status status = TULLE_OK;
    if (scene->response->fits_rows) status = drop_hits_from_behind(work, first_new, times);
    work->report->impact_count += list->rows.count - first_new;
    return status;
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
                        .has_changed = ARENA_NEW(scene->scratch, bool, scene->vertex_count)};
    double *const tested = ARENA_NEW(scene->scratch, double, 3 * scene->vertex_count);
    tulle_status status = work.has_changed && tested ? TULLE_OK : TULLE_ERROR_OUT_OF_MEMORY;
    for (int round = 0; status == TULLE_OK; round++) {
        arena_mark const round_mark = arena_get_mark(scene->scratch);
        pair_events hits = {0};
        status = test_paths(&work, &hits);
        report->is_clean = status == TULLE_OK && hits.count == 0;
        size_t const row_count = list->rows.count;
        bool const is_last = hits.count == 0 || round >= scene->settings.impact_rounds;
        if (status == TULLE_OK && !is_last) status = append_rows(&work, &hits);
        arena_release(scene->scratch, round_mark);
        if (status != TULLE_OK || is_last) break;
        report->rounds++;
        status = scene->response->answer_impacts(scene, list, row_count, u);
        if (status != TULLE_OK) break;
        /* new paths, and which vertices they move */
        memcpy(tested, x1, 3 * scene->vertex_count * sizeof(double));
        set_body_lifts(scene, list);
        propose_paths(scene, u, x1);
        for (size_t i = 0; i < scene->vertex_count; i++)
            work.has_changed[i] = memcmp(x1 + 3 * i, tested + 3 * i, 3 * sizeof(double)) != 0;
        work.is_partial = true;
    }
    arena_release(scene->scratch, mark);
    return status;
}
