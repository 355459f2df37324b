/* app/mend/bodies.h - the bodies as the cloth met them, in a folder: --bodies-out. A body that was
 * never held back is copied byte for byte, and so are those of numbered meshes that were not. */
#ifndef TULLE_APP_MEND_BODIES_H
#define TULLE_APP_MEND_BODIES_H

#include "app/mend/follow.h"
#include "app/mend/names.h"
#include "app/mend/output.h"

typedef struct mend_bodies {
    mend_input *input;
    const char *folder;
    bool made_folder;
    char (*paths)[NUMBERED_PATH_SIZE]; /* of each surface; of numbered meshes unused */
    bool *was_held;                    /* each surface */
    mend_output *outputs;              /* of each surface that is not copied */
} mend_bodies;

/* Makes the folder if there is none, looks whether all may be written there, and adds the files to
 * `names`. Release with mend_bodies_close, also after a failure; it removes a folder that it made
 * and is empty. */
tulle_status mend_bodies_open(mend_input *input, const char *folder, mend_names *names,
                              mend_bodies *bodies, tulle_error *error);
void mend_bodies_close(mend_bodies *bodies);

/* Takes notice of a frame: all vertices as they are given and as the cloth met them. */
void mend_bodies_add(mend_bodies *bodies, const double *given, const double *met);
/* Whether rounding to the floats of their files leads bodies through the cloth in a frame. Errors:
 * TULLE_ERROR_LIMIT. */
tulle_status mend_bodies_judge_rounding(const mend_bodies *bodies, const mend_store *store,
                                        mend_follow *follow, tulle_error *error);
/* Writes all from the frames in the store. */
tulle_status mend_bodies_write(mend_bodies *bodies, const mend_store *store, tulle_error *error);

#endif
