/* render/png_read.c - pictures from PNG files as png_write.c makes them: 8 bits, RGB. */
#define _POSIX_C_SOURCE 200809L
#include "base/error.h"
#include "render/image.h"

#include <errno.h>
#include <fcntl.h>
#include <png.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { CHUNK_BYTES_MAX = 1 << 20 /* [bytes] of a chunk that is kept, such as a note */ };

typedef struct decoder {
    FILE *file;
    png_structp png;
    png_infop info;
    render_image *image;
    tulle_status status; /* of a failure that has its own message */
    tulle_error *error;
    char message[200]; /* libpng's words */
} decoder;

static void keep_message(png_structp png, png_const_charp message) {
    decoder *const in = png_get_error_ptr(png);
    strncpy(in->message, message, sizeof in->message - 1);
    png_longjmp(png, 1);
}

static void ignore_warning(png_structp png, png_const_charp message) { (void)png, (void)message; }

static bool decode(decoder *in) {
    if (setjmp(png_jmpbuf(in->png))) return false;
    png_init_io(in->png, in->file);
    png_set_user_limits(in->png, RENDER_IMAGE_SIDE_MAX, RENDER_IMAGE_SIDE_MAX);
    png_set_chunk_malloc_max(in->png, CHUNK_BYTES_MAX);
    png_read_info(in->png, in->info);
    uint32_t const width = png_get_image_width(in->png, in->info);
    uint32_t const height = png_get_image_height(in->png, in->info);
    if (png_get_bit_depth(in->png, in->info) != 8 ||
        png_get_color_type(in->png, in->info) != PNG_COLOR_TYPE_RGB ||
        png_get_interlace_type(in->png, in->info) != PNG_INTERLACE_NONE)
        png_error(in->png, "it is not 8-bit RGB, not interlaced");
    in->status = render_image_create(width, height, in->image, in->error);
    if (in->status != TULLE_OK) return false;
    for (size_t y = 0; y < height; y++)
        png_read_row(in->png, in->image->pixels + 3 * y * width, NULL);
    png_read_end(in->png, in->info);
    return true;
}

static void copy_note(const decoder *in, const char *key, char *note, size_t note_size) {
    if (!note || note_size < 1) return;
    note[0] = '\0';
    png_textp texts = NULL;
    int const count = png_get_text(in->png, in->info, &texts, NULL);
    for (int i = 0; key && i < count; i++) {
        if (strcmp(texts[i].key, key) != 0) continue;
        snprintf(note, note_size, "%s", texts[i].text);
        return;
    }
}

static tulle_status fail(const char *path, decoder *in, tulle_error *error) {
    render_image_destroy(in->image);
    if (in->status != TULLE_OK) return in->status;
    if (!in->info)
        return error_set_at(error, TULLE_ERROR_OUT_OF_MEMORY, path, 0, 0,
                            "no memory to read a picture");
    if (ferror(in->file)) return error_set_at(error, TULLE_ERROR_IO, path, 0, 0, "cannot be read");
    return error_set_at(error, TULLE_ERROR_PARSE, path, 0, 0, "this picture cannot be read: %s",
                        in->message);
}

tulle_status render_image_read_png(const char *path, render_image *image, const char *note_key,
                                   char *note, size_t note_size, tulle_error *error) {
    *image = (render_image){0};
    /* Without O_NONBLOCK, opening a pipe that nobody writes to would wait for ever. */
    int const file = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    struct stat facts;
    bool const is_regular = file >= 0 && fstat(file, &facts) == 0 && S_ISREG(facts.st_mode);
    decoder in = {.file = is_regular ? fdopen(file, "rb") : NULL, .image = image, .error = error};
    if (!in.file) {
        error_set_at(error, TULLE_ERROR_IO, path, 0, 0, "cannot be opened: %s",
                     file < 0 || is_regular ? strerror(errno) : "is not a regular file");
        if (file >= 0) close(file);
        return TULLE_ERROR_IO;
    }
    tulle_status status = TULLE_OK;
    in.png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &in, keep_message, ignore_warning);
    if (in.png) in.info = png_create_info_struct(in.png);
    if (in.info && decode(&in))
        copy_note(&in, note_key, note, note_size);
    else
        status = fail(path, &in, error);
    png_destroy_read_struct(&in.png, &in.info, NULL);
    fclose(in.file);
    return status;
}
