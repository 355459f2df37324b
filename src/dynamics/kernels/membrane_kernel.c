/* dynamics/kernels/membrane_kernel.c - forces and derivatives of eight membrane elements at a time.
 *
 * With P_u = (psi_u' + c e_v) n_u + psi_s' F_v, n_a = F_a / |F_a|, and P_v alike, the force on
 * corner i is -A (D_iu P_u + D_iv P_v), and its exact derivative is
 *
 *     -A sum_ab D_ia D_jb dP_a/dF_b.
 *
 * The system must be positive definite, with symmetric blocks. So in dP_a/dF_b
 *   - a yarn under compression has no stiffness across itself;
 *   - the term psi_s' I between warp and weft is dropped: it is as often negative as positive;
 *   - between warp and weft stands psi_s'' (F_u F_v^T + F_v F_u^T), where psi_s'' F_v F_u^T is the
 *     derivative. What is added is a coupling of the yarns, psi_s'' in place of c. It is symmetric,
 *     and the whole is definite while psi_u'' psi_v'' >= (psi_s'' |F_u| |F_v|)^2. Where shear is
 *     stiffer, this term alone is scaled down to that.
 * Forces are exact. Damping acts on the rates of e_u, e_v and s with the stiffness at rest times
 * the damping time; its derivative is treated alike.
 *
 * A guess can be far off: contact may have stopped a corner whose neighbours still move. The
 * tangent at a high strain would then overshoot. Beyond `guess_room` more than what the element has
 * at the start, a curve goes on straight, with the slope there. */
#include "dynamics/membrane.h"
#include "math/vertex_lanes.h"

/* Elements with less than this part of their length left along a yarn keep the stiffness across
 * the yarn that they have there. */
static const double COLLAPSED_LENGTH = 0.1;

/* Where a vertex is squeezed, a rough solve can throw it metres off. What is linearised there has
 * lost its stiffness within the cloth. So guesses go no farther than to this many lengths. */
static const double GUESS_LENGTH = 4.0;

/* Of its limit, a yarn may take this share within a substep before growth counts. */
static const double FREE_SHARE = 0.4;

/* Numbers of eight elements. Lanes beyond the last element repeat it. */
typedef struct lanes_of_curve {
    double8 stiffness, inv_knee2, limit, guess_room;
} lanes_of_curve;

/* In the order of membrane_fabric, which has no other numbers. */
typedef struct lanes_of_fabric {
    lanes_of_curve yarns[YARN_COUNT], shear;
    double8 coupling, damping;
} lanes_of_fabric;

typedef struct element_batch {
    const membrane_element *elements[DOUBLE_LANES];
    double8 gradients[2][YARN_COUNT], area;
    lanes_of_fabric fabric;
} element_batch;

/* Where the numbers of vertices come from. */
typedef struct motion_sources {
    lane_source positions, velocities, starts, guess, mean;
} motion_sources;

static motion_sources make_sources(const membrane_motion *motion, const double *mean) {
    size_t const count = motion->vertex_count;
    motion_sources sources = {.positions = lane_source_make(motion->positions, count)};
    if (motion->velocities) sources.velocities = lane_source_make(motion->velocities, count);
    if (motion->start_velocities)
        sources.starts = lane_source_make(motion->start_velocities, count);
    if (motion->guess) sources.guess = lane_source_make(motion->guess, count);
    if (mean) sources.mean = lane_source_make(mean, count);
    return sources;
}

enum { FABRIC_NUMBERS = sizeof(membrane_fabric) / sizeof(double) };

SIMD_INLINE void gather_fabrics(const membrane_motion *motion, element_batch *batch) {
    uint32_t const first = batch->elements[0]->fabric;
    bool is_one = true;
    for (size_t k = 1; k < DOUBLE_LANES; k++) is_one &= batch->elements[k]->fabric == first;
    double8 lanes[FABRIC_NUMBERS];
    double numbers[FABRIC_NUMBERS];
    memcpy(numbers, &motion->fabrics[first], sizeof numbers);
    for (size_t i = 0; i < FABRIC_NUMBERS; i++) lanes[i] = double8_fill(numbers[i]);
    for (size_t k = 1; !is_one && k < DOUBLE_LANES; k++) {
        memcpy(numbers, &motion->fabrics[batch->elements[k]->fabric], sizeof numbers);
        for (size_t i = 0; i < FABRIC_NUMBERS; i++) lanes[i][k] = numbers[i];
    }
    memcpy(&batch->fabric, lanes, sizeof lanes);
}

