/* world/defs.c - default definitions and the checks of what users put into them. */
#include "world/defs.h"

#include "base/error.h"
#include "dynamics/cloth_model.h"
#include "geom/mesh.h"
#include "tulle/mesh.h"
#include "world/world_state.h"

#include <math.h>
#include <string.h>

/* [rad] 45 degrees. Seen along the axis of the cone, steeper triangles are hardly wider than the
 * reach of the certificate. So a wider cone loses more triangles than it gains. */
static const double PATCH_ANGLE_DEFAULT = 0.78539816339744831;
/* [rad] The widest cone that can be computed with: a right angle less a millionth. */
static const double PATCH_ANGLE_MAX = 1.5707963267948966 - 1e-6;
/* [kg/m^3] Half of air's density, 1.2 kg/m^3, times what a plate across the stream has, 1.17. */
static const double DRAG_DEFAULT = 0.7;

tulle_world_def tulle_world_def_default(void) {
    contact_settings const settings = default_contact_settings;
    return (tulle_world_def){
        .cookie = WORLD_DEF_COOKIE,
        .gravity = {0.0, 0.0, -9.81},
        .wind = {.gust_length = 0.5, .gust_time = 0.5, .seed = 1, .drag_coefficient = DRAG_DEFAULT},
        .integrator = TULLE_INTEGRATOR_IMPLICIT_EULER,
        .detection = {.method = TULLE_DETECT_PATCHES,
                      .cone = TULLE_CONE_BERNSTEIN,
                      .max_angle = PATCH_ANGLE_DEFAULT,
                      .has_certificate = 1},
        .response = TULLE_RESPONSE_COUPLED,
        .motion_space = TULLE_MOTION_SPACE_POLYHEDRAL,
        .membrane = TULLE_MEMBRANE_WOVEN,
        .on_overstretch = TULLE_ON_OVERSTRETCH_WARN,
        .quality = TULLE_QUALITY_NORMAL,
        .cg_tolerance = settings.cg_tolerance,
        .cg_max_iterations = settings.cg_max_iterations,
        .solve_rounds = settings.solve_rounds,
        .impulse_sweeps = settings.impulse_sweeps,
        .impact_rounds = settings.impact_rounds,
        .friction_cloth_cloth = 0.3,
        .dynamic_friction_cloth_cloth = -1.0,
        .start_intersections = TULLE_START_REFUSE,
        .untangle_limit = 2000,
        .on_pinch = TULLE_ON_PINCH_LAG,
        .sleep_time = 0.5,
    };
}

tulle_cloth_def tulle_cloth_def_default(void) {
    tulle_cloth_def def = {.cookie = CLOTH_DEF_COOKIE, .grain = {1.0, 0.0, 0.0}};
    (void)tulle_material_preset("cotton", &def.material);
    return def;
}

tulle_pin tulle_pin_default(void) {
    return (tulle_pin){.cookie = PIN_COOKIE, .release_time = (double)INFINITY};
}

tulle_obstacle_def tulle_obstacle_def_default(void) {
    return (tulle_obstacle_def){.cookie = OBSTACLE_DEF_COOKIE,
                                .friction = 0.3,
                                .dynamic_friction = -1.0,
                                .friction_across = 1.0,
                                .grain = {1.0, 0.0, 0.0},
                                .frame_interval = 1.0 / 24.0,
                                .appear_time = -(double)INFINITY,
                                .disappear_time = (double)INFINITY};
}

/* A grain shorter than this has no direction: its square would underflow. */
static const double SMALLEST_GRAIN = 1e-100;
/* A grain has no direction in a triangle where the sine of its angle to the normal is under this.
 */
static const double LEAST_GRAIN_SINE = 1e-6;

/* One number of a def with its allowed range, ends included. */
typedef struct range_check {
    const char *name, *unit;
    double value, low, high;
} range_check;

static tulle_status check_ranges(const range_check *checks, size_t count, const char *owner,
                                 tulle_error *error) {
    for (size_t i = 0; i < count; i++) {
        const range_check *const c = &checks[i];
        if (!(c->value >= c->low && c->value <= c->high)) {
            return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                             "%s: %s is %g%s%s; it must lie between %g and %g", owner, c->name,
                             c->value, c->unit[0] ? " " : "", c->unit, c->low, c->high);
        }
    }
    return TULLE_OK;
}

