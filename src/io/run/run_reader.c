/* io/run/run_reader.c - reads a run directory. Whole frames are those that have a line in
 * frames.csv and are in every cache. */
#define _POSIX_C_SOURCE 200809L
#include "io/run/run_reader.h"
#include "base/error.h"
#include "io/cache/pc2.h"
#include "io/file_data.h"

#include "tulle_io/mesh_files.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

/* [bytes] A scene text is written by people. */
static const size_t scene_size_limit = (size_t)1 << 26;
enum { OPEN_TRIES = 20 /* at a run that writers begin to change again and again */ };

void tulle_run_reader_close(tulle_run_reader *reader) {
    if (!reader) return;
    size_t const body_count = reader->record.bodies.count;
    if (reader->meshes)
        for (size_t i = 0; i < body_count; i++) tulle_mesh_destroy(&reader->meshes[i]);
    memory_release(&reader->heap, reader->bodies, body_count * sizeof *reader->bodies);
    memory_release(&reader->heap, reader->meshes, body_count * sizeof *reader->meshes);
    file_release(&reader->heap, &reader->scene);
    debug_file_close(&reader->debug);
    arena_destroy(&reader->debug_arrays);
    arena_destroy(&reader->damage_texts);
    ARRAY_FREE(&reader->heap, &reader->damages);
    checksums_release(&reader->sums);
    ARRAY_FREE(&reader->heap, &reader->reports);
    run_frames_destroy(&reader->frames);
    run_record_destroy(&reader->record);
    memory heap = memory_default();
    memory_release(&heap, reader, sizeof *reader);
}

static void describe_bodies(tulle_run_reader *reader) {
    const run_record *const record = &reader->record;
    for (size_t i = 0; i < record->bodies.count; i++) {
        const run_body_record *const body = &record->bodies.data[i];
        reader->bodies[i] = (tulle_run_body_info){
            .name = run_record_text(record, body->name),
            .mesh_file = run_record_text(record, body->mesh_file),
            .cache_file = body->is_static ? NULL : run_record_text(record, body->cache_file),
            .is_obstacle = body->is_obstacle,
            .is_static = body->is_static,
            .is_dynamic = body->is_dynamic,
            .vertex_count = body->vertex_count,
            .triangle_count = body->triangle_count};
    }
}

/* [bytes] of debug.bin; 0 without. */
static uint64_t measure_debug(const tulle_run_reader *reader) {
    char path[RUN_PATH_SIZE];
    run_join(path, reader->directory, RUN_FILE_DEBUG);
    struct stat facts;
    bool const is_there = reader->record.kept && stat(path, &facts) == 0;
    return is_there ? (uint64_t)facts.st_size : 0;
}

static void describe_run(tulle_run_reader *reader) {
    const run_record *const record = &reader->record;
    reader->info = (tulle_run_info){.version = run_record_text(record, record->version),
                                    .scene_path = run_record_text(record, record->scene_path),
                                    .scene_text = reader->scene.bytes,
                                    .scene_hash = record->scene_hash,
                                    .seed = record->seed,
                                    .time_step = record->time_step,
                                    .steps_per_frame = record->steps_per_frame,
                                    .wanted_frame_count = record->wanted_frame_count,
                                    .frame_count = (uint32_t)reader->frames.lines.count,
                                    .state = record->state,
                                    .message = run_record_text(record, record->message),
                                    .bodies = reader->bodies,
                                    .body_count = record->bodies.count,
                                    .checkpoint_step = reader->checkpoint.state.step,
                                    .has_checkpoint = reader->has_checkpoint,
                                    .detection = record->has_detection ? &record->detection : NULL,
                                    .has_response = record->has_response,
                                    .response = record->response,
                                    .motion_space = record->motion_space,
                                    .outcome = record->has_outcome ? &record->outcome : NULL,
                                    .has_debug = record->kept == RUN_KEEPS_DEBUG,
                                    .has_velocities = record->kept != RUN_KEEPS_NOTHING,
                                    .debug_byte_count = measure_debug(reader)};
}

/* Opens the cache of a moving body and checks that it is of this body. */
static tulle_status open_cache(const tulle_run_reader *reader, size_t body, tulle_pc2 **cache,
                               tulle_pc2_info *info, tulle_error *error) {
    const run_body_record *const record = &reader->record.bodies.data[body];
    char path[RUN_PATH_SIZE];
    run_join(path, reader->directory, run_record_text(&reader->record, record->cache_file));
    tulle_status const status = pc2_open(path, cache, info, error);
    if (status || info->vertex_count == record->vertex_count) return status;
    tulle_pc2_close(*cache);
    return error_set_at(error, TULLE_ERROR_PARSE, path, 0, 0,
                        "holds %u vertices, but run.json says %u", info->vertex_count,
                        record->vertex_count);
}

