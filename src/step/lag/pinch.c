/* step/lag/pinch.c - what happens when a step can move on no further, or tears cloth that is
 * squeezed.
 *
 * Cloth alone can always stand still. So only scripted vertices (obstacles, pins) that go where
 * cloth has no room can block a step. Obstacles that close on cloth tear it before they block the
 * step: the rows of each side push the cloth into the other side. Either way the step is undone,
 * and the message names the cloth and the obstacles around the place. Then it is made anew with
 * more lag (lag.h), or, where on_pinch lets nothing there lag, it is an error. */
#include "step/lag/pinch.h"

#include "step/lag/lag.h"
#include "step/lag/room.h"
#include "step/script.h"

#include <math.h>
#include <string.h>

/* The contacts of an obstacle have a common direction when the mean of theirs is longer than this.
 */
static const double DIRECTION_MIN = 0.3;

/* A step tears squeezed cloth when it makes an edge longer by over TEARING_GROWTH of its rest
 * length. Stretch up to TEARING_FREE does not count. */
static const double TEARING_GROWTH = 0.1, TEARING_FREE = 1.05;

/* Obstacles that come nearer by at most this share of the minimum gap in a step count as still. */
static const double APPROACH_SHARE = 1e-6;

bool step_is_script_moving(const step_model *model, motion_state *state, step_work *work) {
    for (size_t v = 0; v < model->vertex_count; v++) {
        if (work->active_inverse_masses[v] != 0.0) continue;
        if (memcmp(work->targets + 3 * v, state->positions + 3 * v, 3 * sizeof(double)) != 0) {
            return true;
        }
    }
    return false;
}

void step_stand_still(const step_model *model, motion_state *state) {
    size_t const vertices = model->cloth_vertex_count + 2 * model->body_count;
    size_t const bytes = 3 * vertices * sizeof(double);
    memset(state->velocities, 0, bytes);
    state->previous_time_step = 0.0;
}

/* ---- the place, and what is around it ---- */

/* The place of the pair that blocked the step last. */
static blocked_place find_blocked_place(const step_model *model, const motion_state *state,
                                        const step_work *work) {
    const commit_report *const commit = &work->lag.blocked;
    blocked_place place = {0};
    if (!commit->has_blocking) return place;
    place.is_pair = true;
    feature_pair_vertices(&model->topo, commit->blocking_kind, commit->blocking_pair,
                          place.vertices);
    uint32_t chosen = place.vertices[0];
    for (int k = 3; k >= 0; k--)
        if (work->surfaces[model->vertex_surface[place.vertices[k]]].is_body)
            chosen = place.vertices[k];
    for (int k = 3; k >= 0; k--)
        if (place.vertices[k] < model->cloth_vertex_count) chosen = place.vertices[k];
    place.surface = model->vertex_surface[chosen];
    place.position = vec3_load(state->positions, chosen);
    return place;
}

/* The obstacle that is in a pair of features with a body, or with cloth at a vertex of the place or
 * one of its neighbours. SIZE_MAX for other pairs. */
static size_t find_obstacle(const step_model *model, const uint32_t vertices[4],
                            const blocked_place *place) {
    const adjacency *const around = &model->topo.vertex_neighbours;
    bool const is_body = place->surface >= model->cloths.count;
    bool has_pinched = false, is_near = is_body;
    size_t obstacle = SIZE_MAX;
    for (int k = 0; k < 4; k++) {
        size_t const surface = model->vertex_surface[vertices[k]];
        if (is_body ? surface == place->surface : surface < model->cloths.count)
            has_pinched = true;
        else if (surface >= model->cloths.count)
            obstacle = surface - model->cloths.count;
    }
    if (!has_pinched || obstacle == SIZE_MAX) return SIZE_MAX;
    for (int k = 0; k < 16 && !is_near; k++) {
        uint32_t const vertex = place->vertices[k / 4], other = vertices[k % 4];
        is_near = other == vertex;
        for (uint32_t i = around->begin[vertex]; i < around->begin[vertex + 1]; i++)
            is_near |= around->items[i] == other;
    }
    return is_near ? obstacle : SIZE_MAX;
}

/* Marks the obstacles around a place. */
static void mark_near(const step_model *model, step_work *work, const blocked_place *place) {
    memset(work->lag.is_near, 0, model->obstacles.count);
    size_t const count = work->rows.rows.count;
    for (size_t r = 0; r < count + place->is_pair; r++) {
        const uint32_t *const vertices =
            r < count ? work->rows.rows.data[r].frame.vertices : place->vertices;
        size_t const obstacle = find_obstacle(model, vertices, place);
        if (obstacle != SIZE_MAX) work->lag.is_near[obstacle] = 1;
    }
}

