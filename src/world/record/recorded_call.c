/* world/record/recorded_call.c - see recorded_call.h. Each visit_ function walks over one thing, in
 * one order, and writes or fills it by the stream's direction. What it fills is not trusted: it
 * goes through the same public calls that a host would make. */
#include "world/record/recorded_call.h"

#include "base/hash.h"
#include "tulle/bodies.h"
#include "world/fields/fields.h"

#include <string.h>

_Static_assert(offsetof(tulle_transform, centre) == RECORD_BODY_BYTES, "what a body begins with");
_Static_assert(sizeof(int) == 4 && sizeof(tulle_drive) == 4, "numbers of the format");

#define ANY RECORD_ANY_COUNT
#define RECORD_FACTS(kind, call, first, second) [RECORD_##kind] = {call, {first, second}},
const record_facts record_kinds[RECORD_KIND_COUNT] = {RECORD_KINDS(RECORD_FACTS)};

/* The defs of the kinds that have one. */
static const field_table *const record_defs[RECORD_KIND_COUNT] = {
    [RECORD_CREATE] = &world_def_fields,
    [RECORD_CLOTH] = &cloth_def_fields,
    [RECORD_OBSTACLE] = &obstacle_def_fields,
    [RECORD_CLOTH_CLOTH_LAW] = &contact_law_fields,
    [RECORD_CLOTH_OBSTACLE_LAW] = &contact_law_fields,
    [RECORD_OBSTACLE_OBSTACLE_LAW] = &contact_law_fields,
    [RECORD_MATERIAL_LAW] = &contact_law_fields,
    [RECORD_WIND] = &wind_fields,
    [RECORD_MATERIAL] = &material_fields,
    [RECORD_ATTACH] = &attachment_def_fields,
    [RECORD_DRIVE] = &body_drive_fields,
    [RECORD_ADD_CLOTH] = &cloth_def_fields,
    [RECORD_ADD_OBSTACLE] = &obstacle_def_fields,
    [RECORD_WATCH] = &event_watch_fields,
};

/* ---- numbers and arrays ---- */

void record_store(unsigned char *bytes, size_t byte_count, uint64_t value) {
    for (size_t i = 0; i < byte_count; i++) bytes[i] = (unsigned char)(value >> (8 * i));
}

uint64_t record_load(const unsigned char *bytes, size_t byte_count) {
    uint64_t value = 0;
    for (size_t i = 0; i < byte_count; i++) value |= (uint64_t)bytes[i] << (8 * i);
    return value;
}

static void fail(record_stream *stream, tulle_status status) {
    if (stream->status == TULLE_OK) stream->status = status;
}

/* `count` words of 1, 4 or 8 bytes each. */
static void visit_words(record_stream *stream, void *data, size_t count, size_t size) {
    unsigned char *words = data;
    if (stream->status != TULLE_OK) return;
    if (stream->is_reading) {
        if (count > (size_t)(stream->end - stream->at) / size) {
            fail(stream, TULLE_ERROR_PARSE);
            return;
        }
        for (size_t i = 0; i < count; i++, words += size, stream->at += size) {
            uint64_t const value = record_load(stream->at, size);
            uint32_t const half = (uint32_t)value;
            unsigned char const byte = (unsigned char)value;
            const void *const from = size == 8   ? (const void *)&value
                                     : size == 4 ? (const void *)&half
                                                 : &byte;
            memcpy(words, from, size);
        }
        return;
    }
    if (!ARRAY_RESERVE(stream->heap, &stream->bytes, count * size)) {
        fail(stream, TULLE_ERROR_OUT_OF_MEMORY);
        return;
    }
    unsigned char *to = stream->bytes.data + stream->bytes.count;
    for (size_t i = 0; i < count; i++, words += size, to += size) {
        uint64_t value = words[0];
        uint32_t half = 0;
        if (size == sizeof half) {
            memcpy(&half, words, sizeof half);
            value = half;
        } else if (size == sizeof value) {
            memcpy(&value, words, sizeof value);
        }
        record_store(to, size, value);
    }
    stream->bytes.count += count * size;
}

/* The most values that belong to a thing that is counted. */
enum { VALUES_MAX = 16 };

/* A count of things of which each takes a byte or more behind it. One that is read is so small that
 * no product with VALUES_MAX and a size of 8 bytes overflows. */
