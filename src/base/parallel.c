/* base/parallel.c - parallel_for over OpenMP. */
#include "base/parallel.h"

#ifdef _OPENMP
#include <omp.h>
#endif

enum { MAX_THREADS = 256 };

size_t parallel_chunk_count(size_t count, size_t chunk_size) {
    return (count + chunk_size - 1) / chunk_size;
}

int parallel_resolve_threads(int threads) {
#ifdef _OPENMP
    if (threads <= 0) threads = omp_get_num_procs();
    return threads < 1 ? 1 : threads > MAX_THREADS ? MAX_THREADS : threads;
#else
    (void)threads;
    return 1;
#endif
}

void parallel_for(size_t count, size_t chunk_size, int threads, parallel_body body, void *context) {
    size_t const chunk_count = parallel_chunk_count(count, chunk_size);
    if ((size_t)threads > chunk_count) threads = (int)chunk_count;
    if (threads <= 1) {
        for (size_t chunk = 0; chunk < chunk_count; chunk++) {
            size_t const begin = chunk * chunk_size;
            size_t const end = begin + chunk_size < count ? begin + chunk_size : count;
            body(context, begin, end, chunk, 0);
        }
        return;
    }
#ifdef _OPENMP
#pragma omp parallel for schedule(dynamic, 1) num_threads(threads)
    for (size_t chunk = 0; chunk < chunk_count; chunk++) {
        size_t const begin = chunk * chunk_size;
        size_t const end = begin + chunk_size < count ? begin + chunk_size : count;
        body(context, begin, end, chunk, omp_get_thread_num());
    }
#endif
}
