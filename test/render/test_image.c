/* Pictures as files and radiance as bytes: round trips, files that are no pictures, places that
 * cannot be written, short memory; the exposure curve. */
#define _GNU_SOURCE /* mkdtemp */
#include "render/render_fixture.h"

#include "io/failing_heap.h"
#include "render/image.h"

#include <dirent.h>
#include <sys/stat.h>
#include <unistd.h>

static char folder[] = "/tmp/tulle_image_XXXXXX";

static const char *in_folder(const char *name) {
    static char path[256];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    return path;
}

static size_t count_files(void) {
    DIR *const dir = opendir(folder);
    size_t count = 0;
    for (struct dirent *entry; (entry = readdir(dir));) count += entry->d_name[0] != '.';
    closedir(dir);
    return count;
}

static int make_folder(void **state) {
    (void)state;
    return mkdtemp(folder) ? 0 : -1;
}

static int remove_folder(void **state) {
    (void)state;
    unlink(in_folder("a.png"));
    unlink(in_folder("b.png"));
    return rmdir(folder);
}

static render_image make_picture(uint32_t width, uint32_t height) {
    render_image image;
    assert_int_equal(render_image_create(width, height, &image, NULL), TULLE_OK);
    for (size_t i = 0; i < 3 * (size_t)width * height; i++)
        image.pixels[i] = (uint8_t)(i * i / 7 + i % 5 * 31);
    return image;
}

static size_t read_bytes(const char *path, uint8_t *bytes, size_t limit) {
    FILE *const file = fopen(path, "rb");
    assert_non_null(file);
    size_t const count = fread(bytes, 1, limit, file);
    fclose(file);
    return count;
}

static void pictures_come_back(void **state) {
    (void)state;
    uint32_t const sizes[4][2] = {{1, 1}, {7, 3}, {640, 1}, {33, 129}};
    for (int i = 0; i < 4; i++) {
        render_image image = make_picture(sizes[i][0], sizes[i][1]), back;
        render_note const notes[2] = {{"Title", "a cloth"}, {"Run", "needles \xe9"}};
        assert_int_equal(render_image_write_png(in_folder("a.png"), &image, notes, 2, NULL),
                         TULLE_OK);
        char note[32];
        assert_int_equal(
            render_image_read_png(in_folder("a.png"), &back, "Run", note, sizeof note, NULL),
            TULLE_OK);
        assert_string_equal(note, "needles \xe9");
        assert_int_equal(back.width, image.width);
        assert_int_equal(back.height, image.height);
        assert_memory_equal(back.pixels, image.pixels, 3 * (size_t)image.width * image.height);
        render_image_destroy(&back);
        assert_int_equal(
            render_image_read_png(in_folder("a.png"), &back, "None", note, sizeof note, NULL),
            TULLE_OK);
        assert_string_equal(note, "");
        render_image_destroy(&back);
        render_image_destroy(&image);
    }
}

static void the_same_picture_gives_the_same_bytes(void **state) {
    (void)state;
    static uint8_t a[1 << 16], b[1 << 16];
    render_image image = make_picture(40, 30);
    render_note const note = {"Run", "x"};
    assert_int_equal(render_image_write_png(in_folder("a.png"), &image, &note, 1, NULL), TULLE_OK);
    assert_int_equal(render_image_write_png(in_folder("b.png"), &image, &note, 1, NULL), TULLE_OK);
    size_t const count = read_bytes(in_folder("a.png"), a, sizeof a);
    assert_int_equal(count, read_bytes(in_folder("b.png"), b, sizeof b));
    assert_true(count > 100);
    assert_memory_equal(a, b, count);
    render_image_destroy(&image);
}

/* Every file cut short is refused, and every file with a byte changed is refused or read as a
 * picture of some kind; nothing crashes. */
static void damaged_files_are_refused(void **state) {
    (void)state;
    static uint8_t bytes[1 << 14];
    render_image image = make_picture(9, 7), back;
    assert_int_equal(render_image_write_png(in_folder("a.png"), &image, NULL, 0, NULL), TULLE_OK);
    render_image_destroy(&image);
    size_t const count = read_bytes(in_folder("a.png"), bytes, sizeof bytes);
    tulle_error error;
    for (size_t cut = 0; cut < 2 * count; cut++) {
        FILE *const file = fopen(in_folder("b.png"), "wb");
        assert_non_null(file);
        if (cut >= count) bytes[cut - count] ^= 0x24;
        fwrite(bytes, 1, cut < count ? cut : count, file);
        fclose(file);
        if (cut >= count) bytes[cut - count] ^= 0x24;
        tulle_status const status =
            render_image_read_png(in_folder("b.png"), &back, NULL, NULL, 0, &error);
        if (cut < count) assert_int_equal(status, TULLE_ERROR_PARSE);
        if (status != TULLE_OK) assert_true(!back.pixels && strlen(error.message) > 10);
        render_image_destroy(&back);
    }
    assert_int_equal(render_image_read_png(in_folder("missing.png"), &back, NULL, NULL, 0, &error),
                     TULLE_ERROR_IO);
    assert_non_null(strstr(error.file, "missing.png"));
    assert_int_equal(mkfifo(in_folder("pipe.png"), 0666), 0); /* nobody writes to it */
    assert_int_equal(render_image_read_png(in_folder("pipe.png"), &back, NULL, NULL, 0, &error),
                     TULLE_ERROR_IO);
    assert_non_null(strstr(error.message, "is not a regular file"));
    unlink(in_folder("pipe.png"));
}

