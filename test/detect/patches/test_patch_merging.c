/* Neighbouring patches that become one after growth: where they are certified together and face one
 * axis well; apart in exact arithmetic as all patches are, by the reach that was asked for, and the
 * same for every number of threads. */
#include "detect/patches/kept_patches_parts.h"

#include "support/patch_scene.h"
#include "support/test_support.h"
#include "support/wide_normals.h"

#include <math.h>
#include <stdlib.h>

enum {
    ARCH = 16,           /* squares along and across */
    ARCH_ROW = ARCH + 2, /* vertices; the last is one side of a slit */
    MOST_THREADS = 8
};

static patch_rules make_rules(double degrees, double reach, bool merges) {
    return (patch_rules){.cone = CONE_BERNSTEIN,
                         .max_angle = degrees * DEGREE,
                         .has_certificate = true,
                         .grows_anew = !merges,
                         .reach = reach,
                         .keeps_all = true};
}

static patch_counts update(kept_patches *patches, const patch_scene *scene,
                           const patch_rules *rules, int threads) {
    patch_counts counts;
    patch_step const step = {&scene->set, scene->x0, scene->x1, threads};
    assert_int_equal(update_patches(patches, &step, rules, &counts), TULLE_OK);
    return counts;
}

static patch_counts grow(patch_scene *scene, const patch_rules *rules, kept_patches **patches) {
    assert_int_equal(kept_patches_create(&scene->heap, &scene->set, NULL, patches), TULLE_OK);
    return update(*patches, scene, rules, 1);
}

/* Of a row of the arch; in the first half of a slit arch what lies beyond the slit has a side of it
 * that is its own. */
static uint32_t find_arch_vertex(uint32_t row, uint32_t column, bool is_beyond_slit) {
    return row * ARCH_ROW + (is_beyond_slit && column == ARCH / 2 ? ARCH + 1 : column);
}

/* A sheet bent over a cylinder, normals up to `half` [degrees] to both sides, moving a little. With
 * gap > 0 [m] a slit of that width leads from the middle of its first edge to its middle. */
static void make_arch(patch_scene *scene, double half, double gap) {
    double x0[3 * ARCH_ROW * (ARCH + 1)], x1[3 * ARCH_ROW * (ARCH + 1)];
    uint32_t triangles[6 * ARCH * ARCH];
    for (uint32_t i = 0; i < ARCH_ROW * (ARCH + 1); i++) {
        uint32_t const column = i % ARCH_ROW;
        double const angle = half * DEGREE * (2.0 * (i / ARCH_ROW) / ARCH - 1.0);
        double const across = column > ARCH ? 1.0 + gap : 2.0 * column / ARCH;
        bool const is_shifted = column > ARCH / 2 && column <= ARCH;
        vec3 const place = {sin(angle), is_shifted ? across + gap : across, cos(angle)};
        vec3_store(x0, i, place);
        vec3_store(x1, i, vec3_make(place.x, place.y + 0.01 * angle, place.z + 0.01));
    }
    uint32_t *corner = triangles;
    for (uint32_t i = 0; i < ARCH; i++) {
        for (uint32_t j = 0; j < ARCH; j++) {
            bool const own = gap > 0.0 && j >= ARCH / 2;
            uint32_t const a = find_arch_vertex(i, j, own && i < ARCH / 2);
            uint32_t const b = find_arch_vertex(i + 1, j, own && i + 1 < ARCH / 2);
            uint32_t const corners[6] = {a,
                                         b,
                                         (i + 1) * ARCH_ROW + j + 1,
                                         a,
                                         (i + 1) * ARCH_ROW + j + 1,
                                         i * ARCH_ROW + j + 1};
            for (int k = 0; k < 6; k++) *corner++ = corners[k];
        }
    }
    patch_scene_make_of(scene, x0, x1, ARCH_ROW * (ARCH + 1), triangles, 2 * ARCH * ARCH);
}

static patch_counts grow_arch(double half, double gap, double reach, bool merges) {
    patch_scene scene;
    kept_patches *patches;
    uint64_t seed = 31;
    make_arch(&scene, half, gap);
    patch_rules const rules = make_rules(60.0, reach, merges);
    patch_counts const counts = grow(&scene, &rules, &patches);
    const uint32_t *const labels = kept_patches_get_labels(patches).labels;
    assert_patches_are_discs(&scene, labels);
    assert_true(assert_patches_are_apart(&scene, labels, 2.0 * reach, &seed) > 0);
    assert_int_equal(counts.triangle_count, scene.triangle_count);
    kept_patches_destroy(patches);
    patch_scene_destroy(&scene);
    return counts;
}

