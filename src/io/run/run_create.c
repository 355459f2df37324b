/* io/run/run_create.c - makes the directory of a run.
 *
 * run.json is written first. So a directory that a killed process left half made is known as a run;
 * without a checkpoint such a run begins again from the start. */
#define _POSIX_C_SOURCE 200809L
#include "base/error.h"
#include "io/cache/pc2.h"
#include "io/file_data.h"
#include "io/output_file.h"
#include "io/run/run_report.h"
#include "io/run/run_writer.h"
#include "io/unflushed.h"

#include "tulle_io/mesh_files.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

tulle_run_def tulle_run_def_default(void) {
    return (tulle_run_def){.cookie = RUN_DEF_COOKIE, .steps_per_frame = 1};
}

tulle_status run_writer_check_def(const tulle_run_def *def, tulle_error *error) {
    if (!def || def->cookie != RUN_DEF_COOKIE)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "the def should come from tulle_run_def_default");
    if (!def->directory || def->body_count < 1 || def->body_count > RUN_BODY_MAX || !def->bodies)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "a run needs a directory and 1 to %d bodies", RUN_BODY_MAX);
    if (strlen(def->directory) > RUN_DIRECTORY_MAX || !*def->directory)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "the output directory's path should have 1 to %d bytes, not %zu",
                         RUN_DIRECTORY_MAX, strlen(def->directory));
    if (!(def->time_step > 0.0) || !isfinite(def->time_step) || def->steps_per_frame < 1)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "time_step and steps_per_frame should be above 0");
    for (size_t i = 0; i < def->body_count; i++) {
        const tulle_run_body *const body = &def->bodies[i];
        if (!body->name || body->mesh.vertex_count < 1 || body->mesh.vertex_count > INT32_MAX ||
            body->mesh.triangle_count > INT32_MAX || !body->mesh.positions ||
            (body->mesh.triangle_count > 0 && !body->mesh.triangles))
            return error_set(
                error, TULLE_ERROR_INVALID_ARGUMENT,
                "body %zu needs a name and a mesh of 1 to 2^31 - 1 vertices, with its arrays", i);
    }
    return TULLE_OK;
}

/* ---- a writer in memory ---- */

void run_writer_destroy(tulle_run_writer *writer) {
    if (!writer) return;
    size_t const body_count = writer->record.bodies.count;
    for (size_t i = 0; i < body_count; i++) {
        if (writer->caches) pc2_writer_release(writer->caches[i]);
        if (writer->triangles)
            memory_release(&writer->heap, writer->triangles[i],
                           writer->record.bodies.data[i].triangle_count * 3 * sizeof(uint32_t));
    }
    run_log_close(&writer->report_log);
    run_log_close(&writer->frames_log);
    run_log_close(&writer->bodies_log);
    checksum_log_close(&writer->checksums, &writer->heap);
    ARRAY_FREE(&writer->heap, &writer->notes);
    debug_log_close(&writer->debug);
    run_rounding_release(&writer->rounding);
    if (writer->lock >= 0) close(writer->lock);
    memory_release(&writer->heap, writer->caches, body_count * sizeof(void *));
    memory_release(&writer->heap, writer->triangles, body_count * sizeof(void *));
    memory_release(&writer->heap, writer->line, run_frames_line_size(body_count));
    run_frames_destroy(&writer->frames);
    run_record_destroy(&writer->record);
    memory heap = memory_default();
    memory_release(&heap, writer, sizeof *writer);
}

void run_writer_abandon(tulle_run_writer *writer) {
    if (writer->has_made_directory && !run_directory_check(writer->directory, writer->lock))
        rmdir(writer->directory);
    run_writer_destroy(writer);
}

static bool copy_triangles(tulle_run_writer *writer, const tulle_run_def *def) {
    if (!def->writes_vtp) return true;
    memory *const heap = &writer->heap;
    writer->triangles = memory_allocate_zeroed(heap, def->body_count, sizeof(uint32_t *));
    if (!writer->triangles) return false;
    for (size_t i = 0; i < def->body_count; i++) {
        size_t const size = def->bodies[i].mesh.triangle_count * 3 * sizeof(uint32_t);
        writer->triangles[i] = memory_allocate(heap, size);
        if (!writer->triangles[i]) return false;
        if (size > 0) memcpy(writer->triangles[i], def->bodies[i].mesh.triangles, size);
    }
    return true;
}

