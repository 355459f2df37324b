/* dynamics/kernels/drag_kernel.c - the drag of the wind on a triangle, and damping of the rates at
 * which its hinges fold, in some triangles at a time.
 *
 * Wind: wind_evaluate says it. A third of the force acts on each corner.
 *
 * Damping: in each triangle the fold of hinge a is measured along the triangle's normal n: it is
 * n . c_a, with c_a the hinge's vector (bending_matrix.c). The rate of the fold has the gradient
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
#include "dynamics/drag_kernel.h"
#include "math/vertex_lanes.h"

/* A triangle with less than this part of its rest area has no usable normal. */
static const double FLATTENED_LIMIT = 0.1;

/* Part of M / h that the turning of normals may take. */
static const double TURNING_SHARE = 0.5;

typedef char lanes_fit[PATCH_LANES % WIDE_LANES == 0 ? 1 : -1];

/* Triangles side by side. Lanes beyond the last one repeat it; its slots have room for them. */
typedef struct patch_batch {
    const uint32_t *corners[WIDE_LANES];
    const cloth_patches *patches; /* null without damping */
    size_t lane;                  /* the first of them there */
} patch_batch;

SIMD_INLINE wide load_constant(const patch_batch *batch, const double *constants) {
    return wide_load(constants + batch->lane);
}

/* Values of their vertices: edges from corner 0 to corners 1 and 2 and to the far ones, and the sum
 * over the corners. */
typedef struct patch_values {
    wide3 left, right, fars[3], sum;
} patch_values;

SIMD_INLINE patch_values gather_values(const patch_batch *batch, const double *padded,
                                       bool has_fars, bool has_sum) {
    lanes4 rows[6][WIDE_LANES]; /* of corners, then of far ones */
    for (size_t k = 0; k < WIDE_LANES; k++) {
        for (int i = 0; i < 3; i++)
            rows[i][k] = lanes4_load(padded + 4 * (size_t)batch->corners[k][i]);
        for (int a = 0; a < 3 && has_fars; a++)
            rows[3 + a][k] =
                lanes4_load(padded + 4 * (size_t)batch->patches->fars[a][batch->lane + k]);
    }
    wide3 const origin = lanes4_turn3(rows[0]);
    wide3 const corners[2] = {lanes4_turn3(rows[1]), lanes4_turn3(rows[2])};
    patch_values values;
    values.left = wide3_sub(corners[0], origin);
    values.right = wide3_sub(corners[1], origin);
    for (int a = 0; a < 3 && has_fars; a++)
        values.fars[a] = wide3_sub(lanes4_turn3(rows[3 + a]), origin);
    if (has_sum) values.sum = wide3_add(wide3_add(origin, corners[0]), corners[1]);
    return values;
}

/* Where the triangles are. */
typedef struct patch_normals {
    wide3 normal; /* zero where there is no area */
    wide double_area, inverse;
} patch_normals;

SIMD_INLINE patch_normals find_normals(const patch_values *positions) {
    wide const zero = wide_fill(0.0), one = wide_fill(1.0);
    wide3 const cross = wide3_cross(positions->left, positions->right);
    patch_normals at = {.double_area = wide_sqrt(wide3_dot(cross, cross))};
    wide_bool const has_area = wide_greater(at.double_area, zero);
    at.inverse = wide_select(has_area, one / wide_select(has_area, at.double_area, one), zero);
    at.normal = wide3_scale(cross, at.inverse);
    return at;
}

/* ---- wind ---- */

/* Three times the velocity of the air. */
SIMD_INLINE wide3 gather_air(const assembly *work, const patch_batch *batch) {
    const vec3 *const air = work->terms.air_velocities;
    const double *const mean = work->surroundings->wind.velocity;
    if (!air)
        return (wide3){wide_fill(3.0 * mean[0]), wide_fill(3.0 * mean[1]),
                       wide_fill(3.0 * mean[2])};
    lanes4 sums[WIDE_LANES];
    for (size_t k = 0; k < WIDE_LANES; k++) {
        const uint32_t *const corners = batch->corners[k];
        sums[k] = lanes4_load(&air[corners[0]].x) + lanes4_load(&air[corners[1]].x) +
                  lanes4_load(&air[corners[2]].x);
    }
    return lanes4_turn3(sums);
}

/* On a corner: g of the drag, and f - D w. The sums are those over the corners. */
typedef struct wind_on_corner {
    wide3 drag, source;
} wind_on_corner;

