/* app/view/source_run.c - see source_run.h. */
#include "app/view/source_run.h"

#include "base/error.h"

#include <stdio.h>
#include <string.h>

enum { PATH_SIZE = 4200 /* [bytes] */, PROBLEMS_SIZE = sizeof(tulle_scene_problems) };

/* The last part of a path without the slashes behind it. */
static const char *copy_last_part(view_document *document, const char *path) {
    size_t length = strlen(path), begin;
    while (length > 1 && path[length - 1] == '/') length--;
    for (begin = length; begin > 0 && path[begin - 1] != '/';) begin--;
    char part[PATH_SIZE];
    snprintf(part, sizeof part, "%.*s", (int)(length - begin), path + begin);
    return document_copy_text(document, part);
}

/* How the scene in the run says that things look; the default where it does not. */
static scene_picture read_looks(const view_run *run, memory *heap) {
    scene_picture picture = scene_picture_default();
    char path[PATH_SIZE];
    int const length = snprintf(path, sizeof path, "%s/scene.yaml", run->path);
    tulle_scene_problems *const problems = memory_allocate(heap, PROBLEMS_SIZE);
    if (run->info->scene_text && length > 0 && length < PATH_SIZE && problems)
        (void)scene_read_picture(path, &picture, problems);
    memory_release(heap, problems, PROBLEMS_SIZE);
    if (picture.look_count != run->info->body_count) { /* copies were edited away */
        scene_camera const camera = picture.camera;
        scene_picture_destroy(&picture);
        picture.camera = camera;
    }
    return picture;
}

tulle_status view_run_open(view_run *run, const char *path, view_document *document,
                           tulle_error *error) {
    *run = (view_run){.path = path, .series.heap = memory_default()};
    tulle_status status = tulle_run_reader_open(path, &run->reader, error);
    if (status != TULLE_OK) return status;
    run->info = tulle_run_reader_get_info(run->reader);
    if (run->info->frame_count == 0)
        return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, path, 0, 0,
                            "the run holds no whole frame yet; try again in a moment");
    if (!document_begin(document, run->info->body_count))
        return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "out of memory");
    document->kind = KIND_RUN;
    document->title = document->name = copy_last_part(document, path);
    document->has_debug = run->info->has_debug != 0;
    document->step_seconds = run->info->time_step;
    document->frame_seconds = run->info->time_step * run->info->steps_per_frame;
    for (size_t i = 0; i < run->info->body_count && status == TULLE_OK; i++) {
        const tulle_run_body_info *const body = &run->info->bodies[i];
        view_role const role = !body->is_obstacle ? ROLE_CLOTH
                               : body->is_dynamic ? ROLE_BODY
                                                  : ROLE_OBSTACLE;
        tulle_mesh_view mesh;
        status = tulle_run_reader_get_mesh(run->reader, i, &mesh, error);
        if (status == TULLE_OK) status = document_add(document, body->name, role, mesh, error);
        if (status == TULLE_OK) document->objects[i].is_static = body->is_static != 0;
        if (3 * (size_t)body->vertex_count > run->scratch_count)
            run->scratch_count = 3 * (size_t)body->vertex_count;
    }
    if (status != TULLE_OK) return status;
    run->scratch = memory_allocate(&document->heap, run->scratch_count * sizeof *run->scratch);
    if (!run->scratch) return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "out of memory");
    scene_picture picture = read_looks(run, &document->heap);
    document_finish(document, &picture);
    scene_picture_destroy(&picture);
    return TULLE_OK;
}

void view_run_close(view_run *run) {
    memory heap = memory_default();
    tulle_run_reader_close(run->reader);
    memory_release(&heap, run->scratch, run->scratch_count * sizeof *run->scratch);
    series_clear(&run->series);
    *run = (view_run){0};
}

view_progress view_run_get_progress(const view_run *run) {
    return (view_progress){run->info->frame_count, run->info->state == TULLE_RUN_RUNNING};
}

/* What the run recorded beside positions; not all frames have it. */
static tulle_status read_debug(view_run *run, uint32_t number, tulle_error *error) {
    const tulle_run_debug *debug = NULL;
    run->has_read_debug = false;
    if (!run->info->has_debug) return TULLE_OK;
    tulle_status const status = tulle_run_reader_read_debug(run->reader, number, &debug, error);
    if (status != TULLE_OK || !debug) return status;
    run->debug = *debug;
    run->has_read_debug = true;
    return TULLE_OK;
}

