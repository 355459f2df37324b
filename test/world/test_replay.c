/* Recordings (tulle/record.h). A violent scene makes calls of every kind, steps that fail and one
 * that is interrupted; its replay must come to the hashes that the host saw, step by step, for any
 * number of threads. Then small recordings that are cut anywhere, changed anywhere, or whose writer
 * fails; and every byte of a def, which must change the recording. */
#define _POSIX_C_SOURCE 200809L
#include "tulle/paper.h"
#include "tulle/record.h"

#include "support/body_world.h"
#include "support/pins.h"
#include "support/recording.h"
#include "support/test_support.h"
#include "world/record/recorded_call.h"

#include <dirent.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>

enum { STEPS = 90, SIDE = 9, HASHES_MAX = 400 };
static const double STEP = 1.0 / 60.0; /* [s] */

static tulle_error error;

/* [bytes] of 64-bit structs that are not recorded: the cookie, and pads around fields of 4 bytes */
enum { SILENT_WORLD = 16, SILENT_CLOTH = 12, SILENT_OBSTACLE = 24, SILENT_ATTACHMENT = 8 };

static void expect(tulle_status wanted, tulle_status status, int line) {
    if (status != wanted)
        fail_msg("line %d: status %d, not %d: %s", line, (int)status, (int)wanted, error.message);
}
#define FINE(call) expect(TULLE_OK, (call), __LINE__)

/* What the host saw after each start, step and load. */
typedef struct seen {
    tulle_status statuses[HASHES_MAX];
    uint64_t hashes[HASHES_MAX];
    size_t count, at;
} seen;

static void see(seen *self, const tulle_world *world, tulle_status status) {
    assert_true(self->count < HASHES_MAX);
    self->statuses[self->count] = status;
    self->hashes[self->count++] = tulle_world_get_state_hash(world);
}

static int compare(void *context, const tulle_world *world, const tulle_replay_report *report) {
    seen *const self = context;
    assert_true(self->at < self->count);
    assert_int_equal(report->status, self->statuses[self->at]);
    assert_true(report->hash == self->hashes[self->at]);
    assert_true(tulle_world_get_state_hash(world) == self->hashes[self->at++]);
    return 0;
}

/* ---- the violent scene ---- */

static tulle_mesh flag;

static tulle_status read_flag(void *context, uint32_t frame, double *positions,
                              tulle_error *fault) {
    (void)fault;
    int *const fails_at = context;
    if (*fails_at >= 0 && frame == (uint32_t)*fails_at) {
        *fails_at = -1;
        return TULLE_ERROR_IO;
    }
    memcpy(positions, flag.positions, 3 * flag.vertex_count * sizeof(double));
    for (size_t i = 0; i < flag.vertex_count; i++) positions[3 * i + 2] += 0.05 * sin(0.7 * frame);
    return TULLE_OK;
}

static int refuses_flag_and_second(void *context, const tulle_world *world, tulle_object_id a,
                                   tulle_object_id b) {
    (void)context, (void)world;
    return !(a.kind == TULLE_OBJECT_CLOTH && a.index == 1 && b.index == 2);
}

static int stop_soon(void *context) { return ++*(int *)context > 3; }

enum { BALL, PLATE, FLAG, BOX, GROUND, DOOR };
static const tulle_obstacle_id obstacles[] = {{BALL, 1}, {PLATE, 1},  {FLAG, 1},
                                              {BOX, 1},  {GROUND, 1}, {DOOR, 1}};
static const tulle_cloth_id cloths[] = {{0, 1}, {1, 1}};
static const double NO_TURN[4] = {1.0, 0.0, 0.0, 0.0};

static void add_cloths(tulle_world *world) {
    tulle_mesh upper = small_sheet(0.5, SIDE, 0.35), lower = small_sheet(0.4, SIDE, 0.25);
    uint32_t row[SIDE], other[SIDE];
    for (uint32_t k = 0; k < SIDE; k++) row[k] = k;
    for (uint32_t k = 0; k < SIDE; k++) other[k] = SIDE * (SIDE - 1) + k;
    tulle_keyframe const keys[2] = {
        {.rotation_vector = {0, 0, 0}},
        {.time = 1.0, .translation = {0.1, 0, 0.05}, .rotation_vector = {0, 0, 0}}};
    tulle_pin pins[2] = {make_pin(row, SIDE, (double)INFINITY), make_pin(other, SIDE, 0.4)};
    pins[1].motion = (tulle_motion){.keys = keys, .key_count = 2, .is_eased = 1};
    tulle_crease const crease = {{10, 11}, 0.5};
    tulle_cloth_def def = tulle_cloth_def_default();
    def.name = "upper";
    def.mesh = tulle_mesh_get_view(&upper);
    def.pins = pins;
    def.pin_count = 2;
    def.creases = &crease;
    def.crease_count = 1;
    def.contact_material = "silk";
    def.velocity[2] = -1.0;
    FINE(tulle_world_add_cloth(world, &def, NULL, &error));
    def = tulle_cloth_def_default();
    def.mesh = tulle_mesh_get_view(&lower);
    FINE(tulle_world_add_cloth(world, &def, NULL, &error));
    tulle_mesh_destroy(&upper);
    tulle_mesh_destroy(&lower);
}

