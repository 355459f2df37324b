/* app/run/run.c - `tulle run`: simulates a scene and writes a run directory.
 *
 * Everything that can be wrong with the input is found before the directory is made: the scene is
 * loaded, the world built and its start judged first. */
#include "app/cli/interrupt.h"
#include "app/cli/options.h"
#include "app/commands.h"
#include "app/run/session.h"
#include "base/error.h"
#include "base/timer.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    FRAMES_MAX = 10000000,   /* --frames; as of scenes */
    THREADS_MAX = 256,       /* --threads */
    DIRECTORY_SIZE = 1024,   /* [bytes] of a directory's name made from the scene's */
    CHECKPOINT_TEXT_MAX = 12 /* [characters] of --checkpoint-every */
};
static const char *const checkpoint_default = "30s";

/* The words of the command line. */
typedef struct run_words {
    const char *directory, *progress, *write, *record, *checkpoint, *left, *from;
    long frames, threads;
    int resumes, replaces;
    option_list overrides;
} run_words;

static const char *const write_choices[] = {"vtp", NULL};
static const char *const record_choices[] = {"plain", "velocities", "debug", NULL};

/* ---- options ---- */

/* "30s": seconds; "100": steps. */
static bool read_checkpoint_interval(const char *text, run_options *options) {
    char *end = NULL;
    unsigned long long const number = strtoull(text, &end, 10);
    bool const is_seconds = strcmp(end, "s") == 0;
    if (*text < '0' || *text > '9' || strlen(text) > CHECKPOINT_TEXT_MAX || number == 0 ||
        (*end && !is_seconds)) {
        app_print_message("run",
                          "--checkpoint-every: \"%s\" should be a number of steps, as 100, or of "
                          "seconds, as 30s",
                          text);
        return false;
    }
    if (is_seconds)
        options->checkpoint_seconds = (double)number;
    else
        options->checkpoint_steps = number;
    return true;
}

/* SCENE.yaml in any folder gives SCENE.run in this one. */
static bool name_directory(const char *scene_path, char name[DIRECTORY_SIZE]) {
    const char *const slash = strrchr(scene_path, '/');
    const char *const base = slash ? slash + 1 : scene_path;
    const char *const point = strrchr(base, '.');
    int const length = (int)(point && point > base ? (size_t)(point - base) : strlen(base));
    if (length + 5 > DIRECTORY_SIZE) return false;
    snprintf(name, DIRECTORY_SIZE, "%.*s.run", length, base);
    return true;
}

static options_outcome read_words(int argc, char **argv, run_words *words) {
    const option_spec options[] = {
        TEXT_OPTION("output", 'o', &words->directory, "DIR",
                    "directory for the run (default: SCENE.run in this directory)"),
        INTEGER_OPTION("frames", 'n', &words->frames, "N", 1, FRAMES_MAX,
                       "frames to write after the start (default: as many as the scene says)"),
        INTEGER_OPTION(
            "threads", 't', &words->threads, "N", 1, THREADS_MAX,
            "threads; the result is the same for any number (default: one per processor)"),
        FLAG_OPTION("resume", 0, &words->resumes,
                    "continue from the last checkpoint in DIR; start the run if there is none"),
        FLAG_OPTION("force", 0, &words->replaces, "replace the run in DIR"),
        LIST_OPTION("set", 's', &words->overrides, "PATH=VALUE",
                    "change a key of the scene, as time.frames=10; may be repeated"),
        CHOICE_OPTION("progress", 0, &words->progress, "auto|json|none", progress_choices,
                      "how progress is shown on standard error (default: auto)"),
        CHOICE_OPTION("write", 0, &words->write, "vtp", write_choices,
                      "also write VTP and PVD files, which ParaView reads"),
        CHOICE_OPTION("record", 0, &words->record, "plain|velocities|debug", record_choices,
                      "also keep velocities of each frame; debug: contacts and patches, too "
                      "(default: plain)"),
        TEXT_OPTION("from", 0, &words->from, "RUN[:FRAME]",
                    "begin with the frames of RUN, which keeps velocities, up to FRAME (default: "
                    "its last), and continue from there with the scene as it is now"),
        TEXT_OPTION("list-left", 0, &words->left, "FILE",
                    "if the start is refused, list the pairs of triangles that intersect as CSV"),
        TEXT_OPTION("checkpoint-every", 0, &words->checkpoint, "STEPS|SECONDS",
                    "time between checkpoints: 100 steps, or 30s (default: 30s)"),
    };
    const command_spec command = COMMAND(
        "run", "SCENE.yaml", options, 1, 1,
        "Simulates the scene and writes a directory: the mesh of each body as OBJ, its\n"
        "frames as PC2 (Blender's Mesh Cache) if it moves, report.csv with a line for each\n"
        "step, and checkpoints. --resume continues from the last checkpoint.\n"
        "Ctrl-C undoes the step under way, writes a checkpoint and exits with 130; a\n"
        "second one ends at once. While the start is untangled, Ctrl-C ends the run before\n"
        "anything is written.");
    size_t operand_count = 0;
    return options_parse(&command, argc, argv, &operand_count);
}

