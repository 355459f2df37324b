/* world/defs.c - default definitions and the checks of what users put into them. */
#include "world/defs.h"

#include "base/error.h"
#include "base/hash.h"
#include "geom/mesh.h"
#include "tulle/mesh.h"
#include "tulle/paper.h"
#include "world/fields/fields.h"
#include "world/world_state.h"

#include <math.h>
#include <string.h>

tulle_world_def tulle_world_def_default(void) {
    tulle_world_def def;
    fields_set_defaults(&world_def_fields, &def);
    return def;
}

tulle_paper_options tulle_paper_options_default(void) {
    tulle_paper_options options;
    fields_set_defaults(&paper_options_fields, &options);
    return options;
}

tulle_cloth_def tulle_cloth_def_default(void) {
    tulle_cloth_def def;
    fields_set_defaults(&cloth_def_fields, &def);
    (void)tulle_material_preset("cotton", &def.material);
    return def;
}

tulle_pin tulle_pin_default(void) {
    tulle_pin pin;
    fields_set_defaults(&pin_fields, &pin);
    return pin;
}

tulle_obstacle_def tulle_obstacle_def_default(void) {
    tulle_obstacle_def def;
    fields_set_defaults(&obstacle_def_fields, &def);
    return def;
}

/* A grain shorter than this has no direction: its square would underflow. */
static const double SMALLEST_GRAIN = 1e-100;
/* A grain has no direction in a triangle where the sine of its angle to the normal is under this.
 */
static const double LEAST_GRAIN_SINE = 1e-6;

#define REFUSE(...) error_set(error, TULLE_ERROR_INVALID_ARGUMENT, __VA_ARGS__)

/* Dynamic friction is at most the static one. Any negative value means: the same as the static
 * one. */
static tulle_status check_dynamic(const char *name, double dynamic, double friction,
                                  const char *owner, tulle_error *error) {
    if (dynamic <= friction) return TULLE_OK;
    return REFUSE(
        "%s: %s is %g; dynamic friction may not exceed static friction, %g. A negative value "
        "means: the same",
        owner, name, dynamic, friction);
}

uint64_t world_def_hash(const tulle_world_def *def) {
    return fields_hash(
        &world_def_fields, def,
        " integrator detection on_overstretch quality cg_tolerance cg_max_iterations "
        "solve_rounds impulse_sweeps impact_rounds start_intersections "
        "untangle_limit on_pinch ",
        HASH_SEED);
}

tulle_status world_def_check(const tulle_world_def *def, tulle_error *error) {
    if (!def || def->cookie != world_def_fields.cookie)
        return REFUSE("the world def was not made by tulle_world_def_default");
    if (!allocator_is_whole(&def->allocator))
        return REFUSE("the allocator has only one of its functions; give both or neither");
    if (def->paper && def->paper->cookie != paper_options_fields.cookie)
        return REFUSE("world: `paper` was not made by tulle_paper_options_default");
    if (def->wind.gust_length == 0.0 && def->wind.gust_time == 0.0)
        return REFUSE("world: wind.gust_length and wind.gust_time are 0; begin with the wind of "
                      "tulle_world_def_default, which has a drag coefficient, too");
    tulle_status const status = fields_check(&world_def_fields, def, "world", NULL, error);
    if (status != TULLE_OK) return status;
    if (def->separation_distance > 0.0 && def->separation_distance < def->contact_distance)
        return REFUSE("world: separation_distance is %g m; it must be 0, or at least "
                      "contact_distance, %g m",
                      def->separation_distance, def->contact_distance);
    if (def->contact_distance > 0.0 && def->minimum_gap > 0.5 * def->contact_distance)
        return REFUSE("world: minimum_gap is %g m; it must be at most half of contact_distance, "
                      "%g m",
                      def->minimum_gap, 0.5 * def->contact_distance);
    if (def->sleep_speed > 0.0 && def->paper && def->paper->response != TULLE_RESPONSE_COUPLED)
        return REFUSE("world: cloth sleeps with the coupled response alone; set sleep_speed to 0 "
                      "for the paper's");
    return check_dynamic("dynamic_friction_cloth_cloth", def->dynamic_friction_cloth_cloth,
                         def->friction_cloth_cloth, "world", error);
}

/* [1/m] Largest hysteresis of bending over rigidity, and over stiffness of shear: far beyond cloth,
 * whose loops are narrower than the range of the test. */
static const double LARGEST_BEND_WIDTH = 1e6, LARGEST_SHEAR_WIDTH = 2.0;

/* What values of woven cloth ask of each other. Without the bound on shear a state could have less
 * energy than cloth at rest. */
