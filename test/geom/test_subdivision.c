/* Loop subdivision: connections, rules of odd meshes, errors and failing memory. Limits have tests
 * of their own. */
#include "geom/loop_subdivision.h"

#include "base/hash.h"
#include "math/vec3.h"
#include "tulle/shapes.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static tulle_subdivision *make(tulle_mesh_view mesh, const tulle_subdivision_def *def) {
    tulle_subdivision *made = NULL;
    tulle_error error = {0};
    if (tulle_subdivision_create(mesh, def, &made, &error) != TULLE_OK)
        fail_msg("%s", error.message);
    return made;
}

static tulle_mesh subdivide(tulle_mesh_view mesh, const tulle_subdivision_def *def) {
    tulle_subdivision *const made = make(mesh, def);
    tulle_mesh result;
    assert_int_equal(tulle_subdivision_make_mesh(made, mesh.positions, &result, NULL), TULLE_OK);
    tulle_subdivision_destroy(made);
    return result;
}

static tulle_mesh make_shape(tulle_shape shape, bool is_irregular) {
    tulle_shape_def def = tulle_shape_def_default(shape);
    def.is_irregular = is_irregular;
    for (int k = 0; k < 2; k++)
        if (def.resolution[k] > 12) def.resolution[k] = 12;
    tulle_mesh mesh;
    tulle_error error = {0};
    if (tulle_shape_generate(&def, &mesh, &error) != TULLE_OK) fail_msg("%s", error.message);
    return mesh;
}

static tulle_mesh_info get_info(tulle_mesh_view mesh) {
    tulle_mesh_info info;
    assert_int_equal(tulle_mesh_get_info(mesh, &info, NULL), TULLE_OK);
    return info;
}

/* Pieces, holes, handles and the number of edges on the border are those of the mesh. */
static void expect_same_topology(tulle_mesh_view mesh, const tulle_mesh *result, int levels) {
    tulle_mesh_info const before = get_info(mesh), after = get_info(tulle_mesh_get_view(result));
    assert_int_equal(after.triangle_count, before.triangle_count << (2 * levels));
    assert_int_equal(after.euler_characteristic, before.euler_characteristic);
    assert_int_equal(after.component_count, before.component_count);
    assert_int_equal(after.boundary_loop_count, before.boundary_loop_count);
    assert_int_equal(after.boundary_edge_count, before.boundary_edge_count << levels);
    assert_int_equal(after.nonmanifold_edge_count, before.nonmanifold_edge_count << levels);
    assert_int_equal(after.unreferenced_vertex_count, before.unreferenced_vertex_count);
    assert_int_equal(after.degenerate_triangle_count, 0);
}

/* Every shape, cloths (one with holes) also jittered: the result is a cloth if the shape was one,
 * so its orientation is consistent too. */
static void topology_is_kept(void **state) {
    (void)state;
    for (int shape = 0; shape < 2 * TULLE_SHAPE_COUNT; shape++) {
        bool const is_irregular = shape >= TULLE_SHAPE_COUNT;
        if (is_irregular && shape % TULLE_SHAPE_COUNT > TULLE_SHAPE_NET) continue;
        tulle_mesh mesh = make_shape((tulle_shape)(shape % TULLE_SHAPE_COUNT), is_irregular);
        for (int levels = 1; levels <= 2; levels++) {
            tulle_subdivision_def def = tulle_subdivision_def_default();
            def.levels = levels;
            tulle_mesh result = subdivide(tulle_mesh_get_view(&mesh), &def);
            expect_same_topology(tulle_mesh_get_view(&mesh), &result, levels);
            tulle_error error = {0};
            if (tulle_mesh_validate(tulle_mesh_get_view(&result), TULLE_MESH_ROLE_CLOTH, &error) !=
                TULLE_OK)
                fail_msg("shape %d: %s", shape, error.message);
            tulle_mesh_destroy(&result);
        }
        tulle_mesh_destroy(&mesh);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(topology_is_kept),
    };
    return cmocka_run_group_tests_name("geom.subdivision", tests, NULL, NULL);
}
