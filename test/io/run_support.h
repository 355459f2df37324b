/* A run without physics, written to a directory: what the tests of run directories share. */
#ifndef TULLE_TEST_RUN_SUPPORT_H
#define TULLE_TEST_RUN_SUPPORT_H

#include "base/hash.h"
#include "io/output_file.h"

#include "io/io_support.h"
#include "tulle_io/run.h"

#include <math.h>

/* The state is a number that each step mixes, frames follow from it. */
enum { FRAME_COUNT = 12, STEPS_PER_FRAME = 3, BODY_COUNT = 4, CLOTH_VERTICES = 30 };

static double cloth_positions[3 * CLOTH_VERTICES], box_positions[12];
static uint32_t cloth_triangles[3 * (CLOTH_VERTICES - 2)];
static const uint32_t box_triangles[] = {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};
static tulle_run_body bodies[BODY_COUNT];
static int records_debug = 1; /* of runs that are made from now on; 2: velocities alone */

static inline void make_bodies(void) {
    uint64_t seed = 9;
    for (int i = 0; i < 3 * CLOTH_VERTICES; i++) cloth_positions[i] = random_uniform(&seed);
    for (int i = 0; i < 12; i++) box_positions[i] = random_uniform(&seed);
    for (uint32_t i = 0; i < 3 * (CLOTH_VERTICES - 2); i++) cloth_triangles[i] = i / 3 + i % 3;
    tulle_mesh_view const cloth = {cloth_positions, CLOTH_VERTICES, cloth_triangles,
                                   CLOTH_VERTICES - 2};
    tulle_mesh_view const box = {box_positions, 4, box_triangles, 4};
    bodies[0] = (tulle_run_body){.name = "sheet", .mesh = cloth};
    bodies[1] = (tulle_run_body){.name = "odd name/..", .mesh = cloth};
    bodies[2] = (tulle_run_body){.name = "Sheet", .mesh = box, .is_obstacle = 1, .is_dynamic = 1};
    bodies[3] = (tulle_run_body){.name = "ground", .mesh = box, .is_obstacle = 1, .is_static = 1};
}

static inline tulle_run_def make_def(const char *directory, uint32_t frame_count) {
    tulle_run_def def = tulle_run_def_default();
    def.directory = directory;
    def.scene_path = "scenes/test.yaml";
    def.scene_text = "cloth: []\n";
    def.scene_hash = UINT64_C(0x123456789abcdef0);
    def.seed = UINT64_MAX;
    def.time_step = 0.01;
    def.steps_per_frame = STEPS_PER_FRAME;
    def.frame_count = frame_count;
    def.records_debug = records_debug == 1;
    def.records_velocities = records_debug == 2;
    def.bodies = bodies;
    def.body_count = BODY_COUNT;
    return def;
}

/* The last key of a run.json and what follows. */
static inline char *find_seal(char *text) { return strstr(text, ",\n  \"checksum\": \""); }

/* Gives the text of a run.json that a test has changed the checksum of its bytes. */
static inline void seal_record(char *text) {
    char *const seal = find_seal(text);
    assert_non_null(seal);
    uint64_t const hash = hash_bytes(FILE_SUM_SEED, text, (size_t)(seal - text));
    snprintf(seal, 40, ",\n  \"checksum\": \"%016llx\"\n}\n", (unsigned long long)hash);
}

static inline void find_positions(uint64_t state, int body, double *positions) {
    uint64_t seed = state + (uint64_t)body;
    size_t const count = 3 * bodies[body].mesh.vertex_count;
    for (size_t i = 0; i < count; i++) positions[i] = random_uniform(&seed);
}

/* ---- what explains a frame ---- */

enum { CONTACT_MAX = 20, UNKNOWN_STEP = 9 /* nothing is known of this frame */ };

typedef struct debug_source {
    double velocities[3][3 * CLOTH_VERTICES];
    uint32_t labels[2][CLOTH_VERTICES - 2];
    tulle_contact contacts[CONTACT_MAX];
    const double *velocity_pointers[BODY_COUNT];
    const uint32_t *label_pointers[BODY_COUNT];
    uint32_t patch_counts[BODY_COUNT];
    tulle_run_debug debug;
} debug_source;

