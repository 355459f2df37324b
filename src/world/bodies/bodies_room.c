/* world/bodies/bodies_room.c - see bodies_room.h. */
#include "world/bodies/bodies_room.h"

#include "contact/rows/row_motion.h"

#include <math.h>

/* Rows may use this share of the energy that the substep before lost. */
static const double ROOM_SHARE = 0.5;

/* [m/s] Speed at which a row keeps the room that it has. Without it, bodies that turn come
 * nearer. */
static double compute_kept_speed(const step_context *context, const contact_row *row) {
    return -compute_row_curvature(&context->scene, row) / context->time_step;
}

static double compute_push(const contact_row *row) {
    return fmax(vec3_dot(row->frame.normal, row->solve.impulse), 0.0);
}

void world_share_room(step_context *context) {
    row_list *const list = &context->world->work.rows;
    double work = 0.0; /* [J] with the impulses of the substep before */
    for (size_t i = 0; context->scene.body_count > 0 && i < list->rows.count; i++) {
        const contact_row *const row = &list->rows.data[i];
        if (row->frame.has_body)
            work += compute_push(row) * fmax(row->law.bias - compute_kept_speed(context, row), 0.0);
    }
    double const budget = ROOM_SHARE * context->state->lost_energy;
    if (!(work > budget)) return;
    for (size_t i = 0; i < list->rows.count; i++) {
        contact_row *const row = &list->rows.data[i];
        if (!row->frame.has_body) continue;
        double const kept = compute_kept_speed(context, row);
        if (row->law.bias > kept) row->law.bias = kept + (row->law.bias - kept) * (budget / work);
    }
}

bool world_ask_less_room(step_context *context, int level) {
    row_list *const list = &context->world->work.rows;
    bool has_changed = false;
    for (size_t i = 0; context->scene.body_count > 0 && i < list->rows.count; i++) {
        contact_row *const row = &list->rows.data[i];
        if (!row->frame.has_body) continue;
        double const kept = level == 0 ? compute_kept_speed(context, row) : 0.0;
        if (!(row->law.bias > kept)) continue;
        has_changed |= compute_push(row) > 0.0;
        row->law.bias = kept;
    }
    return has_changed;
}

void world_note_loss(step_context *context) {
    const row_list *const list = &context->world->work.rows;
    double work = 0.0; /* [J] of making room */
    for (size_t i = 0; context->scene.body_count > 0 && i < list->rows.count; i++) {
        const contact_row *const row = &list->rows.data[i];
        if (!row->frame.has_body) continue;
        double const speed =
            vec3_dot(row->frame.normal, get_relative_velocity(row, context->mean_velocity));
        work += compute_push(row) * fmax(speed - compute_kept_speed(context, row), 0.0);
    }
    context->lost_energy = context->scene.body_count > 0 ? fmax(work - context->gain, 0.0) : 0.0;
}
