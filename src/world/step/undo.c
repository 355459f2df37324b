/* world/step/undo.c - a step works on a copy of the state, all or nothing.
 *
 * The copy takes the place of the state when the step has succeeded. What the step changes outside
 * the copy (who is present, which pairs are ignored, patches) is noted before and put back when the
 * step fails or is made anew. */
#include "base/error.h"
#include "world/bodies/bodies.h"
#include "world/step/search.h"

#include <string.h>

tulle_status world_keep_start(tulle_world *world, tulle_error *error) {
    tulle_status const status = world_keep_ignored(world, error);
    if (status != TULLE_OK || world_keep_patches(world) == TULLE_OK) return status;
    return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory left for patches");
}

void world_undo_step(tulle_world *world) {
    for (size_t i = 0; i < world->model.obstacles.count; i++) {
        world_obstacle *const obstacle = &world->model.obstacles.data[i];
        world->model.surfaces[world->model.cloths.count + i].is_present = world->now.is_present[i];
        /* a live reader may give other frames when the step is tried again */
        obstacle->frame_numbers[0] = obstacle->frame_numbers[1] = TULLE_NONE;
    }
    world_mark_bodies(world, &world->now);
    world_restore_ignored(world);
    world_restore_patches(world);
}

tulle_status world_copy_start(tulle_world *world, tulle_error *error) {
    const motion_state *const source = &world->now;
    motion_state *const target = &world->next;
    size_t const bytes = 3 * world->model.vertex_count * sizeof(double);
    double *from[STATE_VECTORS_MAX], *to[STATE_VECTORS_MAX];
    size_t const vector_count = world_list_vectors(source, from);
    (void)world_list_vectors(target, to);
    for (size_t i = 0; i < vector_count; i++) memcpy(to[i], from[i], bytes);
    if (world->model.obstacles.count > 0)
        memcpy(target->is_present, source->is_present, world->model.obstacles.count);
    if (world->model.particle_count > 0)
        memcpy(target->particles, source->particles, world->model.particle_count);
    if (world->model.cloth_rest_count > 0)
        memcpy(target->cloth_rests, source->cloth_rests,
               world->model.cloth_rest_count * sizeof *target->cloth_rests);
    if (world->model.body_count > 0) {
        memcpy(target->rests, source->rests, world->model.body_count * sizeof *target->rests);
        memcpy(target->drive_forces, source->drive_forces,
               BODY_AXES * world->model.body_count * sizeof(double));
    }
    if (world->model.pose_count > 0)
        memcpy(target->poses, source->poses, world->model.pose_count * sizeof *target->poses);
    for (size_t i = 0; i < world->model.obstacles.count; i++) { /* a jump is no velocity */
        const world_obstacle *const obstacle = &world->model.obstacles.data[i];
        if (obstacle->given == GIVEN_JUMP)
            memset(target->velocities + 3 * (size_t)obstacle->vertex_begin, 0,
                   3 * obstacle->mesh.vertex_count * sizeof(double));
    }
    double const length = world->work.step_end - world->now.time;
    for (size_t i = 0; i < world->model.cloths.count; i++) { /* it sets out to where it is drawn */
        const world_cloth *const cloth = &world->model.cloths.data[i];
        double *const x = target->positions + 3 * (size_t)cloth->vertex_begin;
        double *const v = target->velocities + 3 * (size_t)cloth->vertex_begin;
        for (size_t k = 0; cloth->is_drawn && k < 3 * cloth->mesh.vertex_count; k++)
            v[k] = (cloth->targets[3 * cloth->mesh.vertex_count + k] - x[k]) / length;
    }
    if (world->model.plastic_count > 0)
        memcpy(target->plastic, source->plastic, world->model.plastic_count * sizeof(double));
    target->previous_time_step = source->previous_time_step;
    target->lost_energy = source->lost_energy;
    target->elastic = source->elastic;
    memcpy(target->holds, source->holds, source->hold_count * sizeof *source->holds);
    target->hold_count = source->hold_count;
    if (source->ties.count > 0) /* there is room: tulle_world_attach */
        memcpy(target->ties.data, source->ties.data, source->ties.count * sizeof(world_tie));
    target->ties.count = source->ties.count;
    target->attachment_count = source->attachment_count;
    if (world->model.lag_vertex_count > 0) {
        memcpy(target->lags, source->lags, 3 * world->model.lag_vertex_count * sizeof(double));
        memcpy(target->largest_lags, source->largest_lags,
               world->model.obstacles.count * sizeof(double));
    }
    target->time = source->time;

    size_t const count = source->contacts.contacts.count;
    target->contacts.contacts.count = 0;
    if (reserve_contacts(&target->contacts, &world->heap, count) != TULLE_OK)
        return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory left for contacts");
    if (count > 0)
        memcpy(target->contacts.contacts.data, source->contacts.contacts.data,
               count * sizeof *source->contacts.contacts.data);
    target->contacts.contacts.count = count;
    target->contacts.time_step = source->contacts.time_step;
    return world_update_presence(world, target, error);
}

tulle_status world_swap_states(tulle_world *world, tulle_error *error) {
    /* Both sides get the same room, so that a step which needs no more than those before it makes
     * no heap call. */
    memory *const heap = &world->heap;
    row_list *const rows = &world->work.rows, *const accepted = &world->accepted_rows;
    bool const has_room =
        ARRAY_MATCH(heap, &rows->rows, &accepted->rows) &&
        ARRAY_MATCH(heap, &rows->near_pairs.pairs, &accepted->near_pairs.pairs) &&
        ARRAY_MATCH(heap, &world->now.contacts.contacts, &world->next.contacts.contacts);
    if (!has_room)
        return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory left for contacts");
    motion_state const old = world->now;
    world->now = world->next;
    world->next = old;
    row_list const old_rows = world->accepted_rows;
    world->accepted_rows = world->work.rows;
    world->work.rows = old_rows;
    world->has_contacts = world->has_queries = false;
    world->step_count++;
    if (world->ignored.count > 0) world_update_ignored(world, world->now.positions);
    return TULLE_OK;
}