static inline void find_contact(uint64_t *seed, tulle_contact *contact) {
    *contact = (tulle_contact){.kind = random_next(seed) % 2 ? TULLE_CONTACT_EDGE_EDGE
                                                             : TULLE_CONTACT_VERTEX_FACE,
                               .state = (tulle_contact_state)(random_next(seed) % 3),
                               .is_new = (int)(random_next(seed) % 2),
                               .is_hard = (int)(random_next(seed) % 2),
                               .object_a = (uint32_t)(random_next(seed) % BODY_COUNT),
                               .object_b = (uint32_t)(random_next(seed) % BODY_COUNT),
                               .gap = random_uniform(seed)};
    for (int k = 0; k < 4; k++) {
        contact->vertices[k] = (uint32_t)(random_next(seed) % 4); /* all bodies have four */
        contact->weights[k] = random_uniform(seed) - 0.5;
    }
    for (int k = 0; k < 3; k++) {
        contact->position[k] = random_uniform(seed);
        contact->normal[k] = random_uniform(seed);
        contact->impulse[k] = random_uniform(seed);
    }
}

/* Labels of one, two and four bytes. */
static inline void find_debug(uint64_t state, debug_source *source) {
    static const uint32_t patch_counts[3] = {7, 300, 70000};
    uint64_t seed = hash_mix(state);
    *source = (debug_source){.debug = {.velocities = source->velocity_pointers,
                                       .contacts = source->contacts,
                                       .contact_count = state % CONTACT_MAX,
                                       .patch_labels = source->label_pointers,
                                       .patch_counts = source->patch_counts}};
    for (int i = 0; i < 3; i++) {
        for (int k = 0; k < 3 * CLOTH_VERTICES; k++)
            source->velocities[i][k] = random_uniform(&seed) - 0.5;
        source->velocity_pointers[i] = source->velocities[i];
    }
    for (int i = 0; i < 2; i++) {
        source->patch_counts[i] = patch_counts[(state + (uint64_t)i) % 3];
        for (int k = 0; k < CLOTH_VERTICES - 2; k++)
            source->labels[i][k] = (uint32_t)(random_next(&seed) % (source->patch_counts[i] + 1));
        source->label_pointers[i] = source->labels[i];
    }
    for (int k = 0; k < CONTACT_MAX; k++) find_contact(&seed, &source->contacts[k]);
}

static inline void assert_floats(const double *read, const double *written, size_t count) {
    for (size_t i = 0; i < count; i++) assert_true(read[i] == (double)(float)written[i]);
}

static inline void assert_contact(const tulle_contact *read, const tulle_contact *written) {
    assert_int_equal(read->kind, written->kind);
    assert_int_equal(read->state, written->state);
    assert_int_equal(read->is_new, written->is_new);
    assert_int_equal(read->is_hard, written->is_hard);
    assert_int_equal(read->object_a, written->object_a);
    assert_int_equal(read->object_b, written->object_b);
    assert_memory_equal(read->vertices, written->vertices, sizeof read->vertices);
    assert_floats(read->weights, written->weights, 4);
    assert_floats(read->position, written->position, 3);
    assert_floats(read->normal, written->normal, 3);
    assert_floats(&read->gap, &written->gap, 1);
    assert_floats(read->impulse, written->impulse, 3);
}

/* The record is that of the state and step. */
static inline void assert_debug(const tulle_run_debug *debug, uint64_t state, uint64_t step) {
    debug_source source;
    find_debug(state, &source);
    assert_int_equal(debug == NULL, step == UNKNOWN_STEP);
    if (!debug) return;
    for (int i = 0; i < BODY_COUNT; i++) {
        assert_int_equal(debug->velocities[i] == NULL, bodies[i].is_static);
        if (debug->velocities[i])
            assert_floats(debug->velocities[i], source.velocities[i],
                          3 * bodies[i].mesh.vertex_count);
        if (records_debug == 2) continue;
        assert_int_equal(debug->patch_labels[i] == NULL, bodies[i].is_obstacle);
        assert_int_equal(debug->patch_counts[i], source.patch_counts[i]);
        if (debug->patch_labels[i])
            assert_memory_equal(debug->patch_labels[i], source.labels[i], sizeof source.labels[i]);
    }
    if (records_debug == 2) {
        assert_true(!debug->patch_labels && !debug->patch_counts && !debug->contacts);
        source.debug.contact_count = 0;
    }
    assert_int_equal(debug->contact_count, source.debug.contact_count);
    for (size_t i = 0; i < debug->contact_count; i++)
        assert_contact(&debug->contacts[i], &source.contacts[i]);
}

/* ---- frames, reports, checkpoints ---- */

