/* dynamics/membrane.c - the membrane of woven cloth in the linear system: see membrane.h. */
#include "dynamics/assembly.h"

#include "base/parallel.h"

#include <math.h>

bool fill_elements(assembly *work) {
    const cloth_model *const model = work->model;
    const cloth_start *const state = work->state;
    bool const is_mean = work->system->integrator == TULLE_INTEGRATOR_CRANK_NICOLSON;
    size_t const places = cloth_count_places(model);
    work->membrane_blocks = ARENA_NEW(work->scratch, symmetric3, places + 1);
    work->membrane_sources = ARENA_NEW(work->scratch, vec3, places + 1);
    if (!work->membrane_blocks || !work->membrane_sources) return false;
    work->membrane_blocks[places] = (symmetric3){{0.0}};
    membrane_motion motion = {.elements = model->elements,
                              .fabrics = model->fabrics,
                              .element_count = model->triangle_count,
                              .vertex_count = model->vertex_count,
                              .positions = work->padded.positions,
                              .velocities = work->padded.velocities,
                              .start_velocities = work->padded.starts,
                              .guess = work->padded.guess,
                              .time_step = state->time_step,
                              .alpha = work->alpha,
                              .beta = work->beta,
                              .mean_share = is_mean ? work->share : 1.0,
                              .blocks = work->finds_forces ? NULL : work->membrane_blocks,
                              .drags = work->has_wind ? work->terms.triangle_drags : NULL,
                              .sources = work->membrane_sources};
    parallel_for_busy(model->idle_triangles, model->triangle_count, ELEMENTS_PER_CHUNK,
                      work->threads, TULLE_PICK_KERNEL(fill_membrane), &motion);
    return true;
}

typedef struct growth_task {
    membrane_motion motion;
    const double *ends;
    double *parts; /* one a chunk */
} growth_task;

static void find_growth(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)worker;
    const growth_task *const task = context;
    task->parts[chunk] = TULLE_PICK_KERNEL(find_yarn_growth)(&task->motion, task->ends, begin, end);
}

tulle_status cloth_measure_yarn_growth(const cloth_model *model, const double *starts,
                                       const double *ends, int threads, arena *scratch,
                                       double *growth) {
    arena_mark const mark = arena_get_mark(scratch);
    size_t const chunks = parallel_chunk_count(model->triangle_count, ELEMENTS_PER_CHUNK);
    growth_task task = {{.elements = model->elements,
                         .fabrics = model->fabrics,
                         .vertex_count = model->vertex_count,
                         .positions = starts},
                        ends,
                        ARENA_NEW_ZEROED(scratch, double, chunks)};
    *growth = 0.0;
    if (!task.parts) return TULLE_ERROR_OUT_OF_MEMORY;
    parallel_for_busy(model->idle_triangles, model->triangle_count, ELEMENTS_PER_CHUNK, threads,
                      find_growth, &task);
    for (size_t i = 0; i < chunks; i++) *growth = fmax(*growth, task.parts[i]);
    arena_release(scratch, mark);
    return TULLE_OK;
}

static double measure_strain(const membrane_element *element, const double *positions, int yarn) {
    vec3 const origin = vec3_load(positions, element->corners[0]);
    vec3 length = {0.0, 0.0, 0.0};
    for (int i = 0; i < 2; i++)
        length =
            vec3_add_scaled(length, vec3_sub(vec3_load(positions, element->corners[1 + i]), origin),
                            element->gradients[i][yarn]);
    return vec3_norm(length) - 1.0;
}

/* The edge that lies most along a yarn at rest; edge k joins corners k and k + 1. */
static int find_edge_along(const membrane_element *element, int yarn) {
    /* The corners at rest, but for a factor: the inverse of the gradients. */
    const double(*const g)[YARN_COUNT] = element->gradients;
    double const corners[3][YARN_COUNT] = {
        {0.0, 0.0}, {g[1][YARN_WEFT], -g[1][YARN_WARP]}, {-g[0][YARN_WEFT], g[0][YARN_WARP]}};
    int found = 0;
    double most = -1.0;
    for (int k = 0; k < 3; k++) {
        const double *const from = corners[k], *const to = corners[(k + 1) % 3];
        double const way[YARN_COUNT] = {to[0] - from[0], to[1] - from[1]};
        double const share = fabs(way[yarn]) / hypot(way[0], way[1]);
        if (share > most) most = share, found = k;
    }
    return found;
}

bool cloth_is_overstretched(const cloth_model *model, const double *positions, size_t triangle) {
    if (!model->elements) return false;
    const membrane_element *const element = &model->elements[triangle];
    bool is_beyond = false;
    for (int yarn = 0; yarn < YARN_COUNT; yarn++)
        is_beyond |= measure_strain(element, positions, yarn) >
                     model->fabrics[element->fabric].yarns[yarn].limit;
    return is_beyond;
}

yarn_stretch cloth_find_longest_yarn(const cloth_model *model, const double *positions,
                                     bool by_limit) {
    yarn_stretch longest = {.strain = -1.0};
    double most = -(double)INFINITY;
    for (size_t t = 0; model->elements && t < model->triangle_count; t++)
        for (int yarn = 0; yarn < YARN_COUNT; yarn++) {
            const membrane_element *const element = &model->elements[t];
            double const limit = model->fabrics[element->fabric].yarns[yarn].limit;
            double const strain = measure_strain(element, positions, yarn);
            double const measure = by_limit ? strain / limit : strain;
            if (!(measure > most)) continue;
            most = measure;
            longest = (yarn_stretch){strain, limit, (uint32_t)t, yarn, 0};
        }
    if (longest.strain > -1.0)
        longest.edge = find_edge_along(&model->elements[longest.triangle], longest.yarn);
    return longest;
}
