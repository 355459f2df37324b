/* app/cli/whole_file.h - a whole file in memory. */
#ifndef TULLE_APP_CLI_WHOLE_FILE_H
#define TULLE_APP_CLI_WHOLE_FILE_H

#include "tulle/base.h"

/* Reads a regular file of at most 16 GiB. Release the bytes with free. Errors: TULLE_ERROR_IO,
 * TULLE_ERROR_LIMIT, TULLE_ERROR_OUT_OF_MEMORY. */
tulle_status whole_file_read(const char *path, char **bytes, size_t *byte_count,
                             tulle_error *error);

#endif
