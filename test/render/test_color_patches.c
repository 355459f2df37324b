/* Colors of patches: every pair of triangles across an edge is looked at, on sheets cut at random,
 * on soups, and on patches too many to be told apart. */
#include "support/test_support.h"

#include "base/hash.h"
#include "render/color_map.h"
#include "render/color_space.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SIDE = 40, TRIANGLES = 2 * SIDE * SIDE, VERTICES = (SIDE + 1) * (SIDE + 1) };

typedef struct sheet {
    uint32_t triangles[3 * TRIANGLES], labels[TRIANGLES];
    float colors[3 * TRIANGLES];
} sheet;

static tulle_mesh_view view_sheet(const sheet *s) {
    return (tulle_mesh_view){NULL, VERTICES, s->triangles, TRIANGLES};
}

static void make_sheet(sheet *s) {
    uint32_t *corner = s->triangles;
    for (uint32_t y = 0; y < SIDE; y++)
        for (uint32_t x = 0; x < SIDE; x++) {
            uint32_t const a = y * (SIDE + 1) + x, b = a + 1, c = a + SIDE + 1, d = c + 1;
            uint32_t const both[6] = {a, b, d, a, d, c};
            memcpy(corner, both, sizeof both);
            corner += 6;
        }
}

/* Patches as the nearest of `seed_count` places; every tenth triangle none. */
static void cut_sheet(sheet *s, int seed_count, uint64_t random) {
    double x[400], y[400];
    uint32_t labels[400];
    for (int i = 0; i < seed_count; i++) {
        x[i] = SIDE * random_uniform(&random);
        y[i] = SIDE * random_uniform(&random);
        labels[i] = 1 + (uint32_t)(4e9 * random_uniform(&random));
    }
    for (int t = 0; t < TRIANGLES; t++) {
        double const px = t / 2 % SIDE + (t % 2 ? 0.33 : 0.67), py = (double)(t / 2 / SIDE) + 0.5;
        int nearest = 0;
        for (int i = 1; i < seed_count; i++)
            if (hypot(px - x[i], py - y[i]) < hypot(px - x[nearest], py - y[nearest])) nearest = i;
        s->labels[t] = random_uniform(&random) < 0.1 ? 0 : labels[nearest];
    }
}

static double get_distance(const float a[3], const float b[3]) {
    double lab[2][3];
    color_to_oklab((const double[3]){(double)a[0], (double)a[1], (double)a[2]}, lab[0]);
    color_to_oklab((const double[3]){(double)b[0], (double)b[1], (double)b[2]}, lab[1]);
    double sum = 0.0;
    for (int i = 0; i < 3; i++) sum += (lab[0][i] - lab[1][i]) * (lab[0][i] - lab[1][i]);
    return sqrt(sum);
}

static bool share_edge(const uint32_t *a, const uint32_t *b) {
    int shared = 0;
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++) shared += a[i] == b[k];
    return shared >= 2;
}

/* Triangles across an edge: alike within a patch, far apart otherwise; returns pairs that are not.
 */
static size_t count_faults(tulle_mesh_view mesh, const uint32_t *labels, const float *colors) {
    size_t faults = 0;
    float grey[3];
    color_map_patch(TULLE_NONE, grey);
    for (size_t i = 0; i < mesh.triangle_count; i++) {
        if (labels[i] == 0) faults += memcmp(colors + 3 * i, grey, sizeof grey) != 0;
        for (size_t k = 0; k < i; k++) {
            bool const is_near = share_edge(mesh.triangles + 3 * i, mesh.triangles + 3 * k);
            if (labels[i] == labels[k])
                faults += memcmp(colors + 3 * i, colors + 3 * k, 3 * sizeof(float)) != 0;
            else if (is_near)
                faults += get_distance(colors + 3 * i, colors + 3 * k) < COLOR_PATCH_DISTANCE;
        }
    }
    return faults;
}

