/* base/parallel.h - the one place that starts threads. Work is cut into chunks of a fixed size that
 * does not depend on the number of threads; results that are merged by chunk index are
 * bit-identical for any number of threads. */
#ifndef TULLE_BASE_PARALLEL_H
#define TULLE_BASE_PARALLEL_H

#include "tulle/base.h"

#include <stdbool.h>
#include <string.h>

/* Works on items begin .. end-1 of chunk `chunk`; worker is in 0 .. threads-1,
 * 0 in the thread that called parallel_for. */
typedef void (*parallel_body)(void *context, size_t begin, size_t end, size_t chunk, int worker);

/* Runs body over count items in chunks of chunk_size, dynamically on up to `threads` threads. One
 * chunk runs inline. A body does not call it. */
void parallel_for(size_t count, size_t chunk_size, int threads, parallel_body body, void *context);

/* The same without the chunks of which all items are idle: is_idle is not 0. Null: none are. */
void parallel_for_busy(const uint8_t *is_idle, size_t count, size_t chunk_size, int threads,
                       parallel_body body, void *context);

/* Whether all these items are idle; not where none is said to be. */
static inline bool are_idle(const uint8_t *is_idle, size_t begin, size_t end) {
    return is_idle && !memchr(is_idle + begin, 0, end - begin);
}

/* Number of chunks that parallel_for makes. */
size_t parallel_chunk_count(size_t count, size_t chunk_size);

/* Adds up what the chunks left, in their order. */
static inline double parallel_sum(const double *chunk_sums, size_t chunk_count) {
    double sum = 0.0;
    for (size_t chunk = 0; chunk < chunk_count; chunk++) sum += chunk_sums[chunk];
    return sum;
}

/* Where the loops of the calling thread run from here on: as tasks of the host, or on threads of
 * the library where `tasks` is null. Gives what was in force, to be put back by another call. */
const tulle_tasks *parallel_use(const tulle_tasks *tasks);
/* Whether they run on the calling thread alone, whatever else is said. */
void parallel_set_alone(bool is_alone);

/* 1 .. 256; 0 becomes the number of processors that this process may use. */
int parallel_resolve_threads(int threads);

#endif
