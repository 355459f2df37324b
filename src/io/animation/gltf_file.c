/* io/animation/gltf_file.c - see gltf_file.h.
 *
 * Based on: Khronos Group, glTF 2.0 Specification, 2021, sections 3.6 and 4.4. */
#define _POSIX_C_SOURCE 200809L
#include "io/animation/gltf_file.h"

#include "base/error.h"
#include "io/bytes.h"
#include "io/file_data.h"
#include "io/text/text_cursor.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

enum {
    CHUNK_SIZE = 1 << 14, /* [bytes] read at a time */
    STRIDE_MAX = 252,     /* [bytes] the standard's */
    GLB_HEADER_SIZE = 12,
    GLB_CHUNK_HEADER_SIZE = 8,
    PATH_SIZE = 4096
};
/* No file has more elements; sizes that come of it fit into 64 bits. */
#define COUNT_LIMIT (UINT64_C(1) << 40)

/* ---- members ---- */

const json_value *gltf_get_items(const gltf_file *file, const char *key, size_t *count) {
    const json_value *const array = json_find(&file->json, json_get_root(&file->json), key);
    *count = array && array->type == JSON_ARRAY ? array->count : 0;
    return *count > 0 ? json_get_first(&file->json, array) : NULL;
}

tulle_status gltf_find_number(const gltf_file *file, const json_value *object, const char *key,
                              uint64_t limit, uint32_t *number, tulle_error *error) {
    *number = GLTF_NONE;
    const json_value *const member = json_find(&file->json, object, key);
    if (!member) return TULLE_OK;
    uint64_t value = 0;
    tulle_status const status = json_take_count(&file->json, object, key, &value, error);
    if (status) return status;
    if (value >= limit || value >= GLTF_NONE)
        return json_fail(&file->json, member, error, "\"%s\" is %llu, but there are only %llu", key,
                         (unsigned long long)value, (unsigned long long)limit);
    *number = (uint32_t)value;
    return TULLE_OK;
}

tulle_status gltf_find_accessor(const gltf_file *file, const json_value *object, const char *key,
                                uint32_t width, uint32_t *number, tulle_error *error) {
    tulle_status const status =
        gltf_find_number(file, object, key, file->accessors.count, number, error);
    if (status || *number == GLTF_NONE) return status;
    const gltf_accessor *const accessor = &file->accessors.data[*number];
    if (accessor->numbers.width == width) return TULLE_OK;
    return json_fail(&file->json, accessor->place, error,
                     "the accessor of \"%s\" has elements of %u numbers, not %u", key,
                     accessor->numbers.width, width);
}

tulle_status gltf_find_values(const gltf_file *file, const json_value *object, const char *key,
                              size_t count, double *values, tulle_error *error) {
    const json_value *const array = json_find(&file->json, object, key);
    if (!array) return TULLE_OK;
    if (array->type != JSON_ARRAY || array->count != count)
        return json_fail(&file->json, array, error, "\"%s\" should be %zu numbers", key, count);
    const json_value *item = json_get_first(&file->json, array);
    for (size_t i = 0; i < count; i++, item = json_get_next(&file->json, item)) {
        if (item->type != JSON_NUMBER)
            return json_fail(&file->json, item, error, "\"%s\" should be %zu numbers", key, count);
        values[i] = item->number;
    }
    return TULLE_OK;
}

/* A count of bytes or elements; `fallback` where it is missing. */
static tulle_status take_size(const gltf_file *file, const json_value *object, const char *key,
                              uint64_t fallback, uint64_t *size, tulle_error *error) {
    *size = fallback;
    if (!json_find(&file->json, object, key)) return TULLE_OK;
    tulle_status const status = json_take_count(&file->json, object, key, size, error);
    if (status || *size < COUNT_LIMIT) return status;
    return json_fail(&file->json, object, error, "\"%s\" is too large", key);
}

/* ---- buffers ---- */

static int get_digit(char c) {
    if (c >= 'A' && c <= 'Z') return c - 'A';
    if (c >= 'a' && c <= 'z') return c - 'a' + 26;
    if (c >= '0' && c <= '9') return c - '0' + 52;
    return c == '+' || c == '-' ? 62 : c == '/' || c == '_' ? 63 : -1;
}