/* Of a body that lags in a frame of this state; state % 3 do, bodies 0 and 2. */
static inline tulle_run_lag make_lag(uint64_t state, uint32_t body) {
    return (tulle_run_lag){body, (uint32_t)(state % 5), 1e-3 * (double)(1 + state % 7) / 3.0,
                           state >> 40};
}

static inline tulle_status write_frame(tulle_run_writer *writer, uint64_t state, uint64_t step,
                                       tulle_error *error) {
    double positions[3][3 * CLOTH_VERTICES];
    for (int i = 0; i < 3; i++) find_positions(state, i, positions[i]);
    const double *const pointers[BODY_COUNT] = {positions[0], positions[1], positions[2], NULL};
    int const present[BODY_COUNT] = {1, 1, step < 18, 1};
    debug_source source;
    find_debug(state, &source);
    uint64_t seed = state;
    tulle_transform transform = {.mass = random_uniform(&seed), .velocity = {-1e-300, 0.1, 3e20}};
    for (int k = 0; k < 3; k++) transform.position[k] = random_uniform(&seed) - 0.5;
    tulle_run_lag const lags[2] = {make_lag(state, 0), make_lag(state, 2)};
    tulle_run_frame const frame = {.time = (double)step * 0.01,
                                   .step = step,
                                   .state_hash = hash_mix(state),
                                   .positions = pointers,
                                   .is_present = present,
                                   .transforms = &transform,
                                   .lags = lags,
                                   .lag_count = state % 3,
                                   .debug = step == UNKNOWN_STEP ? NULL : &source.debug};
    return tulle_run_write_frame(writer, &frame, error);
}

static inline tulle_status write_checkpoint(tulle_run_writer *writer, uint64_t state, uint64_t step,
                                            tulle_error *error) {
    tulle_run_checkpoint const checkpoint = {.bytes = &state,
                                             .byte_count = sizeof state,
                                             .step = step,
                                             .time = (double)step * 0.01,
                                             .state_hash = hash_mix(state)};
    return tulle_run_write_checkpoint(writer, &checkpoint, error);
}

static inline tulle_status write_report(tulle_run_writer *writer, uint64_t state, uint64_t step,
                                        tulle_error *error) {
    tulle_step_report const report = {.step = step,
                                      .time = (double)(step + 1) * 0.01,
                                      .contacts = state >> 12, /* a number of JSON */
                                      .smallest_gap = INFINITY};
    return tulle_run_write_report(writer, &report, error);
}

/* Goes on from the writer's beginning or the checkpoint to the end; a checkpoint every 4 steps. */
static inline tulle_status go_on(tulle_run_writer *writer, tulle_run_checkpoint *checkpoint,
                                 uint32_t frame_count, tulle_error *error) {
    uint64_t state = 42, step = 0;
    tulle_status status = TULLE_OK;
    if (checkpoint->bytes) {
        assert_int_equal(checkpoint->byte_count, sizeof state);
        memcpy(&state, checkpoint->bytes, sizeof state);
        assert_true(checkpoint->state_hash == hash_mix(state));
        step = checkpoint->step;
        assert_int_equal(checkpoint->frame_count, tulle_run_get_frame_count(writer));
        tulle_run_free_checkpoint(checkpoint);
    } else {
        status = write_frame(writer, state, step, error);
        if (!status) status = write_checkpoint(writer, state, step, error);
    }
    while (!status && step < (uint64_t)frame_count * STEPS_PER_FRAME) {
        state = hash_mix(state + 1);
        status = write_report(writer, state, step, error);
        step++;
        if (!status && step % STEPS_PER_FRAME == 0)
            status = write_frame(writer, state, step, error);
        if (!status && step % 4 == 0) status = write_checkpoint(writer, state, step, error);
    }
    if (!status) status = write_checkpoint(writer, state, step, error);
    return status;
}

static inline void run_whole(const char *directory, uint32_t frame_count) {
    tulle_run_def const def = make_def(directory, frame_count);
    tulle_run_writer *writer = NULL;
    tulle_run_checkpoint none = {0};
    tulle_error error = {0};
    if (tulle_run_create(&def, TULLE_RUN_REFUSE, &writer, &error) ||
        go_on(writer, &none, frame_count, &error) ||
        tulle_run_close(writer, TULLE_RUN_FINISHED, "all is well", &error))
        fail_msg("%s: %s", error.file, error.message);
}