static void add_obstacles(tulle_world *world, int *fails_at) {
    tulle_mesh ball = bodies_make_ball(0.1, 5, (double[]){0.0, 0.0, 0.12});
    tulle_mesh plate = bodies_make_box(0.2, 0.2, 0.02, (double[]){0.6, 0.0, 0.2});
    tulle_mesh box = bodies_make_box(0.1, 0.1, 0.1, (double[]){0.1, 0.1, 0.6});
    tulle_mesh ground = bodies_make_box(3.0, 3.0, 0.1, (double[]){0.0, 0.0, -0.2});
    tulle_mesh door = bodies_make_box(0.05, 0.3, 0.3, (double[]){-0.8, 0.0, 0.1});
    const tulle_mesh *const meshes[] = {&ball, &plate, &flag, &box, &ground, &door};
    tulle_keyframe const keys[2] = {
        {.rotation_vector = {0, 0, 0}},
        {.time = 1.0, .translation = {0.9, 0, 0.0}, .rotation_vector = {0, 0, 0}}};
    for (int i = BALL; i <= DOOR; i++) {
        tulle_obstacle_def def = tulle_obstacle_def_default();
        def.mesh = tulle_mesh_get_view(meshes[i]);
        if (i == BALL) def.drive = TULLE_DRIVE_RIGID;
        if (i == PLATE) def.drive = TULLE_DRIVE_DEFORMING;
        if (i == GROUND) def.contact_material = "stone";
        if (i == DOOR) def.motion = (tulle_motion){.keys = keys, .key_count = 2};
        if (i == BOX)
            def.body = (tulle_body){
                .is_dynamic = 1, .density = 300.0, .sleep_speed = 0.02, .sleep_time = 0.3};
        if (i == FLAG) {
            def.read_frame = read_flag;
            def.frame_context = fails_at;
            def.frame_count = 40;
        }
        FINE(tulle_world_add_obstacle(world, &def, NULL, &error));
    }
    tulle_mesh_destroy(&ball);
    tulle_mesh_destroy(&plate);
    tulle_mesh_destroy(&box);
    tulle_mesh_destroy(&ground);
    tulle_mesh_destroy(&door);
}

static void set_up_world(tulle_world *world) {
    tulle_contact_law const law = {0.6, 0.4, 0.1};
    FINE(tulle_world_set_cloth_cloth_law(world, cloths[0], cloths[1], &law, &error));
    FINE(tulle_world_set_cloth_obstacle_law(world, cloths[0], obstacles[BALL], &law, &error));
    FINE(tulle_world_set_obstacle_obstacle_law(world, obstacles[BOX], obstacles[GROUND], &law,
                                               &error));
    FINE(tulle_world_set_material_law(world, "silk", "stone", &law, &error));
    FINE(tulle_object_set_filter(world, tulle_object_from_obstacle(obstacles[FLAG]), 2, UINT32_MAX,
                                 &error));
    FINE(tulle_world_set_pair_filter(world, refuses_flag_and_second, NULL, &error));
    uint32_t const corner = SIDE - 1;
    double const point[3] = {0.25, -0.2, 0.25};
    tulle_attachment_def def = tulle_attachment_def_default();
    def.cloth = cloths[1];
    def.vertices = &corner;
    def.vertex_count = 1;
    def.points = point;
    def.stiffness = 50.0;
    tulle_attachment_id id;
    FINE(tulle_world_attach(world, &def, &id, &error));
    assert_int_equal(id, 1);
}

static void drive_bodies(tulle_world *world, int step) {
    double const push[3] = {0.02, 0.01, 0.0}, at[3] = {0.1, 0.1, 0.5};
    if (step == 5) FINE(tulle_obstacle_add_impulse(world, obstacles[BOX], at, push, &error));
    if (step == 8) FINE(tulle_obstacle_set_velocity(world, obstacles[BOX], NULL, push, &error));
    if (step == 9) FINE(tulle_obstacle_add_force(world, obstacles[BOX], NULL, push, &error));
    if (step == 10) FINE(tulle_obstacle_add_force(world, obstacles[BOX], at, push, &error));
    if (step == 11) FINE(tulle_obstacle_add_torque(world, obstacles[BOX], push, &error));
    if (step == 14)
        FINE(tulle_obstacle_set_locks(world, obstacles[BOX], TULLE_LOCK_X, TULLE_LOCK_Z, &error));
    if (step == 16) {
        tulle_body_drive drive = tulle_body_drive_default();
        drive.position[2] = 0.3;
        drive.stiffness[2] = 200.0;
        drive.damping[2] = 10.0;
        drive.force_limit[2] = 20.0;
        FINE(tulle_obstacle_set_drive(world, obstacles[BOX], &drive, &error));
    }
    if (step == 50) FINE(tulle_obstacle_set_drive(world, obstacles[BOX], NULL, &error));
    if (step == 70) FINE(tulle_obstacle_wake(world, obstacles[BOX], &error));
}

