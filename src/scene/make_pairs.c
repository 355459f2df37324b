/* scene/make_pairs.c - laws of contact of named pairs: names of contact.pairs resolved to objects.
 *
 * A name stands for a cloth, an obstacle, or an obstacle with all its copies. */
#include "scene/scene_data.h"

#include "base/text.h"

#include <string.h>

/* The objects of one name: consecutive, since copies are. */
typedef struct named_objects {
    size_t begin, end; /* of cloths and obstacles counted together, cloths first */
} named_objects;

static const char *get_name(const scene *loaded, size_t object) {
    return object < loaded->cloth_count ? loaded->cloths[object].name
                                        : loaded->obstacles[object - loaded->cloth_count].name;
}

/* The name, or that of an obstacle whose copy this is: "spike" of "spike.012". */
static bool has_name(const scene *loaded, size_t object, const char *name) {
    const char *own = get_name(loaded, object);
    if (strcmp(own, name) == 0) return true;
    if (object < loaded->cloth_count) return false;
    const obstacle_keys *keys = loaded->obstacles[object - loaded->cloth_count].keys;
    const char *dot = strrchr(own, '.');
    return schema_is_given(&obstacle_map, keys, "copies") && dot &&
           strlen(name) == (size_t)(dot - own) && strncmp(own, name, strlen(name)) == 0;
}

static bool find_objects(const scene *loaded, const char *name, named_objects *found) {
    size_t const count = loaded->cloth_count + loaded->obstacle_count;
    size_t begin = 0;
    while (begin < count && !has_name(loaded, begin, name)) begin++;
    size_t end = begin;
    while (end < count && has_name(loaded, end, name)) end++;
    *found = (named_objects){begin, end};
    return end > begin;
}

static bool refuse_name(const scene_work *work, const pair_keys *keys, size_t which) {
    const scene *loaded = work->scene;
    size_t const count = loaded->cloth_count + loaded->obstacle_count;
    const char **names = ARENA_NEW(&work->scene->storage, const char *, count);
    for (size_t i = 0; names && i < count; i++) names[i] = get_name(loaded, i);
    const char *const name = keys->between.value[which];
    const char *const meant = names ? text_find_nearest(name, names, count) : NULL;
    problem_add(work->problems, TULLE_ERROR_INVALID_ARGUMENT, keys->between.places[which],
                meant ? "%s.between: '%s' is the name of no cloth or obstacle; did you mean '%s'?"
                      : "%s.between: '%s' is the name of no cloth or obstacle",
                keys->head.path, show_text(name).text, meant);
    return false;
}

static bool is_dynamic(const scene *loaded, named_objects objects) {
    return objects.begin >= loaded->cloth_count &&
           loaded->obstacles[objects.begin - loaded->cloth_count].keys->dynamic.head.node != NULL;
}

/* Whether both sides are the copies of one rigid body, which touch one another. */
static bool are_copies(const scene *loaded, const named_objects side[2]) {
    return side[0].begin == side[1].begin && side[0].end == side[1].end &&
           side[0].end - side[0].begin > 1 && is_dynamic(loaded, side[0]);
}

/* The two sides of a pair, a cloth first. False after a problem. */
static bool resolve_sides(const scene_work *work, const pair_keys *keys, named_objects side[2]) {
    const scene *loaded = work->scene;
    for (size_t i = 0; i < 2; i++)
        if (!find_objects(loaded, keys->between.value[i], &side[i]))
            return refuse_name(work, keys, i);
    if (are_copies(loaded, side)) return true;
    if (side[0].begin < side[1].end && side[1].begin < side[0].end) {
        problem_add(work->problems, TULLE_ERROR_INVALID_ARGUMENT, keys->between.places[1],
                    "%s.between: names '%s' twice; friction of a cloth on itself is "
                    "contact.friction",
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

static bool make_pair(const scene_work *work, const pair_keys *keys, size_t count) {
    scene_pair *const pairs = work->scene->pairs;
    named_objects side[2];
    if (!resolve_sides(work, keys, side) ||
        !check_dynamic_friction(work, keys, keys->dynamic_friction, keys->friction))
        return false;
    pairs[count] = (scene_pair){keys, side[0].begin, side[0].end, side[1].begin, side[1].end};
    const scene_pair *const earlier = find_earlier(pairs, count, &pairs[count]);
    if (!earlier) return true;
    scene_place const before = schema_place(earlier->keys, "between");
    const char *const where = before.line > 0 ? store_text(work, "in line %d", before.line)
                                              : store_text(work, "by %s", before.file);
    if (!where) return false;
    problem_add(work->problems, TULLE_ERROR_INVALID_ARGUMENT, schema_place(keys, "between"),
                "%s.between: a law of '%s' and '%s' is given before, %s; keep one", keys->head.path,
                show_text(keys->between.value[0]).text, show_text(keys->between.value[1]).text,
                where);
    return false;
}

bool make_pairs(const scene_work *work) {
    scene *const loaded = work->scene;
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
    return true;
}
