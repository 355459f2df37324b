/* world/step/search.c - see search.h.
 *
 * Based on: Wong, Baciu, Dynamic interaction between deformable surfaces and nonsmooth objects,
 * 2005, section 3. Departures: a patch is skipped only when it is proven not to touch itself, and
 * patches live from step to step; docs/method/update_patches.md. */
#include "world/step/search.h"

#include "base/timer.h"
#include "detect/impact/time_of_impact.h"

#include <math.h>
#include <string.h>

/* Boxes are widened by this share of the mean edge beyond the separation distance, so that paths
 * which the solve bends a little stay inside the candidates that were found for the predicted ones.
 */
static const double PAIR_MARGIN_EDGE_SHARE = 0.05;

/* Patches are certified with this much more than half the separation distance, so that no rounding
 * of a distance tells a candidate from one that was left out. */
static const double REACH_RESERVE = 1.0 + 1e-6;

/* [rad] 89 degrees: the angle of a patch's cone for other paths than those it was found for. It
 * counts only where patches have no certificate; with one, a kept patch may have any angle. */
static const double HOLD_ANGLE = 1.5533430342749535;

/* Stages 8 and 9 take patches that are certified for their paths with this share of the reach, or
 * more where the minimum gap asks for it. */
static const double HOLD_REACH_SHARE = 0.25;

tulle_status world_start_detection(tulle_world *world) {
    const tulle_world_detection *const def = &world->model.def.detection;
    bool const is_paper = def->method == TULLE_DETECT_PAPER;
    broad_phase_method const trees = def->method == TULLE_DETECT_BVOX ? BROAD_PHASE_BVOX
                                     : is_paper                       ? BROAD_PHASE_PAPER
                                                                      : BROAD_PHASE_REFIT;
    tulle_status status = broad_phase_create(&world->heap, &world->model.set, world->model.rest,
                                             trees, &world->work.broad);
    if (status != TULLE_OK) return status;
    broad_phase_configure(world->work.broad,
                          (broad_phase_options){.following = PATHS_WHERE_LONG,
                                                .stop = &world->work.stop,
                                                .most_candidates = MOST_CANDIDATES(world),
                                                .scratch = &world->work.scratch});
    if (def->method != TULLE_DETECT_PATCHES && !is_paper) return TULLE_OK;

    /* [m] Inner pairs of patches stay beyond all that gather_rows makes rows of. */
    double const hit = HIT_RESERVE * world->model.contact_distance;
    double const reach = 0.5 * REACH_RESERVE * fmax(world->model.separation_distance, hit);
    world->work.patch_rules =
        (patch_rules){.cone = def->cone == TULLE_CONE_PAPER ? CONE_PAPER : CONE_BERNSTEIN,
                      .max_angle = def->max_angle,
                      .has_certificate = def->has_certificate != 0,
                      .grows_anew = def->grows_patches_anew || is_paper,
                      .reach = reach,
                      .keeps_all = world->work.patch_rules.keeps_all};
    /* Beyond all that stages 8 and 9 call a hit. The minimum gap is at most half of the contact
     * distance, so this is less than the reach. */
    double const gap_reach = 0.5 * REACH_RESERVE * HIT_RESERVE * world->model.minimum_gap;
    world->work.hold_reach = fmin(fmax(HOLD_REACH_SHARE * reach, gap_reach), reach);
    return kept_patches_create(&world->heap, &world->model.set, &world->work.scratch,
                               &world->work.patches);
}

void world_release_detection(tulle_world *world) {
    if (world->work.broad) broad_phase_destroy(world->work.broad);
    if (world->work.patches) kept_patches_destroy(world->work.patches);
    world->work.broad = NULL;
    world->work.patches = NULL;
    ARRAY_FREE(&world->heap, &world->work.kept_patch_bytes);
    ARRAY_FREE(&world->heap, &world->work.pairs.vertex_triangle);
    ARRAY_FREE(&world->heap, &world->work.pairs.edge_edge);
}

tulle_status world_keep_patches(tulle_world *world) {
    world->work.kept_patch_bytes.count = 0;
    if (!world->work.patches) return TULLE_OK;
    size_t const size = kept_patches_save(world->work.patches, NULL);
    if (!ARRAY_RESERVE(&world->heap, &world->work.kept_patch_bytes, size))
        return TULLE_ERROR_OUT_OF_MEMORY;
    world->work.kept_patch_bytes.count =
        kept_patches_save(world->work.patches, world->work.kept_patch_bytes.data);
    return TULLE_OK;
}

/* Patches that cannot be loaded for want of memory are gone, which is safe. */
void world_restore_patches(tulle_world *world) {
    if (!world->work.patches) return;
    (void)kept_patches_load(world->work.patches, world->work.kept_patch_bytes.data,
                            world->work.kept_patch_bytes.count);
}

/* ---- the stages ---- */

/* Ends a stage that may run inside others: adds what passed since `start` [s] to it, and keeps it
 * from the stage around it. */
static tulle_status end_search(step_context *context, stage number, double start,
                               tulle_status status) {
    double const seconds = timer_now() - start;
    context->report->stage_seconds[number] += seconds;
    context->search_seconds += seconds;
    return world_tell_failure(context, status);
}

