/* app/mend/solve.c - see solve.h. */
#include "app/mend/solve.h"

#include "app/cli/interrupt.h"
#include "base/error.h"

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
/* Departures are small beside the solution, which is the way to the next frame. */
static const double CG_TOLERANCE = 1e-8;
/* [s], [kg/m^2] Only their ratio to the other forces counts. */
static const double TIME_STEP = 0.02, AREA_DENSITY = 0.2;
/* [N/m] The least that a material has: the given shape decides how long edges are. */
static const double STRETCH_STIFFNESS = 1e-12;
/* Between cloth and bodies: cloth that hangs far from the given way lies still where it is pressed
 * on, and does not creep into heaps. */
static const double FRICTION = 0.3;
/* [N s] as a part of what moves a vertex by a contact distance: less presses on nothing. */
static const double PRESS_SHARE = 1e-3;

/* The count alone decides, so the end is the same at every speed. */
static int is_stopped(void *context) {
    mend_solver *const solver = context;
    solver->is_over =
        solver->solve_limit > 0 &&
        tulle_world_get_step_progress(solver->world).solve_count > solver->solve_limit;
    return solver->is_over || interrupt_is_pending();
}

/* Lengths in the files' unit: the contact distance of the options, or a part of an edge. */
static tulle_status choose_gaps(mend_solver *solver, const mend_follow_options *options,
                                const double *first, tulle_world_def *def, tulle_error *error) {
    const mend_surface *const cloth = &solver->input->surfaces[0];
    size_t const count = mend_get_cloth_count(solver->input);
    tulle_mesh_view const mesh = {first, count, solver->input->triangles, cloth->triangle_end};
    tulle_mesh_info info;
    tulle_status status = tulle_mesh_validate(mesh, TULLE_MESH_ROLE_CLOTH, error);
    if (status == TULLE_OK) status = tulle_mesh_get_info(mesh, &info, error);
    if (status != TULLE_OK) return status;
    double extent = 0.0;
    for (size_t i = 0; i < 3 * solver->input->vertex_count; i++)
        extent = fmax(extent, fabs(first[i]));
    solver->scale = exp2(round(log2(WORLD_EDGE / info.edge_length_mean)));
    double const ulps = GAP_ULPS * 0x1p-23 * extent, least = 2.0 * ulps, most = 1.0 / solver->scale;
    double const automatic = fmax(CONTACT_SHARE * info.edge_length_mean, least);
    double const contact = options->gap > 0.0 ? options->gap : automatic;
    if (options->gap > 0.0 && (options->gap < least || options->gap > most))
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "--gap is %g; in this animation it should be from %.3g, so that "
                         "rounding does not close it, to %.3g",
                         options->gap, least, most);
    def->contact_distance = solver->contact_distance = solver->scale * contact;
    def->minimum_gap = solver->scale * fmin(fmax(GAP_SHARE * automatic, ulps),
                                            options->gap > 0.0 ? 0.5 * contact : (double)INFINITY);
    return TULLE_OK;
}

/* ---- the world ---- */

/* Adds the cloth at `positions`, in the world's unit, and the bodies. */
static tulle_status add_surfaces(const mend_solver *solver, double reach, const double *positions,
                                 tulle_error *error) {
    const mend_input *const input = solver->input;
    tulle_cloth_def def = tulle_cloth_def_default();
    tulle_material *const material = &def.material;
    double const length = reach * WORLD_EDGE;
    def.name = "the cloth";
    def.mesh = (tulle_mesh_view){positions, mend_get_cloth_count(input), input->triangles,
                                 input->surfaces[0].triangle_end};
    def.has_flat_rest = 1;
    material->area_density = AREA_DENSITY;
    /* as much as what draws a vertex does, over the length */
    material->springs = (tulle_springs){.stretch_stiffness = STRETCH_STIFFNESS,
                                        .bend_stiffness = AREA_DENSITY / (TIME_STEP * TIME_STEP) *
                                                          length * length * length * length};
    material->stretch_damping = material->bend_damping = material->air_damping = 0.0;
    material->friction = FRICTION;
    material->dynamic_friction = -1.0;
    material->restitution = 0.0;
    tulle_status status = tulle_world_add_cloth(solver->world, &def, NULL, error);
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
        status = tulle_world_add_obstacle(solver->world, &body, NULL, error);
    }
    return status;
}

/* Ids of a world that nothing was removed from. */
static tulle_obstacle_id get_body(size_t surface) {
    return (tulle_obstacle_id){(uint32_t)(surface - 1), 1};
}

static const tulle_cloth_id the_cloth = {0, 1};

static const double *get_positions(const mend_solver *solver, size_t surface) {
    return surface == 0 ? tulle_cloth_get_positions(solver->world, the_cloth, NULL)
                        : tulle_obstacle_get_positions(solver->world, get_body(surface), NULL);
}

/* What is led, and bodies that do not lag, are at their targets to the bit. */
static void read_positions(const mend_solver *solver, double *positions) {
    for (size_t i = 0; i < solver->input->surface_count; i++) {
        const mend_surface *const surface = &solver->input->surfaces[i];
        const double *const found = get_positions(solver, i);
        size_t const begin = 3 * (size_t)surface->vertex_begin;
        for (size_t k = begin; k < 3 * (size_t)surface->vertex_end; k++)
            positions[k] = found[k - begin] / solver->scale;
    }
}

