/* scene/make_attachments.c - attachments of cloths: names resolved to objects, regions to vertices.
 *
 * Which triangle holds a vertex, and whether one is near enough, the world finds at its start. */
#include "scene/scene_data.h"

#include <string.h>

static bool find_holder(const scene_work *work, const attach_keys *keys, size_t *object) {
    const tulle_scene *const loaded = work->scene;
    size_t const count = loaded->cloth_count + loaded->obstacle_count;
    for (*object = 0; *object < count; ++*object)
        if (strcmp(get_object_name(loaded, *object), keys->to) == 0) return true;
    const char **const names = ARENA_NEW(&work->scene->storage, const char *, count);
    for (size_t i = 0; names && i < count; i++) names[i] = get_object_name(loaded, i);
    problem_add(work->problems, TULLE_ERROR_INVALID_ARGUMENT, schema_place(keys, "to"),
                "%s.to: no cloth or obstacle is called '%s'%s", keys->head.path,
                show_text(keys->to).text, tell_meant(work, keys->to, names, count));
    return false;
}

/* The vertices that the keys name, in order, and the object. */
static bool make_attachment(const scene_work *work, const scene_cloth *cloth,
                            const attach_keys *keys, scene_attachment *made) {
    size_t const vertex_count = cloth->mesh.vertex_count;
    unsigned char *const marks =
        ARENA_NEW_ZEROED(&work->scene->storage, unsigned char, vertex_count);
    made->keys = keys;
    made->vertices = ARENA_NEW(&work->scene->storage, uint32_t, vertex_count);
    if (!marks || !made->vertices) {
        problem_add_memory(work->problems, work->scene->path);
        return false;
    }
    vertex_choice const choice = {&attach_map, keys, &keys->where};
    if (!find_holder(work, keys, &made->object) || !choose_vertices(work, cloth, &choice, 1, marks))
        return false;
    for (size_t v = 0; v < vertex_count; v++)
        if (marks[v]) made->vertices[made->vertex_count++] = (uint32_t)v;
    return made->vertex_count > 0 ||
           refuse_empty_choice(work, &cloth->mesh, &keys->head, "attaches no vertex");
}

bool make_attachments(const scene_work *work) {
    tulle_scene *const loaded = work->scene;
    bool is_good = true;
    for (size_t i = 0; i < loaded->cloth_count; i++) {
        scene_cloth *const cloth = &loaded->cloths[i];
        const schema_list *const list = &cloth->keys->attach;
        const attach_keys *const keys = list->items;
        cloth->attachments = ARENA_NEW_ZEROED(&loaded->storage, scene_attachment, list->count + 1);
        if (!cloth->attachments) {
            problem_add_memory(work->problems, loaded->path);
            return false;
        }
        for (size_t k = 0; k < list->count; k++)
            is_good &= make_attachment(work, cloth, &keys[k], &cloth->attachments[k]);
        cloth->attachment_count = list->count;
    }
    return is_good;
}