tulle_status world_update_patches(step_context *context, const double *x1) {
    tulle_world *const world = context->world;
    double const start = timer_now();
    context->source.near_pairs = NULL;
    if (!world->work.patches) return TULLE_OK;
    patch_counts counts = {0};
    patch_step const paths = {&world->model.set, context->state->positions, x1,
                              world->work.threads};
    tulle_status const status =
        update_patches(world->work.patches, &paths, &world->work.patch_rules, &counts);
    tulle_step_report *const report = context->report;
    report->patches = counts.patch_count;
    report->patch_triangles = counts.triangle_count;
    report->patches_certified = counts.star_count + counts.contour_count;
    report->patches_dissolved += counts.dissolved_count;
    memcpy(context->certified_end, x1, 3 * world->model.vertex_count * sizeof(double));
    broad_phase_set_patches(world->work.broad, kept_patches_get_labels(world->work.patches));
    return end_search(context, STAGE_UPDATE_PATCHES, start, status);
}

tulle_status world_build_trees(step_context *context, const double *bounds) {
    tulle_world *const world = context->world;
    double const start = timer_now();
    context->search_mark = arena_get_mark(&world->work.scratch); /* find_pairs releases it */
    tulle_status const status =
        build_trees(world->work.broad, &world->model.set, context->state->positions, bounds,
                    context->source.margin, world->work.threads);
    context->source.is_straight = broad_phase_is_straight(world->work.broad);
    if (status != TULLE_OK) arena_release(&world->work.scratch, context->search_mark);
    return end_search(context, STAGE_BUILD_TREES, start, status);
}

tulle_status world_find_pairs(step_context *context, const double *bounds) {
    tulle_world *const world = context->world;
    pair_source *const source = &context->source;
    double const start = timer_now();
    search_counts counts;
    tulle_status const status =
        find_pairs(world->work.broad, &world->model.set, world->work.threads, PAIRS_UNSORTED,
                   &world->work.pairs, &counts);
    if (status == TULLE_OK && world->work.patches)
        kept_patches_tell_search(world->work.patches, counts.leaf_pair_count,
                                 counts.near_pair_count);
    arena_release(&world->work.scratch, context->search_mark);
    if (end_search(context, STAGE_FIND_PAIRS, start, status) != TULLE_OK) return status;
    context->report->pair_searches++;
    context->report->box_pairs +=
        world->work.pairs.vertex_triangle.count + world->work.pairs.edge_edge.count;
    source->pairs = &world->work.pairs;
    source->bounds = context->bounds;
    if (bounds != context->bounds)
        memcpy(context->bounds, bounds, 3 * world->model.vertex_count * sizeof(double));
    return TULLE_OK;
}

/* Patches and pairs of x0 -> x1 with the trees of x0 -> bounds. */
static tulle_status search_again(step_context *context, const double *x1, const double *bounds) {
    tulle_status status = world_update_patches(context, x1);
    if (status == TULLE_OK) status = world_build_trees(context, bounds);
    if (status == TULLE_OK) status = world_find_pairs(context, bounds);
    return status;
}

static tulle_status renew_pairs(pair_source *source, const double *x1) {
    return search_again(source->context, x1, x1);
}

/* Takes pairs again that patches left out and that are not proven for x0 -> x1. The boxes stay
 * those of the paths that the pairs were found for, so they leave out the same as before. */
static tulle_status adapt_pairs(pair_source *source, const double *x1) {
    step_context *const context = source->context;
    const tulle_world *const world = context->world;
    if (!world->work.patches) return TULLE_OK;
    double const start = timer_now();
    /* The patches are proven for x0 -> x1 too where no vertex of a cloth ends farther from the end
     * that they are certified for than their reach allows; else they are tested anew. */
    patch_rules rules = world->work.patch_rules;
    rules.reach = world->work.hold_reach;
    rules.max_angle = fmax(rules.max_angle, HOLD_ANGLE);
    double const spare = world->work.patch_rules.reach - rules.reach, limit = spare * spare;
    bool is_proven = true;
    for (size_t v = 0; is_proven && v < world->model.cloth_vertex_count; v++) {
        vec3 const moved = vec3_sub(vec3_load(x1, v), vec3_load(context->certified_end, v));
        is_proven = vec3_norm2(moved) <= limit;
    }
    patch_step const paths = {&world->model.set, context->state->positions, x1,
                              world->work.threads};
    is_proven = is_proven || patches_hold(world->work.patches, &paths, &rules);
    (void)end_search(context, STAGE_UPDATE_PATCHES, start, TULLE_OK);
    return is_proven ? TULLE_OK : search_again(context, x1, context->bounds);
}

pair_source world_make_pair_source(step_context *context) {
    const tulle_world *const world = context->world;
    return (pair_source){.margin = world->model.separation_distance +
                                   PAIR_MARGIN_EDGE_SHARE * world->model.edge_length,
                         .renew = renew_pairs,
                         .adapt = adapt_pairs,
                         .context = context};
}
