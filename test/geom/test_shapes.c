/* Generated shapes: topology and closed forms, validity over random parameters, irregular cloth,
 * limits and refusals. */
#include "geom/shapes.h"

#include "base/hash.h"
#include "support/failing_heap.h"
#include "tulle/check.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static const double PI = 3.141592653589793;

static void generate(const tulle_shape_def *def, tulle_mesh *mesh) {
    tulle_error error = {0};
    if (tulle_shape_generate(def, mesh, &error) != TULLE_OK) fail_msg("%s", error.message);
}

static tulle_mesh_role get_role(tulle_shape shape) {
    return tulle_shape_is_cloth(shape) ? TULLE_MESH_ROLE_CLOTH : TULLE_MESH_ROLE_OBSTACLE;
}

/* All generated shapes, obstacles too, are oriented manifolds. */
static tulle_mesh_info expect_manifold(const tulle_mesh *mesh, tulle_shape shape) {
    tulle_error error = {0};
    tulle_mesh_info info;
    tulle_mesh_view const view = tulle_mesh_get_view(mesh);
    /* How low a triangle of cloth may be for floats in files is no matter of manifolds. */
    if (tulle_mesh_validate(view, TULLE_MESH_ROLE_CLOTH, &error) != TULLE_OK &&
        (tulle_shape_is_cloth(shape) || !strstr(error.message, "Floats in files hold no cloth")))
        fail_msg("%s: %s", tulle_shape_name(shape), error.message);
    assert_int_equal(tulle_mesh_validate(view, get_role(shape), NULL), TULLE_OK);
    assert_int_equal(tulle_mesh_get_info(view, &info, NULL), TULLE_OK);
    assert_int_equal(info.component_count, 1);
    return info;
}

static double measure_volume(const tulle_mesh *mesh) {
    double sum = 0.0;
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        const uint32_t *const corner = mesh->triangles + 3 * t;
        vec3 const a = vec3_load(mesh->positions, corner[0]);
        vec3 const b = vec3_load(mesh->positions, corner[1]);
        sum += vec3_dot(a, vec3_cross(b, vec3_load(mesh->positions, corner[2])));
    }
    return sum / 6.0;
}

/* Area of a regular polygon of n corners on the unit circle. */
static double polygon_area(double n) { return 0.5 * n * sin(2.0 * PI / n); }

static void expect_near(double found, double expected, double relative) {
    if (!(fabs(found - expected) <= relative * fabs(expected)))
        fail_msg("found %.17g, expected %.17g", found, expected);
}

/* Volumes and areas of the polyhedra themselves; tolerance 0.02 where only the smooth one is known.
 */
