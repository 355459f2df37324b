/* scene/tree.h - a YAML document as a tree that knows the place of every key and value.
 *
 * Input: text in memory. Output: nodes in an arena, or a problem with line and column. Refused,
 * each with a message: syntax errors, invalid UTF-8, several documents, duplicate keys, keys that
 * are no plain text, anchors, aliases, tags, and anything past the limits below. The limits keep
 * memory a small multiple of the text's size. */
#ifndef TULLE_SCENE_TREE_H
#define TULLE_SCENE_TREE_H

#include "base/arena.h"
#include "scene/problems.h"

enum {
    TREE_TEXT_LIMIT = 4 << 20, /* [bytes] of a scene file */
    TREE_NODE_LIMIT = 200000,
    TREE_DEPTH_LIMIT = 32,
    TREE_KEY_LIMIT = 200 /* of one map */
};

typedef enum node_kind { NODE_SCALAR, NODE_LIST, NODE_MAP } node_kind;

typedef struct scene_node scene_node;
struct scene_node {
    node_kind kind;
    bool is_quoted;           /* scalar written with quotes or as a block */
    scene_place place;        /* of the value */
    const char *key;          /* in a map; else null */
    scene_place key_place;    /* of the key */
    const char *text;         /* scalar; empty string for a missing value */
    scene_node *first, *last; /* children of a list or map */
    scene_node *next;         /* sibling */
    size_t count;             /* children */
};

/* Where text comes from. */
typedef struct tree_source {
    const char *name; /* kept: the file of all places */
    const char *text;
    size_t length;
    const char *needs; /* with has_lines: what an empty file should have had, for a message */
    bool has_lines;    /* false: places carry the name alone (overrides) */
} tree_source;

/* Reads one document. Null after adding a problem. */
scene_node *tree_read(const tree_source *source, arena *storage, tulle_scene_problems *problems);

/* The child with this key, or null. */
scene_node *tree_find(const scene_node *map, const char *key);

/* Applies one override "path=value" to the tree. False after adding a problem. */
bool tree_override(scene_node *root, const char *override_text, arena *storage,
                   tulle_scene_problems *problems);

/* A short noun for messages: "a list", "a map", "text". */
const char *node_kind_text(const scene_node *node);

/* Copies a string of known length into the arena; null when memory is short. */
char *copy_text(arena *storage, const char *text, size_t length);

#endif
