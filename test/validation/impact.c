/* impact.c - sheets that hit: the law of restitution on a plane; momentum and energy of two sheets
 * that collide in free flight.
 *
 * A vertex weighs a third of its triangles. Momenta are sums over vertices, about the origin. */
#include "support/paper_options.h"
#include "validation/stage.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const double CONTACT_DISTANCE = 3e-3; /* [m] */
static const double DROP = 0.7;              /* [m] */
enum { SHEETS = 2 };

/* Speed of a free fall through the contact plane, from a state near it: what gravity still adds or
 * has taken on the way there is reckoned off. */
static double find_plane_speed(const tulle_world *world, tulle_cloth_id sheet) {
    double place[3], velocity[3];
    validate_mean_position(world, sheet, place);
    validate_mean_velocity(world, sheet, velocity);
    double const above = fmax(place[2] - CONTACT_DISTANCE, 0.0);
    return sqrt(velocity[2] * velocity[2] + 2.0 * VALIDATION_GRAVITY * above);
}

/* Part of its speed with which a sheet rebounds from a plane. */
static double drop_sheet(validation_run *run, double restitution) {
    tulle_world_def def = validate_world_def(run);
    def.contact_distance = CONTACT_DISTANCE;
    tulle_world *const world = validate_make_world(run, &def);
    uint32_t const count = validate_options(run)->is_quick ? 9 : 17;
    tulle_mesh *const mesh = stage_make_sheet(
        run, (stage_sheet){.size = {0.3, 0.3}, .counts = {count, count}, .middle = {0, 0, DROP}});
    tulle_cloth_def cloth = stage_cloth_def(mesh);
    cloth.material.restitution = restitution;
    tulle_cloth_id const sheet = validate_add_cloth(run, world, &cloth);
    tulle_mesh *const plane = stage_make_sheet(
        run, (stage_sheet){.size = {2.0, 2.0}, .counts = {5, 5}, .middle = {0.013, 0.017, 0.0}});
    tulle_obstacle_def floor = tulle_obstacle_def_default();
    floor.mesh = tulle_mesh_get_view(plane);
    floor.restitution = restitution;
    validate_add_obstacle(run, world, &floor);
    double before = 0.0;
    for (int i = 0; i < 90; i++) {
        double place[3];
        validate_mean_position(world, sheet, place);
        before = find_plane_speed(world, sheet);
        tulle_step_report const report = validate_step(run, world, VALIDATION_STEP);
        if (report.stick_contacts + report.slip_contacts > 0) break;
    }
    validate_step(run, world, VALIDATION_STEP); /* a hit within a step may end in the next */
    return find_plane_speed(world, sheet) / before;
}

static void drops(validation_run *run) {
    double const restitutions[3] = {0.0, 0.5, 1.0};
    for (int i = 0; i < 3; i++) {
        double const k = restitutions[i];
        char what[80];
        snprintf(what, sizeof what, "restitution %g: rebound over impact speed", k);
        double const measured = drop_sheet(run, k);
        validate_row(run, what, measured, "", k > 0.0 ? within(k, 0.02) : at_most(0.02),
                     "k_c; speeds at the contact plane");
    }
}

/* Masses [kg] of a mesh at rest. */
static double *find_masses(validation_run *run, const tulle_mesh *mesh, double area_density) {
    double *const masses = validate_allocate(run, mesh->vertex_count * sizeof(double));
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        const uint32_t *const corners = mesh->triangles + 3 * t;
        double a[3], b[3];
        for (size_t c = 0; c < 3; c++) {
            a[c] = mesh->positions[3 * corners[1] + c] - mesh->positions[3 * corners[0] + c];
            b[c] = mesh->positions[3 * corners[2] + c] - mesh->positions[3 * corners[0] + c];
        }
        double const area = 0.5 * hypot(hypot(a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2]),
                                        a[0] * b[1] - a[1] * b[0]);
        for (int k = 0; k < 3; k++) masses[corners[k]] += area_density * area / 3.0;
    }
    return masses;
}