#define CHECK_RANGES(checks, owner, error)                                                         \
    check_ranges((checks), sizeof(checks) / sizeof *(checks), (owner), (error))

/* Largest sensible value [SI]. Beyond it doubles no longer resolve the contact distances. */
static const double LARGEST = 1e6;
static const double SMALLEST_POSITIVE = 1e-12;
/* Dynamic friction is at most the static one. Any negative value means: the same as the static
 * one. */
static tulle_status check_dynamic(const char *name, double dynamic, double friction,
                                  const char *owner, tulle_error *error) {
    if (dynamic <= friction) return TULLE_OK;
    return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                     "%s: %s is %g; it must be at most that of what does not slide, %g, or "
                     "negative for the same",
                     owner, name, dynamic, friction);
}

/* The value of an enum. The cast to int keeps a negative one negative where the enum's own type has
 * no sign. */
#define ENUM_VALUE(value) ((double)(int)(value))

tulle_status world_def_check(const tulle_world_def *def, tulle_error *error) {
    if (!def || def->cookie != WORLD_DEF_COOKIE) {
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "the world def was not made by tulle_world_def_default");
    }
    if (!allocator_is_whole(&def->allocator))
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "the allocator has only one of its functions; give both or neither");
    if (def->wind.gust_length == 0.0 && def->wind.gust_time == 0.0)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "world: wind gust length and wind gust time are 0; begin with the wind of "
                         "tulle_world_def_default, which has a drag coefficient, too");
    double const separation = def->separation_distance;
    range_check const checks[] = {
        {"gravity x", "m/s^2", def->gravity[0], -LARGEST, LARGEST},
        {"gravity y", "m/s^2", def->gravity[1], -LARGEST, LARGEST},
        {"gravity z", "m/s^2", def->gravity[2], -LARGEST, LARGEST},
        {"wind velocity x", "m/s", def->wind.velocity[0], -LARGEST, LARGEST},
        {"wind velocity y", "m/s", def->wind.velocity[1], -LARGEST, LARGEST},
        {"wind velocity z", "m/s", def->wind.velocity[2], -LARGEST, LARGEST},
        {"wind gust strength", "m/s", def->wind.gust_strength, 0.0, LARGEST},
        {"wind gust length", "m", def->wind.gust_length, 1e-6, LARGEST},
        {"wind gust time", "s", def->wind.gust_time, 1e-6, LARGEST},
        {"wind drag coefficient", "kg/m^3", def->wind.drag_coefficient, 0.0, LARGEST},
        {"contact distance", "m", def->contact_distance, 0.0, 1.0},
        {"separation distance", "m", separation, separation == 0.0 ? 0.0 : def->contact_distance,
         2.0},
        {"minimum gap", "m", def->minimum_gap, 0.0,
         def->contact_distance > 0.0 ? 0.5 * def->contact_distance : 0.5},
        {"membrane", "", ENUM_VALUE(def->membrane), 0.0, (double)TULLE_MEMBRANE_SPRINGS},
        {"on_overstretch", "", ENUM_VALUE(def->on_overstretch), 0.0,
         (double)TULLE_ON_OVERSTRETCH_STOP},
        {"quality", "", ENUM_VALUE(def->quality), 0.0, (double)TULLE_QUALITY_EXACT},
        {"CG tolerance", "", def->cg_tolerance, 1e-12, 1e-1},
        {"CG iteration limit", "", (double)def->cg_max_iterations, 1.0, 1e6},
        {"solve rounds", "", (double)def->solve_rounds, 1.0, 20.0},
        {"impulse sweeps", "", (double)def->impulse_sweeps, 1.0, 1000.0},
        {"impact rounds", "", (double)def->impact_rounds, 0.0, 100.0},
        {"friction between cloths", "", def->friction_cloth_cloth, 0.0, 10.0},
        {"integrator", "", ENUM_VALUE(def->integrator), 0.0, (double)TULLE_INTEGRATOR_BDF2},
        {"detection method", "", ENUM_VALUE(def->detection.method), 0.0,
         (double)TULLE_DETECT_PAPER},
        {"cone of patches", "", ENUM_VALUE(def->detection.cone), 0.0, (double)TULLE_CONE_PAPER},
        {"angle of patches", "rad", def->detection.max_angle, SMALLEST_POSITIVE, PATCH_ANGLE_MAX},
        {"response", "", ENUM_VALUE(def->response), 0.0, (double)TULLE_RESPONSE_PAPER},
        {"motion space", "", ENUM_VALUE(def->motion_space), 0.0,
         (double)TULLE_MOTION_SPACE_POLYHEDRAL},
        {"start_intersections", "", ENUM_VALUE(def->start_intersections), 0.0,
         (double)TULLE_START_UNTANGLE},
        {"untangle limit", "rounds", (double)def->untangle_limit, 1.0, 1e6},
        {"on_pinch", "", ENUM_VALUE(def->on_pinch), 0.0, (double)TULLE_ON_PINCH_LAG},
        {"threads", "", (double)def->threads, 0.0, 256.0},
        {"sleep speed", "m/s", def->sleep_speed, 0.0, 1000.0},
        {"sleep time", "s", def->sleep_time, SMALLEST_POSITIVE, LARGEST},
    };
    tulle_status const status = CHECK_RANGES(checks, "world", error);
    if (status != TULLE_OK) return status;
    if (def->sleep_speed > 0.0 && def->response != TULLE_RESPONSE_COUPLED)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "world: cloth sleeps with the coupled response alone; set sleep_speed to "
                         "0 for the paper's");
    return check_dynamic("dynamic friction between cloths", def->dynamic_friction_cloth_cloth,
                         def->friction_cloth_cloth, "world", error);
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
    range_check const checks[] = {
        {"grain x", "", g[0], -LARGEST, LARGEST},
        {"grain y", "", g[1], -LARGEST, LARGEST},
        {"grain z", "", g[2], -LARGEST, LARGEST},
    };
    tulle_status const status = CHECK_RANGES(checks, owner, error);
    if (status != TULLE_OK) return status;
    bool const is_isotropic =
        !(surface->friction_across < 1.0) && !(surface->friction_across > 1.0);
    if (is_isotropic || grain_lies_in_surface(surface->rest, vec3_load(g, 0))) return TULLE_OK;
    return error_set(
        error, TULLE_ERROR_INVALID_ARGUMENT,
        "%s: the grain is [%g, %g, %g], no direction in the %s; friction across it is %g, so "
        "give one in the surface of the rest shape",
        owner, g[0], g[1], g[2], surface->kind, surface->friction_across);
}

