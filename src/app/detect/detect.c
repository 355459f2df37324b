/* app/detect/detect.c - `tulle detect`: what collides between two states of a moving triangle
 * surface.
 *
 * Input: two mesh files with the same triangles. Output: events, candidates at every stage, patches
 * and times, as text or JSON; on demand each event. Finding events is no failure: an event may be a
 * near miss, and judging is what `tulle check` does. */
#include "app/cli/options.h"
#include "app/commands.h"
#include "app/detect/report.h"
#include "base/error.h"
#include "base/words.h"
#include "scene/units.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { THREAD_MAX = 256 };
static const double RIGHT_ANGLE = 1.5707963267948966; /* [rad] */
/* A plain number above any angle in radians that makes sense is one in degrees. */
static const double LEAST_PLAIN_DEGREES = 2.0;

static const char *const switch_names[] = {"on", "off", NULL};
static const char *const patches_names[] = {"keep", "grow", NULL};

/* What the command line says, before it is made numbers; null: the default of the library. */
typedef struct detect_words {
    const char *method, *cone, *alpha_max, *thickness, *minimum_separation, *certificate, *patches;
    long threads, repeat;
    int is_json, has_list, is_earliest;
} detect_words;

static options_outcome read_words(int argc, char **argv, detect_words *words) {
    const option_spec specs[] = {
        CHOICE_OPTION("method", 'm', &words->method, "patches|refit|bvox|paper", method_words,
                      "how pairs are found (default: patches)"),
        CHOICE_OPTION("cone", 0, &words->cone, "bernstein|paper", cone_words,
                      "cones that bound the normals of moving triangles (default: bernstein)"),
        TEXT_OPTION("alpha-max", 0, &words->alpha_max, "ANGLE",
                    "widest cone in which a patch grows, above 0, below 90deg (default: 60deg)"),
        TEXT_OPTION(
            "thickness", 0, &words->thickness, "LENGTH",
            "features nearer than this collide; in metres or with a unit, as 1mm (default: 0)"),
        TEXT_OPTION("minimum-separation", 0, &words->minimum_separation, "LENGTH",
                    "added to the thickness (default: 0)"),
        CHOICE_OPTION("certificate", 0, &words->certificate, "on|off", switch_names,
                      "off: patches are skipped by their cones alone; misses collisions, an "
                      "exception to the promise (default: on)"),
        CHOICE_OPTION("patches", 0, &words->patches, "keep|grow", patches_names,
                      "keep patches from call to call, or grow them again (default: keep)"),
        INTEGER_OPTION(
            "threads", 't', &words->threads, "N", 0, THREAD_MAX,
            "threads; 0: one for each processor (default); the events do not depend on it"),
        INTEGER_OPTION("repeat", 'r', &words->repeat, "N", 0, DETECT_REPEAT_MAX,
                       "search N more times, to measure how long it takes (default: 0)"),
        FLAG_OPTION("list", 'l', &words->has_list, "print each event: kind, features, time, state"),
        FLAG_OPTION("earliest", 0, &words->is_earliest, "find only the earliest event"),
        FLAG_OPTION("json", 0, &words->is_json, "one JSON document instead of text"),
    };
    const command_spec command =
        COMMAND("detect", "START END", specs, 2, 2,
                "Finds collisions while the vertices of a surface move in straight lines from "
                "START to\nEND (OBJ, PLY, VTP with the same triangles): vertices with triangles "
                "and edges with\nedges. Pairs that touch or cross at the start are marked. Prints "
                "events, candidates\nat every stage, patches and times. The exit code is 0 with "
                "events and without.");
    size_t operand_count = 0;
    return options_parse(&command, argc, argv, &operand_count);
}

static int find_name(const char *const *names, const char *name) {
    int index = 0;
    while (strcmp(names[index], name) != 0) index++;
    return index;
}

