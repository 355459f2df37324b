/* Arguments of the public functions of tulle/live.h, against a world that has started, with a
 * cloth on three pins and obstacles of each kind, and against one that has not. */
#include "api/arguments.h"
#include "support/pins.h"
#include "support/small_world.h"

static const double STEP = 1.0 / 64.0;

static tulle_mesh sheet, plate;
static tulle_world *started, *fresh;
static tulle_cloth_id cloth, free_cloth;
static tulle_obstacle_id fixed, on_keys, rigid, deforming, body;

enum { HELD, ON_KEYS, LETS_GO, PIN_COUNT };

static tulle_status read_frame(void *context, uint32_t frame, double *positions,
                               tulle_error *unused) {
    (void)context, (void)frame, (void)unused;
    memcpy(positions, plate.positions, 3 * plate.vertex_count * sizeof *positions);
    return TULLE_OK;
}

static tulle_obstacle_def make_obstacle_def(void) {
    tulle_obstacle_def def = tulle_obstacle_def_default();
    def.mesh = tulle_mesh_get_view(&plate);
    return def;
}

static tulle_world *make_world(void) {
    tulle_world_def world_def = tulle_world_def_default();
    world_def.threads = 1;
    tulle_world *world = NULL;
    FINE(tulle_world_create(&world_def, &world, &error));
    static const uint32_t vertices[PIN_COUNT][2] = {{0, 1}, {12, 13}, {3, 2}};
    tulle_keyframe const key = {.rotation_vector = {0, 0, 0}};
    tulle_pin pins[PIN_COUNT];
    for (int k = 0; k < PIN_COUNT; k++) {
        pins[k] = make_pin(vertices[k], 2, k == LETS_GO ? 0.0 : (double)INFINITY);
        pins[k].motion = (tulle_motion){.keys = &key, .key_count = k == ON_KEYS};
    }
    tulle_cloth_def def = tulle_cloth_def_default();
    def.mesh = tulle_mesh_get_view(&sheet);
    def.pins = pins;
    def.pin_count = PIN_COUNT;
    FINE(tulle_world_add_cloth(world, &def, &cloth, &error));
    tulle_mesh aside = small_sheet(0.3, 4, 2.0);
    free_cloth = small_add_cloth(world, &aside);
    tulle_mesh_destroy(&aside);
    fixed = small_add_obstacle(world, &plate);
    tulle_obstacle_def obstacle = make_obstacle_def();
    obstacle.motion = (tulle_motion){.keys = &key, .key_count = 1};
    FINE(tulle_world_add_obstacle(world, &obstacle, &on_keys, &error));
    obstacle = make_obstacle_def();
    obstacle.drive = TULLE_DRIVE_RIGID;
    FINE(tulle_world_add_obstacle(world, &obstacle, &rigid, &error));
    obstacle.drive = TULLE_DRIVE_DEFORMING;
    FINE(tulle_world_add_obstacle(world, &obstacle, &deforming, &error));
    tulle_shape_def shape = tulle_shape_def_default(TULLE_SHAPE_BOX);
    shape.size[0] = shape.size[1] = shape.size[2] = 0.2;
    tulle_mesh box = small_shape(shape, 4.0, 0.0, 0.0);
    obstacle = make_obstacle_def();
    obstacle.mesh = tulle_mesh_get_view(&box);
    obstacle.body = (tulle_body){.is_dynamic = 1, .density = 300.0};
    FINE(tulle_world_add_obstacle(world, &obstacle, &body, &error));
    tulle_mesh_destroy(&box);
    return world;
}

static int set_up(void **unused) {
    (void)unused;
    tulle_shape_def const shape = tulle_shape_def_default(TULLE_SHAPE_BOX);
    sheet = small_sheet(0.3, 4, 0.1);
    plate = small_shape(shape, 0.0, 0.0, -3.0);
    started = make_world();
    fresh = make_world();
    FINE(tulle_world_step(started, STEP, NULL, &error));
    return 0;
}

