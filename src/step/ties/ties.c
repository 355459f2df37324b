/* step/ties/ties.c - where on a surface a vertex is tied, and ties within a step: they lead, pull
 * and break.
 *
 * A tie that leads its vertex sets a target, as a pin does. Every other tie is a spring whose force
 * is taken at the end of the substep, F = -k (d + h J u): d is how far the vertex is from its place
 * at the start, J u how fast it leaves it. So springs are stable at any stiffness. The height over
 * a triangle of cloth turns with it to first order. Over holders that do not answer it keeps its
 * direction within a substep.
 *
 * A place is barycentric coordinates of the vertex' foot in the plane of a triangle, and its height
 * over that plane. A foot beyond the triangle's border has coordinates below 0. */
#include "step/ties/ties.h"

#include "base/error.h"
#include "contact/rows/row_motion.h"
#include "geom/distance.h"
#include "step/bodies/bodies.h"
#include "step/bodies/bodies_sleep.h"
#include "step/sleep/cloth_sleep.h"

#include <math.h>
#include <string.h>

/* [m^2 over edge^2] twice the area of a triangle below this share of its longest edge squared has
 * no plane. */
static const double FLAT = 1e-12;

typedef struct corner_frame {
    vec3 corner, along, beside, normal; /* first corner, two edges, unit normal */
    bool is_flat;                       /* and the normal is zero */
} corner_frame;

static corner_frame make_frame(const uint32_t corners[3], const double *positions) {
    vec3 const a = vec3_load(positions, corners[0]);
    vec3 const along = vec3_sub(vec3_load(positions, corners[1]), a);
    vec3 const beside = vec3_sub(vec3_load(positions, corners[2]), a);
    vec3 const area = vec3_cross(along, beside);
    double const size = vec3_norm(area);
    bool const is_flat = !(size > FLAT * (vec3_norm2(along) + vec3_norm2(beside)));
    vec3 const zero = {0.0, 0.0, 0.0};
    return (corner_frame){a, along, beside, is_flat ? zero : vec3_scale(area, 1.0 / size), is_flat};
}

/* [m] Where the tie has its vertex, with its object at `positions`. */
static vec3 get_tie_place(const world_tie *tie, const double *positions) {
    if (tie->corners[0] == TULLE_NONE) return vec3_load(tie->point, 0);
    corner_frame const frame = make_frame(tie->corners, positions);
    vec3 place = vec3_add_scaled(frame.corner, frame.along, tie->weights[1]);
    place = vec3_add_scaled(place, frame.beside, tie->weights[2]);
    return vec3_add_scaled(place, frame.normal, tie->height);
}

/* How its place turns with the triangle, for ties to cloth. */
static void get_tie_tilt(const world_tie *tie, const double *positions, row_tilt *tilt) {
    corner_frame const frame = make_frame(tie->corners, positions);
    vec3 const area = vec3_cross(frame.along, frame.beside);
    double const factor = frame.is_flat ? 0.0 : tie->height / vec3_norm(area);
    /* the gradient of a corner's coordinate is n x (the edge that faces it) / |area| */
    tilt->normal = frame.normal;
    tilt->arms[1] = vec3_scale(vec3_cross(frame.beside, frame.normal), factor);
    tilt->arms[2] = vec3_scale(vec3_cross(frame.normal, frame.along), factor);
    tilt->arms[0] = vec3_scale(vec3_add(tilt->arms[1], tilt->arms[2]), -1.0);
}

static void load_corners(const step_model *model, uint32_t triangle, uint32_t corners[3]) {
    for (size_t k = 0; k < 3; k++) corners[k] = model->topo.triangles[3 * (size_t)triangle + k];
}

