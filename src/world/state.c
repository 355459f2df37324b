/* world/state.c - the state as a hash and as bytes.
 *
 * A saved state holds everything that decides later steps and is not in the defs: positions,
 * velocities, history of BDF2, clocks, presence of obstacles, contacts with their
 * impulses, ignored pairs, plastic parts where cloth has hysteresis, poses of obstacles that the
 * host drives as a whole, lags of lagging surfaces, attachments, and what the host has changed:
 * gravity, wind, laws, materials, pins, locks and drives. What the host gave for the next step is
 * input and no state. Obstacles that never move are left out: both states of the world have them
 * from its start on, to the bit (place_obstacles). It also holds the patches: they decide how fast
 * later steps are and what reports say, but no position. Little-endian, doubles as they are. */
#include "base/error.h"
#include "base/hash.h"
#include "step/bodies/bodies.h"
#include "step/lag/lag.h"
#include "step/step.h"
#include "tulle/live.h"
#include "world/record/record.h"

#include <stddef.h>
#include <string.h>

/* E: version. */
static const char STATE_MAGIC[8] = {'T', 'U', 'L', 'L', 'E', 'S', 'T', 'F'};

typedef struct state_header {
    char magic[8];
    uint64_t hash; /* of all bytes behind it */
    uint64_t byte_count, def_hash;
    uint64_t vertex_count, obstacle_count, step_count;
    uint64_t contact_bytes, patch_bytes, setting_bytes, ignored_count, still_count;
    uint64_t control_bytes, tie_count, attachment_count, lag_count;
    double time, previous_time_step, lost_energy;
} state_header;

static uint64_t compute_hash(const unsigned char *bytes, size_t byte_count) {
    size_t const begin = offsetof(state_header, byte_count);
    return hash_block(bytes + begin, byte_count - begin);
}

/* Cursor over a block of bytes, for writing or reading in the same order. */
typedef struct byte_cursor {
    unsigned char *bytes;
    size_t used;
} byte_cursor;

static void put(byte_cursor *cursor, const void *source, size_t byte_count) {
    if (byte_count > 0) memcpy(cursor->bytes + cursor->used, source, byte_count);
    cursor->used += byte_count;
}

static void take(byte_cursor *cursor, void *target, size_t byte_count) {
    if (byte_count > 0) memcpy(target, cursor->bytes + cursor->used, byte_count);
    cursor->used += byte_count;
}

moving_run world_first_moving(const tulle_world *world) {
    size_t const count = world->model.surface_count;
    size_t surface = world->model.cloths.count;
    while (surface < count && !world->work.surfaces[surface].is_static) surface++;
    return (moving_run){
        0, surface < count ? world->work.surfaces[surface].vertex_begin : world->model.vertex_count,
        surface};
}

bool world_next_moving(const tulle_world *world, moving_run *run) {
    size_t const count = world->model.surface_count;
    if (run->surface >= count) return false;
    size_t surface = run->surface + 1;
    while (surface < count && !world->work.surfaces[surface].is_static) surface++;
    run->begin = world->work.surfaces[run->surface].vertex_end;
    run->end =
        surface < count ? world->work.surfaces[surface].vertex_begin : world->model.vertex_count;
    run->surface = surface;
    return true;
}

static size_t count_moving(const tulle_world *world) {
    size_t count = 0;
    moving_run run = world_first_moving(world);
    do count += run.end - run.begin;
    while (world_next_moving(world, &run));
    return count;
}

static void put_moving(byte_cursor *cursor, const tulle_world *world, const double *vectors) {
    moving_run run = world_first_moving(world);
    do put(cursor, vectors + 3 * run.begin, 3 * (run.end - run.begin) * sizeof *vectors);
    while (world_next_moving(world, &run));
}

static void take_moving(byte_cursor *cursor, const tulle_world *world, double *vectors) {
    moving_run run = world_first_moving(world);
    do take(cursor, vectors + 3 * run.begin, 3 * (run.end - run.begin) * sizeof *vectors);
    while (world_next_moving(world, &run));
}

