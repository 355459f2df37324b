/* scene/find_regions.c - the regions of a cloth, whose triangles shrink, are stiffer or softer, or
 * have their warp elsewhere. */
#include "scene/rest_shape.h"

#include <string.h>

/* Gives the region to its triangles: those of a part of the mesh file, or those whose corners are
 * all chosen. `marks`: room for one of each vertex and of each triangle. */
static bool mark_triangles(const rest_work *work, const region_keys *keys, uint32_t region,
                           unsigned char *marks) {
    const tulle_mesh *const mesh = &work->cloth->mesh;
    vertex_choice const choice = {&region_map, keys, &keys->where};
    size_t count = 0;
    if (names_part(&choice)) {
        memset(marks, 0, mesh->triangle_count);
        if (!choose_part(work->scene, work->cloth, &choice, marks)) return false;
        for (size_t t = 0; t < mesh->triangle_count; t++)
            if (marks[t]) work->regions[t] = region;
        return true;
    }
    memset(marks, 0, mesh->vertex_count);
    if (!choose_vertices(work->scene, work->cloth, &choice, 1, marks)) return false;
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
    size_t const most =
        mesh->vertex_count > mesh->triangle_count ? mesh->vertex_count : mesh->triangle_count;
    unsigned char *const marks = ARENA_NEW(storage, unsigned char, most);
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
        is_good &= mark_triangles(work, keys, (uint32_t)i, marks) &&
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

bool has_region_stiffness(const rest_work *work) {
    const region_keys *const regions = work->keys->regions.items;
    for (size_t i = 0; i < work->keys->regions.count; i++)
        if (regions[i].stiffness != 1.0) return true;
    return false;
}