/* Decodes base64 in memory. */
static tulle_status open_data(gltf_file *file, const json_value *place, const char *text,
                              gltf_buffer *buffer, tulle_error *error) {
    size_t length = strlen(text);
    while (length > 0 && text[length - 1] == '=') length--;
    buffer->byte_count = length / 4 * 3 + (length % 4) * 3 / 4;
    buffer->bytes = memory_allocate(file->heap, buffer->byte_count);
    if (!buffer->bytes) return file_fail_memory(error, file->path);
    uint32_t bits = 0;
    size_t made = 0;
    for (size_t i = 0; i < length; i++) {
        int const digit = get_digit(text[i]);
        if (digit < 0) return json_fail(&file->json, place, error, "its data are not in base64");
        bits = bits << 6 | (uint32_t)digit;
        if (i % 4 > 0) buffer->bytes[made++] = (unsigned char)(bits >> (6 - 2 * (i % 4)));
    }
    buffer->size = made;
    return TULLE_OK;
}

/* Opens a regular file, once however often it is named. The source it is stays where it is until
 * the next one is opened. */
static tulle_status open_source(gltf_file *file, const char *path, const gltf_source **source,
                                tulle_error *error) {
    struct stat facts;
    if (stat(path, &facts) != 0) return file_fail(error, path, errno, "cannot be opened");
    for (size_t i = 0; i < file->sources.count; i++) {
        *source = &file->sources.data[i];
        if ((*source)->device == facts.st_dev && (*source)->node == facts.st_ino) return TULLE_OK;
    }
    if (!ARRAY_RESERVE(file->heap, &file->sources, 1)) return file_fail_memory(error, file->path);
    int const opened = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (opened < 0) return file_fail(error, path, errno, "cannot be opened");
    gltf_source *const made = &file->sources.data[file->sources.count++];
    made->file = opened;
    if (fstat(opened, &facts) != 0) return file_fail(error, path, errno, "cannot be examined");
    if (!S_ISREG(facts.st_mode))
        return error_set_at(error, TULLE_ERROR_IO, path, 0, 0, "is not a regular file");
    made->device = facts.st_dev;
    made->node = facts.st_ino;
    made->size = (uint64_t)facts.st_size;
    file->file_size += made->size;
    *source = made;
    return TULLE_OK;
}

static int get_hex(char c) {
    if (c >= '0' && c <= '9') return c - '0';
    c = (char)(c | 0x20);
    return c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1;
}

static bool leads_up(const char *path) {
    for (const char *at = path; (at = strstr(at, "..")) != NULL; at++)
        if ((at == path || at[-1] == '/') && (at[2] == '/' || at[2] == '\0')) return true;
    return false;
}

/* Whether a part of a path behind its first `begin` bytes is a symbolic link. */
static bool leads_through_link(char *path, size_t begin) {
    for (char *at = path + begin;; at++) {
        char const end = *at;
        if (end != '/' && end != '\0') continue;
        struct stat facts;
        *at = '\0';
        bool const is_link = lstat(path, &facts) == 0 && S_ISLNK(facts.st_mode);
        *at = end;
        if (is_link || end == '\0') return is_link;
    }
}

/* The path of a file beside the .gltf, whose name begins at *name_begin. False where the URI leads
 * elsewhere. */
static bool make_path(const gltf_file *file, const char *uri, char path[PATH_SIZE],
                      size_t *name_begin) {
    const char *const slash = strrchr(file->path, '/');
    size_t length = slash ? (size_t)(slash + 1 - file->path) : 0;
    if (length >= PATH_SIZE || *uri == '\0' || strchr(uri, ':')) return false;
    memcpy(path, file->path, length);
    char *const name = path + length;
    *name_begin = length;
    for (; *uri; uri++) {
        if (length + 1 >= PATH_SIZE) return false;
        path[length] = *uri;
        if (*uri == '%') {
            int const high = get_hex(uri[1]), low = high < 0 ? -1 : get_hex(uri[2]);
            if (low < 0 || (high == 0 && low == 0)) return false;
            path[length] = (char)(16 * high + low);
            uri += 2;
        }
        length++;
    }
    path[length] = '\0';
    return name[0] != '/' && !leads_up(name);
}

