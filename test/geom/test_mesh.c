/* Meshes: life cycle, transform, every defect that validation names, and counts of odd soups
 * against brute force. */
#include "geom/mesh.h"

#include "base/hash.h"
#include "math/vec3.h"
#include "support/failing_heap.h"

#include "tulle/shapes.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* A 3 x 3 grid in the plane, 8 triangles, all normals up. */
static const double grid_positions[27] = {0, 0, 0, 1, 0, 0, 2, 0, 0, 0, 1, 0, 1, 1,
                                          0, 2, 1, 0, 0, 2, 0, 1, 2, 0, 2, 2, 0};
static const uint32_t grid_triangles[24] = {0, 1, 4, 0, 4, 3, 1, 2, 5, 1, 5, 4,
                                            3, 4, 7, 3, 7, 6, 4, 5, 8, 4, 8, 7};

typedef struct sample {
    double positions[64];
    uint32_t triangles[64];
    tulle_mesh_view view;
} sample;

static void make_grid(sample *s) {
    memcpy(s->positions, grid_positions, sizeof grid_positions);
    memcpy(s->triangles, grid_triangles, sizeof grid_triangles);
    s->view = (tulle_mesh_view){s->positions, 9, s->triangles, 8};
}

static void add_triangle(sample *s, uint32_t a, uint32_t b, uint32_t c) {
    uint32_t *const corner = s->triangles + 3 * s->view.triangle_count++;
    corner[0] = a;
    corner[1] = b;
    corner[2] = c;
}

static void add_vertex(sample *s, double x, double y, double z) {
    double *const position = s->positions + 3 * s->view.vertex_count++;
    position[0] = x;
    position[1] = y;
    position[2] = z;
}

/* Refused in the role, with every one of the words in the message. */
static void expect_refusal(const sample *s, tulle_mesh_role role, const char *first,
                           const char *second, const char *third) {
    tulle_error error = {0};
    assert_int_equal(tulle_mesh_validate(s->view, role, &error), TULLE_ERROR_INVALID_MESH);
    assert_int_equal(error.status, TULLE_ERROR_INVALID_MESH);
    const char *const words[3] = {first, second, third};
    for (int i = 0; i < 3; i++)
        if (!strstr(error.message, words[i])) fail_msg("'%s' lacks '%s'", error.message, words[i]);
    assert_int_equal(tulle_mesh_validate(s->view, role, NULL), TULLE_ERROR_INVALID_MESH);
}

static void expect_acceptance(const sample *s, tulle_mesh_role role) {
    tulle_error error = {0};
    if (tulle_mesh_validate(s->view, role, &error) != TULLE_OK) fail_msg("%s", error.message);
}

static void sound_grid_is_accepted(void **state) {
    (void)state;
    sample s;
    make_grid(&s);
    expect_acceptance(&s, TULLE_MESH_ROLE_CLOTH);
    expect_acceptance(&s, TULLE_MESH_ROLE_OBSTACLE);
}

static void empty_is_refused(void **state) {
    (void)state;
    sample s;
    make_grid(&s);
    s.view.triangle_count = 0;
    expect_refusal(&s, TULLE_MESH_ROLE_CLOTH, "no triangles", "9 vertices", "at least one");
    s.view = (tulle_mesh_view){0};
    expect_refusal(&s, TULLE_MESH_ROLE_OBSTACLE, "no triangles", "0 vertices", "");
    s.view.triangle_count = 1;
    assert_int_equal(tulle_mesh_validate(s.view, TULLE_MESH_ROLE_CLOTH, NULL),
                     TULLE_ERROR_INVALID_ARGUMENT);
}

