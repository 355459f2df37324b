/* detect/patches/patch_merging.c - joins neighbouring patches after growth, and again from time to
 * time; see kept_patches_parts.h.
 *
 * Breadth-first growth meets steep parts last and goes round them, so small patches are left
 * between large ones, with long boundaries, whose pairs the search has to look at. A small patch
 * joins the neighbour with which it shares most edges when its triangles face that one's axis well,
 * both are a disc together, and that disc is certified about the axis. As a kept patch may, the
 * union may so be wider than alpha_max; it keeps half of what is left to a half-space in hand for
 * the steps to come. */
#include "detect/patches/kept_patches_parts.h"

enum {
    MOST_PASSES = 4, /* over all patches */
    NEIGHBOURS_TRIED = 4,
    FEWEST_SHARED = 3, /* edges */
    LEFT_OUT_SHARE = 8 /* one triangle in that many of a small patch, at most, finds no place */
};

static const double RIGHT_ANGLE = 1.5707963267948966; /* [rad] */

/* Puts a label whose count has grown into its place among the best. */
static void insert_neighbour(const uint32_t *counts, uint32_t label,
                             uint32_t best[NEIGHBOURS_TRIED]) {
    int at = 0;
    while (at < NEIGHBOURS_TRIED && best[at] != label) at++;
    if (at == NEIGHBOURS_TRIED) {
        uint32_t const last = best[NEIGHBOURS_TRIED - 1];
        if (last != PATCH_ISOLATED && counts[last - 1] >= counts[label - 1]) return;
        at = NEIGHBOURS_TRIED - 1;
    }
    for (; at > 0; at--) {
        uint32_t const before = best[at - 1];
        if (before != PATCH_ISOLATED && counts[before - 1] >= counts[label - 1]) break;
        best[at] = before;
    }
    best[at] = label;
}

/* Labels of the patches with which `patch` shares most edges, most first. */
static void find_neighbours(kept_patches *patches, const kept_patch *patch, uint32_t label,
                            uint32_t best[NEIGHBOURS_TRIED]) {
    uint32_t *const counts = patches->growth.queue; /* edges, by patch */
    const uint32_t *const list = patches->triangles.data + patch->triangle_begin;
    for (int k = 0; k < NEIGHBOURS_TRIED; k++) best[k] = PATCH_ISOLATED;
    for (int is_counting = 0; is_counting < 2; is_counting++) {
        for (size_t i = 0; i < 3 * (size_t)patch->triangle_count; i++) {
            uint32_t const other = patches->neighbours[3 * (size_t)list[i / 3] + i % 3];
            if (other >= NEIGHBOUR_BARRED) continue;
            uint32_t const at = patches->labels[other];
            if (at == PATCH_ISOLATED || at == label) continue;
            if (!is_counting)
                counts[at - 1] = 0;
            else if (++counts[at - 1] >= FEWEST_SHARED)
                insert_neighbour(counts, at, best);
        }
    }
}

static bool faces_axis(const kept_patches *patches, const kept_patch *patch, vec3 axis,
                       const growth_input *input) {
    double const limit = 0.5 * (input->rules->max_angle + RIGHT_ANGLE);
    const uint32_t *const list = patches->triangles.data + patch->triangle_begin;
    for (size_t i = 0; i < patch->triangle_count; i++) {
        const uint32_t *const corners = patches->topo->triangles + 3 * (size_t)list[i];
        vec3 start[3], end[3];
        for (int k = 0; k < 3; k++) {
            start[k] = vec3_load(input->step->x0, corners[k]);
            end[k] = vec3_load(input->step->x1, corners[k]);
        }
        if (!triangle_faces_axis(start, end, axis, limit, 0.0)) return false;
    }
    return true;
}

static void relabel_patch(kept_patches *patches, const kept_patch *patch, uint32_t label) {
    const uint32_t *const list = patches->triangles.data + patch->triangle_begin;
    for (size_t i = 0; i < patch->triangle_count; i++) patches->labels[list[i]] = label;
}

/* Those of a patch that a disc of both could not take in. */
static void isolate_passed(kept_patches *patches, const kept_patch *patch) {
    const uint32_t *const list = patches->triangles.data + patch->triangle_begin;
    for (size_t i = 0; i < patch->triangle_count; i++) {
        uint32_t *const own = &patches->labels[list[i]];
        if (*own == LABEL_PASSED) *own = PATCH_ISOLATED;
    }
}

