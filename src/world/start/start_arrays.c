/* world/start/start_arrays.c - the arrays, trees and bodies that a world has from its start
 * on, and their release. */
#include "base/error.h"
#include "contact/pairs/body_paths.h"
#include "contact/rows/gather_rows.h"
#include "detect/impact/time_of_impact.h"
#include "geom/mass_properties.h"
#include "step/bodies/bodies.h"
#include "world/start/start.h"

#include <math.h>
#include <string.h>

/* ---- trees, and the rules of patches ---- */

/* Patches are certified with this much more than half the separation distance, so that no rounding
 * of a distance tells a candidate from one that was left out. */
static const double REACH_RESERVE = 1.0 + 1e-6;

/* Stages 8 and 9 take patches that are certified for their paths with this share of the reach, or
 * more where the minimum gap asks for it. */
static const double HOLD_REACH_SHARE = 0.25;

tulle_status world_start_detection(tulle_world *world) {
    const tulle_world_detection *const def = &world->model.paper.detection;
    bool const is_paper = def->method == TULLE_DETECT_PAPER;
    broad_phase_method const trees = def->method == TULLE_DETECT_BVOX ? BROAD_PHASE_BVOX
                                     : is_paper                       ? BROAD_PHASE_PAPER
                                                                      : BROAD_PHASE_REFIT;
    tulle_status status = broad_phase_create(&world->heap, &world->work.set, world->model.rest,
                                             trees, &world->work.broad);
    if (status != TULLE_OK) return status;
    broad_phase_configure(world->work.broad,
                          (broad_phase_options){.following = PATHS_WHERE_LONG,
                                                .stop = &world->work.stop,
                                                .most_candidates = MOST_CANDIDATES(&world->model),
                                                .scratch = &world->work.scratch});
    if (def->method != TULLE_DETECT_PATCHES && !is_paper) return TULLE_OK;

    /* [m] Inner pairs of patches stay beyond all that gather_rows makes rows of. */
    double const hit = HIT_RESERVE * world->model.contact_distance;
    double const reach = 0.5 * REACH_RESERVE * fmax(world->model.separation_distance, hit);
    world->work.patch_rules =
        (patch_rules){.cone = def->cone == TULLE_CONE_PAPER ? CONE_PAPER : CONE_BERNSTEIN,
                      .max_angle = def->max_angle,
                      .has_certificate = def->has_certificate != 0,
                      .grows_anew = def->grows_patches_anew || is_paper,
                      .reach = reach,
                      .keeps_all = world->work.patch_rules.keeps_all};
    /* Beyond all that stages 8 and 9 call a hit. The minimum gap is at most half of the contact
     * distance, so this is less than the reach. */
    double const gap_reach = 0.5 * REACH_RESERVE * HIT_RESERVE * world->model.minimum_gap;
    world->work.hold_reach = fmin(fmax(HOLD_REACH_SHARE * reach, gap_reach), reach);
    return kept_patches_create(&world->heap, &world->work.set, &world->work.scratch,
                               &world->work.patches);
}

static void release_detection(tulle_world *world) {
    if (world->work.broad) broad_phase_destroy(world->work.broad);
    if (world->work.patches) kept_patches_destroy(world->work.patches);
    world->work.broad = NULL;
    world->work.patches = NULL;
    ARRAY_FREE(&world->heap, &world->work.kept_patch_bytes);
    ARRAY_FREE(&world->heap, &world->work.pairs.vertex_triangle);
    ARRAY_FREE(&world->heap, &world->work.pairs.edge_edge);
}

/* ---- arrays ---- */

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
    release_detection(world);
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

/* ---- rigid bodies ---- */

