/* app/mend/solve.c - see solve.h.
 *
 * With w = m / h^2 + k by vertex, K the bending and g the targets, the step makes
 *
 *     w (u - u*) + K u = contact,        u = x - g,  u* the wanted departure:
 *
 * the start velocity leads to g + (w h^2 / m) u*, and a spring of stiffness k draws each free
 * vertex to g + K g / k, which takes away what the bending makes of g itself. */
#include "app/mend/solve.h"

#include "app/cli/interrupt.h"
#include "base/error.h"

#include "tulle/attach.h"
#include "tulle/live.h"
#include "tulle/tulle.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* [m] of a mean edge in the world, whose settings are made for lengths like it. */
static const double WORLD_EDGE = 0.01;
/* The contact distance is this part of a mean edge. */
static const double CONTACT_SHARE = 0.05;
/* The minimum gap as a part of the contact distance, and in last places of a float at the largest
 * coordinate: rounding to float then closes no gap. */
static const double GAP_SHARE = 0.025, GAP_ULPS = 8.0;
/* What bends the given shape and the springs that undo it cancel to this part of them. */
static const double CG_TOLERANCE = 1e-8;
/* Lengths at rest beside those of the first frame. A world tries a step that stretches cloth much
 * in shorter ones; here the given shape decides, however long its edges. */
static const double REST_LENGTH = 4.0;
/* [s], [kg/m^2] Only their ratio to the other forces counts. */
static const double TIME_STEP = 0.02, AREA_DENSITY = 0.2;
/* Share of the draw that the spring has; the rest is inertia. */
static const double SPRING_SHARE = 0.2;
/* Stretch stiffness as a part of the draw over an edge. It is there because a world wants one. */
static const double STRETCH_SHARE = 1e-9;
/* Between cloth and bodies: cloth that hangs far from the given way lies still where it is pressed
 * on, and does not creep into heaps. */
static const double FRICTION = 0.3;
/* [N s] as a part of what moves a vertex by a contact distance: less presses on nothing. */
static const double PRESS_SHARE = 1e-3;

/* A move that is let go after so many solves, and whether it was. */
typedef struct solve_limit {
    const tulle_world *world;
    uint32_t most; /* 0: no limit */
    bool is_over;
} solve_limit;

/* The count alone decides, so the end is the same at every speed. */
static int is_stopped(void *context) {
    solve_limit *const limit = context;
    limit->is_over =
        limit->is_over ||
        (limit->most > 0 && tulle_world_get_step_progress(limit->world).solve_count > limit->most);
    return limit->is_over || interrupt_is_pending();
}

tulle_status mend_solver_open(const mend_input *input, const double *first, mend_solver *solver,
                              tulle_error *error) {
    const mend_surface *const cloth = &input->surfaces[0];
    size_t const count = mend_get_cloth_count(input);
    *solver = (mend_solver){.input = input};
    tulle_mesh_view const mesh = {first, count, input->triangles, cloth->triangle_end};
    tulle_mesh_info info;
    tulle_status status = tulle_mesh_validate(mesh, TULLE_MESH_ROLE_CLOTH, error);
    if (status == TULLE_OK) status = tulle_mesh_get_info(mesh, &info, error);
    if (status != TULLE_OK) return status;
    double extent = 0.0;
    for (size_t i = 0; i < 3 * input->vertex_count; i++) extent = fmax(extent, fabs(first[i]));
    solver->scale = exp2(round(log2(WORLD_EDGE / info.edge_length_mean)));
    double const ulps = GAP_ULPS * 0x1p-23 * extent;
    solver->least_distance = 2.0 * ulps;
    solver->contact_distance = fmax(CONTACT_SHARE * info.edge_length_mean, 2.0 * ulps);
    solver->minimum_gap = fmax(GAP_SHARE * solver->contact_distance, ulps);
    solver->rest = calloc(count, 3 * sizeof *solver->rest);
    solver->scaled = calloc(2 * input->vertex_count + 6 * count, 3 * sizeof *solver->scaled);
    solver->vertices = calloc(count, sizeof *solver->vertices);
    if (!solver->rest || !solver->scaled || !solver->vertices)
        return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "out of memory for %zu vertices", count);
    for (size_t i = 0; i < 3 * count; i++) solver->rest[i] = REST_LENGTH * solver->scale * first[i];
    tulle_mesh_view const rest = {solver->rest, count, input->triangles, cloth->triangle_end};
    return mend_plate_open(rest, &solver->plate, error);
}

