/* geom/shapes_check.c - ranges of a shape's fields, the values that 0 leaves open, and how fields
 * must fit together. Every message names the shape, the field, its value and what is allowed. */
#include "base/error.h"
#include "geom/shapes.h"

/* [m] Lengths far from these have no use in a scene of cloth, and would cost digits. */
static const double LENGTH_MIN = 1e-6, LENGTH_MAX = 1e6;
static const double FULL_TURN = 6.283185307179586; /* [rad] */
/* Edges along a side of default cloth: some 2,500 vertices. */
static const double DEFAULT_EDGES = 50.0;

/* The shapes of a group. */
#define GROUNDS (SHAPE_BIT(BUMPY_GROUND) | SHAPE_BIT(CRESTED_GROUND))
#define WAVED (GROUNDS | SHAPE_BIT(TILE))
#define SOLIDS (SHAPE_BIT(BOX) | SHAPE_BIT(TILE))
#define HEADED (SHAPE_BIT(NAIL) | SHAPE_BIT(SCEPTRE))
#define SIZED                                                                                      \
    (SHAPE_BIT(RECTANGLE) | SHAPE_BIT(RIBBON) | SHAPE_BIT(NET) | SHAPE_BIT(PLANE) | GROUNDS |      \
     SOLIDS)
#define HIGH                                                                                       \
    (SHAPE_BIT(TUBE) | SHAPE_BIT(CYLINDER) | SHAPE_BIT(CONE) | SHAPE_BIT(NEEDLE) |                 \
     SHAPE_BIT(TETRAHEDRON) | HEADED | WAVED)
#define TURNED                                                                                     \
    (SHAPE_BIT(TUBE) | SHAPE_BIT(HEMISPHERE) | SHAPE_BIT(CYLINDER) | SHAPE_BIT(CONE) |             \
     SHAPE_BIT(NEEDLE) | SHAPE_BIT(TORUS) | HEADED)
#define ALL_SHAPES ((UINT32_C(1) << TULLE_SHAPE_COUNT) - 1)

/* A length: its name, place in the def, the shapes that use it, and whether 0 is a default. */
typedef struct length_field {
    const char *name;
    size_t offset;
    uint32_t shapes;
    bool may_be_zero;
} length_field;

#define OFFSET(field) offsetof(tulle_shape_def, field)
static const length_field length_fields[] = {
    {"size[0]", OFFSET(size), SIZED, false},
    {"size[1]", OFFSET(size) + sizeof(double), SIZED, false},
    {"size[2]", OFFSET(size) + 2 * sizeof(double), SOLIDS, false},
    {"radius", OFFSET(radius), ALL_SHAPES & ~(uint32_t)SIZED, false},
    {"inner_radius", OFFSET(inner_radius), SHAPE_BIT(CAPE) | SHAPE_BIT(TORUS), true},
    {"height", OFFSET(height), HIGH, false},
    {"tip_height", OFFSET(tip_height), SHAPE_BIT(NEEDLE), true},
    {"head_radius", OFFSET(head_radius), HEADED, true},
    {"head_height", OFFSET(head_height), SHAPE_BIT(NAIL), true},
    {"strand", OFFSET(strand), SHAPE_BIT(NET), true},
    {"wavelength", OFFSET(wavelength), WAVED, true},
};

static bool has_shape(uint32_t set, const tulle_shape_def *def) {
    return (set >> (unsigned)def->shape & 1) != 0;
}

static tulle_status check_lengths(const tulle_shape_def *def, tulle_error *error) {
    for (size_t i = 0; i < sizeof length_fields / sizeof length_fields[0]; i++) {
        const length_field *const field = &length_fields[i];
        if (!has_shape(field->shapes, def)) continue;
        double const value = *(const double *)((const char *)def + field->offset);
        if ((field->may_be_zero && value == 0.0) || (value >= LENGTH_MIN && value <= LENGTH_MAX))
            continue;
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "%s: %s is %g m; it must be %sbetween %g and %g m",
                         tulle_shape_name(def->shape), field->name, value,
                         field->may_be_zero ? "0 (chosen from the other lengths) or " : "",
                         LENGTH_MIN, LENGTH_MAX);
    }
    return TULLE_OK;
}