uint64_t tulle_world_get_state_hash(const tulle_world *world) {
    if (!world || !world->is_started) return HASH_SEED;
    const motion_state *const now = &world->now;
    size_t const bytes = 3 * world->model.vertex_count * sizeof(double);
    uint64_t hash = HASH_SEED;
    double *vectors[STATE_VECTORS_MAX];
    size_t const vector_count = step_list_vectors(now, vectors);
    for (size_t i = 0; i < vector_count; i++) hash = hash_bytes(hash, vectors[i], bytes);
    if (world->model.plastic_count > 0)
        hash = hash_bytes(hash, now->plastic, world->model.plastic_count * sizeof(double));
    double const clocks[2] = {now->time, now->previous_time_step};
    hash = hash_bytes(hash, clocks, sizeof clocks);
    hash = hash_bytes(hash, &world->now.step_count, sizeof world->now.step_count);
    hash = hash_bytes(hash, now->is_present, world->model.obstacles.count);
    hash = hash_bytes(hash, now->particles, world->model.particle_count);
    hash = hash_bytes(hash, now->rests, world->model.body_count * sizeof *now->rests);
    hash = hash_bytes(hash, now->poses, world->model.pose_count * sizeof *now->poses);
    if (world->model.cloth_rest_count > 0)
        hash = hash_bytes(hash, now->cloth_rests,
                          world->model.cloth_rest_count * sizeof *now->cloth_rests);
    if (now->still_count > 0)
        hash = hash_bytes(hash, now->still, now->still_count * sizeof *now->still);
    if (world->model.body_count > 0)
        hash = hash_bytes(hash, &now->lost_energy, sizeof now->lost_energy);
    hash = hash_bytes(hash, world->ignored.data, world->ignored.count * sizeof(tulle_intersection));
    hash = world_hash_settings(world, hash);
    hash = world_hash_controls(world, hash);
    if (now->attachment_count > 0) {
        hash = hash_bytes(hash, &now->attachment_count, sizeof now->attachment_count);
        hash = hash_bytes(hash, now->ties.data, now->ties.count * sizeof *now->ties.data);
    }
    if (step_has_lags(&world->model, now))
        hash = hash_bytes(hash, now->lags, 3 * world->model.lag_vertex_count * sizeof(double));
    return contact_store_hash(&now->contacts, hash);
}

/* The variable parts of a state. */
typedef struct part_sizes {
    size_t contact_bytes, patch_bytes, ignored_count, still_count, setting_bytes, control_bytes,
        tie_count, lag_count;
} part_sizes;

static size_t state_size(const tulle_world *world, part_sizes parts) {
    double *vectors[STATE_VECTORS_MAX];
    size_t const vector_count = step_list_vectors(&world->now, vectors);
    return sizeof(state_header) + 3 * vector_count * count_moving(world) * sizeof(double) +
           world->model.plastic_count * sizeof(double) + world->model.obstacles.count +
           world->model.particle_count + world->model.body_count * sizeof(body_rest) +
           world->model.cloth_rest_count * sizeof(cloth_rest) +
           world->model.pose_count * sizeof(motion_pose) + parts.still_count * sizeof(still_place) +
           parts.tie_count * sizeof(world_tie) + 3 * parts.lag_count * sizeof(double) +
           parts.contact_bytes + parts.patch_bytes +
           parts.ignored_count * sizeof(tulle_intersection) + parts.control_bytes +
           parts.setting_bytes;
}

/* The parts that a header names. Each of its counts has been checked to fit into the saved bytes.
 */
static part_sizes read_parts(const state_header *header) {
    return (part_sizes){(size_t)header->contact_bytes, (size_t)header->patch_bytes,
                        (size_t)header->ignored_count, (size_t)header->still_count,
                        (size_t)header->setting_bytes, (size_t)header->control_bytes,
                        (size_t)header->tie_count,     (size_t)header->lag_count};
}

static part_sizes measure_parts(const tulle_world *world) {
    return (part_sizes){
        .contact_bytes = contact_store_get_size(&world->now.contacts),
        .patch_bytes = world->work.patches ? kept_patches_save(world->work.patches, NULL) : 0,
        .ignored_count = world->ignored.count,
        .still_count = world->now.still_count,
        .setting_bytes = world_get_settings_size(world),
        .control_bytes = world_get_controls_size(world),
        .tie_count = world->now.ties.count,
        .lag_count = step_has_lags(&world->model, &world->now) ? world->model.lag_vertex_count : 0};
}