void step_set_tie_place(const step_model *model, step_work *work, uint32_t vertex,
                        uint32_t triangle, const double weights[3], world_tie *tie) {
    const double *const positions = work->start->positions;
    load_corners(model, triangle, tie->corners);
    corner_frame const frame = make_frame(tie->corners, positions);
    vec3 const way = vec3_sub(vec3_load(positions, vertex), frame.corner);
    for (int k = 0; k < 3; k++) tie->weights[k] = weights[k];
    tie->height = vec3_dot(way, frame.normal);
}

/* Coordinates of the vertex' own foot. */
static void set_own_place(const step_model *model, step_work *work, uint32_t vertex,
                          uint32_t triangle, const closest_points *closest, world_tie *tie) {
    uint32_t corners[3];
    load_corners(model, triangle, corners);
    corner_frame const frame = make_frame(corners, work->start->positions);
    double weights[3] = {-closest->weights[1], -closest->weights[2], -closest->weights[3]};
    if (!frame.is_flat) {
        vec3 const way = vec3_sub(vec3_load(work->start->positions, vertex), frame.corner);
        double const aa = vec3_norm2(frame.along), bb = vec3_norm2(frame.beside);
        double const ab = vec3_dot(frame.along, frame.beside), determinant = aa * bb - ab * ab;
        double const a = vec3_dot(way, frame.along), b = vec3_dot(way, frame.beside);
        weights[1] = (bb * a - ab * b) / determinant;
        weights[2] = (aa * b - ab * a) / determinant;
        weights[0] = 1.0 - weights[1] - weights[2];
    }
    step_set_tie_place(model, work, vertex, triangle, weights, tie);
}

bool step_find_tie_place(const step_model *model, step_work *work, uint32_t vertex,
                         uint32_t surface, double distance, world_tie *tie) {
    const double *const positions = work->start->positions;
    const surface_range *const range = &work->surfaces[surface];
    vec3 const x = vec3_load(positions, vertex);
    double least2 = distance * distance; /* may be infinite */
    uint32_t nearest = TULLE_NONE;
    closest_points found = {0};
    for (uint32_t t = range->triangle_begin; t < range->triangle_end; t++) {
        uint32_t corners[3];
        load_corners(model, t, corners);
        if (corners[0] == vertex || corners[1] == vertex || corners[2] == vertex) continue;
        vec3 const a = vec3_load(positions, corners[0]), b = vec3_load(positions, corners[1]);
        vec3 const c = vec3_load(positions, corners[2]);
        closest_points const closest = closest_vertex_triangle((const vec3[4]){x, a, b, c});
        if (closest.distance2 > least2 || (nearest != TULLE_NONE && closest.distance2 == least2))
            continue;
        least2 = closest.distance2;
        nearest = t;
        found = closest;
    }
    if (nearest == TULLE_NONE) return false;
    set_own_place(model, work, vertex, nearest, &found, tie);
    return true;
}

/* ---- in a step ---- */

/* A rigid tie leads its vertex unless its other end answers. */
static bool is_led(const step_model *model, const step_work *work, const world_tie *tie) {
    uint32_t const surface = get_tie_surface(model, tie);
    if (isfinite(tie->stiffness)) return false;
    if (surface == TULLE_NONE) return true;
    const surface_range *const range = &work->surfaces[surface];
    return range->is_obstacle && !range->is_body;
}

/* ---- stage 1 ---- */

