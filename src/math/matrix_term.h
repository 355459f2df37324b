/* math/matrix_term.h - a stiff row over a few vertices, added to a matrix. */
#ifndef TULLE_MATH_MATRIX_TERM_H
#define TULLE_MATH_MATRIX_TERM_H

#include "math/vec3.h"

#include <stdbool.h>
#include <stdint.h>

/* The stiffness with factors w_i w_j on the blocks of up to four vertices. */
typedef struct matrix_term {
    uint32_t vertices[4]; /* TULLE_NONE: not there */
    double weights[4];
    mat3 stiffness; /* symmetric, positive semidefinite: of the weighted sum of the vertices */
    bool is_apart;  /* never lies in a pattern: it pulls unknowns outside the matrix, too */
} matrix_term;

#endif