/* Leaves out frames that a cache lacks and nobody has promised. A run killed while its files were
 * made has none. */
static tulle_status drop_partial_frames(tulle_run_reader *reader, tulle_error *error) {
    for (size_t i = 0; i < reader->record.bodies.count && reader->frames.lines.count > 0; i++) {
        const run_body_record *const body = &reader->record.bodies.data[i];
        if (body->is_static) continue;
        tulle_pc2 *cache = NULL;
        tulle_pc2_info info = {0};
        tulle_status status = open_cache(reader, i, &cache, &info, error);
        if (!status) tulle_pc2_close(cache);
        if (status || info.frame_count < run_reader_get_promised_count(reader)) {
            /* Its checksums tell which frame is damaged; if none is, the header is. */
            tulle_status const checked = run_reader_check_file(
                reader, run_record_text(&reader->record, body->cache_file), error);
            if (checked) return checked;
            if (status) return status;
            char path[RUN_PATH_SIZE];
            run_join(path, reader->directory, run_record_text(&reader->record, body->cache_file));
            return pc2_check_header(path, body->vertex_count, run_reader_get_promised_count(reader),
                                    false, error);
        }
        run_frames_truncate(&reader->frames, info.frame_count);
    }
    return TULLE_OK;
}

/* A damaged checkpoint is none; tulle_run_reader_find_damage tells why. One that was missing for a
 * moment, while its writer put the next one in its place, is read again. */
static tulle_status look_for_checkpoint(tulle_run_reader *reader, tulle_error *error) {
    static const char *const names[] = {RUN_FILE_CHECKPOINT, RUN_FILE_CHECKPOINT_BEFORE};
    for (int i = 0; i < 2 && !reader->has_checkpoint; i++) {
        char path[RUN_PATH_SIZE];
        run_join(path, reader->directory, names[i]);
        tulle_status status = checkpoint_read(&reader->heap, path, &reader->checkpoint, NULL);
        if (status == TULLE_ERROR_IO && access(path, F_OK) == 0)
            status = checkpoint_read(&reader->heap, path, &reader->checkpoint, error);
        if (status == TULLE_ERROR_IO && access(path, F_OK) == 0) return status;
        if (status == TULLE_ERROR_OUT_OF_MEMORY) return file_fail_memory(error, path);
        if (status) continue;
        tulle_run_checkpoint *const state = &reader->checkpoint.state;
        memory_release(&reader->heap, state->bytes, state->byte_count);
        state->bytes = NULL;
        state->byte_count = 0;
        reader->has_checkpoint = true;
    }
    return TULLE_OK;
}

/* Users may edit the scene to change how pictures look, so its checksum is not asked here;
 * tulle_run_reader_find_damage does. */
static tulle_status read_scene(tulle_run_reader *reader, tulle_error *error) {
    char path[RUN_PATH_SIZE];
    run_join(path, reader->directory, RUN_FILE_SCENE);
    if (!reader->record.has_scene_text || access(path, F_OK) != 0) return TULLE_OK;
    return file_load(&reader->heap, path, scene_size_limit, &reader->scene, error);
}

static tulle_status read_directory(tulle_run_reader *reader, tulle_error *error) {
    char path[RUN_PATH_SIZE];
    run_join(path, reader->directory, RUN_FILE_RECORD);
    tulle_status status = run_record_read(&reader->record, path, error);
    if (status) return status;
    size_t const body_count = reader->record.bodies.count;
    reader->bodies = memory_allocate(&reader->heap, body_count * sizeof *reader->bodies);
    reader->meshes = memory_allocate_zeroed(&reader->heap, body_count, sizeof *reader->meshes);
    if (!reader->bodies || !reader->meshes)
        return file_fail(error, reader->directory, ENOMEM, "cannot be read");
    tulle_error damage = {0};
    status = look_for_checkpoint(reader, &damage);
    if (!status) status = run_reader_read_checksums(reader, &damage);
    if (!status) status = run_reader_read_frames(reader, &damage);
    if (!status) status = drop_partial_frames(reader, &damage);
    if (status == TULLE_ERROR_PARSE)
        return error_set_at(
            error, status, damage.file, damage.line, damage.column,
            "%s; tulle run --resume continues from before the damage if there is such a checkpoint",
            damage.message);
    if (status && error) *error = damage;
    if (!status) status = read_scene(reader, error);
    if (status) return status;
    describe_bodies(reader);
    describe_run(reader);
    return TULLE_OK;
}

