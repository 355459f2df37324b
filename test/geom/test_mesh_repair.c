/* tulle_mesh_repair: each kind of defect alone, and random triangles in few places, where all come
 * together: what comes out is sound, and a second repair does nothing. */
#include "geom/mesh.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

static tulle_mesh make(const double *positions, size_t vertex_count, const uint32_t *triangles,
                       size_t triangle_count) {
    tulle_mesh mesh = {0};
    assert_int_equal(tulle_mesh_create(vertex_count, triangle_count, &mesh, NULL), TULLE_OK);
    memcpy(mesh.positions, positions, 3 * vertex_count * sizeof *positions);
    if (triangle_count > 0)
        memcpy(mesh.triangles, triangles, 3 * triangle_count * sizeof *triangles);
    return mesh;
}

static tulle_mesh_repairs repair(tulle_mesh *mesh, double tolerance) {
    tulle_mesh_repairs repairs;
    tulle_error error = {0};
    if (tulle_mesh_repair(mesh, tolerance, &repairs, &error) != TULLE_OK)
        fail_msg("%s", error.message);
    return repairs;
}

static size_t count_all(const tulle_mesh_repairs *repairs) {
    size_t sum = 0;
    for (size_t k = 0; k < TULLE_REPAIR_COUNT; k++) sum += repairs->counts[k];
    return sum;
}

static void expect_cloth(const tulle_mesh *mesh) {
    tulle_error error = {0};
    if (tulle_mesh_validate(tulle_mesh_get_view(mesh), TULLE_MESH_ROLE_CLOTH, &error) != TULLE_OK)
        fail_msg("%s", error.message);
}

/* Repairs, wants so many of one kind and nothing else, and cloth; a second time nothing is done. */
static void expect_repair(tulle_mesh *mesh, double tolerance, tulle_repair kind, size_t count) {
    tulle_mesh_repairs repairs = repair(mesh, tolerance);
    assert_int_equal(repairs.counts[kind], count);
    assert_int_equal(count_all(&repairs), count);
    expect_cloth(mesh);
    repairs = repair(mesh, tolerance);
    assert_int_equal(count_all(&repairs), 0);
}

#define COUNT(array) (sizeof(array) / sizeof(array)[0] / 3)
#define MAKE(positions, triangles) make(positions, COUNT(positions), triangles, COUNT(triangles))

static double const square[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0.5, 0, 0, 0.5, -1, 0};

static void one_kind_at_a_time(void **state) {
    (void)state;
    uint32_t const sound[] = {0, 1, 2, 0, 2, 3}, twice[] = {0, 1, 2, 0, 2, 3, 3, 2, 0},
                   wrong[] = {0, 1, 2, 0, 2, 3, 0, 4, 5};
    tulle_mesh mesh = make(square, 4, sound, 2);
    expect_repair(&mesh, 0.0, TULLE_REPAIR_LOOSE, 0);
    assert_memory_equal(mesh.triangles, sound, sizeof sound);
    tulle_mesh_destroy(&mesh);
    mesh = make(square, 6, sound, 2);
    expect_repair(&mesh, 0.0, TULLE_REPAIR_LOOSE, 2);
    assert_int_equal(mesh.vertex_count, 4);
    tulle_mesh_destroy(&mesh);
    mesh = make(square, 4, twice, 3);
    expect_repair(&mesh, 0.0, TULLE_REPAIR_DUPLICATE, 1);
    tulle_mesh_destroy(&mesh);
    mesh = make(square, 6, wrong, 3); /* a bow tie at vertex 0; the third triangle also lies on the
                                         edge of the first one */
    tulle_mesh_repairs const repairs = repair(&mesh, 0.0);
    assert_int_equal(repairs.counts[TULLE_REPAIR_T_JUNCTION], 1);
    expect_cloth(&mesh);
    tulle_mesh_destroy(&mesh);
    uint32_t const strip[] = {0, 1, 2, 0, 2, 3, 1, 0, 4};
    double const places[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0.5, -1, 0};
    mesh = MAKE(places, strip);
    mesh.triangles[0] = 1, mesh.triangles[1] = 0; /* the middle one is turned */
    expect_repair(&mesh, 0.0, TULLE_REPAIR_TURNED, 1);
    assert_int_equal(mesh.triangles[0], 1);
    assert_int_equal(mesh.triangles[1], 2);
    tulle_mesh_destroy(&mesh);
}

