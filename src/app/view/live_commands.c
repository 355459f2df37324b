/* app/view/live_commands.c - what a live scene is told to do, and the script that keeps it.
 *
 * A command that changes the world is a line of the script, with the number of steps that were made
 * before it. Rewinding cuts the script back, so it always leads from the start to the state that
 * there is. A session file is the script with a line before it, which names the scene, and one
 * behind it, which has the hash of the state. */
#include "app/view/live_thread.h"

#include "app/view/pick.h"
#include "app/view/session_file.h"
#include "base/error.h"

#include <stdio.h>
#include <string.h>

static uint64_t get_step(const view_live *live) {
    return tulle_world_get_step_count(live->built.world);
}

static void keep(view_live *live, const view_request *request) {
    view_buffer line = {0};
    buffer_print(&line, "{\"at\":%llu,", (unsigned long long)get_step(live));
    request_write(request, &line);
    buffer_print(&line, "}\n");
    if (line.is_failed || !record_append(&live->script, buffer_get(&line), line.count))
        live_say(live, "further actions are not kept: there is no memory for them");
    buffer_release(&line);
}

/* A session: what leads from the start to here. */
static tulle_status save_session(view_live *live, tulle_error *error) {
    size_t const byte_count = (size_t)atomic_load(&live->script.byte_count);
    view_buffer text = {0};
    session_file_begin(live->options.scene, &text);
    unsigned char *const place = buffer_extend(&text, byte_count);
    if (place && record_read(&live->script, place, byte_count, 0) != byte_count)
        text.is_failed = true;
    session_file_end(get_step(live), tulle_world_get_state_hash(live->built.world), &text);
    tulle_status const status =
        text.is_failed ? error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "there is no room for it")
                       : session_file_write(live->options.scene, &text, error);
    buffer_release(&text);
    return status;
}

static void answer_pins(view_live *live, const live_command *command, view_buffer *answer) {
    uint32_t const object = command->request.object;
    size_t const pin_count = scene_get_object_facts(live->options.scene, object).pin_count;
    buffer_json_whole(answer, "object", object);
    buffer_print(answer, ",\"pins\":[");
    for (size_t p = 0; p < pin_count; p++) {
        size_t count = 0;
        const uint32_t *const vertices =
            scene_get_pin_vertices(live->options.scene, object, p, &count);
        buffer_print(answer, p > 0 ? ",[" : "[");
        for (size_t k = 0; k < count; k++) buffer_print(answer, k > 0 ? ",%u" : "%u", vertices[k]);
        buffer_print(answer, "]");
    }
    buffer_print(answer, "]");
}

/* The document's number of each object of the world: one that was taken in hand has become the last
 * there. Null without memory. */
static uint32_t *number_objects(view_live *live) {
    const tulle_scene_world *const built = &live->built;
    size_t const count = built->cloth_count + built->obstacle_count;
    uint32_t *const numbers = memory_allocate(&live->heap, (count + 1) * sizeof *numbers);
    for (uint32_t n = 0; numbers && n < count; n++) {
        tulle_object_id const id = tulle_world_get_object(built->world, n);
        numbers[n] = n;
        for (uint32_t i = 0; i < built->obstacle_count && id.kind == TULLE_OBJECT_OBSTACLE; i++)
            if (built->obstacles[i].index == id.index &&
                built->obstacles[i].generation == id.generation)
                numbers[n] = (uint32_t)built->cloth_count + i;
    }
    return numbers;
}

static tulle_status answer_pick(view_live *live, const live_command *command, view_buffer *answer,
                                tulle_error *error) {
    const view_document *const document = live->options.document;
    uint32_t const index = command->request.object;
    if (index >= document->object_count)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "there is no object %u", index);
    const tulle_world *const world = live->built.world;
    pick_facts facts = {.document = document, .frame = (uint32_t)get_step(live)};
    bool const is_cloth = index < live->built.cloth_count;
    size_t count = 0;
    if (is_cloth) {
        tulle_cloth_id const id = live->built.cloths[index];
        facts.positions = tulle_cloth_get_positions(world, id, &count);
        facts.velocities = tulle_cloth_get_velocities(world, id, &count);
    } else {
        tulle_obstacle_id const id = live->built.obstacles[index - live->built.cloth_count];
        facts.positions = tulle_obstacle_get_positions(world, id, &count);
        facts.velocities = tulle_obstacle_get_velocities(world, id, &count);
    }
    size_t const byte_count = 3 * document->objects[index].mesh.triangle_count * sizeof(double);
    double *const strains = is_cloth ? memory_allocate(&live->heap, byte_count) : NULL;
    tulle_target const target = {strains, byte_count, 0, TULLE_NUMBER_DOUBLE};
    if (strains &&
        tulle_object_copy_values(world, tulle_object_from_cloth(live->built.cloths[index]),
                                 TULLE_VALUES_STRAINS, &target, NULL) == TULLE_OK)
        facts.strains = strains;
    size_t const number_count = live->built.cloth_count + live->built.obstacle_count + 1;
    bool const is_in_order = live->hold.driven_count == 0;
    uint32_t *const numbers = is_in_order ? NULL : number_objects(live);
    if (is_in_order || numbers)
        (void)tulle_world_get_contacts(live->built.world, &facts.contacts, &facts.contact_count,
                                       NULL);
    facts.numbers = numbers;
    facts.scene = live->options.scene;
    tulle_status const status = pick_write(&facts, &command->request, answer, error);
    memory_release(&live->heap, numbers, number_count * sizeof *numbers);
    memory_release(&live->heap, strains, byte_count);
    return status;
}

