/* stage.h - what the worlds of several experiments are made of. */
#ifndef TULLE_TEST_STAGE_H
#define TULLE_TEST_STAGE_H

#include "validation/validation.h"

/* A level rectangle of counts[0] x counts[1] vertices. */
typedef struct stage_sheet {
    double size[2]; /* [m] along x and y */
    uint32_t counts[2];
    double middle[3]; /* [m] */
} stage_sheet;
tulle_mesh *stage_make_sheet(validation_run *run, stage_sheet sheet);

/* Moves all vertices. */
void stage_move(tulle_mesh *mesh, double x, double y, double z);

/* Cotton without air damping, which closed forms do not know. */
tulle_cloth_def stage_cloth_def(const tulle_mesh *mesh);

/* A default world of woven cloth. */
tulle_world *stage_make_woven_world(validation_run *run);

/* The preset of that name. */
tulle_material stage_take_fabric(validation_run *run, const char *name);

/* An obstacle that stands still. */
tulle_obstacle_id stage_add_obstacle(validation_run *run, tulle_world *world,
                                     const tulle_mesh *mesh, double friction);

/* Key at `time` [s] that moves by (x, y, z) [m] without turning. */
tulle_keyframe stage_key(double time, double x, double y, double z);

#endif
