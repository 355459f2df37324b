/* step/bodies/bodies_room.c - see bodies_room.h. */
#include "step/bodies/bodies_room.h"

#include "contact/rows/row_motion.h"

#include <math.h>

/* Rows may use this share of the energy that the substep before lost. */
static const double ROOM_SHARE = 0.5;

/* [m/s] Speed at which a row keeps its room. Without it, bodies that turn come nearer. */
static double compute_kept_speed(const step_work *work, const contact_row *row) {
    return -compute_row_curvature(&work->sub.scene, row) / work->sub.time_step;
}

static double compute_push(const contact_row *row) {
    return fmax(vec3_dot(row->frame.normal, row->solve.impulse), 0.0);
}

void step_share_room(motion_state *state, step_work *work) {
    row_list *const list = &work->rows;
    double asked = 0.0; /* [J] with the impulses of the substep before */
    for (size_t i = 0; work->sub.scene.body_count > 0 && i < list->rows.count; i++) {
        const contact_row *const row = &list->rows.data[i];
        if (row->frame.has_body)
            asked += compute_push(row) * fmax(row->law.bias - compute_kept_speed(work, row), 0.0);
    }
    double const budget = ROOM_SHARE * state->lost_energy;
    if (!(asked > budget)) return;
    for (size_t i = 0; i < list->rows.count; i++) {
        contact_row *const row = &list->rows.data[i];
        if (!row->frame.has_body) continue;
        double const kept = compute_kept_speed(work, row);
        if (row->law.bias > kept) row->law.bias = kept + (row->law.bias - kept) * (budget / asked);
    }
}

bool step_ask_less_room(step_work *work, int level) {
    row_list *const list = &work->rows;
    bool has_changed = false;
    for (size_t i = 0; work->sub.scene.body_count > 0 && i < list->rows.count; i++) {
        contact_row *const row = &list->rows.data[i];
        if (!row->frame.has_body) continue;
        double const kept = level == 0 ? compute_kept_speed(work, row) : 0.0;
        if (!(row->law.bias > kept)) continue;
        has_changed |= compute_push(row) > 0.0;
        row->law.bias = kept;
    }
    return has_changed;
}

void step_note_loss(step_work *work) {
    const row_list *const list = &work->rows;
    double given = 0.0; /* [J] of making room */
    for (size_t i = 0; work->sub.scene.body_count > 0 && i < list->rows.count; i++) {
        const contact_row *const row = &list->rows.data[i];
        if (!row->frame.has_body) continue;
        double const speed =
            vec3_dot(row->frame.normal, get_relative_velocity(row, work->sub.mean_velocity));
        given += compute_push(row) * fmax(speed - compute_kept_speed(work, row), 0.0);
    }
    work->sub.lost_energy =
        work->sub.scene.body_count > 0 ? fmax(given - work->sub.gain, 0.0) : 0.0;
}