static tulle_status open_buffer(gltf_file *file, const json_value *item, gltf_buffer *buffer,
                                tulle_error *error) {
    const char *uri = NULL;
    char path[PATH_SIZE];
    tulle_status status = json_take_string(&file->json, item, "uri", &uri, error);
    if (status) return status;
    if (strncasecmp(uri, "data:", 5) == 0) {
        const char *const data = strstr(uri, ";base64,");
        return data ? open_data(file, item, data + 8, buffer, error)
                    : json_fail(&file->json, item, error, "its data are not in base64");
    }
    size_t name_begin = 0;
    if (!make_path(file, uri, path, &name_begin))
        return json_fail(&file->json, item, error,
                         "the buffer is not in the folder of the file, where it must be");
    if (leads_through_link(path, name_begin))
        return json_fail(&file->json, item, error,
                         "the buffer %.200s is reached through a symbolic link, which may lead "
                         "out of the folder of the file: put the buffer itself there",
                         path + name_begin);
    const gltf_source *source = NULL;
    status = open_source(file, path, &source, error);
    if (status) return status;
    buffer->file = source->file;
    buffer->size = source->size;
    return TULLE_OK;
}

/* binary: of a .glb, its bytes are those of the first buffer if that has no URI. */
static tulle_status read_buffers(gltf_file *file, const gltf_buffer *binary, tulle_error *error) {
    size_t count;
    const json_value *item = gltf_get_items(file, "buffers", &count);
    if (!ARRAY_RESERVE(file->heap, &file->buffers, count + 1))
        return file_fail_memory(error, file->path);
    for (size_t i = 0; i < count; i++, item = json_get_next(&file->json, item)) {
        gltf_buffer *const buffer = &file->buffers.data[file->buffers.count++];
        *buffer = (gltf_buffer){.file = -1};
        uint64_t size;
        bool const is_binary = i == 0 && binary->file >= 0 && !json_find(&file->json, item, "uri");
        tulle_status status = TULLE_OK;
        if (is_binary)
            *buffer = *binary;
        else
            status = open_buffer(file, item, buffer, error);
        if (status == TULLE_OK)
            status = take_size(file, item, "byteLength", buffer->size, &size, error);
        if (status) return status;
        if (size > buffer->size)
            return json_fail(&file->json, item, error,
                             "the buffer should be of %llu bytes, but %llu are there; it is cut "
                             "short",
                             (unsigned long long)size, (unsigned long long)buffer->size);
        buffer->size = size;
    }
    return TULLE_OK;
}

static tulle_status read_slices(gltf_file *file, tulle_error *error) {
    size_t count;
    const json_value *item = gltf_get_items(file, "bufferViews", &count);
    if (!ARRAY_RESERVE(file->heap, &file->slices, count + 1))
        return file_fail_memory(error, file->path);
    for (size_t i = 0; i < count; i++, item = json_get_next(&file->json, item)) {
        gltf_slice slice = {.place = item};
        tulle_status status =
            gltf_find_number(file, item, "buffer", file->buffers.count, &slice.buffer, error);
        if (status == TULLE_OK)
            status = take_size(file, item, "byteOffset", 0, &slice.offset, error);
        if (status == TULLE_OK) status = take_size(file, item, "byteLength", 0, &slice.size, error);
        if (status == TULLE_OK)
            status = take_size(file, item, "byteStride", 0, &slice.stride, error);
        if (status) return status;
        if (slice.buffer == GLTF_NONE || slice.stride > STRIDE_MAX ||
            slice.offset + slice.size > file->buffers.data[slice.buffer].size)
            return json_fail(&file->json, item, error,
                             "the buffer view reaches beyond its buffer, or has none");
        file->slices.data[file->slices.count++] = slice;
    }
    return TULLE_OK;
}

/* ---- accessors ---- */

/* [bytes] of a number; 0: no such type. */
static size_t get_size(uint32_t type) {
    switch (type) {
    case 5120:
    case 5121: return 1;
    case 5122:
    case 5123: return 2;
    case 5125:
    case 5126: return 4;
    default: return 0;
    }
}

static uint32_t find_width(const char *type) {
    static const char *const names[] = {"SCALAR", "VEC2", "VEC3", "VEC4", "MAT2", "MAT3", "MAT4"};
    static const uint32_t widths[] = {1, 2, 3, 4, 4, 9, 16};
    for (size_t i = 0; i < sizeof widths / sizeof widths[0]; i++)
        if (strcmp(type, names[i]) == 0) return widths[i];
    return 0;
}

