/* What patches must be: edge-connected, within their cones, covering, the same for any number of
 * threads. */
#include "detect/patches/patches.h"

#include "support/wide_normals.h"
#include "tulle/shapes.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

typedef struct moving_sheet {
    tulle_mesh mesh;
    topology topo;
    double *end; /* [m] */
    uint32_t *labels;
    memory heap;
    arena scratch;
} moving_sheet;

/* A square of n x n vertices; the shape and its motion are the test's. */
static moving_sheet make_sheet(unsigned n) {
    moving_sheet sheet = {.heap = memory_default()};
    tulle_shape_def def = tulle_shape_def_default(TULLE_SHAPE_RECTANGLE);
    def.size[0] = def.size[1] = 1.0;
    def.resolution[0] = def.resolution[1] = n;
    assert_int_equal(tulle_shape_generate(&def, &sheet.mesh, NULL), TULLE_OK);
    sheet.end = malloc(3 * sheet.mesh.vertex_count * sizeof(double));
    sheet.labels = malloc(sheet.mesh.triangle_count * sizeof(uint32_t));
    assert_non_null(sheet.end);
    assert_non_null(sheet.labels);
    assert_int_equal(topology_build(&sheet.heap, sheet.mesh.triangles, sheet.mesh.triangle_count,
                                    sheet.mesh.vertex_count, &sheet.topo),
                     TULLE_OK);
    return sheet;
}

static void destroy_sheet(moving_sheet *sheet) {
    arena_destroy(&sheet->scratch);
    topology_destroy(&sheet->heap, &sheet->topo);
    tulle_mesh_destroy(&sheet->mesh);
    free(sheet->end);
    free(sheet->labels);
}

static patch_list grow(moving_sheet *sheet, double max_angle, int threads) {
    patch_surface const surface = {&sheet->topo, 0, (uint32_t)sheet->topo.triangle_count,
                                   sheet->mesh.positions, sheet->end};
    patch_settings const settings = {max_angle, threads};
    patch_list list;
    sheet->scratch = sheet->scratch.heap ? sheet->scratch : arena_make(&sheet->heap);
    assert_int_equal(grow_patches(&surface, &settings, &sheet->scratch, sheet->labels, &list),
                     TULLE_OK);
    return list;
}

static void load_triangle(const moving_sheet *sheet, size_t triangle, vec3 start[3], vec3 end[3]) {
    for (size_t k = 0; k < 3; k++) {
        start[k] = vec3_load(sheet->mesh.positions, sheet->mesh.triangles[3 * triangle + k]);
        end[k] = vec3_load(sheet->end, sheet->mesh.triangles[3 * triangle + k]);
    }
}

/* Triangles that the patch of `seed` reaches over edges that two of its triangles share. */
static size_t count_connected(const moving_sheet *sheet, size_t seed, uint8_t *is_reached) {
    size_t const count = sheet->mesh.triangle_count;
    size_t *const stack = malloc(count * sizeof *stack);
    size_t depth = 0, reached = 0;
    assert_non_null(stack);
    stack[depth++] = seed;
    is_reached[seed] = 1;
    while (depth > 0) {
        size_t const triangle = stack[--depth];
        reached++;
        for (size_t k = 0; k < 3; k++) {
            size_t const edge = sheet->topo.triangle_edges[3 * triangle + k];
            for (size_t side = 0; side < 2; side++) {
                uint32_t const other = sheet->topo.edge_triangles[2 * edge + side];
                if (other == TULLE_NONE || is_reached[other] ||
                    sheet->labels[other] != sheet->labels[seed])
                    continue;
                is_reached[other] = 1;
                stack[depth++] = other;
            }
        }
    }
    free(stack);
    return reached;
}

static void assert_good_patches(const moving_sheet *sheet, const patch_list *list,
                                double max_angle) {
    size_t const count = sheet->mesh.triangle_count;
    uint8_t *const is_reached = calloc(count, 1);
    size_t *const sizes = calloc(list->count + 1, sizeof *sizes);
    size_t *const connected = calloc(list->count + 1, sizeof *connected);
    uint32_t highest = 0;
    for (size_t i = 0; i < count; i++) {
        vec3 start[3], end[3];
        load_triangle(sheet, i, start, end);
        normal_cone const own = normal_cone_of_triangle(CONE_BERNSTEIN, start, end);
        uint32_t const label = sheet->labels[i];
        bool const has_cone = normal_cone_is_valid(own) && own.half_angle <= max_angle;
        assert_int_equal(has_cone, label != PATCH_ISOLATED);
        assert_true(label <= list->count);
        assert_true(label <= highest + 1); /* numbered as they come */
        if (label > highest) highest = label;
        sizes[label]++;
        if (label == PATCH_ISOLATED) continue;
        normal_cone const cone = list->cones[label - 1];
        assert_true(cone.half_angle <= max_angle);
        assert_true(sample_angle(cone.axis, start, end, 10) <= cone.half_angle);
        if (!is_reached[i]) {
            assert_int_equal(connected[label], 0);
            connected[label] = count_connected(sheet, i, is_reached);
        }
    }
    assert_int_equal(highest, list->count);
    for (size_t k = 1; k <= list->count; k++) assert_int_equal(sizes[k], connected[k]);
    free(is_reached);
    free(sizes);
    free(connected);
}

