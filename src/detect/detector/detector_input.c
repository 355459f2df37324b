/* detect/detector/detector_input.c - checks of what callers hand to a detector: the def once,
 * positions at every call. Messages name the triangle, vertex or surface and say what to do. */
#include "base/error.h"
#include "base/parallel.h"
#include "detect/detector/detector_parts.h"

#include <math.h>
#include <stdatomic.h>
#include <string.h>

enum {
    MOST_FEATURES = INT32_MAX, /* vertices or triangles; indices have 32 bits, edges outnumber both
                                */
    MOST_SURFACES = 4096,      /* the table of separations takes 8 bytes for each pair of them */
    MOST_THREADS = 256,
    DOUBLES_A_CHUNK = 16384 /* looked at by one thread at a time, some 5 microseconds */
};

/* [m] Thicknesses and separations beyond this overflow when squared. */
static const double LARGEST_SEPARATION = 1e150;
static const double RIGHT_ANGLE = 1.57079632679489661923; /* [rad] pi / 2 */

tulle_detect_def tulle_detect_def_default(void) {
    return (tulle_detect_def){
        .cookie = DETECT_DEF_COOKIE,
        .method = TULLE_DETECT_PATCHES,
        .cone = TULLE_CONE_BERNSTEIN,
        .max_angle = RIGHT_ANGLE * 2.0 / 3.0,
        .has_certificate = 1,
    };
}

#define INVALID(...) error_set(error, TULLE_ERROR_INVALID_ARGUMENT, __VA_ARGS__)

static tulle_status check_distance(double value, const char *name, tulle_error *error) {
    if (value >= 0.0 && value <= LARGEST_SEPARATION) return TULLE_OK;
    return INVALID("%s is %g m; it must lie between 0 and %g", name, value, LARGEST_SEPARATION);
}

static tulle_status check_settings(const tulle_detect_def *def, tulle_error *error) {
    tulle_status status = check_distance(def->minimum_separation, "the minimum separation", error);
    if (status == TULLE_OK && !def->surfaces)
        status = check_distance(def->thickness, "the thickness", error);
    if (status != TULLE_OK) return status;
    if ((unsigned)def->method > TULLE_DETECT_PAPER)
        return INVALID("method %d is not a value of tulle_detect_method", (int)def->method);
    if ((unsigned)def->cone > TULLE_CONE_PAPER)
        return INVALID("cone %d is not a value of tulle_detect_cone", (int)def->cone);
    if (!(def->max_angle > 0.0 && def->max_angle < RIGHT_ANGLE))
        return INVALID("the widest cone is %g rad; it must lie between 0 and pi/2, both excluded",
                       def->max_angle);
    if (def->threads < 0 || def->threads > MOST_THREADS)
        return INVALID("%d threads; it must be 0 (one per processor) to %d", def->threads,
                       (int)MOST_THREADS);
    if (!allocator_is_whole(&def->allocator))
        return INVALID("the allocator has only one of its functions; give both or neither");
    return TULLE_OK;
}

static tulle_status check_counts(const tulle_detect_def *def, tulle_error *error) {
    if (def->vertex_count == 0) return INVALID("there are no vertices; at least one is needed");
    if (def->vertex_count > MOST_FEATURES || def->triangle_count > MOST_FEATURES)
        return error_set(error, TULLE_ERROR_LIMIT,
                         "%zu vertices and %zu triangles; the most of each is %d",
                         def->vertex_count, def->triangle_count, (int)MOST_FEATURES);
    if (def->triangle_count > 0 && !def->triangles)
        return INVALID("triangles is null, but triangle_count is %zu", def->triangle_count);
    if (!def->surfaces && def->surface_count > 0)
        return INVALID("surfaces is null, but surface_count is %zu; give both or neither",
                       def->surface_count);
    if (def->surfaces && def->surface_count == 0)
        return INVALID("surface_count is 0, but surfaces is given; give both or neither");
    if (def->surface_count > MOST_SURFACES)
        return error_set(error, TULLE_ERROR_LIMIT, "%zu surfaces; the most is %d",
                         def->surface_count, (int)MOST_SURFACES);
    return TULLE_OK;
}

/* Ranges of one kind start where those of the surface before end, and do not go backward. */
static tulle_status check_range(size_t surface, const char *kind, const uint32_t range[2],
                                uint32_t previous_end, tulle_error *error) {
    if (range[0] != previous_end)
        return INVALID(
            "surface %zu starts at %s %u; it must start at %s %u, where the one before ends",
            surface, kind, range[0], kind, previous_end);
    if (range[1] < range[0])
        return INVALID("surface %zu ends at %s %u, before it starts at %u", surface, kind, range[1],
                       range[0]);
    return TULLE_OK;
}