static uint64_t get_stride(const gltf_file *file, const gltf_numbers *numbers) {
    uint64_t const stride = file->slices.data[numbers->slice].stride;
    return stride > 0 ? stride : get_size(numbers->type) * numbers->width;
}

/* Reads where `count` elements of `width` numbers are, and checks that they are there. */
static tulle_status take_numbers(gltf_file *file, const json_value *item, uint64_t count,
                                 gltf_numbers *numbers, tulle_error *error) {
    tulle_status status =
        gltf_find_number(file, item, "bufferView", file->slices.count, &numbers->slice, error);
    if (status == TULLE_OK)
        status = take_size(file, item, "byteOffset", 0, &numbers->offset, error);
    if (status) return status;
    if (get_size(numbers->type) == 0)
        return json_fail(&file->json, item, error,
                         "\"componentType\" is %u, which glTF does not have", numbers->type);
    if (numbers->slice == GLTF_NONE || count == 0) return TULLE_OK;
    uint64_t const size = get_size(numbers->type) * numbers->width;
    uint64_t const end = numbers->offset + (count - 1) * get_stride(file, numbers) + size;
    if (end > file->slices.data[numbers->slice].size)
        return json_fail(&file->json, item, error,
                         "%llu elements reach beyond the buffer view, which ends at byte %llu",
                         (unsigned long long)count,
                         (unsigned long long)file->slices.data[numbers->slice].size);
    return TULLE_OK;
}

static tulle_status take_sparse(gltf_file *file, const json_value *item, gltf_accessor *accessor,
                                tulle_error *error) {
    const json_value *const sparse = json_find(&file->json, item, "sparse");
    if (!sparse) return TULLE_OK;
    const json_value *indices, *values;
    accessor->sparse_indices.width = 1;
    tulle_status status =
        json_take_count(&file->json, sparse, "count", &accessor->sparse_count, error);
    if (status == TULLE_OK && accessor->sparse_count > accessor->count)
        status = json_fail(&file->json, sparse, error, "\"count\" is more than the elements");
    if (status == TULLE_OK)
        status = json_take_member(&file->json, sparse, "indices", JSON_OBJECT, &indices, error);
    if (status == TULLE_OK)
        status = json_take_member(&file->json, sparse, "values", JSON_OBJECT, &values, error);
    if (status == TULLE_OK)
        status = json_take_whole(&file->json, indices, "componentType",
                                 &accessor->sparse_indices.type, error);
    if (status == TULLE_OK)
        status =
            take_numbers(file, indices, accessor->sparse_count, &accessor->sparse_indices, error);
    accessor->sparse_values = accessor->numbers;
    if (status == TULLE_OK)
        status =
            take_numbers(file, values, accessor->sparse_count, &accessor->sparse_values, error);
    if (status == TULLE_OK &&
        (accessor->sparse_indices.slice == GLTF_NONE || accessor->sparse_values.slice == GLTF_NONE))
        status = json_fail(&file->json, sparse, error, "key \"bufferView\" is missing");
    return status;
}

static tulle_status read_accessors(gltf_file *file, tulle_error *error) {
    size_t count;
    const json_value *item = gltf_get_items(file, "accessors", &count);
    if (!ARRAY_RESERVE(file->heap, &file->accessors, count + 1))
        return file_fail_memory(error, file->path);
    for (size_t i = 0; i < count; i++, item = json_get_next(&file->json, item)) {
        gltf_accessor accessor = {.place = item};
        const char *type = NULL;
        tulle_status status = json_take_string(&file->json, item, "type", &type, error);
        if (status == TULLE_OK)
            status =
                json_take_whole(&file->json, item, "componentType", &accessor.numbers.type, error);
        if (status == TULLE_OK) status = take_size(file, item, "count", 0, &accessor.count, error);
        if (status) return status;
        const json_value *const normalized = json_find(&file->json, item, "normalized");
        accessor.numbers.is_normalized =
            normalized && normalized->type == JSON_BOOL && normalized->number != 0.0;
        accessor.numbers.width = find_width(type);
        if (accessor.numbers.width == 0)
            return json_fail(&file->json, item, error, "\"type\" is not a type of glTF");
        status = take_numbers(file, item, accessor.count, &accessor.numbers, error);
        if (status == TULLE_OK) status = take_sparse(file, item, &accessor, error);
        if (status) return status;
        file->accessors.data[file->accessors.count++] = accessor;
    }
    return TULLE_OK;
}

