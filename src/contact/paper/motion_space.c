/* contact/paper/motion_space.c - see motion_space.h.
 *
 * The widest cone inside half-spaces {n_k . v >= 0}: let w be the smallest vector for which every
 * n_k . w >= 1. The axis of the cone is w / |w|, and the sine of its angle is 1 / |w|. For a
 * direction x makes at least the angle asin(min n_k . x) with every boundary. */
#include "contact/paper/motion_space.h"

/* [rad] half of pi */
static const double RIGHT_ANGLE = 1.5707963267948966;
/* Normals of features that are a hundredth of a millimetre apart are exact to this. So a vector
 * outside a half-space by up to this part of its size counts as inside. */
static const double NORMAL_TOLERANCE = 1e-9;
/* A cone with |w|^2 up to this is a half-space but for rounding. */
static const double HALF_SPACE_NORM2 = 1.0 + 1e-12;
/* With |w| beyond this the angle of a cone is under a millionth, and the cone counts as empty. */
static const double EMPTY_NORM = 1e6;
/* A projection goes at most this many times as far as the largest violation. */
static const double WEDGE_REACH = 20.0;
/* Weight of a squared miss against a squared way: a miss counts as much as a way that is
 * WEDGE_REACH times as long. */
static const double SOFT_STIFFNESS = 20.0 * 20.0;
/* Most rounds of a soft projection, most halvings of a step, and the square of the relative change
 * that ends it. */
enum { SOFT_ROUNDS_MAX = 64, SOFT_HALVINGS_MAX = 32 };
static const double SOFT_CHANGE2 = 1e-28;

vec3 canonical_cone_project(const canonical_cone *cone, vec3 v) {
    vec3 const zero = {0.0, 0.0, 0.0};
    if (!(vec3_norm2(cone->axis) > 0.0)) return zero;
    double const along = vec3_dot(v, cone->axis);
    double const cosine = cone->angle < RIGHT_ANGLE ? cos(cone->angle) : 0.0;
    if (along >= cosine * vec3_norm(v)) return v;
    vec3 const across = vec3_normalize(vec3_add_scaled(v, cone->axis, -along));
    vec3 const boundary = vec3_add_scaled(vec3_scale(cone->axis, cosine), across, sin(cone->angle));
    double const length = vec3_dot(v, boundary);
    return length > 0.0 ? vec3_scale(boundary, length) : zero;
}

canonical_cone canonical_cone_inscribe(const half_space *spaces, size_t count) {
    canonical_cone const empty = {{0.0, 0.0, 0.0}, 0.0};
    vec3 w;
    if (!find_nearest_point(spaces, count, (half_space_rules){1.0, 1.0, NORMAL_TOLERANCE},
                            (vec3){0.0, 0.0, 0.0}, &w))
        return empty;
    double const norm2 = vec3_norm2(w);
    if (norm2 > EMPTY_NORM * EMPTY_NORM) return empty;
    double const angle = norm2 <= HALF_SPACE_NORM2 ? RIGHT_ANGLE : atan2(1.0, sqrt(norm2 - 1.0));
    return (canonical_cone){vec3_normalize(w), angle};
}

motion_space motion_space_make(tulle_motion_space kind, const half_space *half_spaces,
                               size_t count) {
    motion_space space = {.kind = kind, .half_spaces = half_spaces, .count = count};
    if (kind == TULLE_MOTION_SPACE_CONE && count > 0)
        space.cone = canonical_cone_inscribe(half_spaces, count);
    return space;
}

bool motion_space_contains(const motion_space *space, vec3 v) {
    bool const has_offsets = space->kind == TULLE_MOTION_SPACE_POLYHEDRAL;
    double const size = vec3_norm(v);
    for (size_t i = 0; i < space->count; i++) {
        const half_space *const plane = &space->half_spaces[i];
        double const offset = has_offsets ? plane->offset : 0.0;
        double const slack = NORMAL_TOLERANCE * (size + fabs(offset));
        if (vec3_dot(plane->normal, v) < offset - slack) return false;
    }
    return true;
}

