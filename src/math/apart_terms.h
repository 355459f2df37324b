/* math/apart_terms.h - terms that lie outside a matrix's pattern, multiplied along with it. */
#ifndef TULLE_MATH_APART_TERMS_H
#define TULLE_MATH_APART_TERMS_H

#include "base/arena.h"
#include "math/matrix_term.h"

#include <stdbool.h>
#include <stddef.h>

/* What a term gives one of its vertices. */
typedef struct apart_share {
    uint32_t vertex, term;
    double weight;
} apart_share;

/* Terms and, by chunk of the vertices, their shares in the order of terms. The vertices of a loop
 * are cut into chunks of one size; all chunks of one loop may be done at once. */
typedef struct apart_terms {
    const matrix_term *const *terms;
    size_t count, chunk_count;
    double *pulls;         /* 3 a term: its stiffness times the weighted sum of its vertices */
    double *curvatures;    /* of each term, once it is pulled: direction . term direction */
    uint32_t *share_begin; /* of each chunk */
    apart_share *shares;
} apart_terms;

/* Terms stay borrowed, all else lies in the arena. False: no memory. */
bool apart_terms_make(const matrix_term *const *terms, size_t count, size_t vertex_count,
                      size_t chunk_size, arena *scratch, apart_terms *apart);
/* Pulls and curvatures of the part of the terms that belongs to a chunk; direction: 3 a vertex. */
void apart_terms_pull(const apart_terms *apart, size_t chunk, const float *direction);
/* Adds the pulls to the product (3 a vertex) of a chunk's vertices, in the order of terms. */
void apart_terms_add(const apart_terms *apart, size_t chunk, float *product);

#endif
