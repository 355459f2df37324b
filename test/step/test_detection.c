/* Detection as stages of the step: every method leads to the same bits, with patches kept or grown,
 * for any number of threads; no state intersects, however violent the motion; patches that are
 * about to touch themselves dissolve in time; saved states and failed steps carry patches along.
 * Without the certificate the promise does not hold, and this shows it. */
#include "support/paper_options.h"
#include "support/pins.h"
#include "support/small_world.h"
#include "tulle/paper.h"
#include "world/world_state.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static const double STEP = 1.0 / 90.0;           /* [s] */
static const double DEGREE = 0.0174532925199433; /* [rad] */

/* A kind of detection under test. */
typedef struct choice {
    const char *name;
    tulle_world_detection detection;
} choice;

static const double ANGLE = 0.78539816339744831; /* [rad] */
static const choice choices[] = {
    {"refit", {TULLE_DETECT_REFIT, TULLE_CONE_BERNSTEIN, ANGLE, 1, 0}},
    {"bvox", {TULLE_DETECT_BVOX, TULLE_CONE_BERNSTEIN, ANGLE, 1, 0}},
    {"patches", {TULLE_DETECT_PATCHES, TULLE_CONE_BERNSTEIN, ANGLE, 1, 0}},
    {"patches, grown", {TULLE_DETECT_PATCHES, TULLE_CONE_BERNSTEIN, ANGLE, 1, 1}},
    {"patches, paper's cone", {TULLE_DETECT_PATCHES, TULLE_CONE_PAPER, ANGLE, 1, 0}},
    {"patches, wide", {TULLE_DETECT_PATCHES, TULLE_CONE_BERNSTEIN, 1.4835298641951802, 1, 0}},
    {"paper", {TULLE_DETECT_PAPER, TULLE_CONE_PAPER, ANGLE, 1, 1}},
};
enum { CHOICE_COUNT = sizeof choices / sizeof choices[0], REFIT = 0, VOXELS, PATCHES };

static bool uses_patches(const choice *of) {
    return of->detection.method == TULLE_DETECT_PATCHES ||
           of->detection.method == TULLE_DETECT_PAPER;
}

/* A cloth and an obstacle below it. */
typedef struct stage_set {
    tulle_mesh cloth, obstacle;
    double *velocities; /* of the cloth; null: none */
    bool is_clamped;    /* vertices of its last row are pushed down */
} stage_set;

static void destroy_set(stage_set *set) {
    tulle_mesh_destroy(&set->cloth);
    tulle_mesh_destroy(&set->obstacle);
    free(set->velocities);
}

static tulle_mesh make_floor(double height) {
    tulle_shape_def box = tulle_shape_def_default(TULLE_SHAPE_BOX);
    box.size[0] = box.size[1] = 2.0;
    box.size[2] = 0.1;
    return small_shape(box, 0.0, 0.0, height - 0.05);
}

static stage_set make_drape(void) {
    tulle_shape_def def = tulle_shape_def_default(TULLE_SHAPE_SPHERE);
    def.radius = 0.3;
    def.resolution[0] = def.resolution[1] = 6;
    return (stage_set){.cloth = small_sheet(1.0, 15, 0.32),
                       .obstacle = small_shape(def, 0.0, 0.0, 0.0)};
}

/* A strip that stands on the floor and is pushed down, so that it folds onto itself. */
static stage_set make_fold(void) {
    tulle_shape_def def = tulle_shape_def_default(TULLE_SHAPE_RECTANGLE);
    def.size[0] = 0.6;
    def.size[1] = 0.1;
    def.resolution[0] = 31;
    def.resolution[1] = 6;
    stage_set set = {.cloth = small_shape(def, 0.0, 0.0, 0.0),
                     .obstacle = make_floor(-0.31),
                     .is_clamped = true};
    for (size_t v = 0; v < set.cloth.vertex_count; v++) { /* x becomes up; it leans and waves */
        double *const p = &set.cloth.positions[3 * v];
        double const height = p[0];
        p[0] = 0.01 * sin(9.0 * height);
        p[2] = height;
    }
    return set;
}

static double next_random(uint64_t *seed) {
    *seed = *seed * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return (double)(*seed >> 11) * 0x1p-53 * 2.0 - 1.0;
}

