/* step/search.c - stages 2 to 4 of a world: patches, trees and the candidate pairs that contact
 * tests, and the parts of them that live from step to step.
 *
 * The candidates leave out pairs within one patch. The patches are certified for the paths for
 * which the candidates are found: two features of a patch that share no vertex stay farther apart
 * than the largest separation distance, and than 1.06 of the largest contact distance. Stage 5
 * makes no rows of pairs so far apart.
 *
 * Stages 8 and 9 test other paths. For each they ask whether the patches are certified for it too,
 * beyond 1.06 of the minimum gap. If a patch is not, the candidates are found again, see
 * contact/pairs/contact_paths.h.
 *
 * So with the certificate the promise of the step does not depend on patches. Nor do states, bit
 * for bit, with one exception: a test may call a near miss of two features of one patch a hit if
 * they come together by more than 14 contact distances (350 by default) within a step, see
 * docs/method/update_patches.md. Without the certificate both depend on patches.
 *
 * Based on: Wong, Baciu, Dynamic interaction between deformable surfaces and nonsmooth objects,
 * 2005, section 3. Departures: a patch is skipped only when it is proven not to touch itself, and
 * patches live from step to step; docs/method/update_patches.md. */
#include "base/timer.h"
#include "detect/impact/time_of_impact.h"
#include "step/step_context.h"

#include <math.h>
#include <string.h>

/* Boxes are widened by this share of the mean edge beyond the separation distance, so that paths
 * which the solve bends a little stay inside the candidates that were found for the predicted ones.
 */
static const double PAIR_MARGIN_EDGE_SHARE = 0.05;

/* [rad] 89 degrees: the angle of a patch's cone for other paths than those it was found for. It
 * counts only where patches have no certificate; with one, a kept patch may have any angle. */
static const double HOLD_ANGLE = 1.5533430342749535;

/* ---- the stages ---- */

/* Ends a stage that may run inside others: adds what passed since `start` [s] to it, and keeps it
 * from the stage around it. */
static tulle_status end_search(step_context *context, stage number, double start,
                               tulle_status status) {
    double const seconds = timer_now() - start;
    context->work->report->stage_seconds[number] += seconds;
    context->search_seconds += seconds;
    return step_narrow(status);
}

tulle_status step_update_patches(step_context *context, const double *x1) {
    double const start = timer_now();
    context->source.near_pairs = NULL;
    if (!context->work->patches) return TULLE_OK;
    patch_counts counts = {0};
    patch_step const paths = {&context->work->set, context->state->positions, x1,
                              context->work->threads};
    tulle_status const status =
        update_patches(context->work->patches, &paths, &context->work->patch_rules, &counts);
    tulle_step_report *const report = context->work->report;
    report->patches = counts.patch_count;
    report->patch_triangles = counts.triangle_count;
    report->patches_certified = counts.star_count + counts.contour_count;
    report->patches_dissolved += counts.dissolved_count;
    memcpy(context->sub->certified_end, x1, 3 * context->model->vertex_count * sizeof(double));
    broad_phase_set_patches(context->work->broad, kept_patches_get_labels(context->work->patches));
    return end_search(context, STAGE_UPDATE_PATCHES, start, status);
}

tulle_status step_build_trees(step_context *context, const double *bounds) {
    double const start = timer_now();
    context->search_mark = arena_get_mark(&context->work->scratch); /* find_pairs releases it */
    tulle_status const status =
        build_trees(context->work->broad, &context->work->set, context->state->positions, bounds,
                    context->source.margin, context->work->threads);
    context->source.is_straight = broad_phase_is_straight(context->work->broad);
    if (status != TULLE_OK) arena_release(&context->work->scratch, context->search_mark);
    return end_search(context, STAGE_BUILD_TREES, start, status);
}

tulle_status step_find_pairs(step_context *context, const double *bounds) {
    pair_source *const source = &context->source;
    double const start = timer_now();
    search_counts counts;
    tulle_status const status =
        find_pairs(context->work->broad, &context->work->set, context->work->threads,
                   PAIRS_UNSORTED, &context->work->pairs, &counts);
    if (status == TULLE_OK && context->work->patches)
        kept_patches_tell_search(context->work->patches, counts.leaf_pair_count,
                                 counts.near_pair_count);
    arena_release(&context->work->scratch, context->search_mark);
    if (end_search(context, STAGE_FIND_PAIRS, start, status) != TULLE_OK) return status;
    context->work->report->pair_searches++;
    context->work->report->box_pairs +=
        context->work->pairs.vertex_triangle.count + context->work->pairs.edge_edge.count;
    source->pairs = &context->work->pairs;
    source->bounds = context->sub->bounds;
    if (bounds != context->sub->bounds)
        memcpy(context->sub->bounds, bounds, 3 * context->model->vertex_count * sizeof(double));
    return TULLE_OK;
}

/* Patches and pairs of x0 -> x1 with the trees of x0 -> bounds. */
static tulle_status search_again(step_context *context, const double *x1, const double *bounds) {
    tulle_status status = step_update_patches(context, x1);
    if (status == TULLE_OK) status = step_build_trees(context, bounds);
    if (status == TULLE_OK) status = step_find_pairs(context, bounds);
    return status;
}

static tulle_status renew_pairs(pair_source *source, const double *x1) {
    return search_again(source->context, x1, x1);
}

/* Adds pairs that patches left out and that are not proven for x0 -> x1. The boxes stay
 * those of the paths that the pairs were found for, so they leave out the same as before. */
static tulle_status adapt_pairs(pair_source *source, const double *x1) {
    step_context *const context = source->context;
    if (!context->work->patches) return TULLE_OK;
    double const start = timer_now();
    /* The patches are proven for x0 -> x1 too where no vertex of a cloth ends farther from the end
     * that they are certified for than their reach allows; else they are tested again. */
    patch_rules rules = context->work->patch_rules;
    rules.reach = context->work->hold_reach;
    rules.max_angle = fmax(rules.max_angle, HOLD_ANGLE);
    double const spare = context->work->patch_rules.reach - rules.reach, limit = spare * spare;
    bool is_proven = true;
    for (size_t v = 0; is_proven && v < context->model->cloth_vertex_count; v++) {
        vec3 const moved = vec3_sub(vec3_load(x1, v), vec3_load(context->sub->certified_end, v));
        is_proven = vec3_norm2(moved) <= limit;
    }
    patch_step const paths = {&context->work->set, context->state->positions, x1,
                              context->work->threads};
    is_proven = is_proven || patches_hold(context->work->patches, &paths, &rules);
    (void)end_search(context, STAGE_UPDATE_PATCHES, start, TULLE_OK);
    return is_proven ? TULLE_OK : search_again(context, x1, context->sub->bounds);
}

pair_source step_make_pair_source(step_context *context) {
    return (pair_source){.margin = context->model->separation_distance +
                                   PAIR_MARGIN_EDGE_SHARE * context->model->edge_length,
                         .renew = renew_pairs,
                         .adapt = adapt_pairs,
                         .context = context};
}
