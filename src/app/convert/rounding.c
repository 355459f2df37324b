/* app/convert/rounding.c - see rounding.h. */
#include "app/convert/rounding.h"

#include "app/cli/interrupt.h"
#include "base/error.h"
#include "io/run/run_rounding.h"

#include <stdio.h>
#include <stdlib.h>

/* The surfaces of the frames, at the places of the one at hand. */
typedef struct rounded_frames {
    convert_source *source;
    tulle_run_body *bodies;
    double **positions;
    double **written; /* of bodies that are written by poses; null: others */
    int *is_present;
    size_t count;
} rounded_frames;

static tulle_status fail_memory(tulle_error *error) {
    return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "out of memory for judging the rounding");
}

static const char *get_name(const void *context, size_t body) {
    return ((const rounded_frames *)context)->bodies[body].name;
}

static tulle_status open_frames(rounded_frames *all, const rounding_input *input,
                                tulle_error *error) {
    const tulle_run_info *const info =
        !input->read ? tulle_run_reader_get_info(all->source->run) : NULL;
    size_t const count = info ? info->body_count : 1;
    all->bodies = calloc(count, sizeof *all->bodies);
    all->positions = calloc(count, sizeof *all->positions);
    all->written = calloc(count, sizeof *all->written);
    all->is_present = calloc(count, sizeof *all->is_present);
    if (!all->bodies || !all->positions || !all->written || !all->is_present)
        return fail_memory(error);
    while (all->count < count) {
        size_t const i = all->count++;
        tulle_run_body *const body = &all->bodies[i];
        *body = (tulle_run_body){.name = convert_source_get_name(all->source), .mesh = input->mesh};
        if (info) {
            *body = (tulle_run_body){.name = info->bodies[i].name,
                                     .is_obstacle = info->bodies[i].is_obstacle,
                                     .is_dynamic = info->bodies[i].is_dynamic};
            tulle_status const status =
                tulle_run_reader_get_mesh(all->source->run, i, &body->mesh, error);
            if (status != TULLE_OK) return status;
        }
        all->positions[i] = calloc(body->mesh.vertex_count, 3 * sizeof(double));
        if (!all->positions[i]) return fail_memory(error);
        if (input->scene && input->scene->bodies[i].mesh &&
            !(all->written[i] = calloc(body->mesh.vertex_count, 3 * sizeof(double))))
            return fail_memory(error);
        body->mesh.positions = all->positions[i];
        all->is_present[i] = 1;
    }
    return TULLE_OK;
}

static void close_frames(rounded_frames *all) {
    for (size_t i = 0; i < all->count; i++) {
        free(all->positions[i]);
        free(all->written[i]);
    }
    free(all->bodies);
    free(all->positions);
    free(all->written);
    free(all->is_present);
}

/* All bodies of the run, turned and scaled. */
static tulle_status read_bodies(rounded_frames *all, const axes_change *change, uint32_t frame,
                                tulle_error *error) {
    tulle_run_reader *const run = all->source->run;
    for (size_t i = 0; i < all->count; i++) {
        tulle_status const status =
            tulle_run_reader_read_positions(run, frame, i, all->positions[i], error);
        if (status != TULLE_OK) return status;
        axes_apply(change, all->positions[i], all->bodies[i].mesh.vertex_count);
        all->is_present[i] = tulle_run_reader_is_present(run, frame, i);
    }
    return TULLE_OK;
}

static void note_frame(convert_rounding *rounding, uint32_t frame, const tulle_error *found) {
    if (rounding->frame_count++ > 0) return;
    rounding->first = frame;
    (void)snprintf(rounding->text, sizeof rounding->text, "%.500s", found->message);
}

tulle_status convert_rounding_judge(const rounding_input *input, convert_rounding *rounding,
                                    tulle_error *error) {
    *rounding = (convert_rounding){0};
    memory heap = memory_default();
    rounded_frames all = {.source = input->source};
    run_rounding judge = {0};
    tulle_status status = open_frames(&all, input, error);
    tulle_run_def def = tulle_run_def_default();
    def.bodies = all.bodies;
    def.body_count = all.count;
    if (status == TULLE_OK && !run_rounding_make(&judge, &heap, &def)) status = fail_memory(error);
    judge.unit = input->change->to.unit;
    for (uint32_t i = 0; i < frame_range_get_count(input->frames) && status == TULLE_OK; i++) {
        uint32_t const frame = frame_range_get(input->frames, i);
        status = input->read ? input->read(input->context, frame, all.positions[0], error)
                             : read_bodies(&all, input->change, frame, error);
        if (status == TULLE_OK && interrupt_is_pending())
            status = error_set(error, TULLE_ERROR_INTERRUPTED, "interrupted");
        if (status != TULLE_OK) break;
        tulle_run_frame const places = {.positions = (const double *const *)all.positions,
                                        .is_present = all.is_present};
        tulle_error found = {0};
        for (size_t k = 0; k < all.count; k++)
            if (all.written[k]) convert_scene_place_rigid(input->scene, k, i, all.written[k]);
        status = run_rounding_judge(&judge, &places, (const double *const *)all.written, get_name,
                                    &all, &found);
        if (status == TULLE_ERROR_LIMIT) {
            note_frame(rounding, frame, &found);
            status = TULLE_OK;
        } else if (status == TULLE_ERROR_INVALID_MESH) { /* as of strangers: corners repeated */
            rounding->is_unknown = true;
            (void)snprintf(rounding->text, sizeof rounding->text, "%.500s", found.message);
            status = TULLE_OK;
            break;
        } else if (status != TULLE_OK) {
            *error = found;
        }
    }
    run_rounding_release(&judge);
    close_frames(&all);
    return status;
}