static void check_measure(const tulle_shape_def *def, const tulle_mesh *mesh, double area) {
    double const r = def->radius, h = def->height, volume = measure_volume(mesh);
    double const n = def->resolution[0], section = r * r * polygon_area(n), tight = 1e-12;
    double const slab = def->size[0] * def->size[1] * def->size[2];
    switch (def->shape) {
    case TULLE_SHAPE_RECTANGLE:
    case TULLE_SHAPE_RIBBON:
    case TULLE_SHAPE_PLANE: expect_near(area, def->size[0] * def->size[1], tight); break;
    case TULLE_SHAPE_DISC:
        expect_near(area, r * r * polygon_area(def->resolution[1]), tight);
        break;
    case TULLE_SHAPE_TUBE: expect_near(area, 2.0 * n * r * sin(PI / n) * h, tight); break;
    case TULLE_SHAPE_CAPE:
        expect_near(area, 0.5 * def->angle * (r * r - def->inner_radius * def->inner_radius), 0.02);
        break;
    case TULLE_SHAPE_NET: {
        double const hole_x = (def->size[0] - (def->cells[0] + 1) * def->strand) / def->cells[0];
        double const hole_y = (def->size[1] - (def->cells[1] + 1) * def->strand) / def->cells[1];
        double const holes = hole_x * hole_y * def->cells[0] * def->cells[1];
        expect_near(area, def->size[0] * def->size[1] - holes, tight);
        break;
    }
    case TULLE_SHAPE_BOX: expect_near(volume, slab, tight); break;
    case TULLE_SHAPE_SPHERE: expect_near(volume, 4.0 / 3.0 * PI * r * r * r, 0.02); break;
    case TULLE_SHAPE_HEMISPHERE: expect_near(volume, 2.0 / 3.0 * PI * r * r * r, 0.02); break;
    case TULLE_SHAPE_CYLINDER: expect_near(volume, section * h, tight); break;
    case TULLE_SHAPE_CONE: expect_near(volume, section * h / 3.0, tight); break;
    case TULLE_SHAPE_NEEDLE:
        expect_near(volume, section * (h - 2.0 / 3.0 * def->tip_height), tight);
        break;
    case TULLE_SHAPE_TETRAHEDRON:
        expect_near(volume, r * r * polygon_area(3) * h / 3.0, tight);
        break;
    case TULLE_SHAPE_TORUS:
        expect_near(volume, 2.0 * PI * PI * r * def->inner_radius * def->inner_radius, 0.03);
        break;
    case TULLE_SHAPE_NAIL: {
        double const head = def->head_radius * def->head_radius * polygon_area(n);
        expect_near(volume, section * (h - def->head_height) + head * def->head_height, tight);
        break;
    }
    case TULLE_SHAPE_SCEPTRE: {
        double const head = def->head_radius, half = sqrt(head * head - r * r);
        double const cap =
            (2.0 * head * head * head + 3.0 * head * head * half - half * half * half) / 3.0;
        double const leg = r * r * (h - head - half);
        /* The ball's meridian is a polygon of chords. */
        expect_near(volume, polygon_area(n) * (cap + leg), 0.02);
        break;
    }
    case TULLE_SHAPE_TILE:
        assert_true(volume > slab && volume < slab * (1 + h / def->size[2]));
        break;
    case TULLE_SHAPE_BUMPY_GROUND:
    case TULLE_SHAPE_CRESTED_GROUND: assert_true(area > def->size[0] * def->size[1]); break;
    case TULLE_SHAPE_COUNT: fail();
    }
}

static size_t expected_loops(const tulle_shape_def *def) {
    switch (def->shape) {
    case TULLE_SHAPE_RECTANGLE:
    case TULLE_SHAPE_RIBBON:
    case TULLE_SHAPE_DISC:
    case TULLE_SHAPE_CAPE:
    case TULLE_SHAPE_PLANE:
    case TULLE_SHAPE_BUMPY_GROUND:
    case TULLE_SHAPE_CRESTED_GROUND: return 1;
    case TULLE_SHAPE_TUBE: return 2;
    case TULLE_SHAPE_NET: return (size_t)def->cells[0] * def->cells[1] + 1;
    default: return 0;
    }
}

static void defaults_are_manifold_with_right_measures(void **state) {
    (void)state;
    for (int shape = 0; shape < TULLE_SHAPE_COUNT; shape++) {
        tulle_shape_def def = tulle_shape_def_default((tulle_shape)shape);
        shape_derive_def(&def);
        tulle_mesh mesh;
        generate(&def, &mesh);
        tulle_mesh_info const info = expect_manifold(&mesh, def.shape);
        print_message("%-15s %6zu vertices %6zu triangles, edges %.4g to %.4g m, angle %.1f deg\n",
                      tulle_shape_name(def.shape), info.vertex_count, info.triangle_count,
                      info.edge_length_min, info.edge_length_max, info.angle_min * 180.0 / PI);
        assert_int_equal(info.boundary_loop_count, expected_loops(&def));
        long const handles = shape == TULLE_SHAPE_TORUS ? 1 : 0;
        assert_int_equal(info.euler_characteristic, 2 - 2 * handles - (long)expected_loops(&def));
        check_measure(&def, &mesh, info.area);
        if (tulle_shape_is_cloth(def.shape)) assert_true(info.angle_min > 25.0 * PI / 180.0);
        tulle_mesh_destroy(&mesh);
    }
}

static void names_are_distinct(void **state) {
    (void)state;
    for (int a = 0; a < TULLE_SHAPE_COUNT; a++)
        for (int b = 0; b < a; b++)
            assert_string_not_equal(tulle_shape_name((tulle_shape)a),
                                    tulle_shape_name((tulle_shape)b));
    assert_null(tulle_shape_name(TULLE_SHAPE_COUNT));
    assert_string_equal(tulle_shape_name(TULLE_SHAPE_BUMPY_GROUND), "bumpy-ground");
}