SIMD_INLINE void gather_elements(const membrane_motion *motion, size_t begin, size_t count,
                                 element_batch *batch) {
    lanes4 gradients[DOUBLE_LANES];
    double areas[DOUBLE_LANES];
    for (size_t k = 0; k < DOUBLE_LANES; k++) {
        const membrane_element *const element =
            &motion->elements[begin + (k < count ? k : count - 1)];
        batch->elements[k] = element;
        gradients[k] = lanes4_load(element->gradients[0]);
        areas[k] = element->area;
    }
    double8x4 const turned = lanes4_turn(gradients);
    for (int i = 0; i < 2; i++)
        for (int yarn = 0; yarn < YARN_COUNT; yarn++)
            batch->gradients[i][yarn] = turned.at[YARN_COUNT * i + yarn];
    batch->area = double8_load(areas);
    gather_fabrics(motion, batch);
}

/* ---- vectors along both yarns ---- */

typedef struct yarn_vectors {
    vec3x8 a[YARN_COUNT];
} yarn_vectors;

SIMD_INLINE vec3x8 combine(vec3x8 a, double8 s, vec3x8 b, double8 t) {
    return (vec3x8){a.x * s + b.x * t, a.y * s + b.y * t, a.z * s + b.z * t};
}

/* sum_i D_ia y_i for values y of the vertices. */
SIMD_INLINE yarn_vectors differentiate(const element_batch *batch, const lane_source *values) {
    lanes4 edges[2][DOUBLE_LANES];
    for (size_t k = 0; k < DOUBLE_LANES; k++) {
        const uint32_t *const corners = batch->elements[k]->corners;
        lanes4 const origin = lanes4_get(values, corners[0]);
        for (int i = 0; i < 2; i++) edges[i][k] = lanes4_get(values, corners[i + 1]) - origin;
    }
    vec3x8 const left = lanes4_turn3(edges[0]), right = lanes4_turn3(edges[1]);
    yarn_vectors result;
    for (int yarn = 0; yarn < YARN_COUNT; yarn++)
        result.a[yarn] = combine(left, batch->gradients[0][yarn], right, batch->gradients[1][yarn]);
    return result;
}

SIMD_INLINE yarn_vectors yarns_add_scaled(yarn_vectors a, yarn_vectors b, double8 s) {
    for (int yarn = 0; yarn < YARN_COUNT; yarn++)
        a.a[yarn] = vec3x8_add_scaled(a.a[yarn], b.a[yarn], s);
    return a;
}

/* ---- laws ---- */

/* A curve: its tension at `strain`, its slope, its energy, and the tension at `kept`, which is the
 * strain but for guesses too far off. */
typedef struct curve_point {
    double8 tension, slope, energy, kept, kept_tension;
} curve_point;

SIMD_INLINE curve_point follow_curve(const lanes_of_curve *lanes, double8 strain, double8 most) {
    double8 const zero = double8_fill(0.0), k = lanes->stiffness;
    double8 const kept = double8_min(strain, most);
    double8 const bent = double8_min(kept, lanes->limit);
    double8 const taut = double8_max(bent, zero);
    double8 const more = lanes->inv_knee2 * taut * taut;
    curve_point point = {.slope = k * (1.0 + 3.0 * more), .kept = kept};
    double8 const tension = k * bent * (1.0 + more), beyond = strain - bent;
    point.kept_tension = tension + point.slope * (kept - bent);
    point.tension = tension + point.slope * beyond;
    point.energy = 0.5 * k * bent * bent * (1.0 + 0.5 * more) +
                   (tension + 0.5 * point.slope * beyond) * beyond;
    return point;
}

typedef struct element_state {
    yarn_vectors lengths, directions;   /* F, n */
    double8 strains[YARN_COUNT], shear; /* e, s */
} element_state;

