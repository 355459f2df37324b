/* world/start/start_arrays.c - the arrays that a world has from its start on, and their release. */
#include "world/bodies/bodies.h"
#include "world/start/start.h"
#include "world/step/search.h"

#include <string.h>

bool world_allocate_start(tulle_world *world) {
    memory *const heap = &world->heap;
    size_t const n = world->vertex_count, surface_count = world->set.surface_count;
    world->rest = memory_allocate(heap, 3 * n * sizeof(double));
    world->targets = memory_allocate_zeroed(heap, 3 * n, sizeof(double));
    world->inverse_masses = memory_allocate_zeroed(heap, n, sizeof(double));
    world->active_inverse_masses = memory_allocate_zeroed(heap, n, sizeof(double));
    world->is_fixed = memory_allocate_zeroed(heap, n, 1);
    world->vertex_surface = memory_allocate(heap, n * sizeof(uint32_t));
    world->laws = memory_allocate_zeroed(heap, surface_count * surface_count, sizeof(contact_law));
    if (world->cloth_rest_count > 0) {
        world->idle_vertex_count = world->cloth_vertex_count;
        world->idle_triangle_count = world->surfaces[world->cloth_rest_count - 1].triangle_end;
    }
    world->idle_vertices = memory_allocate_zeroed(heap, world->idle_vertex_count, 1);
    world->idle_triangles = memory_allocate_zeroed(heap, world->idle_triangle_count, 1);
    world->controls = memory_allocate_zeroed(heap, world->body_count, sizeof *world->controls);
    bool has_all = world->idle_vertices && world->idle_triangles && world->controls &&
                   world->rest && world->targets && world->inverse_masses &&
                   world->active_inverse_masses && world->is_fixed && world->vertex_surface &&
                   world->laws;
    bool const has_history = world->def.integrator == TULLE_INTEGRATOR_BDF2;
    world_motion_state *const states[2] = {&world->now, &world->next};
    for (int i = 0; i < 2; i++) {
        world_motion_state *const state = states[i];
        state->positions = memory_allocate_zeroed(heap, 3 * n, sizeof(double));
        state->velocities = memory_allocate_zeroed(heap, 3 * n, sizeof(double));
        if (has_history) {
            state->previous_mean = memory_allocate_zeroed(heap, 3 * n, sizeof(double));
            state->previous_velocities = memory_allocate_zeroed(heap, 3 * n, sizeof(double));
            has_all = has_all && state->previous_mean && state->previous_velocities;
        }
        state->is_present = memory_allocate_zeroed(heap, world->obstacles.count, 1);
        state->particles = memory_allocate_zeroed(heap, world->particle_count, 1);
        state->rests = memory_allocate_zeroed(heap, world->body_count, sizeof *state->rests);
        state->cloth_rests =
            memory_allocate_zeroed(heap, world->cloth_rest_count, sizeof *state->cloth_rests);
        state->drive_forces =
            memory_allocate_zeroed(heap, BODY_AXES * world->body_count, sizeof(double));
        state->lags = memory_allocate_zeroed(heap, 3 * world->lag_vertex_count, sizeof(double));
        state->largest_lags = memory_allocate_zeroed(heap, world->obstacles.count, sizeof(double));
        state->poses = memory_allocate(heap, world->pose_count * sizeof *state->poses);
        for (size_t k = 0; state->poses && k < world->pose_count; k++)
            state->poses[k] = motion_compute_pose(&world->obstacles.data[k].motion, 0.0, NULL);
        has_all = has_all && state->positions && state->velocities && state->is_present &&
                  state->particles && state->rests && state->cloth_rests && state->drive_forces &&
                  state->poses && state->lags && state->largest_lags;
    }
    return has_all;
}

