/* world/start/start.c - from separate objects to one numbering: topology, masses, contact laws,
 * distances, trees, and the judgement of the first state. Runs once, before the first step.
 * Arrays are in start_arrays.c, laws and distances in start_laws.c. */
#include "world/start/start.h"

#include "base/error.h"
#include "base/hash.h"
#include "base/parallel.h"
#include "dynamics/hysteresis.h"
#include "geom/union_find.h"
#include "step/bodies/bodies.h"
#include "step/script.h"
#include "world/record/record.h"
#include "world/start/inside.h"

#include <math.h>
#include <string.h>

/* Finds the cloths whose triangles do not all hang together. */
static tulle_status find_pieces(tulle_world *world) {
    arena_mark const mark = arena_get_mark(&world->work.scratch);
    uint32_t *const parents =
        ARENA_NEW(&world->work.scratch, uint32_t, world->model.cloth_vertex_count);
    if (!parents) return TULLE_ERROR_OUT_OF_MEMORY;
    union_find_reset(parents, world->model.cloth_vertex_count);
    for (size_t s = 0; s < world->model.cloths.count; s++) {
        surface_range *const range = &world->work.surfaces[s];
        for (uint32_t e = range->edge_begin; e < range->edge_end; e++)
            union_find_join(parents, world->model.topo.edges[2 * (size_t)e],
                            world->model.topo.edges[2 * (size_t)e + 1]);
        range->is_in_pieces = false;
        for (uint32_t v = range->vertex_begin; v < range->vertex_end; v++)
            range->is_in_pieces |= union_find_root(parents, v) != range->vertex_begin;
    }
    arena_release(&world->work.scratch, mark);
    return TULLE_OK;
}

/* Joins the surfaces, cloths first: ranges of vertices, triangles and edges of each, and the
 * topology of all triangles together. Leaves it to the caller to say that memory is short. */
