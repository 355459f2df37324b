/* io/mesh/stl.c - reads STL, text and binary. Each facet brings its own three corners; corners with
 * the same coordinates become one vertex, in order of first use. Normals are passed over. */
#include "base/error.h"
#include "base/hash.h"
#include "io/bytes.h"
#include "io/mesh/mesh_builder.h"
#include "io/text/text_cursor.h"

#include <math.h>
#include <string.h>

enum {
    BINARY_HEADER_SIZE = 84, /* [bytes] a text of 80, then the count of facets */
    BINARY_FACET_SIZE = 50   /* [bytes] normal, three corners, two bytes of attributes */
};

/* Vertices found so far: an open-addressed table of their numbers, always at most half full. */
typedef struct corner_merger {
    mesh_builder builder;
    uint32_t *slots;
    size_t slot_count; /* a power of two, or 0 */
} corner_merger;

static void merger_destroy(corner_merger *merger) {
    memory_release(merger->builder.heap, merger->slots, merger->slot_count * sizeof(uint32_t));
    mesh_builder_destroy(&merger->builder);
}

static uint32_t *find_slot(const corner_merger *merger, const double position[3]) {
    size_t const mask = merger->slot_count - 1;
    size_t slot = (size_t)hash_mix(hash_bytes(HASH_SEED, position, 3 * sizeof(double))) & mask;
    while (merger->slots[slot] != TULLE_NONE &&
           memcmp(merger->builder.positions.data + 3 * (size_t)merger->slots[slot], position,
                  3 * sizeof(double)) != 0)
        slot = (slot + 1) & mask;
    return &merger->slots[slot];
}

static bool merger_grow(corner_merger *merger) {
    memory *const heap = merger->builder.heap;
    size_t const slot_count = merger->slot_count ? 2 * merger->slot_count : 64;
    uint32_t *const slots = memory_allocate(heap, slot_count * sizeof(uint32_t));
    if (!slots) return false;
    memset(slots, 0xff, slot_count * sizeof(uint32_t));
    memory_release(heap, merger->slots, merger->slot_count * sizeof(uint32_t));
    merger->slots = slots;
    merger->slot_count = slot_count;
    size_t const count = mesh_builder_get_vertex_count(&merger->builder);
    for (size_t i = 0; i < count; i++)
        *find_slot(merger, merger->builder.positions.data + 3 * i) = (uint32_t)i;
    return true;
}

/* Adds a corner to the polygon at hand. False when memory is short. */
static bool merger_add_corner(corner_merger *merger, double position[3]) {
    for (int axis = 0; axis < 3; axis++) position[axis] += 0.0; /* -0 and 0 are one place */
    size_t const count = mesh_builder_get_vertex_count(&merger->builder);
    if (2 * (count + 1) > merger->slot_count && !merger_grow(merger)) return false;
    uint32_t *const slot = find_slot(merger, position);
    if (*slot == TULLE_NONE) {
        if (!mesh_builder_add_vertex(&merger->builder, position)) return false;
        *slot = (uint32_t)count;
    }
    return mesh_builder_add_corner(&merger->builder, *slot, MESH_NO_UV);
}

/* ---- binary ---- */

bool stl_has_binary_size(const file_data *data) {
    if (data->byte_count < BINARY_HEADER_SIZE) return false;
    uint64_t const count = bytes_load(data->bytes + 80, 4);
    return data->byte_count == BINARY_HEADER_SIZE + count * BINARY_FACET_SIZE;
}

static tulle_status read_binary_facets(corner_merger *merger, const char *path,
                                       const file_data *data, tulle_error *error) {
    for (size_t place = BINARY_HEADER_SIZE; place < data->byte_count; place += BINARY_FACET_SIZE) {
        mesh_builder_begin_polygon(&merger->builder);
        for (size_t corner = 0; corner < 3; corner++) {
            double position[3];
            for (size_t axis = 0; axis < 3; axis++) {
                size_t const at = place + 12 + 12 * corner + 4 * axis;
                position[axis] = (double)bytes_to_float(bytes_load(data->bytes + at, 4));
                if (!isfinite(position[axis]))
                    return error_set_at(
                        error, TULLE_ERROR_PARSE, path, 0, 0,
                        "byte %zu: coordinate %c of corner %zu of facet %zu is not finite", at,
                        "xyz"[axis], corner, (place - BINARY_HEADER_SIZE) / BINARY_FACET_SIZE);
            }
            if (!merger_add_corner(merger, position)) return file_fail_memory(error, path);
        }
    }
    return TULLE_OK;
}

