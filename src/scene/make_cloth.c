/* scene/make_cloth.c - cloth of a scene: mesh, placement, pins resolved to vertices. */
#include "scene/scene_data.h"

#include <math.h>
#include <string.h>

bool make_cloth(const scene_work *work, const cloth_keys *keys, size_t index, scene_cloth *cloth) {
    cloth->keys = keys;
    cloth->name = keys->name ? keys->name : store_text(work, "cloth%zu", index);
    bool is_good = cloth->name != NULL;
    is_good &= make_material(work, &keys->material, cloth);
    tulle_mesh_source source = {0};
    if (!make_mesh(work, &keys->mesh, TULLE_MESH_ROLE_CLOTH, &cloth->mesh, &source)) return false;
    tulle_mesh_transform(&cloth->mesh, keys->scale.value, keys->rotate.quaternion,
                         keys->translate.value);
    is_good &= count_mesh(work, &cloth->mesh, keys->mesh.head.place, keys->mesh.head.path);
    is_good = is_good && make_rest(work, keys, &source, cloth);
    tulle_mesh_source_destroy(&source);
    return is_good && make_pins(work, cloth);
}

/* Which vertices are free still, and which the pin at hand takes. */
typedef struct pin_work {
    const scene_work *scene;
    scene_cloth *cloth;
    const pin_keys *keys;
    unsigned char *marks; /* 1: taken by an earlier pin, 2: by this one */
} pin_work;

static bool is_in_box(const box_keys *box, const double *p) {
    for (int k = 0; k < 3; k++)
        if (p[k] < box->min.value[k] || p[k] > box->max.value[k]) return false;
    return true;
}

static double distance_to_segment(const double a[3], const double b[3], const double p[3]) {
    double along = 0, length = 0, squared = 0;
    for (int k = 0; k < 3; k++) {
        along += (p[k] - a[k]) * (b[k] - a[k]);
        length += (b[k] - a[k]) * (b[k] - a[k]);
    }
    double t = length > 0 ? fmin(fmax(along / length, 0), 1) : 0;
    for (int k = 0; k < 3; k++) {
        double d = p[k] - a[k] - t * (b[k] - a[k]);
        squared += d * d;
    }
    return sqrt(squared);
}

static size_t find_nearest(const tulle_mesh *mesh, const double point[3]) {
    size_t nearest = 0;
    double smallest = INFINITY;
    for (size_t v = 0; v < mesh->vertex_count; v++) {
        double distance = distance_to_segment(point, point, mesh->positions + 3 * v);
        if (distance < smallest) smallest = distance, nearest = v;
    }
    return nearest;
}

/* Marks the vertices that the pin names. False after a problem. */
static bool mark_vertices(const pin_work *work) {
    const pin_keys *keys = work->keys;
    const tulle_mesh *mesh = &work->cloth->mesh;
    if (schema_is_given(&pin_map, keys, "vertices")) {
        for (size_t i = 0; i < keys->vertices.count; i++) {
            if (keys->vertices.value[i] < mesh->vertex_count) {
                work->marks[keys->vertices.value[i]] |= 2;
                continue;
            }
            problem_add(work->scene->problems, TULLE_ERROR_INVALID_ARGUMENT,
                        schema_place(keys, "vertices"),
                        "%s.vertices: names vertex %u, must be below %zu, the cloth's number of "
                        "vertices",
                        keys->head.path, (unsigned)keys->vertices.value[i], mesh->vertex_count);
            return false;
        }
        return true;
    }
    if (schema_is_given(&pin_map, keys, "nearest")) {
        work->marks[find_nearest(mesh, keys->nearest.value)] |= 2;
        return true;
    }
    bool is_box = schema_is_given(&pin_map, keys, "box");
    for (size_t v = 0; v < mesh->vertex_count; v++) {
        const double *p = mesh->positions + 3 * v;
        bool is_in = is_box ? is_in_box(&keys->box, p)
                            : distance_to_segment(keys->line.from.value, keys->line.to.value, p) <=
                                  keys->line.radius;
        if (is_in) work->marks[v] |= 2;
    }
    return true;
}

static bool refuse_empty_pin(const pin_work *work) {
    double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
    for (size_t i = 0; i < 3 * work->cloth->mesh.vertex_count; i++) {
        low[i % 3] = fmin(low[i % 3], work->cloth->mesh.positions[i]);
        high[i % 3] = fmax(high[i % 3], work->cloth->mesh.positions[i]);
    }
    problem_add(work->scene->problems, TULLE_ERROR_INVALID_ARGUMENT, work->keys->head.place,
                "%s: pins no vertex that is not pinned already; the cloth begins within [%g, %g, "
                "%g] and [%g, %g, %g]",
                work->keys->head.path, low[0], low[1], low[2], high[0], high[1], high[2]);
    return false;
}

/* Lists the marked vertices that no earlier pin took, in order. */
static bool collect_vertices(const pin_work *work, tulle_pin *pin) {
    size_t count = 0, vertex_count = work->cloth->mesh.vertex_count;
    for (size_t v = 0; v < vertex_count; v++) count += work->marks[v] == 2;
    if (count == 0) return refuse_empty_pin(work);
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
