/* geom/mesh_duplicates.c - triangles that an obstacle goes without: those that have the same three
 * corners as another one of their mesh, in whatever order, and those without area.
 *
 * Triangles are sorted by their ascending corners, so that duplicates follow each other. Cost
 * O(n log n). */
#include "geom/mesh.h"

#include "base/error.h"

#include <stdlib.h>
#include <string.h>

/* A triangle by its ascending corners. */
typedef struct triangle_key {
    uint32_t corners[3], triangle;
} triangle_key;

static int compare_keys(const void *first, const void *second) {
    const triangle_key *const a = first, *const b = second;
    for (int k = 0; k < 3; k++)
        if (a->corners[k] != b->corners[k]) return a->corners[k] < b->corners[k] ? -1 : 1;
    return a->triangle < b->triangle ? -1 : a->triangle > b->triangle;
}

static triangle_key make_key(const uint32_t *corner, uint32_t triangle) {
    uint32_t low = corner[0], middle = corner[1], high = corner[2], swap;
    if (low > middle) swap = low, low = middle, middle = swap;
    if (middle > high) swap = middle, middle = high, high = swap;
    if (low > middle) swap = low, low = middle, middle = swap;
    return (triangle_key){{low, middle, high}, triangle};
}

static bool has_same_corners(const triangle_key *a, const triangle_key *b) {
    return a->corners[0] == b->corners[0] && a->corners[1] == b->corners[1] &&
           a->corners[2] == b->corners[2];
}

bool mesh_find_duplicates(memory *heap, tulle_mesh_view mesh, uint32_t *originals,
                          size_t *duplicate_count) {
    size_t const count = mesh.triangle_count;
    triangle_key *const keys = memory_allocate(heap, count * sizeof *keys);
    if (!keys) return false;
    for (size_t t = 0; t < count; t++) keys[t] = make_key(mesh.triangles + 3 * t, (uint32_t)t);
    qsort(keys, count, sizeof *keys, compare_keys);
    *duplicate_count = 0;
    for (size_t k = 0, start = 0; k < count; k++) {
        bool const is_duplicate = k > 0 && has_same_corners(&keys[k], &keys[start]);
        if (!is_duplicate) start = k;
        originals[keys[k].triangle] = is_duplicate ? keys[start].triangle : TULLE_NONE;
        *duplicate_count += is_duplicate;
    }
    memory_release(heap, keys, count * sizeof *keys);
    return true;
}

tulle_status tulle_mesh_find_degenerate(tulle_mesh_view mesh, uint8_t *marks, size_t *count,
                                        tulle_error *error) {
    tulle_status status = mesh_check_indices(mesh, error);
    if (status == TULLE_OK && mesh.triangle_count > 0 && !marks)
        status = error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "the marks are null");
    if (status != TULLE_OK) return status;
    size_t found = 0;
    for (size_t t = 0; t < mesh.triangle_count; t++) {
        const uint32_t *const corner = mesh.triangles + 3 * t;
        bool const is_proper =
            corner[0] != corner[1] && corner[1] != corner[2] && corner[2] != corner[0] &&
            triangle_get_height_ratio(mesh.positions, corner) >= THIN_TRIANGLE_RATIO;
        marks[t] = !is_proper;
        found += !is_proper;
    }
    if (count) *count = found;
    return TULLE_OK;
}

tulle_status tulle_mesh_drop_marked(tulle_mesh *mesh, const uint8_t *marks, uint32_t *lines,
                                    tulle_error *error) {
    if (!mesh || (mesh->triangle_count > 0 && (!mesh->triangles || !marks)))
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "mesh, its triangles and marks may not be null");
    size_t const count = mesh->triangle_count;
    size_t kept_count = 0;
    for (size_t t = 0; t < count; t++) kept_count += marks[t] == 0;
    if (kept_count == count) return TULLE_OK;
    memory heap = memory_default();
    uint32_t *const kept =
        kept_count > 0 ? memory_allocate(&heap, 3 * kept_count * sizeof *kept) : NULL;
    if (kept_count > 0 && !kept)
        return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory for %zu triangles",
                         kept_count);
    for (size_t t = 0, next = 0; t < count; t++) {
        if (marks[t]) continue;
        memcpy(kept + 3 * next, mesh->triangles + 3 * t, 3 * sizeof *kept);
        if (lines) lines[next] = lines[t];
        next++;
    }
    memory_release(&heap, mesh->triangles, 3 * count * sizeof *mesh->triangles);
    mesh->triangles = kept;
    mesh->triangle_count = kept_count;
    return TULLE_OK;
}

tulle_status tulle_mesh_drop_duplicates(tulle_mesh *mesh, uint32_t *lines,
                                        tulle_mesh_duplicates *duplicates, tulle_error *error) {
    if (!mesh || !duplicates || (mesh->triangle_count > 0 && !mesh->triangles))
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "mesh, its triangles and result may not be null");
    *duplicates = (tulle_mesh_duplicates){0};
    size_t const count = mesh->triangle_count;
    memory heap = memory_default();
    uint32_t *const originals = memory_allocate(&heap, count * sizeof *originals);
    uint8_t *const marks = memory_allocate(&heap, count);
    tulle_mesh_duplicates found = {0};
    tulle_status status = TULLE_ERROR_OUT_OF_MEMORY;
    if (originals && marks &&
        mesh_find_duplicates(&heap, tulle_mesh_get_view(mesh), originals, &found.count)) {
        for (size_t t = count; t-- > 0;) {
            marks[t] = originals[t] != TULLE_NONE;
            if (!marks[t]) continue;
            found.dropped = (uint32_t)t;
            found.original = originals[t];
            found.dropped_line = lines ? lines[t] : 0;
            found.original_line = lines ? lines[originals[t]] : 0;
        }
        status = tulle_mesh_drop_marked(mesh, marks, lines, NULL);
    }
    memory_release(&heap, originals, count * sizeof *originals);
    memory_release(&heap, marks, count);
    if (status != TULLE_OK)
        return error_set(error, status, "no memory to look for duplicates among %zu triangles",
                         count);
    *duplicates = found;
    return TULLE_OK;
}
