/* app/mend/plate.c - see plate.h. */
#include "app/mend/plate.h"

#include "base/error.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

/* Triangles are slivers below this ratio of height to longest edge; the library softens their
 * hinges in proportion (docs/method/compute_forces.md). */
static const double SLIVER_RATIO = 0.1;

/* An edge of a triangle. */
typedef struct side {
    uint32_t low, high; /* its ends */
    uint32_t place;     /* 3 * triangle + number of the edge */
} side;

static int compare_sides(const void *a, const void *b) {
    const side *const left = a, *const right = b;
    if (left->low != right->low) return left->low < right->low ? -1 : 1;
    if (left->high != right->high) return left->high < right->high ? -1 : 1;
    return (left->place > right->place) - (left->place < right->place);
}

static double dot(const double *a, const double *b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void subtract(const double *positions, uint32_t a, uint32_t b, double difference[3]) {
    for (size_t k = 0; k < 3; k++)
        difference[k] = positions[3 * (size_t)a + k] - positions[3 * (size_t)b + k];
}

static double compute_double_area(const double *positions, const uint32_t *corners) {
    double u[3], v[3];
    subtract(positions, corners[1], corners[0], u);
    subtract(positions, corners[2], corners[0], v);
    return sqrt(fmax(dot(u, u) * dot(v, v) - dot(u, v) * dot(u, v), 0.0));
}

/* Adds the side of a triangle to the hinge: the outward conormal, times the edge length. */
static void add_side(tulle_mesh_view rest, uint32_t place, size_t number, mend_hinge *hinge) {
    const uint32_t *const corners = rest.triangles + 3 * (size_t)(place / 3);
    uint32_t const opposite = corners[(place + 2) % 3];
    double const double_area = compute_double_area(rest.positions, corners);
    double along[3], offset[3], longest2 = 0.0;
    subtract(rest.positions, hinge->vertices[1], hinge->vertices[0], along);
    subtract(rest.positions, opposite, hinge->vertices[0], offset);
    double const foot = dot(offset, along) / dot(along, along);
    double const slope = dot(along, along) / double_area;
    hinge->vertices[2 + number] = opposite;
    hinge->weights[2 + number] = -slope;
    hinge->weights[0] += slope * (1.0 - foot);
    hinge->weights[1] += slope * foot;
    for (size_t k = 0; k < 3; k++) {
        double edge[3];
        subtract(rest.positions, corners[(k + 1) % 3], corners[k], edge);
        longest2 = fmax(longest2, dot(edge, edge));
    }
    hinge->softening = fmin(hinge->softening, double_area / longest2 / SLIVER_RATIO);
}

static void fill_hinges(tulle_mesh_view rest, const side *sides, mend_plate *plate) {
    size_t const count = 3 * rest.triangle_count;
    for (size_t i = 0; i < count; i++) plate->triangle_hinges[i] = TULLE_NONE;
    for (size_t i = 0; i + 1 < count; i++) {
        if (sides[i].low != sides[i + 1].low || sides[i].high != sides[i + 1].high) continue;
        mend_hinge *const hinge = &plate->hinges[plate->hinge_count];
        *hinge = (mend_hinge){.vertices = {sides[i].low, sides[i].high}, .softening = 1.0};
        for (size_t k = 0; k < 2; k++) {
            add_side(rest, sides[i + k].place, k, hinge);
            plate->triangle_hinges[sides[i + k].place] = (uint32_t)plate->hinge_count;
        }
        plate->hinge_count++;
        i++;
    }
}

static void fill_couplings(tulle_mesh_view rest, mend_plate *plate) {
    for (size_t t = 0; t < rest.triangle_count; t++) {
        const uint32_t *const corners = rest.triangles + 3 * t;
        double edges[3][3];
        for (size_t k = 0; k < 3; k++)
            subtract(rest.positions, corners[(k + 1) % 3], corners[k], edges[k]);
        double const area = 0.5 * compute_double_area(rest.positions, corners);
        for (size_t k = 0; k < 3; k++) plate->areas[corners[k]] += area / 3.0;
        for (size_t k = 0; k < 6; k++) {
            size_t const a = k % 3, b = k < 3 ? a : (k + 1) % 3;
            uint32_t const first = plate->triangle_hinges[3 * t + a];
            uint32_t const second = plate->triangle_hinges[3 * t + b];
            if (first == TULLE_NONE || second == TULLE_NONE) continue;
            double const product = dot(edges[a], edges[b]);
            double const cosine2 =
                a == b ? 1.0
                       : product * product / (dot(edges[a], edges[a]) * dot(edges[b], edges[b]));
            plate->couplings[6 * t + k] = plate->hinges[first].softening *
                                          plate->hinges[second].softening * cosine2 / (4.0 * area);
        }
    }
}

/* Each pair of neighbours once for either end; edges of two triangles come twice in `sides`. */
static void fill_neighbours(const side *sides, size_t count, mend_plate *plate) {
    uint32_t *const begin = plate->neighbour_begin;
    for (int pass = 0; pass < 2; pass++) {
        for (size_t i = 0; i < count; i++) {
            if (i > 0 && sides[i].low == sides[i - 1].low && sides[i].high == sides[i - 1].high)
                continue;
            if (pass == 0) {
                begin[sides[i].low + 1]++;
                begin[sides[i].high + 1]++;
            } else { /* moves each begin to its end */
                plate->neighbours[begin[sides[i].low]++] = sides[i].high;
                plate->neighbours[begin[sides[i].high]++] = sides[i].low;
            }
        }
        for (size_t v = 0; v < plate->vertex_count && pass == 0; v++) begin[v + 1] += begin[v];
    }
    for (size_t v = plate->vertex_count; v > 0; v--) begin[v] = begin[v - 1];
    begin[0] = 0;
}

tulle_status mend_plate_open(tulle_mesh_view rest, mend_plate *plate, tulle_error *error) {
    size_t const count = 3 * rest.triangle_count;
    *plate = (mend_plate){.vertex_count = rest.vertex_count, .triangle_count = rest.triangle_count};
    side *const sides = calloc(count, sizeof *sides);
    plate->hinges = calloc(count, sizeof *plate->hinges);
    plate->triangle_hinges = calloc(count, sizeof *plate->triangle_hinges);
    plate->couplings = calloc(2 * count, sizeof *plate->couplings);
    plate->areas = calloc(rest.vertex_count, sizeof *plate->areas);
    plate->moments = calloc(6 * count, sizeof *plate->moments);
    plate->neighbour_begin = calloc(rest.vertex_count + 1, sizeof *plate->neighbour_begin);
    plate->neighbours = calloc(2 * count, sizeof *plate->neighbours);
    bool const has_room = sides && plate->hinges && plate->triangle_hinges && plate->couplings &&
                          plate->areas && plate->moments && plate->neighbour_begin &&
                          plate->neighbours;
    if (has_room) {
        for (size_t i = 0; i < count; i++) {
            uint32_t const a = rest.triangles[i], b = rest.triangles[i - i % 3 + (i + 1) % 3];
            sides[i] = (side){a < b ? a : b, a < b ? b : a, (uint32_t)i};
        }
        qsort(sides, count, sizeof *sides, compare_sides);
        fill_hinges(rest, sides, plate);
        fill_couplings(rest, plate);
        fill_neighbours(sides, count, plate);
    }
    free(sides);
    return has_room ? TULLE_OK
                    : error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "out of memory for the cloth");
}

