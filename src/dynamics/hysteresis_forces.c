/* dynamics/hysteresis_forces.c - what sliders of hysteresis bring to the linear system.
 *
 * A slider with the gradient g = dq/dx pulls with -A t g. Its force bends sharply where it starts
 * to slide, so the system takes a secant. With q0 at the start of the step and q* where the motion
 * is expected to lead, t0 and t* the tensions there,
 *
 *     k = (t* - t0) / (q* - q0),    force of the system at u = -A t* g - h H (u - u*),
 *
 * H = A k g g^T made from k. A slider that sticks has k = K; one that slides on has 0; what sets
 * out for there has what lies between. The force of the system begins with the true one and never
 * jumps. u* is the guess or, in the first solve of a step, v0. So motion that goes on as it is
 * feels the true force, and a turn of the whole cloth feels none; H acts on what changes it.
 *
 * Departures of H from the exact matrix, for it must fit the pattern and leave the system definite:
 *   - of a curvature, n_h n_h'^T of its hinges is replaced by the identity. Then the block of two
 *     vertices is a number, as in the matrix of bending. Along the normal it is exact, where the
 *     normals around are alike; across it cloth is far stiffer anyway;
 *   - of a shear, warp and weft are coupled as in membrane_kernel.c, as far as what the membrane
 *     leaves of that keeps the whole definite;
 *   - derivatives of g are dropped.
 * So g g^T is never more than twice what H has, and explicit parts do not grow. */
#include "dynamics/assembly.h"

#include "base/parallel.h"

#include <math.h>

/* Tensions of a slider, and the secant. */
typedef struct slider_secant {
    double first, next; /* t0, t* */
    double stiffness;   /* k */
} slider_secant;

/* `stretch` is q0 - p, `change` q* - q0. */
static slider_secant make_secant(const slider_law *law, double stretch, double change) {
    double const first = slider_clamp(law, law->stiffness * stretch);
    double const wanted = first + law->stiffness * change;
    double const next = slider_clamp(law, wanted);
    bool const sticks = fabs(wanted) <= law->most;
    return (slider_secant){first, next, sticks ? law->stiffness : (next - first) / change};
}

/* u* */
static const double *get_expected(const assembly *work) {
    return work->state->guess ? work->state->guess : work->state->velocities;
}

/* The part of the force at the end in the mean of the step. */
static double get_share(const assembly *work) {
    return work->system->integrator == TULLE_INTEGRATOR_CRANK_NICOLSON ? work->share : 1.0;
}

/* ---- bending ---- */

/* Sliders of curvature in a triangle, times its area. */
typedef struct bend_secant {
    double first[YARN_COUNT], next[YARN_COUNT]; /* [N m^2] */
    double stiffness[YARN_COUNT];               /* [N m^3] */
    vec3 moved[YARN_COUNT];                     /* [1/(m s)] sum of weights times c at u* */
} bend_secant;

typedef struct bend_sliders {
    assembly *work;
    hinge_kink *first, *at;  /* by hinge: at x0, and at the guess or at x0 again */
    double *kinks, *changes; /* [m] the value at x0, and how it changes by the way of u* */
    vec3 *moved;             /* [m/s] c of u* */
    bend_secant *secants;    /* by triangle */
} bend_sliders;

static bool is_idle(const cloth_sliders *sliders, size_t hinge) {
    return sliders->hinge_begin[hinge] == sliders->hinge_begin[hinge + 1];
}

static void measure_hinges(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    bend_sliders *const bend = context;
    const assembly *const work = bend->work;
    const cloth_model *const model = work->model;
    const double *const expected = get_expected(work);
    for (size_t h = begin; h < end; h++) {
        bend->kinks[h] = bend->changes[h] = 0.0;
        if (is_idle(model->sliders, h)) continue;
        const cloth_hinge *const hinge = &model->hinges[h];
        hinge_kink *const first = &bend->first[h];
        *first = hysteresis_measure_kink(model, h, work->state->positions);
        bend->kinks[h] = first->value;
        bend->moved[h] = bend_sum_corners(hinge, expected);
        if (work->state->guess) {
            bend->at[h] = hysteresis_measure_kink(model, h, work->guessed_positions);
            bend->changes[h] = bend->at[h].value - first->value;
            continue;
        }
        double rate = vec3_dot(first->normal, bend->moved[h]);
        vec3 const origin = vec3_load(expected, hinge->vertices[0]);
        for (int k = 1; k < 4; k++)
            rate += vec3_dot(first->turning[k],
                             vec3_sub(vec3_load(expected, hinge->vertices[k]), origin));
        bend->changes[h] = work->state->time_step * rate;
    }
}