/* Where they lie: flat cloth about the origin with normals up, the rest as documented. */
static void places_are_as_documented(void **state) {
    (void)state;
    for (int shape = 0; shape < TULLE_SHAPE_COUNT; shape++) {
        tulle_shape_def const def = tulle_shape_def_default((tulle_shape)shape);
        tulle_mesh mesh;
        tulle_mesh_info info;
        generate(&def, &mesh);
        assert_int_equal(tulle_mesh_get_info(tulle_mesh_get_view(&mesh), &info, NULL), TULLE_OK);
        bool const is_sheet = expected_loops(&def) > 0 && shape != TULLE_SHAPE_TUBE;
        for (size_t t = 0; is_sheet && t < mesh.triangle_count; t++) {
            const uint32_t *const corner = mesh.triangles + 3 * t;
            vec3 const a = vec3_load(mesh.positions, corner[0]);
            vec3 const u = vec3_sub(vec3_load(mesh.positions, corner[1]), a);
            assert_true(vec3_cross(u, vec3_sub(vec3_load(mesh.positions, corner[2]), a)).z > 0.0);
        }
        bool const is_on_ground = shape == TULLE_SHAPE_HEMISPHERE ||
                                  (shape >= TULLE_SHAPE_CYLINDER && shape <= TULLE_SHAPE_NAIL &&
                                   shape != TULLE_SHAPE_TORUS) ||
                                  shape == TULLE_SHAPE_SCEPTRE;
        if (is_on_ground) assert_true(info.bounds_min[2] == 0.0);
        if (is_sheet && shape <= TULLE_SHAPE_PLANE)
            assert_true(info.bounds_min[2] == 0.0 && info.bounds_max[2] == 0.0);
        if (shape == TULLE_SHAPE_RECTANGLE || shape == TULLE_SHAPE_NET)
            for (int k = 0; k < 2; k++)
                assert_true(info.bounds_min[k] == -0.5 && info.bounds_max[k] == 0.5);
        tulle_mesh_destroy(&mesh);
    }
}

static bool has_common_corner(const uint32_t *a, const uint32_t *b, int corner_count) {
    for (int i = 0; i < corner_count; i++)
        for (int j = 0; j < 3; j++)
            if (a[i] == b[j]) return true;
    return false;
}

static double signed_volume(const double *x, uint32_t a, uint32_t b, uint32_t c, uint32_t d) {
    vec3 const o = vec3_load(x, a);
    return vec3_dot(vec3_sub(vec3_load(x, b), o),
                    vec3_cross(vec3_sub(vec3_load(x, c), o), vec3_sub(vec3_load(x, d), o)));
}

/* Whether an edge goes through a triangle with which it has no corner in common. */
static bool is_pierced(const double *x, const uint32_t *edge, const uint32_t *corner) {
    double const from = signed_volume(x, corner[0], corner[1], corner[2], edge[0]);
    double const to = signed_volume(x, corner[0], corner[1], corner[2], edge[1]);
    /* Coplanar up to rounding is not through; the shapes are about a metre wide. */
    if (fabs(from) < 1e-14 || fabs(to) < 1e-14 || (from > 0.0) == (to > 0.0)) return false;
    double side[3];
    for (int k = 0; k < 3; k++)
        side[k] = signed_volume(x, edge[0], edge[1], corner[k], corner[(k + 1) % 3]);
    return (side[0] > 0.0 && side[1] > 0.0 && side[2] > 0.0) ||
           (side[0] < 0.0 && side[1] < 0.0 && side[2] < 0.0);
}

static void small_ones_do_not_intersect(void **state) {
    (void)state;
    for (int shape = 0; shape < TULLE_SHAPE_COUNT; shape++) {
        tulle_shape_def def = tulle_shape_def_default((tulle_shape)shape);
        def.resolution[0] = def.resolution[1] = shape == TULLE_SHAPE_SPHERE ? 4 : 7;
        def.cells[0] = def.cells[1] = 2;
        def.is_irregular = 1;
        shape_clear_unused(&def);
        tulle_mesh mesh;
        generate(&def, &mesh);
        for (size_t h = 0; h < 3 * mesh.triangle_count; h++) {
            uint32_t const edge[2] = {mesh.triangles[h], mesh.triangles[h / 3 * 3 + (h + 1) % 3]};
            for (size_t t = 0; t < mesh.triangle_count; t++) {
                const uint32_t *const corner = mesh.triangles + 3 * t;
                if (!has_common_corner(edge, corner, 2) && is_pierced(mesh.positions, edge, corner))
                    fail_msg("%s: edge %u %u", tulle_shape_name(def.shape), edge[0], edge[1]);
            }
        }
        tulle_mesh_destroy(&mesh);
    }
}

