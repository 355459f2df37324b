/* support/struck_calls.c - see struck_calls.h. */
#define _GNU_SOURCE
#include "support/struck_calls.h"

#include "base/arena.h"
#include "support/test_support.h"

#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

enum { TABLE_SIZE = 1 << 14 }; /* a power of two, several times the places of any test */

static uintptr_t table[TABLE_SIZE]; /* places that were struck; 0: free */
static size_t place_count;
static strike watched = STRIKE_COUNT; /* what is struck now; STRIKE_COUNT: nothing */
static const char *struck;            /* name of the call that was; null: none yet */

size_t count_struck_places(void) { return place_count; }

/* Whether a failure of the call may not pass in silence. */
static bool must_be_told(const char *call) {
    static const char *const told[] = {"write",  "pwrite",    "fsync",  "fdatasync",
                                       "syncfs", "ftruncate", "rename", "mkdir"};
    for (size_t i = 0; i < sizeof told / sizeof told[0]; i++)
        if (strcmp(call, told[i]) == 0) return true;
    return false;
}

tulle_status call_struck(const char *name, strike kind, struck_call call, void *context,
                         bool *is_struck) {
    tulle_error error = {0};
    struck = NULL;
    watched = kind;
    tulle_status const status = call(context, &error);
    watched = STRIKE_COUNT;
    *is_struck = struck != NULL;
    const char *const where = struck ? struck : "no call";
    tulle_status const expected = kind == STRIKE_MEMORY   ? TULLE_ERROR_OUT_OF_MEMORY
                                  : kind == STRIKE_SYSTEM ? TULLE_ERROR_IO
                                                          : TULLE_OK;
    const char *const words = kind == STRIKE_MEMORY ? "memory" : strerror(EIO);
    if (status == TULLE_OK) {
        if (struck && (kind == STRIKE_MEMORY || (kind == STRIKE_SYSTEM && must_be_told(struck))))
            fail_msg("%s: %s failed, and nothing is told", name, struck);
        return status;
    }
    if (status != expected || !struck)
        fail_msg("%s: %s was struck: status %d, %s", name, where, (int)status, error.message);
    if (error.status != status || !strstr(error.message, words))
        fail_msg("%s: %s was struck, but it says \"%s\"", name, where, error.message);
    return status;
}

/* Whether the call of a caller is struck now. */
static bool is_struck_now(strike kind, const char *call, const void *caller, const void *frame) {
    if (watched != kind || struck) return false;
    uintptr_t const place = ((uintptr_t)caller * 31 + (uintptr_t)frame) * STRIKE_COUNT + kind;
    size_t slot = (place * (uintptr_t)0x9e3779b97f4a7c15u >> 20) % TABLE_SIZE;
    for (; table[slot]; slot = (slot + 1) % TABLE_SIZE)
        if (table[slot] == place) return false;
    if (2 * place_count >= TABLE_SIZE) return false;
    table[slot] = place;
    place_count++;
    struck = call;
    return true;
}