static void change_settings(tulle_world *world, int step) {
    double const gravity[3] = {0.5, 0.0, -9.0};
    if (step == 12) FINE(tulle_world_set_gravity(world, gravity, &error));
    if (step == 20) {
        tulle_wind wind = tulle_world_def_default().wind;
        wind.velocity[0] = 3.0;
        wind.gust_strength = 1.0;
        wind.seed = 77;
        FINE(tulle_world_set_wind(world, &wind, &error));
    }
    if (step == 24) {
        tulle_material material;
        FINE(tulle_material_preset("silk", &material));
        FINE(tulle_cloth_set_material(world, cloths[1], &material, &error));
    }
    double minimum_gap, contact;
    tulle_world_get_distances(world, &contact, NULL, &minimum_gap);
    if (step == 26)
        FINE(tulle_cloth_set_thickness(world, cloths[1], 0.5 * (contact + 2.0 * minimum_gap),
                                       &error));
    if (step == 40) FINE(tulle_cloth_wake(world, cloths[1], &error));
    if (step == 60) FINE(tulle_cloth_release_pin(world, cloths[0], 0, &error));
    tulle_contact_law const law = {0.2, 0.1, 0.0};
    if (step == 30)
        FINE(tulle_world_set_cloth_obstacle_law(world, cloths[1], obstacles[GROUND], &law, &error));
    tulle_event_watch const watch = tulle_event_watch_default();
    if (step == 3) FINE(tulle_world_watch_events(world, &watch, &error));
    if (step == 80) FINE(tulle_world_watch_events(world, NULL, &error));
}

static void move_attachments(tulle_world *world, int step) {
    double const point[3] = {0.25 + 0.002 * step, -0.2, 0.25};
    if (step < 40) FINE(tulle_attachment_set_points(world, 1, point, 1, &error));
    if (step == 40) FINE(tulle_attachment_release(world, 1, &error));
    if (step != 45) return;
    uint32_t const vertices[2] = {40, 41};
    tulle_attachment_def def = tulle_attachment_def_default();
    def.cloth = cloths[1];
    def.vertices = vertices;
    def.vertex_count = 2;
    def.obstacle = obstacles[BALL];
    def.stiffness = 100.0;
    def.break_force = 2.0;
    tulle_attachment_id id;
    FINE(tulle_world_attach(world, &def, &id, &error));
}

/* Where the host moves things before a step. */
static void move_things(tulle_world *world, const double *plate, size_t plate_count, int step) {
    double const time = STEP * (step + 1);
    double const to[3] = {0.15 * sin(9.0 * time), 0.0, 0.1 * sin(13.0 * time)};
    const double *const middle = tulle_cloth_get_positions(world, cloths[1], NULL) + 3 * 40;
    double const into_cloth[3] = {middle[0], middle[1], middle[2] - 0.12};
    bool const jumps = step == 72; /* which is refused */
    FINE(tulle_obstacle_set_next_transform(world, obstacles[BALL], jumps ? into_cloth : to, NO_TURN,
                                           jumps ? TULLE_TRAVEL_JUMP : TULLE_TRAVEL_MOVE, &error));
    double moved[3 * 64];
    assert_true(plate_count <= 64);
    for (size_t i = 0; i < 3 * plate_count; i++)
        moved[i] = plate[i] + (i % 3 == 0 ? -0.2 * sin(5.0 * time) : 0.0);
    if (step % 3 != 2)
        FINE(tulle_obstacle_set_next_positions(world, obstacles[PLATE], moved, plate_count,
                                               TULLE_TRAVEL_MOVE, &error));
    if (step < 60) {
        size_t count;
        const double *const now = tulle_cloth_get_positions(world, cloths[0], &count);
        double targets[3 * SIDE];
        memcpy(targets, now, sizeof targets);
        for (int k = 0; k < SIDE; k++) targets[3 * k + 2] += 0.003 * cos(20.0 * time);
        FINE(tulle_cloth_set_pin_targets(world, cloths[0], 0, targets, SIDE, &error));
    }
}

/* What the steps were like, added up. */
static tulle_step_report total;

static void step_world(tulle_world *world, seen *record) {
    tulle_step_report report;
    tulle_status const status = tulle_world_step(world, STEP, &report, &error);
    see(record, world, status);
    if (status != TULLE_OK) return;
    total.contacts += report.contacts;
    total.impact_rounds += report.impact_rounds;
    total.substeps += report.substeps;
}

/* Objects come and go: a cloth, one that is refused, an obstacle by a reader, one that was there.
 */