/* A sheet every part of which flies somewhere else, up to `speed` [m/s]. */
static stage_set make_storm(uint64_t seed, double speed) {
    stage_set set = {.cloth = small_sheet(0.5, 14, 0.1), .obstacle = make_floor(0.0)};
    set.velocities = calloc(3 * set.cloth.vertex_count, sizeof *set.velocities);
    assert_non_null(set.velocities);
    for (int wave = 0; wave < 6; wave++) {
        double direction[3], along[2];
        for (int k = 0; k < 3; k++) direction[k] = speed / 3.0 * next_random(&seed);
        for (int k = 0; k < 2; k++) along[k] = 12.0 * next_random(&seed);
        double const phase = 3.0 * next_random(&seed);
        for (size_t v = 0; v < set.cloth.vertex_count; v++) {
            const double *const p = &set.cloth.positions[3 * v];
            double const value = sin(along[0] * p[0] + along[1] * p[1] + phase);
            for (int k = 0; k < 3; k++) set.velocities[3 * v + (size_t)k] += direction[k] * value;
        }
    }
    for (size_t i = 0; i < 3 * set.cloth.vertex_count; i++)
        set.velocities[i] += 0.3 * speed * next_random(&seed);
    return set;
}

/* Its patches are kept, however small. */
static tulle_world *make_world(const stage_set *set, tulle_world_def def) {
    tulle_world *world = NULL;
    tulle_error error = {0};
    if (tulle_world_create(&def, &world, &error) != TULLE_OK) {
        assert_int_equal(error.status, TULLE_ERROR_OUT_OF_MEMORY);
        return NULL;
    }
    world->work.patch_rules.keeps_all = true;
    tulle_cloth_def cloth = tulle_cloth_def_default();
    cloth.mesh = tulle_mesh_get_view(&set->cloth);
    cloth.velocities = set->velocities;
    uint32_t top[] = {30, 61, 92, 123, 154, 185};
    tulle_keyframe const keys[] = {{0.0, {0, 0, 0}, {0, 0, 0}}, {0.6, {0, 0, -0.5}, {0, 0, 0}}};
    tulle_pin pin = make_pin(top, 6, (double)INFINITY);
    pin.motion = (tulle_motion){keys, 2, {0, 0, 0}, 0};
    cloth.pins = &pin;
    cloth.pin_count = set->is_clamped ? 1 : 0;
    tulle_obstacle_def obstacle = tulle_obstacle_def_default();
    obstacle.mesh = tulle_mesh_get_view(&set->obstacle);
    if (tulle_world_add_cloth(world, &cloth, NULL, &error) != TULLE_OK ||
        tulle_world_add_obstacle(world, &obstacle, NULL, &error) != TULLE_OK) {
        assert_int_equal(error.status, TULLE_ERROR_OUT_OF_MEMORY);
        tulle_world_destroy(world);
        return NULL;
    }
    return world;
}

static tulle_world_def make_def(const choice *of, int threads) {
    tulle_world_def def = tulle_world_def_default();
    change_paper(&def)->detection = of->detection;
    def.threads = threads;
    return def;
}

/* What a run of some steps came to. */
typedef struct outcome {
    uint64_t hash, contacts, searches, dissolved, box_pairs;
    uint64_t straight, both; /* steps whose last search followed straight paths; patches too */
    double patch_share;      /* mean share of the cloth's triangles that lie in patches */
} outcome;

static outcome run(const stage_set *set, const choice *of, int threads, int count, bool is_judged) {
    tulle_world *const world = make_world(set, make_def(of, threads));
    outcome result = {0};
    for (int i = 0; i < count; i++) {
        tulle_step_report report;
        tulle_error error = {0};
        if (tulle_world_step(world, STEP, &report, &error) != TULLE_OK)
            fail_msg("%s, step %d: %s", of->name, i, error.message);
        result.contacts += report.contacts;
        result.searches += report.pair_searches;
        result.dissolved += report.patches_dissolved;
        result.box_pairs += report.box_pairs;
        result.straight += broad_phase_is_straight(world->work.broad);
        result.both += broad_phase_is_straight(world->work.broad) && report.patches > 0;
        result.patch_share +=
            (double)report.patch_triangles / (double)set->cloth.triangle_count / count;
        assert_true(report.patches_certified ==
                    (of->detection.has_certificate ? report.patches : 0));
        if (is_judged && small_judge(world, &set->cloth, 1, &set->obstacle, 1) != 0)
            fail_msg("%s: intersections after step %d", of->name, i);
    }
    result.hash = tulle_world_get_state_hash(world);
    tulle_world_destroy(world);
    return result;
}

