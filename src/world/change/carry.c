/* world/change/carry.c - what stays when objects come and go (change.h): each number of a vertex,
 * triangle, edge, obstacle or body becomes the one that the same thing has now. */
#include "world/change/change.h"

#include "base/error.h"
#include "contact/rows/contact_store.h"
#include "dynamics/hysteresis.h"
#include "step/bodies/bodies.h"
#include "step/bodies/bodies_sleep.h"
#include "step/sleep/cloth_sleep.h"

#include <math.h>
#include <string.h>

/* What is new in it is carried over below, too. */
#if UINTPTR_MAX == UINT64_MAX
_Static_assert(sizeof(motion_state) == 888, "carry over all of motion_state");
#endif

/* ---- numbers ---- */

/* The vertex that was `vertex` before, or TULLE_NONE: it has gone, or never was. */
static uint32_t map_vertex(const tulle_world *world, uint32_t vertex) {
    const tulle_world *const before = world->change->before;
    if (vertex >= before->model.vertex_count) return TULLE_NONE;
    uint32_t const source = before->model.vertex_surface[vertex];
    uint32_t const target = world->change->targets[source];
    if (target == TULLE_NONE) return TULLE_NONE;
    return vertex - before->work.surfaces[source].vertex_begin +
           world->work.surfaces[target].vertex_begin;
}

static uint32_t map_triangle(const tulle_world *world, uint32_t triangle) {
    const tulle_world *const before = world->change->before;
    if (triangle >= before->model.topo.triangle_count) return TULLE_NONE;
    uint32_t const source =
        before->model.vertex_surface[before->model.topo.triangles[3 * (size_t)triangle]];
    uint32_t const target = world->change->targets[source];
    if (target == TULLE_NONE) return TULLE_NONE;
    return triangle - before->work.surfaces[source].triangle_begin +
           world->work.surfaces[target].triangle_begin;
}

static uint32_t map_edge(const tulle_world *world, uint32_t edge) {
    const tulle_world *const before = world->change->before;
    if (edge >= before->model.topo.edge_count) return TULLE_NONE;
    uint32_t const source =
        before->model.vertex_surface[before->model.topo.edges[2 * (size_t)edge]];
    uint32_t const target = world->change->targets[source];
    if (target == TULLE_NONE) return TULLE_NONE;
    return edge - before->work.surfaces[source].edge_begin +
           world->work.surfaces[target].edge_begin;
}

/* The obstacle that was this one before. */
static uint32_t map_obstacle(const tulle_world *world, uint32_t obstacle) {
    const tulle_world *const before = world->change->before;
    if (obstacle >= before->model.obstacles.count) return TULLE_NONE;
    uint32_t const target = world->change->targets[before->model.cloths.count + obstacle];
    return target == TULLE_NONE ? TULLE_NONE : target - (uint32_t)world->model.cloths.count;
}

/* What a body was before, or TULLE_NONE: it is new. */
static uint32_t find_body_source(const tulle_world *world, size_t body) {
    const world_change *const change = world->change;
    uint32_t const source =
        change->sources[world->model.cloths.count + world->model.body_obstacles[body]];
    return source == TULLE_NONE ? TULLE_NONE : change->before->model.surface_bodies[source];
}

/* ---- state ---- */

static void carry_vectors(motion_state *now, size_t to, const motion_state *old, size_t from,
                          size_t count) {
    double *targets[STATE_VECTORS_MAX], *sources[STATE_VECTORS_MAX];
    size_t const vector_count = step_list_vectors(now, targets);
    (void)step_list_vectors(old, sources);
    for (size_t i = 0; i < vector_count; i++)
        memcpy(targets[i] + 3 * to, sources[i] + 3 * from, 3 * count * sizeof(double));
}

static void carry_surface(tulle_world *world, size_t surface, size_t source) {
    const tulle_world *const before = world->change->before;
    const surface_range *const range = &world->work.surfaces[surface];
    size_t const to = range->vertex_begin, from = before->work.surfaces[source].vertex_begin;
    size_t const count = range->vertex_end - range->vertex_begin;
    motion_state *const now = &world->now;
    carry_vectors(now, to, &before->now, from, count);
    if (!range->is_obstacle) {
        if (world->model.particle_count > 0)
            memcpy(now->particles + to, before->now.particles + from, count);
        if (world->model.cloth_rest_count > 0)
            now->cloth_rests[surface] = before->now.cloth_rests[source];
        return;
    }
    size_t const obstacle = surface - world->model.cloths.count,
                 old = source - before->model.cloths.count;
    now->is_present[obstacle] = before->now.is_present[old];
    if (world->model.pose_count > 0 && before->model.pose_count > 0)
        now->poses[obstacle] = before->now.poses[old];
}

