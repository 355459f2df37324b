/* support/failing_requests.c - see failing_requests.h. */
#include "support/failing_requests.h"

#include "base/arena.h"

#include "support/test_support.h"

#include <string.h>

enum { TABLE_SIZE = 1 << 14 }; /* a power of two, several times the places of any test */

static uintptr_t table[TABLE_SIZE]; /* places that were refused; 0: free */
static size_t place_count;
static bool is_watched, is_refused;

size_t count_refused_places(void) { return place_count; }

bool survives_refusal(const char *name, refused_call call, void *context) {
    tulle_error error = {0};
    is_watched = true;
    is_refused = false;
    tulle_status const status = call(context, &error);
    is_watched = false;
    if (status == TULLE_OK) return true;
    if (status != TULLE_ERROR_OUT_OF_MEMORY || !is_refused)
        fail_msg("%s: status %d, %s", name, (int)status, error.message);
    if (error.status != status || !strstr(error.message, "memory"))
        fail_msg("%s: memory is short, but it says \"%s\"", name, error.message);
    return false;
}

/* Whether the request of a caller is refused. */
static bool is_refused_now(const void *caller, const void *frame) {
    if (!is_watched || is_refused) return false;
    uintptr_t const place = (uintptr_t)caller * 31 + (uintptr_t)frame;
    size_t slot = (place * (uintptr_t)0x9e3779b97f4a7c15u >> 20) % TABLE_SIZE;
    for (; table[slot]; slot = (slot + 1) % TABLE_SIZE)
        if (table[slot] == place) return false;
    if (2 * place_count >= TABLE_SIZE) return false;
    table[slot] = place;
    place_count++;
    is_refused = true;
    return true;
}

/* Of a wrapper: its return address says who called, its frame how deep the stack is. */
#define IS_REFUSED() is_refused_now(__builtin_return_address(0), __builtin_frame_address(0))

/* The linker leads calls of NAME to __wrap_NAME, and of __real_NAME to NAME. */
#pragma GCC diagnostic ignored "-Wpedantic"
#ifdef __clang__
#pragma GCC diagnostic ignored "-Wreserved-identifier"
#endif
void *__real_memory_allocate(memory *heap, size_t byte_count);
void *__wrap_memory_allocate(memory *heap, size_t byte_count);
void *__wrap_memory_allocate(memory *heap, size_t byte_count) {
    return IS_REFUSED() ? NULL : __real_memory_allocate(heap, byte_count);
}

void *__real_memory_allocate_zeroed(memory *heap, size_t count, size_t size);
void *__wrap_memory_allocate_zeroed(memory *heap, size_t count, size_t size);
void *__wrap_memory_allocate_zeroed(memory *heap, size_t count, size_t size) {
    return IS_REFUSED() ? NULL : __real_memory_allocate_zeroed(heap, count, size);
}

bool __real_array_reserve(memory *heap, void **data, size_t *capacity, size_t count, size_t needed,
                          size_t element_size);
bool __wrap_array_reserve(memory *heap, void **data, size_t *capacity, size_t count, size_t needed,
                          size_t element_size);
bool __wrap_array_reserve(memory *heap, void **data, size_t *capacity, size_t count, size_t needed,
                          size_t element_size) {
    return !IS_REFUSED() && __real_array_reserve(heap, data, capacity, count, needed, element_size);
}

bool __real_array_match(memory *heap, void **data, size_t *capacity, size_t count, size_t wanted,
                        size_t element_size);
bool __wrap_array_match(memory *heap, void **data, size_t *capacity, size_t count, size_t wanted,
                        size_t element_size);
bool __wrap_array_match(memory *heap, void **data, size_t *capacity, size_t count, size_t wanted,
                        size_t element_size) {
    return !IS_REFUSED() && __real_array_match(heap, data, capacity, count, wanted, element_size);
}

void *__real_arena_allocate(arena *scratch, size_t count, size_t size);
void *__wrap_arena_allocate(arena *scratch, size_t count, size_t size);
void *__wrap_arena_allocate(arena *scratch, size_t count, size_t size) {
    return IS_REFUSED() ? NULL : __real_arena_allocate(scratch, count, size);
}

void *__real_arena_allocate_zeroed(arena *scratch, size_t count, size_t size);
void *__wrap_arena_allocate_zeroed(arena *scratch, size_t count, size_t size);
void *__wrap_arena_allocate_zeroed(arena *scratch, size_t count, size_t size) {
    return IS_REFUSED() ? NULL : __real_arena_allocate_zeroed(scratch, count, size);
}
