/* app/reproduce_runs.c - the runs of `tulle reproduce`: where the scenes are, which runs are whole,
 * and `tulle run` for those that are not. */
#define _POSIX_C_SOURCE 200809L
#include "app/cli/beside_program.h"
#include "app/commands.h"
#include "app/reproduce.h"
#include "base/error.h"
#include "scene/scene.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#ifndef TULLE_SCENES_FROM_PROGRAM
#define TULLE_SCENES_FROM_PROGRAM "../share/tulle/scenes"
#endif

enum {
    SCENE_PATH_SIZE = 2 * REPRODUCE_PATH_SIZE,
    OVERRIDES_MAX = 16,
    ARGUMENTS_MAX = 2 * OVERRIDES_MAX + 12
};

/* What goes by the paper's rules gets tangled and takes about so many times as long. */
static const double PAPER_COST = 2.0;

/* From the directory of the program: as it is installed, and where it is built. */
static const char *const scene_places[] = {TULLE_SCENES_FROM_PROGRAM "/paper", "../../scenes/paper",
                                           "../scenes/paper"};

/* Ways of finding pairs: the paper's method goes by its rules, which prove nothing. */
static const struct {
    const char *name;
    const char *overrides[4];
} methods[] = {{"paper",
                {"contact.method=paper", "contact.cone=paper", "contact.certificate=off",
                 "contact.alpha_max=85 deg"}},
               {"bvox", {"contact.method=bvox"}},
               {"refit", {"contact.method=refit"}},
               {"patches", {"contact.method=patches"}}};

typedef struct override_texts {
    const char *items[OVERRIDES_MAX];
    size_t count;
} override_texts;

int reproduce_find_scenes(reproduce *self, const char *given) {
    if (given) {
        snprintf(self->scenes, sizeof self->scenes, "%s", given);
        if (strlen(given) < REPRODUCE_PATH_SIZE / 2 && is_directory(given)) return APP_EXIT_FINE;
        app_print_message("reproduce", "--scenes: %s is no directory", given);
        return APP_EXIT_BAD_INPUT;
    }
    size_t const count = sizeof scene_places / sizeof scene_places[0];
    if (beside_program_find(scene_places, count, sizeof self->scenes, self->scenes))
        return APP_EXIT_FINE;
    app_print_message("reproduce", "the paper's scenes are not beside the program; name their "
                                   "directory with --scenes DIR");
    return APP_EXIT_BAD_INPUT;
}

/* The scene's file; gives what it shares with others, or null where it has one of its own. */
static const reproduce_shared *make_scene_path(const reproduce *self, const reproduce_run *run,
                                               char path[SCENE_PATH_SIZE]) {
    snprintf(path, SCENE_PATH_SIZE, "%s/%s.yaml", self->scenes, run->scene);
    const reproduce_shared *const shared = reproduce_find_shared(run->scene);
    if (!shared || access(path, R_OK) == 0) return NULL;
    snprintf(path, SCENE_PATH_SIZE, "%s/%s.yaml", self->scenes, shared->file);
    return shared;
}

bool reproduce_has_scene(const reproduce *self, const reproduce_run *run) {
    char path[SCENE_PATH_SIZE];
    (void)make_scene_path(self, run, path);
    return access(path, R_OK) == 0;
}

void reproduce_name_run(const reproduce_run *run, char name[REPRODUCE_PATH_SIZE]) {
    snprintf(name, REPRODUCE_PATH_SIZE, "%s%s%s", run->scene, run->method ? "." : "",
             run->method ? run->method : "");
}

void reproduce_find_run(const reproduce *self, const reproduce_run *run,
                        char path[REPRODUCE_PATH_SIZE]) {
    char name[REPRODUCE_PATH_SIZE];
    reproduce_name_run(run, name);
    reproduce_make_path(self, path, "runs/%s", name);
}

bool reproduce_has_run(const reproduce *self, const reproduce_run *run) {
    char path[REPRODUCE_PATH_SIZE];
    reproduce_find_run(self, run, path);
    tulle_run_reader *reader = NULL;
    if (!tulle_run_is_directory(path) || tulle_run_reader_open(path, &reader, NULL) != TULLE_OK)
        return false;
    bool const has_frames = tulle_run_reader_get_info(reader)->frame_count > 1;
    tulle_run_reader_close(reader);
    return has_frames;
}

