/* Attachments (tulle/attach.h) against closed forms, Newton's laws and the exact judge. */
#include "tulle/attach.h"
#include "tulle/live.h"

#include "base/hash.h"
#include "support/small_world.h"
#include "support/test_support.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static const double STEP = 1.0 / 64.0; /* [s] */
static const double G = 9.81;          /* [m/s^2] */

static void expect(tulle_status wanted, tulle_status status, const tulle_error *error) {
    if (status != wanted)
        fail_msg("status %d, not %d: %s", (int)status, (int)wanted, error->message);
}

static void expect_near(const char *what, double wanted, double found, double tolerance) {
    if (!(fabs(found - wanted) <= tolerance))
        fail_msg("%s is %.12g, not %.12g +- %g", what, found, wanted, tolerance);
}

static tulle_world *make_world(int threads) {
    tulle_world_def def = tulle_world_def_default();
    def.threads = threads;
    def.wind.drag_coefficient = 0.0;
    tulle_world *world;
    tulle_error error = {0};
    expect(TULLE_OK, tulle_world_create(&def, &world, &error), &error);
    return world;
}

static void start(tulle_world *world) {
    tulle_error error = {0};
    expect(TULLE_OK, tulle_world_start(world, &error), &error);
}

static void step(tulle_world *world) {
    tulle_error error = {0};
    expect(TULLE_OK, tulle_world_step(world, STEP, NULL, &error), &error);
}

static tulle_attachment_id attach(tulle_world *world, const tulle_attachment_def *def) {
    tulle_attachment_id id = 0;
    tulle_error error = {0};
    expect(TULLE_OK, tulle_world_attach(world, def, &id, &error), &error);
    return id;
}

/* One triangle, whose corners have the same mass. */
static tulle_mesh one_triangle(double z) {
    double const corners[9] = {0.0, 0.0, z, 0.2, 0.0, z, 0.1, 0.2, z};
    tulle_mesh mesh;
    tulle_error error = {0};
    expect(TULLE_OK, tulle_mesh_create(3, 1, &mesh, &error), &error);
    memcpy(mesh.positions, corners, sizeof corners);
    for (uint32_t i = 0; i < 3; i++) mesh.triangles[i] = i;
    return mesh;
}

static const uint32_t THREE[3] = {0, 1, 2};

/* ---- points ---- */

/* A triangle on three springs swings as implicit Euler has it: v' = (v + h (g - k z / m)) / (1 +
 * h^2 k / m). */
static void springs_swing_as_the_integrator_says(void **state) {
    (void)state;
    tulle_mesh mesh = one_triangle(0.0);
    tulle_world *const world = make_world(1);
    tulle_cloth_def def = tulle_cloth_def_default();
    def.mesh = tulle_mesh_get_view(&mesh);
    def.material.air_damping = 0.0;
    tulle_cloth_id cloth;
    tulle_error error = {0};
    expect(TULLE_OK, tulle_world_add_cloth(world, &def, &cloth, &error), &error);
    start(world);
    double const mass = def.material.area_density * 0.02 / 3.0, k = 2.0;
    tulle_attachment_def tie = tulle_attachment_def_default();
    tie.cloth = cloth;
    tie.vertices = THREE;
    tie.vertex_count = 3;
    tie.points = mesh.positions;
    tie.stiffness = k;
    tulle_attachment_id const id = attach(world, &tie);
    double z = 0.0, v = 0.0;
    for (int i = 0; i < 100; i++) {
        step(world);
        v = (v - STEP * G - STEP * k / mass * z) / (1.0 + STEP * STEP * k / mass);
        z += STEP * v;
        const double *const x = tulle_cloth_get_positions(world, cloth, NULL);
        for (int p = 0; p < 3; p++) expect_near("height", z, x[3 * p + 2], 1e-7);
        tulle_attachment_report const report = tulle_attachment_get_report(world, id);
        assert_int_equal(report.held_count, 3);
        expect_near("force", -3.0 * k * z, report.force[2], 3e-7 * k);
        expect_near("largest force", fabs(k * z), report.largest_force, 1e-7 * k);
    }
    assert_true(fabs(z + mass * G / k) < 0.1 * mass * G / k); /* it has come to rest, nearly */
    tulle_world_destroy(world);
    tulle_mesh_destroy(&mesh);
}

