/* scene/schema.h - a table of keys, and what is done with it: reading a tree into structs with
 * types, units, ranges and defaults checked; printing a struct as canonical text; printing the
 * documentation.
 *
 * A schema_map describes one kind of YAML map: its keys and the C struct that they fill. Every such
 * struct begins with a schema_head. */
#ifndef TULLE_SCENE_SCHEMA_H
#define TULLE_SCENE_SCHEMA_H

#include "scene/tree.h"
#include "scene/units.h"

typedef enum schema_type {
    SCHEMA_NUMBER,   /* double */
    SCHEMA_INTEGER,  /* uint64_t */
    SCHEMA_BOOL,     /* bool */
    SCHEMA_TEXT,     /* const char * */
    SCHEMA_NAME,     /* const char *; text_is_of_name */
    SCHEMA_PATH,     /* const char *, as written */
    SCHEMA_CHOICE,   /* int: index into choices */
    SCHEMA_VECTOR,   /* schema_vector: list of least_count .. most_count numbers */
    SCHEMA_INTEGERS, /* schema_integers: the same of integers */
    SCHEMA_NAMES,    /* schema_names: least_count .. most_count names, at most 3 */
    SCHEMA_INDICES,  /* schema_indices: list of any length of integers or "first-last" ranges */
    SCHEMA_ROTATION, /* schema_rotation: [x, y, z] angles or {axis: [...], angle: ...} */
    SCHEMA_MAP,      /* the struct of `map`, in place */
    SCHEMA_LIST      /* schema_list of structs of `map` */
} schema_type;

enum {
    SCHEMA_REQUIRED = 1,      /* an error when not given */
    SCHEMA_ALTERNATIVE = 2,   /* of all keys with this flag in a map, at most one may be given */
    SCHEMA_ABOVE_MINIMUM = 4, /* the minimum itself is out of range */
    SCHEMA_UNIFORM = 8,       /* a vector may be one number, for all its components */
    SCHEMA_OPTIONAL = 16,     /* a map or alternative without defaults: absent when not given */
    SCHEMA_PICTURE = 32,      /* says how pictures look; a run does not depend on it */
    SCHEMA_NOT_ZERO = 64,     /* zero is out of range */
    SCHEMA_SECOND_ALTERNATIVE = 128 /* as SCHEMA_ALTERNATIVE: a second choice in the same map */
};

typedef struct schema_vector {
    double value[3];
    size_t count;
} schema_vector;
typedef struct schema_integers {
    uint64_t value[3];
    size_t count;
} schema_integers;
typedef struct schema_names {
    const char *value[3];
    scene_place places[3];
    size_t count;
} schema_names;
typedef struct schema_indices {
    uint32_t *value;
    size_t count;
} schema_indices;
typedef struct schema_rotation {
    double quaternion[4];   /* w, x, y, z */
    double vector[3];       /* [rad] axis times angle, as it was given */
    bool is_about_one_axis; /* else the vector is that of the quaternion: at most half a turn */
    /* As given, so that the canonical text leads to the same quaternion: angles about x, y and z,
     * or an axis and the angle about it. */
    double given[4];
    bool has_axis;
} schema_rotation;
typedef struct schema_list {
    void *items; /* structs of the list's map */
    size_t count;
} schema_list;

typedef struct schema_map schema_map;

typedef struct schema_key {
    const char *name;
    const char *meaning;  /* one line */
    const char *fallback; /* default, as YAML text read like the user's; null: none */
    const char *derived;  /* documentation only: what stands in when there is no fallback */
    size_t offset;        /* of the field in the map's struct */
    schema_type type;
    unit_dimension unit;
    unsigned flags;
    double minimum, maximum; /* of numbers and components, SI; of a list: entries. Both 0: any */
    size_t least_count, most_count; /* components of vectors and integers */
    const char *word;               /* a word taken in place of a number, as "never" */
    double word_value;
    const char *const *choices; /* null-terminated */
    const schema_map *map;
    uint64_t applies; /* bits of the selector's values for which the key is known; 0: all */
    /* A key of the map without which this one does nothing: then it may only be given with its
     * default. Null: none. With bits, a choice that must have one of these values. */
    const char *beside;
    uint64_t beside_choices;
} schema_key;

struct schema_map {
    const char *title;   /* heading in the documentation */
    const char *meaning; /* a sentence or two below the heading */
    const schema_key *keys;
    size_t key_count; /* <= 64 */
    size_t size;      /* [bytes] of the struct */
    bool needs_alternative, needs_second_alternative;
    bool takes_flag;      /* `true` stands for a map without keys, `false` for none */
    const char *selector; /* name of the choice that `applies` refers to; null: none */
};

/* How every struct of a map begins. */
typedef struct schema_head {
    const scene_node *node; /* null: not given, all fields are defaults */
    scene_place place;      /* of the key that holds the map, or the nearest one above */
    const char *path;       /* as "cloth[0].mesh" */
    uint64_t given;         /* bit k: key k is in the file */
} schema_head;

typedef struct schema_reader {
    arena *storage;
    tulle_scene_problems *problems;
    const char *file;
} schema_reader;

/* Fills *target from a node. All problems found are added; returns whether there were none. */
bool schema_read(const schema_reader *reader, const schema_map *map, const scene_node *node,
                 void *target);

/* The index of a key in a map's table; the key must exist. */
size_t schema_find_key(const schema_map *map, const char *name);
/* Whether a key was given in a struct filled by schema_read. */
bool schema_is_given(const schema_map *map, const void *target, const char *name);
/* Whether a key is known for the selector's value in this struct. */
bool schema_applies(const schema_map *map, const schema_key *key, const void *target);

/* The place of a key's value in a filled struct, or of the struct itself when it is not given. */
scene_place schema_place(const void *target, const char *name);

/* Appends text to a growing buffer in an arena. */
typedef struct text_buffer {
    arena *storage;
    char *data;
    size_t count, capacity;
    bool is_failed;    /* memory was short; the text is incomplete */
    unsigned left_out; /* keys with one of these flags are not written */
} text_buffer;
void text_append(text_buffer *buffer, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/* Writes a filled struct as YAML, defaults included, in SI units. */
void schema_write(const schema_map *map, const void *target, int indent, text_buffer *buffer);

/* Reads a value of one key into the struct; internal to the reader. */
typedef struct value_work {
    const schema_reader *reader;
    const schema_key *key;
    const scene_node *node;
    const char *path; /* of the key */
    void *field;
} value_work;
bool schema_read_value(const value_work *work);

#endif
