/* contact/rows/carry_over.h - impulses of contacts that changed their features. */
#ifndef TULLE_CONTACT_ROWS_CARRY_OVER_H
#define TULLE_CONTACT_ROWS_CARRY_OVER_H

#include "contact/contact_types.h"

/* Gives a row what a contact of the step before hands on to whatever features it has: its impulse
 * (times `scale`), state, age and anchor. side: -1 where the row's first feature is on the side of
 * the contact's second one, else 1. */
void inherit_contact(const contact_scene *scene, contact_row *row, const stored_contact *contact,
                     double scale, double side);

/* Hands each contact of the store that lost its row to at most one row that has no contact:
 * among `rows`, or among `reserve`, rows that are only kept when a contact is handed to them. Each
 * row takes one contact at most, so nothing is doubled. In: rows sorted by (kind, pair), with room
 * for reserve_count more; reserve sorted, too, of other pairs. Out: rows and *count with those of
 * the reserve that are kept. */
tulle_status carry_over_contacts(const contact_scene *scene, const contact_store *store,
                                 contact_row **rows, size_t *count, contact_row *const *reserve,
                                 size_t reserve_count);

#endif
