/* io/vtk/vtp_values.c - see vtp_values.h. */
#include "io/vtk/vtp_values.h"

#include "base/error.h"
#include "io/text/number.h"
#include "io/vtk/vtp_bytes.h"

#include <math.h>
#include <string.h>

static const size_t type_sizes[VTP_TYPE_COUNT] = {1, 1, 2, 2, 4, 4, 8, 8, 4, 8};

enum {
    VALUE_SIZE = 8, /* [bytes] of a value once decoded */
    SHOWN_SIZE = 20 /* [bytes] that a message shows of a word */
};

/* An array being decoded, to doubles or to whole numbers. */
typedef struct value_reader {
    vtp_document *document;
    const vtp_array *array;
    const char *name;
    uint64_t count;
    bool is_double;
    double *doubles;   /* of the result, if is_double */
    uint64_t *indices; /* otherwise */
    tulle_error *error;
} value_reader;

#define FAIL(reader, ...)                                                                          \
    vtp_fail((reader)->document, (reader)->array, (reader)->name, (reader)->error, __VA_ARGS__)

static tulle_status store_double(value_reader *reader, uint64_t index, double value) {
    if (!isfinite(value))
        return FAIL(reader, "value %llu is not a finite number", (unsigned long long)index);
    reader->doubles[index] = value;
    return TULLE_OK;
}

static tulle_status store_index(value_reader *reader, uint64_t index, int64_t value) {
    if (value < 0)
        return FAIL(reader, "value %llu is %lld, but should be 0 or more",
                    (unsigned long long)index, (long long)value);
    reader->indices[index] = (uint64_t)value;
    return TULLE_OK;
}

/* ---- text ---- */

static const char blanks[] = " \t\r\n";

/* The text ends with a zero. */
static tulle_status read_text(value_reader *reader, const char *text) {
    const char *at = text + strspn(text, blanks);
    for (uint64_t i = 0; i < reader->count; i++) {
        size_t const length = strcspn(at, blanks);
        if (length == 0)
            return FAIL(reader, "has %llu values, should have %llu", (unsigned long long)i,
                        (unsigned long long)reader->count);
        double real = 0.0;
        int64_t whole = 0;
        number_outcome const outcome = reader->is_double ? number_parse_double(at, length, &real)
                                                         : number_parse_integer(at, length, &whole);
        if (outcome != NUMBER_READ)
            return FAIL(reader, "value %llu is \"%.*s\", not %s", (unsigned long long)i,
                        (int)(length < SHOWN_SIZE ? length : SHOWN_SIZE), at,
                        reader->is_double ? "a finite number" : "a whole number");
        tulle_status const status =
            reader->is_double ? store_double(reader, i, real) : store_index(reader, i, whole);
        if (status != TULLE_OK) return status;
        at += length;
        at += strspn(at, blanks);
    }
    if (*at == '\0') return TULLE_OK;
    return FAIL(reader, "has more than its %llu values", (unsigned long long)reader->count);
}

static tulle_status decode_text(value_reader *reader) {
    memory *const heap = &reader->document->heap;
    const vtp_text *const text = &reader->array->text;
    char *const copy = memory_allocate(heap, text->count + 1);
    if (!copy) return vtp_fail_memory(reader->document, reader->array, reader->name, reader->error);
    if (text->count > 0) memcpy(copy, text->data, text->count);
    copy[text->count] = '\0';
    tulle_status const status = read_text(reader, copy);
    memory_release(heap, copy, text->count + 1);
    return status;
}

/* ---- bytes ---- */

static double to_double(vtp_type type, uint64_t bits) {
    if (type == VTP_FLOAT32) {
        uint32_t const word = (uint32_t)bits;
        float value;
        memcpy(&value, &word, sizeof value);
        return (double)value;
    }
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

/* Negative numbers and those that int64 cannot hold become negative. */
static int64_t to_integer(vtp_type type, uint64_t bits) {
    switch (type) {
    case VTP_INT8: return (int8_t)bits;
    case VTP_INT16: return (int16_t)bits;
    case VTP_INT32: return (int32_t)bits;
    default: return (int64_t)bits;
    }
}

static tulle_status decode_bytes(value_reader *reader) {
    vtp_type const type = reader->array->type;
    size_t const size = type_sizes[type];
    bool const is_real = type == VTP_FLOAT32 || type == VTP_FLOAT64;
    uint64_t const byte_count = reader->count * size;
    unsigned char *bytes = NULL;
    tulle_status status = vtp_read_bytes(reader->document, reader->array, reader->name, byte_count,
                                         &bytes, reader->error);
    for (uint64_t i = 0; i < reader->count && status == TULLE_OK; i++) {
        uint64_t const bits = vtp_load_number(reader->document, bytes + i * size, size);
        if (!reader->is_double)
            status = store_index(reader, i, to_integer(type, bits));
        else
            status = store_double(reader, i,
                                  is_real ? to_double(type, bits) : (double)to_integer(type, bits));
    }
    memory_release(&reader->document->heap, bytes, bytes ? (size_t)byte_count : 0);
    return status;
}

/* ---- both ---- */

/* Before memory is taken: could the file hold so many values at all? */
static tulle_status check_count(const value_reader *reader) {
    const vtp_array *const array = reader->array;
    uint64_t const size = reader->document->byte_count;
    /* A value takes at least a letter and a blank, or a byte; zlib may make many values of a byte.
     */
    uint64_t const most = array->format == VTP_ASCII ? array->text.count / 2 + 1
                          : reader->document->is_compressed
                              ? size * (VTP_EXPANSION_LIMIT / VALUE_SIZE)
                              : size;
    if (reader->count <= most) return TULLE_OK;
    return FAIL(reader, "should have %llu values, but the file has room for %llu at most",
                (unsigned long long)reader->count, (unsigned long long)most);
}

/* The decoded values, VALUE_SIZE bytes each. */
static tulle_status decode(value_reader *reader, void **values) {
    vtp_type const type = reader->array->type;
    if (!reader->is_double && (type == VTP_FLOAT32 || type == VTP_FLOAT64))
        return FAIL(reader, "holds Float32 or Float64, but should hold whole numbers");
    tulle_status status = check_count(reader);
    if (status != TULLE_OK) return status;
    memory *const heap = &reader->document->heap;
    size_t const byte_count = (size_t)reader->count * VALUE_SIZE;
    void *const made = memory_allocate(heap, byte_count);
    if (!made) return vtp_fail_memory(reader->document, reader->array, reader->name, reader->error);
    if (reader->is_double)
        reader->doubles = made;
    else
        reader->indices = made;
    status = reader->array->format == VTP_ASCII ? decode_text(reader) : decode_bytes(reader);
    if (status == TULLE_OK)
        *values = made;
    else
        memory_release(heap, made, byte_count);
    return status;
}

tulle_status vtp_decode_doubles(vtp_document *document, const vtp_array *array, const char *name,
                                uint64_t count, double **values, tulle_error *error) {
    value_reader reader = {.document = document,
                           .array = array,
                           .name = name,
                           .count = count,
                           .is_double = true,
                           .error = error};
    void *made = NULL;
    tulle_status const status = decode(&reader, &made);
    if (status == TULLE_OK) *values = made;
    return status;
}

tulle_status vtp_decode_indices(vtp_document *document, const vtp_array *array, const char *name,
                                uint64_t count, uint64_t **values, tulle_error *error) {
    value_reader reader = {
        .document = document, .array = array, .name = name, .count = count, .error = error};
    void *made = NULL;
    tulle_status const status = decode(&reader, &made);
    if (status == TULLE_OK) *values = made;
    return status;
}
