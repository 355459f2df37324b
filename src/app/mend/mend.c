/* app/mend/mend.c - `tulle mend`: an animation of cloth that intersects becomes the nearest one
 * that does not.
 *
 * Frames go through one by one: read, judged, followed (follow.h), judged again, kept. When the
 * last one is kept, OUT and the colours are written. */
#define _POSIX_C_SOURCE 200809L
#include "app/cli/interrupt.h"
#include "app/cli/options.h"
#include "app/cli/progress_bar.h"
#include "app/commands.h"
#include "app/mend/bodies.h"
#include "app/mend/colors.h"
#include "app/mend/frames.h"
#include "app/mend/names.h"
#include "app/mend/output.h"
#include "app/mend/report.h"
#include "app/mend/store.h"
#include "base/error.h"
#include "base/timer.h"
#include "io/file_data.h"
#include "io/text/number.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const double STRENGTH = 0.5, STRENGTH_LEAST = 1e-3, STRENGTH_MOST = 1e3;
static const double REACH = 2.0, REACH_LEAST = 0.5, REACH_MOST = 20.0;
enum { FILES_SIZE = 2 * NUMBERED_PATH_SIZE + 64 /* [bytes] of a text that names files */ };

/* The words of the command line. */
typedef struct mend_words {
    const char *mesh, *out, *bodies_out, *strength, *reach, *gap, *on_pinch, *fps, *report, *colors;
    const char *up, *from_up, *unit, *from_unit;
    option_list bodies, body_meshes;
    int is_double, is_json;
    long threads;
} mend_words;

typedef struct mend_session {
    mend_input input;
    mend_output output;
    mend_bodies bodies;
    mend_names names;
    mend_store store;
    mend_follow_options options;
    mend_frames frames;
    mend_summary summary;
    FILE *report; /* or null */
    const char *report_path, *colors_path, *bodies_path;
    char report_temporary[NUMBERED_PATH_SIZE];
    name_pattern colors; /* of numbered files */
    bool is_json;
} mend_session;

static const char *const pinch_choices[] = {"lag", "stop", NULL};

static options_outcome read_words(int argc, char **argv, mend_words *words) {
    const option_spec options[] = {
        TEXT_OPTION(
            "output", 'o', &words->out, "OUT",
            "what is written: .pc2, .mdd, .glb, .gltf, .usda, .npz, .abc, or numbered meshes"),
        TEXT_OPTION("mesh", 'm', &words->mesh, "FILE",
                    "the mesh whose points a point cache (.pc2, .mdd) moves"),
        LIST_OPTION("body", 'b', &words->bodies, "FILE",
                    "what the cloth meets and does not change: a mesh, or an animation with as "
                    "many frames;\n"
                    "may be given several times"),
        LIST_OPTION(
            "body-mesh", 0, &words->body_meshes, "FILE",
            "the mesh of a body that is a point cache; the first belongs to the first of these"),
        TEXT_OPTION("bodies-out", 0, &words->bodies_out, "DIR",
                    "a folder for the bodies as the cloth met them, under their own names: use "
                    "them in place\n"
                    "of the given bodies if these leave the cloth no room"),
        TEXT_OPTION("strength", 0, &words->strength, "S",
                    "how strongly the cloth is drawn to its given places, 0.001 to 1000 (default: "
                    "0.5, which\n"
                    "takes more than half of a departure away in a frame)"),
        TEXT_OPTION("reach", 0, &words->reach, "EDGES",
                    "over how many edges a departure fades out, 0.5 to 20 (default: 2)"),
        TEXT_OPTION("gap", 0, &words->gap, "LENGTH",
                    "distance that moved cloth keeps (default: a twentieth of a mean edge)"),
        CHOICE_OPTION("on-pinch", 0, &words->on_pinch, "lag|stop", pinch_choices,
                      "if bodies leave the cloth no room: let it meet bodies that lag (default),\n"
                      "or stop"),
        CHOICE_OPTION("up", 0, &words->up, "y|z", axes_up_choices,
                      "axis that points up in OUT (default: z; of .glb, .gltf and .abc y)"),
        CHOICE_OPTION("from-up", 0, &words->from_up, "y|z", axes_up_choices,
                      "axis that points up in ANIMATION, and in bodies whose files do not say "
                      "(default: z; of\n"
                      ".glb, .gltf and .abc y; of .usda as the file says)"),
        CHOICE_OPTION(
            "units", 0, &words->unit, "m|cm|mm|in|ft", axes_unit_choices,
            "unit of OUT and of all printed lengths (default: the unit of ANIMATION; of .glb and\n"
            ".gltf m)"),
        CHOICE_OPTION("from-units", 0, &words->from_unit, "m|cm|mm|in|ft", axes_unit_choices,
                      "unit of length of ANIMATION, and of bodies whose files do not say (default: "
                      "m; of .usda\n"
                      "as the file says)"),
        TEXT_OPTION("fps", 0, &words->fps, "N",
                    "frames in a second, where ANIMATION has no times (default: 24)"),
        FLAG_OPTION("double", 0, &words->is_double,
                    "positions of .npz as float64 (default: float32)"),
        TEXT_OPTION("report", 0, &words->report, "FILE.csv", "a table with a line for each frame"),
        TEXT_OPTION("colors", 0, &words->colors, "FILE.ply",
                    "the frame with the largest departure, coloured by departures; numbered files\n"
                    "(away_%04d.ply): all frames"),
        FLAG_OPTION("json", 0, &words->is_json,
                    "say it as JSON: a line for each frame as it is done, and one at the end"),
        INTEGER_OPTION("threads", 't', &words->threads, "N", 1, 256,
                       "threads; the result does not depend on it (default: one per processor)"),
    };
    const command_spec command = COMMAND(
        "mend", "ANIMATION", options, 1, 1,
        "Makes of ANIMATION, of cloth, the nearest one in which nothing intersects, neither in\n"
        "frames nor on the straight paths between them: a point cache (.pc2, .mdd) with its\n"
        "mesh, an animation (.glb, .gltf, .usda, .npz), numbered meshes (frame_%04d.obj or\n"
        "'frame_*.obj'), or a run. Clean frames come back bit for bit.\n"
        "Exit code 1: something still intersects, because bodies leave no room.");
    size_t operand_count = 0;
    return options_parse(&command, argc, argv, &operand_count);
}