static tulle_status check_woven(const tulle_material *m, const char *owner, tulle_error *error) {
    double const most = sqrt(m->warp.stiffness * m->weft.stiffness);
    if (m->bend_hysteresis_warp > LARGEST_BEND_WIDTH * m->bend_warp ||
        m->bend_hysteresis_weft > LARGEST_BEND_WIDTH * m->bend_weft)
        return REFUSE(
            "%s: bend_hysteresis_warp is %g N and bend_hysteresis_weft %g N; they must be "
            "at most %g and %g, which is 1e6 1/m times bend_warp and bend_weft",
            owner, m->bend_hysteresis_warp, m->bend_hysteresis_weft,
            LARGEST_BEND_WIDTH * m->bend_warp, LARGEST_BEND_WIDTH * m->bend_weft);
    if (m->shear_hysteresis > LARGEST_SHEAR_WIDTH * m->shear.stiffness)
        return REFUSE("%s: shear_hysteresis is %g N/m; it must be at most %g, twice the stiffness "
                      "of shear",
                      owner, m->shear_hysteresis, LARGEST_SHEAR_WIDTH * m->shear.stiffness);
    if (m->shear.stiffness <= most) return TULLE_OK;
    return REFUSE("%s: shear.stiffness is %g N/m; it must be at most %g, the geometric mean of the "
                  "stiffness of warp and weft",
                  owner, m->shear.stiffness, most);
}

tulle_status material_check(const tulle_material *material, tulle_membrane membrane,
                            const char *owner, tulle_error *error) {
    bool const is_woven = membrane == TULLE_MEMBRANE_WOVEN;
    if (material->area_density == 0.0)
        return REFUSE("%s: area_density is 0 kg/m^2; it must be above that. Begin with a preset "
                      "(tulle_material_preset): a value that is left at 0 is 0",
                      owner);
    tulle_status status = fields_check(&material_fields, material, owner,
                                       is_woven ? "cloth of springs" : "woven cloth", error);
    if (status == TULLE_OK && is_woven) status = check_woven(material, owner, error);
    if (status != TULLE_OK) return status;
    return check_dynamic("dynamic_friction", material->dynamic_friction, material->friction, owner,
                         error);
}

/* Whether the grain has a direction in the surface of the rest shape, on one triangle at least. */
static bool grain_lies_in_surface(tulle_mesh_view rest, vec3 grain) {
    if (!(vec3_norm(grain) >= SMALLEST_GRAIN)) return false;
    for (size_t t = 0; t < rest.triangle_count; t++) {
        const uint32_t *const corner = rest.triangles + 3 * t;
        vec3 const origin = vec3_load(rest.positions, corner[0]);
        vec3 const normal = vec3_cross(vec3_sub(vec3_load(rest.positions, corner[1]), origin),
                                       vec3_sub(vec3_load(rest.positions, corner[2]), origin));
        vec3 const across = vec3_cross(vec3_normalize(normal), vec3_normalize(grain));
        if (vec3_norm(across) > LEAST_GRAIN_SINE) return true;
    }
    return false;
}

/* A surface whose friction may have a direction. */
typedef struct grained_surface {
    tulle_mesh_view rest;
    const double *grain;
    double friction_across;
    const char *kind; /* "cloth" or "obstacle" */
} grained_surface;

/* A grain must have a direction only where friction depends on it. */
static tulle_status check_grain(const grained_surface *surface, const char *owner,
                                tulle_error *error) {
    const double *const g = surface->grain;
    bool const is_isotropic =
        !(surface->friction_across < 1.0) && !(surface->friction_across > 1.0);
    if (is_isotropic || grain_lies_in_surface(surface->rest, vec3_load(g, 0))) return TULLE_OK;
    return REFUSE(
        "%s: the grain is [%g, %g, %g], no direction in the %s; friction across it is %g, so "
        "give one in the surface of the rest shape",
        owner, g[0], g[1], g[2], surface->kind, surface->friction_across);
}

static tulle_status check_contact_material(const char *name, const char *owner,
                                           tulle_error *error) {
    if (!name) return TULLE_OK;
    size_t const length = strlen(name);
    if (length > 0 && length < WORLD_NAME_BYTES) return TULLE_OK;
    return REFUSE("%s: the name of the contact material has %zu bytes; it must have 1 to %d", owner,
                  length, WORLD_NAME_BYTES - 1);
}

