/* Kept patches: discs, apart in exact arithmetic over the whole step, the same for any number of
 * threads, from step to step and from saved bytes. */
#include "detect/patches/kept_patches.h"

#include "math/kernel_target.h"
#include "support/patch_scene.h"
#include "support/test_support.h"
#include "support/wide_normals.h"

#include <stdlib.h>
#include <string.h>

static patch_rules make_rules(double degrees, bool grows_anew, double reach) {
    return (patch_rules){CONE_BERNSTEIN, degrees * DEGREE, true, grows_anew, reach, false};
}

static kept_patches *create(patch_scene *scene) {
    kept_patches *patches = NULL;
    assert_int_equal(kept_patches_create(&scene->heap, &scene->set, NULL, &patches), TULLE_OK);
    return patches;
}

static patch_counts update(kept_patches *patches, const patch_scene *scene,
                           const patch_rules *rules, int threads) {
    patch_counts counts;
    assert_int_equal(update_patches(patches,
                                    &(patch_step){&scene->set, scene->x0, scene->x1, threads},
                                    rules, &counts),
                     TULLE_OK);
    return counts;
}

static size_t count_labelled(const patch_scene *scene, const uint32_t *labels) {
    size_t count = 0;
    for (size_t i = 0; i < scene->triangle_count; i++) count += labels[i] != PATCH_ISOLATED;
    return count;
}

static void patches_of_all_shapes_are_apart(void **state) {
    (void)state;
    uint64_t seed = 21;
    size_t pair_count = 0, patch_count = 0, swept_count = 0, star_count = 0;
    for (int round = 0; round < 50; round++) {
        patch_shape const shape = (patch_shape)(round % PATCH_SHAPE_COUNT);
        patch_scene scene;
        patch_scene_make(&scene, shape, 6, &seed);
        double const violence = round / 45.0;
        patch_scene_move(&scene, 0.3 * violence, 0.05 * violence * violence, &seed);
        double const reach = round % 3 == 2 ? 0.004 : 0.0;
        patch_rules const rules = make_rules(random_between(&seed, 30.0, 89.0), true, reach);
        kept_patches *const patches = create(&scene);
        patch_counts const counts = update(patches, &scene, &rules, 2);
        const uint32_t *const labels = kept_patches_get_labels(patches).labels;
        assert_int_equal(counts.triangle_count, count_labelled(&scene, labels));
        assert_int_equal(counts.star_count + counts.contour_count, counts.patch_count);
        assert_patches_are_discs(&scene, labels);
        pair_count += assert_patches_are_apart(&scene, labels, 2.0 * reach, &seed);
        assert_true(
            patches_hold(patches, &(patch_step){&scene.set, scene.x0, scene.x1, 2}, &rules));
        patch_count += counts.patch_count, star_count += counts.star_count;
        swept_count += counts.contour_count;
        kept_patches_destroy(patches);
        patch_scene_destroy(&scene);
    }
    assert_true(pair_count > 5000 && patch_count > 300);
    assert_true(star_count > 100 && swept_count > 30);
}

/* What is smooth is one patch, whole. */
static void a_waving_sheet_is_one_patch(void **state) {
    (void)state;
    uint64_t seed = 22;
    patch_scene scene;
    patch_scene_make(&scene, PATCH_SHEET, 40, &seed);
    patch_scene_move(&scene, 0.1, 0.0, &seed);
    kept_patches *const patches = create(&scene);
    patch_rules const rules = make_rules(60.0, false, 0.0);
    patch_counts const counts = update(patches, &scene, &rules, 1);
    assert_int_equal(counts.patch_count, 1);
    assert_int_equal(counts.triangle_count, scene.triangle_count);
    kept_patches_destroy(patches);
    patch_scene_destroy(&scene);
}

/* Kept over many steps of growing violence: sound at each, the same for 1, 2 and 5 threads, the
 * same when saved and loaded half-way. */
typedef struct long_run {
    uint64_t kept, split, dissolved, grown, most_triangles;
    uint64_t same_versions; /* steps whose labels bear the version of the step before */
    uint64_t labels_hash;
} long_run;

static uint64_t hash_labels(uint64_t hash, const patch_scene *scene, const uint32_t *labels) {
    for (size_t i = 0; i < scene->triangle_count; i++) hash = (hash ^ labels[i]) * 1099511628211u;
    return hash;
}