tulle_status reproduce_get_reports(tulle_run_reader *reader, const tulle_step_report **reports,
                                   size_t *count, tulle_error *error) {
    const tulle_run_info *const info = tulle_run_reader_get_info(reader);
    uint64_t steps = 0;
    *count = 0;
    tulle_status status = tulle_run_reader_get_reports(reader, reports, count, error);
    if (status == TULLE_OK && info->frame_count > 0)
        status = tulle_run_reader_get_frame(reader, info->frame_count - 1, NULL, &steps, NULL);
    if (status == TULLE_OK && *count < steps)
        status =
            error_set(error, TULLE_ERROR_PARSE,
                      "its report.csv tells of %zu steps, its frames of %" PRIu64, *count, steps);
    return status;
}

bool reproduce_has_reports(const reproduce *self, const reproduce_run *run) {
    char path[REPRODUCE_PATH_SIZE], name[REPRODUCE_PATH_SIZE];
    tulle_run_reader *reader = NULL;
    const tulle_step_report *reports = NULL;
    size_t count = 0;
    tulle_error error = {0};
    reproduce_find_run(self, run, path);
    reproduce_name_run(run, name);
    tulle_status status = tulle_run_reader_open(path, &reader, &error);
    if (status == TULLE_OK) status = reproduce_get_reports(reader, &reports, &count, &error);
    tulle_run_reader_close(reader);
    if (status != TULLE_OK)
        app_print_message("reproduce",
                          "runs/%s: %s; its times are not known; without that folder the run is "
                          "made again",
                          name, error.message);
    return status == TULLE_OK;
}

static override_texts list_overrides(const reproduce *self, const reproduce_run *run) {
    override_texts texts = {0};
    char path[SCENE_PATH_SIZE];
    const reproduce_shared *const shared = make_scene_path(self, run, path);
    if (shared && shared->override) texts.items[texts.count++] = shared->override;
    const reproduce_quick *const quick = reproduce_find_quick(run->scene);
    for (size_t i = 0; self->is_quick && quick && quick->overrides[i]; i++)
        texts.items[texts.count++] = quick->overrides[i];
    for (size_t m = 0; run->method && m < sizeof methods / sizeof methods[0]; m++)
        for (size_t i = 0; strcmp(methods[m].name, run->method) == 0 && i < 4; i++)
            if (methods[m].overrides[i]) texts.items[texts.count++] = methods[m].overrides[i];
    return texts;
}

/* The scene as it is run; prints what is wrong with it. */
static int load_scene(const reproduce *self, const reproduce_run *run, scene **loaded) {
    char path[SCENE_PATH_SIZE];
    (void)make_scene_path(self, run, path);
    override_texts const texts = list_overrides(self, run);
    scene_problems *const problems = calloc(1, sizeof *problems);
    if (!problems) return APP_EXIT_OUT_OF_MEMORY;
    tulle_status const status = scene_load(path, texts.items, texts.count, loaded, problems);
    if (status != TULLE_OK) scene_print_problems(problems, stderr);
    free(problems);
    return app_exit_for_input(status);
}

static uint32_t count_frames(const reproduce *self, const reproduce_run *run, const scene *loaded) {
    uint32_t const frames = scene_get_frame_count(loaded);
    const reproduce_quick *const quick = reproduce_find_quick(run->scene);
    bool const is_cut = self->is_quick && quick && (uint32_t)quick->frames < frames;
    return is_cut ? (uint32_t)quick->frames : frames;
}

/* Frames that are there, the start not counted; all, where nothing is left to do. */
static uint32_t count_made(const char *path, const scene *loaded, uint32_t frames) {
    tulle_run_reader *reader = NULL;
    if (!tulle_run_is_directory(path) || tulle_run_reader_open(path, &reader, NULL) != TULLE_OK)
        return 0;
    const tulle_run_info *const info = tulle_run_reader_get_info(reader);
    uint32_t made = info->frame_count > 0 ? info->frame_count - 1 : 0;
    if (made >= frames) made = info->state == TULLE_RUN_FINISHED ? frames : frames - 1;
    if (info->scene_hash != scene_get_hash(loaded)) made = 0;
    tulle_run_reader_close(reader);
    return made;
}

