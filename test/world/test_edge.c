/* A ribbon that is pulled over the 90 degree edge of a box and lifts its own hanging part, a known
 * weight. The edge is the load cell: contacts near it take the horizontal tension of the part on
 * the top of the box and the vertical one of the part that hangs.
 *
 * With columns that are fine to the contact distance r the edge is a cylinder of that radius: the
 * capstan equation holds, dT = mu T da along the turn, and the turn itself weighs: rows have the
 * normals of the step's end. Asserted for ways of up to 0.06 of r a step; beyond a tenth the
 * ribbon's own stretch and an excess of friction show. A coarse ribbon turns at few vertices, at
 * worst at one: over a corner of angle a the tensions have the ratio (1 + mu tan(a/2)) / (1 - mu
 * tan(a/2)). */
#include "support/pins.h"
#include "support/small_world.h"
#include "support/test_support.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#define GRAVITY 9.81
#define RIGHT_ANGLE 1.5707963267948966
#define AREA_DENSITY 1.0 /* [kg/m^2] */
#define AIR_DAMPING 0.5  /* [1/s] */
#define SPEED 0.05       /* [m/s] of the pull */
#define SETTLING 0.2     /* [s] before the pull ... */
#define START 0.2        /* [s] ... and how long it takes to come to its speed, and to be steady */
#define REACH 0.5        /* contacts count so many contact distances beyond the edge */
enum { ROWS = 3 };

typedef struct edge_case {
    double contact_distance; /* [m] the edge's radius */
    double column;           /* [m] from one column of vertices to the next */
    double top, hanging;     /* [m] lengths of the ribbon on the box and below, without the turn */
    double step;             /* [s] */
    double seconds;          /* of steady sliding */
    double friction;
} edge_case;

typedef struct edge_run {
    const edge_case *edge;
    tulle_world *world;
    tulle_cloth_id ribbon;
    size_t columns;
    double *arc; /* [m] length along the ribbon at rest, of each column */
} edge_run;

/* The box fills x < 0, z < 0; the ribbon lies along the top, turns around y, and hangs. `length`
 * counts from its end on the top. */
static void place_column(const edge_case *edge, double length, double place[2]) {
    double const radius = edge->contact_distance, turn = length - edge->top;
    double const angle = fmin(fmax(turn / radius, 0.0), RIGHT_ANGLE);
    place[0] = fmin(turn, 0.0) + radius * sin(angle);
    place[1] = radius * cos(angle) - fmax(turn - radius * RIGHT_ANGLE, 0.0);
}

static tulle_mesh make_ribbon(edge_run *run, double **rest) {
    const edge_case *const edge = run->edge;
    double const length = edge->top + edge->contact_distance * RIGHT_ANGLE + edge->hanging;
    run->columns = (size_t)lround(length / edge->column) + 1;
    tulle_shape_def shape = tulle_shape_def_default(TULLE_SHAPE_RECTANGLE);
    shape.size[0] = length;
    shape.size[1] = (ROWS - 1) * 2.0 * edge->column;
    shape.resolution[0] = (uint32_t)run->columns;
    shape.resolution[1] = ROWS;
    tulle_mesh mesh = small_shape(shape, 0.5 * length, 0.0, 0.0);
    *rest = malloc(3 * mesh.vertex_count * sizeof **rest);
    assert_non_null(*rest);
    for (size_t v = 0; v < mesh.vertex_count; v++) {
        double *const x = mesh.positions + 3 * v, place[2];
        for (int k = 0; k < 3; k++) (*rest)[3 * v + (size_t)k] = x[k];
        place_column(edge, x[0], place);
        x[0] = place[0];
        x[2] = place[1];
    }
    return mesh;
}

/* Holds the ribbon's end on the top, then pulls it at SPEED. */
static void add_ribbon(edge_run *run) {
    double *rest;
    tulle_mesh mesh = make_ribbon(run, &rest);
    tulle_cloth_def def = tulle_cloth_def_default();
    def.mesh = tulle_mesh_get_view(&mesh);
    def.rest_positions = rest;
    def.material.area_density = AREA_DENSITY;
    def.material.springs.stretch_stiffness =
        300.0; /* stiffer ones feel how a step leaves the arc */
    def.material.springs.stiffening_strain = 0.0;
    def.material.springs.bend_stiffness = 1e-9;
    def.material.air_damping = AIR_DAMPING;
    def.material.friction = run->edge->friction;
    double const end = SETTLING + 10.0;
    tulle_keyframe const keys[2] = {
        {.time = SETTLING, .rotation_vector = {0, 0, 0}},
        {.time = end, .translation = {-10.0 * SPEED, 0.0, 0.0}, .rotation_vector = {0, 0, 0}}};
    uint32_t held[ROWS];
    uint32_t count = 0;
    for (uint32_t v = 0; v < mesh.vertex_count; v++)
        if (rest[3 * v] < 1e-9 && count < ROWS) held[count++] = v;
    assert_int_equal(count, ROWS);
    tulle_pin pin = make_pin(held, ROWS, (double)INFINITY);
    pin.motion = (tulle_motion){.keys = keys, .key_count = 2};
    def.pins = &pin;
    def.pin_count = 1;
    tulle_error error = {0};
    if (tulle_world_add_cloth(run->world, &def, &run->ribbon, &error) != TULLE_OK)
        fail_msg("%s", error.message);
    run->arc = malloc(mesh.vertex_count * sizeof *run->arc);
    assert_non_null(run->arc);
    for (size_t v = 0; v < mesh.vertex_count; v++) run->arc[v] = rest[3 * v];
    tulle_mesh_destroy(&mesh);
    free(rest);
}