/* |x - v|^2 + SOFT_STIFFNESS sum missing^2 over the half-spaces that x misses. */
static double compute_soft_cost(const motion_space *space, vec3 v, vec3 x) {
    double cost = vec3_norm2(vec3_sub(x, v));
    for (size_t i = 0; i < space->count; i++) {
        double const missing =
            fmax(measure_missing(&space->half_spaces[i], OFFSETS_AS_GIVEN, x), 0.0);
        cost += SOFT_STIFFNESS * missing * missing;
    }
    return cost;
}

/* The point with the least cost. Newton's method finds it, and ends when the half-spaces that are
 * missed stay the same. Where they change on the way, a whole step can lead uphill, and whole steps
 * can go round in a circle: such a step is halved until it leads downhill. */
static vec3 compute_soft_point(const motion_space *space, vec3 v) {
    vec3 point = v;
    double cost = compute_soft_cost(space, v, point);
    for (int round = 0; round < SOFT_ROUNDS_MAX; round++) {
        mat3 matrix = mat3_identity(1.0);
        vec3 right = v;
        for (size_t i = 0; i < space->count; i++) {
            const half_space *const plane = &space->half_spaces[i];
            if (!(measure_missing(plane, OFFSETS_AS_GIVEN, point) > 0.0)) continue;
            mat3 const outer = mat3_outer(plane->normal, plane->normal, SOFT_STIFFNESS);
            mat3_add_scaled(&matrix, &outer, 1.0);
            right = vec3_add_scaled(right, plane->normal, SOFT_STIFFNESS * plane->offset);
        }
        /* symmetric: rows are columns */
        const double *const m = matrix.m;
        vec3 const rows[3] = {{m[0], m[1], m[2]}, {m[3], m[4], m[5]}, {m[6], m[7], m[8]}};
        vec3 const yz = vec3_cross(rows[1], rows[2]), zx = vec3_cross(rows[2], rows[0]);
        vec3 const xy = vec3_cross(rows[0], rows[1]);
        double const scale = 1.0 / vec3_dot(rows[0], yz);
        vec3 next = {scale * vec3_dot(yz, right), scale * vec3_dot(zx, right),
                     scale * vec3_dot(xy, right)};
        if (vec3_norm2(vec3_sub(next, point)) <= SOFT_CHANGE2 * vec3_norm2(next)) return next;
        double next_cost = compute_soft_cost(space, v, next);
        for (int halving = 0; next_cost > cost && halving < SOFT_HALVINGS_MAX; halving++) {
            next = vec3_scale(vec3_add(point, next), 0.5);
            next_cost = compute_soft_cost(space, v, next);
        }
        point = next;
        cost = next_cost;
    }
    return point;
}

/* Finds the nearest point of the half-spaces, with offsets of at most `high`. False where there is
 * none, or it is the far end of a sharp wedge. */
static bool project_on_planes(const motion_space *space, double high, vec3 v, vec3 *nearest) {
    half_space_rules const rules = {-(double)INFINITY, high, NORMAL_TOLERANCE};
    if (!find_nearest_point(space->half_spaces, space->count, rules, v, nearest)) return false;
    double violation = 0.0;
    for (size_t i = 0; i < space->count; i++)
        violation = fmax(violation, measure_missing(&space->half_spaces[i], rules, v));
    return vec3_norm(vec3_sub(*nearest, v)) <= WEDGE_REACH * violation;
}

vec3 motion_space_project(const motion_space *space, vec3 v) {
    if (space->kind != TULLE_MOTION_SPACE_POLYHEDRAL)
        return motion_space_contains(space, v) ? v : canonical_cone_project(&space->cone, v);
    vec3 nearest;
    if (project_on_planes(space, (double)INFINITY, v, &nearest)) return nearest;
    if (project_on_planes(space, 0.0, v, &nearest)) return nearest;
    return compute_soft_point(space, v);
}
