/* app/render/film.h - films of pictures, encoded by the program ffmpeg, which gets them through a
 * pipe. */
#ifndef TULLE_APP_RENDER_FILM_H
#define TULLE_APP_RENDER_FILM_H

#include "render/image.h"

typedef struct film_format film_format;

/* The format that the path's extension (.mp4, .webm, .gif) names; null: none. */
const film_format *film_find_format(const char *path);

/* Whether ffmpeg is there and can encode the format. Errors: TULLE_ERROR_UNSUPPORTED with what to
 * install, TULLE_ERROR_IO. */
tulle_status film_check(const film_format *format, tulle_error *error);

typedef struct film film;

/* Starts a film. film_close puts it at `path`; until then there is only a temporary file in the
 * same folder. Pictures have width x height pixels; where the format wants even sides, the last
 * column or row is repeated. Errors: TULLE_ERROR_UNSUPPORTED, TULLE_ERROR_IO,
 * TULLE_ERROR_OUT_OF_MEMORY. */
tulle_status film_open(const char *path, uint32_t width, uint32_t height, double frame_rate,
                       film **result, tulle_error *error);
/* On failure the message has what ffmpeg said; discard the film then. */
tulle_status film_add(film *made, const render_image *image, tulle_error *error);
/* Waits for ffmpeg and gives the film its name; releases `made` on failure, too. */
tulle_status film_close(film *made, tulle_error *error);
/* Ends ffmpeg and removes what it wrote; null is fine. */
void film_discard(film *made);

#endif
