/* world/world.c - making, filling and destroying a world. Everything that defs point to is copied.
 */
#include "base/error.h"
#include "base/hash.h"
#include "base/parallel.h"
#include "base/text.h"
#include "world/change/change.h"
#include "world/defs.h"
#include "world/fields/fields.h"
#include "world/record/record.h"
#include "world/world_state.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static tulle_status out_of_memory(tulle_error *error, const char *what) {
    return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory left for %s", what);
}

void world_point_work(tulle_world *world) {
    step_work *const work = &world->work;
    work->heap = &world->heap;
    work->start = &world->now;
    work->frames.tell = world->recording ? world_record_frame : NULL;
    work->frames.context = world;
}

tulle_status tulle_world_create(const tulle_world_def *def, tulle_world **world,
                                tulle_error *error) {
    if (!world) return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "no place for the world");
    *world = NULL;
    tulle_status const status = world_def_check(def, error);
    if (status != TULLE_OK) return status;
    memory heap = {.allocator = def->allocator};
    tulle_world *const made = memory_allocate_zeroed(&heap, 1, sizeof *made);
    if (!made) return out_of_memory(error, "the world");
    made->heap = heap;
    made->model.def = *def;
    made->model.paper = def->paper ? *def->paper : tulle_paper_options_default();
    made->model.def.paper = &made->model.paper;
    made->work.threads = parallel_resolve_threads(def->threads);
    made->work.scratch = arena_make(&made->heap);
    world_point_work(made);
    made->def_hash = HASH_SEED;
    made->first.def_hash = world_def_hash(&made->model.def);
    *world = made;
    return TULLE_OK;
}

/* A copy of count * size bytes; null when memory is short. */
static void *copy_array(memory *heap, const void *source, size_t count, size_t size) {
    void *const copy = memory_allocate(heap, count * size);
    if (copy && count > 0) memcpy(copy, source, count * size);
    return copy;
}

static tulle_status copy_mesh(memory *heap, tulle_mesh_view view, world_mesh *mesh) {
    mesh->positions = copy_array(heap, view.positions, view.vertex_count, 3 * sizeof(double));
    mesh->triangles = copy_array(heap, view.triangles, view.triangle_count, 3 * sizeof(uint32_t));
    mesh->vertex_count = view.vertex_count;
    mesh->triangle_count = view.triangle_count;
    for (size_t i = 0; i < 3 * view.vertex_count; i++)
        mesh->extent = fmax(mesh->extent, fabs(view.positions[i]));
    return mesh->positions && mesh->triangles ? TULLE_OK : TULLE_ERROR_OUT_OF_MEMORY;
}

static void destroy_mesh(memory *heap, world_mesh *mesh) {
    memory_release(heap, mesh->positions, 3 * mesh->vertex_count * sizeof(double));
    memory_release(heap, mesh->triangles, 3 * mesh->triangle_count * sizeof(uint32_t));
}

void world_destroy_cloth(memory *heap, world_cloth *cloth) {
    size_t const vector_bytes = 3 * cloth->mesh.vertex_count * sizeof(double);
    memory_release(heap, cloth->rest, vector_bytes);
    memory_release(heap, cloth->warps, 3 * cloth->mesh.triangle_count * sizeof(double));
    memory_release(heap, cloth->factors, cloth->mesh.triangle_count * sizeof(double));
    memory_release(heap, cloth->rest_corners, 9 * cloth->mesh.triangle_count * sizeof(double));
    memory_release(heap, cloth->creases, cloth->crease_count * sizeof *cloth->creases);
    memory_release(heap, cloth->velocities, vector_bytes);
    memory_release(heap, cloth->targets, 7 * cloth->mesh.vertex_count * sizeof(double));
    for (size_t i = 0; cloth->pins && i < cloth->pin_count; i++) {
        world_pin *const pin = &cloth->pins[i];
        memory_release(heap, pin->vertices, pin->vertex_count * sizeof *pin->vertices);
        memory_release(heap, pin->targets, 3 * pin->vertex_count * sizeof(double));
        motion_destroy(heap, &pin->motion);
    }
    memory_release(heap, cloth->pins, cloth->pin_count * sizeof *cloth->pins);
    destroy_mesh(heap, &cloth->mesh);
}

