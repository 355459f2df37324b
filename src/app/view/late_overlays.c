/* app/view/late_overlays.c - overlays that take long: gaps, and triangles that cross by the judge.
 * The worker makes them of a copy of the frame; a client has one of each under way at a time, so
 * the newest frame that is asked for comes next. */
#include "app/view/session.h"
#include "render/rest_coordinates.h"
#include "render/surface_gap.h"

#include <math.h>
#include <string.h>

static const double GAP_FARTHEST = 0.05; /* [m] beyond, gaps are of no interest */

typedef struct overlay_job {
    view_job head;
    memory heap;
    const view_document *document; /* outlives the job: worker_drop_all */
    uint32_t client, number;
    double time;
    view_overlay_kind kind;
    double *positions; /* of all objects */
    uint8_t *is_absent;
    view_overlay overlay;
} overlay_job;

static tulle_mesh_view get_mesh(const overlay_job *job, size_t object) {
    tulle_mesh_view mesh = job->document->objects[object].mesh;
    mesh.positions = job->positions + 3 * job->document->objects[object].vertex_begin;
    if (job->is_absent[object]) mesh.triangle_count = 0;
    return mesh;
}

static void find_crossings(overlay_job *job) {
    size_t const count = job->document->object_count;
    tulle_check_body *const bodies = memory_allocate_zeroed(&job->heap, count + 1, sizeof *bodies);
    for (size_t i = 0; bodies && i < count; i++)
        bodies[i] =
            (tulle_check_body){get_mesh(job, i), job->document->objects[i].role != ROLE_CLOTH};
    tulle_check_result result = {0};
    if (bodies && tulle_check_intersections(bodies, count, 1, &result, NULL) == TULLE_OK) {
        overlay_begin(&job->overlay);
        overlay_put_pairs(&job->overlay, result.pairs, result.pair_count);
        tulle_check_result_destroy(&result);
    }
    memory_release(&job->heap, bodies, (count + 1) * sizeof *bodies);
}

/* Room for all objects: surfaces, their pieces, the gaps of cloth. */
typedef struct gap_work {
    render_gap_surface *surfaces;
    double **gaps;
    uint32_t **pieces;
} gap_work;

static bool prepare_surface(overlay_job *job, gap_work *work, size_t i) {
    tulle_mesh_view const mesh = get_mesh(job, i);
    render_gap_surface *const surface = &work->surfaces[i];
    *surface = (render_gap_surface){.mesh = mesh};
    if (job->document->objects[i].role != ROLE_CLOTH) return true;
    const view_object *const cloth = &job->document->objects[i];
    work->gaps[i] = memory_allocate(&job->heap, (mesh.vertex_count + 1) * sizeof(double));
    work->pieces[i] =
        memory_allocate(&job->heap, (cloth->mesh.triangle_count + 1) * sizeof(uint32_t));
    surface->rest = cloth->mesh.positions;
    surface->pieces = work->pieces[i];
    return work->gaps[i] && work->pieces[i] &&
           render_find_pieces(&job->heap, cloth->mesh, work->pieces[i], &surface->piece_count,
                              NULL) == TULLE_OK;
}

static void put_gaps(overlay_job *job, const gap_work *work) {
    overlay_begin(&job->overlay);
    for (size_t i = 0; i < job->document->object_count; i++) {
        if (!work->gaps[i]) continue;
        size_t const count = job->document->objects[i].mesh.vertex_count;
        overlay_put_object(&job->overlay, i, count);
        for (size_t v = 0; v < count; v++) {
            bool const is_near = work->gaps[i][v] < GAP_FARTHEST;
            buffer_put_f32(&job->overlay.bytes, is_near ? (float)work->gaps[i][v] : INFINITY);
        }
    }
}

