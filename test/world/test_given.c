/* Motion that the host gives step by step (tulle/live.h), against scripts and sequences that say
 * the same. Times and places are dyadic where bits are compared. */
#include "tulle/live.h"

#include "base/hash.h"
#include "support/pins.h"
#include "support/small_world.h"
#include "support/test_support.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static const double STEP = 1.0 / 64.0; /* [s] */
enum { STEPS = 48 };
static const double NO_TURN[4] = {1.0, 0.0, 0.0, 0.0};

static void expect(tulle_status wanted, tulle_status status, const tulle_error *error) {
    if (status != wanted)
        fail_msg("status %d, not %d: %s", (int)status, (int)wanted, error->message);
}

/* ---- a sheet on a plate ---- */

/* Where the plate is at the end of step i - 1, i from 0: it slides, then rises, faster and faster
 * where the motion is fast. */
typedef struct journey {
    double places[STEPS + 1][3]; /* [m] */
} journey;

static journey make_journey(bool is_fast) {
    journey made = {{{0}}};
    for (int i = 0; i < STEPS; i++) {
        const double *const here = made.places[i];
        double *const next = made.places[i + 1];
        memcpy(next, here, sizeof made.places[i]);
        if (i >= 8 && i < 32) next[0] += ldexp(1.0, -9) * (i - 8 < 4 ? i - 8 : 4);
        if (i >= 32) next[2] += ldexp(1.0, -8) * (is_fast && i == 40 ? 12 : 1);
    }
    return made;
}

typedef enum plate_kind { ON_KEYS, ON_FRAMES, RIGID, DEFORMING } plate_kind;

typedef struct stage {
    tulle_mesh sheet, plate;
    tulle_world *world;
    tulle_cloth_id cloth;
    tulle_obstacle_id id;
    plate_kind kind;
    journey journey;
    uint32_t substeps; /* the most in a step */
} stage;

static void place_plate(const stage *made, const double place[3], double *positions) {
    for (size_t i = 0; i < 3 * made->plate.vertex_count; i++)
        positions[i] = made->plate.positions[i] + place[i % 3];
}

static tulle_status read_frame(void *context, uint32_t frame, double *positions,
                               tulle_error *error) {
    (void)error;
    const stage *const made = context;
    place_plate(made, made->journey.places[frame], positions);
    return TULLE_OK;
}

static void make_stage(stage *made, plate_kind kind, bool is_fast, int threads) {
    *made = (stage){.kind = kind, .journey = make_journey(is_fast)};
    made->sheet = small_sheet(0.25, 9, 0.0);
    tulle_shape_def shape = tulle_shape_def_default(TULLE_SHAPE_BOX);
    shape.size[0] = shape.size[1] = 0.5;
    shape.size[2] = 0.0625;
    made->plate = small_shape(shape, 0.0, 0.0, -0.046875);
    for (size_t i = 0; i < 3 * made->plate.vertex_count; i++) /* so that sums are exact */
        made->plate.positions[i] = ldexp(round(ldexp(made->plate.positions[i], 12)), -12) *
                                   (is_fast && i % 3 < 2 ? 0.25 : 1.0);
    tulle_world_def world_def = tulle_world_def_default();
    world_def.threads = threads;
    tulle_error error = {0};
    expect(TULLE_OK, tulle_world_create(&world_def, &made->world, &error), &error);
    static const uint32_t corners[4] = {0, 8, 72, 80};
    tulle_pin const pin = make_pin(corners, 4, 1e9);
    tulle_cloth_def cloth_def = tulle_cloth_def_default();
    cloth_def.mesh = tulle_mesh_get_view(&made->sheet);
    cloth_def.pins = &pin;
    cloth_def.pin_count = is_fast;
    cloth_def.material.restitution = 0.25;
    expect(TULLE_OK, tulle_world_add_cloth(made->world, &cloth_def, &made->cloth, &error), &error);
    tulle_obstacle_def def = tulle_obstacle_def_default();
    def.mesh = tulle_mesh_get_view(&made->plate);
    def.friction = 0.8;
    def.restitution = 0.25;
    static tulle_keyframe keys[STEPS + 1];
    for (int i = 0; i <= STEPS; i++) {
        keys[i] = (tulle_keyframe){.time = i * STEP, .rotation_vector = {0, 0, 0}};
        memcpy(keys[i].translation, made->journey.places[i], sizeof keys[i].translation);
    }
    if (kind == ON_KEYS) def.motion = (tulle_motion){.keys = keys, .key_count = STEPS + 1};
    if (kind == ON_FRAMES) {
        def.read_frame = read_frame;
        def.frame_context = made;
        def.frame_count = STEPS + 1;
        def.frame_interval = STEP;
    }
    if (kind == RIGID) def.drive = TULLE_DRIVE_RIGID;
    if (kind == DEFORMING) def.drive = TULLE_DRIVE_DEFORMING;
    expect(TULLE_OK, tulle_world_add_obstacle(made->world, &def, &made->id, &error), &error);
    expect(TULLE_OK, tulle_world_start(made->world, &error), &error);
}

