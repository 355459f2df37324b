/* io/mesh/obj.c - reads Wavefront OBJ: the positions of `v`, the polygons of `f` and, for those who
 * ask, the texture coordinates of `vt` and which triangles have a name by `g`, `o` or `usemtl`.
 * Corners may be v, v/vt, v//vn or v/vt/vn, counted from 1 or, negative, from the end. All other
 * statements are passed over: those of the format, as normals and lines, and those that only some
 * program knows, as seams of garments. They are noted, and names are too: who wants the triangles
 * alone loses them. What is wrong with texture coordinates is no error of the mesh: the corner has
 * none. */
#include "io/mesh/mesh_builder.h"
#include "io/text/number.h"
#include "io/text/text_cursor.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

/* Statements of one kind that were passed over. */
typedef struct passed_kind {
    char name[TEXT_SHOWN_SIZE];
    size_t count;
    int line; /* of the first */
} passed_kind;

enum { PASSED_KINDS = 12 /* kinds that a note names */ };

typedef struct obj_reader {
    text_cursor text;
    mesh_builder builder;
    /* The corner with the largest number, for vertices that come after their faces. */
    int64_t largest_index;
    text_cursor largest_place;
    passed_kind passed[PASSED_KINDS];
    size_t passed_count;   /* kinds */
    passed_kind unnamed;   /* of further kinds together */
    bool has_passed_shape; /* one of them may say something about the shape */
} obj_reader;

/* Names, normals, materials and pictures: the triangles are the same without them. */
static bool is_dress(text_word word) {
    static const char *const names[] = {
        "vn",     "g",   "o",     "s",        "mg",       "usemtl",     "mtllib",    "usemap",
        "maplib", "lod", "bevel", "c_interp", "d_interp", "shadow_obj", "trace_obj", "color of v"};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++)
        if (text_word_is(word, names[i])) return true;
    return false;
}

static void note_passed_over(obj_reader *reader, text_word word) {
    char name[TEXT_SHOWN_SIZE];
    text_show_word(word, name);
    reader->has_passed_shape |= !is_dress(word);
    size_t k = 0;
    while (k < reader->passed_count && strcmp(reader->passed[k].name, name) != 0) k++;
    passed_kind *const kind = k < PASSED_KINDS ? &reader->passed[k] : &reader->unnamed;
    if (k == reader->passed_count && k < PASSED_KINDS) reader->passed_count++;
    if (kind->count++ > 0) return;
    memcpy(kind->name, name, sizeof name);
    kind->line = reader->text.line;
}

/* "passed over: 12 'seam' (the first in line 40), 1 'usemtl' (line 3)" */
static void write_note(const obj_reader *reader, char *note, size_t size) {
    size_t length = 0;
    note[0] = '\0';
    for (size_t k = 0; k < reader->passed_count && length < size; k++) {
        const passed_kind *const kind = &reader->passed[k];
        length += (size_t)snprintf(note + length, size - length, "%s%zu '%s' (%sline %d)",
                                   k == 0 ? "passed over: " : ", ", kind->count, kind->name,
                                   k == 0 && kind->count > 1 ? "the first in " : "", kind->line);
    }
    if (reader->unnamed.count > 0 && length < size)
        length += (size_t)snprintf(note + length, size - length, ", %zu of other kinds (line %d)",
                                   reader->unnamed.count, reader->unnamed.line);
    if (length + 2 >= size) return;
    polygon_cutter_describe(&reader->builder.cutter, note + length + 2, size - length - 2);
    if (note[length + 2] == '\0') return;
    if (length > 0)
        memcpy(note + length, "; ", 2);
    else
        memmove(note, note + 2, strlen(note + 2) + 1);
}

/* Whether a word is a number, as any program writes one that is not finite: nan, -nan(ind), 1.#IND.
 */
static bool is_any_number(text_word word) {
    double ignored;
    if (number_parse_double(word.text, word.length, &ignored) != NUMBER_MALFORMED) return true;
    bool const has_sign = *word.text == '-' || *word.text == '+';
    const char *const text = word.text + has_sign;
    size_t const length = word.length - has_sign;
    return (length >= 3 &&
            (strncasecmp(text, "nan", 3) == 0 || strncasecmp(text, "inf", 3) == 0)) ||
           (length >= 3 && strncmp(text, "1.#", 3) == 0);
}

