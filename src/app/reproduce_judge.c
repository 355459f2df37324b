/* app/reproduce_judge.c - the exact judge over every frame of the runs of `tulle reproduce`, and
 * the table of runs: sizes, machine time, contacts, rescues and what the judge found. */
#include "app/cli/interrupt.h"
#include "app/commands.h"
#include "app/reproduce_kept.h"
#include "base/error.h"

#include "tulle/check.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

/* A frame of a run on its way to the judge. */
typedef struct judged_run {
    tulle_run_reader *reader;
    const tulle_run_info *info;
    tulle_check_body *bodies;
    double **positions; /* of each body; null for static ones */
    tulle_mesh_view *meshes;
} judged_run;

static void name_table(const reproduce_run *run, char file[REPRODUCE_PATH_SIZE]) {
    char name[REPRODUCE_PATH_SIZE - 16];
    char whole[REPRODUCE_PATH_SIZE];
    reproduce_name_run(run, whole);
    snprintf(name, sizeof name, "%.*s", (int)sizeof name - 1, whole);
    snprintf(file, REPRODUCE_PATH_SIZE, "judged/%s.csv", name);
}

static tulle_status open_run(const char *path, judged_run *judged, tulle_error *error) {
    tulle_status status = tulle_run_reader_open(path, &judged->reader, error);
    if (status != TULLE_OK) return status;
    judged->info = tulle_run_reader_get_info(judged->reader);
    size_t const count = judged->info->body_count;
    judged->bodies = calloc(count, sizeof *judged->bodies);
    judged->positions = calloc(count, sizeof *judged->positions);
    judged->meshes = calloc(count, sizeof *judged->meshes);
    bool has_memory = judged->bodies && judged->positions && judged->meshes;
    for (size_t i = 0; has_memory && status == TULLE_OK && i < count; i++) {
        status = tulle_run_reader_get_mesh(judged->reader, i, &judged->meshes[i], error);
        if (status != TULLE_OK || judged->info->bodies[i].is_static) continue;
        judged->positions[i] = malloc(3 * judged->meshes[i].vertex_count * sizeof(double));
        has_memory = judged->positions[i] != NULL;
    }
    return has_memory
               ? status
               : error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory for a frame of %s", path);
}

static void close_run(judged_run *judged) {
    for (size_t i = 0; judged->positions && i < judged->info->body_count; i++)
        free(judged->positions[i]);
    free(judged->positions);
    free(judged->bodies);
    free(judged->meshes);
    tulle_run_reader_close(judged->reader);
}

static tulle_status judge_frame(judged_run *judged, uint32_t frame, int threads,
                                uint64_t *pair_count, tulle_error *error) {
    size_t count = 0;
    for (size_t i = 0; i < judged->info->body_count; i++) {
        const tulle_run_body_info *const body = &judged->info->bodies[i];
        if (!tulle_run_reader_is_present(judged->reader, frame, i)) continue;
        tulle_mesh_view mesh = judged->meshes[i];
        if (judged->positions[i]) {
            tulle_status const status = tulle_run_reader_read_positions(
                judged->reader, frame, i, judged->positions[i], error);
            if (status != TULLE_OK) return status;
            mesh.positions = judged->positions[i];
        }
        judged->bodies[count++] = (tulle_check_body){mesh, body->is_obstacle && !body->is_dynamic};
    }
    tulle_check_result result = {0};
    tulle_status const status =
        tulle_check_intersections(judged->bodies, count, threads, &result, error);
    *pair_count = result.pair_count;
    tulle_check_result_destroy(&result);
    return status;
}

/* How a frame's line begins: the frame is that of the state that was judged. */
static void format_key(const judged_run *judged, uint32_t frame, char text[64]) {
    uint64_t hash = 0;
    (void)tulle_run_reader_get_frame(judged->reader, frame, NULL, NULL, &hash);
    snprintf(text, 64, "%u,%016" PRIx64 ",", (unsigned)frame, hash);
}

/* How the table begins: a state's verdict holds for the obstacles of its scene. */
static void format_head(const judged_run *judged, char text[128]) {
    snprintf(text, 128, "# scene %016" PRIx64 "\nframe,state_hash,intersections\n",
             judged->info->scene_hash);
}