/* Stages and checks the first `count` triangles of the queue, which bear the label. */
static tulle_status check_union(kept_patches *patches, const growth_input *input, size_t count,
                                uint32_t label, kept_patch *merged) {
    bool is_one = false;
    tulle_status status = stage_patch(patches, patches->growth.queue, count, merged);
    if (status == TULLE_OK) status = stage_loop(patches, merged, label, &is_one);
    if (status == TULLE_OK)
        status = reserve_contour_scratch(patches, check_scratch_size(merged->loop_count));
    if (status != TULLE_OK) return status;
    merged->verdict = is_one ? check_patch(patches, merged, input->step, input->rules,
                                           patches->contour_scratch.data)
                             : PATCH_CROSSED;
    return TULLE_OK;
}

/* Tries to make patches `large` and `small` one, of label large + 1. Where that fails all is as
 * before. */
static tulle_status try_merging(kept_patches *patches, const growth_input *input, uint32_t large,
                                uint32_t small, bool *is_merged) {
    kept_patch const a = patches->patches.data[large], b = patches->patches.data[small];
    size_t const left_out_most = b.triangle_count / LEFT_OUT_SHARE;
    relabel_patch(patches, &a, LABEL_PASSED);
    relabel_patch(patches, &b, LABEL_PASSED);
    size_t const joined =
        spread_among_passed(patches, patches->triangles.data[a.triangle_begin], large + 1);
    isolate_passed(patches, &a);
    isolate_passed(patches, &b);
    kept_patch merged = {.axis = a.axis, .verdict = PATCH_CROSSED};
    if (joined + left_out_most >= (size_t)a.triangle_count + b.triangle_count) {
        tulle_status const status = check_union(patches, input, joined, large + 1, &merged);
        if (status != TULLE_OK) return status;
    }
    *is_merged = verdict_holds((patch_verdict)merged.verdict);
    if (*is_merged) {
        patches->schedule.dead_triangle_count += (uint64_t)a.triangle_count + b.triangle_count;
        patches->patches.data[small].triangle_count = 0;
        patches->version++;
        commit_patch(patches, &merged, large + 1);
    } else {
        relabel_patch(patches, &a, large + 1);
        relabel_patch(patches, &b, small + 1);
    }
    return TULLE_OK;
}

/* Tries to make a patch one with a neighbour that is no smaller. *looked_at: triangles. */
static tulle_status merge_small(kept_patches *patches, const growth_input *input, uint32_t index,
                                uint64_t *looked_at, bool *is_merged) {
    const kept_patch *const small = &patches->patches.data[index];
    uint32_t best[NEIGHBOURS_TRIED];
    find_neighbours(patches, small, index + 1, best);
    *looked_at += small->triangle_count;
    *is_merged = false;
    for (int k = 0; k < NEIGHBOURS_TRIED && best[k] != PATCH_ISOLATED && !*is_merged; k++) {
        const kept_patch *const large = &patches->patches.data[best[k] - 1];
        if (large->triangle_count < small->triangle_count ||
            !faces_axis(patches, small, large->axis, input))
            continue;
        *looked_at += (uint64_t)large->triangle_count + small->triangle_count;
        tulle_status const status = try_merging(patches, input, best[k] - 1, index, is_merged);
        if (status != TULLE_OK) return status;
    }
    return TULLE_OK;
}

tulle_status merge_patches(kept_patches *patches, const growth_input *input, uint64_t budget,
                           patch_counts *counts) {
    uint64_t looked_at = 0;
    bool has_merged = true;
    for (int pass = 0; pass < MOST_PASSES && has_merged; pass++) {
        has_merged = false;
        for (uint32_t i = 0; i < patches->patches.count && looked_at < budget; i++) {
            bool is_merged = false;
            if (patches->patches.data[i].triangle_count == 0) continue;
            tulle_status const status = merge_small(patches, input, i, &looked_at, &is_merged);
            if (status != TULLE_OK) return status;
            has_merged = has_merged || is_merged;
        }
    }
    counts->grown_triangle_count += looked_at;
    return TULLE_OK;
}
