/* base/parallel_none.c - the chunks of parallel_for one after the other on the calling thread. */
#include "base/parallel_backend.h"

int parallel_backend_processor_count(void) { return 1; }

void parallel_backend_run(const parallel_loop *loop, int threads) {
    (void)threads;
    for (size_t chunk = 0; chunk < loop->chunk_count; chunk++) parallel_run_chunk(loop, chunk, 0);
}
