/* app/check/check.c - `tulle check`: exact intersection test of mesh files and of every frame of
 * runs and animations.
 *
 * Input: mesh files, each a frame of its own (or, with --together, the cloths of one frame),
 * animations, and run directories. Output: a line a frame, a line an intersecting pair, a closing
 * line with the sums; the exit code says whether there was any intersection. */
#define _POSIX_C_SOURCE 200809L
#include "app/check/animation.h"
#include "app/check/run.h"
#include "app/cli/frame_range.h"
#include "app/cli/mesh_file.h"
#include "app/cli/options.h"
#include "app/commands.h"
#include "app/convert/names.h"
#include "base/arena.h"
#include "base/error.h"
#include "base/parallel.h"
#include "tulle_io/run.h"

#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

enum { LISTED = 1000, LISTED_JSON = 100000 }; /* pairs of a frame, where nothing else is said */
enum { THREAD_MAX = 256, LIST_MAX = 1000000000, OPERAND_MAX = 100000 };

typedef struct check_options {
    long threads;
    int is_together, welds;
    option_list obstacles, meshes; /* meshes: of point caches, in the order of these */
    const char *frames;            /* of run directories and animations; null: all */
    check_file *files;             /* operands, then obstacles */
    size_t operand_count;
    check_report report;
    mesh_file_notes *notes; /* count up while files are read */
} check_options;

static bool is_directory(const char *path) {
    struct stat status;
    return stat(path, &status) == 0 && S_ISDIR(status.st_mode);
}

static tulle_status read_mesh(const char *path, mesh_file_notes *notes, tulle_mesh *mesh,
                              tulle_error *error) {
    tulle_status const status = mesh_file_read_noted(path, notes, mesh, error);
    if (status != TULLE_OK || mesh->triangle_count > 0) return status;
    tulle_mesh_destroy(mesh);
    return error_set_at(error, TULLE_ERROR_INVALID_MESH, path, 0, 0,
                        "the file holds no triangles, so there is nothing to judge");
}

/* Judges one frame. Its meshes are given: the cloths first, then the obstacles. */
static tulle_status judge_meshes(const check_options *options, check_frame *frame,
                                 const tulle_mesh *meshes, size_t cloth_count,
                                 check_totals *totals) {
    for (size_t i = 0; i < frame->body_count; i++)
        frame->bodies[i] = (tulle_check_body){tulle_mesh_get_view(&meshes[i]), i >= cloth_count};
    check_frames_judge(frame, 1, parallel_resolve_threads((int)options->threads));
    if (frame->status == TULLE_OK) check_report_frame(&options->report, frame, totals);
    tulle_check_result_destroy(&frame->result);
    return frame->status;
}

/* Judges the files as the cloths of one frame, with the obstacles that the options name. */
static tulle_status check_files(const check_options *options, char **files, size_t file_count,
                                check_totals *totals, tulle_error *error) {
    memory heap = memory_default();
    arena scratch = arena_make(&heap);
    size_t const body_count = file_count + options->obstacles.count;
    check_frame frame = {.source = file_count > 1 ? "all files together" : files[0],
                         .number = CHECK_FRAME_OF_FILE,
                         .bodies = ARENA_NEW(&scratch, tulle_check_body, body_count),
                         .names = ARENA_NEW(&scratch, const char *, body_count)};
    tulle_mesh *const meshes = ARENA_NEW(&scratch, tulle_mesh, body_count);
    tulle_status status = TULLE_OK;
    if (!frame.bodies || !frame.names || !meshes)
        status = error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory for %zu files", body_count);
    while (status == TULLE_OK && frame.body_count < body_count) {
        size_t const i = frame.body_count;
        frame.names[i] = i < file_count ? files[i] : options->obstacles.items[i - file_count];
        meshes[i] = (tulle_mesh){0};
        status = read_mesh(frame.names[i], options->notes, &meshes[i], error);
        if (status == TULLE_OK) frame.body_count++;
    }
    if (status == TULLE_OK) {
        status = judge_meshes(options, &frame, meshes, file_count, totals);
        if (status != TULLE_OK)
            error_set_at(error, status, frame.source, 0, 0, "%s", frame.error.message);
    }
    for (size_t i = 0; i < frame.body_count; i++) tulle_mesh_destroy(&meshes[i]);
    arena_destroy(&scratch);
    return status;
}

/* The mesh of each point cache: of operands, then of obstacles. */
static tulle_status match_meshes(const check_options *options, char **operands, size_t count,
                                 check_file *files, tulle_error *error) {
    size_t mesh_count = 0;
    for (size_t i = 0; i < count + options->obstacles.count; i++) {
        const char *const path = i < count ? operands[i] : options->obstacles.items[i - count];
        bool const is_cache = !is_directory(path) && convert_is_cache(convert_get_format(path));
        bool const has_mesh = is_cache && mesh_count < options->meshes.count;
        files[i] = (check_file){path, has_mesh ? options->meshes.items[mesh_count++] : NULL};
    }
    if (mesh_count == options->meshes.count) return TULLE_OK;
    return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                     "--mesh is given %zu times, but there are %zu point caches (.pc2, .mdd)",
                     options->meshes.count, mesh_count);
}

/* Judges `count` operands from `first` on together, with the obstacles. files: of all operands,
 * then the obstacles. */
