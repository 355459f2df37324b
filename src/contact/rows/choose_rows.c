/* contact/rows/choose_rows.c - in stage 5, see choose_rows.h. Most events get no row. So cheap
 * tests come first, and only rows that pass all of them are completed and written. A row stays at
 * the place of its event until the end; until then pointers to rows are sorted out. */
#include "contact/rows/choose_rows.h"

#include "base/parallel.h"
#include "contact/response.h"
#include "contact/rows/admissible_rows.h"
#include "contact/rows/carry_over.h"
#include "contact/rows/contact_rows.h"
#include "contact/rows/contact_store.h"
#include "contact/rows/hidden_rows.h"
#include "contact/rows/row_motion.h"

enum {
    ROW_CHUNK = 64, /* events; some 20 microseconds */
    COPY_CHUNK = 64 /* rows; some 10 microseconds */
};

typedef struct row_work {
    const contact_scene *scene;
    const contact_store *store;
    const double *predicted;
    const pair_event *events;
    size_t vertex_event_count; /* events of vertices come first */
    contact_row *rows;         /* one an event; not set where it is dropped */
    uint8_t *choices;          /* row_choice of each */
    near_planes planes;        /* of vertex events; null: no row is hidden */
} row_work;

/* Tests the pair of event i, the cheapest test first, and completes its row if it passes all. Rows
 * of edges are tried against the planes of those of vertices before that. */
static row_choice make_row(const row_work *work, size_t i, contact_reader *reader,
                           contact_row *row) {
    const contact_scene *const scene = work->scene;
    const contact_settings *const settings = &scene->settings;
    const pair_event *const event = &work->events[i];
    bool const is_edge_row = event->kind == FEATURE_EDGE_EDGE;
    begin_contact_row(scene, work->predicted, event, row);
    bool const is_rim_row = is_on_rim(row->frame.weights);
    if (is_edge_row && is_rim_row) return ROW_DROPPED; /* left to the vertex's own rows */
    const stored_contact *const kept = read_contact(reader, event->kind, event->pair);
    bool const is_old = kept != NULL;
    row->law.is_old = is_old;
    if (is_edge_row && row_is_hidden(scene, work->predicted, &work->planes, row, i))
        return ROW_DROPPED;

    /* Contacts of the step before are held to a wider tolerance. So are new rows that one of them
     * may be carried over to. A body that turns may land on features that were not the nearest at
     * the start. */
    double turn = 0.0;
    for (int side = 0; side < 2; side++) {
        const contact_body *const body = find_side_body(scene, row, side);
        if (body) turn += vec3_norm(body->turn_vector);
    }
    const double tolerances[2] = {settings->slope_tolerance + turn,
                                  settings->old_slope_tolerance + turn};
    bool const may_inherit = work->store->contacts.count > 0 && !is_rim_row;
    bool is_within[2] = {!is_old, is_old || may_inherit};
    test_admissible(scene, work->predicted, row, event->time, tolerances, is_within);
    if (!is_within[0] && !is_within[1]) return ROW_DROPPED;

    if (!finish_contact_row(scene, row)) return ROW_DROPPED;
    straighten_row(scene, work->predicted, event->time, false, row);
    if (event->time == 0.0) turn_row_to_end(scene, row);
    if (!is_old) return is_within[0] ? ROW_KEPT : ROW_RESERVED;
    inherit_contact(scene, row, kept, scene->time_step / work->store->time_step, 1.0);
    row->solve.is_hard = kept->is_hard != 0;
    row->solve.state = row->law.old_state;
    return ROW_KEPT;
}

static void make_vertex_rows(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    const row_work *const work = context;
    contact_reader reader = {.store = work->store};
    for (size_t i = begin; i < end; i++) {
        contact_row row;
        row_choice const choice = make_row(work, i, &reader, &row);
        work->choices[i] = (uint8_t)choice;
        if (choice != ROW_DROPPED) work->rows[i] = row;
        if (!work->planes.of_rows) continue;
        near_plane *const plane = &work->planes.of_rows[i];
        if (choice == ROW_KEPT && work->events[i].time == 0.0)
            make_near_plane(work->scene, work->predicted, &row, plane);
        else
            plane->distance = 0.0;
    }
}

