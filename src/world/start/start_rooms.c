/* world/start/start_rooms.c - where the start leaves cloth less room than the contact distance that
 * the start has chosen (start_laws.c). Part of the start.
 *
 * Takes positions at time 0 and the laws. Gives each vertex its room [m], INFINITY where there is
 * enough: of cloth how near it lies to something, of an obstacle its part of the way to another
 * obstacle or, across a slot, to itself (start_slots.c). compute_pair_distances holds contact to
 * it. A place that is narrower than the least contact distance, of cloth or between two obstacles,
 * is told in world->message.
 *
 * Rooms stay as they were found. A change of objects (change.h) keeps those of what stays, and
 * looks for rooms between what is added and all else, as they are then.
 *
 * A world that unravels or ignores what intersects has no rooms: its start says nothing of them. */
#include "base/error.h"
#include "contact/pairs/pair_rules.h"
#include "detect/trees/broad_phase.h"
#include "world/change/change.h"
#include "world/start/start.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* The least contact distance that follows from room, in minimum gaps: a tenth of the contact
 * distance where the minimum gap is a fortieth. */
static const double LEAST_GAPS = 4.0;
/* Of the way between two obstacles, so that cloth in its middle touches neither. */
static const double SHARE_OF_SLOT = 0.4;
/* Cosine to gravity of the way across a slot into which cloth falls. What stands on something
 * leaves none. */
static const double SIDEWAYS = 0.7;
/* Nearer by less than this share is as near: rounding of a start that was made to fit. */
static const double ROUNDING = 1e-6;

/* The narrowest place of cloth, or between obstacles. */
typedef struct narrow_place {
    double distance; /* [m] INFINITY: none */
    uint32_t surfaces[2];
    vec3 position; /* [m] */
} narrow_place;

/* Notes the rooms of vertices of all pairs that are near at the start, or of pairs with what is
 * added. */
static void note_pairs(tulle_world *world, const pair_list *pairs, narrow_place *narrowest,
                       narrow_place *slot) {
    uint32_t const added = world->change ? world->change->added : TULLE_NONE;
    size_t const triangle_pairs = pairs->vertex_triangle.count;
    size_t const count = triangle_pairs + pairs->edge_edge.count;
    double const least = LEAST_GAPS * world->model.minimum_gap;
    vec3 const gravity = vec3_load(world->model.def.gravity, 0);
    for (size_t i = 0; i < count; i++) {
        bool const has_triangle = i < triangle_pairs;
        feature_kind const kind = has_triangle ? FEATURE_VERTEX_TRIANGLE : FEATURE_EDGE_EDGE;
        feature_pair const pair = has_triangle ? pairs->vertex_triangle.data[i]
                                               : pairs->edge_edge.data[i - triangle_pairs];
        uint32_t v[4];
        vec3 points[4];
        feature_pair_vertices(&world->model.topo, kind, pair, v);
        load_points(world->now.positions, v, points);
        closest_points const closest = closest_of_pair(kind, points);
        double const distance = sqrt(closest.distance2);
        if (!(distance > 0.0)) continue; /* the judgement's, not ours */
        vec3 const place = points[0];
        uint32_t const a = world->model.vertex_surface[v[0]], b = world->model.vertex_surface[v[3]];
        if (world->change && a != added && b != added) continue;
        if (a >= world->model.cloths.count && b >= world->model.cloths.count) {
            /* of obstacles the vertex alone, or a large triangle would be narrow far from here */
            double const room = SHARE_OF_SLOT * distance;
            bool const is_body =
                world->model.surface_bodies && (world->model.surface_bodies[a] != TULLE_NONE ||
                                                world->model.surface_bodies[b] != TULLE_NONE);
            if (has_triangle && !is_body && room >= least && room < world->model.contact_distance)
                world->model.rooms[v[0]] = fmin(world->model.rooms[v[0]], room);
            double const fall = fabs(vec3_dot(closest.difference, gravity)) / distance;
            if (a != b && !is_body && room < least && distance < slot->distance &&
                fall <= SIDEWAYS * vec3_norm(gravity))
                *slot = (narrow_place){distance, {a, b}, place};
            continue;
        }
        bool const is_chosen =
            (a >= world->model.cloths.count || world->model.automatic[a] > 0.0) &&
            (b >= world->model.cloths.count || world->model.automatic[b] > 0.0);
        if (!is_chosen) continue;
        double const contact =
            world->model.laws[a * world->model.surface_count + b].contact_distance;
        load_points(world->model.rest, v, points);
        /* own pairs that rest nearer are held to that (pair_rules.c) */
        bool const rests_nearer = a == b && sqrt(closest_of_pair(kind, points).distance2) < contact;
        if (distance < contact * (1.0 - ROUNDING) && !rests_nearer)
            for (int k = 0; k < 4; k++)
                if (v[k] < world->model.cloth_vertex_count)
                    world->model.rooms[v[k]] =
                        fmin(world->model.rooms[v[k]], fmax(distance, least));
        if (a != b && distance < narrowest->distance)
            *narrowest = (narrow_place){distance, {a, b}, place};
    }
}

