/* io/run/run_damage.c - compares what a run directory holds with its checksums.
 *
 * A run that was closed in good order should hold all that it wrote, and no more. One that goes on
 * or was killed should hold what its newest checkpoint counts; behind that, what is there. */
#define _POSIX_C_SOURCE 200809L
#include "base/error.h"
#include "base/sort.h"
#include "io/cache/pc2.h"
#include "io/run/run_reader.h"

#include <string.h>
#include <unistd.h>

uint32_t run_reader_get_promised_count(const tulle_run_reader *reader) {
    if (reader->record.has_end) return reader->sums.frame_count;
    return reader->has_checkpoint ? reader->checkpoint.state.frame_count : 0;
}

tulle_status run_reader_check_file(const tulle_run_reader *reader, const char *name,
                                   tulle_error *error) {
    return checksums_check_file(&reader->sums, reader->directory, name,
                                (uint32_t)reader->frames.lines.count, error);
}

/* Whether the run has come so far that its files were flushed. Before, a kill or a power failure
 * may have taken any of them. */
static bool is_on_disk(const tulle_run_reader *reader) {
    return reader->record.has_end || reader->has_checkpoint;
}

tulle_status run_reader_read_checksums(tulle_run_reader *reader, tulle_error *error) {
    const run_record *const record = &reader->record;
    char path[RUN_PATH_SIZE];
    run_join(path, reader->directory, RUN_FILE_CHECKSUMS);
    if (!is_on_disk(reader) && access(path, F_OK) != 0) return TULLE_OK;
    tulle_status const status = checksums_read(&reader->sums, &reader->heap, reader->directory,
                                               record->has_end ? &record->end : NULL, error);
    reader->sums.is_complete = record->has_end;
    if (status || reader->sums.mark.size >= reader->checkpoint.checksums.size) return status;
    return error_set_at(error, TULLE_ERROR_PARSE, path, 0, 0,
                        "damaged: its whole lines end at byte %llu, but the newest checkpoint "
                        "knows of %llu bytes",
                        (unsigned long long)reader->sums.mark.size,
                        (unsigned long long)reader->checkpoint.checksums.size);
}

tulle_status run_reader_read_frames(tulle_run_reader *reader, tulle_error *error) {
    char path[RUN_PATH_SIZE];
    tulle_error check_error = {0};
    run_join(path, reader->directory, RUN_FILE_FRAMES);
    tulle_status const status =
        run_frames_read(&reader->frames, &reader->heap, path, reader->record.bodies.count, error);
    if (!is_on_disk(reader) && access(path, F_OK) != 0) return status;
    /* What checksums say of a line that cannot be read is more to the point. */
    size_t const read = reader->frames.lines.count + (status ? 1 : 0);
    uint32_t const known = reader->sums.frame_count;
    uint32_t const promised = run_reader_get_promised_count(reader);
    uint32_t const there = read < known ? (uint32_t)read : known;
    tulle_status const checked =
        checksums_check_file(&reader->sums, reader->directory, RUN_FILE_FRAMES,
                             there > promised ? there : promised, &check_error);
    if (checked && error) *error = check_error;
    if (checked || status) return checked ? checked : status;
    run_frames_truncate(&reader->frames, known);
    return TULLE_OK;
}

/* ---- all of it ---- */

/* Adds a damage, unless the file has one already. */
static void add_damage(void *context, const char *name, int64_t frame, const tulle_error *error) {
    tulle_run_reader *const reader = context;
    /* A resume makes it anew, and then writes its line. */
    if (!reader->record.has_end && strcmp(name, RUN_FILE_SCENE) == 0) return;
    for (size_t i = 0; i < reader->damages.count; i++)
        if (strcmp(reader->damages.data[i].file, name) == 0) return;
    size_t const name_size = strlen(name) + 1, text_size = strlen(error->message) + 1;
    char *const file = ARENA_NEW(&reader->damage_texts, char, name_size);
    char *const message = ARENA_NEW(&reader->damage_texts, char, text_size);
    if (!file || !message || !ARRAY_RESERVE(&reader->heap, &reader->damages, 1)) {
        reader->lacks_memory = true;
        return;
    }
    memcpy(file, name, name_size);
    memcpy(message, error->message, text_size);
    reader->damages.data[reader->damages.count++] =
        (tulle_run_damage){.file = file, .frame = frame, .message = message};
}

