/* contact/motion_space.c - see motion_space.h.
 *
 * The widest cone inside half-spaces {n_k . v >= 0}: with w the smallest vector for which every
 * n_k . w >= 1, its axis is w / |w| and the sine of its angle 1 / |w|, since a direction x makes at
 * least the angle asin(min n_k . x) with every boundary. */
#include "contact/motion_space.h"

/* [rad] half of pi */
#define RIGHT_ANGLE 1.5707963267948966
/* Normals of features that are a hundredth of a millimetre apart are good for this much: a vector
 * misses a half-space only by more than this part of it. */
#define NORMAL_TOLERANCE 1e-9
/* |w|^2 of a cone that is a half-space but for rounding. */
#define HALF_SPACE_NORM2 (1.0 + 1e-12)
/* |w| beyond which a cone has no angle to speak of: under a millionth. */
#define EMPTY_NORM 1e6
/* Two axes nearer to opposite than this (the square of a sine) have no plane in common. */
#define OPPOSITE_SINE2 1e-24
/* A projection may go this many times as far as the largest violation. */
#define WEDGE_REACH 20.0

static bool cone_is_empty(const canonical_cone *cone) { return !(vec3_norm2(cone->axis) > 0.0); }

vec3 canonical_cone_project(const canonical_cone *cone, vec3 v) {
    vec3 const zero = {0.0, 0.0, 0.0};
    if (cone_is_empty(cone)) return zero;
    double const along = vec3_dot(v, cone->axis);
    double const cosine = cone->angle < RIGHT_ANGLE ? cos(cone->angle) : 0.0;
    if (along >= cosine * vec3_norm(v)) return v;
    vec3 const across = vec3_normalize(vec3_add_scaled(v, cone->axis, -along));
    vec3 const boundary = vec3_add_scaled(vec3_scale(cone->axis, cosine), across, sin(cone->angle));
    double const length = vec3_dot(v, boundary);
    return length > 0.0 ? vec3_scale(boundary, length) : zero;
}

canonical_cone canonical_cone_intersect(const canonical_cone *a, const canonical_cone *b) {
    canonical_cone const empty = {{0.0, 0.0, 0.0}, 0.0};
    if (cone_is_empty(a) || cone_is_empty(b)) return empty;
    vec3 const cross = vec3_cross(a->axis, b->axis);
    double const between = atan2(vec3_norm(cross), vec3_dot(a->axis, b->axis));
    if (between + a->angle <= b->angle) return *a;
    if (between + b->angle <= a->angle) return *b;
    if (between >= a->angle + b->angle || vec3_norm2(cross) < OPPOSITE_SINE2) return empty;
    /* the common arc runs on the great circle of the axes from between - b to a, seen from a */
    double const turn = 0.5 * (a->angle + between - b->angle);
    vec3 const across = vec3_normalize(vec3_cross(cross, a->axis));
    return (canonical_cone){
        vec3_normalize(vec3_add_scaled(vec3_scale(a->axis, cos(turn)), across, sin(turn))),
        0.5 * (a->angle + b->angle - between)};
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
        half_space const *const plane = &space->half_spaces[i];
        double const offset = has_offsets ? plane->offset : 0.0;
        double const slack = NORMAL_TOLERANCE * (size + fabs(offset));
        if (vec3_dot(plane->normal, v) < offset - slack) return false;
    }
    return true;
}

static vec3 project_on_polyhedron(const motion_space *space, vec3 v) {
    double const violation = find_violation(space->half_spaces, space->count, v);
    if (!(violation > 0.0)) return v;
    vec3 nearest;
    half_space_rules rules = {-(double)INFINITY, (double)INFINITY, NORMAL_TOLERANCE};
    bool const is_found = find_nearest_point(space->half_spaces, space->count, rules, v, &nearest);
    double const reach = WEDGE_REACH * violation;
    if (is_found && vec3_norm2(vec3_sub(nearest, v)) <= reach * reach) return nearest;
    rules.high = 0.0;
    if (find_nearest_point(space->half_spaces, space->count, rules, v, &nearest)) return nearest;
    return (vec3){0.0, 0.0, 0.0}; /* by rounding alone: zero is in them all */
}

vec3 motion_space_project(const motion_space *space, vec3 v) {
    if (space->kind == TULLE_MOTION_SPACE_POLYHEDRAL) return project_on_polyhedron(space, v);
    return motion_space_contains(space, v) ? v : canonical_cone_project(&space->cone, v);
}