/* Nothing that was refused has changed the worlds, and nothing is waiting in them. */
static int tear_down(void **unused) {
    (void)unused;
    tulle_world *const other = make_world();
    FINE(tulle_world_step(fresh, STEP, NULL, &error));
    FINE(tulle_world_step(other, STEP, NULL, &error));
    assert_true(tulle_world_get_state_hash(fresh) == tulle_world_get_state_hash(other));
    FINE(tulle_world_step(started, STEP, NULL, &error));
    FINE(tulle_world_step(other, STEP, NULL, &error));
    assert_true(tulle_world_get_state_hash(started) == tulle_world_get_state_hash(other));
    tulle_world_destroy(started);
    tulle_world_destroy(fresh);
    tulle_world_destroy(other);
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&plate);
    return 0;
}

static const tulle_cloth_id bad_cloths[] = {{0, 0}, {0, 2}, {2, 1}, {UINT32_MAX, 1}};
static const tulle_obstacle_id bad_obstacles[] = {{2, 0}, {2, 2}, {3, 0}, {5, 1}, {UINT32_MAX, 1}};
enum { BAD_OBSTACLE_COUNT = sizeof bad_obstacles / sizeof bad_obstacles[0] };

/* What a step or a load has used up may be given anew. */
static void let_go(void) {
    void *bytes = NULL;
    size_t count = 0;
    FINE(tulle_world_save_state(started, &bytes, &count, &error));
    FINE(tulle_world_load_state(started, bytes, count, &error));
    tulle_world_free_state(started, bytes, count);
}

static double const here[3] = {0.0, 0.0, 0.0}, no_turn[4] = {1.0, 0.0, 0.0, 0.0};

static tulle_status move(tulle_world *world, tulle_obstacle_id id, const double *translation,
                         const double *rotation) {
    return tulle_obstacle_set_next_transform(world, id, translation, rotation, TULLE_TRAVEL_MOVE,
                                             &error);
}

ARGUMENTS_OF(tulle_obstacle_set_next_transform) {
    REFUSED(move(NULL, rigid, here, no_turn));
    REFUSED(move(fresh, rigid, here, no_turn));
    REFUSED(move(started, rigid, NULL, no_turn));
    REFUSED(move(started, rigid, here, NULL));
    for (int i = 0; i < BAD_OBSTACLE_COUNT; i++)
        REFUSED(move(started, bad_obstacles[i], here, no_turn));
    tulle_obstacle_id const others[] = {fixed, on_keys, deforming, body};
    for (int i = 0; i < 4; i++) REFUSED(move(started, others[i], here, no_turn));
    for (int i = 0; i < NO_NUMBER_COUNT; i++)
        for (int k = 0; k < 7; k++) {
            double numbers[7] = {0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0};
            numbers[k] = no_numbers[i];
            REFUSED(move(started, rigid, numbers, numbers + 3));
        }
    static const double no_rotations[][4] = {
        {0.0, 0.0, 0.0, 0.0}, {0.0, 2.0, 0.0, 0.0}, {1.0, 2e-3, 0.0, 0.0}, {1e-300, 0.0, 0.0, 0.0}};
    for (int i = 0; i < 4; i++) REFUSED(move(started, rigid, here, no_rotations[i]));
    for (int i = 0; i < NO_CHOICE_COUNT; i++) {
        tulle_travel travel;
        SET_CHOICE(travel, no_choices[i]);
        REFUSED(tulle_obstacle_set_next_transform(started, rigid, here, no_turn, travel, &error));
    }
    assert_int_equal(
        tulle_obstacle_set_next_transform(NULL, rigid, NULL, NULL, TULLE_TRAVEL_MOVE, NULL),
        TULLE_ERROR_INVALID_ARGUMENT);
    FINE(move(started, rigid, here, no_turn));
    REFUSED(move(started, rigid, here, no_turn));
    REFUSED(tulle_world_step(started, -1.0, NULL, &error)); /* no step: it waits on */
    REFUSED(move(started, rigid, here, no_turn));
    let_go();
    FINE(move(started, rigid, here, no_turn));
    let_go();
}