tulle_status world_join_surfaces(tulle_world *world, tulle_error *error) {
    size_t const surface_count = world->model.cloths.count + world->model.obstacles.count;
    size_t vertex_count = 0, triangle_count = 0;
    world->model.surface_count = surface_count;
    world->work.set = (surface_set){.topo = &world->model.topo, .surface_count = surface_count};
    world->work.surfaces =
        memory_allocate_zeroed(&world->heap, surface_count, sizeof(surface_range));
    world->work.set.surfaces = world->work.surfaces;
    if (!world->work.surfaces || world_number_bodies(world) != TULLE_OK)
        return TULLE_ERROR_OUT_OF_MEMORY;
    world->model.cloth_rest_count =
        world->model.def.sleep_speed > 0.0 ? world->model.cloths.count : 0;
    world->model.has_sleep |= world->model.cloth_rest_count > 0;
    bool may_lag = false;
    for (size_t s = 0; s < surface_count; s++) {
        const world_mesh *const mesh = world_surface_mesh(&world->model, s);
        if (s == world->model.cloths.count)
            vertex_count += 2 * world->model.body_count; /* their slots */
        if (vertex_count + mesh->vertex_count > INT32_MAX ||
            triangle_count + mesh->triangle_count > TOPOLOGY_TRIANGLES_MAX) {
            return error_set(error, TULLE_ERROR_LIMIT,
                             "all meshes together have over %d vertices or %d triangles", INT32_MAX,
                             TOPOLOGY_TRIANGLES_MAX);
        }
        surface_range *const range = &world->work.surfaces[s];
        range->vertex_begin = (uint32_t)vertex_count;
        range->triangle_begin = (uint32_t)triangle_count;
        vertex_count += mesh->vertex_count;
        triangle_count += mesh->triangle_count;
        range->vertex_end = (uint32_t)vertex_count;
        range->triangle_end = (uint32_t)triangle_count;
        range->is_obstacle = s >= world->model.cloths.count;
        range->is_present = true;
        if (!range->is_obstacle) {
            world->model.cloths.data[s].vertex_begin = range->vertex_begin;
            world->model.cloth_vertex_count = vertex_count;
        } else {
            world_obstacle *const obstacle =
                &world->model.obstacles.data[s - world->model.cloths.count];
            obstacle->vertex_begin = range->vertex_begin;
            range->is_static = obstacle->is_static;
            may_lag |= !obstacle->is_static && !obstacle->body.is_dynamic;
            if (obstacle->drive == TULLE_DRIVE_RIGID)
                world->model.pose_count = world->model.obstacles.count;
        }
    }
    world->model.vertex_count = vertex_count;
    if (may_lag && world->model.def.on_pinch != TULLE_ON_PINCH_STOP)
        world->model.lag_vertex_count =
            vertex_count - world->model.cloth_vertex_count - 2 * world->model.body_count;
    world->model.particle_count = contact_responses[world->model.paper.response]->keeps_particles
                                      ? world->model.cloth_vertex_count
                                      : 0;

    arena_mark const mark = arena_get_mark(&world->work.scratch);
    uint32_t *const triangles = ARENA_NEW(&world->work.scratch, uint32_t, 3 * triangle_count);
    if (!triangles) return TULLE_ERROR_OUT_OF_MEMORY;
    for (size_t s = 0; s < surface_count; s++) {
        const world_mesh *const mesh = world_surface_mesh(&world->model, s);
        const surface_range *const range = &world->work.surfaces[s];
        uint32_t *const target = triangles + 3 * (size_t)range->triangle_begin;
        for (size_t i = 0; i < 3 * mesh->triangle_count; i++) {
            target[i] = range->vertex_begin + mesh->triangles[i];
        }
    }
    tulle_status const status = topology_build(&world->heap, triangles, triangle_count,
                                               world->model.vertex_count, &world->model.topo);
    arena_release(&world->work.scratch, mark);
    if (status != TULLE_OK) return status;
    size_t edge = 0;
    for (size_t s = 0; s < surface_count; s++) {
        surface_range *const range = &world->work.surfaces[s];
        range->edge_begin = (uint32_t)edge;
        while (edge < world->model.topo.edge_count &&
               world->model.topo.edges[2 * edge] < range->vertex_end) {
            edge++;
        }
        range->edge_end = (uint32_t)edge;
        if (!range->is_obstacle) world->model.cloth_edge_count = range->edge_end;
    }
    world->model.pin_count = 0;
    for (size_t i = 0; i < world->model.cloths.count; i++)
        world->model.pin_count += world->model.cloths.data[i].pin_count;
    return find_pieces(world);
}

void world_fill_surface(tulle_world *world, size_t surface) {
    const world_mesh *const mesh = world_surface_mesh(&world->model, surface);
    const surface_range *const range = &world->work.surfaces[surface];
    size_t const offset = 3 * (size_t)range->vertex_begin;
    size_t const bytes = 3 * mesh->vertex_count * sizeof(double);
    bool const is_cloth = !range->is_obstacle;
    memcpy(world->now.positions + offset, mesh->positions, bytes);
    memcpy(world->model.rest + offset,
           is_cloth ? world->model.cloths.data[surface].rest : mesh->positions, bytes);
    if (is_cloth)
        memcpy(world->now.velocities + offset, world->model.cloths.data[surface].velocities, bytes);
    for (uint32_t v = range->vertex_begin; v < range->vertex_end; v++)
        world->model.vertex_surface[v] = (uint32_t)surface;
}

/* [bytes] of scratch that a step without contact takes for each vertex of cloth. */
enum { SCRATCH_BYTES = 750 };

/* The cloth's machinery, and room for the plastic parts of its sliders. Leaves it to the caller to
 * say that memory is short. */
