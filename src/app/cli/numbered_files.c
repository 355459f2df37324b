/* app/cli/numbered_files.c - see numbered_files.h. The user's text never becomes a format of
 * printf. */
#define _POSIX_C_SOURCE 200809L
#include "app/cli/numbered_files.h"

#include "base/error.h"
#include "base/integer.h"

#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *get_last_part(const char *path) {
    const char *const slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

bool name_pattern_is_meant(const char *path) { return strpbrk(get_last_part(path), "%*") != NULL; }

static tulle_status fail_pattern(const char *text, tulle_error *error) {
    return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                     "\"%.200s\": a numbered name holds one %%d or %%0Nd with N from 1 to %d, as "
                     "frame_%%04d.obj, or, for files that are read, one *",
                     text, NUMBERED_DIGITS);
}

tulle_status name_pattern_read(const char *text, name_pattern *pattern, tulle_error *error) {
    const char *const mark = strpbrk(get_last_part(text), "%*");
    if (!mark) return fail_pattern(text, error);
    name_pattern read = {.text = text, .head_length = (size_t)(mark - text), .width = 1};
    const char *at = mark + 1;
    read.is_any = *mark == '*';
    if (!read.is_any && *at == '0') {
        at++;
        if (*at < '1' || *at > '0' + NUMBERED_DIGITS) return fail_pattern(text, error);
        read.width = *at++ - '0';
    }
    if (!read.is_any && *at++ != 'd') return fail_pattern(text, error);
    if (strpbrk(at, "%*")) return fail_pattern(text, error);
    read.tail = at;
    *pattern = read;
    return TULLE_OK;
}

bool name_pattern_format(const name_pattern *pattern, uint32_t number,
                         char path[NUMBERED_PATH_SIZE]) {
    int const length =
        snprintf(path, NUMBERED_PATH_SIZE, "%.*s%0*lu%s", (int)pattern->head_length, pattern->text,
                 pattern->width, (unsigned long)number, pattern->tail);
    return length > 0 && length < NUMBERED_PATH_SIZE;
}

/* ---- files that are there ---- */

/* Whether the name is one of the pattern's, and its number. `head` is the name's part before it. */
static bool match_name(const name_pattern *pattern, const char *head, size_t head_length,
                       const char *name, uint32_t *number) {
    if (strncmp(name, head, head_length) != 0) return false;
    const char *const digits = name + head_length;
    size_t const count = strspn(digits, "0123456789");
    if (count < 1 || count > NUMBERED_DIGITS || strcmp(digits + count, pattern->tail) != 0)
        return false;
    *number = (uint32_t)strtoul(digits, NULL, 10);
    if (pattern->is_any) return true;
    return count == (size_t)pattern->width || (count > (size_t)pattern->width && digits[0] != '0');
}

static tulle_status fail_memory(tulle_error *error) {
    return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "out of memory for the names of the files");
}

static tulle_status add_file(numbered_files *found, size_t *capacity, uint32_t number,
                             const char *name, tulle_error *error) {
    if (found->count == *capacity) {
        size_t const grown = *capacity ? 2 * *capacity : 64;
        numbered_file *const files = realloc(found->files, grown * sizeof *files);
        if (!files) return fail_memory(error);
        found->files = files;
        *capacity = grown;
    }
    size_t const size = strlen(name) + 1;
    char *const copy = malloc(size);
    if (!copy) return fail_memory(error);
    memcpy(copy, name, size);
    found->files[found->count++] = (numbered_file){.number = number, .name = copy};
    return TULLE_OK;
}

static tulle_status list_files(const name_pattern *pattern, numbered_files *found,
                               tulle_error *error) {
    const char *const head = get_last_part(pattern->text);
    size_t const folder_length = (size_t)(head - pattern->text);
    size_t const head_length = pattern->head_length - folder_length;
    if (folder_length >= sizeof found->folder)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "the path is too long");
    memcpy(found->folder, pattern->text, folder_length);
    found->folder[folder_length] = '\0';
    DIR *const folder = opendir(folder_length > 0 ? found->folder : ".");
    if (!folder)
        return error_set_at(error, TULLE_ERROR_IO, pattern->text, 0, 0,
                            "its folder cannot be read: %s", strerror(errno));
    tulle_status status = TULLE_OK;
    size_t capacity = 0;
    const struct dirent *entry;
    while (status == TULLE_OK && (entry = readdir(folder))) {
        uint32_t number;
        if (match_name(pattern, head, head_length, entry->d_name, &number))
            status = add_file(found, &capacity, number, entry->d_name, error);
    }
    closedir(folder);
    return status;
}

static int compare_files(const void *a, const void *b) {
    const numbered_file *const left = a, *const right = b;
    if (left->number != right->number) return left->number < right->number ? -1 : 1;
    return strcmp(left->name, right->name);
}

/* The range and its first gap. */
static void describe_numbers(numbered_files *found) {
    const numbered_file *const files = found->files;
    uint32_t step = 0;
    for (size_t i = 1; i < found->count; i++)
        step = integer_compute_common_factor(files[i].number - files[i - 1].number, step);
    if (step == 0) step = 1;
    found->range = (frame_range){files[0].number, files[found->count - 1].number, step};
    for (size_t i = 1; i < found->count && !found->has_gaps; i++) {
        found->has_gaps = files[i].number - files[i - 1].number != step;
        found->gap = files[i - 1].number + step;
    }
}

tulle_status numbered_files_find(const name_pattern *pattern, numbered_files *found,
                                 tulle_error *error) {
    *found = (numbered_files){0};
    tulle_status status = list_files(pattern, found, error);
    if (status == TULLE_OK && found->count == 0)
        status = error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, pattern->text, 0, 0,
                              "there is no file with such a name and a number");
    if (status == TULLE_OK) {
        qsort(found->files, found->count, sizeof *found->files, compare_files);
        for (size_t i = 1; i < found->count && status == TULLE_OK; i++)
            if (found->files[i].number == found->files[i - 1].number)
                status = error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, pattern->text, 0, 0,
                                      "%s and %s have the same number; give the digits, as %%04d",
                                      found->files[i - 1].name, found->files[i].name);
    }
    if (status == TULLE_OK)
        describe_numbers(found);
    else
        numbered_files_destroy(found);
    return status;
}

void numbered_files_destroy(numbered_files *found) {
    for (size_t i = 0; i < found->count; i++) free(found->files[i].name);
    free(found->files);
    found->files = NULL;
    found->count = 0;
}

bool numbered_files_get_path(const numbered_files *found, uint32_t number,
                             char path[NUMBERED_PATH_SIZE]) {
    size_t low = 0, high = found->count;
    while (low < high) {
        size_t const middle = low + (high - low) / 2;
        if (found->files[middle].number < number)
            low = middle + 1;
        else
            high = middle;
    }
    if (low == found->count || found->files[low].number != number) return false;
    int const length =
        snprintf(path, NUMBERED_PATH_SIZE, "%s%s", found->folder, found->files[low].name);
    return length > 0 && length < NUMBERED_PATH_SIZE;
}
