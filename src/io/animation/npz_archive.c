/* io/animation/npz_archive.c - see npz_archive.h.
 *
 * Based on: PKWARE, .ZIP File Format Specification, version 6.3.3, sections 4.3 and 4.5; NumPy
 * Enhancement Proposal 1. */
#define _POSIX_C_SOURCE 200809L
#include "io/animation/npz_archive.h"

#include "base/error.h"
#include "io/bytes.h"
#include "io/file_data.h"

#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum {
    END_SIZE = 22,       /* [bytes] of the record at the end */
    COMMENT_MAX = 65535, /* [bytes] behind it */
    LOCATOR_SIZE = 20,   /* [bytes] of the record that leads to that of ZIP64 */
    END64_SIZE = 56,     /* [bytes] of the latter */
    ENTRY_SIZE = 46,     /* [bytes] of an entry of the directory without its name */
    LOCAL_SIZE = 30,     /* [bytes] of the head of a file, the same */
    HEAD_MAX = 1 << 14,  /* [bytes] of the head of an array */
    ENCRYPTED = 1,       /* a flag */
    STORED = 0,          /* methods */
    DEFLATED = 8
};

static tulle_status fail(const npz_archive *archive, uint64_t place, const char *text,
                         tulle_error *error) {
    return error_set_at(error, TULLE_ERROR_PARSE, archive->path, 0, 0, "byte %llu: %s",
                        (unsigned long long)place, text);
}

tulle_status npz_array_fail(const npz_archive *archive, const npz_array *array, tulle_error *error,
                            const char *format, ...) {
    char message[sizeof((tulle_error *)0)->message];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(message, sizeof message, format, arguments);
    va_end(arguments);
    return error_set_at(error, TULLE_ERROR_PARSE, archive->path, 0, 0, "%s: %.400s",
                        array->entry.name, message);
}

static tulle_status read_bytes(const npz_archive *archive, uint64_t place, size_t count,
                               unsigned char *bytes, tulle_error *error) {
    if (place > archive->size || count > archive->size - place)
        return fail(archive, place, "the archive ends too early: data is missing here", error);
    ssize_t const got = file_read_at(archive->file, bytes, count, place);
    if (got < 0) return file_fail(error, archive->path, errno, "cannot be read");
    if ((size_t)got < count) return fail(archive, place, "the archive became shorter", error);
    return TULLE_OK;
}

/* ---- the directory ---- */

/* Takes the directory's place from the record of ZIP64, where there is one. */
static tulle_status read_end64(npz_archive *archive, uint64_t end, tulle_error *error) {
    unsigned char bytes[END64_SIZE];
    if (end < LOCATOR_SIZE) return TULLE_OK;
    tulle_status status = read_bytes(archive, end - LOCATOR_SIZE, LOCATOR_SIZE, bytes, error);
    if (status || memcmp(bytes, "PK\6\7", 4) != 0) return status;
    uint64_t const place = bytes_load(bytes + 8, 8);
    status = read_bytes(archive, place, END64_SIZE, bytes, error);
    if (status) return status;
    if (memcmp(bytes, "PK\6\6", 4) != 0)
        return fail(archive, place, "the end record of ZIP64 should be here", error);
    archive->entry_count = bytes_load(bytes + 32, 8);
    archive->directory_size = bytes_load(bytes + 40, 8);
    archive->directory = bytes_load(bytes + 48, 8);
    return TULLE_OK;
}

/* Finds the record at the end, which a comment may follow. */
static tulle_status read_end(npz_archive *archive, tulle_error *error) {
    size_t const most = END_SIZE + COMMENT_MAX;
    size_t const size = archive->size < most ? (size_t)archive->size : most;
    unsigned char *const tail = memory_allocate(archive->heap, size);
    if (!tail) return file_fail_memory(error, archive->path);
    uint64_t const first = archive->size - size;
    tulle_status status = read_bytes(archive, first, size, tail, error);
    size_t at = size < END_SIZE ? 0 : size - END_SIZE + 1;
    bool is_found = false;
    while (status == TULLE_OK && at > 0 && !is_found) {
        at--;
        is_found = memcmp(tail + at, "PK\5\6", 4) == 0 &&
                   at + END_SIZE + bytes_load(tail + at + 20, 2) == size;
    }
    if (is_found) {
        archive->entry_count = bytes_load(tail + at + 10, 2);
        archive->directory_size = bytes_load(tail + at + 12, 4);
        archive->directory = bytes_load(tail + at + 16, 4);
    }
    memory_release(archive->heap, tail, size);
    if (status) return status;
    if (!is_found)
        return fail(
            archive, archive->size,
            "there is no end record of a ZIP archive; it is not an .npz file, or it is cut short",
            error);
    status = read_end64(archive, first + at, error);
    if (status) return status;
    if (archive->directory > archive->size ||
        archive->directory_size > archive->size - archive->directory)
        return fail(archive, first + at, "the directory reaches beyond the archive", error);
    return TULLE_OK;
}

