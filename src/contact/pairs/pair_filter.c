/* contact/pairs/pair_filter.c - see pair_filter.h. */
#include "contact/pairs/pair_filter.h"

#include "base/parallel.h"

enum { RECORD_CHUNK = 4096 /* vertices; some 15 microseconds */ };

typedef struct record_work {
    vertex_record *records;
    const double *start, *end;
} record_work;

static void fill_records(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    const record_work *const work = context;
    for (size_t i = begin; i < end; i++) {
        const double *const a = work->start + 3 * i, *const b = work->end + 3 * i;
        work->records[i] = (vertex_record){{a[0], a[1], a[2], 0.0}, {b[0], b[1], b[2], 0.0}};
    }
}

const vertex_record *make_records(const contact_scene *scene, const double *start,
                                  const double *end) {
    record_work work = {ARENA_NEW(scene->scratch, vertex_record, scene->vertex_count), start, end};
    if (work.records)
        parallel_for(scene->vertex_count, RECORD_CHUNK, scene->threads, fill_records, &work);
    return work.records;
}
