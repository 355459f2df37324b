/* world/start/start_arrays.c - the arrays that a world has from its start on, and their release. */
#include "contact/rows/gather_rows.h"
#include "step/bodies/bodies.h"
#include "world/start/start.h"

#include <string.h>

bool world_allocate_start(tulle_world *world) {
    memory *const heap = &world->heap;
    size_t const n = world->model.vertex_count, surface_count = world->model.surface_count;
    world->model.rest = memory_allocate(heap, 3 * n * sizeof(double));
    world->work.targets = memory_allocate_zeroed(heap, 3 * n, sizeof(double));
    world->model.inverse_masses = memory_allocate_zeroed(heap, n, sizeof(double));
    world->work.active_inverse_masses = memory_allocate_zeroed(heap, n, sizeof(double));
    world->work.is_fixed = memory_allocate_zeroed(heap, n, 1);
    world->model.vertex_surface = memory_allocate(heap, n * sizeof(uint32_t));
    world->model.laws =
        memory_allocate_zeroed(heap, surface_count * surface_count, sizeof(contact_law));
    if (world->model.cloth_rest_count > 0) {
        world->work.idle.vertex_count = world->model.cloth_vertex_count;
        world->work.idle.triangle_count =
            world->work.surfaces[world->model.cloth_rest_count - 1].triangle_end;
    }
    world->work.idle.vertices = memory_allocate_zeroed(heap, world->work.idle.vertex_count, 1);
    world->work.idle.triangles = memory_allocate_zeroed(heap, world->work.idle.triangle_count, 1);
    world->model.controls =
        memory_allocate_zeroed(heap, world->model.body_count, sizeof *world->model.controls);
    bool has_all = world->work.idle.vertices && world->work.idle.triangles &&
                   world->model.controls && world->model.rest && world->work.targets &&
                   world->model.inverse_masses && world->work.active_inverse_masses &&
                   world->work.is_fixed && world->model.vertex_surface && world->model.laws;
    bool const has_history = world->model.def.integrator == TULLE_INTEGRATOR_BDF2;
    motion_state *const states[2] = {&world->now, &world->next};
    for (int i = 0; i < 2; i++) {
        motion_state *const state = states[i];
        state->positions = memory_allocate_zeroed(heap, 3 * n, sizeof(double));
        state->velocities = memory_allocate_zeroed(heap, 3 * n, sizeof(double));
        if (has_history) {
            state->previous_mean = memory_allocate_zeroed(heap, 3 * n, sizeof(double));
            state->previous_velocities = memory_allocate_zeroed(heap, 3 * n, sizeof(double));
            has_all = has_all && state->previous_mean && state->previous_velocities;
        }
        state->is_present = memory_allocate_zeroed(heap, world->model.obstacles.count, 1);
        state->particles = memory_allocate_zeroed(heap, world->model.particle_count, 1);
        state->rests = memory_allocate_zeroed(heap, world->model.body_count, sizeof *state->rests);
        state->cloth_rests =
            memory_allocate_zeroed(heap, world->model.cloth_rest_count, sizeof *state->cloth_rests);
        state->drive_forces =
            memory_allocate_zeroed(heap, BODY_AXES * world->model.body_count, sizeof(double));
        state->lags =
            memory_allocate_zeroed(heap, 3 * world->model.lag_vertex_count, sizeof(double));
        state->largest_lags =
            memory_allocate_zeroed(heap, world->model.obstacles.count, sizeof(double));
        state->poses = memory_allocate(heap, world->model.pose_count * sizeof *state->poses);
        for (size_t k = 0; state->poses && k < world->model.pose_count; k++)
            state->poses[k] =
                motion_compute_pose(&world->model.obstacles.data[k].motion, 0.0, NULL);
        has_all = has_all && state->positions && state->velocities && state->is_present &&
                  state->particles && state->rests && state->cloth_rests && state->drive_forces &&
                  state->poses && state->lags && state->largest_lags;
    }
    return has_all;
}

void world_release_first_cloth(tulle_world *world) {
    memory *const heap = &world->heap;
    for (size_t i = 0; i < world->model.cloths.count; i++) {
        world_cloth *const cloth = &world->model.cloths.data[i];
        size_t const vector_bytes = 3 * cloth->mesh.vertex_count * sizeof(double);
        memory_release(heap, cloth->rest, vector_bytes);
        memory_release(heap, cloth->velocities, vector_bytes);
        cloth->rest = cloth->velocities = NULL;
        if (cloth->pin_count > 0) continue;
        memory_release(heap, cloth->mesh.positions, vector_bytes);
        cloth->mesh.positions = NULL;
    }
}

