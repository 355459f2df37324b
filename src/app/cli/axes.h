/* app/cli/axes.h - the way from coordinates with one up axis and unit of length to another. */
#ifndef TULLE_APP_CLI_AXES_H
#define TULLE_APP_CLI_AXES_H

#include <stddef.h>

/* For the options: "y", "z"; "m", "cm", "mm", "in", "ft". End with null. */
extern const char *const axes_up_choices[];
extern const char *const axes_unit_choices[];

/* How coordinates are meant. */
typedef struct axes_frame {
    const char *up;   /* one of axes_up_choices */
    const char *unit; /* one of axes_unit_choices */
} axes_frame;

/* A change of axes, then of units. */
typedef struct axes_change {
    axes_frame from, to;
    double multiplier, divisor; /* whole numbers without a common factor */
} axes_change;

axes_change axes_change_make(axes_frame from, axes_frame to);
/* To z up and metres, as scenes take files, from a unit of any size [m], which may be none of
 * axes_unit_choices: from.unit is null then. */
axes_change axes_change_to_scene(const char *up, double meters);

/* Changes `count` points, three numbers each, in place. Turning about x is exact: from z up to y up
 * (x, y, z) becomes (x, z, -y), from y up to z up (x, -z, y). Lengths are multiplied, then divided,
 * by whole numbers. They are unchanged where both are 1. They are correctly rounded where one of
 * them is 1, as between metres, centimetres and millimetres, or feet and inches. Else, as from
 * inches to millimetres, they are rounded up to twice. */
void axes_apply(const axes_change *change, double *points, size_t count);

/* Turns the axes of a unit quaternion w, x, y, z in place. */
void axes_turn_rotation(const axes_change *change, double rotation[4]);
/* [m] of a unit of axes_unit_choices. */
double axes_get_meters(const char *unit);
/* The unit of that many metres, to seven digits: files give theirs as float. Null: none. */
const char *axes_find_unit(double meters);

/* Prints the lines "axes" and "units" of a report to standard output. */
void axes_print(const axes_change *change);

#endif
