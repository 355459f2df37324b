/* dynamics/kernels/membrane_kernel.c - forces and derivatives of some membrane elements at a time.
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

/* Numbers of elements side by side. Lanes beyond the last element repeat it. */
typedef struct lanes_of_curve {
    wide stiffness, inv_knee2, limit, guess_room;
} lanes_of_curve;

/* In the order of membrane_fabric, which has no other numbers. */
typedef struct lanes_of_fabric {
    lanes_of_curve yarns[YARN_COUNT], shear;
    wide coupling, damping;
} lanes_of_fabric;

typedef struct element_batch {
    const membrane_element *elements[WIDE_LANES];
    wide gradients[2][YARN_COUNT], area;
    lanes_of_fabric fabric;
} element_batch;

/* Where the numbers of vertices come from. */
typedef struct motion_sources {
    lane_source positions, velocities, starts, guess, mean;
} motion_sources;

static motion_sources make_sources(const membrane_motion *motion, const double *mean) {
    size_t const count = motion->vertex_count;
    motion_sources sources = {.positions = lane_source_make(motion->positions, count)};
    if (motion->guess) sources.guess = lane_source_make(motion->guess, count);
    if (mean) sources.mean = lane_source_make(mean, count);
    return sources;
}

enum { FABRIC_NUMBERS = sizeof(membrane_fabric) / sizeof(double) };

SIMD_INLINE void gather_fabrics(const membrane_motion *motion, element_batch *batch) {
    uint32_t const first = batch->elements[0]->fabric;
    bool is_one = true;
    for (size_t k = 1; k < WIDE_LANES; k++) is_one &= batch->elements[k]->fabric == first;
    wide lanes[FABRIC_NUMBERS];
    double numbers[FABRIC_NUMBERS];
    memcpy(numbers, &motion->fabrics[first], sizeof numbers);
    for (size_t i = 0; i < FABRIC_NUMBERS; i++) lanes[i] = wide_fill(numbers[i]);
    for (size_t k = 1; !is_one && k < WIDE_LANES; k++) {
        memcpy(numbers, &motion->fabrics[batch->elements[k]->fabric], sizeof numbers);
        for (size_t i = 0; i < FABRIC_NUMBERS; i++) lanes[i][k] = numbers[i];
    }
    memcpy(&batch->fabric, lanes, sizeof lanes);
}

SIMD_INLINE void gather_elements(const membrane_motion *motion, size_t begin, size_t count,
                                 element_batch *batch) {
    lanes4 gradients[WIDE_LANES];
    double areas[WIDE_LANES];
    for (size_t k = 0; k < WIDE_LANES; k++) {
        const membrane_element *const element =
            &motion->elements[begin + (k < count ? k : count - 1)];
        batch->elements[k] = element;
        gradients[k] = lanes4_load(element->gradients[0]);
        areas[k] = element->area;
    }
    wide_turned const turned = lanes4_turn(gradients);
    for (int i = 0; i < 2; i++)
        for (int yarn = 0; yarn < YARN_COUNT; yarn++)
            batch->gradients[i][yarn] = turned.at[YARN_COUNT * i + yarn];
    batch->area = wide_load(areas);
    gather_fabrics(motion, batch);
}

/* ---- vectors along both yarns ---- */

typedef struct yarn_vectors {
    wide3 a[YARN_COUNT];
} yarn_vectors;

SIMD_INLINE wide3 combine(wide3 a, wide s, wide3 b, wide t) {
    return (wide3){a.x * s + b.x * t, a.y * s + b.y * t, a.z * s + b.z * t};
}