/* Within 60 degrees of its axis a patch takes 120 of the 130 degrees of the first arch, and the
 * rest, at most 70 from that axis, joins it; of the 164 of the second it would be 104 away. */
static void what_faces_the_axis_joins(void **state) {
    (void)state;
    for (int k = 0; k < 2; k++) {
        double const reach = k * 0.002;
        assert_true(grow_arch(65.0, 0.0, reach, false).patch_count > 1);
        assert_int_equal(grow_arch(65.0, 0.0, reach, true).patch_count, 1);
        assert_true(grow_arch(82.0, 0.0, reach, true).patch_count > 1);
    }
}

/* Both sides of a slit are of one patch only when they are more than twice the reach apart. */
static void what_keeps_twice_the_reach_joins(void **state) {
    (void)state;
    double const gap = 0.01;
    assert_true(grow_arch(65.0, gap, 0.2 * gap, false).patch_count > 1);
    assert_int_equal(grow_arch(65.0, gap, 0.2 * gap, true).patch_count, 1);
    patch_counts const grown = grow_arch(65.0, gap, 0.6 * gap, false);
    patch_counts const merged = grow_arch(65.0, gap, 0.6 * gap, true);
    assert_true(merged.patch_count > 1 && merged.patch_count < grown.patch_count);
}

/* Merging counts edges by label. Labels of patches that are gone do not take it beyond its room. */
static void more_labels_than_triangles_merge(void **state) {
    (void)state;
    patch_scene scene;
    kept_patches *grown, *patches;
    make_arch(&scene, 65.0, 0.0);
    patch_rules const plain = make_rules(60.0, 0.0, false);
    assert_true(grow(&scene, &plain, &grown).patch_count > 1);
    assert_int_equal(kept_patches_create(&scene.heap, &scene.set, NULL, &patches), TULLE_OK);
    for (size_t i = 0; i < 2 * scene.triangle_count; i++) {
        vec3 const axis = {0.0, 0.0, 1.0};
        assert_int_equal(append_patch(patches, NULL, 0, axis, true), TULLE_OK);
    }
    for (size_t i = 0; i < grown->patches.count; i++) {
        const kept_patch *const patch = &grown->patches.data[i];
        const uint32_t *const list = grown->triangles.data + patch->triangle_begin;
        assert_int_equal(append_patch(patches, list, patch->triangle_count, patch->axis, true),
                         TULLE_OK);
    }
    assert_true(patches->patches.count > 2 * scene.triangle_count);

    patch_counts counts = {0};
    patch_rules const rules = make_rules(60.0, 0.0, true);
    patch_step const step = {&scene.set, scene.x0, scene.x1, 1};
    growth_input const input = {&step, &rules, 1};
    uint64_t const budget = 100 * scene.triangle_count;
    assert_int_equal(merge_patches(patches, &input, budget, &counts), TULLE_OK);
    assert_true(patches->patches.count <= scene.triangle_count);
    assert_true(measure_cover(patches, &scene.set).covered == scene.triangle_count);
    size_t live_count = 0;
    for (size_t i = 0; i < patches->patches.count; i++)
        live_count += patches->patches.data[i].triangle_count > 0;
    assert_int_equal(live_count, 1);
    kept_patches_destroy(patches);
    kept_patches_destroy(grown);
    patch_scene_destroy(&scene);
}