SIMD_INLINE element_state measure(yarn_vectors lengths) {
    element_state state = {.lengths = lengths};
    for (int yarn = 0; yarn < YARN_COUNT; yarn++) {
        vec3x8 const f = lengths.a[yarn];
        double8 const length = double8_sqrt(vec3x8_dot(f, f));
        bool8 const is_nothing = bool8_not(double8_greater(length, double8_fill(0.0)));
        double8 const inverse =
            double8_select(is_nothing, double8_fill(0.0), double8_fill(1.0) / length);
        state.directions.a[yarn] = vec3x8_scale(f, inverse);
        state.strains[yarn] = length - 1.0;
    }
    state.shear = vec3x8_dot(lengths.a[YARN_WARP], lengths.a[YARN_WEFT]);
    return state;
}

/* Tensions, and the derivatives as above. */
typedef struct element_response {
    yarn_vectors tensions;                         /* P [N/m] */
    double8 along[YARN_COUNT], across[YARN_COUNT]; /* [N/m] */
    double8 shear;                                 /* [N/m] psi_s'' */
    double8 energy;                                /* [N/m] by rest area */
} element_response;

/* `start` is where a guess begins; null: no guess. */
SIMD_INLINE element_response respond(const element_batch *batch, const element_state *state,
                                     const element_state *start) {
    double8 const coupling = batch->fabric.coupling, zero = double8_fill(0.0);
    double8 const endless = double8_fill((double)INFINITY);
    curve_point yarns[YARN_COUNT];
    for (int yarn = 0; yarn < YARN_COUNT; yarn++) {
        double8 most = endless;
        if (start)
            most = double8_max(start->strains[yarn], zero) + batch->fabric.yarns[yarn].guess_room;
        yarns[yarn] = follow_curve(&batch->fabric.yarns[yarn], state->strains[yarn], most);
    }
    double8 most = endless;
    if (start) most = double8_abs(start->shear) + batch->fabric.shear.guess_room;
    curve_point const shear = follow_curve(&batch->fabric.shear, double8_abs(state->shear), most);
    double8 const turn =
        double8_select(double8_greater(zero, state->shear), -shear.tension, shear.tension);

    element_response response = {.shear = shear.slope};
    response.energy = yarns[YARN_WARP].energy + yarns[YARN_WEFT].energy + shear.energy +
                      coupling * state->strains[YARN_WARP] * state->strains[YARN_WEFT];
    for (int yarn = 0; yarn < YARN_COUNT; yarn++) {
        int const other = 1 - yarn;
        double8 const pull = yarns[yarn].tension + coupling * state->strains[other];
        response.tensions.a[yarn] =
            combine(state->directions.a[yarn], pull, state->lengths.a[other], turn);
        response.along[yarn] = yarns[yarn].slope;
        double8 const kept = yarns[yarn].kept_tension + coupling * yarns[other].kept;
        double8 const length = double8_max(1.0 + yarns[yarn].kept, double8_fill(COLLAPSED_LENGTH));
        response.across[yarn] = double8_max(kept, zero) / length;
    }
    return response;
}

/* ---- derivatives ---- */

/* dP/dF as it stands in the system: along n and across it for each yarn, shear within a yarn and
 * between both. */
typedef struct tangent {
    double8 along[YARN_COUNT], across[YARN_COUNT], shear, cross;
} tangent;

/* The tangent times d. */
SIMD_INLINE yarn_vectors apply_tangent(const tangent *by, const element_state *at,
                                       const yarn_vectors *d) {
    yarn_vectors result;
    for (int yarn = 0; yarn < YARN_COUNT; yarn++) {
        int const other = 1 - yarn;
        vec3x8 const n = at->directions.a[yarn], own = at->lengths.a[yarn];
        vec3x8 const far = at->lengths.a[other], moved = d->a[yarn], far_moved = d->a[other];
        double8 const along = (by->along[yarn] - by->across[yarn]) * vec3x8_dot(n, moved);
        double8 const turned =
            by->shear * vec3x8_dot(far, moved) + by->cross * vec3x8_dot(own, far_moved);
        vec3x8 sum = combine(moved, by->across[yarn], n, along);
        sum = vec3x8_add_scaled(sum, far, turned);
        result.a[yarn] = vec3x8_add_scaled(sum, own, by->cross * vec3x8_dot(far, far_moved));
    }
    return result;
}