static void change_objects(tulle_world *world, seen *record, int *fails_at, int step) {
    static tulle_cloth_id guest;
    static tulle_obstacle_id banner;
    tulle_cloth_def cloth = tulle_cloth_def_default();
    tulle_mesh sheet = small_sheet(0.3, 5, step == 63 ? 0.2 : 0.9);
    cloth.mesh = tulle_mesh_get_view(&sheet);
    cloth.contact_material = "silk";
    tulle_obstacle_def obstacle = tulle_obstacle_def_default();
    obstacle.mesh = tulle_mesh_get_view(&flag);
    obstacle.read_frame = read_flag;
    obstacle.frame_context = fails_at;
    obstacle.frame_count = 400;
    if (step == 62) see(record, world, tulle_world_add_cloth(world, &cloth, &guest, &error));
    if (step == 63) see(record, world, tulle_world_add_cloth(world, &cloth, NULL, &error));
    if (step == 65) see(record, world, tulle_world_remove_obstacle(world, obstacles[DOOR], &error));
    if (step == 67) see(record, world, tulle_world_add_obstacle(world, &obstacle, &banner, &error));
    if (step == 75) see(record, world, tulle_world_remove_cloth(world, guest, &error));
    if (step == 77) see(record, world, tulle_world_remove_obstacle(world, banner, &error));
    tulle_mesh_destroy(&sheet);
    if (step != 62 && step != 63 && step != 65 && step != 67 && step != 75 && step != 77) return;
    assert_int_equal(record->statuses[record->count - 1],
                     step == 63 ? TULLE_ERROR_INTERSECTING_START : TULLE_OK);
    if (step == 67) assert_true(banner.index == DOOR && banner.generation == 2);
}

/* Runs all of the scene, and records it. */
static void run_scene(recording *bytes, seen *record) {
    tulle_world_def world_def = tulle_world_def_default();
    world_def.threads = 1;
    world_def.on_pinch = TULLE_ON_PINCH_SLOW;
    tulle_world *world = NULL;
    int fails_at = 20;
    flag = small_sheet(0.3, 4, 0.0);
    FINE(tulle_world_create(&world_def, &world, &error));
    tulle_record_writer const writer = recording_begin(bytes);
    FINE(tulle_world_record(world, &writer, &error));
    add_cloths(world);
    add_obstacles(world, &fails_at);
    set_up_world(world);
    see(record, world, tulle_world_start(world, &error));
    assert_int_equal(record->statuses[0], TULLE_OK);
    size_t plate_count, state_size = 0;
    const double *const here = tulle_obstacle_get_positions(world, obstacles[PLATE], &plate_count);
    double *const plate = malloc(3 * plate_count * sizeof(double));
    assert_non_null(plate);
    memcpy(plate, here, 3 * plate_count * sizeof(double));
    void *state = NULL;
    size_t failures = 0;
    for (int i = 0; i < STEPS; i++) {
        change_objects(world, record, &fails_at, i);
        drive_bodies(world, i);
        change_settings(world, i);
        move_attachments(world, i);
        move_things(world, plate, plate_count, i);
        if (i == 35) { /* what was given is gone with a step that is interrupted */
            int questions = 0;
            tulle_world_set_stop_request(world, stop_soon, &questions);
            step_world(world, record);
            assert_int_equal(record->statuses[record->count - 1], TULLE_ERROR_INTERRUPTED);
            tulle_world_set_stop_request(world, NULL, NULL);
        }
        if (i == 32) FINE(tulle_world_save_state(world, &state, &state_size, &error));
        if (i == 42) see(record, world, tulle_world_load_state(world, state, state_size, &error));
        if (i == 43) { /* a state that is refused */
            see(record, world, tulle_world_load_state(world, state, state_size - 1, &error));
            assert_int_equal(record->statuses[record->count - 1], TULLE_ERROR_PARSE);
        }
        if (i == 55) { /* as one of a batch */
            tulle_status status;
            tulle_world_batch const batch = {&world, 1, 1, NULL, &status};
            (void)tulle_worlds_step(&batch, STEP, &error);
            see(record, world, status);
        } else {
            step_world(world, record);
        }
        tulle_status const status = record->statuses[record->count - 1];
        failures += status != TULLE_OK;
        if (i == 72) assert_int_equal(status, TULLE_ERROR_INTERSECTING_START);
    }
    assert_true(failures >= 2 && failures < STEPS / 3);
    assert_true(total.contacts > 1000 && total.substeps > STEPS + STEPS / 4);
    assert_true(total.impact_rounds > 0);
    FINE(tulle_world_record(world, NULL, &error));
    tulle_world_free_state(world, state, state_size);
    tulle_world_destroy(world);
    tulle_mesh_destroy(&flag);
    free(plate);
}

