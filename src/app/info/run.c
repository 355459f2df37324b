/* app/info/run.c - what `tulle info` prints of a run directory. */
#include "app/cli/run_damage.h"
#include "app/commands.h"
#include "app/info/info.h"
#include "base/words.h"

#include "tulle_io/run.h"

#include <stdio.h>
#include <string.h>

static const double DEGREES_PER_RADIAN = 57.295779513082323;

static void print_head(const char *path, const tulle_run_info *info) {
    app_print_names(stdout, "%s: run, %s%s%s\n", path, tulle_run_state_name(info->state),
                    info->message[0] ? ": " : "", info->message);
    app_print_names(stdout, "  %-16s %s (hash %016llx)\n", "scene", info->scene_path,
                    (unsigned long long)info->scene_hash);
    printf("  %-16s %llu\n", "seed", (unsigned long long)info->seed);
    app_print_names(stdout, "  %-16s tulle %s\n", "written by", info->version);
    printf("  %-16s %.6g s, %u a frame, %.6g frames a second\n", "step", info->time_step,
           info->steps_per_frame, 1.0 / (info->time_step * info->steps_per_frame));
}

/* How pairs were found. */
static void print_detection(const tulle_world_detection *detection) {
    if (!detection) return;
    printf("  %-16s %s", "detection", method_words[detection->method]);
    if (detection->method == TULLE_DETECT_PATCHES || detection->method == TULLE_DETECT_PAPER)
        printf(", %s cones, %.4g degrees, %s",
               detection->cone == TULLE_CONE_PAPER ? "paper's" : "Bernstein",
               detection->max_angle * DEGREES_PER_RADIAN,
               detection->has_certificate
                   ? "with certificates"
                   : "without certificates: pairs within a patch were not tested");
    putchar('\n');
}

static void print_response(const tulle_run_info *info) {
    static const char *const spaces[] = {"cones", "polyhedra"};
    if (!info->has_response) return;
    if (info->response == TULLE_RESPONSE_PAPER)
        printf("  %-16s paper's, motion spaces are %s\n", "response", spaces[info->motion_space]);
    else
        printf("  %-16s coupled\n", "response");
}

static void print_progress(const tulle_run_reader *reader, const tulle_run_info *info) {
    printf("  %-16s %u of %u, the start counted\n", "frames", info->frame_count,
           info->wanted_frame_count + 1);
    if (info->frame_count > 0) {
        double time = 0.0;
        uint64_t step = 0, hash = 0;
        tulle_run_reader_get_frame(reader, info->frame_count - 1, &time, &step, &hash);
        printf("  %-16s step %llu, %.6g s, state hash %016llx\n", "last frame",
               (unsigned long long)step, time, (unsigned long long)hash);
    }
    if (info->has_checkpoint)
        printf("  %-16s after step %llu\n", "checkpoint",
               (unsigned long long)info->checkpoint_step);
    else
        printf("  %-16s none\n", "checkpoint");
}

/* What did not go well, a line each. Where run.json does not say it, as of a run under way or a
 * killed one, the steps of report.csv are counted. */
static void print_trouble(tulle_run_reader *reader, const tulle_run_info *info) {
    tulle_run_outcome outcome = {0};
    if (info->outcome) {
        outcome = *info->outcome;
    } else {
        const tulle_step_report *reports = NULL;
        size_t count = 0;
        (void)tulle_run_reader_get_reports(reader, &reports, &count, NULL);
        for (size_t i = 0; i < count; i++) tulle_run_outcome_add(&outcome, &reports[i]);
    }
    if (outcome.steps == 0) return;
    char text[2048];
    tulle_run_outcome_describe(&outcome, info->bodies[outcome.stretch_body].name,
                               info->state == TULLE_RUN_FAILED ? info->message : NULL, text,
                               sizeof text);
    const char *label = "trouble";
    for (const char *line = strtok(text, "\n"); line; line = strtok(NULL, "\n")) {
        app_print_names(stdout, "  %-16s %s\n", label, line);
        label = "";
    }
    if (info->state != TULLE_RUN_FAILED && info->message && info->message[0])
        app_print_names(stdout, "  %-16s %s\n", "first message", info->message);
}

/* What debug records cost. */
static void print_debug(const tulle_run_info *info) {
    if (!info->has_velocities) return;
    double const size = (double)info->debug_byte_count;
    printf("  %-16s debug.bin, %.4g MB", info->has_debug ? "debug records" : "velocities",
           size * 1e-6);
    if (info->frame_count > 0) printf(", %.4g kB a frame", size * 1e-3 / info->frame_count);
    putchar('\n');
}

/* Frames in which the body is there. */
static uint32_t count_present(const tulle_run_reader *reader, uint32_t frame_count, size_t body) {
    uint32_t count = 0;
    for (uint32_t frame = 0; frame < frame_count; frame++)
        count += tulle_run_reader_is_present(reader, frame, body) ? 1 : 0;
    return count;
}

static void print_body(const tulle_run_reader *reader, const tulle_run_info *info, size_t index) {
    const tulle_run_body_info *const body = &info->bodies[index];
    const char *const role = !body->is_obstacle ? "cloth"
                             : body->is_static  ? "obstacle"
                                                : "moving obstacle";
    app_print_names(stdout, "  %-16s %s: %u vertices, %u triangles, %s", role, body->name,
                    body->vertex_count, body->triangle_count, body->mesh_file);
    if (body->cache_file) app_print_names(stdout, ", %s", body->cache_file);
    uint32_t const present = count_present(reader, info->frame_count, index);
    if (present < info->frame_count)
        printf(", there in %u of %u frames", present, info->frame_count);
    putchar('\n');
}

/* Whether the files are as the run wrote them; an error if they are not. */
static tulle_status print_damage(tulle_run_reader *reader, const char *path, tulle_error *error) {
    tulle_status const status = run_damage_report("info", path, reader, error);
    printf("  %-16s %s\n", "files", status ? "damaged" : "as the run wrote them");
    return status;
}

tulle_status info_print_run(const char *path, tulle_error *error) {
    tulle_run_reader *reader = NULL;
    tulle_status status = tulle_run_reader_open(path, &reader, error);
    if (status != TULLE_OK) return status;
    const tulle_run_info *const info = tulle_run_reader_get_info(reader);
    print_head(path, info);
    print_progress(reader, info);
    print_trouble(reader, info);
    print_detection(info->detection);
    print_response(info);
    print_debug(info);
    for (size_t i = 0; i < info->body_count; i++) print_body(reader, info, i);
    status = print_damage(reader, path, error);
    tulle_run_reader_close(reader);
    return status;
}
