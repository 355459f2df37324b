/* contact/commit/scale_components.c - see scale_components.h.
 *
 * Against what rests, or against its own cloth, a component that goes s of its way passes through
 * the first part of paths that were tested, in the same order. Against an obstacle that moves by
 * K the displacement relative to K is shortened instead: for a translation the relative paths are
 * again the first part of those tested. Where this does not hold (several obstacles, rotation) the
 * next test says so. */
#include "contact/commit/scale_components.h"

#include "contact/pairs/body_paths.h"

#include <math.h>

/* Part of the time of impact that is used: what is left keeps the gap open for the next step. */
#define PART_OF_TIME 0.9
/* Time of a component that was not hit. */
#define NOT_HIT 2.0
enum { CARRIER_NONE = -1, CARRIER_IDENTITY = -2 };

bool scaled_components_make(scaled_components *components, const contact_scene *scene,
                            const double *base, const double *u) {
    size_t const count = scene->cloth_vertex_count + scene->body_count;
    components->base = base;
    components->body_motions = ARENA_NEW(scene->scratch, vec3, 3 * scene->body_count);
    if (!components->body_motions) return false;
    for (size_t b = 0; b < scene->body_count; b++) {
        size_t const slot = get_body_slot(scene, b);
        components->body_motions[3 * b] = vec3_load(u, slot);
        components->body_motions[3 * b + 1] = vec3_load(u, slot + 1);
        components->body_motions[3 * b + 2] = scene->bodies[b].lift;
    }
    components->scales = ARENA_NEW(scene->scratch, double, count);
    components->carriers = ARENA_NEW(scene->scratch, int32_t, count);
    components->times = ARENA_NEW(scene->scratch, double, count);
    if (!components->scales || !components->carriers || !components->times) return false;
    for (size_t i = 0; i < count; i++) {
        components->scales[i] = 1.0;
        components->carriers[i] = CARRIER_NONE;
    }
    return vertex_groups_make(&components->groups, scene->scratch, count);
}

static int32_t combine_carriers(int32_t a, int32_t b) {
    if (a == b || b == CARRIER_NONE) return a;
    return a == CARRIER_NONE ? b : CARRIER_IDENTITY;
}

/* Number of what a vertex moves with: itself, or its body after all cloth vertices; TULLE_NONE for
 * what has no mass. */
static uint32_t find_member(const contact_scene *scene, uint32_t vertex) {
    if (scene->inverse_mass[vertex] > 0.0) return vertex;
    uint32_t const body = find_body(scene, vertex);
    return body == TULLE_NONE ? TULLE_NONE : (uint32_t)scene->cloth_vertex_count + body;
}

/* What a vertex without mass asks of the component that it touches. */
static int32_t find_carrier(const contact_scene *scene, uint32_t vertex) {
    uint32_t const surface = scene->vertex_surface[vertex];
    bool const is_obstacle = vertex >= scene->cloth_vertex_count;
    bool const has_map = scene->carriers && scene->carriers[surface];
    return is_obstacle && has_map ? (int32_t)surface : CARRIER_IDENTITY;
}

static void join_vertices(scaled_components *components, uint32_t a, uint32_t b) {
    uint32_t const root_a = find_group(&components->groups, a);
    uint32_t const root_b = find_group(&components->groups, b);
    uint32_t const root = join_groups(&components->groups, a, b);
    components->scales[root] = fmin(components->scales[root_a], components->scales[root_b]);
    components->carriers[root] =
        combine_carriers(components->carriers[root_a], components->carriers[root_b]);
}

