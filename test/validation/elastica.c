/* elastica.c - see elastica.h. Based on: Love, A treatise on the mathematical theory of elasticity,
 * chapter 19. */
#include "validation/elastica.h"

#include <math.h>

enum { STEPS = 2000 };
static long double const HALF_TURN = 3.14159265358979323846264338327950288L;

typedef struct section {
    long double x, y, angle, curvature;
} section;

/* What is not known of a heart: curvature at its end, and the force across, over B / L^2. */
typedef struct unknowns {
    long double curvature, force;
} unknowns;

static section add_scaled(section a, section b, long double s) {
    return (section){a.x + s * b.x, a.y + s * b.y, a.angle + s * b.angle,
                     a.curvature + s * b.curvature};
}

/* Moments about a point of the strip: what lies beyond it up to the lowest point weighs down on it,
 * and pulls across by the force. */
static section differentiate(section at, long double place, long double weight, unknowns u) {
    long double const c = cosl(at.angle), s = sinl(at.angle);
    return (section){c, s, at.curvature, weight * (0.5L - place) * c + u.force * s};
}

/* From the end to the lowest point, by the rule of Runge and Kutta; places in between on the way.
 */
static section integrate(long double weight, long double gap, unknowns u, double *points,
                         size_t count) {
    section at = {gap, 0.0L, 0.5L * HALF_TURN, u.curvature};
    long double const step = 0.5L / STEPS;
    for (size_t i = 0, told = 0; i <= STEPS; i++) {
        for (; told < count && told * STEPS <= i * (count - 1); told++) {
            points[2 * told] = (double)at.x;
            points[2 * told + 1] = (double)at.y;
        }
        if (i == STEPS) break;
        long double const place = step * i;
        section const a = differentiate(at, place, weight, u);
        section const b =
            differentiate(add_scaled(at, a, 0.5L * step), place + 0.5L * step, weight, u);
        section const c =
            differentiate(add_scaled(at, b, 0.5L * step), place + 0.5L * step, weight, u);
        section const d = differentiate(add_scaled(at, c, step), place + step, weight, u);
        at = add_scaled(at, a, step / 6.0L);
        at = add_scaled(at, b, step / 3.0L);
        at = add_scaled(at, c, step / 3.0L);
        at = add_scaled(at, d, step / 6.0L);
    }
    return at;
}

/* Newton's method: the lowest point lies in the middle, and the strip runs level there. */
static bool solve(long double weight, long double gap, unknowns *u) {
    for (int round = 0; round < 60; round++) {
        section const end = integrate(weight, gap, *u, NULL, 0);
        long double const off[2] = {end.x, end.angle + HALF_TURN};
        if (fabsl(off[0]) + fabsl(off[1]) < 1e-14L) return true;
        long double const small = 1e-7L;
        section const a =
            integrate(weight, gap, (unknowns){u->curvature + small, u->force}, NULL, 0);
        section const b =
            integrate(weight, gap, (unknowns){u->curvature, u->force + small}, NULL, 0);
        long double const m[4] = {(a.x - end.x) / small, (b.x - end.x) / small,
                                  (a.angle - end.angle) / small, (b.angle - end.angle) / small};
        long double const inv = 1.0L / (m[0] * m[3] - m[1] * m[2]);
        long double const to[2] = {(m[1] * off[1] - m[3] * off[0]) * inv,
                                   (m[2] * off[0] - m[0] * off[1]) * inv};
        long double const share = fminl(1.0L, 10.0L / fmaxl(fabsl(to[0]), fabsl(to[1])));
        u->curvature += share * to[0];
        u->force += share * to[1];
    }
    return false;
}

bool elastica_find_heart(heart def, double *drop, double *points, size_t count) {
    /* Without weight, found from a wide range of guesses; weight is then added little by little. */
    unknowns u = {-10.0L, -40.0L};
    double const step = 10.0;
    long double const gap = (long double)def.gap;
    for (double weight = 0.0; weight < def.weight; weight += step)
        if (!solve((long double)weight, gap, &u)) return false;
    long double const whole = (long double)def.weight;
    if (!solve(whole, gap, &u)) return false;
    *drop = -(double)integrate(whole, gap, u, points, count).y;
    return true;
}

/* Complete elliptic integrals by arithmetic and geometric means: `first` K(k), and E(k) / K(k). */
static void find_integrals(double modulus, double *first, double *ratio) {
    double a = 1.0, b = sqrt(1.0 - modulus * modulus), sum = modulus * modulus, power = 1.0;
    while (a - b > 1e-15) {
        double const difference = 0.5 * (a - b), mean = 0.5 * (a + b);
        b = sqrt(a * b);
        a = mean;
        power *= 2.0;
        sum += power * difference * difference;
    }
    *first = 0.5 * (double)HALF_TURN / a;
    *ratio = 1.0 - 0.5 * sum;
}

double elastica_find_load(double shortening) {
    double low = 0.0, high = 0.9, first = 0.0, ratio = 0.0;
    for (int i = 0; i < 60; i++) {
        double const middle = 0.5 * (low + high);
        find_integrals(middle, &first, &ratio);
        if (2.0 * (1.0 - ratio) < shortening)
            low = middle;
        else
            high = middle;
    }
    return 4.0 * first * first / (double)(HALF_TURN * HALF_TURN);
}