/* Tensions of damping: by the true derivative, where s changes by F_u . v_v + F_v . v_u. */
SIMD_INLINE yarn_vectors damp_rates(const tangent *by, const element_state *at,
                                    const yarn_vectors *rates) {
    double8 const turning = by->shear * (vec3x8_dot(at->lengths.a[YARN_WARP], rates->a[YARN_WEFT]) +
                                         vec3x8_dot(at->lengths.a[YARN_WEFT], rates->a[YARN_WARP]));
    yarn_vectors result;
    for (int yarn = 0; yarn < YARN_COUNT; yarn++) {
        vec3x8 const n = at->directions.a[yarn];
        result.a[yarn] = combine(n, by->along[yarn] * vec3x8_dot(n, rates->a[yarn]),
                                 at->lengths.a[1 - yarn], turning);
    }
    return result;
}

typedef struct symmetric8 {
    double8 m[6];
} symmetric8;

SIMD_INLINE symmetric8 symmetric8_square(vec3x8 n, double8 s) {
    vec3x8 const t = vec3x8_scale(n, s);
    return (symmetric8){{t.x * n.x, t.x * n.y, t.x * n.z, t.y * n.y, t.y * n.z, t.z * n.z}};
}

/* across I + (along - across) n n^T + shear F F^T, F of the other yarn */
SIMD_INLINE symmetric8 make_own_block(const tangent *by, const element_state *at, int yarn) {
    symmetric8 const n =
        symmetric8_square(at->directions.a[yarn], by->along[yarn] - by->across[yarn]);
    symmetric8 const f = symmetric8_square(at->lengths.a[1 - yarn], by->shear);
    symmetric8 sum;
    for (int i = 0; i < 6; i++) sum.m[i] = n.m[i] + f.m[i];
    sum.m[0] += by->across[yarn];
    sum.m[3] += by->across[yarn];
    sum.m[5] += by->across[yarn];
    return sum;
}

/* cross (F_u F_v^T + F_v F_u^T) */
SIMD_INLINE symmetric8 make_cross_block(const tangent *by, const element_state *at) {
    vec3x8 const u = vec3x8_scale(at->lengths.a[YARN_WARP], by->cross);
    vec3x8 const v = at->lengths.a[YARN_WEFT];
    return (symmetric8){{2.0 * u.x * v.x, u.x * v.y + u.y * v.x, u.x * v.z + u.z * v.x,
                         2.0 * u.y * v.y, u.y * v.z + u.z * v.y, 2.0 * u.z * v.z}};
}

/* ---- what is stored ---- */

/* Eight vectors, each to a place three on from the last one's. */
SIMD_INLINE void store_rows(vec3x8 a, size_t count, vec3 *to) {
    lanes4 rows[DOUBLE_LANES];
    lanes4_turn_back(a.x, a.y, a.z, a.z, rows);
    for (size_t k = 0; k < count; k++) lanes4_store3(&to[3 * k].x, rows[k]);
}

/* -A sum_a D_ia P_a on the corners */
SIMD_INLINE void store_forces(const element_batch *batch, const yarn_vectors *tensions,
                              size_t count, vec3 *to) {
    vec3x8 forces[2];
    for (size_t i = 0; i < 2; i++) {
        double8 const u = batch->area * batch->gradients[i][YARN_WARP];
        double8 const v = batch->area * batch->gradients[i][YARN_WEFT];
        forces[i] = vec3x8_neg(combine(tensions->a[YARN_WARP], u, tensions->a[YARN_WEFT], v));
        store_rows(forces[i], count, to + 1 + i);
    }
    store_rows(vec3x8_neg(vec3x8_add(forces[0], forces[1])), count, to);
}