static tulle_status check_resolution(const tulle_shape_def *def, tulle_error *error) {
    if (has_shape(SHAPE_BIT(NET) | SHAPE_BIT(TETRAHEDRON), def)) return TULLE_OK;
    for (int k = 0; k < 2; k++) {
        bool const is_closed = (k == 0 && has_shape(TURNED, def)) ||
                               (k == 1 && has_shape(SHAPE_BIT(TORUS) | SHAPE_BIT(DISC), def));
        uint32_t const least = is_closed ? 3 : 2;
        if (def->resolution[k] == 0 || def->resolution[k] >= least) continue;
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "%s: resolution[%d] is %u; it must be 0 (chosen from the lengths) or at "
                         "least %u",
                         tulle_shape_name(def->shape), k, def->resolution[k], least);
    }
    return TULLE_OK;
}

static tulle_status check_net(const tulle_shape_def *def, tulle_error *error) {
    for (int k = 0; k < 2; k++)
        if (def->cells[k] < 1)
            return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                             "net: cells[%d] is 0; a net has at least 1 hole along each side", k);
    if (def->strand_resolution < 1)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "net: strand_resolution is 0; it must be at least 1");
    return TULLE_OK;
}

tulle_status shape_check_def(const tulle_shape_def *def, tulle_error *error) {
    tulle_status status = check_lengths(def, error);
    if (status == TULLE_OK) status = check_resolution(def, error);
    if (status == TULLE_OK && def->shape == TULLE_SHAPE_NET) status = check_net(def, error);
    /* The narrowest sector is one that a triangle can still fill. */
    if (status == TULLE_OK && def->shape == TULLE_SHAPE_CAPE &&
        !(def->angle >= 1e-6 && def->angle <= FULL_TURN))
        status = error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                           "cape: angle is %g rad; it must be between 1e-06 and 2 pi", def->angle);
    return status;
}

/* Sets resolution[k] to `edges` edges, `extra` more vertices, where it is open. */
static void derive_resolution(tulle_shape_def *def, int k, double edges, uint32_t extra) {
    if (def->resolution[k] != 0) return;
    double const count = fmin(fmax(ceil(edges - 0.5), 1.0), 4e9) + extra;
    def->resolution[k] = (uint32_t)count;
}

static void derive_least(tulle_shape_def *def, uint32_t first, uint32_t second) {
    if (def->resolution[0] == 0) def->resolution[0] = first;
    if (def->resolution[1] == 0) def->resolution[1] = second;
}

static void derive_length(double *length, double value) {
    if (*length == 0.0) *length = value;
}

/* Resolutions that give edges of about the same length everywhere. */
static void derive_cloth(tulle_shape_def *def) {
    double const radius = def->radius;
    double area = def->size[0] * def->size[1];
    if (def->shape == TULLE_SHAPE_TUBE) area = FULL_TURN * radius * def->height;
    if (def->shape == TULLE_SHAPE_CAPE)
        area = 0.5 * def->angle * fabs(radius * radius - def->inner_radius * def->inner_radius);
    double const edge = sqrt(area) / DEFAULT_EDGES;
    switch (def->shape) {
    case TULLE_SHAPE_DISC:
        if (def->resolution[1] != 0)
            derive_resolution(def, 0, fmax(2.0, def->resolution[1] / FULL_TURN), 0);
        derive_resolution(def, 0, DEFAULT_EDGES / sqrt(0.5 * FULL_TURN), 0);
        derive_resolution(def, 1, FULL_TURN * def->resolution[0], 0);
        break;
    case TULLE_SHAPE_TUBE:
        derive_resolution(def, 0, fmax(3.0, FULL_TURN * radius / edge), 0);
        derive_resolution(def, 1, def->height / edge, 1);
        break;
    case TULLE_SHAPE_CAPE:
        derive_resolution(def, 0, radius * def->angle / edge, 1);
        derive_resolution(def, 1, fabs(radius - def->inner_radius) / edge, 1);
        break;
    default:
        derive_resolution(def, 0, def->size[0] / edge, 1);
        derive_resolution(def, 1, def->size[1] / edge, 1);
        break;
    }
}

/* Ground and tile: twelve edges a wave keep bumps round. */
static void derive_waves(tulle_shape_def *def) {
    double const shorter = fmin(def->size[0], def->size[1]);
    derive_length(&def->wavelength, shorter / (def->shape == TULLE_SHAPE_TILE ? 4.0 : 8.0));
    bool const is_crested = def->shape == TULLE_SHAPE_CRESTED_GROUND;
    double const edge = def->wavelength / 12.0;
    derive_resolution(def, 0, def->size[0] / (is_crested ? def->wavelength / 2.0 : edge), 1);
    derive_resolution(def, 1, is_crested ? 1.0 : def->size[1] / edge, 1);
}

