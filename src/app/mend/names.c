/* app/mend/names.c - see names.h. */
#define _XOPEN_SOURCE 700
#include "app/mend/names.h"

#include "app/convert/target.h"
#include "base/error.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

enum { FIRST_CAPACITY = 64 /* names */ };

static const char *get_last_part(const char *path) {
    const char *const slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

static tulle_status append(mend_names *names, mend_name name, tulle_error *error) {
    if (names->count == names->capacity) {
        size_t const capacity = names->capacity > 0 ? 2 * names->capacity : FIRST_CAPACITY;
        mend_name *const items = realloc(names->items, capacity * sizeof *items);
        if (!items) return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "out of memory for names");
        names->items = items;
        names->capacity = capacity;
    }
    name.path = strdup(name.path);
    if (!name.path) return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "out of memory for names");
    names->items[names->count++] = name;
    return TULLE_OK;
}

static tulle_status add_one(mend_names *names, const mend_input *input, mend_name name,
                            tulle_error *error) {
    char folder[NUMBERED_PATH_SIZE];
    struct stat facts;
    tulle_status const status = convert_target_check_place(name.path, error);
    if (status != TULLE_OK) return status;
    int const length = (int)(get_last_part(name.path) - name.path);
    if (mend_input_reads(input, name.path))
        return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, name.path, 0, 0,
                            "is one of the files that are read, and would be %s; give another name",
                            name.role);
    if (snprintf(folder, sizeof folder, "%.*s.", length, name.path) >= NUMBERED_PATH_SIZE ||
        stat(folder, &facts) != 0)
        return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, name.path, 0, 0,
                            "its folder cannot be found");
    name.device = facts.st_dev;
    name.folder = facts.st_ino;
    return append(names, name, error);
}

tulle_status mend_names_add(mend_names *names, const mend_input *input, const char *path,
                            const char *role, tulle_error *error) {
    char bin[NUMBERED_PATH_SIZE];
    mend_name name = {.path = (char *)path, .role = role};
    tulle_status const status = add_one(names, input, name, error);
    if (status != TULLE_OK || convert_get_format(path) != CONVERT_GLTF) return status;
    snprintf(bin, sizeof bin, "%.*sbin", (int)(strlen(path) - strlen("gltf")), path);
    name.path = bin;
    return add_one(names, input, name, error);
}

tulle_status mend_names_add_frames(mend_names *names, const mend_input *input, const char *path,
                                   const name_pattern *pattern, const char *role,
                                   tulle_error *error) {
    if (!pattern) return mend_names_add(names, input, path, role, error);
    tulle_status status = TULLE_OK;
    for (uint32_t i = 0; i < input->frame_count && status == TULLE_OK; i++) {
        char file[NUMBERED_PATH_SIZE];
        if (!name_pattern_format(pattern, mend_input_get_number(input, i), file))
            return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, path, 0, 0,
                                "the path is too long");
        status = mend_names_add(names, input, file, role, error);
    }
    return status;
}

static int compare_files(const void *a, const void *b) {
    const mend_name *const left = a, *const right = b;
    if (left->device != right->device) return left->device < right->device ? -1 : 1;
    if (left->folder != right->folder) return left->folder < right->folder ? -1 : 1;
    return strcmp(get_last_part(left->path), get_last_part(right->path));
}

tulle_status mend_names_check(mend_names *names, tulle_error *error) {
    if (names->count > 0) qsort(names->items, names->count, sizeof *names->items, compare_files);
    for (size_t i = 1; i < names->count; i++) {
        const mend_name *const name = &names->items[i];
        if (compare_files(name - 1, name) == 0)
            return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, name->path, 0, 0,
                                "would be written twice, as %s and as %s; their names should "
                                "differ",
                                name[-1].role, name->role);
    }
    return TULLE_OK;
}

void mend_names_close(mend_names *names) {
    for (size_t i = 0; i < names->count; i++) free(names->items[i].path);
    free(names->items);
    *names = (mend_names){0};
}
