/* scene/make_pairs.c - laws of contact of named pairs: names of contact.pairs resolved to objects,
 * those of contact.materials checked.
 *
 * A name of a pair stands for a cloth, an obstacle, or an obstacle with all its copies. A name of a
 * material is that of a preset or of an object's material. */
#include "scene/scene_data.h"

#include "base/text.h"

#include <stdio.h>
#include <string.h>

/* The objects of one name: consecutive, since copies are. */
typedef struct named_objects {
    size_t begin, end; /* of cloths and obstacles counted together, cloths first */
} named_objects;

/* The name, or that of an obstacle whose copy this is: "spike" of "spike.012". */
static bool has_name(const tulle_scene *loaded, size_t object, const char *name) {
    const char *own = get_object_name(loaded, object);
    if (strcmp(own, name) == 0) return true;
    if (object < loaded->cloth_count) return false;
    const obstacle_keys *keys = loaded->obstacles[object - loaded->cloth_count].keys;
    const char *dot = strrchr(own, '.');
    return schema_is_given(&obstacle_map, keys, "copies") && dot &&
           strlen(name) == (size_t)(dot - own) && strncmp(own, name, strlen(name)) == 0;
}

static bool find_objects(const tulle_scene *loaded, const char *name, named_objects *found) {
    size_t const count = loaded->cloth_count + loaded->obstacle_count;
    size_t begin = 0;
    while (begin < count && !has_name(loaded, begin, name)) begin++;
    size_t end = begin;
    while (end < count && has_name(loaded, end, name)) end++;
    *found = (named_objects){begin, end};
    return end > begin;
}

static bool refuse_name(const scene_work *work, const pair_keys *keys, size_t which) {
    const tulle_scene *loaded = work->scene;
    size_t const count = loaded->cloth_count + loaded->obstacle_count;
    const char **names = ARENA_NEW(&work->scene->storage, const char *, count);
    for (size_t i = 0; names && i < count; i++) names[i] = get_object_name(loaded, i);
    const char *const name = keys->between.value[which];
    problem_add(work->problems, TULLE_ERROR_INVALID_ARGUMENT, keys->between.places[which],
                "%s.between: no cloth or obstacle is called '%s'%s", keys->head.path,
                show_text(name).text, tell_meant(work, name, names, count));
    return false;
}

static bool is_dynamic(const tulle_scene *loaded, named_objects objects) {
    return objects.begin >= loaded->cloth_count &&
           loaded->obstacles[objects.begin - loaded->cloth_count].keys->dynamic.head.node != NULL;
}

/* Whether both sides are the copies of one rigid body, which touch one another. */
static bool are_copies(const tulle_scene *loaded, const named_objects side[2]) {
    return side[0].begin == side[1].begin && side[0].end == side[1].end &&
           side[0].end - side[0].begin > 1 && is_dynamic(loaded, side[0]);
}

/* The two sides of a pair, a cloth first. False after a problem. */
static bool resolve_sides(const scene_work *work, const pair_keys *keys, named_objects side[2]) {
    const tulle_scene *loaded = work->scene;
    for (size_t i = 0; i < 2; i++)
        if (!find_objects(loaded, keys->between.value[i], &side[i]))
            return refuse_name(work, keys, i);
    if (are_copies(loaded, side)) return true;
    if (side[0].begin < side[1].end && side[1].begin < side[0].end) {
        problem_add(work->problems, TULLE_ERROR_INVALID_ARGUMENT, keys->between.places[1],
                    "%s.between: names '%s' twice; friction of a cloth on itself is "
                    "contact.friction, or by its material contact.materials",
                    keys->head.path, show_text(keys->between.value[1]).text);
        return false;
    }
    if (side[0].begin > side[1].begin) {
        named_objects const first = side[0];
        side[0] = side[1];
        side[1] = first;
    }
    bool const has_body = is_dynamic(loaded, side[0]) || is_dynamic(loaded, side[1]);
    if (side[0].begin < loaded->cloth_count || has_body) return true;
    problem_add(work->problems, TULLE_ERROR_INVALID_ARGUMENT, keys->between.places[0],
                "%s.between: '%s' and '%s' are both obstacles, which do not touch; one must be a "
                "cloth or dynamic",
                keys->head.path, show_text(keys->between.value[0]).text,
                show_text(keys->between.value[1]).text);
    return false;
}

bool check_dynamic_friction(const scene_work *work, const void *keys, double dynamic,
                            double friction) {
    if (dynamic <= friction) return true;
    const schema_head *const head = keys;
    problem_add(
        work->problems, TULLE_ERROR_INVALID_ARGUMENT, schema_place(keys, "dynamic_friction"),
        "%s.dynamic_friction: is %g, must be at most friction, %g", head->path, dynamic, friction);
    return false;
}

/* The first of `count` entries before that shares a pair of objects, or null. */
static const scene_pair *find_earlier(const scene_pair *pairs, size_t count,
                                      const scene_pair *wanted) {
    for (size_t i = 0; i < count; i++) {
        const scene_pair *const p = &pairs[i];
        if (p->first_begin < wanted->first_end && wanted->first_begin < p->first_end &&
            p->second_begin < wanted->second_end && wanted->second_begin < p->second_end)
            return p;
    }
    return NULL;
}

