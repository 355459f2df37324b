/* Cones of moving normals against sampled normals in long double, and what patches must be:
 * connected, within their cones, covering, the same for any number of threads. */
#include "detect/patches.h"

#include "base/hash.h"
#include "tulle/shapes.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static const double DEGREE = 0.017453292519943295; /* [rad] */

static double random_between(uint64_t *seed, double low, double high) {
    return low + (high - low) * random_uniform(seed);
}

static vec3 random_vector(uint64_t *seed, double size) {
    double const x = random_between(seed, -size, size), y = random_between(seed, -size, size);
    return vec3_make(x, y, random_between(seed, -size, size));
}

/* ---- sampled normals ---- */

typedef struct wide3 {
    long double x, y, z;
} wide3;

static wide3 wide(vec3 a) { return (wide3){a.x, a.y, a.z}; }
static wide3 wide_cross(wide3 a, wide3 b) {
    return (wide3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
static long double wide_norm(wide3 a) { return sqrtl(a.x * a.x + a.y * a.y + a.z * a.z); }
static double angle_between(wide3 a, wide3 b) {
    return (double)atan2l(wide_norm(wide_cross(a, b)), a.x * b.x + a.y * b.y + a.z * b.z);
}

/* An edge of the triangle at time t. */
static wide3 find_edge(const vec3 start[3], const vec3 end[3], int corner, long double t) {
    wide3 const a0 = wide(start[0]), a1 = wide(end[0]);
    wide3 const b0 = wide(start[corner]), b1 = wide(end[corner]);
    return (wide3){(1.0L - t) * (b0.x - a0.x) + t * (b1.x - a1.x),
                   (1.0L - t) * (b0.y - a0.y) + t * (b1.y - a1.y),
                   (1.0L - t) * (b0.z - a0.z) + t * (b1.z - a1.z)};
}

/* Largest angle between the axis and n(t) at `count` + 1 times. */
static double sample_angle(vec3 axis, const vec3 start[3], const vec3 end[3], int count) {
    double largest = 0.0;
    for (int i = 0; i <= count; i++) {
        long double const t = (long double)i / (long double)count;
        wide3 const n = wide_cross(find_edge(start, end, 1, t), find_edge(start, end, 2, t));
        largest = fmax(largest, angle_between(wide(axis), n));
    }
    return largest;
}

/* A triangle of height `thinness` over an edge of length 1, anywhere. */
static void make_triangle(uint64_t *seed, double thinness, vec3 points[3]) {
    vec3 const u = vec3_normalize(random_vector(seed, 1.0));
    vec3 const across = vec3_normalize(vec3_cross(u, random_vector(seed, 1.0)));
    points[0] = random_vector(seed, 1.0);
    points[1] = vec3_add(points[0], u);
    points[2] =
        vec3_add_scaled(vec3_add_scaled(points[0], u, random_uniform(seed)), across, thinness);
}

static void move_triangle(uint64_t *seed, double motion, const vec3 start[3], vec3 end[3]) {
    vec3 const shift = random_vector(seed, random_uniform(seed) < 0.5 ? 0.0 : 10.0);
    for (int k = 0; k < 3; k++)
        end[k] = vec3_add(vec3_add(start[k], shift), random_vector(seed, motion));
}

/* ---- cones ---- */

static void cones_hold_all_normals(void **state) {
    (void)state;
    static const double thinnesses[] = {1.0, 0.3, 1e-3, 1e-9, 1e-12};
    static const double motions[] = {0.0, 1e-9, 1e-3, 0.1, 1.0, 100.0};
    static const double sizes[] = {1.0, 1e-6, 1e9};
    uint64_t seed = 5;
    size_t valid = 0, all = 0;
    for (int round = 0; round < 90 * 150; round++) {
        double const thinness = thinnesses[round % 5], motion = motions[round / 5 % 6];
        double const size = sizes[round / 30 % 3];
        vec3 start[3], end[3];
        make_triangle(&seed, thinness, start);
        move_triangle(&seed, motion < 1.0 ? motion * thinness : motion, start, end);
        for (int k = 0; k < 3; k++) {
            start[k] = vec3_scale(start[k], size);
            end[k] = vec3_scale(end[k], size);
        }
        normal_cone const cone = normal_cone_of_triangle(start, end);
        all++;
        if (!normal_cone_is_valid(cone)) continue;
        valid++;
        double const angle = sample_angle(cone.axis, start, end, round % 50 ? 40 : 1000);
        if (angle > cone.half_angle)
            fail_msg("a normal leaves its cone of %.17g by %g rad (thinness %g, motion %g)",
                     cone.half_angle, angle - cone.half_angle, thinness, motion);
    }
    print_message("%zu of %zu cones are valid\n", valid, all);
    assert_true(valid > all / 2);
}

/* Half-angle of the best of many axes around a cone's: none is better by more than rounding. */
static void cones_are_the_smallest_of_their_coefficients(void **state) {
    (void)state;
    uint64_t seed = 6;
    for (int round = 0; round < 2000; round++) {
        vec3 start[3], end[3];
        make_triangle(&seed, 0.8, start);
        move_triangle(&seed, 0.3, start, end);
        normal_cone const cone = normal_cone_of_triangle(start, end);
        if (!normal_cone_is_valid(cone)) continue;
        vec3 const u0 = vec3_sub(start[1], start[0]), v0 = vec3_sub(start[2], start[0]);
        vec3 const u1 = vec3_sub(end[1], end[0]), v1 = vec3_sub(end[2], end[0]);
        wide3 const hull[3] = {wide(vec3_cross(u0, v0)), wide(vec3_cross(u1, v1)),
                               wide(vec3_add(vec3_cross(u0, v1), vec3_cross(u1, v0)))};
        for (int i = 0; i < 60; i++) {
            double const size = i % 2 ? 1e-3 : 0.1;
            wide3 const axis = wide(vec3_add(cone.axis, random_vector(&seed, size)));
            double widest = 0.0;
            for (int k = 0; k < 3; k++) widest = fmax(widest, angle_between(axis, hull[k]));
            assert_true(widest >= cone.half_angle - 3e-9);
        }
    }
}

static void stretch_and_noise_hardly_widen_a_cone(void **state) {
    (void)state;
    uint64_t seed = 7;
    double sum = 0.0;
    int const count = 2000;
    for (int i = 0; i < count; i++) {
        vec3 start[3], end[3];
        make_triangle(&seed, 0.866, start);
        for (int k = 0; k < 3; k++) end[k] = vec3_scale(start[k], 1.01);
        assert_true(normal_cone_of_triangle(start, end).half_angle < 1e-8);
        for (int k = 0; k < 3; k++) end[k] = vec3_add(start[k], vec3_make(3.0, -2.0, 1.0));
        assert_true(normal_cone_of_triangle(start, end).half_angle < 1e-8);
        for (int k = 0; k < 3; k++) end[k] = vec3_add(start[k], random_vector(&seed, 0.01));
        sum += normal_cone_of_triangle(start, end).half_angle;
    }
    print_message("noise of 1%% of the edge: %.3g degrees\n", sum / count / DEGREE);
    assert_true(sum / count < 1.0 * DEGREE);
}

static void turning_over_has_no_cone(void **state) {
    (void)state;
    vec3 const start[3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    vec3 const flipped[3] = {{0, 0, 0}, {0, 1, 0}, {1, 0, 0}};
    vec3 const upright[3] = {{0, 0, 0}, {1, 0, 0}, {0, 0.01, 1}};
    vec3 const line[3] = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
    vec3 const broken[3] = {{0, 0, 0}, {1, 0, 0}, {0, (double)NAN, 0}};
    vec3 const endless[3] = {{0, 0, 0}, {1, 0, 0}, {0, (double)INFINITY, 0}};
    vec3 const huge[3] = {{0, 0, 0}, {1e200, 0, 0}, {0, 1e200, 0}};
    vec3 const tiny[3] = {{0, 0, 0}, {1e-200, 0, 0}, {0, 1e-200, 0}};
    assert_true(normal_cone_is_valid(normal_cone_of_triangle(start, start)));
    assert_true(normal_cone_is_valid(normal_cone_of_triangle(start, upright)));
    const vec3 *const others[] = {flipped, line, broken, endless, huge, tiny};
    for (size_t i = 0; i < sizeof others / sizeof others[0]; i++) {
        assert_false(normal_cone_is_valid(normal_cone_of_triangle(start, others[i])));
        assert_false(normal_cone_is_valid(normal_cone_of_triangle(others[i], start)));
    }
    assert_false(normal_cone_is_valid(normal_cone_of_triangle(line, line)));
}

/* A vector that leaves the axis by just the cone's half-angle. */
static wide3 make_rim(uint64_t *seed, const normal_cone *cone) {
    vec3 const side = vec3_normalize(vec3_cross(cone->axis, random_vector(seed, 1.0)));
    long double const c = cosl(cone->half_angle), s = sinl(cone->half_angle);
    return (wide3){c * cone->axis.x + s * side.x, c * cone->axis.y + s * side.y,
                   c * cone->axis.z + s * side.z};
}

static void merged_cones_hold_both(void **state) {
    (void)state;
    static const double spreads[] = {0.0, 1e-16, 1e-10, 1e-9, 1e-8, 1e-3, 0.5, 3.0};
    static const double limits[] = {0.5, 1.0, 89.9 * DEGREE};
    uint64_t seed = 8;
    size_t merged_count = 0;
    for (int round = 0; round < 60000; round++) {
        double const limit = limits[round / 8 % 3];
        normal_cone a = {vec3_normalize(random_vector(&seed, 1.0)), 0.0}, b = a, merged = a;
        b.axis = vec3_normalize(vec3_add(b.axis, random_vector(&seed, spreads[round % 8])));
        a.half_angle = limit * random_uniform(&seed) * (round % 5 ? 1.0 : 1e-9);
        b.half_angle = round % 7 ? limit * random_uniform(&seed) * 0.5 : a.half_angle;
        double const ideal =
            fmax(0.5 * (angle_between(wide(a.axis), wide(b.axis)) + a.half_angle + b.half_angle),
                 fmax(a.half_angle, b.half_angle));
        bool const is_merged = normal_cone_merge(&a, &b, limit, &merged);
        if (!is_merged) assert_true(ideal > limit - 3e-9);
        if (!is_merged) continue;
        merged_count++;
        assert_true(merged.half_angle <= limit);
        assert_true(merged.half_angle <= ideal + 4e-9);
        assert_true(fabs(vec3_norm(merged.axis) - 1.0) < 1e-15);
        for (int k = 0; k < 8; k++) {
            wide3 const rim = make_rim(&seed, k % 2 ? &a : &b);
            /* 1e-14: a rim is made of a rounded axis and side */
            assert_true(angle_between(wide(merged.axis), rim) <= merged.half_angle + 1e-14);
        }
    }
    assert_true(merged_count > 10000);
}

/* ---- patches ---- */

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
        normal_cone const own = normal_cone_of_triangle(start, end);
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
        memory heap = memory_make((tulle_allocator){refuse_memory, release_memory, &left, 0});
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
        cmocka_unit_test(cones_hold_all_normals),
        cmocka_unit_test(cones_are_the_smallest_of_their_coefficients),
        cmocka_unit_test(stretch_and_noise_hardly_widen_a_cone),
        cmocka_unit_test(turning_over_has_no_cone),
        cmocka_unit_test(merged_cones_hold_both),
        cmocka_unit_test(patches_of_rough_sheets_are_sound),
        cmocka_unit_test(a_roof_has_two_sides),
        cmocka_unit_test(want_of_memory_is_reported),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
