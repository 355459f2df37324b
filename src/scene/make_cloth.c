/* scene/make_cloth.c - cloth of a scene: mesh, placement, pins resolved to vertices. */
#include "scene/scene_data.h"

#include "math/vec3.h"

#include <math.h>
#include <string.h>

bool check_grain(const scene_work *work, const schema_head *head, const schema_vector *grain) {
    if (vec3_norm(vec3_load(grain->value, 0)) > 0.0) return true;
    problem_add(work->problems, TULLE_ERROR_INVALID_ARGUMENT, schema_place(head, "grain"),
                "%s.grain: is not a direction; give for example [0, 1, 0]", head->path);
    return false;
}

/* Texture coordinates follow the corners that change places where the mesh is mirrored. */
static void mirror_corners(const scene_cloth *cloth) {
    const double *const scale = cloth->place.scale;
    double *const uvs = cloth->source.corner_uvs;
    bool const is_mirrored = (scale[0] < 0.0) ^ (scale[1] < 0.0) ^ (scale[2] < 0.0);
    for (size_t t = 0; is_mirrored && uvs && t < cloth->mesh.triangle_count; t++)
        for (size_t k = 6 * t + 2; k < 6 * t + 4; k++) {
            double const second = uvs[k];
            uvs[k] = uvs[k + 2];
            uvs[k + 2] = second;
        }
}

bool make_cloth(const scene_work *work, const cloth_keys *keys, size_t index, scene_cloth *cloth) {
    cloth->keys = keys;
    cloth->name = keys->name ? keys->name : store_text(work, "cloth%zu", index);
    bool is_good = cloth->name != NULL && check_grain(work, &keys->head, &keys->grain);
    is_good &= make_material(work, &keys->material, cloth);
    placement_keys const where = {&keys->scale, &keys->rotate, &keys->place};
    source_mesh source = {.mesh = &cloth->mesh};
    if (!make_mesh(work, &keys->mesh, TULLE_MESH_ROLE_CLOTH, &source, &cloth->source) ||
        !find_placement(work, &where, &source, cloth->name, &cloth->place))
        return false;
    mirror_corners(cloth);
    place_cloth_mesh(cloth, &cloth->mesh);
    is_good &= count_mesh(work, &cloth->mesh, keys->mesh.head.place, keys->mesh.head.path);
    return is_good && make_rest(work, keys, cloth) && make_pins(work, cloth);
}

/* Which vertices are free still, and which the pin at hand takes. */
typedef struct pin_work {
    const scene_work *scene;
    scene_cloth *cloth;
    const pin_keys *keys;
    unsigned char *marks; /* 1: taken by an earlier pin, 2: by this one */
} pin_work;

static bool mark_vertices(const pin_work *work) {
    const pin_keys *const keys = work->keys;
    vertex_choice const choice = {&pin_map, keys, &keys->where};
    return choose_vertices(work->scene, work->cloth, &choice, 2, work->marks);
}

/* Lists the marked vertices that no earlier pin took, in order. */
static bool collect_vertices(const pin_work *work, tulle_pin *pin) {
    size_t count = 0, taken = 0, vertex_count = work->cloth->mesh.vertex_count;
    for (size_t v = 0; v < vertex_count; v++) {
        count += work->marks[v] == 2;
        taken += work->marks[v] == 1;
    }
    if (count == 0)
        return refuse_empty_choice(work->scene, &work->cloth->mesh, &work->keys->head,
                                   taken > 0 ? "pins no vertex that is not pinned already"
                                             : "pins no vertex");
    uint32_t *vertices = ARENA_NEW(&work->scene->scene->storage, uint32_t, count);
    if (!vertices) {
        problem_add_memory(work->scene->problems, work->scene->scene->path);
        return false;
    }
    pin->vertices = vertices;
    for (size_t v = 0; v < vertex_count; v++) {
        if (work->marks[v] == 2) vertices[pin->vertex_count++] = (uint32_t)v;
        if (work->marks[v]) work->marks[v] = 1;
    }
    return true;
}

static bool make_pin(const pin_work *work, tulle_pin *pin) {
    const pin_keys *keys = work->keys;
    *pin = tulle_pin_default();
    pin->release_time = keys->release;
    if (!mark_vertices(work) || !collect_vertices(work, pin)) return false;
    const double *positions = work->cloth->mesh.positions;
    for (int k = 0; k < 3; k++) {
        double sum = 0;
        for (size_t i = 0; i < pin->vertex_count; i++)
            sum += positions[3 * (size_t)pin->vertices[i] + (size_t)k];
        bool is_given = schema_is_given(&pin_map, keys, "pivot");
        pin->motion.pivot[k] = is_given ? keys->pivot.value[k] : sum / (double)pin->vertex_count;
    }
    pin->motion.is_eased = keys->eased;
    return make_motion(work->scene, &keys->keyframes, &POSE_IDENTITY, 0, &pin->motion);
}

bool make_pins(const scene_work *work, scene_cloth *cloth) {
    const schema_list *list = &cloth->keys->pins;
    const pin_keys *keys = list->items;
    pin_work pins = {work, cloth, NULL, NULL};
    cloth->pins = ARENA_NEW_ZEROED(&work->scene->storage, tulle_pin, list->count + 1);
    pins.marks = ARENA_NEW_ZEROED(&work->scene->storage, unsigned char, cloth->mesh.vertex_count);
    if (!cloth->pins || !pins.marks) {
        problem_add_memory(work->problems, work->scene->path);
        return false;
    }
    bool is_good = true;
    for (size_t i = 0; i < list->count; i++) {
        pins.keys = &keys[i];
        is_good &= make_pin(&pins, &cloth->pins[i]);
    }
    cloth->pin_count = list->count;
    return is_good;
}
