/* contact/rows/choose_rows.h - in stage 5: the rows of the pairs that its tests found. */
#ifndef TULLE_CONTACT_ROWS_CHOOSE_ROWS_H
#define TULLE_CONTACT_ROWS_CHOOSE_ROWS_H

#include "contact/pairs/pair_scan.h"

/* Replaces the rows of the list (its array lives on scene->heap) by those of the admissible events
 * along x0 -> predicted, with the contacts of the store carried over to them. Out of memory: the
 * list has no rows. What it takes from scene->scratch the caller releases. */
tulle_status choose_rows(const contact_scene *scene, const contact_store *store,
                         const double *predicted, const pair_events *found, row_list *list);

#endif
