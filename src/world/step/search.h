/* world/step/search.h - stages 2 to 4 of a world: patches, trees and the candidate pairs that
 * contact tests, and what of them lives from step to step.
 *
 * Pairs within a patch are left out of the candidates. A patch is certified for the paths that the
 * candidates are found for: two of its features that share no vertex stay farther apart than the
 * largest separation distance, and than 1.06 of the largest contact distance, so farther than stage
 * 5 makes rows for. Other paths need the candidates renewed when a patch is not certified for them
 * too, beyond 1.06 of the minimum gap; stages 8 and 9 ask for each, see
 * contact/pairs/contact_paths.h. With the certificate the promise of the step therefore does not
 * depend on patches. States do not either, bit for bit, but for near misses that a test calls hits:
 * those of two features of one patch that come together by over 14 contact distances (350 by
 * default) within a step, see docs/method/update_patches.md. Without the certificate both depend on
 * them. */
#ifndef TULLE_WORLD_STEP_SEARCH_H
#define TULLE_WORLD_STEP_SEARCH_H

#include "world/step/step.h"

/* Trees and patches of a world whose distances are known. */
tulle_status world_start_detection(tulle_world *world);
void world_release_detection(tulle_world *world);

/* Keeps the patches as they are now, for world_restore_patches: a step that fails leaves none of
 * its changes. */
tulle_status world_keep_patches(tulle_world *world);
void world_restore_patches(tulle_world *world);

/* Source of the candidates of a substep; context->bounds and context->certified_end have room. */
pair_source world_make_pair_source(step_context *context);

#endif
