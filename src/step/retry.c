/* step/retry.c - all that is tried again when a step does not come out at once.
 *
 * A stage says what happened; this file decides what follows. The table of what is tried, and how
 * often, is in docs/method/index.md, "When something does not succeed". The files of the stages
 * tell of loops within a stage. */
#include "step/bodies/bodies.h"
#include "step/bodies/bodies_sleep.h"
#include "step/energy_balance.h"
#include "step/lag/lag.h"
#include "step/lag/pinch.h"
#include "step/step.h"
#include "step/step_context.h"

#include <math.h>
#include <string.h>

enum { LINEARISATIONS_MAX = 3, LINEARISATIONS_LOST_MAX = 12 };
enum { BALANCES_MAX = 3, ROOM_LEVELS_MAX = 2 };
/* Another balance follows one that left less than this part of the gain. What the first one does
 * not mend, later ones seldom do. Nor does one follow where next to nothing of the first gain is
 * left. */
static const double BALANCE_FALL = 0.5, BALANCE_ENOUGH = 0.1;

/* A substep of this share of the step is taken even if it stretches cloth too much. A power of two.
 * With low triangles it is less: the ends of short edges move apart by many of their lengths in a
 * step, and the linear system knows little of that. */
static const double SHORTEST_SHARE = 1.0 / 4.0, SHORTEST_SHARE_LOW = 1.0 / 64.0;
enum { SUBSTEPS_MAX = 48, SUBSTEPS_MAX_LOW = 768 };
/* A crowded substep of this share of the step fails it. A power of two. */
static const double CROWDED_SHARE = 1.0 / 4096.0;
/* A substep crawls when it passes less than this share of what it is to pass. */
static const double CRAWL_SHARE = 0.01;
enum { CRAWLS_MAX = 4 };
/* Each time that a stuck step goes on, its substeps are shorter by so many halvings. */
enum { SHORTER_MAX = 3, SHORTER_HALVINGS = 2 };

/* ---- in a solve ---- */

/* The first solves of a series need only be rough where springs are linearised about what they
 * find. */
static void begin_series(step_context *context) {
    context->retry.is_rough = context->sub->scene.response->begins_roughly;
    context->retry.linearisations = 0;
}

void step_begin_solves(step_context *context) {
    retry_state *const retry = &context->retry;
    retry->solves = retry->balances = retry->room_levels = 0;
    retry->history = (solve_history){0};
    retry->lost = (lost_solve){0};
    retry->last_gain = (double)INFINITY;
    retry->first_gain = 0.0;
    context->sub->gain = 0.0;
    begin_series(context);
}

/* Linearises springs about a guess. Solutions overshoot, or go to and fro, where springs stiffen.
 * The first one is a guess as a whole all the same, since it comes from springs that have not
 * turned; so is what a balance begins with. A lost one has set the guess already. */
static tulle_status linearise_anew(step_context *context) {
    double *const guess = context->sub->guess, *const solution = context->sub->mean_velocity;
    bool const is_first = !context->sub->dynamics.guess || context->retry.linearisations == 0;
    double const share = is_first ? 1.0 : choose_descent(&context->excess);
    size_t const size = context->retry.lost.is_lost ? 0 : 3 * context->model->cloth_vertex_count;
    for (size_t i = 0; i < size; i++)
        guess[i] = is_first ? solution[i] : guess[i] + share * (solution[i] - guess[i]);
    context->sub->dynamics.guess = guess;
    context->retry.history.has_sums = false; /* the matrix is another one from here on */
    return step_compute_forces(context);
}

bool step_may_linearise(const retry_state *retry, bool is_lost) {
    return retry->linearisations < (is_lost ? LINEARISATIONS_LOST_MAX : LINEARISATIONS_MAX);
}

tulle_status step_temper(step_context *context) {
    retry_state *const retry = &context->retry;
    bool const is_last = !retry->is_rough && !step_may_linearise(retry, true);
    return step_temper_solution(context->model, context->state, context->work, &context->excess,
                                is_last, &retry->lost);
}

bool step_retry_solve(step_context *context, tulle_status *status) {
    retry_state *const retry = &context->retry;
    if (*status != TULLE_OK || context->outcome != SUBSTEP_RUNS) return false;
    bool const was_rough = retry->is_rough;
    switch (context->result) {
    case SOLVE_LOST:
    case SOLVE_STRETCHED:
    case SOLVE_NEARLY_SOLVED:
        retry->linearisations++;
        retry->is_rough = context->result != SOLVE_NEARLY_SOLVED;
        *status = linearise_anew(context);
        return *status == TULLE_OK;
    case SOLVE_ROUGH: retry->is_rough = false; return was_rough;
    case SOLVE_SOLVED: break;
    }
    retry->is_rough = false;
    return false;
}

bool step_retry_balance(step_context *context, tulle_status *status) {
    retry_state *const retry = &context->retry;
    if (context->outcome != SUBSTEP_RUNS) return false;
    if (*status == TULLE_OK)
        *status = step_end_stage(context, STAGE_SOLVE_MOTION,
                                 step_measure_gain(context->model, context->state, context->work));
    if (*status != TULLE_OK || !(context->sub->gain > 0.0)) return false;
    if (retry->lost.is_lost && step_may_refuse_gain(context) &&
        step_gains_too_much(context->work, &context->retry.lost))
        return false; /* shorter substeps cost less than to find the way back */
    if (retry->room_levels < ROOM_LEVELS_MAX &&
        step_ask_less_room(context->work, retry->room_levels)) {
        retry->room_levels++;
        /* impacts that are found from here on ask for no room */
        context->work->rows.push_out_cut = context->sub->scene.settings.push_out_speed;
        begin_series(context);
        return true;
    }
    if (retry->balances == 0) retry->first_gain = context->sub->gain;
    bool const is_enough = context->sub->gain < BALANCE_ENOUGH * retry->first_gain;
    bool const falls = context->sub->gain < BALANCE_FALL * retry->last_gain;
    if (retry->balances == BALANCES_MAX || is_enough || !falls) return false;
    retry->balances++; /* the plan then has more rounds */
    retry->last_gain = context->sub->gain;
    begin_series(context);
    if (retry->lost.is_lost) *status = step_temper(context);
    if (*status == TULLE_OK) *status = linearise_anew(context);
    return *status == TULLE_OK;
}

