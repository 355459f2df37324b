/* step/pinch/pinch_work.h - what a step knows of its pinch (pinch.h). */
#ifndef TULLE_STEP_PINCH_PINCH_WORK_H
#define TULLE_STEP_PINCH_PINCH_WORK_H

#include "contact/commit/commit_safely.h"
#include "step/findings.h"
#include "step/motion_state.h"

/* Cloth vertices at which a step was blocked or tears cloth. */
typedef struct blocked_place {
    bool is_pair; /* the vertices are a pair that blocked, of this kind */
    feature_kind kind;
    uint32_t vertices[4];
    uint32_t surface; /* a cloth, or the surface of the first vertex */
    vec3 position;    /* [m] of one of them */
} blocked_place;

typedef struct pinch_work {
    bool is_script_frozen;       /* all that follows a script stands still (on_pinch: slow) */
    double hold_left[HOLDS_MAX]; /* [m] that each hold keeps from its script */
    int level;                   /* how much the step holds back already */
    commit_report blocked;       /* the last commit of the step that named a blocking pair */
    blocked_place torn_place;    /* where the step tears squeezed cloth */
    step_finding finding;        /* of the pinch found last, or of the lag */
    step_finding freed;          /* what is held back no more */
    uint8_t *is_near, *is_freed; /* marks of these findings */
} pinch_work;

#endif