static size_t count_cloth_triangles(const scene *loaded) {
    size_t count = 0;
    for (size_t i = 0; i < scene_get_cloth_count(loaded); i++)
        count += scene_get_cloth_mesh(loaded, i).triangle_count;
    return count;
}

int reproduce_weigh_run(const reproduce *self, const reproduce_run *run, double *work) {
    char path[REPRODUCE_PATH_SIZE];
    reproduce_find_run(self, run, path);
    scene *loaded = NULL;
    int const code = load_scene(self, run, &loaded);
    if (code != APP_EXIT_FINE) return code;
    uint32_t const frames = count_frames(self, run, loaded);
    uint32_t const left = frames - count_made(path, loaded, frames);
    double const cost = reproduce_get_cost(run->scene) *
                        (run->method && strcmp(run->method, "paper") == 0 ? PAPER_COST : 1.0);
    *work = cost * (double)left * (double)scene_get_steps_per_frame(loaded) *
            (double)count_cloth_triangles(loaded);
    scene_destroy(loaded);
    return APP_EXIT_FINE;
}

/* A run that `tulle run` has opened. */
typedef struct opened_run {
    const reproduce *self;
    const reproduce_run *run;
} opened_run;

/* Its conditions are written down before its first step, and not where it is refused. */
static tulle_status note_opened(void *context, int begins, tulle_error *error) {
    const opened_run *const opened = context;
    return reproduce_note_run(opened->self, opened->run, begins != 0, error);
}

/* Calls `tulle run`. */
static int run_scene(const reproduce *self, const reproduce_run *run, char *path, uint32_t frames) {
    char scene_path[SCENE_PATH_SIZE], frame_text[16], thread_text[16];
    (void)make_scene_path(self, run, scene_path);
    snprintf(frame_text, sizeof frame_text, "%u", (unsigned)frames);
    snprintf(thread_text, sizeof thread_text, "%d", self->threads);
    override_texts const texts = list_overrides(self, run);
    const char *words[ARGUMENTS_MAX] = {
        "run",      scene_path,   "--resume",
        "-o",       path,         "--frames",
        frame_text, "--progress", self->bar.is_terminal ? "auto" : "json"};
    int count = 9;
    for (size_t i = 0; i < texts.count; i++) {
        words[count++] = "--set";
        words[count++] = texts.items[i];
    }
    if (self->threads > 0) {
        words[count++] = "--threads";
        words[count++] = thread_text;
    }
    char *arguments[ARGUMENTS_MAX];
    memcpy(arguments, words, sizeof words);
    opened_run opened = {self, run};
    return app_run_and_tell(count, arguments, note_opened, &opened);
}

int reproduce_make_run(reproduce *self, const reproduce_run *run) {
    char path[REPRODUCE_PATH_SIZE], name[REPRODUCE_PATH_SIZE];
    reproduce_find_run(self, run, path);
    reproduce_name_run(run, name);
    scene *loaded = NULL;
    int const code = load_scene(self, run, &loaded);
    if (code != APP_EXIT_FINE) return code;
    uint32_t const frames = count_frames(self, run, loaded);
    bool const is_done = count_made(path, loaded, frames) == frames;
    scene_destroy(loaded);
    reproduce_show_job(self, name, is_done ? "is there" : "runs");
    if (is_done) return APP_EXIT_FINE;
    return run_scene(self, run, path, frames);
}

tulle_status reproduce_find_distance(const reproduce *self, const reproduce_run *run,
                                     double *distance, tulle_error *error) {
    scene *loaded = NULL;
    if (load_scene(self, run, &loaded) != APP_EXIT_FINE)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "%s.yaml cannot be read", run->scene);
    scene_world built = {0};
    tulle_status status = scene_build_world(loaded, self->threads, NULL, &built, error);
    if (status == TULLE_OK) status = tulle_world_start(built.world, error);
    if (status == TULLE_OK) tulle_world_get_distances(built.world, distance, NULL, NULL);
    scene_destroy_world(&built);
    scene_destroy(loaded);
    return status;
}
