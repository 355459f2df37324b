/* world/detection.h - stages 5 to 7 of a world: patches, trees and the candidate pairs that contact
 * tests, and what of them lives from step to step.
 *
 * Pairs within a patch are left out of the candidates. A patch is certified for the paths that the
 * candidates are found for, with half the largest separation distance as its reach: two of its
 * features that share no vertex stay farther apart than any contact reaches. So stage 2 makes the
 * same rows with patches as without. Other paths need the candidates renewed when a patch is not
 * certified for them too; stages 10 and 11 ask for each, see contact/contact_paths.h. Hence states
 * do not depend on patches (unless the certificate is off), only the time that it takes does. */
#ifndef TULLE_WORLD_DETECTION_H
#define TULLE_WORLD_DETECTION_H

#include "world/step.h"

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
