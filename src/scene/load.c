/* scene/load.c - from a scene file to a scene: text, tree, overrides, keys, objects, hash. */
#include "scene/scene.h"
#include "scene/scene_data.h"

#include "base/hash.h"
#include "io/file_data.h"

#include <math.h>
#include <string.h>

static bool check_something_moves(const scene_work *work) {
    const scene_keys *keys = &work->scene->keys;
    const obstacle_keys *obstacles = keys->obstacles.items;
    bool moves = keys->cloth.count > 0;
    for (size_t i = 0; i < keys->obstacles.count; i++)
        moves |= obstacles[i].dynamic.head.node != NULL;
    if (!moves)
        problem_add(work->problems, TULLE_ERROR_PARSE, schema_place(keys, "cloth"),
                    "nothing moves: the scene needs a cloth, or an obstacle that is dynamic");
    return moves;
}

/* The tree of the scene's text, or of its file; null after a problem. */
static scene_node *read_tree(const scene_work *work) {
    tulle_scene *loaded = work->scene;
    file_data file = {0};
    tulle_error error = {0};
    scene_place const place = {loaded->path, 0, 0};
    if (loaded->text_length > TREE_TEXT_LIMIT) {
        problem_add(work->problems, TULLE_ERROR_LIMIT, place, "a scene has at most %d bytes",
                    TREE_TEXT_LIMIT);
        return NULL;
    }
    if (!loaded->text &&
        file_load(&loaded->heap, loaded->path, TREE_TEXT_LIMIT, &file, &error) != TULLE_OK) {
        problem_add(work->problems, error.status, (scene_place){error.file, 0, 0}, "%s",
                    error.message);
        return NULL;
    }
    tree_source const source = {.name = loaded->path,
                                .needs = "a scene has at least the keys time and cloth",
                                .has_lines = true,
                                .text = loaded->text ? loaded->text : file.bytes,
                                .length = loaded->text ? loaded->text_length : file.byte_count};
    scene_node *const root = tree_read(&source, &loaded->storage, work->problems);
    file_release(&loaded->heap, &file);
    return root;
}

bool read_scene_keys(const scene_work *work, const char *const *overrides, size_t count) {
    tulle_scene *loaded = work->scene;
    scene_node *const root = read_tree(work);
    if (!root) return false;
    bool is_good = true;
    for (size_t i = 0; i < count; i++)
        is_good &= tree_override(root, overrides[i], &loaded->storage, work->problems);
    if (!is_good) return false;
    schema_reader reader = {&loaded->storage, work->problems, loaded->path};
    loaded->keys.head = (schema_head){.node = root, .place = {loaded->path, 1, 1}, .path = ""};
    return schema_read(&reader, &scene_map, root, &loaded->keys) && check_something_moves(work);
}

static bool set_frame_count(const scene_work *work) {
    const time_keys *keys = &work->scene->keys.time;
    double frames = (double)keys->frames;
    /* A part of a frame below a billionth is rounding of the division. */
    if (!schema_is_given(&time_map, keys, "frames"))
        frames =
            fmax(ceil(keys->duration / (keys->step * (double)keys->steps_per_frame) - 1e-9), 1);
    if (frames > SCENE_FRAME_LIMIT) {
        problem_add(work->problems, TULLE_ERROR_LIMIT, schema_place(keys, "duration"),
                    "%s.duration: takes %.0f frames, at most %d are allowed; make it shorter, or "
                    "step or steps_per_frame larger",
                    keys->head.path, frames, SCENE_FRAME_LIMIT);
        return false;
    }
    work->scene->frame_count = (uint32_t)frames;
    return true;
}

static bool make_cloths(const scene_work *work) {
    tulle_scene *loaded = work->scene;
    const cloth_keys *keys = loaded->keys.cloth.items;
    loaded->cloth_count = loaded->keys.cloth.count;
    loaded->cloths = ARENA_NEW_ZEROED(&loaded->storage, scene_cloth, loaded->cloth_count + 1);
    if (!loaded->cloths) {
        loaded->cloth_count = 0;
        problem_add_memory(work->problems, loaded->path);
        return false;
    }
    bool is_good = true;
    for (size_t i = 0; i < loaded->cloth_count; i++)
        is_good &= make_cloth(work, &keys[i], i, &loaded->cloths[i]);
    return is_good;
}