/* Rigid ones hold the place to the bit, go where the points go, and carry the weight. */
static void points_lead_rigidly(void **state) {
    (void)state;
    tulle_mesh mesh = one_triangle(0.0);
    tulle_world *const world = make_world(1);
    tulle_cloth_def def = tulle_cloth_def_default();
    def.mesh = tulle_mesh_get_view(&mesh);
    def.material.air_damping = 0.0;
    tulle_cloth_id cloth;
    tulle_error error = {0};
    expect(TULLE_OK, tulle_world_add_cloth(world, &def, &cloth, &error), &error);
    start(world);
    tulle_attachment_def tie = tulle_attachment_def_default();
    tie.cloth = cloth;
    tie.vertices = THREE;
    tie.vertex_count = 3;
    tie.points = mesh.positions;
    tulle_attachment_id const id = attach(world, &tie);
    double const weight = tulle_cloth_def_default().material.area_density * 0.02 * G;
    for (int i = 0; i < 5; i++) step(world);
    const double *x = tulle_cloth_get_positions(world, cloth, NULL);
    for (int k = 0; k < 9; k++) assert_true(x[k] == mesh.positions[k]);
    tulle_attachment_report const report = tulle_attachment_get_report(world, id);
    expect_near("weight", weight, report.force[2], 1e-9 * weight);
    expect_near("weight of one", weight / 3.0, report.largest_force, 1e-9 * weight);

    double moved[9];
    for (int k = 0; k < 9; k++) moved[k] = mesh.positions[k] + (k % 3 == 0 ? 0.0625 : 0.0);
    expect(TULLE_OK, tulle_attachment_set_points(world, id, moved, 3, &error), &error);
    step(world);
    x = tulle_cloth_get_positions(world, cloth, NULL);
    const double *const v = tulle_cloth_get_velocities(world, cloth, NULL);
    for (int k = 0; k < 9; k++) expect_near("moved", moved[k], x[k], 1e-15);
    expect_near("speed", 0.0625 / STEP, v[0], 1e-12);
    step(world);
    for (int k = 0; k < 9; k++) expect_near("stays", moved[k], x[k], 1e-15);

    expect(TULLE_OK, tulle_attachment_release(world, id, &error), &error);
    assert_int_equal(tulle_attachment_get_report(world, id).held_count, 0);
    step(world);
    x = tulle_cloth_get_positions(world, cloth, NULL);
    expect_near("falls", -STEP * STEP * G, x[2], 1e-7);
    expect(TULLE_OK, tulle_attachment_release(world, id, &error), &error); /* again: nothing */
    tulle_world_destroy(world);
    tulle_mesh_destroy(&mesh);
}

/* A third of the weight breaks each vertex off, not before. */
static void breaks_at_its_force(void **state) {
    (void)state;
    for (int is_rigid = 0; is_rigid < 2; is_rigid++) {
        tulle_mesh mesh = one_triangle(0.0);
        tulle_world *const world = make_world(1);
        tulle_cloth_id const cloth = small_add_cloth(world, &mesh);
        start(world);
        double const third = tulle_cloth_def_default().material.area_density * 0.02 * G / 3.0;
        tulle_attachment_def tie = tulle_attachment_def_default();
        tie.cloth = cloth;
        tie.vertices = THREE;
        tie.vertex_count = 3;
        tie.points = mesh.positions;
        tie.break_force = 1.0001 * third;
        if (!is_rigid) tie.stiffness = 1e6; /* so stiff that it does not swing over */
        tulle_attachment_id const id = attach(world, &tie);
        for (int i = 0; i < 20; i++) step(world);
        assert_int_equal(tulle_attachment_get_report(world, id).held_count, 3);
        assert_true(tulle_attachment_holds(world, id, 2));
        assert_string_equal(tulle_world_last_message(world), "");
        tulle_error error = {0};
        double const more[3] = {0.0, 0.0, -1.0002 * G};
        expect(TULLE_OK, tulle_world_set_gravity(world, more, &error), &error);
        step(world);
        assert_int_equal(tulle_attachment_get_report(world, id).held_count, 0);
        assert_false(tulle_attachment_holds(world, id, 2));
        assert_non_null(strstr(tulle_world_last_message(world), "breaks off at 3 vertices"));
        tulle_world_destroy(world);
        tulle_mesh_destroy(&mesh);
    }
}

/* ---- obstacles ---- */

enum { SIDE = 9, COUNT = SIDE * SIDE };