static void every_call_is_repeated(void **unused) {
    (void)unused;
    recording bytes;
    seen record = {0};
    run_scene(&bytes, &record);
    bool has[RECORD_KIND_COUNT] = {false};
    size_t place = RECORD_MAGIC_BYTES;
    uint32_t kind;
    while (recording_next(bytes.bytes, bytes.byte_count, &place, &kind)) has[kind] = true;
    assert_int_equal(place, bytes.byte_count);
    for (int i = 0; i < RECORD_KIND_COUNT; i++)
        if (!has[i] && i != RECORD_TARGETS && i != RECORD_PLACE) /* test_targets.c */
            fail_msg("the scene has no call of kind %d (%s)", i, record_kinds[i].name);
    for (int threads = 0; threads <= 2; threads++) {
        record.at = 0;
        tulle_replay_options const options = {threads, compare, &record};
        tulle_replay_report report;
        FINE(tulle_replay(bytes.bytes, bytes.byte_count, &options, &report, &error));
        if (report.is_different)
            fail_msg("%s at byte %zu, step %llu: status %d, not %d: %s", report.call, report.offset,
                     (unsigned long long)report.steps, (int)report.status,
                     (int)report.recorded_status, report.message);
        assert_true(report.is_whole);
        assert_int_equal(record.at, record.count);
        assert_int_equal(report.steps, STEPS + 1);
        assert_string_equal(report.version, tulle_version());
    }
    free(bytes.bytes);
}

/* A host that does the same without recording comes to the same. */
static void recording_changes_no_bit(void **unused) {
    (void)unused;
    uint64_t hashes[2];
    for (int i = 0; i < 2; i++) {
        tulle_world_def const def = tulle_world_def_default();
        tulle_world *world = NULL;
        recording bytes;
        tulle_record_writer const writer = recording_begin(&bytes);
        FINE(tulle_world_create(&def, &world, &error));
        if (i == 1) FINE(tulle_world_record(world, &writer, &error));
        tulle_mesh sheet = small_sheet(0.3, 6, 0.12);
        tulle_mesh ball = bodies_make_ball(0.1, 4, (double[]){0.0, 0.0, 0.0});
        small_add_cloth(world, &sheet);
        small_add_obstacle(world, &ball);
        for (int k = 0; k < 20; k++) FINE(tulle_world_step(world, STEP, NULL, &error));
        hashes[i] = tulle_world_get_state_hash(world);
        tulle_world_destroy(world);
        assert_true(bytes.byte_count > 0 || i == 0);
        free(bytes.bytes);
        tulle_mesh_destroy(&sheet);
        tulle_mesh_destroy(&ball);
    }
    assert_true(hashes[0] == hashes[1]);
}

/* ---- small recordings ---- */

enum { SMALL_STEPS = 8 };

/* A sheet of 4 triangles or so that falls; ended by the host or not. */
static void record_small(recording *bytes, bool is_ended) {
    tulle_world_def def = tulle_world_def_default();
    def.threads = 1;
    tulle_world *world = NULL;
    FINE(tulle_world_create(&def, &world, &error));
    tulle_record_writer const writer = recording_begin(bytes);
    FINE(tulle_world_record(world, &writer, &error));
    tulle_mesh sheet = small_sheet(0.1, 2, 0.0);
    small_add_cloth(world, &sheet);
    for (int i = 0; i < SMALL_STEPS; i++) {
        double const gravity[3] = {0.1 * i, 0.0, -9.0};
        FINE(tulle_world_set_gravity(world, gravity, &error));
        FINE(tulle_world_step(world, STEP, NULL, &error));
    }
    if (!is_ended) bytes->blocks_left = 0;
    tulle_world_destroy(world);
    tulle_mesh_destroy(&sheet);
}

static void cut_anywhere(void **unused) {
    (void)unused;
    recording bytes;
    record_small(&bytes, true);
    for (size_t size = 0; size < bytes.byte_count; size++) {
        tulle_replay_report report;
        /* bytes of their own, so that a read beyond them is found */
        unsigned char *const cut = malloc(size + (size == 0));
        assert_non_null(cut);
        memcpy(cut, bytes.bytes, size);
        tulle_status const status = tulle_replay(cut, size, NULL, &report, &error);
        free(cut);
        if (size < RECORD_MAGIC_BYTES) {
            expect(TULLE_ERROR_PARSE, status, __LINE__);
            continue;
        }
        expect(TULLE_OK, status, __LINE__);
        uint64_t calls = 0, steps = 0;
        size_t place = RECORD_MAGIC_BYTES;
        uint32_t kind;
        while (recording_next(bytes.bytes, size, &place, &kind)) {
            calls += kind != RECORD_RESULT;
            steps += kind == RECORD_STEP;
        }
        assert_false(report.is_whole);
        assert_false(report.is_different);
        assert_int_equal(report.calls, calls);
        assert_int_equal(report.steps, steps); /* one whose result is cut off included */
    }
    free(bytes.bytes);
}

