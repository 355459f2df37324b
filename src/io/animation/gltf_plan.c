/* io/animation/gltf_plan.c - see gltf_plan.h. */
#include "io/animation/gltf_plan.h"

#include "base/error.h"
#include "base/hash.h"
#include "io/file_data.h"

#include <errno.h>
#include <math.h>
#include <string.h>

size_t gltf_part_get_source(const gltf_part *part, size_t vertex_count, size_t written) {
    return written < vertex_count ? written : part->extra_sources[written - vertex_count];
}

/* ---- vertices with several texture coordinates ---- */

/* Makes written vertices of corners. Finds those that are there in an open-addressed table of their
 * numbers, which is at most half full. */
typedef struct corner_splitter {
    memory *heap;
    const tulle_animation_surface *surface;
    gltf_part *part;
    bool *has_uv; /* of each vertex: some corner has given it texture coordinates */
    uint32_t *slots;
    size_t slot_count; /* a power of two */
} corner_splitter;

/* Texture coordinates of a corner as glTF has them: v from the top down; 0 where there are none. */
static void get_uv(const tulle_animation_surface *surface, size_t corner, float uv[2]) {
    const double *const from = surface->corner_uvs + 2 * corner;
    uv[0] = (float)from[0];
    uv[1] = (float)(1.0 - from[1]);
    if (!isfinite(uv[0]) || !isfinite(uv[1])) uv[0] = uv[1] = 0.0f;
}

static bool add_extra_vertex(corner_splitter *splitter, uint32_t vertex, const float uv[2]) {
    gltf_part *const part = splitter->part;
    size_t const original_count = splitter->surface->mesh.vertex_count;
    size_t const extra_count = part->vertex_count - original_count;
    if (!array_reserve(splitter->heap, (void **)&part->extra_sources, &part->extra_capacity,
                       extra_count, extra_count + 1, sizeof(uint32_t)) ||
        !array_reserve(splitter->heap, (void **)&part->uvs, &part->uv_capacity, part->vertex_count,
                       part->vertex_count + 1, 2 * sizeof(float)))
        return false;
    part->extra_sources[extra_count] = vertex;
    memcpy(part->uvs + 2 * part->vertex_count, uv, 2 * sizeof(float));
    part->vertex_count++;
    return true;
}

/* The number under which a corner is written; false when memory is short. */
static bool find_written(corner_splitter *splitter, size_t corner, uint32_t *written) {
    gltf_part *const part = splitter->part;
    size_t const original_count = splitter->surface->mesh.vertex_count;
    uint32_t const vertex = splitter->surface->mesh.triangles[corner];
    float uv[2];
    get_uv(splitter->surface, corner, uv);
    uint32_t key[3] = {vertex};
    memcpy(key + 1, uv, sizeof uv);
    size_t const mask = splitter->slot_count - 1;
    size_t slot = (size_t)hash_mix(hash_bytes(HASH_SEED, key, sizeof key)) & mask;
    for (; splitter->slots[slot] != TULLE_NONE; slot = (slot + 1) & mask) {
        *written = splitter->slots[slot];
        if (gltf_part_get_source(part, original_count, *written) == vertex &&
            memcmp(part->uvs + 2 * (size_t)*written, uv, sizeof uv) == 0)
            return true;
    }
    *written = vertex;
    if (splitter->has_uv[vertex]) {
        *written = (uint32_t)part->vertex_count;
        if (!add_extra_vertex(splitter, vertex, uv)) return false;
    } else {
        splitter->has_uv[vertex] = true;
        memcpy(part->uvs + 2 * (size_t)vertex, uv, sizeof uv);
    }
    splitter->slots[slot] = *written;
    return true;
}

static bool split_corners(corner_splitter *splitter) {
    gltf_part *const part = splitter->part;
    tulle_mesh_view const mesh = splitter->surface->mesh;
    splitter->slot_count = 64;
    while (splitter->slot_count < 6 * mesh.triangle_count) splitter->slot_count *= 2;
    splitter->slots = memory_allocate(splitter->heap, splitter->slot_count * sizeof(uint32_t));
    splitter->has_uv = memory_allocate_zeroed(splitter->heap, mesh.vertex_count, sizeof(bool));
    part->split_triangles =
        memory_allocate(splitter->heap, 3 * mesh.triangle_count * sizeof(uint32_t));
    bool is_fine = splitter->slots && splitter->has_uv && part->split_triangles &&
                   array_reserve(splitter->heap, (void **)&part->uvs, &part->uv_capacity, 0,
                                 mesh.vertex_count, 2 * sizeof(float));
    if (is_fine) {
        memset(splitter->slots, 0xff, splitter->slot_count * sizeof(uint32_t));
        memset(part->uvs, 0, mesh.vertex_count * 2 * sizeof(float));
    }
    for (size_t i = 0; i < 3 * mesh.triangle_count && is_fine; i++)
        is_fine = find_written(splitter, i, &part->split_triangles[i]);
    memory_release(splitter->heap, splitter->slots, splitter->slot_count * sizeof(uint32_t));
    memory_release(splitter->heap, splitter->has_uv, mesh.vertex_count * sizeof(bool));
    part->triangles = part->split_triangles;
    return is_fine;
}

