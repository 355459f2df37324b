/* dynamics/bending.c - bending forces from the hinges' vectors c (see bending_matrix.c).
 *
 * Elastic: energy 1/2 sum_ij C_ij d_i . d_j with d = c - r n, r the rest value of c along the hinge
 * normal n. For a flat rest shape (r = 0) the force is linear in the positions. The term
 * r n follows the hinge, as in Garg, Grinspun, Wardetzky, Zorin, Cubic shells, 2007; the force is
 * the exact gradient of the energy, so it keeps both momenta.
 * Where all is flat at rest, the force comes from the matrix instead: kernels/row_kernel.c.
 * Damping: kernels/patch_kernel.c. */
#include "dynamics/assembly.h"

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

typedef struct force_task {
    const assembly *work;
    const vec3 *deviations;
    vec3 *forces;
} force_task;

/* Forces [N] on the corners of hinges, in a model with curved rest shapes. */
static void fill_forces(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    const force_task *const task = context;
    const cloth_model *const model = task->work->model;
    for (size_t h = begin; h < end; h++) {
        const cloth_hinge *const hinge = &model->hinges[h];
        vec3 const y = bend_compute_moment(model, h, task->deviations);
        vec3 *const forces = task->forces + 4 * h;
        for (size_t k = 0; k < 4; k++) forces[k] = vec3_scale(y, -hinge->weights[k]);
        const cloth_hinge_rest *const rest = &model->hinge_rests[h];
        if (rest->curvature == 0.0) continue;
        hinge_frame const frame = compute_frame(hinge, rest, task->work->state->positions);
        vec3 const n = frame.normal;
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

bool fill_bending(assembly *work) {
    const cloth_model *const model = work->model;
    size_t const hinges = model->hinge_count;
    if (!model->has_bending || model->bends_by_matrix) return true;
    vec3 *const deviations = ARENA_NEW(work->scratch, vec3, hinges);
    work->hinge_forces = ARENA_NEW(work->scratch, vec3, 4 * hinges + 1);
    if (!deviations || !work->hinge_forces) return false;
    deviation_task task = {model, work->state->positions, deviations};
    parallel_for(hinges, HINGES_PER_CHUNK, work->threads, bend_compute_deviations, &task);
    force_task forces = {work, deviations, work->hinge_forces};
    parallel_for(hinges, HINGES_PER_CHUNK, work->threads, fill_forces, &forces);
    return true;
}
