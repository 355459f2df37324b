/* detect/impact/narrow_events.c - see narrow_events.h. Events are sorted by a radix sort over the
 * digits in which keys differ, from the least significant one on. All (kind, key) differ, so the
 * order does not depend on who wrote which block. */
#include "detect/impact/narrow_events.h"

#include <string.h>

enum {
    BLOCKS_PER_WORKER = 4, /* room that every pass starts with */
    DIGIT_BITS = 11,
    DIGITS = 1 << DIGIT_BITS,
    INSERTION_MOST = 24, /* events: fewer than this are faster sorted by insertion */
    EMPTY_KIND = 255     /* of the ends of blocks */
};

void event_store_free(memory *heap, event_store *store) {
    ARRAY_FREE(heap, &store->events);
    ARRAY_FREE(heap, &store->sorted);
}

bool event_store_start(memory *heap, event_store *store, int threads) {
    atomic_store(&store->block_count, 0);
    store->sorted.count = 0;
    return ARRAY_RESERVE(heap, &store->events, (size_t)threads * BLOCKS_PER_WORKER * EVENT_BLOCK);
}

bool event_store_is_complete(memory *heap, event_store *store, int threads, tulle_status *status) {
    size_t const needed = atomic_load(&store->block_count);
    *status = TULLE_OK;
    if (needed * EVENT_BLOCK <= store->events.capacity) return true;
    /* A worker leaves at most one block unfinished. */
    size_t const room = needed + needed / 4 + (size_t)threads;
    if (!ARRAY_RESERVE(heap, &store->events, room * EVENT_BLOCK))
        *status = TULLE_ERROR_OUT_OF_MEMORY;
    return false;
}

void event_writer_start(event_writer *writer, event_store *store) {
    writer->store = store;
    writer->cursor = writer->end = writer->lost;
}

void event_writer_claim(event_writer *writer) {
    event_store *const store = writer->store;
    size_t const block = atomic_fetch_add_explicit(&store->block_count, 1, memory_order_relaxed);
    bool const fits = (block + 1) * EVENT_BLOCK <= store->events.capacity;
    writer->cursor = fits ? store->events.data + block * EVENT_BLOCK : writer->lost;
    writer->end = writer->cursor + EVENT_BLOCK;
}

void event_writer_finish(event_writer *writer) {
    while (writer->cursor != writer->end) (writer->cursor++)->kind = EMPTY_KIND;
}

/* Sorts events of one kind by key, with as much room in `space`: few by insertion, more by one
 * digit after the other. */
static void sort_by_key(raw_event *events, raw_event *space, size_t count) {
    if (count <= INSERTION_MOST) {
        for (size_t i = 1; i < count; i++) {
            raw_event const event = events[i];
            size_t at = i;
            for (; at > 0 && event.key < events[at - 1].key; at--) events[at] = events[at - 1];
            events[at] = event;
        }
        return;
    }
    raw_event *from = events, *to = space;
    for (unsigned shift = 0; shift < 64; shift += DIGIT_BITS) {
        uint32_t places[DIGITS] = {0}, begin = 0;
        for (size_t i = 0; i < count; i++) places[from[i].key >> shift & (DIGITS - 1)]++;
        if (places[from[0].key >> shift & (DIGITS - 1)] == count) continue; /* all have the same */
        for (size_t d = 0; d < DIGITS; d++) {
            uint32_t const digit_count = places[d];
            places[d] = begin;
            begin += digit_count;
        }
        for (size_t i = 0; i < count; i++)
            to[places[from[i].key >> shift & (DIGITS - 1)]++] = from[i];
        raw_event *const swapped = from;
        from = to;
        to = swapped;
    }
    if (from != events) memcpy(events, from, count * sizeof *events);
}

bool event_store_sort(memory *heap, event_store *store, bool only_earliest) {
    size_t const filled = atomic_load(&store->block_count) * EVENT_BLOCK;
    if (!ARRAY_RESERVE(heap, &store->sorted, store->events.capacity)) return false;
    double latest = 1.0;
    for (size_t i = 0; only_earliest && i < filled; i++) {
        const raw_event *const event = &store->events.data[i];
        if (event->kind != EMPTY_KIND && event->time < latest) latest = event->time;
    }

    /* Gather the events of each kind, then sort them: what was gathered need not stay in its
     * blocks. */
    size_t counts[2] = {0, 0}, total = 0;
    for (int kind = 0; kind < 2; kind++) {
        raw_event *const own = store->sorted.data + total;
        for (size_t i = 0; i < filled; i++) {
            const raw_event *const event = &store->events.data[i];
            if (event->kind == kind && event->time <= latest) own[counts[kind]++] = *event;
        }
        total += counts[kind];
    }
    sort_by_key(store->sorted.data, store->events.data, counts[0]);
    sort_by_key(store->sorted.data + counts[0], store->events.data, counts[1]);
    store->sorted.count = total;
    return true;
}
