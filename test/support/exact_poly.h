/* support/exact_poly.h - integer polynomials of degree 3 at most, their real roots in [0, 1], and
 * the exact sign of one polynomial at a root of another (GMP). Not thread-safe. */
#ifndef TULLE_TEST_EXACT_POLY_H
#define TULLE_TEST_EXACT_POLY_H

#include <gmp.h>
#include <stdbool.h>

typedef struct exact_poly {
    mpz_t c[4]; /* c[0] + c[1] t + c[2] t^2 + c[3] t^3 */
} exact_poly;

/* A root of `poly`, which is square-free: k / 2^m where is_exact, else the only root in the open
 * interval (k / 2^m, (k + 1) / 2^m). */
typedef struct exact_root {
    exact_poly poly;
    mpz_t k;
    unsigned long m;
    bool is_exact;
} exact_root;

void exact_poly_init(exact_poly *p);
void exact_poly_clear(exact_poly *p);
bool exact_poly_is_zero(const exact_poly *p);
/* Number of sign changes of the Bernstein coefficients on [0, 1]: never less than the number of
 * roots in (0, 1), and of the same parity. All of one strict sign: no root in [0, 1]. */
int exact_poly_variations(const exact_poly *p, bool *is_strict);

/* The distinct roots of p (not zero) in [0, 1]; 3 at most. roots are initialised by the call. */
int exact_poly_roots(const exact_poly *p, exact_root roots[3]);
void exact_root_clear(exact_root *root);
/* Sign of q at the root; narrows the root's interval on the way. */
int exact_sign_at(exact_root *root, const exact_poly *q);

#endif