static void bad_indices_are_named(void **state) {
    (void)state;
    sample s;
    make_grid(&s);
    s.triangles[7] = 9;
    s.triangles[20] = TULLE_NONE;
    expect_refusal(&s, TULLE_MESH_ROLE_OBSTACLE, "triangle 2 ", "vertex 9,", "2 triangles");
    s.view.vertex_count = 0;
    expect_refusal(&s, TULLE_MESH_ROLE_OBSTACLE, "triangle 0 ", "0 vertices", "8 triangles");
}

static void bad_coordinates_are_named(void **state) {
    (void)state;
    double const bad[4] = {NAN, INFINITY, -INFINITY, 1e200};
    for (int i = 0; i < 4; i++) {
        sample s;
        make_grid(&s);
        s.positions[3 * 5 + 1] = bad[i];
        s.positions[3 * 7 + 2] = bad[i];
        expect_refusal(&s, TULLE_MESH_ROLE_OBSTACLE, "vertex 5 ", "(2, ", "1 more");
    }
}

static void degenerate_triangles_are_named(void **state) {
    (void)state;
    sample s;
    for (uint32_t k = 0; k < 3; k++) {
        make_grid(&s);
        s.triangles[9 + k] = s.triangles[9 + (k + 1) % 3];
        expect_refusal(&s, TULLE_MESH_ROLE_OBSTACLE, "triangle 3 ", "twice", "remove");
    }
    make_grid(&s);
    add_triangle(&s, 0, 1, 2);
    add_triangle(&s, 0, 3, 6);
    expect_refusal(&s, TULLE_MESH_ROLE_OBSTACLE, "triangle 8 ", "zero area", "1 more");
    make_grid(&s);
    s.positions[3 * 1 + 1] = 2e-9;
    add_triangle(&s, 0, 2, 1);
    expect_acceptance(&s, TULLE_MESH_ROLE_OBSTACLE);
    s.positions[3 * 1 + 1] = 1e-9;
    expect_refusal(&s, TULLE_MESH_ROLE_OBSTACLE, "triangle 8 ", "too thin", "(1, 1e-09, 0)");
    for (int i = 0; i < 27; i++) s.positions[i] *= 1e-200;
    expect_refusal(&s, TULLE_MESH_ROLE_OBSTACLE, "triangle 8 ", "", "");
}

/* What an obstacle goes without is found and dropped, with the entries beside it; what deforms may
 * have it. */
static void degenerate_triangles_are_dropped(void **state) {
    (void)state;
    sample s;
    make_grid(&s);
    add_triangle(&s, 0, 1, 2); /* three vertices on a line */
    add_triangle(&s, 4, 4, 5);
    expect_refusal(&s, TULLE_MESH_ROLE_DEFORMING, "triangle 9 ", "twice", "remove");
    uint8_t marks[16] = {0};
    size_t count = 0;
    assert_int_equal(tulle_mesh_find_degenerate(s.view, marks, &count, NULL), TULLE_OK);
    assert_int_equal(count, 2);
    for (size_t t = 0; t < 10; t++) assert_int_equal(marks[t], t >= 8);
    s.view.triangle_count = 9;
    expect_acceptance(&s, TULLE_MESH_ROLE_DEFORMING);
    expect_refusal(&s, TULLE_MESH_ROLE_OBSTACLE, "triangle 8 ", "zero area", "");
    tulle_mesh mesh = {0};
    assert_int_equal(tulle_mesh_create(9, 9, &mesh, NULL), TULLE_OK);
    memcpy(mesh.positions, s.positions, 27 * sizeof *mesh.positions);
    memcpy(mesh.triangles, s.triangles, 27 * sizeof *mesh.triangles);
    uint32_t lines[9];
    for (uint32_t t = 0; t < 9; t++) lines[t] = 100 + t;
    marks[0] = 1; /* and the first one */
    assert_int_equal(tulle_mesh_drop_marked(&mesh, marks, lines, NULL), TULLE_OK);
    assert_int_equal(mesh.triangle_count, 7);
    assert_memory_equal(mesh.triangles, s.triangles + 3, 21 * sizeof *mesh.triangles);
    for (uint32_t t = 0; t < 7; t++) assert_int_equal(lines[t], 101 + t);
    assert_int_equal(
        tulle_mesh_validate(tulle_mesh_get_view(&mesh), TULLE_MESH_ROLE_OBSTACLE, NULL), TULLE_OK);
    memset(marks, 1, sizeof marks);
    assert_int_equal(tulle_mesh_drop_marked(&mesh, marks, NULL, NULL), TULLE_OK);
    assert_int_equal(mesh.triangle_count, 0);
    tulle_mesh_destroy(&mesh);
}

