/* fuzz/targets/recording.c - tulle_replay. No bytes crash it; a replay that is refused says why;
 * repeated on two threads the same bytes come to the same.
 *
 * The first byte of an input says whether the checks of its blocks are made right, and whether the
 * rest begins as a recording does. */
#include "support/fuzz.h"

#include "tulle/tulle.h"
#include "world/record/recorded_call.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { FLAG_RIGHT_CHECKS = 1, FLAG_RIGHT_MAGIC = 2, RUNS_MAX = 8, TIME_STEPS = 4 };
static const double time_step = 1.0 / 64.0; /* [s] */

/* ---- seeds ---- */

typedef struct sink {
    unsigned char *bytes;
    size_t byte_count;
} sink;

static int write_block(void *context, const void *bytes, size_t byte_count) {
    sink *const self = context;
    self->bytes = realloc(self->bytes, self->byte_count + byte_count);
    FUZZ_CHECK(self->bytes);
    memcpy(self->bytes + self->byte_count, bytes, byte_count);
    self->byte_count += byte_count;
    return 1;
}

static const double corners[] = {0, 0, 0.1, 0.1, 0, 0.1, 0.1, 0.1, 0.1, 0, 0.1, 0.1};
static const uint32_t triangles[] = {0, 1, 2, 0, 2, 3};
static const double solid[] = {0, 0, 0.2, 0.1, 0, 0.2, 0, 0.1, 0.2, 0, 0, 0.3};
static const uint32_t faces[] = {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};
static const double plate[] = {-1, -1, 0, 1, -1, 0, 0, 1, 0};

static tulle_status read_plate(void *context, uint32_t frame, double *positions,
                               tulle_error *error) {
    (void)context, (void)error;
    memcpy(positions, plate, sizeof plate);
    positions[2] += 0.01 * frame;
    return TULLE_OK;
}

static int collide(void *context, const tulle_world *world, tulle_object_id a, tulle_object_id b) {
    (void)context, (void)world, (void)a, (void)b;
    return 1;
}

static void add_objects(tulle_world *world, tulle_error *error) {
    tulle_pin pin = tulle_pin_default();
    pin.vertices = triangles;
    pin.vertex_count = 2;
    pin.release_time = 9.0;
    tulle_crease const crease = {{0, 2}, 0.1};
    tulle_cloth_def cloth = tulle_cloth_def_default();
    cloth.name = "c";
    cloth.contact_material = "m";
    cloth.mesh = (tulle_mesh_view){corners, 4, triangles, 2};
    cloth.pins = &pin;
    cloth.pin_count = 1;
    cloth.creases = &crease;
    cloth.crease_count = 1;
    FUZZ_CHECK_OK(tulle_world_add_cloth(world, &cloth, NULL, error), error);
    for (int i = 0; i < 3; i++) {
        tulle_obstacle_def def = tulle_obstacle_def_default();
        def.mesh = (tulle_mesh_view){plate, 3, triangles, 1};
        if (i == 0) def.drive = TULLE_DRIVE_RIGID;
        if (i == 1) def.mesh = (tulle_mesh_view){solid, 4, faces, 4};
        if (i == 1) def.body = (tulle_body){.is_dynamic = 1, .density = 100.0};
        if (i == 2) def.read_frame = read_plate;
        def.frame_count = 3;
        FUZZ_CHECK_OK(tulle_world_add_obstacle(world, &def, NULL, error), error);
    }
}

static void call_everything(tulle_world *world, bool loads, tulle_error *error) {
    tulle_obstacle_id const driven = {0, 1}, body = {1, 1};
    tulle_cloth_id const cloth = {0, 1};
    tulle_contact_law const law = {0.3, 0.2, 0.1};
    tulle_body_drive const drive = tulle_body_drive_default();
    tulle_event_watch const watch = tulle_event_watch_default();
    tulle_wind const wind = tulle_world_def_default().wind;
    double const numbers[4] = {0.0, 0.0, 0.01, 1.0}, turn[4] = {1.0, 0.0, 0.0, 0.0};
    (void)tulle_world_set_cloth_obstacle_law(world, cloth, driven, &law, error);
    (void)tulle_world_set_material_law(world, "m", "silk", &law, error);
    (void)tulle_world_set_pair_filter(world, collide, NULL, error);
    (void)tulle_world_start(world, error);
    (void)tulle_world_set_wind(world, &wind, error);
    (void)tulle_world_set_gravity(world, numbers, error);
    (void)tulle_world_watch_events(world, &watch, error);
    (void)tulle_obstacle_set_drive(world, body, &drive, error);
    (void)tulle_obstacle_set_locks(world, body, 1, 2, error);
    uint32_t const vertex = 3;
    tulle_attachment_def def = tulle_attachment_def_default();
    tulle_attachment_id id;
    def.cloth = cloth;
    def.vertices = &vertex;
    def.vertex_count = 1;
    def.points = numbers;
    def.stiffness = 1.0;
    (void)tulle_world_attach(world, &def, &id, error);
    for (int i = 0; i < TIME_STEPS; i++) {
        (void)tulle_obstacle_add_force(world, body, NULL, numbers, error);
        (void)tulle_obstacle_set_next_transform(world, driven, numbers, turn, TULLE_TRAVEL_MOVE,
                                                error);
        (void)tulle_world_step(world, time_step, NULL, error);
    }
    (void)tulle_cloth_release_pin(world, cloth, 0, error);
    (void)tulle_cloth_wake(world, cloth, error);
    void *state = NULL;
    size_t size = 0;
    if (loads && tulle_world_save_state(world, &state, &size, error) == TULLE_OK)
        (void)tulle_world_load_state(world, state, size, error);
    tulle_world_free_state(world, state, size);
}

