/* Two layers of one cloth, 0.5 mm apart and joined at the rim: they are near to each other at rest,
 * folded by half a turn, and far from each other along the surface. They lie still without forces,
 * and on a table. */
#include "support/small_world.h"
#include "support/test_support.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

#define STEP (1.0 / 90.0)
#define GAP 5e-4
enum { SIDE = 11, LAYER = SIDE * SIDE, RIM = 4 * (SIDE - 1) };

typedef struct joined_layers {
    double positions[3 * 2 * LAYER];
    uint32_t triangles[3 * (4 * (SIDE - 1) * (SIDE - 1) + 2 * RIM)];
    tulle_mesh mesh;
} joined_layers;

static void add_triangle(joined_layers *to, uint32_t a, uint32_t b, uint32_t c) {
    uint32_t *const t = to->triangles + 3 * to->mesh.triangle_count++;
    t[0] = a, t[1] = b, t[2] = c;
}

/* The grid vertex k of a walk around the rim, seen from above against the clock. */
static uint32_t walk_rim(uint32_t k) {
    uint32_t const last = SIDE - 1, at = k % last;
    switch (k / last % 4) {
    case 0: return at;
    case 1: return SIDE * at + last;
    case 2: return SIDE * last + last - at;
    default: return SIDE * (last - at);
    }
}

/* The rim is a strip as high as the gap or, with a shared rim, one line of vertices half-way up. */
static void make_layers(joined_layers *layers, bool has_shared_rim, double z) {
    uint32_t used[2 * LAYER], count = 0;
    memset(layers, 0, sizeof *layers);
    for (uint32_t layer = 0; layer < 2; layer++)
        for (uint32_t i = 0; i < LAYER; i++) {
            uint32_t const x = i % SIDE, y = i / SIDE;
            bool const is_rim = x == 0 || y == 0 || x == SIDE - 1 || y == SIDE - 1;
            if (is_rim && has_shared_rim && layer == 1) {
                used[LAYER + i] = used[i];
                continue;
            }
            double *const p = layers->positions + 3 * count;
            p[0] = 0.02 * x - 0.1, p[1] = 0.02 * y - 0.1;
            p[2] = z + (is_rim && has_shared_rim ? 0.5 : layer) * GAP;
            used[LAYER * layer + i] = count++;
        }
    for (uint32_t layer = 0; layer < 2; layer++)
        for (uint32_t y = 0; y + 1 < SIDE; y++)
            for (uint32_t x = 0; x + 1 < SIDE; x++) {
                const uint32_t *const a = used + LAYER * layer + SIDE * y + x;
                uint32_t quad[4] = {a[0], a[1], a[SIDE + 1], a[SIDE]};
                /* diagonals end at the corners of the sheet: none has all three vertices of a
                 * triangle on the rim */
                if ((x < SIDE / 2) != (y < SIDE / 2)) {
                    uint32_t const first = quad[0];
                    memmove(quad, quad + 1, 3 * sizeof *quad);
                    quad[3] = first;
                }
                size_t const turn = layer == 0 ? 2 : 0; /* the lower layer looks down */
                add_triangle(layers, quad[0], quad[1 + turn / 2], quad[2 - turn / 2]);
                add_triangle(layers, quad[0], quad[2 + turn / 2], quad[3 - turn / 2]);
            }
    for (uint32_t k = 0; k < RIM && !has_shared_rim; k++) {
        uint32_t const a = used[walk_rim(k)], b = used[walk_rim(k + 1)];
        uint32_t const up_a = used[LAYER + walk_rim(k)], up_b = used[LAYER + walk_rim(k + 1)];
        add_triangle(layers, a, b, up_b);
        add_triangle(layers, a, up_b, up_a);
    }
    layers->mesh.positions = layers->positions;
    layers->mesh.triangles = layers->triangles;
    layers->mesh.vertex_count = count;
}

typedef struct rest {
    double moved;   /* [m] the most of all vertices, from the start */
    double slowest; /* [m] the most in the last step */
    double elastic; /* [J] at the end */
} rest;

static rest run(joined_layers *layers, double gravity, const tulle_mesh *table, double thickness,
                int steps) {
    tulle_world_def def = tulle_world_def_default();
    def.threads = 1;
    def.gravity[2] = -gravity;
    tulle_world *world = NULL;
    assert_int_equal(tulle_world_create(&def, &world, NULL), TULLE_OK);
    tulle_cloth_def cloth = tulle_cloth_def_default();
    cloth.mesh = tulle_mesh_get_view(&layers->mesh);
    cloth.thickness = thickness;
    tulle_error error = {0};
    if (tulle_world_add_cloth(world, &cloth, NULL, &error) != TULLE_OK)
        fail_msg("%s", error.message);
    if (table) small_add_obstacle(world, table);
    rest result = {0};
    double before[3 * 2 * LAYER];
    for (int i = 0; i < steps; i++) {
        const double *const x = tulle_cloth_get_positions(world, (tulle_cloth_id){0, 1}, NULL);
        memcpy(before, i ? x : layers->positions, 3 * layers->mesh.vertex_count * sizeof *before);
        tulle_step_report report;
        if (tulle_world_step(world, STEP, &report, &error) != TULLE_OK)
            fail_msg("step %d: %s", i, error.message);
        result.elastic = report.elastic_energy;
    }
    const double *const x = tulle_cloth_get_positions(world, (tulle_cloth_id){0, 1}, NULL);
    for (size_t i = 0; i < 3 * layers->mesh.vertex_count; i++) {
        result.moved = fmax(result.moved, fabs(x[i] - layers->positions[i]));
        result.slowest = fmax(result.slowest, fabs(x[i] - before[i]));
    }
    assert_int_equal(small_judge(world, &layers->mesh, 1, table, table ? 1 : 0), 0);
    tulle_world_destroy(world);
    print_message("moved %.3g m, %.3g m in the last step, elastic %.3g J\n", result.moved,
                  result.slowest, result.elastic);
    return result;
}

static void without_forces_nothing_moves(void **state) {
    (void)state;
    double const thickness[] = {0.0, 1e-3, 4e-4};
    for (int is_shared = 0; is_shared < 2; is_shared++)
        for (size_t k = 0; k < sizeof thickness / sizeof *thickness; k++) {
            joined_layers layers;
            make_layers(&layers, is_shared, 1.0);
            rest const found = run(&layers, 0.0, NULL, thickness[k], 90);
            assert_true(found.moved < 1e-12);
            assert_true(found.elastic < 1e-18);
        }
}

static void on_a_table_they_lie_still(void **state) {
    (void)state;
    tulle_shape_def plane = tulle_shape_def_default(TULLE_SHAPE_PLANE);
    tulle_mesh table = small_shape(plane, 0.0, 0.0, 0.0);
    for (int is_shared = 0; is_shared < 2; is_shared++) {
        joined_layers layers;
        make_layers(&layers, is_shared, 1e-3);
        rest const found = run(&layers, 9.81, &table, 1e-3, 180);
        assert_true(found.moved < 1e-3);
        assert_true(found.slowest < 1e-6);
    }
    tulle_mesh_destroy(&table);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(without_forces_nothing_moves),
        cmocka_unit_test(on_a_table_they_lie_still),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