/* The judge, which knows nothing of shapes, over each shape as cloth. */
static void judge_finds_no_intersection(void **state) {
    (void)state;
    for (int shape = 0; shape < TULLE_SHAPE_COUNT; shape++) {
        for (int is_irregular = 0; is_irregular <= tulle_shape_is_cloth((tulle_shape)shape);
             is_irregular++) {
            tulle_shape_def def = tulle_shape_def_default((tulle_shape)shape);
            def.is_irregular = is_irregular;
            tulle_mesh mesh;
            generate(&def, &mesh);
            tulle_check_body const body = {tulle_mesh_get_view(&mesh), 0};
            tulle_check_result result;
            assert_int_equal(tulle_check_intersections(&body, 1, 1, &result, NULL), TULLE_OK);
            if (result.pair_count > 0)
                fail_msg("%s: %zu pairs, first %u %u", tulle_shape_name(def.shape),
                         result.pair_count, result.pairs[0].triangle_a, result.pairs[0].triangle_b);
            tulle_check_result_destroy(&result);
            tulle_mesh_destroy(&mesh);
        }
    }
}

static void irregular_keeps_outline_and_area(void **state) {
    (void)state;
    for (int shape = 0; shape <= TULLE_SHAPE_NET; shape++) {
        for (uint64_t seed = 0; seed < 5; seed++) {
            tulle_shape_def def = tulle_shape_def_default((tulle_shape)shape);
            def.seed = seed;
            tulle_mesh regular, irregular, again;
            generate(&def, &regular);
            def.is_irregular = 1;
            generate(&def, &irregular);
            generate(&def, &again);
            size_t const count = irregular.vertex_count;
            assert_int_equal(count, regular.vertex_count);
            assert_memory_equal(irregular.positions, again.positions, 24 * count);
            assert_memory_equal(irregular.triangles, again.triangles, 12 * again.triangle_count);
            tulle_mesh_info const info = expect_manifold(&irregular, def.shape);
            tulle_mesh_info const before = expect_manifold(&regular, def.shape);
            expect_near(info.area, before.area, shape == TULLE_SHAPE_TUBE ? 1e-3 : 1e-12);
            assert_int_equal(info.boundary_edge_count, before.boundary_edge_count);
            assert_memory_equal(info.bounds_min, before.bounds_min, sizeof info.bounds_min);
            if (info.angle_min < 14.0 * PI / 180.0)
                fail_msg("%s: %g deg", tulle_shape_name(def.shape), info.angle_min * 180.0 / PI);
            size_t moved_count = 0;
            double farthest = 0.0;
            for (size_t v = 0; v < count; v++) {
                double const distance = vec3_norm(
                    vec3_sub(vec3_load(irregular.positions, v), vec3_load(regular.positions, v)));
                moved_count += distance > 0.0;
                farthest = fmax(farthest, distance);
            }
            assert_true(farthest < 0.25 * before.edge_length_max);
            /* A net of two columns has two thirds of its vertices on its rims. */
            assert_true(moved_count > (shape == TULLE_SHAPE_NET ? count / 5 : count / 2));
            tulle_mesh_destroy(&regular);
            tulle_mesh_destroy(&irregular);
            tulle_mesh_destroy(&again);
        }
    }
}

static void seeds_matter(void **state) {
    (void)state;
    tulle_shape const seeded[] = {TULLE_SHAPE_RECTANGLE, TULLE_SHAPE_BUMPY_GROUND,
                                  TULLE_SHAPE_CRESTED_GROUND, TULLE_SHAPE_TILE};
    for (size_t i = 0; i < 4; i++) {
        tulle_shape_def def = tulle_shape_def_default(seeded[i]);
        def.is_irregular = tulle_shape_is_cloth(seeded[i]);
        tulle_mesh first, second;
        generate(&def, &first);
        def.seed = 2;
        generate(&def, &second);
        assert_memory_not_equal(first.positions, second.positions, 24 * first.vertex_count);
        tulle_mesh_destroy(&first);
        tulle_mesh_destroy(&second);
    }
}

