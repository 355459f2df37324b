/* app/mend/colors.h - departures as colours: binary PLY files of the mended cloth whose vertices
 * have red, green, blue and the departure. */
#ifndef TULLE_APP_MEND_COLORS_H
#define TULLE_APP_MEND_COLORS_H

#include "tulle/base.h"

/* Writes `path`, whole or not at all; `departures` by vertex. Colours go from light grey, 0, over
 * yellow to dark red, `largest` > 0. Errors: TULLE_ERROR_IO, TULLE_ERROR_DISK_FULL. */
tulle_status mend_colors_write(const char *path, tulle_mesh_view mesh, const double *departures,
                               double largest, tulle_error *error);

#endif
