/* world/record/recorded_call.h - a call of a host as a block of bytes, and back.
 *
 * A recording is RECORD_MAGIC and blocks. A block is, little endian:
 *
 *   8 bytes  length of the payload
 *   4 bytes  record_kind
 *   4 bytes  lower half of the hash_block of the 12 bytes before
 *   payload
 *   8 bytes  hash_block of the payload
 *
 * The payload has two ids, their generations, two numbers and two arrays of doubles, each with its
 * count, whatever the call makes of them; then a def, where it has one. One function walks over a
 * call for writing and for reading (recorded_call_visit), so both agree. */
#ifndef TULLE_WORLD_RECORD_RECORDED_CALL_H
#define TULLE_WORLD_RECORD_RECORDED_CALL_H

#include "base/arena.h"
#include "tulle/attach.h"
#include "tulle/bodies.h"
#include "tulle/events.h"
#include "world/fields/fields.h"

/* Its last byte is the version of the format. */
#define RECORD_MAGIC "TULLREC4"
enum { RECORD_MAGIC_BYTES = 8, RECORD_HEAD_BYTES = 16, RECORD_HASH_BYTES = 8 };

/* Kinds of blocks: the call, how long its arrays are, or ANY: a multiple of three; in the comment
 * ids; numbers; arrays. Their order is part of the format: new ones come last. */
#define RECORD_KINDS(X)                                                                            \
    X(END, "the end", 0, 0)                       /* the host ended the recording */               \
    X(CREATE, "tulle_world_create", 0, 0)         /* -; fields_version; version, def */            \
    X(RESULT, "a result", 0, 0)                   /* of what runs: is_started; status, hash */     \
    X(FRAME, "a frame", ANY, 0)                   /* obstacle, frame; status; positions */         \
    X(ANSWER, "an answer of a pair filter", 0, 0) /* of a pair filter in one: -; 1 or 0 */         \
    X(START, "tulle_world_start", ANY, ANY)       /* -; time, steps; positions, the rest */        \
    X(STEP, "tulle_world_step", 1, 0)             /* -; -; time step */                            \
    X(LOAD, "tulle_world_load_state", 0, 0)       /* the state */                                  \
    X(CLOTH, "tulle_world_add_cloth", 0, 0)       /* the def; so for the next one */               \
    X(OBSTACLE, "tulle_world_add_obstacle", 0, 0)                                                  \
    X(CLOTH_CLOTH_LAW, "tulle_world_set_cloth_cloth_law", 0, 0) /* both; -; the law */             \
    X(CLOTH_OBSTACLE_LAW, "tulle_world_set_cloth_obstacle_law", 0, 0)                              \
    X(OBSTACLE_OBSTACLE_LAW, "tulle_world_set_obstacle_obstacle_law", 0, 0)                        \
    X(MATERIAL_LAW, "tulle_world_set_material_law", 0, 0)     /* names in place of indices */      \
    X(FILTER, "tulle_object_set_filter", 0, 0)                /* index, kind; category, mask */    \
    X(PAIR_FILTER, "tulle_world_set_pair_filter", 0, 0)       /* -; whether there is one */        \
    X(TRANSFORM, "tulle_obstacle_set_next_transform", 3, 4)   /* obstacle; travel; pose */         \
    X(POSITIONS, "tulle_obstacle_set_next_positions", ANY, 0) /* obstacle; travel; positions */    \
    X(PIN_TARGETS, "tulle_cloth_set_pin_targets", ANY, 0)     /* cloth; pin; positions */          \
    X(GRAVITY, "tulle_world_set_gravity", 3, 0)               /* -; -; gravity */                  \
    X(WIND, "tulle_world_set_wind", 0, 0)                     /* the wind */                       \
    X(MATERIAL, "tulle_cloth_set_material", 0, 0)             /* cloth; the material */            \
    X(THICKNESS, "tulle_cloth_set_thickness", 1, 0)           /* cloth; -; thickness */            \
    X(RELEASE_PIN, "tulle_cloth_release_pin", 0, 0)           /* cloth; pin */                     \
    X(ATTACH, "tulle_world_attach", 0, 0)                     /* the def */                        \
    X(POINTS, "tulle_attachment_set_points", ANY, 0)          /* attachment; -; points */          \
    X(RELEASE, "tulle_attachment_release", 0, 0)              /* attachment */                     \
    X(IMPULSE, "tulle_obstacle_add_impulse", 3, 3)            /* obstacle; -; point, impulse */    \
    X(WAKE, "tulle_obstacle_wake", 0, 0)                      /* obstacle */                       \
    X(VELOCITY, "tulle_obstacle_set_velocity", 3, 3) /* obstacle; -; both velocities, or none */   \
    X(FORCE, "tulle_obstacle_add_force", 3, 3)       /* obstacle; -; point or none, force */       \
    X(TORQUE, "tulle_obstacle_add_torque", 3, 0)     /* obstacle; -; torque */                     \
    X(LOCKS, "tulle_obstacle_set_locks", 0, 0)       /* obstacle; translations, rotations */       \
    X(DRIVE, "tulle_obstacle_set_drive", 0, 0)       /* obstacle; whether there is one; it */      \
    X(WATCH, "tulle_world_watch_events", 0, 0)       /* -; whether it watches; what */             \
    X(WAKE_CLOTH, "tulle_cloth_wake", 0, 0)          /* cloth */                                   \
    X(ADD_CLOTH, "tulle_world_add_cloth", 0, 0)      /* the def; so for the next one */            \
    X(ADD_OBSTACLE, "tulle_world_add_obstacle", 0, 0)                                              \
    X(REMOVE_CLOTH, "tulle_world_remove_cloth", 0, 0)       /* cloth */                            \
    X(REMOVE_OBSTACLE, "tulle_world_remove_obstacle", 0, 0) /* obstacle */                         \
    X(TARGETS, "tulle_cloth_set_targets", ANY, ANY)         /* cloth; -; both; a state: led */     \
    X(PLACE, "tulle_world_place", ANY, 0)                   /* -; -; positions */