static void add_box(edge_run *run) {
    tulle_shape_def shape = tulle_shape_def_default(TULLE_SHAPE_BOX);
    shape.size[0] = 0.5;
    shape.size[1] = 0.23;
    shape.size[2] = 0.6;
    tulle_mesh box = small_shape(shape, -0.25, 0.0037, -0.3);
    tulle_obstacle_def def = tulle_obstacle_def_default();
    def.mesh = tulle_mesh_get_view(&box);
    def.friction = run->edge->friction;
    tulle_obstacle_id id;
    assert_int_equal(tulle_world_add_obstacle(run->world, &def, &id, NULL), TULLE_OK);
    tulle_mesh_destroy(&box);
}

static edge_run make_run(const edge_case *edge) {
    edge_run run = {.edge = edge};
    tulle_world_def def = tulle_world_def_default();
    def.membrane = TULLE_MEMBRANE_SPRINGS;
    def.contact_distance = edge->contact_distance;
    def.threads = 1;
    assert_int_equal(tulle_world_create(&def, &run.world, NULL), TULLE_OK);
    add_ribbon(&run);
    add_box(&run);
    return run;
}

/* [N] Sum of forces on the ribbon near the edge; counts the loaded contacts there that stick. */
static unsigned sum_forces(const edge_run *run, double force[3]) {
    const tulle_contact *contacts;
    size_t count;
    unsigned sticking = 0;
    force[0] = force[1] = force[2] = 0.0;
    assert_int_equal(tulle_world_get_contacts(run->world, &contacts, &count, NULL), TULLE_OK);
    for (size_t i = 0; i < count; i++) {
        const tulle_contact *const c = &contacts[i];
        double const reach = -REACH * run->edge->contact_distance;
        if (c->object_a == c->object_b || c->position[0] < reach || c->position[2] < reach)
            continue;
        double const sign = c->object_a == 0 ? 1.0 : -1.0;
        for (int k = 0; k < 3; k++) force[k] += sign * c->impulse[k] / run->edge->step;
        sticking += c->state == TULLE_CONTACT_STICK;
    }
    return sticking;
}

/* Tensions [N] where the ribbon hangs and where it lies on the top, and the push upwards [N], by
 * the closed forms; the weights of what lies or turns where sum_forces looks are in them. */
typedef struct edge_forces {
    double hanging, top, up;
} edge_forces;

static edge_forces find_expected(const edge_run *run) {
    const edge_case *const edge = run->edge;
    double const radius = edge->contact_distance;
    double const m = edge->friction;
    double const per_length = (ROWS - 1) * 2.0 * edge->column * AREA_DENSITY * GRAVITY;
    size_t count;
    const double *const x = tulle_cloth_get_positions(run->world, run->ribbon, &count);
    double border = 0.0; /* [m] of the ribbon's length: where the turn ends */
    for (size_t v = 0; v < count; v++)
        if (x[3 * v + 2] > 0.0) border = fmax(border, run->arc[v] + x[3 * v + 2]);
    double const length = edge->top + radius * RIGHT_ANGLE + edge->hanging;
    double const hanging = (length - border) * per_length * (1.0 + AIR_DAMPING * SPEED / GRAVITY);
    double const growth = exp(m * RIGHT_ANGLE);
    /* the integrals of exp(m a) sin a and exp(m a) cos a over the turn */
    double const lifted = (m * growth + 1.0) / (1.0 + m * m);
    double const pressed = (growth - m) / (1.0 + m * m);
    double const turn = per_length * radius * (lifted + m * pressed);
    double const flat = REACH * radius * per_length;
    return (edge_forces){.hanging = hanging,
                         .top = growth * hanging + turn + edge->friction * flat,
                         .up = hanging + per_length * radius * RIGHT_ANGLE + flat};
}