/* v x y z, then perhaps w, or a colour, which is noted. */
static tulle_status read_vertex(obj_reader *reader, tulle_error *error) {
    static const char *const names[3] = {"x", "y", "z"}, color[] = "color of v";
    double position[3];
    int more = 0;
    for (int axis = 0; axis < 3; axis++) {
        tulle_status const status =
            text_take_double(&reader->text, names[axis], &position[axis], error);
        if (status) return status;
    }
    for (text_word word = text_take_word(&reader->text); word.length > 0 && word.text[0] != '#';
         word = text_take_word(&reader->text)) {
        if (!is_any_number(word))
            return text_fail(&reader->text, word.text, error,
                             "only numbers may follow the position of a vertex");
        if (++more == 3) note_passed_over(reader, (text_word){color, strlen(color)});
    }
    return mesh_builder_add_vertex(&reader->builder, position)
               ? TULLE_OK
               : file_fail_memory(error, reader->text.path);
}

/* vt u v; v may be left out, for 0. */
static tulle_status read_uv(obj_reader *reader, tulle_error *error) {
    double uv[2] = {(double)NAN, 0.0};
    for (int k = 0; k < 2; k++) {
        text_word const word = text_take_word(&reader->text);
        if (word.length == 0 || word.text[0] == '#') break;
        if (number_parse_double(word.text, word.length, &uv[k]) != NUMBER_READ) uv[k] = (double)NAN;
    }
    return mesh_builder_add_uv(&reader->builder, uv[0], uv[1])
               ? TULLE_OK
               : file_fail_memory(error, reader->text.path);
}

/* Whether the text after a corner's vertex is /vt, //vn or /vt/vn; *uv is then vt as it stands, 0
 * without any. */
static bool read_corner_tail(const char *text, size_t length, int64_t *uv) {
    int parts = 0;
    *uv = 0;
    while (length > 0) {
        if (*text != '/' || ++parts > 2) return false;
        const char *const next = length > 1 ? memchr(text + 1, '/', length - 1) : NULL;
        size_t const part = next ? (size_t)(next - text) - 1 : length - 1;
        int64_t number;
        if (part > 0 && number_parse_integer(text + 1, part, &number) != NUMBER_READ) return false;
        if (part > 0 && parts == 1) *uv = number;
        text += part + 1;
        length -= part + 1;
    }
    return true;
}

static tulle_status read_corner(obj_reader *reader, text_word word, tulle_error *error) {
    const char *const slash = memchr(word.text, '/', word.length);
    size_t const length = slash ? (size_t)(slash - word.text) : word.length;
    char shown[TEXT_SHOWN_SIZE];
    int64_t index = 0, uv;
    if (number_parse_integer(word.text, length, &index) == NUMBER_MALFORMED ||
        !read_corner_tail(word.text + length, word.length - length, &uv))
        return text_fail(&reader->text, word.text, error,
                         "\"%s\" should be a corner: v, v/vt, v//vn or v/vt/vn",
                         text_show_word(word, shown));
    int64_t const count = (int64_t)mesh_builder_get_vertex_count(&reader->builder);
    if (index < 0 && index >= -count) index += count + 1;
    if (index < 1 || index > (int64_t)MESH_COUNT_LIMIT)
        return text_fail(&reader->text, word.text, error,
                         "there is no vertex \"%s\"; so far there are %lld, counted from 1",
                         text_show_word(word, shown), (long long)count);
    if (index > reader->largest_index) {
        reader->largest_index = index;
        reader->largest_place = reader->text;
        reader->largest_place.at = word.text;
    }
    int64_t const uv_count = (int64_t)(reader->builder.uvs.count / 2);
    if (uv < 0 && uv >= -uv_count) uv += uv_count + 1;
    bool const has_uv = uv >= 1 && uv <= (int64_t)MESH_COUNT_LIMIT;
    return mesh_builder_add_corner(&reader->builder, (uint32_t)(index - 1),
                                   has_uv ? (uint32_t)(uv - 1) : MESH_NO_UV)
               ? TULLE_OK
               : file_fail_memory(error, reader->text.path);
}

static tulle_status read_face(obj_reader *reader, tulle_error *error) {
    mesh_builder_begin_polygon(&reader->builder);
    for (text_word word = text_take_word(&reader->text); word.length > 0 && word.text[0] != '#';
         word = text_take_word(&reader->text)) {
        tulle_status const status = read_corner(reader, word, error);
        if (status) return status;
    }
    if (reader->builder.fan_count < 3)
        return text_fail(&reader->text, NULL, error,
                         "a face needs at least 3 corners, this has %zu",
                         reader->builder.fan_count);
    return TULLE_OK;
}