SIMD_INLINE wind_on_corner blow(double drag_coefficient, const patch_normals *at, wide3 relatives,
                                wide3 starts) {
    wide const zero = wide_fill(0.0), one = wide_fill(1.0);
    wide const third = wide_fill(1.0 / 3.0);
    wide3 const w = wide3_scale(relatives, third), n = at->normal;
    wide const speed = wide_sqrt(wide3_dot(w, w)), through = wide3_dot(n, w);
    wide_bool const is_moving = wide_greater(speed, zero);
    wide const scale = wide_fill(drag_coefficient) * (0.5 * at->double_area);
    wide const pull = wide_select(is_moving, -scale * speed * through, zero);
    wide const rate = through * through / wide_select(is_moving, speed, one);
    wide const drag = wide_select(is_moving, scale * (speed + rate), zero);
    wide3 const g = wide3_scale(n, third * wide_sqrt(drag));
    wide3 const force = wide3_scale(n, third * pull);
    return (wind_on_corner){g, wide3_add_scaled(force, g, wide3_dot(g, starts))};
}

/* ---- damping ---- */

/* c of the three hinges, or its rate. */
typedef struct hinge_vectors {
    wide3 a[3];
} hinge_vectors;

SIMD_INLINE hinge_vectors sum_weights(const patch_batch *batch, const patch_values *values) {
    hinge_vectors result;
    for (int a = 0; a < 3; a++) {
        result.a[a] =
            wide3_scale(values->left, load_constant(batch, batch->patches->weights[a][0]));
        result.a[a] = wide3_add_scaled(result.a[a], values->right,
                                       load_constant(batch, batch->patches->weights[a][1]));
        result.a[a] = wide3_add_scaled(result.a[a], values->fars[a],
                                       load_constant(batch, batch->patches->weights[a][2]));
    }
    return result;
}

/* C_ab. The coupling of two hinges has the third one's number. */
SIMD_INLINE wide get_coupling(const patch_batch *batch, int a, int b) {
    return load_constant(batch, a == b ? batch->patches->own[a] : batch->patches->cross[3 - a - b]);
}

/* Bounds h m^-1/2 (sum e_a C_ab e_b^T) m^-1/2, summed over all triangles at a vertex, by the trace
 * of C times sum |e_ak|^2 / m_k. */
SIMD_INLINE wide bound_turning(const patch_batch *batch, const patch_values *positions,
                               const patch_normals *at, const hinge_vectors *c, double time_step) {
    wide tangential2 = wide_fill(0.0);
    for (int a = 0; a < 3; a++) {
        wide const along = wide3_dot(at->normal, c->a[a]);
        tangential2 += wide3_dot(c->a[a], c->a[a]) - along * along;
    }
    wide3 const left = positions->left, right = positions->right;
    wide3 const opposite = wide3_sub(right, left);
    const double(*const rates)[PATCH_LANES] = batch->patches->turning_rates;
    wide const rate = wide3_dot(opposite, opposite) * load_constant(batch, rates[0]) +
                      wide3_dot(right, right) * load_constant(batch, rates[1]) +
                      wide3_dot(left, left) * load_constant(batch, rates[2]);
    return wide_fill(time_step) * tangential2 * rate * (at->inverse * at->inverse);
}

/* The part of a at right angles to the normal, over twice the area. */
SIMD_INLINE wide3 reject(wide3 a, const patch_normals *at) {
    return wide3_scale(wide3_add_scaled(a, at->normal, -wide3_dot(at->normal, a)), at->inverse);
}

/* f - D w on the corners and the far ones. */
typedef struct damping_on_patch {
    wide3 corners[3], fars[3];
} damping_on_patch;

