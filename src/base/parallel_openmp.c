/* base/parallel_openmp.c - the chunks of parallel_for on OpenMP's threads. */
#include "base/parallel_backend.h"

#include <omp.h>

int parallel_backend_processor_count(void) { return omp_get_num_procs(); }

void parallel_backend_run(const parallel_loop *loop, int threads) {
    size_t const chunk_count = loop->chunk_count;
#pragma omp parallel for schedule(dynamic, 1) num_threads(threads)
    for (size_t chunk = 0; chunk < chunk_count; chunk++)
        parallel_run_chunk(loop, chunk, omp_get_thread_num());
}