SIMD_INLINE void store_blocks(const element_batch *batch, const tangent *by,
                              const element_state *at, size_t count, symmetric3 *to) {
    symmetric8 const warp = make_own_block(by, at, YARN_WARP);
    symmetric8 const weft = make_own_block(by, at, YARN_WEFT);
    symmetric8 const cross = make_cross_block(by, at);
    double8 const area = batch->area;
    double8 d[3][YARN_COUNT];
    for (int yarn = 0; yarn < YARN_COUNT; yarn++) {
        d[1][yarn] = batch->gradients[0][yarn];
        d[2][yarn] = batch->gradients[1][yarn];
        d[0][yarn] = -(d[1][yarn] + d[2][yarn]);
    }
    for (size_t e = 0; e < 3; e++) {
        const double8 *const a = d[e], *const b = d[(e + 1) % 3];
        double8 const u = -area * (a[YARN_WARP] * b[YARN_WARP]);
        double8 const v = -area * (a[YARN_WEFT] * b[YARN_WEFT]);
        double8 const uv = -area * (a[YARN_WARP] * b[YARN_WEFT] + a[YARN_WEFT] * b[YARN_WARP]);
        double8 m[6];
        for (size_t i = 0; i < 6; i++) m[i] = u * warp.m[i] + v * weft.m[i] + uv * cross.m[i];
        lanes4 first[DOUBLE_LANES], last[DOUBLE_LANES];
        lanes4_turn_back(m[0], m[1], m[2], m[3], first);
        lanes4_turn_back(m[4], m[5], m[4], m[5], last);
        for (size_t k = 0; k < count; k++) {
            memcpy(to[3 * k + e].m, &first[k], sizeof first[k]);
            memcpy(to[3 * k + e].m + 4, &last[k], 2 * sizeof(double));
        }
    }
}

/* ---- the system ---- */

/* Where eight elements are linearised, and how. */
typedef struct linearisation {
    element_state start, at; /* at x0; at the guess */
    yarn_vectors way;        /* from one to the other by the guess [1/s] */
    element_response first, response;
    tangent stiff, damp, all; /* of strain, of its rate, and alpha D + beta K */
} linearisation;

SIMD_INLINE tangent make_tangent(const double8 along[YARN_COUNT], const double8 across[YARN_COUNT],
                                 double8 shear) {
    return (tangent){.along = {along[YARN_WARP], along[YARN_WEFT]},
                     .across = {across[YARN_WARP], across[YARN_WEFT]},
                     .shear = shear};
}

/* Gives the tangents what stands between the yarns: as much as keeps the whole definite. */
SIMD_INLINE void couple_yarns(linearisation *line) {
    double8 const lengths =
        (line->at.strains[YARN_WARP] + 1.0) * (line->at.strains[YARN_WEFT] + 1.0);
    double8 const wanted = line->all.shear * lengths;
    double8 const most = double8_sqrt(line->all.along[YARN_WARP] * line->all.along[YARN_WEFT]);
    double8 const part =
        double8_select(double8_greater(wanted, most), most / wanted, double8_fill(1.0));
    line->stiff.cross = part * line->stiff.shear;
    line->damp.cross = part * line->damp.shear;
    line->all.cross = part * line->all.shear;
}

/* The part of the way on which no yarn gets longer than GUESS_LENGTH times what it is at the start,
 * or at rest where that is more. */
SIMD_INLINE yarn_vectors limit_way(const yarn_vectors *start, yarn_vectors way, double time_step) {
    double8 const one = double8_fill(1.0), h = double8_fill(time_step);
    double8 part = one;
    for (int yarn = 0; yarn < YARN_COUNT; yarn++) {
        vec3x8 const f = start->a[yarn], d = vec3x8_scale(way.a[yarn], h);
        double8 const ff = vec3x8_dot(f, f), fd = vec3x8_dot(f, d), dd = vec3x8_dot(d, d);
        double8 const room = double8_fill(GUESS_LENGTH * GUESS_LENGTH) * double8_max(ff, one) - ff;
        /* ff + 2 p fd + p p dd = ff + room */
        double8 const most = (double8_sqrt(fd * fd + dd * room) - fd) / dd;
        bool8 const is_long = double8_greater(dd + 2.0 * fd, room);
        part = double8_select(is_long, double8_min(part, most), part);
    }
    for (int yarn = 0; yarn < YARN_COUNT; yarn++) way.a[yarn] = vec3x8_scale(way.a[yarn], part);
    return way;
}

