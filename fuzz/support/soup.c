/* fuzz/support/soup.c - see soup.h. */
#include "support/soup.h"

#include <float.h>
#include <gmp.h>
#include <stdlib.h>
#include <string.h>

static double take_coordinate(fuzz_bytes *bytes, soup_places places, size_t axis) {
    if (places == SOUP_FINE) return fuzz_take_between(bytes, -2.0, 2.0);
    int const byte = fuzz_take(bytes);
    double const whole = byte % 5 - 2;
    if (places == SOUP_BESIDE) return whole * (1.0 + (byte / 5 % 8 - 4) * DBL_EPSILON);
    return places == SOUP_BILLION && axis == 0 ? 1e9 * whole : whole;
}

void soup_take_points(fuzz_bytes *bytes, soup_places places, size_t count, double *points) {
    for (size_t i = 0; i < 3 * count; i++) points[i] = take_coordinate(bytes, places, i % 3);
}

/* ---- memory of rational numbers ---- */

enum { POOL_CLASSES = 65, POOL_LEAST = 5 }; /* blocks of 2^POOL_LEAST bytes and up */

typedef struct free_block {
    struct free_block *next;
} free_block;

static free_block *pool[POOL_CLASSES];

/* size <= 2^class */
static int choose_class(size_t size) {
    int const least = size > 1 ? 64 - __builtin_clzll((unsigned long long)size - 1) : 0;
    return least > POOL_LEAST ? least : POOL_LEAST;
}

static void *take_block(size_t size) {
    int const class = choose_class(size);
    free_block *block = pool[class];
    if (block)
        pool[class] = block->next;
    else
        block = malloc((size_t)1 << class);
    if (!block) abort();
    return block;
}

static void give_block(void *block, size_t size) {
    free_block *const given = block;
    int const class = choose_class(size);
    given->next = pool[class];
    pool[class] = given;
}

static void *change_block(void *block, size_t old_size, size_t size) {
    if (choose_class(old_size) == choose_class(size)) return block;
    void *const changed = take_block(size);
    memcpy(changed, block, old_size < size ? old_size : size);
    give_block(block, old_size);
    return changed;
}

void soup_pool_numbers(void) { mp_set_memory_functions(take_block, change_block, give_block); }