static void unwritable_places_are_said_and_left_alone(void **state) {
    (void)state;
    render_image image = make_picture(5, 5);
    tulle_error error;
    size_t const before = count_files();
    char path[300];
    snprintf(path, sizeof path, "%s/no/such/folder/a.png", folder);
    assert_int_equal(render_image_write_png(path, &image, NULL, 0, &error), TULLE_ERROR_IO);
    assert_non_null(strstr(error.file, "no/such"));
    assert_int_not_equal(render_image_write_png(folder, &image, NULL, 0, &error), TULLE_OK);
    render_note const long_key = {"A key that is far too long for the format, which has room for "
                                  "seventy-nine characters only",
                                  "x"};
    assert_int_equal(render_image_write_png(in_folder("c.png"), &image, &long_key, 1, &error),
                     TULLE_ERROR_INVALID_ARGUMENT);
    render_image_destroy(&image);
    assert_int_equal(render_image_write_png(in_folder("c.png"), &image, NULL, 0, &error),
                     TULLE_ERROR_INVALID_ARGUMENT);
    assert_int_equal(count_files(), before);
}

static void sizes_have_limits(void **state) {
    (void)state;
    render_image image;
    assert_int_equal(render_image_create(0, 5, &image, NULL), TULLE_ERROR_LIMIT);
    assert_int_equal(render_image_create(5, 0, &image, NULL), TULLE_ERROR_LIMIT);
    assert_int_equal(render_image_create(RENDER_IMAGE_SIDE_MAX + 1, 1, &image, NULL),
                     TULLE_ERROR_LIMIT);
    assert_null(image.pixels);
}

/* Each call of the heap fails once: out of memory is said, nothing is left behind. */
static void short_memory_leaves_nothing(void **state) {
    (void)state;
    if (!HAS_OWN_HEAP) skip();
    unlink(in_folder("a.png"));
    unlink(in_folder("b.png"));
    size_t const before = count_files();
    render_image image = make_picture(60, 50), back;
    render_note const note = {"Run", "x"};
    bool is_done = false;
    for (long call = 0; !is_done; call++) {
        assert_true(call < 1000);
        watch_heap(call);
        tulle_status const status =
            render_image_write_png(in_folder("a.png"), &image, &note, 1, NULL);
        is_done = !unwatch_heap();
        /* libpng does without some of its memory */
        if (status != TULLE_OK) {
            assert_int_equal(status, TULLE_ERROR_OUT_OF_MEMORY);
            assert_int_equal(count_files(), before);
        }
        unlink(in_folder("a.png"));
    }
    assert_int_equal(render_image_write_png(in_folder("a.png"), &image, &note, 1, NULL), TULLE_OK);
    is_done = false;
    for (long call = 0; !is_done; call++) {
        assert_true(call < 1000);
        watch_heap(call);
        tulle_status const status =
            render_image_read_png(in_folder("a.png"), &back, NULL, NULL, 0, NULL);
        is_done = !unwatch_heap();
        assert_true(status == TULLE_OK || !back.pixels);
        render_image_destroy(&back);
    }
    render_image_destroy(&image);
}

/* Rises everywhere, never reaches white, and is sRGB's own curve up to the knee. */
static void exposure_never_clips(void **state) {
    (void)state;
    enum { COUNT = 4000 };
    static float radiance[3 * COUNT];
    for (int i = 0; i < 3 * COUNT; i++) radiance[i] = 6.0f * (float)i / (3 * COUNT);
    render_image image;
    assert_int_equal(render_image_create(COUNT, 1, &image, NULL), TULLE_OK);
    render_expose(radiance, 1.0, &image);
    for (int i = 1; i < 3 * COUNT; i++) {
        assert_true(image.pixels[i] >= image.pixels[i - 1]);
        double const linear = (double)radiance[i];
        double const encoded =
            linear <= 0.0031308 ? 12.92 * linear : 1.055 * pow(linear, 1.0 / 2.4) - 0.055;
        if (linear <= 0.6) assert_true(fabs(image.pixels[i] - 255.0 * encoded) <= 0.5 + 1e-9);
    }
    assert_int_equal(image.pixels[0], 0);
    assert_true(image.pixels[3 * COUNT - 1] >= 250);
    float const wild[6] = {INFINITY, 1e30f, NAN, -1.0f, -INFINITY, 1e-30f};
    uint8_t const bytes[6] = {254, 254, 0, 0, 0, 0};
    memcpy(radiance, wild, sizeof wild);
    image.width = 2;
    render_expose(radiance, 1.0, &image);
    assert_memory_equal(image.pixels, bytes, 6);
    image.width = COUNT;
    render_image_destroy(&image);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pictures_come_back),
        cmocka_unit_test(the_same_picture_gives_the_same_bytes),
        cmocka_unit_test(damaged_files_are_refused),
        cmocka_unit_test(unwritable_places_are_said_and_left_alone),
        cmocka_unit_test(sizes_have_limits),
        cmocka_unit_test(short_memory_leaves_nothing),
        cmocka_unit_test(exposure_never_clips),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
