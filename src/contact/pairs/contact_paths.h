/* contact/pairs/contact_paths.h - the paths x0 -> x1 of a velocity u, and candidate pairs that are
 * complete for the paths tested.
 *
 * Contract. A source finds its candidates for the paths x0 -> bounds, with boxes widened by
 * margin / 2. They are complete for other paths x0 -> x1 as long as every vertex stays in the box
 * of its own path x0 -> bounds widened by (margin - 1.06 xi) / 2. A straight source has left out
 * pairs that straight paths keep apart: then each vertex must end in the box of its end in `bounds`
 * widened by as much. Stages 8 and 9 check this before every test on which an accepted state rests.
 * They call `renew` when a vertex has left its box, so no such test runs on an incomplete list.
 *
 * Stage 5 notes the pairs that start near each other. Along short paths no other pair can come
 * under xi, so the tests look at those alone (near_pairs.h).
 *
 * A source may leave out pairs that are proven to keep their gap. The proof must hold for the very
 * paths that are tested, not only for those that the pairs were found for. So before every test the
 * source is asked to `adapt` its pairs. */
#ifndef TULLE_CONTACT_PAIRS_CONTACT_PATHS_H
#define TULLE_CONTACT_PAIRS_CONTACT_PATHS_H

#include "contact/contact_types.h"

typedef struct pair_source {
    const pair_list *pairs; /* in any order */
    const double *bounds;   /* [m] 3 * vertex_count, x1 that the pairs were found for */
    bool is_straight;       /* pairs that the paths to `bounds` keep apart were left out; set by
                               renew and adapt */
    double margin;          /* [m] > xi, that the pairs were found with; at least the largest
                               separation_distance for stage 5 */
    /* Pairs that start near each other; null: not known. Stage 5 sets it; renew and adapt reset it
     * where they change the pairs. */
    const near_pair_list *near_pairs;
    /* Finds the candidates of x0 -> x1 with `margin` and sets pairs and bounds (a copy of x1). */
    tulle_status (*renew)(struct pair_source *source, const double *x1);
    /* Called when x1 stays in the bounds, or where pairs beyond the list are not wanted
     * (foresee_impacts). Keeps the bounds. Adds the left-out pairs that are not proven to keep
     * their gap along x0 -> x1. Null: nothing is left out. */
    tulle_status (*adapt)(struct pair_source *source, const double *x1);
    void *context;        /* of renew and adapt */
    uint64_t renew_count; /* renewals so far */
} pair_source;

/* x1 = x0 + h u, or the target where the inverse mass is 0. Vertices of free bodies go where the
 * motion of their body places them, with the lifts that are set. */
void propose_paths(const contact_scene *scene, const double *u, double *x1);

/* Fills u of vertices with inverse mass 0 from their targets: (target - x0) / h. Slots stay. */
void prescribe_motion(const contact_scene *scene, double *u);

/* Whether the source's pairs are complete for x0 -> x1, but for those that it leaves out as proven.
 */
bool paths_stay_in_bounds(const contact_scene *scene, const pair_source *source, const double *x1);

/* Renews the pairs if paths_stay_in_bounds is false, else adapts them. */
tulle_status ensure_pairs_cover(const contact_scene *scene, pair_source *source, const double *x1);

#endif
