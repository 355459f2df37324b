/* render/png_write.c - PNG files from pictures: encoded in memory first, so a file appears whole or
 * not at all. Nothing of the moment goes in (no time, no name of the machine): the same picture and
 * notes give the same bytes with the same libpng and zlib. */
#include "base/error.h"
#include "render/image.h"

#include "tulle_io/mesh_files.h"

#include <png.h>
#include <string.h>

enum { COMPRESSION_LEVEL = 9, KEY_MAX = 79 /* [bytes] by the format */ };

/* The file so far; libpng's errors come back through its jump buffer. */
typedef struct encoder {
    memory heap;
    ARRAY(uint8_t) bytes;
    png_structp png;
    png_infop info;
    bool is_short_of_memory;
    char message[200]; /* libpng's words */
} encoder;

static void append_bytes(png_structp png, png_bytep bytes, size_t count) {
    encoder *const out = png_get_io_ptr(png);
    if (!ARRAY_RESERVE(&out->heap, &out->bytes, count)) {
        out->is_short_of_memory = true;
        png_error(png, "no memory");
    }
    memcpy(out->bytes.data + out->bytes.count, bytes, count);
    out->bytes.count += count;
}

static void flush_nothing(png_structp png) { (void)png; }

static void keep_message(png_structp png, png_const_charp message) {
    encoder *const out = png_get_error_ptr(png);
    strncpy(out->message, message, sizeof out->message - 1);
    png_longjmp(png, 1);
}

static void ignore_warning(png_structp png, png_const_charp message) { (void)png, (void)message; }

static void write_notes(encoder *out, const render_note *notes, size_t note_count) {
    for (size_t i = 0; i < note_count; i++) {
        /* libpng only reads what these point to. */
        png_text text = {.compression = PNG_TEXT_COMPRESSION_NONE,
                         .key = (char *)(uintptr_t)notes[i].key,
                         .text = (char *)(uintptr_t)notes[i].text,
                         .text_length = strlen(notes[i].text)};
        png_set_text(out->png, out->info, &text, 1);
    }
}

static bool encode(encoder *out, const render_image *image, const render_note *notes,
                   size_t note_count) {
    if (setjmp(png_jmpbuf(out->png))) return false;
    png_set_write_fn(out->png, out, append_bytes, flush_nothing);
    png_set_user_limits(out->png, RENDER_IMAGE_SIDE_MAX, RENDER_IMAGE_SIDE_MAX);
    png_set_IHDR(out->png, out->info, image->width, image->height, 8, PNG_COLOR_TYPE_RGB,
                 PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_set_sRGB(out->png, out->info, PNG_sRGB_INTENT_PERCEPTUAL);
    png_set_compression_level(out->png, COMPRESSION_LEVEL);
    png_set_filter(out->png, PNG_FILTER_TYPE_BASE, PNG_ALL_FILTERS);
    write_notes(out, notes, note_count);
    png_write_info(out->png, out->info);
    for (size_t y = 0; y < image->height; y++)
        png_write_row(out->png, image->pixels + 3 * y * image->width);
    png_write_end(out->png, out->info);
    return true;
}

static tulle_status check(const char *path, const render_image *image, const render_note *notes,
                          size_t note_count, tulle_error *error) {
    if (!image->pixels || image->width < 1 || image->height < 1)
        return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, path, 0, 0,
                            "an empty picture cannot be written");
    for (size_t i = 0; i < note_count; i++)
        if (strlen(notes[i].key) < 1 || strlen(notes[i].key) > KEY_MAX)
            return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, path, 0, 0,
                                "the key of a note has 1 to %d characters, not \"%s\"", KEY_MAX,
                                notes[i].key);
    return TULLE_OK;
}

tulle_status render_image_write_png(const char *path, const render_image *image,
                                    const render_note *notes, size_t note_count,
                                    tulle_error *error) {
    tulle_status status = check(path, image, notes, note_count, error);
    if (status != TULLE_OK) return status;
    encoder out = {.heap = memory_default()};
    out.png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &out, keep_message, ignore_warning);
    if (out.png) out.info = png_create_info_struct(out.png);
    out.is_short_of_memory = !out.info;
    if (out.info && encode(&out, image, notes, note_count))
        status = tulle_file_write(path, out.bytes.data, out.bytes.count, error);
    else if (out.is_short_of_memory)
        status = error_set_at(error, TULLE_ERROR_OUT_OF_MEMORY, path, 0, 0,
                              "no memory to write a picture of %ux%u", image->width, image->height);
    else /* the picture and the notes are sound, so libpng lacks memory too */
        status = error_set_at(error, TULLE_ERROR_OUT_OF_MEMORY, path, 0, 0,
                              "the picture cannot be encoded: %s", out.message);
    png_destroy_write_struct(&out.png, &out.info);
    ARRAY_FREE(&out.heap, &out.bytes);
    return status;
}
