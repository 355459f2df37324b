/* io/run/run_resume.c - opens the directory of a run that was cut short and cuts its files back to
 * the newest whole checkpoint. */
#define _POSIX_C_SOURCE 200809L
#include "base/error.h"
#include "io/file_data.h"
#include "io/run/run_checkpoint.h"
#include "io/run/run_writer.h"

#include "io/cache/pc2.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

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
        status = pc2_writer_open_unflushed(path, body->vertex_count, frame_count,
                                           &writer->caches[i], error);
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
        status = transforms_resume(&writer->bodies_log, &writer->record, writer->directory,
                                   frame_count, error);
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
    run_record old = run_record_make(&writer->heap);
    tulle_status status = run_record_read(&old, path, error);
    if (!status) status = run_record_compare(&old, &writer->record, writer->directory, error);
    if (!status) status = run_directory_check_files(writer->directory, &writer->record, error);
    if (!status) status = find_checkpoint(writer, checkpoint, is_found, error);
    if (*is_found) { /* what the start came to stays on record */
        writer->record.has_untangle = old.has_untangle;
        writer->record.untangle = old.untangle;
    }
    run_record_destroy(&old);
    if (status || !*is_found) return status; /* the caller releases the checkpoint */
    run_directory_remove_temporaries(writer->directory, &writer->record);
    writer->has_unflushed_files = true;
    status = cut_files_back(writer, checkpoint, error);
    if (!status) status = run_writer_write_scene(writer, def, error);
    if (!status) status = run_writer_make_vtp_folder(writer, error);
    return status ? status : run_writer_write_record(writer, error);
}

tulle_status tulle_run_resume(const tulle_run_def *def, tulle_run_writer **result,
                              tulle_run_checkpoint *checkpoint, tulle_error *error) {
    if (!result || !checkpoint)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "writer and checkpoint may not be null");
    *result = NULL;
    *checkpoint = (tulle_run_checkpoint){0};
    tulle_status status = run_writer_check_def(def, error);
    tulle_run_writer *writer = NULL;
    if (!status) status = run_writer_make(def, &writer, error);
    if (status) return status;
    run_directory_kind kind = RUN_DIRECTORY_EMPTY;
    checkpoint_record record = {0};
    bool is_found = false;
    status =
        run_directory_lock(writer->directory, &writer->lock, &writer->has_made_directory, error);
    if (!status) status = run_directory_examine(writer->directory, &kind, error);
    if (!status && kind == RUN_DIRECTORY_RUN)
        status = take_over(writer, def, &record, &is_found, error);
    if (!status && !is_found)
        status = run_writer_begin(writer, def, kind, TULLE_RUN_REPLACE, error);
    if (status) {
        checkpoint_release(&writer->heap, &record);
        run_writer_abandon(writer);
        return status;
    }
    *checkpoint = record.state;
    *result = writer;
    return TULLE_OK;
}

int tulle_run_has_checkpoint(const char *directory) {
    if (!directory || strlen(directory) >= RUN_PATH_SIZE) return 0;
    return measure_file(directory, RUN_FILE_RECORD) > 0 &&
           (measure_file(directory, RUN_FILE_CHECKPOINT) > 0 ||
            measure_file(directory, RUN_FILE_CHECKPOINT_BEFORE) > 0);
}

void tulle_run_free_checkpoint(tulle_run_checkpoint *checkpoint) {
    if (!checkpoint) return;
    memory heap = memory_default();
    memory_release(&heap, checkpoint->bytes, checkpoint->byte_count);
    *checkpoint = (tulle_run_checkpoint){0};
}
