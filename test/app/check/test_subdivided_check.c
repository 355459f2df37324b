/* Judging subdivided frames: a tent that smoothing draws through the needle that holds it, a flat
 * sheet that stays where it is, and surfaces that met before. */
#include "app/check/subdivided_check.h"
#include "tulle/mesh.h"
#include "tulle_io/subdivision.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

/* A square tent of four triangles with its top at z = 1, and a needle inside it that ends at the
 * given height. */
static const double tent[15] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0, 0, 0, 1};
static const uint32_t tent_triangles[12] = {0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4};
static const double flat_sheet[15] = {-1, -1, 1, 1, -1, 1, 1, 1, 1, -1, 1, 1, 0, 0, 1};
static const uint32_t needle_triangles[12] = {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};

typedef struct needle {
    double positions[12];
} needle;

static needle make_needle(double height) {
    double const r = 0.02;
    return (needle){{r, 0, 0, -r, r, 0, -r, -r, 0, 0, 0, height}};
}

/* The cloth subdivided over the needle, which is left as it is. */
static void judge(const double cloth[15], double height, long number, int knows_simulated,
                  subdivided_verdict *verdict) {
    needle const spike = make_needle(height);
    tulle_mesh_view const coarse = {cloth, 5, tent_triangles, 4};
    tulle_mesh_view const needle_view = {spike.positions, 4, needle_triangles, 4};
    tulle_subdivision_def def = tulle_subdivision_def_default();
    tulle_subdivision *subdivision;
    tulle_mesh fine;
    assert_int_equal(tulle_subdivision_create(coarse, &def, &subdivision, NULL), TULLE_OK);
    assert_int_equal(tulle_subdivision_make_mesh(subdivision, cloth, &fine, NULL), TULLE_OK);
    tulle_check_body const bodies[2] = {{tulle_mesh_get_view(&fine), 0}, {needle_view, 1}};
    tulle_check_body const simulated[2] = {{coarse, 0}, {needle_view, 1}};
    const char *const names[2] = {"tent", "needle"};
    subdivided_frame const frame = {.number = number,
                                    .bodies = bodies,
                                    .simulated = knows_simulated ? simulated : NULL,
                                    .names = names,
                                    .body_count = 2};
    tulle_error error = {0};
    if (subdivided_check_frame(&frame, 2, verdict, &error) != TULLE_OK)
        fail_msg("%s", error.message);
    tulle_subdivision_destroy(subdivision);
    tulle_mesh_destroy(&fine);
}

static void expect_text(const char *text, const char *part) {
    if (!strstr(text, part)) fail_msg("no \"%s\" in \"%s\"", part, text);
}

/* The limit of the top is at z = 1 - 4/ (4 + 96/31) = 24/55, far under the needle's tip. */
static void smoothing_through_a_needle_is_said(void **state) {
    (void)state;
    subdivided_verdict verdict;
    judge(tent, 0.9, 12, 1, &verdict);
    assert_true(verdict.pair_count >= 4);
    assert_int_equal(verdict.simulated_pair_count, 0);
    assert_int_equal(verdict.body_pair_count, 1);
    assert_int_equal(verdict.body_pairs[0].body_a, 0);
    assert_int_equal(verdict.body_pairs[0].body_b, 1);
    assert_int_equal(verdict.body_pairs[0].pair_count, verdict.pair_count);
    assert_int_equal(verdict.listed_count, SUBDIVIDED_LIST_MAX);
    assert_int_equal(verdict.pairs[0].body_a, 0);
    char start[128];
    snprintf(start, sizeof start,
             "frame 12: the subdivided surface intersects in %zu pairs of triangles: tent with "
             "needle; the first near (",
             verdict.pair_count);
    expect_text(verdict.text, start);
    expect_text(verdict.text, "; the simulated surface does not intersect");
}

static void needle_below_the_limit_is_fine(void **state) {
    (void)state;
    subdivided_verdict verdict;
    judge(tent, 0.4, SUBDIVIDED_NO_FRAME, 1, &verdict);
    assert_int_equal(verdict.pair_count, 0);
    assert_int_equal(verdict.listed_count, 0);
    assert_string_equal(verdict.text, "");
    judge(flat_sheet, 0.999, SUBDIVIDED_NO_FRAME, 1, &verdict);
    assert_int_equal(verdict.pair_count, 0);
    judge(flat_sheet, 1.001, SUBDIVIDED_NO_FRAME, 1, &verdict);
    assert_true(verdict.pair_count > 0);
}

