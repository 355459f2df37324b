/* When patches are let go, tried again and grown, by what searches tell of them. */
#include "detect/patches/kept_patches_parts.h"

#include "base/hash.h"
#include "support/patch_scene.h"
#include "support/test_support.h"
#include "support/wide_normals.h"

#include <stdlib.h>
#include <string.h>

enum { SIDE = 40, FIRST_WAIT = 128 /* calls until patches are tried again */ };

static const patch_rules rules = {CONE_BERNSTEIN, 60.0 * DEGREE, true, false, 0.0, false};

/* A sheet that hardly moves, and its patches. */
typedef struct schedule_case {
    patch_scene scene;
    kept_patches *patches;
    patch_counts counts; /* of the last call */
    uint64_t seed;
} schedule_case;

static void begin(schedule_case *with, uint64_t seed) {
    with->seed = seed;
    patch_scene_make(&with->scene, PATCH_SHEET, SIDE, &with->seed);
    patch_scene_move(&with->scene, 0.01, 0.0, &with->seed);
    assert_int_equal(kept_patches_create(&with->scene.heap, &with->scene.set, NULL, &with->patches),
                     TULLE_OK);
}

static void end(schedule_case *with) {
    kept_patches_destroy(with->patches);
    patch_scene_destroy(&with->scene);
}

static void update(schedule_case *with) {
    const patch_scene *const scene = &with->scene;
    patch_step const step = {&scene->set, scene->x0, scene->x1, 1};
    assert_int_equal(update_patches(with->patches, &step, &rules, &with->counts), TULLE_OK);
}

/* A call, and what its search comes to. */
static void call(schedule_case *with, uint64_t pairs, uint64_t near_pairs) {
    update(with);
    kept_patches_tell_search(with->patches, pairs, near_pairs);
}

/* Calls until patches are in use again; nothing is told of the last. */
static int wait_for_patches(schedule_case *with, uint64_t pairs) {
    for (int count = 1; count < 10000; count++) {
        update(with);
        if (with->counts.patch_count > 0) return count;
        kept_patches_tell_search(with->patches, pairs, pairs);
    }
    fail_msg("patches are not tried again");
    return 0;
}

static void what_saves_nothing_is_let_go(void **state) {
    (void)state;
    schedule_case with;
    begin(&with, 1);
    call(&with, 1000, 1000);
    assert_int_equal(with.counts.patch_count, 1);
    for (int round = 0; round < 3; round++) {
        call(&with, 1000, 1000);
        assert_int_equal(with.counts.patch_count, 0);
        assert_int_equal(wait_for_patches(&with, 1000), FIRST_WAIT << round);
        kept_patches_tell_search(with.patches, 1000, 1000);
    }
    end(&with);
}

static void what_saves_stays(void **state) {
    (void)state;
    schedule_case with;
    begin(&with, 2);
    for (int i = 0; i < 300; i++) {
        call(&with, 200, 1000);
        assert_int_equal(with.counts.patch_count, 1);
        assert_int_equal(with.counts.kept_count, i > 0);
    }
    /* held for long: the wait begins anew */
    for (int round = 0; round < 2; round++) {
        call(&with, 1000, 1000);
        call(&with, 1000, 1000);
        assert_int_equal(with.counts.patch_count, 0);
        assert_int_equal(wait_for_patches(&with, 1000), FIRST_WAIT);
        for (int i = 0; i < FIRST_WAIT; i++) call(&with, 200, 1000);
        assert_int_equal(with.counts.patch_count, 1);
    }
    end(&with);
}

/* Boundaries cost as pairs do. */
static void boundaries_count(void **state) {
    (void)state;
    uint64_t const edge_count = 4 * SIDE;
    for (int is_dearer = 0; is_dearer < 2; is_dearer++) {
        schedule_case with;
        begin(&with, 3);
        call(&with, is_dearer ? 1000 : 1000 - 3 * edge_count / 2 - 100, 1000);
        assert_int_equal(with.counts.patch_count, 1);
        call(&with, 0, 1000);
        assert_int_equal(with.counts.patch_count, is_dearer ? 0 : 1);
        end(&with);
    }
}

/* Where layers lie near one another, searches visit more than what is near on the mesh; how much
 * more, the first search without patches tells, and patches that save against that come back. What
 * it told fades. */
static void a_search_without_patches_tells_better(void **state) {
    (void)state;
    schedule_case with;
    begin(&with, 4);
    call(&with, 10000, 9000);
    call(&with, 20000, 9000); /* let go: this one is without */
    assert_int_equal(with.counts.patch_count, 0);
    call(&with, 10000, 9000);
    assert_int_equal(with.counts.patch_count, 1);
    int lasted = 0;
    for (; with.counts.patch_count == 1 && lasted < 1000; lasted++) call(&with, 10000, 9000);
    assert_true(lasted > 30 && lasted < 300);
    end(&with);
}

/* So patches that save against layers, not against what is near on the mesh, are in use nearly
 * always. */
static void what_saves_against_layers_comes_back(void **state) {
    (void)state;
    static const uint64_t with_patches[] = {10000, 12000, 11000}, without[] = {20000, 20000, 30000};
    for (int k = 0; k < 3; k++) {
        schedule_case with;
        begin(&with, 8);
        int used = 0, grown = 0;
        for (int i = 0; i < 2000; i++) {
            update(&with);
            bool const is_used = with.counts.patch_count > 0;
            used += is_used;
            grown += with.counts.grown_triangle_count > 0;
            kept_patches_tell_search(with.patches, is_used ? with_patches[k] : without[k],
                                     with_patches[k] - 1000);
        }
        assert_true(used > 1900);
        assert_true(grown < 50);
        end(&with);
    }
}

