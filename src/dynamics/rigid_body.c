/* dynamics/rigid_body.c - see rigid_body.h.
 *
 * With P the angular momentum in the body's axes and w = I^-1 P, Euler's equations are
 * dP/dt = P x w. Their implicit midpoint rule
 *     P1 = P0 + h P_m x I^-1 P_m,  P_m = (P0 + P1) / 2,
 * keeps |P|^2 and the energy, both quadratic, exactly, and turning by the Cayley map of h w_m,
 *     q1 = q0 (1, h w_m / 2) / |..|,
 * keeps q P q^-1, the spin in the world's axes. Three such steps of lengths a h, (1 - 2 a) h, a h
 * are of fourth order. Steps are cut so that none turns far.
 *
 * Based on: Simo, Wong, Unconditionally stable algorithms for rigid body dynamics that exactly
 * preserve energy and momentum, 1991; Suzuki 1990 and Yoshida 1990 (composition). */
#include "dynamics/rigid_body.h"

/* Correctly rounded. A call of cbrt is so only where the compiler folds it. */
static const double CUBE_ROOT_OF_2 = 0x1.428a2f98d728bp+0;

/* [rad] Turn of one part of a step. */
static const double PART_TURN = 0.1;
/* [rad] Turn in one step beyond which no result makes sense. */
static const double TURN_MAX = 628.0;
/* Newton's iterations of the midpoint; three or four are enough for parts this short. */
enum { MIDPOINT_ITERATIONS = 20 };

static vec3 divide(vec3 a, vec3 b) { return vec3_make(a.x / b.x, a.y / b.y, a.z / b.z); }

vec3 rigid_compute_angular_velocity(const rigid_body *body, const rigid_state *state) {
    vec3 const own = quaternion_rotate(quaternion_conjugate(state->orientation), state->spin);
    return quaternion_rotate(state->orientation, divide(own, body->moments));
}

vec3 rigid_compute_spin(const rigid_body *body, quaternion orientation, vec3 angular_velocity) {
    vec3 const own = quaternion_rotate(quaternion_conjugate(orientation), angular_velocity);
    vec3 const i = body->moments;
    return quaternion_rotate(orientation, vec3_make(own.x * i.x, own.y * i.y, own.z * i.z));
}

/* R diag(values) R^T */
static mat3 turn_diagonal(quaternion orientation, vec3 diagonal) {
    double const values[3] = {diagonal.x, diagonal.y, diagonal.z};
    mat3 const r = quaternion_to_matrix(orientation);
    mat3 result;
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            double sum = 0.0;
            for (int k = 0; k < 3; k++) sum += r.m[3 * i + k] * values[k] * r.m[3 * j + k];
            result.m[3 * i + j] = sum;
        }
    }
    return result;
}

mat3 rigid_compute_inertia(const rigid_body *body, quaternion orientation) {
    return turn_diagonal(orientation, body->moments);
}

mat3 rigid_compute_inverse_inertia(const rigid_body *body, quaternion orientation) {
    return turn_diagonal(orientation, divide(vec3_make(1.0, 1.0, 1.0), body->moments));
}

/* One midpoint step of the orientation. Newton's method finds P_m and stops when its error stops
 * shrinking. */
static quaternion turn(const rigid_body *body, quaternion q, vec3 spin, double h) {
    vec3 const start = quaternion_rotate(quaternion_conjugate(q), spin), i = body->moments;
    vec3 end = start;
    double last = (double)INFINITY;
    for (int iteration = 0; iteration < MIDPOINT_ITERATIONS; iteration++) {
        vec3 const p = vec3_lerp(start, end, 0.5), w = divide(p, i);
        vec3 const error = vec3_sub(vec3_sub(end, start), vec3_scale(vec3_cross(p, w), h));
        double const size = vec3_norm(error);
        if (!(size < last)) break;
        last = size;
        /* The slope is 1 - h/2 ([p]x I^-1 - [w]x), here by columns; Cramer's rule solves with it.
         */
        double const f = 0.5 * h;
        vec3 const c0 = {1.0, -f * (p.z / i.x - w.z), -f * (-p.y / i.x + w.y)};
        vec3 const c1 = {-f * (-p.z / i.y + w.z), 1.0, -f * (p.x / i.y - w.x)};
        vec3 const c2 = {-f * (p.y / i.z - w.y), -f * (-p.x / i.z + w.x), 1.0};
        vec3 const n = vec3_cross(c1, c2);
        vec3 const change = {vec3_dot(error, n), vec3_dot(c0, vec3_cross(error, c2)),
                             vec3_dot(c0, vec3_cross(c1, error))};
        end = vec3_sub(end, vec3_scale(change, 1.0 / vec3_dot(c0, n)));
    }
    vec3 const middle = vec3_lerp(start, end, 0.5);
    vec3 const half = vec3_scale(divide(middle, i), 0.5 * h);
    quaternion const step = {1.0, half.x, half.y, half.z};
    return quaternion_normalize(quaternion_multiply(q, step));
}

bool rigid_drift(const rigid_body *body, vec3 mean_velocity, double time_step, rigid_state *state) {
    vec3 const position = vec3_add_scaled(state->position, mean_velocity, time_step);
    double const angle = vec3_norm(rigid_compute_angular_velocity(body, state)) * time_step;
    if (!(angle <= TURN_MAX) || !isfinite(position.x + position.y + position.z)) return false;
    double const part_count = ceil(angle / PART_TURN);
    double const outer = 1.0 / (2.0 - CUBE_ROOT_OF_2), h = time_step / fmax(part_count, 1.0);
    quaternion q = state->orientation;
    for (double i = 0.0; i < part_count; i += 1.0) {
        q = turn(body, q, state->spin, outer * h);
        q = turn(body, q, state->spin, (1.0 - 2.0 * outer) * h);
        q = turn(body, q, state->spin, outer * h);
    }
    state->orientation = q;
    state->position = position;
    return true;
}

void rigid_place(const rigid_state *state, const double *points, size_t count, double *placed) {
    mat3 const r = quaternion_to_matrix(state->orientation);
    for (size_t i = 0; i < count; i++)
        vec3_store(placed, i,
                   vec3_add(state->position, mat3_multiply_vec3(&r, vec3_load(points, i))));
}
