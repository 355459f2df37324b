/* What the tests of io/ share: a folder of their own, whole files in memory. */
#ifndef TULLE_TEST_IO_SUPPORT_H
#define TULLE_TEST_IO_SUPPORT_H

#include <dirent.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

static char test_folder[256];

/* A path in the folder of this test program; the text stays. */
static inline const char *test_path(const char *name) {
    static char paths[256][512];
    static size_t count;
    char wanted[512];
    snprintf(wanted, sizeof wanted, "%s/%s", test_folder, name);
    for (size_t i = 0; i < count; i++)
        if (strcmp(paths[i], wanted) == 0) return paths[i];
    assert_true(count < 256);
    memcpy(paths[count], wanted, sizeof wanted);
    return paths[count++];
}

static inline int make_test_folder(void **state) {
    (void)state;
    /* Thousands of small files: in memory where that is possible. */
    const char *const base = access("/dev/shm", W_OK) == 0 ? "/dev/shm" : "/tmp";
    snprintf(test_folder, sizeof test_folder, "%s/tulle-io-XXXXXX", base);
    return mkdtemp(test_folder) ? 0 : -1;
}

static inline void remove_tree(const char *path) {
    DIR *const folder = opendir(path);
    if (folder) {
        for (struct dirent *entry = readdir(folder); entry; entry = readdir(folder)) {
            if (strcmp(entry->d_name, ".") == 0 || strcmp(entry->d_name, "..") == 0) continue;
            size_t const size = strlen(path) + strlen(entry->d_name) + 2;
            char *const inner = malloc(size);
            assert_non_null(inner);
            snprintf(inner, size, "%s/%s", path, entry->d_name);
            remove_tree(inner);
            free(inner);
        }
        closedir(folder);
    }
    remove(path);
}

static inline int remove_test_folder(void **state) {
    (void)state;
    remove_tree(test_folder);
    return 0;
}

static inline size_t count_files(const char *path) {
    size_t count = 0;
    DIR *const folder = opendir(path);
    assert_non_null(folder);
    for (struct dirent *entry = readdir(folder); entry; entry = readdir(folder))
        count += strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0;
    closedir(folder);
    return count;
}

static inline void put_file(const char *path, const void *bytes, size_t byte_count) {
    FILE *const file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, byte_count, file), byte_count);
    assert_int_equal(fclose(file), 0);
}

static inline void put_text(const char *path, const char *text) {
    put_file(path, text, strlen(text));
}

/* The whole file with a zero behind; free() it. */
static inline char *get_file(const char *path, size_t *byte_count) {
    FILE *const file = fopen(path, "rb");
    assert_non_null(file);
    assert_int_equal(fseek(file, 0, SEEK_END), 0);
    long const size = ftell(file);
    rewind(file);
    char *const bytes = malloc((size_t)size + 1);
    assert_non_null(bytes);
    assert_int_equal(fread(bytes, 1, (size_t)size, file), size);
    bytes[size] = '\0';
    fclose(file);
    *byte_count = (size_t)size;
    return bytes;
}

#endif
