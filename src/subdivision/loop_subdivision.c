/* subdivision/loop_subdivision.c - tulle_subdivision: checks of what is given, the levels one after
 * the other, and the product of rows and values. See loop_subdivision.h and
 * docs/method/subdivision.md.
 */
#include "subdivision/loop_subdivision.h"

#include "base/error.h"
#include "geom/mesh_indices.h"

#include "tulle_io/subdivision.h"

#include <math.h>

#define SUBDIVISION_DEF_COOKIE UINT32_C(0x7411e008)

enum { COMPONENT_MAX = 16 };

tulle_subdivision_def tulle_subdivision_def_default(void) {
    return (tulle_subdivision_def){.cookie = SUBDIVISION_DEF_COOKIE,
                                   .levels = 2,
                                   .crease_angle = (double)INFINITY,
                                   .corner_angle = 75.0 / 180.0 * 3.14159265358979323846,
                                   .is_limit = 1};
}

static tulle_status check_def(const tulle_subdivision_def *def, tulle_error *error) {
    if (!def || def->cookie != SUBDIVISION_DEF_COOKIE)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "the subdivision def was not made by tulle_subdivision_def_default");
    if (def->levels < 1 || def->levels > TULLE_SUBDIVISION_LEVELS_MAX)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "%d levels of subdivision were asked for; give 1 to %d", def->levels,
                         TULLE_SUBDIVISION_LEVELS_MAX);
    if (!(def->crease_angle > 0.0) || !(def->corner_angle > 0.0))
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "the crease angle %g rad and the corner angle %g rad must both be greater "
                         "than 0 (INFINITY: none)",
                         def->crease_angle, def->corner_angle);
    if (def->crease_edge_count > 0 && !def->crease_edges)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "the subdivision def has a count of crease edges but a null array");
    return TULLE_OK;
}

static tulle_status check_coordinates(tulle_mesh_view mesh, tulle_error *error) {
    for (size_t i = 0; i < 3 * mesh.vertex_count; i++)
        if (!isfinite(mesh.positions[i]))
            return error_set(
                error, TULLE_ERROR_INVALID_MESH,
                "vertex %zu (counted from 0) is at (%g, %g, %g); coordinates must be finite", i / 3,
                mesh.positions[i - i % 3], mesh.positions[i - i % 3 + 1],
                mesh.positions[i - i % 3 + 2]);
    return TULLE_OK;
}

static tulle_status check_mesh(tulle_mesh_view mesh, int levels, tulle_error *error) {
    size_t const parts = (size_t)1 << (2 * levels);
    if (mesh.triangle_count > TULLE_SUBDIVISION_TRIANGLES_MAX / parts)
        return error_set(error, TULLE_ERROR_LIMIT,
                         "%d levels of subdivision make %zu triangles of each of %zu; the limit is "
                         "%d in all; use fewer levels",
                         levels, parts, mesh.triangle_count, TULLE_SUBDIVISION_TRIANGLES_MAX);
    tulle_status const status = mesh_check_indices(mesh, error);
    if (status != TULLE_OK) return status;
    for (size_t t = 0; t < mesh.triangle_count; t++) {
        const uint32_t *const corner = mesh.triangles + 3 * t;
        if (corner[0] == corner[1] || corner[1] == corner[2] || corner[2] == corner[0])
            return error_set(error, TULLE_ERROR_INVALID_MESH,
                             "triangle %zu (counted from 0) uses one vertex twice (%lu, %lu, %lu); "
                             "remove it before subdividing",
                             t, (unsigned long)corner[0], (unsigned long)corner[1],
                             (unsigned long)corner[2]);
    }
    return check_coordinates(mesh, error);
}