/* `starts` null: they are the velocities. */
SIMD_INLINE damping_on_patch damp(const patch_batch *batch, const patch_values *positions,
                                  const patch_values *velocities, const patch_values *starts,
                                  const patch_normals *at, double time_step) {
    wide const zero = wide_fill(0.0), one = wide_fill(1.0);
    wide3 const none = {zero, zero, zero}, n = at->normal;
    wide_bool const is_usable =
        wide_greater(at->double_area, wide_fill(FLATTENED_LIMIT) *
                                          load_constant(batch, batch->patches->rest_double_areas));
    hinge_vectors const c = sum_weights(batch, positions);
    hinge_vectors const moving = sum_weights(batch, velocities);
    /* dn/dt [1/s], and the rates of n . c_a */
    wide3 const change = wide3_add(wide3_cross(velocities->left, positions->right),
                                   wide3_cross(positions->left, velocities->right));
    wide3 const turning = reject(change, at);
    wide rates[3];
    for (int a = 0; a < 3; a++) rates[a] = wide3_dot(n, moving.a[a]) + wide3_dot(turning, c.a[a]);
    wide const share =
        bound_turning(batch, positions, at, &c, time_step) * wide_fill(1.0 / TURNING_SHARE);
    wide const kept = wide_select(wide_greater(share, one), one / share, one);

    /* Of each hinge the moment along n, and what w takes along every direction: H w. */
    hinge_vectors held = moving;
    if (starts) held = sum_weights(batch, starts);
    damping_on_patch result = {.corners = {none, none, none}};
    wide3 sum = none, total = none;
    for (int a = 0; a < 3; a++) {
        wide moment = zero;
        wide3 pull = none;
        for (int b = 0; b < 3; b++) {
            wide const coupling = get_coupling(batch, a, b);
            moment += coupling * rates[b];
            pull = wide3_add_scaled(pull, held.a[b], coupling);
        }
        moment = wide_select(is_usable, kept * moment, zero);
        sum = wide3_add_scaled(sum, c.a[a], moment);
        pull = wide3_add_scaled(pull, n, -moment);
        for (int i = 0; i < 2; i++)
            result.corners[1 + i] = wide3_add_scaled(
                result.corners[1 + i], pull, load_constant(batch, batch->patches->weights[a][i]));
        result.fars[a] = wide3_scale(pull, load_constant(batch, batch->patches->weights[a][2]));
        total = wide3_add(total, result.fars[a]);
    }
    /* -(dn/dx)^T y on corners 1 and 2, y the sum of moments times c_a */
    wide3 const across = reject(sum, at);
    result.corners[1] = wide3_add(result.corners[1], wide3_cross(across, positions->right));
    result.corners[2] = wide3_add(result.corners[2], wide3_cross(positions->left, across));
    total = wide3_add(total, wide3_add(result.corners[1], result.corners[2]));
    result.corners[0] = wide3_neg(total);
    return result;
}

/* ---- both ---- */

/* The numbers of the next triangles, which are most of what is read here. */
SIMD_INLINE void prefetch_patches(const cloth_patches *next) {
    enum { CACHE_LINE = 64 }; /* [bytes] */
    for (size_t i = 0; i < sizeof *next; i += CACHE_LINE)
        __builtin_prefetch((const char *)next + i);
}

SIMD_INLINE void fill_batch(const assembly *work, size_t begin, bool has_wind, bool has_damping) {
    const cloth_model *const model = work->model;
    const padded_vertices *const padded = &work->padded;
    size_t const last = model->triangle_count - 1;
    patch_batch batch = {.patches = has_damping ? &model->patches[begin / PATCH_LANES] : NULL,
                         .lane = begin % PATCH_LANES};
    for (size_t k = 0; k < WIDE_LANES; k++)
        batch.corners[k] = model->surface->triangles + 3 * (begin + k < last ? begin + k : last);
    patch_values const positions = gather_values(&batch, padded->positions, has_damping, false);
    patch_values const velocities =
        gather_values(&batch, padded->velocities, has_damping, has_wind);
    bool const has_starts = padded->starts != padded->velocities;
    patch_values starts;
    if (has_starts) starts = gather_values(&batch, padded->starts, has_damping, has_wind);
    if (has_damping && batch.lane == 0) prefetch_patches(batch.patches + 1);
    patch_normals const at = find_normals(&positions);
    wide3 sources[3];
    if (has_damping) {
        damping_on_patch const damping =
            damp(&batch, &positions, &velocities, has_starts ? &starts : NULL, &at,
                 work->state->time_step);
        corner_rows const fars = corner_rows_make(damping.fars);
        corner_rows_store(&fars, work->far_sources + 3 * begin);
        for (int k = 0; k < 3; k++) sources[k] = damping.corners[k];
    }
    if (has_wind) {
        wide3 const relatives = wide3_sub(velocities.sum, gather_air(work, &batch));
        wind_on_corner const wind = blow(work->surroundings->wind.drag_coefficient, &at, relatives,
                                         has_starts ? starts.sum : velocities.sum);
        for (int k = 0; k < 3; k++)
            sources[k] = has_damping ? wide3_add(sources[k], wind.source) : wind.source;
        lanes4 drags[WIDE_LANES];
        lanes4_turn_back(wind.drag.x, wind.drag.y, wind.drag.z, wind.drag.z, drags);
        for (size_t k = 0; k < WIDE_LANES; k++)
            lanes4_store3(&work->terms.triangle_drags[begin + k].x, drags[k]);
    }
    corner_rows const rows = corner_rows_make(sources);
    corner_rows_store(&rows, work->corner_sources + 3 * begin);
}

/* What is known when this is compiled saves time. */
void TULLE_KERNEL(fill_drag)(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    const assembly *const work = context;
    for (; begin < end; begin += WIDE_LANES) {
        if (!work->model->patches)
            fill_batch(work, begin, true, false);
        else if (work->has_wind)
            fill_batch(work, begin, true, true);
        else
            fill_batch(work, begin, false, true);
    }
}