tulle_status world_build_model(tulle_world *world, tulle_error *error) {
    cloth_machinery made;
    cloth_settings const settings = {world->first.materials, world->first.releases};
    tulle_status const status = world_build_machinery(world, settings, &made, error);
    if (status != TULLE_OK) return status;
    world_set_machinery(world, &made);
    world->model.plastic_count = hysteresis_count(world->model.cloth_model);
    if (world->model.plastic_count == 0) return TULLE_OK;
    motion_state *const states[2] = {&world->now, &world->next};
    for (int i = 0; i < 2; i++) {
        states[i]->plastic =
            memory_allocate_zeroed(&world->heap, world->model.plastic_count, sizeof(double));
        if (!states[i]->plastic) return TULLE_ERROR_OUT_OF_MEMORY;
    }
    return TULLE_OK;
}

/* Hash of what a saved state must fit: the defs, and the laws and filters of pairs. */
static uint64_t hash_defs(const tulle_world *world) {
    const step_model *const model = &world->model;
    uint64_t hash = world->first.def_hash;
    size_t const pair_count = model->surface_count * model->surface_count;
    size_t const counts[2] = {model->cloths.count, model->obstacles.count};
    hash = hash_bytes(hash, counts, sizeof counts);
    for (size_t i = 0; i < counts[0]; i++)
        hash = hash_bytes(hash, &model->cloths.data[i].label.def_hash, sizeof hash);
    for (size_t i = 0; i < counts[1]; i++)
        hash = hash_bytes(hash, &model->obstacles.data[i].label.def_hash, sizeof hash);
    hash = hash_bytes(hash, model->laws, pair_count * sizeof(contact_law));
    return model->collides ? hash_bytes(hash, model->collides, pair_count) : hash;
}

/* Obstacles at the time of the start and their presence; null: at time 0. Cloth and rigid bodies go
 * where the moment has them. */
static tulle_status place_objects(tulle_world *world, const tulle_moment *moment,
                                  tulle_error *error) {
    double const time = moment ? moment->time : 0.0;
    if (moment) {
        world->now.time = time;
        world->now.step_count = moment->step_count;
        size_t const bytes = 3 * world->model.cloth_vertex_count * sizeof(double);
        memcpy(world->now.positions, moment->positions, bytes);
        memcpy(world->now.velocities, moment->velocities, bytes);
    }
    tulle_status status = step_script_targets(&world->model, &world->work, time, time, error);
    if (status != TULLE_OK) return status;
    size_t const offset = 3 * (world->model.cloth_vertex_count + 2 * world->model.body_count);
    memcpy(world->now.positions + offset, world->work.targets + offset,
           (3 * world->model.vertex_count - offset) * sizeof(double));
    /* saved states leave out what never moves: it is in both states from here on */
    memcpy(world->next.positions + offset, world->work.targets + offset,
           (3 * world->model.vertex_count - offset) * sizeof(double));
    for (size_t i = 0; i < world->model.obstacles.count; i++) {
        const world_obstacle *const obstacle = &world->model.obstacles.data[i];
        bool const has_left = moment && time >= obstacle->disappear_time;
        bool const is_present = obstacle->appear_time <= time && !has_left;
        world->now.is_present[i] = is_present;
        world->work.surfaces[world->model.cloths.count + i].is_present = is_present;
    }
    if (moment) world_place_bodies(world, moment->bodies);
    return TULLE_OK;
}

/* The judgement of the first state, and what is to be done about it. */
static tulle_status judge_start(tulle_world *world, tulle_error *error) {
    tulle_status status =
        world_find_intersections(world, world->now.positions, &world->intersections, error);
    bool const has_any = world->intersections.count > 0;
    if (status != TULLE_OK) return status;
    if (world->model.def.start_intersections == TULLE_START_IGNORE)
        return has_any ? world_ignore_intersections(world, error) : TULLE_OK;
    if (has_any && world->model.def.start_intersections == TULLE_START_REFUSE)
        return world_refuse_intersections(world, world->now.positions, "at the start", error);
    if (has_any) status = world_untangle(world, error);
    inside_question const question = {.when = "at the start"};
    return status == TULLE_OK ? world_refuse_inside(world, world->now.positions, question, error)
                              : status;
}