static tulle_status check_contact_material(const char *name, const char *owner,
                                           tulle_error *error) {
    if (!name) return TULLE_OK;
    size_t const length = strlen(name);
    if (length > 0 && length < WORLD_NAME_BYTES) return TULLE_OK;
    return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                     "%s: the name of the contact material has %zu bytes; it must have 1 to %d",
                     owner, length, WORLD_NAME_BYTES - 1);
}

static tulle_status check_pin(const tulle_cloth_def *def, size_t index, const char *owner,
                              tulle_error *error) {
    const tulle_pin *const pin = &def->pins[index];
    if (pin->cookie != PIN_COOKIE)
        return error_set(
            error, TULLE_ERROR_INVALID_ARGUMENT,
            "%s: pin %zu was not made by tulle_pin_default: a pin of zeros would let go "
            "at 0 s; begin with tulle_pin_default() and set the fields that matter",
            owner, index);
    if (pin->vertex_count > 0 && !pin->vertices)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "%s: pin %zu has %zu vertices, but their array is null", owner, index,
                         pin->vertex_count);
    for (size_t i = 0; i < pin->vertex_count; i++) {
        if (pin->vertices[i] >= def->mesh.vertex_count) {
            return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                             "%s: pin %zu names vertex %u; the mesh has %zu vertices", owner, index,
                             pin->vertices[i], def->mesh.vertex_count);
        }
    }
    if (isnan(pin->release_time)) {
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "%s: the release time of pin %zu is not a number", owner, index);
    }
    return motion_validate(&pin->motion, owner, error);
}