static tulle_status deform(tulle_world *world, tulle_obstacle_id id, const double *positions,
                           size_t count) {
    return tulle_obstacle_set_next_positions(world, id, positions, count, TULLE_TRAVEL_MOVE,
                                             &error);
}

ARGUMENTS_OF(tulle_obstacle_set_next_positions) {
    size_t const count = plate.vertex_count;
    REFUSED(deform(NULL, deforming, plate.positions, count));
    REFUSED(deform(fresh, deforming, plate.positions, count));
    REFUSED(deform(started, deforming, NULL, count));
    for (int i = 0; i < BAD_OBSTACLE_COUNT; i++)
        REFUSED(deform(started, bad_obstacles[i], plate.positions, count));
    tulle_obstacle_id const others[] = {fixed, on_keys, rigid, body};
    for (int i = 0; i < 4; i++) REFUSED(deform(started, others[i], plate.positions, count));
    size_t const counts[] = {0, 1, count - 1, count + 1, SIZE_MAX};
    for (int i = 0; i < 5; i++) REFUSED(deform(started, deforming, plate.positions, counts[i]));
    size_t const places[] = {0, 1, 3 * count - 1};
    for (int i = 0; i < NO_NUMBER_COUNT; i++)
        for (int k = 0; k < 3; k++) {
            double const kept = plate.positions[places[k]];
            plate.positions[places[k]] = no_numbers[i];
            REFUSED(deform(started, deforming, plate.positions, count));
            plate.positions[places[k]] = kept;
        }
    for (int i = 0; i < NO_CHOICE_COUNT; i++) {
        tulle_travel travel;
        SET_CHOICE(travel, no_choices[i]);
        REFUSED(tulle_obstacle_set_next_positions(started, deforming, plate.positions, count,
                                                  travel, &error));
    }
    assert_int_equal(
        tulle_obstacle_set_next_positions(NULL, deforming, NULL, 0, TULLE_TRAVEL_MOVE, NULL),
        TULLE_ERROR_INVALID_ARGUMENT);
    FINE(deform(started, deforming, plate.positions, count));
    REFUSED(deform(started, deforming, plate.positions, count));
    let_go();
    FINE(deform(started, deforming, plate.positions, count));
    let_go();
}

static tulle_status pull(tulle_world *world, tulle_cloth_id id, size_t pin, const double *positions,
                         size_t count) {
    return tulle_cloth_set_pin_targets(world, id, pin, positions, count, &error);
}

ARGUMENTS_OF(tulle_cloth_set_pin_targets) {
    double targets[6];
    memcpy(targets, sheet.positions, sizeof targets);
    REFUSED(pull(NULL, cloth, HELD, targets, 2));
    REFUSED(pull(fresh, cloth, HELD, targets, 2));
    REFUSED(pull(started, cloth, HELD, NULL, 2));
    for (int i = 0; i < 4; i++) REFUSED(pull(started, bad_cloths[i], HELD, targets, 2));
    REFUSED(pull(started, free_cloth, 0, targets, 2));
    size_t const no_pins[] = {ON_KEYS, LETS_GO, PIN_COUNT, SIZE_MAX};
    for (int i = 0; i < 4; i++) REFUSED(pull(started, cloth, no_pins[i], targets, 2));
    size_t const counts[] = {0, 1, 3, SIZE_MAX};
    for (int i = 0; i < 4; i++) REFUSED(pull(started, cloth, HELD, targets, counts[i]));
    for (int i = 0; i < NO_NUMBER_COUNT; i++)
        for (int k = 0; k < 6; k++) {
            double const kept = targets[k];
            targets[k] = no_numbers[i];
            REFUSED(pull(started, cloth, HELD, targets, 2));
            targets[k] = kept;
        }
    assert_int_equal(tulle_cloth_set_pin_targets(NULL, cloth, 0, NULL, 0, NULL),
                     TULLE_ERROR_INVALID_ARGUMENT);
    FINE(pull(started, cloth, HELD, targets, 2));
    REFUSED(pull(started, cloth, HELD, targets, 2));
    let_go();
    FINE(pull(started, cloth, HELD, targets, 2));
    let_go();
}

