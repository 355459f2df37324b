/* dynamics/membrane.c - the membrane of woven cloth in the linear system: see membrane.h. */
#include "dynamics/assembly.h"

#include "base/parallel.h"

static void fill_slots(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    TULLE_PICK_KERNEL(fill_membrane)(context, begin, end);
}

bool fill_elements(assembly *work) {
    const cloth_model *const model = work->model;
    const motion_state *const state = work->state;
    bool const is_mean = work->system->integrator == TULLE_INTEGRATOR_CRANK_NICOLSON;
    work->membrane_slots = ARENA_NEW(work->scratch, membrane_slot, model->triangle_count);
    if (!work->membrane_slots) return false;
    membrane_motion motion = {.elements = model->elements,
                              .fabrics = model->fabrics,
                              .positions = state->positions,
                              .velocities = state->velocities,
                              .start_velocities = work->start_velocities,
                              .guess = state->guess,
                              .time_step = state->time_step,
                              .alpha = work->alpha,
                              .beta = work->beta,
                              .mean_share = is_mean ? work->share : 1.0,
                              .has_forces = !work->is_renewed,
                              .slots = work->membrane_slots};
    parallel_for(model->triangle_count, ELEMENTS_PER_CHUNK, work->threads, fill_slots, &motion);
    return true;
}

symmetric3 gather_edge_block(const assembly *work, uint32_t edge) {
    if (!work->membrane_slots) return work->spring_blocks[edge];
    symmetric3 sum = {{0.0}};
    for (size_t side = 0; side < 2; side++) {
        uint32_t const place = work->model->edge_places[2 * (size_t)edge + side];
        if (place == TULLE_NONE) continue;
        const double *const block = work->membrane_slots[place / 3].blocks[place % 3];
        for (int i = 0; i < 6; i++) sum.m[i] += block[i];
    }
    return sum;
}

static vec3 get_at_corner(const vec3 pair[2], int corner) {
    return corner == 0 ? vec3_neg(vec3_add(pair[0], pair[1])) : pair[corner - 1];
}

void gather_elements(const assembly *work, uint32_t vertex, vertex_sum *sum) {
    const cloth_model *const model = work->model;
    const adjacency *const uses = &model->surface->vertex_triangles;
    for (size_t k = uses->begin[vertex]; k < uses->begin[vertex + 1]; k++) {
        uint32_t const triangle = uses->items[k];
        const uint32_t *const corners = model->elements[triangle].corners;
        const membrane_slot *const slot = &work->membrane_slots[triangle];
        int const corner = corners[0] == vertex ? 0 : corners[1] == vertex ? 1 : 2;
        if (!work->is_renewed)
            sum->force = vec3_add(sum->force, get_at_corner(slot->forces, corner));
        sum->source = vec3_add(sum->source, get_at_corner(slot->sources, corner));
    }
}