tulle_status world_finish_start(tulle_world *world) {
    tulle_status const status = world_start_detection(world);
    if (status != TULLE_OK) return status;
    arena_reserve(&world->work.scratch, SCRATCH_BYTES * world->model.cloth_vertex_count);
    world->def_hash = hash_defs(world);
    memcpy(world->first.settings.gravity, world->model.def.gravity,
           sizeof world->model.def.gravity);
    world->first.settings.wind = world->model.def.wind;
    return TULLE_OK;
}

static tulle_status start_stages(tulle_world *world, bool is_judged, const tulle_moment *moment,
                                 tulle_error *error) {
    static const char no_memory[] = "no memory left to start the world";
    tulle_status status = world_join_surfaces(world, error);
    if (status == TULLE_OK && !world_allocate_start(world)) status = TULLE_ERROR_OUT_OF_MEMORY;
    if (status == TULLE_OK && !world_choose_pairs(world)) status = TULLE_ERROR_OUT_OF_MEMORY;
    if (status == TULLE_OK) {
        for (size_t s = 0; s < world->model.surface_count; s++) world_fill_surface(world, s);
        world_place_bodies(world, NULL);
        status = world_build_model(world, error);
    }
    if (status == TULLE_OK) status = world_derive_distances(world, error);
    if (status == TULLE_OK) status = world_set_grains(world);
    if (status == TULLE_ERROR_OUT_OF_MEMORY) return error_set(error, status, no_memory);
    if (status == TULLE_OK) status = place_objects(world, NULL, error);
    if (status != TULLE_OK) return status;
    status = world_find_rooms(world, error);
    if (status == TULLE_ERROR_OUT_OF_MEMORY) return error_set(error, status, no_memory);
    if (status == TULLE_ERROR_LIMIT) return status;
    if (status != TULLE_OK)
        return error_set(error, status, "the meshes have positions that are not finite");
    if (moment) { /* attachments take their places as at any start */
        status = world_begin_attachments(world, error);
        if (status == TULLE_OK) status = place_objects(world, moment, error);
    }
    if (status == TULLE_OK && is_judged) status = judge_start(world, error);
    if (status != TULLE_OK) return status;
    if (world->model.plastic_count > 0)
        status = hysteresis_start(
            world->model.cloth_model,
            (slider_state){world->now.positions, world->work.threads, &world->work.scratch},
            world->now.plastic);
    if (status == TULLE_OK) status = world_finish_start(world);
    if (status == TULLE_ERROR_OUT_OF_MEMORY) return error_set(error, status, no_memory);
    if (status != TULLE_OK)
        return error_set(error, status, "the meshes have positions that are not finite");
    return TULLE_OK;
}

tulle_status tulle_world_start(tulle_world *world, tulle_error *error) {
    if (!world) return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "the world is null");
    recorded_call const call = {.kind = RECORD_START};
    tulle_status status = world_begin_call(world, &call, error);
    if (status != TULLE_OK) return status;
    status = world_start(world, true, NULL, error);
    world_end_call(world, status);
    return status;
}

/* By how much the square of a rotation's length may miss 1. Text keeps 1e-15 of it. */
static const double UNIT_TOLERANCE = 2e-6;

/* What is wrong with a body's place or motion, or null. */
static const char *find_problem(const tulle_transform *body) {
    const double *const q = body->rotation;
    double const length2 = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
    for (int k = 0; k < 3; k++)
        if (!isfinite(body->position[k]) || !isfinite(body->velocity[k]) ||
            !isfinite(body->angular_velocity[k]))
            return "has a rigid body at a place or with a velocity that is not finite";
    return fabs(length2 - 1.0) <= UNIT_TOLERANCE
               ? NULL
               : "has a rotation of a rigid body that is not a unit quaternion";
}

