/* scene/tree.c - a YAML document as a tree, built from libyaml's events. */
#include "scene/tree.h"

#include <string.h>
#include <yaml.h>

/* A map or list whose end has not come yet. */
typedef struct open_node {
    scene_node *node;
    const char *key; /* of a map: the key that waits for its value */
    scene_place key_place;
} open_node;

typedef struct tree_reader {
    const tree_source *source;
    arena *storage;
    tulle_scene_problems *problems;
    open_node stack[TREE_DEPTH_LIMIT];
    size_t depth, node_count;
    scene_node *root;
} tree_reader;

const char *node_kind_text(const scene_node *node) {
    switch (node->kind) {
    case NODE_LIST: return "a list";
    case NODE_MAP: return "a map";
    case NODE_SCALAR: break;
    }
    return node->text[0] || node->is_quoted ? "text" : "nothing";
}

char *copy_text(arena *storage, const char *text, size_t length) {
    char *copy = ARENA_NEW(storage, char, length + 1);
    if (!copy) return NULL;
    if (length > 0) memcpy(copy, text, length);
    copy[length] = '\0';
    return copy;
}

scene_node *tree_find(const scene_node *map, const char *key) {
    for (scene_node *child = map->first; child; child = child->next)
        if (strcmp(child->key, key) == 0) return child;
    return NULL;
}

static scene_place place_at(const tree_reader *reader, yaml_mark_t mark) {
    if (!reader->source->has_lines) return (scene_place){reader->source->name, 0, 0};
    return (scene_place){reader->source->name, (int)mark.line + 1, (int)mark.column + 1};
}

static bool refuse(tree_reader *reader, scene_place place, const char *message) {
    problem_add(reader->problems, TULLE_ERROR_PARSE, place, "%s", message);
    return false;
}

/* A key is plain text, given once in its map. */
static bool read_key(tree_reader *reader, open_node *open, const yaml_event_t *event) {
    scene_place place = place_at(reader, event->start_mark);
    if (event->type != YAML_SCALAR_EVENT)
        return refuse(reader, place, "a key must be a word, not a list or a map");
    const char *text = (const char *)event->data.scalar.value;
    if (event->data.scalar.length == 0) return refuse(reader, place, "a key must not be empty");
    if (memchr(text, 0, event->data.scalar.length))
        return refuse(reader, place, "a key must not hold a NUL character");
    scene_node *other = tree_find(open->node, text);
    if (other) {
        problem_add(reader->problems, TULLE_ERROR_PARSE, place,
                    "the key '%s' is given twice, first in line %d, column %d; remove one",
                    show_text(text).text, other->key_place.line, other->key_place.column);
        return false;
    }
    if (open->node->count == TREE_KEY_LIMIT) {
        problem_add(reader->problems, TULLE_ERROR_LIMIT, place, "more than %d keys in one map",
                    TREE_KEY_LIMIT);
        return false;
    }
    open->key = copy_text(reader->storage, text, event->data.scalar.length);
    open->key_place = place;
    return open->key || problem_add_memory(reader->problems, reader->source->name) == TULLE_OK;
}

/* Hangs a node under the innermost open one; as the root when there is none. */
static void attach(tree_reader *reader, scene_node *node) {
    if (reader->depth == 0) {
        reader->root = node;
        return;
    }
    open_node *open = &reader->stack[reader->depth - 1];
    if (open->node->kind == NODE_MAP) {
        node->key = open->key;
        node->key_place = open->key_place;
        open->key = NULL;
    }
    if (open->node->last)
        open->node->last->next = node;
    else
        open->node->first = node;
    open->node->last = node;
    open->node->count++;
}

static scene_node *make_node(tree_reader *reader, node_kind kind, const yaml_event_t *event) {
    scene_place place = place_at(reader, event->start_mark);
    if (reader->node_count++ == TREE_NODE_LIMIT) {
        problem_add(reader->problems, TULLE_ERROR_LIMIT, place,
                    "more than %d values in one scene; put large data into mesh files",
                    TREE_NODE_LIMIT);
        return NULL;
    }
    scene_node *node = ARENA_NEW_ZEROED(reader->storage, scene_node, 1);
    if (!node) {
        problem_add_memory(reader->problems, reader->source->name);
        return NULL;
    }
    node->kind = kind;
    node->place = place;
    node->text = "";
    return node;
}

static bool read_scalar(tree_reader *reader, const yaml_event_t *event) {
    const char *text = (const char *)event->data.scalar.value;
    size_t length = event->data.scalar.length;
    scene_node *node = make_node(reader, NODE_SCALAR, event);
    if (!node) return false;
    if (length > 0 && memchr(text, 0, length))
        return refuse(reader, node->place, "text must not hold a NUL character");
    node->is_quoted = event->data.scalar.style != YAML_PLAIN_SCALAR_STYLE;
    node->text = copy_text(reader->storage, text, length);
    if (!node->text) return problem_add_memory(reader->problems, reader->source->name) == TULLE_OK;
    attach(reader, node);
    return true;
}

static bool open_container(tree_reader *reader, node_kind kind, const yaml_event_t *event) {
    if (reader->depth == TREE_DEPTH_LIMIT) {
        problem_add(reader->problems, TULLE_ERROR_LIMIT, place_at(reader, event->start_mark),
                    "lists and maps nested more than %d deep", TREE_DEPTH_LIMIT);
        return false;
    }
    scene_node *node = make_node(reader, kind, event);
    if (!node) return false;
    attach(reader, node);
    reader->stack[reader->depth++] = (open_node){.node = node};
    return true;
}

