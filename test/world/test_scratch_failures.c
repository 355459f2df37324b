/* Calls for scratch memory fail, one after the other. A step says so and leaves the world as it
 * was, or does without and has the same bits; so does a start that is untangled.
 *
 * The arena of base/arena.h hands out room that steps before have left, so that a heap which fails
 * reaches few of its calls. In this program another arena stands in its place. It takes every
 * allocation from the heap, and call number `fail_at` fails. Bytes after each allocation tell at
 * its release if anything was written there. */
#include "base/arena.h"
#include "support/paper_options.h"
#include "support/pins.h"
#include "support/small_world.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static const double STEP = 1.0 / 90.0; /* [s] */
static long call_count, fail_at;       /* fail_at: 0, none fails */
enum { GUARD_BYTES = 64, GUARD = 0x5a };

/* ---- the arena ---- */

struct arena_block {
    arena_block *next;
    size_t byte_count;
    void *payload;
};

arena arena_make(memory *heap) { return (arena){.heap = heap}; }

void *arena_allocate(arena *scratch, size_t count, size_t size) {
    if (++call_count == fail_at) return NULL;
    arena_block *const block = memory_allocate(scratch->heap, sizeof *block);
    if (!block) return NULL;
    size_t const byte_count = count * size + GUARD_BYTES;
    *block =
        (arena_block){scratch->current, byte_count, memory_allocate(scratch->heap, byte_count)};
    if (!block->payload) {
        memory_release(scratch->heap, block, sizeof *block);
        return NULL;
    }
    memset(block->payload, GUARD, byte_count);
    scratch->current = block;
    scratch->used += byte_count;
    return block->payload;
}

void *arena_allocate_zeroed(arena *scratch, size_t count, size_t size) {
    void *const payload = arena_allocate(scratch, count, size);
    if (payload) memset(payload, 0, count * size);
    return payload;
}

void arena_reserve(arena *scratch, size_t byte_count) { (void)scratch, (void)byte_count; }

size_t arena_get_room(const arena *scratch) {
    (void)scratch;
    return SIZE_MAX;
}

arena_mark arena_get_mark(const arena *scratch) {
    return (arena_mark){.block = scratch->current, .all_used = scratch->used};
}

void arena_release(arena *scratch, arena_mark mark) {
    while (scratch->current != mark.block) {
        arena_block *const block = scratch->current;
        const unsigned char *const end = (const unsigned char *)block->payload + block->byte_count;
        for (int i = 1; i <= GUARD_BYTES; i++)
            if (end[-i] != GUARD)
                fail_msg("written past the end of %zu bytes", block->byte_count - GUARD_BYTES);
        scratch->current = block->next;
        memory_release(scratch->heap, block->payload, block->byte_count);
        memory_release(scratch->heap, block, sizeof *block);
    }
    scratch->used = mark.all_used;
}

void arena_destroy(arena *scratch) { arena_release(scratch, (arena_mark){0}); }

/* ---- worlds ---- */

static tulle_world_def make_def(void) {
    tulle_world_def def = tulle_world_def_default();
    def.threads = 1;
    return def;
}

static void add_box(tulle_world *world, const double size[3], const double at[3],
                    const tulle_body *body, const double way[3]) {
    tulle_shape_def shape = tulle_shape_def_default(TULLE_SHAPE_BOX);
    memcpy(shape.size, size, sizeof shape.size);
    tulle_mesh box = small_shape(shape, at[0], at[1], at[2]);
    tulle_keyframe const keys[2] = {{0.0, {0, 0, 0}, {0, 0, 0}},
                                    {0.2, {way[0], way[1], way[2]}, {0, 0, 0}}};
    tulle_obstacle_def obstacle = tulle_obstacle_def_default();
    obstacle.mesh = tulle_mesh_get_view(&box);
    obstacle.friction = 0.5;
    if (body) obstacle.body = *body;
    if (way[0] != 0.0 || way[1] != 0.0 || way[2] != 0.0)
        obstacle.motion = (tulle_motion){.keys = keys, .key_count = 2};
    assert_int_equal(tulle_world_add_obstacle(world, &obstacle, NULL, NULL), TULLE_OK);
    tulle_mesh_destroy(&box);
}