static void free_stage(stage *made) {
    tulle_world_destroy(made->world);
    tulle_mesh_destroy(&made->sheet);
    tulle_mesh_destroy(&made->plate);
}

static tulle_status give(const stage *made, const double place[3], tulle_travel travel,
                         tulle_error *error) {
    if (made->kind == RIGID)
        return tulle_obstacle_set_next_transform(made->world, made->id, place, NO_TURN, travel,
                                                 error);
    double *const positions = malloc(3 * made->plate.vertex_count * sizeof(double));
    assert_non_null(positions);
    place_plate(made, place, positions);
    tulle_status const status = tulle_obstacle_set_next_positions(
        made->world, made->id, positions, made->plate.vertex_count, travel, error);
    free(positions);
    return status;
}

/* Gives what the world needs, and steps. */
static void go_on(stage *made) {
    tulle_error error = {0};
    uint64_t const i = tulle_world_get_step_count(made->world);
    if (made->kind >= RIGID)
        expect(TULLE_OK, give(made, made->journey.places[i + 1], TULLE_TRAVEL_MOVE, &error),
               &error);
    tulle_step_report report;
    expect(TULLE_OK, tulle_world_step(made->world, STEP, &report, &error), &error);
    if (report.substeps > made->substeps) made->substeps = report.substeps;
    assert_int_equal(small_judge(made->world, &made->sheet, 1, &made->plate, 1), 0);
}

/* Hash of what there is to see: positions, velocities, contacts with their impulses. The state hash
 * also holds the pose of what is driven as a whole. */
static uint64_t hash_sight(const stage *made) {
    size_t count;
    uint64_t hash = HASH_SEED;
    for (int k = 0; k < 2; k++) {
        const double *const cloth =
            k == 0 ? tulle_cloth_get_positions(made->world, made->cloth, &count)
                   : tulle_cloth_get_velocities(made->world, made->cloth, &count);
        hash = hash_bytes(hash, cloth, 3 * count * sizeof *cloth);
        const double *const plate =
            k == 0 ? tulle_obstacle_get_positions(made->world, made->id, &count)
                   : tulle_obstacle_get_velocities(made->world, made->id, &count);
        hash = hash_bytes(hash, plate, 3 * count * sizeof *plate);
    }
    const tulle_contact *contacts;
    tulle_error error = {0};
    expect(TULLE_OK, tulle_world_get_contacts(made->world, &contacts, &count, &error), &error);
    return hash_bytes(hash, contacts, count * sizeof *contacts);
}

static void what_is_given_moves_as_a_script_does(void **state) {
    (void)state;
    for (int is_fast = 0; is_fast < 2; is_fast++) {
        stage on_keys, on_frames, rigid, deforming;
        make_stage(&on_keys, ON_KEYS, is_fast, 1);
        make_stage(&on_frames, ON_FRAMES, is_fast, 1);
        make_stage(&rigid, RIGID, is_fast, 1);
        make_stage(&deforming, DEFORMING, is_fast, 1);
        for (int i = 0; i < STEPS; i++) {
            go_on(&on_keys);
            go_on(&on_frames);
            go_on(&rigid);
            go_on(&deforming);
            if (hash_sight(&rigid) != hash_sight(&on_keys))
                fail_msg("step %d, fast %d: driven as a whole it is not as on keyframes", i,
                         is_fast);
            if (hash_sight(&deforming) != hash_sight(&on_frames))
                fail_msg("step %d, fast %d: deforming it is not as a sequence", i, is_fast);
        }
        assert_true(tulle_world_get_state_hash(deforming.world) ==
                    tulle_world_get_state_hash(on_frames.world));
        print_message("fast %d: at most %u substeps\n", is_fast, on_keys.substeps);
        assert_true(is_fast ? on_keys.substeps > 1 : on_keys.substeps == 1);
        assert_int_equal(rigid.substeps, on_keys.substeps);
        free_stage(&on_keys);
        free_stage(&on_frames);
        free_stage(&rigid);
        free_stage(&deforming);
    }
}

/* A turn about a pivot away from the middle, against a script of two keyframes. Poses in between
 * differ by rounding alone, which friction makes some ten times larger every other step. */