tulle_status run_writer_make(const tulle_run_def *def, tulle_run_writer **result,
                             tulle_error *error) {
    memory heap = memory_default();
    tulle_run_writer *const writer = memory_allocate_zeroed(&heap, 1, sizeof *writer);
    if (!writer) return file_fail(error, def->directory, ENOMEM, "cannot be written");
    writer->heap = memory_default();
    writer->lock = writer->report_log.file = writer->frames_log.file = -1;
    writer->bodies_log.file = writer->checksums.log.file = -1;
    writer->debug = debug_log_make(&writer->heap);
    strcpy(writer->directory, def->directory);
    writer->record = run_record_make(&writer->heap);
    writer->frames.heap = &writer->heap;
    tulle_status status = run_record_describe(&writer->record, def, error);
    if (!status) {
        size_t const body_count = def->body_count;
        writer->caches = memory_allocate_zeroed(&writer->heap, body_count, sizeof(void *));
        writer->line = memory_allocate(&writer->heap, run_frames_line_size(body_count));
        if (!writer->caches || !writer->line || !copy_triangles(writer, def) ||
            !run_rounding_make(&writer->rounding, &writer->heap, def))
            status = file_fail(error, def->directory, ENOMEM, "cannot be written");
    }
    if (status)
        run_writer_destroy(writer);
    else
        *result = writer;
    return status;
}

/* ---- files ---- */

bool run_writer_name_file(const tulle_run_writer *writer, scene_file kind, size_t body,
                          char name[RUN_PATH_SIZE]) {
    const run_record *const record = &writer->record;
    const run_body_record *const of = &record->bodies.data[body];
    bool is_there = true;
    name[0] = '\0';
    switch (kind) {
    case SCENE_FILE_TEXT:
        is_there = record->has_scene_text && body == 0;
        strcpy(name, RUN_FILE_SCENE);
        break;
    case SCENE_FILE_MESH: strcpy(name, run_record_text(record, of->mesh_file)); break;
    case SCENE_FILE_VTP:
        is_there = of->is_static && record->writes_vtp;
        run_make_vtp_name(record, body, -1, name);
        break;
    }
    return is_there;
}

tulle_status run_writer_write_file(tulle_run_writer *writer, const tulle_run_def *def,
                                   scene_file kind, size_t body, const file_sum *expected,
                                   tulle_error *error) {
    char name[RUN_PATH_SIZE], path[RUN_PATH_SIZE];
    if (!run_writer_name_file(writer, kind, body, name)) return TULLE_OK;
    run_join(path, writer->directory, name);
    tulle_mesh_view const mesh = def->bodies[body].mesh;
    output_file *output = NULL;
    file_sum sum = expected ? *expected : (file_sum){0};
    sum.is_expected = expected != NULL;
    writer->has_unflushed_files = true;
    tulle_status status = TULLE_OK;
    switch (kind) {
    case SCENE_FILE_TEXT:
        status = output_open_unflushed(path, &output, error);
        if (status) break;
        output_text(output, def->scene_text);
        status = output_commit_summed(output, &sum, error);
        break;
    case SCENE_FILE_MESH: status = mesh_write_unflushed(path, mesh, &sum, error); break;
    case SCENE_FILE_VTP: status = vtp_write_unflushed(path, mesh, NULL, &sum, error); break;
    }
    if (!status && !expected)
        checksum_log_add(&writer->checksums, &writer->heap, name, CHECKSUM_NO_FRAME, &sum);
    return status;
}

static tulle_status write_body(tulle_run_writer *writer, const tulle_run_def *def, size_t body,
                               tulle_error *error) {
    const run_body_record *const record = &writer->record.bodies.data[body];
    char path[RUN_PATH_SIZE];
    tulle_status status = run_writer_write_file(writer, def, SCENE_FILE_MESH, body, NULL, error);
    if (!status) status = run_writer_write_file(writer, def, SCENE_FILE_VTP, body, NULL, error);
    if (status || record->is_static) return status;
    run_join(path, writer->directory, run_record_text(&writer->record, record->cache_file));
    return pc2_writer_open_unflushed(path, record->vertex_count, 0, &writer->caches[body], error);
}

tulle_status run_writer_make_vtp_folder(tulle_run_writer *writer, tulle_error *error) {
    if (!writer->record.writes_vtp) return TULLE_OK;
    char path[RUN_PATH_SIZE];
    run_join(path, writer->directory, RUN_FOLDER_VTP);
    if (mkdir(path, 0777) == 0 || errno == EEXIST) return TULLE_OK;
    return file_fail(error, path, errno, "cannot be made");
}

tulle_status run_writer_write_record(tulle_run_writer *writer, tulle_error *error) {
    char path[RUN_PATH_SIZE];
    run_join(path, writer->directory, RUN_FILE_RECORD);
    return run_record_write(&writer->record, path, error);
}

static tulle_status create_logs(tulle_run_writer *writer, tulle_error *error) {
    char path[RUN_PATH_SIZE], heading[RUN_REPORT_LINE_SIZE];
    run_join(path, writer->directory, RUN_FILE_REPORT);
    tulle_status const status = run_log_create(&writer->report_log, path, heading,
                                               run_report_format_heading(heading), error);
    if (status) return status;
    run_join(path, writer->directory, RUN_FILE_FRAMES);
    return run_log_create(&writer->frames_log, path, RUN_FRAMES_HEADING, strlen(RUN_FRAMES_HEADING),
                          error);
}

