/* detect/patches/patch_growth.c - grows patches, and cuts those that fail; see
 * kept_patches_parts.h. patch_staging.c writes them into the arrays of patches.
 *
 * Growth is breadth-first over shared edges, from the first triangle that has no patch. A triangle
 * joins while one cone of at most max_angle holds all normals and, where patches shall be
 * certified, the patch stays a disc. For that the triangle shares one edge, and its third corner is
 * new. Or it shares two edges, which then meet at a vertex of the boundary, and the third edge is
 * not in the patch. The first glues a disc to a disc along an edge, the second along two edges in a
 * row. So each vertex is on the boundary at most once, and every first part of the list of
 * triangles is a disc too.
 *
 * A patch that is not certified is cut. If triangles may turn away from the axis, the patch is
 * grown again about the same axis without them. If its boundary may cross itself, its first half is
 * tried: that is what lies nearer to its first triangle. Triangles that are left over may grow
 * patches of their own. */
#include "detect/patches/kept_patches_parts.h"

#include "base/parallel.h"

#include <string.h>

enum {
    CONE_CHUNK = 512,    /* triangles; some 40 microseconds */
    LOOKED_AT_MAX = 3,   /* triangles that one growth looks at, over all triangles */
    YIELD_SHARE = 4,     /* one in that many must have found a patch when all might have been */
    LARGE_SHARE = 16,    /* of all triangles: patches of more than one in that many are large */
    LARGE_MINIMUM = 1024 /* [triangles] and at least that many */
};

/* [rad] For the rounding of the limit, and of coordinates far from the origin. */
static const double LIMIT_SLACK = 1e-7;

static const normal_cone no_cone = {{0.0, 0.0, 0.0}, -1.0};

/* ---- what may join ---- */

/* Whether patch `label` stays a disc when this triangle joins. */
static bool keeps_disc(const kept_patches *patches, uint32_t triangle, uint32_t label) {
    int shared_count = 0;
    size_t shared = 0; /* the last shared edge */
    bool is_barred = false;
    for (size_t k = 0; k < 3; k++) {
        uint32_t const other = patches->neighbours[3 * (size_t)triangle + k];
        if (other == NEIGHBOUR_BARRED) is_barred = true;
        if (other >= NEIGHBOUR_BARRED || patches->labels[other] != label) continue;
        shared_count++;
        shared = k;
    }
    if (shared_count == 2) return !is_barred;
    if (shared_count != 1) return false;
    uint32_t const opposite = patches->topo->triangles[3 * (size_t)triangle + (shared + 2) % 3];
    return !is_in_patch(&patches->growth, opposite);
}

static void take_in(kept_patches *patches, uint32_t triangle, uint32_t label) {
    patches->labels[triangle] = label;
    for (size_t k = 0; k < 3; k++)
        patches->growth.stamps[patches->topo->triangles[3 * (size_t)triangle + k]] =
            patches->growth.stamp;
}

static bool is_free(const kept_patches *patches, uint32_t triangle) {
    return patches->labels[triangle] == PATCH_ISOLATED &&
           patches->growth.cones[triangle].half_angle >= 0.0;
}

size_t spread_patch(kept_patches *patches, const patch_rules *rules, uint32_t seed, uint32_t label,
                    normal_cone *cone) {
    growth_scratch *const growth = &patches->growth;
    bool const is_disc = !cone || rules->has_certificate;
    double limit = 0.0;
    size_t joined = 0;
    if (cone) {
        *cone = growth->cones[seed];
        limit = growth->limits[seed];
    }
    start_patch(patches);
    take_in(patches, seed, label);
    growth->queue[joined++] = seed;
    for (size_t next = 0; next < joined; next++) {
        for (size_t k = 0; k < 3; k++) {
            uint32_t const other = patches->neighbours[3 * (size_t)growth->queue[next] + k];
            if (other >= NEIGHBOUR_BARRED) continue;
            if (cone ? !is_free(patches, other) : patches->labels[other] != LABEL_PASSED) continue;
            if (is_disc && !keeps_disc(patches, other, label)) continue;
            if (cone) {
                double const narrower = fmin(limit, growth->limits[other]);
                if (!normal_cone_merge(cone, &growth->cones[other], narrower, cone)) continue;
                limit = narrower;
            }
            take_in(patches, other, label);
            growth->queue[joined++] = other;
        }
    }
    return joined;
}

