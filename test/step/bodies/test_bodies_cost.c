/* What a step with bodies costs: in proportion to its contacts, or to its bodies where they fly,
 * and next to nothing asleep. Prints times; asserts counts, and that the time of a contact or of a
 * body that flies hardly grows: what goes with the square of the bodies makes it 16 times as long.
 */
#include "support/body_world.h"
#include "support/test_support.h"
#include "tulle/tulle.h"

#include <math.h>
#include <time.h>

/* Of the time of a contact, or of a body that flies, from 100 bodies to 1,600. */
#define MOST_GROWTH 4.0

/* Means over steps at rest. */
typedef struct step_cost {
    double contacts, pairs, solves, seconds;
    double least_seconds; /* of all steps */
} step_cost;

/* Adds a step. It is timed by the clock of this one thread, whatever else runs. */
static void add_step(tulle_world *world, unsigned step_count, step_cost *sum) {
    clock_t const start = clock();
    tulle_step_report const report = bodies_step(world);
    double const seconds = (double)(clock() - start) / CLOCKS_PER_SEC;
    sum->seconds += seconds / step_count;
    sum->least_seconds = fmin(sum->least_seconds, seconds);
    sum->contacts += (double)report.contacts / step_count;
    sum->pairs += (double)report.box_pairs / step_count;
    sum->solves += (double)report.solve_count / step_count;
}

/* side x side stacks of boxes that have fallen 5 mm on the ground and on one another. */
static step_cost measure(unsigned side, unsigned height, bool sleeps) {
    enum { SETTLING_STEPS = 60, STEPS = 20 };
    tulle_world_def def = tulle_world_def_default();
    def.threads = 1;
    tulle_world *const world = bodies_make_world(&def, false);
    double const extent = 0.3 * side + 1.0, first = -0.15 * (side - 1.0);
    tulle_mesh ground = bodies_make_box(extent, extent, 0.2, (double[3]){0.0, 0.0, -0.1});
    tulle_body const body = {.is_dynamic = 1,
                             .density = 500.0,
                             .sleep_speed = sleeps ? 0.01 : 0.0,
                             .sleep_time = sleeps ? 0.2 : 0.0};
    bodies_add_obstacle(world, &ground, 0.5, NULL);
    for (unsigned i = 0; i < side * side * height; i++) {
        double const at[3] = {first + 0.3 * (i / height % side), first + 0.3 * (i / height / side),
                              0.06 + 0.11 * (i % height)};
        tulle_mesh box = bodies_make_box(0.2, 0.2, 0.1, at);
        bodies_add_obstacle(world, &box, 0.5, &body);
        tulle_mesh_destroy(&box);
    }
    for (int i = 0; i < SETTLING_STEPS; i++) bodies_step(world);
    step_cost sum = {.least_seconds = (double)INFINITY};
    for (int i = 0; i < STEPS; i++) add_step(world, STEPS, &sum);
    print_message("%3u boxes in stacks of %u%s: %.0f contacts, %.0f pairs, %.1f solves, %.2f ms a "
                  "step, %.1f us a contact\n",
                  side * side * height, height, sleeps ? ", asleep" : "", sum.contacts, sum.pairs,
                  sum.solves, 1e3 * sum.seconds,
                  sum.contacts > 0.0 ? 1e6 * sum.seconds / sum.contacts : 0.0);
    tulle_mesh_destroy(&ground);
    tulle_world_destroy(world);
    return sum;
}

/* side x side boxes that fall freely. */
static step_cost measure_flight(unsigned side) {
    enum { STEPS = 20 };
    tulle_world_def def = tulle_world_def_default();
    def.threads = 1;
    tulle_world *const world = bodies_make_world(&def, false);
    tulle_body const body = {.is_dynamic = 1, .density = 500.0};
    for (unsigned i = 0; i < side * side; i++) {
        double const at[3] = {0.3 * (i % side), 0.3 * (i / side), 0.0};
        tulle_mesh box = bodies_make_box(0.2, 0.2, 0.1, at);
        bodies_add_obstacle(world, &box, 0.5, &body);
        tulle_mesh_destroy(&box);
    }
    (void)bodies_step(world);
    step_cost sum = {.least_seconds = (double)INFINITY};
    for (int i = 0; i < STEPS; i++) add_step(world, STEPS, &sum);
    print_message("%4u boxes in flight: %.3f ms a step at least, %.2f us a box\n", side * side,
                  1e3 * sum.least_seconds, 1e6 * sum.least_seconds / (side * side));
    tulle_world_destroy(world);
    return sum;
}

static void cost_grows_with_contacts(void **state) {
    (void)state;
    for (unsigned height = 1; height <= 2; height++) {
        step_cost const few = measure(3, height, false), many = measure(9, height, false);
        assert_true(fabs(many.contacts / few.contacts - 9.0) < 0.3);
        assert_true(fabs(many.pairs / few.pairs - 9.0) < 0.3);
        assert_true(few.solves < 1.5 && many.solves < 1.5);
    }
    step_cost const asleep = measure(9, 3, true);
    assert_true(asleep.contacts == 0.0 && asleep.pairs == 0.0);
}

static void many_bodies_cost_no_more_each(void **state) {
    (void)state;
    unsigned const sides[] = {10, 20, 40};
    double contact[3], flight[3];
    for (size_t i = 0; i < 3; i++) {
        step_cost const at_rest = measure(sides[i], 1, false);
        assert_true(fabs(at_rest.contacts / (sides[i] * sides[i]) - 4.0) < 0.1);
        contact[i] = at_rest.least_seconds / at_rest.contacts;
        flight[i] = measure_flight(sides[i]).least_seconds / (sides[i] * sides[i]);
    }
    for (size_t i = 1; i < 3; i++) {
        assert_true(contact[i] < MOST_GROWTH * contact[0]);
        assert_true(flight[i] < MOST_GROWTH * flight[0]);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cost_grows_with_contacts),
        cmocka_unit_test(many_bodies_cost_no_more_each),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