/* ---- squeezed cloth that tears ---- */

/* What an obstacle does to cloth at a place. */
typedef struct pinch_side {
    vec3 direction;   /* where it pushes the cloth; unit, or zero where its contacts disagree */
    vec3 way;         /* [m] of its point nearest to the cloth in this step */
    double gap;       /* [m] there */
    double load;      /* [N s] sum of what its rows push with */
    size_t row_count; /* of those rows */
} pinch_side;

/* [m] How far the obstacle's point of a row goes in this step. */
static vec3 measure_way(const step_model *model, const motion_state *state, const step_work *work,
                        const row_frame *frame) {
    vec3 way = {0, 0, 0};
    double sum = 0.0;
    for (int k = 0; k < 4; k++) {
        uint32_t const v = frame->vertices[k];
        if (v < model->cloth_vertex_count) continue;
        vec3 const step =
            vec3_sub(vec3_load(state->positions, v), vec3_load(work->start->positions, v));
        way = vec3_add_scaled(way, step, frame->weights[k]);
        sum += frame->weights[k];
    }
    return vec3_scale(way, 1.0 / sum);
}

/* Fills `sides`, one an obstacle, zeroed before: the mean direction of its rows at the place, by
 * their loads, or alike where none carries any. */
static void measure_sides(const step_model *model, const motion_state *state, const step_work *work,
                          const blocked_place *place, pinch_side *sides) {
    for (size_t r = 0; r < 2 * work->rows.rows.count; r++) {
        const contact_row *const row = &work->rows.rows.data[r % work->rows.rows.count];
        size_t const obstacle = find_obstacle(model, row->frame.vertices, place);
        if (obstacle == SIZE_MAX) continue;
        pinch_side *const side = &sides[obstacle];
        double const load = fmax(0.0, vec3_dot(row->frame.normal, row->solve.impulse));
        if (r < work->rows.rows.count) { /* first the loads alone */
            side->load += load;
            if (side->row_count++ > 0 && row->frame.gap >= side->gap) continue;
            side->gap = row->frame.gap;
            side->way = measure_way(model, state, work, &row->frame);
            continue;
        }
        double const sign = row->frame.vertices[0] < model->cloth_vertex_count ? 1.0 : -1.0;
        side->direction = vec3_add_scaled(side->direction, row->frame.normal,
                                          sign * (side->load > 0.0 ? load : 1.0));
    }
    for (size_t i = 0; i < model->obstacles.count; i++) {
        double const norm = vec3_norm(sides[i].direction);
        double const sum = sides[i].load > 0.0 ? sides[i].load : (double)sides[i].row_count;
        bool const is_common = norm > DIRECTION_MIN * sum;
        sides[i].direction = vec3_scale(sides[i].direction, is_common ? 1.0 / norm : 0.0);
    }
}

/* Whether two obstacles that are nearer to the cloth at a place than the contact distance have come
 * nearer to each other. Free bodies give way. */
static bool is_squeezed(const step_model *model, const motion_state *state, step_work *work,
                        const blocked_place *place) {
    size_t const count = model->obstacles.count;
    arena_mark const mark = arena_get_mark(&work->scratch);
    pinch_side *const sides = ARENA_NEW_ZEROED(&work->scratch, pinch_side, count);
    bool is_so = false;
    if (sides) measure_sides(model, state, work, place, sides);
    for (size_t i = 0; sides && i < count; i++) {
        for (size_t j = 0; j < i; j++) {
            const pinch_side *const a = &sides[i], *const b = &sides[j];
            bool const has_body = work->surfaces[model->cloths.count + i].is_body ||
                                  work->surfaces[model->cloths.count + j].is_body;
            if (has_body || a->gap > model->contact_distance || b->gap > model->contact_distance ||
                !(vec3_dot(a->direction, b->direction) < OPPOSED_COSINE))
                continue;
            vec3 const across = vec3_normalize(vec3_sub(a->direction, b->direction));
            is_so |=
                vec3_dot(vec3_sub(a->way, b->way), across) > APPROACH_SHARE * model->minimum_gap;
        }
    }
    arena_release(&work->scratch, mark);
    return is_so;
}