/* `has_guess` is known when this is compiled: without a guess much is the same. */
SIMD_INLINE void linearise(const membrane_motion *motion, const motion_sources *sources,
                           const element_batch *batch, bool has_guess, bool needs_first,
                           linearisation *line) {
    line->start = measure(differentiate(batch, &sources->positions));
    if (!has_guess || needs_first) line->first = respond(batch, &line->start, NULL);
    if (has_guess) {
        line->way = limit_way(&line->start.lengths, differentiate(batch, &sources->guess),
                              motion->time_step);
        line->at = measure(
            yarns_add_scaled(line->start.lengths, line->way, double8_fill(motion->time_step)));
        line->response = respond(batch, &line->at, &line->start);
    } else {
        line->at = line->start;
        line->response = line->first;
    }
    double8 const alpha = double8_fill(motion->alpha), beta = double8_fill(motion->beta);
    double8 const damping = batch->fabric.damping;
    double8 along[3][YARN_COUNT], across[3][YARN_COUNT];
    for (int yarn = 0; yarn < YARN_COUNT; yarn++) {
        double8 const k = batch->fabric.yarns[yarn].stiffness;
        vec3x8 const n = line->at.directions.a[yarn];
        bool8 const has_length = double8_greater(vec3x8_dot(n, n), double8_fill(0.0));
        along[0][yarn] = line->response.along[yarn];
        across[0][yarn] = double8_select(has_length, line->response.across[yarn], k);
        along[1][yarn] = damping * k;
        across[1][yarn] = double8_fill(0.0);
        along[2][yarn] = beta * along[0][yarn] + alpha * along[1][yarn];
        across[2][yarn] = beta * across[0][yarn];
    }
    double8 const damped = damping * batch->fabric.shear.stiffness;
    line->stiff = make_tangent(along[0], across[0], line->response.shear);
    line->damp = make_tangent(along[1], across[1], damped);
    line->all = make_tangent(along[2], across[2], beta * line->response.shear + alpha * damped);
    couple_yarns(line);
}

SIMD_INLINE void fill_eight(const membrane_motion *motion, const motion_sources *sources,
                            size_t begin, size_t count, bool has_guess) {
    element_batch batch;
    linearisation line;
    gather_elements(motion, begin, count, &batch);
    double8 const one = double8_fill(1.0), step = double8_fill(motion->time_step);
    bool const is_mean = has_guess && motion->mean_share < 1.0;
    linearise(motion, sources, &batch, has_guess, motion->forces || is_mean, &line);
    store_blocks(&batch, &line.all, &line.at, count, motion->blocks + 3 * begin);

    /* The elastic tension of the system at x0: that at the guess, moved back along the tangent. */
    yarn_vectors tensions = line.response.tensions;
    if (has_guess)
        tensions =
            yarns_add_scaled(tensions, apply_tangent(&line.stiff, &line.at, &line.way), -step);
    double8 const share = double8_fill(motion->mean_share);
    for (int yarn = 0; yarn < YARN_COUNT && is_mean; yarn++)
        tensions.a[yarn] =
            combine(line.first.tensions.a[yarn], one - share, tensions.a[yarn], share);
    /* Damping at v0, and what w changes of it. */
    yarn_vectors const velocities = differentiate(&batch, &sources->velocities);
    bool const is_same = sources->starts.values == sources->velocities.values;
    yarn_vectors const moving = is_same ? velocities : differentiate(&batch, &sources->starts);
    tensions = yarns_add_scaled(tensions, damp_rates(&line.damp, &line.at, &velocities), one);
    tensions = yarns_add_scaled(tensions, apply_tangent(&line.damp, &line.at, &moving), -one);
    store_forces(&batch, &tensions, count, motion->sources + 3 * begin);
    if (!motion->forces) return;
    yarn_vectors const damped = damp_rates(&line.damp, &line.start, &velocities);
    yarn_vectors const own = yarns_add_scaled(line.first.tensions, damped, one);
    store_forces(&batch, &own, count, motion->forces + 3 * begin);
}

SIMD_INLINE size_t count_lanes(size_t begin, size_t end) {
    return end - begin < DOUBLE_LANES ? end - begin : DOUBLE_LANES;
}

void TULLE_KERNEL(fill_membrane)(const membrane_motion *motion, size_t begin, size_t end) {
    motion_sources const sources = make_sources(motion, NULL);
    for (; begin < end; begin += DOUBLE_LANES) {
        size_t const count = count_lanes(begin, end);
        if (motion->guess)
            fill_eight(motion, &sources, begin, count, true);
        else
            fill_eight(motion, &sources, begin, count, false);
    }
}

/* ---- energies ---- */

