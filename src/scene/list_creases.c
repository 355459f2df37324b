/* scene/list_creases.c - the edges of a cloth that a scene folds. */
#include "scene/rest_shape.h"

#include <string.h>

/* Edges between marked vertices, each once: of the two triangles at an edge one has it from its
 * lower vertex to its higher one. What is found is put into `creases`, unless that is null. */
static size_t find_edges(const tulle_mesh *mesh, const unsigned char *marks, double angle,
                         tulle_crease *creases) {
    size_t count = 0;
    for (size_t i = 0; i < 3 * mesh->triangle_count; i++) {
        uint32_t const a = mesh->triangles[i], b = mesh->triangles[i % 3 == 2 ? i - 2 : i + 1];
        if (a > b || !marks[a] || !marks[b]) continue;
        if (creases) creases[count] = (tulle_crease){{a, b}, angle};
        count++;
    }
    return count;
}

static bool mark(const rest_work *work, const crease_keys *keys, unsigned char *marks) {
    const tulle_mesh *const mesh = &work->cloth->mesh;
    vertex_choice const choice = {&crease_map, keys, &keys->where};
    memset(marks, 0, mesh->vertex_count);
    return choose_vertices(work->scene, work->cloth, &choice, 1, marks);
}

bool list_creases(const rest_work *work) {
    const schema_list *const list = &work->keys->rest.creases;
    const crease_keys *const keys = list->items;
    scene_cloth *const cloth = work->cloth;
    arena *const storage = &work->scene->scene->storage;
    if (list->count == 0) return true;
    unsigned char *const marks = ARENA_NEW(storage, unsigned char, cloth->mesh.vertex_count);
    size_t count = 0;
    bool is_good = true;
    for (size_t i = 0; marks && i < list->count; i++) {
        bool const is_marked = mark(work, &keys[i], marks);
        size_t const found = is_marked ? find_edges(&cloth->mesh, marks, 0.0, NULL) : 0;
        is_good &=
            is_marked && (found > 0 || refuse_empty_choice(work->scene, &cloth->mesh, &keys[i].head,
                                                           "no edge has both its ends in it"));
        count += found;
    }
    if (!is_good) return false;
    cloth->creases = marks ? ARENA_NEW(storage, tulle_crease, count) : NULL;
    if (!cloth->creases) {
        problem_add_memory(work->scene->problems, work->scene->scene->path);
        return false;
    }
    for (size_t i = 0; i < list->count; i++) {
        mark(work, &keys[i], marks);
        cloth->crease_count +=
            find_edges(&cloth->mesh, marks, keys[i].angle, cloth->creases + cloth->crease_count);
    }
    return true;
}
