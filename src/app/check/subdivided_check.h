/* app/check/subdivided_check.h - judges whether a subdivided frame intersects, and says so in
 * words. Smoothing may push surfaces through each other that the simulation kept apart. A picture
 * or a file of such a frame is made all the same, with a message. */
#ifndef TULLE_APP_CHECK_SUBDIVIDED_CHECK_H
#define TULLE_APP_CHECK_SUBDIVIDED_CHECK_H

#include "tulle/check.h"

enum {
    SUBDIVIDED_LIST_MAX = 3, /* pairs of bodies and pairs of triangles that are named */
    SUBDIVIDED_TEXT_SIZE = 1024,
    SUBDIVIDED_NO_FRAME = -1 /* `number` of a mesh file */
};

/* One frame. All arrays are borrowed; body i is bodies[i], simulated[i], names[i]. */
typedef struct subdivided_frame {
    long number;                       /* of the frame, or SUBDIVIDED_NO_FRAME */
    const tulle_check_body *bodies;    /* as drawn or written */
    const tulle_check_body *simulated; /* before subdivision; null: not known */
    const char *const *names;
    size_t body_count;
} subdivided_frame;

/* Two bodies, or one and itself, that intersect. */
typedef struct subdivided_body_pair {
    uint32_t body_a, body_b;
    size_t pair_count;
} subdivided_body_pair;

typedef struct subdivided_verdict {
    size_t pair_count;           /* intersecting pairs of triangles */
    size_t simulated_pair_count; /* before subdivision; counted only where pair_count is not 0 */
    subdivided_body_pair body_pairs[SUBDIVIDED_LIST_MAX]; /* the first ones */
    size_t body_pair_count;                               /* how many of them are filled */
    tulle_check_pair pairs[SUBDIVIDED_LIST_MAX];          /* the first ones */
    size_t listed_count;                                  /* how many of them are filled */
    char text[SUBDIVIDED_TEXT_SIZE]; /* one sentence without a full stop or newline: what
                                        intersects and where; empty where nothing does */
} subdivided_verdict;

/* Judges the frame exactly. threads: 0 for one per processor. A frame that intersects is not an
 * error. Errors are those of tulle_check_intersections; the verdict is then empty. */
tulle_status subdivided_check_frame(const subdivided_frame *frame, int threads,
                                    subdivided_verdict *verdict, tulle_error *error);

/* Sums over the frames of a film or a sequence; zeroed at first. */
typedef struct subdivided_totals {
    size_t frame_count, bad_frame_count, pair_count;
    char first_text[SUBDIVIDED_TEXT_SIZE]; /* of the first frame that intersects */
} subdivided_totals;

void subdivided_totals_add(subdivided_totals *totals, const subdivided_verdict *verdict);
/* One sentence without a full stop or newline for the end of the work, also where nothing
 * intersects. */
void subdivided_totals_describe(const subdivided_totals *totals, char text[SUBDIVIDED_TEXT_SIZE]);

#endif