static bool use_words(const run_words *words, const char *scene_path,
                      char default_directory[DIRECTORY_SIZE], run_options *options) {
    options->scene_path = scene_path;
    options->directory = words->directory;
    options->left_path = words->left;
    options->threads = (int)words->threads;
    options->resumes = words->resumes;
    options->replaces = words->replaces;
    options->writes_vtp = words->write != NULL;
    options->from = words->from;
    options->records_debug = strcmp(words->record, "debug") == 0;
    options->records_velocities = strcmp(words->record, "velocities") == 0;
    if (options->resumes && options->replaces) {
        app_print_message("run",
                          "--resume keeps the run and --force replaces it; give one of them");
        return false;
    }
    if (!words->directory && !name_directory(scene_path, default_directory)) {
        app_print_message("run", "the scene's name is too long for a directory; give -o DIR");
        return false;
    }
    if (!words->directory) options->directory = default_directory;
    return read_checkpoint_interval(words->checkpoint, options);
}

/* ---- what a session holds ---- */

/* The cloth as it starts: untangled. The positions are good until the first step. */
static tulle_mesh_view get_start_mesh(const run_session *session, size_t cloth) {
    tulle_mesh_view mesh = tulle_scene_get_cloth_mesh(session->scene, cloth);
    if (tulle_world_get_untangle_report(session->built.world).intersections > 0)
        mesh.positions =
            tulle_cloth_get_positions(session->built.world, session->built.cloths[cloth], NULL);
    return mesh;
}

static void describe_bodies(run_session *session) {
    const tulle_scene *const loaded = session->scene;
    size_t const cloth_count = session->built.cloth_count;
    for (size_t i = 0; i < cloth_count; i++)
        session->bodies[i] = (tulle_run_body){.name = tulle_scene_get_cloth_name(loaded, i),
                                              .mesh = get_start_mesh(session, i)};
    for (size_t i = 0; i < session->built.obstacle_count; i++)
        session->bodies[cloth_count + i] =
            (tulle_run_body){.name = tulle_scene_get_obstacle_name(loaded, i),
                             .mesh = tulle_scene_get_obstacle_mesh(loaded, i),
                             .is_obstacle = 1,
                             .is_static = !tulle_scene_is_obstacle_moving(loaded, i),
                             .is_dynamic = tulle_scene_is_obstacle_dynamic(loaded, i)};
}

static tulle_status fail_memory(tulle_error *error) {
    return error_set(error, TULLE_ERROR_OUT_OF_MEMORY,
                     "out of memory for the run; a coarser mesh needs less");
}

