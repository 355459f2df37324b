/* app/render/options.c - see options.h. */
#include "app/render/options.h"

#include "app/cli/frame_range.h"
#include "app/cli/progress_bar.h"
#include "app/commands.h"
#include "app/render/film.h"
#include "base/error.h"
#include "render/render.h"
#include "scene/units.h"

#include "tulle/mesh.h"
#include "tulle_io/subdivision.h"

#include <stdlib.h>
#include <string.h>

enum {
    DEFAULT_WIDTH = 640,
    DEFAULT_HEIGHT = 360,
    DEFAULT_SAMPLES = 32,
    SAMPLES_MAX = 65536,
    THREADS_MAX = 256,
    PIXELS_MAX = 1 << 26 /* of a picture: 64 Mi, some 1 GiB while it is made */
};
static const double RATE_MIN = 0.01, RATE_MAX = 1000.0; /* [1/s] of a film */

static const char *const color_names[] = {"material", "patches", "contacts", "gap",
                                          "velocity", "strain",  NULL};

/* The words of the command line. */
typedef struct render_words {
    const char *size, *camera, *color, *rate;
    long samples, levels, threads;
    int has_wire;
} render_words;

tulle_status picture_read_size(const char *text, uint32_t *width, uint32_t *height,
                               tulle_error *error) {
    unsigned long sides[2] = {0, 0};
    const char *at = text;
    bool is_good = true;
    for (int side = 0; side < 2 && is_good; side++) {
        const char *const begin = at;
        for (; *at >= '0' && *at <= '9'; at++)
            if (sides[side] <= RENDER_IMAGE_SIDE_MAX)
                sides[side] = 10 * sides[side] + (unsigned long)(*at - '0');
        is_good = at > begin && *at == (side == 0 ? 'x' : '\0');
        if (side == 0) at += is_good;
    }
    if (!is_good)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "--size: \"%.40s\" should be WIDTHxHEIGHT in pixels, as 640x360", text);
    if (sides[0] < 1 || sides[1] < 1 || sides[0] > RENDER_IMAGE_SIDE_MAX ||
        sides[1] > RENDER_IMAGE_SIDE_MAX || sides[0] * sides[1] > PIXELS_MAX)
        return error_set(error, TULLE_ERROR_LIMIT,
                         "--size: \"%.40s\": each side should be 1 to %d pixels, and both together "
                         "%d million at most",
                         text, RENDER_IMAGE_SIDE_MAX, PIXELS_MAX / 1000000);
    *width = (uint32_t)sides[0];
    *height = (uint32_t)sides[1];
    return TULLE_OK;
}

tulle_status picture_find_kind(const char *path, picture_kind *kind, tulle_error *error) {
    const char *const slash = strrchr(path, '/');
    const char *const base = slash ? slash + 1 : path;
    const char *const point = strrchr(base, '.');
    if (point && point > base && strcmp(point, ".png") == 0)
        *kind = strchr(base, '%') ? PICTURE_SERIES : PICTURE_STILL;
    else if (point && point > base && film_find_format(path))
        *kind = PICTURE_FILM;
    else
        return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, path, 0, 0,
                            "the name should end in .png for a picture, with %%04d before it for "
                            "one a frame, or in .mp4, .webm or .gif for a film");
    return TULLE_OK;
}

static tulle_status read_rate(const char *text, double *rate, tulle_error *error) {
    double value = 0.0;
    if (quantity_read(text, UNIT_RATE, &value) != QUANTITY_READ ||
        !(value >= RATE_MIN && value <= RATE_MAX))
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "--fps: \"%.40s\" should be a number of frames a second from %g to %g",
                         text, RATE_MIN, RATE_MAX);
    *rate = value;
    return TULLE_OK;
}