static tulle_status check_surfaces(const tulle_detect_def *def, tulle_error *error) {
    uint32_t vertex = 0, triangle = 0;
    for (size_t s = 0; s < def->surface_count; s++) {
        const tulle_detect_surface *const surface = &def->surfaces[s];
        uint32_t const vertices[2] = {surface->vertex_begin, surface->vertex_end};
        uint32_t const triangles[2] = {surface->triangle_begin, surface->triangle_end};
        tulle_status status = check_range(s, "vertex", vertices, vertex, error);
        if (status == TULLE_OK) status = check_range(s, "triangle", triangles, triangle, error);
        if (status != TULLE_OK) return status;
        if (!(surface->thickness >= 0.0 && surface->thickness <= LARGEST_SEPARATION))
            return INVALID("the thickness of surface %zu is %g m; it must lie between 0 and %g", s,
                           surface->thickness, LARGEST_SEPARATION);
        vertex = vertices[1];
        triangle = triangles[1];
    }
    if (def->surface_count > 0 && (vertex != def->vertex_count || triangle != def->triangle_count))
        return INVALID("the surfaces end at vertex %u and triangle %u; they must cover all %zu "
                       "vertices and %zu triangles",
                       vertex, triangle, def->vertex_count, def->triangle_count);
    return TULLE_OK;
}

static tulle_status check_collides(const tulle_detect_def *def, tulle_error *error) {
    if (!def->collides) return TULLE_OK;
    if (!def->surfaces) return INVALID("collides is given without surfaces");
    size_t const count = def->surface_count;
    for (size_t a = 0; a < count; a++)
        for (size_t b = 0; b < a; b++)
            if (!def->collides[a * count + b] != !def->collides[b * count + a])
                return INVALID(
                    "collides is not symmetric: surface %zu meets %zu, but not the other way round",
                    def->collides[a * count + b] ? a : b, def->collides[a * count + b] ? b : a);
    return TULLE_OK;
}

#undef INVALID
#define INVALID(...) error_set(error, TULLE_ERROR_INVALID_MESH, __VA_ARGS__)

static tulle_status check_triangle(const tulle_detect_def *def, size_t triangle, size_t surface,
                                   tulle_error *error) {
    const uint32_t *const corners = def->triangles + 3 * triangle;
    uint32_t const begin = def->surfaces ? def->surfaces[surface].vertex_begin : 0;
    uint32_t const end =
        def->surfaces ? def->surfaces[surface].vertex_end : (uint32_t)def->vertex_count;
    for (int k = 0; k < 3; k++) {
        if (corners[k] >= def->vertex_count)
            return INVALID("corner %d of triangle %zu is vertex %u, but there are only %zu "
                           "vertices, numbered from 0",
                           k, triangle, corners[k], def->vertex_count);
        if (corners[k] < begin || corners[k] >= end)
            return INVALID("corner %d of triangle %zu is vertex %u, outside its surface %zu, which "
                           "starts at vertex %u and ends before %u; surfaces share no vertices",
                           k, triangle, corners[k], surface, begin, end);
        if (corners[k] == corners[(k + 1) % 3])
            return INVALID(
                "triangle %zu has vertex %u twice; remove it, or give it three different corners",
                triangle, corners[k]);
    }
    return TULLE_OK;
}

#undef INVALID

static tulle_status check_triangles(const tulle_detect_def *def, tulle_error *error) {
    size_t surface = 0;
    for (size_t t = 0; t < def->triangle_count; t++) {
        while (def->surfaces && t >= def->surfaces[surface].triangle_end) surface++;
        tulle_status const status = check_triangle(def, t, surface, error);
        if (status != TULLE_OK) return status;
    }
    return TULLE_OK;
}

/* Whether some of `count` doubles is not finite: adding 1 to an exponent of all ones carries into
 * the sign. Plain integers, which compilers turn into vectors. */
static bool has_infinite(const double *values, size_t count) {
    uint64_t const exponent = 0x7FF0000000000000U;
    uint64_t seen = 0;
    for (size_t i = 0; i < count; i++) {
        uint64_t bits;
        memcpy(&bits, &values[i], sizeof bits);
        seen |= (bits & exponent) + 0x0010000000000000U;
    }
    return seen >> 63 != 0;
}

