/* contact/rows/choose_rows.c - in stage 5, see choose_rows.h. Most events get no row, so each is
 * dropped by the cheapest test that drops it, and only what is left is worked out and written. Each
 * row stays where its event is; what goes on from there are pointers. */
#include "contact/rows/choose_rows.h"

#include "base/parallel.h"
#include "contact/response.h"
#include "contact/rows/admissible_rows.h"
#include "contact/rows/carry_over.h"
#include "contact/rows/contact_rows.h"
#include "contact/rows/contact_store.h"
#include "contact/rows/hidden_rows.h"
#include "contact/rows/row_motion.h"

#include <string.h>

enum {
    ROW_CHUNK = 64, /* events; some 20 microseconds */
    COPY_CHUNK = 64 /* rows; some 10 microseconds */
};

/* What becomes of a row: reserved ones are kept only when a contact is carried over to them. */
typedef enum row_choice { ROW_DROPPED, ROW_RESERVED, ROW_KEPT } row_choice;

typedef struct row_work {
    const contact_scene *scene;
    const contact_store *store;
    const double *predicted;
    const pair_event *events;
    size_t event_count, vertex_event_count; /* those of vertices come first */
    contact_row *rows;                      /* one an event; not set where it is dropped */
    uint8_t *choices;                       /* row_choice of each */
    near_planes planes;                     /* of vertex events; null: no row is hidden */
} row_work;

/* Contacts of the step before are held to a wider tolerance; so are new rows that one of them may
 * be carried over to. What turns with a body may land on other features than the nearest of the
 * start. */
static row_choice choose_row(const row_work *work, const contact_row *row, double time) {
    const contact_scene *const scene = work->scene;
    const contact_settings *const settings = &scene->settings;
    double const turn = compute_row_turn(scene, row);
    const double tolerances[2] = {settings->slope_tolerance + turn,
                                  settings->old_slope_tolerance + turn};
    bool const may_inherit = work->store->contacts.count > 0 && !is_on_rim(row->frame.weights);
    bool is_within[2] = {!row->law.is_old, row->law.is_old || may_inherit};
    test_admissible(scene, work->predicted, row, time, tolerances, is_within);
    if (is_within[0]) return ROW_KEPT;
    if (!is_within[1]) return ROW_DROPPED;
    return row->law.is_old ? ROW_KEPT : ROW_RESERVED;
}

/* Rows of edges are tried against the planes of those of vertices before they are completed. */
static row_choice make_row(const row_work *work, size_t i, contact_reader *reader,
                           contact_row *row) {
    const contact_scene *const scene = work->scene;
    const pair_event *const event = &work->events[i];
    bool const is_edge_row = event->kind == FEATURE_EDGE_EDGE;
    uint32_t vertices[4];
    closest_points const closest = compute_contact_points(scene, work->predicted, event, vertices);
    if (is_edge_row && is_on_rim(closest.weights)) return ROW_DROPPED;
    const stored_contact *const kept = read_contact(reader, event->kind, event->pair);
    begin_contact_row(scene, event, vertices, &closest, row);
    row->law.is_old = kept != NULL;
    if (is_edge_row && row_is_hidden(scene, work->predicted, &work->planes, row, i))
        return ROW_DROPPED;
    row_choice const choice = choose_row(work, row, event->time);
    if (choice == ROW_DROPPED || !finish_contact_row(scene, row)) return ROW_DROPPED;
    straighten_row(scene, work->predicted, event->time, row);
    if (event->time == 0.0) turn_row_to_end(scene, row);
    if (!kept) return choice;
    inherit_contact(scene, row, kept, scene->time_step / work->store->time_step, 1.0);
    row->solve.is_hard = kept->is_hard != 0;
    row->solve.state = row->law.old_state;
    return choice;
}

static void make_vertex_rows(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    const row_work *const work = context;
    contact_reader reader =
        read_contacts_from(work->store, work->events[begin].kind, work->events[begin].pair);
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
    if (i == end) return;
    contact_reader reader =
        read_contacts_from(work->store, work->events[i].kind, work->events[i].pair);
    for (; i < end; i++) {
        contact_row row;
        row_choice const choice = make_row(work, i, &reader, &row);
        work->choices[i] = (uint8_t)choice;
        if (choice != ROW_DROPPED) work->rows[i] = row;
    }
}

/* A row for each event that deserves one. Where rows are not fitted to obstacles none is hidden. */
static tulle_status make_rows(row_work *work) {
    const contact_scene *const scene = work->scene;
    near_planes *const planes = &work->planes;
    size_t count = 0; /* of vertex events */
    while (count < work->event_count && work->events[count].kind == FEATURE_VERTEX_TRIANGLE)
        count++;
    work->vertex_event_count = count;
    work->choices = ARENA_NEW(scene->scratch, uint8_t, work->event_count);
    work->rows = ARENA_NEW(scene->scratch, contact_row, work->event_count);
    if (!work->choices || !work->rows) return TULLE_ERROR_OUT_OF_MEMORY;
    if (scene->response->fits_rows) {
        planes->of_rows = ARENA_NEW(scene->scratch, near_plane, count);
        planes->nearest = ARENA_NEW(scene->scratch, uint32_t, scene->vertex_count);
        if (!planes->of_rows || !planes->nearest) return TULLE_ERROR_OUT_OF_MEMORY;
        for (size_t v = 0; v < scene->vertex_count; v++) planes->nearest[v] = TULLE_NONE;
    }
    parallel_for(count, ROW_CHUNK, scene->threads, make_vertex_rows, work);
    for (size_t i = 0; i < count && planes->of_rows; i++) {
        uint32_t *const nearest = &planes->nearest[work->events[i].pair.first];
        double const distance = planes->of_rows[i].distance;
        if (!(distance > 0.0)) continue;
        if (*nearest == TULLE_NONE || planes->of_rows[*nearest].distance > distance)
            *nearest = (uint32_t)i;
    }
    parallel_for(work->event_count, ROW_CHUNK, scene->threads, end_rows, work);
    return TULLE_OK;
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
    arena_mark const mark = arena_get_mark(scratch);
    row_work work = {.scene = scene,
                     .store = store,
                     .predicted = predicted,
                     .events = found->events,
                     .event_count = found->count};
    list->rows.count = 0;
    tulle_status status = make_rows(&work);
    /* the rows of each choice, in the order of their events */
    size_t kept_count = 0, reserve_count = 0;
    contact_row **const kept = ARENA_NEW(scratch, contact_row *, found->count);
    contact_row **const reserve = ARENA_NEW(scratch, contact_row *, found->count);
    if (!kept || !reserve) status = TULLE_ERROR_OUT_OF_MEMORY;
    for (size_t i = 0; status == TULLE_OK && i < found->count; i++) {
        if (work.choices[i] == ROW_KEPT) kept[kept_count++] = &work.rows[i];
        if (work.choices[i] == ROW_RESERVED) reserve[reserve_count++] = &work.rows[i];
    }
    if (status == TULLE_OK) status = thin_rim_rows(scene, kept, &kept_count);
    if (status == TULLE_OK)
        status = carry_over_contacts(scene, store, kept, &kept_count, reserve, reserve_count);
    if (status == TULLE_OK && !ARRAY_RESERVE(scene->heap, &list->rows, kept_count))
        status = TULLE_ERROR_OUT_OF_MEMORY;
    if (status == TULLE_OK) {
        row_copy copy = {list->rows.data, kept};
        parallel_for(kept_count, COPY_CHUNK, scene->threads, copy_rows, &copy);
        list->rows.count = kept_count;
    }
    arena_release(scratch, mark);
    return status;
}
