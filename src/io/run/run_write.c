/* io/run/run_write.c - frames, reports and checkpoints of a run.
 *
 * A frame goes into all caches, debug.bin and bodies.csv first, then its checksums into
 * checksums.csv, then its line into frames.csv: the whole lines count the whole frames. A
 * checkpoint is written after everything it counts is on the disk. */
#define _GNU_SOURCE /* syncfs */
#include "base/error.h"
#include "io/cache/pc2.h"
#include "io/file_data.h"
#include "io/run/run_checkpoint.h"
#include "io/run/run_report.h"
#include "io/run/run_writer.h"
#include "io/unflushed.h"

#include <errno.h>
#include <float.h>
#include <string.h>
#include <unistd.h>

enum { SINGLE_FLUSH_MAX = 16 /* bodies whose caches are flushed one by one */ };

/* Files are opened by their paths. They would be another run's, where the directory was removed and
 * made again. */
static tulle_status check_directory(const tulle_run_writer *writer, tulle_error *error) {
    int const code = run_directory_check(writer->directory, writer->lock);
    if (!code) return TULLE_OK;
    if (code != ENOENT) return file_fail(error, writer->directory, code, "cannot be examined");
    return error_set_at(error, TULLE_ERROR_IO, writer->directory, 0, 0,
                        "was moved, removed or replaced while the run wrote to it");
}

/* ---- frames ---- */

static tulle_status check_frame(const tulle_run_writer *writer, const tulle_run_frame *frame,
                                tulle_error *error) {
    if (!frame || !frame->positions)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "the frame needs positions");
    for (size_t i = 0; i < writer->record.bodies.count; i++)
        if (!writer->record.bodies.data[i].is_static && !frame->positions[i])
            return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                             "the frame needs positions of body %zu, which moves", i);
    if (transforms_count_bodies(&writer->record) > 0 && !frame->transforms)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "the frame needs transforms of the rigid bodies");
    if (frame->lag_count > 0 && !frame->lags)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "the lags of the frame are null");
    for (size_t i = 0; i < frame->lag_count; i++) {
        const tulle_run_lag *const lag = &frame->lags[i];
        if (lag->body >= writer->record.bodies.count || (i > 0 && lag->body <= lag[-1].body) ||
            !(lag->lag > 0.0 && lag->lag <= DBL_MAX))
            return error_set(
                error, TULLE_ERROR_INVALID_ARGUMENT,
                "lag %zu of the frame names no body, is out of order, or has no length", i);
    }
    return TULLE_OK;
}

static tulle_status append_to_cache(tulle_run_writer *writer, const tulle_run_frame *frame,
                                    size_t body, tulle_error *error) {
    const run_record *const record = &writer->record;
    file_sum sum = {0};
    tulle_status const status =
        pc2_writer_append_unflushed(writer->caches[body], frame->positions[body], &sum, error);
    if (!status)
        checksum_log_add(&writer->checksums, &writer->heap,
                         run_record_text(record, record->bodies.data[body].cache_file),
                         (int64_t)writer->frames.lines.count - 1, &sum);
    return status;
}

static tulle_status append_to_caches(tulle_run_writer *writer, const tulle_run_frame *frame,
                                     size_t *done, tulle_error *error) {
    tulle_status status = TULLE_OK;
    for (*done = 0; *done < writer->record.bodies.count && !status; ++*done)
        if (writer->caches[*done]) status = append_to_cache(writer, frame, *done, error);
    return status;
}

static tulle_status write_vtps(tulle_run_writer *writer, const tulle_run_frame *frame, long index,
                               tulle_error *error) {
    if (!writer->triangles) return TULLE_OK;
    writer->has_unflushed_files = true;
    tulle_status status = TULLE_OK;
    for (size_t i = 0; i < writer->record.bodies.count && !status; i++) {
        const run_body_record *const body = &writer->record.bodies.data[i];
        if (body->is_static) continue;
        char name[RUN_PATH_SIZE], path[RUN_PATH_SIZE];
        run_make_vtp_name(&writer->record, i, index, name);
        run_join(path, writer->directory, name);
        tulle_mesh_view const mesh = {frame->positions[i], body->vertex_count, writer->triangles[i],
                                      body->triangle_count};
        file_sum sum = {0};
        status = vtp_write_unflushed(path, mesh, frame->velocities ? frame->velocities[i] : NULL,
                                     &sum, error);
        if (!status) checksum_log_add(&writer->checksums, &writer->heap, name, index, &sum);
    }
    return status;
}