/* A flat triangle that fills a T-junction, and a needle that closes none: both go, and what is
 * beside them is joined. */
static void triangles_without_area_leave_no_crack(void **state) {
    (void)state;
    uint32_t const cap[] = {0, 1, 2, 0, 2, 3, 0, 4, 1, 0, 5, 4, 4, 5, 1};
    tulle_mesh mesh = MAKE(square, cap);
    tulle_mesh_repairs repairs = repair(&mesh, 0.0);
    assert_int_equal(repairs.counts[TULLE_REPAIR_DEGENERATE], 1);
    assert_int_equal(repairs.counts[TULLE_REPAIR_T_JUNCTION], 1);
    assert_int_equal(count_all(&repairs), 2);
    expect_cloth(&mesh);
    tulle_mesh_info info;
    assert_int_equal(tulle_mesh_get_info(tulle_mesh_get_view(&mesh), &info, NULL), TULLE_OK);
    assert_int_equal(info.boundary_loop_count, 1);
    assert_int_equal(info.triangle_count, 5);
    assert_true(fabs(info.area - 1.5) < 1e-12);
    tulle_mesh_destroy(&mesh);
    double const places[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 1, 1, 0};
    uint32_t const needle[] = {0, 1, 2, 0, 4, 3, 0, 2, 4};
    mesh = MAKE(places, needle);
    expect_repair(&mesh, 0.0, TULLE_REPAIR_DEGENERATE, 1);
    assert_int_equal(mesh.vertex_count, 4);
    tulle_mesh_destroy(&mesh);
}

static void boundaries_that_meet_are_joined(void **state) {
    (void)state;
    double const places[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0, 1e-5, 0, 1, 1, 0};
    uint32_t const halves[] = {0, 1, 2, 4, 5, 3};
    tulle_mesh mesh = MAKE(places, halves);
    tulle_mesh_repairs const repairs = repair(&mesh, 0.0); /* one end lies apart */
    assert_int_equal(repairs.counts[TULLE_REPAIR_JOINED], 1);
    tulle_mesh_destroy(&mesh);
    mesh = MAKE(places, halves);
    expect_repair(&mesh, 2e-5, TULLE_REPAIR_JOINED, 2);
    assert_int_equal(mesh.vertex_count, 4);
    tulle_mesh_destroy(&mesh);
    /* Vertex 4 lies off the edge of two triangles of another piece. */
    double hanging[sizeof square / sizeof square[0]];
    memcpy(hanging, square, sizeof square);
    hanging[13] = -1e-5;
    uint32_t const across[] = {0, 1, 2, 0, 2, 3, 0, 5, 4, 4, 5, 1};
    mesh = MAKE(hanging, across);
    expect_repair(&mesh, 2e-5, TULLE_REPAIR_T_JUNCTION, 1);
    assert_int_equal(mesh.triangle_count, 5);
    tulle_mesh_destroy(&mesh);
}

/* A bow tie, and three pages at an edge: two pages stay one sheet, and nothing touches. */
static void sheets_are_cut_apart(void **state) {
    (void)state;
    double const places[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, -1, 0, 0, 0, -1, 0};
    uint32_t const bow[] = {0, 1, 2, 0, 3, 4};
    tulle_mesh mesh = MAKE(places, bow);
    expect_repair(&mesh, 0.0, TULLE_REPAIR_CUT, 1);
    const double *const moved = mesh.positions + 3 * 5;
    assert_true(fabs(moved[0] + 0.01 * sqrt(0.5)) < 1e-15);
    assert_true(fabs(moved[1] + 0.01 * sqrt(0.5)) < 1e-15 && moved[2] == 0.0);
    tulle_mesh_destroy(&mesh);
    double const pages[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, -1, 0};
    uint32_t const book[] = {0, 1, 2, 0, 1, 3, 1, 0, 4};
    mesh = MAKE(pages, book);
    tulle_mesh_repairs const repairs = repair(&mesh, 0.0);
    assert_int_equal(repairs.counts[TULLE_REPAIR_EDGE], 1);
    assert_int_equal(repairs.counts[TULLE_REPAIR_CUT], 2);
    assert_int_equal(count_all(&repairs), 3);
    expect_cloth(&mesh);
    assert_memory_equal(mesh.triangles, book, 3 * sizeof *book); /* the flat pair */
    assert_memory_equal(mesh.triangles + 6, book + 6, 3 * sizeof *book);
    assert_true(mesh.positions[3 * 5 + 2] > 0.0 && mesh.positions[3 * 6 + 2] > 0.0);
    tulle_mesh_destroy(&mesh);
}

