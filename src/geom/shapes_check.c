/* geom/shapes_check.c - ranges of a shape's fields, the values that 0 leaves open, and how fields
 * must fit together; fields that a shape does not use. Every message names the shape, the field,
 * its value and what is allowed. */
#include "base/error.h"
#include "geom/shapes.h"

#include <stdio.h>
#include <string.h>

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

#define CUT                                                                                        \
    (SHAPE_BIT(RECTANGLE) | SHAPE_BIT(RIBBON) | SHAPE_BIT(DISC) | SHAPE_BIT(TUBE) |                \
     SHAPE_BIT(CAPE) | SHAPE_BIT(NET))
#define GRIDS (ALL_SHAPES & ~(SHAPE_BIT(NET) | SHAPE_BIT(TETRAHEDRON)))
#define ONE_RESOLUTION (SHAPE_BIT(BOX) | SHAPE_BIT(SPHERE))

/* A field of the def: its name, its place, and the shapes that use it. */
typedef struct shape_field {
    const char *name;
    size_t offset, size;
    uint32_t shapes;
    bool is_length, may_be_zero; /* of lengths: whether 0 is a default */
} shape_field;

#define FIELD(field) #field, offsetof(tulle_shape_def, field), sizeof((tulle_shape_def){0}.field)
static const shape_field shape_fields[] = {
    {FIELD(size[0]), SIZED, true, false},
    {FIELD(size[1]), SIZED, true, false},
    {FIELD(size[2]), SOLIDS, true, false},
    {FIELD(radius), ALL_SHAPES & ~(uint32_t)SIZED, true, false},
    {FIELD(inner_radius), SHAPE_BIT(CAPE) | SHAPE_BIT(TORUS), true, true},
    {FIELD(height), HIGH, true, false},
    {FIELD(tip_height), SHAPE_BIT(NEEDLE), true, true},
    {FIELD(head_radius), HEADED, true, true},
    {FIELD(head_height), SHAPE_BIT(NAIL), true, true},
    {FIELD(angle), SHAPE_BIT(CAPE), false, false},
    {FIELD(strand), SHAPE_BIT(NET), true, true},
    {FIELD(wavelength), WAVED, true, true},
    {FIELD(resolution[0]), GRIDS, false, false},
    {FIELD(resolution[1]), GRIDS & ~ONE_RESOLUTION, false, false},
    {FIELD(cells[0]), SHAPE_BIT(NET), false, false},
    {FIELD(cells[1]), SHAPE_BIT(NET), false, false},
    {FIELD(strand_resolution), SHAPE_BIT(NET), false, false},
    {FIELD(is_irregular), CUT, false, false},
    {FIELD(seed), CUT | WAVED, false, false},
};
enum { SHAPE_FIELD_COUNT = sizeof shape_fields / sizeof shape_fields[0] };

static bool has_shape(uint32_t set, const tulle_shape_def *def) {
    return (set >> (unsigned)def->shape & 1) != 0;
}

void shape_clear_unused(tulle_shape_def *def) {
    for (size_t i = 0; i < SHAPE_FIELD_COUNT; i++)
        if (!has_shape(shape_fields[i].shapes, def))
            memset((char *)def + shape_fields[i].offset, 0, shape_fields[i].size);
}

/* What was set and has no effect is refused: its author meant something by it. */
static tulle_status check_unused(const tulle_shape_def *def, tulle_error *error) {
    static const char none[sizeof(double)];
    bool const is_repeated = has_shape(ONE_RESOLUTION, def) && def->resolution[0] != 0 &&
                             def->resolution[1] == def->resolution[0];
    for (size_t i = 0; i < SHAPE_FIELD_COUNT; i++) {
        const shape_field *const field = &shape_fields[i];
        if (has_shape(field->shapes, def) ||
            memcmp((const char *)def + field->offset, none, field->size) == 0 ||
            (is_repeated && field->offset == offsetof(tulle_shape_def, resolution[1])))
            continue;
        char list[200] = "";
        size_t used = 0;
        for (size_t k = 0; k < SHAPE_FIELD_COUNT; k++)
            if (has_shape(shape_fields[k].shapes, def))
                used += (size_t)snprintf(list + used, sizeof list - used, "%s%s",
                                         used > 0 ? ", " : "", shape_fields[k].name);
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "%s: %s does not apply to this shape; it takes %s",
                         tulle_shape_name(def->shape), field->name, list);
    }
    return TULLE_OK;
}

static tulle_status check_lengths(const tulle_shape_def *def, tulle_error *error) {
    for (size_t i = 0; i < SHAPE_FIELD_COUNT; i++) {
        const shape_field *const field = &shape_fields[i];
        if (!field->is_length || !has_shape(field->shapes, def)) continue;
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
    if (!has_shape(GRIDS, def)) return TULLE_OK;
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
    tulle_status status = check_unused(def, error);
    if (status == TULLE_OK) status = check_lengths(def, error);
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
    case TULLE_SHAPE_PLANE: derive_least(def, 2, 2); break;
    case TULLE_SHAPE_BOX: derive_least(def, 2, 0); break;
    case TULLE_SHAPE_SPHERE: derive_least(def, 16, 0); break;
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
