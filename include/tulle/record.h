/* tulle/record.h - the calls of a host, recorded and repeated bit for bit: how a fault that shows
 * in an engine is sent to those who can mend it. `tulle replay FILE` repeats a recording.
 *
 * A recording holds every call that changes what a world comes to: defs, laws, filters and the
 * answers of a pair filter, starts, steps, what tulle/live.h, tulle/attach.h and tulle/bodies.h
 * were given, objects that come and go, watches of events, loaded states, frames that a reader
 * gave. After each start, step and load, and each change of the objects since the start, it holds
 * the status and the hash of the state. Steps of tulle_worlds_step are recorded in each world for
 * itself. Left out is what changes no bit: threads, tasks, the allocator, stop requests, user data,
 * queries.
 *
 * The bytes are the same on every machine. Each call is a block with its length and a hash, written
 * at once: what is named last before it runs, all else when it has succeeded. So a
 * recording that a crash cuts off can be repeated, the call that crashed included.
 * docs/guide/embed.md has the format. */
#ifndef TULLE_RECORD_H
#define TULLE_RECORD_H

#include "tulle/world.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Where a recording goes. */
typedef struct tulle_record_writer {
    /* Takes `byte_count` bytes, to be put behind those before. Returns 1 when all were taken, 0
     * when not. Called once a block by the thread that called the world, by one of its own within
     * tulle_worlds_step; it must not call the world. */
    int (*write)(void *context, const void *bytes, size_t byte_count);
    void *context; /* handed to `write`; the library never looks at it */
} tulle_record_writer;

/* Begins to record a world that nothing was added to yet; `writer` is copied. Null `writer`: ends
 * the recording, as tulle_world_destroy does; where there is none, nothing happens. A step then
 * costs a hash of the state more, an add a copy of its arrays.
 *
 * No call is left out silently: where a block cannot be made or written, the recording ends with
 * the block before. From then on tulle_world_start, tulle_world_step, tulle_world_load_state and
 * adding and removing are refused with TULLE_ERROR_IO or TULLE_ERROR_OUT_OF_MEMORY, until this call
 * ends the recording. Errors: TULLE_ERROR_INVALID_ARGUMENT (null world, null `write`, a world that
 * is recorded already, has or had objects, has laws, or has started), TULLE_ERROR_OUT_OF_MEMORY,
 * TULLE_ERROR_IO (the first block is not taken); nothing is recorded then. Ending gives the error
 * by which a recording had ended before. */
TULLE_API tulle_status tulle_world_record(tulle_world *world, const tulle_record_writer *writer,
                                          tulle_error *error);

/* How far a replay has come. */
typedef struct tulle_replay_report {
    uint64_t calls; /* that were repeated, the creation included */
    uint64_t steps; /* calls of tulle_world_step among them, those that failed included */
    /* [bytes] place of the last one in the recording, or of the first that cannot be read */
    size_t offset;
    const char *call; /* name of the last one; static. Null before the first */
    int is_whole;     /* 1: the end of the recording was reached; 0 also where it is cut off */
    int is_different; /* 1: the last one came to something else than was recorded */
    tulle_status recorded_status; /* of the last one, as recorded */
    tulle_status status;          /* of the last one, now */
    uint64_t recorded_hash;       /* of the state after the last call that ran, as recorded */
    uint64_t hash;                /* of the same, now */
    char message[512];            /* of the last one where it failed, else empty */
    char version[16];             /* of the library that recorded; empty before it is read */
} tulle_replay_report;

/* How to repeat a recording. Zeroed is fine. */
typedef struct tulle_replay_options {
    int threads; /* 1 .. 256, in place of those recorded; 0: as recorded */
    /* Called after each start, step, load and late change of the objects, where it is not null,
     * with `context`, the world and how far it has come. Not 0 ends the replay. Of the world it may
     * call what takes a const tulle_world. */
    int (*observe)(void *context, const tulle_world *world, const tulle_replay_report *report);
    void *context; /* handed to `observe` */
} tulle_replay_options;
/* Repeats the recording `bytes`, of `byte_count` bytes, in a world of its own, up to its end, to
 * where it is cut off, or to the first call that comes to another status or another state. `report`
 * tells which; null `options` are zeroed ones. What was interrupted or had no memory left is not
 * repeated, as it depends on more than the calls: the world is as it was. No bytes crash it.
 * Errors: TULLE_ERROR_INVALID_ARGUMENT (null, threads), TULLE_ERROR_PARSE (no recording, another
 * version of the format, a block that is damaged or not where it belongs; the message names the
 * byte; `report` tells how far it came), TULLE_ERROR_OUT_OF_MEMORY. */
TULLE_API tulle_status tulle_replay(const void *bytes, size_t byte_count,
                                    const tulle_replay_options *options,
                                    tulle_replay_report *report, tulle_error *error);

#ifdef __cplusplus
}
#endif
#endif
