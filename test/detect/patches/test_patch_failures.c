/* Patches that fail: large ones without a certificate are noticed when a triangle turns, and to
 * mend patches without memory is an error that leaves none. */
#include "detect/patches/kept_patches.h"
#include "support/failing_heap.h"
#include "support/patch_scene.h"
#include "support/test_support.h"
#include "support/wide_normals.h"

#include <string.h>

enum { PLENTY = 1000 }; /* allocations */

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

/* Patches of a ramp that are mended after some vertices have jumped, with memory for so many
 * allocations. */
static tulle_status mend(patch_scene *scene, int allowed, patch_counts *counts) {
    int left = PLENTY;
    memory heap = failing_heap_make(&left);
    patch_rules const rules = {CONE_BERNSTEIN, 60.0 * DEGREE, true, false, 0.0, true};
    kept_patches *const patches = create(&heap, scene);
    patch_step const step = get_step(scene);
    memcpy(scene->x1, scene->x0, 3 * scene->vertex_count * sizeof(double));
    assert_int_equal(update_patches(patches, &step, &rules, counts), TULLE_OK);
    for (size_t v = 7; v < scene->vertex_count; v += 60) scene->x1[3 * v] += 0.5;
    left = allowed;
    tulle_status const status = update_patches(patches, &step, &rules, counts);
    if (status != TULLE_OK) {
        patch_labels const labels = kept_patches_get_labels(patches);
        assert_int_equal(labels.label_count, 0);
        for (size_t i = 0; i < scene->triangle_count; i++)
            assert_int_equal(labels.labels[i], PATCH_ISOLATED);
        left = PLENTY;
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
    assert_int_equal(mend(&scene, PLENTY, &whole), TULLE_OK);
    assert_true(whole.split_count > 0);
    int allowed = 0;
    while (mend(&scene, allowed, &counts) != TULLE_OK) {
        assert_true(++allowed < PLENTY);
        assert_int_equal(counts.patch_count + counts.split_count, 0);
    }
    assert_memory_equal(&counts, &whole, sizeof whole);
    assert_true(allowed > 3);
    patch_scene_destroy(&scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_turn_in_a_large_patch_is_noticed),
        cmocka_unit_test(want_of_memory_while_patches_are_mended),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
