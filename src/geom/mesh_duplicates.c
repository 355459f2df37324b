/* geom/mesh_duplicates.c - triangles that have the same three corners as another one of their mesh,
 * in whatever order.
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

tulle_status tulle_mesh_drop_duplicates(tulle_mesh *mesh, uint32_t *lines,
                                        tulle_mesh_duplicates *duplicates, tulle_error *error) {
    if (!mesh || !duplicates || (mesh->triangle_count > 0 && !mesh->triangles))
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "mesh, its triangles and result may not be null");
    *duplicates = (tulle_mesh_duplicates){0};
    size_t const count = mesh->triangle_count;
    memory heap = memory_default();
    uint32_t *const originals = memory_allocate(&heap, count * sizeof *originals);
    size_t found = 0;
    bool has_memory =
        originals && mesh_find_duplicates(&heap, tulle_mesh_get_view(mesh), originals, &found);
    size_t const kept_bytes = 3 * (count - found) * sizeof *mesh->triangles;
    uint32_t *const kept = has_memory && found > 0 ? memory_allocate(&heap, kept_bytes) : NULL;
    has_memory &= found == 0 || kept;
    if (has_memory && found > 0) {
        size_t next = 0;
        for (size_t t = 0; t < count; t++) {
            if (originals[t] == TULLE_NONE) {
                memcpy(kept + 3 * next, mesh->triangles + 3 * t, 3 * sizeof *kept);
                if (lines) lines[next] = lines[t];
                next++;
            } else if (duplicates->count++ == 0) {
                duplicates->dropped = (uint32_t)t;
                duplicates->original = originals[t];
                /* nothing has been moved so far */
                duplicates->dropped_line = lines ? lines[t] : 0;
                duplicates->original_line = lines ? lines[originals[t]] : 0;
            }
        }
        memory_release(&heap, mesh->triangles, 3 * count * sizeof *mesh->triangles);
        mesh->triangles = kept;
        mesh->triangle_count = count - found;
    }
    memory_release(&heap, originals, count * sizeof *originals);
    if (has_memory) return TULLE_OK;
    return error_set(error, TULLE_ERROR_OUT_OF_MEMORY,
                     "no memory to look for duplicates among %zu triangles", count);
}