/* Loads the patches where there are none, and then over themselves, where they stay. */
static kept_patches *reload(kept_patches *patches, patch_scene *scene) {
    size_t const size = kept_patches_save(patches, NULL);
    assert_true(size > 0);
    unsigned char *const bytes = malloc(size + 1);
    assert_non_null(bytes);
    kept_patches_save(patches, bytes + 1); /* need not be aligned */
    kept_patches *const again = create(scene);
    assert_int_equal(kept_patches_load(again, bytes + 1, size), TULLE_OK);
    assert_memory_equal(kept_patches_get_labels(again).labels,
                        kept_patches_get_labels(patches).labels,
                        scene->triangle_count * sizeof(uint32_t));
    assert_int_equal(kept_patches_get_labels(again).label_count,
                     kept_patches_get_labels(patches).label_count);
    uint64_t const version = kept_patches_get_labels(again).version;
    assert_int_equal(kept_patches_load(again, bytes + 1, size), TULLE_OK);
    assert_true(kept_patches_get_labels(again).version == version);
    unsigned char *const same = malloc(size);
    assert_non_null(same);
    assert_int_equal(kept_patches_save(again, same), size);
    assert_memory_equal(same, bytes + 1, size);
    free(same);
    free(bytes);
    kept_patches_destroy(patches);
    return again;
}

/* A state is loaded again and again while the patches go on, some steps or none: they are what they
 * were made of alone, and what is kept does not grow. */
static void going_back_leads_to_the_same_patches(void **state) {
    (void)state;
    enum { LATE = 5, ROUNDS = 40 };
    uint64_t seed = 31;
    patch_scene scene;
    patch_scene_make(&scene, PATCH_SHEET, 20, &seed);
    kept_patches *const patches = create(&scene), *const other = create(&scene);
    patch_rules rules = make_rules(60.0, false, 0.0);
    rules.keeps_all = true;
    size_t const coordinates = 3 * scene.vertex_count, bytes = coordinates * sizeof(double);
    double *const base = malloc(bytes), *const paths = malloc((LATE + 1) * bytes);
    assert_true(base && paths);
    memcpy(base, scene.x0, bytes);
    size_t stayed = 0;
    for (int round = 0; round < ROUNDS; round++) {
        double const violence = round < 20 ? 0.002 : 0.06;
        for (int i = 0; i <= LATE; i++) {
            memcpy(scene.x0, base, bytes);
            patch_scene_move(&scene, violence, 0.3 * violence, &seed);
            memcpy(paths + (size_t)i * coordinates, scene.x1, bytes);
        }
        memcpy(scene.x0, base, bytes);
        memcpy(scene.x1, base, bytes);
        update(patches, &scene, &rules, 1);
        size_t const size = kept_patches_save(patches, NULL);
        unsigned char *const saved = malloc(size);
        assert_non_null(saved);
        kept_patches_save(patches, saved);
        unsigned char *ends[3] = {NULL};
        size_t sizes[3] = {0};
        for (int time = 0; time < 3; time++) {
            /* gone on; loaded over what has gone on; loaded where there is something else */
            kept_patches *const own = time == 2 ? other : patches;
            uint64_t const version = kept_patches_get_labels(own).version;
            if (time > 0) assert_int_equal(kept_patches_load(own, saved, size), TULLE_OK);
            stayed += time == 1 && kept_patches_get_labels(own).version == version;
            for (size_t i = 0; i < LATE; i++) {
                memcpy(scene.x0, paths + i * coordinates, bytes);
                memcpy(scene.x1, paths + (i + 1) * coordinates, bytes);
                update(own, &scene, &rules, 1);
            }
            assert_patches_are_discs(&scene, kept_patches_get_labels(own).labels);
            sizes[time] = kept_patches_save(own, NULL);
            ends[time] = malloc(sizes[time]);
            assert_non_null(ends[time]);
            kept_patches_save(own, ends[time]);
            assert_int_equal(sizes[time], sizes[0]);
            assert_memory_equal(ends[time], ends[0], sizes[0]);
        }
        for (int time = 0; time < 3; time++) free(ends[time]);
        free(saved);
    }
    print_message("%d of %d loads left the patches where they were\n", (int)stayed, ROUNDS);
    assert_true(stayed > ROUNDS / 4 && stayed < ROUNDS);
    free(base);
    free(paths);
    kept_patches_destroy(patches);
    kept_patches_destroy(other);
    patch_scene_destroy(&scene);
}