/* ---- certified, or cut ---- */

void label_triangles(kept_patches *patches, const uint32_t *list, size_t count, uint32_t label) {
    for (size_t i = 0; i < count; i++) patches->labels[list[i]] = label;
}

/* Takes a triangle out of its patch. A growth of all does not try it again. */
static void isolate(kept_patches *patches, uint32_t triangle) {
    patches->labels[triangle] = PATCH_ISOLATED;
    if (patches->growth.cones) patches->growth.cones[triangle] = no_cone;
}

tulle_status stage_and_check(kept_patches *patches, const growth_input *input, size_t count,
                             uint32_t label, kept_patch *patch) {
    bool const is_disc = input->rules->has_certificate;
    tulle_status const status =
        stage_patch(patches, patches->growth.queue, count, label, is_disc, patch);
    if (status != TULLE_OK) return status;
    patches->contour_scratch.count = 0;
    if (!ARRAY_RESERVE(patches->heap, &patches->contour_scratch,
                       contour_scratch_size(patch->loop_count)))
        return TULLE_ERROR_OUT_OF_MEMORY;
    patch->verdict =
        is_disc && patch->loop_count == 0
            ? PATCH_CROSSED
            : check_patch(patches, patch, input->step, input->rules, patches->contour_scratch.data);
    return TULLE_OK;
}

/* Grows the staged patch again without the triangles that may turn. Returns how many joined. */
static size_t leave_out_turned(kept_patches *patches, const kept_patch *patch, double reach,
                               uint32_t label) {
    const planar_path *const points = patches->points.data + patch->vertex_begin;
    const uint32_t *const corners = patches->corners.data + 3 * (size_t)patch->triangle_begin;
    const uint32_t *const list = patches->triangles.data + patch->triangle_begin;
    uint32_t seed = TULLE_NONE;
    for (size_t i = 0; i < patch->triangle_count; i++) {
        const uint32_t *const corner = corners + 3 * i;
        bool const passes = reach > 0.0 && compute_turn_sign(&points[corner[0]], &points[corner[1]],
                                                             &points[corner[2]], reach) == 1;
        if (passes)
            patches->labels[list[i]] = LABEL_PASSED;
        else
            isolate(patches, list[i]);
        if (passes && seed == TULLE_NONE) seed = list[i];
    }
    size_t const joined = seed == TULLE_NONE ? 0 : spread_patch(patches, NULL, seed, label, NULL);
    label_triangles(patches, list, patch->triangle_count, PATCH_ISOLATED);
    label_triangles(patches, patches->growth.queue, joined, label);
    return joined;
}

/* Makes the first `count` triangles of the queue, which bear the label, the patch of that label, or
 * as many of them as hold. Without any, patch->triangle_count is 0. */
static tulle_status settle_patch(kept_patches *patches, const growth_input *input, size_t count,
                                 kept_patch *patch, uint32_t label) {
    uint32_t *const list = patches->growth.queue;
    const patch_rules *const rules = input->rules;
    bool was_regrown = false;
    while (count >= input->minimum && count > 0) {
        tulle_status const status = stage_and_check(patches, input, count, label, patch);
        if (status != TULLE_OK) return status;
        if (patch->verdict <= PATCH_HOLDS) {
            commit_patch(patches, patch, label);
            return TULLE_OK;
        }
        if (patch->verdict == PATCH_TURNED) {
            if (was_regrown || !rules->has_certificate) break;
            was_regrown = true;
            double const size = project_patch(patches, patch, input->step, 0, patch->vertex_count);
            count =
                leave_out_turned(patches, patch, compute_planar_reach(rules->reach, size), label);
        } else {
            if (count / 2 < input->minimum) break;
            label_triangles(patches, list + count / 2, count - count / 2, PATCH_ISOLATED);
            count /= 2;
        }
    }
    for (size_t i = 0; i < count; i++) isolate(patches, list[i]);
    patch->triangle_count = 0;
    patches->patches.data[label - 1] = *patch;
    return TULLE_OK;
}

/* ---- growth of all ---- */

typedef struct cone_run {
    kept_patches *patches;
    const growth_input *input;
} cone_run;