/* sum_i D_ia y_i for values y of the vertices. */
SIMD_INLINE yarn_vectors differentiate(const element_batch *batch, const lane_source *values) {
    lanes4 edges[2][WIDE_LANES];
    for (size_t k = 0; k < WIDE_LANES; k++) {
        const uint32_t *const corners = batch->elements[k]->corners;
        lanes4 const origin = lanes4_get(values, corners[0]);
        for (int i = 0; i < 2; i++) edges[i][k] = lanes4_get(values, corners[i + 1]) - origin;
    }
    wide3 const left = lanes4_turn3(edges[0]), right = lanes4_turn3(edges[1]);
    yarn_vectors result;
    for (int yarn = 0; yarn < YARN_COUNT; yarn++)
        result.a[yarn] = combine(left, batch->gradients[0][yarn], right, batch->gradients[1][yarn]);
    return result;
}

SIMD_INLINE yarn_vectors yarns_add_scaled(yarn_vectors a, yarn_vectors b, wide s) {
    for (int yarn = 0; yarn < YARN_COUNT; yarn++)
        a.a[yarn] = wide3_add_scaled(a.a[yarn], b.a[yarn], s);
    return a;
}

/* ---- laws ---- */

/* A curve: its tension at `strain`, its slope, its energy, and the tension at `kept`, which is the
 * strain but for guesses too far off. */
typedef struct curve_point {
    wide tension, slope, energy, kept, kept_tension;
} curve_point;

SIMD_INLINE curve_point follow_curve(const lanes_of_curve *lanes, wide strain, wide most) {
    wide const zero = wide_fill(0.0), k = lanes->stiffness;
    wide const kept = wide_min(strain, most);
    wide const bent = wide_min(kept, lanes->limit);
    wide const taut = wide_max(bent, zero);
    wide const more = lanes->inv_knee2 * taut * taut;
    curve_point point = {.slope = k * (1.0 + 3.0 * more), .kept = kept};
    wide const tension = k * bent * (1.0 + more), beyond = strain - bent;
    point.kept_tension = tension + point.slope * (kept - bent);
    point.tension = tension + point.slope * beyond;
    point.energy = 0.5 * k * bent * bent * (1.0 + 0.5 * more) +
                   (tension + 0.5 * point.slope * beyond) * beyond;
    return point;
}

typedef struct element_state {
    yarn_vectors lengths, directions; /* F, n */
    wide strains[YARN_COUNT], shear;  /* e, s */
} element_state;

SIMD_INLINE element_state measure(yarn_vectors lengths) {
    element_state state = {.lengths = lengths};
    for (int yarn = 0; yarn < YARN_COUNT; yarn++) {
        wide3 const f = lengths.a[yarn];
        wide const length = wide_sqrt(wide3_dot(f, f));
        wide_bool const is_nothing = wide_not(wide_greater(length, wide_fill(0.0)));
        wide const inverse = wide_select(is_nothing, wide_fill(0.0), wide_fill(1.0) / length);
        state.directions.a[yarn] = wide3_scale(f, inverse);
        state.strains[yarn] = length - 1.0;
    }
    state.shear = wide3_dot(lengths.a[YARN_WARP], lengths.a[YARN_WEFT]);
    return state;
}

/* Tensions, and the derivatives as above. */
typedef struct element_response {
    yarn_vectors tensions;                      /* P [N/m] */
    wide along[YARN_COUNT], across[YARN_COUNT]; /* [N/m] */
    wide shear;                                 /* [N/m] psi_s'' */
    wide energy;                                /* [N/m] by rest area */
} element_response;

