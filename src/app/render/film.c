/* app/render/film.c - see film.h. ffmpeg is started without a shell, in a process group of
 * its own so that a Ctrl-C of the terminal reaches only this program, which then decides. */
#define _POSIX_C_SOURCE 200809L
#include "app/render/film.h"

#include "base/error.h"
#include "io/file_data.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

extern char **environ;

enum {
    ARGUMENT_MAX = 48,
    SAID_SIZE = 1200, /* [bytes] of what ffmpeg said that are shown: its last lines */
    TEMPORARY_ROOM = 40,
    EXIT_NOT_FOUND = 127 /* exit code of a child that could not start its program */
};

struct film_format {
    const char *extension, *muxer, *encoder;
    const char *arguments[24]; /* of the encoder; ends with null */
    bool needs_even_sides;
};

#define BT709                                                                                      \
    "-colorspace", "bt709", "-color_primaries", "bt709", "-color_trc", "bt709", "-color_range", "tv"

/* Quality: at 18 of x264 most people see no difference from the original; 24 of VP9 looks the same.
 */
static const film_format formats[] = {
    {".mp4",
     "mp4",
     "libx264",
     {"-vf", "scale=out_color_matrix=bt709:out_range=tv", "-c:v", "libx264", "-pix_fmt", "yuv420p",
      "-crf", "18", BT709, "-movflags", "+faststart", NULL},
     true},
    {".webm",
     "webm",
     "libvpx-vp9",
     {"-vf", "scale=out_color_matrix=bt709:out_range=tv", "-c:v", "libvpx-vp9", "-pix_fmt",
      "yuv420p", "-crf", "24", "-b:v", "0", "-row-mt", "1", BT709, NULL},
     true},
    {".gif",
     "gif",
     "gif",
     {"-filter_complex",
      "split[a][b];[a]palettegen=stats_mode=diff[p];[b][p]paletteuse=dither=bayer", "-c:v", "gif",
      NULL},
     false},
};
enum { FORMAT_COUNT = sizeof formats / sizeof formats[0] };

struct film {
    const film_format *format;
    char *path, *temporary;
    uint32_t width, height; /* of the pictures */
    pid_t process;          /* 0: none runs */
    int pipe;               /* to its standard input; -1: closed */
    FILE *said;             /* what it wrote to standard error */
};

const film_format *film_find_format(const char *path) {
    const char *const point = strrchr(path, '.');
    for (int i = 0; point && i < FORMAT_COUNT; i++)
        if (strcmp(point, formats[i].extension) == 0) return &formats[i];
    return NULL;
}

static tulle_status fail_missing(tulle_error *error) {
    return error_set(error, TULLE_ERROR_UNSUPPORTED,
                     "films need the program ffmpeg, which is not there; install it (Debian's "
                     "package is ffmpeg), or make pictures with -o name_%%04d.png");
}

/* Starts ffmpeg with these streams; 0 or an errno. input -1: none. */
static int start(char *const *arguments, int input, int output, int said, pid_t *process) {
    posix_spawn_file_actions_t actions;
    posix_spawnattr_t attributes;
    if (posix_spawn_file_actions_init(&actions)) return ENOMEM;
    if (posix_spawnattr_init(&attributes)) {
        posix_spawn_file_actions_destroy(&actions);
        return ENOMEM;
    }
    sigset_t usual;
    sigemptyset(&usual);
    sigaddset(&usual, SIGPIPE);
    sigaddset(&usual, SIGXFSZ);
    int code = posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);
    if (!code) code = posix_spawnattr_setsigdefault(&attributes, &usual);
    if (!code) code = posix_spawnattr_setpgroup(&attributes, 0);
    if (!code && input >= 0) code = posix_spawn_file_actions_adddup2(&actions, input, STDIN_FILENO);
    if (!code && input < 0)
        code = posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    if (!code) code = posix_spawn_file_actions_adddup2(&actions, output, STDOUT_FILENO);
    if (!code) code = posix_spawn_file_actions_adddup2(&actions, said, STDERR_FILENO);
    if (!code) code = posix_spawnp(process, "ffmpeg", &actions, &attributes, arguments, environ);
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&actions);
    return code;
}

/* The exit code of a child, or 128 and the signal that ended it. */
static int wait_for(pid_t process) {
    int state = 0;
    while (waitpid(process, &state, 0) < 0)
        if (errno != EINTR) return EXIT_NOT_FOUND;
    return WIFEXITED(state) ? WEXITSTATUS(state) : 128 + WTERMSIG(state);
}