/* Objects come and go after the start. */
static void change_objects(tulle_world *world, tulle_error *error) {
    double raised[12];
    for (int i = 0; i < 12; i++) raised[i] = corners[i] + (i % 3 == 2 ? 0.5 : 0.0);
    tulle_cloth_def cloth = tulle_cloth_def_default();
    cloth.mesh = (tulle_mesh_view){raised, 4, triangles, 2};
    tulle_obstacle_def obstacle = tulle_obstacle_def_default();
    obstacle.mesh = (tulle_mesh_view){plate, 3, triangles, 1};
    obstacle.read_frame = read_plate;
    obstacle.frame_count = 3;
    (void)tulle_world_start(world, error);
    (void)tulle_world_add_cloth(world, &cloth, NULL, error);
    (void)tulle_world_step(world, time_step, NULL, error);
    (void)tulle_world_remove_obstacle(world, (tulle_obstacle_id){2, 1}, error);
    (void)tulle_world_add_obstacle(world, &obstacle, NULL, error);
    (void)tulle_world_remove_cloth(world, (tulle_cloth_id){0, 1}, error);
    (void)tulle_world_step(world, time_step, NULL, error);
}

void fuzz_make_seeds(void) {
    for (int kind = 0; kind < 7; kind++) {
        tulle_error error = {0};
        tulle_world_def def = tulle_world_def_default();
        def.start_intersections = (tulle_start_intersections)(kind % 3);
        tulle_world *world = NULL;
        unsigned char const flags = kind == 0 ? 0 : FLAG_RIGHT_CHECKS | FLAG_RIGHT_MAGIC;
        sink made = {0};
        tulle_record_writer const writer = {write_block, &made};
        (void)write_block(&made, &flags, 1);
        FUZZ_CHECK_OK(tulle_world_create(&def, &world, &error), &error);
        FUZZ_CHECK_OK(tulle_world_record(world, &writer, &error), &error);
        if (kind > 0) add_objects(world, &error);
        if (kind == 6)
            change_objects(world, &error);
        else if (kind > 1)
            call_everything(world, kind == 4, &error);
        tulle_world_destroy(world);
        char name[32];
        snprintf(name, sizeof name, "recording_%d", kind);
        fuzz_put_seed(name, made.bytes, kind == 5 ? made.byte_count - 70 : made.byte_count);
        free(made.bytes);
    }
}

/* ---- an input ---- */

static void make_checks_right(uint8_t *bytes, size_t size) {
    size_t const around = RECORD_HEAD_BYTES + RECORD_HASH_BYTES;
    for (size_t place = RECORD_MAGIC_BYTES; place < size && size - place >= around;) {
        uint64_t const length = record_load(bytes + place, 8);
        if (length > size - place - around) return;
        record_seal(bytes + place, around + (size_t)length);
        place += around + (size_t)length;
    }
}

static int end_soon(void *context, const tulle_world *world, const tulle_replay_report *report) {
    (void)report;
    FUZZ_CHECK(world);
    return ++*(int *)context >= RUNS_MAX;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    if (size == 0) return 0;
    uint8_t const flags = data[0];
    uint8_t *const bytes = malloc(size);
    FUZZ_CHECK(bytes);
    size -= 1;
    memcpy(bytes, data + 1, size);
    if (flags & FLAG_RIGHT_MAGIC && size >= RECORD_MAGIC_BYTES)
        memcpy(bytes, RECORD_MAGIC, RECORD_MAGIC_BYTES);
    if (flags & FLAG_RIGHT_CHECKS) make_checks_right(bytes, size);
    tulle_replay_report reports[2];
    tulle_status statuses[2];
    for (int i = 0; i < 2; i++) {
        int runs = 0;
        tulle_error error = {0};
        tulle_replay_options const options = {i + 1, end_soon, &runs};
        statuses[i] = tulle_replay(bytes, size, &options, &reports[i], &error);
        if (statuses[i]) fuzz_check_error(statuses[i], &error);
        FUZZ_CHECK(statuses[i] != TULLE_OK || reports[i].offset <= size);
    }
    FUZZ_CHECK(statuses[0] == statuses[1] && reports[0].calls == reports[1].calls);
    FUZZ_CHECK(reports[0].hash == reports[1].hash && reports[0].status == reports[1].status);
    FUZZ_CHECK(reports[0].is_different == reports[1].is_different);
    free(bytes);
    return 0;
}
