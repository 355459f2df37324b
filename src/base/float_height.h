/* base/float_height.h - how low a triangle of cloth may be, since files hold floats. */
#ifndef TULLE_BASE_FLOAT_HEIGHT_H
#define TULLE_BASE_FLOAT_HEIGHT_H

/* [of the largest coordinate] Cloth has no lower triangles: four steps of float. It may come as
 * near to itself as a quarter of a triangle's height, and files round by half a step. */
static const double LEAST_HEIGHT = 4.0 * 0x1p-23;

#endif