static int is_stopped(void *context) {
    run_session *const session = context;
    if (tulle_world_get_step_progress(session->built.world).is_under_way)
        progress_show_step_under_way(session);
    else
        progress_show_untangling(session);
    return interrupt_is_pending();
}

static tulle_status prepare_world(run_session *session, tulle_error *error) {
    tulle_status status = tulle_scene_build_world(session->scene, session->options.threads, NULL,
                                                  &session->built, error);
    /* a checkpoint takes the place of the first state, which need not be untangled again */
    session->goes_on =
        session->options.resumes && tulle_run_has_checkpoint(session->options.directory) != 0;
    if (status == TULLE_OK) tulle_world_set_stop_request(session->built.world, is_stopped, session);
    bool const has_source = session->options.from && !session->goes_on;
    if (status == TULLE_OK && !session->goes_on && !has_source)
        status = app_start_world(session->built.world, session->options.scene_path, error);
    if (status != TULLE_OK) return status;
    const char *const message = tulle_world_last_message(session->built.world);
    if (message[0]) progress_show_message(session, &(tulle_step_report){0}, message);
    snprintf(session->totals.message, sizeof session->totals.message, "%s", message);
    session->body_count = session->built.cloth_count + session->built.obstacle_count;
    session->bodies = calloc(session->body_count, sizeof *session->bodies);
    session->positions = calloc(session->body_count, sizeof *session->positions);
    session->velocities = calloc(session->body_count, sizeof *session->velocities);
    session->is_present = calloc(session->body_count, sizeof *session->is_present);
    session->transforms = calloc(session->body_count, sizeof *session->transforms);
    session->lags = calloc(session->body_count + 1, sizeof *session->lags);
    if (!session->bodies || !session->positions || !session->velocities || !session->is_present ||
        !session->transforms || !session->lags)
        return fail_memory(error);
    describe_bodies(session);
    if ((session->options.records_debug || session->options.records_velocities) &&
        !debug_record_prepare(&session->debug, session))
        return fail_memory(error);
    if (has_source) status = run_source_open(session, error);
    return has_source && status == TULLE_OK ? run_source_start(session, error) : status;
}

static void release_session(run_session *session) {
    tulle_scene_destroy_world(&session->built);
    tulle_scene_destroy(session->scene);
    debug_record_release(&session->debug);
    run_source_close(session->source, session->body_count);
    free(session->bodies);
    free(session->positions);
    free(session->velocities);
    free(session->is_present);
    free(session->transforms);
    free(session->lags);
}

/* ---- the output directory ---- */

static tulle_run_def make_run_def(const run_session *session, const tulle_paper_options *paper,
                                  const tulle_untangle_report *untangle) {
    const run_options *const options = &session->options;
    tulle_run_def def = tulle_run_def_default();
    def.directory = options->directory;
    def.scene_path = options->scene_path;
    def.scene_text = tulle_scene_get_canonical_text(session->scene);
    def.scene_hash = tulle_scene_get_hash(session->scene);
    def.seed = tulle_scene_get_seed(session->scene);
    def.time_step = tulle_scene_get_time_step(session->scene);
    def.steps_per_frame = tulle_scene_get_steps_per_frame(session->scene);
    def.frame_count = options->frame_count;
    def.threads = options->threads;
    def.writes_vtp = options->writes_vtp;
    def.records_debug = options->records_debug;
    def.records_velocities = options->records_velocities;
    def.detection = &paper->detection;
    def.has_response = 1;
    def.response = paper->response;
    def.motion_space = paper->motion_space;
    def.untangle = untangle;
    def.bodies = session->bodies;
    def.body_count = session->body_count;
    return def;
}

