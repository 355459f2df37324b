/* io/mesh/ply.c - reads PLY: text, binary little endian and big endian. Positions are x, y, z of
 * element `vertex` in any number type, its texture coordinates s, t (ply_header.c), polygons the
 * list vertex_indices (or vertex_index) of element `face` in any integer type; other elements and
 * properties are passed over.
 *
 * Before an element is read, its count is compared with what is left of the file, so a wrong header
 * costs neither time nor memory.
 *
 * Based on: G. Turk, The PLY polygon file format, 1994. */
#include "io/mesh/ply_header.h"

#include "base/error.h"
#include "io/bytes.h"
#include "io/mesh/mesh_builder.h"
#include "io/text/number.h"

#include <math.h>
#include <stdio.h>

typedef struct ply_reader {
    text_cursor text; /* in binary files only `at` and `end` move */
    const char *begin;
    ply_header header;
    mesh_builder builder;
    uint64_t vertex_count; /* as the header says */
    const ply_element *element;
    uint64_t index; /* of the element at hand among its kind */
} ply_reader;

/* An error at the value at hand: `place` within the line, or the byte offset. */
static tulle_status fail_value(const ply_reader *reader, const char *place, const char *what,
                               const char *problem, tulle_error *error) {
    const char *const name = reader->element->name;
    unsigned long long const index = reader->index;
    if (reader->header.format == PLY_TEXT)
        return text_fail(&reader->text, place, error, "%s %llu, %s: %s", name, index, what,
                         problem);
    return error_set_at(error, TULLE_ERROR_PARSE, reader->text.path, 0, 0,
                        "byte %zu: %s %llu, %s: %s", (size_t)(place - reader->begin), name, index,
                        what, problem);
}

/* ---- values ---- */

static double load_real(const ply_reader *reader, ply_type type, const char *bytes) {
    size_t const size = ply_type_size(type);
    uint64_t const bits = reader->header.format == PLY_BIG_ENDIAN
                              ? bytes_load_big_endian(bytes, size)
                              : bytes_load(bytes, size);
    switch (type) {
    case PLY_INT8: return (double)(int8_t)bits;
    case PLY_INT16: return (double)(int16_t)bits;
    case PLY_INT32: return (double)(int32_t)bits;
    case PLY_INT64: return (double)(int64_t)bits;
    case PLY_FLOAT: return (double)bytes_to_float(bits);
    case PLY_DOUBLE: return bytes_to_double(bits);
    default: return (double)bits;
    }
}

/* The next value, of any type; `place` tells where it is. */
static tulle_status take_real(ply_reader *reader, ply_type type, const char *what, double *value,
                              tulle_error *error) {
    if (reader->header.format == PLY_TEXT)
        return text_take_double(&reader->text, what, value, error);
    size_t const size = ply_type_size(type);
    if ((size_t)(reader->text.end - reader->text.at) < size)
        return fail_value(reader, reader->text.at, what, "the file ends here", error);
    *value = load_real(reader, type, reader->text.at);
    reader->text.at += size;
    return TULLE_OK;
}

/* The next value as a whole number below `limit`; at most 2^32 so that doubles hold it exactly. */
static tulle_status take_whole(ply_reader *reader, ply_type type, const ply_property *property,
                               uint64_t limit, uint32_t *value, tulle_error *error) {
    const char *const place = reader->text.at;
    double number = 0.0;
    tulle_status const status = take_real(reader, type, property->name, &number, error);
    if (status) return status;
    if (!(number >= 0.0 && number < (double)limit && number == floor(number))) {
        char problem[96];
        char text[NUMBER_TEXT_SIZE];
        number_format_double(number, text);
        snprintf(problem, sizeof problem, "%s should be a whole number from 0 to %llu", text,
                 (unsigned long long)(limit - (limit > 0)));
        return fail_value(reader, place, property->name, problem, error);
    }
    *value = (uint32_t)number;
    return TULLE_OK;
}

/* ---- elements ---- */

