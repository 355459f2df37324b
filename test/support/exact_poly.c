/* support/exact_poly.c - see exact_poly.h.
 *
 * Roots are isolated by bisection with Descartes' rule in Bernstein form (Collins, Akritas, 1976),
 * after division by gcd(p, p') has made them simple. A sign at a root comes from an interval that
 * is narrowed until the polynomial has no sign change on it; where that takes long, the greatest
 * common divisor of both polynomials decides whether it is zero. */
#include "support/exact_poly.h"

void exact_poly_init(exact_poly *p) {
    for (int i = 0; i < 4; i++) mpz_init(p->c[i]);
}

void exact_poly_clear(exact_poly *p) {
    for (int i = 0; i < 4; i++) mpz_clear(p->c[i]);
}

static void copy_poly(exact_poly *to, const exact_poly *from) {
    for (int i = 0; i < 4; i++) mpz_set(to->c[i], from->c[i]);
}

static int find_degree(const exact_poly *p) {
    int degree = 3;
    while (degree >= 0 && mpz_sgn(p->c[degree]) == 0) degree--;
    return degree;
}

bool exact_poly_is_zero(const exact_poly *p) { return find_degree(p) < 0; }

/* Divides by the greatest common divisor of the coefficients. */
static void make_primitive(exact_poly *p) {
    mpz_t content;
    mpz_init(content);
    for (int i = 0; i < 4; i++) mpz_gcd(content, content, p->c[i]);
    if (mpz_sgn(content) != 0)
        for (int i = 0; i < 4; i++) mpz_divexact(p->c[i], p->c[i], content);
    mpz_clear(content);
}

/* a modulo b up to a factor; quotient (may be null) up to a factor, where the division is exact. */
static void divide_pseudo(exact_poly *a, const exact_poly *b, exact_poly *quotient) {
    int const degree = find_degree(b);
    mpz_t lead, product;
    mpz_inits(lead, product, NULL);
    for (int da = find_degree(a); da >= degree; da = find_degree(a)) {
        mpz_set(lead, a->c[da]);
        for (int i = 0; i < 4; i++) mpz_mul(a->c[i], a->c[i], b->c[degree]);
        if (quotient) {
            for (int i = 0; i < 4; i++) mpz_mul(quotient->c[i], quotient->c[i], b->c[degree]);
            mpz_add(quotient->c[da - degree], quotient->c[da - degree], lead);
        }
        for (int i = 0; i <= degree; i++) {
            mpz_mul(product, lead, b->c[i]);
            mpz_sub(a->c[da - degree + i], a->c[da - degree + i], product);
        }
    }
    mpz_clears(lead, product, NULL);
}

/* Neither is changed; the result is primitive. */
static void find_gcd(exact_poly *gcd, const exact_poly *a, const exact_poly *b) {
    exact_poly rest;
    exact_poly_init(&rest);
    copy_poly(gcd, a);
    copy_poly(&rest, b);
    while (!exact_poly_is_zero(&rest)) {
        divide_pseudo(gcd, &rest, NULL);
        make_primitive(gcd);
        for (int i = 0; i < 4; i++) mpz_swap(gcd->c[i], rest.c[i]);
    }
    make_primitive(gcd);
    exact_poly_clear(&rest);
}

/* p becomes p / gcd(p, p'), up to a factor. */
static void make_square_free(exact_poly *p) {
    exact_poly derivative, gcd, quotient;
    exact_poly_init(&derivative);
    exact_poly_init(&gcd);
    exact_poly_init(&quotient);
    make_primitive(p);
    for (int i = 1; i < 4; i++) mpz_mul_ui(derivative.c[i - 1], p->c[i], (unsigned long)i);
    find_gcd(&gcd, p, &derivative);
    if (find_degree(&gcd) > 0) {
        divide_pseudo(p, &gcd, &quotient);
        copy_poly(p, &quotient);
        make_primitive(p);
    }
    exact_poly_clear(&derivative);
    exact_poly_clear(&gcd);
    exact_poly_clear(&quotient);
}

int exact_poly_variations(const exact_poly *p, bool *is_strict) {
    mpz_t b;
    int signs[4];
    mpz_init(b);
    signs[0] = mpz_sgn(p->c[0]);
    mpz_mul_ui(b, p->c[0], 3);
    mpz_add(b, b, p->c[1]);
    signs[1] = mpz_sgn(b);
    mpz_add(b, b, p->c[1]);
    mpz_add(b, b, p->c[2]);
    signs[2] = mpz_sgn(b);
    mpz_add(b, p->c[0], p->c[1]);
    mpz_add(b, b, p->c[2]);
    mpz_add(b, b, p->c[3]);
    signs[3] = mpz_sgn(b);
    mpz_clear(b);
    int variations = 0, last = 0, sum = 0;
    for (int i = 0; i < 4; i++) {
        if (signs[i] != 0 && last != 0 && signs[i] != last) variations++;
        if (signs[i] != 0) last = signs[i];
        sum += signs[i];
    }
    if (is_strict) *is_strict = sum == 4 || sum == -4;
    return variations;
}