static void what_cannot_be_repaired_is_refused(void **state) {
    (void)state;
    uint32_t const line[] = {0, 4, 1};
    tulle_mesh mesh = MAKE(square, line);
    tulle_mesh_repairs repairs = repair(&mesh, 0.0);
    assert_int_equal(mesh.triangle_count, 0);
    assert_int_equal(repairs.counts[TULLE_REPAIR_DEGENERATE], 1);
    tulle_mesh_destroy(&mesh);
    mesh = MAKE(square, line);
    mesh.positions[7] = (double)NAN;
    assert_int_equal(tulle_mesh_repair(&mesh, 0.0, &repairs, NULL), TULLE_ERROR_INVALID_MESH);
    assert_int_equal(mesh.triangle_count, 1);
    assert_int_equal(tulle_mesh_repair(&mesh, -1.0, &repairs, NULL), TULLE_ERROR_INVALID_ARGUMENT);
    tulle_mesh_destroy(&mesh);
}

static uint32_t draw(uint64_t *state, uint32_t limit) {
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    return (uint32_t)((*state >> 33) % limit);
}

static void random_soups_become_sound(void **state) {
    (void)state;
    size_t cloth_count = 0, soup_count = 2000, one_sided_count = 0;
    for (size_t soup = 0; soup < soup_count; soup++) {
        uint64_t random = soup;
        uint32_t const vertex_count = 4 + draw(&random, 9), triangle_count = 1 + draw(&random, 14);
        double places[3 * 12];
        uint32_t corners[3 * 14];
        for (uint32_t i = 0; i < 3 * vertex_count; i++)
            places[i] = draw(&random, i % 3 < 2 ? 4 : 2);
        for (uint32_t i = 0; i < 3 * triangle_count; i++) corners[i] = draw(&random, vertex_count);
        double const tolerance = soup % 3 == 0 ? 0.05 : 0.0;
        tulle_mesh mesh = make(places, vertex_count, corners, triangle_count);
        tulle_mesh_repairs repairs = repair(&mesh, tolerance);
        tulle_mesh again =
            make(mesh.positions, mesh.vertex_count, mesh.triangles, mesh.triangle_count);
        repairs = repair(&again, tolerance);
        if (tolerance == 0.0 && count_all(&repairs) != 0)
            fail_msg("soup %zu is repaired twice", soup);
        tulle_error error = {0};
        if (mesh.triangle_count == 0 ||
            tulle_mesh_validate(tulle_mesh_get_view(&mesh), TULLE_MESH_ROLE_CLOTH, &error) ==
                TULLE_OK)
            cloth_count++;
        else if (strstr(error.message, "opposite ways"))
            one_sided_count++;
        else
            fail_msg("soup %zu: %s", soup, error.message);
        tulle_mesh_destroy(&again);
        tulle_mesh_destroy(&mesh);
    }
    print_message("%zu of %zu are cloth, %zu have one side\n", cloth_count, soup_count,
                  one_sided_count);
    assert_true(cloth_count > soup_count * 9 / 10);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(one_kind_at_a_time),
        cmocka_unit_test(triangles_without_area_leave_no_crack),
        cmocka_unit_test(boundaries_that_meet_are_joined),
        cmocka_unit_test(sheets_are_cut_apart),
        cmocka_unit_test(what_cannot_be_repaired_is_refused),
        cmocka_unit_test(random_soups_become_sound),
    };
    return cmocka_run_group_tests_name("geom.mesh_repair", tests, NULL, NULL);
}