static void tell_narrow(tulle_world *world, const narrow_place *place, const narrow_place *slot) {
    double const least = LEAST_GAPS * world->model.minimum_gap, mm = 1e3;
    int length = 0;
    if (place->distance < least)
        length = snprintf(
            world->message, sizeof world->message,
            "'%s' lies %.3g mm from '%s' at the start, at (%.4g, %.4g, %.4g) m. Without a "
            "thickness the contact distance is at least %.3g mm here: contact pushes them "
            "apart to that. To keep them as they lie give the cloth a thickness of %.3g mm",
            world_surface_name(&world->model, place->surfaces[0]), mm * place->distance,
            world_surface_name(&world->model, place->surfaces[1]), place->position.x,
            place->position.y, place->position.z, mm * least, mm * place->distance);
    if (slot->distance < (double)INFINITY)
        snprintf(world->message + length, sizeof world->message - (size_t)length,
                 "%s'%s' and '%s' are %.3g mm apart at (%.4g, %.4g, %.4g) m, too near for the "
                 "contact distance that is chosen without a thickness: cloth that is to go between "
                 "them needs a thickness of at most %.3g mm",
                 length > 0 ? ". " : "", world_surface_name(&world->model, slot->surfaces[0]),
                 world_surface_name(&world->model, slot->surfaces[1]), mm * slot->distance,
                 slot->position.x, slot->position.y, slot->position.z,
                 mm * SHARE_OF_SLOT * slot->distance);
}

tulle_status world_find_rooms(tulle_world *world, tulle_error *error) {
    size_t const surface_count = world->model.surface_count, n = world->model.vertex_count;
    bool has_any = false;
    for (size_t i = 0; i < world->model.cloths.count; i++)
        has_any |= !(world->model.cloths.data[i].thickness > 0.0);
    if (!has_any || world->model.def.contact_distance > 0.0 ||
        world->model.def.start_intersections != TULLE_START_REFUSE)
        return TULLE_OK;
    memory *const heap = &world->heap;
    arena_mark const mark = arena_get_mark(&world->work.scratch);
    surface_range *const ranges = ARENA_NEW(&world->work.scratch, surface_range, surface_count);
    world->model.rooms = memory_allocate(heap, n * sizeof(double));
    world->model.automatic = memory_allocate_zeroed(heap, surface_count, sizeof(double));
    if (!ranges || !world->model.rooms || !world->model.automatic) return TULLE_ERROR_OUT_OF_MEMORY;
    for (size_t v = 0; v < n; v++) world->model.rooms[v] = (double)INFINITY;
    for (size_t i = 0; i < world->model.cloths.count; i++)
        if (!(world->model.cloths.data[i].thickness > 0.0))
            world->model.automatic[i] = world->model.laws[i * surface_count + i].contact_distance;
    const world_change *const change = world->change;
    const double *const kept = change ? change->before->model.rooms : NULL;
    for (size_t s = 0; kept && s < surface_count; s++) {
        const surface_range *const range = &world->work.surfaces[s];
        if (change->sources[s] != TULLE_NONE)
            memcpy(world->model.rooms + range->vertex_begin,
                   kept + change->before->work.surfaces[change->sources[s]].vertex_begin,
                   (range->vertex_end - range->vertex_begin) * sizeof(double));
    }
    /* so that obstacles meet one another, too */
    memcpy(ranges, world->work.surfaces, surface_count * sizeof *ranges);
    for (size_t s = 0; s < surface_count; s++) ranges[s].is_body = ranges[s].is_obstacle;
    surface_set set = world->work.set;
    set.surfaces = ranges;
    broad_phase_options const options = {.most_candidates = MOST_CANDIDATES(&world->model)};
    broad_phase *broad = NULL;
    pair_list pairs = {0};
    narrow_place narrowest = {.distance = (double)INFINITY}, slot = narrowest;
    tulle_status status =
        broad_phase_create(heap, &set, world->now.positions, BROAD_PHASE_REFIT, &broad);
    if (status == TULLE_OK) broad_phase_configure(broad, options);
    /* where meshes are too fine for that, cloth alone, as a step searches */
    const surface_set *const sets[2] = {&set, &world->work.set};
    double const reaches[2] = {world->model.contact_distance / SHARE_OF_SLOT,
                               world->model.contact_distance};
    bool const has_new = !change || change->added != TULLE_NONE;
    tulle_status found = has_new ? TULLE_ERROR_LIMIT : TULLE_OK;
    for (int k = 0; k < 2 && status == TULLE_OK && found == TULLE_ERROR_LIMIT; k++) {
        status = build_trees(broad, sets[k], world->now.positions, world->now.positions, reaches[k],
                             world->work.threads);
        if (status == TULLE_OK)
            found = find_pairs(broad, sets[k], world->work.threads, PAIRS_SORTED, &pairs, NULL);
    }
    if (status == TULLE_OK) status = found;
    if (status == TULLE_ERROR_LIMIT)
        (void)error_set(error, status,
                        "the start has over %llu pairs that are nearer than the contact distance, "
                        "%g mm; use coarser meshes, or give the cloth a smaller thickness",
                        (unsigned long long)MOST_CANDIDATES(&world->model),
                        1e3 * world->model.contact_distance);
    if (status == TULLE_OK) note_pairs(world, &pairs, &narrowest, &slot);
    for (size_t s = 0; s < surface_count;
         s++) /* obstacles that are yet to appear have slots, too */
        ranges[s].is_present = ranges[s].is_obstacle && (!change || s == change->added);
    if (status == TULLE_OK)
        status = world_find_slots(world, &set, broad, LEAST_GAPS * world->model.minimum_gap,
                                  SHARE_OF_SLOT);
    broad_phase_destroy(broad);
    ARRAY_FREE(heap, &pairs.vertex_triangle);
    ARRAY_FREE(heap, &pairs.edge_edge);
    arena_release(&world->work.scratch, mark);
    if (status != TULLE_OK) return status;
    tell_narrow(world, &narrowest, &slot);
    bool is_narrow = false;
    for (size_t v = 0; v < n; v++) is_narrow |= world->model.rooms[v] < (double)INFINITY;
    if (is_narrow) return TULLE_OK;
    memory_release(heap, world->model.rooms, n * sizeof(double));
    memory_release(heap, world->model.automatic, surface_count * sizeof(double));
    world->model.rooms = world->model.automatic = NULL;
    return TULLE_OK;
}
