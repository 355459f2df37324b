/* tulle/record.h - the calls of a host, recorded and repeated bit for bit. A fault that shows in an
 * engine can be sent to others who repair it. `tulle replay FILE` repeats a recording.
 *
 * A recording holds every call that changes the results of a world. These are defs, laws, filters
 * and the answers of a pair filter; starts, steps and loaded states; calls of tulle/live.h,
 * tulle/attach.h and tulle/bodies.h; adding and removing objects; watches of events; frames from a
 * reader. It also holds the status and the state hash after each start, step and load, and after
 * each late change of the objects. Steps of tulle_worlds_step are recorded in each world
 * separately. Calls that change no bit are left out: threads, tasks, the allocator, stop requests,
 * user data, queries.
 *
 * The bytes are the same on every machine. Each call is a block with its length and a hash, written
 * at once. Starts, steps, loads and late changes of the objects are written before they run, all
 * other calls after they have succeeded. So a recording that ends with a crash can be repeated,
 * including the call that crashed. docs/guide/embed.md has the format. */
#ifndef TULLE_RECORD_H
#define TULLE_RECORD_H

#include "tulle/world.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Where a recording goes. */
typedef struct tulle_record_writer {
    /* Appends `byte_count` bytes to the recording. Returns 1 if all were written, else 0. Called
     * once for each block, by the thread that called the world or, within tulle_worlds_step, by one
     * of its threads. It must not call the world. */
    int (*write)(void *context, const void *bytes, size_t byte_count);
    void *context; /* handed to `write`; the library never looks at it */
} tulle_record_writer;

/* Begins to record a world to which nothing was added yet; `writer` is copied. A null `writer` ends
 * the recording, as tulle_world_destroy does; without a recording it does nothing. While recording,
 * a step also costs a hash of the state, and an add costs a copy of its arrays.
 *
 * No call is left out silently. If a block cannot be made or written, the recording ends with the
 * block before it. From then on, starts, steps, loads, adding and removing are refused with
 * TULLE_ERROR_IO or TULLE_ERROR_OUT_OF_MEMORY, until this call ends the recording. Errors:
 * TULLE_ERROR_INVALID_ARGUMENT (null world, null `write`, a world that is recorded already, has or
 * had objects, has laws, or has started), TULLE_ERROR_OUT_OF_MEMORY, TULLE_ERROR_IO (the first
 * block cannot be written); nothing is recorded then. The call that ends a recording gives the
 * error that stopped it before, if there was one. */
TULLE_API tulle_status tulle_world_record(tulle_world *world, const tulle_record_writer *writer,
                                          tulle_error *error);

/* How far a replay has come. */
typedef struct tulle_replay_report {
    uint64_t calls; /* calls that were repeated, the creation included */
    uint64_t steps; /* calls of tulle_world_step among them, those that failed included */
    /* [bytes] place of the last repeated call in the recording, or of the first call that cannot be
     * read */
    size_t offset;
    const char *call; /* name of the last call; static. Null before the first */
    int is_whole;     /* 1: the end of the recording was reached; 0 also if it is cut off */
    int is_different; /* 1: the result of the last call differs from the recorded one */
    tulle_status recorded_status; /* of the last call, as recorded */
    tulle_status status;          /* of the last call, now */
    uint64_t recorded_hash;       /* of the state after the last call that ran, as recorded */
    uint64_t hash;                /* of that state, now */
    char message[512];            /* of the last call if it failed, else empty */
    char version[16];             /* of the library that recorded; empty before it is read */
} tulle_replay_report;

/* How to repeat a recording. Zeroed is fine. */
typedef struct tulle_replay_options {
    int threads; /* 1 .. 256, in place of the recorded number; 0: as recorded */
    /* If not null, called after each start, step, load and late change of the objects, with
     * `context`, the world and the report so far. Any return value but 0 ends the replay. It may
     * call functions that take a const tulle_world. */
    int (*observe)(void *context, const tulle_world *world, const tulle_replay_report *report);
    void *context; /* handed to `observe` */
} tulle_replay_options;
/* Repeats the recording `bytes`, of `byte_count` bytes, in a world of its own. It ends at the end
 * of the recording, where the recording is cut off, or at the first call with another status or
 * another state; `report` says which. Null `options` mean zeroed options. A call that was
 * interrupted or ran out of memory is not repeated, because this depends on more than the calls; it
 * left the world as it was. No content of `bytes` crashes it. Errors: TULLE_ERROR_INVALID_ARGUMENT
 * (null, threads), TULLE_ERROR_PARSE (not a recording, another version of the format, a block that
 * is damaged or in a wrong place; the message names the byte, and `report` says how far the replay
 * came), TULLE_ERROR_OUT_OF_MEMORY. */
TULLE_API tulle_status tulle_replay(const void *bytes, size_t byte_count,
                                    const tulle_replay_options *options,
                                    tulle_replay_report *report, tulle_error *error);

#ifdef __cplusplus
}
#endif
#endif
