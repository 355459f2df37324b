/* step/choose_damping.h - how far a step goes from its integrator towards implicit Euler. */
#ifndef TULLE_STEP_CHOOSE_DAMPING_H
#define TULLE_STEP_CHOOSE_DAMPING_H

#include "step/step_work.h"

/* The damping of the integrator in this step, see force_options. */
double step_choose_damping(const step_model *model, step_work *work);
/* The damping ratio of free motion with this period [s] under an integrator. */
double measure_numerical_damping(tulle_integrator integrator, double time_step, double period);

#endif