/* Saved bytes that say that patches are let go while there are some are refused, and so is more
 * credit than there can be. */
static void impossible_schedules_are_refused(void **state) {
    (void)state;
    schedule_case with;
    begin(&with, 9);
    call(&with, 200, 1000);
    call(&with, 200, 1000);
    size_t const size = kept_patches_save(with.patches, NULL);
    void *const bytes = malloc(size);
    kept_patches *again = NULL;
    assert_non_null(bytes);
    assert_int_equal(kept_patches_create(&with.scene.heap, &with.scene.set, NULL, &again),
                     TULLE_OK);
    patch_schedule const good = with.patches->schedule;
    for (int k = 0; k < 3; k++) {
        with.patches->schedule = good;
        if (k == 0) with.patches->schedule.is_off = 1;
        if (k == 1) with.patches->schedule.credit = UINT64_MAX / 2;
        kept_patches_save(with.patches, bytes);
        assert_int_equal(kept_patches_load(again, bytes, size),
                         k < 2 ? TULLE_ERROR_INVALID_ARGUMENT : TULLE_OK);
        assert_int_equal(kept_patches_get_labels(again).label_count, k < 2 ? 0 : 1);
    }
    free(bytes);
    kept_patches_destroy(again);
    end(&with);
}

/* Crumples the second half of the sheet from one call to the next. */
static void crumple_half(schedule_case *with) {
    patch_scene *const scene = &with->scene;
    for (size_t i = scene->vertex_count / 2; i < scene->vertex_count; i++)
        scene->x1[3 * i + 2] += random_between(&with->seed, -0.1, 0.1);
}

/* The patch fails; what holds is grown again at once where enough was saved before. */
static void what_is_saved_pays_for_growth(void **state) {
    (void)state;
    for (int is_early = 0; is_early < 2; is_early++) {
        schedule_case with;
        begin(&with, 5);
        for (int i = 0; i < (is_early ? 2 : 20); i++) call(&with, 200, 2000);
        crumple_half(&with);
        call(&with, 2000, 2000);
        assert_int_equal(with.counts.dissolved_count, 1);
        if (is_early) {
            assert_int_equal(with.counts.grown_triangle_count, 0);
            assert_int_equal(with.counts.patch_count, 0);
        } else {
            assert_true(with.counts.grown_triangle_count > with.scene.triangle_count / 2);
            assert_true(with.counts.triangle_count > with.scene.triangle_count / 4);
        }
        end(&with);
    }
}

/* What was cut and grown again is merged once the sheet is smooth, not at once. */
static void what_was_cut_is_merged_again(void **state) {
    (void)state;
    schedule_case with;
    begin(&with, 10);
    size_t const bytes = 3 * with.scene.vertex_count * sizeof(double);
    double *const smooth = malloc(bytes);
    assert_non_null(smooth);
    memcpy(smooth, with.scene.x1, bytes);
    for (int i = 0; i < 20; i++) call(&with, 200, 2000);
    crumple_half(&with);
    call(&with, 200, 2000);
    memcpy(with.scene.x1, smooth, bytes);
    uint64_t most = 0;
    int merged_at = 0;
    for (int i = 1; i < 200; i++) {
        call(&with, 200, 2000);
        if (with.counts.patch_count > most) most = with.counts.patch_count;
        if (with.counts.patch_count < most && merged_at == 0) merged_at = i;
    }
    assert_true(most > 1);
    assert_true(merged_at > 10);
    assert_true(with.counts.patch_count < most);
    assert_int_equal(with.counts.triangle_count, with.scene.triangle_count);
    assert_patches_are_discs(&with.scene, kept_patches_get_labels(with.patches).labels);
    free(smooth);
    end(&with);
}

/* A schedule that is saved and loaded goes on as if it had not been. */
static void saved_schedules_go_on(void **state) {
    (void)state;
    schedule_case whole, parted;
    begin(&whole, 6);
    begin(&parted, 6);
    uint64_t seed = 7, used = 0;
    for (int i = 0; i < 400; i++) {
        uint64_t const near_pairs = 2000;
        bool const pays = random_uniform(&seed) < 0.98;
        uint64_t const pairs = pays ? 300 : 2200;
        call(&whole, pairs, near_pairs);
        call(&parted, pairs, near_pairs);
        assert_memory_equal(&whole.counts, &parted.counts, sizeof whole.counts);
        used += whole.counts.patch_count;
        if (i % 3 != 1) continue;
        size_t const size = kept_patches_save(parted.patches, NULL);
        void *const bytes = malloc(size);
        assert_non_null(bytes);
        kept_patches_save(parted.patches, bytes);
        kept_patches_destroy(parted.patches);
        assert_int_equal(
            kept_patches_create(&parted.scene.heap, &parted.scene.set, NULL, &parted.patches),
            TULLE_OK);
        assert_int_equal(kept_patches_load(parted.patches, bytes, size), TULLE_OK);
        free(bytes);
    }
    assert_true(used > 50 && used < 400);
    end(&whole);
    end(&parted);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_saves_nothing_is_let_go),
        cmocka_unit_test(what_saves_stays),
        cmocka_unit_test(boundaries_count),
        cmocka_unit_test(a_search_without_patches_tells_better),
        cmocka_unit_test(what_saves_against_layers_comes_back),
        cmocka_unit_test(what_is_saved_pays_for_growth),
        cmocka_unit_test(impossible_schedules_are_refused),
        cmocka_unit_test(what_was_cut_is_merged_again),
        cmocka_unit_test(saved_schedules_go_on),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
