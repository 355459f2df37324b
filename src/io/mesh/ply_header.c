/* io/mesh/ply_header.c - see ply_header.h. */
#include "io/mesh/ply_header.h"

#include "base/error.h"
#include "io/text/number.h"

#include <string.h>

typedef struct type_name {
    const char *name;
    ply_type type;
} type_name;

static const type_name type_names[] = {
    {"char", PLY_INT8},     {"int8", PLY_INT8},      {"uchar", PLY_UINT8},   {"uint8", PLY_UINT8},
    {"short", PLY_INT16},   {"int16", PLY_INT16},    {"ushort", PLY_UINT16}, {"uint16", PLY_UINT16},
    {"int", PLY_INT32},     {"int32", PLY_INT32},    {"uint", PLY_UINT32},   {"uint32", PLY_UINT32},
    {"int64", PLY_INT64},   {"uint64", PLY_UINT64},  {"float", PLY_FLOAT},   {"float32", PLY_FLOAT},
    {"double", PLY_DOUBLE}, {"float64", PLY_DOUBLE},
};

size_t ply_type_size(ply_type type) {
    static const size_t sizes[PLY_TYPE_COUNT] = {1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
    return sizes[type];
}

static bool is_integer(ply_type type) { return type != PLY_FLOAT && type != PLY_DOUBLE; }

static tulle_status take_type(text_cursor *text, ply_type *type, tulle_error *error) {
    text_word const word = text_take_word(text);
    for (size_t i = 0; i < sizeof type_names / sizeof type_names[0]; i++) {
        if (text_word_is(word, type_names[i].name)) {
            *type = type_names[i].type;
            return TULLE_OK;
        }
    }
    char shown[TEXT_SHOWN_SIZE];
    return text_fail(text, word.text, error,
                     "\"%s\" should be a type: char, uchar, short, ushort, int, uint, float, "
                     "double, int8 .. uint64, float32 or float64",
                     text_show_word(word, shown));
}

static tulle_status read_format(text_cursor *text, ply_header *header, tulle_error *error) {
    static const char *const names[] = {"ascii", "binary_little_endian", "binary_big_endian"};
    text_word const word = text_take_word(text);
    text_word const version = text_take_word(text);
    for (int i = 0; i < 3; i++) {
        if (text_word_is(word, names[i])) {
            header->format = (ply_format)i;
            if (text_word_is(version, "1.0")) return TULLE_OK;
            return text_fail(text, version.text, error, "the version should be 1.0");
        }
    }
    return text_fail(text, word.text, error,
                     "the format should be ascii, binary_little_endian or binary_big_endian");
}

static tulle_status read_element(text_cursor *text, ply_header *header, tulle_error *error) {
    if (header->element_count == PLY_ELEMENT_MAX)
        return text_fail(text, NULL, error, "there are more than %d kinds of element",
                         PLY_ELEMENT_MAX);
    ply_element *const element = &header->elements[header->element_count++];
    text_word const name = text_take_word(text);
    text_word const count = text_take_word(text);
    int64_t number = -1;
    if (name.length == 0 ||
        number_parse_integer(count.text, count.length, &number) != NUMBER_READ || number < 0)
        return text_fail(text, count.text, error,
                         "an element needs a name and a count of 0 or more");
    text_show_word(name, element->name);
    element->count = (uint64_t)number;
    element->first_property = header->property_count;
    element->property_count = 0;
    element->is_vertex = text_word_is(name, "vertex");
    element->is_face = text_word_is(name, "face");
    if (text_word_is(name, "tristrips"))
        return error_set_at(error, TULLE_ERROR_UNSUPPORTED, text->path, text->line, 1,
                            "triangle strips cannot be read; convert them to faces");
    return TULLE_OK;
}

static ply_role find_role(const ply_element *element, const ply_property *property) {
    if (element->is_vertex && !property->is_list && strlen(property->name) == 1) {
        if (property->name[0] == 'x') return PLY_X;
        if (property->name[0] == 'y') return PLY_Y;
        if (property->name[0] == 'z') return PLY_Z;
    }
    static const char *const uvs[2][3] = {{"s", "u", "texture_u"}, {"t", "v", "texture_v"}};
    for (int k = 0; element->is_vertex && !property->is_list && k < 6; k++)
        if (strcmp(property->name, uvs[k / 3][k % 3]) == 0) return k < 3 ? PLY_S : PLY_T;
    if (element->is_face && property->is_list &&
        (strcmp(property->name, "vertex_indices") == 0 ||
         strcmp(property->name, "vertex_index") == 0))
        return PLY_CORNERS;
    return PLY_PASSED_OVER;
}

static tulle_status read_property(text_cursor *text, ply_header *header, tulle_error *error) {
    if (header->element_count == 0)
        return text_fail(text, NULL, error, "a property needs an element before it");
    if (header->property_count == PLY_PROPERTY_MAX)
        return text_fail(text, NULL, error, "there are more than %d properties", PLY_PROPERTY_MAX);
    ply_element *const element = &header->elements[header->element_count - 1];
    ply_property *const property = &header->properties[header->property_count];
    *property = (ply_property){0};
    text_cursor const before = *text;
    property->is_list = text_word_is(text_take_word(text), "list");
    if (!property->is_list) *text = before;
    tulle_status status =
        property->is_list ? take_type(text, &property->count_type, error) : TULLE_OK;
    if (!status && property->is_list && !is_integer(property->count_type))
        return text_fail(text, NULL, error, "the count of a list should have an integer type");
    if (!status) status = take_type(text, &property->type, error);
    if (status) return status;
    text_word const name = text_take_word(text);
    if (name.length == 0) return text_fail(text, NULL, error, "the property has no name");
    text_show_word(name, property->name);
    property->role = find_role(element, property);
    if (property->role == PLY_CORNERS && !is_integer(property->type))
        return text_fail(text, name.text, error,
                         "the corners of faces should have an integer type");
    for (size_t i = element->first_property; i < header->property_count; i++) {
        if (property->role == PLY_PASSED_OVER || header->properties[i].role != property->role)
            continue;
        bool const is_uv = property->role == PLY_S || property->role == PLY_T;
        if (is_uv) /* the first of several counts */
            property->role = PLY_PASSED_OVER;
        else
            return text_fail(text, name.text, error, "property %s is given twice", property->name);
    }
    header->property_count++;
    element->property_count++;
    return TULLE_OK;
}

/* One line; *is_last becomes true at end_header. */
static tulle_status read_line(text_cursor *text, ply_header *header, bool *is_last,
                              tulle_error *error) {
    text_word const word = text_take_word(text);
    if (text_word_is(word, "comment") || text_word_is(word, "obj_info") || word.length == 0)
        return TULLE_OK;
    if (text_word_is(word, "format")) return read_format(text, header, error);
    if (text_word_is(word, "element")) return read_element(text, header, error);
    if (text_word_is(word, "property")) return read_property(text, header, error);
    *is_last = text_word_is(word, "end_header");
    char shown[TEXT_SHOWN_SIZE];
    return *is_last ? TULLE_OK
                    : text_fail(text, word.text, error, "\"%s\" is not a keyword of a PLY header",
                                text_show_word(word, shown));
}

/* Each of the roles from first to last must be taken by a property of the element. */
static tulle_status require_roles(const text_cursor *text, const ply_header *header,
                                  const ply_element *element, const ply_role roles[2],
                                  tulle_error *error) {
    static const char *const names[] = {"", "x", "y", "z", "s", "t", "list vertex_indices"};
    for (ply_role role = roles[0]; role <= roles[1]; role++) {
        bool found = false;
        for (size_t i = 0; i < element->property_count; i++)
            found |= header->properties[element->first_property + i].role == role;
        if (!found)
            return text_fail(text, NULL, error, "element %s has no property %s", element->name,
                             names[role]);
    }
    return TULLE_OK;
}

static tulle_status check_header(const text_cursor *text, const ply_header *header,
                                 tulle_error *error) {
    int vertex_elements = 0;
    int face_elements = 0;
    for (size_t i = 0; i < header->element_count; i++) {
        const ply_element *const element = &header->elements[i];
        tulle_status status = TULLE_OK;
        if (element->is_vertex)
            status = require_roles(text, header, element, (ply_role[2]){PLY_X, PLY_Z}, error);
        if (element->is_face)
            status = require_roles(text, header, element, (ply_role[2]){PLY_CORNERS, PLY_CORNERS},
                                   error);
        if (status) return status;
        if (element->property_count == 0 && element->count > 0)
            return text_fail(text, NULL, error, "element %s has no properties", element->name);
        vertex_elements += element->is_vertex;
        face_elements += element->is_face;
    }
    if (vertex_elements != 1 || face_elements > 1)
        return text_fail(text, NULL, error,
                         "there should be one element vertex and at most one element face");
    return TULLE_OK;
}

tulle_status ply_read_header(text_cursor *text, ply_header *header, tulle_error *error) {
    header->element_count = header->property_count = 0;
    header->format = (ply_format)-1;
    if (!text_word_is(text_take_word(text), "ply"))
        return text_fail(text, text->line_start, error, "a PLY file begins with the line \"ply\"");
    for (bool is_last = false; !is_last;) {
        bool const has_line = text_next_line(text);
        if (!has_line) return text_fail(text, NULL, error, "the file ends within the header");
        tulle_status const status = read_line(text, header, &is_last, error);
        if (status) return status;
    }
    if (header->format == (ply_format)-1)
        return text_fail(text, NULL, error, "the header has no line \"format ...\"");
    tulle_status const status = check_header(text, header, error);
    text_next_line(text);
    return status;
}
