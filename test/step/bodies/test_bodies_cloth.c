/* Rigid bodies and cloth: contact both ways. Laws of conservation, statics, the exact judge. */
#include "support/body_world.h"
#include "support/test_support.h"
#include "tulle/attach.h"
#include "tulle/tulle.h"
#include "world/world_state.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Cloth of 1,000 vertices and more is solved in single precision, with aggregates. */
enum { FINE_SIDE = 35 };

typedef struct momenta {
    double linear[3], angular[3];
} momenta;

static void add_momentum(double mass, const double *x, const double *v, momenta *sum) {
    for (int k = 0; k < 3; k++) {
        int const a = (k + 1) % 3, b = (k + 2) % 3;
        sum->linear[k] += mass * v[k];
        sum->angular[k] += mass * (x[a] * v[b] - x[b] * v[a]);
    }
}

/* Masses of a sheet's vertices. */
static double *find_masses(const tulle_mesh *mesh, double area_density) {
    double *const masses = calloc(mesh->vertex_count, sizeof(double));
    assert_non_null(masses);
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        const double *p[3];
        double normal[3];
        for (int k = 0; k < 3; k++)
            p[k] = mesh->positions + 3 * (size_t)mesh->triangles[3 * t + (size_t)k];
        for (int k = 0; k < 3; k++) {
            int const a = (k + 1) % 3, b = (k + 2) % 3;
            normal[k] = (p[1][a] - p[0][a]) * (p[2][b] - p[0][b]) -
                        (p[1][b] - p[0][b]) * (p[2][a] - p[0][a]);
        }
        double const area =
            0.5 * sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
        for (int k = 0; k < 3; k++)
            masses[mesh->triangles[3 * t + (size_t)k]] += area_density * area / 3.0;
    }
    return masses;
}

static momenta measure(const tulle_world *world, tulle_obstacle_id id, const double *masses) {
    momenta sum = {{0.0}, {0.0}};
    size_t count;
    tulle_cloth_id const cloth = {0, 1};
    const double *const x = tulle_cloth_get_positions(world, cloth, &count);
    const double *const v = tulle_cloth_get_velocities(world, cloth, NULL);
    for (size_t i = 0; i < count; i++) add_momentum(masses[i], x + 3 * i, v + 3 * i, &sum);
    tulle_transform const t = bodies_get_transform(world, id);
    add_momentum(t.mass, t.position, t.velocity, &sum);
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++) sum.angular[i] += t.inertia[3 * i + k] * t.angular_velocity[k];
    return sum;
}

static double find_change(const double a[3], const double b[3]) {
    return sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) +
                (a[2] - b[2]) * (a[2] - b[2]));
}

/* Adds an impulse on a point to the sums. */
static void add_impulse(const double *x, vec3 impulse, vec3 *linear, vec3 *angular) {
    *linear = vec3_add(*linear, impulse);
    *angular = vec3_add(*angular, vec3_cross(vec3_load(x, 0), impulse));
}

/* What the contacts of the last step with the body change of the momentum and angular momentum
 * about the origin of cloth and body together, over the sum of their impulses: places are those
 * before the step. */
static double measure_balance(const tulle_world *world, const double *before,
                              const double centre[3]) {
    vec3 linear = {0.0, 0.0, 0.0}, angular = {0.0, 0.0, 0.0};
    double total = 0.0;
    for (size_t i = 0; i < world->accepted_rows.rows.count; i++) {
        const contact_row *const row = &world->accepted_rows.rows.data[i];
        if (!row->frame.has_body) continue;
        total += vec3_norm(row->solve.impulse);
        for (int k = 0; k < 4; k++)
            if (row->frame.vertices[k] < world->model.cloth_vertex_count)
                add_impulse(before + 3 * (size_t)row->frame.vertices[k],
                            vec3_scale(row->solve.impulse, row->frame.weights[k]), &linear,
                            &angular);
        for (int side = 0; side < 2; side++) {
            if (row->frame.slots[side] == TULLE_NONE) continue;
            add_impulse(centre, vec3_scale(row->solve.impulse, side == 0 ? 1.0 : -1.0), &linear,
                        &angular);
            angular = vec3_add(angular, vec3_cross(row->frame.arms[side], row->solve.impulse));
        }
    }
    return total > 0.0 ? fmax(vec3_norm(linear), vec3_norm(angular)) / total : 0.0;
}