static double decode(const gltf_numbers *numbers, const unsigned char *bytes) {
    uint64_t const bits = bytes_load(bytes, get_size(numbers->type));
    double const scale = numbers->is_normalized ? 1.0 : 0.0;
    switch (numbers->type) {
    case 5120: return scale > 0.0 ? fmax((int8_t)bits / 127.0, -1.0) : (int8_t)bits;
    case 5121: return scale > 0.0 ? (double)bits / 255.0 : (double)bits;
    case 5122: return scale > 0.0 ? fmax((int16_t)bits / 32767.0, -1.0) : (int16_t)bits;
    case 5123: return scale > 0.0 ? (double)bits / 65535.0 : (double)bits;
    case 5125: return (double)bits;
    default: return (double)bytes_to_float(bits);
    }
}

static tulle_status read_bytes(gltf_file *file, const gltf_buffer *buffer, uint64_t offset,
                               size_t count, unsigned char *bytes, tulle_error *error) {
    if (buffer->file < 0) {
        memcpy(bytes, buffer->bytes + offset, count);
        return TULLE_OK;
    }
    ssize_t const got = file_read_at(buffer->file, bytes, count, buffer->offset + offset);
    if (got < 0) return file_fail(error, file->path, errno, "cannot be read");
    if ((size_t)got == count) return TULLE_OK;
    return error_set_at(error, TULLE_ERROR_PARSE, file->path, 0, 0,
                        "byte %llu of a buffer: it became shorter",
                        (unsigned long long)(offset + (uint64_t)got));
}

static tulle_status read_numbers(gltf_file *file, const gltf_numbers *numbers, uint64_t first,
                                 uint64_t count, double *values, tulle_error *error) {
    unsigned char chunk[CHUNK_SIZE];
    const gltf_slice *const slice = &file->slices.data[numbers->slice];
    size_t const number_size = get_size(numbers->type);
    uint32_t const width = numbers->width;
    uint64_t const stride = get_stride(file, numbers);
    uint64_t const at_once =
        CHUNK_SIZE / (stride > number_size * width ? stride : number_size * width);
    for (uint64_t done = 0; done < count; done += at_once) {
        uint64_t const part = count - done < at_once ? count - done : at_once;
        uint64_t const place = slice->offset + numbers->offset + (first + done) * stride;
        size_t const size = (size_t)((part - 1) * stride + number_size * width);
        tulle_status const status =
            read_bytes(file, &file->buffers.data[slice->buffer], place, size, chunk, error);
        if (status) return status;
        for (uint64_t i = 0; i < part; i++)
            for (uint32_t k = 0; k < width; k++) {
                size_t const at = (size_t)(i * stride + k * number_size);
                double const value = decode(numbers, chunk + at);
                if (!isfinite(value))
                    return error_set_at(error, TULLE_ERROR_PARSE, file->path, 0, 0,
                                        "byte %llu of buffer %u: the number is not finite",
                                        (unsigned long long)(place + at), slice->buffer);
                values[(done + i) * width + k] = value;
            }
    }
    return TULLE_OK;
}

/* Puts the sparse elements among those from `first` on in their places. */
static tulle_status read_sparse(gltf_file *file, const gltf_accessor *accessor, uint64_t first,
                                uint64_t count, double *values, tulle_error *error) {
    enum { AT_ONCE = 512 };
    double indices[AT_ONCE];
    for (uint64_t done = 0; done < accessor->sparse_count; done += AT_ONCE) {
        uint64_t const rest = accessor->sparse_count - done;
        uint64_t const part = rest < AT_ONCE ? rest : AT_ONCE;
        tulle_status status =
            read_numbers(file, &accessor->sparse_indices, done, part, indices, error);
        for (uint64_t i = 0; i < part && status == TULLE_OK; i++) {
            double const index = indices[i];
            if (!(index >= 0.0 && index < (double)accessor->count))
                return json_fail(&file->json, accessor->place, error,
                                 "sparse element %.0f is not there; there are %llu", index,
                                 (unsigned long long)accessor->count);
            if (index < (double)first || index >= (double)(first + count)) continue;
            status =
                read_numbers(file, &accessor->sparse_values, done + i, 1,
                             values + ((uint64_t)index - first) * accessor->numbers.width, error);
        }
        if (status) return status;
    }
    return TULLE_OK;
}

