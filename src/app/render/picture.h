/* app/render/picture.h - makes the picture of one frame of a run. */
#ifndef TULLE_APP_RENDER_PICTURE_H
#define TULLE_APP_RENDER_PICTURE_H

#include "app/check/subdivided_check.h"
#include "app/render/explain.h"
#include "app/render/run.h"

enum { PICTURE_DIGEST_SIZE = 20 /* [bytes] of a digest's text */ };

/* What pictures of a run have in common. */
typedef struct picture_maker {
    memory heap;
    picture_run *run;
    picture_explanation explanation;
    render_context *context;
    scene_camera asked; /* of the camera; set by picture_choose_side (sight.h) */
    float *radiance;
    render_image image;       /* the last one made */
    render_surface *surfaces; /* of the frame prepared last */
    size_t surface_count;
    render_frame_def def;                /* of the frame prepared last */
    tulle_check_body *drawn, *simulated; /* bodies of the frame, for the judge */
    const char **names;
    subdivided_totals subdivided;
} picture_maker;

tulle_status picture_maker_open(picture_maker *maker, picture_run *run, tulle_error *error);
void picture_maker_close(picture_maker *maker);

/* Reads the frame and prepares all that decides its picture; `share` 0 .. 1 is its place in the
 * film. digest: a text that is the same for the same picture. A subdivided frame is judged, too. */
tulle_status picture_prepare(picture_maker *maker, uint32_t frame, double share,
                             char digest[PICTURE_DIGEST_SIZE], tulle_error *error);
/* Traces the frame prepared last into maker->image. */
tulle_status picture_trace(picture_maker *maker, tulle_error *error);
/* Writes maker->image with its digest. */
tulle_status picture_write(const picture_maker *maker, const char *path, const char *digest,
                           tulle_error *error);
/* Whether the file is a picture with this digest; then it is read into maker->image. */
bool picture_read_again(picture_maker *maker, const char *path, const char *digest);

#endif
