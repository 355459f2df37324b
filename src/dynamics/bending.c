/* dynamics/bending.c - bending forces from the hinges' vectors c (see bending_matrix.c).
 *
 * Elastic: energy 1/2 sum_ij C_ij d_i . d_j with d = c - r n, r the rest value of c along the hinge
 * normal n. For a flat rest shape (r = 0) the force is linear in the positions. The term
 * r n follows the hinge, as in Garg, Grinspun, Wardetzky, Zorin, Cubic shells, 2007; the force is
 * the exact gradient of the energy, so it keeps both momenta.
 * Where all is flat at rest, the force comes from the matrix instead: kernels/row_kernel.c.
 * Damping: kernels/drag_kernel.c. */
#include "dynamics/assembly.h"

#include "base/parallel.h"

/* Sides that are folded onto each other have no sum of normals to tell the hinge's normal by. Where
 * the sum is shorter than this (a fold angle above 174 degrees), the hinge's vector helps. */
static const double FOLDED_LIMIT = 0.1;

/* The hinge's vector c, too, is along the normal, up or down, and is longest where the sum s of the
 * normals vanishes. So n is the direction of
 *     v = s + (FOLDED_LIMIT - |s|) c / |c|
 * there, with c turned to the side of s. Two sides cannot pass through each other, so they stay on
 * that side. */
hinge_frame bend_compute_frame(const cloth_hinge *hinge, const double inv_double_areas[2],
                               const double *positions) {
    vec3 const x0 = vec3_load(positions, hinge->vertices[0]);
    vec3 const left = vec3_sub(vec3_load(positions, hinge->vertices[2]), x0);
    vec3 const right = vec3_sub(vec3_load(positions, hinge->vertices[3]), x0);
    hinge_frame frame = {.edge = vec3_sub(vec3_load(positions, hinge->vertices[1]), x0)};
    frame.across =
        vec3_sub(vec3_scale(left, inv_double_areas[0]), vec3_scale(right, inv_double_areas[1]));
    vec3 along = vec3_cross(frame.edge, frame.across);
    frame.length = vec3_norm(along);
    if (!(frame.length > FOLDED_LIMIT)) {
        vec3 const c = bend_sum_corners(hinge, positions);
        double const size = vec3_norm(c), more = FOLDED_LIMIT - frame.length;
        if (!(size > 0.0)) return frame;
        double const turn = (vec3_dot(along, c) < 0.0 ? -1.0 : 1.0) / size;
        frame.sum = vec3_normalize(along);
        frame.fold = vec3_scale(c, turn);
        frame.fold_turn = more * turn;
        along = vec3_add_scaled(along, frame.fold, more);
        frame.length = vec3_norm(along);
    }
    frame.normal = vec3_scale(along, 1.0 / frame.length);
    return frame;
}

void bend_turn_normal(const cloth_hinge *hinge, const double inv_double_areas[2],
                      const hinge_frame *frame, vec3 tangential, vec3 turning[4]) {
    vec3 const by_sum =
        frame->fold_turn == 0.0
            ? tangential
            : vec3_add_scaled(tangential, frame->sum, -vec3_dot(frame->fold, tangential));
    vec3 const by_across = vec3_cross(by_sum, frame->edge);
    turning[1] = vec3_cross(frame->across, by_sum);
    turning[2] = vec3_scale(by_across, inv_double_areas[0]);
    turning[3] = vec3_scale(by_across, -inv_double_areas[1]);
    turning[0] = vec3_neg(vec3_add(turning[1], vec3_add(turning[2], turning[3])));
    if (frame->fold_turn == 0.0) return;
    vec3 const by_fold = vec3_scale(vec3_reject(tangential, frame->fold), frame->fold_turn);
    for (int k = 0; k < 4; k++)
        turning[k] = vec3_add_scaled(turning[k], by_fold, hinge->weights[k]);
}

void bend_compute_deviations(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    const deviation_task *const task = context;
    for (size_t h = begin; h < end; h++) {
        const cloth_hinge *const hinge = &task->model->hinges[h];
        const cloth_hinge_rest *const rests = task->model->hinge_rests;
        task->deviations[h] = bend_sum_corners(hinge, task->positions);
        if (!rests || rests[h].curvature == 0.0) continue;
        vec3 const normal =
            bend_compute_frame(hinge, rests[h].inv_double_areas, task->positions).normal;
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
        const double *const inverses = rest->inv_double_areas;
        hinge_frame const frame = bend_compute_frame(hinge, inverses, task->work->state->positions);
        if (vec3_norm2(frame.normal) == 0.0) continue;
        /* r (dn/dx_k)^T y: the gradient of r n . y at fixed y, the elastic moment. */
        vec3 const tangential =
            vec3_scale(vec3_reject(y, frame.normal), rest->curvature / frame.length);
        vec3 turning[4];
        bend_turn_normal(hinge, inverses, &frame, tangential, turning);
        for (size_t k = 0; k < 4; k++) forces[k] = vec3_add(forces[k], turning[k]);
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
