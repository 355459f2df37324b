/* render/image.h - pictures of 8 bits a channel, and PNG files of them. */
#ifndef TULLE_RENDER_IMAGE_H
#define TULLE_RENDER_IMAGE_H

#include "base/memory.h"

#include "tulle/base.h"

enum { RENDER_IMAGE_SIDE_MAX = 16384 }; /* [pixels] of the width and of the height */

/* sRGB, 3 bytes a pixel, rows from the top. A zeroed struct is an empty picture. */
typedef struct render_image {
    uint8_t *pixels; /* 3 * width * height */
    uint32_t width, height;
} render_image;

/* Text kept in a PNG file (tEXt); both Latin-1. */
typedef struct render_note {
    const char *key, *text;
} render_note;

/* Makes a black picture. Errors: TULLE_ERROR_LIMIT (a side of 0 or beyond RENDER_IMAGE_SIDE_MAX),
 * TULLE_ERROR_OUT_OF_MEMORY. */
tulle_status render_image_create(uint32_t width, uint32_t height, render_image *image,
                                 tulle_error *error);
void render_image_destroy(render_image *image);

/* Writes a PNG file, whole or not at all. The same picture and notes give the same bytes. */
tulle_status render_image_write_png(const char *path, const render_image *image,
                                    const render_note *notes, size_t note_count,
                                    tulle_error *error);
/* Reads an 8-bit RGB PNG file as this program writes it, and the text of one note (empty when the
 * file has none). note may be null. */
tulle_status render_image_read_png(const char *path, render_image *image, const char *note_key,
                                   char *note, size_t note_size, tulle_error *error);

#endif