/* Names the first vertex that is not finite. */
static tulle_status report_infinite(const double *positions, const char *name, tulle_error *error) {
    size_t at = 0;
    while (isfinite(positions[at])) at++;
    const double *const x = positions + at / 3 * 3;
    return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                     "vertex %zu of `%s` is at (%g, %g, %g), which is not finite", at / 3, name,
                     x[0], x[1], x[2]);
}

static tulle_status check_finite(const double *positions, size_t vertex_count, const char *name,
                                 tulle_error *error) {
    if (!has_infinite(positions, 3 * vertex_count)) return TULLE_OK;
    return report_infinite(positions, name, error);
}

/* Positions of a call. */
typedef struct finite_check {
    const double *positions[2]; /* `count` doubles each */
    size_t count;
    atomic_bool found[2]; /* something that is not finite */
} finite_check;

/* A chunk is one of each array in turn. */
static void check_chunk(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)begin, (void)end, (void)worker;
    finite_check *const check = context;
    size_t const which = chunk % 2, from = chunk / 2 * DOUBLES_A_CHUNK;
    size_t const left = check->count - from;
    if (has_infinite(check->positions[which] + from,
                     left < DOUBLES_A_CHUNK ? left : DOUBLES_A_CHUNK))
        atomic_store(&check->found[which], true);
}

static tulle_status check_both_finite(const tulle_detector *detector, const double *start,
                                      const double *end, tulle_error *error) {
    finite_check check = {.positions = {start, end}, .count = 3 * detector->topo.vertex_count};
    size_t const chunks = parallel_chunk_count(check.count, DOUBLES_A_CHUNK);
    parallel_for(2 * chunks, 1, detector->threads, check_chunk, &check);
    if (atomic_load(&check.found[0])) return report_infinite(start, "start", error);
    if (atomic_load(&check.found[1])) return report_infinite(end, "end", error);
    return TULLE_OK;
}

tulle_status detect_def_check(const tulle_detect_def *def, tulle_error *error) {
    if (!def || def->cookie != DETECT_DEF_COOKIE)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "the def was not made by tulle_detect_def_default");
    tulle_status status = check_settings(def, error);
    if (status == TULLE_OK) status = check_counts(def, error);
    if (status == TULLE_OK) status = check_surfaces(def, error);
    if (status == TULLE_OK) status = check_collides(def, error);
    if (status == TULLE_OK) status = check_triangles(def, error);
    if (status == TULLE_OK && def->rest)
        status = check_finite(def->rest, def->vertex_count, "rest", error);
    return status;
}

/* Whether static surfaces are where they were; at the first call, whether they stay. */
static tulle_status check_static(const tulle_detector *detector, const double *start,
                                 const double *end, tulle_error *error) {
    const double *known = detector->static_positions;
    for (size_t s = 0; s < detector->set.surface_count; s++) {
        const surface_range *const range = &detector->surfaces[s];
        if (!range->is_static) continue;
        size_t const begin = 3 * (size_t)range->vertex_begin;
        size_t const count = 3 * (size_t)range->vertex_end - begin;
        for (size_t i = 0; i < count; i++) {
            double const expected = detector->has_static_positions ? known[i] : start[begin + i];
            if (start[begin + i] == expected && end[begin + i] == expected) continue;
            return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                             "vertex %zu of surface %zu moves, but the surface was said to be "
                             "static; clear is_static",
                             (begin + i) / 3, s);
        }
        known += count;
    }
    return TULLE_OK;
}

static void keep_static(tulle_detector *detector, const double *start) {
    double *known = detector->static_positions;
    for (size_t s = 0; s < detector->set.surface_count; s++) {
        const surface_range *const range = &detector->surfaces[s];
        size_t const count = 3 * (size_t)(range->vertex_end - range->vertex_begin);
        if (!range->is_static || count == 0) continue;
        memcpy(known, start + 3 * (size_t)range->vertex_begin, count * sizeof *known);
        known += count;
    }
    detector->has_static_positions = true;
}

tulle_status detector_check_positions(tulle_detector *detector, const double *start,
                                      const double *end, tulle_error *error) {
    if (!start || !end)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "the %s positions are null",
                         start ? "end" : "start");
    tulle_status status = check_both_finite(detector, start, end, error);
    if (status != TULLE_OK || detector->static_vertex_count == 0) return status;
    status = check_static(detector, start, end, error);
    if (status == TULLE_OK && !detector->has_static_positions) keep_static(detector, start);
    return status;
}
