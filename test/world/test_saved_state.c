/* Saved states that are damaged, and such as were made to pass for whole: refused or harmless, and
 * a refused one changes nothing. The layout of the bytes is told in world/state.c. */
#include "base/hash.h"
#include "support/body_world.h"
#include "support/paper_options.h"
#include "world/world_state.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static const double STEP = 1.0 / 60.0;
/* Bytes of the header: magic, hash, then numbers of 8 bytes. */
enum { HASH_AT = 8, HASHED_FROM = 16, HEADER_BYTES = 152 };
enum { VERTEX_COUNT_AT = 32, CONTACT_BYTES_AT = 56, PATCH_BYTES_AT = 64, IGNORED_COUNT_AT = 80 };
enum { STILL_COUNT_AT = 88, ATTACHMENTS_AT = 112, LAG_COUNT_AT = 120 };
enum { TIME_AT = 128, TIME_STEP_AT = 136, ENERGY_AT = 144 };
enum { CONTACT_HEADER_BYTES = 16, PATCH_ANGLE_AT = 40, PATCH_REACH_AT = 48 };

static void add_moving(tulle_world *world, const tulle_mesh *mesh, double way) {
    tulle_obstacle_def def = tulle_obstacle_def_default();
    tulle_keyframe const keys[] = {{0.0, {0, 0, 0}, {0, 0, 0}}, {0.2, {0, 0, way}, {0, 0, 0}}};
    def.mesh = tulle_mesh_get_view(mesh);
    def.motion = (tulle_motion){keys, 2, {0, 0, 0}, 0};
    assert_int_equal(tulle_world_add_obstacle(world, &def, NULL, NULL), TULLE_OK);
}

/* A sheet between two plates that close to nothing; two sheets that cross from the start and are
 * ignored; with is_paper a vertex-by-vertex response, else a box on a ground that is pressed, too.
 */
static tulle_world *make_world(bool is_paper) {
    tulle_world_def def = tulle_world_def_default();
    if (!is_paper) def.integrator = TULLE_INTEGRATOR_BDF2; /* its states hold most */
    def.on_pinch = TULLE_ON_PINCH_SLOW;
    def.start_intersections = TULLE_START_IGNORE;
    def.threads = 1;
    if (is_paper) change_paper(&def)->response = TULLE_RESPONSE_PAPER;
    tulle_world *const world = bodies_make_world(&def, false);
    tulle_mesh sheet = small_sheet(0.3, 7, 0.0), flat = small_sheet(0.2, 4, 3.0);
    tulle_mesh upright = small_sheet(0.2, 4, 3.0);
    for (size_t v = 0; v < upright.vertex_count; v++) {
        double *const x = upright.positions + 3 * v;
        x[2] = 3.01 + x[1];
        x[1] = 0.02;
    }
    tulle_mesh plates[2] = {bodies_make_box(0.5, 0.5, 0.1, (double[]){0, 0, -0.06}),
                            bodies_make_box(0.5, 0.5, 0.1, (double[]){0, 0, 0.06})};
    tulle_mesh ground = bodies_make_box(0.5, 0.5, 0.1, (double[]){3, 0, -0.05});
    tulle_mesh box = bodies_make_box(0.1, 0.1, 0.1, (double[]){3, 0, 0.06});
    tulle_mesh press = bodies_make_box(0.1, 0.1, 0.1, (double[]){3, 0, 0.19});
    small_add_cloth(world, &sheet);
    small_add_cloth(world, &flat);
    small_add_cloth(world, &upright);
    small_add_obstacle(world, &plates[0]);
    add_moving(world, &plates[1], -0.021);
    small_add_obstacle(world, &ground);
    tulle_body const body = {.is_dynamic = 1, .density = 300.0};
    if (!is_paper) bodies_add_obstacle(world, &box, 0.5, &body);
    if (!is_paper) add_moving(world, &press, -0.06);
    tulle_mesh *const meshes[] = {&sheet,     &flat,   &upright, &plates[0],
                                  &plates[1], &ground, &box,     &press};
    for (size_t i = 0; i < sizeof meshes / sizeof meshes[0]; i++) tulle_mesh_destroy(meshes[i]);
    return world;
}

static void take_step(tulle_world *world) {
    tulle_error error = {0};
    if (tulle_world_step(world, STEP, NULL, &error) != TULLE_OK) fail_msg("%s", error.message);
}

/* A world after some steps, another one in the same state, and that state. */
typedef struct saved_world {
    tulle_world *world, *twin;
    unsigned char *bytes;
    size_t byte_count;
    uint64_t hash;
} saved_world;

