/* What the two test programs of subdivision share. Include in one file of a program. */
#ifndef TULLE_TEST_SUBDIVISION_SUPPORT_H
#define TULLE_TEST_SUBDIVISION_SUPPORT_H

#include "base/hash.h"
#include "subdivision/loop_subdivision.h"
#include "tulle/shapes.h"
#include "tulle_io/subdivision.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static const double PI = 3.14159265358979323846;

static const double octahedron[18] = {1, 0, 0, 0, 1, 0, -1, 0, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1};
static const uint32_t octahedron_triangles[24] = {0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4,
                                                  1, 0, 5, 2, 1, 5, 3, 2, 5, 0, 3, 5};

static inline tulle_mesh_view view_octahedron(void) {
    return (tulle_mesh_view){octahedron, 6, octahedron_triangles, 8};
}

static inline tulle_subdivision *make_operator(tulle_mesh_view mesh,
                                               const tulle_subdivision_def *def) {
    tulle_subdivision *made = NULL;
    tulle_error error = {0};
    if (tulle_subdivision_create(mesh, def, &made, &error) != TULLE_OK)
        fail_msg("%s", error.message);
    return made;
}

/* The values at the vertices of the result; release with free. */
static inline double *apply(const tulle_subdivision *subdivision, const double *values,
                            size_t count) {
    size_t const size = count * tulle_subdivision_get_vertex_count(subdivision);
    double *const result = malloc((size > 0 ? size : 1) * sizeof *result);
    assert_non_null(result);
    assert_int_equal(tulle_subdivision_apply(subdivision, values, count, result, NULL), TULLE_OK);
    return result;
}

/* The same with an operator of its own. */
static inline double *subdivide_values(tulle_mesh_view mesh, const tulle_subdivision_def *def,
                                       const double *values, size_t count) {
    tulle_subdivision *const made = make_operator(mesh, def);
    double *const result = apply(made, values, count);
    tulle_subdivision_destroy(made);
    return result;
}

static inline tulle_mesh subdivide(tulle_mesh_view mesh, const tulle_subdivision_def *def) {
    tulle_subdivision *const made = make_operator(mesh, def);
    tulle_mesh result;
    assert_int_equal(tulle_subdivision_make_mesh(made, mesh.positions, &result, NULL), TULLE_OK);
    tulle_subdivision_destroy(made);
    return result;
}

/* A shape of at most 12 x 12 vertices, cloth jittered if so asked. */
static inline tulle_mesh make_shape(tulle_shape shape, bool is_irregular) {
    tulle_shape_def def = tulle_shape_def_default(shape);
    def.is_irregular = is_irregular && tulle_shape_is_cloth(shape);
    for (int k = 0; k < 2; k++)
        if (def.resolution[k] > 12) def.resolution[k] = 12;
    tulle_mesh mesh;
    tulle_error error = {0};
    if (tulle_shape_generate(&def, &mesh, &error) != TULLE_OK) fail_msg("%s", error.message);
    return mesh;
}

static inline double *make_random_values(size_t count, uint64_t seed) {
    double *const values = malloc(count * sizeof *values);
    assert_non_null(values);
    for (size_t i = 0; i < count; i++) values[i] = 2.0 * random_uniform(&seed) - 1.0;
    return values;
}

#endif
