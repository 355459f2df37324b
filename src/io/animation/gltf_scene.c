/* io/animation/gltf_scene.c - reads nodes and meshes of a glTF file. */
#include "io/animation/gltf_scene.h"

#include "base/error.h"
#include "io/animation/expansion.h"
#include "io/file_data.h"

#include <string.h>

enum { INDEX_WINDOW = 768 /* read at a time; whole triangles */ };
#define VERTEX_LIMIT ((size_t)INT32_MAX)

typedef enum primitive_mode {
    MODE_POINTS = 0,
    MODE_TRIANGLES = 4,
    MODE_STRIP = 5,
    MODE_FAN = 6
} primitive_mode;

static tulle_status fail_memory(const gltf_scene *scene, tulle_error *error) {
    return file_fail_memory(error, scene->file->path);
}

tulle_status gltf_scene_check_size(const gltf_scene *scene, uint64_t more, tulle_error *error) {
    uint64_t const size = more + 12 * (uint64_t)scene->vertex_count +
                          scene->nodes.count * sizeof *scene->nodes.data +
                          scene->primitive_count * sizeof(gltf_piece) +
                          scene->targets.count * sizeof *scene->targets.data +
                          scene->triangles.count * sizeof *scene->triangles.data +
                          scene->times.count * sizeof *scene->times.data;
    uint64_t const limit = expansion_get_limit(scene->file->file_size);
    if (size <= limit) return TULLE_OK;
    return error_set_at(error, TULLE_ERROR_LIMIT, scene->file->path, 0, 0,
                        "would take more than %llu MB of memory, which is too many times its size: "
                        "it has too many nodes, or uses meshes or times too often",
                        (unsigned long long)(limit >> 20) + 1);
}

/* ---- nodes ---- */

static tulle_status read_node(gltf_scene *scene, const json_value *item, gltf_node *node,
                              tulle_error *error) {
    gltf_file *const file = scene->file;
    size_t mesh_count, skin_count;
    gltf_get_items(file, "meshes", &mesh_count);
    gltf_get_items(file, "skins", &skin_count);
    *node = (gltf_node){
        .place = item, .parent = GLTF_NONE, .rotation = {0, 0, 0, 1}, .scale = {1, 1, 1}};
    for (int i = 0; i < GLTF_PATH_COUNT; i++) node->channels[i].keys = GLTF_NONE;
    node->has_matrix = json_find(&file->json, item, "matrix") != NULL;
    tulle_status status = gltf_find_number(file, item, "mesh", mesh_count, &node->mesh, error);
    if (status == TULLE_OK)
        status = gltf_find_number(file, item, "skin", skin_count, &node->skin, error);
    if (status == TULLE_OK)
        status = gltf_find_values(file, item, "matrix", 16, node->matrix, error);
    if (status == TULLE_OK)
        status = gltf_find_values(file, item, "translation", 3, node->translation, error);
    if (status == TULLE_OK)
        status = gltf_find_values(file, item, "rotation", 4, node->rotation, error);
    if (status == TULLE_OK) status = gltf_find_values(file, item, "scale", 3, node->scale, error);
    return status;
}

/* Visits the numbers of nodes in an array. */
static tulle_status add_child(gltf_scene *scene, uint32_t parent, const json_value *item,
                              tulle_error *error) {
    if (item->type != JSON_NUMBER || !(item->number >= 0.0) ||
        item->number >= (double)scene->nodes.count ||
        item->number != (double)(uint32_t)item->number)
        return json_fail(&scene->file->json, item, error, "there is no such node");
    gltf_node *const child = &scene->nodes.data[(uint32_t)item->number];
    if (child->parent != GLTF_NONE)
        return json_fail(&scene->file->json, item, error, "the node has two parents");
    child->parent = parent;
    return TULLE_OK;
}

static tulle_status read_nodes(gltf_scene *scene, tulle_error *error) {
    gltf_file *const file = scene->file;
    size_t count;
    const json_value *item = gltf_get_items(file, "nodes", &count);
    tulle_status const size_status =
        gltf_scene_check_size(scene, count * sizeof *scene->nodes.data, error);
    if (size_status) return size_status;
    if (!ARRAY_RESERVE(file->heap, &scene->nodes, count + 1)) return fail_memory(scene, error);
    tulle_status status = TULLE_OK;
    for (size_t i = 0; i < count && status == TULLE_OK; i++) {
        status = read_node(scene, item, &scene->nodes.data[i], error);
        scene->nodes.count = i + 1;
        item = json_get_next(&file->json, item);
    }
    for (size_t i = 0; i < count && status == TULLE_OK; i++) {
        const json_value *const children =
            json_find(&file->json, scene->nodes.data[i].place, "children");
        if (!children || children->type != JSON_ARRAY) continue;
        for (const json_value *child = json_get_first(&file->json, children);
             child && status == TULLE_OK; child = json_get_next(&file->json, child))
            status = add_child(scene, (uint32_t)i, child, error);
    }
    return status;
}