/* A plate that turns, slides and is sheared, under a sheet of which one border is attached. */
static void border_follows_a_deforming_plate(void **state) {
    (void)state;
    uint64_t hashes[2];
    for (int run = 0; run < 2; run++) {
        tulle_world *const world = make_world(run == 0 ? 1 : 2);
        tulle_mesh sheet = small_sheet(0.25, SIDE, 0.0);
        tulle_shape_def shape = tulle_shape_def_default(TULLE_SHAPE_BOX);
        shape.size[0] = shape.size[1] = 0.5;
        shape.size[2] = 0.05;
        tulle_mesh plate = small_shape(shape, 0.0, 0.0, -0.03);
        tulle_cloth_id const cloth = small_add_cloth(world, &sheet);
        tulle_obstacle_def def = tulle_obstacle_def_default();
        def.mesh = tulle_mesh_get_view(&plate);
        def.drive = TULLE_DRIVE_DEFORMING;
        tulle_obstacle_id obstacle;
        tulle_error error = {0};
        expect(TULLE_OK, tulle_world_add_obstacle(world, &def, &obstacle, &error), &error);
        start(world);
        uint32_t border[SIDE];
        for (uint32_t i = 0; i < SIDE; i++) border[i] = i;
        tulle_attachment_def tie = tulle_attachment_def_default();
        tie.cloth = cloth;
        tie.vertices = border;
        tie.vertex_count = SIDE;
        tie.obstacle = obstacle;
        tulle_attachment_id const id = attach(world, &tie);
        size_t const n = plate.vertex_count;
        double *const to = malloc(3 * n * sizeof(double));
        assert_non_null(to);
        for (int i = 1; i <= 48; i++) {
            double const a = 0.02 * i, shear = 0.004 * i, x = 0.01 * i;
            for (size_t v = 0; v < n; v++) {
                const double *const p = plate.positions + 3 * v;
                to[3 * v] = cos(a) * p[0] - sin(a) * p[2] + x + shear * p[1];
                to[3 * v + 1] = p[1];
                to[3 * v + 2] = sin(a) * p[0] + cos(a) * p[2];
            }
            expect(TULLE_OK,
                   tulle_obstacle_set_next_positions(world, obstacle, to, n, TULLE_TRAVEL_MOVE,
                                                     &error),
                   &error);
            step(world);
            /* the plate is affine, so its top stays a plane: each vertex 5 mm above its foot */
            const double *const now = tulle_cloth_get_positions(world, cloth, NULL);
            double const along[3] = {cos(a), 0.0, sin(a)}, beside[3] = {shear, 1.0, 0.0};
            double up[3] = {along[1] * beside[2] - along[2] * beside[1],
                            along[2] * beside[0] - along[0] * beside[2],
                            along[0] * beside[1] - along[1] * beside[0]};
            double const size = sqrt(up[0] * up[0] + up[1] * up[1] + up[2] * up[2]);
            for (size_t v = 0; v < SIDE; v++) {
                const double *const p = sheet.positions + 3 * v;
                double const foot[3] = {cos(a) * p[0] + sin(a) * 0.005 + x + shear * p[1], p[1],
                                        sin(a) * p[0] - cos(a) * 0.005};
                for (size_t k = 0; k < 3; k++)
                    expect_near("border", foot[k] + 0.005 * up[k] / size, now[3 * v + k], 1e-12);
            }
            tulle_mesh cloth_now = sheet, plate_now = plate;
            cloth_now.positions = (double *)(uintptr_t)now;
            plate_now.positions = to;
            assert_int_equal(small_judge(world, &cloth_now, 1, &plate_now, 1), 0);
        }
        assert_int_equal(tulle_attachment_get_report(world, id).held_count, SIDE);
        hashes[run] = tulle_world_get_state_hash(world);
        free(to);
        tulle_world_destroy(world);
        tulle_mesh_destroy(&sheet);
        tulle_mesh_destroy(&plate);
    }
    assert_true(hashes[0] == hashes[1]);
}

/* Vertices beyond max_distance are left out; all of them are an error. An obstacle that leaves lets
 * go. */
static void distance_and_departure(void **state) {
    (void)state;
    tulle_world *const world = make_world(1);
    tulle_mesh sheet = small_sheet(0.25, SIDE, 0.0);
    tulle_shape_def shape = tulle_shape_def_default(TULLE_SHAPE_BOX);
    shape.size[0] = shape.size[1] = shape.size[2] = 0.05;
    tulle_mesh box = small_shape(shape, 0.0, 0.0, 0.03);
    tulle_cloth_id const cloth = small_add_cloth(world, &sheet);
    tulle_obstacle_def def = tulle_obstacle_def_default();
    def.mesh = tulle_mesh_get_view(&box);
    def.disappear_time = 10.0 * STEP;
    tulle_obstacle_id obstacle;
    tulle_error error = {0};
    expect(TULLE_OK, tulle_world_add_obstacle(world, &def, &obstacle, &error), &error);
    start(world);
    uint32_t all[COUNT];
    for (uint32_t i = 0; i < COUNT; i++) all[i] = i;
    tulle_attachment_def tie = tulle_attachment_def_default();
    tie.cloth = cloth;
    tie.vertices = all;
    tie.vertex_count = COUNT;
    tie.obstacle = obstacle;
    tie.max_distance = 0.004;
    tulle_attachment_id id = 0;
    expect(TULLE_ERROR_INVALID_ARGUMENT, tulle_world_attach(world, &tie, &id, &error), &error);
    assert_non_null(strstr(error.message, "within 0.004 m"));
    tie.max_distance = 0.0051; /* the middle vertex is 5 mm below the box, its neighbours 1.2 mm
                                  beside its border at least */
    id = attach(world, &tie);
    assert_int_equal(tulle_attachment_get_report(world, id).held_count, 1);
    assert_true(tulle_attachment_holds(world, id, COUNT / 2));
    for (int i = 0; i < 10; i++) step(world);
    const double *const x = tulle_cloth_get_positions(world, cloth, NULL) + 3 * (COUNT / 2);
    assert_true(fabs(x[2]) < 1e-15);
    for (int i = 0; i < 2; i++) step(world);
    assert_int_equal(tulle_attachment_get_report(world, id).held_count, 0);
    tulle_world_destroy(world);
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&box);
}

/* ---- bodies and cloths ---- */

