/* Stage 5: rows of a sheet over a finer or coarser flat mesh are those of the plane, however
 * the meshes lie to each other; rows are found where brute force finds nearness; layers fall and
 * come to rest together. */
#include "base/hash.h"
#include "contact/pairs/pair_rules.h"
#include "contact/rows/contact_rows.h"
#include "support/contact_world.h"
#include "support/paper_options.h"
#include "support/test_support.h"

#include <stdlib.h>
#include <string.h>

#define TIME_STEP (1.0 / 90.0)

/* A sheet of 6 x 7 vertices, turned, `height` above a plane of columns x 9 vertices. */
static void make_sheet_over_plane(contact_world *world, uint64_t *random, uint32_t columns,
                                  double height) {
    *world = contact_world_make();
    double const angle = 6.28 * random_uniform(random);
    vec3 const across = {0.1 * cos(angle), 0.1 * sin(angle), 0.0};
    vec3 const along = {-0.12 * sin(angle), 0.12 * cos(angle), 0.0};
    contact_grid sheet = make_contact_grid(6, 7, vec3_make(0.0, 0.0, height), across, along);
    contact_grid plane = make_contact_grid(columns, 9, vec3_make(-0.3, -0.31, 0.0),
                                           vec3_make(0.6, 0.01, 0.0), vec3_make(0.013, 0.6, 0.0));
    add_contact_surface(world, sheet.mesh, false);
    add_contact_surface(world, plane.mesh, true);
    start_contact_world(world);
    free_contact_grid(&sheet);
    free_contact_grid(&plane);
}

static void gather(contact_world *world) {
    contact_scene const scene = get_contact_scene(world, TIME_STEP);
    pair_source *const source = find_contact_pairs(world, world->x1);
    assert_int_equal(gather_rows(&scene, world->store, world->x1, source, world->rows), TULLE_OK);
}

/* Every vertex of the sheet has exactly one row against the plane and all rows push straight up:
 * resting at the contact distance, or falling onto it. */
static void flat_on_flat_pushes_straight_up(void **state) {
    (void)state;
    uint64_t random = 3;
    for (int i = 0; i < 40; i++) {
        contact_world world;
        double const height = i % 2 ? 3e-3 : 0.05;
        make_sheet_over_plane(&world, &random, 4 + (uint32_t)i, height);
        memcpy(world.x1, world.x0, 3 * world.vertex_count * sizeof(double));
        for (size_t k = 0; k < world.cloth_vertex_count; k++) {
            world.x1[3 * k + 2] -= i % 2 ? 1e-4 : 0.1;
            world.x1[3 * k] += 1e-3;
        }
        gather(&world);
        uint32_t row_counts[64] = {0};
        for (size_t r = 0; r < world.rows->rows.count; r++) {
            const contact_row *const row = &world.rows->rows.data[r];
            bool const is_first_cloth = row->frame.vertices[0] < world.cloth_vertex_count;
            /* Beyond the sheet's border a row may tilt by the slope tolerance. */
            assert_true((is_first_cloth ? 1.0 : -1.0) * row->frame.normal.z > 1.0 - 2e-4);
            assert_true(fabs(row->frame.gap - height) < 4e-4 * height);
            if (row->frame.kind == FEATURE_VERTEX_TRIANGLE && is_first_cloth)
                row_counts[row->frame.vertices[0]]++;
            double const bias = fmin((world.def.contact_distance - height) / TIME_STEP, 0.05);
            assert_true(fabs(row->law.bias - bias) < 4e-4 * height / TIME_STEP);
        }
        for (size_t k = 0; k < world.cloth_vertex_count; k++) assert_int_equal(row_counts[k], 1);
        contact_world_destroy(&world);
    }
}

/* A normal impulse acts along the line between the points that touch, at the time of its frame: it
 * keeps linear and angular momentum. */
