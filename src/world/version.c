/* world/version.c - which library this is: its version, the sizes of its public structs. */
#include "base/error.h"
#include "tulle/tulle.h"
#include "world/fields/fields.h"

#include <string.h>

#define TEXT_OF(number) #number
#define VERSION_OF(major, minor, patch) TEXT_OF(major) "." TEXT_OF(minor) "." TEXT_OF(patch)

const char *tulle_version(void) {
    return VERSION_OF(TULLE_VERSION_MAJOR, TULLE_VERSION_MINOR, TULLE_VERSION_PATCH);
}

tulle_status tulle_check_struct(const char *name, size_t size, tulle_error *error) {
    if (!name) return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "the struct has no name");
    for (size_t i = 0; i < struct_size_count; i++) {
        if (strcmp(struct_sizes[i].name, name) != 0) continue;
        if (struct_sizes[i].size == size) return TULLE_OK;
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "%s has %zu bytes in the program and %zu in the library, Tulle %s: build "
                         "the program with the headers of this library",
                         name, size, struct_sizes[i].size, tulle_version());
    }
    return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                     "the library, Tulle %s, has no struct '%.64s'", tulle_version(), name);
}
