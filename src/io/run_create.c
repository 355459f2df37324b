/* io/run_create.c - makes the directory of a run, or opens that of a run which was cut short and
 * cuts its files back to the newest whole checkpoint.
 *
 * run.json is written first, so a directory that a killed process left half made is known as a run;
 * without a checkpoint such a run starts anew. */
#define _POSIX_C_SOURCE 200809L
#include "base/error.h"
#include "io/file_data.h"
#include "io/output_file.h"
#include "io/pc2.h"
#include "io/run_checkpoint.h"
#include "io/run_report.h"
#include "io/run_writer.h"
#include "io/unflushed.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

tulle_run_def tulle_run_def_default(void) {
    return (tulle_run_def){.cookie = RUN_DEF_COOKIE, .steps_per_frame = 1};
}

static tulle_status check_def(const tulle_run_def *def, tulle_error *error) {
    if (!def || def->cookie != RUN_DEF_COOKIE)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "the def should come from tulle_run_def_default");
    if (!def->directory || def->body_count < 1 || def->body_count > RUN_BODY_MAX || !def->bodies)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "a run needs a directory and 1 to %d bodies", RUN_BODY_MAX);
    if (!(def->time_step > 0.0) || !isfinite(def->time_step) || def->steps_per_frame < 1)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "time_step and steps_per_frame should be above 0");
    for (size_t i = 0; i < def->body_count; i++) {
        const tulle_run_body *const body = &def->bodies[i];
        if (!body->name || body->mesh.vertex_count < 1 || body->mesh.vertex_count > INT32_MAX ||
            body->mesh.triangle_count > INT32_MAX)
            return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                             "body %zu needs a name and a mesh of 1 to 2^31 - 1 vertices", i);
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
    debug_log_close(&writer->debug);
    if (writer->lock >= 0) close(writer->lock);
    memory_release(&writer->heap, writer->caches, body_count * sizeof(void *));
    memory_release(&writer->heap, writer->triangles, body_count * sizeof(void *));
    memory_release(&writer->heap, writer->line, run_frames_line_size(body_count));
    run_frames_destroy(&writer->frames);
    run_record_destroy(&writer->record);
    memory heap = memory_default();
    memory_release(&heap, writer, sizeof *writer);
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

static tulle_status make_writer(const tulle_run_def *def, tulle_run_writer **result,
                                tulle_error *error) {
    memory heap = memory_default();
    tulle_run_writer *const writer = memory_allocate_zeroed(&heap, 1, sizeof *writer);
    if (!writer) return file_fail(error, def->directory, ENOMEM, "cannot be written");
    writer->heap = memory_default();
    writer->lock = writer->report_log.file = writer->frames_log.file = -1;
    writer->debug = debug_log_make(&writer->heap);
    strcpy(writer->directory, def->directory);
    writer->record = run_record_make(&writer->heap);
    writer->frames.heap = &writer->heap;
    tulle_status status = run_record_describe(&writer->record, def, error);
    if (!status) {
        size_t const body_count = def->body_count;
        writer->caches = memory_allocate_zeroed(&writer->heap, body_count, sizeof(void *));
        writer->line = memory_allocate(&writer->heap, run_frames_line_size(body_count));
        if (!writer->caches || !writer->line || !copy_triangles(writer, def))
            status = file_fail(error, def->directory, ENOMEM, "cannot be written");
    }
    if (status)
        run_writer_destroy(writer);
    else
        *result = writer;
    return status;
}

/* ---- files ---- */

static tulle_status write_scene(tulle_run_writer *writer, const tulle_run_def *def,
                                tulle_error *error) {
    if (!def->scene_text) return TULLE_OK;
    char path[RUN_PATH_SIZE];
    run_join(path, writer->directory, RUN_FILE_SCENE);
    return tulle_file_write(path, def->scene_text, strlen(def->scene_text), error);
}

static tulle_status write_static_vtp(tulle_run_writer *writer, const tulle_run_def *def,
                                     size_t body, tulle_error *error) {
    char name[RUN_PATH_SIZE], path[RUN_PATH_SIZE];
    run_make_vtp_name(&writer->record, body, -1, name);
    run_join(path, writer->directory, name);
    return vtp_write_unflushed(path, def->bodies[body].mesh, NULL, error);
}

