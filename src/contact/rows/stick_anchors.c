/* contact/rows/stick_anchors.c - see stick_anchors.h.
 *
 * Friction that sticks holds velocities at zero, but only as well as a few rounds find it. What is
 * left in each step would add up. So a contact keeps the tangential offset d by which its two sides
 * have moved past each other since it began to stick. Friction then aims at the velocity -s d / h
 * instead of rest, within the same Coulomb bound, and errors are undone instead of summed. The
 * offset is summed step by step over the material points in contact. So the anchor moves and turns
 * with the surfaces, and passes from face to face with the contact.
 *
 * A contact that slides, at the start of the step or by its bound at the end, drops its anchor and
 * starts again. An offset is limited so that it asks for a fraction of the speed that counts as
 * slip; hence no anchor ever makes a contact slide. Offsets fade within MEMORY. Offsets that
 * contacts of one piece of cloth have gathered on different paths do not fit together for ever:
 * without fading a pinched sheet trembles.
 *
 * Based on: Cundall, Strack, A discrete numerical model for granular assemblies, 1979 (tangential
 * offset of a contact, bounded by friction); Baumgarte 1972 (a share of the error a step).
 * Departure: no spring, so no stiffness: the offset sets a speed, the solve finds the force. */
#include "contact/rows/stick_anchors.h"

#include "contact/rows/row_motion.h"

/* An anchor asks for this share of the speed that counts as slip, at most. */
static const double SPEED_SHARE = 0.5;

/* [s] Offsets fade by the factor e in this time; half to three times as long does as well. */
static const double MEMORY = 1.0;

/* The offset, shortened so that it asks for at most the largest speed of an anchor. */
static vec3 limit_offset(const contact_scene *scene, vec3 offset) {
    const contact_settings *const settings = &scene->settings;
    double const largest =
        SPEED_SHARE * settings->slip_speed * scene->time_step / settings->anchor_share;
    double const size = vec3_norm(offset);
    return size > largest ? vec3_scale(offset, largest / size) : offset;
}

void take_anchor(const contact_scene *scene, contact_row *row, vec3 offset) {
    row_law *const law = &row->law;
    vec3 const normal = row->frame.normal;
    bool const is_held = law->is_old && law->old_state == ROW_STICKS && !law->is_sliding;
    if (!is_held || !(scene->settings.anchor_share > 0.0)) offset = vec3_make(0.0, 0.0, 0.0);
    vec3 const tangential = vec3_add_scaled(offset, normal, -vec3_dot(normal, offset));
    law->anchor = limit_offset(scene, tangential);
    law->return_velocity =
        vec3_scale(law->anchor, -scene->settings.anchor_share / scene->time_step);
}

void move_anchors(const contact_scene *scene, const double *x1, row_list *list) {
    if (!(scene->settings.anchor_share > 0.0)) return;
    double const kept = fmax(1.0 - scene->time_step / MEMORY, 0.0);
    for (size_t i = 0; i < list->rows.count; i++) {
        contact_row *const row = &list->rows.data[i];
        vec3 const normal = row->frame.normal;
        bool const goes_on = row->solve.state == ROW_STICKS && row->law.old_state == ROW_STICKS;
        vec3 const points =
            vec3_sub(blend_row_vertices(row, x1), blend_row_vertices(row, scene->x0));
        vec3 const way = vec3_add_scaled(points, row->frame.turning, -scene->time_step);
        vec3 const slip = vec3_add_scaled(way, normal, -vec3_dot(normal, way));
        vec3 const offset = vec3_add_scaled(slip, row->law.anchor, kept);
        row->law.anchor = goes_on && !row->law.is_sliding ? limit_offset(scene, offset)
                                                          : vec3_make(0.0, 0.0, 0.0);
    }
}
