/* base/parallel.c - cuts a loop into chunks and hands them to the threading library. */
#include "base/parallel.h"

#include "base/parallel_backend.h"

enum { MAX_THREADS = 256 };

size_t parallel_chunk_count(size_t count, size_t chunk_size) {
    return (count + chunk_size - 1) / chunk_size;
}

int parallel_resolve_threads(int threads) {
    if (threads <= 0) threads = parallel_backend_processor_count();
    return threads < 1 ? 1 : threads > MAX_THREADS ? MAX_THREADS : threads;
}

void parallel_run_chunk(const parallel_loop *loop, size_t chunk, int worker) {
    size_t const begin = chunk * loop->chunk_size;
    size_t const end =
        begin + loop->chunk_size < loop->count ? begin + loop->chunk_size : loop->count;
    loop->body(loop->context, begin, end, chunk, worker);
}

void parallel_for(size_t count, size_t chunk_size, int threads, parallel_body body, void *context) {
    parallel_loop const loop = {.count = count,
                                .chunk_size = chunk_size,
                                .chunk_count = parallel_chunk_count(count, chunk_size),
                                .body = body,
                                .context = context};
    if (threads > 1 && loop.chunk_count > 1) {
        size_t const useful =
            (size_t)threads < loop.chunk_count ? (size_t)threads : loop.chunk_count;
        parallel_backend_run(&loop, (int)useful);
        return;
    }
    for (size_t chunk = 0; chunk < loop.chunk_count; chunk++) parallel_run_chunk(&loop, chunk, 0);
}
