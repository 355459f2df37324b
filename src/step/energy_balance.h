/* step/energy_balance.h - the energy that a substep may end with, and damping. */
#ifndef TULLE_STEP_ENERGY_BALANCE_H
#define TULLE_STEP_ENERGY_BALANCE_H

#include "step/step_work.h"

/* Whether solutions of a substep took far more energy than there is. */
typedef struct lost_solve {
    bool is_lost;     /* there was one */
    bool is_tempered; /* the last solution did, and no other follows: u was moved back */
} lost_solve;

/* Whether a substep must not gain energy. Under other integrators than implicit Euler the energy
 * oscillates, and the paper's response has no such rule. */
bool step_keeps_balance(const step_model *model, const step_work *work);
/* Whether the substep should be tried at half its length: it gains too much energy, or its solve is
 * lost. */
bool step_gains_too_much(const step_work *work, const lost_solve *lost);

/* Moves a solution with far more energy than there is back towards the guess before it, and sets
 * `guess`. All later solutions of the substep that have more energy are moved back, too. */
tulle_status step_temper_solution(const step_model *model, motion_state *state, step_work *work,
                                  const linear_excess *excess, bool is_last, lost_solve *lost);

/* The kinetic energy with which the vertices that can move may end the substep at sub.end. The work
 * of the rows that hold them is left out. */
typedef struct kinetic_limit {
    double start;  /* [J] kinetic energy at the start */
    double energy; /* [J] */
} kinetic_limit;
tulle_status step_compute_kinetic_limit(const step_model *model, motion_state *state,
                                        step_work *work, kinetic_limit *limit);

/* Energies and stretch of the state, into the report. */
tulle_status step_report_energies(const step_model *model, motion_state *state, step_work *work);

/* Sets `gain`: the energy by which the substep, ending with u at `end`, exceeds its limit and a
 * small slack; 0 if no balance is kept. */
tulle_status step_measure_gain(const step_model *model, motion_state *state, step_work *work);

/* Bodies that are too near make room. Called before the first solve of a substep: limits the speeds
 * that rows ask for to a share of the energy that the last substep lost. */
void step_share_room(motion_state *state, step_work *work);
/* Called after a solve that gained energy: rows ask for less. With `level` 0 they keep their
 * present room, with 1 they ask for no speed apart. False when no such row carries load and asked
 * for more. */
bool step_ask_less_room(step_work *work, int level);
/* Called after the last solve, when its gain is known: notes the energy that this substep loses
 * without making room. */
void step_note_loss(step_work *work);

/* The damping of the integrator in this step, see force_options. */
double step_choose_damping(const step_model *model, step_work *work);
/* The damping ratio of free motion with this period [s] under an integrator. */
double measure_numerical_damping(tulle_integrator integrator, double time_step, double period);

#endif