static tulle_status open_once(const char *directory, tulle_run_reader **result,
                              tulle_error *error) {
    memory heap = memory_default();
    tulle_run_reader *const reader = memory_allocate_zeroed(&heap, 1, sizeof *reader);
    if (!reader) return file_fail(error, directory, ENOMEM, "cannot be read");
    reader->heap = memory_default();
    strcpy(reader->directory, directory);
    reader->record = run_record_make(&reader->heap);
    reader->debug.file = -1;
    reader->debug_arrays = arena_make(&reader->heap);
    reader->damage_texts = arena_make(&reader->heap);
    tulle_status const status = read_directory(reader, error);
    if (status)
        tulle_run_reader_close(reader);
    else
        *result = reader;
    return status;
}

/* A writer that takes something away makes run.json anew first, then cuts checksums.csv, then the
 * rest. So a failure may be its doing, unless the next try fails, too, at the same run.json. */
tulle_status tulle_run_reader_open(const char *directory, tulle_run_reader **result,
                                   tulle_error *error) {
    if (!directory || !result || strlen(directory) > RUN_DIRECTORY_MAX)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "a directory of at most %d bytes should be given", RUN_DIRECTORY_MAX);
    *result = NULL;
    struct stat facts;
    if (stat(directory, &facts) == 0 && S_ISREG(facts.st_mode)) {
        const char *const point = strrchr(directory, '.');
        bool const is_scene =
            point && (strcasecmp(point, ".yaml") == 0 || strcasecmp(point, ".yml") == 0);
        if (is_scene)
            return error_set_at(error, TULLE_ERROR_UNSUPPORTED, directory, 0, 0, FILE_SCENE_MESSAGE,
                                directory);
        return error_set_at(error, TULLE_ERROR_UNSUPPORTED, directory, 0, 0,
                            "is a file, not the directory of a run");
    }
    char path[RUN_PATH_SIZE];
    run_join(path, directory, RUN_FILE_RECORD);
    tulle_status status = TULLE_OK;
    int before = -1; /* run.json at the try before; open, so that its inode is not used again */
    bool is_certain = false;
    for (int try = 0; try < OPEN_TRIES && !is_certain; try++) {
        int const record = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
        struct stat then, now;
        status = open_once(directory, result, error);
        is_certain = (status != TULLE_ERROR_PARSE && status != TULLE_ERROR_IO) || record < 0 ||
                     (fstat(before, &then) == 0 && stat(path, &now) == 0 &&
                      then.st_ino == now.st_ino && then.st_dev == now.st_dev);
        if (before >= 0) close(before);
        before = record;
    }
    if (before >= 0) close(before);
    return status;
}

tulle_status run_reader_blame(const tulle_run_reader *reader, tulle_status status,
                              tulle_error *error) {
    bool const is_doubtful = status == TULLE_ERROR_PARSE || status == TULLE_ERROR_IO;
    if (!is_doubtful || !reader->sums.heap) return status;
    memory heap = memory_default();
    checksums now;
    tulle_status const again =
        checksums_read(&now, &heap, reader->directory, &reader->sums.mark, NULL);
    checksums_release(&now);
    if (again == TULLE_OK || again == TULLE_ERROR_OUT_OF_MEMORY) return status;
    return error_set_at(error, TULLE_ERROR_IO, reader->directory, 0, 0,
                        "another process changed the run while it was read; read it again");
}

const tulle_run_info *tulle_run_reader_get_info(const tulle_run_reader *reader) {
    return reader ? &reader->info : NULL;
}

tulle_status tulle_run_reader_get_mesh(tulle_run_reader *reader, size_t body, tulle_mesh_view *mesh,
                                       tulle_error *error) {
    if (!reader || !mesh || body >= reader->record.bodies.count)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "there is no body %zu", body);
    const run_body_record *const record = &reader->record.bodies.data[body];
    tulle_mesh *const kept = &reader->meshes[body];
    if (kept->vertex_count == 0) {
        char path[RUN_PATH_SIZE];
        const char *const name = run_record_text(&reader->record, record->mesh_file);
        run_join(path, reader->directory, name);
        tulle_mesh read = {0};
        tulle_status status = run_reader_check_file(reader, name, error);
        if (!status) status = tulle_mesh_read(path, &read, error);
        if (status) return run_reader_blame(reader, status, error);
        if (read.vertex_count != record->vertex_count ||
            read.triangle_count != record->triangle_count) {
            error_set_at(error, TULLE_ERROR_PARSE, path, 0, 0,
                         "has %zu vertices and %zu triangles, but run.json says %u and %u",
                         read.vertex_count, read.triangle_count, record->vertex_count,
                         record->triangle_count);
            tulle_mesh_destroy(&read);
            return TULLE_ERROR_PARSE;
        }
        *kept = read;
    }
    *mesh = tulle_mesh_get_view(kept);
    return TULLE_OK;
}