/* q(s) = p((k + s) / 2^m) 2^(3 m) */
static void restrict_poly(exact_poly *q, const exact_poly *p, const mpz_t k, unsigned long m) {
    for (int i = 0; i < 4; i++) mpz_mul_2exp(q->c[i], p->c[i], m * (unsigned long)(3 - i));
    for (int round = 0; round < 3; round++) /* Taylor shift by k */
        for (int i = 2; i >= round; i--) mpz_addmul(q->c[i], q->c[i + 1], k);
}

static int sign_at_dyadic(const exact_poly *p, const mpz_t k, unsigned long m) {
    exact_poly q;
    exact_poly_init(&q);
    restrict_poly(&q, p, k, m);
    int const sign = mpz_sgn(q.c[0]);
    exact_poly_clear(&q);
    return sign;
}

static int variations_on(const exact_poly *p, const mpz_t k, unsigned long m) {
    exact_poly q;
    exact_poly_init(&q);
    restrict_poly(&q, p, k, m);
    int const variations = exact_poly_variations(&q, NULL);
    exact_poly_clear(&q);
    return variations;
}

static void add_root(exact_root roots[3], int *count, const exact_poly *p, const mpz_t k,
                     unsigned long m, bool is_exact) {
    exact_root *const root = &roots[(*count)++];
    exact_poly_init(&root->poly);
    copy_poly(&root->poly, p);
    mpz_init_set(root->k, k);
    root->m = m;
    root->is_exact = is_exact;
}

/* Roots in the open interval; p is square-free. */
static void isolate_roots(const exact_poly *p, const mpz_t k, unsigned long m, exact_root roots[3],
                          int *count) {
    int const variations = variations_on(p, k, m);
    if (variations == 0) return;
    if (variations == 1) {
        add_root(roots, count, p, k, m, false);
        return;
    }
    mpz_t half;
    mpz_init(half);
    mpz_mul_2exp(half, k, 1);
    isolate_roots(p, half, m + 1, roots, count);
    mpz_add_ui(half, half, 1);
    if (sign_at_dyadic(p, half, m + 1) == 0) add_root(roots, count, p, half, m + 1, true);
    isolate_roots(p, half, m + 1, roots, count);
    mpz_clear(half);
}

int exact_poly_roots(const exact_poly *p, exact_root roots[3]) {
    exact_poly simple;
    mpz_t k;
    int count = 0;
    exact_poly_init(&simple);
    mpz_init(k);
    copy_poly(&simple, p);
    make_square_free(&simple);
    if (sign_at_dyadic(&simple, k, 0) == 0) add_root(roots, &count, &simple, k, 0, true);
    isolate_roots(&simple, k, 0, roots, &count);
    mpz_set_ui(k, 1);
    if (sign_at_dyadic(&simple, k, 0) == 0) add_root(roots, &count, &simple, k, 0, true);
    mpz_clear(k);
    exact_poly_clear(&simple);
    return count;
}

void exact_root_clear(exact_root *root) {
    exact_poly_clear(&root->poly);
    mpz_clear(root->k);
}

/* Halves the interval. */
static void narrow_root(exact_root *root) {
    mpz_mul_2exp(root->k, root->k, 1);
    root->m++;
    mpz_add_ui(root->k, root->k, 1);
    if (sign_at_dyadic(&root->poly, root->k, root->m) == 0) {
        root->is_exact = true;
        return;
    }
    mpz_sub_ui(root->k, root->k, 1);
    /* The only root lies where the number of variations is odd. */
    if (variations_on(&root->poly, root->k, root->m) % 2 == 0) mpz_add_ui(root->k, root->k, 1);
}

static bool shares_root(const exact_root *root, const exact_poly *q) {
    exact_poly gcd;
    exact_poly_init(&gcd);
    find_gcd(&gcd, &root->poly, q);
    /* Its roots are roots of the square-free poly: simple, one at most in the interval. */
    bool const shares = find_degree(&gcd) > 0 && variations_on(&gcd, root->k, root->m) % 2 == 1;
    exact_poly_clear(&gcd);
    return shares;
}

int exact_sign_at(exact_root *root, const exact_poly *q) {
    if (exact_poly_is_zero(q)) return 0;
    bool is_known_different = false;
    for (int round = 0;; round++) {
        if (root->is_exact) return sign_at_dyadic(q, root->k, root->m);
        if (variations_on(q, root->k, root->m) == 0) {
            /* No root inside: the sign of the middle is that of the whole interval. */
            mpz_t middle;
            mpz_init(middle);
            mpz_mul_2exp(middle, root->k, 1);
            mpz_add_ui(middle, middle, 1);
            int const sign = sign_at_dyadic(q, middle, root->m + 1);
            mpz_clear(middle);
            return sign;
        }
        if (round >= 8 && !is_known_different) {
            if (shares_root(root, q)) return 0;
            is_known_different = true;
        }
        narrow_root(root);
    }
}