/* Pairs that intersect, as the end of a frame's line tells them: digits and a line feed. */
static bool read_pairs(const char *text, uint64_t *pairs) {
    size_t const digits = strspn(text, "0123456789");
    *pairs = strtoull(text, NULL, 10);
    return digits > 0 && text[digits] == '\n';
}

/* Sums up the table; whether it is there, of this run and whole. */
static bool read_table(const reproduce *self, const reproduce_run *run, const judged_run *judged,
                       reproduce_verdict *verdict) {
    char file[REPRODUCE_PATH_SIZE], path[REPRODUCE_PATH_SIZE], line[256] = "", key[64], head[128];
    name_table(run, file);
    reproduce_make_path(self, path, "%s", file);
    FILE *const stream = fopen(path, "r");
    if (!stream) return false;
    format_head(judged, head);
    bool is_this = fgets(line, sizeof line, stream) && strncmp(line, head, strlen(line)) == 0 &&
                   fgets(line, sizeof line, stream);
    while (is_this && fgets(line, sizeof line, stream)) {
        is_this = verdict->frame_count < judged->info->frame_count;
        if (!is_this) break;
        format_key(judged, verdict->frame_count, key);
        uint64_t pairs = 0;
        is_this = strncmp(line, key, strlen(key)) == 0 && read_pairs(line + strlen(key), &pairs);
        verdict->frame_count++;
        verdict->bad_frame_count += pairs > 0;
        verdict->intersection_count += pairs;
    }
    fclose(stream);
    return is_this && verdict->frame_count == judged->info->frame_count;
}

/* A frame's line: what is known of this state, or the judge's verdict. */
static tulle_status write_frame(reproduce *self, judged_run *judged, uint32_t frame,
                                reproduce_kept *known, reproduce_kept *table, tulle_error *error) {
    char key[64];
    uint64_t pairs = 0;
    format_key(judged, frame, key);
    const char *const row = reproduce_kept_find(known, key);
    tulle_status status = TULLE_OK;
    if (row && read_pairs(row, &pairs))
        reproduce_skip_work(self);
    else
        status = judge_frame(judged, frame, self->threads, &pairs, error);
    if (status == TULLE_OK && interrupt_is_pending())
        status = error_set(error, TULLE_ERROR_INTERRUPTED, "interrupted");
    return status == TULLE_OK ? reproduce_kept_add(table, error, "%s%" PRIu64 "\n", key, pairs)
                              : status;
}

/* Judges what is not known, and saves it also after a failure or an interruption. */
static tulle_status judge_frames(reproduce *self, const char *name, const char *file,
                                 judged_run *judged, tulle_error *error) {
    uint32_t const count = judged->info->frame_count;
    char head[128];
    format_head(judged, head);
    reproduce_kept known = {0}, table = {0};
    tulle_status status = reproduce_kept_open(self, file, head, &known, error);
    if (status == TULLE_OK) status = reproduce_kept_open(self, file, head, &table, error);
    if (status == TULLE_OK) reproduce_kept_forget(&table);
    reproduce_begin_work(self);
    for (uint32_t frame = 0; frame < count && status == TULLE_OK; frame++) {
        status = write_frame(self, judged, frame, &known, &table, error);
        reproduce_show_work(self, name, frame + 1, count);
    }
    reproduce_end_work(self);
    tulle_error ignored = {0};
    tulle_status const saved =
        table.text ? reproduce_kept_save(&table, status == TULLE_OK ? error : &ignored) : status;
    reproduce_kept_close(&known);
    reproduce_kept_close(&table);
    return status == TULLE_OK ? saved : status;
}

int reproduce_judge(reproduce *self, const reproduce_run *run) {
    char path[REPRODUCE_PATH_SIZE], file[REPRODUCE_PATH_SIZE], name[REPRODUCE_PATH_SIZE];
    reproduce_find_run(self, run, path);
    name_table(run, file);
    reproduce_name_run(run, name);
    judged_run judged = {0};
    tulle_error error = {0};
    reproduce_verdict verdict = {0};
    tulle_status status = open_run(path, &judged, &error);
    if (status == TULLE_OK && judged.info->frame_count == 0)
        status = error_set(&error, TULLE_ERROR_INVALID_ARGUMENT, "%s holds no whole frame", path);
    if (status == TULLE_OK && !read_table(self, run, &judged, &verdict)) {
        reproduce_show_job(self, name, "is judged");
        status = judge_frames(self, name, file, &judged, &error);
    }
    close_run(&judged);
    return status == TULLE_OK ? APP_EXIT_FINE : reproduce_fail(&error);
}

