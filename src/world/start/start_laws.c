/* world/start/start_laws.c - contact laws of all pairs of surfaces, and the distances that follow
 * from materials, meshes and the def. Part of the start. */
#include "base/error.h"
#include "base/float_height.h"
#include "world/start/start.h"

#include <math.h>

/* The contact distance of a cloth without a thickness, as a share of its mean edge. */
static const double CONTACT_EDGE_SHARE = 0.2;
/* [m] The largest contact distance by default. Thicker cloth looks like felt. */
static const double CONTACT_DISTANCE_MAX = 5e-3;
/* Separation distance over contact distance. */
static const double SEPARATION_FACTOR = 1.5;
/* Minimum gap: this share of the smallest contact distance. */
static const double MINIMUM_GAP_SHARE = 1.0 / 40.0;
/* The minimum gap is at least this many float ulps of the scene's extent, so that it survives
 * rounding to float in files. */
static const double MINIMUM_GAP_ULPS = 4.0;
/* Largest share of a contact distance that the minimum gap may take. */
static const double MINIMUM_GAP_LARGEST_SHARE = 0.5;
/* [of the mean edge] Lower triangles are low: substeps may be shorter with them, and solves are
 * more exact. */
static const double LOW_TRIANGLE = 0.01;

/* Mean rest edge length of a range of edges [m]. */
static double measure_mean_edge(const tulle_world *world, uint32_t edge_begin, uint32_t edge_end) {
    double sum = 0.0;
    for (uint32_t e = edge_begin; e < edge_end; e++) {
        vec3 const a = vec3_load(world->model.rest, world->model.topo.edges[2 * (size_t)e]);
        vec3 const b = vec3_load(world->model.rest, world->model.topo.edges[2 * (size_t)e + 1]);
        sum += vec3_norm(vec3_sub(a, b));
    }
    return edge_end > edge_begin ? sum / (double)(edge_end - edge_begin) : 0.0;
}

/* Refuses triangles at rest that files cannot hold, and notes how low the lowest is. */
static tulle_status check_heights(tulle_world *world, double extent, tulle_error *error) {
    size_t const triangle_count =
        world->model.cloths.count > 0
            ? world->work.surfaces[world->model.cloths.count - 1].triangle_end
            : 0;
    double lowest = (double)INFINITY;
    size_t found = 0;
    for (size_t t = 0; t < triangle_count; t++) {
        vec3 corners[3];
        for (int k = 0; k < 3; k++)
            corners[k] =
                vec3_load(world->model.rest, world->model.topo.triangles[3 * t + (size_t)k]);
        vec3 const a = vec3_sub(corners[1], corners[0]), b = vec3_sub(corners[2], corners[0]);
        double const longest2 =
            fmax(fmax(vec3_norm2(a), vec3_norm2(b)), vec3_norm2(vec3_sub(corners[2], corners[1])));
        double const height = vec3_norm(vec3_cross(a, b)) / sqrt(longest2);
        if (height < lowest) lowest = height, found = t;
    }
    world->model.height_share = fmin(1.0, lowest / (LOW_TRIANGLE * world->model.edge_length));
    double const least = LEAST_HEIGHT * extent;
    if (!(lowest < least)) return TULLE_OK;
    const uint32_t *const corners = world->model.topo.triangles + 3 * found;
    size_t const surface = world->model.vertex_surface[corners[0]];
    uint32_t const begin = world->work.surfaces[surface].vertex_begin;
    double shortest = (double)INFINITY;
    uint32_t ends[2] = {0, 0};
    for (size_t k = 0; k < 3; k++) {
        uint32_t const a = corners[k], b = corners[(k + 1) % 3];
        double const length =
            vec3_norm(vec3_sub(vec3_load(world->model.rest, a), vec3_load(world->model.rest, b)));
        if (!(length < shortest)) continue;
        shortest = length;
        ends[0] = (a < b ? a : b) - begin;
        ends[1] = (a < b ? b : a) - begin;
    }
    return error_set(error, TULLE_ERROR_INVALID_MESH,
                     "'%s': the edge from vertex %u to %u is %.3g m long, and a triangle on it is "
                     "%.3g m high; floats in files hold no cloth lower than %.3g m where the scene "
                     "reaches %.3g m from the origin: merge vertices whose edge is that short, "
                     "move those that lie that near to an edge, or move the scene nearer",
                     world_surface_name(&world->model, surface), ends[0], ends[1], shortest, lowest,
                     least, extent);
}