static void print_outcome(const char *scene, const choice *of, const outcome *result, int count) {
    print_message("%-6s %-22s %5.2f searches a step, %8.0f pairs, %4.1f%% in patches, %llu "
                  "dissolved\n",
                  scene, of->name, (double)result->searches / count,
                  (double)result->box_pairs / count, 100.0 * result->patch_share,
                  (unsigned long long)result->dissolved);
}

/* Returns how many pairs kept patches save. Voxel trees find all whose boxes meet; refitted ones
 * follow straight paths too, which takes more searches and finds less in each. */
static uint64_t compare_choices(const char *scene, const stage_set *set, int count, outcome *sum) {
    outcome const expected = run(set, &choices[REFIT], 1, count, true);
    sum->straight += expected.straight;
    sum->contacts += expected.contacts;
    print_outcome(scene, &choices[REFIT], &expected, count);
    uint64_t saved = 0;
    outcome all = {0};
    for (int k = 1; k < CHOICE_COUNT; k++) {
        outcome const found = run(set, &choices[k], k % 3 + 1, count, false);
        print_outcome(scene, &choices[k], &found, count);
        if (uses_patches(&choices[k])) assert_true(found.patch_share > 0.1);
        if (found.hash != expected.hash) fail_msg("%s differs from refit", choices[k].name);
        if (k == VOXELS) all = found;
        if (k == PATCHES) sum->both += found.both;
        if (found.searches == all.searches) assert_true(found.box_pairs <= all.box_pairs);
        if (k == PATCHES && found.searches == all.searches) saved = all.box_pairs - found.box_pairs;
    }
    return saved;
}

static void every_method_drapes_alike(void **state) {
    (void)state;
    stage_set set = make_drape();
    outcome sum = {0};
    assert_true(compare_choices("drape", &set, 30, &sum) > 0);
    assert_true(sum.contacts > 0);
    destroy_set(&set);
}

static void every_method_folds_alike(void **state) {
    (void)state;
    stage_set set = make_fold();
    outcome sum = {0};
    assert_true(compare_choices("fold", &set, 24, &sum) > 0);
    assert_true(sum.contacts > 0);
    destroy_set(&set);
}

static void every_method_weathers_storms_alike(void **state) {
    (void)state;
    /* [m/s] the slower, the larger the patches */
    static const double speeds[] = {2.0, 6.0, 20.0};
    int const count = getenv("TULLE_TEST_LONG") ? 60 : 3;
    uint64_t saved = 0;
    outcome sum = {0};
    for (int k = 0; k < count; k++) {
        stage_set set = make_storm((uint64_t)k + 1, speeds[k % 3]);
        saved += compare_choices("storm", &set, 12, &sum);
        destroy_set(&set);
    }
    assert_true(saved > 0 && sum.straight > 0 && sum.both > 0 && sum.contacts > 0);
}

/* Patches are there while the strip is smooth, and go where it folds onto itself. */
static void folding_dissolves_patches(void **state) {
    (void)state;
    stage_set set = make_fold();
    outcome const start = run(&set, &choices[PATCHES], 2, 3, true);
    outcome const whole = run(&set, &choices[PATCHES], 2, 36, true);
    assert_true(start.patch_share > 0.5);
    assert_true(whole.dissolved > 0);
    assert_true(whole.contacts > 0);
    destroy_set(&set);
}

static void assert_same_report(const tulle_step_report *a, const tulle_step_report *b) {
    tulle_step_report copies[2] = {*a, *b};
    for (int k = 0; k < 2; k++) {
        memset(copies[k].stage_seconds, 0, sizeof copies[k].stage_seconds);
        copies[k].total_seconds = 0.0;
    }
    assert_int_equal(copies[0].box_pairs, copies[1].box_pairs);
    assert_int_equal(copies[0].patches, copies[1].patches);
    assert_int_equal(copies[0].patch_triangles, copies[1].patch_triangles);
    assert_int_equal(copies[0].patches_dissolved, copies[1].patches_dissolved);
    assert_int_equal(copies[0].pair_searches, copies[1].pair_searches);
    assert_int_equal(copies[0].tested_pairs, copies[1].tested_pairs);
    assert_int_equal(copies[0].contacts, copies[1].contacts);
    assert_true(copies[0].smallest_gap == copies[1].smallest_gap);
}