/* Sums of a free world. */
typedef struct momenta {
    double linear[3], angular[3];
} momenta;

static void add_point(momenta *sum, double mass, const double *x, const double *v) {
    for (int k = 0; k < 3; k++) {
        int const a = (k + 1) % 3, b = (k + 2) % 3;
        sum->linear[k] += mass * v[k];
        sum->angular[k] += mass * (x[a] * v[b] - x[b] * v[a]);
    }
}

/* A box hangs on a sheet whose other end is held: the sheet bears its weight, and their distance
 * stays. */
static void cloth_bears_a_body(void **state) {
    (void)state;
    tulle_world *const world = make_world(1);
    tulle_mesh sheet = small_sheet(0.25, SIDE, 0.0);
    tulle_shape_def shape = tulle_shape_def_default(TULLE_SHAPE_BOX);
    shape.size[0] = 0.25;
    shape.size[1] = shape.size[2] = 0.03;
    tulle_mesh box = small_shape(shape, 0.0, 0.125 + 0.02, 0.0);
    tulle_cloth_id const cloth = small_add_cloth(world, &sheet);
    tulle_obstacle_def def = tulle_obstacle_def_default();
    def.mesh = tulle_mesh_get_view(&box);
    def.body.is_dynamic = 1;
    def.body.mass = 0.2;
    tulle_obstacle_id body;
    tulle_error error = {0};
    expect(TULLE_OK, tulle_world_add_obstacle(world, &def, &body, &error), &error);
    double const down[3] = {0.0, G, 0.0}; /* along the sheet, which hangs from y = -0.125 */
    expect(TULLE_OK, tulle_world_set_gravity(world, down, &error), &error);
    start(world);
    uint32_t low[SIDE], high[SIDE];
    double points[3 * SIDE];
    size_t low_count = 0, high_count = 0;
    for (uint32_t v = 0; v < COUNT; v++) {
        const double *const p = sheet.positions + 3 * (size_t)v;
        if (p[1] > 0.124) low[low_count++] = v;
        if (!(p[1] < -0.124)) continue;
        memcpy(points + 3 * high_count, p, 3 * sizeof(double));
        high[high_count++] = v;
    }
    assert_true(low_count == SIDE && high_count == SIDE);
    tulle_attachment_def tie = tulle_attachment_def_default();
    tie.cloth = cloth;
    tie.vertices = high;
    tie.vertex_count = SIDE;
    tie.points = points;
    tulle_attachment_id const above = attach(world, &tie);
    tie.points = NULL;
    tie.vertices = low;
    tie.obstacle = body;
    tulle_attachment_id const below = attach(world, &tie);
    for (int i = 0; i < 256; i++) step(world);
    double const sheet_weight = tulle_cloth_def_default().material.area_density * 0.0625 * G;
    double const weight = 0.2 * G;
    tulle_attachment_report const on_body = tulle_attachment_get_report(world, below);
    tulle_attachment_report const on_top = tulle_attachment_get_report(world, above);
    expect_near("force on the box", weight, on_body.force[1], 1e-5 * weight);
    expect_near("force at the top", -weight - sheet_weight, on_top.force[1], 1e-5 * weight);
    tulle_transform pose;
    expect(TULLE_OK, tulle_obstacle_get_transform(world, body, &pose, &error), &error);
    const double *const x = tulle_cloth_get_positions(world, cloth, NULL);
    for (size_t i = 0; i < SIDE; i++)
        expect_near("distance", 0.02, pose.position[1] - x[3 * low[i] + 1], 2e-5);
    tulle_world_destroy(world);
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&box);
}

/* A cloth that lies on a free box, attached all over and nearer than contact would have it: contact
 * does not work against the ties, and both fall and turn as one. */
static void contact_leaves_ties_alone(void **state) {
    (void)state;
    tulle_world *const world = make_world(1);
    tulle_shape_def shape = tulle_shape_def_default(TULLE_SHAPE_BOX);
    shape.size[0] = shape.size[1] = 0.3;
    shape.size[2] = 0.05;
    tulle_mesh box = small_shape(shape, 0.0, 0.0, 0.0);
    tulle_mesh sheet = small_sheet(0.25, SIDE, 0.0);
    tulle_cloth_id const cloth = small_add_cloth(world, &sheet);
    tulle_obstacle_def def = tulle_obstacle_def_default();
    for (size_t v = 0; v < box.vertex_count; v++) box.positions[3 * v + 2] -= 0.025 + 5e-4;
    def.mesh = tulle_mesh_get_view(&box);
    def.body.is_dynamic = 1;
    def.body.mass = 0.5;
    def.body.angular_velocity[0] = 3.0;
    tulle_obstacle_id body;
    tulle_error error = {0};
    expect(TULLE_OK, tulle_world_add_obstacle(world, &def, &body, &error), &error);
    start(world);
    uint32_t all[COUNT];
    for (uint32_t i = 0; i < COUNT; i++) all[i] = i;
    tulle_attachment_def tie = tulle_attachment_def_default();
    tie.cloth = cloth;
    tie.vertices = all;
    tie.vertex_count = COUNT;
    tie.obstacle = body;
    tulle_attachment_id const id = attach(world, &tie);
    for (int i = 0; i < 64; i++) {
        step(world);
        /* a turn of 3/64 leaves each vertex some microns off its circle */
        assert_true(tulle_attachment_get_report(world, id).largest_force < 0.15);
    }
    tulle_transform pose;
    expect(TULLE_OK, tulle_obstacle_get_transform(world, body, &pose, &error), &error);
    /* a second of springs of first order takes some hundredths of it */
    expect_near("spin", 3.0, pose.angular_velocity[0], 0.12);
    const double *const q = pose.rotation;
    const double *const x = tulle_cloth_get_positions(world, cloth, NULL);
    for (size_t v = 0; v < COUNT; v++) { /* about x alone */
        double const up[2] = {-2.0 * q[0] * q[1], 1.0 - 2.0 * q[1] * q[1]};
        double const d[2] = {x[3 * v + 1] - pose.position[1], x[3 * v + 2] - pose.position[2]};
        expect_near("height", 0.0255, d[0] * up[0] + d[1] * up[1], 1e-4);
    }
    tulle_world_destroy(world);
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&box);
}

