/* contact/paper/half_spaces.c - see half_spaces.h.
 *
 * Dual active sets: the first iterate is v. The half-space that an iterate misses by most joins the
 * active planes, of which at most three are independent. On the way to it the multipliers of the
 * active planes stay >= 0: a plane whose multiplier reaches zero leaves. So every iterate is the
 * point of the active planes that is nearest to v, and each lies further from v than the one
 * before. The active normals are kept as Q R, orthogonalised twice.
 *
 * Based on: Goldfarb, Idnani, A numerically stable dual method for solving strictly convex
 * quadratic programs, 1983. Departure: Q R is computed again for every change; it has at most three
 * columns. */
#include "contact/paper/half_spaces.h"

/* A vector outside a half-space by up to this part of the largest number counts as inside. That is
 * some hundred roundings. */
static const double MISSED_PART = 2e-14;
/* A normal lies in the span of the active ones if its part outside of it is shorter than this. */
static const double INDEPENDENT_SINE = 1e-14;
/* The same as a part of the tolerance. The miss that a parallel normal hides must stay below the
 * tolerance. */
static const double INDEPENDENT_PART = 0.25;
/* A direction of a multiplier below this counts as zero: no plane leaves because of rounding. */
static const double LEAST_DIRECTION = 1e-14;
/* Most changes of the active planes. Only rounding could make them go round in circles. */
enum { CHANGES_PER_PLANE = 8, CHANGES_LEAST = 64 };

typedef struct active_planes {
    const half_space *spaces;
    half_space_rules rules;
    size_t members[3];
    double multipliers[3];
    int count;
    vec3 q[3];
    double r[3][3]; /* upper triangle: normal of member k = sum_j q[j] r[j][k] */
} active_planes;

double measure_missing(const half_space *space, half_space_rules rules, vec3 v) {
    return fmin(fmax(space->offset, rules.low), rules.high) - vec3_dot(space->normal, v);
}

/* Returns the part of a vector outside the span of the active normals, and gives the coordinates of
 * the rest in Q. */
static vec3 split_outer_part(const active_planes *active, vec3 vector, double coordinates[3]) {
    for (int j = 0; j < 3; j++) coordinates[j] = 0.0;
    for (int pass = 0; pass < 2; pass++)
        for (int j = 0; j < active->count; j++) {
            double const along = vec3_dot(active->q[j], vector);
            coordinates[j] += along;
            vector = vec3_add_scaled(vector, active->q[j], -along);
        }
    return vector;
}

/* Makes a plane active. Its normal must be independent of the active ones. */
static void add_column(active_planes *active, size_t member, double multiplier) {
    double coordinates[3];
    vec3 const outer = split_outer_part(active, active->spaces[member].normal, coordinates);
    int const k = active->count;
    double const norm = vec3_norm(outer);
    active->q[k] = vec3_scale(outer, 1.0 / norm);
    for (int j = 0; j < k; j++) active->r[j][k] = coordinates[j];
    active->r[k][k] = norm;
    active->members[k] = member;
    active->multipliers[k] = multiplier;
    active->count = k + 1;
}

/* Makes the plane `entering` active, and drops others as their multipliers reach zero. *point moves
 * to the point of the active planes that is nearest to v. False when the half-spaces contradict
 * each other. */
static bool enter_plane(active_planes *active, size_t entering, vec3 v, vec3 *point) {
    const half_space *const space = &active->spaces[entering];
    double const sine = fmax(INDEPENDENT_SINE, INDEPENDENT_PART * active->rules.tolerance);
    double multiplier = 0.0;
    for (;;) {
        double coordinates[3], direction[3];
        vec3 const outer = split_outer_part(active, space->normal, coordinates);
        for (int k = active->count - 1; k >= 0; k--) { /* R direction = coordinates */
            double sum = coordinates[k];
            for (int j = k + 1; j < active->count; j++) sum -= active->r[k][j] * direction[j];
            direction[k] = sum / active->r[k][k];
        }
        /* the way to the plane, or until the first multiplier reaches zero */
        double const norm2 = vec3_norm2(outer);
        bool const is_free = active->count < 3 && norm2 > sine * sine;
        double const missing = measure_missing(space, active->rules, *point);
        double length = is_free ? missing / norm2 : (double)INFINITY;
        int leaving = -1;
        for (int k = 0; k < active->count; k++) {
            if (!(direction[k] > LEAST_DIRECTION)) continue;
            double const until = active->multipliers[k] / direction[k];
            if (until >= length) continue;
            length = until;
            leaving = k;
        }
        if (!is_free && leaving < 0) return false;
        for (int k = 0; k < active->count; k++)
            active->multipliers[k] = fmax(active->multipliers[k] - length * direction[k], 0.0);
        multiplier += length;
        if (is_free) *point = vec3_add_scaled(*point, outer, length);
        if (leaving < 0) break;
        active_planes const old = *active;
        active->count = 0;
        for (int k = 0; k < old.count; k++)
            if (k != leaving) add_column(active, old.members[k], old.multipliers[k]);
    }
    add_column(active, entering, multiplier);
    /* the nearest point to v on all active planes at once */
    double shift[3];
    *point = v;
    for (int k = 0; k < active->count; k++) {
        double sum = measure_missing(&active->spaces[active->members[k]], active->rules, v);
        for (int j = 0; j < k; j++) sum -= active->r[j][k] * shift[j];
        shift[k] = sum / active->r[k][k];
    }
    for (int k = 0; k < active->count; k++)
        *point = vec3_add_scaled(*point, active->q[k], shift[k]);
    return true;
}

bool find_nearest_point(const half_space *spaces, size_t count, half_space_rules rules, vec3 v,
                        vec3 *nearest) {
    active_planes active = {.spaces = spaces, .rules = rules};
    double size = fmax(fabs(v.x), fmax(fabs(v.y), fabs(v.z)));
    for (size_t i = 0; i < count; i++)
        size = fmax(size, fabs(fmin(fmax(spaces[i].offset, rules.low), rules.high)));
    vec3 point = v;
    for (size_t change = 0; change < CHANGES_PER_PLANE * count + CHANGES_LEAST; change++) {
        double const reach = fmax(size, vec3_norm(point));
        double largest = fmax(MISSED_PART, rules.tolerance) * reach;
        size_t entering = count;
        for (size_t i = 0; i < count; i++) {
            double const missing = measure_missing(&spaces[i], rules, point);
            if (missing <= largest) continue;
            largest = missing;
            entering = i;
        }
        if (entering == count) break;
        if (!enter_plane(&active, entering, v, &point)) return false;
    }
    *nearest = point;
    return true;
}