static void compare_turns(int steps, const double axis[3], double full, double room,
                          uint32_t substeps) {
    double const half = 0.5 * full, pivot[3] = {0.125, 0.0, 0.0};
    stage made;
    make_stage(&made, RIGID, substeps > 1, 1); /* pinned */
    tulle_world_destroy(made.world);
    tulle_world *worlds[2];
    tulle_obstacle_id ids[2];
    tulle_keyframe const keys[2] = {
        {.rotation_vector = {0, 0, 0}},
        {steps * STEP, {0.0, 0.0, 0.0625}, {full * axis[0], full * axis[1], full * axis[2]}}};
    tulle_error error = {0};
    for (int k = 0; k < 2; k++) {
        tulle_world_def const def = tulle_world_def_default();
        expect(TULLE_OK, tulle_world_create(&def, &worlds[k], &error), &error);
        static const uint32_t corners[4] = {0, 8, 72, 80};
        tulle_pin const pin = make_pin(corners, 4, 1e9);
        tulle_cloth_def cloth = tulle_cloth_def_default();
        cloth.mesh = tulle_mesh_get_view(&made.sheet);
        cloth.pins = &pin;
        cloth.pin_count = substeps > 1;
        expect(TULLE_OK, tulle_world_add_cloth(worlds[k], &cloth, &made.cloth, &error), &error);
        tulle_obstacle_def plate = tulle_obstacle_def_default();
        plate.mesh = tulle_mesh_get_view(&made.plate);
        plate.friction = 0.8;
        if (k == 0) plate.motion = (tulle_motion){.keys = keys, .key_count = 2};
        if (k == 1) plate.drive = TULLE_DRIVE_RIGID;
        memcpy(plate.motion.pivot, pivot, sizeof pivot);
        expect(TULLE_OK, tulle_world_add_obstacle(worlds[k], &plate, &ids[k], &error), &error);
        expect(TULLE_OK, tulle_world_start(worlds[k], &error), &error);
    }
    double farthest = 0.0; /* [m] */
    for (int i = 1; i <= steps; i++) {
        double const angle = half * i / steps, sine = sin(angle);
        double const place[3] = {0.0, 0.0, 0.0625 * i / steps};
        double const turn[4] = {cos(angle), sine * axis[0], sine * axis[1], sine * axis[2]};
        tulle_step_report reports[2];
        expect(TULLE_OK,
               tulle_obstacle_set_next_transform(worlds[1], ids[1], place, turn, TULLE_TRAVEL_MOVE,
                                                 &error),
               &error);
        for (int k = 0; k < 2; k++)
            expect(TULLE_OK, tulle_world_step(worlds[k], STEP, &reports[k], &error), &error);
        assert_int_equal(reports[0].substeps, reports[1].substeps);
        if (reports[0].substeps < substeps) fail_msg("%u substeps", reports[0].substeps);
        size_t counts[2];
        const double *const plates[2] = {tulle_obstacle_get_positions(worlds[0], ids[0], counts),
                                         tulle_obstacle_get_positions(worlds[1], ids[1], counts)};
        for (size_t v = 0; v < 3 * counts[0]; v++)
            assert_true(fabs(plates[0][v] - plates[1][v]) < 1e-14);
        const double *const sheets[2] = {
            tulle_cloth_get_positions(worlds[0], made.cloth, counts),
            tulle_cloth_get_positions(worlds[1], made.cloth, counts + 1)};
        for (size_t v = 0; v < 3 * counts[0]; v++)
            farthest = fmax(farthest, fabs(sheets[0][v] - sheets[1][v]));
    }
    if (!(farthest < room)) fail_msg("the sheets are %g m apart", farthest);
    for (int k = 0; k < 2; k++) tulle_world_destroy(worlds[k]);
    tulle_mesh_destroy(&made.sheet);
    tulle_mesh_destroy(&made.plate);
}

static void turns_are_as_of_a_script(void **state) {
    (void)state;
    compare_turns(16, (double[]){0.0, 0.0, 1.0}, 0.5 * acos(-1.0), 1e-7, 1);
    compare_turns(1, (double[]){0.0, -1.0, 0.0}, 0.1, 1e-7, 2); /* in substeps */
}

/* Friction takes a sheet along: its speed is the plate's, of 4 / 512 m a step. */
static void a_driven_plate_carries_cloth(void **state) {
    (void)state;
    for (plate_kind kind = RIGID; kind <= DEFORMING; kind++) {
        stage made;
        make_stage(&made, kind, false, 1);
        for (int i = 0; i < 32; i++) go_on(&made);
        size_t count;
        const double *const v = tulle_cloth_get_velocities(made.world, made.cloth, &count);
        const double *const plate = tulle_obstacle_get_velocities(made.world, made.id, NULL);
        double const speed = ldexp(4.0, -9) / STEP;
        double mean = 0.0;
        for (size_t i = 0; i < count; i++) mean += v[3 * i] / (double)count;
        assert_true(fabs(plate[0] - speed) < 1e-12 && plate[2] == 0.0);
        if (!(fabs(mean - speed) < 0.01 * speed)) fail_msg("%g m/s, not %g", mean, speed);
        free_stage(&made);
    }
}