tulle_status gltf_read(gltf_file *file, uint32_t number, uint64_t first, uint64_t count,
                       double *values, tulle_error *error) {
    const gltf_accessor *const accessor = &file->accessors.data[number];
    tulle_status status = TULLE_OK;
    if (accessor->numbers.slice == GLTF_NONE)
        memset(values, 0, (size_t)(count * accessor->numbers.width) * sizeof *values);
    else
        status = read_numbers(file, &accessor->numbers, first, count, values, error);
    return status == TULLE_OK ? read_sparse(file, accessor, first, count, values, error) : status;
}

/* ---- the file ---- */

static tulle_status load_text(gltf_file *file, int source, uint64_t offset, uint64_t size,
                              tulle_error *error) {
    if (size > FILE_BYTE_LIMIT)
        return error_set_at(error, TULLE_ERROR_LIMIT, file->path, 0, 0, "is too large");
    file->text_size = (size_t)size;
    file->text = memory_allocate(file->heap, file->text_size);
    if (!file->text) return file_fail_memory(error, file->path);
    ssize_t const count = file_read_at(source, file->text, file->text_size, offset);
    if (count < 0) return file_fail(error, file->path, errno, "cannot be read");
    if ((size_t)count < file->text_size)
        return error_set_at(error, TULLE_ERROR_PARSE, file->path, 0, 0,
                            "byte %llu: the file ends within its JSON text",
                            (unsigned long long)offset + (unsigned long long)count);
    if (text_is_utf16(file->text, file->text_size))
        return error_set_at(error, TULLE_ERROR_UNSUPPORTED, file->path, 0, 0, TEXT_UTF16_MESSAGE);
    /* Some programs put a byte order mark before the text. */
    if (file->text_size >= 3 && memcmp(file->text, "\xef\xbb\xbf", 3) == 0)
        memset(file->text, ' ', 3);
    return json_read(file->heap, file->path, file->text, file->text_size, &file->json, error);
}

/* Finds the chunks of a .glb: the JSON text, and the bytes of the first buffer if there are any. */
static tulle_status read_chunks(gltf_file *file, int source, gltf_buffer *binary,
                                tulle_error *error) {
    unsigned char header[GLB_HEADER_SIZE + GLB_CHUNK_HEADER_SIZE] = {0};
    ssize_t const count = file_read_at(source, header, sizeof header, 0);
    if (count < 0) return file_fail(error, file->path, errno, "cannot be read");
    uint64_t const version = bytes_load(header + 4, 4), size = bytes_load(header + 8, 4);
    uint64_t const text_size = bytes_load(header + 12, 4);
    uint64_t const next = sizeof header + text_size;
    if ((size_t)count < sizeof header || size > file->file_size || next > size)
        return error_set_at(error, TULLE_ERROR_PARSE, file->path, 0, 0,
                            "byte 8: should be of %llu bytes with a JSON text of %llu, but has "
                            "%llu; it is cut short",
                            (unsigned long long)size, (unsigned long long)text_size,
                            (unsigned long long)file->file_size);
    if (version != 2 || memcmp(header + 16, "JSON", 4) != 0)
        return error_set_at(error, TULLE_ERROR_PARSE, file->path, 0, 0,
                            "byte 4: version %llu of glTF, or no JSON text behind; only version 2 "
                            "is known",
                            (unsigned long long)version);
    if (next + GLB_CHUNK_HEADER_SIZE <= size) {
        if (file_read_at(source, header, GLB_CHUNK_HEADER_SIZE, next) != GLB_CHUNK_HEADER_SIZE)
            return file_fail(error, file->path, errno, "cannot be read");
        binary->file = source;
        binary->offset = next + GLB_CHUNK_HEADER_SIZE;
        binary->size = bytes_load(header, 4);
        if (memcmp(header + 4, "BIN", 4) != 0) binary->file = -1;
        if (binary->offset + binary->size > size)
            return error_set_at(error, TULLE_ERROR_PARSE, file->path, 0, 0,
                                "byte %llu: %llu bytes should follow, but the file ends at %llu",
                                (unsigned long long)binary->offset,
                                (unsigned long long)binary->size, (unsigned long long)size);
    }
    return load_text(file, source, sizeof(unsigned char[GLB_HEADER_SIZE + GLB_CHUNK_HEADER_SIZE]),
                     text_size, error);
}

