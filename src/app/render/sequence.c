/* app/render/sequence.c - see sequence.h.
 *
 * Each picture of a series or a film is a file, with a digest of everything that decides it. A file
 * that is there with the wanted digest is not made again. A film is encoded from its files once all
 * are whole; then they are removed. */
#define _POSIX_C_SOURCE 200809L
#include "app/render/sequence.h"

#include "app/cli/interrupt.h"
#include "app/cli/json_text.h"
#include "app/cli/progress_bar.h"
#include "app/render/film.h"
#include "app/render/picture.h"
#include "base/error.h"
#include "base/timer.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static const double LINE_INTERVAL = 10.0; /* [s] between lines where there is no terminal */

/* The work in progress. */
typedef struct sequence {
    picture_maker maker;
    const picture_target *target;
    picture_totals *totals;
    progress_bar bar;
    double shown; /* [s] of the clock: when the last line was shown */
    bool has_json, has_progress;
} sequence;

/* ---- progress ---- */

static void begin_progress(sequence *self, const char *kind) {
    self->has_json = strcmp(kind, "json") == 0;
    self->has_progress = strcmp(kind, "auto") == 0;
    self->bar = progress_bar_begin();
    self->shown = self->bar.begin;
}

static void show_frame(sequence *self, uint32_t done, uint32_t frame, bool is_reused) {
    uint32_t const count = self->totals->frame_count;
    /* Frames that are reused take no time: the pace is that of the others. */
    uint32_t const made = done - self->totals->reused_count;
    double const rest =
        progress_bar_estimate_rest(&self->bar, made, made + (uint64_t)(count - done));
    if (self->has_json) {
        fprintf(stderr,
                "{\"event\":\"frame\",\"frame\":%u,\"done\":%u,\"frames\":%u,\"reused\":%s,"
                "\"rest_seconds\":",
                frame, done, count, is_reused ? "true" : "false");
        json_print_double(stderr, rest);
        fputs("}\n", stderr);
        fflush(stderr);
    }
    if (!self->has_progress || count < 2) return;
    char text[PROGRESS_DURATION_SIZE];
    progress_format_duration(rest, text);
    double const now = timer_now();
    progress_bar_show(&self->bar, done, count, "picture %u/%u  rest %s", done, count, text);
    if (self->bar.is_terminal || now - self->shown < LINE_INTERVAL) return;
    self->shown = now;
    fprintf(stderr, "picture %u/%u  rest %s\n", done, count, text);
}

/* ---- pictures ---- */

static tulle_status make_picture(sequence *self, uint32_t index, const char *path, bool can_reuse,
                                 bool *is_reused, tulle_error *error) {
    picture_maker *const maker = &self->maker;
    char digest[PICTURE_DIGEST_SIZE];
    uint32_t const frame = frame_range_get(maker->run->frames, index);
    /* Of the whole way: 0 for the first; a turn by 360 degrees shows no picture twice. */
    double const share = (double)index / (double)self->totals->frame_count;
    tulle_status status = picture_prepare(maker, frame, share, digest, error);
    if (status != TULLE_OK) return status;
    *is_reused = can_reuse && picture_read_again(maker, path, digest);
    if (*is_reused) {
        self->totals->reused_count++;
        return TULLE_OK;
    }
    double const begin = timer_now();
    status = picture_trace(maker, error);
    self->totals->seconds += timer_now() - begin;
    if (status != TULLE_OK) return status;
    if (interrupt_is_pending()) return TULLE_ERROR_INTERRUPTED;
    status = picture_write(maker, path, digest, error);
    if (status == TULLE_OK) self->totals->made_count++;
    self->totals->is_begun = true;
    return status;
}

static tulle_status make_pictures(sequence *self, tulle_error *error) {
    tulle_status status = TULLE_OK;
    for (uint32_t i = 0; i < self->totals->frame_count && status == TULLE_OK; i++) {
        if (interrupt_is_pending()) return TULLE_ERROR_INTERRUPTED;
        uint32_t const frame = frame_range_get(self->maker.run->frames, i);
        char path[NUMBERED_PATH_SIZE];
        bool is_reused = false;
        bool const is_still = self->target->kind == PICTURE_STILL;
        if (is_still)
            memcpy(path, self->target->path, sizeof path);
        else if (!name_pattern_format(&self->target->names, frame, path))
            return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                             "the name of frame %u is too long", frame);
        status = make_picture(self, i, path, !is_still, &is_reused, error);
        if (status == TULLE_OK) show_frame(self, i + 1, frame, is_reused);
    }
    return status;
}

/* ---- films ---- */

static tulle_status encode(sequence *self, tulle_error *error) {
    const picture_target *const target = self->target;
    const picture_maker *const maker = &self->maker;
    film *made = NULL;
    tulle_status status = film_open(target->path, maker->image.width, maker->image.height,
                                    target->frame_rate, &made, error);
    if (status != TULLE_OK) return status;
    for (uint32_t i = 0; i < self->totals->frame_count && status == TULLE_OK; i++) {
        char path[NUMBERED_PATH_SIZE];
        render_image image = {0};
        name_pattern_format(&target->names, frame_range_get(maker->run->frames, i), path);
        status = render_image_read_png(path, &image, NULL, NULL, 0, error);
        if (status == TULLE_OK) status = film_add(made, &image, error);
        render_image_destroy(&image);
        if (status == TULLE_OK && interrupt_is_pending()) status = TULLE_ERROR_INTERRUPTED;
    }
    if (status == TULLE_OK) return film_close(made, error);
    film_discard(made);
    return status;
}

/* The film is whole: its frames go, and their folder, unless something else is in it. */
static void remove_frames(const sequence *self) {
    for (uint32_t i = 0; i < self->totals->frame_count; i++) {
        char path[NUMBERED_PATH_SIZE];
        if (name_pattern_format(&self->target->names, frame_range_get(self->maker.run->frames, i),
                                path))
            remove(path);
    }
    rmdir(self->target->folder);
}

static tulle_status make_film(sequence *self, tulle_error *error) {
    const char *const folder = self->target->folder;
    if (mkdir(folder, 0777) != 0 && errno != EEXIST)
        return error_set_at(error, TULLE_ERROR_IO, folder, 0, 0, "cannot be made: %s",
                            strerror(errno));
    tulle_status status = make_pictures(self, error);
    progress_bar_end(&self->bar);
    if (status == TULLE_OK) status = encode(self, error);
    if (status == TULLE_OK)
        remove_frames(self);
    else
        rmdir(folder); /* where it is empty */
    return status;
}

tulle_status picture_make_all(picture_run *run, const picture_target *target,
                              picture_totals *totals, tulle_error *error) {
    sequence self = {.target = target, .totals = totals};
    *totals = (picture_totals){.frame_count = frame_range_get_count(run->frames)};
    tulle_status status = picture_maker_open(&self.maker, run, error);
    if (status == TULLE_OK) status = picture_choose_side(&self.maker, &totals->sight, error);
    if (status == TULLE_OK) {
        begin_progress(&self, run->options->progress);
        status =
            target->kind == PICTURE_FILM ? make_film(&self, error) : make_pictures(&self, error);
        progress_bar_end(&self.bar);
    }
    if (run->options->subdivision_levels > 0) {
        subdivided_totals_describe(&self.maker.subdivided, totals->subdivided);
        totals->is_intersecting = self.maker.subdivided.bad_frame_count > 0;
    }
    picture_maker_close(&self.maker);
    return status;
}