static tulle_status check_moment(const tulle_world *world, const tulle_moment *moment,
                                 tulle_error *error) {
    const char *problem = NULL;
    size_t vertex_count = 0, body_count = 0;
    for (size_t i = 0; i < world->model.cloths.count; i++)
        vertex_count += world->model.cloths.data[i].mesh.vertex_count;
    for (size_t i = 0; i < world->model.obstacles.count; i++)
        body_count += world->model.obstacles.data[i].body.is_dynamic != 0;
    if (vertex_count > 0 && (!moment->positions || !moment->velocities))
        problem = "needs positions and velocities";
    else if (moment->vertex_count != vertex_count)
        problem = "has another number of vertices than the cloth of the world";
    else if (moment->body_count != body_count || (body_count > 0 && !moment->bodies))
        problem = "has another number of rigid bodies than the world";
    else if (!(moment->time >= 0.0) || !isfinite(moment->time))
        problem = "needs a time that is finite and at least 0";
    else if (world->is_started)
        problem = "comes too late: the world has started";
    for (size_t i = 0; !problem && i < 3 * vertex_count; i++)
        if (!isfinite(moment->positions[i]) || !isfinite(moment->velocities[i]))
            problem = "has a position or a velocity that is not finite";
    for (size_t i = 0; !problem && i < body_count; i++) problem = find_problem(&moment->bodies[i]);
    return problem ? error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "the moment %s", problem)
                   : TULLE_OK;
}

/* The recording has what is read of each body behind the velocities of cloth. */
static tulle_status begin_start_at(tulle_world *world, const tulle_moment *moment,
                                   tulle_error *error) {
    if (!world->recording) return TULLE_OK;
    recorded_call call = {.kind = RECORD_START, .numbers = {0, moment->step_count}};
    size_t const count = 3 * moment->vertex_count;
    size_t const joined_count = count + RECORD_BODY_COUNT * moment->body_count;
    double *const joined = memory_allocate_zeroed(&world->heap, joined_count + 1, sizeof *joined);
    if (!joined) return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory for the moment");
    if (count > 0) memcpy(joined, moment->velocities, count * sizeof *joined);
    for (size_t i = 0; i < moment->body_count; i++)
        memcpy(joined + count + RECORD_BODY_COUNT * i, &moment->bodies[i], RECORD_BODY_BYTES);
    memcpy(&call.numbers[0], &moment->time, sizeof call.numbers[0]);
    call.arrays[0] = (recorded_array){moment->positions, count};
    call.arrays[1] = (recorded_array){joined, joined_count};
    tulle_status const status = world_begin_call(world, &call, error);
    memory_release(&world->heap, joined, (joined_count + 1) * sizeof *joined);
    return status;
}

tulle_status tulle_world_start_at(tulle_world *world, const tulle_moment *moment,
                                  tulle_error *error) {
    if (!world || !moment)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "the world or the moment is null");
    tulle_status status = check_moment(world, moment, error);
    if (status == TULLE_OK) status = begin_start_at(world, moment, error);
    if (status != TULLE_OK) return status;
    status = world_start(world, true, moment, error);
    if (status != TULLE_OK) world->now.step_count = 0;
    world_end_call(world, status);
    return status;
}

void tulle_world_set_stop_request(tulle_world *world, tulle_stop_request is_stopped,
                                  void *context) {
    if (!world) return;
    world->work.stop.is_wanted = is_stopped;
    world->work.stop.context = context;
}

tulle_status world_start(tulle_world *world, bool is_judged, const tulle_moment *moment,
                         tulle_error *error) {
    if (!world) return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "the world is null");
    if (world->is_started) return TULLE_OK;
    atomic_store(&world->work.stop.is_stopped, false);
    const tulle_tasks *const before = parallel_use(world->work.tasks);
    tulle_status status = start_stages(world, is_judged, moment, error);
    if (status == TULLE_OK && is_judged && !moment) status = world_begin_attachments(world, error);
    (void)parallel_use(before);
    if (status != TULLE_OK) {
        world_release_start(world);
        return status;
    }
    world->is_started = true;
    if (is_judged) world_release_first_cloth(world); /* else it may have to start again */
    return status;
}