static tulle_status check_pin(const tulle_cloth_def *def, size_t index, const char *owner,
                              tulle_error *error) {
    const tulle_pin *const pin = &def->pins[index];
    if (pin->cookie != pin_fields.cookie)
        return REFUSE("%s: pin %zu was not made by tulle_pin_default: a pin of zeros would let go "
                      "at 0 s; begin with tulle_pin_default() and set the fields that matter",
                      owner, index);
    if (pin->vertex_count > 0 && !pin->vertices)
        return REFUSE("%s: pin %zu has %zu vertices, but their array is null", owner, index,
                      pin->vertex_count);
    for (size_t i = 0; i < pin->vertex_count; i++) {
        if (pin->vertices[i] >= def->mesh.vertex_count) {
            return REFUSE("%s: pin %zu names vertex %u; the mesh has %zu vertices", owner, index,
                          pin->vertices[i], def->mesh.vertex_count);
        }
    }
    return motion_validate(&pin->motion, owner, error);
}

/* Triangles at rest may be as thin as those of a mesh. */
static tulle_status check_rest_corners(const tulle_cloth_def *def, const char *owner,
                                       tulle_error *error) {
    static const uint32_t corners[3] = {0, 1, 2};
    for (size_t t = 0; def->rest_corners && t < def->mesh.triangle_count; t++) {
        const double *const at = def->rest_corners + 9 * t;
        double const ratio = triangle_get_height_ratio(at, corners);
        if (!(ratio >= THIN_TRIANGLE_RATIO))
            return REFUSE("%s: triangle %zu at rest is too thin: its height is %.3g of its "
                          "longest edge, the least is %g",
                          owner, t, ratio, THIN_TRIANGLE_RATIO);
    }
    return TULLE_OK;
}

/* [m^2] of a triangle at rest. Less is a wrong unit or scale, and masses would underflow. */
static const double LEAST_AREA = 1e-18;

static tulle_status check_rest_areas(const tulle_cloth_def *def, const char *owner,
                                     tulle_error *error) {
    const double *const positions = def->rest_positions ? def->rest_positions : def->mesh.positions;
    for (size_t t = 0; t < def->mesh.triangle_count; t++) {
        vec3 corners[3];
        for (size_t k = 0; k < 3; k++)
            corners[k] = def->rest_corners ? vec3_load(def->rest_corners, 3 * t + k)
                                           : vec3_load(positions, def->mesh.triangles[3 * t + k]);
        vec3 const normal =
            vec3_cross(vec3_sub(corners[1], corners[0]), vec3_sub(corners[2], corners[0]));
        double const area = 0.5 * vec3_norm(normal);
        if (!(area >= LEAST_AREA))
            return error_set(error, TULLE_ERROR_INVALID_MESH,
                             "%s: triangle %zu has an area of %g m^2 in the rest shape; the least "
                             "is %g: is its unit right, or its scale?",
                             owner, t, area, LEAST_AREA);
    }
    return TULLE_OK;
}

static tulle_status check_warps(const tulle_cloth_def *def, const char *owner, tulle_error *error) {
    for (size_t t = 0; def->warps && t < def->mesh.triangle_count; t++) {
        double const length = vec3_norm(vec3_load(def->warps, t));
        if (length >= SMALLEST_GRAIN) continue;
        return REFUSE("%s: the warp of triangle %zu has the length %g; it must be at least %g",
                      owner, t, length, SMALLEST_GRAIN);
    }
    return TULLE_OK;
}

static tulle_status check_creases(const tulle_cloth_def *def, const char *owner,
                                  tulle_error *error) {
    for (size_t i = 0; i < def->crease_count; i++) {
        const tulle_crease *const crease = &def->creases[i];
        size_t const count = def->mesh.vertex_count;
        if (crease->vertices[0] >= count || crease->vertices[1] >= count)
            return REFUSE("%s: crease %zu lies between vertices %u and %u; there are %zu", owner, i,
                          crease->vertices[0], crease->vertices[1], count);
    }
    return TULLE_OK;
}

tulle_status cloth_def_check(const tulle_cloth_def *def, tulle_membrane membrane, const char *owner,
                             tulle_error *error) {
    if (!def || def->cookie != cloth_def_fields.cookie)
        return REFUSE("%s: the def was not made by tulle_cloth_def_default", owner);
    tulle_status status = tulle_mesh_validate(def->mesh, TULLE_MESH_ROLE_CLOTH, error);
    if (status == TULLE_OK && def->rest_positions) {
        tulle_mesh_view rest = def->mesh;
        rest.positions = def->rest_positions;
        status = tulle_mesh_validate(rest, TULLE_MESH_ROLE_CLOTH, error);
    }
    for (size_t i = 0; status == TULLE_OK && def->pins && i < def->pin_count; i++)
        status = check_pin(def, i, owner, error);
    if (status == TULLE_OK) status = material_check(&def->material, membrane, owner, error);
    if (status == TULLE_OK) status = fields_check(&cloth_def_fields, def, owner, "material", error);
    if (status == TULLE_OK) status = check_rest_corners(def, owner, error);
    if (status == TULLE_OK) status = check_rest_areas(def, owner, error);
    if (status == TULLE_OK) status = check_warps(def, owner, error);
    if (status == TULLE_OK) status = check_creases(def, owner, error);
    grained_surface surface = {def->mesh, def->grain, def->material.friction_across, "cloth"};
    if (def->rest_positions) surface.rest.positions = def->rest_positions;
    if (status == TULLE_OK) status = check_grain(&surface, owner, error);
    return status == TULLE_OK ? check_contact_material(def->contact_material, owner, error)
                              : status;
}