typedef struct flight {
    tulle_world *world;
    tulle_cloth_id sheets[SHEETS];
    double *masses[SHEETS];
} flight;

typedef struct momentum {
    double linear[3], angular[3];
    double linear_scale, angular_scale; /* sums of magnitudes */
} momentum;

static momentum find_momentum(const flight *made) {
    momentum sum = {0};
    for (int i = 0; i < SHEETS; i++) {
        size_t count = 0;
        const double *x = tulle_cloth_get_positions(made->world, made->sheets[i], &count);
        const double *v = tulle_cloth_get_velocities(made->world, made->sheets[i], NULL);
        for (size_t k = 0; k < count; k++, x += 3, v += 3) {
            double const m = made->masses[i][k];
            double const turn[3] = {x[1] * v[2] - x[2] * v[1], x[2] * v[0] - x[0] * v[2],
                                    x[0] * v[1] - x[1] * v[0]};
            for (int c = 0; c < 3; c++) {
                sum.linear[c] += m * v[c];
                sum.angular[c] += m * turn[c];
            }
            sum.linear_scale += m * hypot(hypot(v[0], v[1]), v[2]);
            sum.angular_scale += m * hypot(hypot(turn[0], turn[1]), turn[2]);
        }
    }
    return sum;
}

static double find_distance(const double a[3], const double b[3]) {
    return hypot(hypot(a[0] - b[0], a[1] - b[1]), a[2] - b[2]);
}

/* Two sheets fly at each other without gravity, aside by a third of their side, so that they turn
 * after they have hit. */
static flight make_flight(validation_run *run, double restitution, double friction) {
    tulle_world_def def = validate_world_def(run);
    memset(def.gravity, 0, sizeof def.gravity);
    def.contact_distance = CONTACT_DISTANCE;
    def.friction_cloth_cloth = friction;
    change_paper(&def)->cg_tolerance = 1e-10;
    flight made = {.world = validate_make_world(run, &def)};
    uint32_t const count = validate_options(run)->is_quick ? 9 : 13;
    for (int i = 0; i < SHEETS; i++) {
        tulle_mesh *const mesh =
            stage_make_sheet(run, (stage_sheet){.size = {0.3, 0.3},
                                                .counts = {count, count + 2 * (uint32_t)i},
                                                .middle = {0.1 * i, 0.033 * i, 0.031 * i}});
        tulle_cloth_def cloth = stage_cloth_def(mesh);
        cloth.material.restitution = restitution;
        cloth.velocity[0] = i ? -0.1 : 0.2;
        cloth.velocity[2] = i ? -1.0 : 1.0;
        made.masses[i] = find_masses(run, mesh, cloth.material.area_density);
        made.sheets[i] = validate_add_cloth(run, made.world, &cloth);
    }
    return made;
}

typedef struct flight_record {
    double linear, angular; /* largest change of momentum over the sum of magnitudes */
    double rise;            /* of energy over the least so far, over that of the start */
    double weights;         /* how far weights of a contact miss 1 and -1 */
    uint64_t contacts;
} flight_record;

/* How far the shares of contact impulses are from balance. */
static double find_imbalance(validation_run *run, tulle_world *world) {
    const tulle_contact *contacts = NULL;
    size_t count = 0;
    double worst = 0.0;
    if (tulle_world_get_contacts(world, &contacts, &count, NULL) != TULLE_OK)
        validate_give_up(run, "no contacts");
    for (size_t i = 0; i < count; i++) {
        const double *const w = contacts[i].weights;
        worst = fmax(worst, fabs(w[0] + w[1] + w[2] + w[3]));
    }
    return worst;
}

