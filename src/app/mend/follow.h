/* app/mend/follow.h - the cloth of `tulle mend` from frame to frame.
 *
 * Vertices are on the given way, where their positions are the given ones to the bit, or away from
 * it. Where all are on it and the straight motion to the next frame meets nothing, it is the
 * result. Else the vertices that are away, those that the motion to the next frame makes meet, and
 * what is near them along the mesh become free, and the world moves them (solve.h); all others stay
 * on the given way. A vertex that ends next to its given position is put there. Every frame is
 * clean, and so is the straight way from the one before, shortened where it is not (shorten.h); but
 * for frames that `crosses` tells of. */
#ifndef TULLE_APP_MEND_FOLLOW_H
#define TULLE_APP_MEND_FOLLOW_H

#include "app/mend/solve.h"

typedef struct mend_follow {
    mend_solver solver;
    const mend_follow_options *options; /* the caller's */
    tulle_detector *detector;
    double near;               /* a departure under it is none; in the files' unit */
    double *now;               /* all vertices: the cloth mended, bodies where they lag to */
    double *given;             /* all vertices, as they are given in the same frame */
    double *departures_before; /* of the cloth in the frame before */
    double *begin, *target, *end, *rounded, *wanted, *last; /* scratch */
    unsigned char *is_free, *pressed, *meets;               /* by vertex of the cloth */
    uint32_t held_count; /* moves in a row in which bodies were held */
} mend_follow;

/* What became of a frame. */
typedef struct mend_outcome {
    size_t free_count; /* vertices that the world moved */
    uint32_t moves;    /* steps that were needed */
    double lag;        /* of a body behind its frames, in the files' unit */
    bool crosses;      /* the straight motion from the frame before meets something */
} mend_outcome;

/* `first`: all vertices in the first frame, which must not be empty. The cloth is untangled there.
 * Release with mend_follow_close, also after a failure; it must stay where it is. */
tulle_status mend_follow_open(const mend_input *input, const mend_follow_options *options,
                              const double *first, mend_follow *follow, tulle_error *error);
void mend_follow_close(mend_follow *follow);
/* Goes on to the next frame, given as `next`, all vertices. `is_clear`: nothing meets on the given
 * way to it, as is known. Errors: those of tulle_world_step. */
tulle_status mend_follow_step(mend_follow *follow, const double *next, bool is_clear,
                              mend_outcome *outcome, tulle_error *error);
/* From now on bodies of one frame may move where motions are judged: their rounding. No further
 * step follows. */
tulle_status mend_follow_let_all_move(mend_follow *follow, tulle_error *error);
/* Judges the motion from positions of all vertices, which must not intersect, to what files of
 * floats have of them. Errors: TULLE_ERROR_LIMIT where that leads a surface through another or
 * itself, with the vertex. */
tulle_status mend_follow_judge_rounding(mend_follow *follow, const double *exact,
                                        const double *rounded, tulle_error *error);

#endif