static void assert_same_world(const tulle_world *a, const tulle_world *b) {
    assert_true(tulle_world_get_state_hash(a) == tulle_world_get_state_hash(b));
}

/* A world that goes on from a saved state reports the same patches and pairs, step for step. */
static void saved_state_carries_patches(void **state) {
    (void)state;
    stage_set set = make_drape();
    tulle_world *worlds[2];
    for (int k = 0; k < 2; k++) worlds[k] = make_world(&set, make_def(&choices[PATCHES], k + 1));
    for (int i = 0; i < 25; i++)
        assert_int_equal(tulle_world_step(worlds[0], STEP, NULL, NULL), TULLE_OK);
    for (int i = 0; i < 3; i++) /* its own patches are forgotten */
        assert_int_equal(tulle_world_step(worlds[1], STEP, NULL, NULL), TULLE_OK);
    void *bytes = NULL, *again = NULL;
    size_t size = 0, size_again = 0;
    assert_int_equal(tulle_world_save_state(worlds[0], &bytes, &size, NULL), TULLE_OK);
    assert_int_equal(tulle_world_load_state(worlds[1], bytes, size, NULL), TULLE_OK);
    assert_int_equal(tulle_world_save_state(worlds[1], &again, &size_again, NULL), TULLE_OK);
    assert_int_equal(size, size_again);
    assert_memory_equal(bytes, again, size);
    for (int i = 0; i < 15; i++) {
        tulle_step_report reports[2];
        for (int k = 0; k < 2; k++)
            assert_int_equal(tulle_world_step(worlds[k], STEP, &reports[k], NULL), TULLE_OK);
        assert_true(reports[0].patch_triangles > 0);
        assert_same_report(&reports[0], &reports[1]);
        assert_same_world(worlds[0], worlds[1]);
    }

    /* a world without patches goes on from it as well, and the other way round */
    tulle_world *const plain = make_world(&set, make_def(&choices[REFIT], 1));
    assert_int_equal(tulle_world_load_state(plain, bytes, size, NULL), TULLE_OK);
    for (int i = 0; i < 15; i++)
        assert_int_equal(tulle_world_step(plain, STEP, NULL, NULL), TULLE_OK);
    assert_same_world(plain, worlds[0]);
    tulle_world_free_state(worlds[1], again, size_again);
    assert_int_equal(tulle_world_save_state(plain, &again, &size_again, NULL), TULLE_OK);
    assert_int_equal(tulle_world_load_state(worlds[1], again, size_again, NULL), TULLE_OK);
    for (int i = 0; i < 5; i++)
        for (int k = 0; k < 2; k++)
            assert_int_equal(tulle_world_step(worlds[k], STEP, NULL, NULL), TULLE_OK);
    assert_same_world(worlds[0], worlds[1]);
    tulle_world_free_state(plain, again, size_again);
    tulle_world_free_state(worlds[0], bytes, size);
    tulle_world_destroy(plain);
    for (int k = 0; k < 2; k++) tulle_world_destroy(worlds[k]);
    destroy_set(&set);
}

/* An allocator whose allocation number `fail_at` fails, once. */
typedef struct failing_heap {
    long count, fail_at;
} failing_heap;

static void *failing_allocate(void *context, size_t byte_count) {
    failing_heap *const heap = context;
    return ++heap->count == heap->fail_at ? NULL : malloc(byte_count);
}

static void failing_release(void *context, void *pointer, size_t byte_count) {
    (void)context;
    (void)byte_count;
    free(pointer);
}

/* Steps of a world in which allocation number fail_at fails; a step that failed is made again.
 * Reports go to `reports`, which stay as they are when no world can be made. Returns whether an
 * allocation failed. */