static void expect_refusal(const tulle_shape_def *def, tulle_status expected, const char *words) {
    tulle_error error = {0};
    tulle_mesh mesh;
    tulle_status const status = tulle_shape_generate(def, &mesh, &error);
    if (status != expected || !strstr(error.message, words))
        fail_msg("%s: status %d, '%s', expected %d '%s'", tulle_shape_name(def->shape), (int)status,
                 error.message, (int)expected, words);
    assert_null(mesh.positions);
    assert_null(mesh.triangles);
}

static void too_many_vertices_are_refused_at_once(void **state) {
    (void)state;
    tulle_shape_def def = tulle_shape_def_default(TULLE_SHAPE_RECTANGLE);
    def.resolution[0] = def.resolution[1] = 1000000;
    expect_refusal(&def, TULLE_ERROR_LIMIT, "1000000000000 vertices; the limit is 10000000");
    for (int shape = 0; shape < TULLE_SHAPE_COUNT; shape++) {
        if (shape == TULLE_SHAPE_TETRAHEDRON) continue;
        for (int k = 0; k < 3; k++) {
            def = tulle_shape_def_default((tulle_shape)shape);
            def.resolution[0] = k == 1 ? 4 : UINT32_MAX;
            def.resolution[1] = k == 0 ? 4 : UINT32_MAX;
            if (shape == TULLE_SHAPE_NET) def.strand_resolution = UINT32_MAX;
            if (k == 1 && (shape == TULLE_SHAPE_SPHERE || shape == TULLE_SHAPE_BOX)) continue;
            shape_clear_unused(&def);
            expect_refusal(&def, TULLE_ERROR_LIMIT, "limit is 10000000");
        }
    }
    def = tulle_shape_def_default(TULLE_SHAPE_BUMPY_GROUND);
    def.wavelength = 1e-6;
    expect_refusal(&def, TULLE_ERROR_LIMIT, "limit is 10000000");
    def = tulle_shape_def_default(TULLE_SHAPE_NET);
    def.cells[0] = def.cells[1] = UINT32_MAX;
    def.size[0] = def.size[1] = 1e6;
    def.strand = 1e-6;
    def.strand_resolution = 1;
    expect_refusal(&def, TULLE_ERROR_LIMIT, "limit is 10000000");
}

/* A net of wide holes takes the time of its vertices, not of its outline. */
static void wide_holes_are_quick(void **state) {
    (void)state;
    tulle_shape_def def = tulle_shape_def_default(TULLE_SHAPE_NET);
    def.cells[0] = def.cells[1] = 1;
    def.strand = 1e-5;
    def.strand_resolution = 1;
    tulle_mesh mesh;
    generate(&def, &mesh);
    assert_int_equal(mesh.vertex_count, 8 * 99999);
    tulle_mesh_destroy(&mesh);
}

