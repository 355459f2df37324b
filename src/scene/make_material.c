/* scene/make_material.c - material of a cloth: a preset or a material file, and what the keys
 * replace. */
#include "scene/scene.h"
#include "scene/scene_data.h"

#include "base/hash.h"
#include "base/text.h"
#include "io/file_data.h"

#include <string.h>

static bool refuse_preset(const scene_work *work, const material_keys *keys) {
    char list[1000] = "";
    const char *names[64];
    size_t count = 0, used = 0;
    for (const char *name; count < 64 && (name = tulle_material_preset_name(count)); count++) {
        int added = snprintf(list + used, sizeof list - used, "%s%s", count > 0 ? ", " : "", name);
        if (added > 0 && (size_t)added < sizeof list - used) used += (size_t)added;
        names[count] = name;
    }
    const char *meant = text_find_nearest(keys->preset, names, count);
    problem_add(work->problems, TULLE_ERROR_PARSE, schema_place(keys, "preset"),
                meant ? "%s.preset: is '%s', must be one of %s; did you mean '%s'?"
                      : "%s.preset: is '%s', must be one of %s",
                keys->head.path, show_text(keys->preset).text, list, meant);
    return false;
}

static bool is_given(const material_keys *keys, const char *name) {
    return schema_is_given(&material_map, keys, name);
}

static void replace_curve(const curve_keys *keys, tulle_curve *curve) {
    if (schema_is_given(&curve_map, keys, "stiffness")) curve->stiffness = keys->stiffness;
    if (schema_is_given(&curve_map, keys, "knee")) curve->knee = keys->knee;
    if (schema_is_given(&curve_map, keys, "limit")) curve->limit = keys->limit;
}

/* Replaces the values that are given. Those of one direction go before those of all. */
static void replace_values(const material_keys *keys, tulle_material *material) {
    if (is_given(keys, "stretch"))
        material->warp.stiffness = material->weft.stiffness = material->springs.stretch_stiffness =
            keys->stretch;
    if (is_given(keys, "stiffening_strain"))
        material->warp.knee = material->weft.knee = material->springs.stiffening_strain =
            keys->stiffening_strain;
    if (is_given(keys, "bend")) {
        material->bend_warp = material->bend_weft = material->springs.bend_stiffness = keys->bend;
        material->bend_twist = 0.5 * keys->bend;
    }
    replace_curve(&keys->warp, &material->warp);
    replace_curve(&keys->weft, &material->weft);
    replace_curve(&keys->shear, &material->shear);
    const struct {
        const char *name;
        const double *from;
        double *to;
    } values[] = {
        {"area_density", &keys->area_density, &material->area_density},
        {"poisson", &keys->poisson, &material->poisson},
        {"bend_warp", &keys->bend_warp, &material->bend_warp},
        {"bend_weft", &keys->bend_weft, &material->bend_weft},
        {"bend_twist", &keys->bend_twist, &material->bend_twist},
        {"bend_hysteresis_warp", &keys->bend_hysteresis_warp, &material->bend_hysteresis_warp},
        {"bend_hysteresis_weft", &keys->bend_hysteresis_weft, &material->bend_hysteresis_weft},
        {"shear_hysteresis", &keys->shear_hysteresis, &material->shear_hysteresis},
        {"stretch_damping", &keys->stretch_damping, &material->stretch_damping},
        {"bend_damping", &keys->bend_damping, &material->bend_damping},
        {"air_damping", &keys->air_damping, &material->air_damping},
        {"friction", &keys->friction, &material->friction},
        {"dynamic_friction", &keys->dynamic_friction, &material->dynamic_friction},
        {"restitution", &keys->restitution, &material->restitution},
        {"friction_across", &keys->friction_across, &material->friction_across},
    };
    for (size_t i = 0; i < sizeof values / sizeof values[0]; i++)
        if (is_given(keys, values[i].name)) *values[i].to = *values[i].from;
}

static bool start_from_preset(const scene_work *work, const material_keys *keys,
                              scene_cloth *cloth) {
    const char *const preset = keys->preset ? keys->preset : "cotton";
    if (tulle_material_preset(preset, &cloth->material) != TULLE_OK)
        return refuse_preset(work, keys);
    cloth->contact_material = keys->name ? keys->name : preset;
    return true;
}

