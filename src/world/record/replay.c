/* world/record/replay.c - repeating a recording (tulle/record.h).
 *
 * In: the bytes of a recording, which are not trusted. Each block is checked for its hash and read
 * into a call, which is made as a host would make it. Before a start, a step or a load all that the
 * host gave within it - frames, answers, the result - is looked through. Out: the report. */
#include "tulle/record.h"

#include "base/error.h"
#include "base/hash.h"
#include "tulle/live.h"
#include "tulle/objects.h"
#include "world/record/recorded_call.h"
#include "world/world_state.h"

#include <stdio.h>
#include <string.h>

typedef struct replay replay;

/* Where the frames of an obstacle come from; stays where it is, for the world points to it. */
typedef struct frame_source {
    replay *owner;
    tulle_obstacle_id obstacle;
} frame_source;

/* A frame that the host gave: the place of its block. */
typedef struct recorded_frame {
    tulle_obstacle_id obstacle;
    uint32_t frame;
    size_t place;
} recorded_frame;

struct replay {
    const unsigned char *bytes;
    size_t byte_count, place; /* [bytes] read so far */
    int threads;
    memory heap;
    arena scratch; /* of the block that is read */
    tulle_world *world;
    ARRAY(frame_source *) sources;
    ARRAY(recorded_frame) frames;
    ARRAY(unsigned char) answers; /* of the pair filter in this call */
    size_t answers_given;
    tulle_replay_report *report;
    tulle_error error; /* of the last call that failed, or of the replay */
};

/* ---- blocks ---- */

typedef enum block_state { BLOCK_READ, BLOCK_CUT, BLOCK_BAD } block_state;

static tulle_status refuse_block(replay *self, size_t place, const char *why) {
    self->report->offset = place;
    return error_set(&self->error, TULLE_ERROR_PARSE, "byte %zu of the recording: %s", place, why);
}

static tulle_status refuse_memory(replay *self) {
    return error_set(&self->error, TULLE_ERROR_OUT_OF_MEMORY, "no memory left for the replay");
}

/* Reads the block at `*place` and moves on behind it. Arrays of the call lie in scratch. */
static tulle_status read_block(replay *self, size_t *place, recorded_call *call,
                               block_state *state) {
    size_t const begin = *place, left = self->byte_count - begin;
    const unsigned char *const head = self->bytes + begin;
    *state = BLOCK_CUT;
    if (left < RECORD_HEAD_BYTES) return TULLE_OK;
    uint64_t const payload = record_load(head, 8), kind = record_load(head + 8, 4);
    *state = BLOCK_BAD;
    if ((uint32_t)hash_block(head, 12) != record_load(head + 12, 4))
        return refuse_block(self, begin, "the head of a block is damaged");
    if (payload > left || left - (size_t)payload < RECORD_HEAD_BYTES + RECORD_HASH_BYTES) {
        *state = BLOCK_CUT;
        return TULLE_OK;
    }
    const unsigned char *const body = head + RECORD_HEAD_BYTES;
    if (hash_block(body, (size_t)payload) != record_load(body + payload, 8))
        return refuse_block(self, begin, "a block is damaged");
    if (kind >= RECORD_KIND_COUNT) return refuse_block(self, begin, "there is no such call");
    *call = (recorded_call){.kind = (record_kind)kind};
    record_stream stream = {
        .is_reading = true, .at = body, .end = body + payload, .scratch = &self->scratch};
    tulle_status const status = recorded_call_read(&stream, call);
    if (status == TULLE_ERROR_OUT_OF_MEMORY) return refuse_memory(self);
    if (status == TULLE_ERROR_UNSUPPORTED)
        return error_set(&self->error, TULLE_ERROR_PARSE,
                         "the recording was made by Tulle %.15s, whose defs have other values than "
                         "the defs of Tulle %s: use the version that made it",
                         call->texts[0] ? call->texts[0] : "of no name", tulle_version());
    if (status != TULLE_OK)
        return refuse_block(self, begin, "a block does not hold what its call takes");
    *state = BLOCK_READ;
    *place = begin + RECORD_HEAD_BYTES + (size_t)payload + RECORD_HASH_BYTES;
    return TULLE_OK;
}