static void add_reports(judged_run *judged, reproduce_verdict *verdict) {
    const tulle_step_report *reports = NULL;
    size_t count = 0;
    verdict->has_reports =
        reproduce_get_reports(judged->reader, &reports, &count, NULL) == TULLE_OK;
    if (!verdict->has_reports) return;
    verdict->step_count = count;
    for (size_t i = 0; i < count; i++) {
        verdict->step_seconds += reports[i].total_seconds;
        verdict->simulated_seconds = reports[i].time;
        verdict->contacts += reports[i].contacts;
        verdict->rescues += reports[i].rescue_impact_zones + reports[i].rescue_component_scalings +
                            reports[i].rescue_global_scalings;
    }
}

bool reproduce_read_verdict(const reproduce *self, const reproduce_run *run,
                            reproduce_verdict *verdict) {
    char path[REPRODUCE_PATH_SIZE];
    *verdict = (reproduce_verdict){0};
    reproduce_find_run(self, run, path);
    judged_run judged = {0};
    if (!tulle_run_is_directory(path) ||
        tulle_run_reader_open(path, &judged.reader, NULL) != TULLE_OK)
        return false;
    judged.info = tulle_run_reader_get_info(judged.reader);
    bool const is_judged = judged.info->frame_count > 0 && read_table(self, run, &judged, verdict);
    for (size_t i = 0; i < judged.info->body_count; i++) {
        const tulle_run_body_info *const body = &judged.info->bodies[i];
        if (body->is_obstacle) {
            verdict->obstacle_vertices += body->vertex_count;
            verdict->obstacle_triangles += body->triangle_count;
        } else {
            verdict->cloth_vertices += body->vertex_count;
            verdict->cloth_triangles += body->triangle_count;
        }
    }
    add_reports(&judged, verdict);
    verdict->time_step = judged.info->time_step;
    reproduce_read_conditions(self, run, verdict->conditions);
    snprintf(verdict->state, sizeof verdict->state, "%s", tulle_run_state_name(judged.info->state));
    tulle_run_reader_close(judged.reader);
    return is_judged;
}

/* What report.csv tells of a run; nothing where it does not tell of all steps. */
static void write_steps(FILE *stream, const reproduce_verdict *verdict) {
    double const contacts = (double)verdict->contacts;
    if (!verdict->has_reports)
        fputs(",,", stream);
    else
        fprintf(stream, "%.6g,%.6g,%.3g", verdict->simulated_seconds, verdict->step_seconds,
                contacts > 0.0 ? 1000.0 * (double)verdict->rescues / contacts : 0.0);
}

int reproduce_write_runs(reproduce *self) {
    const reproduce_run *runs[REPRODUCE_RUNS_MAX];
    size_t const count = reproduce_list_runs(runs);
    reproduce_table table;
    if (!reproduce_table_begin(&table)) return APP_EXIT_OUT_OF_MEMORY;
    fputs("run,state,cloth_particles,cloth_triangles,obstacle_particles,obstacle_triangles,frames,"
          "simulated_seconds,step_seconds,rescues_per_1000_contacts,bad_frames,intersections,time_"
          "step,conditions\n",
          table.stream);
    for (size_t i = 0; i < count; i++) {
        reproduce_verdict verdict;
        char name[REPRODUCE_PATH_SIZE];
        if (!reproduce_read_verdict(self, runs[i], &verdict)) continue;
        reproduce_name_run(runs[i], name);
        fprintf(table.stream, "%s,%s,%zu,%zu,%zu,%zu,%u,", name, verdict.state,
                verdict.cloth_vertices, verdict.cloth_triangles, verdict.obstacle_vertices,
                verdict.obstacle_triangles, (unsigned)verdict.frame_count);
        write_steps(table.stream, &verdict);
        fprintf(table.stream, ",%u,%" PRIu64 ",%g,%s\n", (unsigned)verdict.bad_frame_count,
                verdict.intersection_count, verdict.time_step, verdict.conditions);
    }
    return reproduce_table_end(self, &table, "runs.csv");
}