void world_release_first_cloth(tulle_world *world) {
    memory *const heap = &world->heap;
    for (size_t i = 0; i < world->cloths.count; i++) {
        world_cloth *const cloth = &world->cloths.data[i];
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
    size_t const n = world->vertex_count, surface_count = world->set.surface_count;
    world_release_detection(world);
    world_release_events(world);
    cloth_machinery made = {world->model, world->system, world->aggregates};
    world_release_machinery(world, &made);
    world_release_machinery(world, &world->spare);
    world->aggregates = NULL;
    world->system = made.system;
    world_release_first_settings(world);
    world_motion_state *const states[2] = {&world->now, &world->next};
    for (int i = 0; i < 2; i++) {
        world_motion_state *const state = states[i];
        memory_release(heap, state->positions, 3 * n * sizeof(double));
        memory_release(heap, state->velocities, 3 * n * sizeof(double));
        memory_release(heap, state->previous_mean, 3 * n * sizeof(double));
        memory_release(heap, state->previous_velocities, 3 * n * sizeof(double));
        memory_release(heap, state->plastic, world->plastic_count * sizeof(double));
        memory_release(heap, state->is_present, world->obstacles.count);
        memory_release(heap, state->particles, world->particle_count);
        memory_release(heap, state->rests, world->body_count * sizeof *state->rests);
        memory_release(heap, state->cloth_rests,
                       world->cloth_rest_count * sizeof *state->cloth_rests);
        memory_release(heap, state->drive_forces, BODY_AXES * world->body_count * sizeof(double));
        memory_release(heap, state->poses, world->pose_count * sizeof *state->poses);
        memory_release(heap, state->lags, 3 * world->lag_vertex_count * sizeof(double));
        memory_release(heap, state->largest_lags, world->obstacles.count * sizeof(double));
        ARRAY_FREE(heap, &state->contacts.contacts);
        ARRAY_FREE(heap, &state->ties);
        memset(state, 0, sizeof *state);
    }
    memory_release(heap, world->idle_vertices, world->idle_vertex_count);
    memory_release(heap, world->idle_triangles, world->idle_triangle_count);
    memory_release(heap, world->surface_bodies, surface_count * sizeof *world->surface_bodies);
    memory_release(heap, world->controls, world->body_count * sizeof *world->controls);
    memory_release(heap, world->body_obstacles, world->body_count * sizeof *world->body_obstacles);
    query_trees_destroy(&world->queries, heap, world->topo.triangle_count);
    world->has_queries = false;
    if (world->collides) memory_release(heap, world->collides, surface_count * surface_count);
    memory_release(heap, world->rooms, n * sizeof(double));
    memory_release(heap, world->automatic, surface_count * sizeof(double));
    topology_destroy(heap, &world->topo);
    memory_release(heap, world->surfaces, surface_count * sizeof(surface_range));
    memory_release(heap, world->rest, 3 * n * sizeof(double));
    memory_release(heap, world->targets, 3 * n * sizeof(double));
    memory_release(heap, world->inverse_masses, n * sizeof(double));
    memory_release(heap, world->active_inverse_masses, n * sizeof(double));
    memory_release(heap, world->is_fixed, n);
    memory_release(heap, world->vertex_surface, n * sizeof(uint32_t));
    memory_release(heap, world->laws, surface_count * surface_count * sizeof(contact_law));
    if (world->grains) memory_release(heap, world->grains, surface_count * sizeof *world->grains);
    row_list_destroy(&world->rows, heap);
    row_list_destroy(&world->accepted_rows, heap);
    ARRAY_FREE(heap, &world->contacts);
    ARRAY_FREE(heap, &world->places);
    ARRAY_FREE(heap, &world->ignored);
    ARRAY_FREE(heap, &world->ignored_start);
    ARRAY_FREE(heap, &world->ignored_keys);
    arena_destroy(&world->scratch);
    world->model = NULL;
    world->surfaces = NULL;
    world->collides = NULL;
    world->surface_bodies = world->body_obstacles = NULL;
    world->controls = NULL;
    world->idle_vertices = world->idle_triangles = NULL;
    world->idle_vertex_count = world->idle_triangle_count = 0;
    world->rest = world->targets = world->inverse_masses = world->active_inverse_masses = NULL;
    world->is_fixed = NULL;
    world->vertex_surface = NULL;
    world->laws = NULL;
    world->grains = NULL;
    world->rooms = world->automatic = NULL;
    world->vertex_count = world->cloth_vertex_count = world->particle_count = 0;
    world->body_count = world->lag_vertex_count = 0;
    world->plastic_count = world->pose_count = world->cloth_rest_count = 0;
    world->cloth_edge_count = 0;
    world->contact_distance = world->separation_distance = 0.0;
    world->is_started = false;
}