static void normal_impulses_keep_momentum(void **state) {
    (void)state;
    uint64_t random = 19;
    contact_world world;
    make_sheet_over_plane(&world, &random, 9, 0.1);
    for (size_t i = 0; i < 3 * world.vertex_count; i++)
        world.x1[i] = world.x0[i] + 0.05 * (random_uniform(&random) - 0.5);
    contact_scene const scene = get_contact_scene(&world, TIME_STEP);
    const surface_range *const plane = &scene.set->surfaces[1];
    for (int i = 0; i < 400; i++) {
        uint64_t const first = random_next(&random), second = random_next(&random);
        bool const is_edges = i % 2;
        uint32_t const begin = is_edges ? plane->edge_begin : plane->triangle_begin;
        uint32_t const end = is_edges ? plane->edge_end : plane->triangle_end;
        pair_event const event = {
            .kind = is_edges ? FEATURE_EDGE_EDGE : FEATURE_VERTEX_TRIANGLE,
            .pair = {(uint32_t)(first % (is_edges ? scene.set->surfaces[0].edge_end
                                                  : scene.cloth_vertex_count)),
                     begin + (uint32_t)(second % (end - begin))},
            .time = random_uniform(&random)};
        contact_row row;
        begin_contact_row(&scene, world.x1, &event, &row);
        assert_true(finish_contact_row(&scene, &row));
        double sum = 0.0;
        vec3 lever = {0.0, 0.0, 0.0};
        for (int k = 0; k < 4; k++) {
            sum += row.frame.weights[k];
            vec3 const point = vec3_lerp(vec3_load(world.x0, row.frame.vertices[k]),
                                         vec3_load(world.x1, row.frame.vertices[k]), event.time);
            lever = vec3_add_scaled(lever, point, row.frame.weights[k]);
        }
        assert_true(fabs(sum) < 1e-15);
        assert_true(vec3_norm(vec3_cross(lever, row.frame.normal)) < 1e-14);
        assert_true(vec3_norm(lever) > 1e-3);
    }
    contact_world_destroy(&world);
}

/* All of a sheet is held but one vertex: no row acts on that vertex by a lever so short that its
 * impulse would grow beyond measure. */
static void held_features_make_no_row(void **state) {
    (void)state;
    uint64_t random = 11;
    size_t row_count = 0;
    for (int i = 0; i < 60; i++) {
        contact_world world;
        make_sheet_over_plane(&world, &random, 40, 3e-3);
        for (size_t v = 0; v < world.cloth_vertex_count; v++)
            if (v != 8) world.inverse_mass[v] = 0.0;
        memcpy(world.x1, world.x0, 3 * world.vertex_count * sizeof(double));
        gather(&world);
        row_count += world.rows->rows.count;
        for (size_t r = 0; r < world.rows->rows.count; r++)
            assert_true(world.rows->rows.data[r].solve.inverse_mass > 1e-4 * world.inverse_mass[8]);
        contact_world_destroy(&world);
    }
    assert_true(row_count > 100);
}

/* Pairs that stay apart make no row. */
static void far_and_slow_makes_no_row(void **state) {
    (void)state;
    uint64_t random = 5;
    contact_world world;
    make_sheet_over_plane(&world, &random, 9, 0.02);
    memcpy(world.x1, world.x0, 3 * world.vertex_count * sizeof(double));
    gather(&world);
    assert_int_equal(world.rows->rows.count, 0);
    contact_world_destroy(&world);
}

/* A fine flat sheet whose edges are shorter than the contact distance does not touch itself. */
static void fine_sheet_does_not_touch_itself(void **state) {
    (void)state;
    contact_world world = contact_world_make();
    world.def.contact_distance = 5e-3;
    contact_grid sheet = make_contact_grid(20, 20, vec3_make(0.0, 0.0, 0.0),
                                           vec3_make(0.03, 0.0, 0.0), vec3_make(0.0, 0.03, 0.0));
    add_contact_surface(&world, sheet.mesh, false);
    start_contact_world(&world);
    memcpy(world.x1, world.x0, 3 * world.vertex_count * sizeof(double));
    gather(&world);
    assert_true(world.pairs->edge_edge.count > 1000);
    assert_int_equal(world.rows->rows.count, 0);
    free_contact_grid(&sheet);
    contact_world_destroy(&world);
}

