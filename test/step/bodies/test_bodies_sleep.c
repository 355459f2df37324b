/* Bodies that fall asleep: who sleeps and when, that they stand still, and what wakes them. */
#include "support/body_world.h"
#include "support/test_support.h"
#include "tulle/tulle.h"

#include <math.h>
#include <string.h>

enum { STACK = 3, BALL = STACK };
#define SLEEP_SPEED 0.01
#define SLEEP_TIME 0.3

/* A stack of three boxes on the ground, and a ball thrown at it, which flies by at first. */
typedef struct pile {
    tulle_world *world;
    tulle_obstacle_id boxes[STACK + 1];
    tulle_obstacle_id ground, door; /* the door slides in from afar */
} pile;

typedef struct pile_def {
    double sleep_speed, throw_time; /* the ball comes then; 0: never */
    double door_time, leave_time;   /* the door moves then; the ground leaves then; 0: never */
    int threads;
} pile_def;

static pile make_pile(pile_def def) {
    tulle_world_def world_def = tulle_world_def_default();
    world_def.threads = def.threads;
    pile made = {.world = bodies_make_world(&world_def, false)};
    tulle_body body = {.is_dynamic = 1,
                       .density = 500.0,
                       .sleep_speed = def.sleep_speed,
                       .sleep_time = def.sleep_speed > 0.0 ? SLEEP_TIME : 0.0};
    tulle_mesh ground = bodies_make_box(2.0, 2.0, 0.2, (double[3]){0.0, 0.0, -0.1});
    tulle_mesh door = bodies_make_box(0.1, 0.5, 0.5, (double[3]){-0.9, 0.0, 0.3});
    tulle_keyframe const keys[2] = {{.time = def.door_time, .rotation_vector = {0, 0, 0}},
                                    {.time = def.door_time + 1.0,
                                     .translation = {0.79, 0.0, 0.0},
                                     .rotation_vector = {0, 0, 0}}};
    tulle_obstacle_def obstacle = tulle_obstacle_def_default();
    obstacle.friction = 0.5;
    for (int i = 0; i < STACK; i++) {
        tulle_mesh box =
            bodies_make_box(0.2, 0.2, 0.1, (double[3]){0.01 * i, 0.0, 0.06 + 0.11 * i});
        made.boxes[i] = bodies_add_obstacle(made.world, &box, 0.5, &body);
        tulle_mesh_destroy(&box);
    }
    tulle_mesh ball = bodies_make_ball(0.05, 4, (double[3]){1.1, 0.0, 0.28});
    if (def.throw_time > 0.0) {
        body.start_time = def.throw_time;
        tulle_keyframe const throw[2] = {
            {.time = def.throw_time - 0.1, .rotation_vector = {0, 0, 0}},
            {.time = def.throw_time + 0.1,
             .translation = {-1.2, 0.0, 0.0},
             .rotation_vector = {0, 0, 0}}};
        obstacle.mesh = tulle_mesh_get_view(&ball);
        obstacle.motion = (tulle_motion){.keys = throw, .key_count = 2};
        obstacle.body = body;
        assert_int_equal(tulle_world_add_obstacle(made.world, &obstacle, &made.boxes[BALL], NULL),
                         TULLE_OK);
        obstacle.body = (tulle_body){0};
    }
    obstacle.mesh = tulle_mesh_get_view(&ground);
    obstacle.motion = (tulle_motion){0};
    if (def.leave_time > 0.0) obstacle.disappear_time = def.leave_time;
    assert_int_equal(tulle_world_add_obstacle(made.world, &obstacle, &made.ground, NULL), TULLE_OK);
    obstacle.disappear_time = INFINITY;
    obstacle.mesh = tulle_mesh_get_view(&door);
    if (def.door_time > 0.0) obstacle.motion = (tulle_motion){.keys = keys, .key_count = 2};
    assert_int_equal(tulle_world_add_obstacle(made.world, &obstacle, &made.door, NULL), TULLE_OK);
    tulle_mesh_destroy(&ground);
    tulle_mesh_destroy(&door);
    tulle_mesh_destroy(&ball);
    assert_int_equal(tulle_world_start(made.world, NULL), TULLE_OK);
    return made;
}

/* How many boxes sleep; it must be none or all. */
static int count_sleepers(const pile *p) {
    int count = 0;
    for (int i = 0; i < STACK; i++) count += tulle_obstacle_is_asleep(p->world, p->boxes[i]);
    assert_true(count == 0 || count == STACK);
    return count;
}

/* Steps until the boxes sleep; the number of steps. */
static int step_until_sleep(const pile *p) {
    int count = 0;
    while (count_sleepers(p) == 0) {
        assert_true(count++ < 400);
        bodies_step(p->world);
    }
    return count;
}