static void fill_secants(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    bend_sliders *const bend = context;
    const cloth_model *const model = bend->work->model;
    const cloth_sliders *const sliders = model->sliders;
    for (size_t t = begin; t < end; t++) {
        bend_secant *const secant = &bend->secants[t];
        *secant = (bend_secant){.first = {0.0}};
        const membrane_element *const element = &model->elements[t];
        const slider_law *const laws = sliders->fabrics[element->fabric].laws;
        double curvatures[YARN_COUNT], changes[YARN_COUNT];
        hysteresis_sum_curvature(sliders, t, bend->kinks, curvatures);
        hysteresis_sum_curvature(sliders, t, bend->changes, changes);
        for (size_t yarn = 0; yarn < YARN_COUNT; yarn++) {
            if (!(laws[yarn].most > 0.0)) continue;
            double const plastic = bend->work->state->plastic[SLIDER_COUNT * t + yarn];
            slider_secant const one =
                make_secant(&laws[yarn], curvatures[yarn] - plastic, changes[yarn]);
            secant->first[yarn] = element->area * one.first;
            secant->next[yarn] = element->area * one.next;
            secant->stiffness[yarn] = element->area * one.stiffness;
            for (size_t k = sliders->part_begin[t]; k < sliders->part_begin[t + 1]; k++)
                secant->moved[yarn] =
                    vec3_add_scaled(secant->moved[yarn], bend->moved[sliders->parts[k].hinge],
                                    sliders->parts[k].weights[yarn]);
        }
    }
}

static void fill_hinge_forces(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    bend_sliders *const bend = context;
    const assembly *const work = bend->work;
    const cloth_sliders *const sliders = work->model->sliders;
    double const share = get_share(work), step = share * work->state->time_step;
    for (size_t h = begin; h < end; h++) {
        double first = 0.0, next = 0.0;
        vec3 held = {0.0, 0.0, 0.0}; /* what H u* is, but for the hinge's weights */
        for (size_t k = sliders->hinge_begin[h]; k < sliders->hinge_begin[h + 1]; k++) {
            const curvature_part *const part = &sliders->parts[sliders->hinge_parts[k]];
            const bend_secant *const secant = &bend->secants[part->triangle];
            for (int yarn = 0; yarn < YARN_COUNT; yarn++) {
                double const weight = part->weights[yarn];
                first += weight * secant->first[yarn];
                next += weight * secant->next[yarn];
                held = vec3_add_scaled(held, secant->moved[yarn], weight * secant->stiffness[yarn]);
            }
        }
        for (size_t k = 0; k < 4; k++) {
            vec3 *const source = &work->sliders.sources[4 * h + k];
            *source = (vec3){0.0, 0.0, 0.0};
            if (is_idle(sliders, h)) continue;
            double const weight = work->model->hinges[h].weights[k];
            const hinge_kink *const from = &bend->first[h], *const to = &bend->at[h];
            vec3 const here =
                vec3_scale(vec3_add_scaled(from->turning[k], from->normal, weight), -first);
            vec3 const there =
                vec3_scale(vec3_add_scaled(to->turning[k], to->normal, weight), -next);
            *source = vec3_add_scaled(vec3_scale(there, share), held, step * weight);
            *source = work->finds_forces ? here : vec3_add_scaled(*source, here, 1.0 - share);
        }
    }
}

/* Rows of H. */
static void fill_rows(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    bend_sliders *const bend = context;
    const assembly *const work = bend->work;
    const cloth_model *const model = work->model;
    const cloth_sliders *const sliders = model->sliders;
    double *const blocks = work->sliders.blocks, *const scalars = work->system->slider_scalars;
    for (size_t v = begin; v < end; v++) {
        for (size_t k = model->block_begin[v]; k < model->block_begin[v + 1]; k++) blocks[k] = 0.0;
        for (size_t k = model->scalar_begin[v]; k < model->scalar_begin[v + 1]; k++)
            scalars[k] = model->bend_scalars[k];
        for (size_t use = sliders->vertex_begin[v]; use < sliders->vertex_begin[v + 1]; use++) {
            size_t const own = sliders->vertex_corners[use];
            size_t const t = sliders->corners[own].triangle;
            size_t const from = sliders->corner_begin[t], to = sliders->corner_begin[t + 1];
            const uint32_t *const places =
                sliders->places + sliders->place_begin[t] + (own - from) * (to - from);
            for (size_t j = from; j < to; j++) {
                double sum = 0.0;
                for (int yarn = 0; yarn < YARN_COUNT; yarn++)
                    sum += bend->secants[t].stiffness[yarn] * sliders->corners[own].weights[yarn] *
                           sliders->corners[j].weights[yarn];
                uint32_t const place = places[j - from];
                if (place & PLACE_IS_SCALAR)
                    scalars[place & ~PLACE_IS_SCALAR] += sum;
                else
                    blocks[place] += sum;
            }
        }
    }
}