/* ---- preparation ---- */

static tulle_status read_number(const char *name, const char *text, double least, double most,
                                double *value, tulle_error *error) {
    if (!text || (number_parse_double(text, strlen(text), value) == NUMBER_READ &&
                  *value >= least && *value <= most))
        return TULLE_OK;
    return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                     "--%s is \"%s\"; it should be a number from %g to %g", name, text, least,
                     most);
}

static tulle_status read_options(mend_session *session, const mend_words *words,
                                 tulle_error *error) {
    mend_follow_options *const options = &session->options;
    *options =
        (mend_follow_options){.strength = STRENGTH,
                              .reach = REACH,
                              .threads = (int)words->threads,
                              .may_lag = !words->on_pinch || strcmp(words->on_pinch, "lag") == 0};
    tulle_status status = TULLE_OK;
    if (!words->out)
        status = error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                           "-o OUT is missing: the name of the file to write");
    if (status == TULLE_OK)
        status = read_number("strength", words->strength, STRENGTH_LEAST, STRENGTH_MOST,
                             &options->strength, error);
    if (status == TULLE_OK)
        status =
            read_number("reach", words->reach, REACH_LEAST, REACH_MOST, &options->reach, error);
    if (status == TULLE_OK)
        status = read_number("gap", words->gap, 1e-12, 1e12, &options->gap, error);
    session->is_json = words->is_json != 0;
    session->colors_path = words->colors;
    session->report_path = words->report;
    session->bodies_path = words->bodies_out;
    return status;
}

static tulle_status add_colors(mend_session *session, tulle_error *error) {
    const char *const path = session->colors_path;
    size_t const length = strlen(path);
    if (length < 4 || strcmp(path + length - 4, ".ply") != 0)
        return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, path, 0, 0,
                            "the name after --colors should end in .ply");
    bool const is_numbered = name_pattern_is_meant(path);
    tulle_status const status =
        is_numbered ? name_pattern_read(path, &session->colors, error) : TULLE_OK;
    if (status != TULLE_OK) return status;
    if (session->colors.is_any)
        return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, path, 0, 0,
                            "files to be written are named by their numbers, as away_%%04d.ply");
    return mend_names_add_frames(&session->names, &session->input, path,
                                 is_numbered ? &session->colors : NULL, "colours", error);
}

