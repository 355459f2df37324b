/* app/cli/beside_program.c - see beside_program.h. */
#define _POSIX_C_SOURCE 200809L
#include "app/cli/beside_program.h"

#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { PROGRAM_PATH_SIZE = 4096 };

bool is_directory(const char *path) {
    struct stat facts;
    return stat(path, &facts) == 0 && S_ISDIR(facts.st_mode);
}

bool beside_program_find(const char *const *places, size_t place_count, size_t size, char *path) {
    char program[PROGRAM_PATH_SIZE];
    ssize_t const length = readlink("/proc/self/exe", program, sizeof program - 1);
    if (length <= 0) return false;
    program[length] = '\0';
    char *const slash = strrchr(program, '/');
    if (slash) *slash = '\0';
    for (size_t i = 0; i < place_count; i++) {
        int const used = snprintf(path, size, "%s/%s", program, places[i]);
        if (used > 0 && (size_t)used < size && is_directory(path)) return true;
    }
    return false;
}
