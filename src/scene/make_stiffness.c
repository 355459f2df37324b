/* scene/make_stiffness.c - factors on the stiffness of a cloth's triangles: from a file with one
 * for each vertex, and from regions. */
#include "scene/rest_shape.h"

#include "base/error.h"
#include "base/hash.h"
#include "io/file_data.h"
#include "io/text/number.h"

#include <limits.h>
#include <string.h>

/* As of tulle_cloth_def. */
static const double LEAST_FACTOR = 0.01, LARGEST_FACTOR = 100.0;

/* Takes one number for each vertex, until the text ends. Lines and what stands behind # part
 * numbers. */
static tulle_status take_factors(const char *path, const file_data *text, double *factors,
                                 size_t count, tulle_error *error) {
    const char *at = text->bytes, *const end = at + text->byte_count, *begin = at;
    size_t found = 0;
    int line = 1;
    while (at < end) {
        if (*at == '\n' && line < INT_MAX) line++;
        if (*at == '\n') begin = at + 1;
        if (*at == '#') at += strcspn(at, "\n");
        size_t const length = strcspn(at, " \t\r\n#");
        if (length == 0) {
            at += at < end;
            continue;
        }
        int const column = at - begin < INT_MAX ? (int)(at - begin) + 1 : INT_MAX;
        double factor = 0.0;
        if (number_parse_double(at, length, &factor) != NUMBER_READ || !(factor >= LEAST_FACTOR) ||
            !(factor <= LARGEST_FACTOR))
            return error_set_at(error, TULLE_ERROR_PARSE, path, line, column,
                                "the factor on the stiffness of vertex %zu is '%.*s'; it must be a "
                                "number between %g and %g",
                                found, (int)(length < 30 ? length : 30), at, LEAST_FACTOR,
                                LARGEST_FACTOR);
        if (found == count)
            return error_set_at(error, TULLE_ERROR_PARSE, path, line, column,
                                "has more factors than the mesh has vertices (%zu)", count);
        factors[found++] = factor;
        at += length;
    }
    if (found == count) return TULLE_OK;
    return error_set_at(error, TULLE_ERROR_PARSE, path, line, 0,
                        "has %zu factors; the mesh has %zu vertices, and each needs one", found,
                        count);
}

/* Fills the factors of vertices. False after a problem. */
static bool read_factors(const rest_work *work, double *factors) {
    const scene_work *const scene = work->scene;
    const cloth_keys *const keys = work->keys;
    const char *const path = resolve_path(scene, keys->stiffness_file);
    if (!path) return false;
    file_data text = {0};
    tulle_error error = {0};
    tulle_status status = file_load(&scene->scene->heap, path, 0, &text, &error);
    if (status == TULLE_OK) {
        status = take_factors(path, &text, factors, work->cloth->mesh.vertex_count, &error);
        scene->scene->content_hash =
            hash_bytes(scene->scene->content_hash, text.bytes, text.byte_count);
        file_release(&scene->scene->heap, &text);
    }
    if (status != TULLE_OK)
        problem_add_error(scene->problems, schema_place(keys, "stiffness_file"), keys->head.path,
                          &error);
    return status == TULLE_OK;
}

bool make_stiffness(const rest_work *work) {
    const tulle_mesh *const mesh = &work->cloth->mesh;
    arena *const storage = &work->scene->scene->storage;
    bool const has_file = schema_is_given(&cloth_map, work->keys, "stiffness_file");
    if (!has_file && !has_region_stiffness(work)) return true;
    double *const by_triangle = ARENA_NEW(storage, double, mesh->triangle_count);
    double *const by_vertex = has_file ? ARENA_NEW(storage, double, mesh->vertex_count) : NULL;
    if (!by_triangle || (has_file && !by_vertex)) {
        problem_add_memory(work->scene->problems, work->scene->scene->path);
        return false;
    }
    if (has_file && !read_factors(work, by_vertex)) return false;
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        const uint32_t *const corners = mesh->triangles + 3 * t;
        const region_keys *const region = get_region(work, t);
        double const mean =
            has_file ? (by_vertex[corners[0]] + by_vertex[corners[1]] + by_vertex[corners[2]]) / 3.0
                     : 1.0;
        by_triangle[t] = region ? region->stiffness * mean : mean;
    }
    work->cloth->stiffness_factors = by_triangle;
    return true;
}
