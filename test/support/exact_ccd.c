/* support/exact_ccd.c - see exact_ccd.h.
 *
 * All coordinates are scaled by one power of two to integers. Features touch only when their four
 * points are coplanar: at a root of a cubic. At each root in [0, 1] the inside test is a matter of
 * signs of quadratics at that root: cross products of corner differences, in a projection along an
 * axis in which the common normal is not zero. Where the whole normal is zero (no area, parallel
 * edges) they touch when a vertex lies on a segment.
 *
 * Where the cubic vanishes for all t, the times at which they touch are a closed set bounded by
 * roots of those quadratics, or by 0: it is enough to test 0 and all those roots. */
#include "support/exact_ccd.h"
#include "support/exact_poly.h"

#include <math.h>
#include <stdint.h>

typedef struct integer_vector {
    mpz_t c[3];
} integer_vector;

/* A vector whose components are polynomials in t. */
typedef struct poly_vector {
    exact_poly c[3];
} poly_vector;

static void vector_init(integer_vector *v) { mpz_inits(v->c[0], v->c[1], v->c[2], NULL); }
static void vector_clear(integer_vector *v) { mpz_clears(v->c[0], v->c[1], v->c[2], NULL); }

static void poly_vector_init(poly_vector *v) {
    for (int k = 0; k < 3; k++) exact_poly_init(&v->c[k]);
}

static void poly_vector_clear(poly_vector *v) {
    for (int k = 0; k < 3; k++) exact_poly_clear(&v->c[k]);
}

/* x = mantissa 2^exponent, the mantissa a 53-bit integer. */
static int split_double(double x, int64_t *mantissa) {
    int exponent;
    *mantissa = (int64_t)ldexp(frexp(x, &exponent), 53);
    return exponent - 53;
}

static int least_exponent(double x, int least) {
    int64_t mantissa;
    int const exponent = split_double(x, &mantissa);
    return mantissa != 0 && exponent < least ? exponent : least;
}

static int least_exponent_of_points(const vec3 points[4], int least) {
    for (int i = 0; i < 4; i++) {
        least = least_exponent(points[i].x, least);
        least = least_exponent(points[i].y, least);
        least = least_exponent(points[i].z, least);
    }
    return least;
}

/* x / 2^exponent, an integer. */
static void set_scaled(mpz_t integer, double x, int exponent) {
    int64_t mantissa;
    int const own = split_double(x, &mantissa);
    mpz_set_si(integer, (long)mantissa);
    if (mantissa != 0) mpz_mul_2exp(integer, integer, (unsigned long)(own - exponent));
}

/* The integer paths: start[i] and end[i] where t_end = a / 2^b is the new end, all times 2^b. */
typedef struct integer_pair {
    integer_vector start[4], end[4];
    int exponent; /* true coordinates are the integers times 2^exponent */
} integer_pair;

static void load_points(integer_vector points[4], const vec3 from[4], int exponent) {
    for (int i = 0; i < 4; i++) {
        const double x[3] = {from[i].x, from[i].y, from[i].z};
        vector_init(&points[i]);
        for (int k = 0; k < 3; k++) set_scaled(points[i].c[k], x[k], exponent);
    }
}

static void load_pair(integer_pair *to, const moving_pair *pair, double t_end, double separation) {
    int exponent = least_exponent(separation, 1100);
    exponent = least_exponent_of_points(pair->start, exponent);
    exponent = least_exponent_of_points(pair->end, exponent);
    load_points(to->start, pair->start, exponent);
    load_points(to->end, pair->end, exponent);
    int64_t a;
    int const time_exponent = split_double(t_end, &a);
    unsigned long const b = a != 0 ? (unsigned long)(-time_exponent) : 0;
    mpz_t step;
    mpz_init(step);
    for (int i = 0; i < 4; i++)
        for (int k = 0; k < 3; k++) {
            mpz_sub(step, to->end[i].c[k], to->start[i].c[k]);
            mpz_mul_si(step, step, (long)a);
            mpz_mul_2exp(to->start[i].c[k], to->start[i].c[k], b);
            mpz_add(to->end[i].c[k], to->start[i].c[k], step);
        }
    mpz_clear(step);
    to->exponent = exponent - (int)b;
}

static void clear_pair(integer_pair *pair) {
    for (int i = 0; i < 4; i++) {
        vector_clear(&pair->start[i]);
        vector_clear(&pair->end[i]);
    }
}