/* *body_count: bodies whose files were begun. */
static tulle_status make_files(tulle_run_writer *writer, const tulle_run_def *def,
                               size_t *body_count, tulle_error *error) {
    run_directory_remove_temporaries(writer->directory, &writer->record);
    writer->has_unflushed_files = true;
    tulle_status status = run_writer_write_record(writer, error);
    if (!status) status = checksum_log_create(&writer->checksums, writer->directory, error);
    if (!status) status = run_writer_write_file(writer, def, SCENE_FILE_TEXT, 0, NULL, error);
    if (!status) status = run_writer_make_vtp_folder(writer, error);
    for (*body_count = 0; *body_count < def->body_count && !status; ++*body_count)
        status = write_body(writer, def, *body_count, error);
    if (!status && (def->records_debug || def->records_velocities))
        status = debug_log_create(&writer->debug, writer->directory, error);
    if (!status)
        status = transforms_create(&writer->bodies_log, &writer->record, writer->directory, error);
    if (!status) status = create_logs(writer, error);
    return status ? status : run_writer_sum_logs(writer, error);
}

/* Removes the files of the run that is there, but run.json: the new one takes its place. So whoever
 * is killed on the way leaves a run, and its resume begins anew. */
static tulle_status clear_former(const tulle_run_writer *writer, tulle_error *error) {
    char path[RUN_PATH_SIZE];
    run_join(path, writer->directory, RUN_FILE_RECORD);
    memory heap = memory_default();
    run_record record = run_record_make(&heap);
    bool const is_known = run_record_read(&record, path, NULL) == TULLE_OK;
    tulle_status status = TULLE_OK;
    if (is_known)
        status = run_directory_check_foreign(writer->directory, &record, &writer->record, error);
    if (!status && is_known && record.has_end) { /* it does not hold what its end says any more */
        record.has_end = false;
        record.state = TULLE_RUN_RUNNING;
        status = run_record_write(&record, path, error);
    }
    if (!status)
        status = run_directory_clear(writer->directory, is_known ? &record : NULL,
                                     is_known ? record.bodies.count : 0, error);
    run_record_destroy(&record);
    return status;
}

static tulle_status check_existing(const char *directory, run_directory_kind kind,
                                   tulle_run_existing existing, tulle_error *error) {
    if ((int)existing != TULLE_RUN_REFUSE && (int)existing != TULLE_RUN_REPLACE)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "existing is %d, which is not a value of tulle_run_existing",
                         (int)existing);
    if (kind == RUN_DIRECTORY_OTHER)
        return error_set_at(
            error, TULLE_ERROR_INVALID_ARGUMENT, directory, 0, 0,
            "holds files but no run.json, so it is not a run; choose a new or empty directory");
    if (kind == RUN_DIRECTORY_RUN && existing == TULLE_RUN_REFUSE)
        return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, directory, 0, 0,
                            "holds a run already; resume it (tulle run --resume), replace it "
                            "(--force), or choose another directory");
    return TULLE_OK;
}

tulle_status run_writer_begin(tulle_run_writer *writer, const tulle_run_def *def,
                              run_directory_kind kind, tulle_run_existing existing,
                              tulle_error *error) {
    tulle_status status = check_existing(writer->directory, kind, existing, error);
    if (!status && kind == RUN_DIRECTORY_RUN) status = clear_former(writer, error);
    if (!status) status = run_directory_check_files(writer->directory, &writer->record, error);
    if (status) return status;
    size_t body_count = 0;
    status = make_files(writer, def, &body_count, error);
    if (status && !run_directory_check(writer->directory, writer->lock) &&
        run_directory_clear(writer->directory, &writer->record, body_count, NULL) == TULLE_OK) {
        char path[RUN_PATH_SIZE];
        run_join(path, writer->directory, RUN_FILE_RECORD);
        unlink(path);
    }
    return status;
}

tulle_status tulle_run_create(const tulle_run_def *def, tulle_run_existing existing,
                              tulle_run_writer **result, tulle_error *error) {
    if (!result) return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "writer may not be null");
    *result = NULL;
    tulle_status status = run_writer_check_def(def, error);
    tulle_run_writer *writer = NULL;
    if (!status) status = run_writer_make(def, &writer, error);
    if (status) return status;
    run_directory_kind kind = RUN_DIRECTORY_EMPTY;
    status =
        run_directory_lock(writer->directory, &writer->lock, &writer->has_made_directory, error);
    if (!status) status = run_directory_examine(writer->directory, &kind, error);
    if (!status) status = run_writer_begin(writer, def, kind, existing, error);
    if (status)
        run_writer_abandon(writer);
    else
        *result = writer;
    return status;
}