/* ---- places ---- */

static uint64_t take(uint64_t *size, uint64_t byte_count) {
    uint64_t const place = *size;
    *size += byte_count;
    return place;
}

static void place_mesh(const tulle_animation_def *def, gltf_plan *plan, size_t number) {
    gltf_part *const part = &plan->parts[number];
    uint64_t const triangle_count = def->surfaces[number].mesh.triangle_count;
    uint64_t const kinds = triangle_count > 0 ? 2 : 1; /* positions and normals */
    part->mesh = plan->mesh_count++;
    part->first_accessor = plan->accessor_count;
    plan->accessor_count += (triangle_count > 0) + kinds + (part->uvs != NULL);
    plan->accessor_count += kinds * part->target_count;
    part->index_place = take(&plan->sizes[GLTF_VIEW_INDICES], 12 * triangle_count);
    if (part->uvs) part->uv_place = take(&plan->sizes[GLTF_VIEW_UVS], 8 * part->vertex_count);
    part->vector_place = take(&plan->sizes[GLTF_VIEW_VECTORS],
                              12 * part->vertex_count * kinds * (part->target_count + 1));
    plan->has_weights = plan->has_weights || part->target_count > 0;
}

static void place_drives(const tulle_animation_def *def, gltf_plan *plan) {
    uint64_t *const size = &plan->sizes[GLTF_VIEW_DRIVES];
    uint64_t const frame_count = def->frame_count;
    bool is_moving = false;
    for (size_t i = 0; i < def->surface_count; i++)
        is_moving = is_moving || animation_is_moving(def, i);
    if (!is_moving) return;
    plan->time_accessor = plan->accessor_count++;
    take(size, 4 * frame_count);
    if (plan->has_weights) {
        plan->weight_accessor = plan->accessor_count++;
        plan->weight_place =
            take(size, frame_count > GLTF_DENSE_TARGETS ? 8 * frame_count /* indices and values */
                                                        : 4 * frame_count * frame_count);
    }
    for (size_t i = 0; i < def->surface_count; i++) {
        if (def->surfaces[i].motion != TULLE_ANIMATION_RIGID) continue;
        plan->parts[i].drive_accessor = plan->accessor_count;
        plan->accessor_count += 2;
        plan->parts[i].drive_place = take(size, 28 * frame_count);
    }
}

tulle_status gltf_plan_make(animation_job *job, gltf_plan *plan, tulle_error *error) {
    const tulle_animation_def *const def = job->def;
    *plan = (gltf_plan){0};
    plan->parts = memory_allocate_zeroed(&job->heap, def->surface_count, sizeof *plan->parts);
    bool has_memory = plan->parts != NULL;
    for (size_t i = 0; i < def->surface_count && has_memory; i++) {
        const tulle_animation_surface *const surface = &def->surfaces[i];
        gltf_part *const part = &plan->parts[i];
        part->is_own = surface->prototype == i;
        part->vertex_count = surface->mesh.vertex_count;
        part->triangles = surface->mesh.triangles;
        if (!part->is_own) continue;
        if (surface->motion == TULLE_ANIMATION_DEFORMS && def->frame_count > 1)
            part->target_count = def->frame_count;
        if (surface->corner_uvs && surface->mesh.triangle_count > 0) {
            corner_splitter splitter = {.heap = &job->heap, .surface = surface, .part = part};
            has_memory = split_corners(&splitter);
        }
        place_mesh(def, plan, i);
    }
    if (!has_memory) return file_fail(error, job->path, ENOMEM, "cannot be written");
    for (size_t i = 0; i < def->surface_count; i++)
        if (!plan->parts[i].is_own)
            plan->parts[i].mesh = plan->parts[def->surfaces[i].prototype].mesh;
    place_drives(def, plan);
    for (int i = 0; i < GLTF_VIEW_COUNT; i++) plan->total += plan->sizes[i];
    return TULLE_OK;
}

void gltf_plan_destroy(animation_job *job, gltf_plan *plan) {
    for (size_t i = 0; i < job->def->surface_count && plan->parts; i++) {
        gltf_part *const part = &plan->parts[i];
        if (part->split_triangles)
            memory_release(&job->heap, part->split_triangles,
                           3 * job->def->surfaces[i].mesh.triangle_count * sizeof(uint32_t));
        memory_release(&job->heap, part->extra_sources, part->extra_capacity * sizeof(uint32_t));
        memory_release(&job->heap, part->uvs, part->uv_capacity * 2 * sizeof(float));
    }
    memory_release(&job->heap, plan->parts, job->def->surface_count * sizeof *plan->parts);
    *plan = (gltf_plan){0};
}

uint64_t gltf_plan_get_offset(const gltf_plan *plan, gltf_view view) {
    uint64_t offset = 0;
    for (int i = 0; i < (int)view; i++) offset += plan->sizes[i];
    return offset;
}

int gltf_plan_get_view(const gltf_plan *plan, gltf_view view) {
    int number = 0;
    for (int i = 0; i < (int)view; i++) number += plan->sizes[i] > 0;
    return number;
}