/* p_i(t) - p_j(t) */
static void make_difference(poly_vector *to, const integer_pair *pair, int i, int j) {
    for (int k = 0; k < 3; k++) {
        exact_poly *const p = &to->c[k];
        mpz_sub(p->c[0], pair->start[i].c[k], pair->start[j].c[k]);
        mpz_sub(p->c[1], pair->end[i].c[k], pair->end[j].c[k]);
        mpz_sub(p->c[1], p->c[1], p->c[0]);
        mpz_set_ui(p->c[2], 0);
        mpz_set_ui(p->c[3], 0);
    }
}

/* to += sign a b; the product has degree 3 at most. */
static void add_product(exact_poly *to, const exact_poly *a, const exact_poly *b, int sign) {
    for (int i = 0; i < 4; i++)
        for (int j = 0; i + j < 4; j++) {
            if (sign > 0)
                mpz_addmul(to->c[i + j], a->c[i], b->c[j]);
            else
                mpz_submul(to->c[i + j], a->c[i], b->c[j]);
        }
}

static void set_zero(exact_poly *p) {
    for (int i = 0; i < 4; i++) mpz_set_ui(p->c[i], 0);
}

static void make_cross(poly_vector *to, const poly_vector *a, const poly_vector *b) {
    for (int k = 0; k < 3; k++) {
        int const u = (k + 1) % 3, v = (k + 2) % 3;
        set_zero(&to->c[k]);
        add_product(&to->c[k], &a->c[u], &b->c[v], 1);
        add_product(&to->c[k], &a->c[v], &b->c[u], -1);
    }
}

static void make_dot(exact_poly *to, const poly_vector *a, const poly_vector *b) {
    set_zero(to);
    for (int k = 0; k < 3; k++) add_product(to, &a->c[k], &b->c[k], 1);
}

/* A point against a segment: cross = (a - p) x (b - p), dot = (a - p) . (b - p). */
typedef struct segment_test {
    poly_vector cross;
    exact_poly dot;
} segment_test;

/* All quadratics that decide, and the cubic. Segment tests of vertex/triangle: p on ab, bc, ca;
 * of edge/edge: b0 and b1 on the first edge, a0 and a1 on the second. */
typedef struct touch_test {
    feature_kind kind;
    int segment_count;
    segment_test segments[4];
    poly_vector normal;
    exact_poly cubic;
} touch_test;

static void make_segment_test(segment_test *test, const integer_pair *pair, int p, int a, int b) {
    poly_vector to_a, to_b;
    poly_vector_init(&to_a);
    poly_vector_init(&to_b);
    make_difference(&to_a, pair, a, p);
    make_difference(&to_b, pair, b, p);
    poly_vector_init(&test->cross);
    exact_poly_init(&test->dot);
    make_cross(&test->cross, &to_a, &to_b);
    make_dot(&test->dot, &to_a, &to_b);
    poly_vector_clear(&to_a);
    poly_vector_clear(&to_b);
}