static void check_cache_headers(tulle_run_reader *reader) {
    const run_record *const record = &reader->record;
    for (size_t i = 0; i < record->bodies.count && reader->frames.lines.count > 0; i++) {
        const run_body_record *const body = &record->bodies.data[i];
        if (body->is_static) continue;
        const char *const name = run_record_text(record, body->cache_file);
        char path[RUN_PATH_SIZE];
        tulle_error error = {0};
        run_join(path, reader->directory, name);
        if (pc2_check_header(path, body->vertex_count, (uint32_t)reader->frames.lines.count,
                             record->has_end, &error))
            add_damage(reader, name, CHECKSUM_NO_FRAME, &error);
    }
}

/* Checkpoints have hashes of their own. One that is missing is damage where the run says that it
 * made one; a kill may take the newest, but not the one before. */
static void check_checkpoints(tulle_run_reader *reader) {
    static const char *const names[] = {RUN_FILE_CHECKPOINT, RUN_FILE_CHECKPOINT_BEFORE};
    for (int i = 0; i < 2; i++) {
        char path[RUN_PATH_SIZE];
        checkpoint_record checkpoint;
        tulle_error error = {0};
        run_join(path, reader->directory, names[i]);
        bool const is_there = access(path, F_OK) == 0;
        bool const is_promised = i == 0 && reader->record.has_end && reader->record.has_checkpoint;
        tulle_status status = checkpoint_read(&reader->heap, path, &checkpoint, &error);
        if (!status && is_promised && checkpoint.state.step != reader->record.checkpoint_step)
            status = error_set_at(&error, TULLE_ERROR_PARSE, path, 0, 0,
                                  "damaged: it is of step %llu, but the newest was of step %llu",
                                  (unsigned long long)checkpoint.state.step,
                                  (unsigned long long)reader->record.checkpoint_step);
        checkpoint_release(&reader->heap, &checkpoint);
        if (status == TULLE_ERROR_OUT_OF_MEMORY)
            reader->lacks_memory = true;
        else if (status && (is_there || is_promised))
            add_damage(reader, names[i], CHECKSUM_NO_FRAME, &error);
    }
}

static int compare_damages(const void *a, const void *b) {
    const tulle_run_damage *const one = a, *const other = b;
    return strcmp(one->file, other->file);
}

tulle_status tulle_run_reader_find_damage(tulle_run_reader *reader,
                                          const tulle_run_damage **damages, size_t *count,
                                          tulle_error *error) {
    if (!reader || !damages || !count)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "an argument is null");
    reader->damages.count = 0;
    reader->lacks_memory = false;
    arena_release(&reader->damage_texts, (arena_mark){0});
    /* A replacement that failed on its way removed the checkpoints, then the lines of frames. */
    bool const promises_nothing = !is_on_disk(reader) && reader->frames.lines.count == 0;
    if (!promises_nothing) {
        checksums_check_files(&reader->sums, reader->directory,
                              (uint32_t)reader->frames.lines.count, add_damage, reader);
        check_cache_headers(reader);
        check_checkpoints(reader);
    }
    sort_in_place(reader->damages.data, reader->damages.count, sizeof *reader->damages.data,
                  compare_damages);
    *damages = reader->damages.data;
    *count = reader->damages.count;
    tulle_status status = TULLE_OK;
    if (reader->lacks_memory)
        status = file_fail_memory(error, reader->directory);
    else if (*count > 0 && run_reader_blame(reader, TULLE_ERROR_PARSE, error) == TULLE_ERROR_IO)
        status = TULLE_ERROR_IO;
    if (status) *count = 0;
    return status;
}
