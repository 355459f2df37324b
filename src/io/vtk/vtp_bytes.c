/* io/vtk/vtp_bytes.c - see vtp_bytes.h.
 *
 * Uncompressed: the number of bytes, then the bytes. Compressed: number of blocks, size of a block,
 * size of the last one (0: whole), compressed size of each block, then the blocks. Base64 may be
 * one text or several texts with padding one after the other; header and data of compressed arrays
 * are two.
 *
 * Based on: Kitware, VTK file formats, the XML formats; RFC 4648 (base64); RFC 1950 (zlib). */
#include "io/vtk/vtp_bytes.h"

#include "base/error.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <zlib.h>

/* Bytes of one DEFLATE byte at most; more cannot be true. */
static const uint64_t ZLIB_RATIO_MAX = 1032;

/* Where bytes come from, in order. */
typedef struct byte_source {
    const unsigned char *at, *end; /* what is left, encoded */
    bool is_base64;
    unsigned char kept[3]; /* decoded, not taken yet */
    size_t kept_count;
    size_t bad_letter; /* not 0: offset + 1 of a letter that is not base64, from `begin` */
    const unsigned char *begin;
} byte_source;

/* What a binary array is read from. */
typedef struct bytes_reader {
    vtp_document *document;
    const vtp_array *array;
    const char *name;
    tulle_error *error;
    byte_source source;
} bytes_reader;

/* ---- messages ---- */

tulle_status vtp_fail(const vtp_document *document, const vtp_array *array, const char *name,
                      tulle_error *error, const char *format, ...) {
    char text[512];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    return error_set_at(error, TULLE_ERROR_PARSE, document->path, array->line, 0, "array %s: %s",
                        name, text);
}

tulle_status vtp_fail_memory(const vtp_document *document, const vtp_array *array, const char *name,
                             tulle_error *error) {
    return error_set_at(error, TULLE_ERROR_OUT_OF_MEMORY, document->path, array->line, 0,
                        "array %s: out of memory", name);
}

#define FAIL(reader, ...)                                                                          \
    vtp_fail((reader)->document, (reader)->array, (reader)->name, (reader)->error, __VA_ARGS__)

/* ---- encoded bytes ---- */

static int decode_letter(unsigned char letter) {
    if (letter >= 'A' && letter <= 'Z') return letter - 'A';
    if (letter >= 'a' && letter <= 'z') return letter - 'a' + 26;
    if (letter >= '0' && letter <= '9') return letter - '0' + 52;
    if (letter == '+') return 62;
    return letter == '/' ? 63 : -1;
}

static bool is_blank(unsigned char letter) {
    return letter == ' ' || letter == '\n' || letter == '\r' || letter == '\t';
}

/* Decodes the next four letters into `kept`. False at the end or at a letter that does not belong
 * there. */
static bool decode_quad(byte_source *source) {
    uint32_t bits = 0;
    size_t letters = 0, padding = 0;
    while (letters + padding < 4) {
        while (source->at < source->end && is_blank(*source->at)) source->at++;
        if (source->at == source->end) return false;
        int const value = decode_letter(*source->at);
        bool const is_padding = *source->at == '=' && letters >= 2;
        if (!is_padding && (value < 0 || padding > 0)) {
            source->bad_letter = (size_t)(source->at - source->begin) + 1;
            return false;
        }
        bits = bits << 6 | (is_padding ? 0 : (uint32_t)value);
        padding += is_padding;
        letters += !is_padding;
        source->at++;
    }
    for (size_t i = 0; i < 3; i++) source->kept[i] = (unsigned char)(bits >> (16 - 8 * i));
    source->kept_count = 3 - padding;
    return true;
}

/* Takes the next `count` bytes; how many there were. */
static size_t take_bytes(byte_source *source, unsigned char *bytes, size_t count) {
    if (!source->is_base64) {
        size_t const left = (size_t)(source->end - source->at);
        size_t const taken = count < left ? count : left;
        memcpy(bytes, source->at, taken);
        source->at += taken;
        return taken;
    }
    size_t taken = 0;
    while (taken < count) {
        if (source->kept_count == 0 && !decode_quad(source)) break;
        size_t const left = count - taken;
        size_t const step = source->kept_count < left ? source->kept_count : left;
        memcpy(bytes + taken, source->kept, step);
        memmove(source->kept, source->kept + step, source->kept_count - step);
        source->kept_count -= step;
        taken += step;
    }
    return taken;
}

