/* contact/rows/carry_over.h - impulses of contacts that changed their features. */
#ifndef TULLE_CONTACT_ROWS_CARRY_OVER_H
#define TULLE_CONTACT_ROWS_CARRY_OVER_H

#include "contact/rows/admissible_rows.h"

/* Gives a row the impulse (times `scale`), state, age and anchor of a contact of the step before,
 * whatever features that had. side: -1 where the row's first feature is on the side of the
 * contact's second one, else 1. */
void inherit_contact(const contact_scene *scene, contact_row *row, const stored_contact *contact,
                     double scale, double side);

/* Hands each contact of the store that lost its row to at most one of the rows that have none. A
 * row takes one contact at most, so no impulse is doubled. In: rows sorted by (kind, pair), and the
 * row_choice of each; dropped ones take part in nothing. Out: a reserved row that inherits a
 * contact is kept. */
tulle_status carry_over_contacts(const contact_scene *scene, const contact_store *store,
                                 contact_row *const *rows, uint8_t *choices, size_t count);

#endif
