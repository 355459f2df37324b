/* contact/commit/resolve_impacts.c - stage 8, see resolve_impacts.h.
 *
 * Each hit becomes a row with the frame of its time of impact. Against an obstacle the row takes
 * the nearest normal in the normal cone of the feature that is hit. New rows come after those that
 * are there. A pair may own several rows, since the impulse of a row acts along the weights it was
 * made with. Then the response answers to all rows, and only pairs with a vertex that moved
 * differently are tested again. Before the paths are called clean every pair is tested on them
 * once.
 *
 * Impacts foreseen on the paths of a rough solve are no proof, only rows for the solve that
 * follows. So vertices that leave the paths that were predicted need no new search, as long as the
 * source still lists all pairs whose boxes along those paths meet. Only these count, so all sources
 * give the same rows. */
#include "contact/commit/resolve_impacts.h"

#include "contact/pairs/body_paths.h"
#include "contact/pairs/path_test.h"
#include "contact/response.h"
#include "contact/rows/contact_rows.h"

#include <math.h>
#include <string.h>

/* An impact of cloth with an obstacle. */
typedef struct cloth_hit {
    double time;
    vec3 normal; /* towards the cloth; zero: no such impact */
} cloth_hit;

/* Drops rows, from `first_new` on, of cloth that comes to an obstacle from behind: by then it would
 * have passed through, since an earlier impact of one of its vertices pushes the other way. Hits
 * that remain after that impact is resolved come back in the next round. `hits`: of each new row.
 */
static tulle_status drop_hits_from_behind(const contact_scene *scene, row_list *list,
                                          size_t first_new, const cloth_hit *hits) {
    size_t const cloth_count = scene->cloth_vertex_count;
    cloth_hit *const earliest = ARENA_NEW_ZEROED(scene->scratch, cloth_hit, cloth_count);
    if (!earliest) return TULLE_ERROR_OUT_OF_MEMORY;
    for (size_t i = first_new; i < list->rows.count; i++) {
        const row_frame *const frame = &list->rows.data[i].frame;
        const cloth_hit *const hit = &hits[i - first_new];
        for (int k = 0; k < 4 && vec3_norm2(hit->normal) != 0.0; k++) {
            uint32_t const v = frame->vertices[k];
            if (v >= cloth_count || frame->weights[k] == 0.0) continue;
            if (vec3_norm2(earliest[v].normal) == 0.0 || hit->time < earliest[v].time)
                earliest[v] = *hit;
        }
    }
    size_t kept = first_new;
    for (size_t i = first_new; i < list->rows.count; i++) {
        const row_frame *const frame = &list->rows.data[i].frame;
        const cloth_hit *const hit = &hits[i - first_new];
        bool is_from_behind = false;
        for (int k = 0; k < 4 && !is_from_behind; k++) {
            uint32_t const v = frame->vertices[k];
            is_from_behind = v < cloth_count && frame->weights[k] != 0.0 &&
                             earliest[v].time < hit->time &&
                             vec3_dot(earliest[v].normal, hit->normal) < 0.0;
        }
        if (!is_from_behind) list->rows.data[kept++] = list->rows.data[i];
    }
    list->rows.count = kept;
    return TULLE_OK;
}

/* Adds a row for each hit on the paths to x1. */
static tulle_status append_rows(const contact_scene *scene, const pair_events *events,
                                const double *x1, row_list *list) {
    size_t const first_new = list->rows.count;
    cloth_hit *const hits = ARENA_NEW_ZEROED(scene->scratch, cloth_hit, events->count);
    double const most_bias = scene->settings.push_out_speed - list->push_out_cut;
    if (!hits || !ARRAY_RESERVE(scene->heap, &list->rows, events->count))
        return TULLE_ERROR_OUT_OF_MEMORY;
    for (size_t i = 0; i < events->count; i++) {
        contact_row *const row = &list->rows.data[list->rows.count];
        begin_contact_row(scene, x1, &events->events[i], row);
        if (!finish_contact_row(scene, row)) continue;
        straighten_row(scene, x1, events->events[i].time, true, row);
        if (!(row->law.bias < most_bias)) row->law.bias = most_bias;
        bool const is_first = row->frame.vertices[0] >= scene->cloth_vertex_count;
        bool const is_second = row->frame.vertices[3] >= scene->cloth_vertex_count;
        cloth_hit *const hit = &hits[list->rows.count++ - first_new];
        hit->time = events->events[i].time;
        if (is_first != is_second && !row->frame.has_body)
            hit->normal = is_first ? vec3_neg(row->frame.normal) : row->frame.normal;
    }
    if (!scene->response->fits_rows) return TULLE_OK;
    return drop_hits_from_behind(scene, list, first_new, hits);
}

/* Whether the boxes of the predicted paths of a pair's features, each widened by half the margin,
 * meet. */