/* No more than this can be left. */
static uint64_t bound_left(const byte_source *source) {
    uint64_t const left = (uint64_t)(source->end - source->at);
    return source->is_base64 ? left / 4 * 3 + 3 + source->kept_count : left;
}

static tulle_status fail_short(bytes_reader *reader, uint64_t wanted) {
    if (reader->source.bad_letter)
        return FAIL(reader, "letter %zu of its base64 text is not allowed there",
                    reader->source.bad_letter - 1);
    return FAIL(reader, "is cut short: %llu bytes should follow, at most %llu are left",
                (unsigned long long)wanted, (unsigned long long)bound_left(&reader->source));
}

static tulle_status take_exactly(bytes_reader *reader, unsigned char *bytes, size_t count) {
    if (count > bound_left(&reader->source)) return fail_short(reader, count);
    size_t const taken = take_bytes(&reader->source, bytes, count);
    return taken == count ? TULLE_OK : fail_short(reader, count - taken);
}

uint64_t vtp_load_number(const vtp_document *document, const unsigned char *bytes, size_t size) {
    uint64_t value = 0;
    for (size_t i = 0; i < size; i++)
        value = value << 8 | bytes[document->is_big_endian ? i : size - 1 - i];
    return value;
}

static tulle_status take_header(bytes_reader *reader, uint64_t *value) {
    unsigned char bytes[8];
    size_t const size = reader->document->header_size;
    tulle_status const status = take_exactly(reader, bytes, size);
    if (status == TULLE_OK) *value = vtp_load_number(reader->document, bytes, size);
    return status;
}

/* ---- zlib ---- */

typedef struct block_layout {
    uint64_t count, size, last_size; /* last_size: of the last block, 1 .. size */
    uint64_t *packed_sizes;
} block_layout;

/* The header's first three numbers; must come to byte_count. */
static tulle_status take_layout(bytes_reader *reader, uint64_t byte_count, block_layout *layout) {
    uint64_t last = 0;
    tulle_status status = take_header(reader, &layout->count);
    if (status == TULLE_OK) status = take_header(reader, &layout->size);
    if (status == TULLE_OK) status = take_header(reader, &last);
    if (status != TULLE_OK) return status;
    bool const is_possible = layout->count > 0 && layout->size > 0 && last <= layout->size &&
                             layout->count <= bound_left(&reader->source) &&
                             layout->size <= byte_count &&
                             layout->count - 1 <= byte_count / layout->size;
    layout->last_size = last > 0 ? last : layout->size;
    /* A file may hold one short block and call its size the block's. */
    if (layout->count == 1 && last > 0) layout->size = last;
    if ((is_possible || (layout->count == 1 && last == byte_count)) &&
        (layout->count - 1) * layout->size + layout->last_size == byte_count)
        return TULLE_OK;
    return FAIL(reader,
                "its header says %llu blocks of %llu bytes, the last of %llu; together they should "
                "be %llu bytes",
                (unsigned long long)layout->count, (unsigned long long)layout->size,
                (unsigned long long)last, (unsigned long long)byte_count);
}

static tulle_status unpack_block(bytes_reader *reader, uint64_t index, const block_layout *layout,
                                 unsigned char *target) {
    memory *const heap = &reader->document->heap;
    size_t const packed_size = (size_t)layout->packed_sizes[index];
    size_t const size = (size_t)(index + 1 < layout->count ? layout->size : layout->last_size);
    if (packed_size > bound_left(&reader->source)) return fail_short(reader, packed_size);
    unsigned char *const packed = memory_allocate(heap, packed_size);
    if (!packed)
        return vtp_fail_memory(reader->document, reader->array, reader->name, reader->error);
    tulle_status status = take_exactly(reader, packed, packed_size);
    uLongf found = (uLongf)size;
    if (status == TULLE_OK &&
        (uncompress(target, &found, packed, (uLong)packed_size) != Z_OK || found != size))
        status = FAIL(reader, "block %llu is damaged: zlib does not give its %zu bytes",
                      (unsigned long long)index, size);
    memory_release(heap, packed, packed_size);
    return status;
}