/* `start` is where a guess begins; null: no guess. */
SIMD_INLINE element_response respond(const element_batch *batch, const element_state *state,
                                     const element_state *start) {
    wide const coupling = batch->fabric.coupling, zero = wide_fill(0.0);
    wide const endless = wide_fill((double)INFINITY);
    curve_point yarns[YARN_COUNT];
    for (int yarn = 0; yarn < YARN_COUNT; yarn++) {
        wide most = endless;
        if (start)
            most = wide_max(start->strains[yarn], zero) + batch->fabric.yarns[yarn].guess_room;
        yarns[yarn] = follow_curve(&batch->fabric.yarns[yarn], state->strains[yarn], most);
    }
    wide most = endless;
    if (start) most = wide_abs(start->shear) + batch->fabric.shear.guess_room;
    curve_point const shear = follow_curve(&batch->fabric.shear, wide_abs(state->shear), most);
    wide const turn = wide_select(wide_greater(zero, state->shear), -shear.tension, shear.tension);

    element_response response = {.shear = shear.slope};
    response.energy = yarns[YARN_WARP].energy + yarns[YARN_WEFT].energy + shear.energy +
                      coupling * state->strains[YARN_WARP] * state->strains[YARN_WEFT];
    for (int yarn = 0; yarn < YARN_COUNT; yarn++) {
        int const other = 1 - yarn;
        wide const pull = yarns[yarn].tension + coupling * state->strains[other];
        response.tensions.a[yarn] =
            combine(state->directions.a[yarn], pull, state->lengths.a[other], turn);
        response.along[yarn] = yarns[yarn].slope;
        wide const kept = yarns[yarn].kept_tension + coupling * yarns[other].kept;
        wide const length = wide_max(1.0 + yarns[yarn].kept, wide_fill(COLLAPSED_LENGTH));
        response.across[yarn] = wide_max(kept, zero) / length;
    }
    return response;
}

/* ---- derivatives ---- */

/* dP/dF as it stands in the system: along n and across it for each yarn, shear within a yarn and
 * between both. */
typedef struct tangent {
    wide along[YARN_COUNT], across[YARN_COUNT], shear, cross;
} tangent;

/* The tangent times d. */
SIMD_INLINE yarn_vectors apply_tangent(const tangent *by, const element_state *at,
                                       const yarn_vectors *d) {
    yarn_vectors result;
    for (int yarn = 0; yarn < YARN_COUNT; yarn++) {
        int const other = 1 - yarn;
        wide3 const n = at->directions.a[yarn], own = at->lengths.a[yarn];
        wide3 const far = at->lengths.a[other], moved = d->a[yarn], far_moved = d->a[other];
        wide const along = (by->along[yarn] - by->across[yarn]) * wide3_dot(n, moved);
        wide const turned =
            by->shear * wide3_dot(far, moved) + by->cross * wide3_dot(own, far_moved);
        wide3 sum = combine(moved, by->across[yarn], n, along);
        sum = wide3_add_scaled(sum, far, turned);
        result.a[yarn] = wide3_add_scaled(sum, own, by->cross * wide3_dot(far, far_moved));
    }
    return result;
}

/* Tensions of damping: by the true derivative, where s changes by F_u . v_v + F_v . v_u. */
SIMD_INLINE yarn_vectors damp_rates(const tangent *by, const element_state *at,
                                    const yarn_vectors *rates) {
    wide const turning = by->shear * (wide3_dot(at->lengths.a[YARN_WARP], rates->a[YARN_WEFT]) +
                                      wide3_dot(at->lengths.a[YARN_WEFT], rates->a[YARN_WARP]));
    yarn_vectors result;
    for (int yarn = 0; yarn < YARN_COUNT; yarn++) {
        wide3 const n = at->directions.a[yarn];
        result.a[yarn] = combine(n, by->along[yarn] * wide3_dot(n, rates->a[yarn]),
                                 at->lengths.a[1 - yarn], turning);
    }
    return result;
}

typedef struct wide_symmetric {
    wide m[6];
} wide_symmetric;

SIMD_INLINE wide_symmetric wide_symmetric_square(wide3 n, wide s) {
    wide3 const t = wide3_scale(n, s);
    return (wide_symmetric){{t.x * n.x, t.x * n.y, t.x * n.z, t.y * n.y, t.y * n.z, t.z * n.z}};
}

/* across I + (along - across) n n^T + shear F F^T, F of the other yarn */
SIMD_INLINE wide_symmetric make_own_block(const tangent *by, const element_state *at, int yarn) {
    wide_symmetric const n =
        wide_symmetric_square(at->directions.a[yarn], by->along[yarn] - by->across[yarn]);
    wide_symmetric const f = wide_symmetric_square(at->lengths.a[1 - yarn], by->shear);
    wide_symmetric sum;
    for (int i = 0; i < 6; i++) sum.m[i] = n.m[i] + f.m[i];
    sum.m[0] += by->across[yarn];
    sum.m[3] += by->across[yarn];
    sum.m[5] += by->across[yarn];
    return sum;
}

