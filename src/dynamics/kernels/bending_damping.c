/* dynamics/kernels/bending_damping.c - damping of the rates at which hinges fold, in eight
 * triangles at a time.
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
#include "dynamics/bending_kernel.h"
#include "math/vertex_lanes.h"

/* A triangle with less than this part of its rest area has no usable normal. */
static const double FLATTENED_LIMIT = 0.1;

/* Part of M / h that the turning of normals may take. */
static const double TURNING_SHARE = 0.5;

/* Eight triangles at the start of the step. */
typedef struct triangle_batch {
    vec3x8 left, right;             /* edges from corner 0 [m] */
    vec3x8 left_rate, right_rate;   /* [m/s] */
    vec3x8 vectors[3], rates[3];    /* c of the hinges, and its rate; zero on the border */
    double8 own[3], cross[3];       /* couplings [N s/m], see cloth_bend_damping */
    double8 rest_double_area, most; /* [m^2]; most triangles at a corner */
    double8 masses[3];              /* [kg] of the corners */
} triangle_batch;

/* Lanes beyond the last triangle repeat it. */
SIMD_INLINE triangle_batch gather_batch(const assembly *work, const lane_source *positions,
                                        const lane_source *velocities, size_t begin, size_t count) {
    const cloth_model *const model = work->model;
    lanes4 const none = {0.0, 0.0, 0.0, 0.0};
    lanes4 edges[4][DOUBLE_LANES], vectors[3][DOUBLE_LANES], rates[3][DOUBLE_LANES];
    lanes4 constants[2][DOUBLE_LANES];
    double masses[3][DOUBLE_LANES];
    for (size_t k = 0; k < DOUBLE_LANES; k++) {
        size_t const t = begin + (k < count ? k : count - 1);
        const uint32_t *const corners = model->surface->triangles + 3 * t;
        const uint32_t *const hinges = model->triangle_hinges + 3 * t;
        lanes4 const origin = lanes4_get(positions, corners[0]);
        lanes4 const start = lanes4_get(velocities, corners[0]);
        for (int i = 0; i < 2; i++) {
            edges[i][k] = lanes4_get(positions, corners[1 + i]) - origin;
            edges[2 + i][k] = lanes4_get(velocities, corners[1 + i]) - start;
        }
        for (int a = 0; a < 3; a++) {
            bool const is_border = hinges[a] == TULLE_NONE;
            vectors[a][k] = is_border ? none : lanes4_load(&work->hinge_vectors[hinges[a]].x);
            rates[a][k] = is_border ? none : lanes4_load(&work->hinge_rates[hinges[a]].x);
            masses[a][k] = model->masses[corners[a]];
        }
        constants[0][k] = lanes4_load(model->bend_dampings[t].own);
        constants[1][k] = lanes4_load(model->bend_dampings[t].cross);
    }
    double8x4 const own = lanes4_turn(constants[0]), cross = lanes4_turn(constants[1]);
    triangle_batch batch = {.left = lanes4_turn3(edges[0]),
                            .right = lanes4_turn3(edges[1]),
                            .left_rate = lanes4_turn3(edges[2]),
                            .right_rate = lanes4_turn3(edges[3]),
                            .rest_double_area = own.at[3],
                            .most = cross.at[3]};
    for (int a = 0; a < 3; a++) {
        batch.vectors[a] = lanes4_turn3(vectors[a]);
        batch.rates[a] = lanes4_turn3(rates[a]);
        batch.own[a] = own.at[a];
        batch.cross[a] = cross.at[a];
        batch.masses[a] = double8_load(masses[a]);
    }
    return batch;
}

/* Bounds h m^-1/2 (sum e_a C_ab e_b^T) m^-1/2, summed over all triangles at a vertex, by the trace
 * of C times sum |e_ak|^2 / m_k. */
SIMD_INLINE double8 bound_turning(const triangle_batch *batch, double time_step, vec3x8 normal,
                                  double8 double_area) {
    double8 strength = double8_fill(0.0), tangential2 = strength;
    for (int a = 0; a < 3; a++) {
        double8 const along = vec3x8_dot(normal, batch->vectors[a]);
        vec3x8 const tangential = vec3x8_add_scaled(batch->vectors[a], normal, -along);
        strength += batch->own[a];
        tangential2 += vec3x8_dot(tangential, tangential);
    }
    vec3x8 const opposite = vec3x8_sub(batch->right, batch->left);
    double8 const mobility = vec3x8_dot(opposite, opposite) / batch->masses[0] +
                             vec3x8_dot(batch->right, batch->right) / batch->masses[1] +
                             vec3x8_dot(batch->left, batch->left) / batch->masses[2];
    return double8_fill(time_step) * strength * tangential2 * mobility * batch->most /
           (double_area * double_area);
}

