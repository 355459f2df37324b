/* What is said of a start that could not be untangled: pairs of surfaces with the numbers of their
 * pairs of triangles, lines of intersection, pins in obstacles. */
#include "support/pins.h"
#include "support/small_world.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

typedef struct surface_pair {
    uint32_t a, b;
    int count;
} surface_pair;

static int compare_pairs(const void *one, const void *two) {
    const surface_pair *const x = one, *const y = two;
    if (x->count != y->count) return y->count - x->count;
    return x->a != y->a ? (int)x->a - (int)y->a : (int)x->b - (int)y->b;
}

/* Writes what the world's list of intersections says, as the message should. */
static void write_expected(tulle_world *world, const char *const *names, char *text, size_t size) {
    surface_pair pairs[16] = {0};
    size_t left = 0, count = 0, length = 0;
    const tulle_intersection *const list = tulle_world_get_intersections(world, &left);
    for (size_t i = 0; i < left; i++) {
        size_t at = 0;
        while (at < count && (pairs[at].a != list[i].object_a || pairs[at].b != list[i].object_b))
            at++;
        assert_true(at < 16);
        if (at == count) count++;
        pairs[at] = (surface_pair){list[i].object_a, list[i].object_b, pairs[at].count + 1};
    }
    qsort(pairs, count, sizeof *pairs, compare_pairs);
    assert_true(count > 3);
    for (size_t i = 0; i < 3; i++) {
        bool const is_self = pairs[i].a == pairs[i].b;
        length += (size_t)snprintf(text + length, size - length, "%s%d of '%s' with ",
                                   i ? ", " : "", pairs[i].count, names[pairs[i].a]);
        length += (size_t)snprintf(text + length, size - length, is_self ? "itself" : "'%s'",
                                   names[pairs[i].b]);
    }
    (void)snprintf(text + length, size - length, ", %zu other %s of surfaces", count - 3,
                   count == 4 ? "pair" : "pairs");
}

/* Sheets through one another, and in a box: the message counts their pairs as the list does, tells
 * the pairs of surfaces that have most, the lines, and the pins in the box. */
static void check_message(bool has_box, const char *lines) {
    static const char *const names[] = {"cloth 0", "cloth 1", "cloth 2", "obstacle 0"};
    tulle_world_def def = tulle_world_def_default();
    def.start_intersections = TULLE_START_UNTANGLE;
    def.untangle_limit = 1;
    tulle_world *world = NULL;
    assert_int_equal(tulle_world_create(&def, &world, NULL), TULLE_OK);
    tulle_mesh flat = small_sheet(0.3, 13, 0.0);
    tulle_shape_def shape = tulle_shape_def_default(TULLE_SHAPE_BOX);
    shape.size[0] = shape.size[1] = shape.size[2] = 0.1;
    tulle_mesh box = small_shape(shape, 0.0, 0.16, 0.0);
    for (int k = 0; k < 3; k++) {
        tulle_mesh sheet = small_sheet(0.3, 13, 0.0);
        uint32_t held[2], held_count = 0;
        for (uint32_t v = 0; v < sheet.vertex_count; v++) {
            double *const p = sheet.positions + 3 * v, x = p[0], t = 1.3 * x / 0.15;
            if (k == 0) p[2] = 0.003 * x + 0.005 * p[1];
            if (k == 1) p[0] = -0.062 + 0.1 * p[1], p[2] = x + 0.0041; /* across the first */
            if (k == 2) { /* a loop through itself and both */
                p[0] = 0.09 * t * (t * t - 1.0) + 0.004 * p[1];
                p[2] = 0.09 * t * t - 0.0537 + 0.013 * p[1];
            }
            p[1] += 0.0037 * k + 0.0023 * k * x;
            if (k == 0 && fabs(x) < 0.03 && p[1] > 0.14 && held_count < 2) held[held_count++] = v;
        }
        tulle_pin const pin = make_pin(held, held_count, (double)INFINITY);
        tulle_cloth_def cloth = tulle_cloth_def_default();
        cloth.mesh = tulle_mesh_get_view(&sheet);
        cloth.rest_positions = flat.positions;
        cloth.pins = &pin;
        cloth.pin_count = k == 0;
        assert_int_equal(held_count, k == 0 ? 2 : 0);
        assert_int_equal(tulle_world_add_cloth(world, &cloth, NULL, NULL), TULLE_OK);
        tulle_mesh_destroy(&sheet);
    }
    if (has_box) (void)small_add_obstacle(world, &box);
    tulle_error error = {0};
    assert_int_equal(tulle_world_start(world, &error), TULLE_ERROR_INTERSECTING_START);
    char expected[512];
    write_expected(world, names, expected, sizeof expected);
    print_message("%s\n", expected);
    assert_non_null(strstr(error.message, expected));
    assert_int_equal(strstr(error.message, "; 2 pinned vertices lie inside an obstacle, ") != NULL,
                     has_box);
    print_message("%.100s\n", error.message);
    assert_non_null(strstr(error.message, lines));
    tulle_world_destroy(world);
    tulle_mesh_destroy(&box);
    tulle_mesh_destroy(&flat);
}

static void the_message_tells_what_the_list_holds(void **state) {
    (void)state;
    check_message(false, "at the start; in 5 lines: ");
    check_message(true, "at the start; in 9 lines: ");
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(the_message_tells_what_the_list_holds)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
