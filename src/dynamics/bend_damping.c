/* dynamics/bend_damping.c - damping of the rates at which hinges fold.
 *
 * In each triangle the fold of hinge a is measured along the triangle's normal: n . c_a, c_a the
 * hinge's vector (bending_matrix.c). Its rate has the gradient g_a = n w_a + e_a, with w_a the
 * constant weights on the hinge's corners and e_a from the turning of n, on the triangle's. The
 * force is -sum_ab g_a C_ab (g_b . v), C the triangle's couplings times the damping time: it takes
 * energy only, adds up to nothing, as its moments do, and a rigid motion has no rates.
 *
 * The matrix of the system holds H = sum w_a C_ab w_b, along every direction, in place of the true
 * G = sum g_a C_ab g_b^T, which is explicit. A step is stable while G <= 2 (H + M / h). All hinges
 * of a triangle share n, so sum n w_a C_ab w_b n^T <= H; then G <= 2 H + 2 sum e_a C_ab e_b^T. What
 * remains is to keep the part of e under M / h: where sharp folds, fine meshes or strong damping
 * exceed that, the damping of the triangle is scaled down, which vanishes with the step. */
#include "dynamics/bend.h"

#include <math.h>

/* A triangle with less than this part of its rest area has no normal to go by. */
static const double FLATTENED_LIMIT = 0.1;

/* Part of M / h that the turning of normals may take. */
static const double TURNING_SHARE = 0.5;

/* A triangle now: edges from corner 0, normal, and twice the area. */
typedef struct triangle_frame {
    vec3 left, right, normal;
    double double_area;
} triangle_frame;

static const uint32_t *get_corners(const bend_damping_input *input) {
    return cloth_get_corners(input->model, input->triangle);
}

static triangle_frame get_frame(const bend_damping_input *input) {
    const uint32_t *const corners = get_corners(input);
    vec3 const origin = vec3_load(input->positions, corners[0]);
    triangle_frame frame = {.left = vec3_sub(vec3_load(input->positions, corners[1]), origin),
                            .right = vec3_sub(vec3_load(input->positions, corners[2]), origin)};
    vec3 const cross = vec3_cross(frame.left, frame.right);
    frame.double_area = vec3_norm(cross);
    if (frame.double_area > 0.0) frame.normal = vec3_scale(cross, 1.0 / frame.double_area);
    return frame;
}

/* Time derivative of the normal [1/s]. */
static vec3 get_turning(const bend_damping_input *input, const triangle_frame *frame) {
    const uint32_t *const corners = get_corners(input);
    vec3 const origin = vec3_load(input->velocities, corners[0]);
    vec3 const left = vec3_sub(vec3_load(input->velocities, corners[1]), origin);
    vec3 const right = vec3_sub(vec3_load(input->velocities, corners[2]), origin);
    vec3 const change = vec3_add(vec3_cross(left, frame->right), vec3_cross(frame->left, right));
    vec3 const across = vec3_add_scaled(change, frame->normal, -vec3_dot(frame->normal, change));
    return vec3_scale(across, 1.0 / frame->double_area);
}

static vec3 sum_hinge(const cloth_hinge *hinge, const double *values) {
    vec3 const origin = vec3_load(values, hinge->vertices[0]);
    vec3 sum = {0.0, 0.0, 0.0};
    for (int k = 1; k < 4; k++)
        sum = vec3_add_scaled(sum, vec3_sub(vec3_load(values, hinge->vertices[k]), origin),
                              hinge->weights[k]);
    return sum;
}

/* Bound of h m^-1/2 (sum e_a C_ab e_b^T) m^-1/2 over all triangles at a vertex: trace of C times
 * sum |e_ak|^2 / m_k. */
