/* Creases: edges that are folded at rest. What hangs on them takes their angle; they count in both
 * membranes, with lengths at rest of their own, and in what a saved state must fit. */
#include "support/small_world.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

enum {
    COLUMNS = 5,
    ROWS = 4,
    VERTICES = COLUMNS * ROWS,
    TRIANGLES = 2 * (COLUMNS - 1) * (ROWS - 1)
};

/* A strip in the plane z = 0 that is folded along x = 0, and all that may differ. */
typedef struct folded_strip {
    double positions[3 * VERTICES], corners[9 * TRIANGLES];
    uint32_t triangles[3 * TRIANGLES];
    tulle_crease creases[ROWS];
    tulle_world_def world_def;
    tulle_cloth_def def;
} folded_strip;

static void make_strip(folded_strip *strip, double angle) {
    size_t count = 0;
    for (uint32_t j = 0; j < ROWS; j++)
        for (uint32_t i = 0; i < COLUMNS; i++) {
            uint32_t const v = j * COLUMNS + i;
            double const p[3] = {0.02 * ((double)i - 2.0), 0.02 * (double)j, 0.0};
            for (size_t c = 0; c < 3; c++) strip->positions[3 * v + c] = p[c];
            if (i + 1 == COLUMNS || j + 1 == ROWS) continue;
            uint32_t const cell[6] = {v, v + 1, v + COLUMNS + 1, v, v + COLUMNS + 1, v + COLUMNS};
            for (size_t k = 0; k < 6; k++) strip->triangles[count++] = cell[k];
        }
    for (uint32_t j = 0; j + 1 < ROWS; j++)
        strip->creases[j] = (tulle_crease){{j * COLUMNS + 2, (j + 1) * COLUMNS + 2}, angle};
    strip->world_def = tulle_world_def_default();
    strip->world_def.gravity[2] = 0.0;
    strip->def = tulle_cloth_def_default();
    strip->def.mesh = (tulle_mesh_view){.positions = strip->positions,
                                        .triangles = strip->triangles,
                                        .vertex_count = VERTICES,
                                        .triangle_count = TRIANGLES};
    strip->def.material.air_damping = 5.0;
    strip->def.creases = strip->creases;
    strip->def.crease_count = ROWS - 1;
}

static tulle_world *start_strip(const folded_strip *strip, tulle_cloth_id *id) {
    tulle_world *world = NULL;
    tulle_error error = {0};
    assert_int_equal(tulle_world_create(&strip->world_def, &world, &error), TULLE_OK);
    if (tulle_world_add_cloth(world, &strip->def, id, &error)) fail_msg("%s", error.message);
    if (tulle_world_start(world, &error)) fail_msg("%s", error.message);
    return world;
}

/* The angle [rad] to which the strip folds; positive: a ridge as seen from above. */
static double settle(const folded_strip *strip) {
    tulle_cloth_id id;
    tulle_world *const world = start_strip(strip, &id);
    for (int i = 0; i < 300; i++)
        assert_int_equal(tulle_world_step(world, 1.0 / 90.0, NULL, NULL), TULLE_OK);
    const double *const x = tulle_cloth_get_positions(world, id, NULL);
    uint32_t const fold = COLUMNS + 2; /* in the second row */
    double sides[2][3], dot = 0.0, sizes[2] = {0.0, 0.0};
    for (size_t c = 0; c < 3; c++) {
        sides[0][c] = x[3 * fold + c] - x[3 * (fold - 2) + c];
        sides[1][c] = x[3 * (fold + 2) + c] - x[3 * fold + c];
        dot += sides[0][c] * sides[1][c];
        for (size_t k = 0; k < 2; k++) sizes[k] += sides[k][c] * sides[k][c];
    }
    double const angle = acos(dot / sqrt(sizes[0] * sizes[1]));
    double const rise = sides[0][0] * sides[1][2] - sides[0][2] * sides[1][0];
    tulle_world_destroy(world);
    return rise < 0.0 ? angle : -angle;
}

static void expect_fold(const folded_strip *strip, double angle) {
    double const found = settle(strip);
    if (fabs(found - angle) > 0.02) fail_msg("folds to %g, not to %g", found, angle);
}

static void cloth_folds_to_its_creases(void **state) {
    (void)state;
    static double const angles[] = {0.5, -0.5, 1.5707963267948966, -2.0};
    for (size_t i = 0; i < sizeof angles / sizeof angles[0]; i++) {
        folded_strip strip;
        make_strip(&strip, angles[i]);
        strip.world_def.membrane = TULLE_MEMBRANE_SPRINGS;
        expect_fold(&strip, angles[i]);
        strip.world_def.membrane = TULLE_MEMBRANE_WOVEN;
        expect_fold(&strip, angles[i]);
        strip.def.has_flat_rest = 1;
        expect_fold(&strip, angles[i]);
    }
}

