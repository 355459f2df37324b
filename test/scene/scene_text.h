/* Scene files made of text, for tests: a fresh folder under the temporary directory. */
#ifndef TULLE_TEST_SCENE_TEXT_H
#define TULLE_TEST_SCENE_TEXT_H

#include "scene/scene.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

/* All presets, as messages list them. */
#define AFTER_COTTON                                                                               \
    "silk, wool, denim, net, rubber-sheet, denim-soft, denim-firm, cotton-broadcloth, canvas, "    \
    "chiffon, wool-tropical, wool-coating, wool-stretch, polyester-plain, polyester-faille, "      \
    "jersey, felt, ripstop-nylon, glass-plain, coated-polyester, etfe-foil, geotextile"
#define PRESET_NAMES "cotton, " AFTER_COTTON

/* The folder, made on the first call; removed by remove_folder. */
static char folder_path[64];
static char written_names[64][40];
static size_t written_count;

static void write_file(const char *name, const void *bytes, size_t byte_count) {
    if (!folder_path[0]) {
        strcpy(folder_path, "/tmp/tulle-scene-XXXXXX");
        assert_non_null(mkdtemp(folder_path));
    }
    char path[128];
    snprintf(path, sizeof path, "%s/%s", folder_path, name);
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, byte_count, file), byte_count);
    assert_int_equal(fclose(file), 0);
    for (size_t i = 0; i < written_count; i++)
        if (strcmp(written_names[i], name) == 0) return;
    assert_true(written_count < 64);
    snprintf(written_names[written_count++], sizeof written_names[0], "%s", name);
}

static void write_text_file(const char *name, const char *text) {
    write_file(name, text, strlen(text));
}

static int remove_folder(void **state) {
    (void)state;
    for (size_t i = 0; i < written_count; i++) {
        char path[128];
        int length = snprintf(path, sizeof path, "%s/%.40s", folder_path, written_names[i]);
        if (length > 0) remove(path);
    }
    if (folder_path[0]) rmdir(folder_path);
    return 0;
}

/* Loads text as s.yaml of the folder; null on failure. */
static tulle_scene *load_text(const char *text, tulle_scene_problems *problems) {
    write_text_file("s.yaml", text);
    char path[128];
    snprintf(path, sizeof path, "%s/s.yaml", folder_path);
    tulle_scene *loaded = NULL;
    tulle_status status = tulle_scene_load(path, NULL, 0, &loaded, problems);
    assert_int_equal(status == TULLE_OK, loaded != NULL);
    assert_int_equal(status == TULLE_OK, problems->total_count == 0);
    return loaded;
}

static tulle_scene *load_good(const char *text) {
    tulle_scene_problems *problems = calloc(1, sizeof *problems);
    assert_non_null(problems);
    tulle_scene *loaded = load_text(text, problems);
    if (!loaded) scene_print_problems(problems, stderr);
    assert_non_null(loaded);
    free(problems);
    return loaded;
}

#endif