/* Contact distance of one cloth against itself and obstacles [m]. */
static double choose_cloth_distance(const tulle_world *world, size_t cloth) {
    if (world->model.cloths.data[cloth].thickness > 0.0)
        return world->model.cloths.data[cloth].thickness;
    if (world->model.def.contact_distance > 0.0) return world->model.def.contact_distance;
    const surface_range *const range = &world->work.surfaces[cloth];
    return fmin(CONTACT_DISTANCE_MAX,
                CONTACT_EDGE_SHARE * measure_mean_edge(world, range->edge_begin, range->edge_end));
}

/* What a surface brings to a contact. Dynamic friction is not negative. */
typedef struct surface_roughness {
    double friction, dynamic_friction, restitution;
    surface_grain grain;
} surface_roughness;

static surface_roughness get_roughness(const tulle_world *world, size_t surface) {
    size_t const cloth_count = world->model.cloths.count;
    surface_roughness roughness;
    if (surface < cloth_count) {
        const world_cloth *const c = &world->model.cloths.data[surface];
        const tulle_material *const m = &c->material;
        roughness = (surface_roughness){m->friction,
                                        m->dynamic_friction,
                                        m->restitution,
                                        {vec3_load(c->grain, 0), m->friction_across}};
    } else {
        const world_obstacle *const o = &world->model.obstacles.data[surface - cloth_count];
        roughness = (surface_roughness){o->friction,
                                        o->dynamic_friction,
                                        o->restitution,
                                        {vec3_load(o->grain, 0), o->friction_across}};
    }
    if (roughness.dynamic_friction < 0.0) roughness.dynamic_friction = roughness.friction;
    return roughness;
}

/* Coefficients of a pair. A law that was set for the pair, or for what its objects are made of,
 * comes first. Else friction between cloths is the world's, and all other coefficients are the
 * geometric means of both surfaces'. */
static void set_coefficients(const tulle_world *world, size_t a, size_t b, contact_law *law) {
    const tulle_contact_law *const given = world_find_pair_law(world, a, b);
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
    if (a >= world->model.cloths.count || b >= world->model.cloths.count) return;
    double const dynamic = world->model.def.dynamic_friction_cloth_cloth;
    law->static_friction = world->model.def.friction_cloth_cloth;
    law->dynamic_friction = dynamic < 0.0 ? law->static_friction : dynamic;
}

/* Whether a body takes part in a pair of two surfaces. */
static bool has_body(const tulle_world *world, size_t a, size_t b) {
    return a != b && world->model.surface_bodies &&
           (world->model.surface_bodies[a] != TULLE_NONE ||
            world->model.surface_bodies[b] != TULLE_NONE);
}

double world_get_separation(const tulle_world *world, double contact_distance) {
    double const given = world->model.def.separation_distance;
    return given > 0.0 ? given : SEPARATION_FACTOR * contact_distance;
}

static contact_law make_law(const tulle_world *world, size_t a, size_t b) {
    size_t const cloth_count = world->model.cloths.count;
    bool const has_cloth_a = a < cloth_count, has_cloth_b = b < cloth_count;
    contact_law law = {0};
    if (has_cloth_a && has_cloth_b) {
        law.contact_distance =
            0.5 * (choose_cloth_distance(world, a) + choose_cloth_distance(world, b));
    } else if (has_cloth_a || has_cloth_b) {
        law.contact_distance = choose_cloth_distance(world, has_cloth_a ? a : b);
    }
    bool const is_among_bodies = !has_cloth_a && !has_cloth_b && has_body(world, a, b);
    if (is_among_bodies) { /* the least that a cloth has */
        law.contact_distance = world->model.def.contact_distance;
        if (!(law.contact_distance > 0.0)) {
            law.contact_distance = CONTACT_DISTANCE_MAX;
            for (size_t i = 0; i < cloth_count; i++)
                law.contact_distance = fmin(law.contact_distance, choose_cloth_distance(world, i));
        }
    }
    if (has_cloth_a || has_cloth_b || is_among_bodies) set_coefficients(world, a, b, &law);
    law.separation_distance = world_get_separation(world, law.contact_distance);
    return law;
}