/* The world becomes what the checkpoint says. */
static tulle_status load_checkpoint(run_session *session, const tulle_run_checkpoint *checkpoint,
                                    tulle_error *error) {
    tulle_world *const world = session->built.world;
    tulle_status const status =
        tulle_world_load_state(world, checkpoint->bytes, checkpoint->byte_count, error);
    if (status != TULLE_OK) {
        snprintf(error->file, sizeof error->file, "%s/checkpoint.bin", session->options.directory);
        return status;
    }
    if (tulle_world_get_state_hash(world) != checkpoint->state_hash ||
        tulle_world_get_step_count(world) != checkpoint->step)
        return error_set_at(error, TULLE_ERROR_PARSE, session->options.directory, 0, 0,
                            "the checkpoint gives another state than it was made of; was it "
                            "written by another version? Use --force to start again");
    session->checkpoint_step = checkpoint->step;
    return TULLE_OK;
}

/* How the steps before the checkpoint went: by report.csv, which ends there. The place of the
 * largest stretch is known where the run was ended in good order. */
static tulle_status take_over_outcome(run_session *session, tulle_error *error) {
    tulle_run_outcome *const outcome = &session->outcome;
    tulle_run_reader *reader = NULL;
    const tulle_step_report *reports = NULL;
    size_t count = 0;
    tulle_status status = tulle_run_reader_open(session->options.directory, &reader, error);
    if (status == TULLE_OK) status = tulle_run_reader_get_reports(reader, &reports, &count, error);
    for (size_t i = 0; i < count && status == TULLE_OK; i++)
        tulle_run_outcome_add(outcome, &reports[i]);
    tulle_run_reader_close(reader);
    const tulle_run_outcome *const before = tulle_run_get_former_outcome(session->writer);
    if (!before || !before->has_stretch_place ||
        before->largest_stretch_time != outcome->largest_stretch_time)
        return status;
    outcome->has_stretch_place = 1;
    outcome->stretch_body = before->stretch_body;
    memcpy(outcome->stretch_vertices, before->stretch_vertices, sizeof outcome->stretch_vertices);
    memcpy(outcome->stretch_position, before->stretch_position, sizeof outcome->stretch_position);
    return status;
}

/* Tells what was damaged and is made good. */
static void say_notes(const run_session *session) {
    const char *notes = tulle_run_get_notes(session->writer);
    while (*notes) {
        int const length = (int)strcspn(notes, "\n");
        app_print_message("run", "%.*s", length, notes);
        notes += length + (notes[length] == '\n');
    }
}

/* Makes or takes over the directory; *is_new: nothing is written to it yet. */
static tulle_status open_directory(run_session *session, bool *is_new, tulle_error *error) {
    tulle_paper_options const paper = tulle_world_get_paper_options(session->built.world);
    tulle_untangle_report const untangle = tulle_world_get_untangle_report(session->built.world);
    tulle_run_def const def = make_run_def(session, &paper, &untangle);
    *is_new = true;
    if (!session->options.resumes)
        return tulle_run_create(&def,
                                session->options.replaces ? TULLE_RUN_REPLACE : TULLE_RUN_REFUSE,
                                &session->writer, error);
    tulle_run_checkpoint checkpoint = {0};
    tulle_status status = tulle_run_resume(&def, &session->writer, &checkpoint, error);
    if (status == TULLE_OK) say_notes(session);
    if (status == TULLE_OK && !checkpoint.bytes && session->goes_on)
        status = error_set_at(error, TULLE_ERROR_IO, session->options.directory, 0, 0,
                              "another process removed the checkpoint while the scene was loaded; "
                              "run the same command again");
    if (status == TULLE_OK && checkpoint.bytes) {
        *is_new = false;
        status = load_checkpoint(session, &checkpoint, error);
        if (status == TULLE_OK) status = take_over_outcome(session, error);
    }
    tulle_run_free_checkpoint(&checkpoint);
    return status;
}

/* ---- the end ---- */

enum { OUTCOME_SIZE = 2048 /* [bytes] of what did not go well, in words */ };