tulle_status stl_read_binary(memory *heap, const char *path, const file_data *data,
                             tulle_mesh *mesh, tulle_error *error) {
    if (data->byte_count < BINARY_HEADER_SIZE)
        return error_set_at(error, TULLE_ERROR_PARSE, path, 0, 0,
                            "is neither a text STL (it does not begin with \"solid\") nor a binary "
                            "STL (it ends within the header, after %zu bytes)",
                            data->byte_count);
    if (!stl_has_binary_size(data))
        return error_set_at(
            error, TULLE_ERROR_PARSE, path, 0, 0,
            "byte 80: the header says %llu facets, which take %llu bytes, but the file has %zu; it "
            "is cut short or no STL",
            (unsigned long long)bytes_load(data->bytes + 80, 4),
            (unsigned long long)(BINARY_HEADER_SIZE +
                                 bytes_load(data->bytes + 80, 4) * BINARY_FACET_SIZE),
            data->byte_count);
    corner_merger merger = {.builder = mesh_builder_make(heap)};
    tulle_status status = read_binary_facets(&merger, path, data, error);
    if (!status) status = mesh_builder_finish(&merger.builder, path, "facet", mesh, error);
    merger_destroy(&merger);
    return status;
}

/* ---- text ---- */

/* Whether the word is `name`, in capitals or not. */
static bool is_keyword(text_word word, const char *name) {
    if (word.length != strlen(name)) return false;
    for (size_t i = 0; i < word.length; i++)
        if ((word.text[i] | 0x20) != name[i]) return false;
    return true;
}

/* The next word, also across line ends. */
static text_word take_word(text_cursor *text) {
    text_skip_blank_lines(text);
    return text_take_word(text);
}

static tulle_status expect(text_cursor *text, const char *name, tulle_error *error) {
    text_word const word = take_word(text);
    char shown[TEXT_SHOWN_SIZE];
    if (is_keyword(word, name)) return TULLE_OK;
    if (word.length == 0)
        return text_fail(text, NULL, error, "the file ends where \"%s\" should be", name);
    return text_fail(text, word.text, error, "\"%s\" should be \"%s\"", text_show_word(word, shown),
                     name);
}

static tulle_status read_text_corner(corner_merger *merger, text_cursor *text, tulle_error *error) {
    static const char *const names[3] = {"x", "y", "z"};
    tulle_status status = expect(text, "vertex", error);
    double position[3];
    for (int axis = 0; axis < 3 && !status; axis++)
        status = text_take_double(text, names[axis], &position[axis], error);
    if (status) return status;
    return merger_add_corner(merger, position) ? TULLE_OK : file_fail_memory(error, text->path);
}

/* What follows the word `facet`. */
static tulle_status read_text_facet(corner_merger *merger, text_cursor *text, tulle_error *error) {
    tulle_status status = expect(text, "normal", error);
    for (int axis = 0; axis < 3 && !status; axis++)
        if (text_take_word(text).length == 0)
            status = text_fail(text, NULL, error, "a normal needs 3 numbers, this has %d", axis);
    if (!status) status = expect(text, "outer", error);
    if (!status) status = expect(text, "loop", error);
    mesh_builder_begin_polygon(&merger->builder);
    for (int corner = 0; corner < 3 && !status; corner++)
        status = read_text_corner(merger, text, error);
    if (!status) status = expect(text, "endloop", error);
    if (!status) status = expect(text, "endfacet", error);
    return status;
}

/* What follows the word `solid` and its name, up to `endsolid` and its line. */
static tulle_status read_solid(corner_merger *merger, text_cursor *text, tulle_error *error) {
    for (;;) {
        text_word const word = take_word(text);
        if (is_keyword(word, "endsolid")) {
            text_next_line(text);
            return TULLE_OK;
        }
        if (!is_keyword(word, "facet"))
            return text_fail(text, word.text, error, "\"facet\" or \"endsolid\" should be here");
        tulle_status const status = read_text_facet(merger, text, error);
        if (status) return status;
    }
}

static tulle_status read_solids(corner_merger *merger, text_cursor *text, tulle_error *error) {
    while (text_skip_blank_lines(text)) {
        tulle_status status = expect(text, "solid", error);
        if (!status) {
            text_next_line(text);
            status = read_solid(merger, text, error);
        }
        if (status) return status;
    }
    return TULLE_OK;
}

tulle_status stl_read_text(memory *heap, const char *path, const file_data *data, tulle_mesh *mesh,
                           tulle_error *error) {
    text_cursor text = text_cursor_make(path, data->bytes, data->byte_count);
    corner_merger merger = {.builder = mesh_builder_make(heap)};
    tulle_status status = read_solids(&merger, &text, error);
    if (!status) status = mesh_builder_finish(&merger.builder, path, "facet", mesh, error);
    merger_destroy(&merger);
    return status;
}