void world_release_start(tulle_world *world) {
    memory *const heap = &world->heap;
    size_t const n = world->model.vertex_count, surface_count = world->model.surface_count;
    world_release_detection(world);
    world_release_events(world);
    cloth_machinery made = {world->model.cloth_model, world->work.system, world->work.aggregates};
    world_release_machinery(world, &made);
    world_release_machinery(world, &world->spare);
    world->work.aggregates = NULL;
    world->work.system = made.system;
    world_release_first_settings(world);
    motion_state *const states[2] = {&world->now, &world->next};
    for (int i = 0; i < 2; i++) {
        motion_state *const state = states[i];
        memory_release(heap, state->positions, 3 * n * sizeof(double));
        memory_release(heap, state->velocities, 3 * n * sizeof(double));
        memory_release(heap, state->previous_mean, 3 * n * sizeof(double));
        memory_release(heap, state->previous_velocities, 3 * n * sizeof(double));
        memory_release(heap, state->plastic, world->model.plastic_count * sizeof(double));
        memory_release(heap, state->is_present, world->model.obstacles.count);
        memory_release(heap, state->particles, world->model.particle_count);
        memory_release(heap, state->rests, world->model.body_count * sizeof *state->rests);
        memory_release(heap, state->cloth_rests,
                       world->model.cloth_rest_count * sizeof *state->cloth_rests);
        memory_release(heap, state->drive_forces,
                       BODY_AXES * world->model.body_count * sizeof(double));
        memory_release(heap, state->poses, world->model.pose_count * sizeof *state->poses);
        memory_release(heap, state->lags, 3 * world->model.lag_vertex_count * sizeof(double));
        memory_release(heap, state->largest_lags, world->model.obstacles.count * sizeof(double));
        ARRAY_FREE(heap, &state->contacts.contacts);
        ARRAY_FREE(heap, &state->ties);
        memset(state, 0, sizeof *state);
    }
    memory_release(heap, world->work.idle.vertices, world->work.idle.vertex_count);
    memory_release(heap, world->work.idle.triangles, world->work.idle.triangle_count);
    memory_release(heap, world->model.surface_bodies,
                   surface_count * sizeof *world->model.surface_bodies);
    memory_release(heap, world->model.controls,
                   world->model.body_count * sizeof *world->model.controls);
    memory_release(heap, world->model.body_obstacles,
                   world->model.body_count * sizeof *world->model.body_obstacles);
    query_trees_destroy(&world->work.queries, heap, world->model.topo.triangle_count);
    world->work.has_queries = false;
    if (world->model.collides)
        memory_release(heap, world->model.collides, surface_count * surface_count);
    memory_release(heap, world->model.rooms, n * sizeof(double));
    memory_release(heap, world->model.automatic, surface_count * sizeof(double));
    topology_destroy(heap, &world->model.topo);
    memory_release(heap, world->work.surfaces, surface_count * sizeof(surface_range));
    memory_release(heap, world->model.rest, 3 * n * sizeof(double));
    memory_release(heap, world->work.targets, 3 * n * sizeof(double));
    memory_release(heap, world->model.inverse_masses, n * sizeof(double));
    memory_release(heap, world->work.active_inverse_masses, n * sizeof(double));
    memory_release(heap, world->work.is_fixed, n);
    memory_release(heap, world->model.vertex_surface, n * sizeof(uint32_t));
    memory_release(heap, world->model.laws, surface_count * surface_count * sizeof(contact_law));
    if (world->model.grains)
        memory_release(heap, world->model.grains, surface_count * sizeof *world->model.grains);
    row_list_destroy(&world->work.rows, heap);
    row_list_destroy(&world->accepted_rows, heap);
    ARRAY_FREE(heap, &world->contacts);
    ARRAY_FREE(heap, &world->work.lag.places);
    ARRAY_FREE(heap, &world->ignored);
    ARRAY_FREE(heap, &world->ignored_start);
    ARRAY_FREE(heap, &world->work.ignored_keys);
    arena_destroy(&world->work.scratch);
    world->model.cloth_model = NULL;
    world->work.surfaces = NULL;
    world->model.collides = NULL;
    world->model.surface_bodies = world->model.body_obstacles = NULL;
    world->model.controls = NULL;
    world->work.idle.vertices = world->work.idle.triangles = NULL;
    world->work.idle.vertex_count = world->work.idle.triangle_count = 0;
    world->model.rest = world->work.targets = world->model.inverse_masses =
        world->work.active_inverse_masses = NULL;
    world->work.is_fixed = NULL;
    world->model.vertex_surface = NULL;
    world->model.laws = NULL;
    world->model.grains = NULL;
    world->model.rooms = world->model.automatic = NULL;
    world->model.vertex_count = world->model.cloth_vertex_count = world->model.particle_count = 0;
    world->model.body_count = world->model.lag_vertex_count = 0;
    world->model.plastic_count = world->model.pose_count = world->model.cloth_rest_count = 0;
    world->model.cloth_edge_count = 0;
    world->model.contact_distance = world->model.separation_distance = 0.0;
    world->is_started = false;
}
