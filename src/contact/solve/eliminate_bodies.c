/* contact/solve/eliminate_bodies.c - see eliminate_bodies.h. */
#include "contact/solve/eliminate_bodies.h"

#include "contact/rows/row_motion.h"

#include <math.h>
#include <string.h>

/* A pivot below this part of the diagonal is but rounding: mass is lost beside what rows pull. */
static const double LEAST_PIVOT = 1e-13;

/* How a row lies on its body. */
typedef struct row_hold {
    size_t body; /* SIZE_MAX: it lies on none */
    double sign;
    vec3 arm;
} row_hold;

static row_hold get_hold(const contact_scene *scene, const contact_row *row) {
    const row_frame *const frame = &row->frame;
    for (size_t side = 0; side < 2 && frame->has_body; side++)
        if (frame->slots[side] != TULLE_NONE)
            return (row_hold){(frame->slots[side] - scene->cloth_vertex_count) / 2,
                              side == 0 ? 1.0 : -1.0, frame->arms[side]};
    return (row_hold){.body = SIZE_MAX};
}

/* Adds an impulse of the row to the six slots of its body. */
static void add_held_impulse(const row_hold *hold, vec3 impulse, double *slots) {
    vec3_store(slots, 0, vec3_add_scaled(vec3_load(slots, 0), impulse, hold->sign));
    vec3_store(slots, 1, vec3_add(vec3_load(slots, 1), vec3_cross(hold->arm, impulse)));
}

static bool is_locked(const contact_body *body, int axis) {
    return body->drive && body->drive->is_locked[axis];
}

/* Adds the block of B that joins the body's turn to its way. */
static void add_row_to_block(const contact_row *row, const row_hold *hold, double *block) {
    for (int j = 0; j < 3; j++) {
        vec3 const unit = vec3_make(j == 0, j == 1, j == 2);
        vec3 const velocity = vec3_cross(unit, hold->arm);
        vec3 const way = vec3_scale(mat3_multiply_vec3(&row->solve.pull, velocity), hold->sign);
        block[6 * (3 + j)] += way.x;
        block[6 * (3 + j) + 1] += way.y;
        block[6 * (3 + j) + 2] += way.z;
    }
}

/* The lower triangle of a symmetric matrix by that of its Cholesky factor. False: it is not
 * positive definite. */
static bool factor_block(double *block) {
    for (int i = 0; i < 6; i++)
        for (int j = 0; j <= i; j++) {
            double sum = block[6 * i + j];
            for (int k = 0; k < j; k++) sum -= block[6 * i + k] * block[6 * j + k];
            if (i == j && !(sum > LEAST_PIVOT * block[7 * i])) return false;
            block[6 * i + j] = i == j ? sqrt(sum) : sum / block[6 * j + j];
        }
    return true;
}

static void solve_block(const double *factor, double x[6]) {
    for (int i = 0; i < 6; i++) {
        for (int k = 0; k < i; k++) x[i] -= factor[6 * i + k] * x[k];
        x[i] /= factor[7 * i];
    }
    for (int i = 5; i >= 0; i--) {
        for (int k = i + 1; k < 6; k++) x[i] -= factor[6 * k + i] * x[k];
        x[i] /= factor[7 * i];
    }
}