/* The part of a at right angles to the normal, over twice the area. */
SIMD_INLINE vec3x8 reject(vec3x8 a, vec3x8 normal, double8 inverse) {
    return vec3x8_scale(vec3x8_add_scaled(a, normal, -vec3x8_dot(normal, a)), inverse);
}

/* Normals, moments, and forces on corners 1 and 2 from the turning of normals. */
typedef struct batch_response {
    vec3x8 normal, forces[2];
    double8 moments[3];
} batch_response;

SIMD_INLINE batch_response respond(const triangle_batch *batch, double time_step) {
    double8 const zero = double8_fill(0.0), one = double8_fill(1.0);
    vec3x8 const cross = vec3x8_cross(batch->left, batch->right);
    double8 const length = double8_sqrt(vec3x8_dot(cross, cross));
    bool8 const is_usable =
        double8_greater(length, double8_fill(FLATTENED_LIMIT) * batch->rest_double_area);
    double8 const double_area = double8_select(is_usable, length, one);
    double8 const inverse = one / double_area;
    vec3x8 const n = vec3x8_scale(cross, inverse);
    /* dn/dt [1/s], and the rates of n . c_a */
    vec3x8 const change = vec3x8_add(vec3x8_cross(batch->left_rate, batch->right),
                                     vec3x8_cross(batch->left, batch->right_rate));
    vec3x8 const turning = reject(change, n, inverse);
    double8 rates[3];
    for (int a = 0; a < 3; a++)
        rates[a] = vec3x8_dot(n, batch->rates[a]) + vec3x8_dot(turning, batch->vectors[a]);

    double8 const share =
        bound_turning(batch, time_step, n, double_area) / double8_fill(TURNING_SHARE);
    double8 const kept = double8_select(double8_greater(share, one), one / share, one);
    vec3x8 const none = {zero, zero, zero};
    batch_response response = {.normal = vec3x8_select(is_usable, n, none)};
    vec3x8 sum = none;
    for (int a = 0; a < 3; a++) {
        double8 moment = zero;
        for (int b = 0; b < 3; b++) /* the coupling of two hinges has the third one's number */
            moment += kept * (b == a ? batch->own[a] : batch->cross[3 - a - b]) * rates[b];
        response.moments[a] = double8_select(is_usable, moment, zero);
        sum = vec3x8_add_scaled(sum, batch->vectors[a], moment);
    }
    /* -(dn/dx)^T y on corners 1 and 2, y the sum of moments times c_a */
    vec3x8 const across = reject(sum, n, inverse);
    response.forces[0] = vec3x8_select(is_usable, vec3x8_cross(across, batch->right), none);
    response.forces[1] = vec3x8_select(is_usable, vec3x8_cross(batch->left, across), none);
    return response;
}

void TULLE_KERNEL(fill_bending_damping)(void *context, size_t begin, size_t end, size_t chunk,
                                        int worker) {
    (void)chunk, (void)worker;
    const assembly *const work = context;
    size_t const vertices = work->model->vertex_count;
    lane_source const positions = lane_source_make(work->state->positions, vertices);
    lane_source const velocities = lane_source_make(work->state->velocities, vertices);
    for (; begin < end; begin += DOUBLE_LANES) {
        size_t const count = end - begin < DOUBLE_LANES ? end - begin : DOUBLE_LANES;
        triangle_batch const batch = gather_batch(work, &positions, &velocities, begin, count);
        batch_response const r = respond(&batch, work->state->time_step);
        /* Whole vectors are stored: the normal with the first moment, the other two moments, the
         * first force with the start of the second, and its rest. */
        lanes4 rows[3][DOUBLE_LANES];
        lanes4_turn_back(r.normal.x, r.normal.y, r.normal.z, r.moments[0], rows[0]);
        lanes4_turn_back(r.moments[1], r.moments[2], r.forces[1].y, r.forces[1].z, rows[1]);
        lanes4_turn_back(r.forces[0].x, r.forces[0].y, r.forces[0].z, r.forces[1].x, rows[2]);
        for (size_t k = 0; k < count; k++) {
            double *const response = (double *)&work->bend_dampings[begin + k];
            double *const forces = (double *)(work->terms.bend_forces + 2 * (begin + k));
            lanes2 const moments = __builtin_shufflevector(rows[1][k], rows[1][k], 0, 1);
            lanes2 const rest = __builtin_shufflevector(rows[1][k], rows[1][k], 2, 3);
            memcpy(response, &rows[0][k], sizeof rows[0][k]);
            memcpy(response + 4, &moments, sizeof moments);
            memcpy(forces, &rows[2][k], sizeof rows[2][k]);
            memcpy(forces + 4, &rest, sizeof rest);
        }
    }
}
