/* contact/gather_contacts.c - stage 2, see gather_contacts.h.
 *
 * A pair gets a row when it is near now (frame of now) or its predicted path comes within the
 * contact distance (frame of that time, so that the row pushes where the impact will be). Rows
 * only shape the response; what has no row is still caught by stages 10 and 11. */
#include "contact/gather_contacts.h"

#include "base/parallel.h"
#include "base/timer.h"
#include "contact/apart_pairs.h"
#include "contact/carry_over.h"
#include "contact/contact_rows.h"
#include "contact/hidden_rows.h"
#include "contact/near_pairs.h"
#include "contact/pair_filter.h"
#include "contact/row_motion.h"
#include "contact/select_admissible.h"

#include <string.h>

enum { ROW_CHUNK = 64 /* events; some 40 microseconds */ };

/* What becomes of a row: reserved ones are kept only when a contact is carried over to them. */
typedef enum row_choice { ROW_DROPPED, ROW_RESERVED, ROW_KEPT } row_choice;

typedef struct gathering {
    const contact_scene *scene;
    const contact_store *store;
    const double *predicted;
    const vertex_record *now_and_rest;          /* x0 and the rest shape */
    pair_tables tables;                         /* of x0 -> predicted */
    double largest_contact, largest_separation; /* [m] with rounding slack */
    const pair_event *events;
    contact_row *rows;         /* one an event */
    uint8_t *choices;          /* row_choice of each */
    near_plane *planes;        /* of each vertex */
    size_t vertex_event_count; /* they come before those of edges */
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

/* Distances [m] of pairs at x0 and in the rest shape. */
typedef struct scan_distances {
    double now[SCAN_MOST], rest[SCAN_MOST];
} scan_distances;

static void find_distances(const gathering *work, feature_kind kind, const pair_event *events,
                           size_t count, scan_distances *to) {
    feature_pair pairs[SCAN_MOST];
    for (size_t i = 0; i < count; i++) pairs[i] = events[i].pair;
    TULLE_PICK_KERNEL(measure_distances)
    (work->scene->set->topo, work->now_and_rest, kind, pairs, count,
     (double *[2]){to->now, to->rest});
}

/* Time 0 for a pair that is near now. */
static void measure_touches(const void *context, feature_kind kind, pair_event *events,
                            size_t count, scan_verdict *verdicts) {
    const gathering *const work = context;
    const contact_scene *const scene = work->scene;
    scan_distances distances;
    apart_query far = {.kind = kind, .count = 0};
    uint8_t indices[SCAN_MOST];
    find_distances(work, kind, events, count, &distances);
    for (size_t i = 0; i < count; i++) {
        uint32_t vertices[4];
        feature_pair_vertices(scene->set->topo, kind, events[i].pair, vertices);
        pair_distances const limits =
            limit_pair_distances(scene, kind, vertices, distances.rest[i]);
        events[i].distance = distances.now[i];
        events[i].time = 0.0;
        verdicts[i] = SCAN_EVENT;
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

/* Contacts of the step before are held to a wider tolerance; so are new rows that one of them may
 * be carried over to. What turns with a body lands elsewhere than where it is nearest now. */
static row_choice choose_row(const gathering *work, const contact_row *row, double time,
                             const stored_contact *kept) {
    const contact_scene *const scene = work->scene;
    const contact_settings *const settings = &scene->settings;
    double const turn = find_row_turn(scene, row);
    double const new_slope = settings->slope_tolerance + turn;
    double const old_slope = settings->old_slope_tolerance + turn;
    if (!kept && row_is_admissible(scene, work->predicted, row, time, new_slope)) return ROW_KEPT;
    if (!row_is_admissible(scene, work->predicted, row, time, old_slope)) return ROW_DROPPED;
    if (kept) return ROW_KEPT;
    return work->store->contacts.count > 0 && !row_is_on_rim(row) ? ROW_RESERVED : ROW_DROPPED;
}

static void make_row(gathering *work, size_t i) {
    const contact_scene *const scene = work->scene;
    contact_row *const row = &work->rows[i];
    const pair_event *const event = &work->events[i];
    work->choices[i] = ROW_DROPPED;
    if (!make_contact_row(scene, work->predicted, event, row)) return;
    const stored_contact *const kept = find_contact(work->store, row->kind, row->pair);
    work->choices[i] = choose_row(work, row, event->time, kept);
    if (work->choices[i] == ROW_DROPPED) return;
    straighten_row(scene, work->predicted, event->time, row);
    if (event->time == 0.0) turn_row_to_end(scene, row);
    if (kept) restore_contact(scene, row, kept, scene->time_step / work->store->time_step);
}

static void make_vertex_rows(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    for (size_t i = begin; i < end; i++) make_row(context, i);
}

/* What decides whether a row of two edges is hidden. */
static contact_row sketch_edge_row(const gathering *work, const pair_event *event) {
    contact_row row = {.kind = FEATURE_EDGE_EDGE, .pair = event->pair};
    row.is_old = find_contact(work->store, row.kind, row.pair) != NULL;
    vec3 points[4];
    feature_pair_vertices(work->scene->set->topo, row.kind, row.pair, row.vertices);
    for (int k = 0; k < 4; k++)
        points[k] = vec3_lerp(vec3_load(work->scene->x0, row.vertices[k]),
                              vec3_load(work->predicted, row.vertices[k]), event->time);
    closest_points const closest = closest_edge_edge(points);
    memcpy(row.weights, closest.weights, sizeof row.weights);
    return row;
}

/* Most edges on a flat are hidden, which is cheaper found before their rows are made. */
static void make_edge_rows(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    gathering *const work = context;
    for (size_t k = begin; k < end; k++) {
        size_t const i = work->vertex_event_count + k;
        contact_row const sketch = sketch_edge_row(work, &work->events[i]);
        work->choices[i] = ROW_DROPPED;
        if (!work->planes || !row_is_hidden(work->scene, work->predicted, work->planes, &sketch, i))
            make_row(work, i);
    }
}

/* The paper's response keeps all rows. */
static tulle_status drop_hidden_vertex_rows(gathering *work) {
    const contact_scene *const scene = work->scene;
    if (scene->paper) return TULLE_OK;
    work->planes = ARENA_NEW_ZEROED(scene->scratch, near_plane, scene->vertex_count);
    if (!work->planes) return TULLE_ERROR_OUT_OF_MEMORY;
    for (size_t i = 0; i < work->vertex_event_count; i++)
        if (work->choices[i] == ROW_KEPT && work->events[i].time == 0.0)
            note_near_plane(scene, work->predicted, &work->rows[i], i, work->planes);
    for (size_t i = 0; i < work->vertex_event_count; i++)
        if (work->choices[i] != ROW_DROPPED &&
            row_is_hidden(scene, work->predicted, work->planes, &work->rows[i], i))
            work->choices[i] = ROW_DROPPED;
    return TULLE_OK;
}

static tulle_status make_rows(gathering *work, size_t event_count) {
    int const threads = work->scene->threads;
    size_t *const count = &work->vertex_event_count;
    while (*count < event_count && work->events[*count].kind == FEATURE_VERTEX_TRIANGLE) ++*count;
    parallel_for(*count, ROW_CHUNK, threads, make_vertex_rows, work);
    tulle_status const status = drop_hidden_vertex_rows(work);
    if (status == TULLE_OK)
        parallel_for(event_count - *count, ROW_CHUNK, threads, make_edge_rows, work);
    return status;
}

/* Adds the time since *start to *total and restarts the clock. */
static void add_time(double *total, double *start) {
    double const now = timer_now();
    *total += now - *start;
    *start = now;
}

/* Stage 9: rows of the admissible ones among the events; *kept of them. */
static tulle_status select_rows(gathering *work, size_t event_count, size_t *kept) {
    const contact_scene *const scene = work->scene;
    tulle_status status = make_rows(work, event_count);
    if (status != TULLE_OK) return status;
    size_t reserve_count = 0;
    for (size_t i = 0; i < event_count; i++) reserve_count += work->choices[i] == ROW_RESERVED;
    contact_row *const reserve = ARENA_NEW(scene->scratch, contact_row, reserve_count);
    if (!reserve) return TULLE_ERROR_OUT_OF_MEMORY;
    *kept = reserve_count = 0;
    for (size_t i = 0; i < event_count; i++) {
        if (work->choices[i] == ROW_RESERVED) reserve[reserve_count++] = work->rows[i];
        if (work->choices[i] == ROW_KEPT) work->rows[(*kept)++] = work->rows[i];
    }
    status = thin_rim_rows(scene, work->rows, kept);
    if (status != TULLE_OK) return status;
    return carry_over_contacts(scene, work->store, work->rows, kept, reserve, reserve_count);
}

static tulle_status fill_rows(gathering *work, pair_source *source, row_list *list) {
    const contact_scene *const scene = work->scene;
    contact_times unused, *const times = scene->times ? scene->times : &unused;
    unused = (contact_times){0};
    double start = timer_now();
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
    add_time(&times->test_pairs, &start);
    if (status != TULLE_OK) return status;
    source->near_pairs = &list->near_pairs;
    work->events = found.events;
    work->choices = ARENA_NEW(scene->scratch, uint8_t, found.count);
    /* there are many more events than rows that are kept */
    work->rows = ARENA_NEW(scene->scratch, contact_row, found.count);
    if (!work->choices || !work->rows) return TULLE_ERROR_OUT_OF_MEMORY;
    size_t kept = 0;
    status = select_rows(work, found.count, &kept);
    if (status == TULLE_OK && !ARRAY_RESERVE(scene->heap, &list->rows, kept))
        status = TULLE_ERROR_OUT_OF_MEMORY;
    if (status == TULLE_OK) {
        if (kept > 0) memcpy(list->rows.data, work->rows, kept * sizeof *work->rows);
        list->rows.count = kept;
    }
    add_time(&times->select_admissible, &start);
    return status;
}

tulle_status gather_contacts(const contact_scene *scene, const contact_store *store,
                             const double *predicted, pair_source *source, row_list *list) {
    arena_mark const mark = arena_get_mark(scene->scratch);
    double const slack = find_rounding_slack(scene, predicted);
    gathering work = {.scene = scene, .store = store, .predicted = predicted};
    work.largest_separation = scene->largest_separation + slack;
    work.largest_contact = scene->largest_contact + slack;
    list->rows.count = 0;
    tulle_status const status = fill_rows(&work, source, list);
    list->gathered_count = list->rows.count;
    arena_release(scene->scratch, mark);
    return status;
}

void row_list_destroy(row_list *list, memory *heap) {
    ARRAY_FREE(heap, &list->rows);
    near_pair_list_destroy(&list->near_pairs, heap);
    list->gathered_count = 0;
}