/* Of every shape, in motions that are more and more violent, every second one with a reach. */
static void merged_patches_are_apart(void **state) {
    (void)state;
    uint64_t seed = 32, grown_count = 0, merged_count = 0, grown_triangles = 0, triangles = 0;
    size_t pair_count[2] = {0, 0}, merged_with_reach = 0;
    for (int round = 0; round < 60; round++) {
        patch_scene scene;
        patch_scene_make(&scene, (patch_shape)(round / 2 % PATCH_SHAPE_COUNT), 6, &seed);
        double const violence = round / 60.0;
        patch_scene_move(&scene, 0.2 * violence, 0.04 * violence * violence, &seed);
        double const degrees = random_between(&seed, 20.0, 70.0);
        double const reach = round % 2 ? random_between(&seed, 0.0005, 0.006) : 0.0;
        patch_rules const plain = make_rules(degrees, reach, false);
        patch_rules const merging = make_rules(degrees, reach, true);
        kept_patches *grown, *merged;
        patch_counts const before = grow(&scene, &plain, &grown);
        patch_counts const after = grow(&scene, &merging, &merged);
        const uint32_t *const labels = kept_patches_get_labels(merged).labels;
        assert_true(after.patch_count <= before.patch_count);
        assert_int_equal(after.star_count + after.contour_count, after.patch_count);
        assert_patches_are_discs(&scene, labels);
        pair_count[round % 2] += assert_patches_are_apart(&scene, labels, 2.0 * reach, &seed);
        grown_count += before.patch_count, merged_count += after.patch_count;
        if (round % 2) merged_with_reach += before.patch_count - after.patch_count;
        grown_triangles += before.triangle_count, triangles += after.triangle_count;
        kept_patches_destroy(grown);
        kept_patches_destroy(merged);
        patch_scene_destroy(&scene);
    }
    assert_true(pair_count[0] > 5000 && pair_count[1] > 5000);
    assert_true(merged_count + 30 < grown_count); /* most others are single triangles */
    assert_true(merged_with_reach > 15);
    assert_true(50 * triangles > 49 * grown_triangles); /* few are left out for it */
}

static void assert_same_patches(const kept_patches *a, const kept_patches *b, size_t count) {
    size_t const size = kept_patches_save(a, NULL);
    assert_memory_equal(kept_patches_get_labels(a).labels, kept_patches_get_labels(b).labels,
                        count * sizeof(uint32_t));
    assert_true(size > 0 && size == kept_patches_save(b, NULL));
    unsigned char *const bytes = malloc(2 * size);
    assert_non_null(bytes);
    kept_patches_save(a, bytes);
    kept_patches_save(b, bytes + size);
    assert_memory_equal(bytes, bytes + size, size);
    free(bytes);
}

/* Merged by several threads, then kept, mended and merged into over further motions: the same
 * labels, counts and saved bytes after each call. */
static void merging_does_not_depend_on_threads(void **state) {
    (void)state;
    static const int threads[] = {1, 2, 3, MOST_THREADS};
    enum { COUNTS = sizeof threads / sizeof *threads, CALLS = 4 };
    uint64_t seed = 33, merged_count = 0, kept_count = 0;
    for (int round = 0; round < 2 * PATCH_SHAPE_COUNT; round++) {
        patch_scene scene;
        patch_scene_make(&scene, (patch_shape)(round / 2), 30, &seed);
        double const reach = round % 2 ? 0.0005 : 0.0;
        patch_rules const rules = make_rules(random_between(&seed, 20.0, 60.0), reach, true);
        patch_rules const plain = make_rules(rules.max_angle / DEGREE, reach, false);
        kept_patches *all[COUNTS], *grown;
        merged_count += grow(&scene, &plain, &grown).patch_count;
        kept_patches_destroy(grown);
        for (int i = 0; i < COUNTS; i++)
            assert_int_equal(kept_patches_create(&scene.heap, &scene.set, NULL, &all[i]), TULLE_OK);
        for (int call = 0; call < CALLS; call++) {
            patch_counts const first = update(all[0], &scene, &rules, threads[0]);
            if (call == 0) merged_count -= first.patch_count;
            kept_count += first.kept_count;
            for (int i = 1; i < COUNTS; i++) {
                patch_counts const counts = update(all[i], &scene, &rules, threads[i]);
                assert_memory_equal(&first, &counts, sizeof first);
                assert_same_patches(all[0], all[i], scene.triangle_count);
            }
            patch_scene_move(&scene, 0.02 * call, 0.0005 * call, &seed);
        }
        for (int i = 0; i < COUNTS; i++) kept_patches_destroy(all[i]);
        patch_scene_destroy(&scene);
    }
    assert_true(merged_count > 30 && kept_count > 1000);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_faces_the_axis_joins),
        cmocka_unit_test(what_keeps_twice_the_reach_joins),
        cmocka_unit_test(more_labels_than_triangles_merge),
        cmocka_unit_test(merged_patches_are_apart),
        cmocka_unit_test(merging_does_not_depend_on_threads),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
