/* app/mend/follow.c - see follow.h. */
#include "app/mend/follow.h"

#include "app/mend/shorten.h"
#include "base/error.h"

#include "tulle/tulle.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Of a mean edge: a departure under it is none. Pictures do not show it. */
static const double NEAR_SHARE = 1e-3;
/* Free are vertices so many reaches around what is away or meets; there a departure has decayed to
 * a hundredth. */
static const double FREE_REACHES = 5.0;
/* Mean edges a frame^2: no departure sets out for the given way faster. Cloth that hangs far from
 * it then swings, where a pull that grows with the departure would tear at it. */
static const double PULL_MOST = 0.25;
/* A move is repeated so often with what contact presses on as well. */
enum { PRESSED_MAX = 3 };
/* A frame that one straight move does not reach is cut into so many parts, then so many times as
 * many. */
enum { PARTS_FACTOR = 4, PARTS_MAX = 16 };
/* Bodies that leave the cloth no room are held within so many mean edges of where the cloth meets
 * something, and free beyond the other number. */
static const double HOLD_EDGES = 4.0, HOLD_END_EDGES = 12.0;
/* Held bodies that cannot go on without meeting the cloth where it is stay held; at the latest
 * after so many moves it is tried whether they push it away. */
enum { HELD_FRAMES = 24 };
/* A move that needs more solves than this is tried otherwise first. */
enum { SOLVES_MAX = 32 };
/* Rounds in which vertices that may not be put on the given way are left where they were. */
enum { SETTLE_ROUNDS = 8 };

static size_t count_cloth(const mend_follow *follow) {
    return mend_get_cloth_count(follow->solver.input);
}

/* ---- what meets on a way ---- */

/* `may_stand`: bodies of one frame never move. */
static tulle_status make_detector(mend_follow *follow, const double *first, bool may_stand,
                                  tulle_error *error) {
    const mend_input *const input = follow->solver.input;
    tulle_detect_surface *const surfaces = calloc(input->surface_count, sizeof *surfaces);
    if (!surfaces) return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "out of memory");
    for (size_t i = 0; i < input->surface_count; i++) {
        const mend_surface *const surface = &input->surfaces[i];
        surfaces[i] = (tulle_detect_surface){.vertex_begin = surface->vertex_begin,
                                             .vertex_end = surface->vertex_end,
                                             .triangle_begin = surface->triangle_begin,
                                             .triangle_end = surface->triangle_end,
                                             .is_obstacle = i > 0,
                                             .is_static = may_stand && i > 0 && surface->is_still};
    }
    tulle_detect_def def = tulle_detect_def_default();
    def.triangles = input->triangles;
    def.triangle_count = input->triangle_count;
    def.vertex_count = input->vertex_count;
    def.rest = first;
    def.surfaces = surfaces;
    def.surface_count = input->surface_count;
    def.threads = follow->options->threads;
    tulle_status const status = tulle_detector_create(&def, &follow->detector, error);
    free(surfaces);
    return status;
}

/* The events from `start` to `end`; a null `marks` asks only whether there are any. */
static tulle_status find_events(mend_follow *follow, const double *start, const double *end,
                                unsigned char *marks, size_t *count, tulle_error *error) {
    tulle_detect_result result;
    tulle_status const status =
        marks ? tulle_detector_find_events(follow->detector, start, end, &result, error)
              : tulle_detector_find_earliest(follow->detector, start, end, &result, error);
    *count = status == TULLE_OK ? result.event_count : 0;
    for (size_t i = 0; i < *count && marks; i++)
        for (size_t k = 0; k < 4; k++)
            if (result.events[i].vertices[k] < count_cloth(follow))
                marks[result.events[i].vertices[k]] = 1;
    return status;
}

static double measure_distance(const double *a, const double *b, size_t vertex) {
    double sum = 0.0;
    for (size_t k = 3 * vertex; k < 3 * vertex + 3; k++) sum += (a[k] - b[k]) * (a[k] - b[k]);
    return sqrt(sum);
}

