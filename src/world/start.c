/* world/start.c - from separate objects to one numbering: topology, masses, contact laws,
 * distances, trees, and the judgement of the first state. Runs once, before the first step. */
#include "base/error.h"
#include "base/hash.h"
#include "world/detection.h"
#include "world/inside.h"
#include "world/untangle.h"

#include "contact/gather_contacts.h"

#include <math.h>
#include <string.h>

/* Contact distance of a cloth without a thickness: this share of its mean edge ... */
static const double CONTACT_EDGE_SHARE = 0.2;
/* ... but not more than this [m]; thicker looks like felt. */
static const double CONTACT_DISTANCE_MAX = 5e-3;
/* Release distance over contact distance. */
static const double SEPARATION_FACTOR = 1.5;
/* Minimum gap: this share of the smallest contact distance. */
static const double MINIMUM_GAP_SHARE = 1.0 / 40.0;
/* The minimum gap survives rounding to float in files: this many float ulps of the scene's extent.
 */
static const double MINIMUM_GAP_ULPS = 4.0;
/* Largest share of a contact distance that the minimum gap may take. */
static const double MINIMUM_GAP_LARGEST_SHARE = 0.5;

static tulle_status no_memory(tulle_error *error) {
    return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory left to start the world");
}

static const world_mesh *object_mesh(const tulle_world *world, size_t surface) {
    size_t const cloth_count = world->cloths.count;
    return surface < cloth_count ? &world->cloths.data[surface].mesh
                                 : &world->obstacles.data[surface - cloth_count].mesh;
}

/* Ranges of vertices and triangles of every surface, cloths first. */
static tulle_status number_surfaces(tulle_world *world, size_t *triangle_count,
                                    tulle_error *error) {
    size_t const surface_count = world_surface_count(world);
    size_t vertex_count = 0;
    *triangle_count = 0;
    world->surfaces = memory_allocate_zeroed(&world->heap, surface_count, sizeof(surface_range));
    if (!world->surfaces) return no_memory(error);
    for (size_t s = 0; s < surface_count; s++) {
        world_mesh const *const mesh = object_mesh(world, s);
        if (vertex_count + mesh->vertex_count > INT32_MAX ||
            *triangle_count + mesh->triangle_count > INT32_MAX) {
            return error_set(error, TULLE_ERROR_LIMIT,
                             "all meshes together have over 2^31 - 1 vertices or triangles");
        }
        surface_range *const range = &world->surfaces[s];
        range->vertex_begin = (uint32_t)vertex_count;
        range->triangle_begin = (uint32_t)*triangle_count;
        vertex_count += mesh->vertex_count;
        *triangle_count += mesh->triangle_count;
        range->vertex_end = (uint32_t)vertex_count;
        range->triangle_end = (uint32_t)*triangle_count;
        range->is_obstacle = s >= world->cloths.count;
        range->is_present = true;
        if (!range->is_obstacle) {
            world->cloths.data[s].vertex_begin = range->vertex_begin;
            world->cloth_vertex_count = vertex_count;
        } else {
            world_obstacle *const obstacle = &world->obstacles.data[s - world->cloths.count];
            obstacle->vertex_begin = range->vertex_begin;
            range->is_static = obstacle->motion.key_count == 0 && !obstacle->read_frame;
        }
    }
    world->vertex_count = vertex_count;
    return TULLE_OK;
}

