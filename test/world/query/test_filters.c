/* Which objects collide (tulle/query.h): pairs that the host leaves out pass through each other at
 * the start and later, all others are held apart as ever. */
#include "tulle/query.h"

#include "support/pins.h"
#include "support/small_world.h"
#include "support/test_support.h"
#include "tulle/check.h"
#include "tulle/shapes.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

static const double STEP = 1.0 / 64.0; /* [s] */
static tulle_error error;

#define FINE(call)                                                                                 \
    do {                                                                                           \
        if ((call) != TULLE_OK) fail_msg("%s: %s", #call, error.message);                          \
    } while (0)

/* ---- a sheet above a ghost, which lies above a floor ---- */

enum { SHEET, GHOST, FLOOR, OBJECTS };

typedef struct scene {
    tulle_world *world;
    tulle_object_id objects[OBJECTS];
    tulle_mesh sheet, box;
} scene;

/* The ghost is a box from -0.1 to 0.1 m, the floor one from -0.5 to -0.3 m. */
static scene make_scene(double height, double ghost_time) {
    scene made;
    tulle_world_def const def = tulle_world_def_default();
    FINE(tulle_world_create(&def, &made.world, &error));
    made.sheet = small_sheet(0.3, 10, height);
    made.objects[SHEET] = tulle_object_from_cloth(small_add_cloth(made.world, &made.sheet));
    tulle_shape_def shape = tulle_shape_def_default(TULLE_SHAPE_BOX);
    shape.size[0] = shape.size[1] = 0.8;
    shape.size[2] = 0.2;
    made.box = small_shape(shape, 0.0, 0.0, 0.0);
    tulle_obstacle_def ghost = tulle_obstacle_def_default();
    ghost.mesh = tulle_mesh_get_view(&made.box);
    ghost.appear_time = ghost_time;
    tulle_obstacle_id id;
    FINE(tulle_world_add_obstacle(made.world, &ghost, &id, &error));
    made.objects[GHOST] = tulle_object_from_obstacle(id);
    tulle_mesh floor = small_shape(shape, 0.0, 0.0, -0.4);
    made.objects[FLOOR] = tulle_object_from_obstacle(small_add_obstacle(made.world, &floor));
    tulle_mesh_destroy(&floor);
    return made;
}

static void destroy(scene *made) {
    tulle_world_destroy(made->world);
    tulle_mesh_destroy(&made->sheet);
    tulle_mesh_destroy(&made->box);
}

/* Pairs of triangles of two objects that intersect now, as the judge says. */
static size_t judge(const scene *made, int a, int b) {
    tulle_check_body bodies[2];
    static double positions[2][3 * 2000];
    for (int k = 0; k < 2; k++) {
        tulle_object_id const object = made->objects[k == 0 ? a : b];
        tulle_object_info const info = tulle_object_get_info(made->world, object);
        tulle_target const target = {positions[k], sizeof positions[k], 0, TULLE_NUMBER_DOUBLE};
        FINE(
            tulle_object_copy_values(made->world, object, TULLE_VALUES_POSITIONS, &target, &error));
        bodies[k] = (tulle_check_body){
            {positions[k], info.vertex_count, info.triangles, info.triangle_count},
            object.kind == TULLE_OBJECT_OBSTACLE};
    }
    tulle_check_result result;
    FINE(tulle_check_intersections(bodies, 2, 1, &result, &error));
    size_t count = 0;
    for (size_t i = 0; i < result.pair_count; i++)
        count += result.pairs[i].body_a != result.pairs[i].body_b;
    tulle_check_result_destroy(&result);
    return count;
}

/* Until the sheet lies; it must pass the ghost and rest on the floor. */
static void fall_through(const scene *made) {
    size_t inside = 0, contacts = 0;
    for (int i = 0; i < 60; i++) {
        FINE(tulle_world_step(made->world, STEP, NULL, &error));
        assert_int_equal(judge(made, SHEET, FLOOR), 0);
        const double *const middle =
            tulle_cloth_get_positions(made->world, (tulle_cloth_id){0, 1}, NULL) + 3 * 55;
        inside += fabs(middle[2]) < 0.1;
        size_t count;
        FINE(
            tulle_object_copy_contacts(made->world, made->objects[GHOST], NULL, 0, &count, &error));
        assert_int_equal(count, 0);
        FINE(
            tulle_object_copy_contacts(made->world, made->objects[FLOOR], NULL, 0, &count, &error));
        contacts += count;
    }
    assert_true(inside > 0 && contacts > 0);
    tulle_hit hit;
    FINE(tulle_world_find_closest_point(made->world, (double[]){0.0, 0.0, -0.3}, 1.0, 0, &hit,
                                        &error));
    FINE(tulle_world_cast_ray(made->world,
                              &(tulle_ray){.from = {0.01, 0.02, -0.11}, .to = {0.01, 0.02, -1.0}},
                              &hit, &error));
    assert_int_equal(hit.object.kind, TULLE_OBJECT_CLOTH);
    assert_true(hit.position[2] > -0.3 && hit.position[2] < -0.27);
}

/* The ghost and the sheet have no category in common, whichever side says so. */
static void a_filter_lets_pass(void **state) {
    (void)state;
    for (int side = 0; side < 2; side++) {
        scene made = make_scene(0.15, 0.0);
        FINE(tulle_object_set_filter(made.world, made.objects[SHEET], 2, side == 0 ? ~4U : ~0U,
                                     &error));
        FINE(tulle_object_set_filter(made.world, made.objects[GHOST], 4, side == 1 ? ~2U : ~0U,
                                     &error));
        tulle_object_info const info = tulle_object_get_info(made.world, made.objects[GHOST]);
        assert_true(info.category == 4 && info.mask == (side == 1 ? ~2U : ~0U));
        fall_through(&made);
        destroy(&made);
    }
}

/* Sheets that start across the ghost, or within it, or in which it appears, are let be; without the
 * filter each of these is refused. */
static void what_is_left_out_is_not_judged(void **state) {
    (void)state;
    static const struct {
        double height, ghost_time;
    } cases[] = {{0.1, 0.0}, {0.0, 0.0}, {0.1, 0.05}, {0.05, 0.02}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        scene left = make_scene(cases[i].height, cases[i].ghost_time);
        FINE(tulle_object_set_filter(left.world, left.objects[GHOST], 0, 0, &error));
        fall_through(&left);
        destroy(&left);
        scene held = make_scene(cases[i].height, cases[i].ghost_time);
        tulle_status status = TULLE_OK;
        for (int k = 0; k < 10 && status == TULLE_OK; k++)
            status = tulle_world_step(held.world, STEP, NULL, &error);
        if (status != TULLE_ERROR_INTERSECTING_START)
            fail_msg("case %zu: status %d", i, (int)status);
        destroy(&held);
    }
    /* of several pairs only those that are left are told */
    scene both = make_scene(0.15, 0.0);
    tulle_mesh upright = small_sheet(0.7, 10, 0.0);
    for (size_t v = 0; v < upright.vertex_count; v++) {
        upright.positions[3 * v + 2] = upright.positions[3 * v] - 0.1;
        upright.positions[3 * v] = 0.35;
    }
    (void)small_add_cloth(both.world, &upright);
    tulle_mesh_destroy(&upright);
    FINE(tulle_object_set_filter(both.world, both.objects[GHOST], 0, 0, &error));
    assert_int_equal(tulle_world_start(both.world, &error), TULLE_ERROR_INTERSECTING_START);
    size_t count;
    const tulle_intersection *const pairs = tulle_world_get_intersections(both.world, &count);
    assert_true(count > 0);
    for (size_t i = 0; i < count; i++)
        assert_true(pairs[i].object_a == 1 && pairs[i].object_b == FLOOR + 1);
    destroy(&both);
}

/* Filters that leave nothing out change no bit; another choice is another world for saved states.
 */
static void states_know_what_was_left_out(void **state) {
    (void)state;
    scene scenes[3];
    void *bytes[3];
    size_t byte_counts[3];
    for (int k = 0; k < 3; k++) {
        scenes[k] = make_scene(0.15, 0.0);
        if (k == 1)
            FINE(tulle_object_set_filter(scenes[k].world, scenes[k].objects[SHEET], 6, 1, &error));
        if (k == 1)
            for (int o = GHOST; o <= FLOOR; o++)
                FINE(tulle_object_set_filter(scenes[k].world, scenes[k].objects[o], 3, 4, &error));
        if (k == 2)
            FINE(tulle_object_set_filter(scenes[k].world, scenes[k].objects[GHOST], 0, 0, &error));
        for (int i = 0; i < 8; i++) FINE(tulle_world_step(scenes[k].world, STEP, NULL, &error));
        FINE(tulle_world_save_state(scenes[k].world, &bytes[k], &byte_counts[k], &error));
    }
    assert_true(tulle_world_get_state_hash(scenes[0].world) ==
                tulle_world_get_state_hash(scenes[1].world));
    FINE(tulle_world_load_state(scenes[0].world, bytes[1], byte_counts[1], &error));
    for (int k = 0; k < 2; k++)
        assert_int_equal(tulle_world_load_state(scenes[k].world, bytes[2], byte_counts[2], &error),
                         TULLE_ERROR_INVALID_ARGUMENT);
    assert_int_equal(tulle_world_load_state(scenes[2].world, bytes[0], byte_counts[0], &error),
                     TULLE_ERROR_INVALID_ARGUMENT);
    for (int k = 0; k < 3; k++) {
        tulle_world_free_state(scenes[k].world, bytes[k], byte_counts[k]);
        destroy(&scenes[k]);
    }
}

/* ---- the callback ---- */

typedef struct asked {
    const scene *made;
    int counts[OBJECTS][OBJECTS];
    bool refuses_ghost;
} asked;

static int find_object(const scene *made, tulle_object_id id) {
    int k = 0;
    while (k < OBJECTS && memcmp(&id, &made->objects[k], sizeof id) != 0) k++;
    assert_true(k < OBJECTS);
    return k;
}

static int judge_pair(void *context, const tulle_world *world, tulle_object_id a,
                      tulle_object_id b) {
    asked *const self = context;
    assert_ptr_equal(world, self->made->world);
    int const first = find_object(self->made, a), second = find_object(self->made, b);
    self->counts[first][second]++;
    /* it may look at what it is asked about */
    tulle_object_info const info = tulle_object_get_info(world, b);
    assert_true(info.triangle_count > 0);
    return !(self->refuses_ghost && second == GHOST);
}

static void the_host_is_asked_once_for_each_pair(void **state) {
    (void)state;
    scene made = make_scene(0.15, 0.0);
    asked self = {.made = &made, .refuses_ghost = true};
    FINE(tulle_world_set_pair_filter(made.world, judge_pair, &self, &error));
    fall_through(&made);
    for (int a = 0; a < OBJECTS; a++)
        for (int b = 0; b < OBJECTS; b++)
            assert_int_equal(self.counts[a][b], a == SHEET && b != SHEET);
    destroy(&made);

    /* not where filters refuse already, and not after it was taken back */
    made = make_scene(0.15, 0.0);
    self = (asked){.made = &made};
    FINE(tulle_object_set_filter(made.world, made.objects[GHOST], 8, 0, &error));
    FINE(tulle_world_set_pair_filter(made.world, judge_pair, &self, &error));
    FINE(tulle_world_start(made.world, &error));
    assert_true(self.counts[SHEET][FLOOR] == 1 && self.counts[SHEET][GHOST] == 0);
    destroy(&made);
    made = make_scene(0.15, 0.0);
    self = (asked){.made = &made};
    FINE(tulle_world_set_pair_filter(made.world, judge_pair, &self, &error));
    FINE(tulle_world_set_pair_filter(made.world, NULL, NULL, &error));
    FINE(tulle_world_start(made.world, &error));
    assert_int_equal(self.counts[SHEET][FLOOR], 0);
    destroy(&made);
}

/* ---- cloth with cloth, body with body ---- */

/* Three sheets fall on one another: the uppermost passes the middle one and rests on the third. */
static void cloths_pass_each_other(void **state) {
    (void)state;
    tulle_world_def const def = tulle_world_def_default();
    tulle_world *world;
    FINE(tulle_world_create(&def, &world, &error));
    tulle_object_id sheets[3];
    static const uint32_t held[] = {0, 7, 56, 63};
    for (int k = 0; k < 3; k++) {
        tulle_mesh sheet = small_sheet(0.4, 8, -0.1 * k);
        tulle_cloth_def cloth = tulle_cloth_def_default();
        cloth.mesh = tulle_mesh_get_view(&sheet);
        tulle_pin const pin = make_pin(held, 4, (double)INFINITY);
        cloth.pins = &pin;
        cloth.pin_count = k > 0;
        tulle_cloth_id id;
        FINE(tulle_world_add_cloth(world, &cloth, &id, &error));
        sheets[k] = tulle_object_from_cloth(id);
        FINE(tulle_object_set_filter(world, sheets[k], 1U << k, k == 0 ? 4U : 7U, &error));
        tulle_mesh_destroy(&sheet);
    }
    size_t with_middle = 0, with_last = 0;
    for (int i = 0; i < 50; i++) {
        FINE(tulle_world_step(world, STEP, NULL, &error));
        const tulle_contact *contacts;
        size_t count;
        FINE(tulle_world_get_contacts(world, &contacts, &count, &error));
        for (size_t c = 0; c < count; c++) {
            uint32_t const a = contacts[c].object_a, b = contacts[c].object_b;
            with_middle += (a == 0 && b == 1) || (a == 1 && b == 0);
            with_last += (a == 0 && b == 2) || (a == 2 && b == 0);
        }
    }
    assert_true(with_middle == 0 && with_last > 0);
    tulle_world_destroy(world);
}

/* Of two boxes that fall on a third the one that is let through keeps falling. */
static void bodies_pass_each_other(void **state) {
    (void)state;
    tulle_world_def const def = tulle_world_def_default();
    tulle_world *world;
    FINE(tulle_world_create(&def, &world, &error));
    tulle_mesh sheet = small_sheet(0.2, 4, 5.0);
    (void)small_add_cloth(world, &sheet);
    tulle_shape_def shape = tulle_shape_def_default(TULLE_SHAPE_BOX);
    shape.size[0] = shape.size[1] = shape.size[2] = 0.2;
    tulle_obstacle_id bodies[2];
    for (int k = 0; k < 2; k++) {
        tulle_mesh box = small_shape(shape, 2.0 * k, 0.0, 0.25);
        tulle_obstacle_def body = tulle_obstacle_def_default();
        body.mesh = tulle_mesh_get_view(&box);
        body.body = (tulle_body){.is_dynamic = 1, .density = 300.0};
        FINE(tulle_world_add_obstacle(world, &body, &bodies[k], &error));
        tulle_mesh_destroy(&box);
    }
    shape.size[0] = 6.0;
    tulle_mesh floor = small_shape(shape, 0.0, 0.0, 0.0);
    tulle_obstacle_id const ground = small_add_obstacle(world, &floor);
    FINE(tulle_object_set_filter(world, tulle_object_from_obstacle(bodies[1]), 2, 1, &error));
    FINE(tulle_object_set_filter(world, tulle_object_from_obstacle(ground), 1, 1, &error));
    for (int i = 0; i < 32; i++) FINE(tulle_world_step(world, STEP, NULL, &error));
    tulle_transform held, passed;
    FINE(tulle_obstacle_get_transform(world, bodies[0], &held, &error));
    FINE(tulle_obstacle_get_transform(world, bodies[1], &passed, &error));
    assert_true(held.position[2] > 0.2 && passed.position[2] < -0.8);
    tulle_world_destroy(world);
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&floor);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_filter_lets_pass),
        cmocka_unit_test(what_is_left_out_is_not_judged),
        cmocka_unit_test(states_know_what_was_left_out),
        cmocka_unit_test(the_host_is_asked_once_for_each_pair),
        cmocka_unit_test(cloths_pass_each_other),
        cmocka_unit_test(bodies_pass_each_other),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