static bool run_failing(const stage_set *set, long fail_at, tulle_step_report *reports, int count) {
    failing_heap heap = {0, fail_at};
    tulle_world_def def = make_def(&choices[PATCHES], 2);
    def.allocator = (tulle_allocator){failing_allocate, failing_release, &heap, 0};
    tulle_world *const world = make_world(set, def);
    bool has_failed = !world;
    if (world && tulle_world_start(world, NULL) != TULLE_OK) has_failed = true;
    for (int i = 0; i < count && world; i++) {
        uint64_t const hash = tulle_world_get_state_hash(world);
        tulle_error error = {0};
        if (tulle_world_step(world, STEP, &reports[i], &error) == TULLE_OK) continue;
        assert_int_equal(error.status, TULLE_ERROR_OUT_OF_MEMORY);
        assert_true(tulle_world_get_state_hash(world) == hash);
        has_failed = true;
        assert_int_equal(tulle_world_step(world, STEP, &reports[i], &error), TULLE_OK);
    }
    if (world) tulle_world_destroy(world);
    return has_failed;
}

/* A step that failed leaves the patches as they were too: made again, it reports the same. */
static void failed_step_leaves_the_patches(void **state) {
    (void)state;
    enum { COUNT = 3 };
    stage_set set = make_storm(3, 8.0);
    tulle_step_report expected[COUNT], found[COUNT];
    assert_false(run_failing(&set, -1, expected, COUNT));
    for (int i = 0; i < COUNT; i++) assert_true(expected[i].patch_triangles > 0);
    long k = 1;
    memcpy(found, expected, sizeof found);
    for (; run_failing(&set, k, found, COUNT); k++) {
        assert_true(k < 4000);
        for (int i = 0; i < COUNT; i++) assert_same_report(&expected[i], &found[i]);
    }
    print_message("%ld allocations failed\n", k - 1);
    destroy_set(&set);
}

/* The patches in use are those that the report counts; a method without patches has none. */
static void patches_in_use_can_be_asked_for(void **state) {
    (void)state;
    stage_set set = make_drape();
    uint32_t *const labels = malloc(set.cloth.triangle_count * sizeof *labels);
    for (int k = 0; k < CHOICE_COUNT; k++) {
        tulle_world *const world = make_world(&set, make_def(&choices[k], 1));
        tulle_patch_options const options = {.is_in_use = 1};
        tulle_step_report report = {0};
        size_t count = 1, in_patches = 0;
        assert_int_equal(tulle_world_start(world, NULL), TULLE_OK);
        for (int i = 0; i < 8; i++) {
            assert_int_equal(tulle_cloth_get_patches(world, (tulle_cloth_id){0, 1}, &options,
                                                     labels, &count, NULL),
                             TULLE_OK);
            if (i == 0) assert_int_equal(count, 0);
            assert_int_equal(count, report.patches);
            in_patches = 0;
            uint32_t highest = 0;
            for (size_t t = 0; t < set.cloth.triangle_count; t++) {
                in_patches += labels[t] > 0;
                assert_true(labels[t] <= highest + 1);
                if (labels[t] > highest) highest = labels[t];
            }
            assert_int_equal(highest, count);
            assert_int_equal(in_patches, report.patch_triangles);
            assert_int_equal(tulle_world_step(world, STEP, &report, NULL), TULLE_OK);
        }
        assert_int_equal(in_patches > 0, uses_patches(&choices[k]));
        tulle_world_destroy(world);
    }
    free(labels);
    destroy_set(&set);
}

/* Leaves out the triangles whose middle lies in the slot, and vertices without triangles. */
static void cut_slot(tulle_mesh *mesh) {
    uint32_t *const names = malloc(mesh->vertex_count * sizeof *names);
    size_t kept = 0, named = 0;
    for (size_t v = 0; v < mesh->vertex_count; v++) names[v] = UINT32_MAX;
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        uint32_t *const corners = &mesh->triangles[3 * t];
        double x = 0.0, y = 0.0;
        for (int k = 0; k < 3; k++) {
            x += mesh->positions[3 * (size_t)corners[k]] / 3.0;
            y += mesh->positions[3 * (size_t)corners[k] + 1] / 3.0;
        }
        if (fabs(x) < 0.05 && y > -0.2) continue;
        for (int k = 0; k < 3; k++) names[corners[k]] = 0;
        memmove(&mesh->triangles[3 * kept++], corners, 3 * sizeof *corners);
    }
    for (size_t v = 0; v < mesh->vertex_count; v++) {
        if (names[v] == UINT32_MAX) continue;
        names[v] = (uint32_t)named;
        memmove(&mesh->positions[3 * named++], &mesh->positions[3 * v], 3 * sizeof(double));
    }
    for (size_t i = 0; i < 3 * kept; i++) mesh->triangles[i] = names[mesh->triangles[i]];
    mesh->triangle_count = kept;
    mesh->vertex_count = named;
    free(names);
}