tulle_status npz_archive_open(memory *heap, const char *path, npz_archive *archive,
                              tulle_error *error) {
    *archive = (npz_archive){.heap = heap, .path = path};
    struct stat facts;
    archive->file = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (archive->file < 0) return file_fail(error, path, errno, "cannot be opened");
    if (fstat(archive->file, &facts) != 0)
        return file_fail(error, path, errno, "cannot be examined");
    if (!S_ISREG(facts.st_mode))
        return error_set_at(error, TULLE_ERROR_IO, path, 0, 0, "is not a regular file");
    archive->size = (uint64_t)facts.st_size;
    return read_end(archive, error);
}

void npz_archive_close(npz_archive *archive) {
    if (archive->heap && archive->file >= 0) close(archive->file);
    *archive = (npz_archive){0};
}

/* Takes numbers that do not fit into 32 bits from the extra field of ZIP64, in their order. */
static bool read_extra(const unsigned char *extra, size_t size, uint64_t *const numbers[3]) {
    bool needs = false;
    for (int i = 0; i < 3; i++) needs = needs || *numbers[i] == UINT32_MAX;
    if (!needs) return true;
    for (size_t at = 0; at + 4 <= size;) {
        size_t const field_size = (size_t)bytes_load(extra + at + 2, 2);
        if (at + 4 + field_size > size) return false;
        if (bytes_load(extra + at, 2) == 1) {
            size_t used = 0;
            for (int i = 0; i < 3; i++) {
                if (*numbers[i] != UINT32_MAX) continue;
                if (used + 8 > field_size) return false;
                *numbers[i] = bytes_load(extra + at + 4 + used, 8);
                used += 8;
            }
            return true;
        }
        at += 4 + field_size;
    }
    return true; /* the number is just that one */
}

/* Reads an entry of the directory; goes on to the place of the one behind it. A name that is too
 * long is left empty. */
static tulle_status read_entry(const npz_archive *archive, uint64_t *next, npz_entry *entry,
                               tulle_error *error) {
    uint64_t const place = *next;
    unsigned char bytes[ENTRY_SIZE], extra[1 << 10];
    tulle_status status = read_bytes(archive, place, ENTRY_SIZE, bytes, error);
    if (status) return status;
    if (memcmp(bytes, "PK\1\2", 4) != 0)
        return fail(archive, place, "an entry of the directory should be here", error);
    size_t const name_size = (size_t)bytes_load(bytes + 28, 2);
    size_t const extra_size = (size_t)bytes_load(bytes + 30, 2);
    size_t const comment_size = (size_t)bytes_load(bytes + 32, 2);
    unsigned const method = (unsigned)bytes_load(bytes + 10, 2);
    *entry = (npz_entry){.sum = (uint32_t)bytes_load(bytes + 16, 4),
                         .packed_size = bytes_load(bytes + 20, 4),
                         .size = bytes_load(bytes + 24, 4),
                         .local = bytes_load(bytes + 42, 4),
                         .is_deflated = method == DEFLATED,
                         .is_unreadable = (bytes_load(bytes + 8, 2) & ENCRYPTED) ||
                                          (method != STORED && method != DEFLATED)};
    *next = place + ENTRY_SIZE + name_size + extra_size + comment_size;
    if (name_size >= NPZ_NAME_SIZE) return TULLE_OK;
    status =
        read_bytes(archive, place + ENTRY_SIZE, name_size, (unsigned char *)entry->name, error);
    if (status) return status;
    if (extra_size > sizeof extra)
        return fail(archive, place, "the entry's extra fields are too long", error);
    status = read_bytes(archive, place + ENTRY_SIZE + name_size, extra_size, extra, error);
    uint64_t *const numbers[3] = {&entry->size, &entry->packed_size, &entry->local};
    if (status == TULLE_OK && !read_extra(extra, extra_size, numbers))
        status = fail(archive, place, "the entry's field of ZIP64 is too short", error);
    return status;
}

