/* Edges that rotate about each other in contact: the edge of a rod, pressed on a taut ribbon, turns
 * from a crossing at 90 degrees to one at 10. It never loses the ribbon, and without friction it
 * does not drag it along: the ribbon ends as if the rod had come down at 10 degrees. */
#include "support/contact_world.h"
#include "support/test_support.h"

#include <string.h>

#define TIME_STEP (1.0 / 90.0)
#define TURN_ANGLE 1.3962634015954636 /* 80 degrees */
#define STRETCH 1.02                  /* of the ribbon along its length at the start */
#define PRESS_DEPTH 0.02              /* [m] */
enum { PRESS_STEPS = 30, TURN_BEGIN = 50, TURN_STEPS = 120, END = TURN_BEGIN + TURN_STEPS + 90 };

/* The rod comes down, then turns about the vertical through the middle. */
static void make_rod_motion(bool turns, tulle_keyframe keys[4]) {
    double const times[4] = {0.0, PRESS_STEPS * TIME_STEP, TURN_BEGIN * TIME_STEP,
                             (TURN_BEGIN + TURN_STEPS) * TIME_STEP};
    for (int k = 0; k < 4; k++)
        keys[k] = (tulle_keyframe){.time = times[k],
                                   .translation = {0.0, 0.0, k == 0 ? 0.0 : -PRESS_DEPTH},
                                   .rotation_vector = {0, 0, 0}};
    keys[3].rotation_vector[2] = turns ? TURN_ANGLE : 0.0;
}

/* A prism whose lower edge lies at height z, along y turned by an angle. */
static void add_rod(contact_world *world, double z, double angle) {
    double positions[18];
    for (size_t k = 0; k < 6; k++) {
        double const across = k < 2 ? 0.0 : k < 4 ? 0.03 : -0.03, along = k % 2 ? 0.25 : -0.25;
        double const c = cos(angle), s = sin(angle);
        vec3_store(positions, k,
                   vec3_make(c * across - s * along, s * across + c * along, k < 2 ? z : z + 0.05));
    }
    uint32_t const triangles[24] = {0, 1, 3, 0, 3, 2, 2, 3, 5, 2, 5, 4,
                                    4, 5, 1, 4, 1, 0, 0, 2, 4, 1, 5, 3};
    add_contact_surface(world, (contact_mesh){positions, 6, triangles, 8}, true);
}

enum { COLUMNS = 17, VERTICES = 3 * COLUMNS };

typedef struct turning_result {
    double smallest_gap, largest_gap;     /* [m] while turning */
    double smallest_force, largest_force; /* [N] on the rod */
    double positions[3 * VERTICES];       /* [m] at the end */
} turning_result;

static void measure_step(const contact_world *world, turning_result *result) {
    double force = 0.0;
    for (size_t i = 0; i < world->rows->rows.count; i++) {
        const contact_row *const row = &world->rows->rows.data[i];
        bool const is_cloth_first = row->frame.vertices[0] < world->cloth_vertex_count;
        force += (is_cloth_first ? -1.0 : 1.0) * row->solve.impulse.z / TIME_STEP;
    }
    result->smallest_force = fmin(result->smallest_force, force);
    result->largest_force = fmax(result->largest_force, force);
    result->smallest_gap = fmin(result->smallest_gap, world->report.smallest_gap);
    result->largest_gap = fmax(result->largest_gap, world->report.smallest_gap);
}

/* The rod turns in contact, or before it. */
static turning_result press_ribbon(double friction, bool turns) {
    contact_world world = contact_world_make();
    world.friction = friction;
    world.def.gravity[2] = 0.0;
    tulle_keyframe keys[4];
    make_rod_motion(turns, keys);
    world.motions[1] = (tulle_motion){.keys = keys, .key_count = 4};
    contact_grid ribbon = make_contact_grid(COLUMNS, 3, vec3_make(-0.16, -0.01, 0.0),
                                            vec3_make(0.32, 0.0, 0.0), vec3_make(0.0, 0.02, 0.0));
    add_contact_surface(&world, ribbon.mesh, false);
    for (size_t i = 0; i < VERTICES; i++) ribbon.positions[3 * i] /= STRETCH;
    world.rest_positions = ribbon.positions;
    add_rod(&world, 5e-3, turns ? 0.0 : TURN_ANGLE);
    for (uint32_t k = 0; k < 3; k++) {
        world.pinned[world.pin_count++] = COLUMNS * k;
        world.pinned[world.pin_count++] = COLUMNS * k + COLUMNS - 1;
    }
    start_contact_world(&world);
    free_contact_grid(&ribbon);
    turning_result result = {.smallest_gap = INFINITY, .smallest_force = INFINITY};
    for (int step = 0; step < END; step++) {
        assert_int_equal(step_contact_world(&world, TIME_STEP), TULLE_OK);
        assert_int_equal(judge_contact_world(&world), 0);
        if (step >= TURN_BEGIN) measure_step(&world, &result);
    }
    print_message("mu %.1f, %s: gap %.3g to %.3g mm, force %.3g to %.3g N\n", friction,
                  turns ? "turning" : "straight down", 1e3 * result.smallest_gap,
                  1e3 * result.largest_gap, result.smallest_force, result.largest_force);
    memcpy(result.positions, world.x0, sizeof result.positions);
    assert_int_equal(world.rescue_count, 0);
    contact_world_destroy(&world);
    return result;
}

/* Largest distance between the places of a vertex [m]. */
static double compare_ends(const turning_result *a, const turning_result *b) {
    double largest = 0.0;
    for (size_t i = 0; i < VERTICES; i++)
        largest = fmax(largest,
                       vec3_norm(vec3_sub(vec3_load(a->positions, i), vec3_load(b->positions, i))));
    return largest;
}

static void edges_turn_about_each_other(void **state) {
    (void)state;
    double const contact_distance = 3e-3;
    turning_result const straight = press_ribbon(0.0, false);
    turning_result const smooth = press_ribbon(0.0, true), rough = press_ribbon(0.5, true);
    double const dragged = compare_ends(&smooth, &straight);
    double const dragged_rough = compare_ends(&rough, &straight);
    print_message("dragged by %.3g mm, with friction %.3g mm\n", 1e3 * dragged,
                  1e3 * dragged_rough);
    assert_true(smooth.smallest_gap > 0.8 * contact_distance);
    assert_true(smooth.largest_gap < 1.1 * contact_distance);
    assert_true(smooth.smallest_force > 0.0);
    assert_true(dragged < 0.2 * dragged_rough);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(edges_turn_about_each_other)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