static tulle_status write_body(tulle_run_writer *writer, const tulle_run_def *def, size_t body,
                               tulle_error *error) {
    const run_body_record *const record = &writer->record.bodies.data[body];
    char path[RUN_PATH_SIZE];
    run_join(path, writer->directory, run_record_text(&writer->record, record->mesh_file));
    tulle_status status = mesh_write_unflushed(path, def->bodies[body].mesh, error);
    if (status) return status;
    if (record->is_static)
        return def->writes_vtp ? write_static_vtp(writer, def, body, error) : TULLE_OK;
    run_join(path, writer->directory, run_record_text(&writer->record, record->cache_file));
    return pc2_writer_create_unflushed(path, record->vertex_count, &writer->caches[body], error);
}

static tulle_status make_vtp_folder(tulle_run_writer *writer, tulle_error *error) {
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

static tulle_status make_files(tulle_run_writer *writer, const tulle_run_def *def,
                               tulle_error *error) {
    tulle_status status = run_directory_lock(writer->directory, &writer->lock, error);
    if (status) return status;
    run_directory_remove_temporaries(writer->directory);
    writer->has_unflushed_files = true;
    status = run_writer_write_record(writer, error);
    if (!status) status = write_scene(writer, def, error);
    if (!status) status = make_vtp_folder(writer, error);
    for (size_t i = 0; i < def->body_count && !status; i++)
        status = write_body(writer, def, i, error);
    if (!status && def->records_debug)
        status = debug_log_create(&writer->debug, writer->directory, error);
    return status ? status : create_logs(writer, error);
}

/* Removes the files of the run that is there. */
static tulle_status clear_former(const char *directory, tulle_error *error) {
    char path[RUN_PATH_SIZE];
    run_join(path, directory, RUN_FILE_RECORD);
    int lock = -1;
    tulle_status status = run_directory_lock(directory, &lock, error);
    if (status) return status;
    memory heap = memory_default();
    run_record record = run_record_make(&heap);
    bool const is_known = run_record_read(&record, path, NULL) == TULLE_OK;
    status = run_directory_clear(directory, is_known ? &record : NULL, error);
    run_record_destroy(&record);
    close(lock);
    return status;
}

static tulle_status check_existing(const char *directory, run_directory_kind kind,
                                   tulle_run_existing existing, tulle_error *error) {
    if (kind == RUN_DIRECTORY_OTHER)
        return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, directory, 0, 0,
                            "holds files that are no run; choose a new or empty directory");
    if (kind == RUN_DIRECTORY_RUN && existing == TULLE_RUN_REFUSE)
        return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, directory, 0, 0,
                            "holds a run already; resume it, replace it, or choose another "
                            "directory");
    return TULLE_OK;
}

tulle_status tulle_run_create(const tulle_run_def *def, tulle_run_existing existing,
                              tulle_run_writer **result, tulle_error *error) {
    if (!result) return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "writer may not be null");
    *result = NULL;
    run_directory_kind kind = RUN_DIRECTORY_MISSING;
    tulle_status status = check_def(def, error);
    if (!status) status = run_directory_examine(def->directory, &kind, error);
    if (!status) status = check_existing(def->directory, kind, existing, error);
    tulle_run_writer *writer = NULL;
    if (!status) status = make_writer(def, &writer, error);
    if (status) return status;
    if (kind == RUN_DIRECTORY_RUN) status = clear_former(def->directory, error);
    bool const is_made = !status && kind == RUN_DIRECTORY_MISSING;
    if (is_made && mkdir(def->directory, 0777) != 0) {
        status = file_fail(error, def->directory, errno, "cannot be made");
    } else if (!status) {
        status = make_files(writer, def, error);
        if (status) run_directory_clear(def->directory, &writer->record, NULL);
        if (status && is_made) rmdir(def->directory);
    }
    if (status)
        run_writer_destroy(writer);
    else
        *result = writer;
    return status;
}

/* ---- resuming ---- */

