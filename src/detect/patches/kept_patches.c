/* detect/patches/kept_patches.c - the order of a call, which checks, repairs, grows and merges
 * patches; see kept_patches.h. patch_schedule.c keeps the budget: it grows and merges when that is
 * due and can be paid, and says whether a repair can be paid. The work itself is done by
 * kept_patches_check.c, patch_growth.c (repairs too) and patch_merging.c. */
#include "detect/patches/kept_patches_parts.h"

#include <string.h>

enum {
    KEPT_MINIMUM = 32,          /* [triangles] smaller patches hold hardly a leaf of a tree */
    RIM_WIDTH = 3,              /* [triangles a boundary edge] whose pairs lie partly outside */
    USEFUL_PERCENT = 15,        /* of triangles inside patches, without their rims; fewer: off */
    GROWN_DEAD_SHARE = 8,       /* after growth: of triangles in patches, to be worth it */
    COMPACT_TRIANGLE_MIN = 1024 /* dead ones that are not worth a new layout */
};

/* ---- creation ---- */

tulle_status kept_patches_create(memory *heap, const surface_set *set, arena *scratch,
                                 kept_patches **result) {
    kept_patches *const patches = memory_allocate_zeroed(heap, 1, sizeof *patches);
    if (!patches) return TULLE_ERROR_OUT_OF_MEMORY;
    const topology *const topo = set->topo;
    size_t const count = topo->triangle_count;
    patches->heap = heap;
    patches->topo = topo;
    patches->scratch = scratch;
    patches->neighbours = memory_allocate_zeroed(heap, 3 * count, sizeof(uint32_t));
    patches->triangle_surface = memory_allocate_zeroed(heap, count, sizeof(uint32_t));
    patches->labels = memory_allocate_zeroed(heap, count, sizeof(uint32_t));
    patches->version = 1;
    size_t const edge_count = topo->edge_count;
    uint32_t *const edge_counts = memory_allocate_zeroed(heap, edge_count, sizeof(uint32_t));
    if (!patches->neighbours || !patches->triangle_surface || !patches->labels || !edge_counts) {
        memory_release(heap, edge_counts, edge_count * sizeof(uint32_t));
        kept_patches_destroy(patches);
        return TULLE_ERROR_OUT_OF_MEMORY;
    }

    /* Neighbours across edges with two triangles that run along them in opposite ways. */
    for (size_t i = 0; i < 3 * count; i++) edge_counts[topo->triangle_edges[i]]++;
    for (size_t i = 0; i < 3 * count; i++) {
        uint32_t const edge = topo->triangle_edges[i], own = (uint32_t)(i / 3);
        const uint32_t *const both = topo->edge_triangles + 2 * (size_t)edge;
        uint32_t const other = both[0] == own ? both[1] : both[0];
        patches->neighbours[i] = edge_counts[edge] > 2 ? NEIGHBOUR_BARRED : other;
        if (edge_counts[edge] > 2 || other == NEIGHBOUR_NONE) continue;
        for (size_t k = 3 * (size_t)other; k < 3 * (size_t)other + 3; k++)
            if (topo->triangle_edges[k] == edge && topo->triangles[k] == topo->triangles[i])
                patches->neighbours[i] = NEIGHBOUR_BARRED;
    }
    memory_release(heap, edge_counts, edge_count * sizeof(uint32_t));
    for (uint32_t s = 0; s < set->surface_count; s++)
        for (size_t i = set->surfaces[s].triangle_begin; i < set->surfaces[s].triangle_end; i++)
            patches->triangle_surface[i] = s;
    *result = patches;
    return TULLE_OK;
}

void release_patches(kept_patches *patches) {
    memory *const heap = patches->heap;
    ARRAY_FREE(heap, &patches->patches);
    ARRAY_FREE(heap, &patches->triangles);
    ARRAY_FREE(heap, &patches->corners);
    ARRAY_FREE(heap, &patches->vertices);
    ARRAY_FREE(heap, &patches->points);
    ARRAY_FREE(heap, &patches->loops);
    ARRAY_FREE(heap, &patches->tasks);
    ARRAY_FREE(heap, &patches->contour_scratch);

    growth_scratch *const growth = &patches->growth;
    size_t const triangle_bytes = patches->topo->triangle_count * sizeof(uint32_t);
    size_t const vertex_bytes = patches->topo->vertex_count * sizeof(uint32_t);
    release_cones(patches);
    memory_release(heap, growth->queue, triangle_bytes);
    memory_release(heap, growth->local, vertex_bytes);
    memory_release(heap, growth->stamps, vertex_bytes);
    memory_release(heap, growth->next, vertex_bytes);
    growth->queue = growth->local = growth->stamps = growth->next = NULL;
}