static FILE *open_scratch(tulle_error *error) {
    FILE *const file = tmpfile();
    if (file)
        fcntl(fileno(file), F_SETFD, FD_CLOEXEC);
    else
        error_set(error, TULLE_ERROR_IO, "a temporary file could not be made: %s", strerror(errno));
    return file;
}

/* Whether the list of ffmpeg's encoders has the name: " V....D libx264   libx264 H.264 ...". */
static bool has_encoder(FILE *list, const char *encoder) {
    char line[512], name[128];
    rewind(list);
    while (fgets(line, sizeof line, list))
        if (sscanf(line, " %*s %127s", name) == 1 && strcmp(name, encoder) == 0) return true;
    return false;
}

tulle_status film_check(const film_format *format, tulle_error *error) {
    char *const arguments[] = {"ffmpeg", "-hide_banner", "-nostdin", "-encoders", NULL};
    FILE *const list = open_scratch(error);
    if (!list) return TULLE_ERROR_IO;
    pid_t process = 0;
    int const code = start(arguments, -1, fileno(list), fileno(list), &process);
    int const end = code ? EXIT_NOT_FOUND : wait_for(process);
    bool const is_there = has_encoder(list, format->encoder);
    fclose(list);
    if (is_there) return TULLE_OK;
    if (end == EXIT_NOT_FOUND) return fail_missing(error);
    if (end != 0)
        return error_set(error, TULLE_ERROR_UNSUPPORTED,
                         "ffmpeg does not run (`ffmpeg -encoders` ends with %d)", end);
    return error_set(error, TULLE_ERROR_UNSUPPORTED,
                     "this ffmpeg has no encoder %s, which %s films need; install an ffmpeg that "
                     "has it, or choose another extension (.mp4, .webm, .gif)",
                     format->encoder, format->extension);
}

static void release(film *made) {
    if (made->pipe >= 0) close(made->pipe);
    if (made->said) fclose(made->said);
    free(made->path);
    free(made->temporary);
    free(made);
}

static film *make_film(const char *path, uint32_t width, uint32_t height) {
    film *const made = calloc(1, sizeof *made);
    if (!made) return NULL;
    size_t const length = strlen(path) + 1;
    *made = (film){.format = film_find_format(path), .width = width, .height = height, .pipe = -1};
    made->path = malloc(length);
    made->temporary = malloc(length + TEMPORARY_ROOM);
    if (!made->path || !made->temporary) {
        release(made);
        return NULL;
    }
    memcpy(made->path, path, length);
    snprintf(made->temporary, length + TEMPORARY_ROOM, "%s.%ld.tmp", path, (long)getpid());
    return made;
}

static uint32_t round_side(const film *made, uint32_t side) {
    return made->format->needs_even_sides ? side + (side & 1) : side;
}

/* A pipe whose ends do not stay open in other children. 0 or an errno. */
static int open_pipe(int ends[2]) {
    if (pipe(ends) != 0) return errno;
    fcntl(ends[0], F_SETFD, FD_CLOEXEC);
    fcntl(ends[1], F_SETFD, FD_CLOEXEC);
    return 0;
}

static int start_encoder(film *made, double frame_rate) {
    char size[32], rate[32];
    snprintf(size, sizeof size, "%ux%u", round_side(made, made->width),
             round_side(made, made->height));
    snprintf(rate, sizeof rate, "%.9g", frame_rate);
    size_t const length = strlen(made->temporary) + 6;
    char *const target = malloc(length); /* "file:": no name is taken for a protocol or an option */
    if (!target) return ENOMEM;
    snprintf(target, length, "file:%s", made->temporary);
    const char *arguments[ARGUMENT_MAX] = {
        "ffmpeg",   "-hide_banner", "-loglevel",   "error", "-nostdin",   "-y", "-f", "rawvideo",
        "-pix_fmt", "rgb24",        "-video_size", size,    "-framerate", rate, "-i", "pipe:0"};
    size_t count = 16;
    for (const char *const *word = made->format->arguments; *word; word++)
        arguments[count++] = *word;
    arguments[count++] = "-f";
    arguments[count++] = made->format->muxer;
    arguments[count++] = target;
    arguments[count] = NULL;
    int ends[2];
    int code = open_pipe(ends);
    if (!code) {
        int const said = fileno(made->said);
        /* The words are not changed: posix_spawnp's type is older than const. */
        code = start((char *const *)arguments, ends[0], said, said, &made->process);
        close(ends[0]);
        made->pipe = ends[1];
    }
    free(target);
    return code;
}