/* Whether the nodes without parent are all shown: there is no scene. Else marks those of it. */
static tulle_status mark_scene(gltf_scene *scene, tulle_error *error) {
    gltf_file *const file = scene->file;
    size_t count;
    uint32_t chosen;
    const json_value *item = gltf_get_items(file, "scenes", &count);
    tulle_status const status =
        gltf_find_number(file, json_get_root(&file->json), "scene", count, &chosen, error);
    if (status) return status;
    for (uint32_t i = 0; item && chosen != GLTF_NONE && i < chosen; i++)
        item = json_get_next(&file->json, item);
    const json_value *const roots = item ? json_find(&file->json, item, "nodes") : NULL;
    for (size_t i = 0; i < scene->nodes.count; i++) scene->nodes.data[i].is_in_scene = !item;
    if (!roots || roots->type != JSON_ARRAY) return TULLE_OK;
    for (const json_value *root = json_get_first(&file->json, roots); root;
         root = json_get_next(&file->json, root)) {
        if (root->type != JSON_NUMBER || !(root->number >= 0.0) ||
            root->number >= (double)scene->nodes.count)
            return json_fail(&file->json, root, error, "there is no such node");
        scene->nodes.data[(size_t)root->number].is_in_scene = true;
    }
    return TULLE_OK;
}

/* Puts nodes behind their parents. */
static tulle_status order_nodes(gltf_scene *scene, tulle_error *error) {
    gltf_file *const file = scene->file;
    size_t const count = scene->nodes.count;
    if (!ARRAY_RESERVE(file->heap, &scene->order, count + 1)) return fail_memory(scene, error);
    for (size_t i = 0; i < count; i++)
        if (scene->nodes.data[i].parent == GLTF_NONE)
            scene->order.data[scene->order.count++] = (uint32_t)i;
    for (size_t done = 0; done < scene->order.count; done++) {
        const gltf_node *const node = &scene->nodes.data[scene->order.data[done]];
        const json_value *const children = json_find(&file->json, node->place, "children");
        if (!children || children->type != JSON_ARRAY) continue;
        for (const json_value *child = json_get_first(&file->json, children); child;
             child = json_get_next(&file->json, child)) {
            uint32_t const number = (uint32_t)child->number;
            gltf_node *const below = &scene->nodes.data[number];
            below->is_in_scene = below->is_in_scene || node->is_in_scene;
            scene->order.data[scene->order.count++] = number;
        }
    }
    if (scene->order.count == count) return TULLE_OK;
    return json_fail(&file->json, json_get_root(&file->json), error,
                     "nodes are children of each other");
}

/* ---- meshes ---- */

static tulle_status add_triangle(gltf_scene *scene, const gltf_piece *piece, const double corner[3],
                                 tulle_error *error) {
    if (!ARRAY_RESERVE(scene->file->heap, &scene->triangles, 3)) return fail_memory(scene, error);
    for (int k = 0; k < 3; k++) {
        if (!(corner[k] >= 0.0 && corner[k] < (double)piece->vertex_count))
            return json_fail(&scene->file->json, piece->primitive, error,
                             "a triangle uses vertex %.0f, but there are only %zu", corner[k],
                             piece->vertex_count);
        scene->triangles.data[scene->triangles.count++] =
            (uint32_t)(piece->first_vertex + (size_t)corner[k]);
    }
    return TULLE_OK;
}