/* Names of all that is to be written, before anything is done; the table is begun. */
static tulle_status open_reports(mend_session *session, tulle_error *error) {
    tulle_status status = TULLE_OK;
    if (session->report_path)
        status = mend_names_add(&session->names, &session->input, session->report_path, "the table",
                                error);
    if (status == TULLE_OK && session->colors_path) status = add_colors(session, error);
    if (status == TULLE_OK) status = mend_names_check(&session->names, error);
    if (status != TULLE_OK || !session->report_path) return status;
    char *const temporary = session->report_temporary;
    int const length =
        snprintf(temporary, NUMBERED_PATH_SIZE, "%s.%ld.tmp", session->report_path, (long)getpid());
    if (length < 0 || length >= NUMBERED_PATH_SIZE)
        return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, session->report_path, 0, 0,
                            "the path is too long");
    session->report = fopen(temporary, "w");
    if (session->report) mend_report_begin_csv(session->report);
    return session->report ? TULLE_OK
                           : file_fail(error, session->report_path, errno, "cannot be written");
}

static tulle_status prepare(mend_session *session, const char *path, const mend_words *words,
                            tulle_error *error) {
    mend_output_options const output = {words->out, words->fps, words->up, words->is_double != 0};
    mend_input_options input = {.path = path,
                                .mesh_path = words->mesh,
                                .bodies = &words->bodies,
                                .body_meshes = &words->body_meshes,
                                .from_up = words->from_up,
                                .from_unit = words->from_unit,
                                .unit = words->unit};
    tulle_status status = read_options(session, words, error);
    if (status == TULLE_OK) status = mend_output_name(&output, &session->output, error);
    convert_format const format = session->output.target.format;
    if (!input.unit && (format == CONVERT_GLB || format == CONVERT_GLTF)) input.unit = "m";
    if (status == TULLE_OK) status = mend_input_open(&input, &session->input, error);
    if (status == TULLE_OK) {
        session->input.is_float = mend_output_is_float(&session->output);
        session->output.has_departures = true;
        session->output.store = &session->store;
        status = mend_output_open(&output, &session->input, 0, &session->output, error);
    }
    const convert_target *const target = &session->output.target;
    if (status == TULLE_OK)
        status = mend_names_add_frames(&session->names, &session->input, target->path,
                                       target->is_numbered ? &target->pattern : NULL, "OUT", error);
    if (status == TULLE_OK && words->bodies_out)
        status = mend_bodies_open(&session->input, words->bodies_out, &session->names,
                                  &session->bodies, error);
    if (status == TULLE_OK)
        status = mend_store_open(words->out,
                                 words->bodies_out ? session->input.vertex_count
                                                   : mend_get_cloth_count(&session->input),
                                 &session->store, error);
    if (status == TULLE_OK) status = open_reports(session, error);
    if (status == TULLE_OK)
        status = mend_frames_open(&session->input, &session->options, &session->frames, error);
    session->frames.judges_met = words->bodies_out != NULL;
    return status;
}

static void release(mend_session *session) {
    if (session->report) fclose(session->report);
    if (session->report_temporary[0]) unlink(session->report_temporary);
    mend_frames_close(&session->frames);
    mend_output_close(&session->output);
    mend_bodies_close(&session->bodies);
    mend_names_close(&session->names);
    mend_store_close(&session->store);
    mend_input_close(&session->input);
}

/* ---- frames ---- */

static tulle_status make_frames(mend_session *session, tulle_error *error) {
    progress_bar bar = progress_bar_begin();
    tulle_status status = TULLE_OK;
    uint32_t const count = session->input.frame_count;
    for (uint32_t i = 0; i < count && status == TULLE_OK; i++) {
        mend_row row;
        status = mend_frames_make(&session->frames, &row, error);
        if (status == TULLE_OK)
            status = mend_store_keep(&session->store, i, session->frames.second.now, error);
        if (status != TULLE_OK) break;
        if (session->bodies_path)
            mend_bodies_add(&session->bodies, session->frames.second.given,
                            session->frames.second.now);
        mend_summary_add(&session->summary, &row);
        if (session->report) mend_report_add_csv(session->report, &row);
        if (session->is_json) mend_report_print_row_json(&row);
        char rest[PROGRESS_DURATION_SIZE];
        progress_format_duration(progress_bar_estimate_rest(&bar, i + 1, count), rest);
        progress_bar_show(&bar, i + 1, count, "frame %u of %u  rest %s", i + 1, count, rest);
    }
    progress_bar_clear(&bar);
    return status;
}

/* ---- what is written at the end ---- */

