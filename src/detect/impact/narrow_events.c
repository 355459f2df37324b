/* detect/impact/narrow_events.c - see narrow_events.h. Sorting: least significant digit radix sort
 * over the digits in which keys differ. All (kind, key) differ, so the order does not depend on who
 * wrote which block. */
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

static bool comes_before(const raw_event *a, const raw_event *b) {
    return a->kind != b->kind ? a->kind < b->kind : a->key < b->key;
}

static void sort_by_insertion(raw_event *events, size_t count) {
    for (size_t i = 1; i < count; i++) {
        raw_event const event = events[i];
        size_t at = i;
        for (; at > 0 && comes_before(&event, &events[at - 1]); at--) events[at] = events[at - 1];
        events[at] = event;
    }
}

/* Sorts stably by one digit; false, with nothing done, when all have the same. */
static bool sort_digit(const raw_event *from, raw_event *to, size_t count, unsigned shift) {
    uint32_t places[DIGITS] = {0};
    for (size_t i = 0; i < count; i++) places[from[i].key >> shift & (DIGITS - 1)]++;
    if (places[from[0].key >> shift & (DIGITS - 1)] == count) return false;
    uint32_t begin = 0;
    for (size_t d = 0; d < DIGITS; d++) {
        uint32_t const digit_count = places[d];
        places[d] = begin;
        begin += digit_count;
    }
    for (size_t i = 0; i < count; i++) to[places[from[i].key >> shift & (DIGITS - 1)]++] = from[i];
    return true;
}

/* Sorts events of one kind in `events`, with as much room in `space`. */
static void sort_by_key(raw_event *events, raw_event *space, size_t count) {
    if (count <= INSERTION_MOST) {
        sort_by_insertion(events, count);
        return;
    }
    raw_event *from = events, *to = space;
    for (unsigned shift = 0; shift < 64; shift += DIGIT_BITS) {
        if (!sort_digit(from, to, count, shift)) continue;
        raw_event *const swapped = from;
        from = to;
        to = swapped;
    }
    if (from != events) memcpy(events, from, count * sizeof *events);
}

/* Moves the events of one kind and at most time `latest` to `to`; returns their number. */
static size_t gather_kind(const event_store *store, size_t filled, feature_kind kind, double latest,
                          raw_event *to) {
    size_t count = 0;
    for (size_t i = 0; i < filled; i++) {
        const raw_event *const event = &store->events.data[i];
        if (event->kind == kind && event->time <= latest) to[count++] = *event;
    }
    return count;
}

bool event_store_sort(memory *heap, event_store *store, bool only_earliest) {
    size_t const filled = atomic_load(&store->block_count) * EVENT_BLOCK;
    if (!ARRAY_RESERVE(heap, &store->sorted, store->events.capacity)) return false;
    double latest = 1.0;
    for (size_t i = 0; only_earliest && i < filled; i++) {
        const raw_event *const event = &store->events.data[i];
        if (event->kind != EMPTY_KIND && event->time < latest) latest = event->time;
    }
    raw_event *const sorted = store->sorted.data;
    size_t const first = gather_kind(store, filled, FEATURE_VERTEX_TRIANGLE, latest, sorted);
    size_t const second = gather_kind(store, filled, FEATURE_EDGE_EDGE, latest, sorted + first);
    /* what was gathered from the blocks need not stay there */
    sort_by_key(sorted, store->events.data, first);
    sort_by_key(sorted + first, store->events.data, second);
    store->sorted.count = first + second;
    return true;
}
