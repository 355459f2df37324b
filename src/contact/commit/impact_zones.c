/* contact/commit/impact_zones.c - see impact_zones.h.
 *
 * Based on: Provot, Collision and self-collision handling in cloth model dedicated to design
 * garments, 1997; Bridson, Fedkiw, Anderson, Robust treatment of collisions, contact and friction
 * for cloth animation, 2002. Departures: the true rotation places the end of the step, not the
 * linearised one. Paths are still chords, so the zone is tested again like any other motion. Zones
 * that obstacles or pins hold are left to component scaling. */
#include "contact/commit/impact_zones.h"

#include <math.h>

/* [rad] A zone that would turn further in a step is not moved: its chords would shrink it. */
static const double LARGEST_TURN = 0.3;
/* This part of the inertia's trace is added to its diagonal, so that a zone of points on a line has
 * an invertible one, too. */
static const double INERTIA_MARGIN = 1e-9;

typedef struct zone_motion {
    double mass;                 /* [kg] */
    vec3 centre;                 /* [m] at x0 */
    vec3 velocity;               /* [m/s] */
    vec3 angular_momentum, turn; /* [kg m^2/s], [rad] over the step */
    mat3 inertia;                /* [kg m^2] */
} zone_motion;

/* Fills the motions of `count` zones, which are zeroed before, from the momenta of their vertices.
 * zone_of: the zone of each vertex. The rotation over the step is h I^-1 L, by Cramer's rule. */
static void measure_motions(const contact_scene *scene, const uint32_t *zone_of, const double *u,
                            zone_motion *motions, uint32_t count) {
    for (size_t i = 0; i < scene->cloth_vertex_count; i++) {
        if (zone_of[i] == TULLE_NONE) continue;
        zone_motion *const motion = &motions[zone_of[i]];
        double const mass = 1.0 / scene->inverse_mass[i];
        motion->mass += mass;
        motion->centre = vec3_add_scaled(motion->centre, vec3_load(scene->x0, i), mass);
        motion->velocity = vec3_add_scaled(motion->velocity, vec3_load(u, i), mass);
    }
    for (uint32_t zone = 0; zone < count; zone++) {
        motions[zone].centre = vec3_scale(motions[zone].centre, 1.0 / motions[zone].mass);
        motions[zone].velocity = vec3_scale(motions[zone].velocity, 1.0 / motions[zone].mass);
    }
    for (size_t i = 0; i < scene->cloth_vertex_count; i++) {
        if (zone_of[i] == TULLE_NONE) continue;
        zone_motion *const motion = &motions[zone_of[i]];
        double const mass = 1.0 / scene->inverse_mass[i];
        vec3 const arm = vec3_sub(vec3_load(scene->x0, i), motion->centre);
        vec3 const spin = vec3_cross(arm, vec3_sub(vec3_load(u, i), motion->velocity));
        motion->angular_momentum = vec3_add_scaled(motion->angular_momentum, spin, mass);
        mat3 const round = mat3_identity(mass * vec3_norm2(arm));
        mat3 const outer = mat3_outer(arm, arm, -mass);
        mat3_add_scaled(&motion->inertia, &round, 1.0);
        mat3_add_scaled(&motion->inertia, &outer, 1.0);
    }
    for (uint32_t zone = 0; zone < count; zone++) {
        zone_motion *const motion = &motions[zone];
        const double *const m = motion->inertia.m;
        double const margin = INERTIA_MARGIN * (m[0] + m[4] + m[8]);
        vec3 const a = {m[0] + margin, m[3], m[6]};
        vec3 const b = {m[1], m[4] + margin, m[7]};
        vec3 const c = {m[2], m[5], m[8] + margin};
        vec3 const l = motion->angular_momentum;
        double const determinant = vec3_dot(a, vec3_cross(b, c));
        if (!(determinant > 0.0)) continue; /* it does not turn */
        double const scale = scene->time_step / determinant;
        motion->turn =
            vec3_make(scale * vec3_dot(l, vec3_cross(b, c)), scale * vec3_dot(a, vec3_cross(l, c)),
                      scale * vec3_dot(a, vec3_cross(b, l)));
    }
}

tulle_status project_impact_zones(const contact_scene *scene, impact_zones *zones,
                                  const pair_events *hits, double *u, double *x1,
                                  uint64_t *zone_count) {
    vertex_groups *const groups = &zones->groups;
    /* the vertices of a hit are in one zone */
    for (size_t i = 0; i < hits->count; i++) {
        uint32_t vertices[4], first = TULLE_NONE;
        bool is_held = false;
        feature_pair_vertices(scene->set->topo, hits->events[i].kind, hits->events[i].pair,
                              vertices);
        for (int k = 0; k < 4; k++) {
            if (!(scene->inverse_mass[vertices[k]] > 0.0)) {
                is_held = true;
                continue;
            }
            if (first == TULLE_NONE) first = vertices[k];
            is_held |= zones->is_held[find_group(groups, vertices[k])];
            join_groups(groups, first, vertices[k]);
        }
        if (first != TULLE_NONE) zones->is_held[find_group(groups, first)] |= is_held;
    }
    /* zones that nothing holds are numbered, and move */
    arena_mark const mark = arena_get_mark(scene->scratch);
    uint32_t *const zone_of = ARENA_NEW(scene->scratch, uint32_t, scene->cloth_vertex_count);
    uint32_t count = 0;
    for (uint32_t i = 0; zone_of && i < groups->vertex_count; i++) {
        uint32_t const group = find_group(groups, i);
        zone_of[i] = TULLE_NONE;
        if (groups->is_member[i] && !zones->is_held[group])
            zone_of[i] = group == i ? count++ : zone_of[group];
    }
    zone_motion *const motions = ARENA_NEW_ZEROED(scene->scratch, zone_motion, count);
    bool const has_memory = zone_of && motions;
    if (has_memory) {
        measure_motions(scene, zone_of, u, motions, count);
        *zone_count += count;
    }
    /* the vertices of all zones: arms turn by Rodrigues' formula */
    for (size_t i = 0; has_memory && i < scene->cloth_vertex_count; i++) {
        if (zone_of[i] == TULLE_NONE) continue;
        const zone_motion *const motion = &motions[zone_of[i]];
        double const angle = vec3_norm(motion->turn);
        if (!(angle <= LARGEST_TURN)) continue;
        vec3 const start = vec3_load(scene->x0, i);
        vec3 arm = vec3_sub(start, motion->centre);
        if (angle > 0.0) {
            vec3 const axis = vec3_scale(motion->turn, 1.0 / angle);
            vec3 const across = vec3_cross(axis, arm);
            arm = vec3_add_scaled(arm, across, sin(angle));
            arm = vec3_add_scaled(arm, vec3_cross(axis, across), 1.0 - cos(angle));
        }
        vec3 const centre = vec3_add_scaled(motion->centre, motion->velocity, scene->time_step);
        vec3 const end = vec3_add(centre, arm);
        vec3_store(x1, i, end);
        vec3_store(u, i, vec3_scale(vec3_sub(end, start), 1.0 / scene->time_step));
    }
    arena_release(scene->scratch, mark);
    return has_memory ? TULLE_OK : TULLE_ERROR_OUT_OF_MEMORY;
}
