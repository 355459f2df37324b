/* Calls that flush and rename, for one test program: they count, fail at a chosen call, and note
 * which files were renamed without having been flushed. Include in one file of the program only,
 * with _GNU_SOURCE. */
#ifndef TULLE_TEST_WATCHED_FLUSHES_H
#define TULLE_TEST_WATCHED_FLUSHES_H

#include <errno.h>
#include <fcntl.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#ifdef __linux__
#define HAS_WATCHED_FLUSHES 1
enum { FLUSHED_MAX = 64 };
static long flush_calls,
    flush_fail = -1;               /* flushes and renames so far; the one that fails, or -1 */
static ino_t flushed[FLUSHED_MAX]; /* files flushed under the names they had, a ring */
static size_t flushed_count;
static int unflushed_renames;   /* since the file system was flushed */
static int early_checkpoints;   /* that were named before all that was renamed was flushed */
static int checkpoints_renamed; /* in all */

static bool flush_fails(void) {
    if (flush_calls++ != flush_fail) return false;
    errno = EIO;
    return true;
}

static int flush_one(int file, long call) {
    struct stat facts;
    if (flush_fails()) return -1;
    if (fstat(file, &facts) == 0) flushed[flushed_count++ % FLUSHED_MAX] = facts.st_ino;
    return (int)syscall(call, file);
}

int fsync(int file) { return flush_one(file, SYS_fsync); }
int fdatasync(int file) { return flush_one(file, SYS_fdatasync); }

int syncfs(int file) {
    if (flush_fails()) return -1;
    unflushed_renames = 0;
    return (int)syscall(SYS_syncfs, file);
}

int rename(const char *from, const char *to) {
    struct stat facts;
    if (flush_fails()) return -1;
    bool is_flushed = stat(from, &facts) != 0; /* nothing is renamed then */
    for (size_t i = 0; i < FLUSHED_MAX && !is_flushed; i++)
        is_flushed = i < flushed_count && flushed[i] == facts.st_ino;
    unflushed_renames += !is_flushed;
    if (strstr(to, "/checkpoint.bin")) {
        checkpoints_renamed++;
        early_checkpoints += unflushed_renames > 0;
    }
    return renameat(AT_FDCWD, from, AT_FDCWD, to);
}
#else
#define HAS_WATCHED_FLUSHES 0
static long flush_calls, flush_fail = -1;
static int early_checkpoints, checkpoints_renamed;
#endif

#endif