static bool fill_bend_sliders(assembly *work) {
    const cloth_model *const model = work->model;
    arena *const scratch = work->scratch;
    size_t const hinges = model->hinge_count, triangles = model->triangle_count;
    arena_mark const mark = arena_get_mark(scratch);
    bend_sliders bend = {.work = work,
                         .first = ARENA_NEW(scratch, hinge_kink, hinges),
                         .kinks = ARENA_NEW(scratch, double, hinges),
                         .changes = ARENA_NEW(scratch, double, hinges),
                         .moved = ARENA_NEW(scratch, vec3, hinges),
                         .secants = ARENA_NEW(scratch, bend_secant, triangles)};
    bend.at = work->state->guess ? ARENA_NEW(scratch, hinge_kink, hinges) : bend.first;
    if (!bend.first || !bend.kinks || !bend.changes || !bend.moved || !bend.secants || !bend.at)
        return false;
    parallel_for(hinges, HINGES_PER_CHUNK, work->threads, measure_hinges, &bend);
    parallel_for(triangles, TRIANGLES_PER_CHUNK, work->threads, fill_secants, &bend);
    parallel_for(hinges, HINGES_PER_CHUNK, work->threads, fill_hinge_forces, &bend);
    parallel_for(model->vertex_count, VERTICES_PER_CHUNK, work->threads, fill_rows, &bend);
    arena_release(scratch, mark);
    return true;
}

void add_sliders(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    const assembly *const work = context;
    static const size_t diagonal[3] = {0, 3, 5}; /* xx, yy, zz */
    const cloth_model *const model = work->model;
    const adjacency *const uses = &model->vertex_hinges;
    double *const values = work->system->matrix.values;
    for (size_t k = model->block_begin[begin]; k < model->block_begin[end]; k++)
        for (int i = 0; i < 3; i++)
            values[BLOCK_NUMBERS * k + diagonal[i]] += work->beta * work->sliders.blocks[k];
    for (size_t v = begin; v < end; v++) {
        vec3 source = {0.0, 0.0, 0.0};
        for (size_t k = uses->begin[v]; k < uses->begin[v + 1]; k++)
            source = vec3_add(source, work->sliders.sources[uses->items[k]]);
        vec3 const sum = vec3_load(work->sums, v);
        vec3_store(work->sums, v,
                   vec3_add_scaled(sum, source, work->finds_forces ? 1.0 : work->gamma));
    }
}

/* ---- shear ---- */

/* How much of `wanted` [N/m] may couple the yarns: the elastic law has coupled them by its own
 * slope, and in all it may be the root of the product of what the yarns have along themselves. */
static double find_coupling(const assembly *work, const membrane_fabric *fabric,
                            const yarn_pair *yarns, double wanted) {
    double const shear = vec3_dot(yarns->along[YARN_WARP], yarns->along[YARN_WEFT]);
    double const lengths = vec3_norm(yarns->along[YARN_WARP]) * vec3_norm(yarns->along[YARN_WEFT]);
    double const damping = work->alpha * fabric->damping / work->beta; /* over stiffness */
    double const most = (1.0 + damping) * sqrt(fabric->yarns[YARN_WARP].stiffness *
                                               fabric->yarns[YARN_WEFT].stiffness);
    const membrane_curve *const curve = &fabric->shear;
    double const bent = fmin(fabs(shear), curve->limit);
    double const slope = curve->stiffness * (1.0 + 3.0 * bent * bent * curve->inv_knee2);
    double const used = slope + damping * curve->stiffness;
    double const left = lengths * (used + wanted) <= most ? wanted : most / lengths - used;
    return fmax(left, 0.0);
}

/* a + s (b c^T + c b^T) / 2 */
static void add_product(double block[6], vec3 b, vec3 c, double s) {
    double const half = 0.5 * s;
    block[0] += s * b.x * c.x;
    block[1] += half * (b.x * c.y + b.y * c.x);
    block[2] += half * (b.x * c.z + b.z * c.x);
    block[3] += s * b.y * c.y;
    block[4] += half * (b.y * c.z + b.z * c.y);
    block[5] += s * b.z * c.z;
}

/* Adds -A (D_iu p_u + D_iv p_v) of all corners. */
static void add_forces(const membrane_element *element, vec3 warp, vec3 weft, vec3 forces[3]) {
    for (int i = 0; i < 2; i++) {
        const double *const d = element->gradients[i];
        vec3 const pull = vec3_add(vec3_scale(warp, d[YARN_WARP]), vec3_scale(weft, d[YARN_WEFT]));
        forces[0] = vec3_add_scaled(forces[0], pull, element->area);
        forces[1 + i] = vec3_add_scaled(forces[1 + i], pull, -element->area);
    }
}

