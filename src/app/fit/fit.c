/* app/fit/fit.c - `tulle fit`: from what was measured on a fabric to its material file. */
#define _POSIX_C_SOURCE 200809L
#include "app/fit/fit.h"
#include "app/cli/interrupt.h"
#include "app/cli/options.h"
#include "app/commands.h"
#include "base/parallel.h"
#include "base/text.h"
#include "scene/scene.h"
#include "scene/units.h"

#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { THREADS_MAX = 256, SAMPLES_DEFAULT = 3 };
static const double NOT_MEASURED = (double)NAN;

/* The words of the command line. */
typedef struct fit_words {
    const char *drape, *drape_error, *warp, *weft, *length_error, *density, *shear;
    const char *preset, *from, *cell;
    long samples, threads;
    int replaces, wants_json;
} fit_words;

static options_outcome read_words(int argc, char **argv, fit_words *words, size_t *count) {
    const option_spec options[] = {
        TEXT_OPTION("drape", 'd', &words->drape, "PERCENT",
                    "drape coefficient: 300 mm of cloth on a disc of 180 mm"),
        TEXT_OPTION("drape-error", 0, &words->drape_error, "PERCENT",
                    "what it may be off to either side (default: 2)"),
        TEXT_OPTION("bending-warp", 0, &words->warp, "LENGTH",
                    "bending length along the warp: half the overhang at 41.5 degrees, as 19mm"),
        TEXT_OPTION("bending-weft", 0, &words->weft, "LENGTH",
                    "the same along the weft (default: as the start has it to the warp)"),
        TEXT_OPTION("bending-error", 0, &words->length_error, "LENGTH",
                    "what these may be off to either side (default: 0.5mm)"),
        TEXT_OPTION("area-density", 0, &words->density, "DENSITY",
                    "mass per area, as 150gsm (default: the start's)"),
        TEXT_OPTION("shear", 0, &words->shear, "STIFFNESS",
                    "stiffness of shear, as 0.9gf/cm/deg; it is not fitted then"),
        TEXT_OPTION("preset", 'p', &words->preset, "NAME",
                    "fabric to start from (default: cotton)"),
        TEXT_OPTION("from", 0, &words->from, "FILE", "material file to start from, in its place"),
        INTEGER_OPTION("samples", 0, &words->samples, "N", 1, FIT_SAMPLES_MAX,
                       "samples that each simulated drape coefficient is the mean of (default: 3)"),
        TEXT_OPTION("cell", 0, &words->cell, "LENGTH",
                    "edges of the samples' meshes (default: 2/7 of the bending length)"),
        INTEGER_OPTION(
            "threads", 't', &words->threads, "N", 1, THREADS_MAX,
            "threads; the result is the same for any number (default: one per processor)"),
        FLAG_OPTION("force", 0, &words->replaces, "replace FABRIC.yaml"),
        FLAG_OPTION("json", 0, &words->wants_json, "one JSON object instead of text"),
    };
    const command_spec command = COMMAND(
        "fit", "FABRIC.yaml", options, 1, 1,
        "Writes the material file of a fabric from measurements. Bending\n"
        "lengths give bending at once. Drape tests are simulated until they give the drape\n"
        "coefficient: by other shear, or by other bending where no bending length is given.\n"
        "Says how sure each value is. Takes minutes; Ctrl-C ends it (130).");
    return options_parse(&command, argc, argv, count);
}

/* ---- quantities ---- */

/* A quantity of the command line: its SI value between least and most. Null text: *value
 * stays. */
typedef struct quantity_option {
    const char *name, *text;
    unit_dimension dimension;
    double least, most;
    const char *range; /* in words */
    double *value;
} quantity_option;

static bool read_quantity(const quantity_option *option) {
    if (!option->text) return true;
    double value = 0.0;
    size_t const number_length = strspn(option->text, "+-.0123456789eE");
    if (option->text[number_length] == '\0' ||
        quantity_read(option->text, option->dimension, &value) != QUANTITY_READ ||
        value < option->least || value > option->most) {
        app_print_message("fit", "--%s: \"%s\" should be %s", option->name, option->text,
                          option->range);
        return false;
    }
    *option->value = value;
    return true;
}

/* "65", "65 %": 65. */
static bool read_percent(const char *name, const char *text, double least, double most,
                         double *value) {
    if (!text) return true;
    double number = 0.0;
    bool const is_read = quantity_read(text, UNIT_NONE, &number) == QUANTITY_READ;
    if (strchr(text, '%')) number *= 1e2;
    if (is_read && number >= least && number <= most) {
        *value = number;
        return true;
    }
    app_print_message("fit", "--%s: \"%s\" should be from %g to %g, in percent", name, text, least,
                      most);
    return false;
}