static tulle_status check_finite(const double *values, size_t count, const char *what,
                                 const char *owner, tulle_error *error) {
    for (size_t i = 0; values && i < count; i++) {
        if (!isfinite(values[i])) {
            return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                             "%s: the %s of vertex %zu is not finite", owner, what, i / 3);
        }
    }
    return TULLE_OK;
}

/* Triangles at rest may be as thin as those of a mesh. */
static tulle_status check_rest_corners(const tulle_cloth_def *def, const char *owner,
                                       tulle_error *error) {
    static const uint32_t corners[3] = {0, 1, 2};
    for (size_t t = 0; def->rest_corners && t < def->mesh.triangle_count; t++) {
        const double *const at = def->rest_corners + 9 * t;
        for (int i = 0; i < 9; i++)
            if (!(fabs(at[i]) <= LARGEST))
                return error_set(
                    error, TULLE_ERROR_INVALID_ARGUMENT,
                    "%s: corner %d of triangle %zu at rest has the coordinate %g m; it "
                    "must lie between %g and %g",
                    owner, i / 3, t, at[i], -LARGEST, LARGEST);
        double const ratio = triangle_get_height_ratio(at, corners);
        if (!(ratio >= THIN_TRIANGLE_RATIO))
            return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                             "%s: triangle %zu at rest is too thin: its height is %.3g of its "
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

static const double LARGEST_FOLD = 3.0; /* [rad]; sides folded onto each other have no normal */

static tulle_status check_warps(const tulle_cloth_def *def, const char *owner, tulle_error *error) {
    for (size_t t = 0; def->warps && t < def->mesh.triangle_count; t++) {
        double const length = vec3_norm(vec3_load(def->warps, t));
        if (length >= SMALLEST_GRAIN && length <= LARGEST) continue;
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "%s: the warp of triangle %zu has the length %g; it must lie between %g "
                         "and %g",
                         owner, t, length, SMALLEST_GRAIN, LARGEST);
    }
    return TULLE_OK;
}

/* Beyond, the matrix of the cloth is ill-conditioned, and something is mistaken. */
static const double LEAST_FACTOR = 0.01, LARGEST_FACTOR = 100.0;

static tulle_status check_factors(const tulle_cloth_def *def, const char *owner,
                                  tulle_error *error) {
    for (size_t t = 0; def->stiffness_factors && t < def->mesh.triangle_count; t++) {
        double const factor = def->stiffness_factors[t];
        if (factor >= LEAST_FACTOR && factor <= LARGEST_FACTOR) continue;
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "%s: the factor on the stiffness of triangle %zu is %g; it must lie "
                         "between %g and %g",
                         owner, t, factor, LEAST_FACTOR, LARGEST_FACTOR);
    }
    return TULLE_OK;
}

static tulle_status check_creases(const tulle_cloth_def *def, const char *owner,
                                  tulle_error *error) {
    if (def->crease_count > 0 && !def->creases)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "%s: %zu creases, and no array",
                         owner, def->crease_count);
    for (size_t i = 0; i < def->crease_count; i++) {
        const tulle_crease *const crease = &def->creases[i];
        size_t const count = def->mesh.vertex_count;
        if (crease->vertices[0] >= count || crease->vertices[1] >= count)
            return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                             "%s: crease %zu lies between vertices %u and %u; there are %zu", owner,
                             i, crease->vertices[0], crease->vertices[1], count);
        if (!(fabs(crease->angle) <= LARGEST_FOLD))
            return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                             "%s: the angle of crease %zu is %g; it must lie between %g and %g",
                             owner, i, crease->angle, -LARGEST_FOLD, LARGEST_FOLD);
    }
    return TULLE_OK;
}