static void changed_anywhere(void **unused) {
    (void)unused;
    recording bytes;
    record_small(&bytes, true);
    for (size_t i = 0; i < bytes.byte_count; i++) {
        unsigned char const change = (unsigned char)(1u << i % 8);
        tulle_replay_report report;
        error = (tulle_error){0};
        bytes.bytes[i] ^= change;
        tulle_status const status =
            tulle_replay(bytes.bytes, bytes.byte_count, NULL, &report, &error);
        bytes.bytes[i] ^= change;
        expect(TULLE_ERROR_PARSE, status, __LINE__);
        assert_true(error.message[0] != '\0' && error.status == TULLE_ERROR_PARSE);
        if (i >= RECORD_MAGIC_BYTES && !strstr(error.message, "byte "))
            fail_msg("no place in \"%s\"", error.message);
    }
    unsigned char *const longer = calloc(bytes.byte_count + 1, 1);
    assert_non_null(longer);
    memcpy(longer, bytes.bytes, bytes.byte_count);
    tulle_replay_report report;
    expect(TULLE_ERROR_PARSE, tulle_replay(longer, bytes.byte_count + 1, NULL, &report, &error),
           __LINE__);
    free(longer);
    free(bytes.bytes);
}

/* Another hash in the result of the fifth step is told as such, and the replay ends there. */
static void differences_are_told(void **unused) {
    (void)unused;
    recording bytes;
    record_small(&bytes, true);
    size_t place = RECORD_MAGIC_BYTES, results = 0;
    for (uint32_t kind = 0; results < 5;) {
        size_t const begin = place;
        assert_true(recording_next(bytes.bytes, bytes.byte_count, &place, &kind));
        results += kind == RECORD_RESULT;
        if (results < 5) continue;
        bytes.bytes[begin + RECORD_HEAD_BYTES + 24] ^=
            1; /* behind two ids with generations, and the status */
        record_seal(bytes.bytes + begin, place - begin);
    }
    tulle_replay_report report;
    FINE(tulle_replay(bytes.bytes, bytes.byte_count, NULL, &report, &error));
    assert_true(report.is_different);
    assert_int_equal(report.steps, 5);
    assert_string_equal(report.call, "tulle_world_step");
    assert_true(report.hash == (report.recorded_hash ^ 1));
    assert_int_equal(report.status, TULLE_OK);
    free(bytes.bytes);
}

static int end_at_third(void *context, const tulle_world *world,
                        const tulle_replay_report *report) {
    (void)context, (void)world;
    return report->steps == 3;
}

static void an_observer_ends_it(void **unused) {
    (void)unused;
    recording bytes;
    record_small(&bytes, false);
    tulle_replay_options const options = {.observe = end_at_third};
    tulle_replay_report report;
    FINE(tulle_replay(bytes.bytes, bytes.byte_count, &options, &report, &error));
    assert_int_equal(report.steps, 3);
    assert_false(report.is_whole);
    FINE(tulle_replay(bytes.bytes, bytes.byte_count, NULL, &report, &error));
    assert_int_equal(report.steps, SMALL_STEPS);
    assert_false(report.is_whole); /* its end was not written */
    free(bytes.bytes);
}

/* The writer takes `taken` blocks: what is recorded can be repeated, a later step is refused and
 * changes nothing, and the world goes on without a recording. */
static void a_full_disk_is_told(void **unused) {
    (void)unused;
    for (int taken = 1; taken < 9; taken++) {
        tulle_world_def const def = tulle_world_def_default();
        tulle_world *world = NULL;
        FINE(tulle_world_create(&def, &world, &error));
        recording bytes;
        tulle_record_writer const writer = recording_begin(&bytes);
        FINE(tulle_world_record(world, &writer, &error));
        tulle_mesh sheet = small_sheet(0.1, 2, 0.0);
        small_add_cloth(world, &sheet);
        FINE(tulle_world_start(world, &error));
        size_t const before = bytes.byte_count;
        bytes.blocks_left = taken;
        tulle_status status = TULLE_OK;
        int made = 0;
        for (; status == TULLE_OK; made++) {
            uint64_t const hash = tulle_world_get_state_hash(world);
            status = tulle_world_step(world, STEP, NULL, &error);
            if (status != TULLE_OK) assert_true(hash == tulle_world_get_state_hash(world));
        }
        expect(TULLE_ERROR_IO, status, __LINE__);
        assert_int_equal(made, taken / 2 + 1 + taken % 2);
        assert_true(bytes.byte_count > before);
        expect(TULLE_ERROR_IO, tulle_world_record(world, NULL, &error), __LINE__);
        FINE(tulle_world_record(world, NULL, &error));
        FINE(tulle_world_step(world, STEP, NULL, &error));
        tulle_replay_report report;
        FINE(tulle_replay(bytes.bytes, bytes.byte_count, NULL, &report, &error));
        assert_true(!report.is_whole && !report.is_different);
        tulle_world_destroy(world);
        tulle_mesh_destroy(&sheet);
        free(bytes.bytes);
    }
}

/* ---- the fields of defs ---- */