/* ---- what the host gave within a call ---- */

static tulle_status give_frame(void *context, uint32_t frame, double *positions,
                               tulle_error *error) {
    const frame_source *const source = context;
    replay *const self = source->owner;
    tulle_obstacle_id const id = source->obstacle;
    size_t const index = world_find_obstacle(self->world, id);
    size_t const count = self->world->model.obstacles.data[index].mesh.vertex_count;
    for (size_t i = self->frames.count; i-- > 0;) {
        const recorded_frame *const given = &self->frames.data[i];
        if (given->obstacle.index != id.index || given->obstacle.generation != id.generation ||
            given->frame != frame)
            continue;
        arena_mark const mark = arena_get_mark(&self->scratch);
        size_t place = given->place;
        recorded_call call;
        block_state state;
        tulle_status status = read_block(self, &place, &call, &state);
        if (status == TULLE_OK) { /* it was read before, so it fails for want of memory alone */
            status = call.numbers[0] < TULLE_STATUS_COUNT ? (tulle_status)call.numbers[0]
                                                          : TULLE_ERROR_PARSE;
            if (status == TULLE_OK && call.arrays[0].count != 3 * count) status = TULLE_ERROR_PARSE;
            if (status == TULLE_OK)
                memcpy(positions, call.arrays[0].data, 3 * count * sizeof(double));
            else
                error_set(error, status, "the reader gave no frame %u", frame);
        }
        arena_release(&self->scratch, mark);
        return status;
    }
    return error_set(error, TULLE_ERROR_UNSUPPORTED, "the recording has no frame %u", frame);
}

static int give_answer(void *context, const tulle_world *world, tulle_object_id a,
                       tulle_object_id b) {
    replay *const self = context;
    (void)world, (void)a, (void)b;
    return self->answers_given < self->answers.count ? self->answers.data[self->answers_given++]
                                                     : 0;
}

/* Looks through what belongs to the call that was just read, up to its result. `has_result` is
 * false where the recording is cut off before it. */
static tulle_status look_through(replay *self, recorded_call *result, bool *has_result) {
    self->answers.count = self->answers_given = 0;
    *has_result = false;
    while (!*has_result) {
        arena_mark const mark = arena_get_mark(&self->scratch);
        size_t const begin = self->place;
        block_state state;
        tulle_status const status = read_block(self, &self->place, result, &state);
        arena_release(&self->scratch, mark); /* results have no arrays */
        if (status != TULLE_OK || state == BLOCK_CUT) return status;
        if (result->kind == RECORD_FRAME) {
            if (!ARRAY_RESERVE(&self->heap, &self->frames, 1)) return refuse_memory(self);
            self->frames.data[self->frames.count++] =
                (recorded_frame){{result->ids[0], result->generations[0]}, result->ids[1], begin};
        } else if (result->kind == RECORD_ANSWER) {
            if (!ARRAY_RESERVE(&self->heap, &self->answers, 1)) return refuse_memory(self);
            self->answers.data[self->answers.count++] = result->numbers[0] != 0;
        } else if (result->kind == RECORD_RESULT && result->numbers[0] < TULLE_STATUS_COUNT) {
            *has_result = true;
        } else {
            return refuse_block(self, begin, "this does not belong within a call");
        }
    }
    return TULLE_OK;
}

/* ---- calls ---- */

static tulle_status create_world(replay *self, recorded_call *call) {
    size_t const room = sizeof self->report->version - 1;
    if (call->texts[0]) strncpy(self->report->version, call->texts[0], room);
    if (self->threads > 0) call->def.world.threads = self->threads;
    return tulle_world_create(&call->def.world, &self->world, &self->error);
}

