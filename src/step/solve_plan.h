/* step/solve_plan.h - what stage 7 does: the one place that decides how exact a solve is. */
#ifndef TULLE_STEP_SOLVE_PLAN_H
#define TULLE_STEP_SOLVE_PLAN_H

#include "step/step_work.h"

/* The result of a solve of stage 7. retry.c decides what follows. */
typedef enum solve_result {
    SOLVE_ROUGH,         /* its impulses still change, or it ended early */
    SOLVE_SOLVED,        /* a full solve whose impulses have settled */
    SOLVE_NEARLY_SOLVED, /* springs take more energy than the linear system predicts, but hardly
                            more once they are linearised again */
    SOLVE_STRETCHED,     /* they take more */
    SOLVE_LOST           /* a solution of the substep took far more than there is */
} solve_result;

/* The plan of the next solve of a substep. A rough solve need only be good enough to linearise
 * springs about it. After `balances` gains of energy solves take more rounds. */
solve_plan step_make_solve_plan(const step_model *model, const step_work *work, bool is_rough,
                                int balances);

#endif
