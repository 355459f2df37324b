/* io/run/run_debug_read.c - walks over the blocks of debug.bin and reads one, see run_debug.h. */
#define _POSIX_C_SOURCE 200809L
#include "base/error.h"
#include "base/hash.h"
#include "io/bytes.h"
#include "io/file_data.h"
#include "io/run/run_debug_format.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <sys/stat.h>
#include <unistd.h>

static tulle_status fail_at(const debug_file *file, uint64_t byte, tulle_error *error,
                            const char *what) {
    return error_set_at(error, TULLE_ERROR_PARSE, file->path, 0, 0, "byte %llu: %s",
                        (unsigned long long)byte, what);
}

/* Reads whole; false at the end of the file, or with errno set. */
static bool read_at(const debug_file *file, uint64_t byte, void *target, size_t size) {
    errno = 0;
    return file_read_at(file->file, target, size, byte) == (ssize_t)size;
}

static tulle_status fail_read(const debug_file *file, uint64_t byte, tulle_error *error,
                              const char *what) {
    return errno ? file_fail(error, file->path, errno, "cannot be read")
                 : fail_at(file, byte, error, what);
}

tulle_status debug_file_open(debug_file *file, memory *heap, const char *directory,
                             tulle_error *error) {
    *file = (debug_file){.heap = heap, .next = DEBUG_HEAD_SIZE};
    run_join(file->path, directory, RUN_FILE_DEBUG);
    file->file = open(file->path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (file->file < 0) return file_fail(error, file->path, errno, "cannot be opened");
    struct stat facts;
    char head[DEBUG_HEAD_SIZE];
    tulle_status status = TULLE_OK;
    if (fstat(file->file, &facts) != 0)
        status = file_fail(error, file->path, errno, "cannot be examined");
    else if (!S_ISREG(facts.st_mode))
        status = error_set_at(error, TULLE_ERROR_IO, file->path, 0, 0, "is not a regular file");
    else if (!read_at(file, 0, head, sizeof head))
        status = fail_read(file, 0, error, "the file ends within its head");
    else if (memcmp(head, DEBUG_MAGIC, 8) != 0)
        status = fail_at(file, 0, error, "this does not hold debug records of a run");
    else if (bytes_load(head + 8, 8) != DEBUG_VERSION)
        status = fail_at(file, 8, error, "another version; only version 1 can be read");
    if (status) debug_file_close(file);
    return status;
}

void debug_file_close(debug_file *file) {
    if (file->file >= 0) close(file->file);
    file->file = -1;
    if (file->heap) ARRAY_FREE(file->heap, &file->begins);
}

/* Reads and checks the header at `begin` of the block of `frame`. */
static tulle_status read_header(const debug_file *file, uint64_t begin, uint32_t frame,
                                unsigned char header[DEBUG_HEADER_SIZE], tulle_error *error) {
    if (!read_at(file, begin, header, DEBUG_HEADER_SIZE))
        return fail_read(file, begin, error, "the file ends before the block of this frame");
    bool const is_sound = memcmp(header, DEBUG_BLOCK_MAGIC, 4) == 0 &&
                          bytes_load(header + DEBUG_PLACE_HEADER_HASH, 8) ==
                              hash_bytes(HASH_SEED, header, DEBUG_PLACE_HEADER_HASH);
    if (!is_sound) return fail_at(file, begin, error, "the block's header was changed");
    if (bytes_load(header + DEBUG_PLACE_FRAME, 4) != frame)
        return fail_at(file, begin + DEBUG_PLACE_FRAME, error,
                       "this is the block of another frame");
    struct stat facts;
    if (fstat(file->file, &facts) != 0)
        return file_fail(error, file->path, errno, "cannot be examined");
    uint64_t const size = bytes_load(header + DEBUG_PLACE_SIZE, 8);
    if (size < DEBUG_HEADER_SIZE || size > (uint64_t)facts.st_size - begin)
        return fail_at(file, begin + DEBUG_PLACE_SIZE, error, "the file ends within this block");
    return TULLE_OK;
}

tulle_status debug_file_walk(debug_file *file, uint32_t frame_count, tulle_error *error) {
    while (file->begins.count < frame_count) {
        unsigned char header[DEBUG_HEADER_SIZE];
        uint32_t const frame = (uint32_t)file->begins.count;
        tulle_status const status = read_header(file, file->next, frame, header, error);
        if (status) return status;
        if (!ARRAY_RESERVE(file->heap, &file->begins, 1))
            return file_fail(error, file->path, ENOMEM, "cannot be read");
        file->begins.data[file->begins.count++] = file->next;
        file->next += bytes_load(header + DEBUG_PLACE_SIZE, 8);
    }
    return TULLE_OK;
}

/* ---- one block ---- */

/* Walks over the payload in memory. */
typedef struct payload {
    const debug_file *file;
    const unsigned char *bytes;
    size_t used, size;
    uint64_t begin; /* [bytes] of the payload in the file */
    arena *scratch;
    tulle_error *error;
} payload;

static tulle_status fail_payload(const payload *from, const char *what) {
    return fail_at(from->file, from->begin + from->used, from->error, what);
}

static tulle_status fail_memory(const payload *from) {
    return file_fail(from->error, from->file->path, ENOMEM, "cannot be read");
}

/* The next count * size bytes, or null when the block has not so many. */
static const unsigned char *take(payload *from, size_t count, size_t size) {
    if (count > (from->size - from->used) / size) return NULL;
    const unsigned char *const taken = from->bytes + from->used;
    from->used += count * size;
    return taken;
}

/* False when one is not finite. */
static bool load_floats(const unsigned char *bytes, size_t count, double *values) {
    bool are_finite = true;
    for (size_t i = 0; i < count; i++) {
        values[i] = (double)bytes_to_float(bytes_load(bytes + 4 * i, 4));
        are_finite = are_finite && isfinite(values[i]);
    }
    return are_finite;
}

static tulle_status read_velocities(payload *from, const run_record *record,
                                    const double **velocities) {
    for (size_t i = 0; i < record->bodies.count; i++) {
        velocities[i] = NULL;
        if (record->bodies.data[i].is_static) continue;
        size_t const count = 3 * (size_t)record->bodies.data[i].vertex_count;
        const unsigned char *const bytes = take(from, count, sizeof(float));
        if (!bytes) return fail_payload(from, "the block ends within velocities");
        double *const values = ARENA_NEW(from->scratch, double, count);
        if (!values) return fail_memory(from);
        if (!load_floats(bytes, count, values))
            return fail_payload(from, "a velocity before this byte is not finite");
        velocities[i] = values;
    }
    return TULLE_OK;
}

static bool decode_contact(const unsigned char *at, const run_record *record,
                           tulle_contact *contact) {
    uint32_t whole[7];
    double reals[14];
    for (size_t k = 0; k < 7; k++) whole[k] = (uint32_t)bytes_load(at + 4 * k, 4);
    bool const are_finite = load_floats(at + 28, 14, reals);
    uint32_t const flags = whole[6];
    *contact = (tulle_contact){
        .object_a = whole[0],
        .object_b = whole[1],
        .kind = flags & DEBUG_FLAG_EDGES ? TULLE_CONTACT_EDGE_EDGE : TULLE_CONTACT_VERTEX_FACE,
        .state = (tulle_contact_state)(flags >> DEBUG_STATE_SHIFT & DEBUG_STATE_MASK),
        .is_new = (flags & DEBUG_FLAG_NEW) != 0,
        .is_hard = (flags & DEBUG_FLAG_HARD) != 0,
        .gap = reals[10]};
    memcpy(contact->vertices, whole + 2, sizeof contact->vertices);
    memcpy(contact->weights, reals, sizeof contact->weights);
    memcpy(contact->position, reals + 4, sizeof contact->position);
    memcpy(contact->normal, reals + 7, sizeof contact->normal);
    memcpy(contact->impulse, reals + 11, sizeof contact->impulse);
    return are_finite && flags < DEBUG_FLAGS_END && debug_contact_fits(contact, record);
}

static tulle_status read_contacts(payload *from, const run_record *record, size_t count,
                                  const tulle_contact **contacts) {
    size_t const begin = from->used;
    const unsigned char *const bytes = take(from, count, DEBUG_CONTACT_SIZE);
    if (!bytes) return fail_payload(from, "the block ends within contacts");
    tulle_contact *const read = ARENA_NEW(from->scratch, tulle_contact, count);
    if (!read) return fail_memory(from);
    for (size_t i = 0; i < count; i++) {
        if (decode_contact(bytes + i * DEBUG_CONTACT_SIZE, record, &read[i])) continue;
        from->used = begin + i * DEBUG_CONTACT_SIZE;
        return fail_payload(from, "this contact names bodies that the run lacks, or is not finite");
    }
    *contacts = read;
    return TULLE_OK;
}

static tulle_status read_labels(payload *from, const run_record *record, const uint32_t **labels,
                                uint32_t *patch_counts) {
    for (size_t i = 0; i < record->bodies.count; i++) {
        labels[i] = NULL;
        patch_counts[i] = 0;
        if (record->bodies.data[i].is_obstacle) continue;
        size_t const count = record->bodies.data[i].triangle_count;
        const unsigned char *const head = take(from, 1, 4);
        if (!head) return fail_payload(from, "the block ends before patch labels");
        patch_counts[i] = (uint32_t)bytes_load(head, 4);
        size_t const size = debug_label_size(patch_counts[i]);
        const unsigned char *const bytes = take(from, count, size);
        if (!bytes) return fail_payload(from, "the block ends within patch labels");
        uint32_t *const read = ARENA_NEW(from->scratch, uint32_t, count);
        if (!read) return fail_memory(from);
        for (size_t k = 0; k < count; k++) {
            read[k] = (uint32_t)bytes_load(bytes + k * size, size);
            if (read[k] > patch_counts[i])
                return fail_payload(from, "a label before this byte names no patch");
        }
        labels[i] = read;
    }
    return TULLE_OK;
}

static tulle_status decode_payload(payload *from, const run_record *record, size_t contact_count,
                                   const tulle_run_debug **debug) {
    size_t const body_count = record->bodies.count;
    tulle_run_debug *const read = ARENA_NEW(from->scratch, tulle_run_debug, 1);
    const double **const velocities = ARENA_NEW(from->scratch, const double *, body_count);
    const uint32_t **const labels = ARENA_NEW(from->scratch, const uint32_t *, body_count);
    uint32_t *const patch_counts = ARENA_NEW(from->scratch, uint32_t, body_count);
    if (!read || !velocities || !labels || !patch_counts) return fail_memory(from);
    *read = (tulle_run_debug){.velocities = velocities,
                              .contact_count = contact_count,
                              .patch_labels = labels,
                              .patch_counts = patch_counts};
    tulle_status status = read_velocities(from, record, velocities);
    bool const is_all = record->kept == RUN_KEEPS_DEBUG;
    if (!is_all) read->patch_labels = NULL, read->patch_counts = NULL;
    if (!status && is_all) status = read_contacts(from, record, contact_count, &read->contacts);
    if (!status && is_all) status = read_labels(from, record, labels, patch_counts);
    if (!status && from->used < from->size)
        status = fail_payload(from, "the block is longer than its contents");
    if (!status) *debug = read;
    return status;
}

tulle_status debug_file_read(debug_file *file, const run_record *record, uint32_t frame,
                             arena *scratch, const tulle_run_debug **debug, tulle_error *error) {
    *debug = NULL;
    tulle_status status = debug_file_walk(file, frame + 1, error);
    if (status) return status;
    unsigned char header[DEBUG_HEADER_SIZE];
    uint64_t const begin = file->begins.data[frame];
    status = read_header(file, begin, frame, header, error);
    if (status) return status;
    payload from = {.file = file,
                    .size = (size_t)bytes_load(header + DEBUG_PLACE_SIZE, 8) - DEBUG_HEADER_SIZE,
                    .begin = begin + DEBUG_HEADER_SIZE,
                    .scratch = scratch,
                    .error = error};
    unsigned char *const bytes = ARENA_NEW(scratch, unsigned char, from.size);
    if (!bytes) return fail_memory(&from);
    from.bytes = bytes;
    if (!read_at(file, from.begin, bytes, from.size))
        return fail_read(file, from.begin, error, "the file ends within this block");
    if (hash_bytes(HASH_SEED, bytes, from.size) != bytes_load(header + DEBUG_PLACE_PAYLOAD_HASH, 8))
        return fail_at(file, from.begin, error, "the block was changed after it was written");
    uint64_t const known = bytes_load(header + DEBUG_PLACE_KNOWN, 4);
    size_t const contact_count = (size_t)bytes_load(header + DEBUG_PLACE_CONTACTS, 4);
    if (known == 0 && from.size == 0) return TULLE_OK;
    bool const is_all = record->kept == RUN_KEEPS_DEBUG;
    if (known != (is_all ? 1u : 2u) || (!is_all && contact_count > 0))
        return fail_at(file, begin + DEBUG_PLACE_KNOWN, error,
                       "the block keeps something else than run.json says");
    return decode_payload(&from, record, contact_count, debug);
}
