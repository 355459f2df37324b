/* detect/patches/patch_merging.c - joins neighbouring patches after growth, and again from time to
 * time; see kept_patches_parts.h.
 *
 * Breadth-first growth meets steep parts last and goes round them. That leaves small patches
 * between large ones, with long boundaries whose pairs the search has to look at. A small patch
 * joins the neighbour with which it shares most edges, on three conditions: its triangles face that
 * neighbour's axis well, both are one disc together, and that disc is certified about the axis. The
 * union may be wider than alpha_max, as any kept patch may. It keeps half of the angle that is left
 * to a half-space in hand for the steps to come. */
#include "detect/patches/kept_patches_parts.h"

enum {
    MOST_PASSES = 4, /* over all patches */
    NEIGHBOURS_TRIED = 4,
    FEWEST_SHARED = 3, /* edges */
    LEFT_OUT_SHARE = 8 /* one triangle in that many of a small patch, at most, finds no place */
};

static const double RIGHT_ANGLE = 1.5707963267948966; /* [rad] */

/* Labels of the patches with which `patch` shares most edges, most first. */
static void find_neighbours(kept_patches *patches, const kept_patch *patch, uint32_t label,
                            uint32_t best[NEIGHBOURS_TRIED]) {
    uint32_t *const counts = patches->growth.queue; /* edges, by patch: it has room for as many as
                                                       there are triangles */
    const uint32_t *const list = patches->triangles.data + patch->triangle_begin;
    for (int k = 0; k < NEIGHBOURS_TRIED; k++) best[k] = PATCH_ISOLATED;
    for (int is_counting = 0; is_counting < 2; is_counting++) {
        for (size_t i = 0; i < 3 * (size_t)patch->triangle_count; i++) {
            uint32_t const beside = patches->neighbours[3 * (size_t)list[i / 3] + i % 3];
            if (beside >= NEIGHBOUR_BARRED) continue;
            uint32_t const other = patches->labels[beside];
            if (other == PATCH_ISOLATED || other == label) continue;
            if (!is_counting) {
                counts[other - 1] = 0;
                continue;
            }
            uint32_t const count = ++counts[other - 1];
            if (count < FEWEST_SHARED) continue;

            /* Its count has grown: it goes to its place among the best. */
            int at = 0;
            while (at < NEIGHBOURS_TRIED - 1 && best[at] != other) at++;
            uint32_t const last = best[at];
            if (last != other && last != PATCH_ISOLATED && counts[last - 1] >= count) continue;
            for (; at > 0; at--) {
                uint32_t const before = best[at - 1];
                if (before != PATCH_ISOLATED && counts[before - 1] >= count) break;
                best[at] = before;
            }
            best[at] = other;
        }
    }
}

/* Tries to make patches `large` and `small` one, of label large + 1. Where that fails all is as
 * before. */
static tulle_status try_merging(kept_patches *patches, const growth_input *input, uint32_t large,
                                uint32_t small, bool *is_merged) {
    kept_patch const a = patches->patches.data[large], b = patches->patches.data[small];
    size_t const left_out_most = b.triangle_count / LEFT_OUT_SHARE;
    const uint32_t *const a_list = patches->triangles.data + a.triangle_begin;
    const uint32_t *const b_list = patches->triangles.data + b.triangle_begin;
    label_triangles(patches, a_list, a.triangle_count, LABEL_PASSED);
    label_triangles(patches, b_list, b.triangle_count, LABEL_PASSED);
    size_t const joined = spread_patch(patches, NULL, a_list[0], large + 1, NULL);
    label_triangles(patches, a_list, a.triangle_count, PATCH_ISOLATED);
    label_triangles(patches, b_list, b.triangle_count, PATCH_ISOLATED);
    label_triangles(patches, patches->growth.queue, joined, large + 1);
    kept_patch merged = {.axis = a.axis, .verdict = PATCH_CROSSED};
    if (joined + left_out_most >= (size_t)a.triangle_count + b.triangle_count) {
        tulle_status const status = stage_and_check(patches, input, joined, large + 1, &merged);
        if (status != TULLE_OK) return status;
    }
    *is_merged = merged.verdict <= PATCH_HOLDS;
    if (*is_merged) {
        patches->schedule.dead_triangle_count += (uint64_t)a.triangle_count + b.triangle_count;
        patches->patches.data[small].triangle_count = 0;
        patches->version++;
        commit_patch(patches, &merged, large + 1);
    } else {
        const uint32_t *const all = patches->triangles.data; /* staging may have moved it */
        label_triangles(patches, all + a.triangle_begin, a.triangle_count, large + 1);
        label_triangles(patches, all + b.triangle_begin, b.triangle_count, small + 1);
    }
    return TULLE_OK;
}

tulle_status merge_patches(kept_patches *patches, const growth_input *input, uint64_t budget,
                           patch_counts *counts) {
    double const limit = 0.5 * (input->rules->max_angle + RIGHT_ANGLE);
    uint64_t looked_at = 0; /* triangles */
    bool has_merged = true;
    if (patches->patches.count > patches->topo->triangle_count) compact_patches(patches);
    for (int pass = 0; pass < MOST_PASSES && has_merged; pass++) {
        has_merged = false;
        for (uint32_t i = 0; i < patches->patches.count && looked_at < budget; i++) {
            const kept_patch *const small = &patches->patches.data[i];
            if (small->triangle_count == 0) continue;
            looked_at += small->triangle_count;
            uint32_t best[NEIGHBOURS_TRIED];
            find_neighbours(patches, small, i + 1, best);

            /* Try to make it one with a neighbour that is no smaller, about the axis of that. */
            bool is_merged = false;
            for (int k = 0; k < NEIGHBOURS_TRIED && best[k] != PATCH_ISOLATED && !is_merged; k++) {
                const kept_patch *const large = &patches->patches.data[best[k] - 1];
                if (large->triangle_count < small->triangle_count) continue;
                kept_patch turned = *small;
                turned.axis = large->axis;
                if (!patch_faces_axis(patches, &turned, input->step, limit, 0,
                                      turned.triangle_count))
                    continue;
                looked_at += (uint64_t)large->triangle_count + small->triangle_count;
                tulle_status const status = try_merging(patches, input, best[k] - 1, i, &is_merged);
                if (status != TULLE_OK) return status;
            }
            has_merged = has_merged || is_merged;
        }
    }
    counts->grown_triangle_count += looked_at;
    return TULLE_OK;
}
