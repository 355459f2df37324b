/* scene/place.c - how a mesh is set down: turned upright, scaled to a size, centred, stood on a
 * height or on the top of an obstacle. */
#include "scene/scene_data.h"

#include "base/text.h"

#include <math.h>
#include <string.h>

/* A mesh that must be scaled by more than this, or by less than its inverse, has another unit than
 * somebody thinks. */
static const double MOST_SIZE_RATIO = 1e6;

/* The turns that bring an axis up. They are not of unit length so that quarter turns are exact. */
static const double up_turns[][4] = {
    [UP_Z] = {1, 0, 0, 0}, [UP_Y] = {1, 1, 0, 0}, [UP_X] = {1, 0, -1, 0}};

/* ---- boxes ---- */

typedef struct extent_box {
    double low[3], high[3];
} extent_box;

static void extend_box(extent_box *box, const double point[3]) {
    for (int k = 0; k < 3; k++) {
        box->low[k] = fmin(box->low[k], point[k]);
        box->high[k] = fmax(box->high[k], point[k]);
    }
}

/* The box of a mesh's triangles where they are placed. Vertices are moved by the function that will
 * move the mesh, so that the box fits to the last bit. */
static extent_box find_box(const tulle_mesh *mesh, const placement *where) {
    extent_box box = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    double point[3];
    tulle_mesh one = {.positions = point, .vertex_count = 1};
    for (size_t i = 0; i < 3 * mesh->triangle_count; i++) {
        memcpy(point, mesh->positions + 3 * (size_t)mesh->triangles[i], sizeof point);
        tulle_mesh_transform(&one, where->scale, where->turn.rotation, where->turn.translation);
        extend_box(&box, point);
    }
    return box;
}

/* ---- names of obstacles ---- */

/* The name, or that of an obstacle whose copy this is: "spike" of "spike.012". */
static bool has_name(const scene_obstacle *obstacle, const char *name) {
    if (!obstacle->name) return false; /* not made yet */
    if (strcmp(obstacle->name, name) == 0) return true;
    const char *const dot = strrchr(obstacle->name, '.');
    return obstacle->keys->copies.head.node && dot &&
           strlen(name) == (size_t)(dot - obstacle->name) &&
           strncmp(obstacle->name, name, strlen(name)) == 0;
}

bool find_obstacles(const tulle_scene *loaded, const char *name, size_t *begin, size_t *end) {
    *begin = 0;
    while (*begin < loaded->obstacle_count && !has_name(&loaded->obstacles[*begin], name)) ++*begin;
    *end = *begin;
    while (*end < loaded->obstacle_count && has_name(&loaded->obstacles[*end], name)) ++*end;
    return *end > *begin;
}

/* Says how the copies count that a name means; null: it means none. */
static const char *tell_copies(const scene_work *work, const char *name) {
    const char *const dot = strrchr(name, '.');
    const char *const bases[2] = {name,
                                  dot ? store_text(work, "%.*s", (int)(dot - name), name) : NULL};
    for (int i = 0; i < 2; i++) {
        size_t begin, end;
        if (!bases[i] || !find_obstacles(work->scene, bases[i], &begin, &end)) continue;
        const scene_obstacle *const copies = work->scene->obstacles;
        if (copies[begin].keys->copies.head.node)
            return store_text(work, "; copies count from 000, here from '%s' to '%s'",
                              show_text(copies[begin].name).text,
                              show_text(copies[end - 1].name).text);
    }
    return NULL;
}

const char *tell_meant(const scene_work *work, const char *name, const char **names, size_t count) {
    const char *const copies = tell_copies(work, name);
    const char *const meant = copies || !names ? NULL : text_find_nearest(name, names, count);
    if (meant) return store_text(work, "; did you mean '%s'?", show_text(meant).text);
    return copies ? copies : "";
}

