/* app/render/target.c - where the pictures of `tulle render` go, checked before the work begins. */
#define _POSIX_C_SOURCE 200809L
#include "app/render/film.h"
#include "app/render/sequence.h"
#include "base/error.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static const double RATE_MIN = 0.01, RATE_MAX = 1000.0; /* [1/s] of a film */

static tulle_status fail_length(tulle_error *error) {
    return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "the name of the output is too long");
}

/* RUN.png or RUN.mp4 in this directory, of the last part of the run's path. */
static tulle_status name_output(const picture_options *options, bool is_film,
                                char path[NUMBERED_PATH_SIZE], tulle_error *error) {
    const char *const directory = options->directory;
    size_t end = strlen(directory);
    while (end > 0 && directory[end - 1] == '/') end--;
    size_t begin = end;
    while (begin > 0 && directory[begin - 1] != '/') begin--;
    size_t length = end - begin;
    if (length > 4 && strncmp(directory + end - 4, ".run", 4) == 0) length -= 4;
    bool const is_plain = length > 0 && directory[begin] != '.';
    int const written =
        is_plain ? snprintf(path, NUMBERED_PATH_SIZE, "%.*s%s", (int)length, directory + begin,
                            is_film ? ".mp4" : ".png")
                 : snprintf(path, NUMBERED_PATH_SIZE, "render%s", is_film ? ".mp4" : ".png");
    return written > 0 && written < NUMBERED_PATH_SIZE ? TULLE_OK : fail_length(error);
}

/* Nobody named these places. So what others put there leads nowhere else. */
static tulle_status refuse_link(const char *path, tulle_error *error) {
    struct stat facts;
    if (lstat(path, &facts) != 0 || !S_ISLNK(facts.st_mode)) return TULLE_OK;
    return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, path, 0, 0,
                        "is a symbolic link; remove it, or name another place by -o");
}

/* Whether a file can be made at the path: tries another name in the same folder. */
static tulle_status check_place(const char *path, tulle_error *error) {
    struct stat facts;
    if (stat(path, &facts) == 0 && !S_ISREG(facts.st_mode))
        return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, path, 0, 0,
                            "exists and is not a file; choose another name");
    char probe[NUMBERED_PATH_SIZE + 40];
    snprintf(probe, sizeof probe, "%s.%ld.tmp", path, (long)getpid());
    int const file = open(probe, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (file < 0)
        return error_set_at(error, TULLE_ERROR_IO, path, 0, 0, "cannot be written: %s",
                            strerror(errno));
    close(file);
    remove(probe);
    return TULLE_OK;
}

/* The folder of a film's frames: the film's name with .frames in place of its extension. */
static tulle_status name_folder(picture_target *target, tulle_error *error) {
    const char *const point = strrchr(target->path, '.');
    int const stem = (int)(point - target->path);
    int const length =
        snprintf(target->folder, NUMBERED_PATH_SIZE, "%.*s.frames", stem, target->path);
    if (length < 0 || length + 20 > NUMBERED_PATH_SIZE) return fail_length(error);
    /* A % of the folder's own is no place of the number. */
    snprintf(target->pattern, NUMBERED_PATH_SIZE, "%.*s/frame_%%06d.png", NUMBERED_PATH_SIZE - 20,
             target->folder);
    return name_pattern_read(target->pattern, &target->names, error);
}

static tulle_status choose_rate(const picture_options *options, const picture_run *run,
                                picture_target *target, tulle_error *error) {
    double const real =
        1.0 / (run->info->time_step * run->info->steps_per_frame * (double)run->frames.step);
    target->frame_rate = options->frame_rate > 0.0 ? options->frame_rate : real;
    target->speed = target->frame_rate / real;
    if (target->frame_rate >= RATE_MIN && target->frame_rate <= RATE_MAX) return TULLE_OK;
    return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                     "in real time the film would have %g frames a second; give --fps 30",
                     target->frame_rate);
}

static tulle_status check_film(const picture_options *options, const picture_run *run,
                               picture_target *target, tulle_error *error) {
    tulle_status status = choose_rate(options, run, target, error);
    if (status == TULLE_OK) status = name_folder(target, error);
    struct stat facts;
    if (status == TULLE_OK) status = refuse_link(target->folder, error);
    if (status == TULLE_OK && stat(target->folder, &facts) == 0 && !S_ISDIR(facts.st_mode))
        return error_set_at(
            error, TULLE_ERROR_INVALID_ARGUMENT, target->folder, 0, 0,
            "exists and is not a folder; the film's frames are kept there until it is complete");
    if (status == TULLE_OK) status = film_check(film_find_format(target->path), error);
    return status;
}

static tulle_status check_series(picture_target *target, tulle_error *error) {
    memcpy(target->pattern, target->path, sizeof target->pattern);
    tulle_status status = name_pattern_read(target->pattern, &target->names, error);
    char first[NUMBERED_PATH_SIZE];
    if (status == TULLE_OK && !name_pattern_format(&target->names, NUMBERED_NUMBER_MAX, first))
        status = fail_length(error);
    return status == TULLE_OK ? check_place(first, error) : status;
}

tulle_status picture_target_choose(const picture_options *options, const picture_run *run,
                                   picture_target *target, tulle_error *error) {
    *target = (picture_target){.kind = PICTURE_STILL};
    uint32_t const count = frame_range_get_count(run->frames);
    tulle_status status = TULLE_OK;
    if (!options->output)
        status = name_output(options, count > 1, target->path, error);
    else if (snprintf(target->path, NUMBERED_PATH_SIZE, "%s", options->output) >=
             NUMBERED_PATH_SIZE - 60)
        status = fail_length(error);
    if (status == TULLE_OK && !options->output) status = refuse_link(target->path, error);
    if (status == TULLE_OK) status = picture_find_kind(target->path, &target->kind, error);
    if (status != TULLE_OK) return status;
    if (target->kind == PICTURE_SERIES) return check_series(target, error);
    if (target->kind == PICTURE_STILL && count > 1)
        return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, target->path, 0, 0,
                            "is one picture, and there are %u frames; name them as name_%%04d.png, "
                            "or make a film: name.mp4",
                            count);
    status = check_place(target->path, error);
    if (status == TULLE_OK && target->kind == PICTURE_FILM)
        status = check_film(options, run, target, error);
    return status;
}
