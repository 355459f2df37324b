/* base/parallel_backend.h - what parallel_for needs of a threading library. One of
 * parallel_openmp.c, parallel_pthreads.c and parallel_none.c is built (TULLE_THREADS in
 * CMakeLists.txt); the results do not depend on which. */
#ifndef TULLE_BASE_PARALLEL_BACKEND_H
#define TULLE_BASE_PARALLEL_BACKEND_H

#include "base/parallel.h"

/* A loop cut into chunks. */
typedef struct parallel_loop {
    size_t count, chunk_size, chunk_count;
    parallel_body body;
    void *context;
} parallel_loop;

/* Runs one chunk of the loop on the calling thread. */
void parallel_run_chunk(const parallel_loop *loop, size_t chunk, int worker);

/* Runs all chunks, each once, on up to `threads` threads (2 .. 256) with workers 0 .. threads-1;
 * returns when all are done. */
void parallel_backend_run(const parallel_loop *loop, int threads);

/* Number of processors that this process may use, at least 1. */
int parallel_backend_processor_count(void);

#endif
