/* step/carriers.h - the motion of scripted obstacles as affine maps. */
#ifndef TULLE_STEP_CARRIERS_H
#define TULLE_STEP_CARRIERS_H

#include "contact/contact_types.h"
#include "step/motion_state.h"
#include "step/step_model.h"

typedef struct step_work step_work;

typedef struct carrier_work {
    affine_map *maps;        /* per surface, of this substep */
    const affine_map **used; /* per surface; null: it has none */
    affine_map *progress;    /* per obstacle, from the start of the step to where it is */
    affine_map *script;      /* per obstacle, from there to the end of the substep */
} carrier_work;

/* Before the first substep; once targets are set; after a substep is accepted. The maps lie in the
 * scratch arena. */
tulle_status step_begin_carriers(const step_model *model, step_work *work);
void step_compute_carriers(const step_model *model, motion_state *state, step_work *work);
void step_follow_carriers(const step_model *model, step_work *work);

#endif
