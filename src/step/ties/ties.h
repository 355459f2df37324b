/* step/ties/ties.h - ties: single vertices of cloth that attachments hold (tulle/attach.h).
 *
 * A rigid tie to a point or to an obstacle on a script leads its vertex, as a pin does. Every other
 * tie is a spring in the solve of stage 7; a rigid tie is stiffer than the cloth around it. */
#ifndef TULLE_STEP_TIES_TIES_H
#define TULLE_STEP_TIES_TIES_H

#include "step/step_work.h"

/* The surface that holds a tie, or TULLE_NONE. */
static inline uint32_t get_tie_surface(const step_model *model, const world_tie *tie) {
    return tie->corners[0] == TULLE_NONE ? TULLE_NONE : model->vertex_surface[tie->corners[0]];
}

/* Fills place and height of a tie of this vertex to the nearest triangle of a surface
 * that does not own the vertex. False if none is within `distance` [m]. */
bool step_find_tie_place(const step_model *model, step_work *work, uint32_t vertex,
                         uint32_t surface, double distance, world_tie *tie);
/* As above, in a given triangle at `weights`. */
void step_set_tie_place(const step_model *model, step_work *work, uint32_t vertex,
                        uint32_t triangle, const double weights[3], world_tie *tie);

/* Stage 1, once targets are set: drops ties to objects that have left the scene, keeps bodies that
 * are tied awake and sets targets of vertices that are led. */
void step_lead_ties(const step_model *model, motion_state *state, step_work *work);
/* Stage 1, once the scene is made: makes rows of springs for stage 7, and fills in the ties of the
 * scene. */
tulle_status step_make_ties(const step_model *model, motion_state *state, step_work *work);
/* Energy balance [J]: energy that springs give from the start to sub.end, and the work of the
 * objects that move their other ends. */
double step_measure_tie_work(step_work *work);
/* Stage 10, while the rows still have the impulses of the solve: measures the forces of all ties;
 * ties with too large a force break. */
tulle_status step_break_ties(const step_model *model, motion_state *state, step_work *work);

#endif