/* Two sheets, one sewn to the other and thrown, keep both momenta; the seam stays closed. */
static void seam_keeps_momenta(void **state) {
    (void)state;
    tulle_world *const world = make_world(2);
    tulle_mesh first = small_sheet(0.25, SIDE, 0.0), second = small_sheet(0.25, SIDE, 0.01);
    tulle_cloth_def def = tulle_cloth_def_default();
    def.material.air_damping = 0.0;
    double velocities[3 * COUNT];
    tulle_cloth_id cloths[2];
    tulle_error error = {0};
    for (int c = 0; c < 2; c++) {
        def.mesh = tulle_mesh_get_view(c == 0 ? &first : &second);
        for (size_t v = 0; v < COUNT; v++) {
            velocities[3 * v] = 0.3;
            velocities[3 * v + 1] = 0.0;
            velocities[3 * v + 2] = c == 0 ? 0.0 : 0.4;
        }
        def.velocities = velocities;
        expect(TULLE_OK, tulle_world_add_cloth(world, &def, &cloths[c], &error), &error);
    }
    double const none[3] = {0.0, 0.0, 0.0};
    expect(TULLE_OK, tulle_world_set_gravity(world, none, &error), &error);
    start(world);
    uint32_t border[SIDE];
    for (uint32_t i = 0; i < SIDE; i++) border[i] = i;
    tulle_attachment_def tie = tulle_attachment_def_default();
    tie.cloth = cloths[1];
    tie.vertices = border;
    tie.vertex_count = SIDE;
    tie.other_cloth = cloths[0];
    tulle_attachment_id const id = attach(world, &tie);
    /* masses: a cell's area, half on borders, as two triangles with alternating diagonals share it;
     * so they are taken from the sum of areas of each vertex */
    double masses[COUNT] = {0};
    for (size_t t = 0; t < first.triangle_count; t++)
        for (size_t k = 0; k < 3; k++)
            masses[first.triangles[3 * t + k]] +=
                def.material.area_density * (0.25 * 0.25) / (double)first.triangle_count / 3.0;
    momenta before = {{0}, {0}}, after = {{0}, {0}};
    for (int c = 0; c < 2; c++)
        for (size_t v = 0; v < COUNT; v++)
            add_point(&before, masses[v], tulle_cloth_get_positions(world, cloths[c], NULL) + 3 * v,
                      tulle_cloth_get_velocities(world, cloths[c], NULL) + 3 * v);
    for (int i = 0; i < 48; i++) step(world);
    for (int c = 0; c < 2; c++)
        for (size_t v = 0; v < COUNT; v++)
            add_point(&after, masses[v], tulle_cloth_get_positions(world, cloths[c], NULL) + 3 * v,
                      tulle_cloth_get_velocities(world, cloths[c], NULL) + 3 * v);
    double const scale = before.linear[2] * 0.125;
    for (int k = 0; k < 3; k++) {
        expect_near("momentum", before.linear[k], after.linear[k], 1e-6 * before.linear[2]);
        expect_near("angular momentum", before.angular[k], after.angular[k], 0.05 * scale);
    }
    const double *const a = tulle_cloth_get_positions(world, cloths[0], NULL);
    const double *const b = tulle_cloth_get_positions(world, cloths[1], NULL);
    for (size_t v = 0; v < SIDE; v++) {
        double const d[3] = {a[3 * v] - b[3 * v], a[3 * v + 1] - b[3 * v + 1],
                             a[3 * v + 2] - b[3 * v + 2]};
        expect_near("seam", 0.01, sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]), 5e-4);
    }
    assert_int_equal(tulle_attachment_get_report(world, id).held_count, SIDE);
    tulle_world_destroy(world);
    tulle_mesh_destroy(&first);
    tulle_mesh_destroy(&second);
}