void kept_patches_destroy(kept_patches *patches) {
    if (!patches) return;
    memory *const heap = patches->heap;
    size_t const triangle_bytes = patches->topo->triangle_count * sizeof(uint32_t);
    memory_release(heap, patches->neighbours, 3 * triangle_bytes);
    memory_release(heap, patches->triangle_surface, triangle_bytes);
    memory_release(heap, patches->labels, triangle_bytes);
    release_patches(patches);
    memory_release(heap, patches, sizeof *patches);
}

void drop_patches(kept_patches *patches) {
    patches->version++;
    patches->patches.count = patches->triangles.count = patches->corners.count = 0;
    patches->vertices.count = patches->points.count = patches->loops.count = 0;
    patches->tasks.count = 0;
    patches->has_tasks = false;
    patches->schedule.dead_triangle_count = 0;
    if (patches->topo->triangle_count > 0)
        memset(patches->labels, 0, patches->topo->triangle_count * sizeof *patches->labels);
}

patch_labels kept_patches_get_labels(const kept_patches *patches) {
    return (patch_labels){.labels = patches->labels,
                          .label_count = (uint32_t)patches->patches.count,
                          .version = patches->version};
}

/* ---- what they cover ---- */

patch_cover measure_cover(const kept_patches *patches, const surface_set *set) {
    patch_cover sum = {0, 0, 0, 0};
    for (uint32_t s = 0; s < set->surface_count; s++) {
        const surface_range *const range = &set->surfaces[s];
        if (surface_meets_itself(set, s))
            sum.meeting += range->triangle_end - range->triangle_begin;
    }
    for (size_t i = 0; i < patches->patches.count; i++) {
        const kept_patch *const patch = &patches->patches.data[i];
        uint64_t const rim = RIM_WIDTH * (uint64_t)patch->loop_count;
        if (patch->triangle_count == 0) continue;
        sum.covered += patch->triangle_count;
        sum.rims += patch->loop_count;
        if (patch->triangle_count > rim) sum.useful += patch->triangle_count - rim;
    }
    return sum;
}

/* Moves `count` items of an array from one place to one before it. Returns the end. */
static size_t move_down(uint32_t *items, size_t from, size_t count, size_t to) {
    if (count > 0) memmove(items + to, items + from, count * sizeof *items);
    return to + count;
}

void compact_patches(kept_patches *patches) {
    size_t triangles = 0, vertices = 0, loops = 0;
    for (size_t place = 0; place < patches->triangles.count;) {
        /* A live patch whose triangles begin here moves down; other triangles are dead. */
        uint32_t const label = patches->labels[patches->triangles.data[place]];
        kept_patch *const patch =
            label == PATCH_ISOLATED ? NULL : &patches->patches.data[label - 1];
        if (!patch || patch->triangle_begin != place) {
            place++;
            continue;
        }
        kept_patch const old = *patch;
        place += old.triangle_count;
        patch->triangle_begin = (uint32_t)triangles;
        patch->vertex_begin = (uint32_t)vertices;
        patch->loop_begin = (uint32_t)loops;
        move_down(patches->corners.data, 3 * (size_t)old.triangle_begin,
                  3 * (size_t)old.triangle_count, 3 * triangles);
        triangles =
            move_down(patches->triangles.data, old.triangle_begin, old.triangle_count, triangles);
        vertices = move_down(patches->vertices.data, old.vertex_begin, old.vertex_count, vertices);
        loops = move_down(patches->loops.data, old.loop_begin, old.loop_count, loops);
    }
    patches->triangles.count = triangles;
    patches->corners.count = 3 * triangles;
    patches->vertices.count = patches->points.count = vertices;
    patches->loops.count = loops;

    uint32_t kept = 0;
    for (size_t i = 0; i < patches->patches.count; i++) {
        kept_patch const patch = patches->patches.data[i];
        if (patch.triangle_count == 0) continue;
        patches->patches.data[kept++] = patch;
        const uint32_t *const list = patches->triangles.data + patch.triangle_begin;
        for (size_t k = 0; k < patch.triangle_count; k++) patches->labels[list[k]] = kept;
    }
    patches->patches.count = kept;
    patches->version++;
    patches->has_tasks = false;
    patches->schedule.dead_triangle_count = 0;
}

/* ---- a call ---- */

