/* step/solve_plan.h - what stage 7 is to do: the one place where it is decided how exact a solve
 * is. */
#ifndef TULLE_STEP_SOLVE_PLAN_H
#define TULLE_STEP_SOLVE_PLAN_H

#include "step/step_work.h"

/* What a solve of stage 7 came to. retry.c decides what follows. */
typedef enum solve_result {
    SOLVE_ROUGH,         /* its impulses still change, or it ended early */
    SOLVE_SOLVED,        /* a full solve whose impulses have settled */
    SOLVE_NEARLY_SOLVED, /* springs take more energy than the system reckons with, but hardly any
                            more once they are linearised again */
    SOLVE_STRETCHED,     /* they take more */
    SOLVE_LOST           /* a solution of the substep took far more than there is */
} solve_result;

/* Whether cloth is held by its neighbours as if by far more than its mass, on average. */
bool step_is_stiff(const step_model *model, const step_work *work);

/* The plan of the next solve of a substep. A rough one need only be good enough to linearise
 * springs about it. After `balances` gains of energy solves take more rounds. */
solve_plan step_make_solve_plan(const step_model *model, const step_work *work, bool is_rough,
                                int balances, bool is_stiff);

#endif
