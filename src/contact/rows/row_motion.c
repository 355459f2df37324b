/* contact/rows/row_motion.c - see row_motion.h. */
#include "contact/rows/row_motion.h"

#include <math.h>
#include <string.h>

/* The sign of each side in the relative velocity. */
static const double SIDE_SIGNS[2] = {1.0, -1.0};

/* A row acts on vertices that can move if this much of one side's weight lies on them. With less,
 * as where an edge lies under a held one, the impulse that moves the row would throw the free
 * vertex away. */
static const double LEAST_FREE_WEIGHT = 0.01;

/* w_k u, with the tilt's part. */
static inline vec3 get_vertex_velocity(const row_frame *frame, int k, const double *velocities) {
    vec3 const u = vec3_load(velocities, frame->vertices[k]);
    vec3 const part = vec3_scale(u, frame->weights[k]);
    if (!frame->tilt || k == 0) return part;
    return vec3_add_scaled(part, frame->tilt->arms[k - 1], vec3_dot(frame->tilt->normal, u));
}

/* Its transpose. */
static inline vec3 get_vertex_impulse(const row_frame *frame, int k, vec3 impulse) {
    vec3 const part = vec3_scale(impulse, frame->weights[k]);
    if (!frame->tilt || k == 0) return part;
    return vec3_add_scaled(part, frame->tilt->normal, vec3_dot(frame->tilt->arms[k - 1], impulse));
}

/* The part of bodies in the relative velocity. */
static inline vec3 get_body_velocity(const contact_row *row, const double *u) {
    const row_frame *const frame = &row->frame;
    vec3 sum = {0.0, 0.0, 0.0};
    for (int side = 0; side < 2 && frame->has_body; side++) {
        size_t const slot = frame->slots[side];
        if (slot == TULLE_NONE) continue;
        sum = vec3_add_scaled(sum, vec3_load(u, slot), SIDE_SIGNS[side]);
        sum = vec3_add(sum, vec3_cross(vec3_load(u, slot + 1), frame->arms[side]));
    }
    return sum;
}

vec3 get_coupled_velocity(const contact_row *row, const double *u) {
    vec3 sum = get_body_velocity(row, u);
    for (int k = 0; k < 4; k++)
        if (is_row_vertex(row, k)) sum = vec3_add(sum, get_vertex_velocity(&row->frame, k, u));
    return sum;
}

vec3 get_solved_velocity(const contact_row *row, size_t cloth_count, const double *u) {
    vec3 sum = get_body_velocity(row, u);
    for (int k = 0; k < 4; k++)
        if (row->frame.vertices[k] < cloth_count)
            sum = vec3_add(sum, get_vertex_velocity(&row->frame, k, u));
    return sum;
}

vec3 get_free_velocity(const contact_scene *scene, const contact_row *row, const double *u) {
    vec3 sum = get_body_velocity(row, u);
    for (int k = 0; k < 4; k++)
        if (scene->inverse_mass[row->frame.vertices[k]] > 0.0)
            sum = vec3_add(sum, get_vertex_velocity(&row->frame, k, u));
    return sum;
}

/* Velocity [m/s] that an impulse gives a body's centre. */
static vec3 get_centre_answer(const contact_body *body, vec3 impulse) {
    vec3 const a = body->inverse_mass;
    return vec3_make(a.x * impulse.x, a.y * impulse.y, a.z * impulse.z);
}

static void add_to(double *vectors, size_t index, vec3 vector, double factor) {
    vec3_store(vectors, index, vec3_add_scaled(vec3_load(vectors, index), vector, factor));
}

void add_row_impulse(const contact_row *row, size_t cloth_count, vec3 impulse, double *sum) {
    const row_frame *const frame = &row->frame;
    for (int k = 0; k < 4; k++)
        if (frame->vertices[k] < cloth_count)
            add_to(sum, frame->vertices[k], get_vertex_impulse(frame, k, impulse), 1.0);
    for (int side = 0; side < 2 && frame->has_body; side++) {
        size_t const slot = frame->slots[side];
        if (slot == TULLE_NONE) continue;
        add_to(sum, slot, impulse, SIDE_SIGNS[side]);
        add_to(sum, slot + 1, vec3_cross(frame->arms[side], impulse), 1.0);
    }
}

