/* app/view/worker.c - see worker.h. */
#include "app/view/worker.h"

#include "base/memory.h"

#include <pthread.h>

typedef struct job_list {
    view_job *first, *last;
} job_list;

struct view_worker {
    pthread_t thread;
    pthread_mutex_t lock;
    pthread_cond_t has_job, is_idle;
    job_list waiting, done;
    int count;
    bool is_working, is_quitting;
    void (*wake)(void *context);
    void *context;
};

static void put(job_list *list, view_job *job) {
    job->next = NULL;
    if (list->last)
        list->last->next = job;
    else
        list->first = job;
    list->last = job;
}

static view_job *take(job_list *list) {
    view_job *const job = list->first;
    if (job) list->first = job->next;
    if (!list->first) list->last = NULL;
    return job;
}

static void *run(void *context) {
    view_worker *const worker = context;
    pthread_mutex_lock(&worker->lock);
    while (!worker->is_quitting) {
        view_job *const job = take(&worker->waiting);
        if (!job) {
            pthread_cond_wait(&worker->has_job, &worker->lock);
            continue;
        }
        worker->is_working = true;
        pthread_mutex_unlock(&worker->lock);
        job->work(job);
        pthread_mutex_lock(&worker->lock);
        worker->is_working = false;
        put(&worker->done, job);
        pthread_cond_broadcast(&worker->is_idle);
        pthread_mutex_unlock(&worker->lock);
        worker->wake(worker->context);
        pthread_mutex_lock(&worker->lock);
    }
    pthread_mutex_unlock(&worker->lock);
    return NULL;
}

view_worker *worker_start(void (*wake)(void *context), void *context) {
    memory heap = memory_default();
    view_worker *const worker = memory_allocate_zeroed(&heap, 1, sizeof *worker);
    if (!worker) return NULL;
    worker->wake = wake;
    worker->context = context;
    pthread_mutex_init(&worker->lock, NULL);
    pthread_cond_init(&worker->has_job, NULL);
    pthread_cond_init(&worker->is_idle, NULL);
    if (pthread_create(&worker->thread, NULL, run, worker) == 0) return worker;
    memory_release(&heap, worker, sizeof *worker);
    return NULL;
}

bool worker_post(view_worker *worker, view_job *job) {
    pthread_mutex_lock(&worker->lock);
    bool const has_room = worker->count < WORKER_JOBS_MAX;
    if (has_room) {
        put(&worker->waiting, job);
        worker->count++;
        pthread_cond_signal(&worker->has_job);
    }
    pthread_mutex_unlock(&worker->lock);
    if (!has_room) job->release(job);
    return has_room;
}

void worker_finish_done(view_worker *worker, void *owner) {
    for (;;) {
        pthread_mutex_lock(&worker->lock);
        view_job *const job = take(&worker->done);
        if (job) worker->count--;
        pthread_mutex_unlock(&worker->lock);
        if (!job) return;
        job->finish(job, owner);
        job->release(job);
    }
}

void worker_drop_all(view_worker *worker) {
    view_job *job;
    pthread_mutex_lock(&worker->lock);
    while ((job = take(&worker->waiting))) job->release(job);
    while (worker->is_working) pthread_cond_wait(&worker->is_idle, &worker->lock);
    while ((job = take(&worker->done))) job->release(job);
    worker->count = 0;
    pthread_mutex_unlock(&worker->lock);
}

void worker_stop(view_worker *worker) {
    if (!worker) return;
    memory heap = memory_default();
    pthread_mutex_lock(&worker->lock);
    worker->is_quitting = true;
    pthread_cond_signal(&worker->has_job);
    pthread_mutex_unlock(&worker->lock);
    pthread_join(worker->thread, NULL);
    worker_drop_all(worker);
    pthread_mutex_destroy(&worker->lock);
    pthread_cond_destroy(&worker->has_job);
    pthread_cond_destroy(&worker->is_idle);
    memory_release(&heap, worker, sizeof *worker);
}
