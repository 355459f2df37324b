/* dynamics/bending.c - bending forces from the hinges' vectors c (see bending_matrix.c).
 *
 * Elastic: energy 1/2 sum_ij C_ij d_i . d_j with d = c - r n, r the rest value of c along the hinge
 * normal n. For a flat rest shape (r = 0) the force is linear in the positions. Otherwise the term
 * r n follows the hinge, as in Garg, Grinspun, Wardetzky, Zorin, Cubic shells, 2007; the force is
 * the exact gradient of the energy, so it keeps both momenta.
 * Woven cloth with a flat rest shape has its force from the matrix instead: kernels/row_kernel.c.
 * Damping: kernels/bending_damping.c. */
#include "dynamics/bending_kernel.h"

#include "base/parallel.h"

/* Sides that are folded onto each other have no hinge normal. Where the sum of their unit
 * normals is shorter than this (a fold angle above 174 degrees), the rest curvature has no
 * effect. */
static const double FOLDED_LIMIT = 0.1;

/* The hinge's normal is along a x m, with a the edge and m the difference of the corners' offsets
 * over twice the rest areas: the sum of the sides' unit normals where they keep their areas. */
typedef struct hinge_frame {
    vec3 edge, across; /* a [m], m [1/m] */
    double length;     /* |a x m| */
    vec3 normal;       /* zero where the sides are folded onto each other */
} hinge_frame;

static hinge_frame compute_frame(const cloth_hinge *hinge, const cloth_hinge_rest *rest,
                                 const double *positions) {
    vec3 const x0 = vec3_load(positions, hinge->vertices[0]);
    vec3 const left = vec3_sub(vec3_load(positions, hinge->vertices[2]), x0);
    vec3 const right = vec3_sub(vec3_load(positions, hinge->vertices[3]), x0);
    hinge_frame frame = {.edge = vec3_sub(vec3_load(positions, hinge->vertices[1]), x0)};
    frame.across = vec3_sub(vec3_scale(left, rest->inv_double_areas[0]),
                            vec3_scale(right, rest->inv_double_areas[1]));
    vec3 const sum = vec3_cross(frame.edge, frame.across);
    frame.length = vec3_norm(sum);
    bool const is_folded = !(frame.length > FOLDED_LIMIT);
    frame.normal = is_folded ? (vec3){0.0, 0.0, 0.0} : vec3_scale(sum, 1.0 / frame.length);
    return frame;
}

void bend_compute_deviations(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    const deviation_task *const task = context;
    for (size_t h = begin; h < end; h++) {
        const cloth_hinge *const hinge = &task->model->hinges[h];
        const cloth_hinge_rest *const rests = task->model->hinge_rests;
        task->deviations[h] = bend_sum_corners(hinge, task->positions);
        if (!rests || rests[h].curvature == 0.0) continue;
        vec3 const normal = compute_frame(hinge, &rests[h], task->positions).normal;
        task->deviations[h] = vec3_add_scaled(task->deviations[h], normal, -rests[h].curvature);
    }
}

/* Forces [N] on the corners of hinges, in a model with curved rest shapes: from bending, and from
 * what damping adds in both of their triangles. */
static void fill_forces(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    assembly *const work = context;
    const cloth_model *const model = work->model;
    for (size_t h = begin; h < end; h++) {
        const cloth_hinge *const hinge = &model->hinges[h];
        vec3 const elastic = bend_compute_moment(model, h, work->hinge_deviations);
        vec3 damping = {0.0, 0.0, 0.0};
        for (int side = 0; side < 2 && work->bend_dampings; side++) {
            uint32_t const place = hinge->sides[side];
            const bend_damping_response *const in = &work->bend_dampings[place / 3];
            damping = vec3_add(damping, vec3_scale(in->normal, in->moments[place % 3]));
        }
        vec3 const all = vec3_add(elastic, damping);
        vec3 *const forces = work->terms.hinge_forces + 4 * h;
        for (size_t k = 0; k < 4; k++) forces[k] = vec3_scale(all, -hinge->weights[k]);
        const cloth_hinge_rest *const rest = &model->hinge_rests[h];
        if (rest->curvature == 0.0) continue;
        hinge_frame const frame = compute_frame(hinge, rest, work->state->positions);
        vec3 const n = frame.normal, y = elastic;
        if (vec3_norm2(n) == 0.0) continue;
        /* r (dn/dx_k)^T y: the gradient of r n . y at fixed y, the elastic moment. */
        vec3 const tangential =
            vec3_scale(vec3_add_scaled(y, n, -vec3_dot(n, y)), rest->curvature / frame.length);
        vec3 const by_edge = vec3_cross(frame.across, tangential);
        vec3 const by_across = vec3_cross(tangential, frame.edge);
        vec3 const by_left = vec3_scale(by_across, rest->inv_double_areas[0]);
        vec3 const by_right = vec3_scale(by_across, -rest->inv_double_areas[1]);
        forces[1] = vec3_add(forces[1], by_edge);
        forces[2] = vec3_add(forces[2], by_left);
        forces[3] = vec3_add(forces[3], by_right);
        forces[0] = vec3_sub(forces[0], vec3_add(by_edge, vec3_add(by_left, by_right)));
    }
}

bool provide_bending_terms(const cloth_model *model, force_terms *terms, arena *scratch) {
    if (model->has_bend_damping &&
        !provide_slots(&terms->bend_forces, 2 * model->triangle_count + 1, scratch))
        return false;
    if (model->bends_by_matrix && !model->has_bend_damping) return true;
    return model->has_curved_rest
               ? provide_slots(&terms->hinge_forces, 4 * model->hinge_count + 1, scratch)
               : provide_slots(&terms->hinge_moments, model->hinge_count + 1, scratch);
}

bool fill_bending(assembly *work) {
    const cloth_model *const model = work->model;
    size_t const hinges = model->hinge_count, triangles = model->triangle_count;
    bool const is_damped = model->has_bend_damping, is_curved = model->has_curved_rest;
    if (model->bends_by_matrix && !is_damped) return true; /* vertices do all */
    work->hinge_vectors = ARENA_NEW(work->scratch, vec3, hinges + 1);
    work->hinge_deviations =
        is_curved ? ARENA_NEW(work->scratch, vec3, hinges + 1) : work->hinge_vectors;
    if (is_damped) work->hinge_rates = ARENA_NEW(work->scratch, vec3, hinges + 1);
    if (!work->hinge_vectors || !work->hinge_deviations || (is_damped && !work->hinge_rates) ||
        !provide_bending_terms(model, &work->terms, work->scratch))
        return false;
    parallel_for(hinges, HINGES_PER_CHUNK, work->threads, TULLE_PICK_KERNEL(fill_hinge_vectors),
                 work);
    if (is_damped) {
        work->bend_dampings = ARENA_NEW(work->scratch, bend_damping_response, triangles);
        if (!work->bend_dampings) return false;
        parallel_for(triangles, HINGES_PER_CHUNK, work->threads,
                     TULLE_PICK_KERNEL(fill_bending_damping), work);
    }
    if (is_curved) {
        deviation_task task = {model, work->state->positions, work->hinge_deviations};
        parallel_for(hinges, HINGES_PER_CHUNK, work->threads, bend_compute_deviations, &task);
    }
    parallel_for(hinges, HINGES_PER_CHUNK, work->threads,
                 is_curved ? fill_forces : TULLE_PICK_KERNEL(fill_hinge_moments), work);
    return true;
}