static long_run run_long(int threads, int reload_every, bool is_checked) {
    uint64_t seed = 23, check_seed = 1;
    patch_scene scene;
    patch_scene_make(&scene, PATCH_SHEET, 20, &seed);
    kept_patches *patches = create(&scene);
    patch_rules rules = make_rules(60.0, false, 0.0);
    rules.keeps_all = true; /* so that there are some at each step */
    long_run total = {0};
    size_t const bytes = 3 * scene.vertex_count * sizeof(double);
    double *const base = malloc(bytes), *const before = malloc(bytes);
    assert_true(base && before);
    memcpy(base, scene.x0, bytes);
    memcpy(before, scene.x0, bytes);
    patch_labels last = {0};
    uint64_t last_hash = 0;
    for (int step = 0; step < 120; step++) {
        double const violence = step < 60 ? step / 60.0 : (120 - step) / 120.0;
        memcpy(scene.x0, base, bytes); /* x1 stays near the sheet */
        patch_scene_move(&scene, 0.02 + 0.1 * violence, 0.03 * violence * violence, &seed);
        memcpy(scene.x0, before, bytes);
        patch_counts const counts = update(patches, &scene, &rules, threads);
        const uint32_t *const labels = kept_patches_get_labels(patches).labels;
        total.kept += counts.kept_count, total.split += counts.split_count;
        total.dissolved += counts.dissolved_count, total.grown += counts.grown_triangle_count;
        if (counts.triangle_count > total.most_triangles)
            total.most_triangles = counts.triangle_count;
        total.labels_hash = hash_labels(total.labels_hash, &scene, labels);
        patch_labels const now = kept_patches_get_labels(patches);
        uint64_t const hash = hash_labels(0, &scene, labels);
        bool const is_same = now.labels == last.labels && now.version == last.version;
        if (is_same) assert_true(hash == last_hash);
        total.same_versions += is_same;
        last = now, last_hash = hash;
        if (is_checked && step % 40 == 30) {
            assert_patches_are_discs(&scene, labels);
            assert_patches_are_apart(&scene, labels, 0.0, &check_seed);
        }
        if (reload_every && step % reload_every == 0) patches = reload(patches, &scene);
        memcpy(before, scene.x1, bytes);
    }
    free(base);
    free(before);
    kept_patches_destroy(patches);
    patch_scene_destroy(&scene);
    return total;
}

static void patches_are_kept_from_step_to_step(void **state) {
    (void)state;
    long_run const first = run_long(1, 0, true);
    assert_true(first.kept > 20);
    assert_true(first.split > 0 && first.dissolved > 0);
    assert_true(first.most_triangles > 400);
    assert_true(first.same_versions > 20);
    long_run others[3] = {run_long(2, 0, false), run_long(5, 0, false), run_long(2, 7, false)};
    others[2].same_versions = first.same_versions; /* loading makes a new version */
    for (int k = 0; k < 3; k++) assert_memory_equal(&others[k], &first, sizeof first);
}

/* All variants of the kernels give the same bits: the same patches over the long run. */
static void vector_widths_agree(void **state) {
    (void)state;
    kernel_target const own = kernel_target_get();
    long_run const first = run_long(2, 0, false);
    for (int target = 0; target < KERNEL_TARGET_COUNT; target++) {
        if (!kernel_target_force((kernel_target)target)) continue;
        long_run const other = run_long(2, 0, false);
        assert_memory_equal(&other, &first, sizeof first);
    }
    assert_true(kernel_target_force(own));
}

/* Without a certificate: the paper's rule, cones only. A helix of 1.6 turns is one patch then, and
 * is never one with a certificate. */