/* cross (F_u F_v^T + F_v F_u^T) */
SIMD_INLINE wide_symmetric make_cross_block(const tangent *by, const element_state *at) {
    wide3 const u = wide3_scale(at->lengths.a[YARN_WARP], by->cross);
    wide3 const v = at->lengths.a[YARN_WEFT];
    return (wide_symmetric){{2.0 * u.x * v.x, u.x * v.y + u.y * v.x, u.x * v.z + u.z * v.x,
                             2.0 * u.y * v.y, u.y * v.z + u.z * v.y, 2.0 * u.z * v.z}};
}

/* ---- what is stored ---- */

/* -A sum_a D_ia P_a on the corners */
SIMD_INLINE void store_forces(const element_batch *batch, const yarn_vectors *tensions, vec3 *to) {
    wide3 forces[3];
    for (size_t i = 0; i < 2; i++) {
        wide const u = batch->area * batch->gradients[i][YARN_WARP];
        wide const v = batch->area * batch->gradients[i][YARN_WEFT];
        forces[1 + i] = wide3_neg(combine(tensions->a[YARN_WARP], u, tensions->a[YARN_WEFT], v));
    }
    forces[0] = wide3_neg(wide3_add(forces[1], forces[2]));
    corner_rows const rows = corner_rows_make(forces);
    corner_rows_store(&rows, to);
}

/* factor g g^T of these elements. */
SIMD_INLINE wide_symmetric gather_drags(const vec3 *drags, double factor) {
    lanes4 rows[WIDE_LANES];
    for (size_t k = 0; k < WIDE_LANES; k++) rows[k] = lanes4_load(&drags[k].x);
    return wide_symmetric_square(lanes4_turn3(rows), wide_fill(factor));
}

/* `drags` may be null. */
SIMD_INLINE void store_blocks(const element_batch *batch, const tangent *by,
                              const element_state *at, const wide_symmetric *drags,
                              symmetric3 *to) {
    wide_symmetric const warp = make_own_block(by, at, YARN_WARP);
    wide_symmetric const weft = make_own_block(by, at, YARN_WEFT);
    wide_symmetric const cross = make_cross_block(by, at);
    wide const area = batch->area;
    wide d[3][YARN_COUNT];
    for (int yarn = 0; yarn < YARN_COUNT; yarn++) {
        d[1][yarn] = batch->gradients[0][yarn];
        d[2][yarn] = batch->gradients[1][yarn];
        d[0][yarn] = -(d[1][yarn] + d[2][yarn]);
    }
    for (size_t e = 0; e < 3; e++) {
        const wide *const a = d[e], *const b = d[(e + 1) % 3];
        wide const u = -area * (a[YARN_WARP] * b[YARN_WARP]);
        wide const v = -area * (a[YARN_WEFT] * b[YARN_WEFT]);
        wide const uv = -area * (a[YARN_WARP] * b[YARN_WEFT] + a[YARN_WEFT] * b[YARN_WARP]);
        wide m[6];
        for (size_t i = 0; i < 6; i++) {
            m[i] = u * warp.m[i] + v * weft.m[i] + uv * cross.m[i];
            if (drags) m[i] -= drags->m[i];
        }
        lanes4 first[WIDE_LANES], last[WIDE_LANES];
        lanes4_turn_back(m[0], m[1], m[2], m[3], first);
        lanes4_turn_back(m[4], m[5], m[4], m[5], last);
        for (size_t k = 0; k < WIDE_LANES; k++) {
            memcpy(to[3 * k + e].m, &first[k], sizeof first[k]);
            memcpy(to[3 * k + e].m + 4, &last[k], 2 * sizeof(double));
        }
    }
}

/* ---- the system ---- */

