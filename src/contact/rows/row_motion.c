/* contact/rows/row_motion.c - see row_motion.h. */
#include "contact/rows/row_motion.h"

#include <math.h>
#include <string.h>

static vec3 multiply_transposed(const mat3 *a, vec3 b) {
    return vec3_make(a->m[0] * b.x + a->m[3] * b.y + a->m[6] * b.z,
                     a->m[1] * b.x + a->m[4] * b.y + a->m[7] * b.z,
                     a->m[2] * b.x + a->m[5] * b.y + a->m[8] * b.z);
}

static double get_side_sign(int side) { return side == 0 ? 1.0 : -1.0; }

static const contact_body *find_side_body(const contact_scene *scene, const contact_row *row,
                                          int side) {
    if (!row->frame.has_body || row->frame.slots[side] == TULLE_NONE) return NULL;
    return &scene->bodies[(row->frame.slots[side] - scene->cloth_vertex_count) / 2];
}

vec3 get_body_velocity(const contact_row *row, const double *u) {
    vec3 sum = {0.0, 0.0, 0.0};
    for (int side = 0; side < 2 && row->frame.has_body; side++) {
        size_t const slot = row->frame.slots[side];
        if (slot == TULLE_NONE) continue;
        sum = vec3_add_scaled(sum, vec3_load(u, slot), get_side_sign(side));
        sum = vec3_add(sum, vec3_cross(vec3_load(u, slot + 1), row->frame.arms[side]));
    }
    return sum;
}

vec3 get_coupled_velocity(const contact_row *row, const double *u) {
    vec3 sum = get_body_velocity(row, u);
    for (int k = 0; k < 4; k++)
        if (is_row_vertex(row, k))
            sum = vec3_add_scaled(sum, vec3_load(u, row->frame.vertices[k]), row->frame.weights[k]);
    return sum;
}

vec3 get_free_velocity(const contact_scene *scene, const contact_row *row, const double *u) {
    vec3 sum = get_body_velocity(row, u);
    for (int k = 0; k < 4; k++)
        if (scene->inverse_mass[row->frame.vertices[k]] > 0.0)
            sum = vec3_add_scaled(sum, vec3_load(u, row->frame.vertices[k]), row->frame.weights[k]);
    return sum;
}

vec3 get_solved_velocity(const contact_row *row, size_t cloth_count, const double *u) {
    vec3 sum = row->frame.has_body ? get_body_velocity(row, u) : vec3_make(0.0, 0.0, 0.0);
    for (int k = 0; k < 4; k++)
        if (row->frame.vertices[k] < cloth_count)
            sum = vec3_add_scaled(sum, vec3_load(u, row->frame.vertices[k]), row->frame.weights[k]);
    return sum;
}

static void add_to(double *vectors, size_t index, vec3 vector, double factor) {
    vec3_store(vectors, index, vec3_add_scaled(vec3_load(vectors, index), vector, factor));
}

static void add_to_bodies(const contact_row *row, vec3 impulse, double *sum) {
    for (int side = 0; side < 2 && row->frame.has_body; side++) {
        size_t const slot = row->frame.slots[side];
        if (slot == TULLE_NONE) continue;
        add_to(sum, slot, impulse, get_side_sign(side));
        add_to(sum, slot + 1, vec3_cross(row->frame.arms[side], impulse), 1.0);
    }
}

void add_row_impulse(const contact_row *row, size_t cloth_count, vec3 impulse, double *sum) {
    for (int k = 0; k < 4; k++)
        if (row->frame.vertices[k] < cloth_count)
            add_to(sum, row->frame.vertices[k], impulse, row->frame.weights[k]);
    add_to_bodies(row, impulse, sum);
}

static void add_block(double *blocks, size_t index, const mat3 *change, double factor) {
    mat3 block;
    memcpy(&block, blocks + 9 * index, sizeof block);
    mat3_add_scaled(&block, change, factor);
    memcpy(blocks + 9 * index, &block, sizeof block);
}

/* [a]x stiffness [a]x^T */
static mat3 turn_stiffness(const mat3 *stiffness, vec3 arm) {
    mat3 half, sum; /* columns: a x stiffness e_k; then rows in the same way */
    for (int k = 0; k < 3; k++) {
        vec3 const column =
            vec3_make(stiffness->m[3 * k], stiffness->m[3 * k + 1], stiffness->m[3 * k + 2]);
        vec3 const turned = vec3_cross(arm, column);
        half.m[3 * k] = turned.x, half.m[3 * k + 1] = turned.y, half.m[3 * k + 2] = turned.z;
    }
    for (int i = 0; i < 3; i++) {
        vec3 const turned = vec3_cross(arm, vec3_make(half.m[i], half.m[3 + i], half.m[6 + i]));
        sum.m[i] = turned.x, sum.m[3 + i] = turned.y, sum.m[6 + i] = turned.z;
    }
    return sum;
}