static saved_world make_saved(bool is_paper) {
    saved_world made = {.world = make_world(is_paper), .twin = make_world(is_paper)};
    for (int i = 0; i < 14; i++) {
        take_step(made.world);
        take_step(made.twin);
    }
    void *bytes = NULL;
    assert_int_equal(tulle_world_save_state(made.world, &bytes, &made.byte_count, NULL), TULLE_OK);
    made.bytes = malloc(made.byte_count);
    assert_non_null(made.bytes);
    memcpy(made.bytes, bytes, made.byte_count);
    tulle_world_free_state(made.world, bytes, made.byte_count);
    made.hash = tulle_world_get_state_hash(made.world);
    return made;
}

/* What was refused has changed nothing, not even patches, which the hash does not hold. */
static void assert_unchanged(const saved_world *made) {
    assert_true(tulle_world_get_state_hash(made->world) == made->hash);
    void *bytes = NULL;
    size_t byte_count = 0;
    assert_int_equal(tulle_world_save_state(made->world, &bytes, &byte_count, NULL), TULLE_OK);
    assert_int_equal(byte_count, made->byte_count);
    assert_memory_equal(bytes, made->bytes, byte_count);
    tulle_world_free_state(made->world, bytes, byte_count);
}

/* Nothing has changed, neither now nor in the next step. */
static void free_saved(saved_world *made) {
    assert_unchanged(made);
    take_step(made->world);
    take_step(made->twin);
    assert_true(tulle_world_get_state_hash(made->world) == tulle_world_get_state_hash(made->twin));
    tulle_world_destroy(made->world);
    tulle_world_destroy(made->twin);
    free(made->bytes);
}

static uint64_t get_u64(const unsigned char *bytes) {
    uint64_t value;
    memcpy(&value, bytes, sizeof value);
    return value;
}

/* Gives bytes the hash that they should have. */
static void hash_again(unsigned char *bytes, size_t byte_count) {
    uint64_t const hash = hash_block(bytes + HASHED_FROM, byte_count - HASHED_FROM);
    memcpy(bytes + HASH_AT, &hash, sizeof hash);
}

static void no_bit_may_flip(void **state) {
    (void)state;
    saved_world made = make_saved(false);
    uint64_t random = 5;
    size_t const long_share = getenv("TULLE_TEST_LONG") ? 100 : 1;
    for (size_t i = 0; i < 8 * HEADER_BYTES + 400 * long_share; i++) {
        size_t const bit = i < 8 * HEADER_BYTES ? i : random_next(&random) % (8 * made.byte_count);
        unsigned char const mask = (unsigned char)(1u << bit % 8);
        made.bytes[bit / 8] ^= mask;
        tulle_error error = {0};
        if (tulle_world_load_state(made.world, made.bytes, made.byte_count, &error) !=
            TULLE_ERROR_PARSE)
            fail_msg("bit %zu of byte %zu: %s", bit % 8, bit / 8, error.message);
        assert_true(error.message[0] != '\0');
        made.bytes[bit / 8] ^= mask;
    }
    free_saved(&made);
}

/* A world that has not started is as new after a state was refused. */
static void a_refused_state_starts_nothing(void **state) {
    (void)state;
    saved_world made = make_saved(false);
    tulle_world *const fresh = make_world(false), *const other = make_world(false);
    uint64_t const before = tulle_world_get_state_hash(fresh);
    double const nan = (double)NAN;
    double time;
    memcpy(&time, made.bytes + TIME_AT, sizeof time);
    memcpy(made.bytes + TIME_AT, &nan, sizeof nan);
    hash_again(made.bytes, made.byte_count);
    assert_int_equal(tulle_world_load_state(fresh, made.bytes, made.byte_count, NULL),
                     TULLE_ERROR_PARSE);
    assert_true(tulle_world_get_state_hash(fresh) == before);
    assert_int_equal(tulle_world_get_step_count(fresh), 0);
    for (int i = 0; i < 2; i++) {
        take_step(fresh);
        take_step(other);
    }
    assert_true(tulle_world_get_state_hash(fresh) == tulle_world_get_state_hash(other));
    tulle_world_destroy(fresh);
    tulle_world_destroy(other);
    memcpy(made.bytes + TIME_AT, &time, sizeof time);
    hash_again(made.bytes, made.byte_count);
    free_saved(&made);
}

/* Writes `size` bytes at `offset`, with the hash made right: to be refused. */
static void refuse(const saved_world *made, const char *what, size_t offset, const void *value,
                   size_t size) {
    unsigned char *const bytes = malloc(made->byte_count);
    assert_non_null(bytes);
    assert_true(offset + size <= made->byte_count);
    memcpy(bytes, made->bytes, made->byte_count);
    memcpy(bytes + offset, value, size);
    hash_again(bytes, made->byte_count);
    tulle_error error = {0};
    tulle_status const status =
        tulle_world_load_state(made->world, bytes, made->byte_count, &error);
    free(bytes);
    if (status != TULLE_ERROR_PARSE && status != TULLE_ERROR_INVALID_ARGUMENT)
        fail_msg("%s: status %d", what, (int)status);
    if (tulle_world_get_state_hash(made->world) != made->hash) fail_msg("%s: has changed", what);
    if (error.message[0] == '\0') fail_msg("%s: no message", what);
}

