/* io/animation/usd_layer.h - what a USD file says, prim by prim, as far as surfaces and their ways
 * need it. Values stay in the file; their places are known. */
#ifndef TULLE_IO_ANIMATION_USD_LAYER_H
#define TULLE_IO_ANIMATION_USD_LAYER_H

#include "io/animation/usd_text.h"

#define USD_NONE UINT32_MAX /* no number */

/* The attributes and relationships that are read. */
typedef enum usd_name {
    USD_POINTS,
    USD_FACE_COUNTS,
    USD_FACE_INDICES,
    USD_HOLES,
    USD_ORIENTATION,
    USD_SUBDIVISION,
    USD_VISIBILITY,
    USD_PURPOSE,
    USD_OP_ORDER,
    USD_PROTOTYPES, /* of an instancer, as the six that follow */
    USD_PROTO_INDICES,
    USD_POSITIONS,
    USD_ORIENTATIONS,
    USD_SCALES,
    USD_INVISIBLE,
    USD_IDS,
    USD_JOINTS, /* of a skin */
    USD_TIMES,  /* of frames, as Tulle writes them where time codes are rounded */
    USD_OP,     /* xformOp:... */
    USD_NAME_COUNT
} usd_name;

typedef enum usd_type {
    USD_UNTYPED,
    USD_MESH,
    USD_POINT_CLOUD,
    USD_INSTANCER,
    USD_SCOPE,
    USD_SHAPE, /* a surface that is not read: a sphere, curves, patches ... */
    USD_GROUP  /* any other */
} usd_type;

typedef enum usd_specifier { USD_DEF, USD_OVER, USD_CLASS } usd_specifier;

typedef struct usd_sample {
    double code; /* time */
    usd_place place;
} usd_sample;

typedef struct usd_attribute {
    usd_name name;
    uint32_t full_name; /* in texts */
    uint32_t next;      /* of the same prim */
    bool has_value;     /* one that holds at no time in particular */
    bool is_double;     /* numbers have the precision of double */
    bool is_used;       /* it moves something that is shown */
    uint32_t piece;     /* of points: the first part of a scene that shows them; USD_NONE: none */
    usd_place place, value;
    size_t first_sample, sample_count;
} usd_attribute;

/* A prim takes over what another one of the file has. */
typedef struct usd_arc {
    uint32_t path; /* in texts */
    uint32_t next; /* of the same prim */
    bool is_inherited;
    usd_place place;
} usd_arc;

/* Metadata inactiveIds of an instancer. */
typedef struct usd_inactive {
    uint32_t prim;
    bool is_explicit; /* those of weaker prims do not count */
    usd_place place;
} usd_inactive;

typedef struct usd_prim {
    uint32_t name; /* in texts; no empty one but that of the root */
    uint32_t parent, next, first_child, last_child;
    uint32_t first_attribute, attribute_count, first_arc, last_arc;
    usd_type type;
    usd_specifier specifier;
    bool is_inactive;
    usd_place place;
} usd_prim;

/* What is passed over, for the note. */
typedef struct usd_passed {
    size_t variant_sets, other_files, shapes, hidden, smooth, skins, changing;
    size_t classes;                   /* that are not there */
    uint32_t first_file, first_class; /* in texts, of other_files and classes */
    usd_place file_place;             /* where first_file is named */
} usd_passed;

typedef struct usd_layer {
    usd_text text;
    ARRAY(usd_prim) prims; /* the first is the root */
    ARRAY(usd_attribute) attributes;
    ARRAY(usd_arc) arcs;
    ARRAY(usd_sample) samples;
    ARRAY(usd_inactive) inactive;
    ARRAY(char) texts;
    uint32_t *slots; /* prims by parent and name */
    size_t slot_count;
    bool is_y_up;
    double meters_per_unit, codes_per_second, frames_per_second, start_code; /* NaN: not told */
    uint32_t default_prim;                                                   /* in texts */
    usd_passed passed;
} usd_layer;

/* Release with usd_layer_close, also after a failure. */
tulle_status usd_layer_open(memory *heap, const char *path, usd_layer *layer, tulle_error *error);
void usd_layer_close(usd_layer *layer);

const char *usd_layer_get_text(const usd_layer *layer, uint32_t text);
/* The child of a prim; USD_NONE: there is none. */
uint32_t usd_layer_find_child(const usd_layer *layer, uint32_t parent, const char *name,
                              size_t length);
/* The prim of an absolute path, "/World/a"; an empty path is that of the default prim. */
uint32_t usd_layer_find_prim(const usd_layer *layer, const char *path);
/* An attribute of a prim by itself; USD_NONE: there is none. full_name: null, or of USD_OP. */
uint32_t usd_layer_find_attribute(const usd_layer *layer, uint32_t prim, usd_name name,
                                  const char *full_name);

#endif