/* Steps until the boxes wake. */
static int step_until_awake(const pile *p) {
    int count = 0;
    while (count_sleepers(p) > 0) {
        assert_true(count++ < 400);
        bodies_step(p->world);
    }
    return count;
}

static int transforms_differ(const pile *a, const pile *b) {
    int differ = 0;
    for (int i = 0; i < STACK; i++) {
        tulle_transform const ta = bodies_get_transform(a->world, a->boxes[i]);
        tulle_transform const tb = bodies_get_transform(b->world, b->boxes[i]);
        differ |= memcmp(&ta, &tb, sizeof ta) != 0;
    }
    return differ;
}

/* The boxes fall asleep at once, all of them; until then nothing is other than without sleep, and
 * then they stand still to the bit, without contacts or pairs. */
static void a_stack_falls_asleep_whole(void **state) {
    (void)state;
    pile const sleepy = make_pile((pile_def){.sleep_speed = SLEEP_SPEED});
    pile const plain = make_pile((pile_def){0});
    int steps = 0;
    tulle_step_report report = {0};
    while (count_sleepers(&sleepy) == 0) {
        assert_int_equal(transforms_differ(&sleepy, &plain), 0);
        assert_true(steps++ < 300);
        bodies_step(sleepy.world);
        report = bodies_step(plain.world);
    }
    assert_true(steps * BODIES_STEP > SLEEP_TIME);
    uint64_t const pairs = report.box_pairs;
    assert_true(report.contacts > 0 && pairs > 0);
    tulle_transform before[STACK];
    for (int i = 0; i < STACK; i++) {
        before[i] = bodies_get_transform(sleepy.world, sleepy.boxes[i]);
        double impulse[3], moment[3];
        assert_int_equal(tulle_obstacle_get_contact_impulse(sleepy.world, sleepy.boxes[i], impulse,
                                                            moment, NULL),
                         TULLE_OK);
        /* what it rested with stays known */
        assert_true(fabs(impulse[2] / (before[i].mass * 9.81 * BODIES_STEP) - 1.0) < 1e-3);
    }
    for (int k = 0; k < 60; k++) {
        report = bodies_step(sleepy.world);
        assert_int_equal(report.contacts, 0);
        assert_int_equal(report.box_pairs, 0);
        assert_true(report.kinetic_energy == 0.0);
    }
    for (int i = 0; i < STACK; i++) {
        tulle_transform const now = bodies_get_transform(sleepy.world, sleepy.boxes[i]);
        assert_memory_equal(&now, &before[i], sizeof now);
    }
    assert_int_equal(count_sleepers(&sleepy), STACK);
    print_message("asleep after %d steps; %llu pairs a step before, none after\n", steps,
                  (unsigned long long)pairs);
    tulle_world_destroy(sleepy.world);
    tulle_world_destroy(plain.world);
}

/* [N s] Along x, of the boxes and the ball. */
static double find_momentum(const pile *p) {
    double sum = 0.0;
    for (int b = 0; b <= BALL; b++) {
        tulle_transform const t = bodies_get_transform(p->world, p->boxes[b]);
        sum += t.mass * t.velocity[0];
    }
    return sum;
}

/* A ball that flies against the top box wakes all of them in that very step, and gives them its
 * momentum as it does to a stack that never slept. They fall asleep again. */
static void a_ball_wakes_the_stack(void **state) {
    (void)state;
    enum { STEPS = 60 };
    double const throw_time = 2.0;
    double momenta[2][STEPS], speed[2];
    int woken_at = -1;
    for (int is_sleepy = 0; is_sleepy < 2; is_sleepy++) {
        pile const p = make_pile(
            (pile_def){.sleep_speed = is_sleepy ? SLEEP_SPEED : 0.0, .throw_time = throw_time});
        while (tulle_world_get_time(p.world) < throw_time - 0.05) bodies_step(p.world);
        assert_int_equal(count_sleepers(&p), is_sleepy ? STACK : 0);
        speed[is_sleepy] = 0.0;
        for (int i = 0; i < STEPS; i++) {
            int const slept = count_sleepers(&p);
            bodies_step(p.world);
            momenta[is_sleepy][i] = find_momentum(&p);
            if (slept > 0 && count_sleepers(&p) == 0) woken_at = i;
            tulle_transform const top = bodies_get_transform(p.world, p.boxes[STACK - 1]);
            speed[is_sleepy] = fmax(speed[is_sleepy], -top.velocity[0]);
        }
        while (is_sleepy && tulle_world_get_time(p.world) < 5.0) bodies_step(p.world);
        for (int b = 0; b < STACK && is_sleepy; b++)
            assert_true(tulle_obstacle_is_asleep(p.world, p.boxes[b]));
        tulle_world_destroy(p.world);
    }
    assert_true(woken_at > 0);
    double const before = momenta[1][woken_at - 1],
                 off = momenta[1][woken_at] - momenta[0][woken_at];
    print_message("woken in step %d: momentum %.5f to %.5f, never asleep %.5f; top box %.5f and "
                  "%.5f m/s\n",
                  woken_at, before, momenta[1][woken_at], momenta[0][woken_at], speed[1], speed[0]);
    assert_true(speed[0] > 0.2 && fabs(speed[1] / speed[0] - 1.0) < 0.01);
    assert_true(fabs(off) < 0.01 * fabs(before));
}