/* Topology of all triangles together, and each surface's range of edges. */
static tulle_status build_topology(tulle_world *world, size_t triangle_count, tulle_error *error) {
    arena_mark const mark = arena_get_mark(&world->scratch);
    uint32_t *const triangles = ARENA_NEW(&world->scratch, uint32_t, 3 * triangle_count);
    if (!triangles) return no_memory(error);
    for (size_t s = 0; s < world_surface_count(world); s++) {
        world_mesh const *const mesh = object_mesh(world, s);
        surface_range const *const range = &world->surfaces[s];
        uint32_t *const target = triangles + 3 * (size_t)range->triangle_begin;
        for (size_t i = 0; i < 3 * mesh->triangle_count; i++) {
            target[i] = range->vertex_begin + mesh->triangles[i];
        }
    }
    tulle_status const status =
        topology_build(&world->heap, triangles, triangle_count, world->vertex_count, &world->topo);
    arena_release(&world->scratch, mark);
    if (status != TULLE_OK) return no_memory(error);
    size_t edge = 0;
    for (size_t s = 0; s < world_surface_count(world); s++) {
        surface_range *const range = &world->surfaces[s];
        range->edge_begin = (uint32_t)edge;
        while (edge < world->topo.edge_count && world->topo.edges[2 * edge] < range->vertex_end) {
            edge++;
        }
        range->edge_end = (uint32_t)edge;
    }
    world->set = (surface_set){.topo = &world->topo,
                               .surfaces = world->surfaces,
                               .surface_count = world_surface_count(world)};
    return TULLE_OK;
}

/* Arrays of one motion state. */
static bool allocate_state(tulle_world *world, world_motion_state *state) {
    memory *const heap = &world->heap;
    size_t const n = 3 * world->vertex_count, obstacle_count = world->obstacles.count;
    state->positions = memory_allocate_zeroed(heap, n, sizeof(double));
    state->velocities = memory_allocate_zeroed(heap, n, sizeof(double));
    state->previous_mean = memory_allocate_zeroed(heap, n, sizeof(double));
    state->previous_velocities = memory_allocate_zeroed(heap, n, sizeof(double));
    state->is_released = memory_allocate_zeroed(heap, obstacle_count, 1);
    state->is_present = memory_allocate_zeroed(heap, obstacle_count, 1);
    state->particles = memory_allocate_zeroed(heap, world_particle_count(world), 1);
    return state->positions && state->velocities && state->previous_mean && state->particles &&
           state->previous_velocities && state->is_released && state->is_present;
}

static void release_state(tulle_world *world, world_motion_state *state) {
    memory *const heap = &world->heap;
    size_t const vector_bytes = 3 * world->vertex_count * sizeof(double);
    memory_release(heap, state->positions, vector_bytes);
    memory_release(heap, state->velocities, vector_bytes);
    memory_release(heap, state->previous_mean, vector_bytes);
    memory_release(heap, state->previous_velocities, vector_bytes);
    memory_release(heap, state->is_released, world->obstacles.count);
    memory_release(heap, state->is_present, world->obstacles.count);
    memory_release(heap, state->particles, world_particle_count(world));
    contact_store_destroy(&state->contacts, heap);
    memset(state, 0, sizeof *state);
}

static bool allocate_arrays(tulle_world *world) {
    memory *const heap = &world->heap;
    size_t const n = world->vertex_count, surface_count = world_surface_count(world);
    world->rest = memory_allocate(heap, 3 * n * sizeof(double));
    world->targets = memory_allocate_zeroed(heap, 3 * n, sizeof(double));
    world->inverse_masses = memory_allocate_zeroed(heap, n, sizeof(double));
    world->active_inverse_masses = memory_allocate_zeroed(heap, n, sizeof(double));
    world->is_fixed = memory_allocate_zeroed(heap, n, 1);
    world->vertex_surface = memory_allocate(heap, n * sizeof(uint32_t));
    world->laws = memory_allocate_zeroed(heap, surface_count * surface_count, sizeof(contact_law));
    return world->rest && world->targets && world->inverse_masses && world->active_inverse_masses &&
           world->is_fixed && world->vertex_surface && world->laws &&
           allocate_state(world, &world->now) && allocate_state(world, &world->next);
}