/* A ball thrown with spin into a sheet in free flight, for 2/3 s. The change of angular momentum
 * over what there was. */
static double throw_ball(unsigned side, double time_step) {
    tulle_world_def def = tulle_world_def_default();
    def.membrane = TULLE_MEMBRANE_SPRINGS;
    def.wind.drag_coefficient = 0.0;
    for (int k = 0; k < 3; k++) def.gravity[k] = 0.0;
    tulle_world *const world = bodies_make_world(&def, false);
    tulle_mesh sheet = small_sheet(1.0, side, 0.0);
    tulle_mesh ball = bodies_make_ball(0.1, 4, (double[3]){0.03, 0.02, 0.2});
    double const area_density = 0.2;
    bodies_add_cloth(world, &sheet, area_density, 0);
    tulle_body const body = {.is_dynamic = 1,
                             .mass = 0.1,
                             .velocity = {0.4, 0.0, -2.0},
                             .angular_velocity = {3.0, 2.0, -4.0}};
    tulle_obstacle_id const id = bodies_add_obstacle(world, &ball, 0.3, &body);
    tulle_error error;
    if (tulle_world_start(world, &error) != TULLE_OK) fail_msg("%s", error.message);
    double *const masses = find_masses(&sheet, area_density);
    momenta const start = measure(world, id, masses);
    double const p0 = find_change(start.linear, (double[3]){0.0, 0.0, 0.0});
    double const l0 = find_change(start.angular, (double[3]){0.0, 0.0, 0.0});
    double linear = 0.0, angular = 0.0, energy = 0.0, growth = 0.0, balance = 0.0;
    uint64_t contacts = 0, rescues = 0;
    size_t const vector_bytes = 3 * sheet.vertex_count * sizeof(double);
    double *const before = malloc(vector_bytes);
    assert_non_null(before);
    int const steps = (int)(2.0 / 3.0 / time_step + 0.5);
    for (int i = 0; i < steps; i++) {
        tulle_transform const was = bodies_get_transform(world, id);
        memcpy(before, tulle_cloth_get_positions(world, (tulle_cloth_id){0, 1}, NULL),
               vector_bytes);
        tulle_step_report const report = bodies_step_by(world, time_step);
        momenta const now = measure(world, id, masses);
        if (report.substeps == 1)
            balance = fmax(balance, measure_balance(world, before, was.position));
        linear = fmax(linear, find_change(now.linear, start.linear) / p0);
        angular = fmax(angular, find_change(now.angular, start.angular) / l0);
        double const total = report.kinetic_energy + report.elastic_energy;
        if (i > 0) growth = fmax(growth, (total - energy) / energy);
        energy = total;
        contacts += report.contacts;
        rescues += report.rescue_component_scalings + report.rescue_global_scalings +
                   report.rescue_impact_zones;
    }
    tulle_transform const end = bodies_get_transform(world, id);
    print_message(
        "ball into a sheet: momentum %.2g, angular %.2g, of impulses %.2g, energy grows by "
        "%.2g, %d contacts, %d rescues, ball at %.3g m with %.3g m/s\n",
        linear, angular, balance, growth, (int)contacts, (int)rescues, end.position[2],
        end.velocity[2]);
    assert_true(contacts > 100);
    assert_true(linear < 1e-12);
    assert_true(balance < 1e-12);
    free(before);
    assert_true(growth < 1e-12);
    assert_int_equal(bodies_judge(world, &sheet, 1, &ball, 1), 0);
    free(masses);
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&ball);
    tulle_world_destroy(world);
    return angular;
}

/* Linear momentum to rounding; angular momentum as the cloth's integrator keeps it, in proportion
 * to the step. */
static void ball_and_free_sheet_keep_momentum(void **state) {
    (void)state;
    unsigned const sides[] = {17, FINE_SIDE};
    for (int i = 0; i < 2; i++) {
        double const in_long = throw_ball(sides[i], BODIES_STEP);
        double const in_short = throw_ball(sides[i], BODIES_STEP / 4.0);
        assert_true(in_long < 0.05);
        assert_true(in_short < 0.4 * in_long);
    }
}