/* An obstacle that moves up to the stack, one on which it stands that leaves, an impulse of the
 * user, a call: each wakes all. */
static void other_things_wake_it(void **state) {
    (void)state;
    pile p = make_pile((pile_def){.sleep_speed = SLEEP_SPEED, .door_time = 3.0});
    step_until_sleep(&p);
    step_until_awake(&p);
    assert_true(tulle_world_get_time(p.world) > 3.0 && tulle_world_get_time(p.world) < 4.0);
    double const x = bodies_get_transform(p.world, p.boxes[2]).position[0];
    while (tulle_world_get_time(p.world) < 4.0) bodies_step(p.world);
    assert_true(bodies_get_transform(p.world, p.boxes[2]).position[0] > x + 0.01); /* pushed */
    tulle_world_destroy(p.world);

    p = make_pile((pile_def){.sleep_speed = SLEEP_SPEED, .leave_time = 3.0});
    step_until_sleep(&p);
    step_until_awake(&p);
    for (int i = 0; i < 5; i++) bodies_step(p.world);
    assert_true(bodies_get_transform(p.world, p.boxes[0]).velocity[2] < -0.4);
    tulle_world_destroy(p.world);

    p = make_pile((pile_def){.sleep_speed = SLEEP_SPEED});
    step_until_sleep(&p);
    assert_int_equal(tulle_obstacle_wake(p.world, p.boxes[1], NULL), TULLE_OK);
    assert_int_equal(count_sleepers(&p), 0);
    assert_true(step_until_sleep(&p) >= (int)(SLEEP_TIME / BODIES_STEP));
    double const push[3] = {0.0, 0.5, 0.0}, at[3] = {0.02, 0.0, 0.27};
    assert_int_equal(tulle_obstacle_add_impulse(p.world, p.boxes[2], at, push, NULL), TULLE_OK);
    assert_int_equal(count_sleepers(&p), 0);
    bodies_step(p.world);
    assert_true(bodies_get_transform(p.world, p.boxes[2]).velocity[1] > 0.05);
    assert_int_equal(tulle_obstacle_wake(p.world, p.ground, NULL), TULLE_ERROR_INVALID_ARGUMENT);
    assert_int_equal(tulle_obstacle_is_asleep(p.world, p.ground), 0);
    tulle_world_destroy(p.world);
}

/* Sleeping is part of the state: for any threads and over checkpoints, one of them while the stack
 * sleeps, the same hash follows. */
static void the_future_is_the_same(void **state) {
    (void)state;
    static const int threads[] = {1, 2, 5};
    uint64_t hash = 0;
    for (int i = 0; i < 3; i++) {
        pile_def const def = {.sleep_speed = SLEEP_SPEED, .throw_time = 2.0, .threads = threads[i]};
        pile p = make_pile(def);
        step_until_sleep(&p);
        bodies_step(p.world);
        if (i == 1) {
            void *bytes;
            size_t count;
            pile next = make_pile(def);
            assert_int_equal(tulle_world_save_state(p.world, &bytes, &count, NULL), TULLE_OK);
            assert_int_equal(tulle_world_load_state(next.world, bytes, count, NULL), TULLE_OK);
            assert_int_equal(count_sleepers(&next), STACK);
            tulle_world_free_state(p.world, bytes, count);
            tulle_world_destroy(p.world);
            p = next;
        }
        while (tulle_world_get_time(p.world) < 2.3) bodies_step(p.world);
        assert_int_equal(count_sleepers(&p), 0);
        uint64_t const now = tulle_world_get_state_hash(p.world);
        if (i > 0) assert_true(now == hash);
        hash = now;
        tulle_world_destroy(p.world);
    }
}

