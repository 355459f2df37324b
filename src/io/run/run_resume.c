/* io/run/run_resume.c - opens the directory of a run that was cut short and cuts its files back to
 * the newest checkpoint whose files are all as they were when it was made. */
#define _POSIX_C_SOURCE 200809L
#include "base/error.h"
#include "io/cache/pc2.h"
#include "io/file_data.h"
#include "io/run/run_checkpoint.h"
#include "io/run/run_writer.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* [bytes] of a file; 0 when it is not there. */
static uint64_t measure_file(const char *directory, const char *name) {
    char path[RUN_PATH_SIZE];
    run_join(path, directory, name);
    struct stat facts;
    return stat(path, &facts) == 0 ? (uint64_t)facts.st_size : 0;
}

/* ---- what is damaged ---- */

/* A checkpoint that may be gone on from, and what checksums.csv says up to it. */
typedef struct candidate {
    tulle_run_writer *writer;
    checkpoint_record record;
    checksums sums;
    tulle_error damage;          /* the first that cannot be made good; status TULLE_OK: none */
    bool has_damaged_scene_file; /* files that follow from the scene are to be made again */
} candidate;

static void release_candidate(candidate *tried) {
    checkpoint_release(&tried->writer->heap, &tried->record);
    checksums_release(&tried->sums);
}

static bool is_scene_file(const tulle_run_writer *writer, const char *name) {
    char own[RUN_PATH_SIZE];
    for (size_t i = 0; i < writer->record.bodies.count; i++)
        for (int kind = SCENE_FILE_TEXT; kind <= SCENE_FILE_VTP; kind++)
            if (run_writer_name_file(writer, (scene_file)kind, i, own) && strcmp(own, name) == 0)
                return true;
    return false;
}

static void note_damage(void *context, const char *name, int64_t frame, const tulle_error *error) {
    candidate *const tried = context;
    (void)frame;
    if (is_scene_file(tried->writer, name))
        tried->has_damaged_scene_file = true;
    else if (tried->damage.status == TULLE_OK)
        tried->damage = *error;
}

/* Reads one generation and compares all files with what they held when it was made. */
static tulle_status try_checkpoint(candidate *tried, const char *name, tulle_error *error) {
    tulle_run_writer *const writer = tried->writer;
    char path[RUN_PATH_SIZE];
    run_join(path, writer->directory, name);
    tulle_status status = checkpoint_read(&writer->heap, path, &tried->record, error);
    if (!status && tried->record.scene_hash != writer->record.scene_hash)
        status = error_set_at(error, TULLE_ERROR_PARSE, path, 0, 0,
                              "the checkpoint is of another scene");
    if (!status)
        status = checksums_read(&tried->sums, &writer->heap, writer->directory,
                                &tried->record.checksums, error);
    if (!status && tried->sums.frame_count != tried->record.state.frame_count)
        status = error_set_at(error, TULLE_ERROR_PARSE, path, 0, 0,
                              "the checkpoint knows of %u frames, but checksums.csv of %u",
                              tried->record.state.frame_count, tried->sums.frame_count);
    if (!status)
        checksums_check_files(&tried->sums, writer->directory, UINT32_MAX, note_damage, tried);
    for (size_t i = 0; i < writer->record.bodies.count && !status && !tried->damage.status; i++) {
        const run_body_record *const body = &writer->record.bodies.data[i];
        if (body->is_static) continue;
        run_join(path, writer->directory, run_record_text(&writer->record, body->cache_file));
        pc2_check_header(path, body->vertex_count, tried->record.state.frame_count, false,
                         &tried->damage);
    }
    if (!status && tried->damage.status) {
        status = tried->damage.status;
        if (error) *error = tried->damage;
    }
    if (status) {
        release_candidate(tried);
        *tried = (candidate){.writer = writer};
    }
    return status;
}

/* Adds a line to what the resume has to say; without memory it goes untold. */
__attribute__((format(printf, 2, 3))) static void note(tulle_run_writer *writer, const char *format,
                                                       ...) {
    enum { NOTE_SIZE = RUN_PATH_SIZE + 1024 };
    char text[NOTE_SIZE];
    va_list arguments;
    va_start(arguments, format);
    (void)vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    size_t const length = strlen(text);
    if (!ARRAY_RESERVE(&writer->heap, &writer->notes, length + 2)) return;
    if (writer->notes.count > 0) writer->notes.data[writer->notes.count++] = '\n';
    memcpy(writer->notes.data + writer->notes.count, text, length + 1);
    writer->notes.count += length;
}

const char *tulle_run_get_notes(const tulle_run_writer *writer) {
    return writer && writer->notes.count > 0 ? writer->notes.data : "";
}

