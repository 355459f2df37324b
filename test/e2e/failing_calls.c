/* test/e2e/failing_calls.c - a library to preload: one call of the program to the system fails, or
 * all that change files are written down.
 *
 * TULLE_FAIL=CALL:NUMBER:WAY[:ERROR] names the call, which one of them (from 1), and how: `once`,
 * `ever` (this one and all after it) with that errno, or `short`: it reads or writes half of its
 * bytes. TULLE_FAIL_COUNTS=FILE: at the end each call's name and how often it was made is appended.
 * TULLE_CALLS_LOG=FILE: a line is appended for each call that has changed or flushed something,
 * with blanks between its words: the call, the file's inode or the paths, numbers, written bytes as
 * hexadecimal digits. Only calls that the program itself makes count, not those of other libraries.
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <link.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define FILE_CALLS(ENTRY)                                                                          \
    ENTRY(open), ENTRY(read), ENTRY(pread), ENTRY(write), ENTRY(pwrite), ENTRY(fsync),             \
        ENTRY(fdatasync), ENTRY(syncfs), ENTRY(ftruncate)
#define OTHER_CALLS(ENTRY)                                                                         \
    ENTRY(rename), ENTRY(mkdir), ENTRY(flock), ENTRY(unlink), ENTRY(unlinkat), ENTRY(rmdir),       \
        ENTRY(malloc), ENTRY(calloc), ENTRY(realloc)
#define NUMBER_OF(call) CALL_##call
#define TEXT_OF(call) #call
enum { FILE_CALLS(NUMBER_OF), OTHER_CALLS(NUMBER_OF), CALL_COUNT };
static const char *const call_names[] = {FILE_CALLS(TEXT_OF), OTHER_CALLS(TEXT_OF)};

static atomic_uint_fast64_t counts[CALL_COUNT];
static uintptr_t program_begin, program_end; /* its code; both 0 before the start */
static int failing_call = -1;
static uint64_t failing_number;
static int failing_errno;
static enum { FAILS_ONCE, FAILS_EVER, CALL_IS_SHORT } failing_way;
static int log_file = -1;

extern void *__libc_malloc(size_t);
extern void *__libc_calloc(size_t, size_t);
extern void *__libc_realloc(void *, size_t);

static int note_program(struct dl_phdr_info *info, size_t size, void *context) {
    (void)size, (void)context;
    for (int i = 0; i < info->dlpi_phnum; i++) {
        const ElfW(Phdr) *const part = &info->dlpi_phdr[i];
        if (part->p_type != PT_LOAD || !(part->p_flags & PF_X)) continue;
        program_begin = info->dlpi_addr + part->p_vaddr;
        program_end = program_begin + part->p_memsz;
    }
    return 1; /* the program is the first; the rest does not matter */
}

__attribute__((constructor)) static void begin(void) {
    char text[128], *rest = text;
    const char *const wish = getenv("TULLE_FAIL");
    if (wish && strlen(wish) < sizeof text) {
        strcpy(text, wish);
        const char *const name = strsep(&rest, ":"), *const number = strsep(&rest, ":");
        const char *const way = strsep(&rest, ":"), *const code = strsep(&rest, ":");
        for (int i = 0; i < CALL_COUNT; i++)
            if (strcmp(name, call_names[i]) == 0) failing_call = i;
        if (failing_call < 0 || !number || !way) {
            fprintf(stderr, "TULLE_FAIL is wrong: %s\n", wish);
            _exit(99);
        }
        failing_number = strtoull(number, NULL, 10);
        failing_way = strcmp(way, "ever") == 0    ? FAILS_EVER
                      : strcmp(way, "short") == 0 ? CALL_IS_SHORT
                                                  : FAILS_ONCE;
        failing_errno = code ? atoi(code) : EIO;
    }
    const char *const log = getenv("TULLE_CALLS_LOG");
    if (log) log_file = open(log, O_WRONLY | O_APPEND | O_CREAT | O_CLOEXEC, 0666);
    dl_iterate_phdr(note_program, NULL);
}

__attribute__((destructor)) static void end(void) {
    const char *const path = getenv("TULLE_FAIL_COUNTS");
    if (!path) return;
    program_begin = program_end = 0;
    FILE *const file = fopen(path, "a");
    if (!file) return;
    for (int i = 0; i < CALL_COUNT; i++)
        fprintf(file, "%s %llu\n", call_names[i], (unsigned long long)atomic_load(&counts[i]));
    fclose(file);
}

static bool is_of_program(const void *caller) {
    return (uintptr_t)caller >= program_begin && (uintptr_t)caller < program_end;
}

