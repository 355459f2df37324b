/* detect/impact/narrow_events.h - the events that many workers find, sorted. Each worker fills
 * blocks of its own in one shared array. When the array is full, workers continue counting blocks,
 * so that the caller can make room and repeat. */
#ifndef TULLE_DETECT_IMPACT_NARROW_EVENTS_H
#define TULLE_DETECT_IMPACT_NARROW_EVENTS_H

#include "detect/impact/narrow_phase.h"

#include <stdatomic.h>

enum { EVENT_BLOCK = 64 };

typedef struct event_store {
    ARRAY(raw_event) events;    /* blocks as claimed, then space for sorting; count is unused */
    ARRAY(raw_event) sorted;    /* the result */
    _Atomic size_t block_count; /* claimed, also beyond the capacity */
} event_store;

typedef struct event_writer {
    event_store *store;
    raw_event *cursor, *end;
    raw_event lost[EVENT_BLOCK]; /* written to once the store is full */
} event_writer;

void event_store_free(memory *heap, event_store *store);
/* Empties the store and makes room for some blocks a worker; false when memory is short. */
bool event_store_start(memory *heap, event_store *store, int threads);
/* True when all that was written is there; else makes room for it for a repeat. *status says
 * whether that worked. */
bool event_store_is_complete(memory *heap, event_store *store, int threads, tulle_status *status);
/* Sorts by (kind, key) into `sorted`; with only_earliest those of the smallest time only. False
 * when memory is short. */
bool event_store_sort(memory *heap, event_store *store, bool only_earliest);

void event_writer_start(event_writer *writer, event_store *store);
/* Begins another block; the last one is full. */
void event_writer_claim(event_writer *writer);
/* Marks the rest of the last block as empty. */
void event_writer_finish(event_writer *writer);
static inline void event_writer_add(event_writer *writer, raw_event event) {
    if (writer->cursor == writer->end) event_writer_claim(writer);
    *writer->cursor++ = event;
}

#endif