void step_lead_ties(const step_model *model, motion_state *state, step_work *work) {
    size_t const cloth_count = model->cloths.count;
    double const end = state->time + work->sub.time_step;
    double const length = work->step_end - work->start->time;
    double const left = 1.0 - (end - work->start->time) / length; /* of the step, as a share */
    size_t kept = 0;
    for (size_t i = 0; i < state->ties.count; i++) {
        world_tie const tie = state->ties.data[i];
        uint32_t const surface = get_tie_surface(model, &tie);
        bool const is_on_obstacle = surface != TULLE_NONE && surface >= cloth_count;
        bool const has_left =
            is_on_obstacle &&
            state->time >= model->obstacles.data[surface - cloth_count].disappear_time;
        if (has_left || state->time >= tie.release_time) {
            step_wake_cloth_at(model, state, tie.vertex);
            step_wake_cloth_at(model, state, tie.corners[0]);
            continue;
        }
        state->ties.data[kept++] = tie;
        if (is_on_obstacle && model->body_count > 0 && model->surface_bodies[surface] != TULLE_NONE)
            step_wake_body(model, state, model->surface_bodies[surface]);
        if (!is_led(model, work, &tie)) continue;
        /* it returns to its place until the end of the step */
        vec3 const from = vec3_load(work->start->positions, tie.vertex);
        vec3 const away = vec3_sub(from, get_tie_place(&tie, work->start->positions));
        vec3 const place = get_tie_place(&tie, work->targets);
        vec3_store(work->targets, tie.vertex, vec3_add_scaled(place, away, fmax(left, 0.0)));
        work->is_fixed[tie.vertex] = 1;
        work->active_inverse_masses[tie.vertex] = 0.0;
    }
    state->ties.count = kept;
}

static void make_spring(const motion_state *state, const step_work *work, const world_tie *tie,
                        tie_spring *spring) {
    const double *const x0 = state->positions;
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
    set_row_bodies(&work->sub.scene, &spring->row);
    if (!is_point && tie->height != 0.0 && tie->corners[0] < work->sub.scene.cloth_vertex_count) {
        get_tie_tilt(tie, x0, &spring->tilt);
        frame->tilt = &spring->tilt;
    }
    spring->away = vec3_sub(vec3_load(x0, tie->vertex), get_tie_place(tie, x0));
    spring->away = vec3_add(spring->away, get_row_curvature(&work->sub.scene, &spring->row));
}

tulle_status step_make_ties(const step_model *model, motion_state *state, step_work *work) {
    size_t const count = state->ties.count;
    work->sub.springs = NULL;
    work->sub.spring_count = 0;
    if (count == 0) return TULLE_OK;
    work->sub.springs = ARENA_NEW(&work->scratch, tie_spring, count);
    uint32_t *const tied = ARENA_NEW(&work->scratch, uint32_t, model->cloth_vertex_count);
    double *const places = ARENA_NEW(&work->scratch, double, 3 * model->cloth_vertex_count);
    if (!work->sub.springs || !tied || !places) return TULLE_ERROR_OUT_OF_MEMORY;
    for (size_t v = 0; v < model->cloth_vertex_count; v++) tied[v] = TULLE_NONE;
    for (size_t i = 0; i < count; i++) {
        const world_tie *const tie = &state->ties.data[i];
        if (is_led(model, work, tie)) continue;
        make_spring(state, work, tie, &work->sub.springs[work->sub.spring_count++]);
        if (isfinite(tie->stiffness)) continue;
        tied[tie->vertex] = get_tie_surface(model, tie);
        vec3_store(places, tie->vertex, get_tie_place(tie, model->rest));
    }
    work->sub.scene.tied_surfaces = tied;
    work->sub.scene.tied_places = places;
    return TULLE_OK;
}

/* ---- after the solve ---- */

/* [N s] as the solve counts it, on the tied vertex. */
static vec3 get_spring_impulse(const tie_spring *spring, double time_step, const double *u) {
    vec3 const velocity = get_coupled_velocity(&spring->row, u);
    vec3 const wanted = vec3_scale(spring->away, -1.0 / time_step);
    return vec3_scale(vec3_sub(wanted, velocity), spring->pull);
}

