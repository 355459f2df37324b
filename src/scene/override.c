/* scene/override.c - "path=value" texts from the command line, applied to the tree before it is
 * checked. A path names keys and indices: cloth[0].mesh.resolution. Maps on the way that do not
 * exist are made; an index may be that of an entry, or one past the last to append. */
#include "scene/tree.h"

#include <string.h>

/* What one step of a path names. */
typedef struct path_step {
    bool is_index;
    size_t index;
    char key[64];
} path_step;

typedef struct override_work {
    const char *text;  /* the whole override, for messages */
    scene_place place; /* "--set TEXT" */
    const char *cursor;
    const char *end; /* the '=' */
    arena *storage;
    tulle_scene_problems *problems;
} override_work;

static bool refuse(const override_work *work, const char *what) {
    problem_add(work->problems, TULLE_ERROR_PARSE, work->place,
                "%s; an override reads PATH=VALUE, as in time.frames=10 or "
                "'cloth[0].mesh.resolution=[40, 40]'",
                what);
    return false;
}

static bool is_key_character(char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
           c == '-';
}

static bool read_index(override_work *work, path_step *step) {
    work->cursor++;
    const char *begin = work->cursor;
    step->is_index = true;
    step->index = 0;
    while (work->cursor < work->end && *work->cursor >= '0' && *work->cursor <= '9') {
        step->index = step->index * 10 + (size_t)(*work->cursor - '0');
        if (step->index > TREE_NODE_LIMIT) return refuse(work, "an index is too large");
        work->cursor++;
    }
    if (work->cursor == begin || work->cursor >= work->end || *work->cursor != ']')
        return refuse(work, "an index is a number between [ and ]");
    work->cursor++;
    return true;
}

/* Reads ".key", "key" at the start, or "[index]". */
static bool read_step(override_work *work, bool is_first, path_step *step) {
    *step = (path_step){0};
    if (*work->cursor == '[' && !is_first) return read_index(work, step);
    if (!is_first) {
        if (*work->cursor != '.') return refuse(work, "the path must continue with . or [");
        work->cursor++;
    }
    size_t length = 0;
    while (work->cursor < work->end && is_key_character(*work->cursor)) {
        if (length + 1 == sizeof step->key) return refuse(work, "a key of the path is too long");
        step->key[length++] = *work->cursor++;
    }
    if (length == 0) return refuse(work, "a key of the path is empty");
    return true;
}

static void append_child(scene_node *parent, scene_node *child) {
    if (parent->last)
        parent->last->next = child;
    else
        parent->first = child;
    parent->last = child;
    parent->count++;
}

/* The child that a step names; makes it when it is not there. Null after a problem. */
static scene_node *enter(override_work *work, scene_node *node, const path_step *step) {
    node_kind needed = step->is_index ? NODE_LIST : NODE_MAP;
    bool is_empty = node->kind == NODE_SCALAR && !node->text[0] && !node->is_quoted;
    if (is_empty) node->kind = needed;
    if (node->kind != needed) {
        problem_add(work->problems, TULLE_ERROR_PARSE, work->place,
                    "the path does not fit the scene: before %s%.40s it finds %s, not %s",
                    step->is_index ? "an index" : "the key ", step->key, node_kind_text(node),
                    step->is_index ? "a list" : "a map");
        return NULL;
    }
    scene_node *child = NULL;
    if (step->is_index) {
        if (step->index > node->count) {
            problem_add(work->problems, TULLE_ERROR_PARSE, work->place,
                        "index %zu is past the end of a list of %zu", step->index, node->count);
            return NULL;
        }
        child = node->first;
        for (size_t i = 0; child && i < step->index; i++) child = child->next;
    } else {
        child = tree_find(node, step->key);
    }
    if (child) return child;
    child = ARENA_NEW_ZEROED(work->storage, scene_node, 1);
    const char *key = step->is_index ? "" : copy_text(work->storage, step->key, strlen(step->key));
    if (!child || !key) {
        problem_add_memory(work->problems, work->place.file);
        return NULL;
    }
    *child = (scene_node){.place = work->place, .key_place = work->place, .text = ""};
    child->key = step->is_index ? NULL : key;
    append_child(node, child);
    return child;
}

static void remove_child(scene_node *parent, const scene_node *child) {
    scene_node *before = NULL;
    for (scene_node *node = parent->first; node; before = node, node = node->next) {
        if (node != child) continue;
        if (before)
            before->next = node->next;
        else
            parent->first = node->next;
        if (parent->last == node) parent->last = before;
        parent->count--;
        return;
    }
}

/* Puts the value's contents into the node that the path found, keeping its key and siblings. */
static bool set_value(override_work *work, scene_node *parent, scene_node *node) {
    const char *value = work->end + 1;
    while (*value == ' ') value++;
    if (!*value) {
        remove_child(parent, node);
        return true;
    }
    tree_source source = {.name = work->place.file, .text = value, .length = strlen(value)};
    scene_node *read = tree_read(&source, work->storage, work->problems);
    if (!read) return false;
    scene_node *next = node->next;
    const char *key = node->key;
    *node = *read;
    node->next = next;
    node->key = key;
    node->key_place = work->place;
    return true;
}

bool tree_override(scene_node *root, const char *override_text, arena *storage,
                   tulle_scene_problems *problems) {
    size_t length = strlen(override_text);
    char *name = ARENA_NEW(storage, char, length + sizeof "--set ");
    if (!name) {
        problem_add_memory(problems, override_text);
        return false;
    }
    memcpy(name, "--set ", 6);
    memcpy(name + 6, override_text, length + 1);
    override_work work = {.text = override_text,
                          .place = {name, 0, 0},
                          .cursor = override_text,
                          .end = strchr(override_text, '='),
                          .storage = storage,
                          .problems = problems};
    if (!work.end) return refuse(&work, "there is no '='");
    scene_node *node = root, *parent = NULL;
    for (bool is_first = true; work.cursor < work.end; is_first = false) {
        path_step step;
        if (!read_step(&work, is_first, &step)) return false;
        parent = node;
        node = enter(&work, node, &step);
        if (!node) return false;
    }
    if (!parent) return refuse(&work, "the path is empty");
    return set_value(&work, parent, node);
}