/* All but the header. */
static void put_parts(const tulle_world *world, part_sizes parts, byte_cursor *cursor) {
    const motion_state *const now = &world->now;
    double *vectors[STATE_VECTORS_MAX];
    size_t const vector_count = step_list_vectors(now, vectors);
    for (size_t i = 0; i < vector_count; i++) put_moving(cursor, world, vectors[i]);
    put(cursor, now->plastic, world->model.plastic_count * sizeof(double));
    put(cursor, now->is_present, world->model.obstacles.count);
    put(cursor, now->particles, world->model.particle_count);
    put(cursor, now->rests, world->model.body_count * sizeof *now->rests);
    put(cursor, now->cloth_rests, world->model.cloth_rest_count * sizeof *now->cloth_rests);
    put(cursor, now->poses, world->model.pose_count * sizeof *now->poses);
    put(cursor, now->still, parts.still_count * sizeof *now->still);
    put(cursor, now->ties.data, parts.tie_count * sizeof *now->ties.data);
    put(cursor, now->lags, 3 * parts.lag_count * sizeof(double));
    put(cursor, world->ignored.data, parts.ignored_count * sizeof(tulle_intersection));
    contact_store_save(&now->contacts, cursor->bytes + cursor->used);
    cursor->used += parts.contact_bytes;
    if (parts.patch_bytes > 0) kept_patches_save(world->work.patches, cursor->bytes + cursor->used);
    cursor->used += parts.patch_bytes;
    put(cursor, world->model.controls, parts.control_bytes);
    if (parts.setting_bytes > 0) world_put_settings(world, cursor->bytes + cursor->used);
    cursor->used += parts.setting_bytes;
}

size_t tulle_world_get_state_size(const tulle_world *world) {
    return world && world->is_started ? state_size(world, measure_parts(world)) : 0;
}

/* The state into `size` bytes, which is the size that it has with these parts. */
static void write_state(const tulle_world *world, part_sizes parts, unsigned char *bytes,
                        size_t size) {
    byte_cursor cursor = {bytes, sizeof(state_header)};
    put_parts(world, parts, &cursor);
    state_header header = {.byte_count = size,
                           .def_hash = world->def_hash,
                           .vertex_count = world->model.vertex_count,
                           .obstacle_count = world->model.obstacles.count,
                           .step_count = world->now.step_count,
                           .contact_bytes = parts.contact_bytes,
                           .patch_bytes = parts.patch_bytes,
                           .setting_bytes = parts.setting_bytes,
                           .control_bytes = parts.control_bytes,
                           .ignored_count = parts.ignored_count,
                           .still_count = parts.still_count,
                           .tie_count = parts.tie_count,
                           .lag_count = parts.lag_count,
                           .attachment_count = world->now.attachment_count,
                           .time = world->now.time,
                           .previous_time_step = world->now.previous_time_step,
                           .lost_energy = world->now.lost_energy};
    memcpy(header.magic, STATE_MAGIC, sizeof header.magic);
    memcpy(bytes, &header, sizeof header);
    header.hash = compute_hash(bytes, size);
    memcpy(bytes, &header, sizeof header);
}

static tulle_status check_savable(const tulle_world *world, bool has_place, tulle_error *error) {
    if (world && world->is_started && has_place) return TULLE_OK;
    return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                     "start the world before its state is saved, and give memory that is not null");
}

tulle_status tulle_world_save_state_into(const tulle_world *world, void *bytes, size_t capacity,
                                         size_t *byte_count, tulle_error *error) {
    tulle_status const status = check_savable(world, bytes && byte_count, error);
    if (status != TULLE_OK) return status;
    part_sizes const parts = measure_parts(world);
    size_t const size = state_size(world, parts);
    if (size > capacity) {
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "the state takes %zu bytes, and there is room for %zu", size, capacity);
    }
    write_state(world, parts, bytes, size);
    *byte_count = size;
    return TULLE_OK;
}

tulle_status tulle_world_save_state(const tulle_world *world, void **bytes, size_t *byte_count,
                                    tulle_error *error) {
    tulle_status const status = check_savable(world, bytes && byte_count, error);
    if (status != TULLE_OK) return status;
    part_sizes const parts = measure_parts(world);
    size_t const size = state_size(world, parts);
    memory heap = {.allocator = world->model.def.allocator};
    unsigned char *const made = memory_allocate(&heap, size);
    if (!made) {
        return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory left to save the state");
    }
    write_state(world, parts, made, size);
    *bytes = made;
    *byte_count = size;
    return TULLE_OK;
}

void tulle_world_free_state(const tulle_world *world, void *bytes, size_t byte_count) {
    if (!world) return;
    memory heap = {.allocator = world->model.def.allocator};
    heap.bytes_held = SIZE_MAX / 2; /* another heap counted the block */
    memory_release(&heap, bytes, byte_count);
}

