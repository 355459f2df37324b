/* step/findings.h - what a step reports. world/words.c turns findings into sentences. */
#ifndef TULLE_STEP_FINDINGS_H
#define TULLE_STEP_FINDINGS_H

#include "math/vec3.h"

#include <stddef.h>
#include <stdint.h>

typedef enum finding_kind {
    FINDING_NONE,

    /* why a step failed; without one, its status says so */
    FINDING_FRAME,        /* the reader of frames has filled in the error */
    FINDING_CROWDED,      /* numbers: length of the shortest try [s] */
    FINDING_SCRIPT_TURNS, /* surface; numbers: turn in the step, largest in a substep [rad], number
                             of substeps */
    FINDING_BODY_SPINS,   /* surface; numbers: spin [rad/s], largest turn in a substep [rad], number
                             of   substeps */
    FINDING_OVERSTRETCHED, /* vertices; numbers: strain of a yarn, its limit; count: 1 for warp */
    FINDING_TORN,          /* by the paper's response; numbers: growth */
    FINDING_PINCHED,       /* as the two that follow */

    /* what happened in a step that succeeded */
    FINDING_NO_ROOM, /* surface, pinched at the position; marks: obstacles that are near; count:
                        pins that move, vertices: the nearest of these */
    FINDING_WAITS,   /* as above: obstacles and pins on a script wait */
    FINDING_LAGS,    /* surface begins to lag, near the position */
    FINDING_FOLLOWS, /* marks: obstacles that wait no longer; in the end all of them */
    FINDING_BREAKS   /* vertices: the first that breaks off; count of them; numbers: its force, the
                        most that holds it [N]; attachment */
} finding_kind;

typedef struct step_finding {
    finding_kind kind;
    uint32_t surface;
    uint32_t vertices[3]; /* in the numbering of the surface; or a pin of it */
    uint32_t attachment;
    size_t count;
    double time;   /* [s] */
    vec3 position; /* [m] */
    double numbers[3];
    const uint8_t *marks; /* by obstacle, in the scratch arena */
} step_finding;

#endif