static void cones_alone_do_not_see_the_helix(void **state) {
    (void)state;
    uint64_t seed = 24;
    patch_scene scene;
    patch_scene_make(&scene, PATCH_RAMP, 10, &seed);
    kept_patches *const patches = create(&scene);
    patch_rules rules = make_rules(60.0, true, 0.0);
    rules.has_certificate = false;
    patch_counts counts = update(patches, &scene, &rules, 1);
    assert_int_equal(counts.patch_count, 1);
    assert_int_equal(counts.triangle_count, scene.triangle_count);
    assert_true(patches_hold(patches, &(patch_step){&scene.set, scene.x0, scene.x1, 1}, &rules));
    rules.grows_anew = false;
    for (int step = 0; step < 3; step++) counts = update(patches, &scene, &rules, 1);
    assert_int_equal(counts.kept_count, 1);
    rules.has_certificate = true, rules.grows_anew = true;
    counts = update(patches, &scene, &rules, 1);
    assert_true(counts.patch_count > 1);
    assert_true(counts.triangle_count * 10 > scene.triangle_count * 9);
    kept_patches_destroy(patches);
    patch_scene_destroy(&scene);
}

/* Patches that no longer hold are noticed without being changed. */
static void what_fails_is_noticed(void **state) {
    (void)state;
    uint64_t seed = 25;
    patch_scene scene;
    patch_scene_make(&scene, PATCH_SHEET, 80, &seed); /* large: cut into tasks */
    kept_patches *const patches = create(&scene);
    patch_rules const rules = make_rules(60.0, false, 0.0);
    update(patches, &scene, &rules, 2);
    uint32_t *const labels = malloc(scene.triangle_count * sizeof *labels);
    assert_non_null(labels);
    memcpy(labels, kept_patches_get_labels(patches).labels, scene.triangle_count * sizeof *labels);
    for (int round = 0; round < 40; round++) {
        size_t const vertex = (size_t)(random_uniform(&seed) * (double)scene.vertex_count);
        double *const x = scene.x1 + 3 * vertex, old = x[0];
        if (old > 0.9) continue;                     /* it would only stretch the sheet */
        x[0] += round % 4 == 3 ? (double)NAN : 0.05; /* four edge lengths */
        assert_false(
            patches_hold(patches, &(patch_step){&scene.set, scene.x0, scene.x1, 2}, &rules));
        x[0] = old;
        assert_true(
            patches_hold(patches, &(patch_step){&scene.set, scene.x0, scene.x1, 2}, &rules));
    }
    assert_memory_equal(labels, kept_patches_get_labels(patches).labels,
                        scene.triangle_count * sizeof *labels);
    scene.range.ignores_self = true;
    assert_false(patches_hold(patches, &(patch_step){&scene.set, scene.x0, scene.x1, 2}, &rules));
    assert_int_equal(update(patches, &scene, &rules, 2).patch_count, 0);
    assert_int_equal(count_labelled(&scene, kept_patches_get_labels(patches).labels), 0);
    free(labels);
    kept_patches_destroy(patches);
    patch_scene_destroy(&scene);
}

/* On a crumple they go, and are tried again ever more rarely. */
static void they_switch_themselves_off(void **state) {
    (void)state;
    uint64_t seed = 26;
    patch_scene scene;
    patch_scene_make(&scene, PATCH_SHEET, 40, &seed);
    for (size_t i = 0; i < scene.vertex_count; i++)
        scene.x0[3 * i + 2] += random_between(&seed, -0.05, 0.05);
    memcpy(scene.x1, scene.x0, 3 * scene.vertex_count * sizeof(double));
    kept_patches *const patches = create(&scene);
    patch_rules const rules = make_rules(60.0, false, 0.0);
    size_t growths = 0;
    for (int step = 0; step < 1000; step++) {
        patch_counts const counts = update(patches, &scene, &rules, 1);
        growths += counts.grown_triangle_count > 0;
        assert_int_equal(counts.patch_count, 0);
        assert_true(growths <= 1 + (size_t)step / 100); /* a growth costs some calls */
    }
    assert_true(growths >= 3);
    patch_rules keeping = rules;
    keeping.keeps_all = true;
    for (int step = 0; step < 10; step++)
        assert_true(update(patches, &scene, &keeping, 1).triangle_count > scene.triangle_count / 4);
    kept_patches_destroy(patches);
    patch_scene_destroy(&scene);
}