void world_destroy_obstacle(memory *heap, world_obstacle *obstacle) {
    size_t const vector_bytes = 3 * obstacle->mesh.vertex_count * sizeof(double);
    if (obstacle->frames)
        for (int i = 0; i < 2; i++)
            memory_release(heap, obstacle->frames->positions[i], vector_bytes);
    memory_release(heap, obstacle->frames, sizeof *obstacle->frames);
    if (obstacle->points) memory_release(heap, obstacle->points, vector_bytes);
    memory_release(heap, obstacle->given_positions, vector_bytes);
    motion_destroy(heap, &obstacle->motion);
    destroy_mesh(heap, &obstacle->mesh);
}

void tulle_world_destroy(tulle_world *world) {
    if (!world) return;
    memory *const heap = &world->heap;
    world_end_recording(world);
    world_release_start(world);
    for (size_t i = 0; i < world->model.cloths.count; i++)
        world_destroy_cloth(heap, &world->model.cloths.data[i]);
    for (size_t i = 0; i < world->model.obstacles.count; i++) {
        world_destroy_obstacle(heap, &world->model.obstacles.data[i]);
    }
    ARRAY_FREE(heap, &world->model.cloths);
    ARRAY_FREE(heap, &world->model.obstacles);
    ARRAY_FREE(heap, &world->slots.cloths);
    ARRAY_FREE(heap, &world->slots.obstacles);
    ARRAY_FREE(heap, &world->rules.pair_laws);
    ARRAY_FREE(heap, &world->rules.contact_materials);
    ARRAY_FREE(heap, &world->rules.material_laws);
    world_release_attachments(world);
    ARRAY_FREE(heap, &world->intersections);
    ARRAY_FREE(heap, &world->overlaps);
    memory last = world->heap;
    memory_release(&last, world, sizeof *world);
}

static void name_object(char name[WORLD_NAME_BYTES], const char *given, const char *kind,
                        size_t index) {
    if (given && given[0])
        snprintf(name, WORLD_NAME_BYTES, "%s", given), text_drop_cut_character(name);
    else
        snprintf(name, WORLD_NAME_BYTES, "%s %zu", kind, index);
}

/* Puts the owner's name in front of an error's message. */
static tulle_status own_error(tulle_error *error, const char *owner, tulle_status status) {
    if (error && strncmp(error->message, owner, strlen(owner)) != 0) {
        char message[sizeof error->message];
        snprintf(message, sizeof message, "%s: %.*s", owner,
                 (int)(sizeof message - WORLD_NAME_BYTES - 4), error->message);
        memcpy(error->message, message, sizeof message);
    }
    return status;
}

static tulle_status copy_pins(memory *heap, const tulle_cloth_def *def, world_cloth *cloth) {
    if (def->pin_count == 0) return TULLE_OK;
    cloth->pins = memory_allocate_zeroed(heap, def->pin_count, sizeof *cloth->pins);
    if (!cloth->pins) return TULLE_ERROR_OUT_OF_MEMORY;
    cloth->pin_count = def->pin_count;
    for (size_t i = 0; i < def->pin_count; i++) {
        const tulle_pin *const source = &def->pins[i];
        world_pin *const pin = &cloth->pins[i];
        pin->vertices = copy_array(heap, source->vertices, source->vertex_count, sizeof(uint32_t));
        if (!pin->vertices) return TULLE_ERROR_OUT_OF_MEMORY;
        pin->vertex_count = source->vertex_count;
        pin->release_time = source->release_time;
        if (motion_copy(heap, &source->motion, &pin->motion) != TULLE_OK) {
            return TULLE_ERROR_OUT_OF_MEMORY;
        }
        if (source->motion.key_count > 0) continue;
        pin->targets = memory_allocate(heap, 3 * source->vertex_count * sizeof(double));
        if (!pin->targets) return TULLE_ERROR_OUT_OF_MEMORY;
    }
    return TULLE_OK;
}