tulle_status mend_follow_let_all_move(mend_follow *follow, tulle_error *error) {
    tulle_detector_destroy(follow->detector);
    follow->detector = NULL;
    return make_detector(follow, follow->now, false, error);
}

static const mend_surface *find_surface(const mend_input *input, uint32_t vertex) {
    const mend_surface *surface = input->surfaces;
    while (vertex >= surface->vertex_end) surface++;
    return surface;
}

tulle_status mend_follow_judge_rounding(mend_follow *follow, const double *exact,
                                        const double *rounded, tulle_error *error) {
    const mend_input *const input = follow->solver.input;
    tulle_detect_result result;
    tulle_status const status =
        tulle_detector_find_earliest(follow->detector, exact, rounded, &result, error);
    if (status != TULLE_OK || result.event_count == 0) return status;
    const uint32_t *const vertices = result.events[0].vertices;
    uint32_t vertex = vertices[0];
    for (size_t k = 1; k < 4; k++)
        if (measure_distance(exact, rounded, vertices[k]) >
            measure_distance(exact, rounded, vertex))
            vertex = vertices[k];
    const mend_surface *const surface = find_surface(input, vertex);
    const mend_surface *other = find_surface(input, vertices[0]);
    if (other == surface) other = find_surface(input, vertices[3]);
    const double *const x = exact + 3 * (size_t)vertex;
    return error_set(
        error, TULLE_ERROR_LIMIT,
        "floats move vertex %u of '%s' at (%.6g, %.6g, %.6g) %s by %.2g %s, and so through %s%s%s; "
        "a format with doubles keeps them apart: .obj, .ply, .vtp, and .npz with --double",
        vertex - surface->vertex_begin, convert_source_get_name(&surface->source), x[0], x[1], x[2],
        input->unit, measure_distance(exact, rounded, vertex), input->unit,
        other == surface ? "itself" : "'",
        other == surface ? "" : convert_source_get_name(&other->source),
        other == surface ? "" : "'");
}

/* ---- which vertices are free ---- */

enum { MARKED = 1, REACHED = 2 };

/* Marks all vertices within so many edges of the marked ones. */
static void widen(const mend_follow *follow, unsigned char *marks, uint32_t edge_count) {
    const mend_input *const input = follow->solver.input;
    bool goes_on = true;
    for (uint32_t k = 0; k < edge_count && goes_on; k++) {
        goes_on = false;
        for (size_t t = 0; t < input->surfaces[0].triangle_end; t++) {
            const uint32_t *const corners = input->triangles + 3 * t;
            int const found = (marks[corners[0]] | marks[corners[1]] | marks[corners[2]]) & MARKED;
            for (size_t i = 0; i < 3 && found; i++)
                if (!marks[corners[i]]) marks[corners[i]] = REACHED;
        }
        for (size_t v = 0; v < count_cloth(follow); v++) {
            goes_on = goes_on || marks[v] == REACHED;
            marks[v] = marks[v] != 0;
        }
    }
}

static uint32_t get_width(const mend_follow *follow) {
    return (uint32_t)ceil(FREE_REACHES * follow->options->reach);
}

/* From where all are (begin) to target. `departures` are those at the start. */
static tulle_status choose_free(mend_follow *follow, const double *departures, size_t *event_count,
                                tulle_error *error) {
    size_t const count = count_cloth(follow);
    for (size_t v = 0; v < count; v++) {
        const double *const u = departures + 3 * v;
        follow->is_free[v] = sqrt(u[0] * u[0] + u[1] * u[1] + u[2] * u[2]) > follow->near;
    }
    memset(follow->meets, 0, count);
    tulle_status const status =
        find_events(follow, follow->begin, follow->target, follow->meets, event_count, error);
    for (size_t v = 0; v < count; v++) follow->is_free[v] |= follow->meets[v];
    if (status == TULLE_OK) widen(follow, follow->is_free, get_width(follow));
    return status;
}