static tulle_status add_obstacle(replay *self, recorded_call *call) {
    tulle_obstacle_def *const def = &call->def.obstacle;
    if (def->read_frame) {
        frame_source *const source = memory_allocate(&self->heap, sizeof *source);
        if (!source || !ARRAY_RESERVE(&self->heap, &self->sources, 1)) {
            memory_release(&self->heap, source, sizeof *source);
            return refuse_memory(self);
        }
        *source = (frame_source){self, world_find_next_obstacle(self->world)};
        self->sources.data[self->sources.count++] = source;
        def->read_frame = give_frame;
        def->frame_context = source;
    }
    return tulle_world_add_obstacle(self->world, def, NULL, &self->error);
}

static tulle_status make_law(replay *self, const recorded_call *call) {
    const tulle_contact_law *const given = &call->def.law;
    const uint32_t *const generations = call->generations;
    tulle_cloth_id const cloths[2] = {{call->ids[0], generations[0]},
                                      {call->ids[1], generations[1]}};
    tulle_obstacle_id const obstacles[2] = {{call->ids[0], generations[0]},
                                            {call->ids[1], generations[1]}};
    switch (call->kind) {
    case RECORD_CLOTH_CLOTH_LAW:
        return tulle_world_set_cloth_cloth_law(self->world, cloths[0], cloths[1], given,
                                               &self->error);
    case RECORD_CLOTH_OBSTACLE_LAW:
        return tulle_world_set_cloth_obstacle_law(self->world, cloths[0], obstacles[1], given,
                                                  &self->error);
    case RECORD_OBSTACLE_OBSTACLE_LAW:
        return tulle_world_set_obstacle_obstacle_law(self->world, obstacles[0], obstacles[1], given,
                                                     &self->error);
    default:
        return tulle_world_set_material_law(self->world, call->texts[0], call->texts[1], given,
                                            &self->error);
    }
}

/* Calls for a cloth, an attachment or the world. */
static tulle_status make_cloth_call(replay *self, recorded_call *call) {
    tulle_world *const world = self->world;
    tulle_error *const error = &self->error;
    tulle_cloth_id const cloth = {call->ids[0], call->generations[0]};
    const recorded_array *const first = &call->arrays[0];
    size_t const number = (size_t)call->numbers[0];
    tulle_attachment_id made;
    switch (call->kind) {
    case RECORD_CLOTH: return tulle_world_add_cloth(world, &call->def.cloth, NULL, error);
    case RECORD_FILTER:
        return tulle_object_set_filter(
            world,
            (tulle_object_id){(tulle_object_kind)call->ids[1], call->ids[0], call->generations[0]},
            (uint32_t)number, (uint32_t)call->numbers[1], error);
    case RECORD_PAIR_FILTER:
        return tulle_world_set_pair_filter(world, number ? give_answer : NULL, self, error);
    case RECORD_GRAVITY: return tulle_world_set_gravity(world, first->data, error);
    case RECORD_WIND: return tulle_world_set_wind(world, &call->def.wind, error);
    case RECORD_MATERIAL: return tulle_cloth_set_material(world, cloth, &call->def.material, error);
    case RECORD_THICKNESS:
        return tulle_cloth_set_thickness(world, cloth, first->data ? first->data[0] : 0.0, error);
    case RECORD_WAKE_CLOTH: return tulle_cloth_wake(world, cloth, error);
    case RECORD_RELEASE_PIN: return tulle_cloth_release_pin(world, cloth, number, error);
    case RECORD_PIN_TARGETS:
        return tulle_cloth_set_pin_targets(world, cloth, number, first->data, first->count / 3,
                                           error);
    case RECORD_TARGETS: {
        size_t const count = first->count / 3;
        tulle_cloth_targets const targets = {
            first->data, call->arrays[1].count == 3 * count ? call->arrays[1].data : NULL,
            call->def.state.byte_count == count ? call->def.state.bytes : NULL, count};
        return tulle_cloth_set_targets(world, cloth, &targets, error);
    }
    case RECORD_PLACE: return tulle_world_place(world, first->data, first->count / 3, error);
    case RECORD_ATTACH: return tulle_world_attach(world, &call->def.attachment, &made, error);
    case RECORD_POINTS:
        return tulle_attachment_set_points(world, call->ids[0], first->data, first->count / 3,
                                           error);
    case RECORD_RELEASE: return tulle_attachment_release(world, call->ids[0], error);
    default: return tulle_world_watch_events(world, number ? &call->def.watch : NULL, error);
    }
}