/* Whether pairs were left untested without a proof. */
static bool skips_unproven(tulle_world_detection detection) {
    return !detection.has_certificate &&
           (detection.method == TULLE_DETECT_PATCHES || detection.method == TULLE_DETECT_PAPER);
}

/* failure: why the run could not go on, or null. */
static void print_summary(const run_session *session, const char *failure) {
    const run_totals *const totals = &session->totals;
    tulle_world *const world = session->built.world;
    app_print_names(stdout, "result: %s\n", session->options.directory);
    tulle_untangle_report const untangle = tulle_world_get_untangle_report(world);
    if (untangle.intersections > 0)
        printf("untangled: %llu pairs of triangles that intersected at the start, in %u rounds; "
               "vertices moved by %.4g mm at most\n",
               (unsigned long long)untangle.intersections, untangle.rounds,
               1000.0 * untangle.largest_displacement);
    printf("frames: %u, the start counted, to %.6g s in %llu steps\n",
           tulle_run_get_frame_count(session->writer), tulle_world_get_time(world),
           (unsigned long long)tulle_world_get_step_count(world));
    if (totals->steps > 0) {
        printf("steps now: %llu, %.4g ms each\n", (unsigned long long)totals->steps,
               1000.0 * totals->seconds / (double)totals->steps);
        printf("contacts: %llu at most\n", (unsigned long long)totals->most_contacts);
        if (totals->ignored_pairs > 0)
            printf(
                "caught: %llu pairs of triangles intersect still (start_intersections: ignore)\n",
                (unsigned long long)totals->ignored_pairs);
        if (isfinite(totals->smallest_gap))
            printf("smallest gap: %.4g mm\n", 1000.0 * totals->smallest_gap);
    }
    if (session->outcome.steps > 0) {
        const char *const name =
            session->outcome.has_stretch_place
                ? tulle_scene_get_cloth_name(session->scene, session->outcome.stretch_body)
                : NULL;
        char text[OUTCOME_SIZE];
        tulle_run_outcome_describe(&session->outcome, name, failure, text, sizeof text);
        for (const char *line = strtok(text, "\n"); line; line = strtok(NULL, "\n"))
            app_print_names(stdout, "trouble: %s\n", line);
    }
    if (!failure && totals->message[0])
        app_print_names(stdout, "first message: %s\n", totals->message);
    if (skips_unproven(tulle_world_get_paper_options(world).detection))
        printf("certificate: off; patches were skipped by their cones alone, so cloth may have "
               "passed through itself within one: tulle check judges the frames\n");
    printf("state hash: %016llx\n", (unsigned long long)tulle_world_get_state_hash(world));
}

/* Records how it ended and says so; the exit code. */
static int end_run(run_session *session, tulle_status status, tulle_error *error) {
    tulle_run_state const state = status == TULLE_OK                  ? TULLE_RUN_FINISHED
                                  : status == TULLE_ERROR_INTERRUPTED ? TULLE_RUN_INTERRUPTED
                                                                      : TULLE_RUN_FAILED;
    progress_end(session, tulle_run_state_name(state));
    uint64_t const steps = tulle_world_get_step_count(session->built.world);
    if (state == TULLE_RUN_FAILED) {
        app_print_error("run", error);
        app_print_message("run", "stopped after step %llu; all frames up to there are in %s",
                          (unsigned long long)steps, session->options.directory);
    }
    if (state == TULLE_RUN_INTERRUPTED)
        app_print_message(
            "run",
            "interrupted after step %llu; the same command with --resume continues from there",
            (unsigned long long)steps);
    print_summary(session, state == TULLE_RUN_FAILED ? error->message : NULL);
    tulle_run_set_outcome(session->writer, &session->outcome);
    tulle_error close_error = {0};
    tulle_status const closed = tulle_run_close(
        session->writer, state,
        state == TULLE_RUN_FAILED ? error->message : session->totals.message, &close_error);
    session->writer = NULL;
    if (closed != TULLE_OK && status == TULLE_OK) {
        app_print_error("run", &close_error);
        return app_exit_for_run(closed);
    }
    int const written = app_finish_output("run");
    return status != TULLE_OK ? app_exit_for_run(status) : written;
}