static void patches_of_rough_sheets_are_sound(void **state) {
    (void)state;
    uint64_t seed = 10;
    for (int round = 0; round < 12; round++) {
        moving_sheet sheet = make_sheet(30);
        double const roughness = 0.004 * (round % 4), motion = 0.003 * (round % 3);
        for (size_t v = 0; v < sheet.mesh.vertex_count; v++) {
            double *const x = sheet.mesh.positions + 3 * v;
            x[2] = 0.1 * sin(9.0 * x[0]) * cos(4.0 * x[1]) +
                   random_between(&seed, -roughness, roughness);
            vec3 const moved =
                vec3_add(vec3_load(x, 0), random_vector(&seed, round == 11 ? 0.1 : motion));
            vec3_store(sheet.end, v, moved);
        }
        double const max_angle = (round % 2 ? 30.0 : 85.0) * DEGREE;
        patch_list const list = grow(&sheet, max_angle, 1);
        assert_good_patches(&sheet, &list, max_angle);
        size_t const bytes = sheet.mesh.triangle_count * sizeof(uint32_t);
        uint32_t *const labels = malloc(bytes);
        memcpy(labels, sheet.labels, bytes);
        patch_list const again = grow(&sheet, max_angle, 4);
        assert_int_equal(again.count, list.count);
        assert_memory_equal(labels, sheet.labels, bytes);
        assert_memory_equal(again.cones, list.cones, list.count * sizeof(normal_cone));
        free(labels);
        destroy_sheet(&sheet);
    }
}

/* A roof whose sides stand 80 degrees apart: one patch from 40 degrees on, two below. */
static void a_roof_has_two_sides(void **state) {
    (void)state;
    moving_sheet sheet = make_sheet(21);
    for (size_t v = 0; v < sheet.mesh.vertex_count; v++) {
        double *const x = sheet.mesh.positions + 3 * v;
        x[2] = -tan(40.0 * DEGREE) * fabs(x[0]);
        vec3_store(sheet.end, v, vec3_add(vec3_load(x, 0), vec3_make(0.1, 0.0, 5.0)));
    }
    patch_list list = grow(&sheet, 39.9 * DEGREE, 2);
    assert_int_equal(list.count, 2);
    assert_good_patches(&sheet, &list, 39.9 * DEGREE);
    for (size_t i = 0; i < sheet.mesh.triangle_count; i++) {
        double middle = 0.0;
        for (size_t k = 0; k < 3; k++)
            middle += sheet.mesh.positions[3 * (size_t)sheet.mesh.triangles[3 * i + k]];
        double first = 0.0;
        for (size_t k = 0; k < 3; k++)
            first += sheet.mesh.positions[3 * (size_t)sheet.mesh.triangles[k]];
        assert_int_equal((middle < 0.0) == (first < 0.0), sheet.labels[i] == 1);
    }
    list = grow(&sheet, 40.1 * DEGREE, 2);
    assert_int_equal(list.count, 1);
    assert_true(vec3_norm(vec3_sub(list.cones[0].axis, vec3_make(0.0, 0.0, 1.0))) < 1e-6);
    assert_true(fabs(list.cones[0].half_angle - 40.0 * DEGREE) < 1e-5);
    destroy_sheet(&sheet);
}

static void *refuse_memory(void *context, size_t byte_count) {
    long *const left = context;
    return --*left < 0 ? NULL : malloc(byte_count);
}
static void release_memory(void *context, void *pointer, size_t byte_count) {
    (void)context, (void)byte_count;
    free(pointer);
}

static void want_of_memory_is_reported(void **state) {
    (void)state;
    moving_sheet sheet = make_sheet(200);
    memcpy(sheet.end, sheet.mesh.positions, 3 * sheet.mesh.vertex_count * sizeof(double));
    patch_surface const surface = {&sheet.topo, 0, (uint32_t)sheet.topo.triangle_count,
                                   sheet.mesh.positions, sheet.end};
    patch_settings const settings = {60.0 * DEGREE, 1};
    tulle_status status = TULLE_ERROR_OUT_OF_MEMORY;
    long allowed = 0;
    for (; status == TULLE_ERROR_OUT_OF_MEMORY; allowed++) {
        long left = allowed;
        memory heap = {.allocator = {refuse_memory, release_memory, &left, 0}};
        arena scratch = arena_make(&heap);
        patch_list list;
        status = grow_patches(&surface, &settings, &scratch, sheet.labels, &list);
        arena_destroy(&scratch);
    }
    assert_int_equal(status, TULLE_OK);
    assert_true(allowed > 1);
    destroy_sheet(&sheet);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(patches_of_rough_sheets_are_sound),
        cmocka_unit_test(a_roof_has_two_sides),
        cmocka_unit_test(want_of_memory_is_reported),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