/* Finds where the data of an entry are, behind a head of their own. */
static tulle_status find_data(const npz_archive *archive, npz_array *array, tulle_error *error) {
    uint64_t const local = array->entry.local;
    unsigned char bytes[LOCAL_SIZE];
    tulle_status const status = read_bytes(archive, local, LOCAL_SIZE, bytes, error);
    if (status) return status;
    if (memcmp(bytes, "PK\3\4", 4) != 0)
        return npz_array_fail(archive, array, error, "byte %llu: its head should be here",
                              (unsigned long long)local);
    npz_entry *const entry = &array->entry;
    entry->place = local + LOCAL_SIZE + bytes_load(bytes + 26, 2) + bytes_load(bytes + 28, 2);
    if (entry->place > archive->size || entry->packed_size > archive->size - entry->place)
        return npz_array_fail(archive, array, error,
                              "reaches beyond the archive, which is cut short");
    if (!entry->is_deflated && entry->size != entry->packed_size)
        return npz_array_fail(archive, array, error, "is stored, but in two sizes");
    return TULLE_OK;
}

/* ---- bytes of an entry ---- */

static void end_stream(npz_array *array) {
    if (array->is_streaming) inflateEnd(&array->stream);
    array->is_streaming = false;
}

static tulle_status begin_stream(npz_archive *archive, npz_array *array, tulle_error *error) {
    end_stream(array);
    array->stream = (z_stream){0};
    array->packed_done = array->unpacked_done = 0;
    if (inflateInit2(&array->stream, -MAX_WBITS) != Z_OK)
        return file_fail_memory(error, archive->path);
    array->is_streaming = true;
    return TULLE_OK;
}

/* Inflates the next bytes of the entry to the window. */
static tulle_status inflate_window(npz_archive *archive, npz_array *array, tulle_error *error) {
    z_stream *const stream = &array->stream;
    stream->next_out = array->window;
    stream->avail_out = NPZ_WINDOW_SIZE;
    array->window_offset = array->unpacked_done;
    int code = Z_OK;
    while (stream->avail_out > 0 && code == Z_OK) {
        if (stream->avail_in == 0) {
            uint64_t const rest = array->entry.packed_size - array->packed_done;
            size_t const count = rest < NPZ_WINDOW_SIZE ? (size_t)rest : NPZ_WINDOW_SIZE;
            tulle_status const status = read_bytes(archive, array->entry.place + array->packed_done,
                                                   count, array->packed, error);
            if (status) return status;
            array->packed_done += count;
            stream->next_in = array->packed;
            stream->avail_in = (uInt)count;
        }
        code = inflate(stream, Z_NO_FLUSH);
        if (code == Z_MEM_ERROR) return file_fail_memory(error, archive->path);
    }
    array->window_count = NPZ_WINDOW_SIZE - stream->avail_out;
    array->unpacked_done += array->window_count;
    if (code != Z_OK && code != Z_STREAM_END)
        return npz_array_fail(archive, array, error, "its compressed data are damaged at byte %llu",
                              (unsigned long long)array->unpacked_done);
    return TULLE_OK;
}

/* Brings the bytes at an offset into the window, as many as there are. */
static tulle_status fill_window(npz_archive *archive, npz_array *array, uint64_t offset,
                                tulle_error *error) {
    tulle_status status = TULLE_OK;
    if (!array->entry.is_deflated) {
        uint64_t const rest = array->entry.size - offset;
        array->window_offset = offset;
        array->window_count = rest < NPZ_WINDOW_SIZE ? (size_t)rest : NPZ_WINDOW_SIZE;
        return read_bytes(archive, array->entry.place + offset, array->window_count, array->window,
                          error);
    }
    if (!array->is_streaming || offset < array->window_offset) {
        status = begin_stream(archive, array, error);
        array->window_offset = array->window_count = 0;
    }
    while (status == TULLE_OK && offset >= array->window_offset + array->window_count) {
        status = inflate_window(archive, array, error);
        if (status == TULLE_OK && array->window_count == 0)
            status = npz_array_fail(archive, array, error, "its compressed data end at byte %llu",
                                    (unsigned long long)array->unpacked_done);
    }
    return status;
}

/* Reads bytes of the entry, which must have them. */
static tulle_status read_entry_bytes(npz_archive *archive, npz_array *array, uint64_t offset,
                                     size_t count, unsigned char *bytes, tulle_error *error) {
    while (count > 0) {
        bool const is_here =
            offset >= array->window_offset && offset < array->window_offset + array->window_count;
        tulle_status const status = is_here ? TULLE_OK : fill_window(archive, array, offset, error);
        if (status) return status;
        size_t const at = (size_t)(offset - array->window_offset);
        size_t const here = array->window_count - at, part = count < here ? count : here;
        memcpy(bytes, array->window + at, part);
        bytes += part;
        offset += part;
        count -= part;
    }
    return TULLE_OK;
}