/* How far the axis may lean from the normals of a triangle that shall face it with a reach r: at
 * most max_angle, and negative where r is too much for any lean. The bound of compute_turn_sign
 * holds when |n| cos(lean) > r p + DISC_TRIANGLE r^2. p is the perimeter in space, which is no less
 * than that in the plane; 9% are added for bound_length. */
static double compute_limit(const vec3 start[3], const vec3 end[3], const patch_rules *rules) {
    double const reach = rules->reach;
    if (!(reach > 0.0) || !rules->has_certificate) return rules->max_angle;
    vec3 const u0 = vec3_sub(start[1], start[0]), v0 = vec3_sub(start[2], start[0]);
    vec3 const u1 = vec3_sub(end[1], end[0]), v1 = vec3_sub(end[2], end[0]);
    double const p0 = vec3_norm(u0) + vec3_norm(v0) + vec3_norm(vec3_sub(v0, u0));
    double const p1 = vec3_norm(u1) + vec3_norm(v1) + vec3_norm(vec3_sub(v1, u1));
    vec3 const middle = vec3_add(vec3_cross(u0, v1), vec3_cross(u1, v0));
    double const normal[3] = {vec3_norm(vec3_cross(u0, v0)), 0.5 * vec3_norm(middle),
                              vec3_norm(vec3_cross(u1, v1))};
    double const perimeter[3] = {p0, 0.5 * (p0 + p1), p1};
    double cosine = cos(rules->max_angle);
    for (int k = 0; k < 3; k++) {
        double const needed = 1.09 * reach * perimeter[k] + DISC_TRIANGLE * reach * reach;
        if (!(needed < normal[k])) return -1.0;
        cosine = fmax(cosine, needed / normal[k]);
    }
    return fmin(acos(cosine) - LIMIT_SLACK, rules->max_angle);
}

static void compute_cones(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    const cone_run *const run = context;
    kept_patches *const patches = run->patches;
    for (size_t i = begin; i < end; i++) {
        normal_cone *const cone = &patches->growth.cones[i];
        *cone = no_cone;
        if (patches->labels[i] != PATCH_ISOLATED ||
            !surface_meets_itself(run->input->step->set, patches->triangle_surface[i]))
            continue;
        const uint32_t *const corners = patches->topo->triangles + 3 * i;
        vec3 start[3], finish[3];
        for (int k = 0; k < 3; k++) {
            start[k] = vec3_load(run->input->step->x0, corners[k]);
            finish[k] = vec3_load(run->input->step->x1, corners[k]);
        }
        *cone = normal_cone_of_triangle(run->input->rules->cone, start, finish);
        double const limit = compute_limit(start, finish, run->input->rules);
        patches->growth.limits[i] = limit;
        if (cone->half_angle > limit) *cone = no_cone;
    }
}

tulle_status grow_kept_patches(kept_patches *patches, const growth_input *input,
                               patch_counts *counts) {
    growth_scratch *const growth = &patches->growth;
    memory *const heap = patches->heap;
    arena *const scratch = patches->scratch;
    size_t const triangle_count = patches->topo->triangle_count;
    size_t const cone_bytes = triangle_count * sizeof *growth->cones;
    size_t const limit_bytes = triangle_count * sizeof *growth->limits;
    tulle_status status = reserve_growth(patches);
    if (status != TULLE_OK) return status;
    if (!growth->cones)
        growth->cones =
            scratch ? arena_allocate(scratch, 1, cone_bytes) : memory_allocate(heap, cone_bytes);
    if (!growth->limits)
        growth->limits =
            scratch ? arena_allocate(scratch, 1, limit_bytes) : memory_allocate(heap, limit_bytes);
    if (!growth->cones || !growth->limits) return TULLE_ERROR_OUT_OF_MEMORY;
    patches->version++;
    cone_run run = {patches, input};
    parallel_for(triangle_count, CONE_CHUNK, input->step->threads, compute_cones, &run);
    uint64_t looked_at = 0, kept = 0;
    for (uint32_t seed = 0; seed < triangle_count; seed++) {
        if (!is_free(patches, seed)) continue;
        if (looked_at > LOOKED_AT_MAX * triangle_count) break;
        /* Where patches were let go before, most of what grows now may fail too. */
        if (patches->schedule.is_off && looked_at > triangle_count &&
            kept * YIELD_SHARE < looked_at)
            break;
        if (!ARRAY_RESERVE(patches->heap, &patches->patches, 1)) return TULLE_ERROR_OUT_OF_MEMORY;
        uint32_t const label = (uint32_t)(patches->patches.count + 1);
        normal_cone cone;
        size_t const joined = spread_patch(patches, input->rules, seed, label, &cone);
        looked_at += joined;
        kept_patch patch = {.axis = cone.axis};
        status = settle_patch(patches, input, joined, &patch, label);
        if (status != TULLE_OK) return status;
        kept += patch.triangle_count;
        if (patch.triangle_count > 0) patches->patches.count++;
    }
    counts->grown_triangle_count += looked_at;
    return TULLE_OK;
}