tulle_status cloth_def_check(const tulle_cloth_def *def, tulle_membrane membrane, const char *owner,
                             tulle_error *error) {
    if (!def || def->cookie != CLOTH_DEF_COOKIE) {
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "%s: the def was not made by tulle_cloth_def_default", owner);
    }
    tulle_status status = tulle_mesh_validate(def->mesh, TULLE_MESH_ROLE_CLOTH, error);
    if (status == TULLE_OK && def->rest_positions) {
        tulle_mesh_view rest = def->mesh;
        rest.positions = def->rest_positions;
        status = tulle_mesh_validate(rest, TULLE_MESH_ROLE_CLOTH, error);
    }
    if (status == TULLE_OK) status = check_rest_corners(def, owner, error);
    if (status == TULLE_OK) status = check_rest_areas(def, owner, error);
    if (status != TULLE_OK) return status;
    size_t const value_count = 3 * def->mesh.vertex_count;
    status = material_validate(&def->material, membrane, owner, error);
    if (status == TULLE_OK)
        status = check_dynamic("dynamic friction", def->material.dynamic_friction,
                               def->material.friction, owner, error);
    if (status == TULLE_OK) {
        status = check_finite(def->velocities, value_count, "velocity", owner, error);
    }
    if (status == TULLE_OK) status = check_warps(def, owner, error);
    if (status == TULLE_OK) status = check_factors(def, owner, error);
    if (status == TULLE_OK) status = check_creases(def, owner, error);
    range_check const checks[] = {
        {"thickness", "m", def->thickness, 0.0, 1.0},
        {"velocity x", "m/s", def->velocity[0], -LARGEST, LARGEST},
        {"velocity y", "m/s", def->velocity[1], -LARGEST, LARGEST},
        {"velocity z", "m/s", def->velocity[2], -LARGEST, LARGEST},
    };
    if (status == TULLE_OK) status = CHECK_RANGES(checks, owner, error);
    grained_surface surface = {def->mesh, def->grain, def->material.friction_across, "cloth"};
    if (def->rest_positions) surface.rest.positions = def->rest_positions;
    if (status == TULLE_OK) status = check_grain(&surface, owner, error);
    if (status == TULLE_OK) status = check_contact_material(def->contact_material, owner, error);
    if (status == TULLE_OK && def->pin_count > 0 && !def->pins)
        status = error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                           "%s: it has %zu pins, but their array is null", owner, def->pin_count);
    for (size_t i = 0; status == TULLE_OK && i < def->pin_count; i++) {
        status = check_pin(def, i, owner, error);
    }
    return status;
}

/* A dynamic obstacle has exactly one of mass, density and area density. */
static tulle_status check_body(const tulle_obstacle_def *def, const char *owner,
                               tulle_error *error) {
    const tulle_body *const body = &def->body;
    if (!body->is_dynamic) return TULLE_OK;
    int const given = (body->mass != 0.0) + (body->density != 0.0) + (body->area_density != 0.0);
    if (given != 1) {
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "%s: a dynamic obstacle needs %s mass, density and area_density", owner,
                         given == 0 ? "one of" : "only one of");
    }
    range_check const checks[] = {
        {"mass", "kg", body->mass, body->mass == 0.0 ? 0.0 : SMALLEST_POSITIVE, 1e12},
        {"density", "kg/m^3", body->density, body->density == 0.0 ? 0.0 : SMALLEST_POSITIVE, 1e12},
        {"area density", "kg/m^2", body->area_density,
         body->area_density == 0.0 ? 0.0 : SMALLEST_POSITIVE, 1e12},
        {"velocity x", "m/s", body->velocity[0], -LARGEST, LARGEST},
        {"velocity y", "m/s", body->velocity[1], -LARGEST, LARGEST},
        {"velocity z", "m/s", body->velocity[2], -LARGEST, LARGEST},
        {"angular velocity x", "rad/s", body->angular_velocity[0], -LARGEST, LARGEST},
        {"angular velocity y", "rad/s", body->angular_velocity[1], -LARGEST, LARGEST},
        {"angular velocity z", "rad/s", body->angular_velocity[2], -LARGEST, LARGEST},
        {"linear damping", "1/s", body->linear_damping, 0.0, LARGEST},
        {"angular damping", "1/s", body->angular_damping, 0.0, LARGEST},
        {"sleep speed", "m/s", body->sleep_speed, 0.0, LARGEST},
        {"sleep time", "s", body->sleep_time, 0.0, LARGEST},
    };
    tulle_status const status = CHECK_RANGES(checks, owner, error);
    if (status != TULLE_OK) return status;
    if (def->read_frame) {
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "%s: a dynamic obstacle cannot follow a mesh sequence", owner);
    }
    if (body->sleep_speed > 0.0 && !(body->sleep_time > 0.0)) {
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "%s: the body has a sleep speed, so its sleep time must be over 0; 0.5 s "
                         "is usual",
                         owner);
    }
    if (isnan(body->start_time)) {
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "%s: the start time of the body is not a number", owner);
    }
    const tulle_motion *const motion = &def->motion;
    if (motion->keys && motion->key_count > 1 && body->start_time <= motion->keys[0].time)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "%s: the body is free from %g s on, its start_time, so it never follows "
                         "its motion, which begins at %g s; give a later start_time, or no motion",
                         owner, body->start_time, motion->keys[0].time);
    for (int k = 0; motion->keys && motion->key_count > 1 && k < 3; k++)
        if (body->velocity[k] != 0.0 || body->angular_velocity[k] != 0.0)
            return error_set(
                error, TULLE_ERROR_INVALID_ARGUMENT,
                "%s: the body has a velocity and a motion; at its start_time, %g s, it "
                "goes on as the motion, from %g s on, had it; leave the velocity out",
                owner, body->start_time, motion->keys[0].time);
    return TULLE_OK;
}