/* Checks patches, mends those that fail, and grows and merges more where that is due. */
static tulle_status keep_patches(kept_patches *patches, const growth_input *input,
                                 patch_counts *counts) {
    patch_schedule *const schedule = &patches->schedule;
    const surface_set *const set = input->step->set;
    judge_last_search(patches, measure_cover(patches, set).rims);
    if (schedule->is_off && schedule->call_count < schedule->retry_at) return TULLE_OK;
    tulle_status status;
    bool has_grown = !schedule->has_grown || schedule->is_off;
    if (has_grown) {
        status = grow_first(patches, input, counts);
    } else {
        status = prepare_checks(patches, input->step->threads);
        if (status != TULLE_OK) return status;
        check_patches(patches, input->step, input->rules);
        status = mend_patches(patches, input, counts);
        if (status == TULLE_OK) status = grow_when_due(patches, input, counts, &has_grown);
        if (has_grown || counts->split_count > 0) schedule->has_changed = 1;
        if (status == TULLE_OK) status = merge_when_due(patches, input, counts);
    }
    if (status != TULLE_OK) return status;

    /* After growth, before a search has told: let patches go that cannot save more than they cost.
     * To check an edge of a boundary again costs as much as a triangle inside a patch saves. */
    if (input->rules->has_certificate && !input->rules->keeps_all && has_grown) {
        patch_cover const now = measure_cover(patches, set);
        if (now.useful * 100 < now.meeting * USEFUL_PERCENT + now.rims * 100)
            let_patches_go(patches);
    }

    /* Take dead triangles out where there are many, and give back what only growth took. */
    uint64_t const dead = schedule->dead_triangle_count;
    uint64_t const covered = measure_cover(patches, set).covered;
    bool const compacts =
        dead > COMPACT_TRIANGLE_MIN && dead > (has_grown ? covered / GROWN_DEAD_SHARE : covered);
    if (compacts) compact_patches(patches);
    if ((has_grown || compacts) && !patches->scratch) {
        memory *const heap = patches->heap;
        ARRAY_TRIM(heap, &patches->patches);
        ARRAY_TRIM(heap, &patches->triangles);
        ARRAY_TRIM(heap, &patches->corners);
        ARRAY_TRIM(heap, &patches->vertices);
        ARRAY_TRIM(heap, &patches->points);
        ARRAY_TRIM(heap, &patches->loops);
    }
    return TULLE_OK;
}

tulle_status update_patches(kept_patches *patches, const patch_step *step, const patch_rules *rules,
                            patch_counts *counts) {
    *counts = (patch_counts){0};
    const patch_rules *const last = &patches->rules;
    bool const are_alike = last->cone == rules->cone && last->max_angle == rules->max_angle &&
                           last->has_certificate == rules->has_certificate &&
                           last->grows_anew == rules->grows_anew &&
                           last->keeps_all == rules->keeps_all;
    if (!are_alike) {
        drop_patches(patches);
        patches->schedule = (patch_schedule){0};
    }
    patches->rules = *rules;
    bool const keeps_small = !rules->has_certificate || rules->grows_anew || rules->keeps_all;
    growth_input const input = {step, rules, keeps_small ? 1 : KEPT_MINIMUM};
    arena_mark const mark = patches->scratch ? arena_get_mark(patches->scratch) : (arena_mark){0};
    tulle_status status = rules->grows_anew ? grow_first(patches, &input, counts)
                                            : keep_patches(patches, &input, counts);
    if (patches->scratch || !rules->grows_anew) release_cones(patches);
    if (patches->scratch) arena_release(patches->scratch, mark);
    if (status == TULLE_OK) status = prepare_checks(patches, step->threads);
    if (status != TULLE_OK) {
        drop_patches(patches);
        patches->schedule = (patch_schedule){0};
        *counts = (patch_counts){0};
        return status;
    }
    for (size_t i = 0; i < patches->patches.count; i++) {
        const kept_patch *const patch = &patches->patches.data[i];
        if (patch->triangle_count == 0) continue;
        counts->patch_count++;
        counts->triangle_count += patch->triangle_count;
        counts->star_count += patch->verdict == PATCH_HOLDS_BY_STAR;
        counts->contour_count += patch->verdict == PATCH_HOLDS_BY_SWEEP;
    }
    return TULLE_OK;
}

bool patches_hold(const kept_patches *patches, const patch_step *step, const patch_rules *rules) {
    /* Checks write to scratch and verdicts, which say nothing until the next check. */
    kept_patches *const scratch = (kept_patches *)(uintptr_t)patches;
    if (patches->patches.count == 0) return true;
    if (!patches->has_tasks) return false;
    patch_step narrowed = *step;
    if (narrowed.threads > patches->worker_count) narrowed.threads = patches->worker_count;
    check_patches(scratch, &narrowed, rules);
    for (size_t i = 0; i < patches->patches.count; i++) {
        const kept_patch *const patch = &patches->patches.data[i];
        if (patch->triangle_count > 0 && patch->verdict > PATCH_HOLDS) return false;
    }
    return true;
}
