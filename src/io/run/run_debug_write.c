/* io/run/run_debug_write.c - appends blocks to debug.bin, see run_debug.h. */
#include "base/error.h"
#include "base/hash.h"
#include "io/bytes.h"
#include "io/run/run_debug_format.h"

#include <float.h>
#include <math.h>

debug_log debug_log_make(memory *heap) { return (debug_log){.heap = heap, .log = {.file = -1}}; }

void debug_log_close(debug_log *writer) {
    run_log_close(&writer->log);
    ARRAY_FREE(writer->heap, &writer->room);
}

tulle_status debug_log_create(debug_log *writer, const char *directory, tulle_error *error) {
    char path[RUN_PATH_SIZE], head[DEBUG_HEAD_SIZE] = DEBUG_MAGIC;
    run_join(path, directory, RUN_FILE_DEBUG);
    bytes_store(head + 8, 4, DEBUG_VERSION);
    bytes_store(head + 12, 4, 0);
    return run_log_create(&writer->log, path, head, sizeof head, error);
}

/* ---- checks ---- */

bool debug_contact_fits(const tulle_contact *contact, const run_record *record) {
    bool const is_edges = contact->kind == TULLE_CONTACT_EDGE_EDGE;
    if ((!is_edges && contact->kind != TULLE_CONTACT_VERTEX_FACE) ||
        (unsigned)contact->state > TULLE_CONTACT_SLIP)
        return false;
    for (int k = 0; k < 4; k++) {
        uint32_t const object = k < (is_edges ? 2 : 1) ? contact->object_a : contact->object_b;
        if (object >= record->bodies.count ||
            contact->vertices[k] >= record->bodies.data[object].vertex_count)
            return false;
    }
    return true;
}

static bool labels_fit(const uint32_t *labels, size_t count, uint32_t patch_count) {
    for (size_t i = 0; i < count; i++)
        if (labels[i] > patch_count) return false;
    return true;
}

static tulle_status check_debug(const run_record *record, const tulle_run_debug *debug,
                                tulle_error *error) {
    bool const is_all = record->kept == RUN_KEEPS_DEBUG;
    if (!debug->velocities || (is_all && (!debug->patch_labels || !debug->patch_counts ||
                                          (debug->contact_count > 0 && !debug->contacts) ||
                                          debug->contact_count > UINT32_MAX)))
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "a debug record needs velocities, contacts, labels and counts");
    for (size_t i = 0; i < record->bodies.count; i++) {
        const run_body_record *const body = &record->bodies.data[i];
        if (!body->is_static && !debug->velocities[i])
            return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                             "the debug record needs velocities of body %zu, which moves", i);
        if (body->is_obstacle || !is_all) continue;
        if (!debug->patch_labels[i] ||
            !labels_fit(debug->patch_labels[i], body->triangle_count, debug->patch_counts[i]))
            return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                             "the patch labels of cloth %zu are missing, or over %u", i,
                             debug->patch_counts[i]);
    }
    for (size_t i = 0; is_all && i < debug->contact_count; i++)
        if (!debug_contact_fits(&debug->contacts[i], record))
            return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                             "contact %zu of the debug record is not of the run's bodies", i);
    return TULLE_OK;
}

/* ---- bytes ---- */

/* Rounded to float; what float cannot hold becomes the largest float. */
static unsigned char *put_floats(unsigned char *at, const double *values, size_t count) {
    double const most = (double)FLT_MAX;
    for (size_t i = 0; i < count; i++)
        bytes_store_float(at + 4 * i, (float)fmin(fmax(values[i], -most), most));
    return at + 4 * count;
}

static unsigned char *put_whole(unsigned char *at, uint32_t value) {
    bytes_store(at, 4, value);
    return at + 4;
}

static unsigned char *put_contact(unsigned char *at, const tulle_contact *contact) {
    uint32_t const flags = (contact->kind == TULLE_CONTACT_EDGE_EDGE ? DEBUG_FLAG_EDGES : 0u) |
                           (uint32_t)contact->state << DEBUG_STATE_SHIFT |
                           (contact->is_new ? DEBUG_FLAG_NEW : 0u) |
                           (contact->is_hard ? DEBUG_FLAG_HARD : 0u);
    at = put_whole(at, contact->object_a);
    at = put_whole(at, contact->object_b);
    for (int k = 0; k < 4; k++) at = put_whole(at, contact->vertices[k]);
    at = put_whole(at, flags);
    at = put_floats(at, contact->weights, 4);
    at = put_floats(at, contact->position, 3);
    at = put_floats(at, contact->normal, 3);
    at = put_floats(at, &contact->gap, 1);
    return put_floats(at, contact->impulse, 3);
}