tulle_status tulle_run_reader_get_frame(const tulle_run_reader *reader, uint32_t frame,
                                        double *time, uint64_t *step, uint64_t *state_hash) {
    if (!reader || frame >= reader->frames.lines.count) return TULLE_ERROR_INVALID_ARGUMENT;
    const run_frame_line *const line = &reader->frames.lines.data[frame];
    if (time) *time = line->time;
    if (step) *step = line->step;
    if (state_hash) *state_hash = line->state_hash;
    return TULLE_OK;
}

tulle_status tulle_run_reader_get_lags(const tulle_run_reader *reader, uint32_t frame,
                                       const tulle_run_lag **lags, size_t *count) {
    if (!reader || !lags || !count || frame >= reader->frames.lines.count)
        return TULLE_ERROR_INVALID_ARGUMENT;
    const run_frame_line *const line = &reader->frames.lines.data[frame];
    *count = line->lag_count;
    *lags = line->lag_count > 0 ? reader->frames.lags.data + line->first_lag : NULL;
    return TULLE_OK;
}

int tulle_run_reader_is_present(const tulle_run_reader *reader, uint32_t frame, size_t body) {
    if (!reader || frame >= reader->frames.lines.count || body >= reader->record.bodies.count)
        return 0;
    return run_frames_is_present(&reader->frames, frame, body);
}

tulle_status tulle_run_reader_read_positions(tulle_run_reader *reader, uint32_t frame, size_t body,
                                             double *positions, tulle_error *error) {
    if (!reader || !positions || frame >= reader->frames.lines.count ||
        body >= reader->record.bodies.count)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "there is no body %zu in frame %u",
                         body, frame);
    if (reader->record.bodies.data[body].is_static) {
        tulle_mesh_view mesh;
        tulle_status const status = tulle_run_reader_get_mesh(reader, body, &mesh, error);
        if (!status) memcpy(positions, mesh.positions, 3 * mesh.vertex_count * sizeof(double));
        return status;
    }
    tulle_pc2 *cache = NULL;
    tulle_pc2_info info;
    tulle_status status = open_cache(reader, body, &cache, &info, error);
    if (status) return run_reader_blame(reader, status, error);
    const char *const name =
        run_record_text(&reader->record, reader->record.bodies.data[body].cache_file);
    char path[RUN_PATH_SIZE];
    run_join(path, reader->directory, name);
    if (frame >= info.frame_count)
        status =
            error_set_at(error, TULLE_ERROR_PARSE, path, 0, 0,
                         "frame %u: damaged: the file holds %u frames", frame, info.frame_count);
    if (!status) status = tulle_pc2_read_frame(cache, frame, positions, error);
    if (!status) {
        file_sum const sum = pc2_get_sum(cache, frame);
        const checksum_line *const line = checksums_find(&reader->sums, name, sum.begin);
        if (!line || line->sum.hash != sum.hash) status = checksum_fail(path, frame, &sum, error);
    }
    tulle_pc2_close(cache);
    return run_reader_blame(reader, status, error);
}

tulle_status tulle_run_reader_read_debug(tulle_run_reader *reader, uint32_t frame,
                                         const tulle_run_debug **debug, tulle_error *error) {
    if (debug) *debug = NULL;
    if (!reader || !debug || frame >= reader->frames.lines.count)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "there is no frame %u", frame);
    if (!reader->record.kept)
        return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, reader->directory, 0, 0,
                            "the run has no debug records and no velocities; run it again with "
                            "--record debug, or --record velocities");
    if (reader->debug.file < 0) {
        tulle_status const status =
            debug_file_open(&reader->debug, &reader->heap, reader->directory, error);
        if (status) return run_reader_blame(reader, status, error);
    }
    arena_release(&reader->debug_arrays, (arena_mark){0});
    tulle_error damage = {0};
    tulle_status const status = debug_file_read(&reader->debug, &reader->record, frame,
                                                &reader->debug_arrays, debug, &damage);
    if (!status) return TULLE_OK;
    error_set_at(error, status, damage.file, 0, 0, "frame %u: %s", frame, damage.message);
    return run_reader_blame(reader, status, error);
}

tulle_status tulle_run_reader_get_reports(tulle_run_reader *reader,
                                          const tulle_step_report **reports, size_t *count,
                                          tulle_error *error) {
    if (!reader || !reports || !count)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "an argument is null");
    tulle_status status = TULLE_OK;
    if (reader->reports.count == 0) {
        char path[RUN_PATH_SIZE];
        run_join(path, reader->directory, RUN_FILE_REPORT);
        status = run_reader_check_file(reader, RUN_FILE_REPORT, error);
        if (!status) status = run_report_read(&reader->heap, path, &reader->reports, error);
        if (status) reader->reports.count = 0;
    }
    *reports = reader->reports.data;
    *count = reader->reports.count;
    return run_reader_blame(reader, status, error);
}
