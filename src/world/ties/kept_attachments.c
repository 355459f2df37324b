/* world/ties/kept_attachments.c - attachments that were made before the start, kept until then. */
#include "base/error.h"
#include "world/world_state.h"

#include <string.h>

/* A copy of an array, or null: of nothing, or without memory. */
static void *copy_array(memory *heap, const void *source, size_t byte_count) {
    void *const copy = source ? memory_allocate(heap, byte_count) : NULL;
    if (copy) memcpy(copy, source, byte_count);
    return copy;
}

static void release_def(memory *heap, tulle_attachment_def *def) {
    size_t const count = def->vertex_count;
    memory_release(heap, (void *)(uintptr_t)def->vertices, count * sizeof(uint32_t));
    memory_release(heap, (void *)(uintptr_t)def->points, 3 * count * sizeof(double));
    memory_release(heap, (void *)(uintptr_t)def->triangles, count * sizeof(uint32_t));
    memory_release(heap, (void *)(uintptr_t)def->weights, 3 * count * sizeof(double));
}

tulle_status world_keep_attachment(tulle_world *world, const tulle_attachment_def *def,
                                   tulle_error *error) {
    memory *const heap = &world->heap;
    size_t const count = def->vertex_count;
    tulle_attachment_def copy = *def;
    bool const has_room = ARRAY_RESERVE(heap, &world->attachments, 1);
    copy.vertices = copy_array(heap, def->vertices, count * sizeof(uint32_t));
    copy.points = copy_array(heap, def->points, 3 * count * sizeof(double));
    copy.triangles = copy_array(heap, def->triangles, count * sizeof(uint32_t));
    copy.weights = copy_array(heap, def->weights, 3 * count * sizeof(double));
    if (!has_room || !copy.vertices || (def->points && !copy.points) ||
        (def->triangles && !copy.triangles) || (def->weights && !copy.weights)) {
        release_def(heap, &copy);
        return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory left for an attachment");
    }
    world->attachments.data[world->attachments.count++] = copy;
    return TULLE_OK;
}

void world_release_attachments(tulle_world *world) {
    for (size_t i = 0; i < world->attachments.count; i++)
        release_def(&world->heap, &world->attachments.data[i]);
    ARRAY_FREE(&world->heap, &world->attachments);
}