void mend_solver_close(mend_solver *solver) {
    mend_plate_close(&solver->plate);
    free(solver->rest);
    free(solver->scaled);
    free(solver->vertices);
    *solver = (mend_solver){0};
}

/* ---- the world ---- */

/* [N/m] per area at rest: inertia, and all that draws a free vertex. */
static double get_inertia(void) {
    return AREA_DENSITY / (REST_LENGTH * REST_LENGTH * TIME_STEP * TIME_STEP);
}
static double get_draw(void) { return get_inertia() / (1.0 - SPRING_SHARE); }

static tulle_status make_world(const mend_solver *solver, tulle_start_intersections start,
                               solve_limit *limit, tulle_world **world, tulle_error *error) {
    tulle_world_def def = tulle_world_def_default();
    memset(def.gravity, 0, sizeof def.gravity);
    def.wind.drag_coefficient = 0.0;
    def.contact_distance = solver->scale * solver->contact_distance;
    def.minimum_gap = solver->scale * solver->minimum_gap;
    def.membrane = TULLE_MEMBRANE_SPRINGS;
    def.quality = TULLE_QUALITY_NORMAL;
    def.cg_tolerance = CG_TOLERANCE;
    def.friction_cloth_cloth = 0.0;
    def.start_intersections = start;
    def.on_pinch = TULLE_ON_PINCH_STOP;
    def.threads = solver->threads;
    tulle_status const status = tulle_world_create(&def, world, error);
    limit->world = *world;
    if (status == TULLE_OK) tulle_world_set_stop_request(*world, is_stopped, limit);
    return status;
}

static double get_rigidity(const mend_solver *solver) {
    double const length = solver->reach * WORLD_EDGE, rest_length = REST_LENGTH * length;
    return get_draw() * length * length * rest_length * rest_length * REST_LENGTH * REST_LENGTH;
}

/* The cloth when it is moved; all zero when it only starts. */
typedef struct cloth_motion {
    const double *velocities;
    const tulle_pin *pin; /* or null */
    bool moves;
} cloth_motion;

/* Adds the cloth at `positions`, in the world's unit, and the bodies. */
static tulle_status add_surfaces(const mend_solver *solver, const double *positions,
                                 const cloth_motion *motion, tulle_world *world,
                                 tulle_error *error) {
    const mend_input *const input = solver->input;
    tulle_cloth_def def = tulle_cloth_def_default();
    tulle_material *const material = &def.material;
    def.name = "the cloth";
    def.mesh = (tulle_mesh_view){positions, mend_get_cloth_count(input), input->triangles,
                                 input->surfaces[0].triangle_end};
    def.rest_positions = solver->rest;
    def.has_flat_rest = 1;
    def.velocities = motion->velocities;
    def.pins = motion->pin;
    def.pin_count = motion->pin ? 1 : 0;
    material->area_density = AREA_DENSITY / (REST_LENGTH * REST_LENGTH);
    material->springs =
        (tulle_springs){.stretch_stiffness = STRETCH_SHARE * get_draw() * WORLD_EDGE * WORLD_EDGE,
                        .bend_stiffness = get_rigidity(solver)};
    material->stretch_damping = material->bend_damping = material->air_damping = 0.0;
    material->friction = FRICTION;
    material->dynamic_friction = -1.0;
    material->restitution = 0.0;
    tulle_status status = tulle_world_add_cloth(world, &def, NULL, error);
    for (size_t i = 1; i < input->surface_count && status == TULLE_OK; i++) {
        const mend_surface *const surface = &input->surfaces[i];
        size_t const begin = 3 * (size_t)surface->vertex_begin;
        tulle_obstacle_def body = tulle_obstacle_def_default();
        body.name = convert_source_get_name(&surface->source);
        body.mesh =
            (tulle_mesh_view){positions + begin, surface->vertex_end - surface->vertex_begin,
                              input->local_triangles + 3 * (size_t)surface->triangle_begin,
                              surface->triangle_end - surface->triangle_begin};
        body.friction = FRICTION;
        body.restitution = 0.0;
        body.dynamic_friction = -1.0;
        body.drive = surface->is_still ? TULLE_DRIVE_NONE : TULLE_DRIVE_DEFORMING;
        status = tulle_world_add_obstacle(world, &body, NULL, error);
    }
    return status;
}