/* A tight strip that stands askew over a free sheet, tied to it at both ends, pulls at its places
 * with a couple. What ties add to that turns the sheet back: nothing is set spinning. */
static void height_turns_no_cloth(void **state) {
    (void)state;
    tulle_world *const world = make_world(1);
    tulle_mesh sheet = small_sheet(0.3, SIDE, 0.0), strip = small_sheet(0.2, SIDE, 0.0);
    double rest[3 * COUNT];
    for (size_t v = 0; v < COUNT; v++)
        strip.positions[3 * v + 2] = 0.01 + 0.35 * (strip.positions[3 * v] + 0.1);
    for (size_t k = 0; k < 3 * COUNT; k++) rest[k] = 0.9 * strip.positions[k];
    tulle_cloth_def def = tulle_cloth_def_default();
    def.material.air_damping = 0.0;
    def.mesh = tulle_mesh_get_view(&sheet);
    tulle_cloth_id cloths[2];
    tulle_error error = {0};
    expect(TULLE_OK, tulle_world_add_cloth(world, &def, &cloths[0], &error), &error);
    def.mesh = tulle_mesh_get_view(&strip);
    def.rest_positions = rest;
    expect(TULLE_OK, tulle_world_add_cloth(world, &def, &cloths[1], &error), &error);
    double const none[3] = {0.0, 0.0, 0.0};
    expect(TULLE_OK, tulle_world_set_gravity(world, none, &error), &error);
    start(world);
    uint32_t ends[COUNT];
    size_t end_count = 0;
    for (uint32_t v = 0; v < COUNT; v++)
        if (fabs(strip.positions[3 * v]) > 0.099) ends[end_count++] = v;
    tulle_attachment_def tie = tulle_attachment_def_default();
    tie.cloth = cloths[1];
    tie.vertices = ends;
    tie.vertex_count = end_count;
    tie.other_cloth = cloths[0];
    tie.stiffness = 100.0;
    attach(world, &tie);
    double masses[2][COUNT] = {{0}};
    for (size_t t = 0; t < sheet.triangle_count; t++) {
        double const mass = def.material.area_density / (3.0 * (double)sheet.triangle_count);
        for (size_t k = 0; k < 3; k++) {
            masses[0][sheet.triangles[3 * t + k]] += 0.09 * mass;
            masses[1][strip.triangles[3 * t + k]] += 0.81 * 0.04 * hypot(1.0, 0.35) * mass;
        }
    }
    double kinetic = 0.0;
    for (int i = 0; i < 192; i++) {
        tulle_step_report report;
        expect(TULLE_OK, tulle_world_step(world, STEP, &report, &error), &error);
        kinetic = report.kinetic_energy;
        momenta sum = {{0}, {0}};
        for (int c = 0; c < 2; c++)
            for (size_t v = 0; v < COUNT; v++)
                add_point(&sum, masses[c][v],
                          tulle_cloth_get_positions(world, cloths[c], NULL) + 3 * v,
                          tulle_cloth_get_velocities(world, cloths[c], NULL) + 3 * v);
        for (int k = 0; k < 3; k++) {
            expect_near("momentum", 0.0, sum.linear[k], 1e-12);
            expect_near("angular momentum", 0.0, sum.angular[k], 1e-4); /* [kg m^2/s] */
        }
    }
    expect_near("kinetic energy", 0.0, kinetic, 1e-7);
    tulle_world_destroy(world);
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&strip);
}

/* A cloth is folded onto a patch that is sewn to it all over: the fold has contact with the patch
 * like any other. Without it impacts alone would keep them apart, in round after round. */
static void folds_meet_what_is_sewn_on(void **state) {
    (void)state;
    enum { FINE = 17 };
    tulle_world *const world = make_world(1);
    tulle_mesh meshes[2] = {small_sheet(0.4, FINE, 0.006), small_sheet(0.1, 5, 0.012)};
    for (size_t v = 0; v < meshes[1].vertex_count; v++) meshes[1].positions[3 * v] += 0.1;
    tulle_mesh ground = small_shape(tulle_shape_def_default(TULLE_SHAPE_PLANE), 0.0, 0.0, 0.0);
    tulle_cloth_id const cloth = small_add_cloth(world, &meshes[0]);
    tulle_cloth_id const patch = small_add_cloth(world, &meshes[1]);
    small_add_obstacle(world, &ground);
    start(world);
    uint32_t all[25], border[FINE];
    for (uint32_t i = 0; i < 25; i++) all[i] = i;
    tulle_attachment_def sewn = tulle_attachment_def_default();
    sewn.cloth = patch;
    sewn.vertices = all;
    sewn.vertex_count = 25;
    sewn.other_cloth = cloth;
    attach(world, &sewn);
    double points[3 * FINE];
    size_t count = 0;
    for (uint32_t v = 0; v < FINE * FINE; v++)
        if (meshes[0].positions[3 * v] > 0.199) border[count++] = v;
    for (size_t i = 0; i < count; i++)
        memcpy(points + 3 * i, meshes[0].positions + 3 * border[i], 3 * sizeof *points);
    tulle_attachment_def hand = tulle_attachment_def_default();
    hand.cloth = cloth;
    hand.vertices = border;
    hand.vertex_count = count;
    hand.points = points;
    tulle_attachment_id const id = attach(world, &hand);
    tulle_step_report report;
    tulle_error error = {0};
    uint64_t rounds = 0;
    for (int i = 0; i < 128; i++) {
        double const angle = fmin(1.0, i / 80.0) * 3.05;
        for (size_t k = 0; k < count; k++) {
            points[3 * k] = 0.2 * cos(angle);
            points[3 * k + 2] = 0.02 + 0.18 * sin(angle);
        }
        if (i == 96) expect(TULLE_OK, tulle_attachment_release(world, id, &error), &error);
        if (i < 96)
            expect(TULLE_OK, tulle_attachment_set_points(world, id, points, count, &error), &error);
        expect(TULLE_OK, tulle_world_step(world, STEP, &report, &error), &error);
        assert_int_equal(small_judge(world, meshes, 2, &ground, 1), 0);
        rounds += report.impact_rounds;
    }
    assert_true(rounds < 30); /* 293 without rows */
    tulle_world_destroy(world);
    for (int c = 0; c < 2; c++) tulle_mesh_destroy(&meshes[c]);
    tulle_mesh_destroy(&ground);
}