static inline tulle_status resume_run(const char *directory, uint32_t frame_count,
                                      tulle_error *error) {
    tulle_run_def const def = make_def(directory, frame_count);
    tulle_run_writer *writer = NULL;
    tulle_run_checkpoint checkpoint;
    tulle_status status = tulle_run_resume(&def, &writer, &checkpoint, error);
    if (!status) status = go_on(writer, &checkpoint, frame_count, error);
    if (!status) return tulle_run_close(writer, TULLE_RUN_FINISHED, "all is well", error);
    if (writer) tulle_run_close(writer, TULLE_RUN_FAILED, NULL, NULL);
    return status;
}

static inline void assert_same_file(const char *a, const char *b, const char *name) {
    char path[1024];
    size_t size_a, size_b;
    snprintf(path, sizeof path, "%s/%s", a, name);
    char *const bytes_a = get_file(path, &size_a);
    snprintf(path, sizeof path, "%s/%s", b, name);
    char *const bytes_b = get_file(path, &size_b);
    if (size_a != size_b || memcmp(bytes_a, bytes_b, size_a) != 0)
        fail_msg("%s differs between %s and %s", name, a, b);
    free(bytes_a);
    free(bytes_b);
}

static const char *const all_files[] = {
    "run.json",        "scene.yaml",     "frames.csv",    "report.csv",
    "bodies.csv",      "checkpoint.bin", "sheet.obj",     "sheet.pc2",
    "Sheet-2.obj",     "Sheet-2.pc2",    "ground.obj",    "odd_name_...obj",
    "odd_name_...pc2", "debug.bin",      "checksums.csv", "checkpoint.previous.bin"};
enum { FILE_COUNT = sizeof all_files / sizeof all_files[0] };

static inline void assert_same_run(const char *a, const char *b) {
    assert_int_equal(count_files(a), FILE_COUNT);
    assert_int_equal(count_files(b), FILE_COUNT);
    /* The generation before depends on where the run was cut. */
    for (size_t i = 0; i + 1 < FILE_COUNT; i++) assert_same_file(a, b, all_files[i]);
}

/* Every whole frame of the directory is what was written; returns their number. */
static inline uint32_t assert_sound(const char *directory) {
    tulle_run_reader *reader = NULL;
    tulle_error error = {0};
    if (tulle_run_reader_open(directory, &reader, &error))
        fail_msg("%s: %s", error.file, error.message);
    const tulle_run_info *const info = tulle_run_reader_get_info(reader);
    uint64_t state = 42;
    for (uint32_t frame = 0; frame < info->frame_count; frame++) {
        double time;
        uint64_t step, hash;
        assert_int_equal(tulle_run_reader_get_frame(reader, frame, &time, &step, &hash), TULLE_OK);
        assert_int_equal(step, frame * STEPS_PER_FRAME);
        assert_true(time == (double)step * 0.01);
        assert_true(hash == hash_mix(state));
        const tulle_run_lag *lags = NULL;
        size_t lag_count = 9;
        assert_int_equal(tulle_run_reader_get_lags(reader, frame, &lags, &lag_count), TULLE_OK);
        assert_int_equal(lag_count, state % 3);
        for (size_t i = 0; i < lag_count; i++) {
            tulle_run_lag const lag = make_lag(state, i == 0 ? 0 : 2);
            assert_int_equal(lags[i].body, lag.body);
            assert_int_equal(lags[i].vertex, lag.vertex);
            assert_true(lags[i].lag == lag.lag && lags[i].drawn_crossings == lag.drawn_crossings);
        }
        for (int body = 0; body < BODY_COUNT; body++) {
            double expected[3 * CLOTH_VERTICES], read[3 * CLOTH_VERTICES];
            size_t const count = 3 * bodies[body].mesh.vertex_count;
            find_positions(state, body, expected);
            assert_int_equal(
                tulle_run_reader_read_positions(reader, frame, (size_t)body, read, &error),
                TULLE_OK);
            for (size_t i = 0; i < count; i++)
                assert_true(read[i] == (bodies[body].is_static ? box_positions[i]
                                                               : (double)(float)expected[i]));
            assert_int_equal(tulle_run_reader_is_present(reader, frame, (size_t)body),
                             body != 2 || step < 18);
        }
        const tulle_run_debug *debug = NULL;
        if (tulle_run_reader_read_debug(reader, frame, &debug, &error))
            fail_msg("%s: %s", error.file, error.message);
        assert_debug(debug, state, step);
        for (int i = 0; i < STEPS_PER_FRAME; i++) state = hash_mix(state + 1);
    }
    uint32_t const frame_count = info->frame_count;
    tulle_run_reader_close(reader);
    return frame_count;
}

#endif