static void all_zero_area_is_refused(void **state) {
    (void)state;
    sample s;
    make_grid(&s);
    for (int i = 0; i < 27; i++) s.positions[i] = 0.25;
    expect_refusal(&s, TULLE_MESH_ROLE_CLOTH, "triangle 0 ", "zero area", "7 more");
}

static void duplicates_are_named(void **state) {
    (void)state;
    sample s;
    make_grid(&s);
    add_triangle(&s, 4, 1, 5);
    add_triangle(&s, 0, 4, 3);
    expect_refusal(&s, TULLE_MESH_ROLE_OBSTACLE, "triangle 8 ", "triangle 3 ", "1 more");
}

static void nonmanifold_edges_are_named(void **state) {
    (void)state;
    sample s;
    make_grid(&s);
    add_vertex(&s, 1, 1, 1);
    add_triangle(&s, 9, 4, 5);
    expect_acceptance(&s, TULLE_MESH_ROLE_OBSTACLE);
    expect_refusal(&s, TULLE_MESH_ROLE_CLOTH, "vertices 4 at (1, 1, 0) and 5", "3 triangles", "");
}

static void orientation_is_checked(void **state) {
    (void)state;
    sample s;
    make_grid(&s);
    s.triangles[1] = 4;
    s.triangles[2] = 1;
    expect_acceptance(&s, TULLE_MESH_ROLE_OBSTACLE);
    expect_refusal(&s, TULLE_MESH_ROLE_CLOTH, "triangles 0 and 1", "opposite ways", "1 more");
}

static void bow_ties_are_named(void **state) {
    (void)state;
    sample s;
    make_grid(&s);
    add_vertex(&s, 3, 3, 0);
    add_vertex(&s, 2, 3, 0);
    add_triangle(&s, 8, 9, 10);
    expect_acceptance(&s, TULLE_MESH_ROLE_OBSTACLE);
    expect_refusal(&s, TULLE_MESH_ROLE_CLOTH, "vertex 8 at (2, 2, 0)", "2 separate", "bow tie");
}

static void unreferenced_vertices_are_named(void **state) {
    (void)state;
    sample s;
    make_grid(&s);
    add_vertex(&s, 5, 6, 7);
    add_vertex(&s, 5, 6, 8);
    expect_acceptance(&s, TULLE_MESH_ROLE_OBSTACLE);
    expect_refusal(&s, TULLE_MESH_ROLE_CLOTH, "vertex 9 at (5, 6, 7)", "no triangle", "1 more");
}

static void meshes_live_and_die(void **state) {
    (void)state;
    tulle_mesh mesh;
    assert_int_equal(tulle_mesh_create(4, 2, &mesh, NULL), TULLE_OK);
    for (int i = 0; i < 12; i++) mesh.positions[i] = i;
    for (uint32_t i = 0; i < 6; i++) mesh.triangles[i] = i % 4;
    tulle_mesh_view const view = tulle_mesh_get_view(&mesh);
    assert_true(view.positions == mesh.positions && view.triangles == mesh.triangles);
    assert_int_equal(view.vertex_count, 4);
    assert_int_equal(view.triangle_count, 2);
    tulle_mesh_destroy(&mesh);
    assert_null(mesh.positions);
    assert_int_equal(mesh.vertex_count, 0);
    tulle_mesh_destroy(&mesh);
    tulle_mesh_destroy(NULL);
    assert_int_equal(tulle_mesh_create(0, 0, &mesh, NULL), TULLE_OK);
    tulle_mesh_destroy(&mesh);
    tulle_error error = {0};
    assert_int_equal(tulle_mesh_create((size_t)1 << 31, 0, &mesh, &error), TULLE_ERROR_LIMIT);
    assert_non_null(strstr(error.message, "2147483648"));
    assert_int_equal(tulle_mesh_create(1, SIZE_MAX, &mesh, &error), TULLE_ERROR_LIMIT);
}