/* A sheet with its middle at (x, 0, z). */
typedef struct sheet_def {
    double side, x, z;
    double speed; /* [m/s] downwards */
    unsigned n;
    bool is_upright; /* and pinned at two corners */
} sheet_def;

static void add_sheet(tulle_world *world, sheet_def def) {
    tulle_mesh sheet = small_sheet(def.side, def.n, 0.0);
    for (size_t v = 0; v < sheet.vertex_count; v++) {
        double *const p = sheet.positions + 3 * v;
        if (def.is_upright) p[2] = p[1], p[1] = 0.0;
        p[0] += def.x;
        p[2] += def.z;
    }
    uint32_t const corners[2] = {0, def.n - 1};
    tulle_pin const pin = make_pin(corners, 2, (double)INFINITY);
    tulle_cloth_def cloth = tulle_cloth_def_default();
    cloth.mesh = tulle_mesh_get_view(&sheet);
    cloth.velocity[2] = -def.speed;
    cloth.material.bend_hysteresis_warp = 1e-4; /* of woven cloth */
    cloth.material.shear_hysteresis = 1.0;
    if (def.is_upright) cloth.pins = &pin, cloth.pin_count = 1;
    assert_int_equal(tulle_world_add_cloth(world, &cloth, NULL, NULL), TULLE_OK);
    tulle_mesh_destroy(&sheet);
}

static tulle_world *create(tulle_world_def def) {
    tulle_world *world = NULL;
    def.wind.velocity[0] = 1.0;
    assert_int_equal(tulle_world_create(&def, &world, NULL), TULLE_OK);
    return world;
}

/* Two sheets fall over each other and over the edge of a box that moves. */
static tulle_world *make_sheets(tulle_world_def def, unsigned n) {
    tulle_world *const world = create(def);
    /* The paper's response throws fast sheets through the room, or tears them. */
    double const slow = get_paper(&def).response == TULLE_RESPONSE_PAPER ? 0.2 : 1.0;
    add_sheet(world, (sheet_def){.side = 0.2, .n = n, .z = 0.012, .speed = 1.5 * slow});
    add_sheet(world, (sheet_def){.side = 0.16, .n = 5, .x = 0.02, .z = 0.022, .speed = 2.0 * slow});
    add_box(world, (double[3]){0.1, 0.1, 0.05}, (double[3]){0.01, 0.005, -0.026}, NULL,
            (double[3]){0.02, 0.0, 0.02});
    return world;
}

/* A box falls on a sheet and on another box, which sleeps on the ground. */
static tulle_world *make_bodies(void) {
    tulle_world *const world = create(make_def());
    tulle_body const body = {
        .is_dynamic = 1, .density = 300.0, .sleep_speed = 0.5, .sleep_time = 0.02};
    double const still[3] = {0.0, 0.0, 0.0}, size[3] = {0.1, 0.1, 0.1};
    add_sheet(world, (sheet_def){.side = 0.2, .n = 5, .x = 0.12, .z = 0.004});
    add_box(world, (double[3]){1.0, 1.0, 0.1}, (double[3]){0.0, 0.0, -0.05}, NULL, still);
    add_box(world, size, (double[3]){-0.05, 0.01, 0.054}, &body, still);
    add_box(world, size, (double[3]){0.04, 0.0, 0.175}, &body, still);
    return world;
}