tulle_status mend_solver_open(const mend_input *input, const mend_follow_options *options,
                              double *now, mend_solver *solver, tulle_error *error) {
    *solver = (mend_solver){.input = input};
    tulle_world_def def = tulle_world_def_default();
    tulle_status status = choose_gaps(solver, options, now, &def, error);
    if (status != TULLE_OK) return status;
    size_t const all = 3 * input->vertex_count;
    solver->scaled = calloc(2 * all + 3 * mend_get_cloth_count(input), sizeof *solver->scaled);
    if (!solver->scaled)
        return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "out of memory for %zu vertices",
                         input->vertex_count);
    for (size_t i = 0; i < all; i++) solver->scaled[i] = solver->scale * now[i];
    memset(def.gravity, 0, sizeof def.gravity);
    def.wind.drag_coefficient = 0.0;
    def.membrane = TULLE_MEMBRANE_SPRINGS;
    tulle_paper_options paper = tulle_paper_options_default();
    paper.cg_tolerance = CG_TOLERANCE;
    def.paper = &paper;
    def.friction_cloth_cloth = 0.0;
    def.start_intersections = TULLE_START_UNTANGLE;
    def.on_pinch = TULLE_ON_PINCH_STOP;
    def.threads = options->threads;
    status = tulle_world_create(&def, &solver->world, error);
    if (status == TULLE_OK) tulle_world_set_stop_request(solver->world, is_stopped, solver);
    if (status == TULLE_OK) status = add_surfaces(solver, options->reach, solver->scaled, error);
    if (status == TULLE_OK) status = tulle_world_start(solver->world, error);
    if (status == TULLE_OK) read_positions(solver, now);
    return status;
}

void mend_solver_close(mend_solver *solver) {
    tulle_world_destroy(solver->world);
    free(solver->scaled);
    *solver = (mend_solver){0};
}

/* ---- a move ---- */

/* Puts all where the move begins, unless it is there: frames without trouble do without the world,
 * and what comes out of it is rounded. */
static tulle_status place(const mend_solver *solver, const double *positions, tulle_error *error) {
    bool is_there = true;
    for (size_t i = 0; i < solver->input->surface_count; i++) {
        const mend_surface *const surface = &solver->input->surfaces[i];
        size_t const begin = surface->vertex_begin, count = surface->vertex_end - begin;
        is_there = is_there && memcmp(get_positions(solver, i), positions + 3 * begin,
                                      3 * count * sizeof *positions) == 0;
    }
    return is_there
               ? TULLE_OK
               : tulle_world_place(solver->world, positions, solver->input->vertex_count, error);
}

/* Marks led vertices that contact presses on. */
static tulle_status find_pressed(const mend_solver *solver, const mend_move *move,
                                 mend_moved *moved, tulle_error *error) {
    const tulle_contact *contacts;
    size_t contact_count;
    double const mass = AREA_DENSITY * WORLD_EDGE * WORLD_EDGE;
    double const least = PRESS_SHARE * mass * solver->contact_distance / TIME_STEP;
    memset(moved->pressed, 0, mend_get_cloth_count(solver->input));
    moved->pressed_count = 0;
    tulle_status const status =
        tulle_world_get_contacts(solver->world, &contacts, &contact_count, error);
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

/* Gives the world where all is to go. */
static tulle_status lead(const mend_solver *solver, const mend_move *move, const double *targets,
                         const double *departures, unsigned char *is_led, tulle_error *error) {
    const mend_input *const input = solver->input;
    size_t const count = mend_get_cloth_count(input);
    for (size_t v = 0; v < count; v++) is_led[v] = !move->is_free[v];
    tulle_cloth_targets const drawn = {targets, departures, is_led, count};
    tulle_status status = tulle_cloth_set_targets(solver->world, the_cloth, &drawn, error);
    for (size_t i = 1; i < input->surface_count && status == TULLE_OK; i++) {
        const mend_surface *const surface = &input->surfaces[i];
        if (surface->is_still) continue;
        status = tulle_obstacle_set_next_positions(
            solver->world, get_body(i), targets + 3 * (size_t)surface->vertex_begin,
            surface->vertex_end - surface->vertex_begin, TULLE_TRAVEL_MOVE, error);
    }
    return status;
}

tulle_status mend_solver_move(mend_solver *solver, const mend_move *move, mend_moved *moved,
                              tulle_error *error) {
    size_t const all = 3 * solver->input->vertex_count;
    size_t const cloth = 3 * mend_get_cloth_count(solver->input);
    double *const now = solver->scaled, *const targets = now + all;
    double *const departures = targets + all;
    for (size_t i = 0; i < all; i++) {
        now[i] = solver->scale * move->now[i];
        targets[i] = solver->scale * move->targets[i];
    }
    for (size_t i = 0; i < cloth; i++) departures[i] = solver->scale * move->departures[i];
    solver->is_over = false;
    tulle_status status = place(solver, now, error);
    if (status == TULLE_OK) status = lead(solver, move, targets, departures, moved->pressed, error);
    if (status == TULLE_OK) status = tulle_world_step(solver->world, TIME_STEP, NULL, error);
    if (status == TULLE_ERROR_INTERRUPTED && solver->is_over && !interrupt_is_pending())
        status = error_set(error, TULLE_ERROR_STEP_FAILED,
                           "the cloth finds no way to where it is given in %u solves",
                           solver->solve_limit);
    if (status != TULLE_OK) return status;
    read_positions(solver, moved->end);
    return find_pressed(solver, move, moved, error);
}