static void transform_scales_turns_moves(void **state) {
    (void)state;
    tulle_mesh mesh;
    assert_int_equal(tulle_mesh_create(1, 0, &mesh, NULL), TULLE_OK);
    vec3_store(mesh.positions, 0, vec3_make(1, 2, 3));
    /* A third of a turn about (1, 1, 1): x -> y -> z -> x. */
    double const scale[3] = {2, 3, 4}, rotation[4] = {0.5, 0.5, 0.5, 0.5}, shift[3] = {10, 20, 30};
    tulle_mesh_transform(&mesh, scale, rotation, shift);
    double const expected[3] = {12 + 10, 2 + 20, 6 + 30};
    for (int k = 0; k < 3; k++) assert_true(fabs(mesh.positions[k] - expected[k]) < 1e-14);
    tulle_mesh_destroy(&mesh);
}

/* The signed volume of a closed mesh, by the divergence theorem. */
static double measure_volume(const tulle_mesh *mesh) {
    double sum = 0.0;
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        const double *p[3];
        for (size_t k = 0; k < 3; k++)
            p[k] = mesh->positions + 3 * (size_t)mesh->triangles[3 * t + k];
        sum += p[0][0] * (p[1][1] * p[2][2] - p[1][2] * p[2][1]) +
               p[0][1] * (p[1][2] * p[2][0] - p[1][0] * p[2][2]) +
               p[0][2] * (p[1][0] * p[2][1] - p[1][1] * p[2][0]);
    }
    return sum / 6.0;
}

/* Whatever the signs, the outside stays outside: the volume is that of the box, and positive. */
static void transform_mirrors(void **state) {
    (void)state;
    for (int signs = 0; signs < 8; signs++) {
        tulle_shape_def def = tulle_shape_def_default(TULLE_SHAPE_BOX);
        tulle_mesh mesh = {0};
        for (int k = 0; k < 3; k++) def.size[k] = 1.0;
        assert_int_equal(tulle_shape_generate(&def, &mesh, NULL), TULLE_OK);
        double scale[3] = {2, 3, 4}, shift[3] = {5, 6, 7};
        double const rotation[4] = {0.5, 0.5, 0.5, 0.5};
        for (int k = 0; k < 3; k++)
            if (signs >> k & 1) scale[k] = -scale[k];
        double const before = mesh.positions[0];
        tulle_mesh_transform(&mesh, scale, rotation, shift);
        assert_true(fabs(measure_volume(&mesh) - 24.0) < 1e-12);
        assert_true(fabs(mesh.positions[1] - (6.0 + scale[0] * before)) < 1e-12);
        tulle_mesh_destroy(&mesh);
    }
}

static void info_of_grid(void **state) {
    (void)state;
    sample s;
    make_grid(&s);
    tulle_mesh_info info;
    assert_int_equal(tulle_mesh_get_info(s.view, &info, NULL), TULLE_OK);
    assert_int_equal(info.edge_count, 16);
    assert_int_equal(info.boundary_edge_count, 8);
    assert_int_equal(info.boundary_loop_count, 1);
    assert_int_equal(info.component_count, 1);
    assert_int_equal(info.euler_characteristic, 1);
    assert_int_equal(info.nonmanifold_edge_count + info.degenerate_triangle_count, 0);
    assert_true(fabs(info.area - 4.0) < 1e-14);
    assert_true(info.edge_length_min == 1.0);
    assert_true(fabs(info.edge_length_max - sqrt(2.0)) < 1e-15);
    assert_true(fabs(info.edge_length_mean - (12.0 + 4.0 * sqrt(2.0)) / 16.0) < 1e-14);
    assert_true(fabs(info.angle_min - atan(1.0)) < 1e-15);
    assert_true(info.bounds_min[0] == 0.0 && info.bounds_max[1] == 2.0 && info.bounds_max[2] == 0);
}