static tulle_status copy_cloth(memory *heap, const tulle_cloth_def *def, world_cloth *cloth) {
    size_t const count = def->mesh.vertex_count;
    cloth->material = def->material;
    cloth->thickness = def->thickness;
    cloth->has_flat_rest = def->has_flat_rest != 0;
    memcpy(cloth->grain, def->grain, sizeof cloth->grain);
    if (copy_mesh(heap, def->mesh, &cloth->mesh) != TULLE_OK) return TULLE_ERROR_OUT_OF_MEMORY;
    const double *const rest = def->rest_positions ? def->rest_positions : def->mesh.positions;
    cloth->rest = copy_array(heap, rest, count, 3 * sizeof(double));
    cloth->velocities = memory_allocate(heap, 3 * count * sizeof(double));
    if (def->warps)
        cloth->warps = copy_array(heap, def->warps, def->mesh.triangle_count, 3 * sizeof(double));
    if (def->stiffness_factors)
        cloth->factors = copy_array(heap, def->stiffness_factors, def->mesh.triangle_count,
                                    sizeof *cloth->factors);
    if (def->rest_corners)
        cloth->rest_corners =
            copy_array(heap, def->rest_corners, def->mesh.triangle_count, 9 * sizeof(double));
    cloth->crease_count = def->crease_count;
    if (def->crease_count > 0)
        cloth->creases = copy_array(heap, def->creases, def->crease_count, sizeof *cloth->creases);
    if (def->crease_count > 0 && !cloth->creases) return TULLE_ERROR_OUT_OF_MEMORY;
    if (!cloth->rest || !cloth->velocities || (def->warps && !cloth->warps) ||
        (def->rest_corners && !cloth->rest_corners) || (def->stiffness_factors && !cloth->factors))
        return TULLE_ERROR_OUT_OF_MEMORY;
    for (size_t i = 0; i < 3 * count; i++) {
        cloth->velocities[i] = def->velocities ? def->velocities[i] : def->velocity[i % 3];
    }
    return copy_pins(heap, def, cloth);
}

/* An error where nothing can be added, however good the def is. */
static tulle_status check_adding(const tulle_world *world, tulle_error *error) {
    if (!world) return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "the world is null");
    return world_check_recording(world, error);
}

/* Puts what was made of a def, a cloth or an obstacle, into the world; there is room. `call` is
 * what is recorded. An error leaves it to the caller. */
static tulle_status put_object(tulle_world *world, world_cloth *cloth, world_obstacle *obstacle,
                               recorded_call *call, tulle_error *error) {
    slot_list *const slots = cloth ? &world->slots.cloths : &world->slots.obstacles;
    uint32_t const slot = cloth ? cloth->slot : obstacle->slot;
    size_t const material_count = world->rules.contact_materials.count;
    if (cloth)
        cloth->contact_material =
            world_add_contact_material(world, call->def.cloth.contact_material);
    else
        obstacle->contact_material =
            world_add_contact_material(world, call->def.obstacle.contact_material);
    world_take_slot(slots, slot, cloth ? world->model.cloths.count : world->model.obstacles.count);
    if (!world->is_started) {
        if (cloth)
            world->model.cloths.data[world->model.cloths.count++] = *cloth;
        else
            world->model.obstacles.data[world->model.obstacles.count++] = *obstacle;
        if (world->recording) world_record(world, call);
        return TULLE_OK;
    }
    call->kind = cloth ? RECORD_ADD_CLOTH : RECORD_ADD_OBSTACLE;
    tulle_status status = world_begin_call(world, call, error);
    if (status == TULLE_OK) {
        status = world_add_late(world, cloth, obstacle, error);
        world_end_call(world, status);
    }
    if (status == TULLE_OK) return status;
    world_return_slot(slots, slot);
    world->rules.contact_materials.count = material_count;
    return status;
}

tulle_status tulle_world_add_cloth(tulle_world *world, const tulle_cloth_def *def,
                                   tulle_cloth_id *id, tulle_error *error) {
    tulle_status status = check_adding(world, error);
    if (status != TULLE_OK) return status;
    memory *const heap = &world->heap;
    world_cloth cloth = {.label = {.category = 1, .mask = UINT32_MAX},
                         .slot = world_find_free_slot(&world->slots.cloths)};
    name_object(cloth.name, def ? def->name : NULL, "cloth", cloth.slot);
    status = cloth_def_check(def, world->model.def.membrane, cloth.name, error);
    if (status != TULLE_OK) return own_error(error, cloth.name, status);
    cloth.label.def_hash = fields_hash(&cloth_def_fields, def, NULL, HASH_SEED);
    if (!ARRAY_RESERVE(heap, &world->model.cloths, 1) ||
        !ARRAY_RESERVE(heap, &world->slots.cloths, 1) ||
        !ARRAY_RESERVE(heap, &world->rules.contact_materials, 1) ||
        copy_cloth(heap, def, &cloth) != TULLE_OK) {
        world_destroy_cloth(heap, &cloth);
        return out_of_memory(error, cloth.name);
    }
    recorded_call call = {.kind = RECORD_CLOTH, .def.cloth = *def};
    status = put_object(world, &cloth, NULL, &call, error);
    if (status != TULLE_OK)
        world_destroy_cloth(heap, &cloth);
    else if (id)
        *id = world_get_cloth_id(world, world->model.cloths.count - 1);
    return status;
}

