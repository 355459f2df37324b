/* geom/cut_polygons.c - cuts the polygons of a mesh, doubles alike.
 *
 * A double is a polygon whose corners lie where those of an earlier one lie, in the same or the
 * opposite order; modellers write them for surfaces with two sides. Its fan is moved to begin where
 * the other one begins and to go the same way round, cut, and turned back. Doubles follow each
 * other when polygons are sorted by a hash of their sides. Cost O(n log n) of n corners. */
#include "geom/cut_polygon.h"

#include "base/error.h"
#include "base/hash.h"
#include "base/sort.h"

#include <string.h>

/* Corners of a polygon in the place of the first one of another that are tried; more than one lie
 * there only at bridges to holes. */
enum { START_LIMIT = 16 };

typedef struct side_key {
    uint64_t hash;
    size_t fan;
} side_key;

static int compare_keys(const void *one, const void *two) {
    const side_key *const a = one, *const b = two;
    if (a->hash != b->hash) return a->hash < b->hash ? -1 : 1;
    return (a->fan > b->fan) - (a->fan < b->fan);
}

/* What a fan holds of a corner. */
static uint32_t get_corner(const uint32_t *fan, size_t count, size_t corner) {
    if (corner == 0) return fan[0];
    return corner + 1 < count ? fan[3 * (corner - 1) + 1] : fan[3 * (count - 3) + 2];
}

static const double *get_place(const polygon_list *list, const polygon_fan *fan, size_t corner) {
    size_t const count = (size_t)fan->count + 2;
    uint32_t const vertex = get_corner(list->triangles + 3 * fan->first, count, corner % count);
    return list->positions + 3 * (size_t)vertex;
}

static uint64_t hash_place(const double *place) {
    double const x[3] = {place[0] + 0.0, place[1] + 0.0, place[2] + 0.0}; /* -0 is 0 */
    return hash_block(x, sizeof x);
}

/* The same wherever the polygon begins and whichever way it goes. */
static uint64_t hash_sides(const polygon_list *list, const polygon_fan *fan) {
    uint64_t sum = 0, before = hash_place(get_place(list, fan, (size_t)fan->count + 1));
    for (size_t i = 0; i < (size_t)fan->count + 2; i++) {
        uint64_t const here = hash_place(get_place(list, fan, i));
        sum += hash_mix(before + here);
        before = here;
    }
    return sum;
}

static bool is_same_place(const double *a, const double *b) {
    return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

/* Whether the corners lie where those of `first` lie, from `start` on, forwards or backwards. */
static bool goes_along(const polygon_list *list, const polygon_fan *first, const polygon_fan *fan,
                       size_t start, bool is_backwards) {
    size_t const count = (size_t)fan->count + 2;
    for (size_t i = 0; i < count; i++)
        if (!is_same_place(get_place(list, first, i),
                           get_place(list, fan, start + (is_backwards ? count - i : i))))
            return false;
    return true;
}

/* Writes a fan anew from a corner on, forwards or backwards. `ring`: room for its corners. */
static void move_fan(uint32_t *fan, size_t count, size_t start, bool is_backwards, uint32_t *ring) {
    for (size_t i = 0; i < count; i++)
        ring[i] = get_corner(fan, count, (start + (is_backwards ? count - i : i)) % count);
    for (size_t i = 0; i + 2 < count; i++)
        memcpy(fan + 3 * i, (uint32_t[3]){ring[0], ring[i + 1], ring[i + 2]}, 3 * sizeof *fan);
}

static void align(const polygon_list *list, const polygon_fan *first, polygon_fan *fan,
                  uint32_t *ring) {
    size_t const count = (size_t)fan->count + 2;
    if (first->count != fan->count) return;
    int tries = 0;
    for (size_t start = 0; start < count && tries < START_LIMIT; start++) {
        if (!is_same_place(get_place(list, first, 0), get_place(list, fan, start))) continue;
        tries++;
        bool const is_backwards = goes_along(list, first, fan, start, true);
        if (!is_backwards && !goes_along(list, first, fan, start, false)) continue;
        fan->is_turned = is_backwards;
        move_fan(list->triangles + 3 * fan->first, count, start, is_backwards, ring);
        if (list->corner_uvs)
            move_fan(list->corner_uvs + 3 * fan->first, count, start, is_backwards, ring);
        return;
    }
}

/* False when memory is short. `ring`: room for the corners of any polygon. */
static bool align_doubles(memory *heap, const polygon_list *list, uint32_t *ring) {
    side_key *const keys = memory_allocate(heap, list->fan_count * sizeof *keys);
    if (!keys) return false;
    for (size_t i = 0; i < list->fan_count; i++) {
        list->fans[i].is_turned = false;
        keys[i] = (side_key){hash_sides(list, &list->fans[i]), i};
    }
    sort_in_place(keys, list->fan_count, sizeof *keys, compare_keys);
    for (size_t i = 1, start = 0; i < list->fan_count; i++) {
        if (keys[i].hash != keys[start].hash)
            start = i;
        else
            align(list, &list->fans[keys[start].fan], &list->fans[keys[i].fan], ring);
    }
    memory_release(heap, keys, list->fan_count * sizeof *keys);
    return true;
}

/* What corners have goes to where they are cut now. `ring`: room for the corners. */
static void move_corners(uint32_t *values, const uint32_t *corners, uint32_t triangle_count,
                         uint32_t *ring) {
    size_t const count = (size_t)triangle_count + 2;
    for (size_t i = 0; i < count; i++) ring[i] = get_corner(values, count, i);
    for (size_t i = 0; i < 3 * (size_t)triangle_count; i++) values[i] = ring[corners[i]];
}

static void turn(uint32_t *triangles, uint32_t count) {
    for (size_t i = 0; i < count; i++) {
        uint32_t const second = triangles[3 * i + 1];
        triangles[3 * i + 1] = triangles[3 * i + 2];
        triangles[3 * i + 2] = second;
    }
}

tulle_status polygons_cut(polygon_cutter *cutter, const polygon_list *list, tulle_error *error) {
    size_t most = 0;
    if (list->fan_count == 0) return TULLE_OK;
    for (size_t i = 0; i < list->fan_count; i++)
        most = list->fans[i].count > most ? list->fans[i].count : most;
    size_t const size = (most + 2) * sizeof(uint32_t);
    uint32_t *const ring = memory_allocate(cutter->heap, size);
    tulle_status status = TULLE_OK;
    if (!ring || !align_doubles(cutter->heap, list, ring))
        status = error_set_at(error, TULLE_ERROR_OUT_OF_MEMORY, cutter->path, 0, 0,
                              "out of memory for %zu polygons", list->fan_count);
    for (size_t i = 0; i < list->fan_count && status == TULLE_OK; i++) {
        const polygon_fan *const fan = &list->fans[i];
        uint32_t *const triangles = list->triangles + 3 * fan->first;
        uint32_t *const uvs = list->corner_uvs ? list->corner_uvs + 3 * fan->first : NULL;
        cutter->number = fan->number;
        status = polygon_cut(cutter, list->positions, triangles, fan->count, error);
        if (status == TULLE_OK && uvs && cutter->corners)
            move_corners(uvs, cutter->corners, fan->count, ring);
        if (status == TULLE_OK && fan->is_turned) turn(triangles, fan->count);
        if (status == TULLE_OK && fan->is_turned && uvs) turn(uvs, fan->count);
    }
    memory_release(cutter->heap, ring, size);
    return status;
}
