/* world/record/record.c - recording the calls of a host (tulle/record.h). Each call becomes one
 * block in memory, which is given to the host's writer at once. */
#include "world/record/record.h"

#include "base/error.h"
#include "tulle/record.h"
#include "world/fields/fields.h"

#include <string.h>

struct world_recording {
    tulle_record_writer writer;
    record_stream stream; /* one block at a time */
};

/* Gives what is in the stream to the writer. */
static void write_out(world_recording *recording) {
    record_stream *const stream = &recording->stream;
    if (stream->status == TULLE_OK &&
        recording->writer.write(recording->writer.context, stream->bytes.data,
                                stream->bytes.count) != 1)
        stream->status = TULLE_ERROR_IO;
    stream->bytes.count = 0;
}

void world_record(tulle_world *world, const recorded_call *call) {
    world_recording *const recording = world->recording;
    if (recording->stream.status != TULLE_OK) return;
    (void)recorded_call_write(&recording->stream, call);
    write_out(recording);
}

void world_record_frame(void *context, size_t obstacle, uint32_t frame, const double *positions,
                        tulle_status status) {
    tulle_world *const world = context;
    const world_obstacle *const of = &world->model.obstacles.data[obstacle];
    recorded_call const call = {.kind = RECORD_FRAME,
                                .ids = {of->slot, frame},
                                .generations = {world->slots.obstacles.data[of->slot].generation},
                                .numbers = {(uint64_t)status},
                                .arrays = {{positions, positions ? 3 * of->mesh.vertex_count : 0}}};
    world_record(world, &call);
}

tulle_status world_check_recording(const tulle_world *world, tulle_error *error) {
    tulle_status const status = world->recording ? world->recording->stream.status : TULLE_OK;
    if (status == TULLE_OK) return TULLE_OK;
    return error_set(error, status,
                     "the recording of the calls has ended early, because %s; end it with "
                     "tulle_world_record to continue without it",
                     status == TULLE_ERROR_IO ? "its writer took no more"
                                              : "there was no memory for a block");
}

tulle_status world_begin_call(tulle_world *world, const recorded_call *call, tulle_error *error) {
    if (!world->recording) return TULLE_OK;
    world_record(world, call);
    return world_check_recording(world, error);
}

void world_end_call(tulle_world *world, tulle_status status) {
    if (!world->recording) return;
    uint64_t const hash = tulle_world_get_state_hash(world);
    world_record(world, &(recorded_call){.kind = RECORD_RESULT,
                                         .ids = {world->is_started},
                                         .numbers = {(uint64_t)status, hash}});
}

static void release_recording(tulle_world *world) {
    memory *const heap = &world->heap;
    ARRAY_FREE(heap, &world->recording->stream.bytes);
    memory_release(heap, world->recording, sizeof *world->recording);
    world->recording = NULL;
    world_point_work(world);
}

void world_end_recording(tulle_world *world) {
    if (!world->recording) return;
    world_record(world, &(recorded_call){.kind = RECORD_END});
    release_recording(world);
}

/* What a world already has that a recording would lack, or null. */
static const char *find_obstruction(const tulle_world *world) {
    if (world->recording) return "it is recorded already";
    if (world->is_started) return "it has started";
    if (world->slots.cloths.count + world->slots.obstacles.count > 0) return "it has had objects";
    if (world->rules.material_laws.count > 0) return "it has laws of materials";
    return world->rules.pair_filter ? "it has a pair filter" : NULL;
}

tulle_status tulle_world_record(tulle_world *world, const tulle_record_writer *writer,
                                tulle_error *error) {
    if (!world) return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "the world is null");
    if (!writer) {
        tulle_status status = world_check_recording(world, error);
        if (world->recording && status == TULLE_OK) {
            world_record(world, &(recorded_call){.kind = RECORD_END});
            status = world_check_recording(world, error);
        }
        if (world->recording) release_recording(world);
        return status;
    }
    if (!writer->write)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "the writer has no function");
    const char *const obstruction = find_obstruction(world);
    if (obstruction)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "a world is recorded from its creation on, and %s", obstruction);
    world_recording *const made = memory_allocate_zeroed(&world->heap, 1, sizeof *made);
    if (!made)
        return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory left to record the calls");
    made->writer = *writer;
    made->stream.heap = &world->heap;
    world->recording = made;
    world_point_work(world);
    record_stream *const stream = &made->stream;
    recorded_call create = {
        .kind = RECORD_CREATE, .numbers = {fields_version}, .texts = {tulle_version()}};
    create.def.world = world->model.def;
    if (ARRAY_RESERVE(&world->heap, &stream->bytes, RECORD_MAGIC_BYTES)) {
        memcpy(stream->bytes.data, RECORD_MAGIC, RECORD_MAGIC_BYTES);
        stream->bytes.count = RECORD_MAGIC_BYTES;
    } else {
        stream->status = TULLE_ERROR_OUT_OF_MEMORY;
    }
    world_record(world, &create);
    tulle_status const status = stream->status;
    if (status == TULLE_OK) return TULLE_OK;
    release_recording(world);
    return error_set(error, status, "the calls cannot be recorded: %s",
                     status == TULLE_ERROR_IO ? "the writer did not take the first block"
                                              : "no memory is left");
}