/* First positions and velocities, rest shapes, surface of each vertex. */
static void fill_arrays(tulle_world *world) {
    for (size_t s = 0; s < world_surface_count(world); s++) {
        world_mesh const *const mesh = object_mesh(world, s);
        surface_range const *const range = &world->surfaces[s];
        size_t const offset = 3 * (size_t)range->vertex_begin;
        size_t const bytes = 3 * mesh->vertex_count * sizeof(double);
        bool const is_cloth = !range->is_obstacle;
        memcpy(world->now.positions + offset, mesh->positions, bytes);
        memcpy(world->rest + offset, is_cloth ? world->cloths.data[s].rest : mesh->positions,
               bytes);
        if (is_cloth) {
            memcpy(world->now.velocities + offset, world->cloths.data[s].velocities, bytes);
        }
        for (uint32_t v = range->vertex_begin; v < range->vertex_end; v++) {
            world->vertex_surface[v] = (uint32_t)s;
        }
    }
}

/* Cloth of fewer vertices is solved as fast without a factor (31 x 31 faster, 61 x 61 slower). */
enum { FACTORED_VERTICES = 2000 };

/* Forces and masses of all cloth together. */
static tulle_status build_model(tulle_world *world, tulle_error *error) {
    arena_mark const mark = arena_get_mark(&world->scratch);
    size_t const cloth_count = world->cloths.count;
    tulle_material *const materials = ARENA_NEW(&world->scratch, tulle_material, cloth_count);
    if (!materials) return no_memory(error);
    for (size_t i = 0; i < cloth_count; i++) materials[i] = world->cloths.data[i].material;
    cloth_model_def const def = {.vertex_count = world->cloth_vertex_count,
                                 .surface = &world->topo,
                                 .rest_positions = world->rest,
                                 .materials = materials,
                                 .material_count = cloth_count,
                                 .vertex_materials = world->vertex_surface};
    world->model = memory_allocate_zeroed(&world->heap, 1, sizeof *world->model);
    if (!world->model) return no_memory(error);
    tulle_status status = cloth_model_build(&world->heap, &def, world->model, error);
    arena_release(&world->scratch, mark);
    if (status != TULLE_OK) {
        memory_release(&world->heap, world->model, sizeof *world->model);
        world->model = NULL;
        return status;
    }
    if (linear_system_build(&world->heap, world->model, &world->system) != TULLE_OK) {
        return no_memory(error);
    }
    if (world->cloth_vertex_count >= FACTORED_VERTICES) {
        block_pattern const pattern = {world->model->block_begin, world->model->block_columns};
        world->factor =
            sparse_cholesky_build(&world->heap, world->cloth_vertex_count, pattern, world->rest);
        if (!world->factor) return no_memory(error);
    }
    for (size_t v = 0; v < world->cloth_vertex_count; v++) {
        world->inverse_masses[v] = 1.0 / world->model->masses[v];
    }
    return TULLE_OK;
}

/* Mean rest edge length of a range of edges [m]. */
static double mean_edge_length(const tulle_world *world, uint32_t edge_begin, uint32_t edge_end) {
    double sum = 0.0;
    for (uint32_t e = edge_begin; e < edge_end; e++) {
        vec3 const a = vec3_load(world->rest, world->topo.edges[2 * (size_t)e]);
        vec3 const b = vec3_load(world->rest, world->topo.edges[2 * (size_t)e + 1]);
        sum += vec3_norm(vec3_sub(a, b));
    }
    return edge_end > edge_begin ? sum / (double)(edge_end - edge_begin) : 0.0;
}

/* Contact distance of one cloth against itself and obstacles [m]. */
static double cloth_contact_distance(const tulle_world *world, size_t cloth) {
    if (world->cloths.data[cloth].thickness > 0.0) return world->cloths.data[cloth].thickness;
    if (world->def.contact_distance > 0.0) return world->def.contact_distance;
    surface_range const *const range = &world->surfaces[cloth];
    return fmin(CONTACT_DISTANCE_MAX,
                CONTACT_EDGE_SHARE * mean_edge_length(world, range->edge_begin, range->edge_end));
}

