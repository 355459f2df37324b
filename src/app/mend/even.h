/* app/mend/even.h - departures evened out in time, over five frames.
 *
 * Cloth that is followed from frame to frame stops at once where it meets something, and its
 * contacts catch and let go. Weighted means with 1 4 6 4 1 have no such jerks. Either departures
 * are averaged, as is right for cloth that goes along with what is given, or the way that was
 * followed, as is right for cloth that lies still while the given one goes on behind a body; of
 * both, and all between, each vertex takes what changes it least. The way that comes out is
 * followed in turn (frames.h). Where nothing departs over five frames it is the given one to the
 * bit. */
#ifndef TULLE_APP_MEND_EVEN_H
#define TULLE_APP_MEND_EVEN_H

#include "app/mend/input.h"

enum { EVEN_REACH = 2, EVEN_FRAMES = 2 * EVEN_REACH + 1 };

typedef struct mend_even {
    const mend_input *input;
    uint32_t count;                  /* frames added */
    double *given[EVEN_FRAMES];      /* of the last ones: all vertices */
    double *departures[EVEN_FRAMES]; /* and of the cloth */
} mend_even;

/* Release with mend_even_close, also after a failure. */
tulle_status mend_even_open(const mend_input *input, mend_even *even, tulle_error *error);
void mend_even_close(mend_even *even);

/* Memory for the frame that is added next: all vertices, as they are given. */
double *mend_even_get_next(mend_even *even);
/* Adds it; `followed` are all vertices, of which the cloth counts. */
void mend_even_add(mend_even *even, const double *followed);
/* A frame that was given, one of the last EVEN_FRAMES. */
const double *mend_even_get_given(const mend_even *even, uint32_t index);
/* The way at frame `index`, all vertices; frames up to EVEN_REACH later must be there, or it ends.
 * A departure up to `near` is none. True: all of it is as given. */
bool mend_even_make(const mend_even *even, uint32_t index, double near, double *way);

#endif
