/* world/ties/tie_motion.c - ties within a step: what they lead, pull and break.
 *
 * A tie that leads its vertex sets a target, as a pin does. Every other one is a spring whose force
 * is that at the end of the substep, F = -k (d + h J u): d is how far the vertex is from its place
 * at the start, J u how fast it leaves it. So springs are stable at any stiffness. The height over
 * a triangle of cloth turns with it to first order. With what does not answer, it keeps its
 * direction within a substep. */
#include "base/error.h"
#include "contact/rows/row_motion.h"
#include "world/bodies/bodies.h"
#include "world/bodies/bodies_sleep.h"
#include "world/sleep/cloth_sleep.h"
#include "world/ties/ties.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* A rigid tie leads its vertex unless its other end answers. */
static bool is_led(const tulle_world *world, const world_tie *tie) {
    uint32_t const surface = get_tie_surface(world, tie);
    if (isfinite(tie->stiffness)) return false;
    if (surface == TULLE_NONE) return true;
    const surface_range *const range = &world->model.surfaces[surface];
    return range->is_obstacle && !range->is_body;
}

/* ---- stage 1 ---- */

void world_lead_ties(step_context *context) {
    tulle_world *const world = context->world;
    motion_state *const state = context->state;
    size_t const cloth_count = world->model.cloths.count;
    double const end = state->time + (context->is_script_frozen ? 0.0 : context->time_step);
    double const length = world->work.step_end - world->now.time;
    double const left = 1.0 - (end - world->now.time) / length; /* of the step, as a share */
    size_t kept = 0;
    for (size_t i = 0; i < state->ties.count; i++) {
        world_tie const tie = state->ties.data[i];
        uint32_t const surface = get_tie_surface(world, &tie);
        bool const is_on_obstacle = surface != TULLE_NONE && surface >= cloth_count;
        bool const has_left =
            is_on_obstacle &&
            state->time >= world->model.obstacles.data[surface - cloth_count].disappear_time;
        if (has_left || state->time >= tie.release_time) {
            world_wake_cloth_at(world, state, tie.vertex);
            world_wake_cloth_at(world, state, tie.corners[0]);
            continue;
        }
        state->ties.data[kept++] = tie;
        if (is_on_obstacle && world->model.body_count > 0 &&
            world->model.surface_bodies[surface] != TULLE_NONE)
            world_wake_body(world, state, world->model.surface_bodies[surface]);
        if (!is_led(world, &tie)) continue;
        /* what it is away from its place, it makes up for until the end of the step */
        vec3 const from = vec3_load(world->now.positions, tie.vertex);
        vec3 const away = vec3_sub(from, world_get_tie_place(&tie, world->now.positions));
        vec3 const place = world_get_tie_place(&tie, world->work.targets);
        vec3_store(world->work.targets, tie.vertex, vec3_add_scaled(place, away, fmax(left, 0.0)));
        world->work.is_fixed[tie.vertex] = 1;
        world->work.active_inverse_masses[tie.vertex] = 0.0;
    }
    state->ties.count = kept;
}

static void make_spring(const step_context *context, const world_tie *tie, tie_spring *spring) {
    const double *const x0 = context->state->positions;
    *spring = (tie_spring){.stiffness = tie->stiffness};
    row_frame *const frame = &spring->row.frame;
    frame->kind = FEATURE_VERTEX_TRIANGLE;
    frame->vertices[0] = tie->vertex;
    frame->weights[0] = 1.0;
    bool const is_point = tie->corners[0] == TULLE_NONE; /* then all four are the vertex itself */
    for (int k = 0; k < 3; k++) {
        frame->vertices[k + 1] = is_point ? tie->vertex : tie->corners[k];
        frame->weights[k + 1] = is_point ? 0.0 : -tie->weights[k];
    }
    set_row_bodies(&context->scene, &spring->row);
    if (!is_point && tie->height != 0.0 && tie->corners[0] < context->scene.cloth_vertex_count) {
        world_get_tie_tilt(tie, x0, &spring->tilt);
        frame->tilt = &spring->tilt;
    }
    spring->away = vec3_sub(vec3_load(x0, tie->vertex), world_get_tie_place(tie, x0));
    spring->away = vec3_add(spring->away, get_row_curvature(&context->scene, &spring->row));
}

tulle_status world_make_ties(step_context *context) {
    tulle_world *const world = context->world;
    size_t const count = context->state->ties.count;
    context->springs = NULL;
    context->spring_count = 0;
    if (count == 0) return TULLE_OK;
    context->springs = ARENA_NEW(&world->work.scratch, tie_spring, count);
    uint32_t *const tied =
        ARENA_NEW(&world->work.scratch, uint32_t, world->model.cloth_vertex_count);
    double *const places =
        ARENA_NEW(&world->work.scratch, double, 3 * world->model.cloth_vertex_count);
    if (!context->springs || !tied || !places) return TULLE_ERROR_OUT_OF_MEMORY;
    for (size_t v = 0; v < world->model.cloth_vertex_count; v++) tied[v] = TULLE_NONE;
    for (size_t i = 0; i < count; i++) {
        const world_tie *const tie = &context->state->ties.data[i];
        if (is_led(world, tie)) continue;
        make_spring(context, tie, &context->springs[context->spring_count++]);
        if (isfinite(tie->stiffness)) continue;
        tied[tie->vertex] = get_tie_surface(world, tie);
        vec3_store(places, tie->vertex, world_get_tie_place(tie, world->model.rest));
    }
    context->scene.tied_surfaces = tied;
    context->scene.tied_places = places;
    return TULLE_OK;
}