/* Bytes that do not fit are refused, and leave no patches, whether these were the same or not. */
static void damaged_bytes_are_refused(void **state) {
    (void)state;
    uint64_t seed = 27;
    patch_scene scene;
    patch_scene_make(&scene, PATCH_SHEET, 12, &seed);
    kept_patches *const patches = create(&scene);
    assert_int_equal(kept_patches_save(patches, NULL), 0);
    assert_int_equal(kept_patches_load(patches, NULL, 0), TULLE_OK);
    patch_rules const rules = make_rules(60.0, false, 0.0);
    update(patches, &scene, &rules, 1);
    size_t const size = kept_patches_save(patches, NULL);
    unsigned char *const bytes = malloc(size), *const damaged = malloc(size);
    assert_true(bytes && damaged);
    kept_patches_save(patches, bytes);
    size_t refused = 0;
    for (int round = 0; round < 3000; round++) {
        memcpy(damaged, bytes, size);
        size_t const at = (size_t)(random_uniform(&seed) * (double)size);
        damaged[at] ^= (unsigned char)(1u << (round % 8));
        tulle_status const status = kept_patches_load(patches, damaged, round % 5 == 0 ? at : size);
        if (status == TULLE_OK) { /* the schedule, or another order of the same disc */
            assert_patches_are_discs(&scene, kept_patches_get_labels(patches).labels);
        } else {
            refused++;
            assert_int_equal(status, TULLE_ERROR_INVALID_ARGUMENT);
            assert_int_equal(kept_patches_get_labels(patches).label_count, 0);
            assert_int_equal(count_labelled(&scene, kept_patches_get_labels(patches).labels), 0);
        }
        update(patches, &scene, &rules, 1);
    }
    assert_true(refused > 1500);
    free(bytes);
    free(damaged);
    kept_patches_destroy(patches);
    patch_scene_destroy(&scene);
}

static void *refuse_memory(void *context, size_t byte_count) {
    long *const left = context;
    return --*left < 0 ? NULL : malloc(byte_count);
}
static void release_memory(void *context, void *pointer, size_t byte_count) {
    (void)context, (void)byte_count;
    free(pointer);
}

/* Each allocation fails in turn: an error, no patches, no leak; and the next call works. */
static void want_of_memory_leaves_no_patches(void **state) {
    (void)state;
    uint64_t seed = 28;
    patch_scene scene;
    patch_scene_make(&scene, PATCH_RAMP, 20, &seed);
    patch_rules const rules = make_rules(60.0, true, 0.0);
    bool is_through = false;
    long allowed = 0;
    for (; !is_through; allowed++) {
        assert_true(allowed < 1000);
        long left = allowed;
        memory heap = {.allocator = {refuse_memory, release_memory, &left, 0}};
        kept_patches *patches = NULL;
        if (kept_patches_create(&heap, &scene.set, NULL, &patches) == TULLE_OK) {
            patch_counts counts;
            tulle_status const status = update_patches(
                patches, &(patch_step){&scene.set, scene.x0, scene.x1, 2}, &rules, &counts);
            is_through = status == TULLE_OK;
            if (!is_through) {
                assert_int_equal(status, TULLE_ERROR_OUT_OF_MEMORY);
                assert_int_equal(kept_patches_get_labels(patches).label_count, 0);
                assert_int_equal(count_labelled(&scene, kept_patches_get_labels(patches).labels),
                                 0);
                left = 1000;
                assert_true(update(patches, &scene, &rules, 2).patch_count > 0);
            }
            kept_patches_destroy(patches);
        }
        assert_int_equal(heap.bytes_held, 0);
    }
    assert_true(allowed > 15);
    patch_scene_destroy(&scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(patches_of_all_shapes_are_apart),
        cmocka_unit_test(a_waving_sheet_is_one_patch),
        cmocka_unit_test(patches_are_kept_from_step_to_step),
        cmocka_unit_test(vector_widths_agree),
        cmocka_unit_test(cones_alone_do_not_see_the_helix),
        cmocka_unit_test(what_fails_is_noticed),
        cmocka_unit_test(they_switch_themselves_off),
        cmocka_unit_test(going_back_leads_to_the_same_patches),
        cmocka_unit_test(damaged_bytes_are_refused),
        cmocka_unit_test(want_of_memory_leaves_no_patches),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
