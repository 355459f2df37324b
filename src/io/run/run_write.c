/* io/run/run_write.c - frames, reports and checkpoints of a run.
 *
 * A frame goes into all caches, debug.bin and bodies.csv first, then its line into frames.csv: the
 * whole lines count the whole frames. A checkpoint is written after everything it counts is on the
 * disk. */
#define _GNU_SOURCE /* syncfs */
#include "base/error.h"
#include "io/cache/pc2.h"
#include "io/file_data.h"
#include "io/run/run_checkpoint.h"
#include "io/run/run_report.h"
#include "io/run/run_writer.h"
#include "io/unflushed.h"

#include <errno.h>
#include <string.h>
#include <unistd.h>

enum { SINGLE_FLUSH_MAX = 16 /* bodies whose caches are flushed one by one */ };

/* Files are opened by their paths. They would be another run's, where the directory was removed and
 * made again. */
static tulle_status check_directory(const tulle_run_writer *writer, tulle_error *error) {
    if (run_directory_is_held(writer->directory, writer->lock)) return TULLE_OK;
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
    return TULLE_OK;
}

static tulle_status append_to_caches(tulle_run_writer *writer, const tulle_run_frame *frame,
                                     size_t *done, tulle_error *error) {
    tulle_status status = TULLE_OK;
    for (*done = 0; *done < writer->record.bodies.count && !status; ++*done)
        if (writer->caches[*done])
            status =
                pc2_writer_append_unflushed(writer->caches[*done], frame->positions[*done], error);
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
        status =
            vtp_write_unflushed(path, mesh, frame->velocities ? frame->velocities[i] : NULL, error);
    }
    return status;
}

/* Takes the last frame back out of the first `done` caches, and of debug.bin and bodies.csv, which
 * had so many bytes before; best effort on a disk that fails. */
static void roll_back(tulle_run_writer *writer, size_t done, uint64_t debug_size,
                      uint64_t bodies_size) {
    run_log_cut(&writer->debug.log, debug_size);
    run_log_cut(&writer->bodies_log, bodies_size);
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
    if (status) return status;
    size_t const body_count = writer->record.bodies.count;
    size_t const index = writer->frames.lines.count;
    if (!run_frames_add(&writer->frames, frame, body_count))
        return error_set_at(error, TULLE_ERROR_OUT_OF_MEMORY, writer->directory, 0, 0,
                            "out of memory for frame %zu", index);
    size_t done = 0;
    uint64_t const debug_size = writer->debug.log.size, bodies_size = writer->bodies_log.size;
    status = append_to_caches(writer, frame, &done, error);
    if (!status && writer->record.records_debug)
        status =
            debug_log_append(&writer->debug, &writer->record, (uint32_t)index, frame->debug, error);
    if (!status)
        status = transforms_append(&writer->bodies_log, &writer->record, (uint32_t)index,
                                   frame->transforms, error);
    if (!status) status = write_vtps(writer, frame, (long)index, error);
    if (!status) {
        size_t const length =
            run_frames_format_last(&writer->frames, writer->line, run_frames_line_size(body_count));
        status = run_log_append(&writer->frames_log, writer->line, length, error);
    }
    if (status) roll_back(writer, done, debug_size, bodies_size);
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
    if (!status) status = sync_all(writer, error);
    if (status) return status;
    checkpoint_record record = {.state = *checkpoint,
                                .scene_hash = writer->record.scene_hash,
                                .report_size = writer->report_log.size,
                                .frames_size = writer->frames_log.size};
    record.state.frame_count = tulle_run_get_frame_count(writer);
    return checkpoint_write(writer->directory, &record, error);
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
        status = pvd_write_unflushed(path, list->files, list->times, count, error);
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
                           "state %d is none of tulle_run_state", (int)state);
    if (status) {
        run_writer_destroy(writer);
        return status;
    }
    writer->record.state = state;
    if (!run_record_keep(&writer->record, message ? message : "", &writer->record.message))
        writer->record.message = 0;
    status = run_writer_write_collections(writer, error);
    if (!status) status = sync_all(writer, error);
    /* How it ended is worth recording even where the rest failed. */
    tulle_status const recorded = run_writer_write_record(writer, status ? NULL : error);
    run_writer_destroy(writer);
    return status ? status : recorded;
}
