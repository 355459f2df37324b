/* base/sort.h - sorts without a heap call, which qsort of the C library may make. */
#ifndef TULLE_BASE_SORT_H
#define TULLE_BASE_SORT_H

#include <stddef.h>
#include <stdint.h>

/* In place, as qsort; equal items end in an order that depends on the items alone. size: at most 96
 * bytes. */
void sort_in_place(void *items, size_t count, size_t size,
                   int (*compare)(const void *, const void *));
/* The same by a heap, however few the items are. */
void sort_by_heap(void *items, size_t count, size_t size,
                  int (*compare)(const void *, const void *));

/* Sorts keys, fewer than 2^32, between two lists of so many that do not overlap; both are written
 * to. Gives the one that holds the sorted keys. */
const uint64_t *sort_keys(uint64_t *keys, uint64_t *spare, size_t count);

/* Compare two items for an ascending order: keys of 64 bits; doubles that are not NaN. */
int compare_u64(const void *a, const void *b);
int compare_doubles(const void *a, const void *b);

#endif