static tulle_status draw(tulle_world *world, tulle_cloth_id id, const double *targets,
                         const double *departures, size_t count) {
    tulle_cloth_targets const given = {targets, departures, NULL, count};
    return tulle_cloth_set_targets(world, id, &given, &error);
}

ARGUMENTS_OF(tulle_cloth_set_targets) {
    size_t const count = sheet.vertex_count;
    double *const to = sheet.positions;
    REFUSED(draw(NULL, free_cloth, to, NULL, count));
    REFUSED(draw(fresh, free_cloth, to, NULL, count));
    REFUSED(draw(started, free_cloth, NULL, NULL, count));
    for (int i = 0; i < 4; i++) REFUSED(draw(started, bad_cloths[i], to, NULL, count));
    size_t const counts[] = {0, 1, count - 1, count + 1, SIZE_MAX};
    for (int i = 0; i < 5; i++) REFUSED(draw(started, free_cloth, to, NULL, counts[i]));
    for (int i = 0; i < NO_NUMBER_COUNT; i++) {
        double const kept = to[3 * count - 1];
        double *const copy = malloc(3 * count * sizeof *copy);
        assert_non_null(copy);
        memcpy(copy, to, 3 * count * sizeof *copy);
        copy[3 * count - 1] = no_numbers[i];
        REFUSED(draw(started, free_cloth, copy, NULL, count));
        REFUSED(draw(started, free_cloth, to, copy, count));
        assert_true(to[3 * count - 1] == kept);
        free(copy);
    }
    REFUSED(tulle_cloth_set_targets(started, free_cloth, NULL, &error));
    assert_int_equal(tulle_cloth_set_targets(NULL, free_cloth, NULL, NULL),
                     TULLE_ERROR_INVALID_ARGUMENT);
    FINE(draw(started, free_cloth, to, NULL, count));
    REFUSED(draw(started, free_cloth, to, NULL, count));
    let_go();
    FINE(draw(started, free_cloth, to, to, count));
    let_go();
}

ARGUMENTS_OF(tulle_world_place) {
    double places[3 * 1024] = {0.0};
    size_t count = 0;
    for (uint32_t k = 0; k < 7; k++) { /* two sheets and five obstacles */
        size_t own = 0;
        const double *const x =
            k < 2 ? tulle_cloth_get_positions(started, (tulle_cloth_id){k, 1}, &own)
                  : tulle_obstacle_get_positions(started, (tulle_obstacle_id){k - 2, 1}, &own);
        assert_true(own > 0 && count + own <= 1024);
        memcpy(places + 3 * count, x, 3 * own * sizeof *x);
        count += own;
    }
    REFUSED(tulle_world_place(NULL, places, count, &error));
    REFUSED(tulle_world_place(fresh, places, count, &error));
    REFUSED(tulle_world_place(started, NULL, count, &error));
    size_t const counts[] = {0, 1, count - 1, count + 1, SIZE_MAX};
    for (int i = 0; i < 5; i++) REFUSED(tulle_world_place(started, places, counts[i], &error));
    for (int i = 0; i < NO_NUMBER_COUNT; i++) {
        double const kept = places[3 * count - 1];
        places[3 * count - 1] = no_numbers[i];
        REFUSED(tulle_world_place(started, places, count, &error));
        places[3 * count - 1] = kept;
    }
    assert_int_equal(tulle_world_place(NULL, NULL, 0, NULL), TULLE_ERROR_INVALID_ARGUMENT);
}