/* ---- a move and its end ---- */

/* All bodies, or cloth and bodies, to where files can have them; nothing else may be written. */
static void round_bodies(const mend_follow *follow, double *positions) {
    const mend_input *const input = follow->solver.input;
    for (size_t i = 1; i < input->surface_count; i++)
        if (!input->surfaces[i].is_still)
            mend_input_round_body(input, i,
                                  positions + 3 * (size_t)input->surfaces[i].vertex_begin);
}
static void round_all(const mend_follow *follow, double *positions) {
    for (size_t i = 0; i < 3 * count_cloth(follow) && follow->solver.input->is_float; i++)
        positions[i] = (double)(float)positions[i];
    round_bodies(follow, positions);
}

/* Puts vertices that ended next to their targets there, unless they would meet something: those
 * stay where the move left them. The last round but rounds, and what that leads through something
 * is an error. */
static tulle_status settle(mend_follow *follow, tulle_error *error) {
    size_t const count = count_cloth(follow);
    size_t const all = follow->solver.input->vertex_count;
    unsigned char *const holds = follow->pressed; /* not needed any more */
    memset(holds, 0, count);
    for (int round = 0; round <= SETTLE_ROUNDS; round++) {
        size_t event_count = 0;
        bool const is_last = round == SETTLE_ROUNDS;
        memcpy(follow->rounded, follow->end, 3 * all * sizeof(double));
        round_all(follow, follow->rounded);
        for (size_t v = 0; v < count && !is_last; v++)
            if (!holds[v] && measure_distance(follow->end, follow->target, v) <= follow->near)
                memcpy(follow->rounded + 3 * v, follow->target + 3 * v, 3 * sizeof(double));
        if (memcmp(follow->rounded, follow->end, 3 * all * sizeof(double)) == 0) return TULLE_OK;
        tulle_status const status =
            is_last ? mend_follow_judge_rounding(follow, follow->end, follow->rounded, error)
                    : find_events(follow, follow->end, follow->rounded, holds, &event_count, error);
        if (status != TULLE_OK) return status;
        if (event_count > 0) continue;
        memcpy(follow->end, follow->rounded, 3 * all * sizeof(double));
        return TULLE_OK;
    }
    return TULLE_OK;
}

static bool has_moving_bodies(const mend_follow *follow) {
    size_t const begin = 3 * count_cloth(follow), end = 3 * follow->solver.input->vertex_count;
    return memcmp(follow->begin + begin, follow->target + begin, (end - begin) * sizeof(double)) !=
           0;
}

/* Moves bodies less on their ways, with a smooth edge, and near where the cloth meets something not
 * at all: what stands leaves as much room as there is. */
static void hold_bodies(mend_follow *follow) {
    double const edge = follow->near / NEAR_SHARE;
    double *const trouble = follow->rounded; /* scratch: where it is */
    size_t count = 0;
    for (size_t v = 0; v < count_cloth(follow); v++)
        if (follow->meets[v])
            memcpy(trouble + 3 * count++, follow->begin + 3 * v, 3 * sizeof *trouble);
    for (size_t v = count_cloth(follow); v < follow->solver.input->vertex_count; v++) {
        double nearest = (double)INFINITY;
        for (size_t k = 0; k < count; k++)
            nearest = fmin(nearest, measure_distance(trouble + 3 * k, follow->begin + 3 * v, 0));
        double const way = (nearest / edge - HOLD_EDGES) / (HOLD_END_EDGES - HOLD_EDGES);
        double const part = fmin(fmax(way, 0.0), 1.0), share = part * part * (3.0 - 2.0 * part);
        for (size_t i = 3 * v; i < 3 * v + 3 && share < 1.0; i++)
            follow->target[i] = follow->begin[i] + share * (follow->target[i] - follow->begin[i]);
    }
    round_bodies(follow, follow->target);
}