/* A box that is driven falls on a sheet that lies on the ground; the host watches. */
static tulle_world *make_body_on_cloth(unsigned n) {
    tulle_world *const world = create(make_def());
    tulle_body const body = {.is_dynamic = 1, .density = 300.0, .velocity = {0.0, 0.0, -1.0}};
    double const still[3] = {0.0, 0.0, 0.0};
    add_sheet(world, (sheet_def){.side = 0.2, .n = n, .z = 0.004});
    add_box(world, (double[3]){1.0, 1.0, 0.1}, (double[3]){0.0, 0.0, -0.05}, NULL, still);
    add_box(world, (double[3]){0.1, 0.1, 0.1}, (double[3]){0.01, 0.02, 0.062}, &body, still);
    tulle_body_drive drive = tulle_body_drive_default();
    drive.damping[0] = 1e-3;
    drive.force_limit[0] = 1e-6;
    tulle_obstacle_id const box = {1, 1};
    assert_int_equal(tulle_world_start(world, NULL), TULLE_OK);
    assert_int_equal(tulle_obstacle_set_drive(world, box, &drive, NULL), TULLE_OK);
    assert_int_equal(tulle_obstacle_set_locks(world, box, 0, TULLE_LOCK_Y, NULL), TULLE_OK);
    tulle_event_watch const watch = tulle_event_watch_default();
    assert_int_equal(tulle_world_watch_events(world, &watch, NULL), TULLE_OK);
    return world;
}

/* Fingers close on a hanging sheet to nothing. */
static tulle_world *make_pinch(tulle_on_pinch choice) {
    tulle_world_def def = make_def();
    def.on_pinch = choice;
    def.contact_distance = 3e-3;
    tulle_world *const world = create(def);
    add_sheet(world, (sheet_def){.side = 0.1, .n = 6, .is_upright = true});
    for (int k = 0; k < 2; k++) {
        double const side = k == 0 ? -1.0 : 1.0;
        add_box(world, (double[3]){0.03, 0.03, 0.03}, (double[3]){0.0, side * 0.02, 0.0}, NULL,
                (double[3]){0.0, -side * 0.0051, 0.0});
    }
    return world;
}

/* ---- failures ---- */

/* Where all calls take long, few are tried: all of them with TULLE_TEST_LONG=1. */
static long choose_stride(long stride) { return getenv("TULLE_TEST_LONG") ? 1 : stride; }

/* After `step_count` steps the calls of the next one fail in turn, every `stride`th; takes the
 * world. Returns how many steps did without what they had asked for. */
static int fail_calls_of_a_step(tulle_world *world, int step_count, long stride) {
    tulle_error error = {0};
    tulle_step_report report = {0};
    fail_at = 0;
    for (int i = 0; i < step_count; i++) {
        if (tulle_world_step(world, STEP, &report, &error) != TULLE_OK)
            fail_msg("step %d: %s", i, error.message);
    }
    void *bytes = NULL;
    size_t byte_count = 0;
    assert_int_equal(tulle_world_save_state(world, &bytes, &byte_count, NULL), TULLE_OK);
    assert_int_equal(tulle_world_load_state(world, bytes, byte_count, NULL), TULLE_OK);
    uint64_t const before = tulle_world_get_state_hash(world);
    call_count = 0;
    assert_int_equal(tulle_world_step(world, STEP, &report, NULL), TULLE_OK);
    uint64_t const after = tulle_world_get_state_hash(world);
    long const calls = call_count;
    assert_true(calls > 50); /* else another arena is in use */
    int done_without = 0;
    assert_int_equal(tulle_world_load_state(world, bytes, byte_count, NULL), TULLE_OK);
    for (long k = 1; k <= calls; k += stride) {
        call_count = 0;
        fail_at = k;
        error = (tulle_error){0};
        tulle_status const status = tulle_world_step(world, STEP, NULL, &error);
        fail_at = 0;
        if (status == TULLE_OK) {
            done_without++;
            if (tulle_world_get_state_hash(world) != after) fail_msg("call %ld: other bits", k);
            assert_int_equal(tulle_world_load_state(world, bytes, byte_count, NULL), TULLE_OK);
            continue;
        }
        if (status != TULLE_ERROR_OUT_OF_MEMORY || error.status != status ||
            !strstr(error.message, "no memory") || tulle_world_get_state_hash(world) != before)
            fail_msg("call %ld: %s", k, error.message);
    }
    assert_int_equal(tulle_world_step(world, STEP, NULL, NULL), TULLE_OK);
    assert_true(tulle_world_get_state_hash(world) == after);
    print_message("%ld calls, %llu contacts, %d done without\n", calls,
                  (unsigned long long)report.contacts, done_without);
    tulle_world_free_state(world, bytes, byte_count);
    tulle_world_destroy(world);
    return done_without;
}