bool step_tears_squeezed(const step_model *model, motion_state *state, step_work *work) {
    bool const may_tear =
        work->report->max_stretch > TEARING_FREE + TEARING_GROWTH && !model->cloth_model->shape;
    if (!may_tear || model->obstacles.count < 2 || work->rows.rows.count == 0) return false;
    const double *const states[3] = {model->rest, work->start->positions, state->positions};
    for (size_t e = 0; e < model->cloth_edge_count; e++) {
        uint32_t const a = model->topo.edges[2 * e], b = model->topo.edges[2 * e + 1];
        double lengths[3];
        for (int k = 0; k < 3; k++)
            lengths[k] = vec3_norm(vec3_sub(vec3_load(states[k], a), vec3_load(states[k], b)));
        double const before = lengths[1] / lengths[0], after = lengths[2] / lengths[0];
        if (!(after - fmax(before, TEARING_FREE) > TEARING_GROWTH)) continue;
        work->lag.torn_place = (blocked_place){.vertices = {a, b, a, b},
                                               .surface = model->vertex_surface[a],
                                               .position = vec3_load(work->start->positions, a)};
        if (is_squeezed(model, state, work, &work->lag.torn_place)) return true;
    }
    return false;
}

/* ---- findings ---- */

/* Notes where the step is pinched, between what, and which pins move there. */
static void note_pinch(const step_model *model, const motion_state *state, step_work *work,
                       const blocked_place *place, finding_kind kind) {
    step_finding *const finding = &work->lag.finding;
    *finding = (step_finding){.kind = kind,
                              .surface = place->surface,
                              .time = state->time,
                              .position = place->position,
                              .marks = work->lag.is_near};
    /* cloth: the pin that moves nearest to the place, and how many move */
    double nearest = (double)INFINITY;
    bool const is_body = place->surface >= model->cloths.count;
    const world_cloth *const cloth = is_body ? NULL : &model->cloths.data[place->surface];
    for (size_t p = 0; cloth && p < cloth->pin_count; p++) {
        bool moves = false;
        for (size_t k = 0; k < cloth->pins[p].vertex_count; k++) {
            size_t const v = cloth->vertex_begin + cloth->pins[p].vertices[k];
            vec3 const target = vec3_load(work->targets, v);
            if (!work->is_fixed[v] ||
                vec3_norm(vec3_sub(target, vec3_load(work->start->positions, v))) == 0.0)
                continue;
            double const distance = vec3_norm(vec3_sub(target, place->position));
            moves = true;
            if (distance < nearest) finding->vertices[0] = (uint32_t)p;
            nearest = fmin(nearest, distance);
        }
        finding->count += moves;
    }
}

void step_end_pinch(const step_model *model, motion_state *state, step_work *work) {
    lag_work *const lag = &work->lag;
    bool has_begun = false;
    for (size_t i = 0; i <= model->obstacles.count; i++) {
        bool const was = step_is_held(model, work->start, i);
        bool const is = step_is_held(model, state, i);
        if (was || is) work->report->pinched = 1;
        has_begun |= is && !was;
        lag->is_freed[i] = was && !is;
        if (lag->is_freed[i])
            lag->freed = (step_finding){
                .kind = FINDING_FOLLOWS, .time = state->time, .marks = lag->is_freed};
    }
    if (!has_begun) lag->finding.kind = FINDING_NONE;
}

/* ---- the choice ---- */

bool step_waits_at_once(const step_model *model, motion_state *state, step_work *work) {
    blocked_place const place = find_blocked_place(model, state, work);
    bool lags = model->def.on_pinch == TULLE_ON_PINCH_SLOW && work->lag.still_count > 0;
    for (int k = 0; k < 4 && place.is_pair; k++) {
        size_t const surface = model->vertex_surface[place.vertices[k]];
        lags |= surface >= model->cloths.count &&
                step_lags_now(model, work, surface - model->cloths.count);
    }
    return lags;
}

tulle_status step_handle_pinch(const step_model *model, motion_state *state, step_work *work,
                               bool is_torn) {
    blocked_place const place =
        is_torn ? work->lag.torn_place : find_blocked_place(model, state, work);
    mark_near(model, work, &place);
    /* Targets at the end of the whole step, where the script alone has them. */
    double const start = work->start->time;
    tulle_status const status =
        step_script_targets(model, work, start, start + work->whole_step, work->error);
    if (status != TULLE_OK) return status; /* the reader of frames has said why */
    bool const is_slow = model->def.on_pinch == TULLE_ON_PINCH_SLOW;
    bool lags = false;
    for (size_t i = 0; i < model->obstacles.count; i++)
        lags |= work->lag.is_near[i] && step_deforms(model, i) && step_lags_now(model, work, i);
    if ((lags || is_slow) && step_lag_more(model, work, &place)) {
        note_pinch(model, state, work, &place, lags ? FINDING_NO_ROOM : FINDING_WAITS);
        return TULLE_OK;
    }
    note_pinch(model, state, work, &place, FINDING_PINCHED);
    work->report->pinched = 1;
    work->failure = work->lag.finding;
    return TULLE_ERROR_PINCHED;
}