static void fill_overlay(const view_run *run, const view_document *document, view_overlay_kind kind,
                         view_frame *frame) {
    view_overlay *const overlay = &frame->overlays[kind];
    const tulle_run_debug *const debug = &run->debug;
    overlay_begin(overlay);
    if (kind == OVERLAY_STRAIN) overlay_put_flat_strains(overlay, document, frame->positions);
    if (!run->has_read_debug) return;
    if (kind == OVERLAY_CONTACTS)
        overlay_put_contacts(overlay, debug->contacts, debug->contact_count);
    for (size_t i = 0; i < document->object_count; i++) {
        tulle_mesh_view const mesh = document->objects[i].mesh;
        if (kind == OVERLAY_VELOCITIES && debug->velocities[i]) {
            overlay_put_object(overlay, i, mesh.vertex_count);
            overlay_put_doubles(overlay, debug->velocities[i], 3 * mesh.vertex_count);
        }
        if (kind == OVERLAY_PATCHES && debug->patch_labels[i]) {
            overlay_put_object(overlay, i, mesh.triangle_count);
            buffer_put_u32s(&overlay->bytes, debug->patch_labels[i], mesh.triangle_count);
        }
    }
}

tulle_status view_run_read(view_run *run, const view_document *document, uint32_t number,
                           unsigned overlays, view_frame *frame, tulle_error *error) {
    tulle_status status =
        tulle_run_reader_get_frame(run->reader, number, &frame->time, &frame->step, NULL);
    if (status != TULLE_OK)
        return error_set(error, status, "there is no frame %u; the run has %u", number,
                         run->info->frame_count);
    frame->number = number;
    for (size_t i = 0; i < document->object_count && status == TULLE_OK; i++) {
        const view_object *const object = &document->objects[i];
        frame->is_absent[i] = !tulle_run_reader_is_present(run->reader, number, i);
        if (object->is_static || frame->is_absent[i]) continue;
        status = tulle_run_reader_read_positions(run->reader, number, i, run->scratch, error);
        float *const to = frame->positions + 3 * object->vertex_begin;
        for (size_t k = 0; k < 3 * object->mesh.vertex_count && status == TULLE_OK; k++)
            to[k] = (float)run->scratch[k];
    }
    unsigned const at_once = overlays & ~OVERLAYS_LATE;
    if (status == TULLE_OK && at_once != 0) status = read_debug(run, number, error);
    for (int kind = 0; kind < OVERLAY_COUNT; kind++) {
        frame->overlays[kind].is_filled = false;
        if (status == TULLE_OK && at_once >> kind & 1u)
            fill_overlay(run, document, (view_overlay_kind)kind, frame);
    }
    return status;
}

static bool is_same_run(const tulle_run_info *a, const tulle_run_info *b) {
    if (a->scene_hash != b->scene_hash || a->body_count != b->body_count) return false;
    for (size_t i = 0; i < a->body_count; i++)
        if (a->bodies[i].vertex_count != b->bodies[i].vertex_count ||
            a->bodies[i].triangle_count != b->bodies[i].triangle_count)
            return false;
    return true;
}

bool view_run_follow(view_run *run) {
    if (run->info->state != TULLE_RUN_RUNNING) return false;
    tulle_run_reader *reader = NULL;
    if (tulle_run_reader_open(run->path, &reader, NULL) != TULLE_OK) return false;
    const tulle_run_info *const info = tulle_run_reader_get_info(reader);
    bool const is_news =
        info->frame_count > run->info->frame_count || info->state != run->info->state;
    if (!is_news || !is_same_run(run->info, info)) {
        tulle_run_reader_close(reader);
        return false;
    }
    tulle_run_reader_close(run->reader);
    run->reader = reader;
    run->info = info;
    run->has_series = run->has_read_debug = false;
    return true;
}

tulle_status view_run_read_series(view_run *run, tulle_error *error) {
    if (run->has_series) return TULLE_OK;
    const tulle_step_report *reports = NULL;
    size_t count = 0;
    tulle_status const status = tulle_run_reader_get_reports(run->reader, &reports, &count, error);
    if (status != TULLE_OK) return status;
    series_clear(&run->series);
    for (size_t i = 0; i < count; i++) {
        series_row const row = series_make_row(&reports[i]);
        series_add(&run->series, &row, false);
    }
    run->has_series = true;
    return TULLE_OK;
}