static void visit_count(record_stream *stream, size_t *count) {
    uint64_t word = *count;
    visit_words(stream, &word, 1, sizeof word);
    if (!stream->is_reading) return;
    if (word > (uint64_t)(stream->end - stream->at) ||
        word > SIZE_MAX / (VALUES_MAX * sizeof(double)))
        fail(stream, TULLE_ERROR_PARSE);
    *count = stream->status == TULLE_OK ? (size_t)word : 0;
}

/* An array of `count` words, or null. */
static void visit_array(record_stream *stream, const void **data, size_t count, size_t size) {
    unsigned char is_there = *data != NULL;
    visit_words(stream, &is_there, 1, 1);
    if (stream->status != TULLE_OK || is_there == 0) {
        if (stream->is_reading) *data = NULL;
        return;
    }
    if (!stream->is_reading) {
        visit_words(stream, (void *)(uintptr_t)*data, count, size);
        return;
    }
    *data = NULL;
    if (count > (size_t)(stream->end - stream->at) / size) {
        fail(stream, TULLE_ERROR_PARSE);
        return;
    }
    void *const made = arena_allocate(stream->scratch, count, size);
    if (!made) fail(stream, TULLE_ERROR_OUT_OF_MEMORY);
    visit_words(stream, made, count, size);
    *data = made;
}

/* A text with its final zero, or null. */
static void visit_text(record_stream *stream, const char **text) {
    size_t count = *text ? strlen(*text) + 1 : 0;
    const void *array = *text;
    visit_count(stream, &count);
    visit_array(stream, &array, count, 1);
    if (!stream->is_reading) return;
    *text = array;
    if (*text && (count == 0 || (*text)[count - 1] != '\0')) {
        fail(stream, TULLE_ERROR_PARSE);
        *text = NULL;
    }
}

/* ---- defs ---- */

static tulle_status give_no_frame(void *context, uint32_t frame, double *positions,
                                  tulle_error *error) {
    (void)context, (void)frame, (void)positions, (void)error;
    return TULLE_ERROR_UNSUPPORTED;
}

/* A number of 8 bytes on every machine. */
static void visit_size(record_stream *stream, size_t *number) {
    uint64_t word = *number;
    visit_words(stream, &word, 1, sizeof word);
    if (stream->is_reading) *number = word > SIZE_MAX ? SIZE_MAX : (size_t)word;
}

/* Whether there is a function. One that is read gives nothing. */
static void visit_function(record_stream *stream, tulle_frame_reader *function) {
    unsigned char is_there = *function != NULL;
    visit_words(stream, &is_there, 1, 1);
    if (stream->is_reading) *function = is_there ? give_no_frame : NULL;
}

/* The numbers of items of all arrays, which come before the arrays. */
static void visit_lengths(record_stream *stream, const field_table *table, char *def) {
    for (size_t r = 0; r < table->row_count; r++) {
        const field *const row = &table->rows[r];
        if (row->kind == FIELD_LENGTH) visit_count(stream, (size_t *)(void *)(def + row->offset));
        if (row->kind == FIELD_STRUCT && !row->is_array && !row->is_pointer)
            visit_lengths(stream, row->inner, def + row->offset);
    }
}

static void visit_values(record_stream *stream, const field_table *table, char *def);

/* An array of structs. */
static void visit_structs(record_stream *stream, const field *row, char *at, size_t count) {
    const void *array = NULL;
    size_t const size = row->inner->size;
    memcpy(&array, at, sizeof array);
    char *items = (char *)(uintptr_t)array;
    if (stream->is_reading) {
        items = count > 0 && stream->status == TULLE_OK
                    ? arena_allocate_zeroed(stream->scratch, count, size)
                    : NULL;
        if (!items && count > 0) fail(stream, TULLE_ERROR_OUT_OF_MEMORY);
        array = items;
        memcpy(at, &array, sizeof array);
    }
    for (size_t i = 0; items && i < count && stream->status == TULLE_OK; i++) {
        visit_lengths(stream, row->inner, items + i * size);
        visit_values(stream, row->inner, items + i * size);
    }
}

