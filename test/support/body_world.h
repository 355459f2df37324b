/* support/body_world.h - worlds with rigid bodies for tests. */
#ifndef TULLE_TEST_BODY_WORLD_H
#define TULLE_TEST_BODY_WORLD_H

#include "support/small_world.h"

#include <stdbool.h>

#define BODIES_STEP (1.0 / 90.0)

/* A world; with a little sheet far off, all of it pinned, where a test has no cloth of its own: its
 * mean edge gives a contact distance of 5 mm unless the def has another. */
tulle_world *bodies_make_world(const tulle_world_def *def, bool has_far_cloth);
/* Meshes with their centres at a place. */
tulle_mesh bodies_make_box(double x, double y, double z, const double at[3]);
tulle_mesh bodies_make_ball(double radius, unsigned resolution, const double at[3]);
/* Turns a mesh about the y axis [rad]. */
void bodies_rotate_mesh(tulle_mesh *mesh, double angle);

/* An obstacle, a body where `body` is given. These fail the test on an error. */
tulle_obstacle_id bodies_add_obstacle(tulle_world *world, const tulle_mesh *mesh, double friction,
                                      const tulle_body *body);
/* Square cloth of cotton without air damping, as small_sheet makes it. */
tulle_cloth_id bodies_add_cloth(tulle_world *world, const tulle_mesh *mesh, double area_density,
                                int has_pinned_corners);
/* Pairs of triangles that intersect now, of everything with everything, by the exact judge: cloths
 * 0 .. cloth_count - 1 and obstacles 0 .. obstacle_count - 1. */
size_t bodies_judge(const tulle_world *world, const tulle_mesh *cloths, size_t cloth_count,
                    const tulle_mesh *obstacles, size_t obstacle_count);
tulle_step_report bodies_step(tulle_world *world);
tulle_step_report bodies_step_by(tulle_world *world, double time_step);
tulle_transform bodies_get_transform(const tulle_world *world, tulle_obstacle_id id);

#endif
