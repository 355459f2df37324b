/* How deep triangles lie in each other: overlaps that are known, and random triangles beside moves
 * in many directions, none of which parts them with less. */
#include "tulle/check.h"
#include "world/start/start.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

static vec3 at(double x, double y, double z) { return vec3_make(x, y, z); }

static void assert_near(double value, double wanted) {
    if (!(fabs(value - wanted) < 1e-12)) fail_msg("%.17g, not %.17g", value, wanted);
}

/* An upright triangle that pokes 0.03 m through a level one, far from the origin. */
static void known_overlaps(void **state) {
    (void)state;
    vec3 const level[3] = {at(999.0, -1.0, 0.0), at(1001.0, -1.0, 0.0), at(1000.0, 2.0, 0.0)};
    vec3 const upright[3] = {at(1000.0, 0.0, -0.03), at(1000.1, 0.0, 1.0), at(999.9, 0.0, 1.0)};
    for (int order = 0; order < 2; order++) {
        triangle_overlap const poked =
            order ? measure_overlap(upright, level) : measure_overlap(level, upright);
        assert_near(poked.depth, 0.03);
        assert_near(poked.position.x, 1000.0);
        assert_near(poked.position.y, 0.0);
        assert_near(poked.position.z, 0.0);
    }
    vec3 const in_plane[3] = {at(999.5, -0.5, 0.0), at(1000.5, -0.5, 0.0), at(1000.0, 0.5, 0.0)};
    assert_near(measure_overlap(level, in_plane).depth, 0.0);
    vec3 const corner[3] = {at(1000.0, 0.0, 0.0), at(1000.1, 0.0, 1.0), at(999.9, 0.0, 1.0)};
    assert_near(measure_overlap(level, corner).depth, 0.0);
}

static double random_number(uint64_t *seed) {
    *seed = *seed * 6364136223846793005u + 1442695040888963407u;
    return (double)(*seed >> 11) * 0x1p-53 - 0.5;
}

static int intersects_after_move(const vec3 a[3], const vec3 b[3], vec3 move) {
    double positions[18];
    uint32_t const first[3] = {0, 1, 2}, second[3] = {3, 4, 5};
    for (size_t k = 0; k < 3; k++) {
        vec3_store(positions, k, vec3_add(a[k], move));
        vec3_store(positions, 3 + k, b[k]);
    }
    return tulle_check_triangle_pair(positions, first, second, 0);
}

static void no_shorter_move_parts_random_triangles(void **state) {
    (void)state;
    uint64_t seed = 5;
    int crossing_count = 0, tight_count = 0;
    for (int trial = 0; trial < 2000; trial++) {
        vec3 a[3], b[3];
        for (int k = 0; k < 3; k++) {
            a[k] = at(random_number(&seed), random_number(&seed), random_number(&seed));
            b[k] = at(random_number(&seed), random_number(&seed), random_number(&seed));
        }
        if (!intersects_after_move(a, b, at(0.0, 0.0, 0.0))) continue;
        crossing_count++;
        double const depth = measure_overlap(a, b).depth;
        int is_tight = 0;
        for (int way = 0; way < 400; way++) {
            vec3 const direction = vec3_normalize(
                at(random_number(&seed), random_number(&seed), random_number(&seed)));
            assert_true(intersects_after_move(a, b, vec3_scale(direction, 0.999 * depth)));
            is_tight |= !intersects_after_move(a, b, vec3_scale(direction, 1.25 * depth));
        }
        tight_count += is_tight;
    }
    assert_true(crossing_count > 100);
    assert_true(tight_count > 9 * crossing_count / 10);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(known_overlaps),
        cmocka_unit_test(no_shorter_move_parts_random_triangles),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
