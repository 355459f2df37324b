/* io/animation/fine_frames.c - see fine_frames.h.
 *
 * An interval is cut by its turn first, so that no turn between two moments is taken for none. What
 * the middle of a cut is off the line between its ends is its sagitta, which falls with the square
 * of the number of cuts; so a measurement or two tell how many are needed. */
#include "io/animation/fine_frames.h"

#include "base/error.h"
#include "io/file_data.h"

#include <math.h>
#include <string.h>

enum { ADDED_MAX = 65536, ROUNDS_MAX = 4 };
/* [rad] Turns are measured in cuts as small. */
static const double TURN_MAX = 0.5;
/* A part may be so far off its path, in parts of its size: half of what is promised. */
static const double PATH_TOLERANCE = 5e-4;
/* The size of a part counts at least as this part of that of all: of one vertex, too. */
static const double LEAST_PART = 0.01;

typedef struct fine_work {
    fine_frames *frames;
    size_t key;            /* the interval behind it is looked at */
    double *room;          /* for positions, three times, and for extents; null: none yet */
    const double *extents; /* the largest of each part */
    double whole;          /* that of all together */
} fine_work;

static size_t count_room(const fine_frames *frames) {
    return 9 * frames->first_vertices[frames->part_count] + frames->part_count;
}

static tulle_status measure_parts(fine_work *work, tulle_error *error) {
    const fine_frames *const frames = work->frames;
    work->room = memory_allocate_zeroed(frames->heap, count_room(frames), sizeof(double));
    if (!work->room) return file_fail_memory(error, frames->path);
    double *const extents = work->room + count_room(frames) - frames->part_count;
    double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
    tulle_status const status = frames->pose(frames->scene, frames->keys[0], work->room, error);
    for (size_t part = 0; part < frames->part_count; part++) {
        double least[3] = {INFINITY, INFINITY, INFINITY};
        double most[3] = {-INFINITY, -INFINITY, -INFINITY};
        size_t const first = frames->first_vertices[part], next = frames->first_vertices[part + 1];
        for (size_t i = 3 * first; i < 3 * next; i++) {
            least[i % 3] = fmin(least[i % 3], work->room[i]);
            most[i % 3] = fmax(most[i % 3], work->room[i]);
        }
        for (int k = 0; k < 3; k++) {
            extents[part] = fmax(extents[part], most[k] - least[k]);
            low[k] = fmin(low[k], least[k]);
            high[k] = fmax(high[k], most[k]);
        }
    }
    for (int k = 0; k < 3; k++) work->whole = fmax(work->whole, high[k] - low[k]);
    work->extents = extents;
    return status;
}

/* The largest distance of a vertex from the middle of its line, in tolerances of its part. */
static double measure_sagitta(const fine_work *work, double *const ends[2], const double *middle) {
    const size_t *const firsts = work->frames->first_vertices;
    double worst = 0.0;
    for (size_t part = 0; part < work->frames->part_count; part++) {
        double square = 0.0;
        for (size_t i = firsts[part]; i < firsts[part + 1]; i++) {
            double sum = 0.0;
            for (size_t k = 3 * i; k < 3 * i + 3; k++) {
                double const off = middle[k] - 0.5 * (ends[0][k] + ends[1][k]);
                sum += off * off;
            }
            square = fmax(square, sum);
        }
        double const size = fmax(work->extents[part], LEAST_PART * work->whole);
        worst = fmax(worst, sqrt(square) / (PATH_TOLERANCE * size));
    }
    return worst;
}

/* The worst sagitta of an interval in so many cuts. */
static tulle_status measure_cuts(const fine_work *work, uint32_t count, double *worst,
                                 tulle_error *error) {
    const fine_frames *const frames = work->frames;
    size_t const size = 3 * frames->first_vertices[frames->part_count];
    double const from = frames->keys[work->key], to = frames->keys[work->key + 1];
    double *ends[2] = {work->room, work->room + size}, *const middle = work->room + 2 * size;
    *worst = 0.0;
    tulle_status status = frames->pose(frames->scene, from, ends[0], error);
    for (uint32_t i = 0; i < count && status == TULLE_OK; i++) {
        double const half = from + (to - from) * ((i + 0.5) / count);
        double const end = i + 1 < count ? from + (to - from) * ((i + 1.0) / count) : to;
        status = frames->pose(frames->scene, half, middle, error);
        if (status == TULLE_OK) status = frames->pose(frames->scene, end, ends[1], error);
        if (status == TULLE_OK) *worst = fmax(*worst, measure_sagitta(work, ends, middle));
        double *const spare = ends[0];
        ends[0] = ends[1];
        ends[1] = spare;
    }
    return status;
}

static tulle_status cut(fine_work *work, double turn, uint32_t *count, tulle_error *error) {
    fine_frames *const frames = work->frames;
    double const limit = (double)(ADDED_MAX - frames->added_count) + 1.0;
    double wanted = fmax(ceil(turn / TURN_MAX), 1.0), worst = INFINITY;
    tulle_status status = TULLE_OK;
    for (int round = 0; round < ROUNDS_MAX && worst > 1.0 && status == TULLE_OK; round++) {
        if (wanted > limit) break;
        *count = (uint32_t)wanted;
        status = measure_cuts(work, *count, &worst, error);
        wanted = fmax(ceil(*count * sqrt(worst)), 1.0);
    }
    frames->is_cut = frames->is_cut || wanted > limit;
    *count = (uint32_t)fmin(wanted, limit);
    frames->added_count += *count - 1;
    return status;
}

tulle_status fine_frames_make(fine_frames *self, tulle_error *error) {
    self->first_vertices = memory_allocate(self->heap, (self->part_count + 1) * sizeof(size_t));
    self->cuts = memory_allocate(self->heap, self->key_count * sizeof(uint32_t));
    return self->first_vertices && self->cuts ? TULLE_OK : file_fail_memory(error, self->path);
}

void fine_frames_release(fine_frames *self) {
    size_t const firsts = self->first_vertices ? (self->part_count + 1) * sizeof(size_t) : 0;
    memory_release(self->heap, self->first_vertices, firsts);
    memory_release(self->heap, self->cuts, self->cuts ? self->key_count * sizeof(uint32_t) : 0);
}

tulle_status fine_frames_find(fine_frames *self, tulle_error *error) {
    fine_work work = {.frames = self};
    tulle_status status = TULLE_OK;
    for (; work.key + 1 < self->key_count && status == TULLE_OK; work.key++) {
        double const from = self->keys[work.key], to = self->keys[work.key + 1];
        double turn = 0.0;
        self->cuts[work.key] = 1;
        /* A jump is between moments that are neighbours among floats. */
        if (nextafterf((float)from, INFINITY) >= (float)to) continue;
        status = self->find_turn(self->scene, from, to, &turn, error);
        if (status != TULLE_OK || !(turn > 0.0)) continue;
        if (!work.room) status = measure_parts(&work, error);
        if (status == TULLE_OK && work.whole > 0.0)
            status = cut(&work, turn, &self->cuts[work.key], error);
    }
    memory_release(self->heap, work.room, work.room ? count_room(self) * sizeof(double) : 0);
    return status;
}

void fine_frames_spread(const fine_frames *self, double *values) {
    size_t out = self->key_count - 1 + self->added_count;
    for (size_t key = self->key_count - 1; key > 0; key--) {
        double const from = values[key - 1], to = values[key];
        uint32_t const count = self->cuts[key - 1];
        values[out--] = to;
        for (uint32_t i = count - 1; i > 0; i--)
            values[out--] = from + (to - from) * ((double)i / count);
    }
}