/* Of a wrapper: its return address says who called, its frame how deep the stack is. */
#define IS_STRUCK(kind, call)                                                                      \
    is_struck_now(kind, #call, __builtin_return_address(0), __builtin_frame_address(0))

/* The linker leads calls of NAME to __wrap_NAME, and of __real_NAME to NAME. */
#pragma GCC diagnostic ignored "-Wpedantic"
#ifdef __clang__
#pragma GCC diagnostic ignored "-Wreserved-identifier"
#endif
void *__real_memory_allocate(memory *heap, size_t byte_count);
void *__wrap_memory_allocate(memory *heap, size_t byte_count);
void *__wrap_memory_allocate(memory *heap, size_t byte_count) {
    return IS_STRUCK(STRIKE_MEMORY, memory) ? NULL : __real_memory_allocate(heap, byte_count);
}

void *__real_memory_allocate_zeroed(memory *heap, size_t count, size_t size);
void *__wrap_memory_allocate_zeroed(memory *heap, size_t count, size_t size);
void *__wrap_memory_allocate_zeroed(memory *heap, size_t count, size_t size) {
    return IS_STRUCK(STRIKE_MEMORY, memory) ? NULL
                                            : __real_memory_allocate_zeroed(heap, count, size);
}

bool __real_array_reserve(memory *heap, void **data, size_t *capacity, size_t count, size_t needed,
                          size_t element_size);
bool __wrap_array_reserve(memory *heap, void **data, size_t *capacity, size_t count, size_t needed,
                          size_t element_size);
bool __wrap_array_reserve(memory *heap, void **data, size_t *capacity, size_t count, size_t needed,
                          size_t element_size) {
    return !IS_STRUCK(STRIKE_MEMORY, memory) &&
           __real_array_reserve(heap, data, capacity, count, needed, element_size);
}

bool __real_array_match(memory *heap, void **data, size_t *capacity, size_t count, size_t wanted,
                        size_t element_size);
bool __wrap_array_match(memory *heap, void **data, size_t *capacity, size_t count, size_t wanted,
                        size_t element_size);
bool __wrap_array_match(memory *heap, void **data, size_t *capacity, size_t count, size_t wanted,
                        size_t element_size) {
    return !IS_STRUCK(STRIKE_MEMORY, memory) &&
           __real_array_match(heap, data, capacity, count, wanted, element_size);
}

void *__real_arena_allocate(arena *scratch, size_t count, size_t size);
void *__wrap_arena_allocate(arena *scratch, size_t count, size_t size);
void *__wrap_arena_allocate(arena *scratch, size_t count, size_t size) {
    return IS_STRUCK(STRIKE_MEMORY, memory) ? NULL : __real_arena_allocate(scratch, count, size);
}

void *__real_arena_allocate_zeroed(arena *scratch, size_t count, size_t size);
void *__wrap_arena_allocate_zeroed(arena *scratch, size_t count, size_t size);
void *__wrap_arena_allocate_zeroed(arena *scratch, size_t count, size_t size) {
    return IS_STRUCK(STRIKE_MEMORY, memory) ? NULL
                                            : __real_arena_allocate_zeroed(scratch, count, size);
}

/* These take memory where there is some, and do without where there is none. */
void __real_arena_reserve(arena *scratch, size_t byte_count);
void __wrap_arena_reserve(arena *scratch, size_t byte_count);
void __wrap_arena_reserve(arena *scratch, size_t byte_count) {
    strike const kind = watched;
    watched = STRIKE_NOTHING;
    __real_arena_reserve(scratch, byte_count);
    watched = kind;
}

void __real_arena_release(arena *scratch, arena_mark mark);
void __wrap_arena_release(arena *scratch, arena_mark mark);
void __wrap_arena_release(arena *scratch, arena_mark mark) {
    strike const kind = watched;
    watched = STRIKE_NOTHING;
    __real_arena_release(scratch, mark);
    watched = kind;
}

/* ---- calls to the system ---- */

#define SYSTEM_FAILS(call) (IS_STRUCK(STRIKE_SYSTEM, call) && (errno = EIO, true))

int __real_open(const char *path, int flags, ...);
int __wrap_open(const char *path, int flags, ...);
int __wrap_open(const char *path, int flags, ...) {
    va_list arguments;
    va_start(arguments, flags);
    mode_t const mode = flags & O_CREAT ? va_arg(arguments, mode_t) : 0;
    va_end(arguments);
    return SYSTEM_FAILS(open) ? -1 : __real_open(path, flags, mode);
}

/* Fails, is interrupted, or transfers one byte. */
#define TRANSFER(call, ...)                                                                        \
    if (SYSTEM_FAILS(call)) return -1;                                                             \
    if (IS_STRUCK(STRIKE_INTERRUPT, call)) {                                                       \
        errno = EINTR;                                                                             \
        return -1;                                                                                 \
    }                                                                                              \
    if (count > 1 && IS_STRUCK(STRIKE_SHORTEN, call)) count = 1;                                   \
    return __real_##call(file, bytes, count __VA_ARGS__)

ssize_t __real_read(int file, void *bytes, size_t count);
ssize_t __wrap_read(int file, void *bytes, size_t count);
ssize_t __wrap_read(int file, void *bytes, size_t count) { TRANSFER(read, ); }

ssize_t __real_write(int file, const void *bytes, size_t count);
ssize_t __wrap_write(int file, const void *bytes, size_t count);
ssize_t __wrap_write(int file, const void *bytes, size_t count) { TRANSFER(write, ); }

ssize_t __real_pread(int file, void *bytes, size_t count, off_t offset);
ssize_t __wrap_pread(int file, void *bytes, size_t count, off_t offset);
ssize_t __wrap_pread(int file, void *bytes, size_t count, off_t offset) {
    TRANSFER(pread, , offset);
}

ssize_t __real_pwrite(int file, const void *bytes, size_t count, off_t offset);
ssize_t __wrap_pwrite(int file, const void *bytes, size_t count, off_t offset);
ssize_t __wrap_pwrite(int file, const void *bytes, size_t count, off_t offset) {
    TRANSFER(pwrite, , offset);
}

#define PLAIN(call, parameters, ...)                                                               \
    int __real_##call parameters;                                                                  \
    int __wrap_##call parameters;                                                                  \
    int __wrap_##call parameters { return SYSTEM_FAILS(call) ? -1 : __real_##call(__VA_ARGS__); }
PLAIN(fstat, (int file, struct stat *facts), file, facts)
PLAIN(fsync, (int file), file)
PLAIN(fdatasync, (int file), file)
PLAIN(syncfs, (int file), file)
PLAIN(ftruncate, (int file, off_t size), file, size)
PLAIN(rename, (const char *from, const char *to), from, to)
PLAIN(mkdir, (const char *path, mode_t mode), path, mode)
PLAIN(flock, (int file, int way), file, way)
PLAIN(unlink, (const char *path), path)

/* A file is closed even where that tells of an error. */
int __real_close(int file);
int __wrap_close(int file);
int __wrap_close(int file) {
    bool const fails = SYSTEM_FAILS(close);
    int const code = __real_close(file);
    if (!fails) return code;
    errno = EIO;
    return -1;
}