static tulle_status unpack_blocks(bytes_reader *reader, uint64_t byte_count, block_layout *layout,
                                  unsigned char *bytes) {
    uint64_t packed_total = 0;
    for (uint64_t i = 0; i < layout->count; i++) {
        tulle_status const status = take_header(reader, &layout->packed_sizes[i]);
        if (status != TULLE_OK) return status;
        if (layout->packed_sizes[i] > bound_left(&reader->source))
            return fail_short(reader, layout->packed_sizes[i]);
        packed_total += layout->packed_sizes[i];
    }
    if (packed_total > bound_left(&reader->source)) return fail_short(reader, packed_total);
    if (byte_count / ZLIB_RATIO_MAX > packed_total)
        return FAIL(reader, "%llu bytes cannot come from %llu", (unsigned long long)byte_count,
                    (unsigned long long)packed_total);
    /* Compressed, header and data are two texts. */
    reader->source.kept_count = 0;
    for (uint64_t i = 0; i < layout->count; i++) {
        tulle_status const status = unpack_block(reader, i, layout, bytes + i * layout->size);
        if (status != TULLE_OK) return status;
    }
    return TULLE_OK;
}

static tulle_status read_compressed(bytes_reader *reader, uint64_t byte_count,
                                    unsigned char *bytes) {
    block_layout layout = {0};
    tulle_status status = take_layout(reader, byte_count, &layout);
    if (status != TULLE_OK) return status;
    memory *const heap = &reader->document->heap;
    layout.packed_sizes = memory_allocate_zeroed(heap, (size_t)layout.count, sizeof(uint64_t));
    if (!layout.packed_sizes)
        return vtp_fail_memory(reader->document, reader->array, reader->name, reader->error);
    status = unpack_blocks(reader, byte_count, &layout, bytes);
    memory_release(heap, layout.packed_sizes, (size_t)layout.count * sizeof(uint64_t));
    return status;
}

static tulle_status read_plain(bytes_reader *reader, uint64_t byte_count, unsigned char *bytes) {
    uint64_t said = 0;
    tulle_status const status = take_header(reader, &said);
    if (status != TULLE_OK) return status;
    if (said != byte_count)
        return FAIL(reader, "its header says %llu bytes, but there should be %llu",
                    (unsigned long long)said, (unsigned long long)byte_count);
    return take_exactly(reader, bytes, (size_t)byte_count);
}

/* ---- the array ---- */

static tulle_status find_source(bytes_reader *reader) {
    const vtp_document *const document = reader->document;
    const vtp_array *const array = reader->array;
    byte_source *const source = &reader->source;
    const char *begin = array->text.data, *end = begin;
    source->is_base64 = true;
    if (array->format == VTP_APPENDED) {
        if (!document->has_appended)
            return FAIL(reader, "is appended, but the file has no appended data; is it cut short?");
        uint64_t const size = document->appended_end - document->appended_begin;
        if (array->offset > size)
            return FAIL(reader, "its offset is %llu, but %llu bytes are appended",
                        (unsigned long long)array->offset, (unsigned long long)size);
        begin = document->bytes + document->appended_begin + array->offset;
        end = document->bytes + document->appended_end;
        source->is_base64 = !document->is_appended_raw;
    } else if (array->text.count == 0) {
        return FAIL(reader, "is empty");
    } else {
        end += array->text.count;
    }
    source->begin = source->at = (const unsigned char *)begin;
    source->end = (const unsigned char *)end;
    return TULLE_OK;
}

tulle_status vtp_read_bytes(vtp_document *document, const vtp_array *array, const char *name,
                            uint64_t byte_count, unsigned char **bytes, tulle_error *error) {
    bytes_reader reader = {.document = document, .array = array, .name = name, .error = error};
    tulle_status status = find_source(&reader);
    if (status != TULLE_OK) return status;
    if (!document->is_compressed && byte_count > bound_left(&reader.source))
        return fail_short(&reader, byte_count);
    if (byte_count / VTP_EXPANSION_LIMIT > document->byte_count)
        return error_set_at(error, TULLE_ERROR_LIMIT, document->path, array->line, 0,
                            "array %s: expands to more than %llu times the size of the file", name,
                            (unsigned long long)VTP_EXPANSION_LIMIT);
    unsigned char *const made = memory_allocate(&document->heap, (size_t)byte_count);
    if (!made) return vtp_fail_memory(document, array, name, error);
    status = document->is_compressed ? read_compressed(&reader, byte_count, made)
                                     : read_plain(&reader, byte_count, made);
    if (status == TULLE_OK)
        *bytes = made;
    else
        memory_release(&document->heap, made, (size_t)byte_count);
    return status;
}