/* Changes the world by a command; what succeeded is kept. */
static tulle_status change(view_live *live, view_request *request, tulle_error *error) {
    hold_scene *const held = &live->held;
    tulle_status status = TULLE_ERROR_INVALID_ARGUMENT;
    switch (request->type) {
    case REQUEST_GRAB: status = hold_grab_object(held, request, error); break;
    case REQUEST_DRAG: status = hold_drag(held, request, error); break;
    case REQUEST_LET_GO: status = hold_let_go(held, request, error); break;
    case REQUEST_CUT_PIN: status = hold_cut_pin(held, request, error); break;
    case REQUEST_MOVE: status = hold_move(held, request, error); break;
    case REQUEST_SET: status = hold_set(held, request, error); break;
    default: break;
    }
    if (status != TULLE_OK) return status;
    live->has_failed = false; /* what stood in the way may be gone */
    keep(live, request);
    return TULLE_OK;
}

static tulle_status reset(view_live *live, tulle_error *error) {
    record_cut(&live->script, 0);
    live->is_running = false;
    live->steps_left = 0;
    live->message[0] = '\0';
    tulle_status const status = live_build(live, error);
    live->has_failed = status != TULLE_OK;
    if (status == TULLE_OK) live_save_if_due(live);
    return status;
}

static tulle_status execute(view_live *live, live_command *command, view_buffer *answer,
                            const char **type, tulle_error *error) {
    view_request *const request = &command->request;
    tulle_status status = TULLE_OK;
    if (!live->is_started && request->type != REQUEST_RESET && request->type != REQUEST_PICK &&
        request->type != REQUEST_PINS)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "the scene has not started");
    if (live->replayed && request->type != REQUEST_PICK && request->type != REQUEST_PINS)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "a session is being repeated; wait for its end");
    switch (request->type) {
    case REQUEST_RUN:
        live->is_running = true;
        live->has_failed = false;
        live->speed = request->speed;
        live->next_step = 0.0;
        live->message[0] = '\0';
        return TULLE_OK;
    case REQUEST_PAUSE:
        live->is_running = false;
        live->steps_left = 0;
        return TULLE_OK;
    case REQUEST_STEP:
        live->is_running = false;
        live->has_failed = false;
        live->steps_left = request->count;
        return TULLE_OK;
    case REQUEST_RESET: return reset(live, error);
    case REQUEST_REWIND: return live_rewind(live, request->step, error);
    case REQUEST_SAVE_SESSION:
        status = save_session(live, error);
        if (status == TULLE_OK) {
            *type = "saved_session";
            session_file_write_name(live->options.scene, answer);
        }
        return status;
    case REQUEST_PINS:
        *type = "pins";
        answer_pins(live, command, answer);
        return TULLE_OK;
    case REQUEST_PICK: *type = "picked"; return answer_pick(live, command, answer, error);
    case REQUEST_GRAB:
        status = change(live, request, error);
        *type = "grabbed";
        buffer_json_whole(answer, "grab", request->grab);
        return status;
    default: return change(live, request, error);
    }
}

/* A command with an id gets an answer, and so does one that fails. */
void live_execute(view_live *live, live_command *command) {
    view_buffer answer = {0}, members = {0};
    tulle_error error = {0};
    const char *type = "done";
    tulle_status const status = execute(live, command, &members, &type, &error);
    buffer_print(&answer, "{\"type\":\"%s\"", status == TULLE_OK ? type : "error");
    if (command->request.has_id) buffer_json_whole(&answer, "id", command->request.id);
    if (status == TULLE_OK)
        buffer_put_bytes(&answer, buffer_get(&members), members.count);
    else
        buffer_json_text(&answer, "message",
                         error.message[0] ? error.message : tulle_status_text(status));
    buffer_print(&answer, "}");
    buffer_release(&members);
    if (command->client != 0 && (command->request.has_id || status != TULLE_OK))
        live_answer_client(live, command->client, &answer);
    else
        buffer_release(&answer);
}

/* ---- a session that is repeated ---- */

static void end_replay(view_live *live, const session_line *last) {
    uint64_t const hash = tulle_world_get_state_hash(live->built.world);
    live->replayed = NULL;
    live->is_running = false;
    if (hash == last->hash)
        live_say(live, "session repeated: %llu steps, the same state %016llx",
                 (unsigned long long)get_step(live), (unsigned long long)hash);
    else
        live_say(live, "session repeated: %llu steps, another state: %016llx, recorded was %016llx",
                 (unsigned long long)get_step(live), (unsigned long long)hash,
                 (unsigned long long)last->hash);
    live->has_failed = hash != last->hash;
}

void live_go_on_with_script(view_live *live) {
    while (live->replayed && live->is_started) {
        session_line line;
        tulle_error error = {0};
        const char *const next = session_file_read_line(live->replayed, &line, &error);
        if (!next) {
            live->replayed = NULL;
            live->has_failed = true;
            live_say(live, "session repeated up to step %llu: %s",
                     (unsigned long long)get_step(live), error.message);
            return;
        }
        if (line.at > get_step(live)) return;
        live->replayed = next;
        if (line.is_end) {
            end_replay(live, &line);
            return;
        }
        tulle_status const status = change(live, &line.request, &error);
        if (status == TULLE_OK) continue;
        live->replayed = NULL;
        live->has_failed = true;
        live_say(live, "session repeated up to step %llu: %s", (unsigned long long)get_step(live),
                 error.message);
    }
}
