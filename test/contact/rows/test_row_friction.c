/* The grain of a row: that of the side which has one, on the triangles of the row's own feature. */
#include "contact/rows/row_friction.h"

#include "contact/rows/contact_rows.h"
#include "support/contact_world.h"
#include "support/test_support.h"

#define TIME_STEP (1.0 / 90.0)

/* A sheet over a plane; rows in all four ways: a vertex or an edge of either on the other. The
 * grain of one side lies along the diagonal. */
static void check_grain(int side, double factor) {
    contact_world world = contact_world_make();
    for (int i = 0; i < 2; i++) {
        contact_grid sheet =
            make_contact_grid(4, 4, vec3_make(-0.01 * i, -0.02 * i, 0.004 * (1 - i)),
                              vec3_make(0.1, 0.0, 0.0), vec3_make(0.0, 0.1, 0.0));
        add_contact_surface(&world, sheet.mesh, i == 1);
        free_contact_grid(&sheet);
    }
    start_contact_world(&world);
    vec3 const along = {0.6, 0.8, 0.0};
    surface_grain grains[2] = {{along, 1.0}, {along, 1.0}};
    grains[side].across = factor;
    contact_scene scene = get_contact_scene(&world, TIME_STEP);
    scene.grains = grains;
    const surface_range *const ranges = scene.set->surfaces;
    pair_event const events[] = {
        {.kind = FEATURE_VERTEX_TRIANGLE, .pair = {5, ranges[1].triangle_begin + 8}},
        {.kind = FEATURE_VERTEX_TRIANGLE, .pair = {ranges[1].vertex_begin + 5, 8}},
        {.kind = FEATURE_EDGE_EDGE, .pair = {7, ranges[1].edge_begin + 9}}};
    for (int i = 0; i < 3; i++) {
        contact_row row;
        begin_contact_row(&scene, world.x0, &events[i], &row);
        row.frame.normal = vec3_make(0.0, 0.0, i == 1 ? -1.0 : 1.0);
        set_row_friction(&scene, &row);
        assert_true(row.law.friction_along == 1.0 && row.law.friction_across == factor);
        assert_true(fabs(fabs(vec3_dot(row.law.grain, along)) - 1.0) < 1e-14);
    }
    contact_world_destroy(&world);
}

static void either_side_gives_the_grain(void **state) {
    (void)state;
    check_grain(0, 0.25);
    check_grain(1, 4.0);
}

/* Where a grain leaves friction in one direction alone, the bound is a segment: straight within it,
 * a corner at its ends. */
static void segments_are_straight_up_to_their_ends(void **state) {
    (void)state;
    for (int across = 0; across < 2; across++) {
        contact_row const row = {.frame.normal = {0.0, 0.0, 1.0},
                                 .law = {.friction = 0.5,
                                         .friction_along = across ? 0.0 : 1.0,
                                         .friction_across = across ? 1.0 : 0.0,
                                         .grain = {1.0, 0.0, 0.0}}};
        for (int i = 0; i < 3; i++) { /* inside, at the end, aside of it */
            double const along = i == 0 ? 0.3 : 0.9, aside = i == 2 ? 0.2 : 0.1;
            vec3 const trial = across ? vec3_make(aside, along, 0.0) : vec3_make(along, aside, 0.0);
            bool is_inside;
            vec3 const friction = limit_friction(&row, 1.0, trial, &is_inside);
            double const size = fmin(along, 0.5);
            assert_false(is_inside);
            assert_true(vec3_norm(vec3_sub(friction, across ? vec3_make(0.0, size, 0.0)
                                                            : vec3_make(size, 0.0, 0.0))) < 1e-12);
            vec3 const on_bound = across ? vec3_make(0.0, size, 0.0) : vec3_make(size, 0.0, 0.0);
            assert_true(measure_bound_follow(&row, 1.0, on_bound, trial) == (i == 0 ? 1.0 : 0.0));
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(either_side_gives_the_grain),
                                       cmocka_unit_test(segments_are_straight_up_to_their_ends)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