/* Rows of every level; the last level is left in *level, whatever the status. */
static tulle_status make_steps(tulle_subdivision *made, const tulle_subdivision_def *def,
                               const spoke_rule_table *rules, subdivision_level *level,
                               tulle_error *error) {
    for (int i = 0; i < def->levels; i++) {
        if (level->vertex_count + level->edge_count > INT32_MAX)
            return error_set(error, TULLE_ERROR_LIMIT,
                             "level %d of the subdivision has %zu vertices; the limit is %d", i + 1,
                             level->vertex_count + level->edge_count, INT32_MAX);
        subdivision_level fine;
        if (!subdivision_rows_refine(&made->heap, level, rules, &made->steps[made->step_count]))
            return TULLE_ERROR_OUT_OF_MEMORY;
        made->step_count++;
        if (!subdivision_level_refine(&made->heap, level, &fine)) return TULLE_ERROR_OUT_OF_MEMORY;
        subdivision_level_destroy(&made->heap, level);
        *level = fine;
    }
    if (!def->is_limit) return TULLE_OK;
    if (!subdivision_rows_limit(&made->heap, level, rules, &made->steps[made->step_count]))
        return TULLE_ERROR_OUT_OF_MEMORY;
    made->step_count++;
    return TULLE_OK;
}

static tulle_status fill_subdivision(tulle_subdivision *made, tulle_mesh_view mesh,
                                     const tulle_subdivision_def *def, tulle_error *error) {
    subdivision_level level = {0};
    spoke_rule_table rules = {0};
    tulle_status status = subdivision_level_begin(&made->heap, mesh, def, &level, &rules, error);
    if (status == TULLE_OK) status = make_steps(made, def, &rules, &level, error);
    if (status == TULLE_OK) {
        made->vertex_count = level.vertex_count;
        made->triangle_count = level.triangle_count;
        made->triangles = level.triangles; /* taken over */
        level.triangles = NULL;
    }
    subdivision_level_destroy(&made->heap, &level);
    ARRAY_FREE(&made->heap, &rules);
    return status;
}

tulle_status subdivision_create(memory heap, tulle_mesh_view mesh, const tulle_subdivision_def *def,
                                tulle_subdivision **subdivision, tulle_error *error) {
    if (!subdivision)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "the subdivision pointer is null");
    *subdivision = NULL;
    tulle_status status = check_def(def, error);
    if (status == TULLE_OK) status = check_mesh(mesh, def->levels, error);
    if (status != TULLE_OK) return status;
    tulle_subdivision *const made = memory_allocate_zeroed(&heap, 1, sizeof *made);
    status = TULLE_ERROR_OUT_OF_MEMORY;
    if (made) {
        made->heap = heap;
        made->levels = def->levels;
        made->base_vertex_count = mesh.vertex_count;
        status = fill_subdivision(made, mesh, def, error);
    }
    if (status == TULLE_OK) {
        *subdivision = made;
        return TULLE_OK;
    }
    tulle_subdivision_destroy(made);
    if (status == TULLE_ERROR_OUT_OF_MEMORY)
        return error_set(
            error, status,
            "no memory for %d levels of subdivision of %zu triangles; use fewer levels",
            def->levels, mesh.triangle_count);
    return status;
}

tulle_status tulle_subdivision_create(tulle_mesh_view mesh, const tulle_subdivision_def *def,
                                      tulle_subdivision **subdivision, tulle_error *error) {
    return subdivision_create(memory_default(), mesh, def, subdivision, error);
}

void tulle_subdivision_destroy(tulle_subdivision *subdivision) {
    if (!subdivision) return;
    memory heap = subdivision->heap;
    for (size_t i = 0; i < subdivision->step_count; i++)
        subdivision_rows_destroy(&heap, &subdivision->steps[i]);
    memory_release(&heap, subdivision->triangles,
                   3 * subdivision->triangle_count * sizeof *subdivision->triangles);
    memory_release(&heap, subdivision, sizeof *subdivision);
}

size_t tulle_subdivision_get_vertex_count(const tulle_subdivision *subdivision) {
    return subdivision ? subdivision->vertex_count : 0;
}

size_t tulle_subdivision_get_triangle_count(const tulle_subdivision *subdivision) {
    return subdivision ? subdivision->triangle_count : 0;
}

const uint32_t *tulle_subdivision_get_triangles(const tulle_subdivision *subdivision) {
    return subdivision ? subdivision->triangles : NULL;
}

