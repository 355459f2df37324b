/* app/view/worker.h - a thread for what takes long and is no step: scenes that are checked and
 * loaded, the judge, gaps. Jobs run one after the other; what is done is fetched by the network. */
#ifndef TULLE_APP_VIEW_WORKER_H
#define TULLE_APP_VIEW_WORKER_H

#include <stdbool.h>

enum { WORKER_JOBS_MAX = 64 /* that wait, or are done and not fetched */ };

typedef struct view_job view_job;
/* The beginning of a struct with what the job needs and finds. */
struct view_job {
    void (*work)(view_job *job);                /* in the worker's thread */
    void (*finish)(view_job *job, void *owner); /* in the one that fetches it */
    void (*release)(view_job *job);
    view_job *next;
};

typedef struct view_worker view_worker;

/* `wake` is called by the worker when a job is done. Null without memory or a thread. */
view_worker *worker_start(void (*wake)(void *context), void *context);
/* Ends after the job that is under way; releases all others. Null is fine. */
void worker_stop(view_worker *worker);
/* False where too many wait: then the job is released. */
bool worker_post(view_worker *worker, view_job *job);
/* Finishes and releases what is done. */
void worker_finish_done(view_worker *worker, void *owner);
/* Waits for the job that is under way and releases all jobs, unfinished. */
void worker_drop_all(view_worker *worker);

#endif
