/* io/animation/npz_read.c - NumPy archives as tulle_animation_open reads them: positions, and
 * triangles and times where there are any. */
#include "base/error.h"
#include "io/animation/animation_read.h"
#include "io/animation/expansion.h"
#include "io/animation/npz_archive.h"
#include "io/file_data.h"

#include <math.h>
#include <stdio.h>

#define COUNT_LIMIT ((uint64_t)INT32_MAX)
/* [1/s] of frames without times. */
static const double DEFAULT_RATE = 24.0;

typedef struct npz_state {
    npz_archive archive;
    npz_array positions;
    uint64_t frame_count, vertex_count;
    uint32_t *triangles;
    size_t triangle_count;
    double *times;
} npz_state;

static tulle_status check_positions(npz_state *npz, tulle_error *error) {
    const npz_array *const positions = &npz->positions;
    const uint64_t *const shape = positions->shape;
    size_t const count = positions->dimension_count;
    bool const is_right =
        positions->kind == 'f' && (count == 2 || count == 3) && shape[count - 1] == 3;
    npz->frame_count = count == 3 ? shape[0] : 1;
    npz->vertex_count = count > 1 ? shape[count - 2] : 0;
    if (!is_right || npz->frame_count == 0 || npz->vertex_count == 0)
        return npz_array_fail(&npz->archive, positions, error,
                              "should be floating point numbers, frames x vertices x 3, or "
                              "vertices x 3, with at least one frame and vertex");
    if (npz->frame_count <= COUNT_LIMIT && npz->vertex_count <= COUNT_LIMIT) return TULLE_OK;
    return error_set_at(error, TULLE_ERROR_LIMIT, npz->archive.path, 0, 0,
                        "its vertices or frames are too many");
}

/* Refuses what would take too many times the file's bytes. */
static tulle_status check_size(const npz_state *npz, uint64_t triangle_count, tulle_error *error) {
    uint64_t const size = 12 * npz->vertex_count + 8 * npz->frame_count + 12 * triangle_count;
    uint64_t const limit = expansion_get_limit(npz->archive.size);
    if (size <= limit) return TULLE_OK;
    return error_set_at(error, TULLE_ERROR_LIMIT, npz->archive.path, 0, 0,
                        "would take more than %llu MB of memory, which is too many times its size",
                        (unsigned long long)(limit >> 20) + 1);
}

static tulle_status read_triangles(npz_state *npz, npz_array *array, tulle_error *error) {
    npz_archive *const archive = &npz->archive;
    bool const is_empty = array->shape[0] == 0 && array->dimension_count > 0;
    if (is_empty) return TULLE_OK;
    if (array->kind == 'f' || array->dimension_count != 2 || array->shape[1] != 3)
        return npz_array_fail(archive, array, error, "should be whole numbers, triangles x 3");
    uint64_t const count = array->shape[0];
    tulle_status status = check_size(npz, count, error);
    if (status) return status;
    if (count > COUNT_LIMIT)
        return error_set_at(error, TULLE_ERROR_LIMIT, archive->path, 0, 0,
                            "its triangles are too many");
    npz->triangles = memory_allocate(archive->heap, 3 * (size_t)count * sizeof(uint32_t));
    if (!npz->triangles) return file_fail_memory(error, archive->path);
    npz->triangle_count = (size_t)count;
    /* In the order in which they stand. */
    for (uint64_t i = 0; i < 3 * count && status == TULLE_OK; i++) {
        uint64_t const at[2] = {array->is_fortran ? i % count : i / 3,
                                array->is_fortran ? i / count : i % 3};
        double vertex = 0.0;
        status = npz_array_read(archive, array, at, &vertex, error);
        if (status == TULLE_OK && !(vertex >= 0.0 && vertex < (double)npz->vertex_count))
            status = npz_array_fail(
                archive, array, error, "triangle %llu uses vertex %.0f, but there are only %llu",
                (unsigned long long)at[0], vertex, (unsigned long long)npz->vertex_count);
        if (status == TULLE_OK) npz->triangles[3 * at[0] + at[1]] = (uint32_t)vertex;
    }
    return status;
}

