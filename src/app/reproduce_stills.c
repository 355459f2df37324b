/* app/reproduce_stills.c - Figs. 8 and 9 and the stills of Fig. 6: three pictures of each run, by
 * `tulle render`. */
#define _POSIX_C_SOURCE 200809L
#include "app/cli/interrupt.h"
#include "app/cli/whole_file.h"
#include "app/commands.h"
#include "app/render/options.h"
#include "app/reproduce.h"
#include "render/render.h"

#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

enum { ARGUMENTS_MAX = 16, PNG_HEAD_SIZE = 24, PNG_WIDTH = 16, PNG_END_SIZE = 12 /* [bytes] */ };

bool reproduce_find_stills(const reproduce *self, const reproduce_run *run,
                           uint32_t frames[REPRODUCE_STILLS]) {
    char path[REPRODUCE_PATH_SIZE];
    reproduce_find_run(self, run, path);
    tulle_run_reader *reader = NULL;
    if (!tulle_run_is_directory(path) || tulle_run_reader_open(path, &reader, NULL) != TULLE_OK)
        return false;
    uint32_t const count = tulle_run_reader_get_info(reader)->frame_count;
    tulle_run_reader_close(reader);
    if (count == 0) return false;
    const double *const places = reproduce_find_still_places(run->scene);
    for (int i = 0; i < REPRODUCE_STILLS; i++) {
        uint32_t const least = i > 0 && frames[i - 1] + 1 < count ? frames[i - 1] + 1 : 0;
        uint32_t const frame = (uint32_t)(places[i] * (double)(count - 1) + 0.5);
        frames[i] = frame > least ? frame : least;
    }
    return true;
}

void reproduce_name_still(const reproduce_run *run, uint32_t frame,
                          char file[REPRODUCE_PATH_SIZE]) {
    char name[REPRODUCE_PATH_SIZE];
    reproduce_name_run(run, name);
    snprintf(file, REPRODUCE_PATH_SIZE, "stills/%.*s_%04u.png", REPRODUCE_PATH_SIZE / 2, name,
             (unsigned)frame);
}

bool reproduce_is_whole_picture(const char *bytes, size_t count) {
    static const unsigned char end[PNG_END_SIZE] = {0,   0,   0,    0,    'I',  'E',
                                                    'N', 'D', 0xae, 0x42, 0x60, 0x82};
    return count >= PNG_HEAD_SIZE + PNG_END_SIZE && memcmp(bytes, "\x89PNG\r\n\x1a\n", 8) == 0 &&
           memcmp(bytes + count - PNG_END_SIZE, end, PNG_END_SIZE) == 0;
}

/* Whether the file is a whole PNG of this size: width and height stand in its first chunk. */
static bool has_size(const char *picture, uint32_t width, uint32_t height) {
    char *bytes = NULL;
    size_t count = 0;
    if (whole_file_read(picture, &bytes, &count, NULL) != TULLE_OK) return false;
    bool const is_whole = reproduce_is_whole_picture(bytes, count);
    unsigned char size[8] = {0};
    if (is_whole) memcpy(size, bytes + PNG_WIDTH, sizeof size);
    free(bytes);
    const unsigned char *const w = size, *const h = size + 4;
    return is_whole && width == ((uint32_t)w[0] << 24 | w[1] << 16 | w[2] << 8 | w[3]) &&
           height == ((uint32_t)h[0] << 24 | h[1] << 16 | h[2] << 8 | h[3]);
}

/* Whether the picture is there, of the size that is asked for and younger than the run's frames. */
static bool is_fresh(const reproduce *self, const reproduce_run *run, const char *picture) {
    char name[REPRODUCE_PATH_SIZE], frames[REPRODUCE_PATH_SIZE];
    struct stat picture_facts, frames_facts;
    uint32_t width = 0, height = 0;
    reproduce_name_run(run, name);
    reproduce_make_path(self, frames, "runs/%s/frames.csv", name);
    return picture_read_size(self->still_size, &width, &height, NULL) == TULLE_OK &&
           has_size(picture, width, height) && stat(picture, &picture_facts) == 0 &&
           stat(frames, &frames_facts) == 0 && picture_facts.st_mtime >= frames_facts.st_mtime;
}

static int render(const reproduce *self, char *run_path, char *picture, uint32_t frame) {
    char frame_text[16], thread_text[16];
    snprintf(frame_text, sizeof frame_text, "%u", (unsigned)frame);
    snprintf(thread_text, sizeof thread_text, "%d", self->threads);
    const char *words[ARGUMENTS_MAX] = {
        "render",     run_path, "--frame",        frame_text,  "-o",
        picture,      "--size", self->still_size, "--samples", self->is_quick ? "8" : "32",
        "--progress", "none"};
    int count = 12;
    if (self->threads > 0) {
        words[count++] = "--threads";
        words[count++] = thread_text;
    }
    char *arguments[ARGUMENTS_MAX];
    memcpy(arguments, words, sizeof words);
    return app_render(count, arguments);
}

int reproduce_stills(reproduce *self, const reproduce_figure *figure) {
    if (!render_is_available()) {
        if (!self->has_told_pictures)
            app_print_message("reproduce", "no stills are made: this program was built without "
                                           "Embree, the ray tracer (Debian's package is "
                                           "libembree-dev)");
        self->has_told_pictures = self->is_lacking = true;
        return APP_EXIT_FINE;
    }
    size_t const count = figure->run_count * REPRODUCE_STILLS;
    reproduce_begin_work(self);
    for (size_t i = 0; i < count; i++) {
        const reproduce_run *const run = &figure->runs[i / REPRODUCE_STILLS];
        uint32_t frames[REPRODUCE_STILLS];
        char file[REPRODUCE_PATH_SIZE], picture[REPRODUCE_PATH_SIZE], path[REPRODUCE_PATH_SIZE];
        if (!reproduce_find_stills(self, run, frames)) continue;
        reproduce_name_still(run, frames[i % REPRODUCE_STILLS], file);
        reproduce_make_path(self, picture, "%s", file);
        reproduce_find_run(self, run, path);
        if (is_fresh(self, run, picture)) continue;
        int const code = render(self, path, picture, frames[i % REPRODUCE_STILLS]);
        if (code != APP_EXIT_FINE || interrupt_is_pending())
            return code != APP_EXIT_FINE ? code : APP_EXIT_INTERRUPTED;
        reproduce_show_work(self, "stills", i + 1, count);
    }
    reproduce_end_work(self);
    return APP_EXIT_FINE;
}