static tulle_status check_header(const tulle_world *world, const state_header *header,
                                 const unsigned char *bytes, size_t byte_count,
                                 tulle_error *error) {
    if (memcmp(header->magic, STATE_MAGIC, sizeof header->magic - 1) != 0) {
        return error_set(error, TULLE_ERROR_PARSE, "these bytes are not a saved state");
    }
    if (header->magic[7] != STATE_MAGIC[7]) {
        return error_set(error, TULLE_ERROR_PARSE,
                         "the saved state is of another version of Tulle (format %c, this one "
                         "reads %c): start the run again",
                         header->magic[7] >= ' ' && header->magic[7] <= '~' ? header->magic[7]
                                                                            : '?',
                         STATE_MAGIC[7]);
    }
    uint64_t const left = byte_count / sizeof(tulle_intersection);
    if (header->byte_count != byte_count || header->contact_bytes > byte_count ||
        header->patch_bytes > byte_count || header->ignored_count > left ||
        header->still_count > STILL_PLACES || header->setting_bytes > byte_count ||
        header->control_bytes > byte_count || header->tie_count > byte_count / sizeof(world_tie) ||
        header->attachment_count > UINT32_MAX || header->hash != compute_hash(bytes, byte_count)) {
        return error_set(error, TULLE_ERROR_PARSE, "the saved state is damaged or cut off");
    }
    if (header->def_hash != world->def_hash || header->vertex_count != world->model.vertex_count ||
        header->obstacle_count != world->model.obstacles.count ||
        (header->control_bytes != 0 &&
         header->control_bytes != world->model.body_count * sizeof *world->model.controls) ||
        (header->lag_count != 0 && header->lag_count != world->model.lag_vertex_count) ||
        state_size(world, read_parts(header)) != byte_count) {
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "the saved state belongs to another scene");
    }
    return TULLE_OK;
}

/* Reads the ignored pairs into world->ignored_start, which nothing uses between steps, and makes
 * room for them among those that are ignored now. */
static tulle_status take_ignored(tulle_world *world, byte_cursor *cursor, size_t count,
                                 tulle_error *error) {
    world->ignored_start.count = 0;
    size_t const old_count = world->ignored.count,
                 extra = count > old_count ? count - old_count : 0;
    if (!ARRAY_RESERVE(&world->heap, &world->ignored_start, count) ||
        !ARRAY_RESERVE(&world->heap, &world->ignored, extra) ||
        !ARRAY_RESERVE(&world->heap, &world->work.ignored_keys, extra)) {
        return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory left to load the state");
    }
    take(cursor, world->ignored_start.data, count * sizeof(tulle_intersection));
    for (size_t i = 0; i < count; i++) {
        const tulle_intersection *const pair = &world->ignored_start.data[i];
        uint32_t const objects[2] = {pair->object_a, pair->object_b};
        uint32_t const triangles[2] = {pair->triangle_a, pair->triangle_b};
        for (int k = 0; k < 2; k++) {
            if (objects[k] >= world->model.surface_count ||
                triangles[k] >= world->work.surfaces[objects[k]].triangle_end -
                                    world->work.surfaces[objects[k]].triangle_begin) {
                return error_set(
                    error, TULLE_ERROR_PARSE,
                    "the saved state names triangles that are not there: start the run again");
            }
        }
    }
    world->ignored_start.count = count;
    return TULLE_OK;
}

/* Loads the patches. After an error they are as before, or there are none if memory is too short
 * for that; the next step then grows its own. */
static tulle_status take_patches(tulle_world *world, const unsigned char *bytes, size_t byte_count,
                                 tulle_error *error) {
    if (!world->work.patches) return TULLE_OK;
    tulle_status status = step_keep_patches(&world->work);
    if (status == TULLE_OK) {
        status = kept_patches_load(world->work.patches, bytes, byte_count);
        if (status != TULLE_OK) step_restore_patches(&world->work);
    }
    if (status == TULLE_OK) return status;
    if (status == TULLE_ERROR_OUT_OF_MEMORY)
        return error_set(error, status, "no memory left to load the patches of the saved state");
    return error_set(error, TULLE_ERROR_PARSE,
                     "the patches of the saved state cannot be read: start the run again");
}