/* Stored impulses come back with their pairs, scaled by the step's length. */
static void impulses_come_back(void **state) {
    (void)state;
    uint64_t random = 9;
    contact_world world;
    make_sheet_over_plane(&world, &random, 9, 3e-3);
    memcpy(world.x1, world.x0, 3 * world.vertex_count * sizeof(double));
    gather(&world);
    size_t const count = world.rows->rows.count;
    assert_true(count >= world.cloth_vertex_count);
    for (size_t r = 0; r < count; r++) {
        assert_false(world.rows->rows.data[r].law.is_old);
        world.rows->rows.data[r].solve.impulse = vec3_make(1.0 + (double)r, 0.0, 0.5);
    }
    assert_int_equal(store_contacts(world.store, world.heap, world.rows, NULL, 0, 2.0 * TIME_STEP),
                     TULLE_OK);
    gather(&world);
    assert_int_equal(world.rows->rows.count, count);
    for (size_t r = 0; r < count; r++) {
        assert_true(world.rows->rows.data[r].law.is_old);
        assert_true(fabs(world.rows->rows.data[r].solve.impulse.x - 0.5 * (1.0 + (double)r)) <
                    1e-12);
    }
    contact_world_destroy(&world);
}

/* Two layers at the contact distance fall as fast as one, then rest on the plane. */
static void layers_fall_and_rest_together(void **state) {
    (void)state;
    contact_world world = contact_world_make();
    change_paper(&world.def)->cg_tolerance = 1e-5; /* below what is asked of the fall */
    for (int i = 0; i < 2; i++) {
        contact_grid sheet =
            make_contact_grid(9, 9, vec3_make(0.0, 0.001 * i, 0.1 + 3e-3 * i),
                              vec3_make(0.15, 0.0, 0.0), vec3_make(0.0, 0.15, 0.0));
        add_contact_surface(&world, sheet.mesh, false);
        free_contact_grid(&sheet);
    }
    contact_grid plane = make_contact_grid(6, 6, vec3_make(-0.1, -0.1, 0.0),
                                           vec3_make(0.35, 0.0, 0.0), vec3_make(0.0, 0.35, 0.0));
    add_contact_surface(&world, plane.mesh, true);
    free_contact_grid(&plane);
    start_contact_world(&world);
    for (int step = 0; step < 8; step++) assert_int_equal(step_contact_world(&world, TIME_STEP), 0);
    double const fall = 9.81 * 8.0 * TIME_STEP;
    for (size_t i = 0; i < world.cloth_vertex_count; i++)
        assert_true(fabs(world.velocities[3 * i + 2] + fall) < 1e-5 * fall);
    for (int step = 0; step < 80; step++) {
        assert_int_equal(step_contact_world(&world, TIME_STEP), TULLE_OK);
        assert_int_equal(judge_contact_world(&world), 0);
    }
    double fastest = 0.0;
    for (size_t i = 0; i < 3 * world.cloth_vertex_count; i++)
        fastest = fmax(fastest, fabs(world.velocities[i]));
    print_message("layers at rest: fastest %.3g m/s, rescues %llu\n", fastest,
                  (unsigned long long)world.rescue_count);
    assert_true(fastest < 1e-4);
    assert_int_equal(world.rescue_count, 0);
    contact_world_destroy(&world);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(flat_on_flat_pushes_straight_up),
        cmocka_unit_test(normal_impulses_keep_momentum),
        cmocka_unit_test(held_features_make_no_row),
        cmocka_unit_test(far_and_slow_makes_no_row),
        cmocka_unit_test(fine_sheet_does_not_touch_itself),
        cmocka_unit_test(impulses_come_back),
        cmocka_unit_test(layers_fall_and_rest_together),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