static tulle_status copy_obstacle(memory *heap, const tulle_obstacle_def *def,
                                  world_obstacle *obstacle) {
    obstacle->friction = def->friction;
    obstacle->dynamic_friction = def->dynamic_friction;
    obstacle->restitution = def->restitution;
    obstacle->friction_across = def->friction_across;
    memcpy(obstacle->grain, def->grain, sizeof obstacle->grain);
    obstacle->read_frame = def->read_frame;
    obstacle->frame_context = def->frame_context;
    obstacle->frame_count = def->frame_count;
    obstacle->frame_start_time = def->frame_start_time;
    obstacle->frame_interval = def->frame_interval;
    obstacle->appear_time = def->appear_time;
    obstacle->disappear_time = def->disappear_time;
    obstacle->body = def->body;
    obstacle->drive = def->drive;
    obstacle->is_static = def->motion.key_count == 0 && !def->read_frame && !def->body.is_dynamic &&
                          def->drive == TULLE_DRIVE_NONE;
    /* what is driven as a whole stands still until it is given a pose */
    static tulle_keyframe const still[2] = {{.time = 0.0}};
    tulle_motion motion = def->motion;
    if (def->drive == TULLE_DRIVE_RIGID) {
        motion.keys = still;
        motion.key_count = 2;
        motion.is_eased = 0;
    }
    if (copy_mesh(heap, def->mesh, &obstacle->mesh) != TULLE_OK ||
        motion_copy(heap, &motion, &obstacle->motion) != TULLE_OK) {
        return TULLE_ERROR_OUT_OF_MEMORY;
    }
    size_t const vector_bytes = 3 * def->mesh.vertex_count * sizeof(double);
    if (def->drive != TULLE_DRIVE_NONE) {
        obstacle->given_positions = memory_allocate(heap, vector_bytes);
        if (!obstacle->given_positions) return TULLE_ERROR_OUT_OF_MEMORY;
    }
    if (!def->read_frame) return TULLE_OK;
    obstacle->frames = memory_allocate_zeroed(heap, 1, sizeof *obstacle->frames);
    for (int i = 0; i < 2 && obstacle->frames; i++) {
        obstacle->frames->numbers[i] = TULLE_NONE;
        obstacle->frames->positions[i] = memory_allocate(heap, vector_bytes);
    }
    if (!obstacle->frames || !obstacle->frames->positions[0] || !obstacle->frames->positions[1])
        return TULLE_ERROR_OUT_OF_MEMORY;
    return TULLE_OK;
}

tulle_status tulle_world_add_obstacle(tulle_world *world, const tulle_obstacle_def *def,
                                      tulle_obstacle_id *id, tulle_error *error) {
    tulle_status status = check_adding(world, error);
    if (status != TULLE_OK) return status;
    memory *const heap = &world->heap;
    world_obstacle obstacle = {.label = {.category = 1, .mask = UINT32_MAX},
                               .slot = world_find_free_slot(&world->slots.obstacles)};
    name_object(obstacle.name, def ? def->name : NULL, "obstacle", obstacle.slot);
    status = obstacle_def_check(def, obstacle.name, error);
    if (status != TULLE_OK) return own_error(error, obstacle.name, status);
    obstacle.label.def_hash = fields_hash(&obstacle_def_fields, def, NULL, HASH_SEED);
    if (!ARRAY_RESERVE(heap, &world->model.obstacles, 1) ||
        !ARRAY_RESERVE(heap, &world->slots.obstacles, 1) ||
        !ARRAY_RESERVE(heap, &world->rules.contact_materials, 1) ||
        copy_obstacle(heap, def, &obstacle) != TULLE_OK) {
        world_destroy_obstacle(heap, &obstacle);
        return out_of_memory(error, obstacle.name);
    }
    status = world_make_body(world, &obstacle, error);
    if (status != TULLE_OK) status = own_error(error, obstacle.name, status);
    recorded_call call = {.kind = RECORD_OBSTACLE, .def.obstacle = *def};
    if (status == TULLE_OK) status = put_object(world, NULL, &obstacle, &call, error);
    if (status != TULLE_OK)
        world_destroy_obstacle(heap, &obstacle);
    else if (id)
        *id = world_get_obstacle_id(world, world->model.obstacles.count - 1);
    return status;
}

/* The vectors of one object among those of all vertices; null before the start. */
static const double *object_vectors(const double *vectors, uint32_t vertex_begin) {
    return vectors ? vectors + 3 * (size_t)vertex_begin : NULL;
}

/* A pair filter may ask while objects come and go, when the start has not ended yet. */
static bool has_state(const tulle_world *world) { return world->is_started || world->change; }