/* Frames in the shortest cache. */
static tulle_status count_cached_frames(const tulle_run_writer *writer, uint32_t *count,
                                        tulle_error *error) {
    *count = UINT32_MAX;
    for (size_t i = 0; i < writer->record.bodies.count; i++) {
        const run_body_record *const body = &writer->record.bodies.data[i];
        if (body->is_static) continue;
        char path[RUN_PATH_SIZE];
        run_join(path, writer->directory, run_record_text(&writer->record, body->cache_file));
        tulle_pc2 *cache = NULL;
        tulle_pc2_info info;
        tulle_status const status = tulle_pc2_open(path, &cache, &info, error);
        if (status) return status;
        tulle_pc2_close(cache);
        if (info.frame_count < *count) *count = info.frame_count;
    }
    return TULLE_OK;
}

/* [bytes] of a file; 0 when it is not there. */
static uint64_t measure_file(const char *directory, const char *name) {
    char path[RUN_PATH_SIZE];
    run_join(path, directory, name);
    struct stat facts;
    return stat(path, &facts) == 0 ? (uint64_t)facts.st_size : 0;
}

/* Reads one generation and checks that the other files reach as far. */
static tulle_status try_checkpoint(tulle_run_writer *writer, const char *name,
                                   checkpoint_record *record, tulle_error *error) {
    char path[RUN_PATH_SIZE];
    run_join(path, writer->directory, name);
    tulle_status status = checkpoint_read(&writer->heap, path, record, error);
    uint32_t cached = 0;
    if (status) return status;
    status = count_cached_frames(writer, &cached, error);
    if (status) {
        checkpoint_release(&writer->heap, record);
        return status;
    }
    const char *lacking = NULL;
    if (record->scene_hash != writer->record.scene_hash) lacking = "is of another scene";
    if (record->state.frame_count > cached) lacking = "knows of more frames than the caches hold";
    if (record->report_size > measure_file(writer->directory, RUN_FILE_REPORT) ||
        record->frames_size > measure_file(writer->directory, RUN_FILE_FRAMES))
        lacking = "knows of more lines than report.csv or frames.csv hold";
    if (!lacking && writer->record.records_debug &&
        !debug_has_frames(&writer->heap, writer->directory, record->state.frame_count))
        lacking = "knows of more frames than debug.bin holds whole";
    if (!lacking) return TULLE_OK;
    checkpoint_release(&writer->heap, record);
    return error_set_at(error, TULLE_ERROR_PARSE, path, 0, 0, "the checkpoint %s", lacking);
}

/* The generation before takes the place of a newest one that cannot be used, so that the next
 * checkpoint does not replace the only sound one. */
static tulle_status drop_newest(const tulle_run_writer *writer, tulle_error *error) {
    char newest[RUN_PATH_SIZE], before[RUN_PATH_SIZE];
    run_join(newest, writer->directory, RUN_FILE_CHECKPOINT);
    run_join(before, writer->directory, RUN_FILE_CHECKPOINT_BEFORE);
    return rename(before, newest) == 0 ? TULLE_OK
                                       : file_fail(error, before, errno, "cannot be renamed");
}

/* The newest usable checkpoint; *is_found false when the run never made one. */
static tulle_status find_checkpoint(tulle_run_writer *writer, checkpoint_record *record,
                                    bool *is_found, tulle_error *error) {
    *is_found = true;
    tulle_error newest = {0};
    if (!try_checkpoint(writer, RUN_FILE_CHECKPOINT, record, &newest)) return TULLE_OK;
    if (newest.status == TULLE_ERROR_OUT_OF_MEMORY) {
        if (error) *error = newest;
        return newest.status;
    }
    if (!try_checkpoint(writer, RUN_FILE_CHECKPOINT_BEFORE, record, NULL))
        return drop_newest(writer, error);
    *is_found = measure_file(writer->directory, RUN_FILE_CHECKPOINT) > 0 ||
                measure_file(writer->directory, RUN_FILE_CHECKPOINT_BEFORE) > 0;
    if (!*is_found) return TULLE_OK;
    return error_set_at(error, TULLE_ERROR_PARSE, newest.file, 0, 0,
                        "neither checkpoint of the run can be used (%s); replace the run",
                        newest.message);
}