static void two_threads_lead_to_the_same_bits(void **state) {
    (void)state;
    for (plate_kind kind = RIGID; kind <= DEFORMING; kind++) {
        stage one, two;
        make_stage(&one, kind, true, 1);
        make_stage(&two, kind, true, 2);
        for (int i = 0; i < STEPS; i++) {
            go_on(&one);
            go_on(&two);
        }
        assert_true(tulle_world_get_state_hash(one.world) == tulle_world_get_state_hash(two.world));
        free_stage(&one);
        free_stage(&two);
    }
}

/* Without anything given it stands where it was left. */
static void what_is_given_nothing_stands_still(void **state) {
    (void)state;
    for (plate_kind kind = RIGID; kind <= DEFORMING; kind++) {
        stage made;
        make_stage(&made, kind, false, 1);
        for (int i = 0; i < 20; i++) go_on(&made);
        tulle_error error = {0};
        for (int i = 0; i < 3; i++) {
            expect(TULLE_OK, tulle_world_step(made.world, STEP, NULL, &error), &error);
            const double *const x = tulle_obstacle_get_positions(made.world, made.id, NULL);
            const double *const v = tulle_obstacle_get_velocities(made.world, made.id, NULL);
            for (size_t k = 0; k < 3 * made.plate.vertex_count; k++) {
                assert_true(x[k] == made.plate.positions[k] + made.journey.places[20][k % 3]);
                assert_true(v[k] == 0.0);
            }
        }
        free_stage(&made);
    }
}

/* ---- rollback ---- */

typedef struct saved {
    void *bytes;
    size_t byte_count;
} saved;

static saved save(const tulle_world *world) {
    saved made = {0};
    tulle_error error = {0};
    expect(TULLE_OK, tulle_world_save_state(world, &made.bytes, &made.byte_count, &error), &error);
    return made;
}

static void load(tulle_world *world, const saved *from) {
    tulle_error error = {0};
    expect(TULLE_OK, tulle_world_load_state(world, from->bytes, from->byte_count, &error), &error);
}

/* The same again leads to the same hashes, something else to others, and back again. What waits for
 * the next step is no part of a saved state, and gone when one is loaded. */
static void to_give_the_same_again_leads_to_the_same_state(void **state) {
    (void)state;
    for (plate_kind kind = RIGID; kind <= DEFORMING; kind++) {
        stage made, fresh;
        make_stage(&made, kind, true, 1);
        for (int i = 0; i < 20; i++) go_on(&made);
        saved const plain = save(made.world);
        tulle_error error = {0};
        expect(TULLE_OK, give(&made, made.journey.places[30], TULLE_TRAVEL_JUMP, &error), &error);
        saved const waiting = save(made.world);
        assert_int_equal(waiting.byte_count, plain.byte_count);
        assert_memory_equal(waiting.bytes, plain.bytes, plain.byte_count);
        load(made.world, &waiting);
        uint64_t hashes[STEPS];
        for (int i = 20; i < STEPS; i++) {
            go_on(&made); /* would be refused had the jump stayed */
            hashes[i] = tulle_world_get_state_hash(made.world);
        }
        load(made.world, &plain);
        expect(TULLE_OK, give(&made, made.journey.places[24], TULLE_TRAVEL_MOVE, &error), &error);
        expect(TULLE_OK, tulle_world_step(made.world, STEP, NULL, &error), &error);
        assert_true(tulle_world_get_state_hash(made.world) != hashes[20]);
        make_stage(&fresh, kind, true, 1); /* of the same defs, which takes the state over */
        load(made.world, &plain);
        load(fresh.world, &plain);
        for (int i = 20; i < STEPS; i++) {
            go_on(&made);
            go_on(&fresh);
            assert_true(tulle_world_get_state_hash(made.world) == hashes[i]);
            assert_true(tulle_world_get_state_hash(fresh.world) == hashes[i]);
        }
        tulle_world_free_state(made.world, plain.bytes, plain.byte_count);
        tulle_world_free_state(made.world, waiting.bytes, waiting.byte_count);
        free_stage(&made);
        free_stage(&fresh);
    }
}

/* A state in which the pose is none is refused, whatever its hash says. */
static void a_pose_that_is_none_is_refused(void **state) {
    (void)state;
    enum { HASH_AT = 8, HASHED_FROM = 16 };
    stage made;
    make_stage(&made, RIGID, false, 1);
    for (int i = 0; i < 20; i++) go_on(&made);
    saved const good = save(made.world);
    double pose[7] = {0};
    memcpy(pose, made.journey.places[20], sizeof made.journey.places[20]);
    pose[3] = 1.0;
    unsigned char *const bytes = good.bytes;
    size_t at = 0;
    while (at + sizeof pose <= good.byte_count && memcmp(bytes + at, pose, sizeof pose) != 0) at++;
    assert_true(at + sizeof pose <= good.byte_count);
    double const bad[] = {(double)NAN, (double)INFINITY, 1.5};
    for (size_t k = 0; k < 8; k++) {
        double changed[7];
        memcpy(changed, pose, sizeof pose);
        if (k < 7) changed[k] = bad[k < 3 ? k % 2 : k % 3]; /* a translation may be 1.5 m */
        memcpy(bytes + at, changed, sizeof changed);
        uint64_t const hash = hash_block(bytes + HASHED_FROM, good.byte_count - HASHED_FROM);
        memcpy(bytes + HASH_AT, &hash, sizeof hash);
        tulle_error error = {0};
        expect(k < 7 ? TULLE_ERROR_PARSE : TULLE_OK,
               tulle_world_load_state(made.world, bytes, good.byte_count, &error), &error);
    }
    tulle_world_free_state(made.world, good.bytes, good.byte_count);
    free_stage(&made);
}