static void bad_values_are_named(void **state) {
    (void)state;
    double const bad[] = {-1.0, NAN, INFINITY, 1e-7, 2e6};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        tulle_shape_def def = tulle_shape_def_default(TULLE_SHAPE_RECTANGLE);
        def.size[1] = bad[i];
        expect_refusal(&def, TULLE_ERROR_INVALID_ARGUMENT, "rectangle: size[1] is ");
        def = tulle_shape_def_default(TULLE_SHAPE_TILE);
        def.size[2] = bad[i];
        expect_refusal(&def, TULLE_ERROR_INVALID_ARGUMENT, "tile: size[2] is ");
        def = tulle_shape_def_default(TULLE_SHAPE_NAIL);
        def.head_height = bad[i];
        expect_refusal(&def, TULLE_ERROR_INVALID_ARGUMENT, "nail: head_height is ");
        def = tulle_shape_def_default(TULLE_SHAPE_CAPE);
        def.angle = i == 3 ? 0.0 : i == 4 ? 6.3 : bad[i];
        expect_refusal(&def, TULLE_ERROR_INVALID_ARGUMENT, "cape: angle is ");
    }
    tulle_shape_def def = tulle_shape_def_default(TULLE_SHAPE_TORUS);
    def.inner_radius = def.radius;
    expect_refusal(&def, TULLE_ERROR_INVALID_ARGUMENT, "inner_radius is 0.4 m; it must be less");
    def.inner_radius = 0.1;
    def.resolution[1] = 2;
    expect_refusal(&def, TULLE_ERROR_INVALID_ARGUMENT, "resolution[1] is 2; ");
    def = tulle_shape_def_default(TULLE_SHAPE_NET);
    def.strand = 0.2;
    expect_refusal(&def, TULLE_ERROR_INVALID_ARGUMENT, "9 strands of 0.2 m fill 1.8 m");
    def.cells[1] = 0;
    expect_refusal(&def, TULLE_ERROR_INVALID_ARGUMENT, "cells[1] is 0");
    def = tulle_shape_def_default(TULLE_SHAPE_NEEDLE);
    def.tip_height = 1.0;
    expect_refusal(&def, TULLE_ERROR_INVALID_ARGUMENT, "tip_height is 1 m");
    def.radius = 1e-6;
    def.height = 1e6;
    expect_refusal(&def, TULLE_ERROR_INVALID_ARGUMENT, "needle: ");
    def.cookie++;
    expect_refusal(&def, TULLE_ERROR_INVALID_ARGUMENT, "tulle_shape_def_default");
    def = tulle_shape_def_default(TULLE_SHAPE_COUNT);
    assert_int_equal(tulle_shape_generate(&def, NULL, NULL), TULLE_ERROR_INVALID_ARGUMENT);
}

typedef struct unused_field {
    const char *name;
    size_t offset;
    char kind; /* double, uint32_t, uint64_t, int */
} unused_field;

static void set_field(tulle_shape_def *def, const unused_field *field) {
    char *const at = (char *)def + field->offset;
    if (field->kind == 'd') *(double *)(void *)at = 0.23;
    if (field->kind == 'u') *(uint32_t *)(void *)at = 50;
    if (field->kind == 's') *(uint64_t *)(void *)at = 5;
    if (field->kind == 'i') *(int *)(void *)at = 1;
}

static bool is_same_mesh(const tulle_mesh *a, const tulle_mesh *b) {
    return a->vertex_count == b->vertex_count && a->triangle_count == b->triangle_count &&
           memcmp(a->positions, b->positions, 24 * a->vertex_count) == 0 &&
           memcmp(a->triangles, b->triangles, 12 * a->triangle_count) == 0;
}

/* Of each shape, each field: it changes the mesh or it is refused by name. */
static void nothing_is_ignored(void **state) {
    (void)state;
#define UNUSED(field, kind) {#field, offsetof(tulle_shape_def, field), kind}
    unused_field const fields[] = {UNUSED(size[0], 'd'),
                                   UNUSED(size[1], 'd'),
                                   UNUSED(size[2], 'd'),
                                   UNUSED(radius, 'd'),
                                   UNUSED(inner_radius, 'd'),
                                   UNUSED(height, 'd'),
                                   UNUSED(tip_height, 'd'),
                                   UNUSED(head_radius, 'd'),
                                   UNUSED(head_height, 'd'),
                                   UNUSED(angle, 'd'),
                                   UNUSED(strand, 'd'),
                                   UNUSED(wavelength, 'd'),
                                   UNUSED(resolution[0], 'u'),
                                   UNUSED(resolution[1], 'u'),
                                   UNUSED(cells[0], 'u'),
                                   UNUSED(cells[1], 'u'),
                                   UNUSED(strand_resolution, 'u'),
                                   UNUSED(is_irregular, 'i'),
                                   UNUSED(seed, 's')};
#undef UNUSED
    size_t refused_count = 0;
    for (int shape = 0; shape < TULLE_SHAPE_COUNT; shape++) {
        tulle_shape_def const plain = tulle_shape_def_default((tulle_shape)shape);
        for (size_t i = 0; i < sizeof fields / sizeof fields[0]; i++) {
            tulle_shape_def before = plain, def;
            /* The seed of cloth is that of irregular cloth. */
            if (fields[i].kind == 's') before.is_irregular = tulle_shape_is_cloth(plain.shape);
            def = before;
            set_field(&def, &fields[i]);
            char words[80];
            snprintf(words, sizeof words, "%s: %s does not apply to this shape; it takes ",
                     tulle_shape_name(plain.shape), fields[i].name);
            tulle_error error = {0};
            tulle_mesh mesh, usual;
            tulle_status const status = tulle_shape_generate(&def, &mesh, &error);
            if (status == TULLE_OK) {
                generate(&before, &usual);
                if (is_same_mesh(&mesh, &usual)) fail_msg("%s is ignored", words);
                tulle_mesh_destroy(&usual);
                tulle_mesh_destroy(&mesh);
            } else if (strstr(error.message, "does not apply")) {
                expect_refusal(&def, TULLE_ERROR_INVALID_ARGUMENT, words);
                refused_count++;
            }
        }
    }
    assert_int_equal(refused_count, 277); /* of 20 shapes with 19 fields, 103 apply */
    tulle_shape_def def = tulle_shape_def_default(TULLE_SHAPE_SPHERE);
    def.resolution[0] = 24, def.resolution[1] = 12;
    expect_refusal(&def, TULLE_ERROR_INVALID_ARGUMENT,
                   "sphere: resolution[1] does not apply to this shape; it takes radius, "
                   "resolution[0]");
    tulle_mesh once, twice;
    def.resolution[0] = def.resolution[1] = 3;
    generate(&def, &twice);
    def.resolution[1] = 0;
    generate(&def, &once);
    assert_true(is_same_mesh(&once, &twice));
    tulle_mesh_destroy(&once);
    tulle_mesh_destroy(&twice);
}