static flight_record fly(validation_run *run, double restitution, double friction,
                         double time_step) {
    flight const made = make_flight(run, restitution, friction);
    momentum const start = find_momentum(&made);
    flight_record record = {0};
    double least = (double)INFINITY, first = 0.0;
    long const steps = lround(0.3 / time_step);
    validate_plan(run, steps);
    for (long i = 0; i < steps; i++) {
        tulle_step_report const report = validate_step(run, made.world, time_step);
        momentum const now = find_momentum(&made);
        double const energy = report.kinetic_energy + report.elastic_energy;
        if (i == 0) first = energy;
        record.linear =
            fmax(record.linear, find_distance(now.linear, start.linear) / start.linear_scale);
        record.angular =
            fmax(record.angular, find_distance(now.angular, start.angular) / start.angular_scale);
        record.rise = fmax(record.rise, (energy - least) / first);
        least = fmin(least, energy);
        record.weights = fmax(record.weights, find_imbalance(run, made.world));
        record.contacts += report.stick_contacts + report.slip_contacts;
    }
    return record;
}

/* All that holds whatever the restitution, the friction and the step. */
static void report_flight(validation_run *run, const char *name, const flight_record *record) {
    char what[120];
    snprintf(what, sizeof what, "%s: loaded contacts, summed", name);
    validate_row(run, what, (double)record->contacts, "", at_least(1.0), "they hit");
    snprintf(what, sizeof what, "%s: change of linear momentum, relative", name);
    validate_row(run, what, record->linear, "", at_most(1e-12), "kept");
    snprintf(what, sizeof what, "%s: shares of a contact impulse, sum", name);
    validate_row(run, what, record->weights, "", at_most(1e-12), "action and reaction");
    snprintf(what, sizeof what, "%s: rise of energy, relative", name);
    validate_row(run, what, record->rise, "", at_most(1e-12), "never grows");
}

/* Flights with steps of 1/90 s and of a quarter of it each time: what the integrator does to
 * angular momentum is of its order, 1, once steps are so short that another step is not another
 * collision. */
static void refine(validation_run *run, const char *name, double restitution) {
    bool const is_quick = validate_options(run)->is_quick;
    int const count = is_quick ? 3 : 4;
    double step = VALIDATION_STEP, before = 0.0;
    flight_record worst = {.contacts = UINT64_MAX};
    for (int i = 0; i < count; i++, step /= 4.0) {
        flight_record const record = fly(run, restitution, 0.0, step);
        worst.contacts = record.contacts < worst.contacts ? record.contacts : worst.contacts;
        worst.linear = fmax(worst.linear, record.linear);
        worst.weights = fmax(worst.weights, record.weights);
        worst.rise = fmax(worst.rise, record.rise);
        validate_plot_point(run, name, step, record.angular);
        char what[120];
        snprintf(what, sizeof what, "%s: change of angular momentum, step 1/%g s", name,
                 round(1.0 / step));
        validate_row(run, what, record.angular, "", nothing(), "");
        if (i > 0) {
            snprintf(what, sizeof what, "%s: step 1/%g s over one four times as long", name,
                     round(1.0 / step));
            expectation const order = is_quick ? at_most(0.35) : within(0.25, 0.2);
            validate_row(run, what, record.angular / before, "", i == count - 1 ? order : nothing(),
                         "1/4: the integrator's order");
        }
        before = record.angular;
    }
    report_flight(run, name, &worst);
}

static void collides(validation_run *run) {
    double const restitutions[3] = {0.0, 0.5, 1.0};
    validate_start_plot(run, &(validation_plot){.name = "impact_order",
                                                .title = "Two sheets that collide in flight",
                                                .x_label = "step [s]",
                                                .y_label = "change of angular momentum, relative",
                                                .is_x_logarithmic = true,
                                                .is_y_logarithmic = true});
    for (int i = 0; i < 3; i++) {
        char name[40];
        snprintf(name, sizeof name, "restitution %g", restitutions[i]);
        refine(run, name, restitutions[i]);
    }
    flight_record const rough = fly(run, 0.0, 0.4, VALIDATION_STEP);
    report_flight(run, "friction 0.4", &rough);
    validate_row(run, "friction 0.4: change of angular momentum", rough.angular, "", nothing(),
                 "friction acts a contact distance apart");
}

const experiment impact_experiments[] = {
    {"impact.drop", "a flat sheet rebounds from a plane", drops, false},
    {"impact.flight", "two sheets collide in free flight", collides, false},
    {0},
};
