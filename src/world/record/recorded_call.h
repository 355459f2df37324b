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

/* Its last byte is the version of the format. */
#define RECORD_MAGIC "TULLREC3"
enum { RECORD_MAGIC_BYTES = 8, RECORD_HEAD_BYTES = 16, RECORD_HASH_BYTES = 8 };

/* Kinds of blocks. Their numbers are part of the format: new ones come before RECORD_KIND_COUNT. */
typedef enum record_kind {
    RECORD_END,    /* the host ended the recording */
    RECORD_CREATE, /* the first block, with the version of the library */
    RECORD_RESULT, /* of what runs, see record_runs: is_started; status, hash */
    RECORD_FRAME,  /* that a reader gave in one: obstacle, frame; status; positions */
    RECORD_ANSWER, /* of a pair filter in one: -; 1 or 0 */
    RECORD_START,  /* -; bits of time, steps; positions, velocities and, behind them, the bodies; or
                    * all is zero and none: at time 0 */
    RECORD_STEP,   /* -; -; time step */
    RECORD_LOAD,   /* the state */
    RECORD_CLOTH,  /* the def; so for the next one */
    RECORD_OBSTACLE,
    RECORD_CLOTH_CLOTH_LAW, /* both indices; -; the law; so for the next three */
    RECORD_CLOTH_OBSTACLE_LAW,
    RECORD_OBSTACLE_OBSTACLE_LAW,
    RECORD_MATERIAL_LAW, /* names in place of indices */
    RECORD_FILTER,       /* index, kind; category, mask */
    RECORD_PAIR_FILTER,  /* -; whether there is one */
    RECORD_TRANSFORM,    /* obstacle; travel; translation, rotation */
    RECORD_POSITIONS,    /* obstacle; travel; positions */
    RECORD_PIN_TARGETS,  /* cloth; pin; positions */
    RECORD_GRAVITY,      /* -; -; gravity */
    RECORD_WIND,         /* -; seed; all else of it */
    RECORD_MATERIAL,     /* cloth; the material */
    RECORD_THICKNESS,    /* cloth; -; thickness */
    RECORD_RELEASE_PIN,  /* cloth; pin */
    RECORD_ATTACH,       /* the def */
    RECORD_POINTS,       /* attachment; -; points */
    RECORD_RELEASE,      /* attachment */
    RECORD_IMPULSE,      /* obstacle; -; point, impulse */
    RECORD_WAKE,         /* obstacle */
    RECORD_VELOCITY,     /* obstacle; -; velocity or none, angular velocity or none */
    RECORD_FORCE,        /* obstacle; -; point or none, force */
    RECORD_TORQUE,       /* obstacle; -; torque */
    RECORD_LOCKS,        /* obstacle; translations, rotations */
    RECORD_DRIVE,        /* obstacle; -; the drive or none */
    RECORD_WATCH,        /* -; kinds, capacity; force, or none: watches no more */
    RECORD_WAKE_CLOTH,   /* cloth */
    RECORD_ADD_CLOTH,    /* the def, of a world that has started; so for the next one */
    RECORD_ADD_OBSTACLE,
    RECORD_REMOVE_CLOTH,    /* cloth */
    RECORD_REMOVE_OBSTACLE, /* obstacle */
    RECORD_KIND_COUNT
} record_kind;

/* Numbers of a body at a start amid a motion: position, rotation and velocities, the first members
 * of tulle_transform, and zeros up to a multiple of three. */
enum { RECORD_BODY_COUNT = 15, RECORD_BODY_BYTES = 13 * sizeof(double) };

/* Length of an array that depends on the call. */
#define RECORD_ANY_COUNT SIZE_MAX

/* What is known of a kind. */
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
 * is known. Status: TULLE_ERROR_OUT_OF_MEMORY, or TULLE_ERROR_PARSE where a payload is not one of
 * its kind. */
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