static void find_gaps(overlay_job *job) {
    size_t const count = job->document->object_count;
    gap_work work = {.surfaces =
                         memory_allocate_zeroed(&job->heap, count + 1, sizeof *work.surfaces),
                     .gaps = memory_allocate_zeroed(&job->heap, count + 1, sizeof *work.gaps),
                     .pieces = memory_allocate_zeroed(&job->heap, count + 1, sizeof *work.pieces)};
    bool is_good = work.surfaces && work.gaps && work.pieces;
    for (size_t i = 0; i < count && is_good; i++) is_good = prepare_surface(job, &work, i);
    render_gap_def const def = {work.surfaces, count, GAP_FARTHEST, 1};
    if (is_good && render_measure_gaps(&job->heap, &def, work.gaps, NULL) == TULLE_OK)
        put_gaps(job, &work);
    for (size_t i = 0; i < count && work.gaps && work.pieces; i++) {
        tulle_mesh_view const mesh = job->document->objects[i].mesh;
        if (work.gaps[i])
            memory_release(&job->heap, work.gaps[i], (mesh.vertex_count + 1) * sizeof(double));
        if (work.pieces[i])
            memory_release(&job->heap, work.pieces[i],
                           (mesh.triangle_count + 1) * sizeof(uint32_t));
    }
    memory_release(&job->heap, work.surfaces, (count + 1) * sizeof *work.surfaces);
    memory_release(&job->heap, work.gaps, (count + 1) * sizeof *work.gaps);
    memory_release(&job->heap, work.pieces, (count + 1) * sizeof *work.pieces);
}

static void work_on_overlay(view_job *head) {
    overlay_job *const job = (overlay_job *)head;
    if (job->kind == OVERLAY_CROSSINGS)
        find_crossings(job);
    else
        find_gaps(job);
}

static void finish_overlay(view_job *head, void *owner) {
    overlay_job *const job = (overlay_job *)head;
    view_client *const client = session_find_client(owner, job->client);
    if (!client) return;
    client->late &= ~(1u << job->kind);
    if (client->missed >> job->kind & 1u) { /* the last frame comes again, with what it lacks */
        client->missed &= ~(1u << job->kind);
        client->live_version = 0;
        if (client->stream.remaining == 0)
            client->stream = (client_stream){client->last_sent, 1, 1, false};
    }
    if (!job->overlay.is_filled || !(client->overlays >> job->kind & 1u)) return;
    view_buffer buffer = {0};
    overlay_write(&job->overlay, job->kind, job->number, job->time, &buffer);
    client_push(client, &buffer, true);
}

static void release_overlay(view_job *head) {
    overlay_job *const job = (overlay_job *)head;
    memory heap = job->heap;
    size_t const numbers = 3 * job->document->vertex_count + 1;
    memory_release(&heap, job->positions, numbers * sizeof *job->positions);
    memory_release(&heap, job->is_absent, job->document->object_count + 1);
    buffer_release(&job->overlay.bytes);
    memory_release(&heap, job, sizeof *job);
}

void late_overlays_ask(view_session *session, view_client *client, const view_frame *frame,
                       unsigned overlays) {
    const view_document *const document = &session->document;
    size_t const numbers = 3 * document->vertex_count + 1;
    client->last_sent = frame->number;
    for (int kind = 0; kind < OVERLAY_COUNT; kind++) {
        if (!(overlays >> kind & 1u)) continue;
        if (client->late >> kind & 1u) {
            client->missed |= 1u << kind;
            continue;
        }
        memory heap = memory_default();
        overlay_job *const job = memory_allocate_zeroed(&heap, 1, sizeof *job);
        if (!job) return;
        job->head = (view_job){
            .work = work_on_overlay, .finish = finish_overlay, .release = release_overlay};
        job->heap = heap;
        job->document = document;
        job->client = client->number;
        job->number = frame->number;
        job->time = frame->time;
        job->kind = (view_overlay_kind)kind;
        job->positions = memory_allocate(&heap, numbers * sizeof *job->positions);
        job->is_absent = memory_allocate(&heap, document->object_count + 1);
        if (!job->positions || !job->is_absent) {
            release_overlay(&job->head);
            return;
        }
        for (size_t i = 0; i + 1 < numbers; i++) job->positions[i] = (double)frame->positions[i];
        memcpy(job->is_absent, frame->is_absent, document->object_count);
        if (worker_post(session->worker, &job->head)) client->late |= 1u << kind;
    }
}