static void fill_shear_slider(const assembly *work, size_t t) {
    const cloth_model *const model = work->model;
    const cloth_start *const state = work->state;
    const membrane_element *const element = &model->elements[t];
    const slider_law *const law = &model->sliders->fabrics[element->fabric].laws[SLIDER_SHEAR];
    if (!(law->most > 0.0)) return;
    yarn_pair const first = hysteresis_measure_yarns(element, state->positions);
    yarn_pair const way = hysteresis_measure_yarns(element, get_expected(work));
    yarn_pair const at =
        state->guess ? hysteresis_measure_yarns(element, work->guessed_positions) : first;
    vec3 const u = at.along[YARN_WARP], v = at.along[YARN_WEFT];
    double const h = state->time_step, before = vec3_dot(first.along[YARN_WARP], first.along[1]);
    double const by_way =
        h * (vec3_dot(v, way.along[YARN_WARP]) + vec3_dot(u, way.along[YARN_WEFT]));
    double const change = state->guess ? vec3_dot(u, v) - before : by_way;
    slider_secant const secant =
        make_secant(law, before - state->plastic[SLIDER_COUNT * t + SLIDER_SHEAR], change);
    double const k = secant.stiffness;
    double const cross = find_coupling(work, &model->fabrics[element->fabric], &at, k);

    /* t0 grad s at x0 */
    vec3 const start[YARN_COUNT] = {vec3_scale(first.along[YARN_WEFT], secant.first),
                                    vec3_scale(first.along[YARN_WARP], secant.first)};
    if (work->finds_forces) {
        add_forces(element, start[YARN_WARP], start[YARN_WEFT], work->membrane_sources + 3 * t);
        return;
    }

    symmetric3 *const blocks = work->membrane_blocks + 3 * t;
    for (size_t i = 0; i < 3; i++) {
        double d[2][YARN_COUNT]; /* of both corners of edge i */
        for (size_t end = 0; end < 2; end++)
            for (size_t yarn = 0; yarn < YARN_COUNT; yarn++) {
                size_t const corner = (i + end) % 3;
                d[end][yarn] = corner == 0
                                   ? -(element->gradients[0][yarn] + element->gradients[1][yarn])
                                   : element->gradients[corner - 1][yarn];
            }
        double const scale = -work->beta * element->area;
        add_product(blocks[i].m, v, v, scale * k * d[0][YARN_WARP] * d[1][YARN_WARP]);
        add_product(blocks[i].m, u, u, scale * k * d[0][YARN_WEFT] * d[1][YARN_WEFT]);
        double const mixed = d[0][YARN_WARP] * d[1][YARN_WEFT] + d[0][YARN_WEFT] * d[1][YARN_WARP];
        add_product(blocks[i].m, u, v, 2.0 * scale * cross * mixed);
    }

    /* t* grad s - h H u* */
    double const uv = vec3_dot(u, way.along[YARN_WEFT]), vu = vec3_dot(v, way.along[YARN_WARP]);
    double const uu = vec3_dot(u, way.along[YARN_WARP]), vv = vec3_dot(v, way.along[YARN_WEFT]);
    double const share = get_share(work);
    vec3 warp = vec3_scale(v, secant.next - h * (k * vu + cross * uv));
    vec3 weft = vec3_scale(u, secant.next - h * (k * uv + cross * vu));
    warp = vec3_add_scaled(warp, u, -h * cross * vv);
    weft = vec3_add_scaled(weft, v, -h * cross * uu);
    warp = vec3_add_scaled(vec3_scale(warp, share), start[YARN_WARP], 1.0 - share);
    weft = vec3_add_scaled(vec3_scale(weft, share), start[YARN_WEFT], 1.0 - share);
    add_forces(element, warp, weft, work->membrane_sources + 3 * t);
}

static void fill_shear_sliders(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    for (size_t t = begin; t < end; t++) fill_shear_slider(context, t);
}

/* ---- both ---- */

bool provide_slider_slots(assembly *work) {
    const cloth_model *const model = work->model;
    block_matrix *const matrix = &work->system->matrix;
    matrix->scalar_parts[1] = model->bend_scalars;
    if (!model->sliders || !model->sliders->has_bend || !work->state->plastic) return true;
    matrix->scalar_parts[1] = work->system->slider_scalars;
    work->sliders =
        (slider_slots){.blocks = ARENA_NEW(work->scratch, double, model->block_count),
                       .sources = ARENA_NEW(work->scratch, vec3, 4 * model->hinge_count)};
    return work->sliders.blocks && work->sliders.sources;
}

bool fill_sliders(assembly *work) {
    const cloth_model *const model = work->model;
    if (model->sliders && model->sliders->has_shear && work->state->plastic)
        parallel_for(model->triangle_count, ELEMENTS_PER_CHUNK, work->threads, fill_shear_sliders,
                     work);
    return !work->sliders.blocks || fill_bend_sliders(work);
}
