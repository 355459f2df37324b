/* step/undo.c - a step works on a copy of the state, all or nothing.
 *
 * The copy takes the place of the state when the step has succeeded. What the step changes outside
 * the copy (who is present, patches) is noted before and put back when the
 * step fails or is repeated. */
#include "step/undo.h"

#include "step/bodies/bodies.h"
#include "step/bodies/bodies_sleep.h"

#include <string.h>

tulle_status step_keep_patches(step_work *work) {
    work->kept_patch_bytes.count = 0;
    if (!work->patches) return TULLE_OK;
    size_t const size = kept_patches_save(work->patches, NULL);
    if (!ARRAY_RESERVE(work->heap, &work->kept_patch_bytes, size)) return TULLE_ERROR_OUT_OF_MEMORY;
    work->kept_patch_bytes.count = kept_patches_save(work->patches, work->kept_patch_bytes.data);
    return TULLE_OK;
}

/* Patches that cannot be loaded for want of memory are gone, which is safe. */
void step_restore_patches(step_work *work) {
    if (!work->patches) return;
    (void)kept_patches_load(work->patches, work->kept_patch_bytes.data,
                            work->kept_patch_bytes.count);
}

void step_undo(const step_model *model, step_work *work) {
    for (size_t i = 0; i < model->obstacles.count; i++) {
        frame_cache *const frames = model->obstacles.data[i].frames;
        work->surfaces[model->cloths.count + i].is_present = work->start->is_present[i];
        /* a live reader may give other frames when the step is tried again */
        if (frames) frames->numbers[0] = frames->numbers[1] = TULLE_NONE;
    }
    step_mark_bodies(model, work->start, work);
    step_restore_patches(work);
}

/* Which obstacles are there, and which bodies are free, at the time of the state. */
static bool update_presence(const step_model *model, motion_state *state, step_work *work) {
    bool has_appeared = false, has_changed = false;
    for (size_t i = 0; i < model->obstacles.count; i++) {
        const world_obstacle *const obstacle = &model->obstacles.data[i];
        bool const is_present =
            state->time >= obstacle->appear_time && state->time < obstacle->disappear_time;
        has_appeared = has_appeared || (is_present && !state->is_present[i]);
        has_changed |= is_present != (state->is_present[i] != 0);
        state->is_present[i] = is_present;
        work->surfaces[model->cloths.count + i].is_present = is_present;
    }
    if (has_changed) step_wake_all(model, state);
    has_appeared |= step_free_bodies(model, state);
    step_mark_bodies(model, state, work);
    return has_appeared;
}

tulle_status step_copy_start(const step_model *model, motion_state *target, step_work *work,
                             bool *has_appeared) {
    const motion_state *const source = work->start;
    size_t const bytes = 3 * model->vertex_count * sizeof(double);
    double *from[STATE_VECTORS_MAX], *to[STATE_VECTORS_MAX];
    size_t const vector_count = step_list_vectors(source, from);
    (void)step_list_vectors(target, to);
    for (size_t i = 0; i < vector_count; i++) memcpy(to[i], from[i], bytes);
    if (model->obstacles.count > 0)
        memcpy(target->is_present, source->is_present, model->obstacles.count);
    if (model->particle_count > 0)
        memcpy(target->particles, source->particles, model->particle_count);
    if (model->cloth_rest_count > 0)
        memcpy(target->cloth_rests, source->cloth_rests,
               model->cloth_rest_count * sizeof *target->cloth_rests);
    if (model->body_count > 0) {
        memcpy(target->rests, source->rests, model->body_count * sizeof *target->rests);
        memcpy(target->drive_forces, source->drive_forces,
               BODY_AXES * model->body_count * sizeof(double));
    }
    if (model->pose_count > 0)
        memcpy(target->poses, source->poses, model->pose_count * sizeof *target->poses);
    for (size_t i = 0; i < model->obstacles.count; i++) { /* a jump is no velocity */
        const world_obstacle *const obstacle = &model->obstacles.data[i];
        if (obstacle->given == GIVEN_JUMP)
            memset(target->velocities + 3 * (size_t)obstacle->vertex_begin, 0,
                   3 * obstacle->mesh.vertex_count * sizeof(double));
    }
    double const length = work->step_end - source->time;
    for (size_t i = 0; i < model->cloths.count; i++) { /* it sets out to where it is drawn */
        const world_cloth *const cloth = &model->cloths.data[i];
        double *const x = target->positions + 3 * (size_t)cloth->vertex_begin;
        double *const v = target->velocities + 3 * (size_t)cloth->vertex_begin;
        for (size_t k = 0; cloth->is_drawn && k < 3 * cloth->mesh.vertex_count; k++)
            v[k] = (cloth->targets[3 * cloth->mesh.vertex_count + k] - x[k]) / length;
    }
    if (model->plastic_count > 0)
        memcpy(target->plastic, source->plastic, model->plastic_count * sizeof(double));
    target->previous_time_step = source->previous_time_step;
    target->lost_energy = source->lost_energy;
    target->elastic = source->elastic;
    memcpy(target->still, source->still, sizeof source->still);
    target->still_count = source->still_count;
    if (source->ties.count > 0) /* there is room: tulle_world_attach */
        memcpy(target->ties.data, source->ties.data, source->ties.count * sizeof(world_tie));
    target->ties.count = source->ties.count;
    target->attachment_count = source->attachment_count;
    if (model->lag_vertex_count > 0) {
        memcpy(target->lags, source->lags, 3 * model->lag_vertex_count * sizeof(double));
        memcpy(target->largest_lags, source->largest_lags, model->obstacles.count * sizeof(double));
    }
    target->time = source->time;
    target->step_count = source->step_count;

    size_t const count = source->contacts.contacts.count;
    target->contacts.contacts.count = 0;
    if (reserve_contacts(&target->contacts, work->heap, count) != TULLE_OK)
        return TULLE_ERROR_OUT_OF_MEMORY;
    if (count > 0)
        memcpy(target->contacts.contacts.data, source->contacts.contacts.data,
               count * sizeof *source->contacts.contacts.data);
    target->contacts.contacts.count = count;
    target->contacts.time_step = source->contacts.time_step;
    *has_appeared = update_presence(model, target, work);
    return TULLE_OK;
}
