/* What the boxes of vertices say of the whole: the largest point of all that is there. */
#include "detect/trees/broad_phase_parts.h"
#include "support/pair_keys.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

/* Rounding is judged by the largest coordinate of all that is there, also of what is static and was
 * fitted long ago. */
static void the_largest_point_is_kept(void **state) {
    (void)state;
    memory heap = memory_default();
    uint64_t seed = 17;
    soup_scene *const soup = calloc(1, sizeof *soup);
    assert_non_null(soup);
    soup_scene_add(soup, SOUP_SHEET, 50, 0.02, &seed);
    soup_scene_add(soup, SOUP_SHEET, 50, 0.0, &seed);
    soup_scene_finish(&heap, soup);
    soup->surfaces[1].is_static = true;
    const uint32_t *const far = soup->topo.triangles + 3 * (size_t)soup->surfaces[1].triangle_begin;
    for (int side = 0; side < 2; side++)
        soup->x0[3 * (size_t)far[side]] = soup->x1[3 * (size_t)far[side]] = side ? 1e3 : -1e3;
    broad_phase *const broad = make_trees(&heap, soup, BROAD_PHASE_REFIT);
    double const largest = broad_phase_get_tables(broad)->largest_point;
    for (int build = 0; build < 3; build++) {
        assert_true(broad_phase_get_tables(broad)->largest_point == largest);
        assert_true(largest == broad->trees[1].largest && largest > 1.1 * broad->trees[0].largest);
        assert_int_equal(build_trees(broad, &soup->set, soup->x0, soup->x1, 0.02, 1), TULLE_OK);
    }
    broad_phase_destroy(broad);
    free_scene(&heap, soup);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(the_largest_point_is_kept)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