typedef struct edge_result {
    double ratio;            /* mean of the tensions' */
    double top, up;          /* mean forces over the expected ones */
    double lowest, highest;  /* of the former in single steps */
    double slowest, fastest; /* vertices, over SPEED */
    double way;              /* [m] of the hanging end */
    unsigned sticking, rescues;
} edge_result;

/* [m] Height of the hanging end. */
static double find_end(const edge_run *run) {
    size_t count;
    const double *const x = tulle_cloth_get_positions(run->world, run->ribbon, &count);
    double lowest = 0.0;
    for (size_t v = 0; v < count; v++) lowest = fmin(lowest, x[3 * v + 2]);
    return lowest;
}

static void add_speeds(const edge_run *run, edge_result *result) {
    size_t count;
    const double *const v = tulle_cloth_get_velocities(run->world, run->ribbon, &count);
    for (size_t k = 0; k < count; k++) {
        double const speed = hypot(v[3 * k], v[3 * k + 2]) / SPEED;
        result->slowest = fmin(result->slowest, speed);
        result->fastest = fmax(result->fastest, speed);
    }
}

static edge_result pull(const edge_case *edge) {
    edge_run run = make_run(edge);
    edge_result result = {.lowest = 1e9, .slowest = 1e9};
    long const first = lround((SETTLING + START) / edge->step);
    long const steps = lround(edge->seconds / edge->step);
    for (long i = 0; i < first + steps; i++) {
        tulle_step_report report;
        tulle_error error = {0};
        if (i == first) result.way = -find_end(&run);
        if (tulle_world_step(run.world, edge->step, &report, &error) != TULLE_OK)
            fail_msg("%s", error.message);
        result.rescues += (unsigned)(report.rescue_impact_zones + report.rescue_component_scalings +
                                     report.rescue_global_scalings);
        if (i < first) continue;
        double force[3];
        result.sticking += sum_forces(&run, force);
        edge_forces const expected = find_expected(&run);
        double const top = force[0] / expected.top;
        result.ratio += force[0] / expected.hanging / (double)steps;
        result.top += top / (double)steps;
        result.up += force[2] / expected.up / (double)steps;
        result.lowest = fmin(result.lowest, top);
        result.highest = fmax(result.highest, top);
        add_speeds(&run, &result);
    }
    result.way += find_end(&run);
    print_message("friction %.1f, contact distance %g, columns %g m, steps 1/%.0f s: tension %.4f "
                  "of the expected one, in steps %.3f .. %.3f; ratio %.3f; load %.4f; speeds %.3f "
                  ".. %.3f; way %.4f m; %u stick, %u rescues\n",
                  edge->friction, edge->contact_distance, edge->column, 1.0 / edge->step,
                  result.top, result.lowest, result.highest, result.ratio, result.up,
                  result.slowest, result.fastest, result.way, result.sticking, result.rescues);
    tulle_world_destroy(run.world);
    free(run.arc);
    return result;
}

static void a_fine_ribbon_slides_by_the_capstan_equation(void **state) {
    (void)state;
    double const steps[] = {1.0 / 360.0, 1.0 / 90.0, 1.0 / 90.0}, frictions[] = {0.3, 0.3, 0.0};
    for (int i = 0; i < 3; i++) {
        edge_case const edge = {0.01, 0.0033, 0.03, 0.12, steps[i], 0.4, frictions[i]};
        edge_result const result = pull(&edge);
        assert_true(fabs(result.top - 1.0) < 0.02);
        assert_true(fabs(result.up - 1.0) < 0.02);
        assert_true(result.lowest > 0.9 && result.highest < 1.1);
        assert_true(result.slowest > 0.9 && result.fastest < 1.1);
        assert_true(result.sticking == 0 && result.rescues == 0);
    }
}

/* Columns of three contact distances: the hanging part swings as corners pass, and comes along. */
static void a_coarse_ribbon_does_not_catch(void **state) {
    (void)state;
    double const steps[] = {1.0 / 360.0, 1.0 / 90.0}, friction = 0.3;
    double const corner = (1.0 + friction) / (1.0 - friction);
    for (int i = 0; i < 2; i++) {
        edge_case const edge = {0.004, 0.012, 0.05, 0.2, steps[i], 0.96, friction};
        edge_result const result = pull(&edge);
        assert_true(result.ratio > 1.0 && result.ratio < 1.1 * corner);
        assert_true(fabs(result.way - SPEED * edge.seconds) < 0.25 * edge.column);
        assert_int_equal(result.rescues, 0);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_fine_ribbon_slides_by_the_capstan_equation),
        cmocka_unit_test(a_coarse_ribbon_does_not_catch),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
