/* app/view/live_thread.h - the inside of a live scene, for live.c (what both threads touch),
 * live_thread.c (the loop), live_commands.c and live_saved.c. */
#ifndef TULLE_APP_VIEW_LIVE_THREAD_H
#define TULLE_APP_VIEW_LIVE_THREAD_H

#include "app/view/live.h"
#include "app/view/record.h"

#include "tulle/live.h"
#include "tulle/query.h"

#include <pthread.h>

typedef struct live_command {
    view_request request;
    uint32_t client;
} live_command;

typedef struct live_answer {
    uint32_t client;
    view_buffer buffer;
} live_answer;

/* A state to go back to, with what hands did then. */
typedef struct live_saved {
    uint64_t step;
    void *bytes;
    size_t byte_count;
    uint64_t script_bytes;
    live_hold hold;
} live_saved;

struct view_live {
    live_options options;
    pthread_t thread;
    atomic_bool is_quitting;
    atomic_uint overlays;

    /* Between the threads, under the lock; the world's thread holds it for moments only. */
    pthread_mutex_t lock;
    pthread_cond_t has_news; /* for the world's thread */
    live_command queue[LIVE_QUEUE_MAX];
    size_t queue_count;
    live_answer answers[LIVE_ANSWER_MAX];
    size_t answer_begin, answer_count;
    live_state state;
    series_row *rows; /* LIVE_ROWS_MAX */
    size_t row_count;
    int ready; /* which of the frames is the newest */
    uint64_t frame_version;
    bool must_publish; /* other overlays are wanted */

    view_frame frames[3];
    int front; /* the network's thread reads it */
    uint64_t front_version;

    /* Of the world's thread alone. */
    int back;
    memory heap;
    tulle_scene_world built;
    live_hold hold;
    hold_scene held;
    view_record recording, script;
    bool is_running, has_failed, is_started;
    uint64_t steps_left; /* while it is not running */
    double speed;        /* times real time; 0: as fast as it goes */
    double next_step;    /* [s] of the clock */
    double rate_begin;   /* [s] of the clock */
    uint64_t rate_steps;
    tulle_step_report report;
    char message[1024];
    live_saved saved[LIVE_SAVED_MAX];
    size_t saved_count, saved_bytes;
    uint64_t save_interval; /* steps */
    const char *replayed;   /* the rest of the script that is repeated; null: none */
};

enum { LIVE_ROWS_MAX = 8192 };

/* live_thread.c */
void *live_run(void *live);
void live_say(view_live *live, const char *format, ...) __attribute__((format(printf, 2, 3)));
/* Builds the world anew and starts it: nothing was done. */
tulle_status live_build(view_live *live, tulle_error *error);
void live_publish(view_live *live);

/* live_commands.c */
void live_execute(view_live *live, live_command *command);
/* Executes those lines of the script whose step has come; ends the replay behind the last. */
void live_go_on_with_script(view_live *live);

/* live_saved.c */
void live_save_if_due(view_live *live);
void live_forget_saved(view_live *live);
tulle_status live_rewind(view_live *live, uint64_t step, tulle_error *error);

/* live.c: a text is taken over; the network is woken. */
void live_answer_client(view_live *live, uint32_t client, view_buffer *buffer);
void live_put_state(view_live *live);
void live_put_row(view_live *live, const tulle_step_report *report);

#endif