static const char *get_body_name(const void *context, size_t body) {
    const run_record *const record = context;
    return run_record_text(record, record->bodies.data[body].name);
}

/* ---- checksums ---- */

/* The logs with their names. */
typedef struct named_log {
    run_log *log;
    const char *name;
} named_log;
enum { LOG_COUNT = 4 };

static void list_logs(tulle_run_writer *writer, named_log logs[LOG_COUNT]) {
    logs[0] = (named_log){&writer->debug.log, RUN_FILE_DEBUG};
    logs[1] = (named_log){&writer->bodies_log, RUN_FILE_BODIES};
    logs[2] = (named_log){&writer->report_log, RUN_FILE_REPORT};
    logs[3] = (named_log){&writer->frames_log, RUN_FILE_FRAMES};
}

/* Prepares a line for what each log holds and checksums.csv does not cover, and for the text that
 * is about to be appended to frames.csv. Steps belong to the frame that they lead to. */
static void add_logs(tulle_run_writer *writer, int64_t frame, const char *text, size_t length) {
    named_log logs[LOG_COUNT];
    list_logs(writer, logs);
    for (int i = 0; i < LOG_COUNT; i++) {
        if (logs[i].log->file < 0) continue;
        bool const is_last = i == LOG_COUNT - 1;
        file_sum const sum = run_log_get_sum(logs[i].log, text, is_last ? length : 0);
        if (sum.end > sum.begin)
            checksum_log_add(&writer->checksums, &writer->heap, logs[i].name, frame, &sum);
    }
}

static void mark_logs(tulle_run_writer *writer) {
    named_log logs[LOG_COUNT];
    list_logs(writer, logs);
    for (int i = 0; i < LOG_COUNT; i++) run_log_mark_summed(logs[i].log);
}

tulle_status run_writer_sum_logs(tulle_run_writer *writer, tulle_error *error) {
    add_logs(writer, CHECKSUM_NO_FRAME, "", 0);
    tulle_status const status = checksum_log_append(&writer->checksums, error);
    if (!status) mark_logs(writer);
    return status;
}

/* Takes the last frame back out of the first `done` caches, and of debug.bin, bodies.csv and
 * checksums.csv; best effort on a disk that fails. */
static void roll_back(tulle_run_writer *writer, size_t done, checksum_mark mark) {
    checksum_log_cut(&writer->checksums, mark);
    run_log_cut(&writer->debug.log);
    run_log_cut(&writer->bodies_log);
    run_frames_truncate(&writer->frames, writer->frames.lines.count - 1);
    uint32_t const frame_count = (uint32_t)writer->frames.lines.count;
    for (size_t i = 0; i < done; i++)
        if (writer->caches[i]) pc2_writer_truncate(writer->caches[i], frame_count, NULL);
}

