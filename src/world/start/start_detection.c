/* world/start/start_detection.c - the start of the search: trees, and the rules of patches. */
#include "detect/impact/time_of_impact.h"
#include "world/start/start.h"

#include <math.h>

/* Patches are certified with this much more than half the separation distance, so that no rounding
 * of a distance tells a candidate from one that was left out. */
static const double REACH_RESERVE = 1.0 + 1e-6;

/* Stages 8 and 9 take patches that are certified for their paths with this share of the reach, or
 * more where the minimum gap asks for it. */
static const double HOLD_REACH_SHARE = 0.25;

tulle_status world_start_detection(tulle_world *world) {
    const tulle_world_detection *const def = &world->model.paper.detection;
    bool const is_paper = def->method == TULLE_DETECT_PAPER;
    broad_phase_method const trees = def->method == TULLE_DETECT_BVOX ? BROAD_PHASE_BVOX
                                     : is_paper                       ? BROAD_PHASE_PAPER
                                                                      : BROAD_PHASE_REFIT;
    tulle_status status = broad_phase_create(&world->heap, &world->work.set, world->model.rest,
                                             trees, &world->work.broad);
    if (status != TULLE_OK) return status;
    broad_phase_configure(world->work.broad,
                          (broad_phase_options){.following = PATHS_WHERE_LONG,
                                                .stop = &world->work.stop,
                                                .most_candidates = MOST_CANDIDATES(&world->model),
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
    return kept_patches_create(&world->heap, &world->work.set, &world->work.scratch,
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