static tulle_status use_words(const render_words *words, picture_options *options,
                              tulle_error *error) {
    options->samples = (uint32_t)words->samples;
    options->subdivision_levels = (int)words->levels;
    options->threads = (int)words->threads;
    options->has_wire = words->has_wire != 0;
    options->color_name = words->color;
    for (int i = 0; color_names[i]; i++)
        if (strcmp(words->color, color_names[i]) == 0) options->color = (picture_color)i;
    tulle_status status = TULLE_OK;
    if (words->size)
        status = picture_read_size(words->size, &options->width, &options->height, error);
    if (status == TULLE_OK && words->camera)
        status = picture_read_camera(words->camera, &options->camera, error);
    if (status == TULLE_OK && words->rate)
        status = read_rate(words->rate, &options->frame_rate, error);
    return status;
}

options_outcome picture_options_read(int argc, char **argv, picture_options *options) {
    *options =
        (picture_options){.progress = "auto", .width = DEFAULT_WIDTH, .height = DEFAULT_HEIGHT};
    render_words words = {.color = "material", .samples = DEFAULT_SAMPLES};
    const option_spec specs[] = {
        TEXT_OPTION("output", 'o', &options->output, "FILE",
                    "a picture (.png), one a frame (name_%04d.png), or a film (.mp4, .webm, .gif); "
                    "default: RUN.png or RUN.mp4 in this directory"),
        TEXT_OPTION("frame", 'f', &options->frame, "N", "the frame to show (default: the last)"),
        TEXT_OPTION("frames", 'n', &options->frames, "A:B[:STEP]", FRAME_RANGE_HELP),
        TEXT_OPTION("size", 0, &words.size, "WxH", "pixels (default: 640x360)"),
        INTEGER_OPTION("samples", 0, &words.samples, "N", 1, SAMPLES_MAX,
                       "rays of a pixel; four times as many halve the noise (default: 32)"),
        TEXT_OPTION("camera", 0, &words.camera, "KEY=VALUE,...",
                    "position=X,Y,Z or orbit=AZIMUTH,ELEVATION[,DISTANCE]; target=X,Y,Z; "
                    "fov=ANGLE; turn=ANGLE, over a film. Metres; angles as 40deg. Default: the "
                    "scene's, else all in view"),
        INTEGER_OPTION("subdivide", 0, &words.levels, "N", 0, TULLE_SUBDIVISION_LEVELS_MAX,
                       "smooth the cloth: each level makes four triangles of one"),
        FLAG_OPTION("wire", 0, &words.has_wire, "draw the edges of the triangles"),
        CHOICE_OPTION(
            "color", 0, &words.color, "WHAT", color_names,
            "material, patches, contacts, gap (to the nearest surface), velocity or strain"),
        LIST_OPTION("hide", 0, &options->hidden, "NAME",
                    "leave out a body, or all copies of an obstacle; may be repeated"),
        TEXT_OPTION("fps", 0, &words.rate, "RATE",
                    "frames of a film a second (default: as many as run in real time)"),
        INTEGER_OPTION("threads", 't', &words.threads, "N", 1, THREADS_MAX,
                       "threads; the pictures do not depend on it (default: one per processor)"),
        CHOICE_OPTION("progress", 0, &options->progress, "auto|json|none", progress_choices,
                      "how progress is shown on standard error (default: auto)"),
    };
    const command_spec command = COMMAND(
        "render", "RUN", specs, 1, 1,
        "Makes ray traced pictures and films of a run's frames. A film needs ffmpeg. Its\n"
        "frames are kept in NAME.frames until the film is whole: if it is interrupted, "
        "the\nsame command continues. Ctrl-C ends after the present frame, a second Ctrl-C "
        "at\nonce. --color patches, contacts and velocity need `tulle run --record debug`.");
    size_t operand_count = 0;
    options_outcome const outcome = options_parse(&command, argc, argv, &operand_count);
    if (outcome != OPTIONS_READ) return outcome;
    options->directory = argv[0];
    tulle_error error = {0};
    if (use_words(&words, options, &error) == TULLE_OK) return OPTIONS_READ;
    app_print_error("render", &error);
    return OPTIONS_REFUSED;
}
