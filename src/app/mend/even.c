/* app/mend/even.c - see even.h. */
#include "app/mend/even.h"

#include "base/error.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double weights[EVEN_FRAMES] = {0.0625, 0.25, 0.375, 0.25, 0.0625}; /* sum 1 */

tulle_status mend_even_open(const mend_input *input, mend_even *even, tulle_error *error) {
    *even = (mend_even){.input = input};
    bool has_room = true;
    for (size_t i = 0; i < EVEN_FRAMES; i++) {
        even->given[i] = calloc(input->vertex_count, 3 * sizeof(double));
        even->departures[i] = calloc(mend_get_cloth_count(input), 3 * sizeof(double));
        has_room = has_room && even->given[i] && even->departures[i];
    }
    return has_room ? TULLE_OK
                    : error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "out of memory for %zu vertices",
                                input->vertex_count);
}

void mend_even_close(mend_even *even) {
    for (size_t i = 0; i < EVEN_FRAMES; i++) {
        free(even->given[i]);
        free(even->departures[i]);
    }
    *even = (mend_even){0};
}

double *mend_even_get_next(mend_even *even) { return even->given[even->count % EVEN_FRAMES]; }

void mend_even_add(mend_even *even, const double *followed) {
    const double *const given = mend_even_get_next(even);
    double *const departures = even->departures[even->count++ % EVEN_FRAMES];
    for (size_t i = 0; i < 3 * mend_get_cloth_count(even->input); i++)
        departures[i] = followed[i] - given[i];
}

const double *mend_even_get_given(const mend_even *even, uint32_t index) {
    return even->given[index % EVEN_FRAMES];
}

static double dot(const double *a, const double *b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* What the weights make of a vertex, less what it is in the middle frame. */
static void find_change(const double *const window[EVEN_FRAMES], size_t vertex, double change[3]) {
    for (size_t i = 0; i < 3; i++) {
        change[i] = 0.0;
        for (size_t k = 0; k < EVEN_FRAMES; k++)
            change[i] +=
                weights[k] * (window[k][3 * vertex + i] - window[EVEN_REACH][3 * vertex + i]);
    }
}

bool mend_even_make(const mend_even *even, uint32_t index, double near, double *way) {
    const double *given[EVEN_FRAMES], *departures[EVEN_FRAMES];
    bool is_given = true;
    for (uint32_t k = 0; k < EVEN_FRAMES; k++) {
        uint32_t const sum = index + k, last = even->count - 1;
        uint32_t const frame = sum < EVEN_REACH ? 0 : sum - EVEN_REACH;
        given[k] = even->given[(frame < last ? frame : last) % EVEN_FRAMES];
        departures[k] = even->departures[(frame < last ? frame : last) % EVEN_FRAMES];
    }
    memcpy(way, given[EVEN_REACH], 3 * even->input->vertex_count * sizeof *way);
    for (size_t v = 0; v < mend_get_cloth_count(even->input); v++) {
        double departure[3], of_departures[3], of_given[3];
        find_change(departures, v, of_departures);
        find_change(given, v, of_given);
        /* the least change between that of departures and that of the way that was followed */
        double const share = dot(of_given, of_given) > 0.0
                                 ? -dot(of_departures, of_given) / dot(of_given, of_given)
                                 : 0.0;
        for (size_t i = 0; i < 3; i++)
            departure[i] = departures[EVEN_REACH][3 * v + i] + of_departures[i] +
                           fmin(fmax(share, 0.0), 1.0) * of_given[i];
        if (!(sqrt(dot(departure, departure)) > near)) continue;
        is_given = false;
        for (size_t i = 3 * v; i < 3 * v + 3; i++) {
            double const place = given[EVEN_REACH][i] + departure[i - 3 * v];
            way[i] = even->input->is_float ? (double)(float)place : place;
        }
    }
    return is_given;
}