double step_measure_tie_work(step_work *work) {
    double const h = work->sub.time_step, force_time = work->system.force_time;
    const double *const u = work->sub.mean_velocity;
    double sum = 0.0;
    for (size_t i = 0; i < work->sub.spring_count; i++) {
        const tie_spring *const spring = &work->sub.springs[i];
        vec3 const velocity = get_coupled_velocity(&spring->row, u);
        vec3 const end = vec3_add_scaled(spring->away, velocity, h);
        double const stiffness = spring->pull / (force_time * h); /* [N/m] */
        sum += 0.5 * stiffness * (vec3_norm2(spring->away) - vec3_norm2(end));
        vec3 const led = vec3_sub(velocity, get_free_velocity(&work->sub.scene, &spring->row, u));
        vec3 const force = vec3_scale(get_spring_impulse(spring, h, u), 1.0 / force_time);
        sum -= h * vec3_dot(force, led);
    }
    return sum;
}

/* [N s] as the solve counts them: what leads each vertex gives it, A u - b without contacts and
 * springs. Null without memory. */
static double *measure_leads(const step_model *model, step_work *work) {
    const double *const u = work->sub.mean_velocity;
    size_t const count = model->cloth_vertex_count, all = count + 2 * model->body_count;
    double *const sum = ARENA_NEW(&work->scratch, double, 3 * all);
    if (!sum) return NULL;
    block_matrix_operator matrix = {&work->system.matrix, work->threads};
    block_matrix_apply(&matrix, u, sum);
    for (size_t k = 0; k < 3 * count; k++) sum[k] -= work->system.right_hand_side[k];
    memset(sum + 3 * count, 0, 3 * (all - count) * sizeof(double));
    for (size_t i = 0; i < work->rows.rows.count; i++) {
        const contact_row *const row = &work->rows.rows.data[i];
        add_row_impulse(row, count, vec3_scale(row->solve.impulse, -1.0), sum);
    }
    for (size_t i = 0; i < work->sub.spring_count; i++) {
        const tie_spring *const spring = &work->sub.springs[i];
        vec3 const impulse = get_spring_impulse(spring, work->sub.time_step, u);
        add_row_impulse(&spring->row, count, vec3_scale(impulse, -1.0), sum);
    }
    return sum;
}

tulle_status step_break_ties(const step_model *model, motion_state *state, step_work *work) {
    if (state->ties.count == 0) return TULLE_OK;
    arena_mark const mark = arena_get_mark(&work->scratch);
    const double *const leads =
        work->sub.spring_count < state->ties.count ? measure_leads(model, work) : work->sub.end;
    if (!leads) return TULLE_ERROR_OUT_OF_MEMORY;
    size_t kept = 0, broken = 0, spring = 0;
    world_tie first = {0};
    double first_force = 0.0;
    for (size_t i = 0; i < state->ties.count; i++) {
        world_tie tie = state->ties.data[i];
        if (work->surfaces[model->vertex_surface[tie.vertex]].is_asleep) { /* it pulls as it did */
            spring += !is_led(model, work, &tie);
            state->ties.data[kept++] = tie;
            continue;
        }
        vec3 const impulse = is_led(model, work, &tie)
                                 ? vec3_load(leads, tie.vertex)
                                 : get_spring_impulse(&work->sub.springs[spring++],
                                                      work->sub.time_step, work->sub.mean_velocity);
        vec3 const force = vec3_scale(impulse, 1.0 / work->system.force_time);
        vec3_store(tie.force, 0, force);
        if (vec3_norm(force) > tie.break_force) {
            if (broken++ == 0) first = tie, first_force = vec3_norm(force);
        } else {
            state->ties.data[kept++] = tie;
        }
    }
    uint32_t const cloth = model->vertex_surface[first.vertex];
    if (broken > 0 && work->broken.kind == FINDING_NONE)
        work->broken =
            (step_finding){.kind = FINDING_BREAKS,
                           .surface = cloth,
                           .vertices = {first.vertex - work->surfaces[cloth].vertex_begin},
                           .attachment = first.number,
                           .count = broken,
                           .numbers = {first_force, first.break_force}};
    state->ties.count = kept;
    arena_release(&work->scratch, mark);
    return TULLE_OK;
}