/* Whether bodies meet the cloth on their way to their targets, if it stands. */
static tulle_status find_shut(mend_follow *follow, bool *is_shut, tulle_error *error) {
    size_t const cloth = 3 * count_cloth(follow), all = 3 * follow->solver.input->vertex_count;
    size_t event_count = 0;
    memcpy(follow->rounded, follow->begin, cloth * sizeof(double));
    memcpy(follow->rounded + cloth, follow->target + cloth, (all - cloth) * sizeof(double));
    tulle_status const status =
        find_events(follow, follow->begin, follow->rounded, NULL, &event_count, error);
    *is_shut = event_count > 0;
    return status;
}

/* Shortens the straight way from `begin` to follow->end where it meets something. */
static tulle_status straighten(mend_follow *follow, const double *begin, bool *is_clean,
                               tulle_error *error) {
    const mend_input *const input = follow->solver.input;
    mend_way const way = {follow->detector, count_cloth(follow), input->vertex_count, begin,
                          follow->end,      input->is_float};
    return mend_shorten(&way, is_clean, error);
}

/* What no world moves goes to where it is drawn as far as it can. Bodies that then hit it stand. */
static tulle_status go_straight(mend_follow *follow, tulle_error *error) {
    size_t const all = 3 * follow->solver.input->vertex_count, cloth = 3 * count_cloth(follow);
    bool is_clean = false;
    memcpy(follow->end, follow->target, all * sizeof(double));
    for (size_t i = 0; i < cloth; i++) follow->end[i] += follow->wanted[i];
    tulle_status const status = straighten(follow, follow->begin, &is_clean, error);
    if (status == TULLE_OK && !is_clean) memcpy(follow->end, follow->begin, all * sizeof(double));
    return status;
}

/* Where each vertex would be if nothing met and nothing smoothed: u'' is critically damped, by
 * implicit Euler (both roots of (1 + s) z^2 - (1 + b) z + b are the same), and s as large as the
 * pull allows. A departure that grew goes on a bit, so what slides off a body sets out gently. */