/* How far lagging surfaces lag. */
static void carry_lags(tulle_world *world) {
    const world_change *const change = world->change;
    const tulle_world *const before = change->before;
    for (size_t i = 0; i < world->model.obstacles.count && before->model.lag_vertex_count; i++) {
        const world_obstacle *const obstacle = &world->model.obstacles.data[i];
        uint32_t const source = change->sources[world->model.cloths.count + i];
        if (source == TULLE_NONE || world->model.lag_vertex_count == 0) continue;
        size_t const old = source - before->model.cloths.count;
        size_t const from = before->model.obstacles.data[old].vertex_begin -
                            before->model.obstacles.data[0].vertex_begin;
        size_t const to = obstacle->vertex_begin - world->model.obstacles.data[0].vertex_begin;
        memcpy(world->now.lags + 3 * to, before->now.lags + 3 * from,
               3 * obstacle->mesh.vertex_count * sizeof(double));
        world->now.largest_lags[i] = before->now.largest_lags[old];
    }
    memcpy(world->now.still, before->now.still, sizeof world->now.still);
    if (world->model.surface_count >= before->model.surface_count) /* else nothing pinches there */
        world->now.still_count = before->now.still_count;
}

/* New cloth or a new body has moved as it moves now. No step before: there is no history. */
static void make_history(tulle_world *world) {
    uint32_t const added = world->change->added;
    if (added == TULLE_NONE || !(world->now.previous_time_step > 0.0)) return;
    if (!world->now.previous_mean) return;
    bool const is_cloth = added < world->model.cloths.count;
    uint32_t const body =
        world->model.body_count > 0 ? world->model.surface_bodies[added] : TULLE_NONE;
    if (!is_cloth && body == TULLE_NONE) return;
    size_t const first =
        is_cloth ? world->work.surfaces[added].vertex_begin : get_first_slot(&world->model, body);
    size_t const count = is_cloth ? world->model.cloths.data[added].mesh.vertex_count : 2;
    size_t const begin = 3 * first, bytes = 3 * count * sizeof(double);
    memcpy(world->now.previous_mean + begin, world->now.velocities + begin, bytes);
    memcpy(world->now.previous_velocities + begin, world->now.velocities + begin, bytes);
}

/* The body that names a group of sleepers: the lowest of those that are left. */
static uint32_t map_group(const tulle_world *world, size_t body, uint32_t group) {
    const body_rest *const old = world->change->before->now.rests;
    for (size_t b = 0; b < world->model.body_count; b++) {
        uint32_t const source = find_body_source(world, b);
        if (source == TULLE_NONE) continue;
        if (source == group || (old[source].group == group && old[source].state == BODY_SLEEPS &&
                                old[find_body_source(world, body)].state == BODY_SLEEPS))
            return (uint32_t)b;
    }
    return (uint32_t)body;
}

static void carry_bodies(tulle_world *world) {
    const tulle_world *const before = world->change->before;
    motion_state *const now = &world->now;
    for (size_t b = 0; b < world->model.body_count; b++) {
        uint32_t const source = find_body_source(world, b);
        if (source == TULLE_NONE) continue;
        carry_vectors(now, get_first_slot(&world->model, b), &before->now,
                      get_first_slot(&before->model, source), 2);
        now->rests[b] = before->now.rests[source];
        now->rests[b].group = map_group(world, b, now->rests[b].group);
        memcpy(now->drive_forces + BODY_AXES * b, before->now.drive_forces + BODY_AXES * source,
               BODY_AXES * sizeof(double));
        world->model.controls[b] = before->model.controls[source];
    }
    now->lost_energy = world->model.body_count > 0 ? before->now.lost_energy : 0.0;
    step_mark_bodies(&world->model, now, &world->work);
}

void world_carry_state(tulle_world *world) {
    const world_change *const change = world->change;
    world->now.previous_time_step = change->before->now.previous_time_step;
    world->now.attachment_count = change->before->now.attachment_count;
    for (size_t s = 0; s < world->model.surface_count; s++)
        if (change->sources[s] != TULLE_NONE) carry_surface(world, s, change->sources[s]);
    carry_lags(world);
    make_history(world);
    carry_bodies(world);
}

void world_carry_plastic(tulle_world *world) {
    const world_change *const change = world->change;
    if (world->model.plastic_count == 0 || change->before->model.plastic_count == 0) return;
    for (size_t s = 0; s < world->model.cloths.count; s++) {
        if (change->sources[s] == TULLE_NONE) continue;
        const surface_range *const from = &change->before->work.surfaces[change->sources[s]];
        size_t const count = SLIDER_COUNT * (size_t)(from->triangle_end - from->triangle_begin);
        memcpy(world->now.plastic + SLIDER_COUNT * (size_t)world->work.surfaces[s].triangle_begin,
               change->before->now.plastic + SLIDER_COUNT * (size_t)from->triangle_begin,
               count * sizeof(double));
    }
}

void world_mark_held(tulle_world *world) {
    for (size_t i = 0; i < world->model.cloths.count; i++) {
        const world_cloth *const cloth = &world->model.cloths.data[i];
        for (size_t p = 0; p < cloth->pin_count; p++) {
            const world_pin *const pin = &cloth->pins[p];
            if (world->now.time >= pin->release_time) continue;
            for (size_t k = 0; k < pin->vertex_count; k++)
                world->work.is_fixed[cloth->vertex_begin + pin->vertices[k]] = 1;
        }
    }
    const motion_state *const old = &world->change->before->now;
    for (size_t i = 0; i < old->ties.count; i++) {
        uint32_t const vertex = map_vertex(world, old->ties.data[i].vertex);
        if (vertex != TULLE_NONE && !isfinite(old->ties.data[i].stiffness))
            world->work.is_fixed[vertex] = 1;
    }
}