bool factor_bodies(eliminated_bodies *bodies, arena *scratch) {
    const contact_scene *const scene = bodies->scene;
    size_t const count = scene->body_count;
    double *const blocks = ARENA_NEW_ZEROED(scratch, double, 36 * count);
    bodies->factors = blocks;
    bodies->answers = ARENA_NEW(scratch, double, 6 * count);
    bodies->held = ARENA_NEW(scratch, uint32_t, count);
    uint8_t *const is_held = ARENA_NEW_ZEROED(scratch, uint8_t, count);
    if (!blocks || !bodies->answers || !bodies->held || !is_held) return false;
    for (size_t i = 0; i < bodies->row_count; i++) {
        row_hold const hold = get_hold(scene, bodies->rows[i]);
        if (hold.body == SIZE_MAX) continue;
        add_row_to_block(bodies->rows[i], &hold, blocks + 36 * hold.body);
        is_held[hold.body] = 1;
    }
    bodies->held_count = 0;
    bodies->is_definite = true;
    for (uint32_t b = 0; b < count; b++)
        if (is_held[b]) bodies->held[bodies->held_count++] = b;
    for (size_t b = 0; b < count; b++) {
        double *const block = blocks + 36 * b;
        const double *const own = bodies->diagonal + 9 * (size_t)get_body_slot(scene, b);
        for (int i = 3; i < 6; i++)
            for (int j = 0; j < 3; j++)
                if (is_locked(&scene->bodies[b], i) || is_locked(&scene->bodies[b], j))
                    block[6 * i + j] = 0.0;
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++) {
                block[6 * i + j] = own[3 * i + j];
                block[6 * (3 + i) + 3 + j] = own[9 + 3 * i + j];
            }
        bodies->is_definite &= factor_block(block);
    }
    return true;
}

/* The answer of a body, from the impulse in its place. */
static void solve_body(const eliminated_bodies *bodies, size_t body) {
    const contact_body *const which = &bodies->scene->bodies[body];
    double *const answer = bodies->answers + 6 * body;
    for (int k = 0; k < BODY_AXES; k++)
        if (!which->is_free || is_locked(which, k)) answer[k] = 0.0;
    solve_block(bodies->factors + 36 * body, answer);
}

void settle_bodies(const eliminated_bodies *bodies, double *u) {
    const contact_scene *const scene = bodies->scene;
    size_t const cloth_count = scene->cloth_vertex_count, number_count = 6 * scene->body_count;
    double *const slots = u + 3 * cloth_count;
    memset(slots, 0, number_count * sizeof(double)); /* rows then move with the cloth alone */
    memcpy(bodies->answers, bodies->right_hand_side + 3 * cloth_count,
           number_count * sizeof(double));
    for (size_t i = 0; i < bodies->row_count; i++) {
        const contact_row *const row = bodies->rows[i];
        row_hold const hold = get_hold(scene, row);
        if (hold.body == SIZE_MAX) continue;
        vec3 const velocity = get_solved_velocity(row, cloth_count, u);
        vec3 const impulse = mat3_multiply_vec3(&row->solve.pull, velocity);
        add_held_impulse(&hold, vec3_scale(impulse, -1.0), bodies->answers + 6 * hold.body);
    }
    for (size_t b = 0; b < scene->body_count; b++) solve_body(bodies, b);
    memcpy(slots, bodies->answers, number_count * sizeof(double));
}

double yield_bodies(const eliminated_bodies *bodies, double *impulses) {
    const contact_scene *const scene = bodies->scene;
    for (size_t i = 0; i < bodies->held_count; i++)
        memset(bodies->answers + 6 * (size_t)bodies->held[i], 0, 6 * sizeof(double));
    for (size_t i = 0; i < bodies->row_count; i++) {
        row_hold const hold = get_hold(scene, bodies->rows[i]);
        if (hold.body != SIZE_MAX)
            add_held_impulse(&hold, vec3_load(impulses, i), bodies->answers + 6 * hold.body);
    }
    for (size_t i = 0; i < bodies->held_count; i++) solve_body(bodies, bodies->held[i]);
    double less = 0.0;
    for (size_t i = 0; i < bodies->row_count; i++) {
        const contact_row *const row = bodies->rows[i];
        row_hold const hold = get_hold(scene, row);
        if (hold.body == SIZE_MAX) continue;
        const double *const slots = bodies->answers + 6 * hold.body;
        vec3 const turn = vec3_cross(vec3_load(slots, 1), hold.arm);
        vec3 const velocity = vec3_add_scaled(turn, vec3_load(slots, 0), hold.sign);
        vec3 const impulse = vec3_load(impulses, i);
        less += vec3_dot(velocity, impulse);
        vec3_store(impulses, i, vec3_sub(impulse, mat3_multiply_vec3(&row->solve.pull, velocity)));
    }
    return less;
}
