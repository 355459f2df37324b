/* Patches that fail: large ones without a certificate are noticed when a triangle turns, and to
 * mend patches without memory is an error that leaves none. */
#include "detect/patches/kept_patches.h"
#include "support/patch_scene.h"
#include "support/test_support.h"
#include "support/wide_normals.h"

#include <stdlib.h>
#include <string.h>

/* A heap of which one allocation fails. */
typedef struct flawed_heap {
    int left;        /* allocations before it */
    bool has_failed; /* it was asked for */
} flawed_heap;

static void *allocate(void *context, size_t byte_count) {
    flawed_heap *const heap = context;
    if (heap->left-- != 0) return malloc(byte_count);
    heap->has_failed = true;
    return NULL;
}

static void release(void *context, void *pointer, size_t byte_count) {
    (void)context, (void)byte_count;
    free(pointer);
}

static kept_patches *create(memory *heap, const patch_scene *scene) {
    kept_patches *patches = NULL;
    assert_int_equal(kept_patches_create(heap, &scene->set, NULL, &patches), TULLE_OK);
    return patches;
}

static patch_step get_step(const patch_scene *scene) {
    return (patch_step){&scene->set, scene->x0, scene->x1, 2};
}

/* Every triangle counts, also in a patch so large that tasks share it. */
static void a_turn_in_a_large_patch_is_noticed(void **state) {
    (void)state;
    uint64_t seed = 25;
    patch_scene scene;
    patch_scene_make(&scene, PATCH_SHEET, 80, &seed);
    patch_rules const rules = {CONE_BERNSTEIN, 60.0 * DEGREE, false, false, 0.0, false};
    kept_patches *const patches = create(&scene.heap, &scene);
    patch_counts counts;
    patch_step const step = get_step(&scene);
    assert_int_equal(update_patches(patches, &step, &rules, &counts), TULLE_OK);
    assert_true(counts.patch_count == 1 && counts.triangle_count == scene.triangle_count);
    for (size_t vertex = 0; vertex < scene.vertex_count; vertex += 211) {
        double *const x = scene.x1 + 3 * vertex, old = *x;
        if (old > 0.9) continue;                         /* it would only stretch the sheet */
        *x = vertex % 2 == 0 ? old + 0.05 : (double)NAN; /* four edge lengths */
        assert_false(patches_hold(patches, &step, &rules));
        *x = old;
        assert_true(patches_hold(patches, &step, &rules));
    }
    kept_patches_destroy(patches);
    patch_scene_destroy(&scene);
}

/* Without a certificate nothing tells what else of a patch holds: all of it goes. */
static void a_turn_without_a_certificate_dissolves_the_patch(void **state) {
    (void)state;
    uint64_t seed = 26;
    patch_scene scene;
    patch_scene_make(&scene, PATCH_SHEET, 20, &seed);
    patch_rules const rules = {CONE_BERNSTEIN, 60.0 * DEGREE, false, false, 0.0, true};
    kept_patches *const patches = create(&scene.heap, &scene);
    patch_counts counts;
    patch_step const step = get_step(&scene);
    assert_int_equal(update_patches(patches, &step, &rules, &counts), TULLE_OK);
    assert_true(counts.patch_count == 1 && counts.triangle_count == scene.triangle_count);
    scene.x1[3 * (scene.vertex_count / 2)] += 0.2; /* four edge lengths */
    assert_int_equal(update_patches(patches, &step, &rules, &counts), TULLE_OK);
    assert_true(counts.dissolved_count == 1 && counts.split_count == 0);
    kept_patches_destroy(patches);
    patch_scene_destroy(&scene);
}

/* Patches of a ramp that are mended after some vertices have jumped. Allocation `flaw` of that
 * fails; negative: none does. */
static tulle_status mend(patch_scene *scene, int flaw, patch_counts *counts, bool *has_failed) {
    flawed_heap flawed = {.left = -1};
    memory heap = {.allocator = {allocate, release, &flawed, 0}};
    patch_rules const rules = {CONE_BERNSTEIN, 60.0 * DEGREE, true, false, 0.0, true};
    kept_patches *const patches = create(&heap, scene);
    patch_step const step = get_step(scene);
    memcpy(scene->x1, scene->x0, 3 * scene->vertex_count * sizeof(double));
    assert_int_equal(update_patches(patches, &step, &rules, counts), TULLE_OK);
    for (size_t v = 7; v < scene->vertex_count; v += 60) scene->x1[3 * v] += 0.5;
    flawed.left = flaw;
    tulle_status const status = update_patches(patches, &step, &rules, counts);
    *has_failed = flawed.has_failed;
    if (status != TULLE_OK) {
        assert_int_equal(status, TULLE_ERROR_OUT_OF_MEMORY);
        patch_labels const labels = kept_patches_get_labels(patches);
        assert_int_equal(labels.label_count, 0);
        for (size_t i = 0; i < scene->triangle_count; i++)
            assert_int_equal(labels.labels[i], PATCH_ISOLATED);
        patch_counts again;
        assert_int_equal(update_patches(patches, &step, &rules, &again), TULLE_OK);
        assert_true(again.patch_count > 0);
    }
    kept_patches_destroy(patches);
    assert_int_equal(heap.bytes_held, 0);
    return status;
}

/* A call does what it does with memory, or says that it had none. */
static void want_of_memory_while_patches_are_mended(void **state) {
    (void)state;
    uint64_t seed = 29;
    patch_scene scene;
    patch_scene_make(&scene, PATCH_RAMP, 20, &seed);
    patch_counts whole, counts;
    bool has_failed;
    int failures = 0;
    assert_int_equal(mend(&scene, -1, &whole, &has_failed), TULLE_OK);
    assert_true(whole.split_count > 0 && !has_failed);
    for (int flaw = 0; flaw == 0 || has_failed; flaw++) {
        tulle_status const status = mend(&scene, flaw, &counts, &has_failed);
        failures += status != TULLE_OK;
        patch_counts const expected = status == TULLE_OK ? whole : (patch_counts){0};
        assert_memory_equal(&counts, &expected, sizeof expected);
    }
    assert_true(failures > 3);
    patch_scene_destroy(&scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_turn_in_a_large_patch_is_noticed),
        cmocka_unit_test(a_turn_without_a_certificate_dissolves_the_patch),
        cmocka_unit_test(want_of_memory_while_patches_are_mended),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