static void make_touch_test(touch_test *test, feature_kind kind, const integer_pair *pair) {
    static const int points[2][4][3] = {{{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {0, 0, 0}},
                                        {{2, 0, 1}, {3, 0, 1}, {0, 2, 3}, {1, 2, 3}}};
    test->kind = kind;
    test->segment_count = kind == FEATURE_VERTEX_TRIANGLE ? 3 : 4;
    for (int i = 0; i < test->segment_count; i++)
        make_segment_test(&test->segments[i], pair, points[kind][i][0], points[kind][i][1],
                          points[kind][i][2]);
    poly_vector u, v, w;
    poly_vector_init(&u);
    poly_vector_init(&v);
    poly_vector_init(&w);
    bool const is_vt = kind == FEATURE_VERTEX_TRIANGLE;
    make_difference(&u, pair, is_vt ? 2 : 1, is_vt ? 1 : 0);
    make_difference(&v, pair, 3, is_vt ? 1 : 2);
    make_difference(&w, pair, is_vt ? 0 : 2, is_vt ? 1 : 0);
    poly_vector_init(&test->normal);
    make_cross(&test->normal, &u, &v);
    exact_poly_init(&test->cubic);
    make_dot(&test->cubic, &test->normal, &w);
    poly_vector_clear(&u);
    poly_vector_clear(&v);
    poly_vector_clear(&w);
}

static void clear_touch_test(touch_test *test) {
    for (int i = 0; i < test->segment_count; i++) {
        poly_vector_clear(&test->segments[i].cross);
        exact_poly_clear(&test->segments[i].dot);
    }
    poly_vector_clear(&test->normal);
    exact_poly_clear(&test->cubic);
}

static bool lies_on_segment(segment_test *test, exact_root *root) {
    for (int k = 0; k < 3; k++)
        if (exact_sign_at(root, &test->cross.c[k]) != 0) return false;
    return exact_sign_at(root, &test->dot) <= 0;
}

/* At a time when the four points are coplanar. */
static bool touches_at(touch_test *test, exact_root *root) {
    int axis = 0, normal_sign = 0;
    while (axis < 3 && (normal_sign = exact_sign_at(root, &test->normal.c[axis])) == 0) axis++;
    if (normal_sign == 0) {
        for (int i = 0; i < test->segment_count; i++)
            if (lies_on_segment(&test->segments[i], root)) return true;
        return false;
    }
    int side[4];
    for (int i = 0; i < test->segment_count; i++)
        side[i] = exact_sign_at(root, &test->segments[i].cross.c[axis]);
    if (test->kind == FEATURE_VERTEX_TRIANGLE)
        return side[0] * normal_sign >= 0 && side[1] * normal_sign >= 0 &&
               side[2] * normal_sign >= 0;
    return side[0] * side[1] <= 0 && side[2] * side[3] <= 0;
}

/* At one of the roots of p in [0, 1]; p is not zero. */
static bool touches_at_roots(touch_test *test, const exact_poly *p) {
    exact_root roots[3];
    int const count = exact_poly_roots(p, roots);
    bool touches = false;
    for (int i = 0; i < count; i++) {
        touches = touches || touches_at(test, &roots[i]);
        exact_root_clear(&roots[i]);
    }
    return touches;
}

static bool touches_at_roots_of_vector(touch_test *test, const poly_vector *v) {
    for (int k = 0; k < 3; k++)
        if (!exact_poly_is_zero(&v->c[k]) && touches_at_roots(test, &v->c[k])) return true;
    return false;
}

/* The four points are coplanar at all times. */
static bool touches_in_plane(touch_test *test) {
    exact_poly time; /* t = 0 */
    exact_poly_init(&time);
    mpz_set_ui(time.c[1], 1);
    bool touches = touches_at_roots(test, &time);
    exact_poly_clear(&time);
    touches = touches || touches_at_roots_of_vector(test, &test->normal);
    for (int i = 0; i < test->segment_count && !touches; i++) {
        const segment_test *const segment = &test->segments[i];
        touches = touches_at_roots_of_vector(test, &segment->cross) ||
                  (!exact_poly_is_zero(&segment->dot) && touches_at_roots(test, &segment->dot));
    }
    return touches;
}

bool exact_pair_touches(feature_kind kind, const moving_pair *pair, double t_end) {
    integer_pair points;
    touch_test test;
    load_pair(&points, pair, t_end, 0.0);
    make_touch_test(&test, kind, &points);
    bool is_strict, touches;
    if (exact_poly_is_zero(&test.cubic))
        touches = touches_in_plane(&test);
    else if (exact_poly_variations(&test.cubic, &is_strict) == 0 && is_strict)
        touches = false;
    else
        touches = touches_at_roots(&test, &test.cubic);
    clear_touch_test(&test);
    clear_pair(&points);
    return touches;
}

/* Integer vectors, for distances at one time. */
static void subtract(integer_vector *to, const integer_vector *a, const integer_vector *b) {
    for (int k = 0; k < 3; k++) mpz_sub(to->c[k], a->c[k], b->c[k]);
}

static void cross(integer_vector *to, const integer_vector *a, const integer_vector *b) {
    for (int k = 0; k < 3; k++) {
        int const u = (k + 1) % 3, v = (k + 2) % 3;
        mpz_mul(to->c[k], a->c[u], b->c[v]);
        mpz_submul(to->c[k], a->c[v], b->c[u]);
    }
}

static void dot(mpz_t to, const integer_vector *a, const integer_vector *b) {
    mpz_set_ui(to, 0);
    for (int k = 0; k < 3; k++) mpz_addmul(to, a->c[k], b->c[k]);
}

/* numerator / denominator > separation^2 */
static bool is_quotient_more(const mpz_t numerator, const mpz_t denominator,
                             const mpz_t separation2) {
    mpz_t product;
    mpz_init(product);
    mpz_mul(product, denominator, separation2);
    bool const is_more = mpz_cmp(numerator, product) > 0;
    mpz_clear(product);
    return is_more;
}

static bool point_is_farther(const integer_vector *p, const integer_vector *a,
                             const integer_vector *b, const mpz_t separation2) {
    integer_vector edge, offset, other, normal;
    mpz_t along, length2, value, one;
    vector_init(&edge), vector_init(&offset), vector_init(&other), vector_init(&normal);
    mpz_inits(along, length2, value, NULL);
    mpz_init_set_ui(one, 1);
    subtract(&edge, b, a);
    subtract(&offset, p, a);
    subtract(&other, p, b);
    dot(along, &offset, &edge);
    dot(length2, &edge, &edge);
    bool is_farther;
    if (mpz_sgn(along) <= 0) {
        dot(value, &offset, &offset);
        is_farther = is_quotient_more(value, one, separation2);
    } else if (mpz_cmp(along, length2) >= 0) {
        dot(value, &other, &other);
        is_farther = is_quotient_more(value, one, separation2);
    } else {
        cross(&normal, &offset, &edge);
        dot(value, &normal, &normal);
        is_farther = is_quotient_more(value, length2, separation2);
    }
    vector_clear(&edge), vector_clear(&offset), vector_clear(&other), vector_clear(&normal);
    mpz_clears(along, length2, value, one, NULL);
    return is_farther;
}

/* Sign of x, and of x - most. */
static bool is_between(const mpz_t x, const mpz_t most) {
    return mpz_sgn(x) >= 0 && mpz_cmp(x, most) <= 0;
}

/* Distance to the plane of a triangle, or of the lines of two edges, where the closest points lie
 * inside. With n = u x v: a triangle's point nearest to a + w is a + s u + t v, s = n . (w x v) /
 * n^2, t = n . (u x w) / n^2; the points of two lines are a + s u and a + w + t v, t = n . (w x u)
 * / n^2. */
static bool inside_is_farther(feature_kind kind, const integer_vector p[4],
                              const mpz_t separation2) {
    bool const is_vt = kind == FEATURE_VERTEX_TRIANGLE;
    integer_vector u, v, w, normal, turned;
    mpz_t normal2, s, t, height;
    vector_init(&u), vector_init(&v), vector_init(&w), vector_init(&normal), vector_init(&turned);
    mpz_inits(normal2, s, t, height, NULL);
    subtract(&u, &p[is_vt ? 2 : 1], &p[is_vt ? 1 : 0]);
    subtract(&v, &p[3], &p[is_vt ? 1 : 2]);
    subtract(&w, &p[is_vt ? 0 : 2], &p[is_vt ? 1 : 0]);
    cross(&normal, &u, &v);
    dot(normal2, &normal, &normal);
    cross(&turned, &w, &v);
    dot(s, &normal, &turned);
    cross(&turned, &u, &w);
    dot(t, &normal, &turned);
    if (!is_vt) mpz_neg(t, t);
    bool is_inside = mpz_sgn(normal2) != 0 && is_between(s, normal2) && is_between(t, normal2);
    if (is_inside && is_vt) {
        mpz_add(s, s, t);
        is_inside = mpz_cmp(s, normal2) <= 0;
    }
    dot(height, &normal, &w);
    mpz_mul(height, height, height);
    bool const is_farther = !is_inside || is_quotient_more(height, normal2, separation2);
    vector_clear(&u), vector_clear(&v), vector_clear(&w);
    vector_clear(&normal), vector_clear(&turned);
    mpz_clears(normal2, s, t, height, NULL);
    return is_farther;
}

bool exact_pair_is_farther(feature_kind kind, const moving_pair *pair, double t,
                           double separation) {
    integer_pair points;
    load_pair(&points, pair, t, separation);
    mpz_t separation2;
    mpz_init(separation2);
    set_scaled(separation2, separation, points.exponent);
    mpz_mul(separation2, separation2, separation2);
    const integer_vector *const p = points.end;
    bool is_farther = inside_is_farther(kind, p, separation2);
    if (kind == FEATURE_VERTEX_TRIANGLE)
        for (int k = 0; k < 3; k++)
            is_farther =
                is_farther && point_is_farther(&p[0], &p[1 + k], &p[1 + (k + 1) % 3], separation2);
    else
        for (int k = 0; k < 2; k++)
            is_farther = is_farther && point_is_farther(&p[k], &p[2], &p[3], separation2) &&
                         point_is_farther(&p[2 + k], &p[0], &p[1], separation2);
    mpz_clear(separation2);
    clear_pair(&points);
    return is_farther;
}