/* What a surface brings to a contact; dynamic friction is not negative. */
typedef struct surface_roughness {
    double friction, dynamic_friction, restitution;
} surface_roughness;

static surface_roughness get_roughness(const tulle_world *world, size_t surface) {
    size_t const cloth_count = world->cloths.count;
    surface_roughness roughness;
    if (surface < cloth_count) {
        tulle_material const *const m = &world->cloths.data[surface].material;
        roughness = (surface_roughness){m->friction, m->dynamic_friction, m->restitution};
    } else {
        world_obstacle const *const o = &world->obstacles.data[surface - cloth_count];
        roughness = (surface_roughness){o->friction, o->dynamic_friction, o->restitution};
    }
    if (roughness.dynamic_friction < 0.0) roughness.dynamic_friction = roughness.friction;
    return roughness;
}

/* Coefficients of a pair: what was set for it; else geometric means, but that friction between
 * cloths is the world's. */
static void set_coefficients(const tulle_world *world, size_t a, size_t b, contact_law *law) {
    tulle_contact_law const *const given = world_find_pair_law(world, a, b);
    if (given) {
        bool const has_dynamic = given->dynamic_friction >= 0.0;
        law->static_friction = given->static_friction;
        law->dynamic_friction = has_dynamic ? given->dynamic_friction : given->static_friction;
        law->restitution = given->restitution;
        return;
    }
    surface_roughness const first = get_roughness(world, a), second = get_roughness(world, b);
    law->restitution = sqrt(first.restitution * second.restitution);
    law->static_friction = sqrt(first.friction * second.friction);
    law->dynamic_friction = sqrt(first.dynamic_friction * second.dynamic_friction);
    if (a >= world->cloths.count || b >= world->cloths.count) return;
    double const dynamic = world->def.dynamic_friction_cloth_cloth;
    law->static_friction = world->def.friction_cloth_cloth;
    law->dynamic_friction = dynamic < 0.0 ? law->static_friction : dynamic;
}

static contact_law make_law(const tulle_world *world, size_t a, size_t b) {
    size_t const cloth_count = world->cloths.count;
    bool const has_cloth_a = a < cloth_count, has_cloth_b = b < cloth_count;
    contact_law law = {0};
    if (has_cloth_a && has_cloth_b) {
        law.contact_distance =
            0.5 * (cloth_contact_distance(world, a) + cloth_contact_distance(world, b));
    } else if (has_cloth_a || has_cloth_b) {
        law.contact_distance = cloth_contact_distance(world, has_cloth_a ? a : b);
    }
    if (has_cloth_a || has_cloth_b) set_coefficients(world, a, b, &law);
    law.separation_distance =
        fmax(world->def.separation_distance, SEPARATION_FACTOR * law.contact_distance);
    if (world->def.separation_distance > 0.0) {
        law.separation_distance = fmax(world->def.separation_distance, law.contact_distance);
    }
    return law;
}

static double largest_coordinate(const tulle_world *world) {
    double largest = 0.0;
    for (size_t i = 0; i < 3 * world->vertex_count; i++) {
        largest = fmax(largest, fabs(world->now.positions[i]));
    }
    return largest;
}