static unsigned char *put_labels(unsigned char *at, const uint32_t *labels, size_t count,
                                 uint32_t patch_count) {
    at = put_whole(at, patch_count);
    size_t const size = debug_label_size(patch_count);
    for (size_t i = 0; i < count; i++) bytes_store(at + size * i, size, labels[i]);
    return at + size * count;
}

static size_t measure_payload(const run_record *record, const tulle_run_debug *debug) {
    bool const is_all = record->kept == RUN_KEEPS_DEBUG;
    size_t size = is_all ? debug->contact_count * DEBUG_CONTACT_SIZE : 0;
    for (size_t i = 0; i < record->bodies.count; i++) {
        const run_body_record *const body = &record->bodies.data[i];
        if (!body->is_static) size += 3 * sizeof(float) * (size_t)body->vertex_count;
        if (is_all && !body->is_obstacle)
            size += 4 + debug_label_size(debug->patch_counts[i]) * (size_t)body->triangle_count;
    }
    return size;
}

static void encode_payload(unsigned char *at, const run_record *record,
                           const tulle_run_debug *debug) {
    for (size_t i = 0; i < record->bodies.count; i++)
        if (!record->bodies.data[i].is_static)
            at = put_floats(at, debug->velocities[i],
                            3 * (size_t)record->bodies.data[i].vertex_count);
    if (record->kept != RUN_KEEPS_DEBUG) return;
    for (size_t i = 0; i < debug->contact_count; i++) at = put_contact(at, &debug->contacts[i]);
    for (size_t i = 0; i < record->bodies.count; i++)
        if (!record->bodies.data[i].is_obstacle)
            at = put_labels(at, debug->patch_labels[i], record->bodies.data[i].triangle_count,
                            debug->patch_counts[i]);
}

static void encode_header(unsigned char *block, size_t size, uint32_t frame,
                          const tulle_run_debug *debug, bool is_all) {
    memcpy(block + DEBUG_PLACE_MAGIC, DEBUG_BLOCK_MAGIC, 4);
    bytes_store(block + DEBUG_PLACE_FRAME, 4, frame);
    bytes_store(block + DEBUG_PLACE_SIZE, 8, size);
    bytes_store(block + DEBUG_PLACE_PAYLOAD_HASH, 8,
                hash_bytes(HASH_SEED, block + DEBUG_HEADER_SIZE, size - DEBUG_HEADER_SIZE));
    bytes_store(block + DEBUG_PLACE_CONTACTS, 4, debug && is_all ? debug->contact_count : 0);
    bytes_store(block + DEBUG_PLACE_KNOWN, 4, !debug ? 0 : is_all ? 1 : 2);
    bytes_store(block + DEBUG_PLACE_HEADER_HASH, 8,
                hash_bytes(HASH_SEED, block, DEBUG_PLACE_HEADER_HASH));
}

tulle_status debug_log_append(debug_log *writer, const run_record *record, uint32_t frame,
                              const tulle_run_debug *debug, tulle_error *error) {
    tulle_status const status = debug ? check_debug(record, debug, error) : TULLE_OK;
    if (status) return status;
    size_t const size = DEBUG_HEADER_SIZE + (debug ? measure_payload(record, debug) : 0);
    writer->room.count = 0;
    if (!ARRAY_RESERVE(writer->heap, &writer->room, size))
        return error_set_at(error, TULLE_ERROR_OUT_OF_MEMORY, writer->log.path, 0, 0,
                            "out of memory for the debug record of frame %u", frame);
    unsigned char *const block = writer->room.data;
    if (debug) encode_payload(block + DEBUG_HEADER_SIZE, record, debug);
    encode_header(block, size, frame, debug, record->kept == RUN_KEEPS_DEBUG);
    return run_log_append(&writer->log, (const char *)block, size, error);
}
