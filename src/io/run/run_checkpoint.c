/* io/run/run_checkpoint.c - see run_checkpoint.h. */
#define _POSIX_C_SOURCE 200809L
#include "io/run/run_checkpoint.h"

#include "base/error.h"
#include "base/hash.h"
#include "io/bytes.h"
#include "io/file_data.h"
#include "io/output_file.h"
#include "io/run/run_directory.h"
#include "io/run/run_record.h"

#include <errno.h>
#include <stdio.h>
#include <unistd.h>

enum {
    HEADER_SIZE = 96, /* [bytes] before the state */
    HASH_SIZE = 8,    /* [bytes] at the header's end: of everything else */
    HASH_PLACE = HEADER_SIZE - HASH_SIZE,
    CHECKPOINT_VERSION = 2
};
static const char magic[9] = "TULLECKP";

static void encode_header(const checkpoint_record *record, unsigned char header[HEADER_SIZE]) {
    const tulle_run_checkpoint *const state = &record->state;
    memcpy(header, magic, 8);
    bytes_store(header + 8, 4, CHECKPOINT_VERSION);
    bytes_store(header + 12, 4, state->frame_count);
    bytes_store(header + 16, 8, state->step);
    bytes_store_double(header + 24, state->time);
    bytes_store(header + 32, 8, state->state_hash);
    bytes_store(header + 40, 8, record->scene_hash);
    bytes_store(header + 48, 8, record->report_size);
    bytes_store(header + 56, 8, record->frames_size);
    bytes_store(header + 64, 8, state->byte_count);
    bytes_store(header + 72, 8, record->checksums.size);
    bytes_store(header + 80, 8, record->checksums.chain);
    uint64_t const hash = hash_bytes(HASH_SEED, header, HASH_PLACE);
    bytes_store(header + HASH_PLACE, 8, hash_bytes(hash, state->bytes, state->byte_count));
}

/* Renames the newest checkpoint, if there is one, to the name of the one before. */
static tulle_status age_newest(const char *newest, const char *before, tulle_error *error) {
    if (rename(newest, before) == 0 || errno == ENOENT) return TULLE_OK;
    return file_fail(error, newest, errno, "cannot be renamed");
}

static tulle_status write_file(const char *newest, const char *before,
                               const checkpoint_record *record, tulle_error *error) {
    output_file *output = NULL;
    tulle_status status = output_open_inside(newest, &output, error);
    if (status) return status;
    unsigned char header[HEADER_SIZE];
    encode_header(record, header);
    output_write(output, header, sizeof header);
    output_write(output, record->state.bytes, record->state.byte_count);
    /* All bytes are on the disk before the generations move. */
    status = output_flush(output, error);
    if (!status) status = age_newest(newest, before, error);
    if (status) {
        output_discard(output);
        return status;
    }
    status = output_commit(output, error);
    /* Where the new one got no name, the one that was the newest is so again; best effort. */
    if (status && access(newest, F_OK) != 0) (void)rename(before, newest);
    return status;
}

tulle_status checkpoint_write(const char *directory, const checkpoint_record *record,
                              tulle_error *error) {
    char newest[RUN_PATH_SIZE], before[RUN_PATH_SIZE];
    run_join(newest, directory, RUN_FILE_CHECKPOINT);
    run_join(before, directory, RUN_FILE_CHECKPOINT_BEFORE);
    return write_file(newest, before, record, error);
}

/* A number of JSON: whole to 2^53. */
#define STEPS_MAX ((UINT64_C(1) << 53) - 1)

static tulle_status decode(memory *heap, const char *path, const file_data *data,
                           checkpoint_record *record, tulle_error *error) {
    const char *const header = data->bytes;
    if (data->byte_count < HEADER_SIZE || memcmp(header, magic, 8) != 0)
        return error_set_at(error, TULLE_ERROR_PARSE, path, 0, 0,
                            "byte 0: is not a checkpoint, or is cut within its header");
    if (bytes_load(header + 8, 4) != CHECKPOINT_VERSION)
        return error_set_at(error, TULLE_ERROR_PARSE, path, 0, 0,
                            "byte 8: version %u; only version %d can be read",
                            (unsigned)bytes_load(header + 8, 4), CHECKPOINT_VERSION);
    size_t const size = data->byte_count - HEADER_SIZE;
    if (bytes_load(header + 64, 8) != size)
        return error_set_at(error, TULLE_ERROR_PARSE, path, 0, 0,
                            "byte %zu: the file should have %llu bytes of state, but it has %zu",
                            data->byte_count, (unsigned long long)bytes_load(header + 64, 8), size);
    uint64_t const hash = hash_bytes(HASH_SEED, header, HASH_PLACE);
    if (hash_bytes(hash, header + HEADER_SIZE, size) != bytes_load(header + HASH_PLACE, 8))
        return error_set_at(error, TULLE_ERROR_PARSE, path, 0, 0,
                            "its bytes were changed after it was written");
    if (bytes_load(header + 16, 8) > STEPS_MAX)
        return error_set_at(error, TULLE_ERROR_PARSE, path, 0, 0,
                            "byte 16: %llu steps are more than run.json can name",
                            (unsigned long long)bytes_load(header + 16, 8));
    void *const bytes = memory_allocate(heap, size);
    if (!bytes) return file_fail(error, path, ENOMEM, "cannot be read");
    memcpy(bytes, header + HEADER_SIZE, size);
    *record = (checkpoint_record){
        .state = {.bytes = bytes,
                  .byte_count = size,
                  .step = bytes_load(header + 16, 8),
                  .time = bytes_to_double(bytes_load(header + 24, 8)),
                  .state_hash = bytes_load(header + 32, 8),
                  .frame_count = (uint32_t)bytes_load(header + 12, 4)},
        .scene_hash = bytes_load(header + 40, 8),
        .report_size = bytes_load(header + 48, 8),
        .frames_size = bytes_load(header + 56, 8),
        .checksums = {.size = bytes_load(header + 72, 8), .chain = bytes_load(header + 80, 8)}};
    return TULLE_OK;
}

tulle_status checkpoint_read(memory *heap, const char *path, checkpoint_record *record,
                             tulle_error *error) {
    *record = (checkpoint_record){0};
    file_data data;
    tulle_status status = file_load(heap, path, 0, &data, error);
    if (status) return status;
    status = decode(heap, path, &data, record, error);
    file_release(heap, &data);
    return status;
}

void checkpoint_release(memory *heap, checkpoint_record *record) {
    memory_release(heap, record->state.bytes, record->state.byte_count);
    *record = (checkpoint_record){0};
}