static tulle_status read_times(npz_state *npz, npz_array *array, bool is_there,
                               tulle_error *error) {
    npz_archive *const archive = &npz->archive;
    npz->times = memory_allocate(archive->heap, (size_t)npz->frame_count * sizeof *npz->times);
    if (!npz->times) return file_fail_memory(error, archive->path);
    if (is_there && (array->dimension_count != 1 || array->shape[0] != npz->frame_count))
        return npz_array_fail(archive, array, error,
                              "should be numbers of one dimension, one for each of %llu frames",
                              (unsigned long long)npz->frame_count);
    for (uint64_t i = 0; i < npz->frame_count; i++) {
        npz->times[i] = (double)i / DEFAULT_RATE;
        if (!is_there) continue;
        tulle_status const status = npz_array_read(archive, array, &i, &npz->times[i], error);
        if (status) return status;
        if (!isfinite(npz->times[i]))
            return npz_array_fail(archive, array, error, "time %llu is not finite",
                                  (unsigned long long)i);
    }
    return TULLE_OK;
}

static tulle_status read_others(npz_state *npz, bool *has_times, tulle_error *error) {
    npz_array array;
    bool is_there = false;
    tulle_status status = npz_array_open(&npz->archive, "triangles", &array, &is_there, error);
    if (status == TULLE_OK && is_there) status = read_triangles(npz, &array, error);
    npz_array_close(&npz->archive, &array);
    if (status) return status;
    status = npz_array_open(&npz->archive, "times", &array, has_times, error);
    if (status == TULLE_OK) status = read_times(npz, &array, *has_times, error);
    npz_array_close(&npz->archive, &array);
    return status;
}

static tulle_status open_npz(memory *heap, const char *path, void *state,
                             animation_content *content, tulle_error *error) {
    npz_state *const npz = state;
    bool is_there = false, has_times = false;
    tulle_status status = npz_archive_open(heap, path, &npz->archive, error);
    if (status == TULLE_OK)
        status = npz_array_open(&npz->archive, "positions", &npz->positions, &is_there, error);
    if (status) return status;
    if (!is_there)
        return error_set_at(error, TULLE_ERROR_PARSE, path, 0, 0,
                            "has no array \"positions\" (positions.npy)");
    status = check_positions(npz, error);
    if (status == TULLE_OK) status = check_size(npz, 0, error);
    if (status == TULLE_OK) status = read_others(npz, &has_times, error);
    if (status) return status;
    content->info = (tulle_animation_info){.vertex_count = (size_t)npz->vertex_count,
                                           .triangle_count = npz->triangle_count,
                                           .frame_count = (uint32_t)npz->frame_count,
                                           .has_times = has_times,
                                           .meters_per_unit = 1.0};
    if (!has_times && npz->frame_count > 1)
        snprintf(content->info.note, sizeof content->info.note,
                 "there are no times; a second has %g frames", DEFAULT_RATE);
    content->triangles = npz->triangles;
    content->times = npz->times;
    return TULLE_OK;
}

static tulle_status read_npz(void *state, uint32_t frame, double *positions, tulle_error *error) {
    npz_state *const npz = state;
    npz_array *const array = &npz->positions;
    uint64_t const count = npz->vertex_count;
    for (uint64_t i = 0; i < 3 * count; i++) {
        uint64_t const vertex = array->is_fortran ? i % count : i / 3;
        uint64_t const axis = array->is_fortran ? i / count : i % 3;
        uint64_t const at[3] = {frame, vertex, axis};
        double *const value = positions + 3 * vertex + axis;
        tulle_status const status = npz_array_read(
            &npz->archive, array, array->dimension_count == 3 ? at : at + 1, value, error);
        if (status) return status;
        if (!isfinite(*value))
            return npz_array_fail(&npz->archive, array, error,
                                  "frame %u: vertex %llu is not finite", frame,
                                  (unsigned long long)vertex);
    }
    return TULLE_OK;
}

static void close_npz(void *state) {
    npz_state *const npz = state;
    memory *const heap = npz->archive.heap;
    if (!heap) return;
    npz_array_close(&npz->archive, &npz->positions);
    memory_release(heap, npz->triangles, 3 * npz->triangle_count * sizeof *npz->triangles);
    memory_release(heap, npz->times, (size_t)npz->frame_count * sizeof *npz->times);
    npz_archive_close(&npz->archive);
}

const animation_reader npz_reader = {.extensions = {".npz"},
                                     .state_size = sizeof(npz_state),
                                     .open = open_npz,
                                     .read = read_npz,
                                     .close = close_npz};