/* Counts a call. True: it shall fail, or be short; errno is set. */
static bool is_struck(int call, const void *caller) {
    if (!is_of_program(caller)) return false;
    uint64_t const number = atomic_fetch_add(&counts[call], 1) + 1;
    if (call != failing_call || number < failing_number) return false;
    if (number > failing_number && failing_way != FAILS_EVER) return false;
    errno = failing_errno;
    return true;
}
#define CALLER __builtin_return_address(0)
#define STRUCK(call) is_struck(CALL_##call, CALLER)
#define REAL(call)                                                                                 \
    static __typeof__(&call) real;                                                                 \
    if (!real) real = (__typeof__(&call))dlsym(RTLD_NEXT, #call)

/* ---- the log ---- */

static unsigned long long get_inode(int file) {
    struct stat facts;
    return fstat(file, &facts) == 0 ? (unsigned long long)facts.st_ino : 0;
}

__attribute__((format(printf, 2, 3))) static void log_call(const void *caller, const char *format,
                                                           ...) {
    if (log_file < 0 || !is_of_program(caller)) return;
    int const code = errno;
    va_list arguments;
    va_start(arguments, format);
    vdprintf(log_file, format, arguments);
    va_end(arguments);
    errno = code;
}

/* Of a write to a regular file. */
static void log_bytes(const void *caller, int file, off_t offset, const void *bytes,
                      ssize_t count) {
    if (log_file < 0 || count < 0 || offset < 0 || !is_of_program(caller)) return;
    char *const digits = __libc_malloc(2 * (size_t)count + 1);
    if (!digits) _exit(99);
    for (ssize_t i = 0; i < count; i++)
        snprintf(digits + 2 * i, 3, "%02x", ((const unsigned char *)bytes)[i]);
    dprintf(log_file, "write %llu %lld %.*s\n", get_inode(file), (long long)offset,
            (int)(2 * count), digits);
    free(digits);
}

/* Of a name within a folder that is open. */
static void log_removal(const void *caller, int folder, const char *name) {
    char link[64], path[PATH_MAX];
    snprintf(link, sizeof link, "/proc/self/fd/%d", folder);
    ssize_t const length = readlink(link, path, sizeof path);
    if (length > 0) log_call(caller, "unlink %.*s/%s\n", (int)length, path, name);
}

/* ---- the calls ---- */

int open(const char *path, int flags, ...) {
    va_list arguments;
    va_start(arguments, flags);
    mode_t const mode = flags & O_CREAT ? va_arg(arguments, mode_t) : 0;
    va_end(arguments);
    REAL(open);
    if (STRUCK(open)) return -1;
    int const file = real(path, flags, mode);
    if (file >= 0)
        log_call(CALLER, "open %llu %s%s%s\n", get_inode(file), flags & O_CREAT ? "c" : "-",
                 flags & O_TRUNC ? "t " : "- ", path);
    return file;
}

#define TRANSFER(call, ...)                                                                        \
    REAL(call);                                                                                    \
    if (STRUCK(call)) {                                                                            \
        if (failing_way != CALL_IS_SHORT) return -1;                                               \
        count = count > 1 ? count / 2 : count;                                                     \
    }                                                                                              \
    ssize_t const done = real(file, bytes, count __VA_ARGS__)

ssize_t read(int file, void *bytes, size_t count) {
    TRANSFER(read, );
    return done;
}
ssize_t pread(int file, void *bytes, size_t count, off_t offset) {
    TRANSFER(pread, , offset);
    return done;
}
ssize_t write(int file, const void *bytes, size_t count) {
    off_t const offset = log_file < 0 ? 0 : lseek(file, 0, SEEK_CUR);
    TRANSFER(write, );
    log_bytes(CALLER, file, offset, bytes, done);
    return done;
}
ssize_t pwrite(int file, const void *bytes, size_t count, off_t offset) {
    TRANSFER(pwrite, , offset);
    log_bytes(CALLER, file, offset, bytes, done);
    return done;
}

/* What is logged of a call that succeeded comes last. */
#define PLAIN(call, parameters, arguments, ...)                                                    \
    int call parameters {                                                                          \
        REAL(call);                                                                                \
        if (STRUCK(call)) return -1;                                                               \
        int const result = real arguments;                                                         \
        if (result == 0) log_call(CALLER, #call __VA_ARGS__);                                      \
        return result;                                                                             \
    }
PLAIN(fsync, (int file), (file), " %llu\n", get_inode(file))
PLAIN(fdatasync, (int file), (file), " %llu\n", get_inode(file))
PLAIN(syncfs, (int file), (file), "\n")
PLAIN(ftruncate, (int file, off_t size), (file, size), " %llu %lld\n", get_inode(file),
      (long long)size)
PLAIN(rename, (const char *from, const char *to), (from, to), " %s %s\n", from, to)
PLAIN(mkdir, (const char *path, mode_t mode), (path, mode), " %s\n", path)
PLAIN(flock, (int file, int way), (file, way), "\n")
PLAIN(unlink, (const char *path), (path), " %s\n", path)
PLAIN(rmdir, (const char *path), (path), " %s\n", path)

int unlinkat(int folder, const char *name, int flags) {
    REAL(unlinkat);
    if (STRUCK(unlinkat)) return -1;
    int const result = real(folder, name, flags);
    if (result == 0) log_removal(CALLER, folder, name);
    return result;
}

/* dlsym may call the heap, so these ask the C library by its inner names. */
void *malloc(size_t size) { return STRUCK(malloc) ? NULL : __libc_malloc(size); }
void *calloc(size_t count, size_t size) {
    return STRUCK(calloc) ? NULL : __libc_calloc(count, size);
}
void *realloc(void *block, size_t size) {
    return STRUCK(realloc) ? NULL : __libc_realloc(block, size);
}