static tulle_status read_list(ply_reader *reader, const ply_property *property,
                              tulle_error *error) {
    size_t const left = (size_t)(reader->text.end - reader->text.at);
    uint64_t const most = left < UINT32_MAX ? left : UINT32_MAX;
    uint32_t count = 0;
    tulle_status status =
        take_whole(reader, property->count_type, property, most + 1, &count, error);
    if (!status && property->role == PLY_CORNERS && count < 3)
        return fail_value(reader, reader->text.at, property->name,
                          "a face needs at least 3 corners", error);
    mesh_builder_begin_polygon(&reader->builder);
    reader->builder.line =
        reader->header.format == PLY_TEXT ? (uint32_t)reader->text.line : (uint32_t)reader->index;
    for (uint32_t i = 0; i < count && !status; i++) {
        double passed_over;
        uint32_t vertex = 0;
        if (property->role != PLY_CORNERS && reader->header.format == PLY_TEXT) {
            if (text_take_word(&reader->text).length == 0)
                status = fail_value(reader, NULL, property->name, "is missing", error);
            continue;
        }
        if (property->role != PLY_CORNERS) {
            status = take_real(reader, property->type, property->name, &passed_over, error);
            continue;
        }
        status = take_whole(reader, property->type, property, reader->vertex_count, &vertex, error);
        if (!status && !mesh_builder_add_corner(&reader->builder, vertex, vertex))
            status = file_fail_memory(error, reader->text.path);
    }
    return status;
}

typedef struct ply_vertex {
    double position[3], uv[2];
} ply_vertex;

static tulle_status read_scalar(ply_reader *reader, const ply_property *property,
                                ply_vertex *vertex, tulle_error *error) {
    const char *const place = reader->text.at;
    bool const is_uv = property->role == PLY_S || property->role == PLY_T;
    double *const uv = is_uv ? &vertex->uv[property->role - PLY_S] : NULL;
    if ((is_uv || property->role == PLY_PASSED_OVER) && reader->header.format == PLY_TEXT) {
        text_word const word = text_take_word(&reader->text);
        if (word.length == 0) return fail_value(reader, NULL, property->name, "is missing", error);
        if (is_uv && number_parse_double(word.text, word.length, uv) != NUMBER_READ)
            *uv = (double)NAN;
        return TULLE_OK;
    }
    double value = 0.0;
    tulle_status const status = take_real(reader, property->type, property->name, &value, error);
    if (is_uv) *uv = value;
    if (status || is_uv || property->role == PLY_PASSED_OVER) return status;
    if (!isfinite(value))
        return fail_value(reader, place, property->name, "is not a finite number", error);
    vertex->position[property->role - PLY_X] = value;
    return TULLE_OK;
}

static tulle_status read_one(ply_reader *reader, tulle_error *error) {
    const ply_element *const element = reader->element;
    ply_vertex vertex = {.uv = {(double)NAN, (double)NAN}};
    for (size_t i = 0; i < element->property_count; i++) {
        const ply_property *const property =
            &reader->header.properties[element->first_property + i];
        tulle_status const status = property->is_list
                                        ? read_list(reader, property, error)
                                        : read_scalar(reader, property, &vertex, error);
        if (status) return status;
    }
    bool has_memory = true;
    if (element->is_vertex) has_memory = mesh_builder_add_vertex(&reader->builder, vertex.position);
    if (element->is_vertex && reader->builder.keeps_uvs)
        has_memory &= mesh_builder_add_uv(&reader->builder, vertex.uv[0], vertex.uv[1]);
    return has_memory ? TULLE_OK : file_fail_memory(error, reader->text.path);
}

/* Text: each element has a line of its own. */
static tulle_status read_text_line(ply_reader *reader, tulle_error *error) {
    if (!text_skip_blank_lines(&reader->text))
        return fail_value(reader, NULL, "line", "the file ends here", error);
    tulle_status const status = read_one(reader, error);
    if (status) return status;
    text_word const rest = text_take_word(&reader->text);
    if (rest.length > 0)
        return fail_value(reader, rest.text, "line",
                          "has more values than the properties of the header: add to it those that "
                          "it leaves out, each list as a list",
                          error);
    return TULLE_OK;
}