#define RECORD_ENUM(kind, call, first, second) RECORD_##kind,
typedef enum record_kind { RECORD_KINDS(RECORD_ENUM) RECORD_KIND_COUNT } record_kind;

/* Numbers of a body at a start amid a motion: position, rotation and velocities, the first members
 * of tulle_transform, and zeros up to a multiple of three. */
enum { RECORD_BODY_COUNT = 15, RECORD_BODY_BYTES = 13 * sizeof(double) };

/* Length of an array that depends on the call. */
#define RECORD_ANY_COUNT SIZE_MAX

typedef struct record_facts {
    const char *name; /* of the call */
    size_t counts[2]; /* of its arrays, or RECORD_ANY_COUNT: a multiple of three */
} record_facts;
extern const record_facts record_kinds[RECORD_KIND_COUNT];

typedef struct recorded_array {
    const double *data; /* null: none */
    size_t count;
} recorded_array;

typedef struct recorded_state {
    const void *bytes;
    size_t byte_count;
} recorded_state;

/* A call; what a kind does not have is zero. */
typedef struct recorded_call {
    record_kind kind;
    uint32_t ids[2];
    uint32_t generations[2]; /* of objects among them */
    uint64_t numbers[2];
    recorded_array arrays[2];
    union {
        tulle_world_def world;
        tulle_cloth_def cloth;
        tulle_obstacle_def obstacle; /* read_frame: null or not */
        tulle_attachment_def attachment;
        tulle_material material;
        tulle_wind wind;
        tulle_contact_law law;
        tulle_body_drive drive;
        tulle_event_watch watch;
        recorded_state state;
    } def;
    const char *texts[2]; /* of the kinds that have texts; or null */
} recorded_call;

/* Bytes that a call is written to or read from. */
typedef struct record_stream {
    bool is_reading;
    tulle_status status; /* of what went wrong first; the rest is left out then */
    /* writing */
    memory *heap;
    ARRAY(unsigned char) bytes;
    /* reading */
    const unsigned char *at, *end;
    arena *scratch; /* what was read points into it */
} record_stream;

/* Writes a call as a block behind what is in the stream; or reads the payload of one, whose kind
 * is known. Status: TULLE_ERROR_OUT_OF_MEMORY, TULLE_ERROR_PARSE where a payload is not one of its
 * kind, TULLE_ERROR_UNSUPPORTED where defs have other values; texts[0] is whose. */
tulle_status recorded_call_write(record_stream *stream, const recorded_call *call);
tulle_status recorded_call_read(record_stream *stream, recorded_call *call);

/* Whether a call is written before it runs, and its result after. */
static inline bool record_runs(record_kind kind) {
    return (kind >= RECORD_START && kind <= RECORD_LOAD) ||
           (kind >= RECORD_ADD_CLOTH && kind <= RECORD_REMOVE_OBSTACLE);
}

/* Little endian numbers of 1 to 8 bytes. */
void record_store(unsigned char *bytes, size_t byte_count, uint64_t value);
uint64_t record_load(const unsigned char *bytes, size_t byte_count);

/* Makes the checks in the head of a block and behind its payload. `block` is whole. */
void record_seal(unsigned char *block, size_t byte_count);

#endif