/* ---- jumps ---- */

static void assert_place(const stage *made, const double place[3]) {
    const double *const x = tulle_obstacle_get_positions(made->world, made->id, NULL);
    const double *const v = tulle_obstacle_get_velocities(made->world, made->id, NULL);
    for (size_t k = 0; k < 3 * made->plate.vertex_count; k++) {
        assert_true(x[k] == made->plate.positions[k] + place[k % 3]);
        assert_true(v[k] == 0.0);
    }
}

/* A jump out of motion, through the cloth: it has no velocity, and the cloth falls on as if there
 * never had been a plate. */
static void a_jump_is_no_motion(void **state) {
    (void)state;
    static const double ABOVE[3] = {0.0, 0.0, 1.0};
    for (plate_kind kind = RIGID; kind <= DEFORMING; kind++) {
        stage made, other;
        make_stage(&made, kind, false, 1);
        make_stage(&other, kind, false, 1);
        tulle_error error = {0};
        for (int i = 0; i < 12; i++) {
            go_on(&made);
            go_on(&other);
        }
        static const double BELOW[3] = {0.0, 0.0, -5.0};
        expect(TULLE_OK, give(&made, ABOVE, TULLE_TRAVEL_JUMP, &error), &error);
        expect(TULLE_OK, give(&other, BELOW, TULLE_TRAVEL_JUMP, &error), &error);
        for (int i = 0; i < 8; i++) {
            expect(TULLE_OK, tulle_world_step(made.world, STEP, NULL, &error), &error);
            expect(TULLE_OK, tulle_world_step(other.world, STEP, NULL, &error), &error);
            assert_place(&made, ABOVE);
            assert_place(&other, BELOW);
            size_t count;
            const double *const x = tulle_cloth_get_positions(made.world, made.cloth, &count);
            assert_memory_equal(x, tulle_cloth_get_positions(other.world, other.cloth, NULL),
                                3 * count * sizeof *x);
        }
        /* from there it moves on as ever */
        double const next[3] = {0.0, 0.0, 1.0 + STEP};
        expect(TULLE_OK, give(&made, next, TULLE_TRAVEL_MOVE, &error), &error);
        expect(TULLE_OK, tulle_world_step(made.world, STEP, NULL, &error), &error);
        const double *const v = tulle_obstacle_get_velocities(made.world, made.id, NULL);
        assert_true(v[0] == 0.0 && v[2] == 1.0);
        free_stage(&made);
        free_stage(&other);
    }
}

/* Also in a step of several substeps it stands still. */
static void a_jump_stands_still_in_each_substep(void **state) {
    (void)state;
    static const double ABOVE[3] = {0.25, 0.0, 1.0};
    for (plate_kind kind = RIGID; kind <= DEFORMING; kind++) {
        stage made;
        make_stage(&made, kind, true, 1);
        for (int i = 0; i < 4; i++) go_on(&made);
        double corners[12]; /* of the sheet, which is drawn out */
        const double *const x = tulle_cloth_get_positions(made.world, made.cloth, NULL);
        static const size_t vertices[4] = {0, 8, 72, 80};
        for (size_t k = 0; k < 12; k++) corners[k] = 1.15 * x[3 * vertices[k / 3] + k % 3];
        tulle_error error = {0};
        expect(TULLE_OK, tulle_cloth_set_pin_targets(made.world, made.cloth, 0, corners, 4, &error),
               &error);
        expect(TULLE_OK, give(&made, ABOVE, TULLE_TRAVEL_JUMP, &error), &error);
        tulle_step_report report;
        expect(TULLE_OK, tulle_world_step(made.world, STEP, &report, &error), &error);
        assert_true(report.substeps > 1);
        assert_place(&made, ABOVE);
        free_stage(&made);
    }
}