void add_row_blocks(const contact_row *row, size_t cloth_count, const mat3 *stiffness,
                    double *blocks) {
    const row_frame *const frame = &row->frame;
    for (int k = 0; k < 4; k++) {
        double const factor = frame->weights[k] * frame->weights[k];
        double *const block = blocks + 9 * (size_t)frame->vertices[k];
        bool const has_tilt = frame->tilt && k > 0;
        for (int i = 0; i < 9 && frame->vertices[k] < cloth_count && !has_tilt; i++)
            block[i] += factor * stiffness->m[i];
        if (frame->vertices[k] >= cloth_count || !has_tilt) continue;
        for (int i = 0; i < 3; i++) { /* columns */
            vec3 const unit = vec3_make(i == 0, i == 1, i == 2);
            vec3 const velocity =
                vec3_add_scaled(vec3_scale(unit, frame->weights[k]), frame->tilt->arms[k - 1],
                                vec3_dot(frame->tilt->normal, unit));
            vec3 const column =
                get_vertex_impulse(frame, k, mat3_multiply_vec3(stiffness, velocity));
            block[i] += column.x, block[3 + i] += column.y, block[6 + i] += column.z;
        }
    }
    for (int side = 0; side < 2 && frame->has_body; side++) {
        size_t const slot = frame->slots[side];
        if (slot == TULLE_NONE) continue;
        /* the block of the turn is [a]x stiffness [a]x^T, a the arm */
        vec3 const arm = frame->arms[side];
        mat3 half, of_turn; /* columns: a x stiffness e_k; then rows in the same way */
        for (int k = 0; k < 3; k++) {
            vec3 const column =
                vec3_make(stiffness->m[3 * k], stiffness->m[3 * k + 1], stiffness->m[3 * k + 2]);
            vec3 const turned = vec3_cross(arm, column);
            half.m[3 * k] = turned.x, half.m[3 * k + 1] = turned.y, half.m[3 * k + 2] = turned.z;
        }
        for (int i = 0; i < 3; i++) {
            vec3 const turned = vec3_cross(arm, vec3_make(half.m[i], half.m[3 + i], half.m[6 + i]));
            of_turn.m[i] = turned.x, of_turn.m[3 + i] = turned.y, of_turn.m[6 + i] = turned.z;
        }
        for (size_t i = 0; i < 9; i++) {
            blocks[9 * slot + i] += stiffness->m[i];
            blocks[9 * (slot + 1) + i] += of_turn.m[i];
        }
    }
}

double measure_row_mobility(const contact_scene *scene, const contact_row *row,
                            const double *blocks) {
    double mobility = 0.0;
    for (int k = 0; k < 4; k++) {
        uint32_t const vertex = row->frame.vertices[k];
        if (!(scene->inverse_mass[vertex] > 0.0)) continue;
        mat3 block;
        memcpy(&block, blocks + 9 * (size_t)vertex, sizeof block);
        double factor = row->frame.weights[k] * row->frame.weights[k];
        vec3 direction = row->frame.normal;
        if (row->frame.tilt) {
            vec3 const impulse = get_vertex_impulse(&row->frame, k, direction);
            factor = vec3_norm2(impulse);
            direction = vec3_normalize(impulse);
        }
        double const mass = vec3_dot(direction, mat3_multiply_vec3(&block, direction));
        if (mass > 0.0) mobility += factor / mass;
    }
    for (int side = 0; side < 2; side++) {
        const contact_body *const body = find_side_body(scene, row, side);
        if (!body) continue;
        vec3 const turn = vec3_cross(row->frame.arms[side], row->frame.normal);
        mobility +=
            (body->drive ? vec3_dot(row->frame.normal, get_centre_answer(body, row->frame.normal))
                         : body->inverse_mass.x) +
            vec3_dot(turn, mat3_multiply_vec3(&body->inverse_inertia, turn));
    }
    return mobility;
}