/* Least bytes that an element takes in the file. */
static uint64_t least_size(const ply_header *header, const ply_element *element) {
    uint64_t size = 0;
    for (size_t i = 0; i < element->property_count; i++) {
        const ply_property *const property = &header->properties[element->first_property + i];
        size += header->format == PLY_TEXT ? 2
                : property->is_list        ? ply_type_size(property->count_type)
                                           : ply_type_size(property->type);
    }
    return size;
}

/* Whether the count can be true; the last text line may lack its end. */
static tulle_status check_count(const ply_reader *reader, tulle_error *error) {
    const ply_element *const element = reader->element;
    uint64_t const left = (uint64_t)(reader->text.end - reader->text.at) + 1;
    uint64_t const size = least_size(&reader->header, element);
    if (element->count == 0 || element->count <= left / size) return TULLE_OK;
    return error_set_at(error, TULLE_ERROR_PARSE, reader->text.path, 0, 0,
                        "byte %zu: the header says %llu of element %s, which take at least %llu "
                        "bytes each, but only %llu bytes are left; the file is cut short",
                        (size_t)(reader->text.at - reader->begin),
                        (unsigned long long)element->count, element->name, (unsigned long long)size,
                        (unsigned long long)(left - 1));
}

static tulle_status read_element(ply_reader *reader, const ply_element *element,
                                 tulle_error *error) {
    reader->element = element;
    tulle_status status = check_count(reader, error);
    for (uint64_t i = 0; i < element->count && !status; i++) {
        reader->index = i;
        status = reader->header.format == PLY_TEXT ? read_text_line(reader, error)
                                                   : read_one(reader, error);
    }
    return status;
}

static tulle_status read_all(ply_reader *reader, bool wants_uvs, tulle_error *error) {
    tulle_status status = ply_read_header(&reader->text, &reader->header, error);
    if (status) return status;
    for (size_t i = 0; i < reader->header.element_count; i++)
        if (reader->header.elements[i].is_vertex)
            reader->vertex_count = reader->header.elements[i].count;
    for (size_t i = 0; i < reader->header.property_count; i++)
        reader->builder.keeps_uvs |= wants_uvs && reader->header.properties[i].role == PLY_S;
    if (reader->vertex_count > MESH_COUNT_LIMIT)
        return error_set_at(error, TULLE_ERROR_LIMIT, reader->text.path, 0, 0,
                            "the header says %llu vertices; the most is %zu",
                            (unsigned long long)reader->vertex_count, MESH_COUNT_LIMIT);
    for (size_t i = 0; i < reader->header.element_count && !status; i++)
        status = read_element(reader, &reader->header.elements[i], error);
    if (status || !text_skip_blank_lines(&reader->text)) return status;
    return error_set_at(
        error, TULLE_ERROR_PARSE, reader->text.path, 0, 0,
        "byte %zu: something follows the last element; do the counts in the header fit?",
        (size_t)(reader->text.at - reader->begin));
}

tulle_status ply_read(memory *heap, const char *path, const file_data *data, tulle_mesh *mesh,
                      tulle_mesh_source *source, tulle_error *error) {
    ply_reader *const reader = memory_allocate_zeroed(heap, 1, sizeof *reader);
    if (!reader) return file_fail_memory(error, path);
    reader->text = text_cursor_make(path, data->bytes, data->byte_count);
    reader->begin = data->bytes;
    reader->builder = mesh_builder_make(heap);
    tulle_status status = read_all(reader, source != NULL, error);
    const char *const place = reader->header.format == PLY_TEXT ? "line" : "face";
    if (!status) status = mesh_builder_finish(&reader->builder, path, place, mesh, error);
    if (!status && source && mesh_builder_take_source(&reader->builder, source) != TULLE_OK) {
        tulle_mesh_destroy(mesh);
        status = file_fail_memory(error, path);
    }
    if (!status && source) {
        polygon_cutter_describe(&reader->builder.cutter, source->note, sizeof source->note);
        source->has_passed_shape = source->note[0] != '\0';
    }
    mesh_builder_destroy(&reader->builder);
    memory_release(heap, reader, sizeof *reader);
    return status;
}