static void info_of_odd_soups(void **state) {
    (void)state;
    sample s;
    tulle_mesh_info info;
    make_grid(&s); /* with a bow tie, a fin, a repeated corner, zero area and lonely vertices */
    add_vertex(&s, 3, 3, 0);
    add_vertex(&s, 2, 3, 0);
    add_triangle(&s, 8, 9, 10);
    add_vertex(&s, 1, 1, 1);
    add_triangle(&s, 11, 4, 5);
    add_vertex(&s, 7, 7, 7);
    add_triangle(&s, 12, 12, 4);
    add_vertex(&s, 8, 8, 8);
    assert_int_equal(tulle_mesh_get_info(s.view, &info, NULL), TULLE_OK);
    assert_int_equal(info.degenerate_triangle_count, 1);
    assert_int_equal(info.unreferenced_vertex_count, 1);
    assert_int_equal(info.nonmanifold_edge_count, 1);
    assert_int_equal(info.component_count, 2);
    assert_int_equal(info.edge_count, 16 + 3 + 2);
    assert_int_equal(info.boundary_edge_count, 8 + 3 + 2);
    assert_int_equal(info.boundary_loop_count, 1 + 1 + 1);
    assert_int_equal(info.euler_characteristic, 12 - 21 + 10);
    s.view.triangle_count = 0;
    assert_int_equal(tulle_mesh_get_info(s.view, &info, NULL), TULLE_OK);
    assert_int_equal(info.edge_count + info.component_count, 0);
    assert_int_equal(info.unreferenced_vertex_count, 14);
    s.view = (tulle_mesh_view){0};
    assert_int_equal(tulle_mesh_get_info(s.view, &info, NULL), TULLE_OK);
    make_grid(&s);
    s.triangles[3] = 9;
    assert_int_equal(tulle_mesh_get_info(s.view, &info, NULL), TULLE_ERROR_INVALID_MESH);
}

/* Cloth is what brute force calls an oriented manifold: each directed edge at most once, each
 * vertex's triangles reachable from one another across edges at that vertex. */
static bool is_manifold(const sample *s) {
    size_t const count = s->view.triangle_count;
    for (size_t a = 0; a < 3 * count; a++) {
        for (size_t b = 0; b < a; b++) {
            uint32_t const a_end = s->triangles[a / 3 * 3 + (a + 1) % 3];
            uint32_t const b_end = s->triangles[b / 3 * 3 + (b + 1) % 3];
            if (s->triangles[a] == s->triangles[b] && a_end == b_end) return false;
        }
    }
    for (uint32_t v = 0; v < s->view.vertex_count; v++) {
        uint32_t reached = 0, all = 0;
        for (size_t t = 0; t < count; t++)
            for (int k = 0; k < 3; k++)
                if (s->triangles[3 * t + (size_t)k] == v) all |= 1u << t;
        if (all == 0) return false;
        reached = all & (~all + 1);
        for (size_t round = 0; round < count; round++) {
            for (size_t t = 0; t < count; t++) {
                if (!(all >> t & 1)) continue;
                for (size_t u = 0; u < count; u++) {
                    int shared = 0;
                    for (int k = 0; k < 9; k++)
                        shared += s->triangles[3 * t + (size_t)(k / 3)] ==
                                  s->triangles[3 * u + (size_t)(k % 3)];
                    if ((reached >> u & 1) && shared >= 2) reached |= 1u << t;
                }
            }
        }
        if (reached != all) return false;
    }
    return true;
}