/* Anchors, aliases and tags have no use in a scene; without them no text can grow when read. */
static bool refuse_decorations(tree_reader *reader, const yaml_event_t *event) {
    const yaml_char_t *anchor = NULL, *tag = NULL;
    if (event->type == YAML_SCALAR_EVENT)
        anchor = event->data.scalar.anchor, tag = event->data.scalar.tag;
    if (event->type == YAML_SEQUENCE_START_EVENT)
        anchor = event->data.sequence_start.anchor, tag = event->data.sequence_start.tag;
    if (event->type == YAML_MAPPING_START_EVENT)
        anchor = event->data.mapping_start.anchor, tag = event->data.mapping_start.tag;
    scene_place place = place_at(reader, event->start_mark);
    if (event->type == YAML_ALIAS_EVENT || anchor)
        return refuse(reader, place,
                      "anchors (&) and aliases (*) are not supported; write the value out, in "
                      "quotes if it begins with & or *");
    if (tag)
        return refuse(reader, place,
                      "tags (!) are not supported; write the value without, in quotes if it begins "
                      "with !");
    return true;
}

/* Takes one event; false after adding a problem. */
static bool read_event(tree_reader *reader, const yaml_event_t *event) {
    if (event->type == YAML_DOCUMENT_START_EVENT && reader->root)
        return refuse(reader, place_at(reader, event->start_mark),
                      "a second document begins here; a scene file holds one");
    if (!refuse_decorations(reader, event)) return false;
    open_node *open = reader->depth > 0 ? &reader->stack[reader->depth - 1] : NULL;
    bool is_value = event->type == YAML_SCALAR_EVENT || event->type == YAML_SEQUENCE_START_EVENT ||
                    event->type == YAML_MAPPING_START_EVENT;
    if (is_value && open && open->node->kind == NODE_MAP && !open->key)
        return read_key(reader, open, event);
    switch (event->type) {
    case YAML_SCALAR_EVENT: return read_scalar(reader, event);
    case YAML_SEQUENCE_START_EVENT: return open_container(reader, NODE_LIST, event);
    case YAML_MAPPING_START_EVENT: return open_container(reader, NODE_MAP, event);
    case YAML_SEQUENCE_END_EVENT:
    case YAML_MAPPING_END_EVENT: reader->depth--; return true;
    default: return true;
    }
}

/* Line and column of a byte, for errors that libyaml places by offset alone. */
static scene_place place_of_offset(const tree_source *source, size_t offset) {
    if (!source->has_lines) return (scene_place){source->name, 0, 0};
    scene_place place = {source->name, 1, 1};
    for (size_t i = 0; i < offset && i < source->length; i++) {
        unsigned char c = (unsigned char)source->text[i];
        if (c == '\n')
            place.line++, place.column = 1;
        else if ((c & 0xc0) != 0x80)
            place.column++;
    }
    return place;
}

static void report_syntax(tree_reader *reader, const yaml_parser_t *parser) {
    if (parser->error == YAML_MEMORY_ERROR) {
        problem_add_memory(reader->problems, reader->source->name);
        return;
    }
    const char *problem = parser->problem ? parser->problem : "syntax error";
    if (parser->error == YAML_READER_ERROR) {
        problem_add(reader->problems, TULLE_ERROR_PARSE,
                    place_of_offset(reader->source, parser->problem_offset),
                    "%s; the file must be UTF-8 text", problem);
        return;
    }
    bool const is_at_tab = parser->buffer.pointer && *parser->buffer.pointer == '\t';
    if (parser->error == YAML_SCANNER_ERROR && (is_at_tab || strstr(problem, "a tab character"))) {
        (void)refuse(reader, place_at(reader, parser->problem_mark),
                     "a tab: indent with spaces, YAML takes no tabs there");
        return;
    }
    problem_add(reader->problems, TULLE_ERROR_PARSE, place_at(reader, parser->problem_mark),
                "not valid YAML: %s%s%s", problem, parser->context ? " " : "",
                parser->context ? parser->context : "");
}

static bool read_stream(tree_reader *reader, yaml_parser_t *parser) {
    for (;;) {
        yaml_event_t event;
        if (!yaml_parser_parse(parser, &event)) {
            report_syntax(reader, parser);
            return false;
        }
        bool is_end = event.type == YAML_STREAM_END_EVENT;
        bool is_read = read_event(reader, &event);
        yaml_event_delete(&event);
        if (!is_read) return false;
        if (is_end) return true;
    }
}

scene_node *tree_read(const tree_source *source, arena *storage, tulle_scene_problems *problems) {
    tree_reader reader = {.source = source, .storage = storage, .problems = problems};
    if (source->length > TREE_TEXT_LIMIT) {
        problem_add(problems, TULLE_ERROR_LIMIT, (scene_place){source->name, 0, 0},
                    "longer than %d bytes; put large data into mesh files", TREE_TEXT_LIMIT);
        return NULL;
    }
    yaml_parser_t parser;
    if (!yaml_parser_initialize(&parser)) {
        problem_add_memory(problems, source->name);
        return NULL;
    }
    yaml_parser_set_input_string(&parser, (const unsigned char *)source->text, source->length);
    bool is_read = read_stream(&reader, &parser);
    yaml_parser_delete(&parser);
    if (!is_read) return NULL;
    if (!reader.root)
        problem_add(problems, TULLE_ERROR_PARSE, (scene_place){source->name, 0, 0},
                    source->has_lines ? "the file is empty; %s" : "the value is empty",
                    source->needs);
    return reader.root;
}