/* Contact laws of all pairs of surfaces and the distances that the world reports. */
static tulle_status derive_distances(tulle_world *world, tulle_error *error) {
    size_t const surface_count = world_surface_count(world), cloth_count = world->cloths.count;
    double smallest_contact = (double)INFINITY;
    for (size_t a = 0; a < surface_count; a++) {
        for (size_t b = 0; b < surface_count; b++) {
            contact_law const law = make_law(world, a, b);
            world->laws[a * surface_count + b] = law;
            if (a >= cloth_count && b >= cloth_count) continue;
            world->contact_distance = fmax(world->contact_distance, law.contact_distance);
            world->separation_distance = fmax(world->separation_distance, law.separation_distance);
            smallest_contact = fmin(smallest_contact, law.contact_distance);
        }
    }
    double const float_floor = MINIMUM_GAP_ULPS * 0x1p-23 * largest_coordinate(world);
    world->minimum_gap = world->def.minimum_gap > 0.0
                             ? world->def.minimum_gap
                             : fmax(MINIMUM_GAP_SHARE * smallest_contact, float_floor);
    if (world->minimum_gap > MINIMUM_GAP_LARGEST_SHARE * smallest_contact) {
        return error_set(
            error, TULLE_ERROR_INVALID_ARGUMENT,
            "the minimum gap of %g m is over half of the contact distance of %g m; the "
            "scene reaches %g m from the origin: move it nearer, use thicker cloth, or "
            "give the minimum gap (xi) yourself",
            world->minimum_gap, smallest_contact, largest_coordinate(world));
    }
    world->edge_length = mean_edge_length(world, 0, world->surfaces[cloth_count - 1].edge_end);
    return TULLE_OK;
}

/* Grain of the cloths, if one of them has friction that depends on the direction. */
static tulle_status set_grains(tulle_world *world, tulle_error *error) {
    bool has_grain = false;
    for (size_t i = 0; i < world->cloths.count; i++)
        has_grain |= world->cloths.data[i].material.friction_across != 1.0;
    if (!has_grain) return TULLE_OK;
    size_t const count = world_surface_count(world);
    world->grains = memory_allocate_zeroed(&world->heap, count, sizeof *world->grains);
    if (!world->grains) return no_memory(error);
    for (size_t s = 0; s < count; s++) {
        world->grains[s].across = 1.0;
        if (s >= world->cloths.count) continue;
        world->grains[s].across = world->cloths.data[s].material.friction_across;
        world->grains[s].direction = vec3_load(world->cloths.data[s].grain, 0);
    }
    return TULLE_OK;
}

/* Hash of what a saved state must fit: meshes, rest shapes, masses, time scripts. */
static uint64_t hash_defs(const tulle_world *world) {
    uint64_t hash = HASH_SEED;
    size_t const vector_bytes = 3 * world->vertex_count * sizeof(double);
    hash = hash_bytes(hash, &world->cloths.count, sizeof world->cloths.count);
    hash = hash_bytes(hash, &world->obstacles.count, sizeof world->obstacles.count);
    hash = hash_bytes(hash, world->rest, vector_bytes);
    hash =
        hash_bytes(hash, world->topo.triangles, 3 * world->topo.triangle_count * sizeof(uint32_t));
    hash = hash_bytes(hash, world->inverse_masses, world->vertex_count * sizeof(double));
    hash = hash_bytes(hash, world->laws,
                      world->set.surface_count * world->set.surface_count * sizeof(contact_law));
    if (world->grains)
        hash = hash_bytes(hash, world->grains, world->set.surface_count * sizeof *world->grains);
    hash = hash_bytes(hash, world->def.gravity, sizeof world->def.gravity);
    hash = hash_bytes(hash, &world->minimum_gap, sizeof world->minimum_gap);
    int const choices[2] = {(int)world->def.response, (int)world->def.motion_space};
    hash = hash_bytes(hash, choices, sizeof choices);
    for (size_t i = 0; i < world->obstacles.count; i++) {
        world_obstacle const *const o = &world->obstacles.data[i];
        hash = hash_bytes(hash, o->motion.keys, o->motion.key_count * sizeof *o->motion.keys);
        hash = hash_bytes(hash, &o->appear_time, sizeof o->appear_time);
        hash = hash_bytes(hash, &o->disappear_time, sizeof o->disappear_time);
    }
    return hash;
}

