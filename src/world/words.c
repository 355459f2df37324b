/* world/words.c - what a step has found (step/findings.h), in words. */
#include "base/error.h"
#include "step/step_work.h"
#include "world/world_state.h"

#include <stdio.h>
#include <string.h>

/* Writes the names of marked obstacles, as far as there is room. Returns how many are marked. */
static size_t list_names(const step_model *model, const uint8_t *is_marked, char *text,
                         size_t size) {
    static const char others[] = " and others";
    size_t length = 0, count = 0;
    bool is_full = false;
    text[0] = '\0';
    for (size_t i = 0; i < model->obstacles.count; i++) {
        if (!is_marked[i]) continue;
        const char *const name = model->obstacles.data[i].name;
        const char *const separator = count++ > 0 ? ", " : "";
        if (is_full) continue;
        is_full = length + strlen(separator) + strlen(name) + 2 + sizeof others > size;
        length +=
            (size_t)(is_full ? snprintf(text + length, size - length, "%s", others)
                             : snprintf(text + length, size - length, "%s'%s'", separator, name));
    }
    return count;
}

static void write_note(const step_model *model, const step_finding *finding, char *text,
                       size_t size) {
    static const char *const consequences[] = {
        [FINDING_NO_ROOM] = "it has no room there",
        [FINDING_WAITS] = "scripted motion waits (on_pinch: slow)",
        [FINDING_PINCHED] = "give it room, take shorter steps if the obstacle is fast, or set "
                            "on_pinch to slow"};
    const char *const name = world_surface_name(model, finding->surface);
    vec3 const at = finding->position;
    char names[WORLD_MESSAGE_BYTES / 2], pins[80] = "";
    size_t named;
    switch (finding->kind) {
    case FINDING_BREAKS:
        snprintf(text, size,
                 "'%s' breaks off at %zu %s, first at vertex %u of attachment %u, held by %.3g N "
                 "and by at most %.3g N",
                 name, finding->count, finding->count == 1 ? "vertex" : "vertices",
                 finding->vertices[0], finding->attachment, finding->numbers[0],
                 finding->numbers[1]);
        return;
    case FINDING_LAGS:
        snprintf(text, size,
                 "'%s' leaves cloth no room near (%.6g, %.6g, %.6g) m at %.6g s; there it lags "
                 "behind its frames (on_pinch: %s)",
                 name, at.x, at.y, at.z, finding->time,
                 model->def.on_pinch == TULLE_ON_PINCH_LAG ? "lag" : "slow");
        return;
    case FINDING_FOLLOWS:
        named = list_names(model, finding->marks, names, sizeof names);
        snprintf(text, size, "%s %s again at %.6g s: the cloth is pinched no more",
                 named > 0 ? names : "all pins and obstacles",
                 named == 1 ? "follows its script" : "follow their script", finding->time);
        return;
    default: break; /* a pinch */
    }
    named = list_names(model, finding->marks, names, WORLD_MESSAGE_BYTES / 4);
    if (finding->count > 0)
        snprintf(pins, sizeof pins, ", dragged by its pin number %u%s", finding->vertices[0],
                 finding->count > 1 ? " and others" : "");
    snprintf(text, size, "'%s' is pinched near (%.6g, %.6g, %.6g) m at %.6g s, %s %s%s; %s", name,
             at.x, at.y, at.z, finding->time, named == 1 ? "by" : "between",
             named > 0 ? names : "pins and other cloth", pins, consequences[finding->kind]);
}

void world_tell_findings(tulle_world *world) {
    const step_work *const work = &world->work;
    const step_finding *const findings[] = {&work->broken, &work->lag.finding, &work->lag.freed};
    bool const has_message = world->message[0] != '\0';
    for (int i = 0; i < 3; i++) {
        size_t const length = strlen(world->message);
        char text[WORLD_MESSAGE_BYTES];
        if (findings[i]->kind == FINDING_NONE || (i == 0 && has_message)) continue;
        write_note(&world->model, findings[i], text, sizeof text);
        snprintf(world->message + length, sizeof world->message - length, "%s%s",
                 length > 0 ? ". " : "", text);
    }
}

tulle_status world_tell_failure(tulle_world *world, tulle_status status, tulle_error *error) {
    const step_model *const model = &world->model;
    const step_finding *const finding = &world->work.failure;
    const double *const numbers = finding->numbers;
    unsigned long long const step = world->now.step_count;
    char text[WORLD_MESSAGE_BYTES];
    const char *const name =
        finding->kind == FINDING_NONE ? "" : world_surface_name(model, finding->surface);
    switch (finding->kind) {
    case FINDING_FRAME: return status;
    case FINDING_PINCHED:
        write_note(model, finding, text, sizeof text);
        world_tell_findings(world);
        return error_set(error, status, "%s", text);
    case FINDING_CROWDED:
        return error_set(error, status,
                         "step %llu has too many candidate pairs, even when cut to %g s; use "
                         "slower motion, coarser meshes or a smaller contact distance",
                         step, numbers[0]);
    case FINDING_SCRIPT_TURNS:
        return error_set(error, status,
                         "the keyframes of '%s' turn it by %.6g rad in step %llu; substeps that "
                         "follow it turn by %.3g rad, and a step has at most %g of them; use a "
                         "shorter time step or a slower turn",
                         name, numbers[0], step, numbers[1], numbers[2]);
    case FINDING_BODY_SPINS:
        return error_set(error, status,
                         "'%s' spins with %.6g rad/s in step %llu, %.6g rad within the step; "
                         "substeps that follow its turn last %.3g s, and a step has at most %g "
                         "of them; use a time step of at most %.3g s, less spin or a larger "
                         "contact distance",
                         name, numbers[0], step, numbers[0] * world->work.whole_step,
                         numbers[1] / numbers[0], numbers[2], numbers[2] * numbers[1] / numbers[0]);
    case FINDING_OVERSTRETCHED:
        return error_set(error, status,
                         "'%s' is overstretched in step %llu, which is undone: at vertices %u, "
                         "%u, %u its %s is stretched by %.3g %%, and the material holds %.3g %%; "
                         "pull less, take a stronger material, or let on_overstretch warn",
                         name, step, finding->vertices[0], finding->vertices[1],
                         finding->vertices[2], finding->count == 1 ? "warp" : "weft",
                         100.0 * numbers[0], 100.0 * numbers[1]);
    case FINDING_TORN:
        return error_set(error, status,
                         "contact by the paper's response tears cloth to over %g times its rest "
                         "length in step %llu; use the coupled response, %sa smaller time step or "
                         "less restitution",
                         numbers[0], step,
                         model->def.membrane == TULLE_MEMBRANE_WOVEN
                             ? "a membrane of springs, for which it was made, "
                             : "");
    default: break;
    }
    if (status == TULLE_ERROR_OUT_OF_MEMORY)
        return error_set(error, status, "no memory left for step %llu", step);
    return error_set(error, status,
                     "step %llu leads to positions that are not finite or too far away; use a "
                     "smaller time step, softer materials or weaker wind",
                     step);
}