/* A ball on a sheet held at its corners, with the ratio of its mass to the sheet's. In the end it
 * may move by so much [m] a step, and its centre lies between two heights [m]. */
static void rest_on_sheet(unsigned side, double ratio, double area_density, double most_jitter,
                          double lowest, double highest) {
    int const steps = 450;
    tulle_world_def def = tulle_world_def_default();
    def.membrane = TULLE_MEMBRANE_SPRINGS;
    tulle_world *const world = bodies_make_world(&def, false);
    tulle_mesh sheet = small_sheet(1.0, side, 0.0);
    tulle_mesh ball = bodies_make_ball(0.15, 4, (double[3]){0.0, 0.0, 0.16});
    bodies_add_cloth(world, &sheet, area_density, 1);
    tulle_body const body = {.is_dynamic = 1, .mass = ratio * area_density, .linear_damping = 2.0};
    tulle_obstacle_id const id = bodies_add_obstacle(world, &ball, 0.5, &body);
    uint64_t rescues = 0, contacts = 0, iterations = 0;
    double stretch = 0.0, last = 0.0, jitter = 0.0;
    double gap = (double)INFINITY, last_gap = (double)INFINITY;
    for (int i = 0; i < steps; i++) {
        tulle_step_report const report = bodies_step(world);
        rescues += report.rescue_component_scalings + report.rescue_global_scalings +
                   report.rescue_impact_zones;
        contacts = report.contacts;
        iterations += report.cg_iterations;
        stretch = fmax(stretch, report.max_stretch);
        double const height = bodies_get_transform(world, id).position[2];
        gap = fmin(gap, report.smallest_gap);
        if (i > steps - 30) {
            jitter = fmax(jitter, fabs(height - last));
            last_gap = fmin(last_gap, report.smallest_gap);
        }
        last = height;
    }
    tulle_transform const end = bodies_get_transform(world, id);
    print_message("ratio %g: height %.4g m, speed %.2g m/s, way a step %.2g m, smallest gap %.3g "
                  "mm, %.4g at rest, "
                  "%d contacts, stretch %.3g, %d rescues, %d iterations a step\n",
                  ratio, end.position[2],
                  sqrt(end.velocity[0] * end.velocity[0] + end.velocity[1] * end.velocity[1] +
                       end.velocity[2] * end.velocity[2]),
                  jitter, 1e3 * gap, 1e3 * last_gap, (int)contacts, stretch, (int)rescues,
                  (int)(iterations / (uint64_t)steps));
    assert_int_equal(rescues, 0);
    assert_true(jitter < most_jitter);
    assert_true(end.position[2] > lowest && end.position[2] < highest);
    assert_true(gap >= 0.005 / 40.0); /* the least that the world promises */
    assert_true(last_gap > 0.0048);   /* the ball keeps its contact distance */
    assert_int_equal(bodies_judge(world, &sheet, 1, &ball, 1), 0);
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&ball);
    tulle_world_destroy(world);
}

static void balls_rest_on_a_sheet(void **state) {
    (void)state;
    rest_on_sheet(13, 1.0, 0.2, 3e-6, -0.061, -0.059);
    rest_on_sheet(13, 0.001, 0.2, 2e-7, 0.016, 0.018);
    rest_on_sheet(13, 1000.0, 0.002, 2.5e-5, -0.196, -0.192);
    /* `exact` gives -0.07106, 0.01501 and -0.2058 m */
    rest_on_sheet(FINE_SIDE, 1.0, 0.2, 3e-6, -0.0715, -0.0705);
    rest_on_sheet(FINE_SIDE, 0.001, 0.2, 2e-7, 0.0145, 0.0155);
    rest_on_sheet(FINE_SIDE, 1000.0, 0.002, 2.5e-5, -0.2068, -0.2048);
}