/* Where elements are linearised, and how. */
typedef struct linearisation {
    element_state start, at; /* at x0; at the guess */
    yarn_vectors way;        /* from one to the other by the guess [1/s] */
    element_response first, response;
    tangent stiff, damp, all; /* of strain, of its rate, and alpha D + beta K */
} linearisation;

SIMD_INLINE tangent make_tangent(const wide along[YARN_COUNT], const wide across[YARN_COUNT],
                                 wide shear) {
    return (tangent){.along = {along[YARN_WARP], along[YARN_WEFT]},
                     .across = {across[YARN_WARP], across[YARN_WEFT]},
                     .shear = shear};
}

/* Gives the tangents what stands between the yarns: as much as keeps the whole definite. */
SIMD_INLINE void couple_yarns(linearisation *line) {
    wide const lengths = (line->at.strains[YARN_WARP] + 1.0) * (line->at.strains[YARN_WEFT] + 1.0);
    wide const wanted = line->all.shear * lengths;
    wide const most = wide_sqrt(line->all.along[YARN_WARP] * line->all.along[YARN_WEFT]);
    wide const part = wide_select(wide_greater(wanted, most), most / wanted, wide_fill(1.0));
    line->stiff.cross = part * line->stiff.shear;
    line->damp.cross = part * line->damp.shear;
    line->all.cross = part * line->all.shear;
}

/* The part of the way on which no yarn gets longer than GUESS_LENGTH times what it is at the start,
 * or at rest where that is more. */
SIMD_INLINE yarn_vectors limit_way(const yarn_vectors *start, yarn_vectors way, double time_step) {
    wide const one = wide_fill(1.0), h = wide_fill(time_step);
    wide part = one;
    for (int yarn = 0; yarn < YARN_COUNT; yarn++) {
        wide3 const f = start->a[yarn], d = wide3_scale(way.a[yarn], h);
        wide const ff = wide3_dot(f, f), fd = wide3_dot(f, d), dd = wide3_dot(d, d);
        wide const room = wide_fill(GUESS_LENGTH * GUESS_LENGTH) * wide_max(ff, one) - ff;
        /* ff + 2 p fd + p p dd = ff + room */
        wide const most = (wide_sqrt(fd * fd + dd * room) - fd) / dd;
        wide_bool const is_long = wide_greater(dd + 2.0 * fd, room);
        part = wide_select(is_long, wide_min(part, most), part);
    }
    for (int yarn = 0; yarn < YARN_COUNT; yarn++) way.a[yarn] = wide3_scale(way.a[yarn], part);
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
        line->at =
            measure(yarns_add_scaled(line->start.lengths, line->way, wide_fill(motion->time_step)));
        line->response = respond(batch, &line->at, &line->start);
    } else {
        line->at = line->start;
        line->response = line->first;
    }
    wide const alpha = wide_fill(motion->alpha), beta = wide_fill(motion->beta);
    wide const damping = batch->fabric.damping;
    wide along[3][YARN_COUNT], across[3][YARN_COUNT];
    for (int yarn = 0; yarn < YARN_COUNT; yarn++) {
        wide const k = batch->fabric.yarns[yarn].stiffness;
        wide3 const n = line->at.directions.a[yarn];
        wide_bool const has_length = wide_greater(wide3_dot(n, n), wide_fill(0.0));
        along[0][yarn] = line->response.along[yarn];
        across[0][yarn] = wide_select(has_length, line->response.across[yarn], k);
        along[1][yarn] = damping * k;
        across[1][yarn] = wide_fill(0.0);
        along[2][yarn] = beta * along[0][yarn] + alpha * along[1][yarn];
        across[2][yarn] = beta * across[0][yarn];
    }
    wide const damped = damping * batch->fabric.shear.stiffness;
    line->stiff = make_tangent(along[0], across[0], line->response.shear);
    line->damp = make_tangent(along[1], across[1], damped);
    line->all = make_tangent(along[2], across[2], beta * line->response.shear + alpha * damped);
    couple_yarns(line);
}