/* ---- states ---- */

/* A state holds attachments: loaded into the same world and into a fresh one, all goes on alike. */
static void states_hold_attachments(void **state) {
    (void)state;
    tulle_mesh mesh = small_sheet(0.25, SIDE, 0.0);
    tulle_world *worlds[2];
    tulle_cloth_id cloth = {0};
    for (int i = 0; i < 2; i++) {
        worlds[i] = make_world(1);
        cloth = small_add_cloth(worlds[i], &mesh);
    }
    start(worlds[0]);
    static const uint32_t corners[2] = {0, SIDE - 1};
    double const points[6] = {-0.125, -0.125, 0.1, 0.125, -0.125, 0.1};
    tulle_attachment_def tie = tulle_attachment_def_default();
    tie.cloth = cloth;
    tie.vertices = corners;
    tie.vertex_count = 2;
    tie.points = points;
    tie.stiffness = 50.0;
    tulle_attachment_id const id = attach(worlds[0], &tie);
    for (int i = 0; i < 8; i++) step(worlds[0]);
    void *bytes;
    size_t size;
    tulle_error error = {0};
    expect(TULLE_OK, tulle_world_save_state(worlds[0], &bytes, &size, &error), &error);
    uint64_t const saved = tulle_world_get_state_hash(worlds[0]);
    for (int i = 0; i < 8; i++) step(worlds[0]);
    uint64_t const later = tulle_world_get_state_hash(worlds[0]);
    expect(TULLE_OK, tulle_attachment_release(worlds[0], id, &error), &error);
    assert_true(tulle_world_get_state_hash(worlds[0]) != later);
    step(worlds[0]);
    for (int i = 0; i < 2; i++) {
        expect(TULLE_OK, tulle_world_load_state(worlds[i], bytes, size, &error), &error);
        assert_true(tulle_world_get_state_hash(worlds[i]) == saved);
        assert_int_equal(tulle_attachment_get_report(worlds[i], id).held_count, 2);
        for (int k = 0; k < 8; k++) step(worlds[i]);
        assert_true(tulle_world_get_state_hash(worlds[i]) == later);
    }
    tulle_world_free_state(worlds[0], bytes, size);
    for (int i = 0; i < 2; i++) tulle_world_destroy(worlds[i]);
    tulle_mesh_destroy(&mesh);
}

/* An attachment made before the start begins with it, has the same name, and lets go in time. */
static void made_before_the_start(void **state) {
    (void)state;
    uint64_t hashes[2];
    for (int is_before = 0; is_before < 2; is_before++) {
        tulle_mesh mesh = one_triangle(0.0);
        tulle_world *const world = make_world(1);
        tulle_cloth_id const cloth = small_add_cloth(world, &mesh);
        double points[9];
        uint32_t vertices[3] = {0, 1, 2};
        memcpy(points, mesh.positions, sizeof points);
        tulle_attachment_def tie = tulle_attachment_def_default();
        tie.cloth = cloth;
        tie.vertices = vertices;
        tie.vertex_count = 3;
        tie.points = points;
        tie.release_time = 4.0 * STEP;
        if (!is_before) start(world);
        tulle_attachment_id const id = attach(world, &tie);
        assert_int_equal(id, 1);
        if (is_before) { /* arrays are copied */
            memset(points, 0, sizeof points);
            memset(vertices, 0, sizeof vertices);
            assert_int_equal(tulle_attachment_get_report(world, id).held_count, 0);
            start(world);
        }
        assert_int_equal(tulle_attachment_get_report(world, id).held_count, 3);
        for (int i = 0; i < 4; i++) step(world);
        const double *x = tulle_cloth_get_positions(world, cloth, NULL);
        for (int k = 0; k < 9; k++) assert_true(x[k] == mesh.positions[k]);
        step(world);
        assert_int_equal(tulle_attachment_get_report(world, id).held_count, 0);
        x = tulle_cloth_get_positions(world, cloth, NULL);
        assert_true(x[2] < 0.0);
        hashes[is_before] = tulle_world_get_state_hash(world);
        tulle_world_destroy(world);
        tulle_mesh_destroy(&mesh);
    }
    assert_true(hashes[0] == hashes[1]);
    /* what the start does not have is its error, and the world has not started */
    tulle_mesh mesh = one_triangle(0.0);
    tulle_world *const world = make_world(1);
    tulle_attachment_def tie = tulle_attachment_def_default();
    tie.cloth = small_add_cloth(world, &mesh);
    tie.vertices = (const uint32_t[]){3};
    tie.vertex_count = 1;
    tie.points = mesh.positions;
    attach(world, &tie);
    tulle_error error = {0};
    for (int i = 0; i < 2; i++) {
        expect(TULLE_ERROR_INVALID_ARGUMENT, tulle_world_start(world, &error), &error);
        assert_non_null(strstr(error.message, "vertex 3"));
    }
    tulle_world_destroy(world);
    tulle_mesh_destroy(&mesh);
}