/* Reads the keys of a material file. False after a problem. */
static bool read_keys(const scene_work *work, const material_keys *keys, const char *path,
                      material_keys *found) {
    tulle_scene *const loaded = work->scene;
    file_data text = {0};
    tulle_error error = {0};
    if (file_load(&loaded->heap, path, TREE_TEXT_LIMIT, &text, &error) != TULLE_OK) {
        problem_add(work->problems, error.status, schema_place(keys, "file"), "%s.file: '%s' %s",
                    keys->head.path, show_text(path).text, error.message);
        return false;
    }
    loaded->content_hash = hash_bytes(loaded->content_hash, text.bytes, text.byte_count);
    tree_source const source = {.name = path,
                                .needs = "see `material` in docs/guide/scene.md for its keys",
                                .has_lines = true,
                                .text = text.bytes,
                                .length = text.byte_count};
    scene_node *const root = tree_read(&source, &loaded->storage, work->problems);
    file_release(&loaded->heap, &text);
    if (!root) return false;
    schema_reader const reader = {&loaded->storage, work->problems, path};
    *found = (material_keys){.head = {.node = root, .place = {path, 1, 1}, .path = "material"}};
    return schema_read(&reader, &material_map, root, found);
}

/* Fills the cloth's material from a material file whose path can be opened as it is. */
static bool fill_from_file(const scene_work *work, const material_keys *keys, const char *path,
                           scene_cloth *cloth) {
    material_keys found;
    if (!read_keys(work, keys, path, &found)) return false;
    if (is_given(&found, "file")) {
        problem_add(work->problems, TULLE_ERROR_PARSE, schema_place(&found, "file"),
                    "material.file: a material file cannot name another one; give a preset");
        return false;
    }
    if (!start_from_preset(work, &found, cloth)) return false;
    replace_values(&found, &cloth->material);
    return check_dynamic_friction(work, &found, cloth->material.dynamic_friction,
                                  cloth->material.friction);
}

static bool start_from_file(const scene_work *work, const material_keys *keys, scene_cloth *cloth) {
    const char *const path = resolve_path(work, keys->file);
    if (!path || !fill_from_file(work, keys, path, cloth)) return false;
    if (keys->name) cloth->contact_material = keys->name;
    return true;
}

bool scene_has_springs(const scene_work *work) {
    const scene_keys *const keys = &work->scene->keys;
    return keys->membrane == TULLE_MEMBRANE_SPRINGS && schema_place(keys, "membrane").line > 0;
}

/* Refuses what cloth made of springs does not have; a material file may have it. */
static bool check_springs(const scene_work *work, const material_keys *keys) {
    static const char *const woven[] = {"warp",
                                        "weft",
                                        "shear",
                                        "poisson",
                                        "bend_warp",
                                        "bend_weft",
                                        "bend_twist",
                                        "bend_hysteresis_warp",
                                        "bend_hysteresis_weft",
                                        "shear_hysteresis"};
    if (!scene_has_springs(work)) return true;
    for (size_t i = 0; i < sizeof woven / sizeof woven[0]; i++) {
        if (!is_given(keys, woven[i])) continue;
        problem_add(work->problems, TULLE_ERROR_PARSE, schema_place(keys, woven[i]),
                    "%s.%s: does nothing with membrane: springs, whose values are stretch, "
                    "stiffening_strain and bend; give these, or set membrane: woven",
                    keys->head.path, woven[i]);
        return false;
    }
    return true;
}

bool make_material(const scene_work *work, const material_keys *keys, scene_cloth *cloth) {
    if (!check_springs(work, keys)) return false;
    if (!(is_given(keys, "file") ? start_from_file : start_from_preset)(work, keys, cloth))
        return false;
    replace_values(keys, &cloth->material);
    return check_dynamic_friction(work, keys, cloth->material.dynamic_friction,
                                  cloth->material.friction);
}

tulle_status scene_load_material(const char *path, tulle_material *material,
                                 tulle_scene_problems *problems) {
    memset(problems, 0, sizeof *problems);
    tulle_scene loaded = {.heap = memory_default(), .path = path};
    loaded.storage = arena_make(&loaded.heap);
    const scene_work work = {&loaded, problems};
    material_keys const keys = {.head = {.place = {path, 0, 0}, .path = "material"}};
    scene_cloth cloth = {0};
    bool const is_good = fill_from_file(&work, &keys, path, &cloth);
    if (is_good) *material = cloth.material;
    arena_destroy(&loaded.storage);
    return is_good ? TULLE_OK : problems->list[0].status;
}