/* A sheet with a slot, bent a little to a valley along it, whose two arms fly towards each other:
 * one patch by its cone. */
static stage_set make_slotted(void) {
    tulle_shape_def def = tulle_shape_def_default(TULLE_SHAPE_RECTANGLE);
    def.size[0] = 0.4;
    def.size[1] = 0.6;
    def.resolution[0] = 9;
    def.resolution[1] = 13;
    stage_set set = {.cloth = small_shape(def, 0.0, 0.0, 0.0), .obstacle = make_floor(-1.0)};
    cut_slot(&set.cloth);
    set.velocities = calloc(3 * set.cloth.vertex_count, sizeof *set.velocities);
    assert_non_null(set.velocities);
    for (size_t v = 0; v < set.cloth.vertex_count; v++) {
        double *const p = &set.cloth.positions[3 * v];
        p[2] = 0.2 * fabs(p[0]);
        double const side = p[0] > 0.0 ? -1.0 : 1.0;
        if (p[1] > -0.2) set.velocities[3 * v] = side * 15.0 * (p[1] + 0.2);
    }
    return set;
}

/* Intersections of the slotted sheet over some steps. */
static size_t count_slot_crossings(tulle_world_detection detection) {
    stage_set set = make_slotted();
    choice const of = {"slot", detection};
    tulle_world *const world = make_world(&set, make_def(&of, 1));
    size_t count = 0;
    for (int i = 0; i < 6; i++) {
        assert_int_equal(tulle_world_step(world, STEP, NULL, NULL), TULLE_OK);
        count += small_judge(world, &set.cloth, 1, &set.obstacle, 1);
    }
    tulle_world_destroy(world);
    destroy_set(&set);
    return count;
}

static void certificate_makes_the_difference(void **state) {
    (void)state;
    tulle_detect_method const methods[] = {TULLE_DETECT_PATCHES, TULLE_DETECT_PAPER};
    for (int k = 0; k < 2; k++) {
        tulle_world_detection detection = choices[PATCHES].detection;
        detection.method = methods[k];
        assert_int_equal(count_slot_crossings(detection), 0);
        detection.has_certificate = 0;
        assert_true(count_slot_crossings(detection) > 0);
    }
}

static void bad_definitions_are_refused(void **state) {
    (void)state;
    tulle_world_detection bad[5];
    for (int k = 0; k < 5; k++) bad[k] = choices[PATCHES].detection;
    bad[0].method = (tulle_detect_method)4;
    bad[1].cone = (tulle_detect_cone)2;
    bad[2].max_angle = 0.0;
    bad[3].max_angle = 90.0 * DEGREE;
    bad[4].max_angle = (double)NAN;
    for (int k = 0; k < 5; k++) {
        tulle_world_def def = tulle_world_def_default();
        change_paper(&def)->detection = bad[k];
        tulle_world *world = NULL;
        tulle_error error = {0};
        assert_int_equal(tulle_world_create(&def, &world, &error), TULLE_ERROR_INVALID_ARGUMENT);
        assert_non_null(strstr(error.message, k == 0 ? "method" : k == 1 ? "cone" : "angle"));
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_method_drapes_alike),
        cmocka_unit_test(every_method_folds_alike),
        cmocka_unit_test(every_method_weathers_storms_alike),
        cmocka_unit_test(folding_dissolves_patches),
        cmocka_unit_test(saved_state_carries_patches),
        cmocka_unit_test(failed_step_leaves_the_patches),
        cmocka_unit_test(patches_in_use_can_be_asked_for),
        cmocka_unit_test(certificate_makes_the_difference),
        cmocka_unit_test(bad_definitions_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
