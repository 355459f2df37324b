/* io/run/run_seal.c - what run.json says of checksums: the member "checksums", how far
 * checksums.csv goes and whether there is a checkpoint, once the run is closed; and its last key,
 * the hash of its own bytes. */
#include "base/error.h"
#include "base/hash.h"
#include "io/run/run_record.h"

#include <stdio.h>
#include <string.h>

void run_end_write(json_writer *writer, const run_record *record) {
    if (!record->has_end) return;
    json_begin(writer, "checksums", '{');
    json_put_unsigned(writer, "bytes", record->end.size);
    json_put_hash(writer, "chain", record->end.chain);
    if (record->has_checkpoint)
        json_put_unsigned(writer, "checkpoint_step", record->checkpoint_step);
    json_end(writer, '}');
}

tulle_status run_end_read(run_record *record, const json_document *document, const json_value *root,
                          tulle_error *error) {
    const json_value *object = NULL;
    if (!json_find(document, root, "checksums")) return TULLE_OK;
    tulle_status status =
        json_take_member(document, root, "checksums", JSON_OBJECT, &object, error);
    if (!status) status = json_take_count(document, object, "bytes", &record->end.size, error);
    if (!status) status = json_take_hash(document, object, "chain", &record->end.chain, error);
    record->has_checkpoint = !status && json_find(document, object, "checkpoint_step");
    if (record->has_checkpoint)
        status =
            json_take_count(document, object, "checkpoint_step", &record->checkpoint_step, error);
    record->has_end = !status;
    return status;
}

/* What follows the bytes of a run.json that its checksum is of. */
static const char seal_begin[] = ",\n  \"checksum\": \"", seal_end[] = "\"\n}\n";

tulle_status run_seal_check(const char *path, const file_data *data, bool *has_seal,
                            tulle_error *error) {
    enum { BEGIN_SIZE = sizeof seal_begin - 1, END_SIZE = sizeof seal_end - 1, DIGITS = 16 };
    size_t const size = BEGIN_SIZE + DIGITS + END_SIZE;
    const char *const seal = data->bytes + data->byte_count - size;
    *has_seal = data->byte_count >= size && memcmp(seal, seal_begin, BEGIN_SIZE) == 0 &&
                memcmp(seal + BEGIN_SIZE + DIGITS, seal_end, END_SIZE) == 0;
    if (!*has_seal) return TULLE_OK;
    char digits[DIGITS + 1];
    uint64_t const hash = hash_bytes(FILE_SUM_SEED, data->bytes, data->byte_count - size);
    snprintf(digits, sizeof digits, "%016llx", (unsigned long long)hash);
    if (memcmp(seal + BEGIN_SIZE, digits, DIGITS) == 0) return TULLE_OK;
    return error_set_at(error, TULLE_ERROR_PARSE, path, 0, 0,
                        "damaged: its bytes are not those that the run wrote, as the checksum at "
                        "its end says");
}