/* Counts the bytes of a def that change nothing in the recording: its cookie, what is not recorded,
 * pads between fields. Bytes of pointers and counts, which cannot be changed alone, are in `held`:
 * pairs of a place and a length, ended by a length of 0. */
static size_t count_silent_bytes(recorded_call *call, size_t def_size, const size_t (*held)[2]) {
    memory heap = memory_default();
    record_stream stream = {.heap = &heap};
    unsigned char *const def = (unsigned char *)&call->def;
    assert_int_equal(recorded_call_write(&stream, call), TULLE_OK);
    size_t const size = stream.bytes.count;
    size_t silent = 0;
    for (size_t i = 0; i < def_size; i++) {
        bool is_held = false;
        for (size_t k = 0; held[k][1] != 0; k++)
            is_held |= i >= held[k][0] && i < held[k][0] + held[k][1];
        if (is_held) continue;
        def[i] ^= 0x10;
        assert_int_equal(recorded_call_write(&stream, call), TULLE_OK);
        def[i] ^= 0x10;
        assert_int_equal(stream.bytes.count, 2 * size);
        silent += memcmp(stream.bytes.data, stream.bytes.data + size, size) == 0;
        stream.bytes.count = size;
    }
    /* what is read is what was written */
    arena scratch = arena_make(&heap);
    recorded_call again = {.kind = call->kind};
    record_stream reader = {.is_reading = true,
                            .at = stream.bytes.data + RECORD_HEAD_BYTES,
                            .end = stream.bytes.data + size - RECORD_HASH_BYTES,
                            .scratch = &scratch};
    assert_int_equal(recorded_call_read(&reader, &again), TULLE_OK);
    assert_int_equal(recorded_call_write(&stream, &again), TULLE_OK);
    assert_memory_equal(stream.bytes.data, stream.bytes.data + size, size);
    arena_destroy(&scratch);
    ARRAY_FREE(&heap, &stream.bytes);
    return silent;
}

#define HELD(type, field)                                                                          \
    { offsetof(type, field), sizeof(((type *)0)->field) }
#define HELD_END                                                                                   \
    { 0, 0 }

static void every_field_is_recorded(void **unused) {
    (void)unused;
    if (sizeof(void *) != 8) skip(); /* the pads are others */
    double const numbers[27] = {1.0, 2.0, 3.0, 4.0, 5.0};
    uint32_t const indices[3] = {0, 1, 2};
    tulle_mesh_view const mesh = {numbers, 3, indices, 1};
    recorded_call call = {.kind = RECORD_CREATE, .numbers = {fields_version}, .texts = {"0.1.0"}};
    call.def.world = tulle_world_def_default();
    size_t const none[][2] = {HELD_END};
    size_t const worlds[][2] = {HELD(tulle_world_def, allocator), HELD(tulle_world_def, paper),
                                HELD_END};
    assert_int_equal(count_silent_bytes(&call, sizeof(tulle_world_def), worlds), SILENT_WORLD);
    call = (recorded_call){.kind = RECORD_MATERIAL};
    call.def.material = tulle_cloth_def_default().material;
    assert_int_equal(count_silent_bytes(&call, sizeof(tulle_material), none), 0);
    call = (recorded_call){.kind = RECORD_CLOTH};
    tulle_crease const creases[1] = {{{0, 1}, 0.5}};
    tulle_keyframe const keys[2] = {{.time = 1.0}, {.time = 2.0}};
    tulle_pin pins[1] = {make_pin(indices, 3, 4.0)};
    pins[0].motion = (tulle_motion){keys, 2, {1.0, 2.0, 3.0}, 1};
    tulle_cloth_def *const cloth = &call.def.cloth;
    *cloth = tulle_cloth_def_default();
    cloth->name = "name";
    cloth->mesh = mesh;
    cloth->rest_positions = cloth->rest_corners = cloth->warps = cloth->velocities = numbers;
    cloth->stiffness_factors = numbers;
    cloth->creases = creases;
    cloth->crease_count = 1;
    cloth->pins = pins;
    cloth->pin_count = 1;
    cloth->contact_material = "material";
    size_t const in_cloth[][2] = {HELD(tulle_cloth_def, name),
                                  HELD(tulle_cloth_def, mesh),
                                  HELD(tulle_cloth_def, rest_positions),
                                  HELD(tulle_cloth_def, rest_corners),
                                  HELD(tulle_cloth_def, creases),
                                  HELD(tulle_cloth_def, crease_count),
                                  HELD(tulle_cloth_def, warps),
                                  HELD(tulle_cloth_def, contact_material),
                                  HELD(tulle_cloth_def, pins),
                                  HELD(tulle_cloth_def, pin_count),
                                  HELD(tulle_cloth_def, velocities),
                                  HELD(tulle_cloth_def, stiffness_factors),
                                  HELD_END};
    assert_int_equal(count_silent_bytes(&call, sizeof *cloth, in_cloth), SILENT_CLOTH);
    call = (recorded_call){.kind = RECORD_OBSTACLE};
    tulle_obstacle_def *const obstacle = &call.def.obstacle;
    *obstacle = tulle_obstacle_def_default();
    obstacle->name = "name";
    obstacle->mesh = mesh;
    obstacle->contact_material = "material";
    obstacle->motion = pins[0].motion;
    size_t const in_obstacle[][2] = {
        HELD(tulle_obstacle_def, name),          HELD(tulle_obstacle_def, mesh),
        HELD(tulle_obstacle_def, motion.keys),   HELD(tulle_obstacle_def, motion.key_count),
        HELD(tulle_obstacle_def, read_frame),    HELD(tulle_obstacle_def, contact_material),
        HELD(tulle_obstacle_def, frame_context), HELD_END};
    assert_int_equal(count_silent_bytes(&call, sizeof *obstacle, in_obstacle), SILENT_OBSTACLE);
    call = (recorded_call){.kind = RECORD_ATTACH};
    tulle_attachment_def *const attachment = &call.def.attachment;
    *attachment = tulle_attachment_def_default();
    attachment->vertices = attachment->triangles = indices;
    attachment->points = attachment->weights = numbers;
    attachment->vertex_count = 3;
    size_t const in_attachment[][2] = {
        HELD(tulle_attachment_def, vertices), HELD(tulle_attachment_def, vertex_count),
        HELD(tulle_attachment_def, points),   HELD(tulle_attachment_def, triangles),
        HELD(tulle_attachment_def, weights),  HELD_END};
    assert_int_equal(count_silent_bytes(&call, sizeof *attachment, in_attachment),
                     SILENT_ATTACHMENT);
}