/* Reads all once: the sum is right, and so is the size. */
static tulle_status check_sum(npz_archive *archive, npz_array *array, tulle_error *error) {
    uint32_t sum = 0;
    for (uint64_t done = 0; done < array->entry.size;) {
        tulle_status const status = fill_window(archive, array, done, error);
        if (status) return status;
        sum = (uint32_t)crc32_z(sum, array->window, array->window_count);
        done += array->window_count;
        if (done > array->entry.size)
            return npz_array_fail(archive, array, error,
                                  "its compressed data are of more bytes than the archive says");
    }
    if (sum == array->entry.sum) return TULLE_OK;
    return npz_array_fail(archive, array, error, "its checksum differs: the file is damaged");
}

/* ---- the head of an array ---- */

/* Finds the value of a key in the head, a dictionary as Python prints it; null: there is none. */
static const char *find_key(const char *head, const char *key) {
    size_t const length = strlen(key);
    for (const char *at = head; *at; at++) {
        if (*at != '\'' && *at != '"') continue;
        const char *const end = strchr(at + 1, *at);
        if (!end) return NULL;
        const char *after = end + 1 + strspn(end + 1, " ");
        if ((size_t)(end - at - 1) == length && strncmp(at + 1, key, length) == 0 && *after == ':')
            return after + 1 + strspn(after + 1, " ");
        at = end;
    }
    return NULL;
}

/* "<f8": byte order, kind, bytes. */
static bool read_type(const char *text, npz_array *array) {
    char const quote = text ? *text : '\0';
    if (quote != '\'' && quote != '"') return false;
    char const order = text[1];
    if (order == '\0' || !strchr("<>|=", order)) return false;
    array->kind = text[2];
    if (text[2] == '\0' || text[3] < '1' || text[3] > '8' || text[4] != quote) return false;
    array->width = (size_t)(text[3] - '0');
    array->is_big_endian = order == '>';
    if (array->kind == 'f') return array->width == 4 || array->width == 8;
    if (array->kind != 'i' && array->kind != 'u') return false;
    return array->width == 1 || array->width == 2 || array->width == 4 || array->width == 8;
}

/* "(3, 4)"; false for more dimensions than there are here, or numbers that are too large. */
static bool read_shape(const char *text, npz_array *array) {
    if (!text || *text != '(') return false;
    text++;
    for (array->dimension_count = 0;; array->dimension_count++) {
        text += strspn(text, " ");
        if (*text == ')') return true;
        if (array->dimension_count == NPZ_DIMENSION_MAX || *text < '0' || *text > '9') return false;
        uint64_t value = 0;
        for (; *text >= '0' && *text <= '9'; text++) {
            value = 10 * value + (uint64_t)(*text - '0');
            if (value > (UINT64_C(1) << 40)) return false;
        }
        array->shape[array->dimension_count] = value;
        text += *text == 'L';
        text += strspn(text, " ");
        if (*text == ',') text++;
    }
}

/* The bytes of all numbers must be those that are there. */
static bool fits(const npz_array *array) {
    uint64_t const there = array->entry.size - array->first;
    uint64_t needed = array->width;
    for (size_t i = 0; i < array->dimension_count; i++) {
        if (array->shape[i] > 0 && needed > UINT64_MAX / 2 / array->shape[i]) return false;
        needed *= array->shape[i];
    }
    return needed == there;
}

static tulle_status parse_head(npz_archive *archive, npz_array *array, const char *head,
                               tulle_error *error) {
    const char *const order = find_key(head, "fortran_order");
    if (!read_type(find_key(head, "descr"), array))
        return npz_array_fail(archive, array, error,
                              "key 'descr' should be a type of whole numbers of 1, 2, 4 or 8 "
                              "bytes, as '>i8', or of floating point numbers of 4 or 8, as '<f4'");
    if (!order || (strncmp(order, "True", 4) != 0 && strncmp(order, "False", 5) != 0))
        return npz_array_fail(archive, array, error, "key 'fortran_order' should be True or False");
    array->is_fortran = order[0] == 'T';
    if (!read_shape(find_key(head, "shape"), array))
        return npz_array_fail(archive, array, error,
                              "key 'shape' should be at most %d whole numbers in ( )",
                              NPZ_DIMENSION_MAX);
    if (fits(array)) return TULLE_OK;
    return npz_array_fail(archive, array, error,
                          "has %llu bytes of numbers, which are not what its shape and type need",
                          (unsigned long long)(array->entry.size - array->first));
}