/* A state whose tie says what no tie may say is refused, though its hash is right. */
static void crafted_ties_are_refused(void **state) {
    (void)state;
    tulle_mesh mesh = one_triangle(0.0);
    tulle_world *const world = make_world(1);
    tulle_cloth_id const cloth = small_add_cloth(world, &mesh);
    start(world);
    static const double points[9] = {0.0, 0.0, 0.015625, 0.25, 0.0, 0.0, 0.125, 0.25, 0.0};
    tulle_attachment_def tie = tulle_attachment_def_default();
    tie.cloth = cloth;
    tie.vertices = THREE;
    tie.vertex_count = 1;
    tie.points = points;
    attach(world, &tie);
    void *bytes;
    size_t size;
    tulle_error error = {0};
    expect(TULLE_OK, tulle_world_save_state(world, &bytes, &size, &error), &error);
    uint64_t const hash = tulle_world_get_state_hash(world);
    /* the tie: eight words, four doubles, then its point, stiffness, force at which it breaks */
    enum { HASHED_FROM = 16, HASH_AT = 8, POINT_IN_TIE = 64, TIE_BYTES = 136 };
    unsigned char *const saved = bytes, *const made = malloc(size);
    assert_non_null(made);
    size_t at = 0;
    while (at + TIE_BYTES <= size && memcmp(saved + at + POINT_IN_TIE, points, 24) != 0) at++;
    assert_true(at + TIE_BYTES <= size);
    struct {
        size_t offset;
        uint32_t word;
        double number;
        bool is_word;
    } const wrong[] = {{0, 0, 0.0, true},        {0, 2, 0.0, true},           {4, 1, 0.0, true},
                       {12, 3, 0.0, true},       {16, 0, 0.0, true},          {32, 0, NAN, false},
                       {56, 0, NAN, false},      {64, 0, 1e101, false},       {88, 0, 0.0, false},
                       {88, 0, 1e13, false},     {96, 0, (double)NAN, false}, {104, 0, NAN, false},
                       {112, 0, INFINITY, false}};
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        memcpy(made, saved, size);
        if (wrong[i].is_word)
            memcpy(made + at + wrong[i].offset, &wrong[i].word, sizeof wrong[i].word);
        else
            memcpy(made + at + wrong[i].offset, &wrong[i].number, sizeof wrong[i].number);
        uint64_t const right = hash_block(made + HASHED_FROM, size - HASHED_FROM);
        memcpy(made + HASH_AT, &right, sizeof right);
        if (tulle_world_load_state(world, made, size, &error) != TULLE_ERROR_PARSE)
            fail_msg("wrong value %zu was taken", i);
        assert_non_null(strstr(error.message, "attachments"));
        assert_true(tulle_world_get_state_hash(world) == hash);
    }
    expect(TULLE_OK, tulle_world_load_state(world, saved, size, &error), &error);
    tulle_world_free_state(world, bytes, size);
    free(made);
    tulle_world_destroy(world);
    tulle_mesh_destroy(&mesh);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(springs_swing_as_the_integrator_says),
        cmocka_unit_test(points_lead_rigidly),
        cmocka_unit_test(breaks_at_its_force),
        cmocka_unit_test(border_follows_a_deforming_plate),
        cmocka_unit_test(distance_and_departure),
        cmocka_unit_test(cloth_bears_a_body),
        cmocka_unit_test(contact_leaves_ties_alone),
        cmocka_unit_test(seam_keeps_momenta),
        cmocka_unit_test(height_turns_no_cloth),
        cmocka_unit_test(folds_meet_what_is_sewn_on),
        cmocka_unit_test(states_hold_attachments),
        cmocka_unit_test(made_before_the_start),
        cmocka_unit_test(crafted_ties_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