/* A dynamic obstacle has exactly one of mass, density and area density. */
static tulle_status check_body(const tulle_obstacle_def *def, const char *owner,
                               tulle_error *error) {
    const tulle_body *const body = &def->body;
    if (!body->is_dynamic) return TULLE_OK;
    int const given = (body->mass != 0.0) + (body->density != 0.0) + (body->area_density != 0.0);
    if (given != 1)
        return REFUSE("%s: a dynamic obstacle needs %s mass, density and area_density", owner,
                      given == 0 ? "one of" : "only one of");
    if (def->read_frame)
        return REFUSE("%s: a dynamic obstacle cannot follow a mesh sequence", owner);
    if (body->sleep_speed > 0.0 && !(body->sleep_time > 0.0))
        return REFUSE("%s: with a sleep_speed, sleep_time must be above 0; 0.5 s is usual", owner);
    const tulle_motion *const motion = &def->motion;
    if (motion->keys && motion->key_count > 1 && body->start_time <= motion->keys[0].time)
        return REFUSE("%s: the body is free from %g s on, its start_time, so it never follows "
                      "its motion, which begins at %g s; give a later start_time, or no motion",
                      owner, body->start_time, motion->keys[0].time);
    for (int k = 0; motion->keys && motion->key_count > 1 && k < 3; k++)
        if (body->velocity[k] != 0.0 || body->angular_velocity[k] != 0.0)
            return REFUSE("%s: the body has a velocity and a motion, which begins at %g s; at its "
                          "start_time, %g s, it keeps the velocity of that motion; leave its own "
                          "velocity out",
                          owner, motion->keys[0].time, body->start_time);
    return TULLE_OK;
}

tulle_status obstacle_def_check(const tulle_obstacle_def *def, const char *owner,
                                tulle_error *error) {
    if (!def || def->cookie != obstacle_def_fields.cookie)
        return REFUSE("%s: the def was not made by tulle_obstacle_def_default", owner);
    bool const deforms = def->read_frame || def->drive == TULLE_DRIVE_DEFORMING;
    tulle_status status = tulle_mesh_validate(
        def->mesh, deforms ? TULLE_MESH_ROLE_DEFORMING : TULLE_MESH_ROLE_OBSTACLE, error);
    if (status == TULLE_OK) status = motion_validate(&def->motion, owner, error);
    if (status == TULLE_OK) status = fields_check(&obstacle_def_fields, def, owner, NULL, error);
    if (status != TULLE_OK) return status;
    if (def->read_frame && def->frame_count == 0)
        return REFUSE("%s: its mesh sequence has no frames; give frame_count", owner);
    if (def->read_frame && def->motion.key_count > 0)
        return REFUSE("%s: has both keyframes and a mesh sequence; give one", owner);
    if (def->drive != TULLE_DRIVE_NONE &&
        (def->motion.key_count > 0 || def->read_frame || def->body.is_dynamic))
        return REFUSE("%s: the host drives it, so it can have no keyframes, no mesh sequence "
                      "and no body",
                      owner);
    if (def->disappear_time <= def->appear_time)
        return REFUSE("%s: disappears at %g s, which must come after it appears at %g s", owner,
                      def->disappear_time, def->appear_time);
    grained_surface const surface = {def->mesh, def->grain, def->friction_across, "obstacle"};
    status = check_grain(&surface, owner, error);
    if (status == TULLE_OK) status = check_contact_material(def->contact_material, owner, error);
    if (status == TULLE_OK)
        status =
            check_dynamic("dynamic_friction", def->dynamic_friction, def->friction, owner, error);
    return status == TULLE_OK ? check_body(def, owner, error) : status;
}

tulle_status contact_law_check(const tulle_contact_law *law, const char *owner,
                               tulle_error *error) {
    tulle_status const status = fields_check(&contact_law_fields, law, owner, NULL, error);
    if (status != TULLE_OK) return status;
    return check_dynamic("dynamic_friction", law->dynamic_friction, law->static_friction, owner,
                         error);
}