/* Ids of a world that nothing was removed from. */
static tulle_obstacle_id get_body(size_t surface) {
    return (tulle_obstacle_id){(uint32_t)(surface - 1), 1};
}

static const tulle_cloth_id the_cloth = {0, 1};

static void read_cloth(const mend_solver *solver, const tulle_world *world, double *end) {
    const double *const positions = tulle_cloth_get_positions(world, the_cloth, NULL);
    for (size_t i = 0; i < 3 * mend_get_cloth_count(solver->input); i++)
        end[i] = positions[i] / solver->scale;
}

tulle_status mend_solver_start(mend_solver *solver, double *now, tulle_error *error) {
    tulle_world *world = NULL;
    solve_limit limit = {.most = 0};
    for (size_t i = 0; i < 3 * solver->input->vertex_count; i++)
        solver->scaled[i] = solver->scale * now[i];
    tulle_status status = make_world(solver, TULLE_START_UNTANGLE, &limit, &world, error);
    if (status == TULLE_OK)
        status =
            add_surfaces(solver, solver->scaled, &(cloth_motion){.moves = false}, world, error);
    if (status == TULLE_OK) status = tulle_world_start(world, error);
    if (status == TULLE_OK) read_cloth(solver, world, now);
    tulle_world_destroy(world);
    return status;
}

/* ---- a move ---- */

/* In scratch memory, in the world's unit. */
typedef struct move_values {
    double *now, *targets;                 /* all vertices */
    double *velocities, *bending, *points; /* the cloth; points those of free vertices */
    double *pinned;                        /* targets of pinned vertices */
    size_t free_count, pinned_count;
    double stiffness; /* [N/m] of a spring */
} move_values;

static move_values make_values(mend_solver *solver, const mend_move *move) {
    size_t const all = 3 * solver->input->vertex_count;
    size_t const count = mend_get_cloth_count(solver->input);
    move_values values = {.now = solver->scaled, .targets = solver->scaled + all};
    values.velocities = values.targets + all;
    values.bending = values.velocities + 3 * count;
    values.points = values.bending + 3 * count;
    values.pinned = values.points + 3 * count;
    for (size_t i = 0; i < all; i++) {
        values.now[i] = solver->scale * move->now[i];
        values.targets[i] = solver->scale * move->targets[i];
    }
    mend_plate_apply(&solver->plate, values.targets, values.bending);
    double const rigidity = get_rigidity(solver);
    double area = 0.0;
    for (size_t v = 0; v < count; v++) area += solver->plate.areas[v] / (double)count;
    values.stiffness = SPRING_SHARE * get_draw() * area;
    for (size_t v = 0; v < count; v++) values.free_count += move->is_free[v] != 0;
    size_t free_place = 0, pinned_place = values.free_count;
    for (size_t v = 0; v < count; v++) {
        bool const is_free = move->is_free[v] != 0;
        size_t const place = is_free ? free_place++ : pinned_place++;
        solver->vertices[place] = (uint32_t)v;
        double const inertia = get_inertia() * solver->plate.areas[v];
        double const excess = 1.0 + values.stiffness / inertia;
        for (size_t k = 0; k < 3; k++) {
            size_t const i = 3 * v + k;
            double const lead = is_free ? excess * solver->scale * move->departures[i] : 0.0;
            values.velocities[i] = (values.targets[i] + lead - values.now[i]) / TIME_STEP;
            if (is_free)
                values.points[3 * place + k] =
                    values.targets[i] + rigidity * values.bending[i] / values.stiffness;
            else
                values.pinned[3 * (place - values.free_count) + k] = values.targets[i];
        }
    }
    values.pinned_count = count - values.free_count;
    return values;
}