SIMD_INLINE double8 measure_excess(const membrane_motion *motion, const motion_sources *sources,
                                   size_t begin, size_t count, bool has_guess) {
    element_batch batch;
    linearisation line;
    gather_elements(motion, begin, count, &batch);
    double8 const step = double8_fill(motion->time_step);
    linearise(motion, sources, &batch, has_guess, false, &line);
    /* The way from where it is linearised to the end of the step. */
    yarn_vectors way = differentiate(&batch, &sources->mean);
    if (has_guess) way = yarns_add_scaled(way, line.way, double8_fill(-1.0));
    for (int yarn = 0; yarn < YARN_COUNT; yarn++) way.a[yarn] = vec3x8_scale(way.a[yarn], step);
    yarn_vectors const pull = apply_tangent(&line.stiff, &line.at, &way);
    double8 reckoned = line.response.energy;
    for (int yarn = 0; yarn < YARN_COUNT; yarn++)
        reckoned += vec3x8_dot(line.response.tensions.a[yarn], way.a[yarn]) +
                    0.5 * vec3x8_dot(pull.a[yarn], way.a[yarn]);
    element_state const last = measure(yarns_add_scaled(line.at.lengths, way, double8_fill(1.0)));
    element_response const truth = respond(&batch, &last, NULL);
    return batch.area * (truth.energy - reckoned);
}

double TULLE_KERNEL(sum_membrane_excess)(const membrane_motion *motion, const double *mean,
                                         size_t begin, size_t end) {
    motion_sources const sources = make_sources(motion, mean);
    double sum = 0.0;
    for (; begin < end; begin += DOUBLE_LANES) {
        size_t const count = count_lanes(begin, end);
        double8 const excess = motion->guess
                                   ? measure_excess(motion, &sources, begin, count, true)
                                   : measure_excess(motion, &sources, begin, count, false);
        double lanes[DOUBLE_LANES];
        double8_store(lanes, excess);
        for (size_t k = 0; k < count; k++) sum += lanes[k];
    }
    return sum;
}

double TULLE_KERNEL(find_yarn_growth)(const membrane_motion *motion, const double *ends,
                                      size_t begin, size_t end) {
    motion_sources const sources = make_sources(motion, ends);
    double most = 0.0;
    for (; begin < end; begin += DOUBLE_LANES) {
        size_t const count = count_lanes(begin, end);
        element_batch batch;
        double growth[DOUBLE_LANES];
        gather_elements(motion, begin, count, &batch);
        element_state const first = measure(differentiate(&batch, &sources.positions));
        element_state const last = measure(differentiate(&batch, &sources.mean));
        for (int yarn = 0; yarn < YARN_COUNT; yarn++) {
            double8 const limit = batch.fabric.yarns[yarn].limit;
            double8 const free = double8_fill(FREE_SHARE) * limit;
            double8 const grown = last.strains[yarn] - double8_max(first.strains[yarn], free);
            double8_store(growth, grown / limit);
            for (size_t k = 0; k < count; k++) most = fmax(most, growth[k]);
        }
    }
    return most;
}

membrane_energy TULLE_KERNEL(sum_membrane_energy)(const membrane_motion *motion, size_t begin,
                                                  size_t end) {
    motion_sources const sources = make_sources(motion, NULL);
    membrane_energy sum = {0.0, 0.0, 0};
    for (; begin < end; begin += DOUBLE_LANES) {
        size_t const count = count_lanes(begin, end);
        element_batch batch;
        double energies[DOUBLE_LANES], strains[YARN_COUNT][DOUBLE_LANES];
        gather_elements(motion, begin, count, &batch);
        element_state const at = measure(differentiate(&batch, &sources.positions));
        element_response const response = respond(&batch, &at, NULL);
        double8_store(energies, batch.area * response.energy);
        for (int yarn = 0; yarn < YARN_COUNT; yarn++)
            double8_store(strains[yarn], at.strains[yarn]);
        for (size_t k = 0; k < count; k++) {
            double const warp = strains[YARN_WARP][k], weft = strains[YARN_WEFT][k];
            sum.energy += energies[k];
            sum.max_stretch = fmax(sum.max_stretch, 1.0 + fmax(warp, weft));
            sum.overstretched += warp > batch.fabric.yarns[YARN_WARP].limit[k] ||
                                 weft > batch.fabric.yarns[YARN_WEFT].limit[k];
        }
    }
    return sum;
}