/* The first member of the hit, or TULLE_NONE. A component with a body is never carried. */
static uint32_t join_hit(const contact_scene *scene, scaled_components *components,
                         const pair_event *hit) {
    uint32_t vertices[4], first = TULLE_NONE;
    int32_t carrier = CARRIER_NONE;
    feature_pair_vertices(scene->set->topo, hit->kind, hit->pair, vertices);
    for (int k = 0; k < 4; k++) {
        uint32_t const member = find_member(scene, vertices[k]);
        if (member != TULLE_NONE) {
            if (first == TULLE_NONE) first = member;
            join_vertices(components, first, member);
            if (member >= scene->cloth_vertex_count) carrier = CARRIER_IDENTITY;
        } else {
            carrier = combine_carriers(carrier, find_carrier(scene, vertices[k]));
        }
    }
    if (first == TULLE_NONE) return first;
    uint32_t const root = find_group(&components->groups, first);
    components->carriers[root] = combine_carriers(components->carriers[root], carrier);
    return first;
}

static vec3 carry_point(const contact_scene *scene, int32_t carrier, vec3 point) {
    if (carrier < 0) return point;
    const affine_map *const map = scene->carriers[carrier];
    return vec3_add(mat3_multiply_vec3(&map->matrix, point), map->offset);
}

/* A body that goes the part s of its free motion is one that moves s times as fast all the time. */
static void slow_body(const contact_scene *scene, const vec3 *motion, size_t body, double s,
                      double *u) {
    size_t const slot = get_body_slot(scene, body);
    vec3_store(u, slot, vec3_scale(motion[0], s));
    vec3_store(u, slot + 1, vec3_scale(motion[1], s));
    scene->bodies[body].lift = vec3_scale(motion[2], s);
}

static void place_components(const contact_scene *scene, scaled_components *components, double *u,
                             double *x1) {
    for (uint32_t i = 0; i < scene->cloth_vertex_count; i++) {
        if (!components->groups.is_member[i] || !(scene->inverse_mass[i] > 0.0)) continue;
        uint32_t const root = find_group(&components->groups, i);
        vec3 const start = vec3_load(scene->x0, i);
        vec3 const carried = carry_point(scene, components->carriers[root], start);
        vec3 const end =
            vec3_lerp(carried, vec3_load(components->base, i), components->scales[root]);
        vec3_store(x1, i, end);
        vec3_store(u, i, vec3_scale(vec3_sub(end, start), 1.0 / scene->time_step));
    }
    for (uint32_t b = 0; b < scene->body_count; b++) {
        uint32_t const member = (uint32_t)scene->cloth_vertex_count + b;
        if (components->groups.is_member[member])
            slow_body(scene, components->body_motions + 3 * (size_t)b, b,
                      components->scales[find_group(&components->groups, member)], u);
    }
    place_bodies(scene, u, 1.0, x1);
}

/* Joins all hits, then takes the smallest time of each component that was hit; NOT_HIT for the
 * others. */
static void join_hits(const contact_scene *scene, scaled_components *components,
                      const pair_events *hits) {
    for (size_t i = 0; i < hits->count; i++) join_hit(scene, components, &hits->events[i]);
    for (uint32_t i = 0; i < components->groups.vertex_count; i++) components->times[i] = NOT_HIT;
    for (size_t i = 0; i < hits->count; i++) {
        uint32_t const vertex = join_hit(scene, components, &hits->events[i]);
        if (vertex == TULLE_NONE) continue;
        double *const time = &components->times[find_group(&components->groups, vertex)];
        *time = fmin(*time, hits->events[i].time);
    }
}

size_t scale_components(const contact_scene *scene, scaled_components *components,
                        const pair_events *hits, bool stop, double *u, double *x1) {
    size_t shortened_count = 0;
    join_hits(scene, components, hits);
    for (uint32_t i = 0; i < components->groups.vertex_count; i++) {
        if (components->times[i] == NOT_HIT || !(components->scales[i] > 0.0)) continue;
        components->scales[i] *= stop ? 0.0 : PART_OF_TIME * components->times[i];
        shortened_count++;
    }
    if (shortened_count > 0) place_components(scene, components, u, x1);
    return shortened_count;
}
