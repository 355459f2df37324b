/* Stick anchors: what they gather and let go, that they move on with the contact, and that errors
 * of a solve with too few sweeps do not add up. */
#include "base/hash.h"
#include "contact/rows/stick_anchors.h"
#include "contact/solve/project_impulses.h"
#include "support/contact_world.h"
#include "support/paper_options.h"
#include "support/test_support.h"

#include <string.h>

#define TIME_STEP (1.0 / 90.0)
#define DEGREE 0.017453292519943295

static vec3 random_vector(uint64_t *random, double size) {
    double const x = random_uniform(random), y = random_uniform(random);
    return vec3_make(size * (2.0 * x - 1.0), size * (2.0 * y - 1.0),
                     size * (2.0 * random_uniform(random) - 1.0));
}

static void set_states(contact_world *world, row_state before, row_state after) {
    for (size_t r = 0; r < world->rows->rows.count; r++) {
        world->rows->rows.data[r].law.is_old = true;
        world->rows->rows.data[r].law.old_state = before;
        world->rows->rows.data[r].solve.state = after;
    }
}

/* The whole scene moves by one vector, the sheet by another one besides: anchors gather the
 * tangential part of the latter, in steps and up to a limit, and only while both steps stick. */
static void anchors_gather_slip_alone(void **state) {
    (void)state;
    uint64_t random = 5;
    for (int i = 0; i < 20; i++) {
        contact_world world;
        make_coarse_sheet_over_cloth(&world, &random);
        gather_at_rest(&world, TIME_STEP);
        contact_scene const scene = get_contact_scene(&world, TIME_STEP);
        vec3 const common = random_vector(&random, 0.1), slip = random_vector(&random, 2e-6);
        for (size_t v = 0; v < world.vertex_count; v++) {
            vec3 const own = v < count_sheet_vertices(&world) ? slip : vec3_make(0.0, 0.0, 0.0);
            vec3_store(world.x1, v, vec3_add(vec3_load(world.x0, v), vec3_add(common, own)));
        }
        set_states(&world, ROW_STICKS, ROW_STICKS);
        for (int step = 1; step <= 3; step++) {
            move_anchors(&scene, world.x1, world.rows);
            for (size_t r = 0; r < world.rows->rows.count; r++) {
                const contact_row *const row = &world.rows->rows.data[r];
                double const side =
                    row->frame.vertices[0] < count_sheet_vertices(&world) ? 1.0 : -1.0;
                double const fading = 1.0 - TIME_STEP; /* of the steps before: 1 s */
                double const times = step == 1   ? 1.0
                                     : step == 2 ? 1.0 + fading
                                                 : 1.0 + fading + fading * fading;
                vec3 const expected = vec3_make(side * times * slip.x, side * times * slip.y, 0.0);
                assert_true(vec3_norm(vec3_sub(row->law.anchor, expected)) < 1e-15);
            }
        }
        for (int step = 0; step < 100; step++) move_anchors(&scene, world.x1, world.rows);
        for (size_t r = 0; r < world.rows->rows.count; r++) {
            contact_row *const row = &world.rows->rows.data[r];
            take_anchor(&scene, row, row->law.anchor);
            assert_true(vec3_norm(row->law.anchor) > 0.0);
            assert_true(vec3_norm(row->law.return_velocity) <= 0.501 * scene.settings.slip_speed);
            assert_true(vec3_dot(row->law.anchor, row->law.return_velocity) < 0.0);
        }
        bool const slides_at_start = i % 2 == 0;
        set_states(&world, slides_at_start ? ROW_SLIDES : ROW_STICKS,
                   slides_at_start ? ROW_STICKS : ROW_SLIDES);
        move_anchors(&scene, world.x1, world.rows);
        for (size_t r = 0; r < world.rows->rows.count; r++)
            assert_true(vec3_norm(world.rows->rows.data[r].law.anchor) == 0.0);
        contact_world_destroy(&world);
    }
}

/* The sheet slides on by up to a third of a cell: rows of its vertices have the offset of their
 * vertex whatever their triangle, rows of the plane's vertices the opposite; what did not stick has
 * none. */
