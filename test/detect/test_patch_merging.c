/* Neighbouring patches that become one after growth: where they are certified together and face one
 * axis well; apart in exact arithmetic as all patches are. */
#include "detect/kept_patches.h"

#include "support/patch_scene.h"
#include "support/test_support.h"
#include "support/wide_normals.h"

#include <math.h>
#include <stdlib.h>

enum { ARCH = 24 }; /* squares along and across */

static patch_counts grow(patch_scene *scene, double degrees, bool merges, kept_patches **patches) {
    patch_rules const rules = {.cone = CONE_BERNSTEIN,
                               .max_angle = degrees * DEGREE,
                               .has_certificate = true,
                               .grows_anew = !merges,
                               .keeps_all = true};
    patch_counts counts;
    assert_int_equal(kept_patches_create(&scene->heap, &scene->set, patches), TULLE_OK);
    patch_step const step = {&scene->set, scene->x0, scene->x1, 1};
    assert_int_equal(update_patches(*patches, &step, &rules, &counts), TULLE_OK);
    return counts;
}

/* A sheet bent over a cylinder, normals up to `half` [degrees] to both sides, moving a little. */
static void make_arch(patch_scene *scene, double half) {
    enum { ROW = ARCH + 1 };
    double x0[3 * ROW * ROW], x1[3 * ROW * ROW];
    uint32_t triangles[6 * ARCH * ARCH];
    for (uint32_t i = 0; i < ROW * ROW; i++) {
        double const angle = half * DEGREE * (2.0 * (i / ROW) / ARCH - 1.0);
        double const across = 2.0 * (i % ROW) / ARCH;
        vec3 const place = {sin(angle), across, cos(angle)};
        vec3_store(x0, i, place);
        vec3_store(x1, i, vec3_make(place.x, place.y + 0.01 * angle, place.z + 0.01));
    }
    uint32_t *corner = triangles;
    for (uint32_t i = 0; i < ARCH; i++) {
        for (uint32_t j = 0; j < ARCH; j++) {
            uint32_t const a = i * ROW + j, b = a + ROW;
            uint32_t const corners[6] = {a, b, b + 1, a, b + 1, a + 1};
            for (int k = 0; k < 6; k++) *corner++ = corners[k];
        }
    }
    patch_scene_make_of(scene, x0, x1, ROW * ROW, triangles, 2 * ARCH * ARCH);
}

static patch_counts grow_arch(double half, bool merges) {
    patch_scene scene;
    kept_patches *patches;
    uint64_t seed = 31;
    make_arch(&scene, half);
    patch_counts const counts = grow(&scene, 60.0, merges, &patches);
    const uint32_t *const labels = kept_patches_get_labels(patches);
    assert_patches_are_discs(&scene, labels);
    assert_true(assert_patches_are_apart(&scene, labels, 0.0, &seed) > 0);
    assert_int_equal(counts.triangle_count, scene.triangle_count);
    kept_patches_destroy(patches);
    patch_scene_destroy(&scene);
    return counts;
}

/* Within 60 degrees of its axis a patch takes 120 of the 130 degrees of the first arch, and the
 * rest, at most 70 from that axis, joins it; of the 164 of the second it would be 104 away. */
static void what_faces_the_axis_joins(void **state) {
    (void)state;
    assert_true(grow_arch(65.0, false).patch_count > 1);
    assert_int_equal(grow_arch(65.0, true).patch_count, 1);
    assert_true(grow_arch(82.0, true).patch_count > 1);
}

/* Of every shape, in motions that are more and more violent. */
static void merged_patches_are_apart(void **state) {
    (void)state;
    uint64_t seed = 32, grown_count = 0, merged_count = 0, grown_triangles = 0, triangles = 0;
    size_t pair_count = 0;
    for (int round = 0; round < 60; round++) {
        patch_scene scene;
        patch_scene_make(&scene, (patch_shape)(round % PATCH_SHAPE_COUNT), 7, &seed);
        double const violence = round / 60.0;
        patch_scene_move(&scene, 0.2 * violence, 0.04 * violence * violence, &seed);
        double const degrees = random_between(&seed, 20.0, 70.0);
        kept_patches *grown, *merged;
        patch_counts const before = grow(&scene, degrees, false, &grown);
        patch_counts const after = grow(&scene, degrees, true, &merged);
        const uint32_t *const labels = kept_patches_get_labels(merged);
        assert_true(after.patch_count <= before.patch_count);
        assert_int_equal(after.star_count + after.contour_count, after.patch_count);
        assert_patches_are_discs(&scene, labels);
        pair_count += assert_patches_are_apart(&scene, labels, 0.0, &seed);
        grown_count += before.patch_count, merged_count += after.patch_count;
        grown_triangles += before.triangle_count, triangles += after.triangle_count;
        kept_patches_destroy(grown);
        kept_patches_destroy(merged);
        patch_scene_destroy(&scene);
    }
    assert_true(pair_count > 5000);
    assert_true(merged_count + 30 < grown_count);       /* most others are single triangles */
    assert_true(50 * triangles > 49 * grown_triangles); /* few are left out for it */
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_faces_the_axis_joins),
        cmocka_unit_test(merged_patches_are_apart),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
