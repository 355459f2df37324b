/* scene/picture.c - see picture.h. */
#include "scene/picture.h"

#include "scene/scene_data.h"

#include <string.h>

scene_picture scene_picture_default(void) {
    return (scene_picture){.floor = SCENE_FLOOR_AUTO, .exposure = 1.0};
}

static bool copy_vector(const schema_map *map, const void *keys, const char *name,
                        const schema_vector *from, double to[3]) {
    if (!schema_is_given(map, keys, name)) return false;
    memcpy(to, from->value, from->count * sizeof *to);
    return true;
}

static scene_camera describe_camera(const camera_keys *keys) {
    const schema_map *const map = &camera_map;
    scene_camera camera = {
        .distance = keys->distance, .field_of_view = keys->field_of_view, .turn = keys->turn};
    camera.has_position = copy_vector(map, keys, "position", &keys->position, camera.position);
    camera.has_target = copy_vector(map, keys, "target", &keys->target, camera.target);
    double orbit[3] = {0};
    camera.has_orbit = copy_vector(map, keys, "orbit", &keys->orbit, orbit);
    camera.azimuth = orbit[0];
    camera.elevation = orbit[1];
    camera.has_distance = schema_is_given(map, keys, "distance");
    camera.has_field_of_view = schema_is_given(map, keys, "field_of_view");
    camera.has_turn = schema_is_given(map, keys, "turn");
    return camera;
}

static scene_look describe_cloth(const cloth_keys *keys) {
    scene_look look = {.pattern = (scene_pattern)keys->pattern, .pattern_size = keys->pattern_size};
    look.has_color = copy_vector(&cloth_map, keys, "color", &keys->color, look.color);
    look.has_back_color =
        copy_vector(&cloth_map, keys, "back_color", &keys->back_color, look.back_color);
    look.has_pattern = schema_is_given(&cloth_map, keys, "pattern");
    return look;
}

static scene_look describe_obstacle(const obstacle_keys *keys) {
    scene_look look = {.is_hidden = keys->hidden};
    look.has_color = copy_vector(&obstacle_map, keys, "color", &keys->color, look.color);
    return look;
}

/* The camera's keys that go together, and its elevation. */
static bool check_camera(const scene_work *work, const camera_keys *keys) {
    const double most = 1.5533430342749532; /* [rad] 89 degrees: up must not be the direction */
    scene_camera const camera = describe_camera(keys);
    if (camera.has_orbit && !(camera.elevation >= -most && camera.elevation <= most)) {
        problem_add(work->problems, TULLE_ERROR_INVALID_ARGUMENT, schema_place(keys, "orbit"),
                    "%s.orbit: the elevation should be -89 deg to 89 deg", keys->head.path);
        return false;
    }
    if (camera.has_position && camera.has_distance) {
        problem_add(work->problems, TULLE_ERROR_INVALID_ARGUMENT, schema_place(keys, "distance"),
                    "%s.distance: belongs to an orbit; a position decides the distance itself",
                    keys->head.path);
        return false;
    }
    if (camera.has_position && camera.has_target &&
        memcmp(camera.position, camera.target, sizeof camera.position) == 0) {
        problem_add(work->problems, TULLE_ERROR_INVALID_ARGUMENT, schema_place(keys, "target"),
                    "%s.target: is the camera's position; it should be elsewhere", keys->head.path);
        return false;
    }
    return true;
}

bool check_picture(const scene_work *work) {
    const scene_keys *const keys = &work->scene->keys;
    return !schema_is_given(&scene_map, keys, "render") ||
           !schema_is_given(&picture_map, &keys->picture, "camera") ||
           check_camera(work, &keys->picture.camera);
}

static bool describe_looks(const scene_work *work, scene_picture *picture) {
    const scene_keys *const keys = &work->scene->keys;
    const obstacle_keys *const obstacles = keys->obstacles.items;
    const cloth_keys *const cloths = keys->cloth.items;
    size_t count = keys->cloth.count;
    for (size_t i = 0; i < keys->obstacles.count; i++) {
        size_t const copies = count_copies(&obstacles[i]);
        if (copies > SCENE_OBJECT_LIMIT || (count += copies) > 2 * (size_t)SCENE_OBJECT_LIMIT) {
            problem_add(work->problems, TULLE_ERROR_LIMIT, obstacles[i].head.place,
                        "%s: brings the scene to more than %d obstacles with all copies",
                        obstacles[i].head.path, SCENE_OBJECT_LIMIT);
            return false;
        }
    }
    memory heap = memory_default();
    picture->looks = memory_allocate(&heap, count * sizeof *picture->looks);
    if (!picture->looks) {
        problem_add_memory(work->problems, work->scene->path);
        return false;
    }
    picture->look_count = count;
    scene_look *next = picture->looks;
    for (size_t i = 0; i < keys->cloth.count; i++) *next++ = describe_cloth(&cloths[i]);
    for (size_t i = 0; i < keys->obstacles.count; i++)
        for (size_t copy = count_copies(&obstacles[i]); copy > 0; copy--)
            *next++ = describe_obstacle(&obstacles[i]);
    return true;
}

static bool describe(const scene_work *work, scene_picture *picture) {
    const scene_keys *const keys = &work->scene->keys;
    if (!read_scene_keys(work, NULL, 0) || !check_picture(work)) return false;
    if (schema_is_given(&scene_map, keys, "render")) {
        picture->floor = (scene_floor)keys->picture.floor;
        picture->exposure = keys->picture.exposure;
        if (schema_is_given(&picture_map, &keys->picture, "camera"))
            picture->camera = describe_camera(&keys->picture.camera);
    }
    return describe_looks(work, picture);
}

tulle_status scene_read_picture(const char *path, scene_picture *picture,
                                tulle_scene_problems *problems) {
    *picture = scene_picture_default();
    memset(problems, 0, sizeof *problems);
    tulle_scene read = {.heap = memory_default(), .path = path};
    read.storage = arena_make(&read.heap);
    const scene_work work = {&read, problems};
    bool const is_good = describe(&work, picture);
    arena_destroy(&read.storage);
    if (is_good) return TULLE_OK;
    scene_picture_destroy(picture);
    return problems->list[0].status;
}

void scene_picture_destroy(scene_picture *picture) {
    memory heap = memory_default();
    memory_release(&heap, picture->looks, picture->look_count * sizeof *picture->looks);
    *picture = scene_picture_default();
}