/* indices: an accessor, or GLTF_NONE for 0, 1, 2 ... */
static tulle_status add_triangles(gltf_scene *scene, const gltf_piece *piece, uint32_t mode,
                                  uint32_t indices, tulle_error *error) {
    gltf_file *const file = scene->file;
    uint64_t const count =
        indices == GLTF_NONE ? piece->vertex_count : file->accessors.data[indices].count;
    uint64_t const step = mode == MODE_TRIANGLES ? 3 : 1;
    if (indices != GLTF_NONE && file->accessors.data[indices].numbers.slice == GLTF_NONE)
        return json_fail(&file->json, piece->primitive, error, "its indices have no buffer view");
    double window[INDEX_WINDOW], first_corner = 0.0; /* window: indices from window_first on */
    uint64_t window_first = 0, window_count = 0;
    for (uint64_t first = 0; first + 3 <= count; first += step) {
        tulle_status status = TULLE_OK;
        if (first + 3 > window_first + window_count) {
            window_first = first;
            window_count = count - first < INDEX_WINDOW ? count - first : INDEX_WINDOW;
            for (uint64_t i = 0; i < window_count; i++) window[i] = (double)(first + i);
            if (indices != GLTF_NONE)
                status = gltf_read(file, indices, first, window_count, window, error);
            if (first == 0) first_corner = window[0];
        }
        const double *const read = window + (first - window_first);
        double const corners[3] = {mode == MODE_FAN ? first_corner : read[0],
                                   mode == MODE_STRIP && first % 2 ? read[2] : read[1],
                                   mode == MODE_STRIP && first % 2 ? read[1] : read[2]};
        /* A strip goes from one row to the next over triangles that use a vertex twice. */
        bool const is_link =
            mode == MODE_STRIP &&
            (corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0]);
        if (status == TULLE_OK && !is_link) status = add_triangle(scene, piece, corners, error);
        if (status == TULLE_OK) status = gltf_scene_check_size(scene, 0, error);
        if (status) return status;
        if (scene->triangles.count / 3 > VERTEX_LIMIT)
            return error_set_at(error, TULLE_ERROR_LIMIT, file->path, 0, 0,
                                "its triangles are too many");
    }
    return TULLE_OK;
}

static tulle_status read_targets(gltf_scene *scene, gltf_piece *piece, tulle_error *error) {
    gltf_file *const file = scene->file;
    const json_value *const targets = json_find(&file->json, piece->primitive, "targets");
    piece->first_target = scene->targets.count;
    if (!targets || targets->type != JSON_ARRAY) return TULLE_OK;
    tulle_status const size_status =
        gltf_scene_check_size(scene, targets->count * sizeof *scene->targets.data, error);
    if (size_status) return size_status;
    if (!ARRAY_RESERVE(file->heap, &scene->targets, targets->count))
        return fail_memory(scene, error);
    piece->target_count = targets->count;
    for (const json_value *target = json_get_first(&file->json, targets); target;
         target = json_get_next(&file->json, target)) {
        uint32_t accessor;
        tulle_status const status =
            gltf_find_accessor(file, target, "POSITION", 3, &accessor, error);
        if (status) return status;
        if (accessor != GLTF_NONE && file->accessors.data[accessor].count != piece->vertex_count)
            return json_fail(&file->json, target, error,
                             "the target has another number of vertices than its mesh");
        scene->targets.data[scene->targets.count++] = accessor;
    }
    return TULLE_OK;
}

static tulle_status add_piece(gltf_scene *scene, uint32_t node, const json_value *primitive,
                              tulle_error *error) {
    gltf_file *const file = scene->file;
    gltf_piece piece = {.node = node, .primitive = primitive, .first_vertex = scene->vertex_count};
    uint32_t mode = MODE_TRIANGLES, indices = GLTF_NONE;
    const json_value *attributes = NULL;
    scene->primitive_count++;
    tulle_status status = gltf_scene_check_size(scene, 0, error);
    if (status == TULLE_OK && json_find(&file->json, primitive, "mode"))
        status = json_take_whole(&file->json, primitive, "mode", &mode, error);
    if (status == TULLE_OK && mode > MODE_FAN)
        status = json_fail(&file->json, primitive, error, "\"mode\" is not a mode of glTF");
    if (status) return status;
    if (mode > MODE_POINTS && mode < MODE_TRIANGLES) {
        scene->passed_primitives++;
        return TULLE_OK;
    }
    status =
        json_take_member(&file->json, primitive, "attributes", JSON_OBJECT, &attributes, error);
    if (status == TULLE_OK)
        status = gltf_find_accessor(file, attributes, "POSITION", 3, &piece.positions, error);
    if (status == TULLE_OK)
        status = gltf_find_accessor(file, primitive, "indices", 1, &indices, error);
    if (status) return status;
    if (piece.positions == GLTF_NONE) return TULLE_OK; /* the standard: nothing is drawn */
    const gltf_accessor *const positions = &file->accessors.data[piece.positions];
    if (positions->numbers.slice == GLTF_NONE)
        return json_fail(&file->json, positions->place, error,
                         "positions without a buffer view are not read here%s",
                         json_find(&file->json, primitive, "extensions")
                             ? "; if they are compressed, export the file without compression"
                             : "");
    status = gltf_scene_check_size(scene, 12 * positions->count, error);
    if (status) return status;
    if (positions->count > VERTEX_LIMIT - scene->vertex_count)
        return error_set_at(error, TULLE_ERROR_LIMIT, file->path, 0, 0,
                            "its vertices are too many");
    piece.vertex_count = (size_t)positions->count;
    scene->vertex_count += piece.vertex_count;
    status = read_targets(scene, &piece, error);
    piece.first_triangle = scene->triangles.count / 3;
    if (status == TULLE_OK && mode != MODE_POINTS)
        status = add_triangles(scene, &piece, mode, indices, error);
    piece.triangle_count = scene->triangles.count / 3 - piece.first_triangle;
    if (status) return status;
    if (!ARRAY_RESERVE(file->heap, &scene->pieces, 1)) return fail_memory(scene, error);
    scene->pieces.data[scene->pieces.count++] = piece;
    return TULLE_OK;
}