/* A sceptre's ball is round: its rings lie on a sphere of head_radius, the last on the leg; above
 * the leg the volumes of the frustums of its rows add up. */
static void sceptre_has_a_ball_on_a_leg(void **state) {
    (void)state;
    tulle_shape_def def = tulle_shape_def_default(TULLE_SHAPE_SCEPTRE);
    def.radius = 0.03, def.head_radius = 0.1, def.height = 0.7;
    def.resolution[0] = 12, def.resolution[1] = 5;
    tulle_mesh mesh;
    generate(&def, &mesh);
    double const centre = 0.6, neck = centre - sqrt(0.1 * 0.1 - 0.03 * 0.03);
    assert_int_equal(mesh.vertex_count, 2 + 12 * (6 - 1 + 5));
    double volume = 0.0, above[2] = {0.0, 0.7}; /* radius and height of the ring before */
    for (size_t v = 1; v + 1 < mesh.vertex_count; v += 12) {
        for (size_t k = v; k < v + 12; k++) {
            vec3 const at = vec3_load(mesh.positions, k);
            double const radius = hypot(at.x, at.y);
            if (at.z >= neck) expect_near(hypot(radius, at.z - centre), 0.1, 1e-12);
            if (at.z <= neck) expect_near(radius, 0.03, 1e-12);
        }
        vec3 const at = vec3_load(mesh.positions, v);
        double const radius = hypot(at.x, at.y);
        volume +=
            (above[1] - at.z) / 3.0 * (above[0] * above[0] + above[0] * radius + radius * radius);
        above[0] = radius, above[1] = at.z;
    }
    assert_true(above[1] == 0.0);
    expect_near(measure_volume(&mesh), polygon_area(12) * volume, 1e-12);
    tulle_mesh_destroy(&mesh);
    def.head_radius = 0.02;
    expect_refusal(&def, TULLE_ERROR_INVALID_ARGUMENT, "radius is 0.03 m; it must be less");
    def.head_radius = 0.4;
    expect_refusal(&def, TULLE_ERROR_INVALID_ARGUMENT, "must be less than half of height");
}

/* A full turn is sewn up, a hair less is not. */
static void full_cape_is_an_annulus(void **state) {
    (void)state;
    tulle_shape_def def = tulle_shape_def_default(TULLE_SHAPE_CAPE);
    def.angle = 2.0 * PI;
    tulle_mesh mesh;
    generate(&def, &mesh);
    assert_int_equal(expect_manifold(&mesh, def.shape).boundary_loop_count, 2);
    tulle_mesh_destroy(&mesh);
    def.angle = 2.0 * PI - 1e-3;
    generate(&def, &mesh);
    assert_int_equal(expect_manifold(&mesh, def.shape).boundary_loop_count, 1);
    tulle_mesh_destroy(&mesh);
}

