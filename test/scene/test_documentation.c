/* docs/guide/scene.md is what the table of keys prints. With TULLE_UPDATE_DOCS=1 this program
 * writes it.
 */
#define _POSIX_C_SOURCE 200809L
#include "scene/scene.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static char *print_page(size_t *length) {
    char *page = NULL;
    FILE *stream = open_memstream(&page, length);
    assert_non_null(stream);
    scene_print_documentation(stream);
    assert_int_equal(fclose(stream), 0);
    return page;
}

static void test_page_is_current(void **state) {
    (void)state;
    const char *source = getenv("TULLE_SOURCE_DIR");
    char path[1024];
    assert_true(snprintf(path, sizeof path, "%s/docs/guide/scene.md", source ? source : ".") > 0);
    size_t length = 0;
    char *page = print_page(&length);
    assert_true(length > 10000);
    if (getenv("TULLE_UPDATE_DOCS")) {
        FILE *file = fopen(path, "wb");
        assert_non_null(file);
        assert_int_equal(fwrite(page, 1, length, file), length);
        assert_int_equal(fclose(file), 0);
    }
    char *kept = calloc(1, length + 2);
    FILE *file = fopen(path, "rb");
    size_t kept_length = file && kept ? fread(kept, 1, length + 1, file) : 0;
    if (file) fclose(file);
    if (kept_length != length || memcmp(kept, page, length) != 0)
        fail_msg("%s is stale; run this program with TULLE_UPDATE_DOCS=1", path);
    free(kept);
    free(page);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_page_is_current)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
