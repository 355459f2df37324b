/* Which rows turn with what slides: those against an obstacle that stands or shifts as a script
 * says. An obstacle that moves without one keeps the frame of the start. */
#include "contact/rows/contact_rows.h"

#include "support/contact_world.h"
#include "support/test_support.h"

#include <string.h>

#define TIME_STEP (1.0 / 90.0)

/* A row of a vertex that slides along a plane, turned to the end of the step. */
typedef struct turned_row {
    contact_row before, after;
} turned_row;

/* The plane moves by `rise` [m] upwards, on one side by twice as much where it bends. A carrier
 * tells of the motion; only a shift has one. */
static turned_row turn_row(double rise, bool bends, bool has_carrier) {
    contact_world world = contact_world_make();
    contact_grid sheet = make_contact_grid(3, 3, vec3_make(0.0, 0.0, 3e-3),
                                           vec3_make(0.1, 0.0, 0.0), vec3_make(0.0, 0.1, 0.0));
    contact_grid plane = make_contact_grid(2, 2, vec3_make(-1.0, -1.1, 0.0),
                                           vec3_make(2.0, 0.0, 0.0), vec3_make(0.0, 2.3, 0.0));
    add_contact_surface(&world, sheet.mesh, false);
    add_contact_surface(&world, plane.mesh, true);
    start_contact_world(&world);
    for (size_t v = 0; v < world.cloth_vertex_count; v++)
        vec3_store(world.velocities, v, vec3_make(0.3, 0.1, 0.0));
    size_t const begin = world.cloth_vertex_count;
    memcpy(world.targets + 3 * begin, world.x0 + 3 * begin,
           3 * (world.vertex_count - begin) * sizeof(double));
    for (size_t v = begin; v < world.vertex_count; v++)
        world.targets[3 * v + 2] += bends && world.x0[3 * v] > 0.0 ? 2.0 * rise : rise;
    world.maps[1] = (affine_map){.matrix = mat3_identity(1.0), .offset = {0.0, 0.0, rise}};
    if (has_carrier) world.carriers[1] = &world.maps[1];

    contact_scene const scene = get_contact_scene(&world, TIME_STEP);
    pair_event event = {.kind = FEATURE_VERTEX_TRIANGLE,
                        .pair = {4, scene.set->surfaces[1].triangle_begin}};
    turned_row row;
    begin_contact_row(&scene, world.x0, &event, &row.before);
    if (!(fabs(row.before.frame.normal.z - 1.0) < 1e-12)) { /* over the other triangle */
        event.pair.second++;
        begin_contact_row(&scene, world.x0, &event, &row.before);
    }
    assert_true(finish_contact_row(&scene, &row.before));
    row.after = row.before;
    turn_row_to_end(&scene, &row.after);
    contact_world_destroy(&world);
    free_contact_grid(&sheet);
    free_contact_grid(&plane);
    return row;
}

/* The vertex slides by 3.3 mm and 1.1 mm on a plane of 2 m and 2.3 m: the weights of its point of
 * contact change by that part. */
static void assert_turned(const turned_row *row) {
    double largest = 0.0;
    for (int k = 1; k < 4; k++)
        largest = fmax(largest, fabs(row->after.frame.weights[k] - row->before.frame.weights[k]));
    assert_true(fabs(largest - 0.3 * TIME_STEP / 2.0) < 1e-9 ||
                fabs(largest - 0.1 * TIME_STEP / 2.3) < 1e-9 ||
                fabs(largest - (0.3 / 2.0 + 0.1 / 2.3) * TIME_STEP) < 1e-9);
}

static void rows_follow_what_stands_or_shifts(void **state) {
    (void)state;
    turned_row const stands = turn_row(0.0, false, false), shifts = turn_row(1e-3, false, true);
    assert_turned(&stands);
    assert_turned(&shifts);
    turned_row const is_told_to_stand = turn_row(0.0, false, true);
    assert_memory_equal(&is_told_to_stand.after.frame.weights, &stands.after.frame.weights,
                        sizeof stands.after.frame.weights);
}

static void rows_of_what_moves_without_a_script_stay(void **state) {
    (void)state;
    for (int bends = 0; bends < 2; bends++) {
        turned_row const row = turn_row(1e-3, bends, false);
        const row_frame *const before = &row.before.frame, *const after = &row.after.frame;
        assert_memory_equal(after->weights, before->weights, sizeof before->weights);
        assert_memory_equal(&after->normal, &before->normal, sizeof before->normal);
        assert_memory_equal(&after->turning, &before->turning, sizeof before->turning);
        assert_true(after->gap == before->gap);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rows_follow_what_stands_or_shifts),
        cmocka_unit_test(rows_of_what_moves_without_a_script_stay),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