/* Obstacles at time 0 and their presence. */
static tulle_status place_obstacles(tulle_world *world, tulle_error *error) {
    tulle_status status = world_script_targets(world, 0.0, 0.0, error);
    if (status != TULLE_OK) return status;
    size_t const offset = 3 * world->cloth_vertex_count;
    memcpy(world->now.positions + offset, world->targets + offset,
           (3 * world->vertex_count - offset) * sizeof(double));
    for (size_t i = 0; i < world->obstacles.count; i++) {
        bool const is_present = world->obstacles.data[i].appear_time <= 0.0;
        world->now.is_present[i] = is_present;
        world->surfaces[world->cloths.count + i].is_present = is_present;
    }
    return TULLE_OK;
}

/* The judgement of the first state, and what is to be done about it. */
static tulle_status judge_start(tulle_world *world, tulle_error *error) {
    tulle_status status =
        world_find_intersections(world, world->now.positions, &world->intersections, error);
    bool const has_any = world->intersections.count > 0;
    if (status != TULLE_OK) return status;
    if (world->def.start_intersections == TULLE_START_IGNORE)
        return has_any ? world_ignore_intersections(world, error) : TULLE_OK;
    if (has_any && world->def.start_intersections == TULLE_START_REFUSE)
        return world_refuse_intersections(world, world->now.positions, "at the start", error);
    if (has_any) status = world_untangle(world, error);
    return status == TULLE_OK ? world_refuse_cloth_inside(world, world->now.positions, error)
                              : status;
}

static tulle_status start_stages(tulle_world *world, bool is_judged, tulle_error *error) {
    size_t triangle_count;
    tulle_status status = number_surfaces(world, &triangle_count, error);
    if (status == TULLE_OK) status = build_topology(world, triangle_count, error);
    if (status == TULLE_OK && !allocate_arrays(world)) status = no_memory(error);
    if (status != TULLE_OK) return status;
    fill_arrays(world);
    status = build_model(world, error);
    if (status == TULLE_OK) status = derive_distances(world, error);
    if (status == TULLE_OK) status = set_grains(world, error);
    if (status != TULLE_OK) return status;
    status = place_obstacles(world, error);
    if (status == TULLE_OK && is_judged) status = judge_start(world, error);
    if (status != TULLE_OK) return status;
    if (world_start_detection(world) != TULLE_OK) return no_memory(error);
    world->def_hash = hash_defs(world);
    return TULLE_OK;
}

tulle_status tulle_world_start(tulle_world *world, tulle_error *error) {
    return world_start(world, true, error);
}

tulle_status world_start(tulle_world *world, bool is_judged, tulle_error *error) {
    if (!world) return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "the world is null");
    if (world->is_started) return TULLE_OK;
    if (world->cloths.count == 0) {
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "the world has no cloth; add one before it starts");
    }
    tulle_status const status = start_stages(world, is_judged, error);
    if (status == TULLE_OK)
        world->is_started = true;
    else
        world_release_start(world);
    return status;
}

void world_release_start(tulle_world *world) {
    memory *const heap = &world->heap;
    size_t const n = world->vertex_count, surface_count = world_surface_count(world);
    world_release_detection(world);
    linear_system_destroy(heap, &world->system);
    sparse_cholesky_destroy(heap, world->factor);
    world->factor = NULL;
    if (world->model) {
        cloth_model_destroy(heap, world->model);
        memory_release(heap, world->model, sizeof *world->model);
    }
    release_state(world, &world->now);
    release_state(world, &world->next);
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
    ARRAY_FREE(heap, &world->ignored);
    ARRAY_FREE(heap, &world->ignored_start);
    ARRAY_FREE(heap, &world->ignored_keys);
    arena_destroy(&world->scratch);
    world->model = NULL;
    world->surfaces = NULL;
    world->rest = world->targets = world->inverse_masses = world->active_inverse_masses = NULL;
    world->is_fixed = NULL;
    world->vertex_surface = NULL;
    world->laws = NULL;
    world->grains = NULL;
    world->vertex_count = world->cloth_vertex_count = 0;
    world->contact_distance = world->separation_distance = 0.0;
    world->is_started = false;
}
