/* contact/pairs/contact_paths.c - paths and the contract of pair_source, see contact_paths.h. */
#include "contact/pairs/contact_paths.h"

#include "base/parallel.h"
#include "contact/pairs/body_paths.h"
#include "detect/impact/time_of_impact.h"

#include <stdatomic.h>

enum { VERTICES_PER_CHUNK = 2048 };

typedef struct path_task {
    const contact_scene *scene;
    const double *u;
    double *x1;
} path_task;

static void propose_chunk(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    const path_task *const task = context;
    const contact_scene *const scene = task->scene;
    for (size_t vertex = begin; vertex < end; vertex++) {
        if (is_slot(scene, vertex)) continue;
        bool const is_free = scene->inverse_mass[vertex] > 0.0;
        for (size_t i = 3 * vertex; i < 3 * vertex + 3; i++)
            task->x1[i] =
                is_free ? scene->x0[i] + scene->time_step * task->u[i] : scene->targets[i];
    }
}

void propose_paths(const contact_scene *scene, const double *u, double *x1) {
    path_task task = {scene, u, x1};
    parallel_for(scene->vertex_count, VERTICES_PER_CHUNK, scene->threads, propose_chunk, &task);
    place_bodies(scene, u, 1.0, x1);
}

void prescribe_motion(const contact_scene *scene, double *u) {
    for (size_t vertex = 0; vertex < scene->vertex_count; vertex++) {
        if (scene->inverse_mass[vertex] > 0.0 || is_slot(scene, vertex)) continue;
        for (size_t i = 3 * vertex; i < 3 * vertex + 3; i++)
            u[i] = (scene->targets[i] - scene->x0[i]) / scene->time_step;
    }
}

typedef struct bounds_task {
    const contact_scene *scene;
    const double *first, *last, *x1; /* ways of the search go from first to last */
    double reach;
    atomic_bool is_outside;
} bounds_task;

static void check_chunk(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    bounds_task *const task = context;
    for (size_t v = begin; v < end; v++) {
        if (is_slot(task->scene, v)) continue; /* the vertices of its body count */
        bool is_inside = true;
        for (size_t i = 3 * v; i < 3 * v + 3; i++) {
            double const a = task->first[i], b = task->last[i];
            double const low = a < b ? a : b, high = a < b ? b : a;
            is_inside &= task->x1[i] >= low - task->reach && task->x1[i] <= high + task->reach;
        }
        if (is_inside) continue;
        atomic_store(&task->is_outside, true);
        return;
    }
}

bool paths_stay_in_bounds(const contact_scene *scene, const pair_source *source, const double *x1) {
    /* A triangle's path box, widened by half of what a test may call a hit, then lies in the box
     * that was searched. A millionth less covers the rounding of these sums. */
    double const hit = HIT_RESERVE * scene->settings.minimum_gap;
    bounds_task task = {.scene = scene,
                        .first = source->is_straight ? source->bounds : scene->x0,
                        .last = source->bounds,
                        .x1 = x1,
                        .reach = 0.5 * (source->margin - hit) * (1.0 - 1e-6)};
    if (!(task.reach >= 0.0)) return false;
    atomic_init(&task.is_outside, false);
    parallel_for(scene->vertex_count, VERTICES_PER_CHUNK, scene->threads, check_chunk, &task);
    return !atomic_load(&task.is_outside);
}

tulle_status ensure_pairs_cover(const contact_scene *scene, pair_source *source, const double *x1) {
    if (paths_stay_in_bounds(scene, source, x1))
        return source->adapt ? source->adapt(source, x1) : TULLE_OK;
    if (stop_is_wanted(scene->stop, 0)) return TULLE_ERROR_INTERRUPTED;
    source->renew_count++;
    return source->renew(source, x1);
}
