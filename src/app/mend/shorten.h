/* app/mend/shorten.h - a straight way that meets nothing, for cloth that went round a corner. */
#ifndef TULLE_APP_MEND_SHORTEN_H
#define TULLE_APP_MEND_SHORTEN_H

#include "tulle/detect.h"

#include <stdbool.h>

typedef struct mend_way {
    tulle_detector *detector;
    size_t cloth_count, vertex_count; /* vertices of the cloth, which come first, and all */
    const double *begin;
    double *end;   /* of the cloth it gets shorter; that of bodies stays */
    bool is_float; /* ends are rounded to float */
} mend_way;

/* Shortens ways of the cloth until all go straight from begin to end without meeting anything:
 * vertices that hits join go the same part of their ways, or none. `*is_clean` false: moving bodies
 * hit cloth that stands. */
tulle_status mend_shorten(const mend_way *way, bool *is_clean, tulle_error *error);

#endif
