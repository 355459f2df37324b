/* detect/patches/patch_staging.c - from a list of triangles to a patch in the arrays of all
 * patches: takes triangles in the order in which they joined, writes them with their vertices,
 * corners and boundary behind all patches; commit_patch then makes them part of those. And the
 * scratch of growth. */
#include "detect/patches/kept_patches_parts.h"

enum { SORTED_SHARE = 16 /* patches of more than one in that many triangles are large */ };

tulle_status reserve_growth(kept_patches *patches) {
    growth_scratch *const growth = &patches->growth;
    if (growth->next) return TULLE_OK;
    size_t const triangle_count = patches->topo->triangle_count;
    size_t const vertex_count = patches->topo->vertex_count;
    memory *const heap = patches->heap;
    if (!growth->queue)
        growth->queue = memory_allocate_zeroed(heap, triangle_count, sizeof(uint32_t));
    if (!growth->local)
        growth->local = memory_allocate_zeroed(heap, vertex_count, sizeof(uint32_t));
    if (!growth->stamps)
        growth->stamps = memory_allocate_zeroed(heap, vertex_count, sizeof(uint32_t));
    if (!growth->queue || !growth->local || !growth->stamps) return TULLE_ERROR_OUT_OF_MEMORY;
    growth->next = memory_allocate_zeroed(heap, vertex_count, sizeof(uint32_t));
    return growth->next ? TULLE_OK : TULLE_ERROR_OUT_OF_MEMORY;
}

void release_cones(kept_patches *patches) {
    growth_scratch *const growth = &patches->growth;
    size_t const count = patches->topo->triangle_count;
    if (!patches->scratch) {
        memory_release(patches->heap, growth->cones, count * sizeof *growth->cones);
        memory_release(patches->heap, growth->limits, count * sizeof *growth->limits);
    }
    growth->cones = NULL;
    growth->limits = NULL;
}

void start_patch(kept_patches *patches) {
    growth_scratch *const growth = &patches->growth;
    if (growth->stamp == UINT32_MAX) {
        for (size_t i = 0; i < patches->topo->vertex_count; i++) growth->stamps[i] = 0;
        growth->stamp = 0;
    }
    growth->stamp++;
}

tulle_status stage_patch(kept_patches *patches, const uint32_t *list, size_t count, uint32_t label,
                         bool is_disc, kept_patch *patch) {
    memory *const heap = patches->heap;
    if (!ARRAY_RESERVE(heap, &patches->triangles, count) ||
        !ARRAY_RESERVE(heap, &patches->corners, 3 * count))
        return TULLE_ERROR_OUT_OF_MEMORY;
    growth_scratch *const growth = &patches->growth;
    uint32_t *const corners = patches->corners.data + patches->corners.count;
    uint32_t vertex_count = 0;
    start_patch(patches);
    for (size_t i = 0; i < count; i++) {
        for (size_t k = 0; k < 3; k++) {
            uint32_t const vertex = patches->topo->triangles[3 * (size_t)list[i] + k];
            if (!is_in_patch(growth, vertex)) {
                growth->stamps[vertex] = growth->stamp;
                growth->local[vertex] = vertex_count++;
            }
            corners[3 * i + k] = growth->local[vertex];
        }
    }
    if (!ARRAY_RESERVE(heap, &patches->vertices, vertex_count) ||
        !array_reserve(heap, (void **)&patches->points.data, &patches->points.capacity,
                       patches->vertices.count, patches->vertices.count + vertex_count,
                       sizeof *patches->points.data))
        return TULLE_ERROR_OUT_OF_MEMORY;
    uint32_t *const vertices = patches->vertices.data + patches->vertices.count;
    for (size_t i = 0; i < count; i++) {
        patches->triangles.data[patches->triangles.count + i] = list[i];
        for (size_t k = 0; k < 3; k++)
            vertices[corners[3 * i + k]] = patches->topo->triangles[3 * (size_t)list[i] + k];
    }
    patch->triangle_begin = (uint32_t)patches->triangles.count;
    patch->triangle_count = (uint32_t)count;
    patch->vertex_begin = (uint32_t)patches->vertices.count;
    patch->vertex_count = vertex_count;
    patch->surface = patches->triangle_surface[list[0]];
    patch->loop_begin = (uint32_t)patches->loops.count;
    patch->loop_count = 0;
    if (!is_disc) return TULLE_OK;

    /* The boundary: edges without a neighbour of the same label, each of which tells the next. */
    uint32_t *const next = growth->next;
    uint32_t edge_count = 0, first = TULLE_NONE;
    for (size_t i = 0; i < count; i++) {
        for (size_t k = 0; k < 3; k++) {
            uint32_t const other = patches->neighbours[3 * (size_t)list[i] + k];
            if (other < NEIGHBOUR_BARRED && patches->labels[other] == label) continue;
            next[corners[3 * i + k]] = corners[3 * i + (k + 1) % 3];
            if (corners[3 * i + k] < first) first = corners[3 * i + k];
            edge_count++;
        }
    }
    if (first == TULLE_NONE) return TULLE_OK;
    if (!ARRAY_RESERVE(heap, &patches->loops, edge_count)) return TULLE_ERROR_OUT_OF_MEMORY;
    uint32_t *const loop = patches->loops.data + patches->loops.count;
    uint32_t loop_count = 0, at = first;
    do {
        loop[loop_count++] = at;
        at = next[at];
    } while (at != first && loop_count < edge_count);
    if (at == first && loop_count == edge_count) patch->loop_count = loop_count;
    return TULLE_OK;
}

void commit_patch(kept_patches *patches, const kept_patch *patch, uint32_t label) {
    const topology *const topo = patches->topo;
    if (patch->triangle_count > topo->triangle_count / SORTED_SHARE) {
        /* Vertices and corners of a large patch are put in the order of the mesh: numbers near one
         * another are mostly near in memory there, while growth goes round in rings. */
        growth_scratch *const growth = &patches->growth;
        uint32_t *const vertices = patches->vertices.data + patch->vertex_begin;
        uint32_t *const loop =
            patch->loop_count > 0 ? patches->loops.data + patch->loop_begin : NULL;
        uint32_t *corner = patches->corners.data + 3 * (size_t)patch->triangle_begin;
        uint32_t count = 0;
        for (uint32_t i = 0; i < patch->loop_count; i++) loop[i] = vertices[loop[i]];
        for (uint32_t v = 0; v < topo->vertex_count; v++) {
            if (!is_in_patch(growth, v)) continue;
            growth->local[v] = count;
            vertices[count++] = v;
        }
        for (uint32_t i = 0; i < patch->loop_count; i++) loop[i] = growth->local[loop[i]];
        for (size_t i = 0; i < topo->triangle_count; i++) {
            if (patches->labels[i] != label) continue;
            for (size_t k = 0; k < 3; k++) *corner++ = growth->local[topo->triangles[3 * i + k]];
        }
    }
    patches->triangles.count += patch->triangle_count;
    patches->corners.count += 3 * (size_t)patch->triangle_count;
    patches->vertices.count += patch->vertex_count;
    patches->points.count = patches->vertices.count;
    patches->loops.count += patch->loop_count;
    patches->patches.data[label - 1] = *patch;
    patches->has_tasks = false;
}
