/* contact/commit/commit_safely.c - stage 9, see commit_safely.h.
 *
 * Only paths that passed a test of all candidates are accepted. If those of stage 8 are not clean,
 * three rescues follow in this order: impact zones; component scaling; one factor for the whole
 * scene, obstacles included, which shortens time. Below every time of impact a common factor leaves
 * only parts of paths that were tested, so the last rescue passes unless a pair starts at its gap.
 *
 * Based on: Provot 1997; Bridson, Fedkiw, Anderson 2002; Harmon, Vouga, Tamstorf, Grinspun, Robust
 * treatment of simultaneous collisions, 2008. Departure: Wong and Baciu stop single particles at
 * their own times, which takes their neighbours' paths into new intersections. Here connected
 * components stop together, and the result is tested again. */
#include "contact/commit/commit_safely.h"

#include "contact/commit/impact_zones.h"
#include "contact/commit/scale_components.h"
#include "contact/pairs/body_paths.h"
#include "contact/pairs/pair_rules.h"
#include "contact/pairs/path_test.h"

#include <string.h>

/* A smaller part of the time step is no progress: the scene is blocked. */
static const double MINIMUM_FRACTION = 1e-6;
/* Part of the smallest time of impact that the whole scene goes. */
static const double PART_OF_TIME = 0.9;
/* From this component round on, components that are hit stop where they are. */
enum { STOP_ROUND = 8 };

typedef struct commit_work {
    const contact_scene *scene;
    pair_source *source;
    double *u, *x1;
    commit_report *report;
    bool is_clean;
} commit_work;

/* Tests all candidates on the present paths. The hits stay in scratch. */
static tulle_status test_all(commit_work *work, pair_events *hits) {
    *hits = (pair_events){0};
    tulle_status status = ensure_pairs_cover(work->scene, work->source, work->x1);
    if (status != TULLE_OK) return status;
    status = find_hits(work->scene, work->source, work->x1, NULL, hits);
    work->report->tested_pairs += hits->measured_count;
    work->report->turning_pairs += hits->turning_count;
    work->is_clean = status == TULLE_OK && hits->count == 0;
    return status;
}

/* First: cloth vertices that keep hitting one another move as rigid bodies. */
static tulle_status run_zone_rounds(commit_work *work) {
    const contact_scene *const scene = work->scene;
    size_t const count = scene->cloth_vertex_count;
    impact_zones zones = {.is_held = ARENA_NEW_ZEROED(scene->scratch, bool, count)};
    if (!zones.is_held || !vertex_groups_make(&zones.groups, scene->scratch, count))
        return TULLE_ERROR_OUT_OF_MEMORY;
    for (int round = 0; round < scene->settings.zone_rounds; round++) {
        arena_mark const mark = arena_get_mark(scene->scratch);
        pair_events hits;
        tulle_status status = test_all(work, &hits);
        if (status == TULLE_OK && !work->is_clean)
            status = project_impact_zones(scene, &zones, &hits, work->u, work->x1,
                                          &work->report->impact_zones);
        arena_release(scene->scratch, mark);
        if (status != TULLE_OK || work->is_clean) return status;
    }
    return TULLE_OK;
}

/* Second: connected components go a part of their way. */
static tulle_status run_component_rounds(commit_work *work) {
    const contact_scene *const scene = work->scene;
    scaled_components components;
    if (!scaled_components_make(&components, scene, work->x1, work->u))
        return TULLE_ERROR_OUT_OF_MEMORY;
    for (int round = 0;; round++) {
        arena_mark const mark = arena_get_mark(scene->scratch);
        pair_events hits;
        tulle_status const status = test_all(work, &hits);
        size_t scaled_count = 0;
        if (status == TULLE_OK && !work->is_clean && round < scene->settings.component_rounds)
            scaled_count =
                scale_components(scene, &components, &hits, round >= STOP_ROUND, work->u, work->x1);
        work->report->component_scalings += scaled_count;
        arena_release(scene->scratch, mark);
        if (status != TULLE_OK || scaled_count == 0) return status;
    }
}

/* Last: the whole scene goes a part of its way. */
static tulle_status shorten_time(commit_work *work) {
    const contact_scene *const scene = work->scene;
    commit_report *const report = work->report;
    size_t const size = 3 * scene->vertex_count;
    double *const base = ARENA_NEW(scene->scratch, double, size);
    if (!base) return TULLE_ERROR_OUT_OF_MEMORY;
    memcpy(base, work->x1, size * sizeof(double));
    for (;;) {
        arena_mark const mark = arena_get_mark(scene->scratch);
        pair_events hits;
        tulle_status const status = test_all(work, &hits);
        if (status == TULLE_OK && !work->is_clean) {
            /* the earliest hit is named as the cause of a block */
            const pair_event *earliest = &hits.events[0];
            for (size_t i = 1; i < hits.count; i++)
                if (hits.events[i].time < earliest->time) earliest = &hits.events[i];
            report->fraction *= PART_OF_TIME * earliest->time;
            report->outcome = COMMIT_SHORTENED;
            report->global_scalings++;
            report->has_blocking = true;
            report->blocking_kind = earliest->kind;
            report->blocking_pair = earliest->pair;
        }
        arena_release(scene->scratch, mark);
        if (status != TULLE_OK || work->is_clean) return status;
        if (!(report->fraction >= MINIMUM_FRACTION)) break;
        /* x1 = x0 + fraction (base - x0); vertices that stand still keep their bits, the sign of a
         * zero included; bodies go the first part of their paths */
        for (size_t i = 0; i < size; i++)
            if (base[i] != scene->x0[i])
                work->x1[i] = scene->x0[i] + report->fraction * (base[i] - scene->x0[i]);
            else
                work->x1[i] = scene->x0[i];
        place_bodies(scene, work->u, report->fraction, work->x1);
    }
    report->outcome = COMMIT_BLOCKED;
    report->fraction = 0.0;
    memcpy(work->x1, scene->x0, size * sizeof(double));
    return TULLE_OK;
}

tulle_status commit_safely(const contact_scene *scene, pair_source *source, bool is_clean,
                           double *u, double *x1, commit_report *report) {
    *report = (commit_report){.outcome = COMMIT_CLEAN, .fraction = 1.0, .smallest_gap = INFINITY};
    commit_work work = {scene, source, u, x1, report, is_clean};
    arena_mark const mark = arena_get_mark(scene->scratch);
    tulle_status status = TULLE_OK;
    if (!work.is_clean) status = run_zone_rounds(&work);
    if (status == TULLE_OK && !work.is_clean) status = run_component_rounds(&work);
    if (status == TULLE_OK && !work.is_clean) status = shorten_time(&work);
    if (status == TULLE_OK) {
        smallest_gap smallest;
        status = find_smallest_gap(scene, source, x1, scene->largest_separation, &smallest);
        report->smallest_gap = smallest.distance;
        report->smallest_kind = smallest.kind;
        report->smallest_pair = smallest.pair;
    }
    arena_release(scene->scratch, mark);
    return status;
}