tulle_status tulle_run_write_frame(tulle_run_writer *writer, const tulle_run_frame *frame,
                                   tulle_error *error) {
    if (!writer) return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "writer may not be null");
    tulle_status status = check_frame(writer, frame, error);
    if (!status) status = check_directory(writer, error);
    size_t const body_count = writer->record.bodies.count;
    size_t const index = writer->frames.lines.count;
    tulle_error found = {0};
    if (!status)
        status = run_rounding_judge(&writer->rounding, frame, NULL, get_body_name, &writer->record,
                                    &found);
    if (status == TULLE_ERROR_LIMIT)
        return error_set(error, status,
                         "frame %zu cannot be kept: the files hold floats, which %.900s. Keep it "
                         "nearer to the origin, or use thicker cloth or a larger minimum gap (xi)",
                         index, found.message);
    if (status && found.message[0] && error) *error = found;
    if (status) return status;
    if (!run_frames_add(&writer->frames, frame, body_count))
        return error_set_at(error, TULLE_ERROR_OUT_OF_MEMORY, writer->directory, 0, 0,
                            "out of memory for frame %zu", index);
    size_t done = 0;
    checksum_mark const mark = writer->checksums.mark;
    status = append_to_caches(writer, frame, &done, error);
    if (!status && writer->record.kept)
        status =
            debug_log_append(&writer->debug, &writer->record, (uint32_t)index, frame->debug, error);
    if (!status)
        status = transforms_append(&writer->bodies_log, &writer->record, (uint32_t)index,
                                   frame->transforms, error);
    if (!status) status = write_vtps(writer, frame, (long)index, error);
    if (!status) {
        size_t const length =
            run_frames_format_last(&writer->frames, writer->line, run_frames_line_size(body_count));
        add_logs(writer, (int64_t)index, writer->line, length);
        status = checksum_log_append(&writer->checksums, error);
        if (!status) status = run_log_append(&writer->frames_log, writer->line, length, error);
    }
    if (status)
        roll_back(writer, done, mark);
    else
        mark_logs(writer);
    return status;
}

tulle_status tulle_run_write_report(tulle_run_writer *writer, const tulle_step_report *report,
                                    tulle_error *error) {
    if (!writer || !report)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "writer and report may not be null");
    char line[RUN_REPORT_LINE_SIZE];
    return run_log_append(&writer->report_log, line, run_report_format(report, line), error);
}

uint32_t tulle_run_get_frame_count(const tulle_run_writer *writer) {
    return writer ? (uint32_t)writer->frames.lines.count : 0;
}

/* ---- checkpoints ---- */

/* Many files are flushed faster together, with all else on their file system. */
static tulle_status sync_file_system(tulle_run_writer *writer, tulle_error *error) {
#ifdef __linux__
    if (syncfs(writer->lock) != 0)
        return file_fail(error, writer->directory, errno, "cannot be flushed to disk");
#else
    sync();
#endif
    writer->has_unflushed_files = false;
    return TULLE_OK;
}

static tulle_status sync_all(tulle_run_writer *writer, tulle_error *error) {
    if (writer->has_unflushed_files || writer->record.bodies.count > SINGLE_FLUSH_MAX)
        return sync_file_system(writer, error);
    tulle_status status = TULLE_OK;
    for (size_t i = 0; i < writer->record.bodies.count && !status; i++)
        if (writer->caches[i]) status = pc2_writer_sync(writer->caches[i], error);
    if (!status) status = run_log_sync(&writer->debug.log, error);
    if (!status) status = run_log_sync(&writer->bodies_log, error);
    if (!status) status = run_log_sync(&writer->report_log, error);
    if (!status) status = run_log_sync(&writer->checksums.log, error);
    return status ? status : run_log_sync(&writer->frames_log, error);
}

tulle_status tulle_run_write_checkpoint(tulle_run_writer *writer,
                                        const tulle_run_checkpoint *checkpoint,
                                        tulle_error *error) {
    if (!writer || !checkpoint || !checkpoint->bytes)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "writer and checkpoint may not be null or empty");
    tulle_status status = check_directory(writer, error);
    if (!status) status = run_writer_write_collections(writer, error);
    checksum_log_forget(&writer->checksums); /* of collections, which grow */
    if (!status) status = run_writer_sum_logs(writer, error);
    if (!status) status = sync_all(writer, error);
    if (status) return status;
    checkpoint_record record = {.state = *checkpoint,
                                .scene_hash = writer->record.scene_hash,
                                .report_size = writer->report_log.size,
                                .frames_size = writer->frames_log.size,
                                .checksums = writer->checksums.mark};
    record.state.frame_count = tulle_run_get_frame_count(writer);
    status = checkpoint_write(writer->directory, &record, error);
    /* After a failure the newest may be under the name of the one before. */
    writer->record.has_checkpoint = status == TULLE_OK;
    writer->record.checkpoint_step = checkpoint->step;
    return status;
}