static tulle_status check_group(const check_options *options, char **operands, size_t first,
                                size_t count, check_totals *totals, tulle_error *error) {
    const check_file *const files = options->files;
    size_t const obstacle_count = options->obstacles.count;
    bool is_animation = false;
    check_file *const group = calloc(count + obstacle_count, sizeof *group);
    if (!group)
        return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory for %zu files", count);
    memcpy(group, files + first, count * sizeof *group);
    memcpy(group + count, files + options->operand_count, obstacle_count * sizeof *group);
    for (size_t i = 0; i < count + obstacle_count; i++)
        is_animation |= check_is_animation(group[i].path);
    check_animation_choice const choice = {.files = group,
                                           .cloth_count = count,
                                           .file_count = count + obstacle_count,
                                           .frames = options->frames,
                                           .threads = (int)options->threads,
                                           .welds = options->welds != 0};
    tulle_status status = TULLE_OK;
    if (is_animation)
        status = check_animations(&choice, &options->report, totals, error);
    else if (options->frames)
        status = error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, group[0].path, 0, 0,
                              "--frames goes with run directories and animations; a mesh file is "
                              "one frame");
    else if (options->welds)
        status = error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, group[0].path, 0, 0,
                              "--weld goes with animations");
    else
        status = check_files(options, operands + first, count, totals, error);
    free(group);
    return status;
}

static tulle_status check_directory(const check_options *options, const char *path,
                                    check_totals *totals, tulle_error *error) {
    if (!tulle_run_is_directory(path))
        return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, path, 0, 0,
                            "this directory holds no run.json; name a run directory or mesh files");
    if (options->is_together || options->obstacles.count > 0)
        return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, path, 0, 0,
                            "--together and --obstacle go with mesh files; a run directory brings "
                            "its own obstacles");
    check_run_choice const choice = {options->frames, (int)options->threads};
    return check_run_directory(path, choice, &options->report, totals, error);
}

static tulle_status check_operands(const check_options *options, char **operands, size_t count,
                                   check_totals *totals, tulle_error *error) {
    tulle_status status = TULLE_OK;
    if (options->is_together) {
        for (size_t i = 0; i < count; i++)
            if (is_directory(operands[i]))
                return check_directory(options, operands[i], totals, error);
        return check_group(options, operands, 0, count, totals, error);
    }
    for (size_t i = 0; i < count && status == TULLE_OK; i++)
        status = is_directory(operands[i]) ? check_directory(options, operands[i], totals, error)
                                           : check_group(options, operands, i, 1, totals, error);
    return status;
}

int app_check(int argc, char **argv) {
    mesh_file_notes notes = {.command = "check"};
    check_options options = {.report = {.list_limit = -1}, .notes = &notes};
    const option_spec specs[] = {
        INTEGER_OPTION("threads", 't', &options.threads, "N", 0, THREAD_MAX,
                       "threads; 0: one for each processor (default)"),
        TEXT_OPTION("frames", 'n', &options.frames, "RANGE",
                    "of runs and animations: " FRAME_RANGE_HELP),
        LIST_OPTION(
            "mesh", 'm', &options.meshes, "FILE",
            "the mesh whose points a point cache (.pc2, .mdd) moves; again for the next one"),
        FLAG_OPTION(
            "weld", 0, &options.welds,
            "of animations: vertices in the same place in all frames are one, as along seams"),
        FLAG_OPTION("json", 0, &options.report.is_json, "one JSON object a line instead of text"),
        INTEGER_OPTION(
            "list", 0, &options.report.list_limit, "N", 0, LIST_MAX,
            "list at most N pairs a frame; the sums count all (default: 1000, with --json 100000)"),
        FLAG_OPTION("together", 0, &options.is_together,
                    "judge all files as the cloths of one frame"),
        LIST_OPTION("obstacle", 0, &options.obstacles, "FILE",
                    "a file to judge every file against; may be repeated"),
    };
    const command_spec command = COMMAND(
        "check", "FILE|DIR ...", specs, 1, OPERAND_MAX,
        "Judges with exact arithmetic whether triangles intersect: in mesh files (OBJ, PLY, STL, "
        "VTP),\n"
        "in every frame of animations (.pc2, .mdd, .glb, .gltf, .usda, .npz, 'frame_%04d.obj')\n"
        "and of run directories, cloth with cloth, with itself and with obstacles.\n"
        "Exit code 0: nowhere, 1: somewhere, 2: input that cannot be judged.");
    size_t operand_count = 0;
    options_outcome const outcome = options_parse(&command, argc, argv, &operand_count);
    if (outcome != OPTIONS_READ) return options_exit(outcome);

    if (options.report.list_limit < 0)
        options.report.list_limit = options.report.is_json ? LISTED_JSON : LISTED;
    check_totals totals = {0};
    tulle_error error = {0};
    options.operand_count = operand_count;
    options.files = calloc(operand_count + options.obstacles.count, sizeof *options.files);
    tulle_status status = options.files
                              ? match_meshes(&options, argv, operand_count, options.files, &error)
                              : error_set(&error, TULLE_ERROR_OUT_OF_MEMORY,
                                          "no memory for %zu files", operand_count);
    if (status == TULLE_OK) status = check_operands(&options, argv, operand_count, &totals, &error);
    free(options.files);
    mesh_file_finish_notes(&notes);
    if (status != TULLE_OK) {
        int const written = app_finish_output("check");
        app_print_error("check", &error);
        return written != APP_EXIT_FINE ? written : app_exit_for_input(status);
    }
    check_report_totals(&options.report, &totals);
    int const written = app_finish_output("check");
    if (written != APP_EXIT_FINE) return written;
    return totals.intersection_count > 0 ? APP_EXIT_FALSE : APP_EXIT_FINE;
}