static void steps_with_contacts(void **state) {
    (void)state;
    assert_int_equal(fail_calls_of_a_step(make_sheets(make_def(), 6), 5, 1), 0);
    tulle_world_def def = make_def();
    def.membrane = TULLE_MEMBRANE_SPRINGS;
    assert_int_equal(fail_calls_of_a_step(make_sheets(def, 6), 5, 1), 0);
    change_paper(&def)->response = TULLE_RESPONSE_PAPER;
    assert_int_equal(fail_calls_of_a_step(make_sheets(def, 6), 1, 1), 0);
    def = make_def();
    change_paper(&def)->detection.method = TULLE_DETECT_PAPER;
    assert_int_equal(fail_calls_of_a_step(make_sheets(def, 6), 5, 1), 0);
}

/* Fine enough for solves in single precision with aggregates. */
static void a_step_of_finer_sheets(void **state) {
    (void)state;
    assert_int_equal(fail_calls_of_a_step(make_sheets(make_def(), 32), 3, choose_stride(7)), 0);
}

static void steps_with_bodies(void **state) {
    (void)state;
    for (int step_count = 2; step_count < 9; step_count += 3)
        assert_int_equal(fail_calls_of_a_step(make_bodies(), step_count, 1), 0);
}

/* Bodies and cloth are solved together. */
static void steps_of_a_body_on_cloth(void **state) {
    (void)state;
    assert_int_equal(fail_calls_of_a_step(make_body_on_cloth(5), 1, 1), 0);
    assert_int_equal(fail_calls_of_a_step(make_body_on_cloth(5), 2, choose_stride(40)), 0);
    /* fine cloth, which bodies follow */
    assert_int_equal(fail_calls_of_a_step(make_body_on_cloth(33), 2, choose_stride(40)), 0);
}

static void steps_with_a_pinch(void **state) {
    (void)state;
    assert_int_equal(fail_calls_of_a_step(make_pinch(TULLE_ON_PINCH_SLOW), 17, choose_stride(4)),
                     0);
}

/* A start that cannot be judged or untangled can be tried again. */
static void a_start_that_is_untangled(void **state) {
    (void)state;
    tulle_world_def def = make_def();
    def.start_intersections = TULLE_START_UNTANGLE;
    uint64_t hash = 0;
    long calls = 0;
    for (long k = 0; k <= calls; k += choose_stride(4)) {
        tulle_world *const world = create(def);
        add_sheet(world, (sheet_def){.side = 0.2, .n = 6, .z = 0.004});
        add_sheet(world,
                  (sheet_def){.side = 0.2, .n = 6, .x = 0.043, .z = 0.013, .is_upright = true});
        add_box(world, (double[3]){0.1, 0.1, 0.1}, (double[3]){0.013, 0.085, 0.0}, NULL,
                (double[3]){0.0, 0.0, 0.0});
        call_count = 0;
        fail_at = k;
        tulle_error error = {0};
        tulle_status status = tulle_world_start(world, &error);
        fail_at = 0;
        if (k == 0) {
            assert_int_equal(status, TULLE_OK);
            assert_true(tulle_world_get_untangle_report(world).rounds > 1);
            calls = call_count;
            hash = tulle_world_get_state_hash(world);
        } else if (status != TULLE_OK) {
            if (status != TULLE_ERROR_OUT_OF_MEMORY || !strstr(error.message, "no memory"))
                fail_msg("call %ld: %s", k, error.message);
            status = tulle_world_start(world, &error);
        }
        assert_int_equal(status, TULLE_OK);
        assert_true(tulle_world_get_state_hash(world) == hash);
        tulle_world_destroy(world);
    }
    print_message("%ld calls\n", calls);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(steps_with_contacts),      cmocka_unit_test(a_step_of_finer_sheets),
        cmocka_unit_test(steps_with_bodies),        cmocka_unit_test(steps_with_a_pinch),
        cmocka_unit_test(steps_of_a_body_on_cloth), cmocka_unit_test(a_start_that_is_untangled),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
