/* scene/find_regions.c - the regions of a cloth, whose triangles shrink or have their warp
 * elsewhere.
 */
#include "scene/rest_shape.h"

#include <string.h>

/* Gives the region to the triangles whose corners are all marked. */
static bool mark_triangles(const rest_work *work, const region_keys *keys, uint32_t region,
                           const unsigned char *marks) {
    const tulle_mesh *const mesh = &work->cloth->mesh;
    size_t count = 0;
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        const uint32_t *const corners = mesh->triangles + 3 * t;
        if (!marks[corners[0]] || !marks[corners[1]] || !marks[corners[2]]) continue;
        work->regions[t] = region;
        count++;
    }
    return count > 0 || refuse_empty_choice(work->scene, mesh, &keys->head,
                                            "no triangle has all its corners in it");
}

bool find_regions(rest_work *work) {
    const schema_list *const list = &work->keys->regions;
    const tulle_mesh *const mesh = &work->cloth->mesh;
    if (list->count == 0) return true;
    arena *const storage = &work->scene->scene->storage;
    unsigned char *const marks = ARENA_NEW(storage, unsigned char, mesh->vertex_count);
    work->regions = ARENA_NEW(storage, uint32_t, mesh->triangle_count);
    if (!marks || !work->regions) {
        problem_add_memory(work->scene->problems, work->scene->scene->path);
        return false;
    }
    for (size_t t = 0; t < mesh->triangle_count; t++) work->regions[t] = UINT32_MAX;
    const region_keys *const regions = list->items;
    bool is_good = true;
    for (size_t i = 0; i < list->count; i++) {
        const region_keys *const keys = &regions[i];
        vertex_choice const choice = {&region_map,     keys, &keys->box, &keys->line,
                                      &keys->vertices, NULL};
        memset(marks, 0, mesh->vertex_count);
        is_good &= choose_vertices(work->scene, mesh, &choice, 1, marks) &&
                   mark_triangles(work, keys, (uint32_t)i, marks) &&
                   (!schema_is_given(&region_map, keys, "grain") ||
                    check_grain(work->scene, &keys->head, &keys->grain));
    }
    return is_good;
}

bool has_region_grain(const rest_work *work) {
    const region_keys *const regions = work->keys->regions.items;
    for (size_t i = 0; i < work->keys->regions.count; i++)
        if (schema_is_given(&region_map, &regions[i], "grain")) return true;
    return false;
}

bool has_region_shrink(const rest_work *work) {
    const region_keys *const regions = work->keys->regions.items;
    for (size_t i = 0; i < work->keys->regions.count; i++)
        if (regions[i].shrink != 1.0) return true;
    return false;
}
