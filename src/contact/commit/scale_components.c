/* contact/commit/scale_components.c - see scale_components.h.
 *
 * A component that goes the part s of its path, against its own cloth or against things at rest,
 * repeats the first part of tested paths. Against an obstacle that moves by K the displacement
 * relative to K is shortened instead: if K is a translation, the relative paths are again the first
 * part of those tested. With several obstacles, or a rotation, they need not be; then the next test
 * says so. */
#include "contact/commit/scale_components.h"

#include "contact/pairs/body_paths.h"

#include <math.h>
#include <string.h>

/* Part of the time of impact that is used. The rest keeps the gap open for the next step. */
static const double PART_OF_TIME = 0.9;
/* Time of a component that was not hit. */
static const double NOT_HIT = 2.0;
enum { CARRIER_NONE = -1, CARRIER_IDENTITY = -2 };

bool scaled_components_make(scaled_components *components, const contact_scene *scene,
                            const double *x1, const double *u) {
    arena *const scratch = scene->scratch;
    size_t const count = scene->cloth_vertex_count + scene->body_count;
    components->base = ARENA_NEW(scratch, double, 3 * scene->vertex_count);
    components->body_motions = ARENA_NEW(scratch, vec3, 2 * scene->body_count);
    components->scales = ARENA_NEW(scratch, double, count);
    components->carriers = ARENA_NEW(scratch, int32_t, count);
    components->times = ARENA_NEW(scratch, double, count);
    if (!components->base || !components->body_motions || !components->scales ||
        !components->carriers || !components->times)
        return false;
    memcpy(components->base, x1, 3 * scene->vertex_count * sizeof(double));
    for (size_t b = 0; b < scene->body_count; b++) {
        size_t const slot = get_body_slot(scene, b);
        components->body_motions[2 * b] = vec3_load(u, slot);
        components->body_motions[2 * b + 1] = vec3_load(u, slot + 1);
    }
    for (size_t i = 0; i < count; i++) {
        components->scales[i] = 1.0;
        components->carriers[i] = CARRIER_NONE;
    }
    return vertex_groups_make(&components->groups, scratch, count);
}

static int32_t combine_carriers(int32_t a, int32_t b) {
    if (a == b || b == CARRIER_NONE) return a;
    return a == CARRIER_NONE ? b : CARRIER_IDENTITY;
}

/* Joins the members of a hit to one component. A member is a vertex, or the body of a vertex;
 * bodies are numbered after all cloth vertices. Returns the first member, or TULLE_NONE if nothing
 * has mass. A vertex without mass gives the component its carrier; a component with a body has
 * none. */
static uint32_t join_hit(const contact_scene *scene, scaled_components *components,
                         const pair_event *hit) {
    vertex_groups *const groups = &components->groups;
    size_t const cloth_count = scene->cloth_vertex_count;
    uint32_t vertices[4], first = TULLE_NONE;
    int32_t carrier = CARRIER_NONE;
    feature_pair_vertices(scene->set->topo, hit->kind, hit->pair, vertices);
    for (int k = 0; k < 4; k++) {
        uint32_t member = vertices[k];
        if (!(scene->inverse_mass[member] > 0.0)) {
            uint32_t const body = find_body(scene, member);
            member = body == TULLE_NONE ? TULLE_NONE : (uint32_t)cloth_count + body;
        }
        if (member == TULLE_NONE) {
            uint32_t const surface = scene->vertex_surface[vertices[k]];
            bool const is_obstacle = vertices[k] >= cloth_count;
            bool const has_map = scene->carriers && scene->carriers[surface];
            carrier = combine_carriers(carrier, is_obstacle && has_map ? (int32_t)surface
                                                                       : CARRIER_IDENTITY);
            continue;
        }
        if (first == TULLE_NONE) first = member;
        uint32_t const a = find_group(groups, first), b = find_group(groups, member);
        uint32_t const root = join_groups(groups, first, member);
        components->scales[root] = fmin(components->scales[a], components->scales[b]);
        components->carriers[root] =
            combine_carriers(components->carriers[a], components->carriers[b]);
        if (member >= cloth_count) carrier = CARRIER_IDENTITY;
    }
    if (first == TULLE_NONE) return first;
    uint32_t const root = find_group(groups, first);
    components->carriers[root] = combine_carriers(components->carriers[root], carrier);
    return first;
}

size_t scale_components(const contact_scene *scene, scaled_components *components,
                        const pair_events *hits, bool stop, double *u, double *x1) {
    vertex_groups *const groups = &components->groups;
    size_t const count = groups->vertex_count;
    double *const times = components->times;
    /* all hits are joined before times are noted: a time belongs to the whole component */
    for (size_t i = 0; i < hits->count; i++) join_hit(scene, components, &hits->events[i]);
    for (size_t i = 0; i < count; i++) times[i] = NOT_HIT;
    for (size_t i = 0; i < hits->count; i++) {
        uint32_t const member = join_hit(scene, components, &hits->events[i]);
        if (member == TULLE_NONE) continue;
        double *const time = &times[find_group(groups, member)];
        *time = fmin(*time, hits->events[i].time);
    }
    size_t shortened_count = 0;
    for (size_t i = 0; i < count; i++) {
        if (times[i] == NOT_HIT || !(components->scales[i] > 0.0)) continue;
        components->scales[i] *= stop ? 0.0 : PART_OF_TIME * times[i];
        shortened_count++;
    }
    if (shortened_count == 0) return 0;
    /* vertices go the part s of the way from where the carrier takes them */
    for (uint32_t i = 0; i < scene->cloth_vertex_count; i++) {
        if (!groups->is_member[i] || !(scene->inverse_mass[i] > 0.0)) continue;
        uint32_t const root = find_group(groups, i);
        int32_t const carrier = components->carriers[root];
        vec3 const start = vec3_load(scene->x0, i), base = vec3_load(components->base, i);
        vec3 carried = start;
        if (carrier >= 0) {
            const affine_map *const map = scene->carriers[carrier];
            carried = vec3_add(mat3_multiply_vec3(&map->matrix, start), map->offset);
        }
        vec3 const end = vec3_lerp(carried, base, components->scales[root]);
        vec3_store(x1, i, end);
        vec3_store(u, i, vec3_scale(vec3_sub(end, start), 1.0 / scene->time_step));
    }
    /* a body that goes the part s of its free motion moves s times as fast all the time */
    for (uint32_t b = 0; b < scene->body_count; b++) {
        uint32_t const member = (uint32_t)scene->cloth_vertex_count + b;
        if (!groups->is_member[member]) continue;
        double const s = components->scales[find_group(groups, member)];
        const vec3 *const motion = components->body_motions + 2 * (size_t)b;
        size_t const slot = get_body_slot(scene, b);
        vec3_store(u, slot, vec3_scale(motion[0], s));
        vec3_store(u, slot + 1, vec3_scale(motion[1], s));
    }
    place_bodies(scene, u, 1.0, x1);
    return shortened_count;
}
