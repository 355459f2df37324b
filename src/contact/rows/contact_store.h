/* contact/rows/contact_store.h - in stage 10: the contacts that live from step to step. */
#ifndef TULLE_CONTACT_ROWS_CONTACT_STORE_H
#define TULLE_CONTACT_ROWS_CONTACT_STORE_H

#include "contact/contact_types.h"

/* Replaces the store's contents by the rows of an accepted step of length time_step [s], each pair
 * once with the sum of its rows' impulses, and by `others`, contacts of pairs without a row, in
 * ascending order. Fails
 * only when memory is short, which an earlier call of reserve_contacts rules out; the store is then
 * as it was. */
tulle_status store_contacts(contact_store *store, memory *heap, const row_list *list,
                            const stored_contact *others, size_t other_count, double time_step);
/* Makes room for `row_count` contacts. */
tulle_status reserve_contacts(contact_store *store, memory *heap, size_t row_count);

/* Looks up keys that ascend in (kind, pair), at least from one call of read_contact to the next. A
 * zeroed reader with its store is at the first contact. */
typedef struct contact_reader {
    const contact_store *store;
    size_t next; /* contacts before this one have smaller keys than the last one looked up */
} contact_reader;

/* The contact of a pair, or null. */
const stored_contact *read_contact(contact_reader *reader, feature_kind kind, feature_pair pair);

uint64_t contact_store_hash(const contact_store *store, uint64_t hash);

/* The store as bytes (a little-endian block without padding), for the checkpoint. */
size_t contact_store_get_size(const contact_store *store);
void contact_store_save(const contact_store *store, void *bytes);
/* Reads a block of byte_count bytes; INVALID_ARGUMENT if it is wrong (size, order, values not
 * finite); then the store is as it was. contact_store_fits says whether indices fit the mesh. */
tulle_status contact_store_load(contact_store *store, memory *heap, const void *bytes,
                                size_t byte_count);

/* Whether all contacts are of features that are there. */
bool contact_store_fits(const contact_store *store, const topology *topo);

#endif