/* The pose from which the next step goes on is part of the state, beside the places of vertices. */
static void the_hash_holds_the_pose(void **state) {
    (void)state;
    stage stages[2];
    for (int k = 0; k < 2; k++) {
        double const place[3] = {0.0, 0.0, 0.0}, turn[4] = {k == 0 ? 1.0 : -1.0, 0.0, 0.0, 0.0};
        tulle_error error = {0};
        make_stage(&stages[k], RIGID, false, 1);
        expect(TULLE_OK,
               tulle_obstacle_set_next_transform(stages[k].world, stages[k].id, place, turn,
                                                 TULLE_TRAVEL_MOVE, &error),
               &error);
        expect(TULLE_OK, tulle_world_step(stages[k].world, STEP, NULL, &error), &error);
    }
    assert_true(hash_sight(&stages[0]) == hash_sight(&stages[1]));
    assert_true(tulle_world_get_state_hash(stages[0].world) !=
                tulle_world_get_state_hash(stages[1].world));
    for (int k = 0; k < 2; k++) free_stage(&stages[k]);
}

/* Friction and impacts do not see how an obstacle moved before it jumped: it lands under a sheet,
 * out of motion and out of rest. */
static void a_jump_forgets_the_motion_before(void **state) {
    (void)state;
    for (plate_kind kind = RIGID; kind <= DEFORMING; kind++) {
        stage stages[2];
        tulle_error error = {0};
        for (int k = 0; k < 2; k++) {
            stage *const made = &stages[k];
            make_stage(made, kind, false, 1);
            double place[3] = {0.0, 0.0, -5.0};
            expect(TULLE_OK, give(made, place, TULLE_TRAVEL_JUMP, &error), &error);
            for (int i = 0; i < 6; i++) { /* the first one moves at 8 m/s */
                expect(TULLE_OK, tulle_world_step(made->world, STEP, NULL, &error), &error);
                place[0] += k == 0 ? 0.125 : 0.0;
                place[2] += k == 0 ? 0.125 : 0.0;
                expect(TULLE_OK, give(made, place, TULLE_TRAVEL_MOVE, &error), &error);
            }
            expect(TULLE_OK, tulle_world_step(made->world, STEP, NULL, &error), &error);
            size_t count;
            const double *const x = tulle_cloth_get_positions(made->world, made->cloth, &count);
            double lowest = x[2], top = made->plate.positions[2];
            for (size_t v = 0; v < count; v++) lowest = fmin(lowest, x[3 * v + 2]);
            for (size_t v = 0; v < made->plate.vertex_count; v++)
                top = fmax(top, made->plate.positions[3 * v + 2]);
            double const under[3] = {0.0, 0.0, lowest - 0.001 - top};
            expect(TULLE_OK, give(made, under, TULLE_TRAVEL_JUMP, &error), &error);
            for (int i = 0; i < 3; i++)
                expect(TULLE_OK, tulle_world_step(made->world, STEP, NULL, &error), &error);
        }
        assert_true(hash_sight(&stages[0]) == hash_sight(&stages[1]));
        const tulle_contact *contacts;
        size_t contact_count;
        expect(TULLE_OK,
               tulle_world_get_contacts(stages[0].world, &contacts, &contact_count, &error),
               &error);
        assert_true(contact_count > 0);
        for (int k = 0; k < 2; k++) free_stage(&stages[k]);
    }
}

/* A jump into cloth fails the step: nothing has changed, and what was given is gone. */
static void a_jump_into_cloth_is_refused(void **state) {
    (void)state;
    for (plate_kind kind = RIGID; kind <= DEFORMING; kind++) {
        stage made, twin;
        make_stage(&made, kind, false, 1);
        make_stage(&twin, kind, false, 1);
        for (int i = 0; i < 12; i++) {
            go_on(&made);
            go_on(&twin);
        }
        /* its faces cross the sheet; or the sheet lies within it as a whole */
        static const double INTO[2][3] = {{0.25, 0.0, 0.046875}, {0.0, 0.0, 0.046875}};
        for (int k = 0; k < 2; k++) {
            tulle_error error = {0};
            saved const before = save(made.world);
            expect(TULLE_OK, give(&made, INTO[k], TULLE_TRAVEL_JUMP, &error), &error);
            expect(TULLE_ERROR_INTERSECTING_START, tulle_world_step(made.world, STEP, NULL, &error),
                   &error);
            assert_non_null(strstr(error.message, "'obstacle 0'"));
            saved const after = save(made.world);
            assert_int_equal(after.byte_count, before.byte_count);
            assert_memory_equal(after.bytes, before.bytes, before.byte_count);
            assert_int_equal(tulle_obstacle_is_present(made.world, made.id), 1);
            tulle_world_free_state(made.world, before.bytes, before.byte_count);
            tulle_world_free_state(made.world, after.bytes, after.byte_count);
        }
        for (int i = 12; i < STEPS; i++) {
            go_on(&made);
            go_on(&twin);
        }
        assert_true(tulle_world_get_state_hash(made.world) ==
                    tulle_world_get_state_hash(twin.world));
        free_stage(&made);
        free_stage(&twin);
    }
}

