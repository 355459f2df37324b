/* scene/schema_read.c - walking a tree along the table of keys and filling structs. */
#include "scene/schema.h"

#include "base/text.h"

#include <stdarg.h>
#include <string.h>

enum { path_limit = 240 };

size_t schema_find_key(const schema_map *map, const char *name) {
    size_t k = 0;
    while (k < map->key_count && strcmp(map->keys[k].name, name) != 0) k++;
    return k;
}

bool schema_is_given(const schema_map *map, const void *target, const char *name) {
    const schema_head *head = target;
    return head->given >> schema_find_key(map, name) & 1;
}

static int selected_value(const schema_map *map, const void *target) {
    const schema_key *key = &map->keys[schema_find_key(map, map->selector)];
    return *(const int *)((const char *)target + key->offset);
}

bool schema_applies(const schema_map *map, const schema_key *key, const void *target) {
    if (!map->selector || !key->applies) return true;
    if (!schema_is_given(map, target, map->selector)) return false;
    return key->applies >> selected_value(map, target) & 1;
}

scene_place schema_place(const void *target, const char *name) {
    const schema_head *head = target;
    const scene_node *node = head->node && name ? tree_find(head->node, name) : NULL;
    return node ? node->place : head->place;
}

/* One map being read. */
typedef struct map_work {
    const schema_reader *reader;
    const schema_map *map;
    const scene_node *node; /* null: nothing given, defaults only */
    schema_head *head;      /* the struct */
    bool is_clean;
} map_work;

static void join_path(const map_work *work, const char *name, char path[path_limit]) {
    const char *base = work->head->path;
    snprintf(path, path_limit, "%s%s%s", base, base[0] ? "." : "", name);
}

