/* app/cli/axes.c - see axes.h. */
#include "app/cli/axes.h"

#include "base/integer.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

const char *const axes_up_choices[] = {"y", "z", NULL};
const char *const axes_unit_choices[] = {"m", "cm", "mm", "in", "ft", NULL};

typedef struct length_unit {
    const char *symbol, *name;
    uint32_t size; /* [0.1 mm], in which all of them are whole numbers */
} length_unit;

static const length_unit units[] = {
    {"m", "metres", 10000}, {"cm", "centimetres", 100}, {"mm", "millimetres", 10},
    {"in", "inches", 254},  {"ft", "feet", 3048},
};

/* A unit this near to another, as a part of it, is that one, told as a float. */
static const double UNIT_TOLERANCE = 1e-7;

static const length_unit *find_unit(const char *symbol) {
    size_t i = 0;
    while (strcmp(units[i].symbol, symbol) != 0) i++;
    return &units[i];
}

axes_change axes_change_make(axes_frame from, axes_frame to) {
    uint32_t const size_from = find_unit(from.unit)->size, size_to = find_unit(to.unit)->size;
    uint32_t const factor = integer_compute_common_factor(size_from, size_to);
    return (axes_change){.from = from,
                         .to = to,
                         .multiplier = (double)(size_from / factor),
                         .divisor = (double)(size_to / factor)};
}

axes_change axes_change_to_scene(const char *up, double meters) {
    axes_frame const from = {up, axes_find_unit(meters)}, scene = {"z", "m"};
    if (from.unit) return axes_change_make(from, scene);
    return (axes_change){.from = from, .to = scene, .multiplier = meters, .divisor = 1.0};
}

static void turn(double *points, size_t count, int is_to_y) {
    for (size_t i = 0; i < count; i++) {
        double *const point = points + 3 * i;
        double const y = point[1], z = point[2];
        point[1] = is_to_y ? z : -z;
        point[2] = is_to_y ? -y : y;
    }
}

void axes_apply(const axes_change *change, double *points, size_t count) {
    if (strcmp(change->from.up, change->to.up) != 0)
        turn(points, count, strcmp(change->to.up, "y") == 0);
    if (change->multiplier != 1.0)
        for (size_t i = 0; i < 3 * count; i++) points[i] *= change->multiplier;
    if (change->divisor != 1.0)
        for (size_t i = 0; i < 3 * count; i++) points[i] /= change->divisor;
}

/* The axis of a rotation turns as a point does. */
void axes_turn_rotation(const axes_change *change, double rotation[4]) {
    axes_change const turning = {change->from, change->to, 1.0, 1.0};
    axes_apply(&turning, rotation + 1, 1);
}

double axes_get_meters(const char *unit) { return find_unit(unit)->size / 10000.0; }

const char *axes_find_unit(double meters) {
    for (size_t i = 0; i < sizeof units / sizeof units[0]; i++) {
        double const size = units[i].size / 10000.0;
        if (fabs(meters - size) <= UNIT_TOLERANCE * size) return units[i].symbol;
    }
    return NULL;
}

void axes_print(const axes_change *change) {
    if (strcmp(change->from.up, change->to.up) == 0)
        printf("  %-11s %s up, as before\n", "axes", change->to.up);
    else
        printf("  %-11s %s up, from %s up: (x, y, z) became %s\n", "axes", change->to.up,
               change->from.up, change->to.up[0] == 'y' ? "(x, z, -y)" : "(x, -z, y)");
    const char *const name = find_unit(change->to.unit)->name;
    if (change->multiplier == 1.0 && change->divisor == 1.0) {
        printf("  %-11s %s, as before\n", "units", name);
        return;
    }
    printf("  %-11s %s, from %s:", "units", name, find_unit(change->from.unit)->name);
    if (change->multiplier != 1.0) printf(" times %.0f", change->multiplier);
    if (change->divisor != 1.0) printf(" divided by %.0f", change->divisor);
    putchar('\n');
}
