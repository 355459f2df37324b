/* dynamics/bending_damping.c - damping of the rates at which hinges fold.
 *
 * In each triangle the fold of hinge a is measured along the triangle's normal n: it is n . c_a,
 * with c_a the hinge's vector (bending_matrix.c). The rate of the fold has the gradient
 *
 *     g_a = n w_a + e_a.
 *
 * The constant weights w_a act on the hinge's corners; e_a, from the turning of n, acts on the
 * triangle's. The force is -sum_ab g_a C_ab (g_b . v), with C the triangle's couplings times the
 * damping time. It only takes energy. Its sum and the sum of its moments are zero, and a rigid
 * motion has no rates.
 *
 * The matrix of the system holds H = sum w_a C_ab w_b, along every direction. The true matrix is
 * G = sum g_a C_ab g_b^T; the force uses it explicitly. A step is stable while G <= 2 (H + M / h).
 * All hinges of a triangle share n, so sum n w_a C_ab w_b n^T <= H, and then
 *
 *     G <= 2 H + 2 sum e_a C_ab e_b^T.
 *
 * So the part of e must stay below M / h. Where sharp folds, fine meshes or strong damping exceed
 * that, the damping of the triangle is scaled down; this effect vanishes with the time step. */
#include "dynamics/assembly.h"

#include <math.h>

/* A triangle with less than this part of its rest area has no usable normal. */
static const double FLATTENED_LIMIT = 0.1;

/* Part of M / h that the turning of normals may take. */
static const double TURNING_SHARE = 0.5;

/* A triangle at the start of the step: edges from corner 0, normal, and twice the area. */
typedef struct triangle_frame {
    vec3 left, right, normal;
    double double_area;
} triangle_frame;

/* Bounds h m^-1/2 (sum e_a C_ab e_b^T) m^-1/2, summed over all triangles at a vertex, by the trace
 * of C times sum |e_ak|^2 / m_k. */
static double bound_turning(const assembly *work, size_t triangle, const triangle_frame *frame,
                            const vec3 vectors[3]) {
    const cloth_model *const model = work->model;
    const uint32_t *const corners = model->surface->triangles + 3 * triangle;
    const uint32_t *const uses = model->surface->vertex_triangles.begin;
    double strength = 0.0, tangential2 = 0.0;
    uint32_t most = 0; /* triangles at one of the corners */
    for (int a = 0; a < 3; a++) {
        double const along = vec3_dot(frame->normal, vectors[a]);
        uint32_t const count = uses[corners[a] + 1] - uses[corners[a]];
        strength += model->bend_dampings[triangle].own[a];
        tangential2 += vec3_norm2(vec3_add_scaled(vectors[a], frame->normal, -along));
        if (count > most) most = count;
    }
    vec3 const opposite = vec3_sub(frame->right, frame->left);
    double const mobility = vec3_norm2(opposite) / model->masses[corners[0]] +
                            vec3_norm2(frame->right) / model->masses[corners[1]] +
                            vec3_norm2(frame->left) / model->masses[corners[2]];
    return work->state->time_step * strength * tangential2 * mobility * most /
           (frame->double_area * frame->double_area);
}

