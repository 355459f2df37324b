/* contact/rows/gather_contacts.c - stage 2, see gather_contacts.h.
 *
 * A pair gets a row when it is near now (frame of now) or its predicted path comes within the
 * contact distance (frame of that time, so that the row pushes where the impact will be). Rows
 * only shape the response; what has no row is still caught by stages 10 and 11. */
#include "contact/rows/gather_contacts.h"

#include "contact/pairs/apart_pairs.h"
#include "contact/pairs/near_pairs.h"
#include "contact/pairs/pair_filter.h"
#include "contact/pairs/pair_rules.h"
#include "contact/rows/choose_rows.h"

typedef struct gathering {
    const contact_scene *scene;
    const double *predicted;
    const vertex_record *now_and_rest;          /* x0 and the rest shape */
    pair_tables tables;                         /* of x0 -> predicted */
    double largest_contact, largest_separation; /* [m] with rounding slack */
} gathering;

/* The time is when the path of a pair that is not near now first comes within the contact distance.
 */
static scan_verdict measure_approach(const gathering *work, pair_event *event, double contact) {
    const contact_scene *const scene = work->scene;
    feature_kind const kind = event->kind;
    uint32_t vertices[4];
    moving_pair paths;
    feature_pair_vertices(scene->set->topo, kind, event->pair, vertices);
    load_points(scene->x0, vertices, paths.start);
    load_points(work->predicted, vertices, paths.end);
    if (pair_stays_apart(kind, &paths, contact)) return SCAN_DROP;
    toi_result const result = time_of_impact(kind, &paths, contact);
    event->time = result.lower_bound;
    return result.state == TOI_SEPARATED ? SCAN_DROP : SCAN_EVENT;
}

/* Verdicts on pairs that are not near now: `indices` of those in the query. */
static void measure_approaches(const gathering *work, const apart_query *far,
                               const uint8_t *indices, pair_event *events, scan_verdict *verdicts) {
    bool is_apart[SCAN_MOST];
    find_apart(&work->tables, far, is_apart);
    for (size_t k = 0; k < far->count; k++) {
        size_t const i = indices[k];
        verdicts[i] =
            is_apart[k] ? SCAN_DROP : measure_approach(work, &events[i], far->separations[k]);
        if (verdicts[i] == SCAN_DROP && events[i].distance < work->largest_separation)
            verdicts[i] = SCAN_DROP_NEAR;
    }
}

/* Of pairs at x0 and in the rest shape. */
typedef struct scan_measures {
    double now[SCAN_MOST], rest[SCAN_MOST]; /* [m] distances */
    bool is_at_end[SCAN_MOST];
} scan_measures;

static void measure_scan(const gathering *work, feature_kind kind, const pair_event *events,
                         size_t count, scan_measures *to) {
    feature_pair pairs[SCAN_MOST];
    pair_measures const measures = {to->now, to->rest, to->is_at_end};
    for (size_t i = 0; i < count; i++) pairs[i] = events[i].pair;
    TULLE_PICK_KERNEL(measure_distances)
    (work->scene->set->topo, work->now_and_rest, kind, pairs, count, &measures);
}

/* Time 0 for a pair that is near now. Two edges that touch at an end are no event: rows of them are
 * left to the vertex's own (select_admissible.h). */
static void measure_touches(const void *context, feature_kind kind, pair_event *events,
                            size_t count, scan_verdict *verdicts) {
    const gathering *const work = context;
    const contact_scene *const scene = work->scene;
    scan_measures measures;
    apart_query far = {.kind = kind, .count = 0};
    uint8_t indices[SCAN_MOST];
    measure_scan(work, kind, events, count, &measures);
    for (size_t i = 0; i < count; i++) {
        uint32_t vertices[4];
        feature_pair_vertices(scene->set->topo, kind, events[i].pair, vertices);
        pair_distances const limits = limit_pair_distances(scene, kind, vertices, measures.rest[i]);
        events[i].distance = measures.now[i];
        events[i].time = 0.0;
        verdicts[i] = measures.is_at_end[i] ? SCAN_DROP_NEAR : SCAN_EVENT;
        if (!(events[i].distance >= limits.separation)) continue;
        indices[far.count] = (uint8_t)i;
        far.pairs[far.count] = events[i].pair;
        far.separations[far.count++] = limits.contact;
    }
    measure_approaches(work, &far, indices, events, verdicts);
    for (size_t i = 0; i < count; i++)
        if (verdicts[i] != SCAN_DROP && pair_is_ignored(scene, kind, events[i].pair))
            verdicts[i] = SCAN_DROP;
}

static tulle_status fill_rows(gathering *work, const contact_store *store, pair_source *source,
                              row_list *list) {
    const contact_scene *const scene = work->scene;
    pair_scan const scan = {.records = make_records(scene, scene->x0, work->predicted),
                            .at_start = work->largest_separation,
                            .at_end = work->largest_contact,
                            .measure = measure_touches,
                            .context = work,
                            .notes_near_pairs = true};
    pair_events found;
    work->now_and_rest = make_records(scene, scene->x0, scene->rest);
    if (!work->now_and_rest || !make_feature_tables(scene, scan.records, &work->tables))
        return TULLE_ERROR_OUT_OF_MEMORY;
    tulle_status status = scan_pairs(scene, source->pairs, &scan, &found);
    if (status == TULLE_OK) status = note_near_pairs(scene, &found, &list->near_pairs);
    if (status != TULLE_OK) return status;
    source->near_pairs = &list->near_pairs;
    return choose_rows(scene, store, work->predicted, &found, list);
}

tulle_status gather_contacts(const contact_scene *scene, const contact_store *store,
                             const double *predicted, pair_source *source, row_list *list) {
    arena_mark const mark = arena_get_mark(scene->scratch);
    double const slack = find_rounding_slack(scene, predicted);
    gathering work = {.scene = scene, .predicted = predicted};
    work.largest_separation = scene->largest_separation + slack;
    work.largest_contact = scene->largest_contact + slack;
    list->rows.count = 0;
    tulle_status const status = fill_rows(&work, store, source, list);
    list->gathered_count = list->rows.count;
    arena_release(scene->scratch, mark);
    return status;
}

void row_list_destroy(row_list *list, memory *heap) {
    ARRAY_FREE(heap, &list->rows);
    near_pair_list_destroy(&list->near_pairs, heap);
    list->gathered_count = 0;
}