/* Calls for an obstacle or a body. */
static tulle_status make_obstacle_call(replay *self, recorded_call *call) {
    tulle_world *const world = self->world;
    tulle_error *const error = &self->error;
    tulle_obstacle_id const id = {call->ids[0], call->generations[0]};
    const double *const first = call->arrays[0].data, *const second = call->arrays[1].data;
    tulle_travel const travel = (tulle_travel)call->numbers[0];
    switch (call->kind) {
    case RECORD_OBSTACLE: return add_obstacle(self, call);
    case RECORD_TRANSFORM:
        return tulle_obstacle_set_next_transform(world, id, first, second, travel, error);
    case RECORD_POSITIONS:
        return tulle_obstacle_set_next_positions(world, id, first, call->arrays[0].count / 3,
                                                 travel, error);
    case RECORD_IMPULSE:
        if (first && second) return tulle_obstacle_add_impulse(world, id, first, second, error);
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "the point or the impulse is null");
    case RECORD_WAKE: return tulle_obstacle_wake(world, id, error);
    case RECORD_VELOCITY: return tulle_obstacle_set_velocity(world, id, first, second, error);
    case RECORD_FORCE: return tulle_obstacle_add_force(world, id, first, second, error);
    case RECORD_TORQUE: return tulle_obstacle_add_torque(world, id, first, error);
    case RECORD_LOCKS:
        return tulle_obstacle_set_locks(world, id, (unsigned)call->numbers[0],
                                        (unsigned)call->numbers[1], error);
    default:
        return tulle_obstacle_set_drive(world, id, call->numbers[0] ? &call->def.drive : NULL,
                                        error);
    }
}

static int stop_at_once(void *context) {
    (void)context;
    return 1;
}

/* A call that ended early by what lies outside of the calls: it leaves the world as it was, but a
 * step uses up what was given for it, and a world may have started in it. */
static tulle_status undo_call(replay *self, const recorded_call *call,
                              const recorded_call *result) {
    tulle_world *const world = self->world;
    tulle_status const recorded = (tulle_status)result->numbers[0];
    if (result->ids[0] && !world->is_started) {
        tulle_status const status = tulle_world_start(world, &self->error);
        if (status != TULLE_OK) return status;
    }
    if (call->kind != RECORD_STEP || !world->is_started) return recorded;
    tulle_world_set_stop_request(world, stop_at_once, NULL);
    tulle_status const status =
        tulle_world_step(world, call->arrays[0].data[0], NULL, &self->error);
    tulle_world_set_stop_request(world, NULL, NULL);
    return status == TULLE_ERROR_INTERRUPTED ? recorded : status;
}