/* Drops the hidden ones among the rows of vertices, and makes those of edges. */
static void end_rows(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    const row_work *const work = context;
    size_t i = begin;
    for (; i < end && i < work->vertex_event_count; i++)
        if (work->choices[i] != ROW_DROPPED &&
            row_is_hidden(work->scene, work->predicted, &work->planes, &work->rows[i], i))
            work->choices[i] = ROW_DROPPED;
    contact_reader reader = {.store = work->store};
    for (; i < end; i++) {
        contact_row row;
        row_choice const choice = make_row(work, i, &reader, &row);
        work->choices[i] = (uint8_t)choice;
        if (choice != ROW_DROPPED) work->rows[i] = row;
    }
}

typedef struct row_copy {
    contact_row *to;
    contact_row *const *from;
} row_copy;

static void copy_rows(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    const row_copy *const copy = context;
    for (size_t i = begin; i < end; i++) copy->to[i] = *copy->from[i];
}

tulle_status choose_rows(const contact_scene *scene, const contact_store *store,
                         const double *predicted, const pair_events *found, row_list *list) {
    arena *const scratch = scene->scratch;
    row_work work = {.scene = scene,
                     .store = store,
                     .predicted = predicted,
                     .events = found->events,
                     .rows = ARENA_NEW(scratch, contact_row, found->count),
                     .choices = ARENA_NEW(scratch, uint8_t, found->count)};
    contact_row **const rows = ARENA_NEW(scratch, contact_row *, found->count);
    list->rows.count = 0;
    if (!work.rows || !work.choices || !rows) return TULLE_ERROR_OUT_OF_MEMORY;
    size_t vertex_count = 0; /* events of vertices */
    while (vertex_count < found->count &&
           found->events[vertex_count].kind == FEATURE_VERTEX_TRIANGLE)
        vertex_count++;
    work.vertex_event_count = vertex_count;
    near_planes *const planes = &work.planes;
    if (scene->response->fits_rows) {
        planes->of_rows = ARENA_NEW(scratch, near_plane, vertex_count);
        planes->nearest = ARENA_NEW(scratch, uint32_t, scene->vertex_count);
        if (!planes->of_rows || !planes->nearest) return TULLE_ERROR_OUT_OF_MEMORY;
        for (size_t v = 0; v < scene->vertex_count; v++) planes->nearest[v] = TULLE_NONE;
    }

    /* rows of vertices, the nearest plane to each vertex, then the other rows */
    parallel_for(vertex_count, ROW_CHUNK, scene->threads, make_vertex_rows, &work);
    for (size_t i = 0; i < vertex_count && planes->of_rows; i++) {
        uint32_t *const nearest = &planes->nearest[found->events[i].pair.first];
        double const distance = planes->of_rows[i].distance;
        if (!(distance > 0.0)) continue;
        if (*nearest == TULLE_NONE || planes->of_rows[*nearest].distance > distance)
            *nearest = (uint32_t)i;
    }
    parallel_for(found->count, ROW_CHUNK, scene->threads, end_rows, &work);

    /* the remaining rows, in the order of the events */
    size_t count = 0;
    for (size_t i = 0; i < found->count; i++) {
        if (work.choices[i] == ROW_DROPPED) continue;
        rows[count] = &work.rows[i];
        work.choices[count++] = work.choices[i];
    }
    tulle_status status = thin_rim_rows(scene, rows, work.choices, count);
    if (status == TULLE_OK) status = carry_over_contacts(scene, store, rows, work.choices, count);
    if (status != TULLE_OK) return status;
    size_t kept = 0;
    for (size_t i = 0; i < count; i++)
        if (work.choices[i] == ROW_KEPT) rows[kept++] = rows[i];
    if (!ARRAY_RESERVE(scene->heap, &list->rows, kept)) return TULLE_ERROR_OUT_OF_MEMORY;
    row_copy copy = {list->rows.data, rows};
    parallel_for(kept, COPY_CHUNK, scene->threads, copy_rows, &copy);
    list->rows.count = kept;
    return TULLE_OK;
}
