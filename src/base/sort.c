/* base/sort.c - see sort.h.
 *
 * Short lists are sorted by insertion, long ones by a heap: a tree in the array itself in which
 * no parent comes before its children. The root, which comes last of all, is moved to the end,
 * again and again. Keys that are numbers are sorted by one digit after the other, from the least
 * significant one on.
 *
 * Based on: J. W. J. Williams, Algorithm 232: Heapsort, 1964; the heap is built from the bottom
 * as in R. W. Floyd, Algorithm 245: Treesort 3, 1964. Digits: D. E. Knuth, The Art of Computer
 * Programming 3, 5.2.5. */
#include "base/sort.h"

#include <assert.h>
#include <stdint.h>
#include <string.h>

enum {
    INSERTION_MOST = 24,
    SIZE_MOST = 96 /* [bytes] */,
    DIGIT_BITS = 8,
    DIGITS = 1 << DIGIT_BITS
};

typedef struct sorting {
    char *items;
    size_t size;
    int (*compare)(const void *, const void *);
} sorting;

static char *get_item(const sorting *list, size_t index) {
    return list->items + index * list->size;
}

/* Moves `item` from place `at` down to where no child comes after it. */
static void sink_item(const sorting *list, const char *item, size_t at, size_t count) {
    for (size_t child = 2 * at + 1; child < count; child = 2 * at + 1) {
        if (child + 1 < count &&
            list->compare(get_item(list, child + 1), get_item(list, child)) > 0)
            child++;
        if (list->compare(get_item(list, child), item) <= 0) break;
        memcpy(get_item(list, at), get_item(list, child), list->size);
        at = child;
    }
    memcpy(get_item(list, at), item, list->size);
}

void sort_by_heap(void *items, size_t count, size_t size,
                  int (*compare)(const void *, const void *)) {
    assert(size <= SIZE_MOST);
    sorting const list = {items, size, compare};
    char item[SIZE_MOST];
    for (size_t i = count / 2; i-- > 0;) {
        memcpy(item, get_item(&list, i), size);
        sink_item(&list, item, i, count);
    }
    for (size_t end = count; end-- > 1;) {
        memcpy(item, get_item(&list, end), size);
        memcpy(get_item(&list, end), list.items, size);
        sink_item(&list, item, 0, end);
    }
}

void sort_in_place(void *items, size_t count, size_t size,
                   int (*compare)(const void *, const void *)) {
    if (count > INSERTION_MOST) {
        sort_by_heap(items, count, size, compare);
        return;
    }
    assert(size <= SIZE_MOST);
    sorting const list = {items, size, compare};
    char item[SIZE_MOST];
    for (size_t i = 1; i < count; i++) {
        size_t at = i;
        while (at > 0 && compare(get_item(&list, at - 1), get_item(&list, i)) > 0) at--;
        if (at == i) continue;
        memcpy(item, get_item(&list, i), size);
        memmove(get_item(&list, at + 1), get_item(&list, at), (i - at) * size);
        memcpy(get_item(&list, at), item, size);
    }
}

/* Puts keys into the order of one digit; those where it is the same stay in theirs. */
static void sort_by_digit(const uint64_t *from, uint64_t *to, size_t count, unsigned shift) {
    uint32_t places[DIGITS] = {0}, begin = 0;
    for (size_t i = 0; i < count; i++) places[from[i] >> shift & (DIGITS - 1)]++;
    for (size_t d = 0; d < DIGITS; d++) {
        uint32_t const digit_count = places[d];
        places[d] = begin;
        begin += digit_count;
    }
    for (size_t i = 0; i < count; i++) to[places[from[i] >> shift & (DIGITS - 1)]++] = from[i];
}

const uint64_t *sort_keys(uint64_t *keys, uint64_t *spare, size_t count) {
    if (count <= INSERTION_MOST) {
        for (size_t i = 1; i < count; i++) {
            uint64_t const key = keys[i];
            size_t at = i;
            for (; at > 0 && keys[at - 1] > key; at--) keys[at] = keys[at - 1];
            keys[at] = key;
        }
        return keys;
    }
    uint64_t differing = 0; /* bits that not all keys have alike */
    for (size_t i = 1; i < count; i++) differing |= keys[i] ^ keys[0];
    for (unsigned shift = 0; shift < 64; shift += DIGIT_BITS) {
        if ((differing >> shift & (DIGITS - 1)) == 0) continue;
        sort_by_digit(keys, spare, count, shift);
        uint64_t *const swapped = keys;
        keys = spare;
        spare = swapped;
    }
    return keys;
}

int compare_u64(const void *a, const void *b) {
    uint64_t const x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return (x > y) - (x < y);
}

int compare_doubles(const void *a, const void *b) {
    double const x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}