static tulle_status load_state(tulle_world *world, const void *bytes, size_t byte_count,
                               tulle_error *error) {
    tulle_status status = TULLE_OK;
    state_header header;
    if (byte_count < sizeof header) {
        return error_set(error, TULLE_ERROR_PARSE, "the saved state is damaged or cut off");
    }
    memcpy(&header, bytes, sizeof header);
    status = check_header(world, &header, bytes, byte_count, error);
    if (status != TULLE_OK) return status;

    part_sizes const parts = read_parts(&header);
    const unsigned char *const settings =
        (const unsigned char *)bytes + byte_count - parts.setting_bytes;
    const unsigned char *const controls = settings - parts.control_bytes;

    /* into the spare state first, so that a failure changes nothing */
    motion_state *const next = &world->next;
    byte_cursor cursor = {(unsigned char *)(uintptr_t)bytes, sizeof header};
    double *vectors[STATE_VECTORS_MAX];
    size_t const vector_count = step_list_vectors(next, vectors);
    for (size_t i = 0; i < vector_count; i++) take_moving(&cursor, world, vectors[i]);
    take(&cursor, next->plastic, world->model.plastic_count * sizeof(double));
    take(&cursor, next->is_present, world->model.obstacles.count);
    take(&cursor, next->particles, world->model.particle_count);
    take(&cursor, next->rests, world->model.body_count * sizeof *next->rests);
    take(&cursor, next->cloth_rests, world->model.cloth_rest_count * sizeof *next->cloth_rests);
    take(&cursor, next->poses, world->model.pose_count * sizeof *next->poses);
    next->elastic.is_known = false;
    next->still_count = parts.still_count;
    take(&cursor, next->still, parts.still_count * sizeof *next->still);
    next->ties.count = 0;
    if (!ARRAY_RESERVE(&world->heap, &next->ties, parts.tie_count) ||
        !ARRAY_MATCH(&world->heap, &next->ties, &world->now.ties))
        return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory left to load the state");
    next->ties.count = parts.tie_count;
    take(&cursor, next->ties.data, parts.tie_count * sizeof *next->ties.data);
    memset(next->lags, 0, 3 * world->model.lag_vertex_count * sizeof(double));
    take(&cursor, next->lags, 3 * parts.lag_count * sizeof(double));
    step_measure_lags(&world->model, next);
    next->attachment_count = (uint32_t)header.attachment_count;
    next->time = header.time;
    next->previous_time_step = header.previous_time_step;
    next->lost_energy = header.lost_energy;
    if (world->model.body_count > 0) /* not saved */
        memset(next->drive_forces, 0, BODY_AXES * world->model.body_count * sizeof(double));
    status = world_check_settings(world, settings, parts.setting_bytes, error);
    if (status == TULLE_OK)
        status = world_check_controls(world, controls, parts.control_bytes, error);
    if (status == TULLE_OK) status = world_check_state(world, next, error);
    if (status == TULLE_OK) status = take_ignored(world, &cursor, parts.ignored_count, error);
    if (status != TULLE_OK) return status;
    status = contact_store_load(&next->contacts, &world->heap, cursor.bytes + cursor.used,
                                parts.contact_bytes);
    if (status == TULLE_ERROR_OUT_OF_MEMORY)
        return error_set(error, status, "no memory left for the contacts of the saved state");
    if (status != TULLE_OK || !contact_store_fits(&next->contacts, &world->model.topo))
        return error_set(error, TULLE_ERROR_PARSE,
                         "the contacts of the saved state cannot be read: start the run again");
    status = world_find_touching(world, next, error);
    if (status != TULLE_OK) return status;
    status = take_patches(world, cursor.bytes + cursor.used + parts.contact_bytes,
                          parts.patch_bytes, error);
    if (status != TULLE_OK) return status;

    world_restore_ignored(world); /* as read */
    world_take_settings(world, settings, parts.setting_bytes);
    world_take_controls(world, controls, parts.control_bytes);
    world->intersections.count = world->overlaps.count = 0;
    motion_state const old = world->now;
    world->now = *next;
    world->next = old;
    world->now.step_count = header.step_count;
    world->accepted_rows.rows.count = 0; /* a saved state has no rows */
    world->has_contacts = world->work.has_queries = false;
    for (size_t i = 0; i < world->model.obstacles.count; i++) {
        frame_cache *const frames = world->model.obstacles.data[i].frames;
        world->work.surfaces[world->model.cloths.count + i].is_present = world->now.is_present[i];
        /* a live reader gives what belongs to the state from here on */
        if (frames) frames->numbers[0] = frames->numbers[1] = TULLE_NONE;
    }
    world_end_given(world, true);
    step_mark_bodies(&world->model, &world->now, &world->work);
    world_restart_events(world);
    return TULLE_OK;
}

tulle_status tulle_world_load_state(tulle_world *world, const void *bytes, size_t byte_count,
                                    tulle_error *error) {
    if (!bytes)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "the bytes of the state are null");
    if (!world) return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "the world is null");
    recorded_call const call = {.kind = RECORD_LOAD, .def.state = {bytes, byte_count}};
    tulle_status status = world_begin_call(world, &call, error);
    if (status != TULLE_OK) return status;
    bool const was_started = world->is_started;
    status = world_start(world, false, NULL, error);
    if (status == TULLE_OK) {
        status = load_state(world, bytes, byte_count, error);
        if (status != TULLE_OK && !was_started) world_release_start(world); /* not judged */
        if (status == TULLE_OK) world_release_first_cloth(world);
    }
    world_end_call(world, status);
    return status;
}
