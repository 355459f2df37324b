/* app/convert/repair.h - --repair: makes what is read a mesh that can be cloth, and says what was
 * done. */
#ifndef TULLE_APP_CONVERT_REPAIR_H
#define TULLE_APP_CONVERT_REPAIR_H

#include "app/convert/source.h"

typedef struct convert_repair {
    tulle_mesh_repairs done;
    bool is_cloth;
    char reason[sizeof((tulle_error *)0)->message]; /* why it cannot be cloth after all */
    size_t pairs_before, pairs_after;               /* of triangles that intersect */
    bool is_judged;                                 /* false: too many pairs, or no memory */
} convert_repair;

/* Repairs the one frame that is read; from then on it is the mesh of the source. tolerance: [unit
 * of the source] */
tulle_status convert_repair_source(convert_source *source, frame_range frames, double tolerance,
                                   convert_repair *repair, tulle_error *error);
/* Prints the lines of the report. */
void convert_repair_print(const convert_repair *repair);

#endif