static tulle_status read_angle(const char *text, double *angle, tulle_error *error) {
    double plain = 0.0;
    bool const is_plain = quantity_read(text, UNIT_NONE, &plain) == QUANTITY_READ;
    if (is_plain && plain > 0.0 && plain < LEAST_PLAIN_DEGREES)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "--alpha-max: \"%.80s\" could be meant in degrees or in radians; give a "
                         "unit, as 60deg or 1rad",
                         text);
    double value = plain * RIGHT_ANGLE / 90.0;
    if ((is_plain || quantity_read(text, UNIT_ANGLE, &value) == QUANTITY_READ) && value > 0.0 &&
        value < RIGHT_ANGLE) {
        *angle = value;
        return TULLE_OK;
    }
    return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                     "--alpha-max: \"%.80s\" should be an angle above 0 and below 90deg, as 60deg",
                     text);
}

static tulle_status read_length(const char *name, const char *text, double *length,
                                tulle_error *error) {
    double value = 0.0;
    if (quantity_read(text, UNIT_LENGTH, &value) == QUANTITY_READ && value >= 0.0) {
        *length = value;
        return TULLE_OK;
    }
    return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                     "--%s: \"%.80s\" should be a length of 0 or more, in metres or with a unit, "
                     "as 1mm",
                     name, text);
}

static tulle_status make_passes(const detect_words *words, detect_passes *passes,
                                tulle_error *error) {
    *passes = (detect_passes){.def = tulle_detect_def_default(),
                              .repeat_count = (uint32_t)words->repeat,
                              .is_earliest = words->is_earliest != 0};
    tulle_detect_def *const def = &passes->def;
    if (words->method) def->method = (tulle_detect_method)find_name(method_words, words->method);
    if (words->cone) def->cone = (tulle_detect_cone)find_name(cone_words, words->cone);
    if (words->certificate) def->has_certificate = strcmp(words->certificate, "on") == 0;
    if (words->patches) def->grows_patches_anew = strcmp(words->patches, "grow") == 0;
    def->threads = (int)words->threads;
    tulle_status status = TULLE_OK;
    if (words->alpha_max) status = read_angle(words->alpha_max, &def->max_angle, error);
    if (status == TULLE_OK && words->thickness)
        status = read_length("thickness", words->thickness, &def->thickness, error);
    if (status == TULLE_OK && words->minimum_separation)
        status = read_length("minimum-separation", words->minimum_separation,
                             &def->minimum_separation, error);
    return status;
}

/* Reads, searches and reports; the exit code. */
static int detect(const detect_words *words, detect_report *report, detect_passes *passes,
                  detect_frames *frames, tulle_error *error) {
    tulle_status status = make_passes(words, passes, error);
    if (status == TULLE_OK)
        status = detect_frames_read(report->start_path, report->end_path, frames, error);
    if (status != TULLE_OK) return app_exit_for_input(status);
    status =
        detect_frames_count_crossings(frames, (int)words->threads, &report->crossing_count, error);
    if (status == TULLE_OK) status = detect_passes_run(passes, frames, error);
    if (status != TULLE_OK) {
        if (status == TULLE_ERROR_INVALID_MESH && !error->file[0])
            snprintf(error->file, sizeof error->file, "%s", report->start_path);
        return app_exit_for_run(status);
    }
    if (words->is_json)
        detect_report_json(report, passes);
    else
        detect_report_text(report, passes);
    return app_finish_output("detect");
}

int app_detect(int argc, char **argv) {
    detect_words words = {0};
    options_outcome const outcome = read_words(argc, argv, &words);
    if (outcome != OPTIONS_READ) return options_exit(outcome);
    detect_report report = {
        .start_path = argv[0], .end_path = argv[1], .has_list = words.has_list != 0};
    detect_passes passes;
    detect_frames frames = {0};
    tulle_error error = {0};
    int const code = detect(&words, &report, &passes, &frames, &error);
    if (error.status != TULLE_OK) app_print_error("detect", &error);
    detect_passes_destroy(&passes);
    detect_frames_destroy(&frames);
    return code;
}