/* ---- the public calls ---- */

/* Of the calls that take a world that may change, those that change nothing of what it comes to. */
static const char *const not_recorded[] = {"tulle_cloth_get_patches",
                                           "tulle_object_copy_contacts",
                                           "tulle_object_set_user_data",
                                           "tulle_world_cast_ray",
                                           "tulle_world_destroy",
                                           "tulle_world_find_box_overlaps",
                                           "tulle_world_find_closest_point",
                                           "tulle_world_find_mesh_overlaps",
                                           "tulle_world_get_contacts",
                                           "tulle_world_poll_events",
                                           "tulle_world_record",
                                           "tulle_world_set_stop_request",
                                           "tulle_world_set_tasks",
                                           "tulle_world_start_at", /* as tulle_world_start */
                                           "tulle_world_update_queries"};

static bool is_known_call(const char *name) {
    for (size_t i = 0; i < sizeof not_recorded / sizeof not_recorded[0]; i++)
        if (strcmp(not_recorded[i], name) == 0) return true;
    for (int i = 0; i < RECORD_KIND_COUNT; i++)
        if (strcmp(record_kinds[i].name, name) == 0) return true;
    return false;
}

/* Looks through a header; gives the number of calls that take a world that may change. */
static size_t check_header(const char *source, const char *header) {
    static char text[1 << 18];
    char path[1024];
    snprintf(path, sizeof path, "%s/include/tulle/%s", source, header);
    FILE *const file = fopen(path, "r");
    assert_non_null(file);
    size_t const size = fread(text, 1, sizeof text - 1, file);
    fclose(file);
    assert_true(size < sizeof text - 1);
    text[size] = '\0';
    size_t found = 0;
    for (char *call = strstr(text, "\nTULLE_API "); call;) {
        char *const next = strstr(call + 1, "\nTULLE_API ");
        char *const open = strchr(call, '(');
        assert_non_null(open);
        if (strncmp(open, "(tulle_world *world", 19) == 0) {
            *open = '\0';
            const char *const name = strrchr(call, ' ') + 1;
            if (!is_known_call(name + (name[0] == '*')))
                fail_msg("%s: %s is not recorded; record it or list it here", header, name);
            found++;
        }
        call = next;
    }
    return found;
}

static void every_call_is_recorded(void **unused) {
    (void)unused;
    const char *const source = getenv("TULLE_SOURCE_DIR");
    if (!source) skip(); /* CTest sets it */
    char path[1024];
    snprintf(path, sizeof path, "%s/include/tulle", source);
    DIR *const folder = opendir(path);
    assert_non_null(folder);
    size_t found = 0;
    for (const struct dirent *entry; (entry = readdir(folder));)
        if (entry->d_name[0] != '.') found += check_header(source, entry->d_name);
    closedir(folder);
    assert_true(found > 40);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_call_is_repeated), cmocka_unit_test(recording_changes_no_bit),
        cmocka_unit_test(cut_anywhere),           cmocka_unit_test(changed_anywhere),
        cmocka_unit_test(differences_are_told),   cmocka_unit_test(an_observer_ends_it),
        cmocka_unit_test(a_full_disk_is_told),    cmocka_unit_test(every_field_is_recorded),
        cmocka_unit_test(every_call_is_recorded),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