bool refuse_obstacle_name(const scene_work *work, const void *keys, const char *key,
                          const char *name) {
    const tulle_scene *const loaded = work->scene;
    const char *const path = ((const schema_head *)keys)->path;
    const obstacle_keys *const entries = loaded->keys.obstacles.items;
    for (size_t i = 0; i < loaded->keys.obstacles.count; i++) {
        if (!entries[i].name || strcmp(entries[i].name, name) != 0) continue;
        if (work->problems->total_count == 0) /* else it could not be made */
            problem_add(work->problems, TULLE_ERROR_INVALID_ARGUMENT, schema_place(keys, key),
                        "%s.%s: '%s' must be before it in the file", path, key, name);
        return false;
    }
    const char **const names =
        ARENA_NEW(&work->scene->storage, const char *, loaded->obstacle_count + 1);
    size_t count = 0;
    for (size_t i = 0; names && i < loaded->obstacle_count; i++)
        if (loaded->obstacles[i].name) names[count++] = loaded->obstacles[i].name;
    problem_add(work->problems, TULLE_ERROR_INVALID_ARGUMENT, schema_place(keys, key),
                "%s.%s: no obstacle is called '%s'%s", path, key, show_text(name).text,
                tell_meant(work, name, names, count));
    return false;
}

/* ---- the placement ---- */

static bool refuse(const scene_work *work, const place_keys *keys, const char *key,
                   const char *text) {
    if (text)
        problem_add(work->problems, TULLE_ERROR_INVALID_ARGUMENT, schema_place(keys, key),
                    "%s.%s: %s", keys->head.path, key, text);
    return false;
}

static bool set_size(const scene_work *work, const place_keys *keys, const tulle_mesh *mesh,
                     placement *result) {
    bool const is_height = schema_is_given(&place_map, keys, "height");
    if (!is_height && !schema_is_given(&place_map, keys, "size")) return true;
    extent_box const box = find_box(mesh, result);
    double extent = 0.0;
    for (int k = is_height ? 2 : 0; k < 3; k++) extent = fmax(extent, box.high[k] - box.low[k]);
    const char *const key = is_height ? "height" : "size";
    if (!(extent > 0.0))
        return refuse(work, keys, key, "the mesh is flat there; size may be meant");
    double const factor = (is_height ? keys->height : keys->size) / extent;
    if (!(factor <= MOST_SIZE_RATIO && factor >= 1.0 / MOST_SIZE_RATIO))
        return refuse(work, keys, key,
                      store_text(work,
                                 "the mesh has %.3g m, it would be scaled by %.3g; at most "
                                 "%g and at least %g are allowed",
                                 extent, factor, MOST_SIZE_RATIO, 1.0 / MOST_SIZE_RATIO));
    for (int k = 0; k < 3; k++) result->scale[k] *= factor;
    return true;
}

/* The height on which the mesh is to stand. False after a problem. */
static bool find_height(const scene_work *work, const place_keys *keys, double *height) {
    const tulle_scene *const loaded = work->scene;
    size_t begin, end;
    *height = keys->on;
    if (!schema_is_given(&place_map, keys, "on_top_of")) return true;
    if (!find_obstacles(loaded, keys->on_top_of, &begin, &end))
        return refuse_obstacle_name(work, keys, "on_top_of", keys->on_top_of);
    placement const here = {.scale = {1, 1, 1}, .turn = POSE_IDENTITY};
    *height = -INFINITY;
    for (size_t i = begin; i < end; i++)
        *height = fmax(*height, find_box(&loaded->obstacles[i].mesh, &here).high[2]);
    return true;
}

/* ---- sizes ---- */

/* [m] A body that is larger than the first, or smaller than the second, is told: its file has
 * another unit than somebody thinks. */
static const double LARGEST_BODY = 100.0, SMALLEST_BODY = 1e-3;

static void note_odd_size(const scene_work *work, const source_mesh *source, const char *name,
                          const placement *where) {
    extent_box const box = find_box(source->mesh, where);
    double extent = 0.0;
    for (int k = 0; k < 3; k++) {
        extent = fmax(extent, box.high[k] - box.low[k]);
        extent = fmax(extent, source->extent * fabs(where->scale[k]));
    }
    if (!(extent > LARGEST_BODY) && !(extent < SMALLEST_BODY)) return;
    bool const is_large = extent > LARGEST_BODY;
    note_add(work,
             "%s is %.3g m across, %s; if its file has another unit than the %s taken here, set "
             "'scale' (metres in a unit: 0.01 for centimetres, 0.001 for millimetres) or "
             "'place: {size: ...}'",
             name, extent, is_large ? "more than 100 m" : "less than 1 mm",
             source->axes.meters_per_unit == 1.0
                 ? "metre"
                 : store_text(work, "%.6g m", source->axes.meters_per_unit));
}