static void refuse_double(const saved_world *made, const char *what, size_t offset, double value) {
    refuse(made, what, offset, &value, sizeof value);
}

static void refuse_bad_doubles(const saved_world *made, const char *what, size_t offset) {
    refuse_double(made, what, offset, (double)NAN);
    refuse_double(made, what, offset, (double)INFINITY);
    refuse_double(made, what, offset, -(double)INFINITY);
}

static void refuse_u32(const saved_world *made, const char *what, size_t offset, uint32_t value) {
    refuse(made, what, offset, &value, sizeof value);
}

static void refuse_u8(const saved_world *made, const char *what, size_t offset, uint8_t value) {
    refuse(made, what, offset, &value, sizeof value);
}

static void refuse_header(const saved_world *made) {
    refuse_bad_doubles(made, "time", TIME_AT);
    refuse_double(made, "time", TIME_AT, -1.0);
    refuse_bad_doubles(made, "time step", TIME_STEP_AT);
    refuse_double(made, "time step", TIME_STEP_AT, -0.1);
    refuse_double(made, "time step", TIME_STEP_AT, 1.5);
    refuse_bad_doubles(made, "lost energy", ENERGY_AT);
    for (size_t at = HASHED_FROM; at <= LAG_COUNT_AT; at += 8) {
        /* any number of steps may have been made, and of attachments */
        if (at == 48 || at == ATTACHMENTS_AT) continue;
        uint64_t const is = get_u64(made->bytes + at);
        uint64_t const values[] = {is + 1, is - 1, is + 8, UINT64_MAX, UINT64_MAX / 16, 0};
        for (size_t i = 0; i < sizeof values / sizeof values[0]; i++) {
            char name[32];
            snprintf(name, sizeof name, "count at %zu", at);
            if (values[i] != is) refuse(made, name, at, &values[i], sizeof values[i]);
        }
    }
}

/* Vertices whose vectors a saved state has: of the boxes, which are the obstacles and have equally
 * many, not those of the two that are static. */
static size_t count_moving(size_t vertex_count, size_t box_count, size_t slot_count) {
    size_t const others = 49 + 16 + 16 + slot_count;
    assert_int_equal((vertex_count - others) % box_count, 0);
    return others + (box_count - 2) * (vertex_count - others) / box_count;
}

static void crafted_values_are_refused(void **state) {
    (void)state;
    saved_world made = make_saved(false);
    refuse_header(&made);
    size_t const vertex_count = (size_t)get_u64(made.bytes + VERTEX_COUNT_AT);
    size_t const obstacle_count = 5, moving_count = count_moving(vertex_count, obstacle_count, 2);
    size_t const vector_bytes = 3 * moving_count * sizeof(double);
    size_t at = HEADER_BYTES;
    for (int part = 0; part < 4; part++, at += vector_bytes) {
        refuse_bad_doubles(&made, "first coordinate", at);
        refuse_bad_doubles(&made, "last coordinate", at + vector_bytes - sizeof(double));
    }
    for (size_t i = 0; i < obstacle_count; i++) refuse_u8(&made, "flag", at + i, 2);
    at += obstacle_count;

    refuse_u32(&made, "body's state", at, BODY_SLEEPS + 1);
    refuse_u32(&made, "body's group", at + offsetof(body_rest, group), 1);
    refuse_double(&made, "quiet time", at + offsetof(body_rest, quiet_time), -1.0);
    for (size_t i = offsetof(body_rest, quiet_time); i < sizeof(body_rest); i += sizeof(double))
        refuse_bad_doubles(&made, "body's rest", at + i);
    at += sizeof(body_rest);

    size_t const still_count = (size_t)get_u64(made.bytes + STILL_COUNT_AT);
    assert_true(still_count > 0);
    refuse_u32(&made, "place's wait", at + offsetof(still_place, wait), UINT32_MAX);
    refuse_u32(&made, "place's wait", at + offsetof(still_place, waiting), INT32_MAX);
    refuse_double(&made, "place's radius", at + offsetof(still_place, radius), 0.0);
    for (size_t i = 0; i < 3; i++) refuse_bad_doubles(&made, "place", at + 8 * i);
    at += still_count * sizeof(still_place);

    /* the lower plate, which is static, does not lag */
    size_t const lag_count = (size_t)get_u64(made.bytes + LAG_COUNT_AT);
    assert_true(lag_count > 0);
    refuse_bad_doubles(&made, "lag", at);
    refuse_double(&made, "lag of a static obstacle", at, 1e-6);
    refuse_bad_doubles(&made, "last lag", at + 3 * lag_count * sizeof(double) - 8);
    at += 3 * lag_count * sizeof(double);

    size_t const ignored_count = (size_t)get_u64(made.bytes + IGNORED_COUNT_AT);
    assert_true(ignored_count > 0);
    for (size_t i = 0; i < 4; i++) refuse_u32(&made, "ignored pair", at + 4 * i, 1000);
    at += ignored_count * sizeof(tulle_intersection);

    assert_true(get_u64(made.bytes + at) > 0);
    uint64_t const no_contacts = 0;
    refuse(&made, "number of contacts", at, &no_contacts, sizeof no_contacts);
    refuse_bad_doubles(&made, "contacts' time step", at + 8);
    refuse_double(&made, "contacts' time step", at + 8, 0.0);
    size_t const contact = at + CONTACT_HEADER_BYTES;
    refuse_u32(&made, "contact's kind", contact, 2);
    refuse_u32(&made, "contact's order", contact + offsetof(stored_contact, first), UINT32_MAX);
    refuse_u32(&made, "contact's feature", contact + offsetof(stored_contact, second), UINT32_MAX);
    refuse_u32(&made, "hard contact", contact + offsetof(stored_contact, is_hard), 2);
    refuse_u32(&made, "contact's state", contact + offsetof(stored_contact, state), 3);
    for (size_t i = offsetof(stored_contact, impulse); i < sizeof(stored_contact); i += 8)
        refuse_bad_doubles(&made, "contact", contact + i);
    at += (size_t)get_u64(made.bytes + CONTACT_BYTES_AT);

    assert_true(get_u64(made.bytes + PATCH_BYTES_AT) > 0);
    refuse_bad_doubles(&made, "angle of patches", at + PATCH_ANGLE_AT);
    refuse_bad_doubles(&made, "reach of patches", at + PATCH_REACH_AT);
    free_saved(&made);
}