bool gltf_leaves_surfaces(const char *extension) {
    static const char *const beginnings[] = {
        "KHR_materials_", "KHR_texture_", "EXT_texture_", "MSFT_texture_",
        "KHR_lights_",    "EXT_lights_",  "KHR_xmp",      "KHR_mesh_quantization"};
    for (size_t i = 0; i < sizeof beginnings / sizeof beginnings[0]; i++)
        if (strncmp(extension, beginnings[i], strlen(beginnings[i])) == 0) return true;
    return false;
}

static tulle_status check_asset(const gltf_file *file, tulle_error *error) {
    const json_value *const root = json_get_root(&file->json), *asset = NULL;
    const char *version = NULL;
    if (root->type != JSON_OBJECT)
        return json_fail(&file->json, root, error, "the text should be an object");
    tulle_status status = json_take_member(&file->json, root, "asset", JSON_OBJECT, &asset, error);
    if (status == TULLE_OK)
        status = json_take_string(&file->json, asset, "version", &version, error);
    if (status) return status;
    if (strncmp(version, "2.", 2) != 0)
        return json_fail(&file->json, asset, error, "version \"%.20s\" of glTF is not known, 2 is",
                         version);
    const json_value *const needed = json_find(&file->json, root, "extensionsRequired");
    const json_value *item =
        needed && needed->type == JSON_ARRAY ? json_get_first(&file->json, needed) : NULL;
    while (item && item->type == JSON_STRING && gltf_leaves_surfaces(item->string))
        item = json_get_next(&file->json, item);
    if (!item) return TULLE_OK;
    const char *const name = item->type == JSON_STRING ? item->string : "?";
    json_fail(&file->json, needed, error, "needs the extension %.60s, which is not known here%s",
              name, strstr(name, "compression") ? "; export the file without compression" : "");
    if (error) error->status = TULLE_ERROR_UNSUPPORTED;
    return TULLE_ERROR_UNSUPPORTED;
}

tulle_status gltf_file_open(memory *heap, const char *path, gltf_file *file, tulle_error *error) {
    *file = (gltf_file){.heap = heap, .path = path};
    const gltf_source *opened = NULL;
    char magic[4] = {0};
    gltf_buffer binary = {.file = -1};
    tulle_status status = open_source(file, path, &opened, error);
    if (status == TULLE_OK) {
        int const source = opened->file;
        bool const is_binary = file_read_at(source, magic, sizeof magic, 0) == sizeof magic &&
                               memcmp(magic, "glTF", 4) == 0;
        status = is_binary ? read_chunks(file, source, &binary, error)
                           : load_text(file, source, 0, file->file_size, error);
    }
    if (status == TULLE_OK) status = check_asset(file, error);
    if (status == TULLE_OK) status = read_buffers(file, &binary, error);
    if (status == TULLE_OK) status = read_slices(file, error);
    if (status == TULLE_OK) status = read_accessors(file, error);
    return status;
}

void gltf_file_close(gltf_file *file) {
    for (size_t i = 0; i < file->sources.count; i++) close(file->sources.data[i].file);
    ARRAY_FREE(file->heap, &file->sources);
    for (size_t i = 0; i < file->buffers.count; i++) {
        gltf_buffer *const buffer = &file->buffers.data[i];
        memory_release(file->heap, buffer->bytes, buffer->byte_count);
    }
    memory_release(file->heap, file->text, file->text_size);
    if (file->json.heap) json_destroy(&file->json);
    ARRAY_FREE(file->heap, &file->buffers);
    ARRAY_FREE(file->heap, &file->slices);
    ARRAY_FREE(file->heap, &file->accessors);
    *file = (gltf_file){0};
}