/* Whether keys beside `as` say where the mesh goes. */
static bool has_own_place(const placement_keys *keys) {
    static const char *const names[] = {"size", "height", "on", "on_top_of"};
    const double *const scale = keys->scale->value, *const q = keys->rotate->quaternion;
    bool has_any = keys->place->up != UP_Z || keys->place->center;
    has_any |= keys->scale->count > 0 && (scale[0] != 1.0 || scale[1] != 1.0 || scale[2] != 1.0);
    has_any |= q[0] != 1.0 || q[1] != 0.0 || q[2] != 0.0 || q[3] != 0.0;
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++)
        has_any |= schema_is_given(&place_map, keys->place, names[i]);
    return has_any;
}

/* The placement of an obstacle. False after a problem. */
static bool follow_obstacle(const scene_work *work, const placement_keys *keys, placement *result) {
    const place_keys *const place = keys->place;
    size_t begin, end;
    if (has_own_place(keys))
        return refuse(work, place, "as",
                      "goes with no scale, no rotate and no other key of place; only translate "
                      "may move it on");
    if (!find_obstacles(work->scene, place->as, &begin, &end))
        return refuse_obstacle_name(work, place, "as", place->as);
    if (end - begin > 1)
        return refuse(work, place, "as", "has several copies; name one of them, as post.002");
    *result = work->scene->obstacles[begin].place;
    return true;
}

/* Scale and turn: of the keys, else of the file. */
static void set_axes(const placement_keys *keys, file_axes axes, placement *result) {
    bool const has_up = keys->place->head.node && schema_is_given(&place_map, keys->place, "up");
    int const up = has_up ? keys->place->up : axes.is_y_up ? UP_Y : UP_Z;
    *result = (placement){.turn = POSE_IDENTITY};
    for (int k = 0; k < 3; k++)
        result->scale[k] = keys->scale->count > 0 ? keys->scale->value[k] : axes.meters_per_unit;
    memcpy(result->turn.rotation, keys->rotate->quaternion, sizeof result->turn.rotation);
    if (up != UP_Z)
        multiply_rotations(keys->rotate->quaternion, up_turns[up], result->turn.rotation);
}

static bool set_place(const scene_work *work, const placement_keys *keys, const tulle_mesh *mesh,
                      placement *result) {
    const place_keys *const place = keys->place;
    if (!place->head.node) return true;
    if (schema_is_given(&place_map, place, "as")) return follow_obstacle(work, keys, result);
    if (!set_size(work, place, mesh, result)) return false;
    bool const stands =
        schema_is_given(&place_map, place, "on") || schema_is_given(&place_map, place, "on_top_of");
    if (!stands && !place->center) return true;
    extent_box const box = find_box(mesh, result);
    double height = 0.0;
    if (stands && !find_height(work, place, &height)) return false;
    double *const shift = result->turn.translation;
    for (int k = 0; place->center && k < 2; k++) shift[k] = -0.5 * (box.low[k] + box.high[k]);
    if (stands) shift[2] = height - box.low[2];
    return true;
}

bool find_placement(const scene_work *work, const placement_keys *keys, const source_mesh *source,
                    const char *name, placement *result) {
    set_axes(keys, source->axes, result);
    if (!set_place(work, keys, source->mesh, result)) return false;
    if (source->is_of_file) note_odd_size(work, source, name, result);
    return true;
}

void place_cloth_mesh(const scene_cloth *cloth, tulle_mesh *mesh) {
    const placement *const where = &cloth->place;
    double translation[3];
    for (int k = 0; k < 3; k++)
        translation[k] = where->turn.translation[k] + cloth->keys->translate.value[k];
    tulle_mesh_transform(mesh, where->scale, where->turn.rotation, translation);
}