static void random_soups_are_judged_like_brute_force(void **state) {
    (void)state;
    uint64_t random = 17;
    int accepted_count = 0;
    for (int round = 0; round < 20000; round++) {
        sample s = {.view = {.vertex_count = 4 + random_next(&random) % 4}};
        s.view.positions = s.positions;
        s.view.triangles = s.triangles;
        for (size_t i = 0; i < 3 * s.view.vertex_count; i++)
            s.positions[i] = random_uniform(&random);
        size_t const count = 2 + random_next(&random) % 5;
        while (s.view.triangle_count < count) {
            uint32_t c[3];
            for (int k = 0; k < 3; k++)
                c[k] = (uint32_t)(random_next(&random) % s.view.vertex_count);
            if (c[0] != c[1] && c[1] != c[2] && c[2] != c[0]) add_triangle(&s, c[0], c[1], c[2]);
        }
        tulle_error error = {0};
        bool const is_accepted =
            tulle_mesh_validate(s.view, TULLE_MESH_ROLE_CLOTH, &error) == TULLE_OK;
        /* Two opposite triangles on the same corners are a duplicate, though manifold. */
        bool const is_duplicate = strstr(error.message, "same three vertices") != NULL;
        assert_int_equal(is_accepted, is_manifold(&s) && !is_duplicate);
        accepted_count += is_accepted;
        tulle_mesh_info info;
        assert_int_equal(tulle_mesh_get_info(s.view, &info, NULL), TULLE_OK);
        if (is_accepted) assert_int_equal(info.nonmanifold_edge_count, 0);
    }
    assert_true(accepted_count > 20);
}

static void every_allocation_may_fail(void **state) {
    (void)state;
    sample s;
    make_grid(&s);
    tulle_mesh_info info;
    for (int what = 0; what < 2; what++) {
        for (int k = 0;; k++) {
            assert_true(k < 100);
            int left = k;
            memory heap = failing_heap_make(&left);
            tulle_error error = {0};
            tulle_status const status = what == 0
                                            ? mesh_validate(&heap, s.view, TULLE_MESH_ROLE_CLOTH,
                                                            (tulle_mesh_lines){0}, &error)
                                            : mesh_get_info(&heap, s.view, &info, &error);
            assert_int_equal(heap.bytes_held, 0);
            if (status == TULLE_OK) break;
            assert_int_equal(status, TULLE_ERROR_OUT_OF_MEMORY);
            assert_int_equal(error.status, TULLE_ERROR_OUT_OF_MEMORY);
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sound_grid_is_accepted),
        cmocka_unit_test(empty_is_refused),
        cmocka_unit_test(bad_indices_are_named),
        cmocka_unit_test(bad_coordinates_are_named),
        cmocka_unit_test(degenerate_triangles_are_named),
        cmocka_unit_test(degenerate_triangles_are_dropped),
        cmocka_unit_test(all_zero_area_is_refused),
        cmocka_unit_test(duplicates_are_named),
        cmocka_unit_test(nonmanifold_edges_are_named),
        cmocka_unit_test(orientation_is_checked),
        cmocka_unit_test(bow_ties_are_named),
        cmocka_unit_test(unreferenced_vertices_are_named),
        cmocka_unit_test(meshes_live_and_die),
        cmocka_unit_test(transform_scales_turns_moves),
        cmocka_unit_test(transform_mirrors),
        cmocka_unit_test(info_of_grid),
        cmocka_unit_test(info_of_odd_soups),
        cmocka_unit_test(random_soups_are_judged_like_brute_force),
        cmocka_unit_test(every_allocation_may_fail),
    };
    return cmocka_run_group_tests_name("geom.mesh", tests, NULL, NULL);
}