static bool paths_meet(const contact_scene *scene, const double *predicted, double margin,
                       const pair_event *event) {
    uint32_t vertices[4];
    feature_pair_vertices(scene->set->topo, event->kind, event->pair, vertices);
    int const first_count = event->kind == FEATURE_EDGE_EDGE ? 2 : 1;
    for (size_t axis = 0; axis < 3; axis++) {
        double low[2] = {(double)INFINITY, (double)INFINITY};
        double high[2] = {-(double)INFINITY, -(double)INFINITY};
        for (int k = 0; k < 4; k++) {
            int const side = k < first_count ? 0 : 1;
            double const begin = scene->x0[3 * (size_t)vertices[k] + axis];
            double const end = predicted[3 * (size_t)vertices[k] + axis];
            low[side] = fmin(low[side], fmin(begin, end));
            high[side] = fmax(high[side], fmax(begin, end));
        }
        if (low[0] > high[1] + margin || low[1] > high[0] + margin) return false;
    }
    return true;
}

tulle_status foresee_impacts(const contact_scene *scene, pair_source *source, row_list *list,
                             const double *predicted, const double *x1, impact_report *report) {
    *report = (impact_report){0};
    if (scene->settings.impact_rounds < 1) return TULLE_OK;
    arena_mark const mark = arena_get_mark(scene->scratch);
    bool const lists_all_predicted = source->renew_count == 0 && !source->is_straight;
    tulle_status status = TULLE_OK;
    if (!lists_all_predicted)
        status = ensure_pairs_cover(scene, source, x1);
    else if (source->adapt) /* what is left out must keep its gap on these paths, too */
        status = source->adapt(source, x1);
    pair_events hits = {0};
    if (status == TULLE_OK) status = find_hits(scene, source, x1, NULL, &hits);
    report->tested_pairs = hits.measured_count;
    report->turning_pairs = hits.turning_count;
    size_t kept = 0;
    for (size_t i = 0; i < hits.count; i++)
        if (paths_meet(scene, predicted, source->margin, &hits.events[i]))
            hits.events[kept++] = hits.events[i];
    hits.count = kept;
    size_t const row_count = list->rows.count;
    if (status == TULLE_OK && kept > 0) status = append_rows(scene, &hits, x1, list);
    report->impact_count = list->rows.count - row_count;
    arena_release(scene->scratch, mark);
    return status;
}

tulle_status resolve_impacts(const contact_scene *scene, pair_source *source, row_list *list,
                             double *u, double *x1, impact_report *report) {
    *report = (impact_report){0};
    arena_mark const mark = arena_get_mark(scene->scratch);
    /* vertices whose end moved since the last test */
    bool *const has_changed = ARENA_NEW(scene->scratch, bool, scene->vertex_count);
    double *const tested = ARENA_NEW(scene->scratch, double, 3 * scene->vertex_count);
    tulle_status status = has_changed && tested ? TULLE_OK : TULLE_ERROR_OUT_OF_MEMORY;
    for (int round = 0; status == TULLE_OK; round++) {
        arena_mark const round_mark = arena_get_mark(scene->scratch);
        /* Later rounds test only pairs with a changed vertex. If that finds no hit, all pairs are
         * tested. Pairs that were found again need no full test: what was tested on paths that are
         * still the same was complete for them. So hits do not depend on when pairs are searched.
         */
        pair_events hits = {0};
        status = ensure_pairs_cover(scene, source, x1);
        for (bool is_partial = round > 0; status == TULLE_OK; is_partial = false) {
            status = find_hits(scene, source, x1, is_partial ? has_changed : NULL, &hits);
            report->tested_pairs += hits.measured_count;
            report->turning_pairs += hits.turning_count;
            if (!is_partial || hits.count > 0) break;
        }
        report->is_clean = status == TULLE_OK && hits.count == 0;
        size_t const row_count = list->rows.count;
        bool const is_last = hits.count == 0 || round >= scene->settings.impact_rounds;
        if (status == TULLE_OK && !is_last) status = append_rows(scene, &hits, x1, list);
        arena_release(scene->scratch, round_mark);
        if (status != TULLE_OK || is_last) break;
        report->impact_count += list->rows.count - row_count;
        report->rounds++;
        status = scene->response->answer_impacts(scene, list, row_count, u);
        if (status != TULLE_OK) break;
        /* new paths, and which vertices they move */
        memcpy(tested, x1, 3 * scene->vertex_count * sizeof(double));
        propose_paths(scene, u, x1);
        for (size_t i = 0; i < scene->vertex_count; i++)
            has_changed[i] = memcmp(x1 + 3 * i, tested + 3 * i, 3 * sizeof(double)) != 0;
    }
    arena_release(scene->scratch, mark);
    return status;
}