static tulle_status read_head(npz_archive *archive, npz_array *array, tulle_error *error) {
    unsigned char begin[12] = {0};
    uint64_t const size = array->entry.size;
    if (size < sizeof begin)
        return npz_array_fail(archive, array, error, "is too short for an .npy file");
    tulle_status status = read_entry_bytes(archive, array, 0, sizeof begin, begin, error);
    if (status) return status;
    size_t const count_size = begin[6] == 1 ? 2 : 4;
    uint64_t const length = bytes_load(begin + 8, count_size);
    array->first = 8 + count_size + length;
    if (memcmp(begin, "\x93NUMPY", 6) != 0 || begin[6] < 1 || begin[6] > 3)
        return npz_array_fail(archive, array, error, "is not an .npy file of version 1, 2 or 3");
    if (array->first > size || length > HEAD_MAX)
        return npz_array_fail(archive, array, error, "its head of %llu bytes is too long",
                              (unsigned long long)length);
    char *const head = memory_allocate(archive->heap, (size_t)length + 1);
    if (!head) return file_fail_memory(error, archive->path);
    status = read_entry_bytes(archive, array, 8 + count_size, (size_t)length, (unsigned char *)head,
                              error);
    head[length] = '\0';
    if (status == TULLE_OK) status = parse_head(archive, array, head, error);
    memory_release(archive->heap, head, (size_t)length + 1);
    return status;
}

/* ---- arrays ---- */

tulle_status npz_array_open(npz_archive *archive, const char *name, npz_array *array,
                            bool *is_there, tulle_error *error) {
    char wanted[NPZ_NAME_SIZE];
    snprintf(wanted, sizeof wanted, "%s.npy", name);
    *array = (npz_array){0};
    *is_there = false;
    uint64_t place = archive->directory;
    uint64_t const end = archive->directory + archive->directory_size;
    for (uint64_t i = 0; i < archive->entry_count && place < end; i++) {
        npz_entry entry;
        tulle_status const status = read_entry(archive, &place, &entry, error);
        if (status) return status;
        if (strcmp(entry.name, wanted) != 0) continue;
        array->entry = entry;
        if (*is_there) return npz_array_fail(archive, array, error, "is there twice");
        *is_there = true;
    }
    if (!*is_there) return TULLE_OK;
    if (array->entry.is_unreadable)
        return npz_array_fail(archive, array, error,
                              "is encrypted, or compressed otherwise than deflated");
    array->window = memory_allocate(archive->heap, NPZ_WINDOW_SIZE);
    array->packed = memory_allocate(archive->heap, NPZ_WINDOW_SIZE);
    if (!array->window || !array->packed) return file_fail_memory(error, archive->path);
    tulle_status status = find_data(archive, array, error);
    if (status == TULLE_OK) status = check_sum(archive, array, error);
    return status == TULLE_OK ? read_head(archive, array, error) : status;
}

void npz_array_close(npz_archive *archive, npz_array *array) {
    end_stream(array);
    memory_release(archive->heap, array->window, array->window ? NPZ_WINDOW_SIZE : 0);
    memory_release(archive->heap, array->packed, array->packed ? NPZ_WINDOW_SIZE : 0);
    *array = (npz_array){0};
}

static double decode(const npz_array *array, uint64_t bits) {
    if (array->kind == 'f')
        return array->width == 4 ? (double)bytes_to_float(bits) : bytes_to_double(bits);
    if (array->kind == 'u') return (double)bits;
    switch (array->width) {
    case 1: return (double)(int8_t)bits;
    case 2: return (double)(int16_t)bits;
    case 4: return (double)(int32_t)bits;
    default: return (double)(int64_t)bits;
    }
}

tulle_status npz_array_read(npz_archive *archive, npz_array *array, const uint64_t *at,
                            double *value, tulle_error *error) {
    uint64_t index = 0;
    for (size_t i = 0; i < array->dimension_count; i++) {
        size_t const k = array->is_fortran ? array->dimension_count - 1 - i : i;
        index = index * array->shape[k] + at[k];
    }
    unsigned char bytes[8];
    tulle_status const status = read_entry_bytes(
        archive, array, array->first + index * array->width, array->width, bytes, error);
    if (status) return status;
    *value = decode(array, array->is_big_endian ? bytes_load_big_endian(bytes, array->width)
                                                : bytes_load(bytes, array->width));
    return TULLE_OK;
}