/* What is refused in a world without bodies: test/world/test_start_at.c. */
ARGUMENTS_OF(tulle_world_start_at) {
    double const numbers[96] = {0.0};
    tulle_moment const moment = {
        .positions = numbers, .velocities = numbers, .vertex_count = 32, .step_count = 5};
    REFUSED(tulle_world_start_at(NULL, &moment, &error));
    REFUSED(tulle_world_start_at(fresh, NULL, &error));
    REFUSED(tulle_world_start_at(started, &moment, &error));
    REFUSED(tulle_world_start_at(fresh, &moment, &error)); /* it has a body */
    assert_int_equal(tulle_world_start_at(NULL, NULL, NULL), TULLE_ERROR_INVALID_ARGUMENT);
}

ARGUMENTS_OF(tulle_world_set_gravity) {
    double const good[3] = {0.0, 0.0, -9.81};
    REFUSED(tulle_world_set_gravity(NULL, good, &error));
    REFUSED(tulle_world_set_gravity(started, NULL, &error));
    REFUSED(tulle_world_set_gravity(fresh, NULL, &error));
    assert_int_equal(tulle_world_set_gravity(NULL, NULL, NULL), TULLE_ERROR_INVALID_ARGUMENT);
    for (int i = 0; i < NO_NUMBER_COUNT; i++)
        for (int k = 0; k < 3; k++) {
            double gravity[3] = {0.0, 0.0, -9.81};
            gravity[k] = no_numbers[i];
            REFUSED(tulle_world_set_gravity(started, gravity, &error));
            REFUSED(tulle_world_set_gravity(fresh, gravity, &error));
        }
    FINE(tulle_world_set_gravity(started, good, &error));
    FINE(tulle_world_set_gravity(fresh, good, NULL));
}

ARGUMENTS_OF(tulle_world_set_wind) {
    tulle_wind const good = tulle_world_def_default().wind;
    REFUSED(tulle_world_set_wind(NULL, &good, &error));
    REFUSED(tulle_world_set_wind(started, NULL, &error));
    assert_int_equal(tulle_world_set_wind(NULL, NULL, NULL), TULLE_ERROR_INVALID_ARGUMENT);
    tulle_wind wind;
    double *const numbers[] = {&wind.velocity[0],     &wind.velocity[1], &wind.velocity[2],
                               &wind.gust_length,     &wind.gust_time,   &wind.gust_strength,
                               &wind.drag_coefficient};
    for (int i = 0; i < NO_NUMBER_COUNT; i++)
        for (size_t k = 0; k < sizeof numbers / sizeof numbers[0]; k++) {
            wind = good;
            *numbers[k] = no_numbers[i];
            REFUSED(tulle_world_set_wind(started, &wind, &error));
            REFUSED(tulle_world_set_wind(fresh, &wind, &error));
        }
    FINE(tulle_world_set_wind(started, &good, &error));
    FINE(tulle_world_set_wind(fresh, &good, NULL));
}

ARGUMENTS_OF(tulle_cloth_set_material) {
    tulle_material const good = tulle_cloth_def_default().material;
    uint64_t const before = tulle_world_get_state_hash(started);
    REFUSED(tulle_cloth_set_material(NULL, cloth, &good, &error));
    REFUSED(tulle_cloth_set_material(started, cloth, NULL, &error));
    REFUSED(tulle_cloth_set_material(fresh, cloth, &good, &error));
    REFUSED(tulle_cloth_set_material(started, (tulle_cloth_id){cloth.index, 2}, &good, &error));
    REFUSED(tulle_cloth_set_material(started, (tulle_cloth_id){2, 1}, &good, &error));
    tulle_material material;
    double *const numbers[] = {&material.area_density, &material.warp.stiffness,
                               &material.shear.limit, &material.bend_weft, &material.air_damping};
    for (int i = 0; i < NO_NUMBER_COUNT; i++)
        for (size_t k = 0; k < sizeof numbers / sizeof numbers[0]; k++) {
            material = good;
            *numbers[k] = no_numbers[i];
            REFUSED(tulle_cloth_set_material(started, cloth, &material, &error));
        }
    material = good;
    material.shear_hysteresis = 0.01 * material.shear.stiffness;
    REFUSED(tulle_cloth_set_material(started, cloth, &material, &error));
    FINE(tulle_cloth_set_material(started, cloth, &good, &error));
    material = good;
    material.friction = 0.9; /* stays as it is */
    FINE(tulle_cloth_set_material(started, cloth, &material, NULL));
    assert_true(tulle_world_get_state_hash(started) == before);
}