/* Marks pinned vertices that contact presses on. */
static tulle_status find_pressed(const mend_solver *solver, tulle_world *world,
                                 const mend_move *move, mend_moved *moved, tulle_error *error) {
    const tulle_contact *contacts;
    size_t contact_count, count = mend_get_cloth_count(solver->input);
    memset(moved->pressed, 0, count);
    moved->pressed_count = 0;
    tulle_status const status = tulle_world_get_contacts(world, &contacts, &contact_count, error);
    double const mass = AREA_DENSITY * WORLD_EDGE * WORLD_EDGE;
    double const least = PRESS_SHARE * mass * solver->scale * solver->contact_distance / TIME_STEP;
    for (size_t i = 0; i < contact_count && status == TULLE_OK; i++) {
        const tulle_contact *const contact = &contacts[i];
        const double *const impulse = contact->impulse;
        if (!(fabs(impulse[0]) + fabs(impulse[1]) + fabs(impulse[2]) > least)) continue;
        size_t const first = contact->kind == TULLE_CONTACT_VERTEX_FACE ? 1 : 2;
        for (size_t k = 0; k < 4; k++) {
            if ((k < first ? contact->object_a : contact->object_b) != 0) continue;
            uint32_t const vertex = contact->vertices[k];
            if (contact->weights[k] == 0.0 || move->is_free[vertex] || moved->pressed[vertex])
                continue;
            moved->pressed[vertex] = 1;
            moved->pressed_count++;
        }
    }
    return status;
}

static tulle_status lead(const mend_solver *solver, const move_values *values, tulle_world *world,
                         tulle_error *error) {
    const mend_input *const input = solver->input;
    tulle_status status = TULLE_OK;
    if (values->pinned_count > 0)
        status = tulle_cloth_set_pin_targets(world, the_cloth, 0, values->pinned,
                                             values->pinned_count, error);
    for (size_t i = 1; i < input->surface_count && status == TULLE_OK; i++) {
        const mend_surface *const surface = &input->surfaces[i];
        if (surface->is_still) continue;
        status = tulle_obstacle_set_next_positions(
            world, get_body(i), values->targets + 3 * (size_t)surface->vertex_begin,
            surface->vertex_end - surface->vertex_begin, TULLE_TRAVEL_MOVE, error);
    }
    return status;
}

/* Positions at the end; what is pinned, and bodies, are at their targets to the bit. */
static void read_end(const mend_solver *solver, const tulle_world *world, const mend_move *move,
                     double *end) {
    const mend_input *const input = solver->input;
    read_cloth(solver, world, end);
    for (size_t i = 1; i < input->surface_count; i++) {
        const mend_surface *const surface = &input->surfaces[i];
        const double *const positions = tulle_obstacle_get_positions(world, get_body(i), NULL);
        size_t const begin = 3 * (size_t)surface->vertex_begin;
        for (size_t k = begin; k < 3 * (size_t)surface->vertex_end; k++)
            end[k] = surface->is_still ? move->now[k] : positions[k - begin] / solver->scale;
    }
}

tulle_status mend_solver_move(mend_solver *solver, const mend_move *move, mend_moved *moved,
                              tulle_error *error) {
    move_values const values = make_values(solver, move);
    tulle_pin pin = tulle_pin_default();
    pin.vertices = solver->vertices + values.free_count;
    pin.vertex_count = values.pinned_count;
    cloth_motion const motion = {values.velocities, values.pinned_count > 0 ? &pin : NULL, true};
    tulle_attachment_def draw = tulle_attachment_def_default();
    draw.cloth = the_cloth;
    draw.vertices = solver->vertices;
    draw.vertex_count = values.free_count;
    draw.points = values.points;
    draw.stiffness = values.stiffness;
    tulle_world *world = NULL;
    tulle_step_report report;
    tulle_attachment_id id;
    solve_limit limit = {.most = move->solve_limit};
    tulle_status status = make_world(solver, TULLE_START_REFUSE, &limit, &world, error);
    if (status == TULLE_OK) status = add_surfaces(solver, values.now, &motion, world, error);
    if (status == TULLE_OK && values.free_count > 0)
        status = tulle_world_attach(world, &draw, &id, error);
    if (status == TULLE_OK) status = tulle_world_start(world, error);
    if (status == TULLE_OK) status = lead(solver, &values, world, error);
    if (status == TULLE_OK) status = tulle_world_step(world, TIME_STEP, &report, error);
    if (status == TULLE_OK) status = find_pressed(solver, world, move, moved, error);
    if (status == TULLE_OK) {
        read_end(solver, world, move, moved->end);
    }
    tulle_world_destroy(world);
    if (status == TULLE_ERROR_INTERRUPTED && limit.is_over && !interrupt_is_pending())
        status = error_set(error, TULLE_ERROR_STEP_FAILED,
                           "the cloth finds no way to where it is given in %u solves", limit.most);
    return status;
}