void add_row_blocks(const contact_row *row, size_t cloth_count, const mat3 *stiffness,
                    double *blocks) {
    for (int k = 0; k < 4; k++)
        if (row->frame.vertices[k] < cloth_count)
            add_block(blocks, row->frame.vertices[k], stiffness,
                      row->frame.weights[k] * row->frame.weights[k]);
    for (int side = 0; side < 2 && row->frame.has_body; side++) {
        size_t const slot = row->frame.slots[side];
        if (slot == TULLE_NONE) continue;
        mat3 const of_turn = turn_stiffness(stiffness, row->frame.arms[side]);
        add_block(blocks, slot, stiffness, 1.0);
        add_block(blocks, slot + 1, &of_turn, 1.0);
    }
}

/* What a unit impulse on a side answers along itself. */
static double measure_body_mobility(const contact_body *body, vec3 arm, vec3 direction) {
    vec3 const turn = vec3_cross(arm, direction);
    return 1.0 / body->body->mass +
           vec3_dot(turn, mat3_multiply_vec3(&body->inverse_inertia, turn));
}

double measure_row_mobility(const contact_scene *scene, const contact_row *row,
                            const double *blocks) {
    double mobility = 0.0;
    for (int k = 0; k < 4; k++) {
        uint32_t const vertex = row->frame.vertices[k];
        if (!(scene->inverse_mass[vertex] > 0.0)) continue;
        mat3 block;
        memcpy(&block, blocks + 9 * (size_t)vertex, sizeof block);
        double const mass =
            vec3_dot(row->frame.normal, mat3_multiply_vec3(&block, row->frame.normal));
        if (mass > 0.0) mobility += row->frame.weights[k] * row->frame.weights[k] / mass;
    }
    for (int side = 0; side < 2; side++) {
        const contact_body *const body = find_side_body(scene, row, side);
        if (body) mobility += measure_body_mobility(body, row->frame.arms[side], row->frame.normal);
    }
    return mobility;
}

void set_row_turning(const contact_scene *scene, contact_row *row) {
    row->frame.turning = vec3_make(0.0, 0.0, 0.0);
    if (!scene->carriers || row->frame.has_body) return;
    const affine_map *carrier = NULL;
    for (int k = 0; k < 4 && !carrier; k++)
        carrier = scene->carriers[scene->vertex_surface[row->frame.vertices[k]]];
    if (!carrier) return;
    vec3 const offset = vec3_scale(row->frame.normal, row->frame.gap);
    vec3 const change = vec3_sub(mat3_multiply_vec3(&carrier->matrix, offset), offset);
    row->frame.turning =
        vec3_scale(vec3_add_scaled(change, row->frame.normal, -vec3_dot(change, row->frame.normal)),
                   1.0 / scene->time_step);
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
        add_to(u, slot, impulse, get_side_sign(side) / body->body->mass);
        add_to(u, slot + 1, mat3_multiply_vec3(&body->inverse_inertia, turn), 1.0);
    }
}

/* Whether a side can move by what rows do: it is of cloth or a free body. */
static bool side_may_move(const contact_scene *scene, const contact_row *row, int side) {
    if (row->frame.slots[side] != TULLE_NONE) return true;
    bool is_cloth = false;
    for (int k = 0; k < 4; k++)
        is_cloth |=
            get_row_side(row, k) == side && row->frame.vertices[k] < scene->cloth_vertex_count;
    return is_cloth;
}

/* The point of a side at x0. */
static vec3 find_side_point(const contact_scene *scene, const contact_row *row, int side) {
    vec3 sum = {0.0, 0.0, 0.0};
    for (int k = 0; k < 4; k++)
        if (get_row_side(row, k) == side)
            sum = vec3_add_scaled(sum, vec3_load(scene->x0, row->frame.vertices[k]),
                                  fabs(row->frame.weights[k]));
    return sum;
}

/* Between two that answer, the impulse acts at one point of x0 on both, so that it keeps angular
 * momentum, friction across the gap too: cloth's own, else the middle. */
static void share_point(const contact_scene *scene, contact_row *row) {
    vec3 const first = find_side_point(scene, row, 0), second = find_side_point(scene, row, 1);
    vec3 point = vec3_lerp(first, second, 0.5);
    if (row->frame.slots[0] == TULLE_NONE) point = first;
    if (row->frame.slots[1] == TULLE_NONE) point = second;
    for (int side = 0; side < 2; side++) {
        const contact_body *const body = find_side_body(scene, row, side);
        if (!body) continue;
        row->frame.arms[side] =
            vec3_scale(vec3_sub(point, body->start.position), get_side_sign(side));
    }
}

/* Against what nothing moves, arms are those of the end of the step, where the contact lands below
 * the centre: with those of x0 a rolling ball meets a resistance of first order in its turn. */
static void choose_arms(const contact_scene *scene, contact_row *row) {
    row->frame.has_end_arms = !side_may_move(scene, row, 0) || !side_may_move(scene, row, 1);
    if (!row->frame.has_end_arms) {
        share_point(scene, row);
        return;
    }
    for (int side = 0; side < 2; side++) {
        const contact_body *const body = find_side_body(scene, row, side);
        if (body) row->frame.arms[side] = mat3_multiply_vec3(&body->turn, row->frame.arms[side]);
    }
}