/* ---- ParaView collections ---- */

/* One body's collection: the frames in which it is there. */
typedef struct collection {
    const char **files;
    char *names; /* frame_count names of name_size bytes */
    double *times;
    size_t frame_count;
} collection;
enum { NAME_SIZE = RUN_STEM_SIZE + 32 }; /* [bytes] "vtp/STEM.NUMBER.vtp" */

static size_t fill_collection(const tulle_run_writer *writer, size_t body, collection *list) {
    bool const is_static = writer->record.bodies.data[body].is_static;
    size_t count = 0;
    for (size_t frame = 0; frame < list->frame_count; frame++) {
        if (!run_frames_is_present(&writer->frames, frame, body)) continue;
        char name[RUN_PATH_SIZE];
        run_make_vtp_name(&writer->record, body, is_static ? -1 : (long)frame, name);
        char *const kept = list->names + count * NAME_SIZE;
        memcpy(kept, name, strlen(name) + 1);
        list->files[count] = kept;
        list->times[count++] = writer->frames.lines.data[frame].time;
    }
    return count;
}

static tulle_status write_collections(tulle_run_writer *writer, collection *list,
                                      tulle_error *error) {
    tulle_status status = TULLE_OK;
    for (size_t i = 0; i < writer->record.bodies.count && !status; i++) {
        size_t const count = fill_collection(writer, i, list);
        char name[RUN_PATH_SIZE], path[RUN_PATH_SIZE];
        run_make_pvd_name(&writer->record, i, name);
        run_join(path, writer->directory, name);
        file_sum sum = {0};
        status = pvd_write_unflushed(path, list->files, list->times, count, &sum, error);
        if (!status)
            checksum_log_add(&writer->checksums, &writer->heap, name, CHECKSUM_NO_FRAME, &sum);
    }
    return status;
}

tulle_status run_writer_write_collections(tulle_run_writer *writer, tulle_error *error) {
    if (!writer->record.writes_vtp) return TULLE_OK;
    writer->has_unflushed_files = true;
    memory *const heap = &writer->heap;
    size_t const count = writer->frames.lines.count;
    collection list = {.frame_count = count,
                       .files = memory_allocate(heap, count * sizeof(char *)),
                       .names = memory_allocate(heap, count * NAME_SIZE),
                       .times = memory_allocate(heap, count * sizeof(double))};
    tulle_status const status =
        list.files && list.names && list.times
            ? write_collections(writer, &list, error)
            : error_set_at(error, TULLE_ERROR_OUT_OF_MEMORY, writer->directory, 0, 0,
                           "out of memory for the ParaView collections");
    memory_release(heap, list.files, count * sizeof(char *));
    memory_release(heap, list.names, count * NAME_SIZE);
    memory_release(heap, list.times, count * sizeof(double));
    return status;
}

tulle_status tulle_run_close(tulle_run_writer *writer, tulle_run_state state, const char *message,
                             tulle_error *error) {
    if (!writer) return TULLE_OK;
    tulle_status status = check_directory(writer, error);
    if (!status && !tulle_run_state_name(state))
        status = error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                           "state %d is not a value of tulle_run_state", (int)state);
    if (status) {
        run_writer_destroy(writer);
        return status;
    }
    writer->record.state = state;
    if (!run_record_keep(&writer->record, message ? message : "", &writer->record.message)) {
        writer->record.message = 0;
        status = file_fail_memory(error, writer->directory);
    }
    if (!status) status = run_writer_write_collections(writer, error);
    if (!status) status = run_writer_sum_logs(writer, error);
    if (!status) status = sync_all(writer, error);
    writer->record.has_end = status == TULLE_OK;
    writer->record.end = writer->checksums.mark;
    /* How it ended is worth recording even where the rest failed. */
    tulle_status const recorded = run_writer_write_record(writer, status ? NULL : error);
    run_writer_destroy(writer);
    return status ? status : recorded;
}