/* The world as it was when `bytes` were saved. */
static void go_back(void *bytes, size_t size, uint64_t hash) {
    FINE(tulle_world_load_state(started, bytes, size, &error));
    tulle_world_free_state(started, bytes, size);
    assert_true(tulle_world_get_state_hash(started) == hash);
}

ARGUMENTS_OF(tulle_cloth_set_thickness) {
    void *bytes;
    size_t size;
    uint64_t const before = tulle_world_get_state_hash(started);
    FINE(tulle_world_save_state(started, &bytes, &size, &error));
    double contact, gap;
    tulle_world_get_distances(started, &contact, NULL, &gap);
    REFUSED(tulle_cloth_set_thickness(NULL, cloth, contact, &error));
    REFUSED(tulle_cloth_set_thickness(fresh, cloth, contact, &error));
    REFUSED(tulle_cloth_set_thickness(started, (tulle_cloth_id){2, 1}, contact, &error));
    for (int i = 0; i < NO_NUMBER_COUNT; i++)
        REFUSED(tulle_cloth_set_thickness(started, cloth, no_numbers[i], &error));
    REFUSED(tulle_cloth_set_thickness(started, cloth, 0.0, &error));
    REFUSED(tulle_cloth_set_thickness(started, cloth, 1.99 * gap, &error));
    REFUSED(tulle_cloth_set_thickness(started, cloth, 1.01 * contact, &error));
    assert_true(tulle_world_get_state_hash(started) == before);
    FINE(tulle_cloth_set_thickness(started, cloth, contact, NULL));
    FINE(tulle_cloth_set_thickness(started, cloth, 2.0 * gap, &error));
    go_back(bytes, size, before);
}

ARGUMENTS_OF(tulle_cloth_release_pin) {
    uint64_t const before = tulle_world_get_state_hash(started);
    REFUSED(tulle_cloth_release_pin(NULL, cloth, HELD, &error));
    REFUSED(tulle_cloth_release_pin(fresh, cloth, HELD, &error));
    REFUSED(tulle_cloth_release_pin(started, (tulle_cloth_id){cloth.index, 0}, HELD, &error));
    REFUSED(tulle_cloth_release_pin(started, cloth, PIN_COUNT, &error));
    REFUSED(tulle_cloth_release_pin(started, cloth, SIZE_MAX, &error));
    REFUSED(tulle_cloth_release_pin(started, free_cloth, 0, &error));
    FINE(tulle_cloth_release_pin(started, cloth, LETS_GO, &error)); /* it has */
    assert_true(tulle_world_get_state_hash(started) == before);
    void *bytes;
    size_t size;
    FINE(tulle_world_save_state(started, &bytes, &size, &error));
    FINE(tulle_cloth_release_pin(started, cloth, ON_KEYS, NULL));
    assert_true(tulle_world_get_state_hash(started) != before);
    go_back(bytes, size, before);
}

ARGUMENTS_OF(tulle_cloth_is_asleep) {
    assert_int_equal(tulle_cloth_is_asleep(NULL, cloth), 0);
    assert_int_equal(tulle_cloth_is_asleep(fresh, cloth), 0);
    assert_int_equal(tulle_cloth_is_asleep(started, (tulle_cloth_id){2, 1}), 0);
    assert_int_equal(tulle_cloth_is_asleep(started, (tulle_cloth_id){cloth.index, 0}), 0);
    assert_int_equal(tulle_cloth_is_asleep(started, cloth), 0); /* nothing sleeps here */
}