/* A crease is a ridge or a valley as its triangles go round, in whatever order they are listed. */
static void order_of_triangles_does_not_turn_a_crease(void **state) {
    (void)state;
    for (int woven = 0; woven < 2; woven++)
        for (int order = 0; order < 2; order++) {
            folded_strip strip;
            make_strip(&strip, 1.0);
            strip.world_def.membrane = woven ? TULLE_MEMBRANE_WOVEN : TULLE_MEMBRANE_SPRINGS;
            for (size_t t = 0; order && 2 * t < TRIANGLES; t++)
                for (size_t k = 0; k < 3; k++) {
                    uint32_t *const a = &strip.triangles[3 * t + k];
                    uint32_t *const b = &strip.triangles[3 * (TRIANGLES - 1 - t) + k];
                    uint32_t const kept = *a;
                    *a = *b, *b = kept;
                }
            expect_fold(&strip, 1.0);
        }
}

/* With triangles at rest of their own, and against a rest shape that is folded otherwise. */
static void creases_go_before_the_rest_shape(void **state) {
    (void)state;
    folded_strip strip;
    make_strip(&strip, 1.0);
    strip.world_def.membrane = TULLE_MEMBRANE_WOVEN;
    for (size_t i = 0; i < 3 * TRIANGLES; i++)
        for (size_t c = 0; c < 3; c++)
            strip.corners[3 * i + c] = strip.positions[3 * strip.triangles[i] + c];
    strip.def.rest_corners = strip.corners;
    expect_fold(&strip, 1.0);
    strip.def.rest_corners = NULL;
    double rest[3 * VERTICES];
    for (size_t v = 0; v < VERTICES; v++) {
        double const x = strip.positions[3 * v], turned = x > 0.0 ? x : 0.0;
        rest[3 * v] = x - turned + turned * cos(1.2);
        rest[3 * v + 1] = strip.positions[3 * v + 1];
        rest[3 * v + 2] = turned * sin(1.2); /* a valley */
    }
    strip.def.rest_positions = rest;
    expect_fold(&strip, 1.0);
    strip.def.crease_count = 0;
    expect_fold(&strip, -1.2);
}

static void the_last_crease_of_an_edge_counts(void **state) {
    (void)state;
    folded_strip strip;
    make_strip(&strip, 0.8);
    tulle_crease creases[2 * ROWS];
    for (size_t i = 0; i + 1 < ROWS; i++) {
        creases[i] =
            (tulle_crease){{strip.creases[i].vertices[1], strip.creases[i].vertices[0]}, -2.0};
        creases[ROWS - 1 + i] = strip.creases[i];
    }
    creases[2 * ROWS - 2] = (tulle_crease){{0, 1}, 3.0}; /* on the border: it means nothing */
    strip.def.creases = creases;
    strip.def.crease_count = 2 * ROWS - 1;
    expect_fold(&strip, 0.8);
}

static void creases_without_an_edge_are_refused(void **state) {
    (void)state;
    folded_strip strip;
    make_strip(&strip, 0.8);
    strip.creases[1] = (tulle_crease){{0, VERTICES - 1}, 0.5};
    strip.def.name = "strip";
    tulle_world *world = NULL;
    tulle_cloth_id id;
    tulle_error error = {0};
    assert_int_equal(tulle_world_create(&strip.world_def, &world, &error), TULLE_OK);
    assert_int_equal(tulle_world_add_cloth(world, &strip.def, &id, &error), TULLE_OK);
    assert_int_equal(tulle_world_start(world, &error), TULLE_ERROR_INVALID_ARGUMENT);
    assert_string_equal(error.message,
                        "'strip': crease 1 lies between vertices 0 and 19, which no edge joins");
    tulle_world_destroy(world);
}

static void saved_states_know_creases(void **state) {
    (void)state;
    folded_strip strip;
    make_strip(&strip, 0.8);
    tulle_cloth_id id;
    tulle_error error = {0};
    tulle_world *const first = start_strip(&strip, &id);
    strip.creases[0].angle = 0.9;
    tulle_world *const second = start_strip(&strip, &id);
    void *saved = NULL;
    size_t size = 0;
    assert_int_equal(tulle_world_save_state(first, &saved, &size, &error), TULLE_OK);
    assert_int_equal(tulle_world_load_state(first, saved, size, &error), TULLE_OK);
    assert_int_not_equal(tulle_world_load_state(second, saved, size, &error), TULLE_OK);
    tulle_world_free_state(first, saved, size);
    tulle_world_destroy(first);
    tulle_world_destroy(second);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cloth_folds_to_its_creases),
        cmocka_unit_test(order_of_triangles_does_not_turn_a_crease),
        cmocka_unit_test(creases_go_before_the_rest_shape),
        cmocka_unit_test(the_last_crease_of_an_edge_counts),
        cmocka_unit_test(creases_without_an_edge_are_refused),
        cmocka_unit_test(saved_states_know_creases),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
