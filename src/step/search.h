/* step/search.h - stages 2 to 4 of a world: patches, trees and the candidate pairs that contact
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
 * docs/method/update_patches.md. Without the certificate both depend on patches. */
#ifndef TULLE_STEP_SEARCH_H
#define TULLE_STEP_SEARCH_H

#include "step/step_context.h"

/* The most candidates that a search lists. If there are more, paths are too long for a substep, or
 * meshes too fine. */
#define MOST_CANDIDATES(model) (256 * (uint64_t)(model)->vertex_count + (1 << 20))

/* Source of the candidates of a substep; context->bounds and context->certified_end have room. */
pair_source step_make_pair_source(step_context *context);

#endif
