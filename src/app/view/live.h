/* app/view/live.h - a scene that is simulated while one looks at it. Its world has a thread of its
 * own, which waits for nobody: commands come through a queue, frames go out through three buffers
 * of which the newest is taken, answers through a list. Commands take effect between two steps, so
 * the bits depend on what was done before which step and on nothing else. */
#ifndef TULLE_APP_VIEW_LIVE_H
#define TULLE_APP_VIEW_LIVE_H

#include "app/view/frame.h"
#include "app/view/hold.h"
#include "app/view/series.h"

enum {
    LIVE_QUEUE_MAX = 256,   /* commands that wait */
    LIVE_ANSWER_MAX = 1024, /* answers that wait to be fetched; more are dropped */
    LIVE_SAVED_MAX = 48     /* states to which one can rewind */
};

typedef struct view_live view_live;

typedef struct live_options {
    tulle_scene *scene;            /* the live scene owns it from live_start on */
    const view_document *document; /* outlives the live scene */
    int threads;
    const char *script; /* lines of a session that are repeated at once; null: none */
    size_t script_length;
    void (*wake)(void *context); /* called by the world's thread when something can be fetched */
    void *context;
} live_options;

/* What a state message tells. */
typedef struct live_state {
    bool is_running, has_failed, is_starting, is_replaying;
    uint64_t step;
    double time, steps_per_second, real_time_ratio;
    tulle_step_report report; /* of the last step */
    uint32_t held[HOLD_GRAB_MAX];
    size_t held_count;
    uint64_t saved[LIVE_SAVED_MAX];
    size_t saved_count;
    uint64_t hash; /* of the state, where has_hash: it stands still */
    bool has_hash;
    char message[1024];
    uint64_t version; /* counts changes */
} live_state;

/* Null without memory or a thread; the scene is destroyed then, too. */
view_live *live_start(const live_options *options);
/* Ends the step that is under way, and the thread. */
void live_stop(view_live *live);

/* Hands over a command of client number `client`; false: too many wait. A later drag of the same
 * grab takes the place of an earlier one that waits. */
bool live_post(view_live *live, const view_request *request, uint32_t client);
/* Overlays that frames are to have from now on. */
void live_set_overlays(view_live *live, unsigned overlays);

/* What the network's thread fetches. The frame is valid until the next call; *version counts. */
const view_frame *live_get_frame(view_live *live, uint64_t *version);
live_state live_get_state(view_live *live);
/* An answer to a client, or false. */
bool live_take_answer(view_live *live, uint32_t *client, view_buffer *answer);
/* Adds the steps since the last call to a table. */
void live_take_rows(view_live *live, series_table *table);
/* [bytes] The recording so far, and a piece of it; as of record_read. */
uint64_t live_get_recording_size(view_live *live);
/* Counts how often the recording began anew. */
unsigned live_get_recording_generation(view_live *live);
size_t live_read_recording(view_live *live, void *bytes, size_t byte_count, uint64_t offset);

#endif