static bool refuse_second(const scene_work *work, const pair_keys *earlier, const pair_keys *keys) {
    scene_place const before = schema_place(earlier, "between");
    const char *const where = before.line > 0 ? store_text(work, "in line %d", before.line)
                                              : store_text(work, "by %s", before.file);
    if (!where) return false;
    problem_add(work->problems, TULLE_ERROR_INVALID_ARGUMENT, schema_place(keys, "between"),
                "%s.between: a law of '%s' and '%s' is given before, %s; keep one", keys->head.path,
                show_text(keys->between.value[0]).text, show_text(keys->between.value[1]).text,
                where);
    return false;
}

static bool make_pair(const scene_work *work, const pair_keys *keys, size_t count) {
    scene_pair *const pairs = work->scene->pairs;
    named_objects side[2];
    if (!resolve_sides(work, keys, side) ||
        !check_dynamic_friction(work, keys, keys->dynamic_friction, keys->friction))
        return false;
    pairs[count] = (scene_pair){keys, side[0].begin, side[0].end, side[1].begin, side[1].end};
    const scene_pair *const earlier = find_earlier(pairs, count, &pairs[count]);
    return earlier ? refuse_second(work, earlier->keys, keys) : true;
}

/* The names of materials that a scene has, each once: those of its objects, then presets. */
typedef struct material_names {
    const char **list;
    size_t count;
} material_names;

static bool has_material(const material_names *names, const char *name) {
    for (size_t i = 0; i < names->count; i++)
        if (strcmp(names->list[i], name) == 0) return true;
    return false;
}

static void add_material(material_names *names, const char *name) {
    if (name && !has_material(names, name)) names->list[names->count++] = name;
}

static bool find_materials(const scene_work *work, material_names *names) {
    tulle_scene *const loaded = work->scene;
    size_t preset_count = 0;
    while (tulle_material_preset_name(preset_count)) preset_count++;
    *names = (material_names){
        .list = ARENA_NEW(&loaded->storage, const char *,
                          loaded->cloth_count + loaded->obstacle_count + preset_count)};
    if (!names->list) {
        problem_add_memory(work->problems, loaded->path);
        return false;
    }
    for (size_t i = 0; i < loaded->cloth_count; i++)
        add_material(names, loaded->cloths[i].contact_material);
    for (size_t i = 0; i < loaded->obstacle_count; i++)
        add_material(names, loaded->obstacles[i].contact_material);
    for (size_t i = 0; i < preset_count; i++) add_material(names, tulle_material_preset_name(i));
    return true;
}

static bool refuse_material(const scene_work *work, const material_names *names,
                            const pair_keys *keys, size_t which) {
    char list[1000] = "";
    for (size_t i = 0, used = 0; i < names->count && used < sizeof list; i++) {
        int const added = snprintf(list + used, sizeof list - used, "%s%s", i > 0 ? ", " : "",
                                   show_text(names->list[i]).text);
        used += added > 0 ? (size_t)added : 0;
    }
    const char *const name = keys->between.value[which];
    const char *const meant = text_find_nearest(name, names->list, names->count);
    problem_add(
        work->problems, TULLE_ERROR_INVALID_ARGUMENT, keys->between.places[which],
        meant ? "%s.between: no cloth, obstacle or preset has the material '%s'; there are %s; did "
                "you mean '%s'?"
              : "%s.between: no cloth, obstacle or preset has the material '%s'; there are %s",
        keys->head.path, show_text(name).text, list, meant);
    return false;
}

static bool is_same_pair(const pair_keys *a, const pair_keys *b) {
    const char *const *x = a->between.value, *const *y = b->between.value;
    return (strcmp(x[0], y[0]) == 0 && strcmp(x[1], y[1]) == 0) ||
           (strcmp(x[0], y[1]) == 0 && strcmp(x[1], y[0]) == 0);
}

static bool check_materials(const scene_work *work) {
    const schema_list *const laws = &work->scene->keys.contact.materials;
    const pair_keys *const keys = laws->items;
    material_names names;
    if (laws->count == 0) return true;
    if (!find_materials(work, &names)) return false;
    for (size_t i = 0; i < laws->count; i++) {
        for (size_t k = 0; k < 2; k++)
            if (!has_material(&names, keys[i].between.value[k]))
                return refuse_material(work, &names, &keys[i], k);
        if (!check_dynamic_friction(work, &keys[i], keys[i].dynamic_friction, keys[i].friction))
            return false;
        for (size_t k = 0; k < i; k++)
            if (is_same_pair(&keys[k], &keys[i])) return refuse_second(work, &keys[k], &keys[i]);
    }
    return true;
}

bool make_pairs(const scene_work *work) {
    tulle_scene *const loaded = work->scene;
    const contact_keys *const contact = &loaded->keys.contact;
    if (!check_dynamic_friction(work, contact, contact->dynamic_friction, contact->friction))
        return false;
    const pair_keys *keys = loaded->keys.contact.pairs.items;
    size_t const count = loaded->keys.contact.pairs.count;
    loaded->pairs = ARENA_NEW_ZEROED(&loaded->storage, scene_pair, count + 1);
    if (!loaded->pairs) {
        problem_add_memory(work->problems, loaded->path);
        return false;
    }
    for (size_t i = 0; i < count; i++) {
        if (!make_pair(work, &keys[i], loaded->pair_count)) return false;
        loaded->pair_count++;
    }
    return check_materials(work);
}