/* Says that the start intersects, where the scene lets it. */
static void say_what_is_ignored(run_session *session) {
    size_t count = 0;
    (void)tulle_world_get_intersections(session->built.world, &count);
    if (count == 0) return;
    char *const message = session->totals.message;
    snprintf(message, sizeof session->totals.message,
             "%zu pairs of triangles intersect at the start and are let be until they come apart "
             "(start_intersections: ignore)",
             count);
    app_print_message("run", "%s", message);
}

static int run_scene(run_session *session, const char *progress, tulle_error *error) {
    interrupt_catch();
    progress_begin(&session->progress, progress);
    tulle_status status = prepare_world(session, error);
    progress_bar_clear(&session->progress.bar);
    session->wanted_steps =
        (uint64_t)session->options.frame_count * tulle_scene_get_steps_per_frame(session->scene);
    bool is_new = true;
    if (status == TULLE_ERROR_INTERRUPTED) {
        app_print_message("run", "%s; nothing was written", error->message);
        return APP_EXIT_INTERRUPTED;
    }
    if (status == TULLE_OK) status = open_directory(session, &is_new, error);
    if (status != TULLE_OK) {
        app_print_error("run", error);
        tulle_error left_error = {0};
        if (status == TULLE_ERROR_INTERSECTING_START &&
            run_write_left(session, &left_error) != TULLE_OK)
            app_print_error("run", &left_error);
        tulle_run_close(session->writer, TULLE_RUN_FAILED, error->message, NULL);
        return status == TULLE_ERROR_DISK_FULL ? APP_EXIT_CANNOT_GO_ON : app_exit_for_input(status);
    }
    progress_begin(&session->progress, progress);
    progress_show_begin(session, !is_new);
    session->checkpoint_time = timer_now();
    session->totals.smallest_gap = INFINITY;
    if (is_new) say_what_is_ignored(session);
    if (is_new) status = run_write_start(session, error);
    if (status == TULLE_OK) status = run_step_to_end(session, error);
    return end_run(session, status, error);
}

/* Loads the scene, printing what is wrong with it; the exit code. */
static int load_scene(run_session *session, const option_list *overrides) {
    tulle_scene_problems *const problems = calloc(1, sizeof *problems);
    if (!problems) {
        app_print_message("run", "out of memory");
        return APP_EXIT_OUT_OF_MEMORY;
    }
    tulle_status const status = tulle_scene_load(session->options.scene_path, overrides->items,
                                                 overrides->count, &session->scene, problems);
    if (status != TULLE_OK) scene_print_problems(problems, stderr);
    for (size_t i = 0; status == TULLE_OK && i < tulle_scene_get_note_count(session->scene); i++)
        app_print_message("run", "%s", tulle_scene_get_note(session->scene, i));
    free(problems);
    return app_exit_for_input(status);
}

int app_run(int argc, char **argv) {
    run_words words = {.progress = "auto", .record = "plain", .checkpoint = checkpoint_default};
    options_outcome const outcome = read_words(argc, argv, &words);
    if (outcome != OPTIONS_READ) return options_exit(outcome);
    char default_directory[DIRECTORY_SIZE];
    run_session session = {0};
    if (!use_words(&words, argv[0], default_directory, &session.options)) return APP_EXIT_BAD_INPUT;
    int code = load_scene(&session, &words.overrides);
    if (code == APP_EXIT_FINE) {
        session.options.frame_count =
            words.frames > 0 ? (uint32_t)words.frames : tulle_scene_get_frame_count(session.scene);
        tulle_error error = {0};
        code = run_scene(&session, words.progress, &error);
    }
    release_session(&session);
    return code;
}
