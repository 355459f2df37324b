/* Axes and units: turning is exact and turns back; lengths are scaled by the ratio that the units
 * have, correctly rounded where they are multiples; triangles keep their orientation. */
#include "app/cli/axes.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

static const double values[] = {0.0,  -0.0,   1.0,        -1.0, 1.0 / 3.0, 0.1,
                                1e-3, 12.345, -9876.5432, 7e88, 5e-324,    0x1.fffffffffffffp1023};
enum { VALUE_COUNT = sizeof values / sizeof values[0] };

static axes_change make_change(const char *from_up, const char *from_unit, const char *up,
                               const char *unit) {
    return axes_change_make((axes_frame){from_up, from_unit}, (axes_frame){up, unit});
}

static void expect_bits(double found, double expected) {
    assert_memory_equal(&found, &expected, sizeof found);
}

static void turning_is_exact(void **unused) {
    (void)unused;
    axes_change const to_y = make_change("z", "m", "y", "m");
    axes_change const to_z = make_change("y", "m", "z", "m");
    for (int i = 0; i < VALUE_COUNT * VALUE_COUNT; i++) {
        double const x = values[i % VALUE_COUNT], y = values[i / VALUE_COUNT], z = 0.7;
        double point[3] = {x, y, z};
        axes_apply(&to_y, point, 1);
        expect_bits(point[0], x);
        expect_bits(point[1], z);
        expect_bits(point[2], -y);
        axes_apply(&to_z, point, 1);
        expect_bits(point[0], x);
        expect_bits(point[1], y);
        expect_bits(point[2], z);
    }
    /* Up is up: what was over the origin is so afterwards. */
    double over[3] = {0, 0, 2};
    axes_apply(&to_y, over, 1);
    assert_true(over[1] == 2.0);
}

/* A turn and no mirror: the product of three edges keeps its sign. */
static void orientation_is_kept(void **unused) {
    (void)unused;
    static const char *const ups[] = {"y", "z"};
    for (int k = 0; k < 4; k++) {
        double p[9] = {1, 2, 3, -2, 5, 1, 4, 0, -7};
        double determinants[2];
        for (int i = 0; i < 2; i++) {
            determinants[i] = p[0] * (p[4] * p[8] - p[5] * p[7]) -
                              p[1] * (p[3] * p[8] - p[5] * p[6]) +
                              p[2] * (p[3] * p[7] - p[4] * p[6]);
            axes_change const change = make_change(ups[k % 2], "m", ups[k / 2], "m");
            axes_apply(&change, p, 3);
        }
        assert_true(determinants[0] == determinants[1]);
    }
}

static void nothing_asked_changes_nothing(void **unused) {
    (void)unused;
    for (int k = 0; k < 10; k++) {
        const char *const unit = axes_unit_choices[k / 2], *const up = axes_up_choices[k % 2];
        axes_change const change = make_change(up, unit, up, unit);
        for (int i = 0; i < VALUE_COUNT; i++) {
            double point[3] = {values[i], values[i], values[i]};
            axes_apply(&change, point, 1);
            for (int axis = 0; axis < 3; axis++) expect_bits(point[axis], values[i]);
        }
    }
}

static void lengths_follow_the_units(void **unused) {
    (void)unused;
    static const struct {
        const char *from, *to;
        double multiplier, divisor;
    } cases[] = {{"m", "cm", 100, 1},    {"m", "mm", 1000, 1},   {"cm", "m", 1, 100},
                 {"mm", "m", 1, 1000},   {"cm", "mm", 10, 1},    {"ft", "in", 12, 1},
                 {"in", "ft", 1, 12},    {"in", "mm", 127, 5},   {"in", "m", 127, 5000},
                 {"ft", "m", 381, 1250}, {"m", "in", 5000, 127}, {"m", "ft", 1250, 381}};
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        axes_change const change = make_change("y", cases[k].from, "y", cases[k].to);
        for (int i = 0; i < VALUE_COUNT; i++) {
            double point[3] = {values[i], 1.0, -2.5};
            axes_apply(&change, point, 1);
            expect_bits(point[0], values[i] * cases[k].multiplier / cases[k].divisor);
        }
    }
    axes_change const both = make_change("z", "m", "y", "cm");
    double point[3] = {1, 2, 3};
    axes_apply(&both, point, 1);
    expect_bits(point[0], 100.0);
    expect_bits(point[1], 300.0);
    expect_bits(point[2], -200.0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(turning_is_exact),
        cmocka_unit_test(orientation_is_kept),
        cmocka_unit_test(nothing_asked_changes_nothing),
        cmocka_unit_test(lengths_follow_the_units),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
