/* contact/rows/gather_rows.c - stage 5, see gather_rows.h.
 *
 * A pair that is near at the start gets a row with the frame of the start. A pair whose predicted
 * path comes within the contact distance gets a row with the frame of that time, so that the row
 * pushes where the impact will be. Rows only shape the response: stages 8 and 9 catch what has no
 * row.
 */
#include "contact/rows/gather_rows.h"

#include "contact/pairs/apart_pairs.h"
#include "contact/pairs/near_pairs.h"
#include "contact/pairs/pair_filter.h"
#include "contact/pairs/pair_rules.h"
#include "contact/rows/choose_rows.h"

typedef struct gathering {
    const contact_scene *scene;
    const double *predicted;
    const vertex_record *start_and_rest;        /* x0 and the rest shape */
    pair_tables tables;                         /* of x0 -> predicted */
    double largest_contact, largest_separation; /* [m] with rounding slack */
} gathering;

/* The time of an event is 0 for a pair that is near at the start. For another one it is when the
 * pair's path first comes within the contact distance. Two edges that touch at an end are no event:
 * their contact is left to the vertex's own rows (admissible_rows.h). */
static void measure_touches(const void *context, feature_kind kind, pair_event *events,
                            size_t count, scan_verdict *verdicts) {
    const gathering *const work = context;
    const contact_scene *const scene = work->scene;
    if (count == 0) return;
    /* distances at the start and in the rest shape */
    double start[SCAN_MOST], rest[SCAN_MOST];
    bool is_at_end[SCAN_MOST];
    pair_measures const measures = {start, rest, is_at_end};
    feature_pair pairs[SCAN_MOST];
    for (size_t i = 0; i < count; i++) pairs[i] = events[i].pair;
    TULLE_PICK_KERNEL(measure_distances)
    (scene->set->topo, work->start_and_rest, kind, pairs, count, &measures);

    /* near pairs; the others make a query */
    apart_query far = {.kind = kind, .count = 0};
    uint8_t indices[SCAN_MOST]; /* of the query's pairs among the events */
    for (size_t i = 0; i < count; i++) {
        uint32_t vertices[4];
        feature_pair_vertices(scene->set->topo, kind, pairs[i], vertices);
        pair_distances const limits = compute_pair_distances(scene, kind, vertices, &rest[i]);
        events[i].distance = start[i];
        events[i].time = 0.0;
        verdicts[i] = is_at_end[i] ? SCAN_DROP_NEAR : SCAN_EVENT;
        if (!(start[i] >= limits.separation)) continue;
        indices[far.count] = (uint8_t)i;
        far.pairs[far.count] = pairs[i];
        far.separations[far.count++] = limits.contact;
    }

    /* those of the others that approach */
    bool is_apart[SCAN_MOST];
    mark_apart(&work->tables, &far, is_apart);
    for (size_t k = 0; k < far.count; k++) {
        size_t const i = indices[k];
        double const contact = far.separations[k];
        verdicts[i] = start[i] < work->largest_separation ? SCAN_DROP_NEAR : SCAN_DROP;
        if (is_apart[k]) continue;
        uint32_t vertices[4];
        moving_pair paths;
        feature_pair_vertices(scene->set->topo, kind, pairs[i], vertices);
        load_points(scene->x0, vertices, paths.start);
        load_points(work->predicted, vertices, paths.end);
        if (prove_apart(kind, &paths, contact) == APART_BY_DIRECTION) continue;
        toi_result const result = time_of_impact(kind, &paths, contact);
        events[i].time = result.lower_bound;
        if (result.state != TOI_SEPARATED) verdicts[i] = SCAN_EVENT;
    }
    for (size_t i = 0; i < count; i++)
        if (verdicts[i] != SCAN_DROP && pair_is_ignored(scene, kind, pairs[i]))
            verdicts[i] = SCAN_DROP;
}

tulle_status gather_rows(const contact_scene *scene, const contact_store *store,
                         const double *predicted, pair_source *source, row_list *list) {
    arena_mark const mark = arena_get_mark(scene->scratch);
    double const slack = compute_rounding_slack(scene, predicted);
    gathering work = {.scene = scene,
                      .predicted = predicted,
                      .start_and_rest = make_records(scene, scene->x0, scene->rest),
                      .largest_contact = scene->largest_contact + slack,
                      .largest_separation = scene->largest_separation + slack};
    pair_scan const scan = {.records = make_records(scene, scene->x0, predicted),
                            .at_start = work.largest_separation,
                            .at_end = work.largest_contact,
                            .measure = measure_touches,
                            .context = &work,
                            .notes_near_pairs = true};
    bool const has_memory =
        work.start_and_rest && make_feature_tables(scene, scan.records, &work.tables);
    pair_events found;
    list->rows.count = 0;
    tulle_status status = has_memory ? TULLE_OK : TULLE_ERROR_OUT_OF_MEMORY;
    if (status == TULLE_OK) status = scan_pairs(scene, source->pairs, &scan, &found);
    if (status == TULLE_OK) status = note_near_pairs(scene, &found, &list->near_pairs);
    if (status == TULLE_OK) {
        source->near_pairs = &list->near_pairs;
        status = choose_rows(scene, store, predicted, &found, list);
    }
    list->gathered_count = list->rows.count;
    arena_release(scene->scratch, mark);
    return status;
}

void row_list_destroy(row_list *list, memory *heap) {
    ARRAY_FREE(heap, &list->rows);
    ARRAY_FREE(heap, &list->near_pairs.pairs);
    list->gathered_count = 0;
}