/* Where a damped ball comes to rest is a matter of weights alone, not of the integrator. */
static void integrators_agree_at_rest(void **state) {
    (void)state;
    double first = 0.0;
    for (int integrator = 0; integrator < 3; integrator++) {
        tulle_world_def def = tulle_world_def_default();
        def.membrane = TULLE_MEMBRANE_SPRINGS;
        def.integrator = (tulle_integrator)integrator;
        tulle_world *const world = bodies_make_world(&def, false);
        tulle_mesh sheet = small_sheet(1.0, 13, 0.0);
        tulle_mesh ball = bodies_make_ball(0.15, 4, (double[3]){0.0, 0.0, 0.16});
        bodies_add_cloth(world, &sheet, 0.2, 1);
        tulle_body const body = {.is_dynamic = 1, .mass = 0.2, .linear_damping = 4.0};
        tulle_obstacle_id const id = bodies_add_obstacle(world, &ball, 0.5, &body);
        for (int i = 0; i < 900; i++) bodies_step(world);
        double const height = bodies_get_transform(world, id).position[2];
        print_message("integrator %d: the ball rests at %.6f m\n", integrator, height);
        if (integrator == 0) first = height;
        assert_true(fabs(height - first) < 1e-4);
        tulle_mesh_destroy(&sheet);
        tulle_mesh_destroy(&ball);
        tulle_world_destroy(world);
    }
}

/* Three boxes on a sheet held at its corners come to rest within 5 s and stay where they are, for
 * another 3 s, 30 with TULLE_TEST_LONG=1. */
static void stack_rests(unsigned side) {
    int const steps = getenv("TULLE_TEST_LONG") ? 35 * 90 : 8 * 90;
    tulle_world_def def = tulle_world_def_default();
    tulle_world *const world = bodies_make_world(&def, false);
    tulle_mesh sheet = small_sheet(0.8, side, 0.0);
    tulle_mesh boxes[3];
    tulle_obstacle_id ids[3];
    bodies_add_cloth(world, &sheet, 0.3, 1);
    for (int i = 0; i < 3; i++) {
        tulle_body const body = {
            .is_dynamic = 1, .mass = 0.1, .linear_damping = 3.0, .angular_damping = 3.0};
        boxes[i] = bodies_make_box(0.2, 0.2, 0.1, (double[3]){0.0, 0.0, 0.06 + 0.106 * i});
        ids[i] = bodies_add_obstacle(world, &boxes[i], 0.6, &body);
    }
    uint64_t rescues = 0;
    tulle_transform before[3] = {{.mass = 0.0}};
    double creep = 0.0, turn = 0.0;
    for (int i = 1; i <= steps; i++) {
        tulle_step_report const report = bodies_step(world);
        rescues += report.rescue_component_scalings + report.rescue_global_scalings;
        for (int b = 0; b < 3; b++) {
            tulle_transform const now = bodies_get_transform(world, ids[b]);
            if (i <= 450) before[b] = now;
            for (int k = 0; k < 3; k++) {
                creep = fmax(creep, fabs(now.position[k] - before[b].position[k]));
                turn = fmax(turn, 2.0 * fabs(now.rotation[k + 1] - before[b].rotation[k + 1]));
            }
        }
        if (i % 60 == 0) assert_int_equal(bodies_judge(world, &sheet, 1, boxes, 3), 0);
    }
    print_message(
        "stack on %u x %u: top at %.5g m, creeps by %.2g m and turns by %.2g in %d s, %d rescues\n",
        side, side, before[2].position[2], creep, turn, steps / 90 - 5, (int)rescues);
    for (int i = 0; i + 1 < 3; i++) {
        double const gap = bodies_get_transform(world, ids[i + 1]).position[2] -
                           bodies_get_transform(world, ids[i]).position[2] - 0.1;
        assert_true(gap > 0.0 && gap < 0.02);
    }
    assert_int_equal(rescues, 0);
    assert_true(creep < 1e-6 && turn < 1e-6);
    for (int i = 0; i < 3; i++) tulle_mesh_destroy(&boxes[i]);
    tulle_mesh_destroy(&sheet);
    tulle_world_destroy(world);
}

static void stack_comes_to_rest(void **state) {
    (void)state;
    stack_rests(13);
    stack_rests(FINE_SIDE);
}

