/* app/convert/judge.c - see judge.h. */
#include "app/convert/judge.h"

#include "base/error.h"

#include <stdlib.h>

static tulle_status fail_memory(tulle_error *error) {
    return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "out of memory for judging the surface");
}

/* Meshes of the obstacles, and room for those that move. */
static tulle_status open_obstacles(convert_judge *judge, tulle_error *error) {
    const tulle_run_info *const info = tulle_run_reader_get_info(judge->source->run);
    judge->positions = calloc(info->body_count, sizeof *judge->positions);
    judge->meshes = calloc(info->body_count, sizeof *judge->meshes);
    if (!judge->positions || !judge->meshes) return fail_memory(error);
    judge->run_body_count = info->body_count;
    for (size_t i = 0; i < info->body_count; i++) {
        if (!info->bodies[i].is_obstacle) continue;
        tulle_status const status =
            tulle_run_reader_get_mesh(judge->source->run, i, &judge->meshes[i], error);
        if (status != TULLE_OK) return status;
        if (info->bodies[i].is_static) continue;
        judge->positions[i] = calloc(judge->meshes[i].vertex_count, 3 * sizeof(double));
        if (!judge->positions[i]) return fail_memory(error);
    }
    return TULLE_OK;
}

tulle_status convert_judge_open(convert_source *source, convert_judge *judge, tulle_error *error) {
    *judge = (convert_judge){.source = source, .capacity = 1};
    bool has_obstacles = false;
    if (source->kind == SOURCE_RUN) {
        const tulle_run_info *const info = tulle_run_reader_get_info(source->run);
        has_obstacles = !info->bodies[source->body].is_obstacle;
        if (has_obstacles) judge->capacity += info->body_count;
    }
    judge->bodies = calloc(judge->capacity, sizeof *judge->bodies);
    judge->simulated = calloc(judge->capacity, sizeof *judge->simulated);
    judge->names = calloc(judge->capacity, sizeof *judge->names);
    if (!judge->bodies || !judge->simulated || !judge->names) return fail_memory(error);
    return has_obstacles ? open_obstacles(judge, error) : TULLE_OK;
}

void convert_judge_close(convert_judge *judge) {
    for (size_t i = 0; i < judge->run_body_count; i++) free(judge->positions[i]);
    free(judge->positions);
    free(judge->meshes);
    free(judge->bodies);
    free(judge->simulated);
    free(judge->names);
    *judge = (convert_judge){0};
}

/* Adds the obstacles of the frame behind the body. */
static tulle_status add_obstacles(convert_judge *judge, uint32_t frame, size_t *count,
                                  tulle_error *error) {
    tulle_run_reader *const run = judge->source->run;
    for (size_t i = 0; i < judge->run_body_count; i++) {
        const tulle_run_body_info *const info = &tulle_run_reader_get_info(run)->bodies[i];
        if (!info->is_obstacle || !tulle_run_reader_is_present(run, frame, i)) continue;
        tulle_mesh_view mesh = judge->meshes[i];
        if (judge->positions[i]) {
            tulle_status const status =
                tulle_run_reader_read_positions(run, frame, i, judge->positions[i], error);
            if (status != TULLE_OK) return status;
            mesh.positions = judge->positions[i];
        }
        judge->names[*count] = info->name;
        judge->bodies[*count] = judge->simulated[*count] = (tulle_check_body){mesh, 1};
        (*count)++;
    }
    return TULLE_OK;
}

tulle_status convert_judge_frame(convert_judge *judge, uint32_t frame, tulle_mesh_view simulated,
                                 tulle_mesh_view subdivided, subdivided_verdict *verdict,
                                 tulle_error *error) {
    size_t count = 1;
    judge->names[0] = convert_source_get_name(judge->source);
    judge->bodies[0] = (tulle_check_body){subdivided, 0};
    judge->simulated[0] = (tulle_check_body){simulated, 0};
    tulle_status status = add_obstacles(judge, frame, &count, error);
    if (status != TULLE_OK) return status;
    subdivided_frame const judged = {
        .number = judge->source->kind == SOURCE_MESH ? SUBDIVIDED_NO_FRAME : (long)frame,
        .bodies = judge->bodies,
        .simulated = judge->simulated,
        .names = judge->names,
        .body_count = count};
    status = subdivided_check_frame(&judged, 0, verdict, error);
    if (status == TULLE_OK) subdivided_totals_add(&judge->totals, verdict);
    return status;
}
