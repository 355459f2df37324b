/* app/cli/beside_program.h - directories that come with the program. */
#ifndef TULLE_APP_CLI_BESIDE_PROGRAM_H
#define TULLE_APP_CLI_BESIDE_PROGRAM_H

#include <stdbool.h>
#include <stddef.h>

/* The first of the places, each seen from the directory of the program, that is a directory. False:
 * none is, or its name is longer than `size` bytes allow. */
bool beside_program_find(const char *const *places, size_t place_count, size_t size, char *path);
/* Whether there is a directory of that name. */
bool is_directory(const char *path);

#endif