void shape_derive_def(tulle_shape_def *def) {
    switch (def->shape) {
    case TULLE_SHAPE_CAPE:
        derive_length(&def->inner_radius, 0.2 * def->radius);
        derive_cloth(def);
        break;
    case TULLE_SHAPE_NET:
        /* A fifth of a hole and its strand. */
        derive_length(&def->strand, 0.2 * fmin(def->size[0] / (def->cells[0] + 1.0),
                                               def->size[1] / (def->cells[1] + 1.0)));
        break;
    case TULLE_SHAPE_PLANE:
    case TULLE_SHAPE_BOX: derive_least(def, 2, 2); break;
    case TULLE_SHAPE_SPHERE: derive_least(def, 16, 2); break;
    case TULLE_SHAPE_HEMISPHERE:
        derive_least(def, 64, 0);
        derive_resolution(def, 1, fmax(2.0, def->resolution[0] / 4.0), 0);
        break;
    case TULLE_SHAPE_CYLINDER: derive_least(def, 48, 2); break;
    case TULLE_SHAPE_CONE: derive_least(def, 32, 2); break;
    case TULLE_SHAPE_NEEDLE:
        derive_length(&def->tip_height, 0.4 * def->height);
        derive_least(def, 8, 4);
        break;
    case TULLE_SHAPE_TORUS:
        derive_length(&def->inner_radius, 0.2 * def->radius);
        derive_least(def, 64, 20);
        break;
    case TULLE_SHAPE_NAIL:
        derive_length(&def->head_radius, 2.5 * def->radius);
        derive_length(&def->head_height, fmin(def->radius, 0.25 * def->height));
        derive_least(def, 16, 4);
        break;
    case TULLE_SHAPE_SCEPTRE:
        derive_length(&def->head_radius, 2.5 * def->radius);
        derive_least(def, 16, 4);
        break;
    case TULLE_SHAPE_BUMPY_GROUND:
    case TULLE_SHAPE_CRESTED_GROUND:
    case TULLE_SHAPE_TILE: derive_waves(def); break;
    case TULLE_SHAPE_TETRAHEDRON: break;
    default: derive_cloth(def); break;
    }
}

/* `small` must be below `large`. */
static tulle_status check_below(const tulle_shape_def *def, const char *small_name, double small,
                                const char *large_name, double large, tulle_error *error) {
    if (small < large) return TULLE_OK;
    return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                     "%s: %s is %g m; it must be less than %s, which is %g m",
                     tulle_shape_name(def->shape), small_name, small, large_name, large);
}

static tulle_status check_strands(const tulle_shape_def *def, tulle_error *error) {
    for (int k = 0; k < 2; k++) {
        double const strands = def->strand * (def->cells[k] + 1.0);
        /* A hole narrower than a millionth of the strand is none. */
        if (def->size[k] - strands >= 1e-6 * def->strand * def->cells[k]) continue;
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "net: %.15g strands of %g m fill %g m, but size[%d] is %g m; choose fewer "
                         "cells or a thinner strand",
                         def->cells[k] + 1.0, def->strand, strands, k, def->size[k]);
    }
    return TULLE_OK;
}

tulle_status shape_check_fit(const tulle_shape_def *def, tulle_error *error) {
    tulle_status status = TULLE_OK;
    switch (def->shape) {
    case TULLE_SHAPE_CAPE:
    case TULLE_SHAPE_TORUS:
        return check_below(def, "inner_radius", def->inner_radius, "radius", def->radius, error);
    case TULLE_SHAPE_NEEDLE:
        return check_below(def, "tip_height", def->tip_height, "height", def->height, error);
    case TULLE_SHAPE_NAIL:
        status = check_below(def, "radius", def->radius, "head_radius", def->head_radius, error);
        if (status != TULLE_OK) return status;
        return check_below(def, "head_height", def->head_height, "height", def->height, error);
    case TULLE_SHAPE_SCEPTRE:
        status = check_below(def, "radius", def->radius, "head_radius", def->head_radius, error);
        if (status != TULLE_OK) return status;
        return check_below(def, "head_radius", def->head_radius, "half of height",
                           0.5 * def->height, error);
    case TULLE_SHAPE_NET: return check_strands(def, error);
    default: return TULLE_OK;
    }
}