void move_row(const contact_scene *scene, const contact_row *row, vec3 impulse, double *u) {
    for (int k = 0; k < 4; k++) {
        uint32_t const vertex = row->frame.vertices[k];
        double const mobility = row->frame.weights[k] * scene->inverse_mass[vertex];
        if (mobility != 0.0) add_to(u, vertex, impulse, mobility);
    }
    for (int side = 0; side < 2; side++) {
        const contact_body *const body = find_side_body(scene, row, side);
        if (!body) continue;
        size_t const slot = row->frame.slots[side];
        vec3 const turn = vec3_cross(row->frame.arms[side], impulse);
        add_to(u, slot, get_centre_answer(body, impulse), SIDE_SIGNS[side]);
        add_to(u, slot + 1, mat3_multiply_vec3(&body->inverse_inertia, turn), 1.0);
    }
}

/* Between two sides that can move, the impulse acts on both at one point of x0. So it keeps angular
 * momentum, and so does friction across the gap. The point is that of the cloth, else the middle.
 * Against things that cannot move, arms are taken at the end of the step, where the contact lands
 * below the centre. With the arms of x0 a rolling ball would meet a resistance of first order in
 * its turn.
 */
void set_row_bodies(const contact_scene *scene, contact_row *row) {
    row_frame *const frame = &row->frame;
    frame->has_body = false;
    frame->slots[0] = frame->slots[1] = TULLE_NONE;
    frame->arms[0] = frame->arms[1] = vec3_make(0.0, 0.0, 0.0);
    if (scene->body_count == 0) return;
    bool answers[2] = {false, false}, has_cloth = false;
    vec3 points[2] = {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}}; /* of each side at x0 */
    for (int k = 0; k < 4; k++) {
        int const side = get_row_side(row, k);
        uint32_t const vertex = frame->vertices[k], index = find_body(scene, vertex);
        vec3 const start = vec3_load(scene->x0, vertex);
        bool const is_cloth = vertex < scene->cloth_vertex_count;
        has_cloth |= is_cloth;
        answers[side] |= is_cloth || index != TULLE_NONE;
        points[side] = vec3_add_scaled(points[side], start, fabs(frame->weights[k]));
        if (index == TULLE_NONE) continue;
        vec3 const arm = vec3_sub(start, scene->bodies[index].start.position);
        frame->has_body = true;
        frame->slots[side] = get_body_slot(scene, index);
        frame->arms[side] = vec3_add_scaled(frame->arms[side], arm, frame->weights[k]);
    }
    if (!frame->has_body) return;
    frame->is_without_cloth = !has_cloth;
    frame->has_end_arms = !answers[0] || !answers[1];
    vec3 point = vec3_lerp(points[0], points[1], 0.5);
    if (frame->slots[0] == TULLE_NONE) point = points[0];
    if (frame->slots[1] == TULLE_NONE) point = points[1];
    for (int side = 0; side < 2; side++) {
        const contact_body *const body = find_side_body(scene, row, side);
        if (!body) continue;
        frame->arms[side] = frame->has_end_arms ? mat3_multiply_vec3(&body->turn, frame->arms[side])
                                                : vec3_scale(vec3_sub(point, body->start.position),
                                                             SIDE_SIGNS[side]);
    }
}

/* The part of a normal impulse's motion that locks leave to the bodies of a row, 0 .. 4. If it is
 * tiny, the row would throw a body along it: such a pair is treated as a pair of obstacles, which
 * only the safe commit looks after. */
static double measure_free_share(const contact_scene *scene, const contact_row *row) {
    double sum = 0.0;
    for (int side = 0; side < 2; side++) {
        const contact_body *const body = find_side_body(scene, row, side);
        if (!body) continue;
        vec3 const arm = row->frame.arms[side], turn = vec3_cross(arm, row->frame.normal);
        double const axes[6] = {
            row->frame.normal.x, row->frame.normal.y, row->frame.normal.z, turn.x, turn.y, turn.z};
        double const arm2 = vec3_norm2(arm);
        for (int k = 0; k < BODY_AXES; k++)
            if (!body->drive || !body->drive->is_locked[k])
                sum += axes[k] * axes[k] * (k < 3 ? 1.0 : arm2 > 0.0 ? 1.0 / arm2 : 0.0);
    }
    return sum;
}

