/* contact/pairs/apart_pairs.h - the first proofs of prove_apart, eight pairs at a time. */
#ifndef TULLE_CONTACT_PAIRS_APART_PAIRS_H
#define TULLE_CONTACT_PAIRS_APART_PAIRS_H

#include "contact/pairs/pair_scan.h"
#include "detect/impact/pair_batch.h"

/* Tables in which slots are features and records are those of vertices; false when memory is
 * short. Their arrays are in the scene's scratch arena, or borrowed. */
bool make_feature_tables(const contact_scene *scene, const vertex_record *records,
                         pair_tables *tables);

/* Pairs of one kind, by (first, second), with a separation [m] each. */
typedef struct apart_query {
    feature_kind kind;
    size_t count; /* SCAN_MOST at most */
    feature_pair pairs[SCAN_MOST];
    double separations[SCAN_MOST];
} apart_query;

/* Marks the pairs that an axis or the closest direction at the start keeps apart. The arithmetic is
 * that of prove_apart, which calls all marked pairs APART_BY_DIRECTION and may call others so. */
void mark_apart(const pair_tables *tables, const apart_query *query, bool is_apart[SCAN_MOST]);

#endif