static void bad_values_are_refused(void **state) {
    (void)state;
    tulle_world_def def = tulle_world_def_default();
    tulle_world *const world = bodies_make_world(&def, false);
    tulle_mesh box = bodies_make_box(0.1, 0.1, 0.1, (double[3]){0.0, 0.0, 0.0});
    tulle_obstacle_def obstacle = tulle_obstacle_def_default();
    obstacle.mesh = tulle_mesh_get_view(&box);
    static const double speeds[] = {-1.0, (double)NAN, 0.01}, times[] = {0.5, 0.5, 0.0};
    static const char *const parts[] = {"sleep_speed", "sleep_speed", "sleep_time"};
    for (int i = 0; i < 3; i++) {
        tulle_error error = {0};
        obstacle.body = (tulle_body){
            .is_dynamic = 1, .mass = 1.0, .sleep_speed = speeds[i], .sleep_time = times[i]};
        assert_int_equal(tulle_world_add_obstacle(world, &obstacle, NULL, &error),
                         TULLE_ERROR_INVALID_ARGUMENT);
        assert_non_null(strstr(error.message, parts[i]));
    }
    tulle_mesh_destroy(&box);
    tulle_world_destroy(world);
}

/* A box of 0.2 m sleeps on the ground. From 1 s to 2 s a small one passes it at a clearance [m],
 * along the next axis: on side 0, 1, 2 (+x, +y, +z), 3 or 4 (-x, -y). Where the small one is along
 * its way when the sleeper wakes, or NAN. */
static double pass_by(int side, double clearance) {
    double const separation = 0.02, reach = 0.6;
    int const axis = side % 3, along = (axis + 1) % 3;
    tulle_world_def def = tulle_world_def_default();
    def.threads = 1;
    def.separation_distance = separation;
    tulle_world *const world = bodies_make_world(&def, false);
    tulle_body const body = {
        .is_dynamic = 1, .density = 500.0, .sleep_speed = SLEEP_SPEED, .sleep_time = SLEEP_TIME};
    tulle_mesh ground = bodies_make_box(2.0, 2.0, 0.2, (double[3]){0.0, 0.0, -0.1});
    tulle_mesh box = bodies_make_box(0.2, 0.2, 0.2, (double[3]){0.0, 0.0, 0.105});
    double at[3] = {0.0, 0.0, axis == 2 ? 0.105 : 0.12};
    at[axis] += (side < 3 ? 1.0 : -1.0) * (0.1 + clearance + 0.025);
    at[along] -= reach;
    if (along == 2) at[2] += reach + 0.6; /* downwards, and not into the ground */
    tulle_mesh small = bodies_make_box(0.05, 0.05, 0.05, at);
    tulle_keyframe keys[2] = {{.time = 1.0, .rotation_vector = {0, 0, 0}},
                              {.time = 2.0, .rotation_vector = {0, 0, 0}}};
    keys[1].translation[along] = along == 2 ? -0.6 : 2.0 * reach;
    (void)bodies_add_obstacle(world, &ground, 0.5, NULL);
    tulle_obstacle_id const sleeper = bodies_add_obstacle(world, &box, 0.5, &body);
    tulle_obstacle_def obstacle = tulle_obstacle_def_default();
    obstacle.mesh = tulle_mesh_get_view(&small);
    obstacle.motion = (tulle_motion){.keys = keys, .key_count = 2};
    assert_int_equal(tulle_world_add_obstacle(world, &obstacle, NULL, NULL), TULLE_OK);
    tulle_mesh_destroy(&ground);
    tulle_mesh_destroy(&box);
    tulle_mesh_destroy(&small);
    while (tulle_world_get_time(world) < 1.0 - 0.5 * BODIES_STEP) bodies_step(world);
    assert_true(tulle_obstacle_is_asleep(world, sleeper));
    double place = (double)NAN;
    while (isnan(place) && tulle_world_get_time(world) < 2.1) {
        bodies_step(world);
        if (!tulle_obstacle_is_asleep(world, sleeper))
            place = at[along] + keys[1].translation[along] * (tulle_world_get_time(world) - 1.0);
    }
    tulle_world_destroy(world);
    return along == 2 ? place - 0.105 : place;
}

/* What passes a sleeper within the separation distance wakes it, on whatever side and no sooner;
 * what passes farther away does not. */
static void what_passes_near_wakes(void **state) {
    (void)state;
    for (int side = 0; side < 5; side++) {
        double const place = pass_by(side, 0.013), reach = 0.1 + 0.025 + 0.02;
        print_message("side %d: wakes at %.3f m\n", side, place);
        assert_true(fabs(place) <= reach && fabs(place) >= reach - 1.2 * BODIES_STEP - 0.005);
        assert_true(isnan(pass_by(side, 0.027)));
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_stack_falls_asleep_whole), cmocka_unit_test(a_ball_wakes_the_stack),
        cmocka_unit_test(other_things_wake_it),       cmocka_unit_test(the_future_is_the_same),
        cmocka_unit_test(bad_values_are_refused),     cmocka_unit_test(what_passes_near_wakes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