static tulle_status start(replay *self, const recorded_call *call) {
    tulle_world *const world = self->world;
    tulle_error *const error = &self->error;
    const recorded_array *const first = &call->arrays[0], *const second = &call->arrays[1];
    if (!first->data && !second->data && call->numbers[0] == 0 && call->numbers[1] == 0)
        return tulle_world_start(world, error);
    tulle_moment moment = {.step_count = call->numbers[1],
                           .positions = first->data,
                           .velocities = second->data,
                           .vertex_count = first->count / 3};
    memcpy(&moment.time, &call->numbers[0], sizeof moment.time);
    size_t const rest = second->count >= first->count ? second->count - first->count : 0;
    if (second->count < first->count || rest % RECORD_BODY_COUNT != 0)
        return refuse_block(self, self->report->offset, "a start has odd arrays");
    moment.body_count = rest / RECORD_BODY_COUNT;
    tulle_transform *const bodies =
        ARENA_NEW(&self->scratch, tulle_transform, moment.body_count + 1);
    if (!bodies) return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory for the moment");
    for (size_t i = 0; i < moment.body_count; i++)
        memcpy(&bodies[i], second->data + first->count + RECORD_BODY_COUNT * i, RECORD_BODY_BYTES);
    moment.bodies = bodies;
    return tulle_world_start_at(world, &moment, error);
}

static tulle_status run_call(replay *self, recorded_call *call) {
    tulle_world *const world = self->world;
    tulle_error *const error = &self->error;
    tulle_cloth_id const cloth = {call->ids[0], call->generations[0]};
    tulle_obstacle_id const obstacle = {call->ids[0], call->generations[0]};
    switch (call->kind) {
    case RECORD_START: return start(self, call);
    case RECORD_STEP: return tulle_world_step(world, call->arrays[0].data[0], NULL, error);
    case RECORD_ADD_CLOTH: return tulle_world_add_cloth(world, &call->def.cloth, NULL, error);
    case RECORD_ADD_OBSTACLE: return add_obstacle(self, call);
    case RECORD_REMOVE_CLOTH: return tulle_world_remove_cloth(world, cloth, error);
    case RECORD_REMOVE_OBSTACLE: return tulle_world_remove_obstacle(world, obstacle, error);
    default:
        return tulle_world_load_state(world, call->def.state.bytes, call->def.state.byte_count,
                                      error);
    }
}

/* A call that runs, and what it came to. */
static tulle_status repeat_run(replay *self, recorded_call *call, bool *has_result) {
    tulle_replay_report *const report = self->report;
    recorded_call result;
    tulle_status const status = look_through(self, &result, has_result);
    if (status != TULLE_OK) return status;
    bool const has_numbers = call->kind != RECORD_STEP || call->arrays[0].data;
    if (!has_numbers) return refuse_block(self, report->offset, "a step has no time step");
    tulle_status const recorded = *has_result ? (tulle_status)result.numbers[0] : TULLE_OK;
    bool const is_undone =
        recorded == TULLE_ERROR_INTERRUPTED || recorded == TULLE_ERROR_OUT_OF_MEMORY;
    report->steps += call->kind == RECORD_STEP;
    report->status = is_undone ? undo_call(self, call, &result) : run_call(self, call);
    report->hash = tulle_world_get_state_hash(self->world);
    report->recorded_status = *has_result ? recorded : report->status;
    report->recorded_hash = *has_result ? result.numbers[1] : report->hash;
    return TULLE_OK;
}