static bool read_measures(const fit_words *words, fit_measures *measures, double *cell) {
    static const char length_range[] = "a length from 2mm to 100mm, with its unit";
    const quantity_option options[] = {
        {"bending-warp", words->warp, UNIT_LENGTH, 2e-3, 0.1, length_range, &measures->lengths[0]},
        {"bending-weft", words->weft, UNIT_LENGTH, 2e-3, 0.1, length_range, &measures->lengths[1]},
        {"bending-error", words->length_error, UNIT_LENGTH, 0.0, 0.02,
         "a length up to 20mm, with its unit", &measures->length_error},
        {"area-density", words->density, UNIT_AREA_DENSITY, 5e-3, 5.0,
         "from 5gsm to 5000gsm, with its unit", &measures->density},
        {"shear", words->shear, UNIT_STIFFNESS, 0.1, 1e6,
         "from 0.1N/m to 1e6N/m, with its unit; gf/cm/deg is known, too", &measures->shear},
        {"cell", words->cell, UNIT_LENGTH, 1e-3, 0.03, "a length from 1mm to 30mm, with its unit",
         cell},
    };
    for (size_t i = 0; i < sizeof options / sizeof options[0]; i++)
        if (!read_quantity(&options[i])) return false;
    if (!read_percent("drape", words->drape, 2.0, 99.5, &measures->drape) ||
        !read_percent("drape-error", words->drape_error, 0.0, 30.0, &measures->drape_error))
        return false;
    if (words->drape || words->warp || words->weft) return true;
    app_print_message("fit",
                      "nothing was measured: give --drape, --bending-warp or --bending-weft");
    return false;
}

/* Options that would change nothing are mistakes. */
static bool check_effects(const fit_words *words) {
    bool const has_length = words->warp || words->weft;
    const struct {
        const char *name, *needed;
        bool is_idle;
    } options[] = {
        {"drape-error", "--drape", words->drape_error && !words->drape},
        {"bending-error", "a bending length", words->length_error && !has_length},
        {"samples", "--drape", words->samples != 0 && !words->drape},
        {"cell", "--drape", words->cell && !words->drape},
    };
    for (size_t i = 0; i < sizeof options / sizeof options[0]; i++) {
        if (!options[i].is_idle) continue;
        app_print_message("fit", "--%s has no effect without %s", options[i].name,
                          options[i].needed);
        return false;
    }
    return true;
}

/* ---- the start ---- */

static bool refuse_preset(const char *preset) {
    const char *names[64], *name;
    size_t count = 0;
    for (; count < 64 && (name = tulle_material_preset_name(count)); count++) names[count] = name;
    const char *const nearest = text_find_nearest(preset, names, count);
    if (nearest)
        app_print_message("fit", "--preset: there is no fabric \"%s\"; did you mean \"%s\"?",
                          preset, nearest);
    else
        app_print_message(
            "fit", "--preset: there is no fabric \"%s\"; docs/guide/scene.md lists them", preset);
    return false;
}

/* The material to start from, and what it is called. */
static bool load_start(const fit_words *words, tulle_material *material, char name[FIT_START_SIZE],
                       int *code) {
    *code = APP_EXIT_BAD_INPUT;
    if (words->preset && words->from) {
        app_print_message("fit", "--preset and --from are two starts; give one of them");
        return false;
    }
    if (words->from) {
        tulle_scene_problems *const problems = calloc(1, sizeof *problems);
        *code = APP_EXIT_OUT_OF_MEMORY;
        if (!problems) return false;
        tulle_status const status = scene_load_material(words->from, material, problems);
        if (status != TULLE_OK) scene_print_problems(problems, stderr);
        free(problems);
        *code = app_exit_for_input(status);
        if (status != TULLE_OK) return false;
        snprintf(name, FIT_START_SIZE, "the file %s", words->from);
    } else {
        const char *const preset = words->preset ? words->preset : "cotton";
        if (tulle_material_preset(preset, material) != TULLE_OK) return refuse_preset(preset);
        snprintf(name, FIT_START_SIZE, "the preset %s", preset);
    }
    *code = APP_EXIT_BAD_INPUT;
    if (material->bend_warp > 0.0 && material->bend_weft > 0.0) return true;
    app_print_message(
        "fit", "%s has no bending rigidity along warp or weft, so there is none to scale", name);
    return false;
}

/* Whether a world takes the material. */
static tulle_status check_material(const tulle_material *material, tulle_error *error) {
    double positions[] = {0.0, 0.0, 0.0, 0.1, 0.0, 0.0, 0.0, 0.1, 0.0};
    uint32_t triangle[] = {0, 1, 2};
    tulle_world_def const def = tulle_world_def_default();
    tulle_cloth_def cloth = tulle_cloth_def_default();
    cloth.mesh = (tulle_mesh_view){positions, 3, triangle, 1};
    cloth.material = *material;
    cloth.name = "the fabric";
    tulle_world *world = NULL;
    tulle_status status = tulle_world_create(&def, &world, error);
    if (status == TULLE_OK) status = tulle_world_add_cloth(world, &cloth, NULL, error);
    tulle_world_destroy(world);
    return status;
}

static bool check_start(const tulle_material *start, const char *name) {
    tulle_error error = {0};
    if (check_material(start, &error) == TULLE_OK) return true;
    app_print_message("fit", "%s cannot be started from: %s", name, error.message);
    return false;
}

