/* app/mend/names.h - the files that are to be written: each is written once, and none is read. */
#ifndef TULLE_APP_MEND_NAMES_H
#define TULLE_APP_MEND_NAMES_H

#include "app/mend/input.h"

#include <sys/types.h>

typedef struct mend_name {
    dev_t device; /* of its folder */
    ino_t folder;
    char *path;
    const char *role; /* what it is, for messages: "OUT" */
} mend_name;

/* Set to zero before; release with mend_names_close. */
typedef struct mend_names {
    mend_name *items;
    size_t count, capacity;
} mend_names;

/* Takes a file's path; of a .gltf that of its .bin, too. Errors: TULLE_ERROR_INVALID_ARGUMENT where
 * no file may be made there, or where it is read; TULLE_ERROR_OUT_OF_MEMORY. */
tulle_status mend_names_add(mend_names *names, const mend_input *input, const char *path,
                            const char *role, tulle_error *error);
/* The same of numbered files, one for each frame of the cloth; without a pattern, null, of one. */
tulle_status mend_names_add_frames(mend_names *names, const mend_input *input, const char *path,
                                   const name_pattern *pattern, const char *role,
                                   tulle_error *error);
/* Errors: TULLE_ERROR_INVALID_ARGUMENT where two are one file. */
tulle_status mend_names_check(mend_names *names, tulle_error *error);
void mend_names_close(mend_names *names);

#endif
