/* detect/patches/patches.c - see patches.h.
 *
 * First the cones of single triangles are computed, in parallel. Then patches grow breadth-first:
 * the seed is the first triangle that has no patch yet, and neighbours across edges join while the
 * cone of all stays within max_angle. A neighbour that could not join from one triangle is tried
 * again from others. It cannot join then either, since the cone only grows, but trying costs one
 * merge. */
#include "detect/patches/patches.h"

#include "base/parallel.h"

enum { CONE_CHUNK = 512 /* triangles; some 40 microseconds */ };

typedef struct growth {
    const patch_surface *surface;
    double max_angle;
    normal_cone *cones; /* of each triangle */
    uint32_t *queue;    /* triangles of the patch that grows, in the order they joined */
    uint32_t *labels;
} growth;

static void compute_cones(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    const growth *const work = context;
    const patch_surface *const surface = work->surface;
    for (size_t i = begin; i < end; i++) {
        const uint32_t *const corners =
            surface->topo->triangles + 3 * (surface->triangle_begin + i);
        vec3 start[3], finish[3];
        for (int k = 0; k < 3; k++) {
            start[k] = vec3_load(surface->x0, corners[k]);
            finish[k] = vec3_load(surface->x1, corners[k]);
        }
        work->cones[i] = normal_cone_of_triangle(CONE_BERNSTEIN, start, finish);
    }
}

/* Whether the triangle may be in a patch and is in none. */
static bool is_free(const growth *work, size_t triangle) {
    double const half_angle = work->cones[triangle].half_angle;
    return work->labels[triangle] == PATCH_ISOLATED && half_angle >= 0.0 &&
           half_angle <= work->max_angle;
}

/* The triangle across edge `k` of a triangle, both counted from triangle_begin; TULLE_NONE if there
 * is none. */
static uint32_t find_neighbour(const patch_surface *surface, uint32_t triangle, size_t k) {
    uint32_t const own = surface->triangle_begin + triangle;
    uint32_t const edge = surface->topo->triangle_edges[3 * (size_t)own + k];
    const uint32_t *const both = surface->topo->edge_triangles + 2 * (size_t)edge;
    uint32_t const other = both[0] == own ? both[1] : both[0];
    bool const is_inside = other >= surface->triangle_begin && other < surface->triangle_end;
    return is_inside ? other - surface->triangle_begin : TULLE_NONE;
}

/* Grows the patch of one seed and returns its cone. */
static normal_cone grow_from(growth *work, uint32_t seed, uint32_t label) {
    normal_cone cone = work->cones[seed];
    size_t joined = 0;
    work->labels[seed] = label;
    work->queue[joined++] = seed;
    for (size_t next = 0; next < joined; next++) {
        for (size_t k = 0; k < 3; k++) {
            uint32_t const neighbour = find_neighbour(work->surface, work->queue[next], k);
            if (neighbour == TULLE_NONE || !is_free(work, neighbour)) continue;
            if (!normal_cone_merge(&cone, &work->cones[neighbour], work->max_angle, &cone))
                continue;
            work->labels[neighbour] = label;
            work->queue[joined++] = neighbour;
        }
    }
    return cone;
}

tulle_status grow_patches(const patch_surface *surface, const patch_settings *settings,
                          arena *scratch, uint32_t *labels, patch_list *list) {
    size_t const count = surface->triangle_end - surface->triangle_begin;
    *list = (patch_list){.cones = ARENA_NEW(scratch, normal_cone, count)};
    growth work = {.surface = surface,
                   .max_angle = settings->max_angle,
                   .cones = ARENA_NEW(scratch, normal_cone, count),
                   .queue = ARENA_NEW(scratch, uint32_t, count),
                   .labels = labels};
    if (!list->cones || !work.cones || !work.queue) return TULLE_ERROR_OUT_OF_MEMORY;
    parallel_for(count, CONE_CHUNK, settings->threads, compute_cones, &work);
    for (size_t i = 0; i < count; i++) labels[i] = PATCH_ISOLATED;
    for (size_t i = 0; i < count; i++) {
        if (!is_free(&work, i)) continue;
        list->cones[list->count] = grow_from(&work, (uint32_t)i, (uint32_t)(list->count + 1));
        list->count++;
    }
    return TULLE_OK;
}