void set_row_bodies(const contact_scene *scene, contact_row *row) {
    row->frame.has_body = false;
    row->frame.slots[0] = row->frame.slots[1] = TULLE_NONE;
    row->frame.arms[0] = row->frame.arms[1] = vec3_make(0.0, 0.0, 0.0);
    for (int k = 0; k < 4; k++) {
        uint32_t const index = find_body(scene, row->frame.vertices[k]);
        if (index == TULLE_NONE) continue;
        int const side = get_row_side(row, k);
        vec3 const arm = vec3_sub(vec3_load(scene->x0, row->frame.vertices[k]),
                                  scene->bodies[index].start.position);
        row->frame.has_body = true;
        row->frame.slots[side] = get_body_slot(scene, index);
        row->frame.arms[side] = vec3_add_scaled(row->frame.arms[side], arm, row->frame.weights[k]);
    }
    if (!row->frame.has_body) return;
    row->frame.is_without_cloth = true;
    for (int k = 0; k < 4; k++)
        row->frame.is_without_cloth &= row->frame.vertices[k] >= scene->cloth_vertex_count;
    choose_arms(scene, row);
}

/* K p for an impulse p on the row, K the part of bodies in the change of its velocity. */
static vec3 answer_by_bodies(const contact_scene *scene, const contact_row *row, vec3 impulse) {
    vec3 sum = {0.0, 0.0, 0.0};
    for (int side = 0; side < 2; side++) {
        const contact_body *const body = find_side_body(scene, row, side);
        if (!body) continue;
        vec3 const arm = row->frame.arms[side];
        vec3 const turn = mat3_multiply_vec3(&body->inverse_inertia, vec3_cross(arm, impulse));
        sum = vec3_add_scaled(sum, impulse, 1.0 / body->body->mass);
        sum = vec3_add(sum, vec3_cross(turn, arm));
    }
    return sum;
}

/* Two unit tangents at right angles. */
static void find_tangents(vec3 normal, vec3 *first, vec3 *second) {
    vec3 const axis = fabs(normal.x) < 0.6 ? vec3_make(1.0, 0.0, 0.0) : vec3_make(0.0, 1.0, 0.0);
    *first = vec3_normalize(vec3_cross(normal, axis));
    *second = vec3_cross(normal, *first);
}

void set_row_mobility(const contact_scene *scene, contact_row *row) {
    double of_vertices = 0.0;
    for (int k = 0; k < 4; k++)
        of_vertices += row->frame.weights[k] * row->frame.weights[k] *
                       scene->inverse_mass[row->frame.vertices[k]];
    row->solve.inverse_mass = of_vertices;
    if (!row->frame.has_body) return;
    vec3 a, b;
    find_tangents(row->frame.normal, &a, &b);
    vec3 const ka = answer_by_bodies(scene, row, a), kb = answer_by_bodies(scene, row, b);
    vec3 const kn = answer_by_bodies(scene, row, row->frame.normal);
    row->solve.inverse_mass += vec3_dot(row->frame.normal, kn);
    row->solve.slip_answer =
        vec3_add_scaled(kn, row->frame.normal, -vec3_dot(row->frame.normal, kn));
    double const aa = vec3_dot(a, ka), ab = vec3_dot(a, kb), bb = vec3_dot(b, kb);
    double const half = 0.5 * (aa - bb); /* no hypot: its last bits differ between processors */
    row->solve.slip_inverse_mass =
        of_vertices + 0.5 * (aa + bb) + sqrt(half * half + ab * ab); /* largest eigenvalue */
}

double find_row_fall(const contact_scene *scene, const contact_row *row) {
    double fall = 0.0;
    for (int k = 0; k < 4; k++)
        if (scene->inverse_mass[row->frame.vertices[k]] > 0.0)
            fall += scene->time_step * row->frame.weights[k] *
                    vec3_dot(row->frame.normal, scene->gravity);
    for (int side = 0; side < 2 && row->frame.has_body; side++)
        if (row->frame.slots[side] != TULLE_NONE)
            fall += scene->time_step * get_side_sign(side) *
                    vec3_dot(row->frame.normal, scene->gravity);
    return fall;
}

double find_row_curvature(const contact_scene *scene, const contact_row *row) {
    double sum = 0.0;
    for (int side = 0; side < 2; side++) {
        const contact_body *const body = find_side_body(scene, row, side);
        if (!body) continue;
        vec3 const arm = row->frame.arms[side];
        vec3 const way = row->frame.has_end_arms
                             ? vec3_sub(arm, multiply_transposed(&body->turn, arm))
                             : vec3_sub(mat3_multiply_vec3(&body->turn, arm), arm);
        vec3 const linear = vec3_cross(body->turn_vector, arm);
        sum += vec3_dot(row->frame.normal, vec3_sub(way, linear));
    }
    return sum;
}

double find_row_turn(const contact_scene *scene, const contact_row *row) {
    double sum = 0.0;
    for (int side = 0; side < 2; side++) {
        const contact_body *const body = find_side_body(scene, row, side);
        if (body) sum += vec3_norm(body->turn_vector);
    }
    return sum;
}