uint32_t tulle_subdivision_get_parent_triangle(const tulle_subdivision *subdivision,
                                               uint32_t triangle) {
    if (!subdivision || triangle >= subdivision->triangle_count) return TULLE_NONE;
    return triangle >> (2 * subdivision->levels);
}

static void multiply_positions(const subdivision_rows *rows, const double *values, double *result) {
    for (size_t r = 0; r < rows->row_count; r++) {
        double x = 0.0, y = 0.0, z = 0.0;
        for (uint32_t i = rows->begin[r]; i < rows->begin[r + 1]; i++) {
            const double *const value = values + 3 * (size_t)rows->columns[i];
            x += rows->weights[i] * value[0];
            y += rows->weights[i] * value[1];
            z += rows->weights[i] * value[2];
        }
        result[3 * r] = x;
        result[3 * r + 1] = y;
        result[3 * r + 2] = z;
    }
}

static void multiply_values(const subdivision_rows *rows, const double *values, size_t count,
                            double *result) {
    for (size_t r = 0; r < rows->row_count; r++) {
        double sums[COMPONENT_MAX] = {0.0};
        for (uint32_t i = rows->begin[r]; i < rows->begin[r + 1]; i++) {
            const double *const value = values + count * rows->columns[i];
            for (size_t k = 0; k < count; k++) sums[k] += rows->weights[i] * value[k];
        }
        for (size_t k = 0; k < count; k++) result[count * r + k] = sums[k];
    }
}

/* Step after step from one half of the scratch to the other, the last one into the result. */
static void multiply_steps(const tulle_subdivision *subdivision, const double *values, size_t count,
                           double *const halves[2], double *result) {
    for (size_t i = 0; i < subdivision->step_count; i++) {
        const subdivision_rows *const rows = &subdivision->steps[i];
        double *const target = i + 1 == subdivision->step_count ? result : halves[i % 2];
        if (count == 3)
            multiply_positions(rows, values, target);
        else
            multiply_values(rows, values, count, target);
        values = target;
    }
}

tulle_status tulle_subdivision_apply(const tulle_subdivision *subdivision, const double *values,
                                     size_t component_count, double *result, tulle_error *error) {
    if (!subdivision || component_count < 1 || component_count > COMPONENT_MAX)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "%zu components at each vertex; give a subdivision and 1 to %d of them",
                         component_count, COMPONENT_MAX);
    if (subdivision->vertex_count == 0) return TULLE_OK;
    if (!values || !result)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "the values or the result of a subdivision are null");
    memory heap = {.allocator = subdivision->heap.allocator};
    double *halves[2] = {NULL, NULL};
    size_t bytes[2] = {0, 0};
    for (size_t i = 0; i + 1 < subdivision->step_count; i++)
        bytes[i % 2] = subdivision->steps[i].row_count * component_count * sizeof(double);
    for (int side = 0; side < 2; side++) halves[side] = memory_allocate(&heap, bytes[side]);
    tulle_status status = TULLE_OK;
    if (halves[0] && halves[1])
        multiply_steps(subdivision, values, component_count, halves, result);
    else
        status =
            error_set(error, TULLE_ERROR_OUT_OF_MEMORY,
                      "no memory to subdivide values at %zu vertices", subdivision->vertex_count);
    for (int side = 0; side < 2; side++) memory_release(&heap, halves[side], bytes[side]);
    return status;
}

tulle_status tulle_subdivision_make_mesh(const tulle_subdivision *subdivision,
                                         const double *positions, tulle_mesh *mesh,
                                         tulle_error *error) {
    if (!subdivision || !mesh)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "the subdivision or the mesh pointer is null");
    tulle_mesh made;
    tulle_status status =
        tulle_mesh_create(subdivision->vertex_count, subdivision->triangle_count, &made, error);
    if (status != TULLE_OK) {
        *mesh = (tulle_mesh){0};
        return status;
    }
    for (size_t i = 0; i < 3 * made.triangle_count; i++)
        made.triangles[i] = subdivision->triangles[i];
    status = tulle_subdivision_apply(subdivision, positions, 3, made.positions, error);
    if (status != TULLE_OK) tulle_mesh_destroy(&made);
    *mesh = made;
    return status;
}