ARGUMENTS_OF(tulle_cloth_wake) {
    uint64_t const before = tulle_world_get_state_hash(started);
    REFUSED(tulle_cloth_wake(NULL, cloth, &error));
    REFUSED(tulle_cloth_wake(fresh, cloth, &error));
    REFUSED(tulle_cloth_wake(started, (tulle_cloth_id){2, 1}, &error));
    REFUSED(tulle_cloth_wake(started, (tulle_cloth_id){cloth.index, 2}, &error));
    FINE(tulle_cloth_wake(started, cloth, &error));
    FINE(tulle_cloth_wake(started, cloth, NULL));
    assert_true(tulle_world_get_state_hash(started) == before);
}

ARGUMENTS_OF(tulle_world_get_state_size) {
    assert_int_equal(tulle_world_get_state_size(NULL), 0);
    assert_int_equal(tulle_world_get_state_size(fresh), 0);
    assert_true(tulle_world_get_state_size(started) > 0);
}

ARGUMENTS_OF(tulle_world_save_state_into) {
    size_t const size = tulle_world_get_state_size(started);
    size_t count = 7;
    unsigned char *const bytes = malloc(size + 1);
    assert_non_null(bytes);
    memset(bytes, 9, size + 1);
    REFUSED(tulle_world_save_state_into(NULL, bytes, size, &count, &error));
    REFUSED(tulle_world_save_state_into(fresh, bytes, size, &count, &error));
    REFUSED(tulle_world_save_state_into(started, NULL, size, &count, &error));
    REFUSED(tulle_world_save_state_into(started, bytes, size, NULL, &error));
    size_t const too_small[] = {0, 1, size - 1};
    for (int i = 0; i < 3; i++)
        REFUSED(tulle_world_save_state_into(started, bytes, too_small[i], &count, &error));
    assert_int_equal(tulle_world_save_state_into(NULL, NULL, 0, NULL, NULL),
                     TULLE_ERROR_INVALID_ARGUMENT);
    for (size_t i = 0; i <= size; i++) assert_int_equal(bytes[i], 9);
    assert_int_equal(count, 7);
    FINE(tulle_world_save_state_into(started, bytes + 1, size, &count, &error));
    assert_int_equal(count, size);
    FINE(tulle_world_load_state(started, bytes + 1, count, &error));
    free(bytes);
}

/* What the host drives has nothing else that moves it. */
static void one_thing_moves_an_obstacle(void **unused) {
    (void)unused;
    tulle_keyframe const key = {.rotation_vector = {0, 0, 0}};
    for (int drive = TULLE_DRIVE_RIGID; drive <= TULLE_DRIVE_DEFORMING; drive++) {
        tulle_obstacle_def defs[4];
        for (int k = 0; k < 4; k++) {
            defs[k] = make_obstacle_def();
            defs[k].drive = (tulle_drive)drive;
        }
        defs[0].motion = (tulle_motion){.keys = &key, .key_count = 1};
        defs[1].read_frame = read_frame;
        defs[1].frame_count = 1;
        defs[2].body = (tulle_body){.is_dynamic = 1, .density = 300.0};
        for (int k = 0; k < 3; k++)
            REFUSED(tulle_world_add_obstacle(fresh, &defs[k], NULL, &error));
        for (int i = 0; i < NO_CHOICE_COUNT; i++) {
            SET_CHOICE(defs[3].drive, no_choices[i]);
            REFUSED(tulle_world_add_obstacle(fresh, &defs[3], NULL, &error));
        }
    }
}

int main(void) {
    const struct CMUnitTest last[] = {cmocka_unit_test(one_thing_moves_an_obstacle)};
    int const failed = run_arguments(HEADERS("tulle/live.h"), set_up, NULL);
    return cmocka_run_group_tests(last, NULL, tear_down) + failed;
}