/* ---- after the solve ---- */

/* [N s] as the solve counts it, on the tied vertex. */
static vec3 get_spring_impulse(const tie_spring *spring, double time_step, const double *u) {
    vec3 const velocity = get_coupled_velocity(&spring->row, u);
    vec3 const wanted = vec3_scale(spring->away, -1.0 / time_step);
    return vec3_scale(vec3_sub(wanted, velocity), spring->pull);
}

double world_measure_tie_work(const step_context *context) {
    double const h = context->time_step, force_time = context->world->work.system.force_time;
    const double *const u = context->mean_velocity;
    double work = 0.0;
    for (size_t i = 0; i < context->spring_count; i++) {
        const tie_spring *const spring = &context->springs[i];
        vec3 const velocity = get_coupled_velocity(&spring->row, u);
        vec3 const end = vec3_add_scaled(spring->away, velocity, h);
        double const stiffness = spring->pull / (force_time * h); /* [N/m] */
        work += 0.5 * stiffness * (vec3_norm2(spring->away) - vec3_norm2(end));
        vec3 const led = vec3_sub(velocity, get_free_velocity(&context->scene, &spring->row, u));
        vec3 const force = vec3_scale(get_spring_impulse(spring, h, u), 1.0 / force_time);
        work -= h * vec3_dot(force, led);
    }
    return work;
}

/* [N s] as the solve counts them: what leads each vertex gives it, A u - b without contacts and
 * springs. Null without memory. */
static double *measure_leads(const step_context *context) {
    tulle_world *const world = context->world;
    const double *const u = context->mean_velocity;
    size_t const count = world->model.cloth_vertex_count, all = count + 2 * world->model.body_count;
    double *const sum = ARENA_NEW(&world->work.scratch, double, 3 * all);
    if (!sum) return NULL;
    block_matrix_operator matrix = {&world->work.system.matrix, world->work.threads};
    block_matrix_apply(&matrix, u, sum);
    for (size_t k = 0; k < 3 * count; k++) sum[k] -= world->work.system.right_hand_side[k];
    memset(sum + 3 * count, 0, 3 * (all - count) * sizeof(double));
    for (size_t i = 0; i < world->work.rows.rows.count; i++) {
        const contact_row *const row = &world->work.rows.rows.data[i];
        add_row_impulse(row, count, vec3_scale(row->solve.impulse, -1.0), sum);
    }
    for (size_t i = 0; i < context->spring_count; i++) {
        const tie_spring *const spring = &context->springs[i];
        vec3 const impulse = get_spring_impulse(spring, context->time_step, u);
        add_row_impulse(&spring->row, count, vec3_scale(impulse, -1.0), sum);
    }
    return sum;
}

static void tell_broken(tulle_world *world, const world_tie *first, double force, size_t count) {
    uint32_t const cloth = world->model.vertex_surface[first->vertex];
    if (count == 0 || world->message[0]) return;
    snprintf(
        world->message, sizeof world->message,
        "'%s' breaks off at %zu %s, first at vertex %u of attachment %u, held by %.3g N and by "
        "at most %.3g N",
        world_surface_name(world, cloth), count, count == 1 ? "vertex" : "vertices",
        first->vertex - world->model.surfaces[cloth].vertex_begin, first->number, force,
        first->break_force);
}

tulle_status world_break_ties(step_context *context) {
    tulle_world *const world = context->world;
    motion_state *const state = context->state;
    if (state->ties.count == 0) return TULLE_OK;
    arena_mark const mark = arena_get_mark(&world->work.scratch);
    const double *const leads =
        context->spring_count < state->ties.count ? measure_leads(context) : context->end;
    if (!leads) return TULLE_ERROR_OUT_OF_MEMORY;
    size_t kept = 0, broken = 0, spring = 0;
    world_tie first = {0};
    double first_force = 0.0;
    for (size_t i = 0; i < state->ties.count; i++) {
        world_tie tie = state->ties.data[i];
        if (world->model.surfaces[world->model.vertex_surface[tie.vertex]]
                .is_asleep) { /* it pulls as it did */
            spring += !is_led(world, &tie);
            state->ties.data[kept++] = tie;
            continue;
        }
        vec3 const impulse = is_led(world, &tie)
                                 ? vec3_load(leads, tie.vertex)
                                 : get_spring_impulse(&context->springs[spring++],
                                                      context->time_step, context->mean_velocity);
        vec3 const force = vec3_scale(impulse, 1.0 / world->work.system.force_time);
        vec3_store(tie.force, 0, force);
        if (vec3_norm(force) > tie.break_force) {
            if (broken++ == 0) first = tie, first_force = vec3_norm(force);
        } else {
            state->ties.data[kept++] = tie;
        }
    }
    tell_broken(world, &first, first_force, broken);
    state->ties.count = kept;
    arena_release(&world->work.scratch, mark);
    return TULLE_OK;
}