const tulle_run_outcome *tulle_run_get_former_outcome(const tulle_run_writer *writer) {
    return writer && writer->has_former_outcome ? &writer->former_outcome : NULL;
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

/* A damaged generation before is of no use. */
static tulle_status drop_damaged_before(tulle_run_writer *writer, tulle_error *error) {
    char before[RUN_PATH_SIZE];
    checkpoint_record record;
    tulle_error damage = {0};
    run_join(before, writer->directory, RUN_FILE_CHECKPOINT_BEFORE);
    tulle_status const status = checkpoint_read(&writer->heap, before, &record, &damage);
    checkpoint_release(&writer->heap, &record);
    if (status == TULLE_ERROR_OUT_OF_MEMORY) return file_fail_memory(error, before);
    if (status != TULLE_ERROR_PARSE) return TULLE_OK;
    if (unlink(before) != 0) return file_fail(error, before, errno, "cannot be removed");
    note(writer, "%s: damaged, and removed: the newest checkpoint is whole", before);
    return TULLE_OK;
}

/* The newest usable checkpoint; *is_found false when the run never made one. */
static tulle_status find_checkpoint(candidate *tried, const run_record *old, bool *is_found,
                                    tulle_error *error) {
    tulle_run_writer *const writer = tried->writer;
    bool const has_newest = measure_file(writer->directory, RUN_FILE_CHECKPOINT) > 0;
    bool const has_before = measure_file(writer->directory, RUN_FILE_CHECKPOINT_BEFORE) > 0;
    tulle_error newest = {0};
    *is_found = true;
    if (!try_checkpoint(tried, RUN_FILE_CHECKPOINT, &newest))
        return drop_damaged_before(writer, error);
    if (newest.status == TULLE_ERROR_OUT_OF_MEMORY) {
        if (error) *error = newest;
        return newest.status;
    }
    if (!try_checkpoint(tried, RUN_FILE_CHECKPOINT_BEFORE, NULL)) {
        if (has_newest || old->has_end) /* else it was killed between the two */
            note(writer, "%s: %s; the run continues from the checkpoint before, after step %llu",
                 newest.file, newest.message, (unsigned long long)tried->record.state.step);
        return drop_newest(writer, error);
    }
    *is_found = has_newest || has_before || (old->has_end && old->has_checkpoint);
    if (!*is_found) return TULLE_OK;
    return error_set_at(error, TULLE_ERROR_PARSE, newest.file, 0, 0,
                        "%s; neither checkpoint of the run can be used: bring the file back from a "
                        "copy, or replace the run (--force)",
                        newest.message);
}

/* ---- taking over ---- */

/* Makes damaged files that follow from the scene again, to the bytes that they had. */
static tulle_status restore_scene_files(const candidate *tried, const tulle_run_def *def,
                                        tulle_error *error) {
    tulle_run_writer *const writer = tried->writer;
    char name[RUN_PATH_SIZE];
    tulle_status status = run_writer_make_vtp_folder(writer, error);
    if (!tried->has_damaged_scene_file) return status;
    for (size_t i = 0; i < writer->record.bodies.count && !status; i++) {
        for (int kind = SCENE_FILE_MESH; kind <= SCENE_FILE_VTP && !status; kind++) {
            if (!run_writer_name_file(writer, (scene_file)kind, i, name) ||
                !checksums_check_file(&tried->sums, writer->directory, name, UINT32_MAX, NULL))
                continue;
            status = run_writer_write_file(writer, def, (scene_file)kind, i,
                                           &checksums_find(&tried->sums, name, 0)->sum, error);
            if (!status) note(writer, "%s/%s: damaged, and made again", writer->directory, name);
        }
    }
    return status;
}

/* Writes scene.yaml, unless it is there. It has another number of frames where the run gets longer;
 * that of a run which is longer than `def` wants stays. */
static tulle_status renew_scene_text(const candidate *tried, const tulle_run_def *def,
                                     bool is_longer, tulle_error *error) {
    tulle_run_writer *const writer = tried->writer;
    const checksum_line *const line = checksums_find(&tried->sums, RUN_FILE_SCENE, 0);
    size_t const size = def->scene_text ? strlen(def->scene_text) : 0;
    bool const is_same = line && line->sum.end == size &&
                         line->sum.hash == hash_bytes(FILE_SUM_SEED, def->scene_text, size);
    bool const is_sound =
        (is_same || (line && is_longer)) &&
        !checksums_check_file(&tried->sums, writer->directory, RUN_FILE_SCENE, UINT32_MAX, NULL);
    if (is_sound) return TULLE_OK;
    tulle_status const status =
        run_writer_write_file(writer, def, SCENE_FILE_TEXT, 0, is_same ? &line->sum : NULL, error);
    if (!status && is_same)
        note(writer, "%s/%s: damaged, and made again", writer->directory, RUN_FILE_SCENE);
    return status ? status : checksum_log_append(&writer->checksums, error);
}

static tulle_status resume_log(const tulle_run_writer *writer, run_log *log, const char *name,
                               const checksums *sums, tulle_error *error) {
    char path[RUN_PATH_SIZE];
    run_join(path, writer->directory, name);
    return run_log_resume(log, path, checksums_get_end(sums, name), error);
}

static tulle_status cut_files_back(const candidate *tried, tulle_error *error) {
    tulle_run_writer *const writer = tried->writer;
    const checksums *const sums = &tried->sums;
    char path[RUN_PATH_SIZE];
    uint32_t const frame_count = tried->record.state.frame_count;
    /* What says that the rest is there goes first, so that a reader is not misled. */
    tulle_status status =
        checksum_log_resume(&writer->checksums, writer->directory, sums->mark, error);
    if (!status) status = resume_log(writer, &writer->frames_log, RUN_FILE_FRAMES, sums, error);
    for (size_t i = 0; i < writer->record.bodies.count && !status; i++) {
        const run_body_record *const body = &writer->record.bodies.data[i];
        if (body->is_static) continue;
        run_join(path, writer->directory, run_record_text(&writer->record, body->cache_file));
        tulle_error cut = {0};
        if (pc2_is_cut(path, &cut)) /* after a power failure */
            note(writer,
                 "%s: %s; its frames up to the checkpoint are whole, the others are made again",
                 path, cut.message);
        status = pc2_writer_open_unflushed(path, body->vertex_count, frame_count,
                                           &writer->caches[i], error);
    }
    if (!status) status = resume_log(writer, &writer->report_log, RUN_FILE_REPORT, sums, error);
    if (!status && writer->record.kept)
        status = resume_log(writer, &writer->debug.log, RUN_FILE_DEBUG, sums, error);
    if (!status && transforms_count_bodies(&writer->record) > 0)
        status = resume_log(writer, &writer->bodies_log, RUN_FILE_BODIES, sums, error);
    if (!status)
        status = run_frames_read(&writer->frames, &writer->heap, writer->frames_log.path,
                                 writer->record.bodies.count, error);
    if (!status && writer->frames.lines.count != frame_count)
        status = error_set_at(error, TULLE_ERROR_PARSE, writer->frames_log.path, 0, 0,
                              "holds %zu frames, but the checkpoint knows of %u; replace the run",
                              writer->frames.lines.count, frame_count);
    return status;
}

/* The run in writer->directory becomes the writer's, cut back to its checkpoint. Nothing is changed
 * before all of it is known to be sound. */
static tulle_status take_over(candidate *tried, const tulle_run_def *def, bool *is_found,
                              tulle_error *error) {
    tulle_run_writer *const writer = tried->writer;
    char path[RUN_PATH_SIZE];
    run_join(path, writer->directory, RUN_FILE_RECORD);
    run_record old = run_record_make(&writer->heap);
    tulle_status status = run_record_read(&old, path, error);
    if (!status) status = run_record_compare(&old, &writer->record, writer->directory, error);
    if (!status) status = run_directory_check_files(writer->directory, &writer->record, error);
    if (!status) status = find_checkpoint(tried, &old, is_found, error);
    if (*is_found) { /* what the start came to stays on record */
        writer->record.has_untangle = old.has_untangle;
        writer->record.untangle = old.untangle;
        writer->has_former_outcome = old.has_outcome;
        writer->former_outcome = old.outcome;
    }
    uint32_t const held = tried->record.state.frame_count; /* with that of the start */
    bool const is_longer = *is_found && held > 0 && held - 1 > def->frame_count;
    if (is_longer) writer->record.wanted_frame_count = old.wanted_frame_count;
    run_record_destroy(&old);
    if (status || !*is_found) return status;
    writer->record.has_checkpoint = true;
    writer->record.checkpoint_step = tried->record.state.step;
    run_directory_remove_temporaries(writer->directory, &writer->record);
    writer->has_unflushed_files = true;
    status = restore_scene_files(tried, def, error);
    /* While files are cut, the run is no longer one that ended. */
    if (!status) status = run_writer_write_record(writer, error);
    if (!status) status = cut_files_back(tried, error);
    if (!status && is_longer)
        note(writer,
             "%s: holds %u frames after the start, more than the %u that are wanted: it stays",
             writer->directory, held - 1, def->frame_count);
    return status ? status : renew_scene_text(tried, def, is_longer, error);
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
    candidate tried = {.writer = writer};
    bool is_found = false;
    status =
        run_directory_lock(writer->directory, &writer->lock, &writer->has_made_directory, error);
    if (!status) status = run_directory_examine(writer->directory, &kind, error);
    if (!status && kind == RUN_DIRECTORY_RUN) status = take_over(&tried, def, &is_found, error);
    if (!status && !is_found)
        status = run_writer_begin(writer, def, kind, TULLE_RUN_REPLACE, error);
    if (status) {
        release_candidate(&tried);
        run_writer_abandon(writer);
        return status;
    }
    *checkpoint = tried.record.state;
    checksums_release(&tried.sums);
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