/* The response of the paper keeps a state of each cloth vertex. */
static void crafted_particles_are_refused(void **state) {
    (void)state;
    saved_world made = make_saved(true);
    size_t const vertex_count = (size_t)get_u64(made.bytes + VERTEX_COUNT_AT);
    size_t const moving_count = count_moving(vertex_count, 3, 0);
    size_t const at = HEADER_BYTES + 6 * moving_count * sizeof(double) + 3;
    refuse_u8(&made, "first particle", at, 3);
    refuse_u8(&made, "last particle", at + 49 + 16 + 16 - 1, 255);
    free_saved(&made);
}

/* Random words in random places, with the right hash: refused, or steps go on or fail, and a whole
 * state can be loaded again. */
static void crafted_words_are_harmless(void **state) {
    (void)state;
    saved_world made = make_saved(false);
    unsigned char *const bytes = malloc(made.byte_count);
    assert_non_null(bytes);
    double const doubles[] = {0.0, -1.0, 1e-300, 1e12, -1e160, 1e300};
    uint64_t random = 11;
    int const count = getenv("TULLE_TEST_LONG") ? 20000 : 80;
    int accepted_count = 0;
    for (int i = 0; i < count; i++) {
        memcpy(bytes, made.bytes, made.byte_count);
        uint64_t const kind = random_next(&random) % 8;
        uint64_t word = random_next(&random);
        if (kind < 6) memcpy(&word, &doubles[kind], sizeof word);
        if (kind == 6) word %= 40;
        size_t const size = random_next(&random) % 2 ? 8 : 4;
        size_t const first = i % 3 == 0 ? HASHED_FROM : HEADER_BYTES;
        size_t const words = (made.byte_count - first) / 4 - 1;
        memcpy(bytes + first + 4 * (size_t)(random_next(&random) % words), &word, size);
        hash_again(bytes, made.byte_count);
        if (tulle_world_load_state(made.world, bytes, made.byte_count, NULL) == TULLE_OK) {
            accepted_count++;
            (void)tulle_world_step(made.world, STEP, NULL, NULL);
            (void)tulle_world_step(made.world, STEP, NULL, NULL);
            assert_int_equal(tulle_world_load_state(made.world, made.bytes, made.byte_count, NULL),
                             TULLE_OK);
        }
        assert_unchanged(&made);
    }
    assert_true(accepted_count > 0 && accepted_count < count);
    free(bytes);
    free_saved(&made);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_bit_may_flip),
        cmocka_unit_test(a_refused_state_starts_nothing),
        cmocka_unit_test(crafted_values_are_refused),
        cmocka_unit_test(crafted_particles_are_refused),
        cmocka_unit_test(crafted_words_are_harmless),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