/* With start_intersections: ignore a jump goes through, and pairs are let be until they part. */
static void a_jump_into_cloth_may_be_ignored(void **state) {
    (void)state;
    stage made;
    make_stage(&made, RIGID, false, 1);
    tulle_world_destroy(made.world);
    tulle_world_def def = tulle_world_def_default();
    def.start_intersections = TULLE_START_IGNORE;
    tulle_error error = {0};
    expect(TULLE_OK, tulle_world_create(&def, &made.world, &error), &error);
    made.cloth = small_add_cloth(made.world, &made.sheet);
    tulle_obstacle_def plate = tulle_obstacle_def_default();
    plate.mesh = tulle_mesh_get_view(&made.plate);
    plate.drive = TULLE_DRIVE_RIGID;
    expect(TULLE_OK, tulle_world_add_obstacle(made.world, &plate, &made.id, &error), &error);
    expect(TULLE_OK, tulle_world_start(made.world, &error), &error);
    static const double INTO[3] = {0.25, 0.0, 0.046875};
    tulle_step_report report;
    expect(TULLE_OK, give(&made, INTO, TULLE_TRAVEL_JUMP, &error), &error);
    expect(TULLE_OK, tulle_world_step(made.world, STEP, &report, &error), &error);
    assert_true(report.ignored_pairs > 0);
    assert_place(&made, INTO);
    static const double AWAY[3] = {0.0, 0.0, 5.0};
    expect(TULLE_OK, give(&made, AWAY, TULLE_TRAVEL_JUMP, &error), &error);
    expect(TULLE_OK, tulle_world_step(made.world, STEP, &report, &error), &error);
    assert_int_equal(report.ignored_pairs, 0);
    free_stage(&made);
}

/* ---- pinches ---- */

/* A plate that closes on a sheet on the floor and leaves no room is held back, as a script is, and
 * follows again when it is told to open. */
static void a_driven_plate_is_held_back(void **state) {
    (void)state;
    for (plate_kind kind = RIGID; kind <= DEFORMING; kind++) {
        stage made;
        make_stage(&made, kind, false, 1);
        tulle_world_destroy(made.world);
        tulle_shape_def shape = tulle_shape_def_default(TULLE_SHAPE_BOX);
        shape.size[0] = shape.size[1] = 0.5;
        shape.size[2] = 0.0625;
        tulle_mesh floor = small_shape(shape, 0.0, 0.0, -0.046875);
        for (size_t v = 0; v < made.plate.vertex_count; v++)
            made.plate.positions[3 * v + 2] += 0.125;
        tulle_world_def def = tulle_world_def_default();
        def.on_pinch = TULLE_ON_PINCH_SLOW;
        tulle_error error = {0};
        expect(TULLE_OK, tulle_world_create(&def, &made.world, &error), &error);
        made.cloth = small_add_cloth(made.world, &made.sheet);
        tulle_obstacle_def plate = tulle_obstacle_def_default();
        plate.mesh = tulle_mesh_get_view(&made.plate);
        plate.drive = kind == RIGID ? TULLE_DRIVE_RIGID : TULLE_DRIVE_DEFORMING;
        expect(TULLE_OK, tulle_world_add_obstacle(made.world, &plate, &made.id, &error), &error);
        small_add_obstacle(made.world, &floor);
        expect(TULLE_OK, tulle_world_start(made.world, &error), &error);
        uint32_t pinched = 0;
        for (int i = 0; i < 96; i++) {
            double const way = i < 40 ? -0.0625 * i / 40.0 : -0.0625 * fmax(0, 80 - i) / 40.0;
            double const place[3] = {0.0, 0.0, way};
            tulle_step_report report;
            expect(TULLE_OK, give(&made, place, TULLE_TRAVEL_MOVE, &error), &error);
            expect(TULLE_OK, tulle_world_step(made.world, STEP, &report, &error), &error);
            pinched += report.pinched != 0;
            tulle_mesh const obstacles[2] = {made.plate, floor};
            assert_int_equal(small_judge(made.world, &made.sheet, 1, obstacles, 2), 0);
        }
        assert_true(pinched > 0);
        const double *const x = tulle_obstacle_get_positions(made.world, made.id, NULL);
        assert_true(x[2] == made.plate.positions[2]);
        print_message("pinched in %u steps\n", pinched);
        free_stage(&made);
        tulle_mesh_destroy(&floor);
    }
}

/* ---- pins ---- */

/* A sheet that hangs by two corners. The script swings them; the host says the same. */
typedef struct swing {
    tulle_mesh sheet;
    tulle_world *world;
    tulle_cloth_id cloth;
    bool is_driven;
} swing;

static const uint32_t CORNERS[2] = {0, 8};

static double find_swing(int i) { return ldexp((double)(i % 16 < 8 ? i % 16 : 16 - i % 16), -7); }