static tulle_status read_mesh(gltf_scene *scene, uint32_t number, const json_value *mesh,
                              tulle_error *error) {
    gltf_file *const file = scene->file;
    gltf_node *const node = &scene->nodes.data[number];
    const json_value *primitives = NULL;
    tulle_status status =
        json_take_member(&file->json, mesh, "primitives", JSON_ARRAY, &primitives, error);
    if (status) return status;
    size_t const first = scene->pieces.count;
    for (const json_value *item = json_get_first(&file->json, primitives);
         item && status == TULLE_OK; item = json_get_next(&file->json, item))
        status = add_piece(scene, number, item, error);
    for (size_t i = first; i < scene->pieces.count && status == TULLE_OK; i++)
        if (scene->pieces.data[i].target_count != scene->pieces.data[first].target_count)
            status = json_fail(&file->json, mesh, error,
                               "the parts of the mesh have different numbers of targets");
    node->weights = json_find(&file->json, node->place, "weights");
    if (!node->weights) node->weights = json_find(&file->json, mesh, "weights");
    size_t const target_count =
        first < scene->pieces.count ? scene->pieces.data[first].target_count : 0;
    node->target_count = target_count;
    if (status == TULLE_OK && node->weights && first < scene->pieces.count) {
        if (!ARRAY_RESERVE(file->heap, &scene->weights, 3 * target_count + 1))
            return fail_memory(scene, error);
        status = gltf_find_values(
            file, node->weights == json_find(&file->json, mesh, "weights") ? mesh : node->place,
            "weights", target_count, scene->weights.data, error);
    }
    return status;
}

static tulle_status read_meshes(gltf_scene *scene, tulle_error *error) {
    gltf_file *const file = scene->file;
    size_t count;
    const json_value *const first = gltf_get_items(file, "meshes", &count);
    /* Meshes by number, so that they are not counted off for each node. */
    const json_value **const meshes = memory_allocate(file->heap, (count + 1) * sizeof *meshes);
    if (!meshes) return fail_memory(scene, error);
    const json_value *item = first;
    for (size_t i = 0; i < count; i++, item = json_get_next(&file->json, item)) meshes[i] = item;
    tulle_status status = TULLE_OK;
    for (uint32_t i = 0; i < scene->nodes.count && status == TULLE_OK; i++) {
        const gltf_node *const node = &scene->nodes.data[i];
        if (node->is_in_scene && node->mesh != GLTF_NONE)
            status = read_mesh(scene, i, meshes[node->mesh], error);
    }
    memory_release(file->heap, meshes, (count + 1) * sizeof *meshes);
    if (status == TULLE_OK && scene->vertex_count == 0)
        status =
            error_set_at(error, TULLE_ERROR_PARSE, file->path, 0, 0, "its scene shows no meshes");
    return status;
}

tulle_status gltf_scene_read(gltf_file *file, gltf_scene *scene, tulle_error *error) {
    *scene = (gltf_scene){.file = file};
    tulle_status status = read_nodes(scene, error);
    if (status == TULLE_OK) status = mark_scene(scene, error);
    if (status == TULLE_OK) status = order_nodes(scene, error);
    if (status == TULLE_OK) status = read_meshes(scene, error);
    if (status == TULLE_OK) status = gltf_animation_read(scene, error);
    if (status == TULLE_OK) status = gltf_scene_turn(scene, error);
    return status;
}

void gltf_scene_destroy(gltf_scene *scene) {
    if (!scene->file) return;
    memory *const heap = scene->file->heap;
    ARRAY_FREE(heap, &scene->nodes);
    ARRAY_FREE(heap, &scene->order);
    ARRAY_FREE(heap, &scene->pieces);
    ARRAY_FREE(heap, &scene->targets);
    ARRAY_FREE(heap, &scene->triangles);
    ARRAY_FREE(heap, &scene->keys);
    ARRAY_FREE(heap, &scene->times);
    ARRAY_FREE(heap, &scene->frames);
    ARRAY_FREE(heap, &scene->scratch);
    ARRAY_FREE(heap, &scene->weights);
    *scene = (gltf_scene){0};
}
