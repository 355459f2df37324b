/* contact/hidden_rows.h - rows with an obstacle that a nearer one makes idle. */
#ifndef TULLE_CONTACT_HIDDEN_ROWS_H
#define TULLE_CONTACT_HIDDEN_ROWS_H

#include "contact/pair_scan.h"

/* Rows of events, vertex/triangle first, and which of them are chosen. */
typedef struct chosen_rows {
    const contact_row *rows;
    const pair_event *events;
    const uint8_t *is_kept;
    size_t count;
} chosen_rows;

/* Marks in is_hidden, which comes in false, chosen rows whose obstacle's feature lies behind the
 * plane of a nearer one of the same vertices of cloth or of a free body: that one keeps them away
 * from it, too. Where an obstacle is flat a row a vertex is left; where triangles or obstacles lie
 * flush without sharing vertices, the rim of the next one is no edge to stop at. The nearest row of
 * a vertex is never hidden. ends [m]: predicted. */
tulle_status mark_hidden_rows(const contact_scene *scene, const double *ends,
                              const chosen_rows *chosen, bool *is_hidden);

#endif