/* Log-uniform. */
static double random_length(uint64_t *random) {
    return pow(10.0, -3.0 + 4.0 * random_uniform(random));
}

static void random_parameters_give_manifolds_or_errors(void **state) {
    (void)state;
    uint64_t random = 23;
    int made_count = 0;
    for (int round = 0; round < 3000; round++) {
        tulle_shape_def def = tulle_shape_def_default((tulle_shape)(round % TULLE_SHAPE_COUNT));
        for (int k = 0; k < 3; k++) def.size[k] = random_length(&random);
        def.radius = random_length(&random);
        def.height = random_length(&random);
        if (round % 3) def.inner_radius = def.radius * random_uniform(&random);
        if (round % 5) def.tip_height = def.height * random_uniform(&random);
        if (round % 7) def.head_radius = def.radius * (1.0 + random_uniform(&random));
        def.angle = 2.0 * PI * random_uniform(&random);
        def.wavelength = def.size[0] * (0.02 + random_uniform(&random));
        for (int k = 0; k < 2; k++) {
            def.resolution[k] = (uint32_t)(random_next(&random) % 24);
            def.cells[k] = 1 + (uint32_t)(random_next(&random) % 5);
        }
        def.strand_resolution = 1 + (uint32_t)(random_next(&random) % 4);
        def.is_irregular = round % 2;
        def.seed = (uint64_t)round;
        /* Left to the shape, long and thin things would get very many vertices. */
        for (int k = 0; k < 2; k++)
            if (def.resolution[k] == 0) def.resolution[k] = 5;
        if (def.shape == TULLE_SHAPE_NET)
            def.size[1] = def.size[0] * (1.0 + random_uniform(&random));
        shape_clear_unused(&def);
        tulle_mesh mesh;
        tulle_error error = {0};
        tulle_status const status = tulle_shape_generate(&def, &mesh, &error);
        if (status == TULLE_OK) {
            tulle_mesh_info const info = expect_manifold(&mesh, def.shape);
            assert_int_equal(info.boundary_loop_count, expected_loops(&def));
            if (expected_loops(&def) == 0) assert_true(measure_volume(&mesh) > 0.0);
            made_count++;
        } else if (status != TULLE_OK) {
            assert_true(error.message[0] != 0);
            assert_null(mesh.positions);
        }
        tulle_mesh_destroy(&mesh);
    }
    assert_true(made_count > 2000);
}

static void jitter_survives_failing_allocations(void **state) {
    (void)state;
    tulle_shape_def const def = tulle_shape_def_default(TULLE_SHAPE_RECTANGLE);
    tulle_mesh mesh;
    generate(&def, &mesh);
    for (int k = 0;; k++) {
        assert_true(k < 100);
        int left = k;
        memory heap = failing_heap_make(&left);
        tulle_status const status = shape_jitter(&heap, &def, &mesh, NULL);
        assert_int_equal(heap.bytes_held, 0);
        if (status == TULLE_OK) break;
        assert_int_equal(status, TULLE_ERROR_OUT_OF_MEMORY);
    }
    tulle_mesh_destroy(&mesh);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(defaults_are_manifold_with_right_measures),
        cmocka_unit_test(names_are_distinct),
        cmocka_unit_test(places_are_as_documented),
        cmocka_unit_test(small_ones_do_not_intersect),
        cmocka_unit_test(judge_finds_no_intersection),
        cmocka_unit_test(irregular_keeps_outline_and_area),
        cmocka_unit_test(seeds_matter),
        cmocka_unit_test(too_many_vertices_are_refused_at_once),
        cmocka_unit_test(wide_holes_are_quick),
        cmocka_unit_test(bad_values_are_named),
        cmocka_unit_test(nothing_is_ignored),
        cmocka_unit_test(sceptre_has_a_ball_on_a_leg),
        cmocka_unit_test(full_cape_is_an_annulus),
        cmocka_unit_test(random_parameters_give_manifolds_or_errors),
        cmocka_unit_test(jitter_survives_failing_allocations),
    };
    return cmocka_run_group_tests_name("geom.shapes", tests, NULL, NULL);
}
