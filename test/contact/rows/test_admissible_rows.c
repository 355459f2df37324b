/* The fold of admissible_rows.c: a vertex that lies nearer to the other feature than its own one
 * does not speak against a pair if it joins both features; any other does. */
#include "contact/rows/admissible_rows.h"

#include "contact/rows/contact_rows.h"
#include "support/contact_world.h"
#include "support/test_support.h"

#define TIME_STEP (1.0 / 90.0)

enum { VERTEX = 3, APEX = 4 };

/* Whether the row of VERTEX with triangle 0 of a surface at rest is admissible. */
static bool is_row_admissible(contact_mesh mesh) {
    contact_world world = contact_world_make();
    add_contact_surface(&world, mesh, false);
    world.def.start_intersections = TULLE_START_IGNORE;
    start_contact_world(&world);
    contact_scene const scene = get_contact_scene(&world, TIME_STEP);
    pair_event const event = {.kind = FEATURE_VERTEX_TRIANGLE, .pair = {VERTEX, 0}};
    contact_row row;
    begin_contact_row(&scene, world.x0, &event, &row);
    assert_true(row.frame.vertices[0] == VERTEX && fabs(row.frame.normal.z - 1.0) < 1e-12);
    bool is_within[2] = {true, true};
    test_admissible(&scene, world.x0, &row, 0.0, (double[2]){0.02, 0.05}, is_within);
    assert_int_equal(is_within[0], is_within[1]);
    contact_world_destroy(&world);
    return is_within[0];
}

/* A triangle of the corners 0, 1, 2, and a vertex 10 cm above its middle. The vertex is a corner of
 * another triangle, whose apex lies in the plane of the first. More triangles lead from there to
 * the edge {joined, next}: one of the first triangle, or one far off. */
static bool is_admissible(uint32_t joined, uint32_t next) {
    static const double positions[] = {
        0.0,  0.0,  0.0,  /* corners of the first triangle */
        1.0,  -0.5, 0.0,  /* */
        1.0,  0.5,  0.0,  /* */
        0.5,  0.0,  0.1,  /* VERTEX */
        -0.3, 0.0,  0.0,  /* APEX */
        -0.3, 0.2,  0.3,  /* higher than VERTEX */
        -0.3, 0.3,  -0.2, /* */
        -3.0, 0.0,  -0.2, /* far off */
        -3.0, 0.5,  -0.2,
    };
    uint32_t const triangles[] = {0, 1,    2,      APEX, 5,      VERTEX, APEX, 6,
                                  5, APEX, joined, 6,    joined, next,   6};
    size_t const vertex_count = joined < 3 ? 7 : 9;
    return is_row_admissible((contact_mesh){positions, vertex_count, triangles, 5});
}

static void the_apex_of_a_fold_does_not_count(void **state) {
    (void)state;
    for (uint32_t corner = 0; corner < 3; corner++)
        assert_true(is_admissible(corner, (corner + 2) % 3));
}

static void any_other_vertex_in_between_does(void **state) {
    (void)state;
    assert_false(is_admissible(7, 8));
}

/* A triangle, and at its edge {0, 1} another one that rises by `slope` to the side of a vertex over
 * the middle of that edge. */
static bool is_admissible_at_edge(double slope) {
    double const positions[] = {
        -0.5, 0.0,  0.0, /* corners of the first triangle */
        0.5,  0.0,  0.0, /* */
        0.0,  0.5,  0.0, /* */
        0.0,  0.0,  0.1, /* VERTEX */
        -0.2, -0.1, 0.5, /* its triangle goes on upwards */
        0.2,  0.1,  0.5, /* */
        0.0,  -0.5, 0.5 * slope,
    };
    static const uint32_t triangles[] = {0, 1, 2, VERTEX, 5, 4, 1, 0, 6};
    return is_row_admissible((contact_mesh){positions, 7, triangles, 3});
}

static void the_bottom_of_a_valley_is_nearest_to_nothing(void **state) {
    (void)state;
    assert_true(is_admissible_at_edge(-0.3));
    assert_true(is_admissible_at_edge(0.0));
    assert_false(is_admissible_at_edge(0.1));
}

/* The corner of a triangle that is folded up on another one, and the edge that both share. */
static void a_fold_does_not_hide_its_own_corner(void **state) {
    (void)state;
    static const double positions[] = {-0.5, 0.0, 0.0, 0.5, 0.0, 0.0, 0.0, 0.5, 0.0, 0.0, 0.0, 0.1};
    static const uint32_t triangles[] = {0, 1, 2, 1, 0, VERTEX};
    assert_true(is_row_admissible((contact_mesh){positions, 4, triangles, 2}));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_apex_of_a_fold_does_not_count),
        cmocka_unit_test(any_other_vertex_in_between_does),
        cmocka_unit_test(the_bottom_of_a_valley_is_nearest_to_nothing),
        cmocka_unit_test(a_fold_does_not_hide_its_own_corner),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
