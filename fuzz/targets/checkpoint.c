/* fuzz/targets/checkpoint.c - the reader of checkpoint files. What it takes is written again to the
 * same bytes. The first byte of an input says whether the hash is made right, without which nearly
 * all inputs end at it. */
#include "support/fuzz.h"

#include "base/hash.h"
#include "io/file_data.h"
#include "io/run/run_checkpoint.h"
#include "io/run/run_record.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { HASH_SIZE = 8, HEADER_SIZE = 96 /* src/io/run/FORMAT.md */ };

static void make_hash_right(uint8_t *bytes, size_t size) {
    if (size < HEADER_SIZE) return;
    uint64_t const hash = hash_bytes(HASH_SEED, bytes, HEADER_SIZE - HASH_SIZE);
    uint64_t const whole = hash_bytes(hash, bytes + HEADER_SIZE, size - HEADER_SIZE);
    memcpy(bytes + HEADER_SIZE - HASH_SIZE, &whole, sizeof whole);
}

static void check_written_again(const checkpoint_record *record, const uint8_t *bytes,
                                size_t size) {
    tulle_error error = {0};
    memory heap = memory_default();
    file_data written = {0};
    const char *const newest = fuzz_path(RUN_FILE_CHECKPOINT);
    char folder[512];
    snprintf(folder, sizeof folder, "%s", newest);
    *strrchr(folder, '/') = '\0';
    FUZZ_CHECK_OK(checkpoint_write(folder, record, &error), &error);
    FUZZ_CHECK_OK(file_load(&heap, newest, 0, &written, &error), &error);
    FUZZ_CHECK(written.byte_count == size && memcmp(written.bytes, bytes, size) == 0);
    file_release(&heap, &written);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    if (size < 1) return 0;
    uint8_t *const bytes = malloc(size);
    FUZZ_CHECK(bytes);
    memcpy(bytes, data + 1, --size);
    if (data[0] % 2 == 1) make_hash_right(bytes, size);
    const char *const path = fuzz_put_file("input.bin", bytes, size);
    memory heap = memory_default();
    checkpoint_record record;
    tulle_error error = {0};
    tulle_status const status = checkpoint_read(&heap, path, &record, &error);
    if (status) {
        /* Of a file with its hash made right only the head can be wrong. */
        FUZZ_CHECK(data[0] % 2 == 0 || !strstr(error.message, "were changed"));
        fuzz_check_error(status, &error);
        FUZZ_CHECK(strcmp(error.file, path) == 0 && !record.state.bytes);
    } else {
        FUZZ_CHECK(record.state.byte_count == size - HEADER_SIZE);
        check_written_again(&record, bytes, size);
        checkpoint_release(&heap, &record);
    }
    free(bytes);
    return 0;
}

void fuzz_make_seeds(void) {
    char state[] = "a state of some bytes";
    checkpoint_record const record = {.state = {.bytes = state,
                                                .byte_count = sizeof state,
                                                .step = 7,
                                                .time = 0.25,
                                                .state_hash = 99,
                                                .frame_count = 3},
                                      .scene_hash = 5,
                                      .report_size = 100,
                                      .frames_size = 200};
    const char *const newest = fuzz_path(RUN_FILE_CHECKPOINT);
    char folder[512], seed[512] = "\1";
    snprintf(folder, sizeof folder, "%s", newest);
    *strrchr(folder, '/') = '\0';
    memory heap = memory_default();
    file_data written = {0};
    FUZZ_CHECK(checkpoint_write(folder, &record, NULL) == TULLE_OK);
    FUZZ_CHECK(file_load(&heap, newest, 0, &written, NULL) == TULLE_OK);
    memcpy(seed + 1, written.bytes, written.byte_count);
    fuzz_put_seed("whole", seed, 1 + written.byte_count);
    fuzz_put_seed("without_state", seed, 1 + HEADER_SIZE);
    file_release(&heap, &written);
}