/* A box of half a kilogram hangs below fine cloth by a tie of 1e11 N/m, as with exact solves. */
static double hang_from_tie(tulle_quality quality) {
    tulle_world_def def = tulle_world_def_default();
    def.quality = quality;
    tulle_world *const world = bodies_make_world(&def, false);
    tulle_mesh sheet = small_sheet(1.0, FINE_SIDE, 0.0);
    tulle_mesh box = bodies_make_box(0.15, 0.15, 0.02, (double[3]){0.0, 0.0, -0.03});
    bodies_add_cloth(world, &sheet, 0.3, 1);
    tulle_body const body = {.is_dynamic = 1, .mass = 0.5};
    tulle_obstacle_id const id = bodies_add_obstacle(world, &box, 0.5, &body);
    tulle_attachment_def tie = tulle_attachment_def_default();
    tie.cloth = (tulle_cloth_id){0, 1};
    tie.vertices = (const uint32_t[]){FINE_SIDE * FINE_SIDE / 2};
    tie.vertex_count = 1;
    tie.obstacle = id;
    tie.stiffness = 1e11;
    tulle_attachment_id attachment;
    assert_int_equal(tulle_world_attach(world, &tie, &attachment, NULL), TULLE_OK);
    for (int i = 0; i < 45; i++) bodies_step(world);
    double const height = bodies_get_transform(world, id).position[2];
    assert_int_equal(bodies_judge(world, &sheet, 1, &box, 1), 0);
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&box);
    tulle_world_destroy(world);
    return height;
}

static void a_stiff_tie_bears_a_body(void **state) {
    (void)state;
    double const normal = hang_from_tie(TULLE_QUALITY_NORMAL);
    double const exact = hang_from_tie(TULLE_QUALITY_EXACT);
    print_message("a box hangs at %.6f m, with exact solves at %.6f m\n", normal, exact);
    assert_true(exact < -0.05 && exact > -0.4);
    assert_true(fabs(normal - exact) < 1e-3);
}

/* A ball that falls into a sheet, with any number of threads and across a checkpoint. */
static uint64_t fall_with(unsigned side, int threads, bool saves) {
    tulle_world_def def = tulle_world_def_default();
    def.threads = threads;
    uint64_t hash = 0;
    void *bytes = NULL;
    size_t byte_count = 0;
    tulle_world *worlds[2] = {NULL, NULL};
    tulle_mesh sheet = small_sheet(1.0, side, 0.0);
    tulle_mesh ball = bodies_make_ball(0.15, 4, (double[3]){0.1, 0.0, 0.2});
    tulle_body const body = {.is_dynamic = 1, .mass = 1.0, .angular_velocity = {0.0, 9.0, 0.0}};
    for (int part = 0; part < 2; part++) {
        tulle_world *const world = worlds[part] = bodies_make_world(&def, false);
        bodies_add_cloth(world, &sheet, 0.2, 1);
        bodies_add_obstacle(world, &ball, 0.5, &body);
        if (saves && part == 1)
            assert_int_equal(tulle_world_load_state(world, bytes, byte_count, NULL), TULLE_OK);
        int const last = saves && part == 0 ? 20 : 40;
        for (int i = saves && part == 1 ? 20 : 0; i < last; i++) bodies_step(world);
        hash = tulle_world_get_state_hash(world);
        if (!saves) break;
        if (part == 0)
            assert_int_equal(tulle_world_save_state(world, &bytes, &byte_count, NULL), TULLE_OK);
    }
    tulle_world_free_state(worlds[0], bytes, byte_count);
    for (int part = 0; part < 2; part++) tulle_world_destroy(worlds[part]);
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&ball);
    return hash;
}

static void bits_are_the_same(void **state) {
    (void)state;
    unsigned const sides[] = {13, FINE_SIDE};
    for (int i = 0; i < 2; i++) {
        uint64_t const hash = fall_with(sides[i], 1, false);
        for (int threads = 2; threads <= 8; threads += 3)
            assert_true(fall_with(sides[i], threads, false) == hash);
        assert_true(fall_with(sides[i], 2, true) == hash);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ball_and_free_sheet_keep_momentum),
        cmocka_unit_test(balls_rest_on_a_sheet),
        cmocka_unit_test(integrators_agree_at_rest),
        cmocka_unit_test(stack_comes_to_rest),
        cmocka_unit_test(a_stiff_tie_bears_a_body),
        cmocka_unit_test(bits_are_the_same),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