/* Everything but lengths. What is written is not changed. */
static void visit_values(record_stream *stream, const field_table *table, char *def) {
    if (stream->is_reading && table->cookie) memcpy(def, &table->cookie, sizeof table->cookie);
    for (size_t r = 0; r < table->row_count; r++) {
        const field *const row = &table->rows[r];
        char *const at = def + row->offset;
        size_t count = 0;
        if (row->is_array) memcpy(&count, def + row->length, sizeof count);
        if (row->kind == FIELD_TEXT) {
            visit_text(stream, (const char **)(void *)at);
        } else if (row->kind == FIELD_CALL) {
            visit_function(stream, (tulle_frame_reader *)(void *)at);
        } else if (row->is_pointer) {
            const void *inner = NULL;
            memcpy(&inner, at, sizeof inner);
            unsigned char is_there = inner != NULL;
            visit_words(stream, &is_there, 1, 1);
            visit_structs(stream, row, at, is_there != 0);
        } else if (row->kind == FIELD_STRUCT && row->is_array) {
            visit_structs(stream, row, at, count);
        } else if (row->kind == FIELD_STRUCT) {
            visit_values(stream, row->inner, at);
        } else if (row->is_array) {
            const void *array = NULL;
            memcpy(&array, at, sizeof array);
            visit_array(stream, &array, count * row->count, field_size(row));
            if (stream->is_reading) memcpy(at, &array, sizeof array);
        } else if (row->kind == FIELD_SIZE) {
            visit_size(stream, (size_t *)(void *)at);
        } else if (row->kind < FIELD_SIZE) {
            visit_words(stream, at, row->count, field_size(row));
        }
    }
}

/* ---- calls ---- */

static void visit_call(record_stream *stream, recorded_call *call) {
    visit_words(stream, call->ids, 2, sizeof call->ids[0]);
    visit_words(stream, call->generations, 2, sizeof call->generations[0]);
    visit_words(stream, call->numbers, 2, sizeof call->numbers[0]);
    for (int k = 0; k < 2; k++) {
        recorded_array *const array = &call->arrays[k];
        size_t const wanted = record_kinds[call->kind].counts[k];
        visit_count(stream, &array->count);
        const void *data = array->data;
        visit_array(stream, &data, array->count, sizeof(double));
        array->data = data;
        bool const fits = wanted == ANY ? array->count % 3 == 0 : array->count == wanted;
        if (array->data ? !fits : array->count > 0) fail(stream, TULLE_ERROR_PARSE);
    }
    bool const is_created = call->kind == RECORD_CREATE;
    if (is_created || call->kind == RECORD_MATERIAL_LAW)
        for (int k = 0; k < 2; k++) visit_text(stream, &call->texts[k]);
    if (is_created && call->numbers[0] != fields_version) fail(stream, TULLE_ERROR_UNSUPPORTED);
    const field_table *const table = record_defs[call->kind];
    if (table) {
        visit_lengths(stream, table, (char *)&call->def);
        visit_values(stream, table, (char *)&call->def);
    }
    if (call->kind == RECORD_LOAD || call->kind == RECORD_TARGETS) {
        visit_count(stream, &call->def.state.byte_count);
        visit_array(stream, &call->def.state.bytes, call->def.state.byte_count, 1);
    }
}

void record_seal(unsigned char *block, size_t byte_count) {
    size_t const payload = byte_count - RECORD_HEAD_BYTES - RECORD_HASH_BYTES;
    record_store(block, 8, payload);
    record_store(block + 12, 4, hash_block(block, 12));
    record_store(block + byte_count - RECORD_HASH_BYTES, 8,
                 hash_block(block + RECORD_HEAD_BYTES, payload));
}

tulle_status recorded_call_write(record_stream *stream, const recorded_call *call) {
    size_t const begin = stream->bytes.count;
    uint32_t head[4] = {0, 0, (uint32_t)call->kind, 0};
    uint64_t hash = 0;
    recorded_call copy = *call;
    visit_words(stream, head, 4, sizeof head[0]);
    visit_call(stream, &copy);
    visit_words(stream, &hash, 1, sizeof hash);
    if (stream->status == TULLE_OK)
        record_seal(stream->bytes.data + begin, stream->bytes.count - begin);
    return stream->status;
}

tulle_status recorded_call_read(record_stream *stream, recorded_call *call) {
    visit_call(stream, call);
    if (stream->at != stream->end) fail(stream, TULLE_ERROR_PARSE);
    return stream->status;
}