static void simulated_intersections_are_counted(void **state) {
    (void)state;
    subdivided_verdict verdict;
    judge(tent, 1.5, SUBDIVIDED_NO_FRAME, 1, &verdict);
    assert_true(verdict.simulated_pair_count > 0);
    assert_int_equal(strncmp(verdict.text, "the subdivided", 14), 0);
    char end[64];
    snprintf(end, sizeof end, "; the simulated surface intersects in %zu pair",
             verdict.simulated_pair_count);
    expect_text(verdict.text, end);
    judge(tent, 1.5, SUBDIVIDED_NO_FRAME, 0, &verdict);
    assert_null(strstr(verdict.text, "simulated"));
}

/* Four bodies of one square each: pairs of bodies beyond the listed ones are counted together. */
static void many_bodies_are_summed(void **state) {
    (void)state;
    static const uint32_t triangle[3] = {0, 1, 2};
    double positions[4][9];
    tulle_check_body bodies[4];
    for (int i = 0; i < 4; i++) {
        double const z = 0.1 * i;
        const double corners[9] = {-1, -1, z, 1, -1, z, 0, 1, -z};
        memcpy(positions[i], corners, sizeof corners);
        bodies[i] = (tulle_check_body){{positions[i], 3, triangle, 1}, 0};
    }
    const char *const names[4] = {"a", "b", "c", "d"};
    subdivided_frame const frame = {SUBDIVIDED_NO_FRAME, bodies, NULL, names, 4};
    subdivided_verdict verdict;
    assert_int_equal(subdivided_check_frame(&frame, 1, &verdict, NULL), TULLE_OK);
    assert_int_equal(verdict.pair_count, 6);
    assert_int_equal(verdict.body_pair_count, SUBDIVIDED_LIST_MAX);
    expect_text(verdict.text,
                "6 pairs of triangles: a with b 1, a with c 1, a with d 1, others 3;");
}

static void frames_are_summed(void **state) {
    (void)state;
    subdivided_totals totals = {0};
    subdivided_verdict fine, bad;
    char text[SUBDIVIDED_TEXT_SIZE];
    judge(tent, 0.4, 0, 1, &fine);
    judge(tent, 0.9, 7, 1, &bad);
    subdivided_totals_add(&totals, &fine);
    subdivided_totals_describe(&totals, text);
    assert_string_equal(text, "the subdivided surface does not intersect (1 frame judged)");
    subdivided_totals_add(&totals, &bad);
    judge(tent, 0.9, 8, 1, &bad);
    subdivided_totals_add(&totals, &bad);
    subdivided_totals_describe(&totals, text);
    char start[128];
    snprintf(start, sizeof start,
             "the subdivided surface intersects in 2 of 3 frames, %zu pairs of triangles in all; "
             "frame 7: the",
             2 * bad.pair_count);
    assert_int_equal(strncmp(text, start, strlen(start)), 0);
    totals = (subdivided_totals){0};
    subdivided_totals_add(&totals, &bad);
    subdivided_totals_describe(&totals, text);
    assert_string_equal(text, bad.text);
}

static void bad_meshes_are_refused(void **state) {
    (void)state;
    static const uint32_t triangle[3] = {0, 1, 9};
    tulle_check_body const body = {{tent, 5, triangle, 1}, 0};
    const char *const name = "bad";
    subdivided_frame const frame = {SUBDIVIDED_NO_FRAME, &body, NULL, &name, 1};
    subdivided_verdict verdict;
    tulle_error error = {0};
    assert_int_equal(subdivided_check_frame(&frame, 1, &verdict, &error), TULLE_ERROR_INVALID_MESH);
    assert_int_equal(verdict.pair_count, 0);
    assert_true(error.message[0] != '\0');
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(smoothing_through_a_needle_is_said),
        cmocka_unit_test(needle_below_the_limit_is_fine),
        cmocka_unit_test(simulated_intersections_are_counted),
        cmocka_unit_test(many_bodies_are_summed),
        cmocka_unit_test(frames_are_summed),
        cmocka_unit_test(bad_meshes_are_refused),
    };
    return cmocka_run_group_tests_name("app.subdivided_check", tests, NULL, NULL);
}