static tulle_status cut_files_back(tulle_run_writer *writer, const checkpoint_record *checkpoint,
                                   tulle_error *error) {
    char path[RUN_PATH_SIZE];
    uint32_t const frame_count = checkpoint->state.frame_count;
    tulle_status status = TULLE_OK;
    for (size_t i = 0; i < writer->record.bodies.count && !status; i++) {
        const run_body_record *const body = &writer->record.bodies.data[i];
        if (body->is_static) continue;
        run_join(path, writer->directory, run_record_text(&writer->record, body->cache_file));
        status =
            tulle_pc2_writer_open(path, body->vertex_count, frame_count, &writer->caches[i], error);
    }
    if (status) return status;
    run_join(path, writer->directory, RUN_FILE_REPORT);
    status = run_log_resume(&writer->report_log, path, checkpoint->report_size, error);
    if (status) return status;
    run_join(path, writer->directory, RUN_FILE_FRAMES);
    status = run_log_resume(&writer->frames_log, path, checkpoint->frames_size, error);
    if (!status && writer->record.records_debug)
        status = debug_log_resume(&writer->debug, writer->directory, frame_count, error);
    if (!status)
        status = run_frames_read(&writer->frames, &writer->heap, path, writer->record.bodies.count,
                                 error);
    if (!status && writer->frames.lines.count != frame_count)
        status = error_set_at(error, TULLE_ERROR_PARSE, path, 0, 0,
                              "holds %zu frames, but the checkpoint knows of %u; replace the run",
                              writer->frames.lines.count, frame_count);
    return status;
}

/* The run in writer->directory becomes the writer's, cut back to its checkpoint. */
static tulle_status take_over(tulle_run_writer *writer, const tulle_run_def *def,
                              checkpoint_record *checkpoint, bool *is_found, tulle_error *error) {
    char path[RUN_PATH_SIZE];
    run_join(path, writer->directory, RUN_FILE_RECORD);
    tulle_status status = run_directory_lock(writer->directory, &writer->lock, error);
    if (status) return status;
    run_record old = run_record_make(&writer->heap);
    status = run_record_read(&old, path, error);
    if (!status) status = run_record_compare(&old, &writer->record, writer->directory, error);
    run_record_destroy(&old);
    if (!status) status = find_checkpoint(writer, checkpoint, is_found, error);
    if (status || !*is_found) return status; /* the caller releases the checkpoint */
    run_directory_remove_temporaries(writer->directory);
    status = cut_files_back(writer, checkpoint, error);
    if (!status) status = write_scene(writer, def, error);
    if (!status) status = make_vtp_folder(writer, error);
    return status ? status : run_writer_write_record(writer, error);
}

tulle_status tulle_run_resume(const tulle_run_def *def, tulle_run_writer **result,
                              tulle_run_checkpoint *checkpoint, tulle_error *error) {
    if (!result || !checkpoint)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "writer and checkpoint may not be null");
    *result = NULL;
    *checkpoint = (tulle_run_checkpoint){0};
    run_directory_kind kind = RUN_DIRECTORY_MISSING;
    tulle_status status = check_def(def, error);
    if (!status) status = run_directory_examine(def->directory, &kind, error);
    if (status) return status;
    if (kind != RUN_DIRECTORY_RUN) return tulle_run_create(def, TULLE_RUN_REFUSE, result, error);
    tulle_run_writer *writer = NULL;
    status = make_writer(def, &writer, error);
    if (status) return status;
    checkpoint_record record = {0};
    bool is_found = false;
    status = take_over(writer, def, &record, &is_found, error);
    if (!status && is_found) {
        *checkpoint = record.state;
        *result = writer;
        return TULLE_OK;
    }
    checkpoint_release(&writer->heap, &record);
    run_writer_destroy(writer);
    return status ? status : tulle_run_create(def, TULLE_RUN_REPLACE, result, error);
}

void tulle_run_free_checkpoint(tulle_run_checkpoint *checkpoint) {
    if (!checkpoint) return;
    memory heap = memory_default();
    memory_release(&heap, checkpoint->bytes, checkpoint->byte_count);
    *checkpoint = (tulle_run_checkpoint){0};
}
