/* app/check/weld.h - vertices that are in the same place in every frame, as along the seams of
 * files that give each texture coordinate a vertex of its own. */
#ifndef TULLE_APP_CHECK_WELD_H
#define TULLE_APP_CHECK_WELD_H

#include "tulle/base.h"

/* What each vertex is taken for: itself, or an earlier one in the same place in all frames so far.
 */
typedef struct check_weld {
    uint32_t *same;        /* vertex_count */
    uint32_t *next, *last; /* room for vertex_count: of a vertex, those that leave it in a frame */
    size_t vertex_count;
} check_weld;

/* By the first frame; release with check_weld_close, also after a failure. */
tulle_status check_weld_open(const double *positions, size_t vertex_count, check_weld *weld,
                             tulle_error *error);
void check_weld_close(check_weld *weld);
/* Parts what is not in the same place in another frame. */
void check_weld_part(check_weld *weld, const double *positions);
/* Vertices that are taken for another one. */
size_t check_weld_count(const check_weld *weld);

#endif
