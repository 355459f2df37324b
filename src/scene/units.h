/* scene/units.h - numbers with units: "2 mm", "30 deg", "1/90 s", "0.2 kg/m^2". */
#ifndef TULLE_SCENE_UNITS_H
#define TULLE_SCENE_UNITS_H

#include <stdbool.h>
#include <stddef.h>

typedef enum unit_dimension {
    UNIT_NONE, /* a plain number or percent */
    UNIT_LENGTH,
    UNIT_TIME,
    UNIT_ANGLE,
    UNIT_VELOCITY,
    UNIT_ACCELERATION,
    UNIT_AREA_DENSITY,
    UNIT_STIFFNESS,   /* force per width */
    UNIT_BENDING,     /* plate bending rigidity */
    UNIT_LINE_FORCE,  /* force per length, whatever the strain */
    UNIT_LINE_MOMENT, /* moment per width */
    UNIT_RATE,
    UNIT_DRAG,
    UNIT_MASS,
    UNIT_DENSITY,
    UNIT_SPIN,
    UNIT_FORCE,
    UNIT_SPRING, /* force per length of a spring */
    UNIT_DIMENSION_COUNT
} unit_dimension;

/* What a text turned out to be. */
typedef enum quantity_state {
    QUANTITY_READ,
    QUANTITY_NOT_A_NUMBER,
    QUANTITY_NOT_FINITE, /* NaN, an infinity, or too large for a double */
    QUANTITY_UNKNOWN_UNIT
} quantity_state;

/* Reads a number or a fraction ("1/90"), with an optional unit of the dimension; *value gets SI. */
quantity_state quantity_read(const char *text, unit_dimension dimension, double *value);

/* Whether the text is a decimal integer without sign that fits 2^53; *value gets it. */
bool integer_read(const char *text, unsigned long long *value);

/* The SI unit of a dimension, "" for none. */
const char *unit_si_name(unit_dimension dimension);
/* The units allowed, as "m, km, cm". At most 100 bytes are written. */
void unit_list_names(unit_dimension dimension, char *names, size_t capacity);

#endif
