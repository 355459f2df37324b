/* The helix that passes through itself between two clean frames, and the ring with a gap that
 * closes: without a certificate each is one patch, so its collisions are lost; certified patches
 * are apart in exact arithmetic. Reads TULLE_DATA_DIR; exit code 77 without it. */
#include "detect/patches/kept_patches.h"

#include "support/patch_scene.h"
#include "support/test_support.h"
#include "support/wide_normals.h"
#include "tulle_io/mesh_files.h"

#include <stdio.h>
#include <stdlib.h>

static const char *data_path;

static tulle_mesh read_mesh(const char *name) {
    char path[4096];
    tulle_mesh mesh;
    tulle_error error;
    snprintf(path, sizeof path, "%s/synthetic/%s.obj", data_path, name);
    assert_int_equal(tulle_mesh_read(path, &mesh, &error), TULLE_OK);
    return mesh;
}

/* `degrees`: at which the whole surface is one patch by its cone. */
static void check_surface(const char *start_name, const char *end_name, double degrees) {
    uint64_t seed = 31;
    tulle_mesh start = read_mesh(start_name), end = read_mesh(end_name);
    assert_int_equal(start.vertex_count, end.vertex_count);
    patch_scene scene;
    patch_scene_make_of(&scene, start.positions, end.positions, start.vertex_count, start.triangles,
                        start.triangle_count);
    kept_patches *patches = NULL;
    assert_int_equal(kept_patches_create(&scene.heap, &scene.set, NULL, &patches), TULLE_OK);
    patch_rules rules = {CONE_BERNSTEIN, degrees * DEGREE, false, true, 0.0, false};
    patch_counts counts;
    assert_int_equal(
        update_patches(patches, &(patch_step){&scene.set, scene.x0, scene.x1, 2}, &rules, &counts),
        TULLE_OK);
    assert_int_equal(counts.patch_count, 1);
    assert_int_equal(counts.triangle_count, scene.triangle_count);
    for (int kept = 0; kept < 2; kept++) {
        rules.has_certificate = true, rules.grows_anew = !kept;
        assert_int_equal(update_patches(patches, &(patch_step){&scene.set, scene.x0, scene.x1, 2},
                                        &rules, &counts),
                         TULLE_OK);
        assert_true(counts.patch_count > 1);
        const uint32_t *const labels = kept_patches_get_labels(patches).labels;
        assert_patches_are_discs(&scene, labels);
        assert_patches_are_apart(&scene, labels, 0.0, &seed);
    }
    assert_true(counts.triangle_count * 2 > scene.triangle_count);
    kept_patches_destroy(patches);
    patch_scene_destroy(&scene);
    tulle_mesh_destroy(&start);
    tulle_mesh_destroy(&end);
}

static void the_helix_is_not_certified_whole(void **state) {
    (void)state;
    check_surface("ramp_t0", "ramp_t1", 60.0);
}

static void the_ring_is_not_certified_whole(void **state) {
    (void)state;
    check_surface("cring_t0", "cring_t1", 60.0);
}

int main(void) {
    data_path = getenv("TULLE_DATA_DIR");
    char path[4096];
    snprintf(path, sizeof path, "%s/synthetic/ramp_t0.obj", data_path ? data_path : "");
    FILE *const file = data_path ? fopen(path, "rb") : NULL;
    if (!file) {
        printf("skipped: TULLE_DATA_DIR names no folder with synthetic\n");
        return 77;
    }
    fclose(file);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_helix_is_not_certified_whole),
        cmocka_unit_test(the_ring_is_not_certified_whole),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