tulle_status world_make_body(tulle_world *world, world_obstacle *obstacle, tulle_error *error) {
    const tulle_body *const def = &obstacle->body;
    if (!def->is_dynamic) return TULLE_OK;
    if (!contact_responses[world->model.paper.response]->moves_bodies) {
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "%s: the paper's response knows no rigid bodies that answer; use the "
                         "coupled response",
                         obstacle->name);
    }
    tulle_mesh_view const mesh = {obstacle->mesh.positions, obstacle->mesh.vertex_count,
                                  obstacle->mesh.triangles, obstacle->mesh.triangle_count};
    bool const is_shell = def->area_density > 0.0;
    mass_properties unit;
    tulle_status const status =
        mass_properties_compute(&world->heap, mesh, is_shell ? MASS_ON_SURFACE : MASS_IN_VOLUME,
                                obstacle->name, &unit, error);
    if (status != TULLE_OK) return status;
    double density = is_shell ? def->area_density : def->density;
    if (def->mass > 0.0) density = def->mass / unit.measure;
    obstacle->rigid = (rigid_body){.mass = density * unit.measure,
                                   .moments = vec3_scale(unit.moments, density),
                                   .linear_damping = def->linear_damping,
                                   .angular_damping = def->angular_damping};
    obstacle->centre = unit.centre;
    obstacle->axes = unit.axes;
    vec3 const moments = obstacle->rigid.moments;
    double const least = fmin(moments.x, fmin(moments.y, moments.z));
    if (!isfinite(obstacle->rigid.mass) || !(obstacle->rigid.mass > 0.0) || !(least > 0.0) ||
        !isfinite(moments.x + moments.y + moments.z)) {
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "%s: a mass of %g kg and a moment of inertia of %g kg m^2 cannot be "
                         "computed with; check the mass or density and the mesh's unit",
                         obstacle->name, obstacle->rigid.mass, least);
    }
    size_t const count = obstacle->mesh.vertex_count;
    obstacle->points = memory_allocate(&world->heap, 3 * count * sizeof(double));
    if (!obstacle->points) {
        return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory left for %s", obstacle->name);
    }
    obstacle->radius = 0.0;
    for (size_t i = 0; i < count; i++) {
        vec3 const arm = vec3_sub(vec3_load(mesh.positions, i), unit.centre);
        vec3_store(obstacle->points, i, quaternion_rotate(quaternion_conjugate(unit.axes), arm));
        obstacle->radius = fmax(obstacle->radius, vec3_norm(arm));
    }
    return TULLE_OK;
}

tulle_status world_number_bodies(tulle_world *world) {
    size_t const cloth_count = world->model.cloths.count,
                 surface_count = world->model.surface_count;
    world->model.body_count = 0;
    world->model.has_sleep = false;
    for (size_t i = 0; i < world->model.obstacles.count; i++)
        world->model.body_count += world->model.obstacles.data[i].body.is_dynamic != 0;
    if (world->model.body_count == 0) return TULLE_OK;
    world->model.surface_bodies = memory_allocate(&world->heap, surface_count * sizeof(uint32_t));
    world->model.body_obstacles = memory_allocate(
        &world->heap, world->model.body_count * sizeof *world->model.body_obstacles);
    if (!world->model.surface_bodies || !world->model.body_obstacles)
        return TULLE_ERROR_OUT_OF_MEMORY;
    uint32_t number = 0;
    for (size_t s = 0; s < surface_count; s++) {
        bool const is_body =
            s >= cloth_count && world->model.obstacles.data[s - cloth_count].body.is_dynamic;
        world->model.surface_bodies[s] = is_body ? number : TULLE_NONE;
        if (is_body) world->model.body_obstacles[number++] = (uint32_t)(s - cloth_count);
    }
    for (size_t b = 0; b < world->model.body_count; b++)
        world->model.has_sleep |= get_body(&world->model, b)->body.sleep_speed > 0.0;
    return TULLE_OK;
}

void world_place_bodies(tulle_world *world, const tulle_transform *transforms) {
    motion_state *const state = &world->now;
    (void)step_free_bodies(&world->model, state);
    step_mark_bodies(&world->model, state, &world->work);
    for (size_t b = 0; b < world->model.body_count; b++) {
        const world_obstacle *const obstacle = get_body(&world->model, b);
        size_t const slot = get_first_slot(&world->model, b);
        vec3 velocity = vec3_load(obstacle->body.velocity, 0);
        vec3 spin = vec3_load(obstacle->body.angular_velocity, 0);
        vec3 centre;
        quaternion orientation;
        step_compute_script_pose(obstacle, state->time, &centre, &orientation);
        if (transforms && body_answers(&world->model, &world->work, b)) {
            const double *const q = transforms[b].rotation;
            centre = vec3_load(transforms[b].position, 0);
            orientation = quaternion_normalize(
                quaternion_multiply((quaternion){q[0], q[1], q[2], q[3]}, obstacle->axes));
            velocity = vec3_load(transforms[b].velocity, 0);
            spin = vec3_load(transforms[b].angular_velocity, 0);
            for (size_t i = 0; i < obstacle->mesh.vertex_count; i++) {
                vec3 const arm = quaternion_rotate(orientation, vec3_load(obstacle->points, i));
                vec3_store(state->positions, obstacle->vertex_begin + i, vec3_add(centre, arm));
            }
        }
        vec3_store(state->positions, slot, centre);
        vec3_store(state->positions, slot + 1, pack_orientation(orientation));
        vec3_store(state->velocities, slot, velocity);
        vec3_store(state->velocities, slot + 1, spin);
        for (size_t k = slot; k < slot + 2; k++) {
            vec3_store(world->model.rest, k, obstacle->centre);
            world->model.vertex_surface[k] =
                (uint32_t)(world->model.cloths.count + world->model.body_obstacles[b]);
        }
    }
}