/* Contact laws of all pairs of surfaces and the distances that the world reports. */
tulle_status world_derive_distances(tulle_world *world, tulle_error *error) {
    size_t const surface_count = world->model.surface_count,
                 cloth_count = world->model.cloths.count;
    double smallest = (double)INFINITY; /* [m] contact distance of all pairs that can touch */
    for (size_t a = 0; a < surface_count; a++) {
        for (size_t b = 0; b < surface_count; b++) {
            contact_law const law = make_law(world, a, b);
            world->model.laws[a * surface_count + b] = law;
            if (a >= cloth_count && b >= cloth_count && !has_body(world, a, b)) continue;
            if (law.separation_distance < law.contact_distance)
                return error_set(
                    error, TULLE_ERROR_INVALID_ARGUMENT,
                    "the separation distance (delta_s) of %g m is under the contact distance "
                    "(delta_c, thickness) of %g m between '%s' and '%s'; give at least that, or "
                    "leave it out: 1.5 times the contact distance",
                    law.separation_distance, law.contact_distance,
                    world_surface_name(&world->model, a), world_surface_name(&world->model, b));
            world->model.contact_distance =
                fmax(world->model.contact_distance, law.contact_distance);
            world->model.separation_distance =
                fmax(world->model.separation_distance, law.separation_distance);
            smallest = fmin(smallest, law.contact_distance);
        }
    }
    world->model.edge_length = measure_mean_edge(world, 0, world->model.cloth_edge_count);
    double extent = 0.0; /* [m] the largest coordinate */
    for (size_t s = 0; s < surface_count; s++)
        extent = fmax(extent, world_surface_mesh(&world->model, s)->extent);
    tulle_status const status = check_heights(world, extent, error);
    if (status != TULLE_OK) return status;
    if (!isfinite(smallest)) { /* nothing meets anything */
        world->model.minimum_gap = world->model.def.minimum_gap;
        return TULLE_OK;
    }

    double const float_floor = MINIMUM_GAP_ULPS * 0x1p-23 * extent;
    bool const is_given = world->model.def.minimum_gap > 0.0;
    world->model.minimum_gap =
        is_given ? world->model.def.minimum_gap : fmax(MINIMUM_GAP_SHARE * smallest, float_floor);
    double const largest = MINIMUM_GAP_LARGEST_SHARE * smallest;
    if (world->model.minimum_gap <= largest) return TULLE_OK;
    if (is_given)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "the minimum gap (xi) of %g m is more than half of the smallest contact "
                         "distance (delta_c, thickness) of %g m; give at most %g m, or leave it "
                         "out: a fortieth of the contact distance",
                         world->model.minimum_gap, smallest, largest);
    return error_set(
        error, TULLE_ERROR_INVALID_ARGUMENT,
        "the minimum gap, %g m, is more than half of the contact distance, %g m: it is so large "
        "because the scene reaches %g m from the origin and its files hold floats. Move the scene "
        "nearer, use thicker cloth, or give the minimum gap (xi) yourself",
        world->model.minimum_gap, smallest, extent);
}

/* Grain of the surfaces, if one of them has friction that depends on the direction. */
tulle_status world_set_grains(tulle_world *world) {
    size_t const count = world->model.surface_count;
    bool has_grain = false;
    for (size_t s = 0; s < count; s++) has_grain |= get_roughness(world, s).grain.across != 1.0;
    if (!has_grain) return TULLE_OK;
    world->model.grains = memory_allocate_zeroed(&world->heap, count, sizeof *world->model.grains);
    if (!world->model.grains) return TULLE_ERROR_OUT_OF_MEMORY;
    for (size_t s = 0; s < count; s++) world->model.grains[s] = get_roughness(world, s).grain;
    return TULLE_OK;
}
