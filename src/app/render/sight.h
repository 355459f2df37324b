/* app/render/sight.h - from which side pictures of a run show its cloth. */
#ifndef TULLE_APP_RENDER_SIGHT_H
#define TULLE_APP_RENDER_SIGHT_H

#include "app/render/picture.h"

/* What came of it. */
typedef struct picture_sight {
    bool has_turned; /* the camera looks from another side than by default */
    bool is_unseen;  /* what hides the cloth hides all of it, whatever the side */
    char said[400];  /* about either, for the user; else empty */
} picture_sight;

/* Sets maker->asked to what options and scene ask of the camera. Where they leave its direction
 * open and the default one sees little of the cloth, the direction becomes one that sees more: one
 * for all pictures. Errors: those of the reader and of render_find_sights. */
tulle_status picture_choose_side(picture_maker *maker, picture_sight *sight, tulle_error *error);

#endif
