/* strips.h - strips of cloth for experiments, divided into triangles in several ways. */
#ifndef TULLE_TEST_STRIPS_H
#define TULLE_TEST_STRIPS_H

#include "validation/validation.h"

/* How the cells of a strip are divided. */
typedef enum pattern {
    ALTERNATING, /* the diagonals of the default rectangle */
    ALIKE,       /* all diagonals the same way */
    CROSSED,     /* four triangles about a middle: a lattice at 45 degrees */
    IRREGULAR,
    TURNED, /* a lattice at 22.5 degrees, cut along the border */
    PATTERN_COUNT
} pattern;
extern const char *const strips_pattern_names[PATTERN_COUNT];

/* A rectangle [x0, x1] x [-width / 2, width / 2] of columns x rows cells. */
typedef struct strip {
    double begin, end, width; /* [m] */
    uint32_t columns, rows;
    pattern pattern;
    /* [m] x of lines across the strip along which a turned lattice has edges, beside its border.
     * Those of the other patterns are where their columns are. */
    double lines[2];
} strip;
tulle_mesh *strips_make(validation_run *run, const strip *sample);

/* A strip whose pattern is TURNED. */
tulle_mesh *strips_make_turned(validation_run *run, const strip *sample);

/* Holds the vertices with from <= x <= to for ever. */
tulle_pin strips_pin_between(validation_run *run, const tulle_mesh *mesh, double from, double to);

#endif