/* The responses of triangles, and forces [N] on their corners 1 and 2 from the turning of n. */
void fill_bending_damping(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    assembly *const work = context;
    const cloth_model *const model = work->model;
    const double *const positions = work->state->positions;
    const double *const velocities = work->state->velocities;
    for (size_t t = begin; t < end; t++) {
        const cloth_bend_damping *const damping = &model->bend_dampings[t];
        const uint32_t *const hinges = model->triangle_hinges + 3 * t;
        const uint32_t *const corners = model->surface->triangles + 3 * t;
        bend_damping_response *const response = &work->bend_dampings[t];
        vec3 *const forces = work->terms.bend_forces + 2 * t;
        *response = (bend_damping_response){0};
        forces[0] = forces[1] = (vec3){0.0, 0.0, 0.0};

        vec3 const origin = vec3_load(positions, corners[0]);
        triangle_frame frame = {.left = vec3_sub(vec3_load(positions, corners[1]), origin),
                                .right = vec3_sub(vec3_load(positions, corners[2]), origin)};
        vec3 const cross = vec3_cross(frame.left, frame.right);
        frame.double_area = vec3_norm(cross);
        if (!(frame.double_area > FLATTENED_LIMIT * damping->rest_double_area)) continue;
        vec3 const n = frame.normal = vec3_scale(cross, 1.0 / frame.double_area);

        /* dn/dt [1/s] */
        vec3 const start = vec3_load(velocities, corners[0]);
        vec3 const left = vec3_sub(vec3_load(velocities, corners[1]), start);
        vec3 const right = vec3_sub(vec3_load(velocities, corners[2]), start);
        vec3 const change = vec3_add(vec3_cross(left, frame.right), vec3_cross(frame.left, right));
        vec3 const turning =
            vec3_scale(vec3_add_scaled(change, n, -vec3_dot(n, change)), 1.0 / frame.double_area);

        /* c_a and the rates of n . c_a */
        vec3 vectors[3] = {0};
        double rates[3] = {0};
        for (int a = 0; a < 3; a++) {
            if (hinges[a] == TULLE_NONE) continue;
            const cloth_hinge *const hinge = &model->hinges[hinges[a]];
            vectors[a] = bend_sum_corners(hinge, positions);
            rates[a] =
                vec3_dot(n, bend_sum_corners(hinge, velocities)) + vec3_dot(turning, vectors[a]);
        }

        double const share = bound_turning(work, t, &frame, vectors) / TURNING_SHARE;
        double const kept = share > 1.0 ? 1.0 / share : 1.0;
        response->normal = n;
        vec3 sum = {0.0, 0.0, 0.0};
        for (uint32_t a = 0; a < 3; a++) {
            if (hinges[a] == TULLE_NONE) continue;
            /* An edge of more than two triangles is a hinge of two of them alone. */
            size_t const edge = 3 * t + a;
            const uint32_t *const sides = model->hinges[hinges[a]].sides;
            size_t const side = sides[0] == edge ? 0 : 1;
            if (sides[side] != edge) continue;
            const double *others =
                model->side_couplings + HINGE_COUPLINGS * (size_t)hinges[a] + 1 + 2 * side;
            double moment = 0.0;
            for (uint32_t b = 0; b < 3; b++) {
                double const coupling = b == a ? damping->own[a] : *others++ * damping->time;
                moment += kept * coupling * rates[b];
            }
            response->moments[a] = moment;
            sum = vec3_add_scaled(sum, vectors[a], moment);
        }

        /* -(dn/dx)^T y on corners 1 and 2, y the sum of moments times c_a */
        vec3 const across =
            vec3_scale(vec3_add_scaled(sum, n, -vec3_dot(n, sum)), 1.0 / frame.double_area);
        forces[0] = vec3_cross(across, frame.right);
        forces[1] = vec3_cross(frame.left, across);
    }
}

void gather_bending_damping(const assembly *work, uint32_t vertex, vertex_sum *sum) {
    const cloth_model *const model = work->model;
    const double *const w = work->start_velocities;
    /* The turning of normals. */
    const adjacency *const uses = &model->surface->vertex_triangles;
    for (size_t k = uses->begin[vertex]; work->terms.bend_forces && k < uses->begin[vertex + 1];
         k++) {
        uint32_t const triangle = uses->items[k];
        const uint32_t *const corners = model->surface->triangles + 3 * (size_t)triangle;
        const vec3 *const at = work->terms.bend_forces + 2 * triangle; /* on corners 1 and 2 */
        vec3 const force = corners[0] == vertex   ? vec3_neg(vec3_add(at[0], at[1]))
                           : corners[1] == vertex ? at[0]
                                                  : at[1];
        sum->force = vec3_add(sum->force, force);
        sum->source = vec3_add(sum->source, force);
    }
    /* The source -D w of the constant matrix. */
    for (size_t k = model->scalar_begin[vertex]; k < model->scalar_begin[vertex + 1]; k++)
        sum->source = vec3_add_scaled(sum->source, vec3_load(w, model->scalar_columns[k]),
                                      model->bend_scalar_damping[k]);
    for (size_t k = model->block_begin[vertex]; k < model->block_begin[vertex + 1]; k++)
        sum->source = vec3_add_scaled(sum->source, vec3_load(w, model->block_columns[k]),
                                      model->bend_block_damping[k]);
}