static void choose_wanted(mend_follow *follow, double part) {
    size_t const count = count_cloth(follow);
    const double *const departures = follow->last, *const change = follow->last + 3 * count;
    double const most = PULL_MOST * follow->near / NEAR_SHARE;
    for (size_t v = 0; v < count; v++) {
        const double *const u = departures + 3 * v;
        double const length = sqrt(u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
        double const whole = length > most ? fmin(follow->options->strength, most / (length - most))
                                           : follow->options->strength;
        double const left = pow(1.0 - sqrt(whole / (1.0 + whole)), part);
        double const strength = (1.0 - left) * (1.0 - left) / (1.0 - (1.0 - left) * (1.0 - left));
        double const kept = 1.0 + 2.0 * strength - 2.0 * sqrt(strength * (1.0 + strength));
        for (size_t i = 3 * v; i < 3 * v + 3; i++)
            follow->wanted[i] = (departures[i] + kept * change[i]) / (1.0 + strength);
    }
}

/* Moves from begin to target, for a part of a frame; leaves the end in follow->end. follow->last
 * has the departures at the start, then what they changed by in the time that a move takes. */
static tulle_status make_move(mend_follow *follow, double part, mend_moved *moved,
                              mend_outcome *outcome, tulle_error *error) {
    size_t const count = count_cloth(follow);
    size_t event_count;
    choose_wanted(follow, part);
    mend_move move = {follow->begin, follow->target, follow->wanted, follow->is_free};
    *moved = (mend_moved){.end = follow->end, .pressed = follow->pressed};
    tulle_status status = choose_free(follow, follow->last, &event_count, error);
    if (status != TULLE_OK) return status;
    bool is_shut = false;
    if (follow->held_count % HELD_FRAMES != 0) status = find_shut(follow, &is_shut, error);
    if (status != TULLE_OK) return status;
    bool is_held = is_shut;
    if (is_held) hold_bodies(follow);
    for (int pressed = 0;;) {
        outcome->moves++;
        status = mend_solver_move(&follow->solver, &move, moved, error);
        bool const is_stuck = status == TULLE_ERROR_PINCHED || status == TULLE_ERROR_STEP_FAILED;
        if (is_stuck && follow->options->may_lag && !is_held && has_moving_bodies(follow)) {
            is_held = true;
            hold_bodies(follow);
        } else if (is_stuck && memchr(follow->is_free, 0, count)) {
            memset(follow->is_free, 1, count);
        } else if (is_stuck && (follow->options->may_lag || !has_moving_bodies(follow))) {
            status = go_straight(follow, error);
            break;
        } else if (status == TULLE_OK && moved->pressed_count > 0 && pressed < PRESSED_MAX) {
            pressed++;
            widen(follow, follow->pressed, get_width(follow));
            for (size_t v = 0; v < count; v++) follow->is_free[v] |= follow->pressed[v];
        } else {
            break;
        }
    }
    if (status != TULLE_OK) return status;
    follow->held_count = is_held ? follow->held_count + 1 : 0;
    size_t free_count = 0;
    for (size_t v = 0; v < count; v++) free_count += follow->is_free[v];
    if (free_count > outcome->free_count) outcome->free_count = free_count;
    return settle(follow, error);
}

/* From follow->now to `next` in `part_count` moves; leaves the end in follow->end. */
static tulle_status make_moves(mend_follow *follow, const double *next, uint32_t part_count,
                               mend_outcome *outcome, tulle_error *error) {
    size_t const all = 3 * follow->solver.input->vertex_count, cloth = 3 * count_cloth(follow);
    double *const departures = follow->last, *const change = follow->last + cloth;
    memcpy(follow->begin, follow->now, all * sizeof(double));
    for (size_t i = 0; i < cloth; i++) {
        departures[i] = follow->now[i] - follow->given[i];
        change[i] = (departures[i] - follow->departures_before[i]) / (double)part_count;
    }
    for (uint32_t part = 1; part <= part_count; part++) {
        double const share = (double)part / (double)part_count;
        for (size_t i = 0; i < all; i++)
            follow->target[i] = part == part_count
                                    ? next[i]
                                    : follow->given[i] + share * (next[i] - follow->given[i]);
        if (part < part_count) round_bodies(follow, follow->target);
        mend_moved moved;
        tulle_status const status =
            make_move(follow, 1.0 / (double)part_count, &moved, outcome, error);
        if (status != TULLE_OK) return status;
        memcpy(follow->begin, follow->end, all * sizeof(double));
        for (size_t i = 0; i < cloth; i++) {
            double const departure = follow->end[i] - follow->target[i];
            change[i] = departure - departures[i];
            departures[i] = departure;
        }
    }
    return TULLE_OK;
}

/* ---- frames ---- */

tulle_status mend_follow_step(mend_follow *follow, const double *next, bool is_clear,
                              mend_outcome *outcome, tulle_error *error) {
    size_t const all = 3 * follow->solver.input->vertex_count, cloth = 3 * count_cloth(follow);
    bool const is_on_way = memcmp(follow->now, follow->given, all * sizeof(double)) == 0;
    size_t event_count = is_on_way && is_clear ? 0 : 1;
    bool is_done = false;
    tulle_status status = TULLE_OK;
    *outcome = (mend_outcome){0};
    if (is_on_way && !is_clear)
        status = find_events(follow, follow->now, next, NULL, &event_count, error);
    if (status == TULLE_OK && event_count == 0) {
        memcpy(follow->end, next, all * sizeof(double));
        is_done = true;
    }
    for (uint32_t parts = 1; !is_done && status == TULLE_OK; parts *= PARTS_FACTOR) {
        status = make_moves(follow, next, parts, outcome, error);
        bool const is_last = parts * PARTS_FACTOR > PARTS_MAX;
        if ((status == TULLE_ERROR_PINCHED || status == TULLE_ERROR_STEP_FAILED) && !is_last) {
            status = TULLE_OK;
            continue;
        }
        if (status != TULLE_OK) return status;
        status = straighten(follow, follow->now, &is_done, error);
        if (status != TULLE_OK) return status;
        if (!is_done && is_last && follow->options->may_lag) {
            memcpy(follow->end, follow->now, all * sizeof(double));
            is_done = true;
        }
        outcome->crosses = !is_done;
        is_done = is_done || is_last;
    }
    if (status != TULLE_OK) return status;
    for (size_t i = 0; i < cloth; i++)
        follow->departures_before[i] = follow->now[i] - follow->given[i];
    memcpy(follow->now, follow->end, all * sizeof(double));
    memcpy(follow->given, next, all * sizeof(double));
    outcome->lag = 0.0;
    for (size_t v = cloth / 3; v < all / 3; v++)
        outcome->lag = fmax(outcome->lag, measure_distance(follow->now, follow->given, v));
    return TULLE_OK;
}

/* Untangles; vertices that hardly moved stay as they are given. */
static tulle_status begin_frames(mend_follow *follow, const double *first, tulle_error *error) {
    size_t const all = 3 * follow->solver.input->vertex_count;
    memcpy(follow->given, first, all * sizeof(double));
    memcpy(follow->end, first, all * sizeof(double));
    memcpy(follow->target, first, all * sizeof(double));
    tulle_status status = mend_solver_open(follow->solver.input, follow->options, follow->end,
                                           &follow->solver, error);
    if (status != TULLE_OK) return status;
    follow->solver.solve_limit = SOLVES_MAX;
    follow->near = NEAR_SHARE * 0.01 / follow->solver.scale;
    status = make_detector(follow, first, true, error);
    if (status == TULLE_OK) status = settle(follow, error);
    if (status != TULLE_OK) return status;
    memcpy(follow->now, follow->end, all * sizeof(double));
    for (size_t i = 0; i < 3 * count_cloth(follow); i++)
        follow->departures_before[i] = follow->now[i] - first[i];
    return TULLE_OK;
}

tulle_status mend_follow_open(const mend_input *input, const mend_follow_options *options,
                              const double *first, mend_follow *follow, tulle_error *error) {
    *follow = (mend_follow){.solver.input = input, .options = options};
    size_t const all = 3 * input->vertex_count, count = count_cloth(follow);
    double **const arrays[] = {&follow->now, &follow->given,   &follow->begin, &follow->target,
                               &follow->end, &follow->rounded, &follow->wanted};
    bool has_room = true;
    for (size_t i = 0; i < sizeof arrays / sizeof arrays[0]; i++)
        has_room = (*arrays[i] = calloc(all, sizeof(double))) && has_room;
    follow->departures_before = calloc(count, 3 * sizeof(double));
    follow->last = calloc(count, 6 * sizeof(double));
    follow->is_free = calloc(count, 1);
    follow->pressed = calloc(count, 1);
    follow->meets = calloc(count, 1);
    if (!has_room || !follow->departures_before || !follow->last || !follow->is_free ||
        !follow->pressed || !follow->meets)
        return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "out of memory for %zu vertices",
                         input->vertex_count);
    return begin_frames(follow, first, error);
}

void mend_follow_close(mend_follow *follow) {
    mend_solver_close(&follow->solver);
    tulle_detector_destroy(follow->detector);
    double *const arrays[] = {
        follow->now, follow->given,   follow->begin,  follow->target,
        follow->end, follow->rounded, follow->wanted, follow->departures_before,
        follow->last};
    for (size_t i = 0; i < sizeof arrays / sizeof arrays[0]; i++) free(arrays[i]);
    free(follow->is_free);
    free(follow->pressed);
    free(follow->meets);
    *follow = (mend_follow){0};
}