static const world_cloth *find_cloth(const tulle_world *world, tulle_cloth_id id,
                                     size_t *vertex_count) {
    size_t const index = world_find_cloth(world, id);
    const world_cloth *const cloth = index != SIZE_MAX ? &world->model.cloths.data[index] : NULL;
    if (vertex_count) *vertex_count = cloth ? cloth->mesh.vertex_count : 0;
    return cloth;
}

const double *tulle_cloth_get_positions(const tulle_world *world, tulle_cloth_id id,
                                        size_t *vertex_count) {
    const world_cloth *const cloth = find_cloth(world, id, vertex_count);
    if (!cloth) return NULL;
    return has_state(world) ? object_vectors(world->now.positions, cloth->vertex_begin)
                            : cloth->mesh.positions;
}

const double *tulle_cloth_get_velocities(const tulle_world *world, tulle_cloth_id id,
                                         size_t *vertex_count) {
    const world_cloth *const cloth = find_cloth(world, id, vertex_count);
    if (!cloth) return NULL;
    return has_state(world) ? object_vectors(world->now.velocities, cloth->vertex_begin)
                            : cloth->velocities;
}

static const world_obstacle *find_obstacle(const tulle_world *world, tulle_obstacle_id id) {
    size_t const index = world_find_obstacle(world, id);
    return index != SIZE_MAX ? &world->model.obstacles.data[index] : NULL;
}

const double *tulle_obstacle_get_positions(const tulle_world *world, tulle_obstacle_id id,
                                           size_t *vertex_count) {
    const world_obstacle *const obstacle = find_obstacle(world, id);
    if (vertex_count) *vertex_count = obstacle ? obstacle->mesh.vertex_count : 0;
    if (!obstacle) return NULL;
    return has_state(world) ? object_vectors(world->now.positions, obstacle->vertex_begin)
                            : obstacle->mesh.positions;
}

int tulle_obstacle_is_present(const tulle_world *world, tulle_obstacle_id id) {
    const world_obstacle *const obstacle = find_obstacle(world, id);
    if (!obstacle) return 0;
    if (!has_state(world)) return obstacle->appear_time <= 0.0;
    return world->now.is_present[obstacle - world->model.obstacles.data];
}

const double *tulle_obstacle_get_velocities(const tulle_world *world, tulle_obstacle_id id,
                                            size_t *vertex_count) {
    const world_obstacle *const obstacle = find_obstacle(world, id);
    if (vertex_count) *vertex_count = obstacle ? obstacle->mesh.vertex_count : 0;
    if (!obstacle || !has_state(world)) return NULL;
    return object_vectors(world->now.velocities, obstacle->vertex_begin);
}

double tulle_world_get_time(const tulle_world *world) { return world ? world->now.time : 0.0; }

uint64_t tulle_world_get_step_count(const tulle_world *world) {
    return world ? world->now.step_count : 0;
}

void tulle_world_get_distances(const tulle_world *world, double *contact, double *separation,
                               double *minimum_gap) {
    if (contact) *contact = world ? world->model.contact_distance : 0.0;
    if (separation) *separation = world ? world->model.separation_distance : 0.0;
    if (minimum_gap) *minimum_gap = world ? world->model.minimum_gap : 0.0;
}

tulle_paper_options tulle_world_get_paper_options(const tulle_world *world) {
    return world ? world->model.paper : tulle_paper_options_default();
}

const char *tulle_world_last_message(const tulle_world *world) {
    return world ? world->message : "";
}

const tulle_intersection *tulle_world_get_intersections(const tulle_world *world, size_t *count) {
    if (count) *count = world ? world->intersections.count : 0;
    return world ? world->intersections.data : NULL;
}

const tulle_overlap *tulle_world_get_overlaps(const tulle_world *world, size_t *count) {
    if (count) *count = world ? world->overlaps.count : 0;
    return world && world->overlaps.count > 0 ? world->overlaps.data : NULL;
}

tulle_untangle_report tulle_world_get_untangle_report(const tulle_world *world) {
    return world ? world->untangle_report : (tulle_untangle_report){0};
}

static const char *const STAGE_NAMES[TULLE_STAGE_COUNT] = {
    "predict_paths",  "update_patches", "build_trees",     "find_pairs",    "gather_rows",
    "compute_forces", "solve_motion",   "resolve_impacts", "commit_safely", "accept_state",
};

const char *tulle_stage_name(int stage) {
    return stage >= 0 && stage < TULLE_STAGE_COUNT ? STAGE_NAMES[stage] : NULL;
}