/* Errors of bending lengths are small beside them, or nothing is told. */
static bool check_length_error(const fit_measures *measures) {
    for (int i = 0; i < 2; i++) {
        if (!(measures->length_error > measures->lengths[i] / 4.0)) continue;
        app_print_message("fit",
                          "--bending-error: %g mm is more than a quarter of the bending length of "
                          "%g mm; measure it better, or leave it out",
                          1e3 * measures->length_error, 1e3 * measures->lengths[i]);
        return false;
    }
    return true;
}

/* Shear and yarns must go together, as the world demands it. */
static bool check_shear(const fit_measures *measures, const tulle_material *start) {
    double const most = sqrt(start->warp.stiffness * start->weft.stiffness);
    if (!(measures->shear > most)) return true;
    app_print_message("fit",
                      "--shear: %g N/m is more than the geometric mean of the yarns' stiffness, %g "
                      "N/m; start from a fabric with stiffer yarns",
                      measures->shear, most);
    return false;
}

/* ---- the work ---- */

/* Whether the material file may be written: before minutes are spent. */
static bool check_target(const char *path, bool replaces) {
    struct stat facts;
    bool const is_there = stat(path, &facts) == 0;
    char folder[4096];
    const char *const slash = strrchr(path, '/');
    if (strlen(slash ? slash + 1 : path) == 0 || strlen(slash ? slash + 1 : path) > NAME_MAX) {
        app_print_message("fit",
                          "\"%s\" cannot be the name of a file: it should have 1 to %d bytes", path,
                          NAME_MAX);
        return false;
    }
    snprintf(folder, sizeof folder, "%.*s", slash ? (int)(slash - path) + 1 : 1,
             slash ? path : ".");
    if (is_there && !S_ISREG(facts.st_mode))
        app_print_message("fit", "%s exists and is not a file", path);
    else if (is_there && !replaces)
        app_print_message("fit", "%s is there; --force replaces it", path);
    else if (access(folder, W_OK) != 0)
        app_print_message("fit", "%s cannot be written: no file can be made in %s", path, folder);
    else
        return true;
    return false;
}

static int fail(const tulle_error *error, tulle_status status) {
    if (status == TULLE_ERROR_INTERRUPTED)
        app_print_message("fit", "interrupted; nothing was written");
    else
        app_print_error("fit", error);
    return app_exit_for_run(status);
}

static int find_and_write(const tulle_material *start, const fit_method *method, fit_story *story,
                          bool wants_json) {
    fit_found found;
    tulle_error error = {0};
    uint32_t const tests = fit_count_tests(story->measures, method);
    if (tests > 0)
        fprintf(stderr, "at most %u drape tests will be simulated, on %d thread%s\n", tests,
                method->threads, method->threads == 1 ? "" : "s");
    tulle_status status = fit_find(start, story->measures, method, &found, &error);
    if (status != TULLE_OK) return fail(&error, status);
    story->found = &found;
    bool const is_possible = fit_is_possible(&found);
    fit_round_material(&found.material);
    if (is_possible) status = check_material(&found.material, &error);
    if (status != TULLE_OK) {
        app_print_error("fit", &error);
        return app_exit_for_input(status);
    }
    if (is_possible) status = fit_write_material(story, &error);
    if (status != TULLE_OK) return fail(&error, status);
    if (wants_json)
        fit_tell_json(story, stdout);
    else
        fit_tell(story, "", stdout);
    if (is_possible && !wants_json) app_print_names(stdout, "wrote %s\n", story->path);
    int const written = app_finish_output("fit");
    if (is_possible || written != APP_EXIT_FINE) return written;
    app_print_message("fit", "the measures contradict each other; no file was written");
    return APP_EXIT_BAD_INPUT;
}

int app_fit(int argc, char **argv) {
    fit_words words = {0};
    size_t count = 0;
    options_outcome const outcome = read_words(argc, argv, &words, &count);
    if (outcome != OPTIONS_READ) return options_exit(outcome);
    fit_measures measures = {.drape = NOT_MEASURED,
                             .drape_error = 2.0,
                             .lengths = {NOT_MEASURED, NOT_MEASURED},
                             .length_error = 0.5e-3,
                             .density = NOT_MEASURED,
                             .shear = NOT_MEASURED};
    fit_method method = {.samples = (uint32_t)(words.samples ? words.samples : SAMPLES_DEFAULT),
                         .pattern = DRAPE_IRREGULAR_RINGS,
                         .threads = parallel_resolve_threads((int)words.threads),
                         .progress = stderr};
    tulle_material start;
    char start_name[FIT_START_SIZE];
    int code = APP_EXIT_BAD_INPUT;
    if (!read_measures(&words, &measures, &method.cell) || !check_effects(&words) ||
        !load_start(&words, &start, start_name, &code) || !check_shear(&measures, &start) ||
        !check_length_error(&measures) || !check_start(&start, start_name) ||
        !check_target(argv[0], words.replaces != 0))
        return code;
    interrupt_catch();
    fit_story story = {.measures = &measures, .start = start_name, .path = argv[0]};
    return find_and_write(&start, &method, &story, words.wants_json != 0);
}
