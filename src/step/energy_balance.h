/* step/energy_balance.h - the energy that a substep may end with. */
#ifndef TULLE_STEP_ENERGY_BALANCE_H
#define TULLE_STEP_ENERGY_BALANCE_H

#include "step/step_work.h"

/* What became of the solutions of a substep that took far more energy than there is. */
typedef struct lost_solve {
    bool is_lost;     /* there was one */
    bool is_tempered; /* the last one still did, and no other follows: u went back on its way */
} lost_solve;

/* Whether a substep must not gain energy. Other integrators than implicit Euler
 * let it go up and down about its value, and the paper's response has no such rule. */
bool step_keeps_balance(const step_model *model, const step_work *work);
/* Whether the gain is so large, or the solve so lost, that the substep is better tried at half its
 * length. */
bool step_gains_too_much(const step_work *work, const lost_solve *lost);

/* Takes a solution that stretches cloth by far more energy than there is back on
 * the way to it, and sets `guess`. From then on so it takes all of the substep that have more. */
tulle_status step_temper_solution(const step_model *model, motion_state *state, step_work *work,
                                  const linear_excess *excess, bool is_last, lost_solve *lost);

/* The kinetic energy of vertices that can move with which the substep may end at
 * sub.end, without the work of what rows hold them by. */
typedef struct kinetic_limit {
    double start;  /* [J] kinetic energy at the start */
    double energy; /* [J] */
} kinetic_limit;
tulle_status step_compute_kinetic_limit(const step_model *model, motion_state *state,
                                        step_work *work, kinetic_limit *limit);

/* Energies of the cloths at `positions` with the velocities of state. The elastic ones are
 * those in *elastic where they are known, else they are measured into it. */
tulle_status step_measure_cloths(const step_model *model, motion_state *state, step_work *work,
                                 const double *positions, known_elastic *elastic,
                                 cloth_energies *energies);

/* Sets `gain`: the energy that the substep, ending with u at `end`, has beyond what it may and a
 * small slack; 0 where it need not keep a balance. */
tulle_status step_measure_gain(const step_model *model, motion_state *state, step_work *work);

#endif