tulle_status mend_patches(kept_patches *patches, const growth_input *input, patch_counts *counts) {
    patch_schedule *const schedule = &patches->schedule;
    uint64_t most = patches->topo->triangle_count / LARGE_SHARE;
    if (most < LARGE_MINIMUM) most = LARGE_MINIMUM;
    for (uint32_t i = 0; i < patches->patches.count; i++) {
        kept_patch const old = patches->patches.data[i];
        if (old.triangle_count == 0) continue;
        if (old.verdict <= PATCH_HOLDS) {
            counts->kept_count++;
            continue;
        }
        bool const is_repaired = old.verdict != PATCH_LEFT &&
                                 (old.triangle_count <= most || patches->rules.keeps_all) &&
                                 pay_for_repair(schedule, old.triangle_count);

        /* The patch is dissolved: its triangles are isolated, or go to the queue to be repaired. */
        const uint32_t *const list = patches->triangles.data + old.triangle_begin;
        patches->patches.data[i].triangle_count = 0;
        patches->version++;
        patches->has_tasks = false;
        schedule->dead_triangle_count += old.triangle_count;
        if (!is_repaired) {
            label_triangles(patches, list, old.triangle_count, PATCH_ISOLATED);
            counts->dissolved_count++;
            continue;
        }

        /* What is left of it becomes the patch of its label again. */
        tulle_status status = reserve_growth(patches);
        if (status != TULLE_OK) return status;
        memcpy(patches->growth.queue, list, old.triangle_count * sizeof *list);
        counts->grown_triangle_count += old.triangle_count;
        kept_patch patch = {.axis = old.axis};
        status = settle_patch(patches, input, old.triangle_count, &patch, i + 1);
        if (status != TULLE_OK) return status;
        if (patch.triangle_count > 0)
            counts->split_count++;
        else
            counts->dissolved_count++;
    }
    return TULLE_OK;
}

tulle_status append_patch(kept_patches *patches, const uint32_t *triangles, size_t count, vec3 axis,
                          bool is_disc) {
    tulle_status status = reserve_growth(patches);
    if (status == TULLE_OK && !ARRAY_RESERVE(patches->heap, &patches->patches, 1))
        status = TULLE_ERROR_OUT_OF_MEMORY;
    if (status != TULLE_OK) return status;
    uint32_t const label = (uint32_t)(patches->patches.count + 1);
    const uint32_t *const surfaces = patches->triangle_surface;
    patches->version++;
    start_patch(patches);
    for (size_t i = 0; i < count; i++) {
        uint32_t const triangle = triangles[i];
        bool const is_good = triangle < patches->topo->triangle_count &&
                             surfaces[triangle] == surfaces[triangles[0]] &&
                             patches->labels[triangle] == PATCH_ISOLATED &&
                             (!is_disc || i == 0 || keeps_disc(patches, triangle, label));
        if (!is_good) return TULLE_ERROR_INVALID_ARGUMENT;
        take_in(patches, triangle, label);
    }
    kept_patch patch = {.axis = axis};
    if (count > 0) status = stage_patch(patches, triangles, count, label, is_disc, &patch);
    if (status != TULLE_OK) return status;
    if (count > 0 && is_disc && patch.loop_count == 0) return TULLE_ERROR_INVALID_ARGUMENT;
    patches->patches.count++;
    commit_patch(patches, &patch, label);
    return TULLE_OK;
}