static void test_sheets_cut_at_random(void **state) {
    (void)state;
    static sheet s;
    memory heap = memory_default();
    make_sheet(&s);
    int const seed_counts[] = {1, 7, 60, 400};
    for (int i = 0; i < 4; i++) {
        cut_sheet(&s, seed_counts[i], 17 + (uint64_t)i);
        size_t alike = 9;
        assert_int_equal(color_patches(&heap, view_sheet(&s), s.labels, s.colors, &alike, NULL),
                         TULLE_OK);
        assert_int_equal(alike, 0);
        assert_int_equal(count_faults(view_sheet(&s), s.labels, s.colors), 0);
    }
    for (int t = 0; t < TRIANGLES; t++) s.labels[t] = (uint32_t)t + 1; /* a patch each */
    assert_int_equal(color_patches(&heap, view_sheet(&s), s.labels, s.colors, NULL, NULL),
                     TULLE_OK);
    assert_int_equal(count_faults(view_sheet(&s), s.labels, s.colors), 0);
    memset(s.labels, 0, sizeof s.labels);
    assert_int_equal(color_patches(&heap, view_sheet(&s), s.labels, s.colors, NULL, NULL),
                     TULLE_OK);
    assert_int_equal(count_faults(view_sheet(&s), s.labels, s.colors), 0);
    assert_int_equal(heap.bytes_held, 0);
}

/* Patches that keep their label and neighbours keep their color when others change far away. */
static void test_colors_stay_from_frame_to_frame(void **state) {
    (void)state;
    static sheet before, after;
    memory heap = memory_default();
    make_sheet(&before);
    cut_sheet(&before, 60, 5);
    after = before;
    after.labels[0] = 77; /* a patch of its own in a corner */
    color_patches(&heap, view_sheet(&before), before.labels, before.colors, NULL, NULL);
    color_patches(&heap, view_sheet(&after), after.labels, after.colors, NULL, NULL);
    int kept = 0;
    for (int t = 0; t < TRIANGLES; t++)
        kept += memcmp(before.colors + 3 * t, after.colors + 3 * t, 3 * sizeof(float)) == 0;
    assert_true(kept > TRIANGLES * 9 / 10);
}

/* `count` triangles around one edge, a patch each, touch each other all. */
static void color_fan(uint32_t count, size_t *alike, size_t *faults) {
    static uint32_t triangles[3 * 20000], labels[20000];
    static float colors[3 * 20000];
    memory heap = memory_default();
    for (uint32_t i = 0; i < count; i++) {
        triangles[3 * i] = 0;
        triangles[3 * i + 1] = 1;
        triangles[3 * i + 2] = 2 + i;
        labels[i] = 1000 * (count - i);
    }
    tulle_mesh_view const mesh = {NULL, count + 2, triangles, count};
    assert_int_equal(color_patches(&heap, mesh, labels, colors, alike, NULL), TULLE_OK);
    *faults = count > 100 ? 0 : count_faults(mesh, labels, colors);
}

static void test_more_patches_than_colors_are_counted(void **state) {
    (void)state;
    size_t alike, faults;
    color_fan(COLOR_PATCH_COUNT, &alike, &faults);
    assert_int_equal(alike, 0);
    assert_int_equal(faults, 0);
    color_fan(COLOR_PATCH_COUNT + 1, &alike, &faults);
    assert_int_equal(alike, 1);
    assert_int_equal(faults, 1);
    color_fan(20000, &alike, &faults); /* 2e8 pairs are not listed one by one */
    assert_true(alike > 0);
}

typedef struct failing {
    int countdown;
} failing;

static void *allocate_some(void *context, size_t byte_count) {
    failing *const f = context;
    return f->countdown-- > 0 ? malloc(byte_count) : NULL;
}

static void release_some(void *context, void *pointer, size_t byte_count) {
    (void)context, (void)byte_count;
    free(pointer);
}

static void test_no_memory(void **state) {
    (void)state;
    static sheet s;
    make_sheet(&s);
    cut_sheet(&s, 60, 3);
    int allowed = 0;
    for (tulle_status status = TULLE_ERROR_OUT_OF_MEMORY; status != TULLE_OK; allowed++) {
        failing f = {allowed};
        memory heap = {.allocator = {allocate_some, release_some, &f, 0}};
        tulle_error error;
        status = color_patches(&heap, view_sheet(&s), s.labels, s.colors, NULL, &error);
        assert_true(status == TULLE_OK || error.status == TULLE_ERROR_OUT_OF_MEMORY);
        assert_int_equal(heap.bytes_held, 0);
        assert_true(allowed < 100);
    }
    assert_true(allowed > 9);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_sheets_cut_at_random),
        cmocka_unit_test(test_colors_stay_from_frame_to_frame),
        cmocka_unit_test(test_more_patches_than_colors_are_counted),
        cmocka_unit_test(test_no_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