/* damp_rates less apply_tangent of the same rates: the departures of the matrix. */
SIMD_INLINE yarn_vectors find_departure(const tangent *by, const element_state *at,
                                        const yarn_vectors *rates) {
    yarn_vectors result;
    for (int yarn = 0; yarn < YARN_COUNT; yarn++) {
        int const other = 1 - yarn;
        wide3 const own = at->lengths.a[yarn], far = at->lengths.a[other];
        wide3 const moved = rates->a[other];
        result.a[yarn] = combine(far, (by->shear - by->cross) * wide3_dot(own, moved), own,
                                 -by->cross * wide3_dot(far, moved));
    }
    return result;
}

SIMD_INLINE void fill_batch(const membrane_motion *motion, const motion_sources *sources,
                            size_t begin, bool has_guess) {
    element_batch batch;
    linearisation line;
    size_t const rest = motion->element_count - begin;
    gather_elements(motion, begin, rest < WIDE_LANES ? rest : WIDE_LANES, &batch);
    wide const one = wide_fill(1.0), step = wide_fill(motion->time_step);
    bool const is_mean = has_guess && motion->mean_share < 1.0;
    linearise(motion, sources, &batch, has_guess, is_mean, &line);
    symmetric3 *const blocks = motion->blocks ? motion->blocks + 3 * begin : NULL;
    if (blocks && motion->drags) {
        wide_symmetric const drags = gather_drags(motion->drags + begin, motion->alpha);
        store_blocks(&batch, &line.all, &line.at, &drags, blocks);
    } else if (blocks) {
        store_blocks(&batch, &line.all, &line.at, NULL, blocks);
    }

    /* The elastic tension of the system at x0: that at the guess, moved back along the tangent. */
    yarn_vectors tensions = line.response.tensions;
    if (has_guess)
        tensions =
            yarns_add_scaled(tensions, apply_tangent(&line.stiff, &line.at, &line.way), -step);
    wide const share = wide_fill(motion->mean_share);
    for (int yarn = 0; yarn < YARN_COUNT && is_mean; yarn++)
        tensions.a[yarn] =
            combine(line.first.tensions.a[yarn], one - share, tensions.a[yarn], share);
    /* Damping at v0, and what w changes of it. */
    yarn_vectors const velocities = differentiate(&batch, &sources->velocities);
    if (sources->starts.values == sources->velocities.values) {
        yarn_vectors const departure = find_departure(&line.damp, &line.at, &velocities);
        tensions = yarns_add_scaled(tensions, departure, one);
    } else {
        yarn_vectors const moving = differentiate(&batch, &sources->starts);
        tensions = yarns_add_scaled(tensions, damp_rates(&line.damp, &line.at, &velocities), one);
        tensions = yarns_add_scaled(tensions, apply_tangent(&line.damp, &line.at, &moving), -one);
    }
    store_forces(&batch, &tensions, motion->sources + 3 * begin);
}

SIMD_INLINE size_t count_lanes(size_t begin, size_t end) {
    return end - begin < WIDE_LANES ? end - begin : WIDE_LANES;
}

void TULLE_KERNEL(fill_membrane)(void *context, size_t begin, size_t end, size_t chunk,
                                 int worker) {
    (void)chunk, (void)worker;
    const membrane_motion *const motion = context;
    motion_sources const sources = {.positions = lane_source_pad(motion->positions),
                                    .velocities = lane_source_pad(motion->velocities),
                                    .starts = lane_source_pad(motion->start_velocities),
                                    .guess = lane_source_pad(motion->guess)};
    for (; begin < end; begin += WIDE_LANES) {
        if (motion->guess)
            fill_batch(motion, &sources, begin, true);
        else
            fill_batch(motion, &sources, begin, false);
    }
}

/* ---- energies ---- */

/* way_energies of elements. */
typedef struct way_lanes {
    wide excess, curvature;
} way_lanes;

