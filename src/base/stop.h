/* base/stop.h - whether the caller of long work wants it to end early. */
#ifndef TULLE_BASE_STOP_H
#define TULLE_BASE_STOP_H

#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>

typedef struct stop_poll {
    int (*is_wanted)(void *context); /* nonzero: end early; null: never */
    void *context;
    atomic_bool is_stopped; /* once wanted, it stays so */
} stop_poll;

/* Asks the caller. Only the thread that the caller called may ask; it is worker 0 of
 * parallel_for. A null poll never stops. */
static inline bool stop_is_wanted(stop_poll *poll) {
    if (!poll || !poll->is_wanted) return false;
    if (atomic_load_explicit(&poll->is_stopped, memory_order_relaxed)) return true;
    if (poll->is_wanted(poll->context) == 0) return false;
    atomic_store_explicit(&poll->is_stopped, true, memory_order_relaxed);
    return true;
}

/* The same from inside a chunk of parallel_for: only worker 0 asks, others see its answer. */
static inline bool stop_is_wanted_by(stop_poll *poll, int worker) {
    if (!poll) return false;
    return worker == 0 ? stop_is_wanted(poll)
                       : atomic_load_explicit(&poll->is_stopped, memory_order_relaxed);
}

#endif