/* ---- in a substep ---- */

void step_begin_retries(step_context *context) {
    bool const has_low = context->model->height_share < 1.0;
    context->retry = (retry_state){
        .remaining = context->work->whole_step,
        .wanted = context->work->whole_step,
        .turn_time = (double)INFINITY,
        .shortest = (has_low ? SHORTEST_SHARE_LOW : SHORTEST_SHARE) * context->work->whole_step,
        .substep_limit =
            context->work->report->substeps + (has_low ? SUBSTEPS_MAX_LOW : SUBSTEPS_MAX),
    };
}

bool step_is_over(const step_context *context) {
    return context->outcome == SUBSTEP_PINCHED ||
           !(context->retry.remaining > REMAINDER_SHARE * context->work->whole_step);
}

bool step_may_halve(const step_context *context) {
    return context->sub->time_step > context->retry.shortest;
}

/* What lags presses the cloth between it in substeps of any length. So while anything does, a gain
 * refuses nothing. */
bool step_may_refuse_gain(const step_context *context) {
    return step_may_halve(context) && context->work->lag.level == 0 &&
           !step_has_lags(context->model, context->state);
}

tulle_status step_choose_substep(step_context *context) {
    retry_state *const retry = &context->retry;
    double const longest = fmin(retry->wanted, retry->remaining);
    context->sub->time_step = fmin(longest, retry->turn_time);
    tulle_status const status =
        step_limit_turns(context->model, context->state, context->work, &context->sub->time_step);
    retry->is_cut_by_turns = context->sub->time_step < longest;
    retry->turn_time = (double)INFINITY;
    return status;
}

void step_retry_substep(step_context *context, tulle_status *status) {
    retry_state *const retry = &context->retry;
    if (*status == TULLE_ERROR_LIMIT) { /* a search has more candidates than it lists */
        context->outcome = SUBSTEP_CROWDED;
        *status = TULLE_OK;
        if (!(context->sub->time_step > CROWDED_SHARE * context->work->whole_step)) {
            *status = TULLE_ERROR_LIMIT;
            context->work->failure =
                (step_finding){.kind = FINDING_CROWDED, .numbers = {context->sub->time_step}};
        }
    }
    if (*status != TULLE_OK) return;
    /* substeps that are short only because bodies turn do not make a step stuck */
    bool const is_cut = retry->is_cut_by_turns && context->outcome == SUBSTEP_WHOLE;
    if (is_cut || context->outcome == SUBSTEP_TURNS) retry->substep_limit++;
    switch (context->outcome) {
    case SUBSTEP_CROWDED:
        retry->wanted = 0.5 * context->sub->time_step;
        retry->substep_limit += (uint32_t)(context->work->whole_step / retry->wanted);
        return;
    case SUBSTEP_WAKES:
    case SUBSTEP_TURNS: return;
    case SUBSTEP_STRETCHES:
    case SUBSTEP_GAINS: retry->wanted = 0.5 * context->sub->time_step; return;
    default: break;
    }
    retry->remaining -= context->sub->passed;
    if (step_is_over(context)) return;

    /* what a turn alone cut short is no sign of a step that is stuck */
    double const wanted = retry->is_cut_by_turns ? context->sub->time_step : retry->wanted;
    bool const is_slow = context->sub->passed < CRAWL_SHARE * wanted;
    retry->crawl_count = is_slow ? retry->crawl_count + 1 : 0;
    bool const is_stuck = context->outcome == SUBSTEP_BLOCKED || retry->crawl_count >= CRAWLS_MAX ||
                          context->work->report->substeps >= retry->substep_limit;
    if (!is_stuck) return;
    if (!step_is_script_moving(context->model, context->state, context->work)) {
        step_stand_still(context->model, context->state);
        retry->remaining = 0.0;
    } else if (retry->shorter_count == SHORTER_MAX ||
               step_waits_at_once(context->model, context->state, context->work)) {
        context->outcome = SUBSTEP_PINCHED;
    } else {
        /* What turns fast leaves its circle less in shorter substeps, and cloth that rides on it
         * comes less near. */
        retry->shorter_count++;
        retry->wanted = ldexp(context->work->whole_step, -SHORTER_HALVINGS * retry->shorter_count);
        retry->substep_limit += 1u << (SHORTER_HALVINGS * retry->shorter_count);
        retry->crawl_count = 0;
    }
}

/* ---- in a step ---- */

bool step_retry_whole(step_context *context, tulle_status *status) {
    motion_state *const state = context->state;
    bool const is_bad = context->outcome == SUBSTEP_PINCHED || context->outcome == SUBSTEP_TORN;
    if (*status != TULLE_OK || !is_bad) return false;
    bool const is_torn = context->outcome == SUBSTEP_TORN;
    *status = step_handle_pinch(context->model, state, context->work, is_torn);
    if (*status != TULLE_OK) return false;

    context->work->broken = (step_finding){0};
    step_undo(context->model, context->work);
    bool has_appeared; /* was judged before the first try */
    *status = step_copy_start(context->model, state, context->work, &has_appeared);
    return *status == TULLE_OK;
}