static tulle_status write_colors(mend_session *session, tulle_error *error) {
    const mend_surface *const cloth = &session->input.surfaces[0];
    double const largest =
        session->summary.worst.largest > 0.0 ? session->summary.worst.largest : 1.0;
    tulle_mesh_view const mesh = {session->output.positions, cloth->vertex_end,
                                  session->input.local_triangles, cloth->triangle_end};
    tulle_status status = TULLE_OK;
    for (uint32_t i = 0; i < session->input.frame_count && status == TULLE_OK; i++) {
        char path[NUMBERED_PATH_SIZE];
        uint32_t const number = mend_input_get_number(&session->input, i);
        if (interrupt_is_pending()) return error_set(error, TULLE_ERROR_INTERRUPTED, "interrupted");
        if (session->colors.text && !name_pattern_format(&session->colors, number, path))
            return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, session->colors_path, 0, 0,
                                "the path is too long");
        if (!session->colors.text && number != session->summary.worst.frame) continue;
        status = mend_output_measure(&session->output, i, error);
        if (status == TULLE_OK)
            status = mend_colors_write(session->colors.text ? path : session->colors_path, mesh,
                                       session->output.given, largest, error);
    }
    return status;
}

static tulle_status write_report(mend_session *session, tulle_error *error) {
    int code = ferror(session->report) ? EIO : 0;
    errno = 0;
    if (fclose(session->report) != 0) code = errno ? errno : EIO;
    session->report = NULL;
    if (code == 0) code = file_rename(session->report_temporary, session->report_path);
    if (code != 0) return file_fail(error, session->report_path, code, "cannot be written");
    session->report_temporary[0] = '\0';
    return TULLE_OK;
}

static void print_report(const mend_session *session) {
    char files[FILES_SIZE];
    if (session->is_json) {
        mend_report_print_summary_json(&session->summary);
        return;
    }
    if (convert_target_describe(&session->output.target, files, sizeof files))
        app_print_names(stdout, "%s\n", files);
    if (session->bodies_path) app_print_names(stdout, "%s\n", session->bodies_path);
    if (session->report_path) app_print_names(stdout, "%s\n", session->report_path);
    if (session->colors_path) app_print_names(stdout, "%s\n", session->colors_path);
    convert_source_print(&session->input.surfaces[0].source, false);
    for (size_t i = 1; i < session->input.surface_count; i++)
        app_print_names(stdout, "  %-11s %s\n", "body", session->input.surfaces[i].source.path);
    mend_report_print_summary(&session->summary);
    if (session->bodies_path && session->summary.lagging_frames > 0)
        app_print_names(stdout, "  %-11s use the bodies in %s: the pairs are counted with them\n",
                        "bodies", session->bodies_path);
}

static int fail(const mend_session *session, tulle_status status, const tulle_error *error) {
    char files[FILES_SIZE];
    app_print_error("mend", error);
    if (convert_target_describe(&session->output.target, files, sizeof files))
        app_print_message("mend", "whole and there: %s; other files may be missing", files);
    else if (status == TULLE_ERROR_INTERRUPTED)
        app_print_message("mend", "nothing was written");
    return mend_frames_are_running(&session->frames) ? app_exit_for_run(status)
                                                     : app_exit_for_input(status);
}

int app_mend(int argc, char **argv) {
    mend_words words = {0};
    options_outcome const outcome = read_words(argc, argv, &words);
    if (outcome != OPTIONS_READ) return options_exit(outcome);
    mend_session *const session = calloc(1, sizeof *session);
    if (!session) {
        app_print_message("mend", "out of memory");
        return APP_EXIT_OUT_OF_MEMORY;
    }
    session->store.file = -1;
    tulle_error error = {0};
    interrupt_catch();
    tulle_status status = prepare(session, argv[0], &words, &error);
    if (status == TULLE_OK) status = make_frames(session, &error);
    if (status == TULLE_OK && session->bodies_path)
        status = mend_bodies_judge_rounding(&session->bodies, &session->store,
                                            &session->frames.second, &error);
    if (status == TULLE_OK) status = mend_output_write(&session->output, &error);
    if (status == TULLE_OK && session->bodies_path)
        status = mend_bodies_write(&session->bodies, &session->store, &error);
    if (status == TULLE_OK && session->report) status = write_report(session, &error);
    if (status == TULLE_OK && session->colors_path) status = write_colors(session, &error);
    int code = APP_EXIT_FINE;
    if (status == TULLE_OK) {
        const mend_summary *const summary = &session->summary;
        print_report(session);
        code = app_finish_output("mend");
        if (code == APP_EXIT_FINE && (summary->bad_after > 0 || summary->crossing_frames > 0 ||
                                      (summary->lagging_frames > 0 && !session->bodies_path)))
            code = APP_EXIT_FALSE;
    } else {
        code = fail(session, status, &error);
    }
    release(session);
    free(session);
    return code;
}