static void anchors_go_on_with_the_contact(void **state) {
    (void)state;
    uint64_t random = 7;
    size_t changed = 0;
    for (int i = 0; i < 20; i++) {
        contact_world world;
        make_coarse_sheet_over_cloth(&world, &random);
        gather_at_rest(&world, TIME_STEP);
        bool const sticks = i % 4 != 3;
        vec3 const offset = {1e-5, -2e-6, 0.0};
        for (size_t r = 0; r < world.rows->rows.count; r++) {
            contact_row *const row = &world.rows->rows.data[r];
            double const side = row->frame.vertices[0] < count_sheet_vertices(&world) ? 1.0 : -1.0;
            row->law.anchor = vec3_scale(offset, side);
            row->solve.impulse = vec3_scale(row->frame.normal, 1e-6);
            row->solve.state = sticks ? ROW_STICKS : ROW_SLIDES;
        }
        assert_int_equal(store_contacts(world.store, world.heap, world.rows, NULL, 0, TIME_STEP),
                         TULLE_OK);
        double const dx = 0.01 * random_uniform(&random), dy = 0.01 * random_uniform(&random);
        for (size_t v = 0; v < count_sheet_vertices(&world); v++) {
            world.x0[3 * v] += dx;
            world.x0[3 * v + 1] += dy;
        }
        gather_at_rest(&world, TIME_STEP);
        for (size_t r = 0; r < world.rows->rows.count; r++) {
            const contact_row *const row = &world.rows->rows.data[r];
            double const side = row->frame.vertices[0] < count_sheet_vertices(&world) ? 1.0 : -1.0;
            vec3 const expected = vec3_scale(offset, row->law.is_old && sticks ? side : 0.0);
            vec3 const tangential = vec3_add_scaled(expected, row->frame.normal,
                                                    -vec3_dot(row->frame.normal, expected));
            assert_true(vec3_norm(vec3_sub(row->law.anchor, tangential)) < 1e-15);
            contact_reader reader = {.store = world.store};
            changed += row->law.is_old && !read_contact(&reader, row->frame.kind, row->frame.pair);
        }
        contact_world_destroy(&world);
    }
    assert_true(changed > 500);
}

/* Three sheets on a slope of 31 degrees, friction 0.62, with a single sweep a round: far too few.
 */
static double measure_drift(bool has_anchors) {
    contact_world world = contact_world_make();
    world.def.contact_distance = HEIGHT_OVER_PLANE;
    world.friction = 0.62; /* tan 31 degrees is 0.601 */
    change_paper(&world.def)->impulse_sweeps = 1;
    world.def.gravity[0] = 9.81 * sin(31.0 * DEGREE);
    world.def.gravity[2] = -9.81 * cos(31.0 * DEGREE);
    for (int i = 0; i < 4; i++) {
        double const size = i < 3 ? 0.3 : 1.0;
        uint32_t const count = i < 3 ? 7 : 5;
        vec3 const corner = {-0.5 * size + 0.0031 * i, -0.5 * size + 0.0017 * i,
                             i < 3 ? (i + 1) * HEIGHT_OVER_PLANE : 0.0};
        contact_grid grid = make_contact_grid(count, count, corner, vec3_make(size, 0.0, 0.0),
                                              vec3_make(0.0, size, 0.0));
        add_contact_surface(&world, grid.mesh, i == 3);
        free_contact_grid(&grid);
    }
    start_contact_world(&world);
    double drift = 0.0;
    for (int step = 0; step < 270; step++) {
        assert_int_equal(step_contact_world(&world, TIME_STEP), TULLE_OK);
        for (size_t i = 0; i < world.store->contacts.count && !has_anchors; i++)
            memset(world.store->contacts.data[i].anchor, 0, 3 * sizeof(double));
        if (step == 8) /* the start has no impulses */
            for (size_t v = 0; v < world.cloth_vertex_count; v++) drift -= world.x0[3 * v];
    }
    for (size_t v = 0; v < world.cloth_vertex_count; v++) drift += world.x0[3 * v];
    drift /= (double)world.cloth_vertex_count;
    contact_world_destroy(&world);
    return drift;
}

static void errors_do_not_add_up(void **state) {
    (void)state;
    double const without = measure_drift(false);
    double const with = measure_drift(true);
    print_message("drift in 3 s: %.3g m without anchors, %.3g m with\n", without, with);
    assert_true(fabs(without) > 1e-9); /* else the test shows nothing */
    assert_true(fabs(with) < fabs(without) && fabs(with) < 1e-7);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(anchors_gather_slip_alone),
        cmocka_unit_test(anchors_go_on_with_the_contact),
        cmocka_unit_test(errors_do_not_add_up),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
