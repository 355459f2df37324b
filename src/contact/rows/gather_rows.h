/* contact/rows/gather_rows.h - stage 5: rows of pairs that touch or will touch. */
#ifndef TULLE_CONTACT_ROWS_GATHER_ROWS_H
#define TULLE_CONTACT_ROWS_GATHER_ROWS_H

#include "contact/contact_types.h"
#include "contact/pairs/contact_paths.h"
#include "contact/rows/contact_store.h"

/* Replaces `list` (its array lives on scene->heap). A pair of the source gets a row if it is nearer
 * than its separation distance at x0, or if its path x0 -> predicted comes within its contact
 * distance, and if it is admissible (admissible_rows.h). Impulses of pairs in the store are carried
 * over, scaled to this time step. The source's pairs must be the candidates of x0 -> predicted with
 * a margin of at least the largest separation distance. Its near pairs are set, to an array of the
 * list. Out of memory: the list is empty. */
tulle_status gather_rows(const contact_scene *scene, const contact_store *store,
                         const double *predicted, pair_source *source, row_list *list);

void row_list_destroy(row_list *list, memory *heap);

#endif