bool set_row_mobility(const contact_scene *scene, contact_row *row) {
    double of_vertices = 0.0, lightest = 0.0; /* [1/kg] */
    for (int k = 0; k < 4; k++) {
        double const inverse_mass = scene->inverse_mass[row->frame.vertices[k]];
        of_vertices += row->frame.weights[k] * row->frame.weights[k] * inverse_mass;
        lightest = fmax(lightest, inverse_mass);
    }
    row->solve.inverse_mass = of_vertices;
    if (!row->frame.has_body)
        return row->solve.inverse_mass > LEAST_FREE_WEIGHT * LEAST_FREE_WEIGHT * lightest;

    /* K a, K b and K n for an impulse of 1 along two tangents and the normal, K the part of bodies
     * in the change of the row's velocity */
    vec3 const n = row->frame.normal;
    vec3 const axis = fabs(n.x) < 0.6 ? vec3_make(1.0, 0.0, 0.0) : vec3_make(0.0, 1.0, 0.0);
    vec3 const a = vec3_normalize(vec3_cross(n, axis)), b = vec3_cross(n, a);
    const vec3 impulses[3] = {a, b, n};
    vec3 answers[3];
    for (int i = 0; i < 3; i++) {
        answers[i] = vec3_make(0.0, 0.0, 0.0);
        for (int side = 0; side < 2; side++) {
            const contact_body *const body = find_side_body(scene, row, side);
            if (!body) continue;
            vec3 const arm = row->frame.arms[side];
            vec3 const turn =
                mat3_multiply_vec3(&body->inverse_inertia, vec3_cross(arm, impulses[i]));
            answers[i] = vec3_add(answers[i], get_centre_answer(body, impulses[i]));
            answers[i] = vec3_add(answers[i], vec3_cross(turn, arm));
        }
    }
    vec3 const ka = answers[0], kb = answers[1], kn = answers[2];
    row->solve.inverse_mass += vec3_dot(n, kn);
    row->solve.slip_answer = vec3_add_scaled(kn, n, -vec3_dot(n, kn));
    double const aa = vec3_dot(a, ka), ab = vec3_dot(a, kb), bb = vec3_dot(b, kb);
    double const half = 0.5 * (aa - bb); /* no hypot: its last bits differ between processors */
    row->solve.slip_inverse_mass =
        of_vertices + 0.5 * (aa + bb) + sqrt(half * half + ab * ab); /* largest eigenvalue */
    bool is_driven = false;
    for (int side = 0; side < 2; side++) {
        const contact_body *const body = find_side_body(scene, row, side);
        is_driven |= body && body->drive;
    }
    if (is_driven) { /* friction that cannot slip moves nothing, but has its bound */
        double const least = LEAST_FREE_WEIGHT * LEAST_FREE_WEIGHT;
        row->solve.slip_inverse_mass =
            fmax(row->solve.slip_inverse_mass, least * row->solve.inverse_mass);
        if (of_vertices == 0.0 && measure_free_share(scene, row) < least) return false;
    }
    return row->solve.inverse_mass > 0.0;
}

/* [m] What the predicted turn of a side's body adds to the row's vector beyond h w x arm. */
static vec3 get_side_curvature(const contact_scene *scene, const contact_row *row, int side) {
    const contact_body *const body = find_side_body(scene, row, side);
    if (!body) return vec3_make(0.0, 0.0, 0.0);
    vec3 const arm = row->frame.arms[side];
    const double *const m = body->turn.m;
    vec3 const before = {m[0] * arm.x + m[3] * arm.y + m[6] * arm.z, /* turn^T arm */
                         m[1] * arm.x + m[4] * arm.y + m[7] * arm.z,
                         m[2] * arm.x + m[5] * arm.y + m[8] * arm.z};
    vec3 const way = row->frame.has_end_arms ? vec3_sub(arm, before)
                                             : vec3_sub(mat3_multiply_vec3(&body->turn, arm), arm);
    return vec3_sub(way, vec3_cross(body->turn_vector, arm));
}

vec3 get_row_curvature(const contact_scene *scene, const contact_row *row) {
    return vec3_add(get_side_curvature(scene, row, 0), get_side_curvature(scene, row, 1));
}

double compute_row_curvature(const contact_scene *scene, const contact_row *row) {
    double sum = 0.0;
    for (int side = 0; side < 2; side++)
        if (find_side_body(scene, row, side))
            sum += vec3_dot(row->frame.normal, get_side_curvature(scene, row, side));
    return sum;
}