tulle_status film_open(const char *path, uint32_t width, uint32_t height, double frame_rate,
                       film **result, tulle_error *error) {
    *result = NULL;
    film *const made = make_film(path, width, height);
    if (!made) return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "out of memory for a film");
    made->said = open_scratch(error);
    if (!made->said) {
        release(made);
        return TULLE_ERROR_IO;
    }
    int const code = start_encoder(made, frame_rate);
    if (code) {
        made->process = 0;
        release(made);
        return code == ENOENT ? fail_missing(error)
                              : error_set(error, TULLE_ERROR_IO, "ffmpeg could not be started: %s",
                                          strerror(code));
    }
    *result = made;
    return TULLE_OK;
}

/* Waits for ffmpeg, which has or gets the end of its input; its exit code. */
static int end_process(film *made) {
    if (made->pipe >= 0) close(made->pipe);
    made->pipe = -1;
    int const end = made->process ? wait_for(made->process) : EXIT_NOT_FOUND;
    made->process = 0;
    return end;
}

/* The last lines of what ffmpeg said, on one line. */
static void read_said(film *made, char said[SAID_SIZE]) {
    fseek(made->said, 0, SEEK_END);
    long const size = ftell(made->said);
    fseek(made->said, size > SAID_SIZE - 1 ? size - (SAID_SIZE - 1) : 0, SEEK_SET);
    size_t count = fread(said, 1, SAID_SIZE - 1, made->said);
    while (count > 0 && said[count - 1] == '\n') count--;
    said[count] = '\0';
    for (size_t i = 0; i < count; i++)
        if ((unsigned char)said[i] < ' ') said[i] = said[i] == '\n' ? ';' : ' ';
}

static tulle_status fail_encoder(film *made, tulle_error *error) {
    int const end = end_process(made);
    char said[SAID_SIZE];
    read_said(made, said);
    return error_set_at(error, TULLE_ERROR_IO, made->path, 0, 0,
                        "ffmpeg could not make the film (it ended with %d)%s%s", end,
                        said[0] ? ": " : "", said);
}

static bool write_all(int file, const uint8_t *bytes, size_t byte_count) {
    while (byte_count > 0) {
        ssize_t const count = write(file, bytes, byte_count);
        if (count < 0 && errno == EINTR) continue;
        if (count <= 0) return false;
        bytes += count;
        byte_count -= (size_t)count;
    }
    return true;
}

tulle_status film_add(film *made, const render_image *image, tulle_error *error) {
    if (image->width != made->width || image->height != made->height)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "a picture of %ux%u pixels does not fit a film of %ux%u", image->width,
                         image->height, made->width, made->height);
    uint32_t const width = round_side(made, made->width);
    uint32_t const height = round_side(made, made->height);
    size_t const row_size = 3 * (size_t)made->width;
    for (uint32_t y = 0; y < height; y++) {
        uint32_t const from = y < made->height ? y : made->height - 1;
        const uint8_t *const row = image->pixels + from * row_size;
        if (!write_all(made->pipe, row, row_size) ||
            (width > made->width && !write_all(made->pipe, row + row_size - 3, 3)))
            return fail_encoder(made, error);
    }
    return TULLE_OK;
}

tulle_status film_close(film *made, tulle_error *error) {
    tulle_status status = TULLE_OK;
    int const end = end_process(made);
    if (end != 0) {
        char said[SAID_SIZE];
        read_said(made, said);
        status = error_set_at(error, TULLE_ERROR_IO, made->path, 0, 0,
                              "ffmpeg could not make the film (it ended with %d)%s%s", end,
                              said[0] ? ": " : "", said);
    } else {
        int const code = file_rename(made->temporary, made->path);
        if (code) status = file_fail(error, made->path, code, "the film could not be kept");
    }
    if (status != TULLE_OK) remove(made->temporary);
    release(made);
    return status;
}

void film_discard(film *made) {
    if (!made) return;
    if (made->process) kill(made->process, SIGKILL);
    end_process(made);
    remove(made->temporary);
    release(made);
}