static void complain(map_work *work, scene_place place, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
static void complain(map_work *work, scene_place place, const char *format, ...) {
    char message[1024];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(message, sizeof message, format, arguments);
    va_end(arguments);
    problem_add(work->reader->problems, TULLE_ERROR_PARSE, place, "%s", message);
    work->is_clean = false;
}

/* Names of the keys that exist here, for "allowed" and "did you mean". */
static size_t list_keys(const map_work *work, const char *names[64], char *text, size_t capacity) {
    size_t count = 0, used = 0;
    text[0] = '\0';
    for (size_t k = 0; k < work->map->key_count; k++) {
        const schema_key *key = &work->map->keys[k];
        if (!schema_applies(work->map, key, work->head) && key->applies) continue;
        names[count++] = key->name;
        int added = snprintf(text + used, capacity - used, "%s%s", used > 0 ? ", " : "", key->name);
        if (added > 0 && (size_t)added < capacity - used) used += (size_t)added;
    }
    return count;
}

static void refuse_unknown(map_work *work, const scene_node *child) {
    const char *names[64];
    char list[600], path[path_limit];
    size_t count = list_keys(work, names, list, sizeof list);
    shown_text shown = show_text(child->key);
    join_path(work, shown.text, path);
    const char *meant = text_find_nearest(child->key, names, count);
    if (meant)
        complain(work, child->key_place, "%s: unknown key; did you mean '%s'?", path, meant);
    else
        complain(work, child->key_place, "%s: unknown key; known here: %s", path, list);
}

/* A key of the table that the chosen shape does not have. */
static void refuse_inapplicable(map_work *work, const scene_node *child) {
    const char *names[64];
    char list[600], path[path_limit];
    list_keys(work, names, list, sizeof list);
    join_path(work, child->key, path);
    const schema_key *selector = &work->map->keys[schema_find_key(work->map, work->map->selector)];
    if (!schema_is_given(work->map, work->head, work->map->selector)) {
        complain(work, child->key_place, "%s: has a meaning only together with the key '%s'", path,
                 selector->name);
        return;
    }
    complain(work, child->key_place, "%s: does not apply to %s %s; known here: %s", path,
             selector->name, selector->choices[selected_value(work->map, work->head)], list);
}

static bool read_key(map_work *work, size_t k, const scene_node *node);

/* A struct's head: its node, its place, its path. False when memory is short. */
static bool begin_struct(const map_work *work, const scene_node *node, const char *path,
                         schema_head *head) {
    head->node = node;
    head->place = node ? (node->key ? node->key_place : node->place) : work->head->place;
    head->path = copy_text(work->reader->storage, path, strlen(path));
    if (!head->path) problem_add_memory(work->reader->problems, work->reader->file);
    return head->path != NULL;
}

static bool read_list(map_work *work, const schema_key *key, const scene_node *node,
                      const char *path) {
    size_t count = node->kind == NODE_LIST ? node->count : 0;
    if (node->kind != NODE_LIST) {
        complain(work, node->place, "%s: is %s, must be a list of maps (lines beginning with '-')",
                 path, node_kind_text(node));
        return false;
    }
    if ((double)count < key->minimum || (double)count > key->maximum) {
        complain(work, node->place, "%s: has %zu entries, must have %.0f to %.0f", path, count,
                 key->minimum, key->maximum);
        return false;
    }
    schema_list *list = (schema_list *)(void *)((char *)work->head + key->offset);
    char *items = ARENA_NEW_ZEROED(work->reader->storage, char, (count + 1) * key->map->size);
    if (!items) {
        problem_add_memory(work->reader->problems, work->reader->file);
        return work->is_clean = false;
    }
    *list = (schema_list){items, count};
    for (const scene_node *item = node->first; item; item = item->next, items += key->map->size) {
        char item_path[path_limit];
        size_t index = (size_t)(items - (char *)list->items) / key->map->size;
        if (snprintf(item_path, sizeof item_path, "%s[%zu]", path, index) < 0) return false;
        schema_head *head = (schema_head *)(void *)items;
        if (!begin_struct(work, item, item_path, head)) return work->is_clean = false;
        work->is_clean &= schema_read(work->reader, key->map, item, head);
    }
    return work->is_clean;
}

static bool read_map(map_work *work, const schema_key *key, const scene_node *node,
                     const char *path) {
    schema_head *head = (schema_head *)(void *)((char *)work->head + key->offset);
    if (!begin_struct(work, node, path, head)) return work->is_clean = false;
    work->is_clean &= schema_read(work->reader, key->map, node, head);
    return work->is_clean;
}

static bool read_key(map_work *work, size_t k, const scene_node *node) {
    const schema_key *key = &work->map->keys[k];
    char path[path_limit];
    join_path(work, key->name, path);
    if (key->type == SCHEMA_MAP) return read_map(work, key, node, path);
    if (key->type == SCHEMA_LIST) return read_list(work, key, node, path);
    value_work value = {work->reader, key, node, path, (char *)work->head + key->offset};
    work->is_clean &= schema_read_value(&value);
    return work->is_clean;
}

/* Defaults are text of the same language and pass through the same reader. */
static void read_default(map_work *work, size_t k) {
    const schema_key *key = &work->map->keys[k];
    if (key->type == SCHEMA_MAP) {
        if (!(key->flags & (SCHEMA_OPTIONAL | SCHEMA_REQUIRED))) {
            char path[path_limit];
            join_path(work, key->name, path);
            read_map(work, key, NULL, path);
        }
        return;
    }
    if (!key->fallback) return;
    tree_source source = {
        .name = work->reader->file, .text = key->fallback, .length = strlen(key->fallback)};
    const scene_node *node = tree_read(&source, work->reader->storage, work->reader->problems);
    if (!node)
        work->is_clean = false;
    else
        read_key(work, k, node);
}

static bool is_word(const scene_node *node, const char *word) {
    return node->kind == NODE_SCALAR && !node->is_quoted && strcmp(node->text, word) == 0;
}

/* Whether a key says that there is no such map. */
static bool is_turned_off(const schema_key *key, const scene_node *node) {
    return key->type == SCHEMA_MAP && key->map->takes_flag && is_word(node, "false");
}

/* Sets the bits of the keys that are given and refuses unknown ones. */
static void find_given(map_work *work) {
    for (const scene_node *child = work->node->first; child; child = child->next) {
        size_t k = schema_find_key(work->map, child->key);
        if (k < work->map->key_count && !is_turned_off(&work->map->keys[k], child))
            work->head->given |= UINT64_C(1) << k;
    }
    if (work->map->selector) {
        size_t k = schema_find_key(work->map, work->map->selector);
        const scene_node *node = tree_find(work->node, work->map->selector);
        if (node && !read_key(work, k, node)) return;
    }
    for (const scene_node *child = work->node->first; child; child = child->next) {
        size_t k = schema_find_key(work->map, child->key);
        if (k == work->map->key_count)
            refuse_unknown(work, child);
        else if (!schema_applies(work->map, &work->map->keys[k], work->head))
            refuse_inapplicable(work, child);
    }
}

/* At most one key with the flag may be given, exactly one where one is needed. One that comes from
 * an override replaces one of the file. */
static void choose_alternative(map_work *work, unsigned flag, bool is_needed) {
    char list[200] = "";
    size_t used = 0, count = 0;
    const scene_node *first = NULL, *chosen = NULL;
    for (size_t k = 0; k < work->map->key_count; k++) {
        const schema_key *key = &work->map->keys[k];
        if (!(key->flags & flag)) continue;
        int added = snprintf(list + used, sizeof list - used, "%s%s", used ? ", " : "", key->name);
        if (added > 0) used += (size_t)added;
        const scene_node *node = tree_find(work->node, key->name);
        if (!node) continue;
        count++;
        if (!first) first = node;
        if (node->key_place.line == 0) chosen = node;
    }
    if (count == 0 && is_needed)
        complain(work, work->head->place, "%s: needs one of the keys %s", work->head->path, list);
    if (count < 2) return;
    if (!chosen) {
        complain(work, first->key_place, "%s: may have only one of the keys %s", work->head->path,
                 list);
        return;
    }
    for (size_t k = 0; k < work->map->key_count; k++)
        if (work->map->keys[k].flags & flag && strcmp(work->map->keys[k].name, chosen->key) != 0)
            work->head->given &= ~(UINT64_C(1) << k);
}

static bool has_default(const map_work *work, size_t k) {
    const schema_key *const key = &work->map->keys[k];
    char *const defaults = ARENA_NEW_ZEROED(work->reader->storage, char, work->map->size);
    if (!key->fallback || !defaults) return false;
    map_work fresh = {work->reader, work->map, NULL, (schema_head *)(void *)defaults, true};
    *fresh.head = *work->head;
    read_default(&fresh, k);
    static const size_t sizes[] = {[SCHEMA_NUMBER] = sizeof(double),
                                   [SCHEMA_INTEGER] = sizeof(uint64_t),
                                   [SCHEMA_BOOL] = sizeof(bool),
                                   [SCHEMA_CHOICE] = sizeof(int),
                                   [SCHEMA_VECTOR] = sizeof(schema_vector)};
    return memcmp(defaults + key->offset, (const char *)work->head + key->offset,
                  sizes[key->type]) == 0;
}

/* Refuses keys that do nothing as the others of the map are. What an override says may leave keys
 * of the file without a use. */
static void refuse_idle(map_work *work) {
    for (const scene_node *child = work->node->first; child; child = child->next) {
        size_t const k = schema_find_key(work->map, child->key);
        if (k == work->map->key_count || !(work->head->given >> k & 1)) continue;
        const schema_key *const key = &work->map->keys[k];
        if (!key->beside) continue;
        size_t const o = schema_find_key(work->map, key->beside);
        const schema_key *const other = &work->map->keys[o];
        bool const is_given = work->head->given >> o & 1;
        const scene_node *const node = tree_find(work->node, key->beside);
        bool const is_set = is_given && node && node->key_place.line == 0;
        if (is_set || !schema_applies(work->map, other, work->head)) continue;
        char path[path_limit], words[160] = "";
        join_path(work, key->name, path);
        if (!key->beside_choices) {
            if (!is_given && !has_default(work, k))
                complain(work, child->key_place,
                         "%s: does nothing without the key '%s'; give that, too, or leave this out",
                         path, other->name);
            continue;
        }
        if (!is_given && !other->fallback) continue;
        int const value = *(const int *)(const void *)((char *)work->head + other->offset);
        if (key->beside_choices >> value & 1 || has_default(work, k)) continue;
        for (size_t c = 0, used = 0; other->choices[c]; c++) {
            if (!(key->beside_choices >> c & 1)) continue;
            int const added = snprintf(words + used, sizeof words - used, "%s%s",
                                       used > 0 ? " or " : "", other->choices[c]);
            if (added > 0 && (size_t)added < sizeof words - used) used += (size_t)added;
        }
        complain(work, child->key_place,
                 "%s: does nothing with %s: %s; set %s: %s, or leave this out", path, other->name,
                 other->choices[value], other->name, words);
    }
}

bool schema_read(const schema_reader *reader, const schema_map *map, const scene_node *node,
                 void *target) {
    map_work work = {reader, map, node, target, true};
    bool const is_bare = node && map->takes_flag && is_word(node, "true");
    if (node && node->kind != NODE_MAP && !is_bare) {
        char keys[600];
        const char *names[64];
        list_keys(&work, names, keys, sizeof keys);
        complain(&work, node->place, "%s%sis %s, must be %sa map with keys %s", work.head->path,
                 work.head->path[0] ? ": " : "the scene ", node_kind_text(node),
                 map->takes_flag ? "true, false or " : "", keys);
        return false;
    }
    if (node) {
        find_given(&work);
        choose_alternative(&work, SCHEMA_ALTERNATIVE, map->needs_alternative);
        choose_alternative(&work, SCHEMA_SECOND_ALTERNATIVE, map->needs_second_alternative);
    }
    for (const scene_node *child = node ? node->first : NULL; child; child = child->next) {
        size_t k = schema_find_key(map, child->key);
        bool is_selector = map->selector && strcmp(map->selector, child->key) == 0;
        if (k < map->key_count && work.head->given >> k & 1 && !is_selector)
            read_key(&work, k, child);
    }
    for (size_t k = 0; k < map->key_count; k++) {
        if (work.head->given >> k & 1) continue;
        if (map->keys[k].flags & SCHEMA_REQUIRED)
            complain(&work, work.head->place, "%s%sthe key '%s' is missing: %s", work.head->path,
                     work.head->path[0] ? ": " : "", map->keys[k].name, map->keys[k].meaning);
        else
            read_default(&work, k);
    }
    if (node && work.is_clean) refuse_idle(&work);
    return work.is_clean;
}