/* ---- lists ---- */

/* Contacts keep their order: what stays has the same order as before. */
static void carry_store(tulle_world *world) {
    const contact_store *const old = &world->change->before->now.contacts;
    contact_store *const store = &world->now.contacts;
    for (size_t i = 0; i < old->contacts.count; i++) {
        stored_contact contact = old->contacts.data[i];
        bool const is_edges = contact.kind == FEATURE_EDGE_EDGE;
        contact.first =
            is_edges ? map_edge(world, contact.first) : map_vertex(world, contact.first);
        contact.second =
            is_edges ? map_edge(world, contact.second) : map_triangle(world, contact.second);
        if (contact.first != TULLE_NONE && contact.second != TULLE_NONE)
            store->contacts.data[store->contacts.count++] = contact;
    }
    store->time_step = store->contacts.count > 0 ? old->time_step : 0.0; /* as a step has it */
}

/* Attachments of what has gone, and to it, end. */
static void carry_ties(tulle_world *world) {
    const motion_state *const old = &world->change->before->now;
    motion_state *const now = &world->now;
    for (size_t i = 0; i < old->ties.count; i++) {
        world_tie tie = old->ties.data[i];
        bool const is_point = tie.corners[0] == TULLE_NONE;
        tie.vertex = map_vertex(world, tie.vertex);
        for (int k = 0; k < 3 && !is_point; k++) tie.corners[k] = map_vertex(world, tie.corners[k]);
        if (tie.vertex != TULLE_NONE && (is_point || tie.corners[0] != TULLE_NONE))
            now->ties.data[now->ties.count++] = tie;
        else if (tie.vertex != TULLE_NONE)
            step_wake_cloth_at(&world->model, now, tie.vertex);
        else if (tie.corners[0] != TULLE_NONE)
            step_wake_cloth_at(&world->model, now, tie.corners[0]);
    }
}

/* The body that stays of a surface before, or TULLE_NONE. */
static uint32_t map_body(const tulle_world *world, uint32_t source) {
    uint32_t const target = world->change->targets[source];
    return target == TULLE_NONE || !world->model.surface_bodies
               ? TULLE_NONE
               : world->model.surface_bodies[target];
}

/* Wakes what touched what has gone, and the bodies that fell asleep with it. */
static void wake_left(tulle_world *world) {
    const tulle_world *const before = world->change->before;
    const contact_store *const store = &before->now.contacts;
    for (size_t i = 0; i < store->contacts.count && world->model.has_sleep; i++) {
        const stored_contact *const contact = &store->contacts.data[i];
        bool const is_edges = contact->kind == FEATURE_EDGE_EDGE;
        size_t const first = contact->first, second = contact->second;
        const uint32_t *const edges = before->model.topo.edges, *const corners =
                                                                    before->model.topo.triangles;
        uint32_t const ends[2] = {
            before->model.vertex_surface[is_edges ? edges[2 * first] : contact->first],
            before->model.vertex_surface[is_edges ? edges[2 * second] : corners[3 * second]]};
        for (int k = 0; k < 2; k++) {
            if (world->change->targets[ends[1 - k]] != TULLE_NONE) continue;
            uint32_t const body = map_body(world, ends[k]);
            uint32_t const surface = world->change->targets[ends[k]];
            if (body != TULLE_NONE)
                step_wake_body(&world->model, &world->now, body);
            else if (surface < world->model.cloth_rest_count)
                step_wake_cloth(&world->model, &world->now, surface);
        }
    }
    for (size_t b = 0; b < before->model.body_count; b++) {
        const body_rest *const gone = &before->now.rests[b];
        if (map_obstacle(world, before->model.body_obstacles[b]) != TULLE_NONE ||
            gone->state != BODY_SLEEPS)
            continue;
        for (size_t k = 0; k < world->model.body_count; k++) {
            uint32_t const source = find_body_source(world, k);
            if (source != TULLE_NONE && before->now.rests[source].state == BODY_SLEEPS &&
                before->now.rests[source].group == gone->group)
                step_wake_body(&world->model, &world->now, k);
        }
    }
}

tulle_status world_carry_contacts(tulle_world *world, tulle_error *error) {
    const motion_state *const old = &world->change->before->now;
    motion_state *const now = &world->now;
    if (reserve_contacts(&now->contacts, &world->heap, old->contacts.contacts.count) != TULLE_OK ||
        !ARRAY_RESERVE(&world->heap, &now->ties, old->ties.count) ||
        !ARRAY_MATCH(&world->heap, &now->ties, &world->next.ties))
        return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory left for contacts");
    carry_store(world);
    carry_ties(world);
    wake_left(world);
    return TULLE_OK;
}