static bool make_all_obstacles(const scene_work *work) {
    tulle_scene *loaded = work->scene;
    const obstacle_keys *keys = loaded->keys.obstacles.items;
    size_t count = 0;
    for (size_t i = 0; i < loaded->keys.obstacles.count; i++) {
        size_t copies = count_copies(&keys[i]);
        if (copies <= SCENE_OBJECT_LIMIT && count + copies <= SCENE_OBJECT_LIMIT) {
            count += copies;
            continue;
        }
        problem_add(work->problems, TULLE_ERROR_LIMIT, keys[i].head.place,
                    "%s: brings the scene to more than %d obstacles with all copies",
                    keys[i].head.path, SCENE_OBJECT_LIMIT);
        return false;
    }
    loaded->obstacles = ARENA_NEW_ZEROED(&loaded->storage, scene_obstacle, count + 1);
    if (!loaded->obstacles) {
        problem_add_memory(work->problems, loaded->path);
        return false;
    }
    loaded->obstacle_count = count;
    bool is_good = true;
    for (size_t i = 0, next = 0; i < loaded->keys.obstacles.count; i++) {
        is_good &= make_obstacles(work, &keys[i], i, &loaded->obstacles[next]);
        next += count_copies(&keys[i]);
    }
    return is_good;
}

const char *get_object_name(const tulle_scene *loaded, size_t object) {
    return object < loaded->cloth_count ? loaded->cloths[object].name
                                        : loaded->obstacles[object - loaded->cloth_count].name;
}

static bool check_names(const scene_work *work) {
    const tulle_scene *loaded = work->scene;
    for (size_t i = 0; i < loaded->cloth_count + loaded->obstacle_count; i++) {
        for (size_t k = 0; k < i; k++) {
            if (strcmp(get_object_name(loaded, i), get_object_name(loaded, k)) != 0) continue;
            const void *keys = i < loaded->cloth_count
                                   ? (const void *)loaded->cloths[i].keys
                                   : loaded->obstacles[i - loaded->cloth_count].keys;
            problem_add(work->problems, TULLE_ERROR_INVALID_ARGUMENT, schema_place(keys, "name"),
                        "%s.name: '%s' is the name of an object before; names must differ",
                        ((const schema_head *)keys)->path, get_object_name(loaded, i));
            return false;
        }
    }
    return true;
}

static const char *write_canonical(tulle_scene *loaded, unsigned left_out) {
    text_buffer buffer = {.storage = &loaded->storage, .left_out = left_out};
    schema_write(&scene_map, &loaded->keys, 0, &buffer);
    return buffer.is_failed ? NULL : buffer.data;
}

/* The canonical text, and the hash: text without the length of the run and without what only
 * pictures depend on, materials, meshes. */
static bool finish(const scene_work *work) {
    tulle_scene *loaded = work->scene;
    loaded->canonical_text = write_canonical(loaded, 0);
    uint64_t given = loaded->keys.time.head.given;
    loaded->keys.time.head.given &= ~(UINT64_C(1) << schema_find_key(&time_map, "frames"));
    loaded->keys.time.head.given &= ~(UINT64_C(1) << schema_find_key(&time_map, "duration"));
    const char *text = write_canonical(loaded, SCHEMA_PICTURE);
    loaded->keys.time.head.given = given;
    if (!loaded->canonical_text || !text) {
        problem_add_memory(work->problems, loaded->path);
        return false;
    }
    uint64_t hash = hash_bytes(loaded->content_hash, text, strlen(text));
    for (size_t i = 0; i < loaded->cloth_count; i++) {
        const tulle_material *m = &loaded->cloths[i].material;
        const double values[] = {m->area_density,
                                 m->warp.stiffness,
                                 m->warp.knee,
                                 m->warp.limit,
                                 m->weft.stiffness,
                                 m->weft.knee,
                                 m->weft.limit,
                                 m->shear.stiffness,
                                 m->shear.knee,
                                 m->shear.limit,
                                 m->poisson,
                                 m->bend_warp,
                                 m->bend_weft,
                                 m->bend_twist,
                                 m->stretch_damping,
                                 m->bend_damping,
                                 m->air_damping,
                                 m->friction,
                                 m->dynamic_friction,
                                 m->restitution,
                                 m->friction_across,
                                 m->springs.stretch_stiffness,
                                 m->springs.bend_stiffness,
                                 m->springs.stiffening_strain};
        hash = hash_bytes(hash, values, sizeof values);
        double const widths[] = {m->bend_hysteresis_warp, m->bend_hysteresis_weft,
                                 m->shear_hysteresis};
        if (widths[0] > 0.0 || widths[1] > 0.0 || widths[2] > 0.0)
            hash = hash_bytes(hash, widths, sizeof widths);
    }
    loaded->hash = hash;
    return true;
}