SIMD_INLINE way_lanes measure_excess(const membrane_motion *motion, const motion_sources *sources,
                                     size_t begin, size_t count, bool has_guess) {
    element_batch batch;
    linearisation line;
    gather_elements(motion, begin, count, &batch);
    wide const step = wide_fill(motion->time_step);
    linearise(motion, sources, &batch, has_guess, false, &line);
    /* The way from where it is linearised to the end of the step. */
    yarn_vectors way = differentiate(&batch, &sources->mean);
    if (has_guess) way = yarns_add_scaled(way, line.way, wide_fill(-1.0));
    for (int yarn = 0; yarn < YARN_COUNT; yarn++) way.a[yarn] = wide3_scale(way.a[yarn], step);
    yarn_vectors const pull = apply_tangent(&line.stiff, &line.at, &way);
    wide reckoned = line.response.energy, curvature = wide_fill(0.0);
    for (int yarn = 0; yarn < YARN_COUNT; yarn++) {
        reckoned += wide3_dot(line.response.tensions.a[yarn], way.a[yarn]);
        curvature += wide3_dot(pull.a[yarn], way.a[yarn]);
    }
    reckoned += 0.5 * curvature;
    element_state const last = measure(yarns_add_scaled(line.at.lengths, way, wide_fill(1.0)));
    element_response const truth = respond(&batch, &last, NULL);
    return (way_lanes){batch.area * (truth.energy - reckoned), batch.area * curvature};
}

way_energies TULLE_KERNEL(sum_membrane_excess)(const membrane_motion *motion, const double *mean,
                                               size_t begin, size_t end) {
    motion_sources const sources = make_sources(motion, mean);
    way_energies sum = {0.0, 0.0};
    for (; begin < end; begin += WIDE_LANES) {
        size_t const count = count_lanes(begin, end);
        way_lanes const way = motion->guess ? measure_excess(motion, &sources, begin, count, true)
                                            : measure_excess(motion, &sources, begin, count, false);
        double excess[WIDE_LANES], curvature[WIDE_LANES];
        wide_store(excess, way.excess);
        wide_store(curvature, way.curvature);
        for (size_t k = 0; k < count; k++) {
            sum.excess += excess[k];
            sum.curvature += curvature[k];
        }
    }
    return sum;
}

double TULLE_KERNEL(find_yarn_growth)(const membrane_motion *motion, const double *ends,
                                      size_t begin, size_t end) {
    motion_sources const sources = make_sources(motion, ends);
    double most = 0.0;
    for (; begin < end; begin += WIDE_LANES) {
        size_t const count = count_lanes(begin, end);
        element_batch batch;
        double growth[WIDE_LANES];
        gather_elements(motion, begin, count, &batch);
        element_state const first = measure(differentiate(&batch, &sources.positions));
        element_state const last = measure(differentiate(&batch, &sources.mean));
        for (int yarn = 0; yarn < YARN_COUNT; yarn++) {
            wide const limit = batch.fabric.yarns[yarn].limit;
            wide const free = wide_fill(FREE_SHARE) * limit;
            wide const grown = last.strains[yarn] - wide_max(first.strains[yarn], free);
            wide_store(growth, grown / limit);
            for (size_t k = 0; k < count; k++) most = fmax(most, growth[k]);
        }
    }
    return most;
}

membrane_energy TULLE_KERNEL(sum_membrane_energy)(const membrane_motion *motion, size_t begin,
                                                  size_t end) {
    motion_sources const sources = make_sources(motion, NULL);
    membrane_energy sum = {0.0, 0.0, 0};
    for (; begin < end; begin += WIDE_LANES) {
        size_t const count = count_lanes(begin, end);
        element_batch batch;
        double energies[WIDE_LANES], strains[YARN_COUNT][WIDE_LANES];
        gather_elements(motion, begin, count, &batch);
        element_state const at = measure(differentiate(&batch, &sources.positions));
        element_response const response = respond(&batch, &at, NULL);
        wide_store(energies, batch.area * response.energy);
        for (int yarn = 0; yarn < YARN_COUNT; yarn++) wide_store(strains[yarn], at.strains[yarn]);
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
