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

/* Whether the caller wants long work to end. Only the thread that the caller called may ask it:
 * that is worker 0, inside parallel_for and outside of it. Other workers see the last answer. A
 * null poll never stops. */
static inline bool stop_is_wanted(stop_poll *poll, int worker) {
    if (!poll || !poll->is_wanted) return false;
    if (atomic_load_explicit(&poll->is_stopped, memory_order_relaxed)) return true;
    if (worker != 0 || poll->is_wanted(poll->context) == 0) return false;
    atomic_store_explicit(&poll->is_stopped, true, memory_order_relaxed);
    return true;
}

#endif
