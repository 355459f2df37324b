/* app/reproduce_judge.c - the exact judge over every frame of the runs of `tulle reproduce`, and
 * the table of runs: sizes, machine time, contacts, rescues and what the judge found. */
#include "app/commands.h"
#include "app/interrupt.h"
#include "app/reproduce.h"
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

static tulle_status judge_frame(judged_run *judged, uint32_t frame, int threads, size_t *pair_count,
                                tulle_error *error) {
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

/* The last line of a table, as it should be. */
static void format_last(const judged_run *judged, char text[64]) {
    uint64_t hash = 0;
    uint32_t const last = judged->info->frame_count - 1;
    (void)tulle_run_reader_get_frame(judged->reader, last, NULL, NULL, &hash);
    snprintf(text, 64, "%u,%016" PRIx64 ",", (unsigned)last, hash);
}

/* Sums up the table; whether it is there and ends with the run's last frame. */
static bool read_table(const reproduce *self, const reproduce_run *run, const judged_run *judged,
                       reproduce_verdict *verdict) {
    char file[REPRODUCE_PATH_SIZE], path[REPRODUCE_PATH_SIZE], line[256] = "", last[64];
    name_table(run, file);
    reproduce_make_path(self, path, "%s", file);
    FILE *const stream = fopen(path, "r");
    if (!stream) return false;
    format_last(judged, last);
    bool is_last = false;
    if (!fgets(line, sizeof line, stream)) line[0] = '\0';
    while (fgets(line, sizeof line, stream)) {
        const char *const comma = strrchr(line, ',');
        uint64_t const pairs = comma ? strtoull(comma + 1, NULL, 10) : 0;
        verdict->frame_count++;
        verdict->bad_frame_count += pairs > 0;
        verdict->intersection_count += pairs;
        is_last = strncmp(line, last, strlen(last)) == 0;
    }
    fclose(stream);
    return is_last && verdict->frame_count == judged->info->frame_count;
}

static tulle_status judge_frames(reproduce *self, const char *name, judged_run *judged,
                                 reproduce_table *table, tulle_error *error) {
    tulle_status status = TULLE_OK;
    uint32_t const count = judged->info->frame_count;
    fputs("frame,state_hash,intersections\n", table->stream);
    reproduce_begin_work(self);
    for (uint32_t frame = 0; frame < count && status == TULLE_OK; frame++) {
        size_t pairs = 0;
        uint64_t hash = 0;
        (void)tulle_run_reader_get_frame(judged->reader, frame, NULL, NULL, &hash);
        status = judge_frame(judged, frame, self->threads, &pairs, error);
        if (status == TULLE_OK && interrupt_is_pending())
            status = error_set(error, TULLE_ERROR_INTERRUPTED, "interrupted");
        fprintf(table->stream, "%u,%016" PRIx64 ",%zu\n", (unsigned)frame, hash, pairs);
        reproduce_show_work(self, name, frame + 1, count);
    }
    reproduce_end_work(self);
    return status;
}

int reproduce_judge(reproduce *self, const reproduce_run *run) {
    char path[REPRODUCE_PATH_SIZE], file[REPRODUCE_PATH_SIZE], name[REPRODUCE_PATH_SIZE];
    reproduce_find_run(self, run, path);
    name_table(run, file);
    reproduce_name_run(run, name);
    judged_run judged = {0};
    tulle_error error = {0};
    reproduce_verdict verdict = {0};
    reproduce_table table = {0};
    int code = APP_EXIT_FINE;
    tulle_status status = open_run(path, &judged, &error);
    if (status == TULLE_OK && judged.info->frame_count == 0)
        status = error_set(&error, TULLE_ERROR_INVALID_ARGUMENT, "%s holds no whole frame", path);
    if (status == TULLE_OK && !read_table(self, run, &judged, &verdict)) {
        reproduce_show_job(self, name, "is judged");
        if (!reproduce_table_begin(&table)) code = APP_EXIT_OUT_OF_MEMORY;
        if (table.stream) status = judge_frames(self, name, &judged, &table, &error);
        if (table.stream && status == TULLE_OK) code = reproduce_table_end(self, &table, file);
        if (table.stream) fclose(table.stream);
        free(table.bytes);
    }
    if (status != TULLE_OK) code = reproduce_fail(&error);
    close_run(&judged);
    return code;
}

static void add_reports(judged_run *judged, reproduce_verdict *verdict) {
    const tulle_step_report *reports = NULL;
    size_t count = 0;
    if (tulle_run_reader_get_reports(judged->reader, &reports, &count, NULL) != TULLE_OK) return;
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
    snprintf(verdict->state, sizeof verdict->state, "%s", tulle_run_state_name(judged.info->state));
    tulle_run_reader_close(judged.reader);
    return is_judged;
}

int reproduce_write_runs(reproduce *self) {
    const reproduce_run *runs[REPRODUCE_RUNS_MAX];
    size_t const count = reproduce_list_runs(runs);
    reproduce_table table;
    if (!reproduce_table_begin(&table)) return APP_EXIT_OUT_OF_MEMORY;
    fputs("run,state,cloth_particles,cloth_triangles,obstacle_particles,obstacle_triangles,frames,"
          "simulated_seconds,step_seconds,rescues_per_1000_contacts,bad_frames,intersections\n",
          table.stream);
    for (size_t i = 0; i < count; i++) {
        reproduce_verdict verdict;
        char name[REPRODUCE_PATH_SIZE];
        if (!reproduce_read_verdict(self, runs[i], &verdict)) continue;
        reproduce_name_run(runs[i], name);
        double const rescues = verdict.contacts > 0
                                   ? 1000.0 * (double)verdict.rescues / (double)verdict.contacts
                                   : 0.0;
        fprintf(table.stream, "%s,%s,%zu,%zu,%zu,%zu,%u,%.6g,%.6g,%.3g,%u,%" PRIu64 "\n", name,
                verdict.state, verdict.cloth_vertices, verdict.cloth_triangles,
                verdict.obstacle_vertices, verdict.obstacle_triangles,
                (unsigned)verdict.frame_count, verdict.simulated_seconds, verdict.step_seconds,
                rescues, (unsigned)verdict.bad_frame_count, verdict.intersection_count);
    }
    return reproduce_table_end(self, &table, "runs.csv");
}