/* Repeats one call that was read. `goes_on` becomes false at the end and where it is cut off. */
static tulle_status repeat_call(replay *self, recorded_call *call,
                                const tulle_replay_options *options, bool *goes_on) {
    tulle_replay_report *const report = self->report;
    bool const is_first = report->calls == 0;
    if (is_first != (call->kind == RECORD_CREATE))
        return refuse_block(self, report->offset,
                            is_first ? "it does not begin with the creation of a world"
                                     : "a second world is created");
    bool const runs = record_runs(call->kind);
    bool has_result = true;
    if (call->kind == RECORD_END) {
        report->is_whole = 1;
        *goes_on = false;
        if (self->place == self->byte_count) return TULLE_OK;
        return refuse_block(self, self->place, "bytes follow its end");
    }
    if (!is_first && call->kind < RECORD_START)
        return refuse_block(self, report->offset, "this belongs within a call");
    report->call = record_kinds[call->kind].name;
    report->recorded_status = report->status = TULLE_OK;
    bool const is_law = call->kind >= RECORD_CLOTH_CLOTH_LAW && call->kind <= RECORD_MATERIAL_LAW;
    bool const is_obstacle = call->kind == RECORD_OBSTACLE || call->kind == RECORD_TRANSFORM ||
                             call->kind == RECORD_POSITIONS ||
                             (call->kind >= RECORD_IMPULSE && call->kind <= RECORD_DRIVE);
    if (runs) {
        tulle_status const status = repeat_run(self, call, &has_result);
        if (status != TULLE_OK) return status;
    } else {
        report->status = is_first      ? create_world(self, call)
                         : is_law      ? make_law(self, call)
                         : is_obstacle ? make_obstacle_call(self, call)
                                       : make_cloth_call(self, call);
    }
    report->calls++;
    report->message[0] = '\0';
    if (report->status != TULLE_OK)
        snprintf(report->message, sizeof report->message, "%.*s", (int)sizeof report->message - 1,
                 self->error.message);
    report->is_different =
        report->status != report->recorded_status || report->hash != report->recorded_hash;
    if (report->status == TULLE_ERROR_OUT_OF_MEMORY && report->is_different)
        return TULLE_ERROR_OUT_OF_MEMORY; /* of this replay; its message is there */
    *goes_on = has_result && !report->is_different;
    if (runs && options->observe && options->observe(options->context, self->world, report))
        *goes_on = false;
    return TULLE_OK;
}

static void release(replay *self) {
    tulle_world_destroy(self->world);
    for (size_t i = 0; i < self->sources.count; i++)
        memory_release(&self->heap, self->sources.data[i], sizeof *self->sources.data[i]);
    ARRAY_FREE(&self->heap, &self->sources);
    ARRAY_FREE(&self->heap, &self->frames);
    ARRAY_FREE(&self->heap, &self->answers);
    arena_destroy(&self->scratch);
}

tulle_status tulle_replay(const void *bytes, size_t byte_count, const tulle_replay_options *options,
                          tulle_replay_report *report, tulle_error *error) {
    tulle_replay_options const zeroed = {0};
    if (!options) options = &zeroed;
    if (!bytes || !report)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "the bytes of the recording or the report is null");
    if (options->threads < 0 || options->threads > 256)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "there are %d threads; there must be 0 to 256", options->threads);
    *report = (tulle_replay_report){0};
    /* its last byte is the version */
    if (byte_count < RECORD_MAGIC_BYTES || memcmp(bytes, RECORD_MAGIC, RECORD_MAGIC_BYTES - 1) != 0)
        return error_set(error, TULLE_ERROR_PARSE, "these bytes are not a recording of a world");
    if (((const char *)bytes)[RECORD_MAGIC_BYTES - 1] != RECORD_MAGIC[RECORD_MAGIC_BYTES - 1])
        return error_set(error, TULLE_ERROR_PARSE,
                         "the recording is of another version of the format than Tulle %s reads: "
                         "take the version of Tulle that made it",
                         tulle_version());
    replay self = {.bytes = bytes,
                   .byte_count = byte_count,
                   .place = RECORD_MAGIC_BYTES,
                   .threads = options->threads,
                   .report = report};
    self.scratch = arena_make(&self.heap);
    tulle_status status = TULLE_OK;
    bool goes_on = true;
    while (status == TULLE_OK && goes_on) {
        arena_mark const mark = arena_get_mark(&self.scratch);
        recorded_call call;
        block_state state;
        report->offset = self.place;
        status = read_block(&self, &self.place, &call, &state);
        if (status == TULLE_OK && state == BLOCK_CUT) break;
        if (status == TULLE_OK) status = repeat_call(&self, &call, options, &goes_on);
        arena_release(&self.scratch, mark);
    }
    release(&self);
    if (status != TULLE_OK && error) {
        *error = self.error;
        error->status = status;
    }
    return status;
}
