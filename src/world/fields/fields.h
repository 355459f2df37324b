/* world/fields/fields.h - the values of the defs as rows, and the operations on any def by its
 * rows.
 *
 * The rows are made from the comments of the public headers by tools/make_fields.py; so a value
 * stands in its header alone, with its unit, range and default. record/recorded_call.c writes and
 * reads defs by the same rows. */
#ifndef TULLE_WORLD_FIELDS_FIELDS_H
#define TULLE_WORLD_FIELDS_FIELDS_H

#include "tulle/base.h"

#include <stdbool.h>

typedef enum field_kind {
    FIELD_DOUBLE,
    FIELD_INT,
    FIELD_ENUM,
    FIELD_U8,
    FIELD_U32,
    FIELD_U64,
    FIELD_SIZE,   /* size_t */
    FIELD_LENGTH, /* the same, of an array */
    FIELD_STRUCT,
    FIELD_TEXT, /* const char *, may be null */
    FIELD_CALL, /* a function, may be null */
    FIELD_HOST  /* of this process alone: neither recorded nor hashed */
} field_kind;

typedef struct field_table field_table;

/* A value of a def. */
typedef struct field {
    const char *name;
    size_t offset;
    field_kind kind;
    size_t count;             /* of numbers, in the def or in each item of an array */
    bool is_array;            /* a pointer to items, may be null */
    bool is_pointer;          /* to one struct, may be null */
    size_t length;            /* offset of the number of items */
    const char *item;         /* what an item belongs to, as "vertex" */
    const field_table *inner; /* of structs */
    const char *range;        /* in words, null: none. Both ends are allowed */
    double least, most;
    bool takes_zero;  /* 0 is allowed, too */
    const char *unit; /* null: none */
    double fallback[4];
    const char *group; /* null: none */
} field;

/* A def. Its first member is the cookie, if it has one. */
struct field_table {
    const char *name;
    size_t row_count, size;
    uint32_t cookie; /* 0: none */
    const field *rows;
};

extern const field_table world_def_fields, paper_options_fields, cloth_def_fields,
    obstacle_def_fields, attachment_def_fields, wind_fields, material_fields, pin_fields,
    contact_law_fields, body_drive_fields, event_watch_fields;
/* Another number for other rows. */
extern const uint32_t fields_version;

/* The public structs of libtulle. */
typedef struct struct_size {
    const char *name;
    size_t size; /* [bytes] */
} struct_size;
extern const struct_size struct_sizes[];
extern const size_t struct_size_count;

/* Puts defaults into a def; values without one become zero. */
void fields_set_defaults(const field_table *table, void *def);

/* Refuses numbers out of their range, but for those of the group or value `without`, which may be
 * null. */
tulle_status fields_check(const field_table *table, const void *def, const char *owner,
                          const char *without, tulle_error *error);

/* Adds all values to a hash but texts, what is the host's alone, the group "the host's", and those
 * whose names stand in `without` with a space on each side, in inner structs, too; it may be null.
 */
uint64_t fields_hash(const field_table *table, const void *def, const char *without, uint64_t hash);

/* [bytes] of one number or struct. */
size_t field_size(const field *row);

#endif
