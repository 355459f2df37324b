/* world/presence.c - the judgement of obstacles that appear, and of bodies that come free. */
#include "base/error.h"
#include "world/start/inside.h"

#include <stdio.h>

tulle_status world_judge_appearance(tulle_world *world, const motion_state *state,
                                    tulle_error *error) {
    const intersection_list *const list = &world->intersections;
    size_t const cloth_count = world->model.cloths.count;
    bool const is_ignored = world->model.def.start_intersections == TULLE_START_IGNORE;
    char when[WORLD_NAME_BYTES + 64];
    tulle_status const status =
        world_find_intersections(world, state->positions, &world->intersections, error);
    if (status != TULLE_OK || (list->count == 0 && is_ignored)) return status;
    if (list->count == 0) {
        snprintf(when, sizeof when, "when one of them appears or comes free at %.6g s",
                 state->time);
        return world_refuse_inside(world, state->positions,
                                   (inside_question){.when = when, .is_late = true}, error);
    }
    if (is_ignored) {
        /* a message that names the first obstacle that appears in something, and in what */
        size_t count = 0;
        uint32_t caught = 0, late = 0;
        for (size_t i = 0; i < list->count; i++) {
            uint32_t const a = list->data[i].object_a, b = list->data[i].object_b;
            bool const is_new_a = a >= cloth_count && !world->now.is_present[a - cloth_count];
            bool const is_new_b = b >= cloth_count && !world->now.is_present[b - cloth_count];
            if (!is_new_a && !is_new_b) continue;
            if (count++ > 0) continue;
            caught = is_new_b ? a : b;
            late = is_new_b ? b : a;
        }
        if (count > 0)
            snprintf(world->message, sizeof world->message,
                     "'%s' is caught at %.6g s in '%s', which appears there: %zu pairs of "
                     "triangles intersect and are let be until they come apart "
                     "(start_intersections: ignore)",
                     world_surface_name(&world->model, caught), state->time,
                     world_surface_name(&world->model, late), count);
        return world_ignore_intersections(world, error);
    }
    /* "at 0.8 s, when 'late' appears": the first obstacle of the pairs that is new */
    snprintf(when, sizeof when, "at %.6g s, when a body comes free", state->time);
    bool is_named = false;
    for (size_t i = 0; i < 2 * list->count && !is_named; i++) {
        const tulle_intersection *const pair = &list->data[i / 2];
        uint32_t const object = i % 2 == 0 ? pair->object_a : pair->object_b;
        is_named = object >= cloth_count && !world->now.is_present[object - cloth_count];
        if (is_named)
            snprintf(when, sizeof when, "at %.6g s, when '%s' appears", state->time,
                     world_surface_name(&world->model, object));
    }
    return world_refuse_intersections(world, state->positions, when, error);
}