void mend_plate_close(mend_plate *plate) {
    free(plate->hinges);
    free(plate->triangle_hinges);
    free(plate->couplings);
    free(plate->areas);
    free(plate->moments);
    free(plate->neighbour_begin);
    free(plate->neighbours);
    *plate = (mend_plate){0};
}

void mend_plate_apply(const mend_plate *plate, const double *values, double *result) {
    double *const sums = plate->moments, *const moments = sums + 3 * plate->hinge_count;
    for (size_t h = 0; h < plate->hinge_count; h++) {
        const mend_hinge *const hinge = &plate->hinges[h];
        const double *const origin = values + 3 * (size_t)hinge->vertices[0];
        for (size_t k = 0; k < 3; k++) {
            double sum = 0.0; /* weights sum to zero; differences keep rounding small */
            for (size_t i = 1; i < 4; i++)
                sum += hinge->weights[i] * (values[3 * (size_t)hinge->vertices[i] + k] - origin[k]);
            sums[3 * h + k] = sum;
            moments[3 * h + k] = 0.0;
        }
    }
    for (size_t t = 0; t < plate->triangle_count; t++)
        for (size_t k = 0; k < 6; k++) {
            double const coupling = plate->couplings[6 * t + k];
            if (coupling == 0.0) continue;
            size_t const a = plate->triangle_hinges[3 * t + k % 3];
            size_t const b = plate->triangle_hinges[3 * t + (k < 3 ? k : (k + 1) % 3)];
            for (size_t i = 0; i < 3; i++) {
                moments[3 * a + i] += coupling * sums[3 * b + i];
                if (a != b) moments[3 * b + i] += coupling * sums[3 * a + i];
            }
        }
    memset(result, 0, 3 * plate->vertex_count * sizeof *result);
    for (size_t h = 0; h < plate->hinge_count; h++)
        for (size_t i = 0; i < 4; i++)
            for (size_t k = 0; k < 3; k++)
                result[3 * (size_t)plate->hinges[h].vertices[i] + k] +=
                    plate->hinges[h].weights[i] * moments[3 * h + k];
}