/* Names of triangles to come: `g` has one in each word, `o` and `usemtl` all their words, of which
 * the first may begin with '#'. */
static tulle_status read_part_names(obj_reader *reader, part_kind kind, tulle_error *error) {
    bool is_good = mesh_builder_end_parts(&reader->builder, kind);
    text_word word = text_take_word(&reader->text);
    if (kind == PART_GROUP) {
        for (; is_good && word.length > 0 && word.text[0] != '#';
             word = text_take_word(&reader->text))
            is_good = mesh_builder_begin_part(&reader->builder, kind, word.text, word.length);
    } else if (word.length > 0) {
        is_good = mesh_builder_begin_part(&reader->builder, kind, word.text, word.length);
        for (word = text_take_word(&reader->text);
             is_good && word.length > 0 && word.text[0] != '#';
             word = text_take_word(&reader->text))
            is_good = mesh_builder_extend_name(&reader->builder, word.text, word.length);
    }
    return is_good ? TULLE_OK : file_fail_memory(error, reader->text.path);
}

/* Whether a statement names triangles, and how. */
static bool is_part(text_word word, part_kind *kind) {
    static const char *const names[] = {
        [PART_GROUP] = "g", [PART_OBJECT] = "o", [PART_MATERIAL] = "usemtl"};
    for (int k = 0; k < 3; k++)
        if (text_word_is(word, names[k])) return *kind = (part_kind)k, true;
    return false;
}

static tulle_status read_statement(obj_reader *reader, tulle_error *error) {
    reader->builder.line = (uint32_t)reader->text.line;
    text_word const word = text_take_word(&reader->text);
    if (text_word_is(word, "v")) return read_vertex(reader, error);
    if (text_word_is(word, "f")) return read_face(reader, error);
    if (text_word_is(word, "vt"))
        return reader->builder.keeps_uvs ? read_uv(reader, error) : TULLE_OK;
    if (word.text[0] != '#') note_passed_over(reader, word);
    part_kind kind;
    bool const has_name = reader->builder.keeps_parts && is_part(word, &kind);
    return has_name ? read_part_names(reader, kind, error) : TULLE_OK;
}

static tulle_status read_statements(obj_reader *reader, tulle_error *error) {
    while (text_skip_blank_lines(&reader->text)) {
        tulle_status const status = read_statement(reader, error);
        if (status) return status;
        text_next_line(&reader->text);
    }
    size_t const count = mesh_builder_get_vertex_count(&reader->builder);
    if (reader->largest_index > (int64_t)count)
        return text_fail(&reader->largest_place, NULL, error,
                         "there is no vertex %lld; the file has %zu, counted from 1",
                         (long long)reader->largest_index, count);
    return TULLE_OK;
}

tulle_status obj_read(memory *heap, const char *path, const file_data *data, tulle_mesh *mesh,
                      tulle_mesh_source *source, tulle_error *error) {
    static const char MARK[] = "\xef\xbb\xbf"; /* some editors put it before UTF-8 text */
    size_t const mark = strlen(MARK);
    bool const is_marked = data->byte_count >= mark && memcmp(data->bytes, MARK, mark) == 0;
    size_t const begin = is_marked ? mark : 0;
    obj_reader reader = {.text =
                             text_cursor_make(path, data->bytes + begin, data->byte_count - begin),
                         .builder = mesh_builder_make(heap)};
    reader.text.joins_lines = true;
    reader.builder.keeps_lines = reader.builder.keeps_uvs = source != NULL;
    reader.builder.keeps_parts = source != NULL;
    tulle_status status = read_statements(&reader, error);
    if (!status) status = mesh_builder_finish(&reader.builder, path, "line", mesh, error);
    if (!status && source) {
        status = mesh_builder_take_source(&reader.builder, source);
        if (status) {
            tulle_mesh_destroy(mesh);
            status = file_fail_memory(error, path);
        }
        write_note(&reader, source->note, sizeof source->note);
        const polygon_cutter *const cutter = &reader.builder.cutter;
        source->has_passed_shape =
            reader.has_passed_shape || cutter->bent_count + cutter->crossed_count > 0;
    }
    mesh_builder_destroy(&reader.builder);
    return status;
}