tulle_status obstacle_def_check(const tulle_obstacle_def *def, const char *owner,
                                tulle_error *error) {
    if (!def || def->cookie != OBSTACLE_DEF_COOKIE) {
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "%s: the def was not made by tulle_obstacle_def_default", owner);
    }
    bool const deforms = def->read_frame || def->drive == TULLE_DRIVE_DEFORMING;
    tulle_status status = tulle_mesh_validate(
        def->mesh, deforms ? TULLE_MESH_ROLE_DEFORMING : TULLE_MESH_ROLE_OBSTACLE, error);
    if (status != TULLE_OK) return status;
    if (def->read_frame) {
        range_check const checks[] = {
            {"frame count", "", (double)def->frame_count, 1.0, 1e9},
            {"frame start time", "s", def->frame_start_time, -LARGEST, LARGEST},
            {"frame interval", "s", def->frame_interval, 1e-9, LARGEST},
        };
        status = CHECK_RANGES(checks, owner, error);
        if (status != TULLE_OK) return status;
        if (def->motion.key_count > 0) {
            return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                             "%s: has both keyframes and a mesh sequence; give one", owner);
        }
    }
    if (def->drive != TULLE_DRIVE_NONE &&
        (def->motion.key_count > 0 || def->read_frame || def->body.is_dynamic))
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "%s: the host drives it, so it can have no keyframes, no mesh sequence "
                         "and no body",
                         owner);
    if (isnan(def->appear_time) || isnan(def->disappear_time) ||
        def->disappear_time <= def->appear_time) {
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "%s: disappears at %g s, which must come after it appears at %g s", owner,
                         def->disappear_time, def->appear_time);
    }
    range_check const checks[] = {
        {"friction", "", def->friction, 0.0, 10.0},
        {"friction across", "", def->friction_across, 0.0, 10.0},
        {"restitution", "", def->restitution, 0.0, 1.0},
        {"drive", "", ENUM_VALUE(def->drive), 0.0, (double)TULLE_DRIVE_DEFORMING},
    };
    status = CHECK_RANGES(checks, owner, error);
    grained_surface const surface = {def->mesh, def->grain, def->friction_across, "obstacle"};
    if (status == TULLE_OK) status = check_grain(&surface, owner, error);
    if (status == TULLE_OK) status = check_contact_material(def->contact_material, owner, error);
    if (status == TULLE_OK)
        status =
            check_dynamic("dynamic friction", def->dynamic_friction, def->friction, owner, error);
    if (status == TULLE_OK) status = motion_validate(&def->motion, owner, error);
    if (status == TULLE_OK) status = check_body(def, owner, error);
    return status;
}

tulle_status contact_law_check(const tulle_contact_law *law, const char *owner,
                               tulle_error *error) {
    range_check const checks[] = {
        {"static friction", "", law->static_friction, 0.0, 10.0},
        {"restitution", "", law->restitution, 0.0, 1.0},
    };
    tulle_status const status = CHECK_RANGES(checks, owner, error);
    if (status != TULLE_OK) return status;
    return check_dynamic("dynamic friction", law->dynamic_friction, law->static_friction, owner,
                         error);
}