static double bound_turning(const bend_damping_input *input, const triangle_frame *frame,
                            const vec3 vectors[3]) {
    const uint32_t *const corners = get_corners(input);
    const double *const masses = input->model->masses;
    double strength = 0.0, tangential2 = 0.0;
    for (int a = 0; a < 3; a++) {
        double const along = vec3_dot(frame->normal, vectors[a]);
        strength += input->model->bend_dampings[input->triangle].own[a];
        tangential2 += vec3_norm2(vec3_add_scaled(vectors[a], frame->normal, -along));
    }
    vec3 const opposite = vec3_sub(frame->right, frame->left);
    double const mobility = vec3_norm2(opposite) / masses[corners[0]] +
                            vec3_norm2(frame->right) / masses[corners[1]] +
                            vec3_norm2(frame->left) / masses[corners[2]];
    return input->time_step * strength * tangential2 * mobility * input->triangles_at_a_vertex /
           (frame->double_area * frame->double_area);
}

/* Forces -(dn/dx)^T y on corners 1 and 2. */
static void get_turning_forces(const triangle_frame *frame, vec3 y, vec3 forces[2]) {
    vec3 const across = vec3_scale(vec3_add_scaled(y, frame->normal, -vec3_dot(frame->normal, y)),
                                   1.0 / frame->double_area);
    forces[0] = vec3_cross(across, frame->right);
    forces[1] = vec3_cross(frame->left, across);
}

/* Couplings of the hinge of edge `a` with those of all three. False for an edge of more than two
 * triangles, of which this is none of the hinge's two. */
static bool get_couplings(const bend_damping_input *input, uint32_t a, double couplings[3]) {
    const cloth_model *const model = input->model;
    const cloth_bend_damping *const damping = &model->bend_dampings[input->triangle];
    size_t const edge = 3 * input->triangle + a;
    size_t const hinge = model->triangle_hinges[edge];
    const uint32_t *const sides = model->hinges[hinge].sides;
    size_t const side = sides[0] == edge ? 0 : 1;
    if (sides[side] != edge) return false;
    const double *from = model->couplings + HINGE_COUPLINGS * hinge + 1 + 2 * side;
    for (uint32_t b = 0; b < 3; b++)
        couplings[b] = b == a ? damping->own[a] : *from++ * damping->time;
    return true;
}

void bend_evaluate_damping(const bend_damping_input *input, bend_damping_response *response,
                           vec3 forces[2]) {
    const cloth_model *const model = input->model;
    const uint32_t *const hinges = model->triangle_hinges + 3 * input->triangle;
    *response = (bend_damping_response){0};
    forces[0] = forces[1] = (vec3){0.0, 0.0, 0.0};
    triangle_frame const frame = get_frame(input);
    if (!(frame.double_area >
          FLATTENED_LIMIT * model->bend_dampings[input->triangle].rest_double_area))
        return;
    vec3 const turning = get_turning(input, &frame);
    vec3 vectors[3] = {0};
    double rates[3] = {0};
    for (int a = 0; a < 3; a++) {
        if (hinges[a] == TULLE_NONE) continue;
        const cloth_hinge *const hinge = &model->hinges[hinges[a]];
        vectors[a] = sum_hinge(hinge, input->positions);
        rates[a] = vec3_dot(frame.normal, sum_hinge(hinge, input->velocities)) +
                   vec3_dot(turning, vectors[a]);
    }
    double const share = bound_turning(input, &frame, vectors) / TURNING_SHARE;
    double const kept = share > 1.0 ? 1.0 / share : 1.0;
    response->normal = frame.normal;
    vec3 sum = {0.0, 0.0, 0.0};
    for (uint32_t a = 0; a < 3; a++) {
        double couplings[3], moment = 0.0;
        if (hinges[a] == TULLE_NONE || !get_couplings(input, a, couplings)) continue;
        for (int b = 0; b < 3; b++) moment += kept * couplings[b] * rates[b];
        response->moments[a] = moment;
        sum = vec3_add_scaled(sum, vectors[a], moment);
    }
    get_turning_forces(&frame, sum, forces);
}