/* What mesh files have beside the meshes is needed until all vertices are chosen. */
static void release_sources(tulle_scene *loaded) {
    for (size_t i = 0; i < loaded->cloth_count; i++)
        tulle_mesh_source_destroy(&loaded->cloths[i].source);
}

static bool load(const scene_work *work, const char *const *overrides, size_t override_count) {
    if (!read_scene_keys(work, overrides, override_count)) return false;
    bool is_good = set_frame_count(work);
    is_good &= check_picture(work);
    /* Cloth may stand on an obstacle and choose vertices near one. */
    is_good &= make_all_obstacles(work);
    is_good &= make_cloths(work);
    is_good = is_good && check_names(work) && make_attachments(work);
    release_sources(work->scene);
    return is_good && make_pairs(work) && finish(work);
}

/* A scene's text where it is not what the file holds. */
typedef struct scene_text {
    const char *bytes;
    size_t length;
} scene_text;

static tulle_status load_scene(const char *path, const scene_text *text,
                               const char *const *overrides, size_t override_count,
                               tulle_scene **result, tulle_scene_problems *problems) {
    memory heap = memory_default();
    tulle_scene *loaded = memory_allocate_zeroed(&heap, 1, sizeof *loaded);
    if (!loaded) return problem_add_memory(problems, path);
    loaded->heap = heap;
    loaded->storage = arena_make(&loaded->heap);
    loaded->content_hash = HASH_SEED;
    loaded->path = copy_text(&loaded->storage, path, strlen(path));
    if (text) {
        loaded->text = text->bytes;
        loaded->text_length = text->length;
    }
    const scene_work work = {loaded, problems};
    if (!loaded->path)
        problem_add_memory(problems, path);
    else if (load(&work, overrides, override_count)) {
        loaded->text = NULL;
        *result = loaded;
        return TULLE_OK;
    }
    /* The places of problems point into the scene no more: problem_add copied their texts. */
    tulle_scene_destroy(loaded);
    return problems->list[0].status;
}

tulle_status tulle_scene_load(const char *path, const char *const *overrides, size_t override_count,
                              tulle_scene **result, tulle_scene_problems *problems) {
    if (result) *result = NULL;
    if (!problems) return TULLE_ERROR_INVALID_ARGUMENT;
    memset(problems, 0, sizeof *problems);
    bool has_all = path && result && (override_count == 0 || overrides);
    for (size_t i = 0; has_all && i < override_count; i++) has_all = overrides[i] != NULL;
    if (!has_all)
        return problem_add(problems, TULLE_ERROR_INVALID_ARGUMENT, (scene_place){path, 0, 0},
                           "the path, an override or the place of the scene is null");
    return load_scene(path, NULL, overrides, override_count, result, problems);
}

tulle_status scene_load_text(const char *path, const char *text, size_t length,
                             tulle_scene **result, tulle_scene_problems *problems) {
    *result = NULL;
    memset(problems, 0, sizeof *problems);
    scene_text const given = {text, length};
    return load_scene(path, &given, NULL, 0, result, problems);
}
void tulle_scene_destroy(tulle_scene *loaded) {
    if (!loaded) return;
    release_sources(loaded);
    for (size_t i = 0; i < loaded->cloth_count; i++) tulle_mesh_destroy(&loaded->cloths[i].mesh);
    for (size_t i = 0; i < loaded->obstacle_count; i++) {
        tulle_mesh_destroy(&loaded->obstacles[i].mesh);
        sequence_close(loaded->obstacles[i].sequence);
    }
    arena_destroy(&loaded->storage);
    memory heap = loaded->heap;
    memory_release(&heap, loaded, sizeof *loaded);
}