static void make_swing(swing *made, bool is_driven, int threads) {
    *made = (swing){.sheet = small_sheet(0.25, 9, 0.0), .is_driven = is_driven};
    tulle_world_def world_def = tulle_world_def_default();
    world_def.threads = threads;
    tulle_error error = {0};
    expect(TULLE_OK, tulle_world_create(&world_def, &made->world, &error), &error);
    static tulle_keyframe keys[STEPS + 1];
    for (int i = 0; i <= STEPS; i++)
        keys[i] = (tulle_keyframe){i * STEP, {find_swing(i), 0.0, find_swing(i)}, {0, 0, 0}};
    tulle_pin pin = make_pin(CORNERS, 2, 40.0 * STEP);
    if (!is_driven) pin.motion = (tulle_motion){.keys = keys, .key_count = STEPS + 1};
    tulle_cloth_def def = tulle_cloth_def_default();
    def.mesh = tulle_mesh_get_view(&made->sheet);
    def.pins = &pin;
    def.pin_count = 1;
    expect(TULLE_OK, tulle_world_add_cloth(made->world, &def, &made->cloth, &error), &error);
    expect(TULLE_OK, tulle_world_start(made->world, &error), &error);
}

static void free_swing(swing *made) {
    tulle_world_destroy(made->world);
    tulle_mesh_destroy(&made->sheet);
}

static tulle_status give_corners(const swing *made, double way, tulle_error *error) {
    double places[6];
    for (size_t k = 0; k < 6; k++)
        places[k] = made->sheet.positions[3 * CORNERS[k / 3] + k % 3] + (k % 3 == 1 ? 0.0 : way);
    return tulle_cloth_set_pin_targets(made->world, made->cloth, 0, places, 2, error);
}

static uint32_t swing_on(const swing *made) {
    tulle_error error = {0};
    int const i = (int)tulle_world_get_step_count(made->world);
    tulle_step_report report;
    if (made->is_driven)
        expect(i < 40 ? TULLE_OK : TULLE_ERROR_INVALID_ARGUMENT,
               give_corners(made, find_swing(i + 1), &error), &error);
    expect(TULLE_OK, tulle_world_step(made->world, STEP, &report, &error), &error);
    return report.substeps;
}

static void pins_go_as_a_script_has_them(void **state) {
    (void)state;
    swing scripted, driven, driven_by_two;
    make_swing(&scripted, false, 1);
    make_swing(&driven, true, 1);
    make_swing(&driven_by_two, true, 2);
    for (int i = 0; i < STEPS; i++) {
        (void)swing_on(&scripted);
        (void)swing_on(&driven);
        (void)swing_on(&driven_by_two);
        uint64_t const hash = tulle_world_get_state_hash(driven.world);
        if (hash != tulle_world_get_state_hash(scripted.world)) fail_msg("step %d", i);
        assert_true(hash == tulle_world_get_state_hash(driven_by_two.world));
    }
    free_swing(&scripted);
    free_swing(&driven);
    free_swing(&driven_by_two);
}

/* Pins that are told nothing stay; after a rollback they go where they are told then. */
static void pins_stay_and_roll_back(void **state) {
    (void)state;
    swing made;
    make_swing(&made, true, 1);
    for (int i = 0; i < 5; i++) (void)swing_on(&made);
    saved const here = save(made.world);
    tulle_error error = {0};
    for (int i = 0; i < 3; i++)
        expect(TULLE_OK, tulle_world_step(made.world, STEP, NULL, &error), &error);
    const double *x = tulle_cloth_get_positions(made.world, made.cloth, NULL);
    assert_true(x[0] == made.sheet.positions[0] + find_swing(5));
    uint64_t hashes[2];
    for (int k = 0; k < 2; k++) {
        load(made.world, &here);
        for (int i = 0; i < 10; i++) (void)swing_on(&made);
        hashes[k] = tulle_world_get_state_hash(made.world);
        expect(TULLE_OK, give_corners(&made, 0.0, &error), &error); /* loading lets go of it */
    }
    assert_true(hashes[0] == hashes[1]);
    tulle_world_free_state(made.world, here.bytes, here.byte_count);
    free_swing(&made);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_given_moves_as_a_script_does),
        cmocka_unit_test(turns_are_as_of_a_script),
        cmocka_unit_test(a_driven_plate_carries_cloth),
        cmocka_unit_test(two_threads_lead_to_the_same_bits),
        cmocka_unit_test(what_is_given_nothing_stands_still),
        cmocka_unit_test(to_give_the_same_again_leads_to_the_same_state),
        cmocka_unit_test(a_pose_that_is_none_is_refused),
        cmocka_unit_test(a_jump_is_no_motion),
        cmocka_unit_test(a_jump_stands_still_in_each_substep),
        cmocka_unit_test(the_hash_holds_the_pose),
        cmocka_unit_test(a_jump_forgets_the_motion_before),
        cmocka_unit_test(a_jump_into_cloth_is_refused),
        cmocka_unit_test(a_jump_into_cloth_may_be_ignored),
        cmocka_unit_test(a_driven_plate_is_held_back),
        cmocka_unit_test(pins_go_as_a_script_has_them),
        cmocka_unit_test(pins_stay_and_roll_back),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
