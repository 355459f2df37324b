/* io/run/run_checksums_write.c - appends lines to checksums.csv, see run_checksums.h. */
#include "io/run/run_checksums_format.h"

#include "base/error.h"

#include <stdio.h>

void checksum_log_forget(checksum_log *sums) {
    sums->lines.count = 0;
    sums->chain = sums->mark.chain;
    sums->lacks_memory = false;
}

tulle_status checksum_log_create(checksum_log *sums, const char *directory, tulle_error *error) {
    char path[RUN_PATH_SIZE];
    size_t const length = strlen(CHECKSUMS_HEADING);
    run_join(path, directory, RUN_FILE_CHECKSUMS);
    sums->mark = checksums_get_first_mark();
    checksum_log_forget(sums);
    return run_log_create(&sums->log, path, CHECKSUMS_HEADING, length, error);
}

tulle_status checksum_log_resume(checksum_log *sums, const char *directory, checksum_mark mark,
                                 tulle_error *error) {
    char path[RUN_PATH_SIZE];
    run_join(path, directory, RUN_FILE_CHECKSUMS);
    sums->mark = mark;
    checksum_log_forget(sums);
    return run_log_resume(&sums->log, path, mark.size, error);
}

void checksum_log_add(checksum_log *sums, memory *heap, const char *name, int64_t frame,
                      const file_sum *sum) {
    size_t const room = strlen(name) + CHECKSUM_LINE_SIZE;
    if (!ARRAY_RESERVE(heap, &sums->lines, room)) {
        sums->lacks_memory = true;
        return;
    }
    char *const line = sums->lines.data + sums->lines.count;
    char number[24] = "";
    if (frame >= 0) (void)snprintf(number, sizeof number, "%lld", (long long)frame);
    size_t const length = (size_t)snprintf(
        line, room, "%s,%s,%llu,%llu,%016llx,", name, number, (unsigned long long)sum->begin,
        (unsigned long long)sum->end, (unsigned long long)sum->hash);
    sums->chain = hash_bytes(sums->chain, line, length);
    (void)snprintf(line + length, room - length, "%016llx\n", (unsigned long long)sums->chain);
    sums->lines.count += length + CHECKSUM_CHAIN_SIZE;
}

tulle_status checksum_log_append(checksum_log *sums, tulle_error *error) {
    tulle_status const status =
        sums->lacks_memory ? error_set_at(error, TULLE_ERROR_OUT_OF_MEMORY, sums->log.path, 0, 0,
                                          "out of memory for its lines")
                           : run_log_append(&sums->log, sums->lines.data, sums->lines.count, error);
    if (status == TULLE_OK) {
        sums->mark = (checksum_mark){.size = sums->log.size, .chain = sums->chain};
        run_log_mark_summed(&sums->log);
    }
    checksum_log_forget(sums);
    return status;
}

void checksum_log_cut(checksum_log *sums, checksum_mark mark) {
    sums->log.summed = mark.size;
    run_log_cut(&sums->log);
    sums->mark = mark;
    checksum_log_forget(sums);
}

void checksum_log_close(checksum_log *sums, memory *heap) {
    run_log_close(&sums->log);
    ARRAY_FREE(heap, &sums->lines);
}
