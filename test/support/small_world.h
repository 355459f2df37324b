/* support/small_world.h - small worlds for tests: one cloth over one obstacle, judged exactly. */
#ifndef TULLE_TEST_SMALL_WORLD_H
#define TULLE_TEST_SMALL_WORLD_H

#include "tulle/tulle.h"

/* A rectangle of side x side metres with n x n vertices at height z. Release with
 * tulle_mesh_destroy. */
tulle_mesh small_sheet(double side, unsigned n, double z);
/* A generated shape moved by (x, y, z). */
tulle_mesh small_shape(tulle_shape_def def, double x, double y, double z);

/* Adds cloth or obstacle with default defs; fails the test on an error. */
tulle_cloth_id small_add_cloth(tulle_world *world, const tulle_mesh *mesh);
tulle_obstacle_id small_add_obstacle(tulle_world *world, const tulle_mesh *mesh);

/* Pairs that intersect now, by the exact judge, between all given cloths and present obstacles. */
size_t small_judge(const tulle_world *world, const tulle_mesh *cloths, size_t cloth_count,
                   const tulle_mesh *obstacles, size_t obstacle_count);

#endif
