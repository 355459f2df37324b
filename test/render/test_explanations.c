/* What pictures explain cloth by: rest coordinates against isometry and closed forms, strains
 * against closed forms, gaps against all pairs. */
#include "base/hash.h"
#include "render/rest_coordinates.h"
#include "render/strain.h"
#include "render/surface_gap.h"

#include "tulle/mesh.h"
#include "tulle/shapes.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static double measure(const double *a, const double *b, int count) {
    double sum = 0.0;
    for (int k = 0; k < count; k++) sum += (a[k] - b[k]) * (a[k] - b[k]);
    return sqrt(sum);
}

/* A grid of (columns + 1) x (rows + 1) vertices, 1 m by 1 m in the plane z = 0. */
static tulle_mesh make_grid(size_t columns, size_t rows) {
    tulle_mesh mesh = {0};
    assert_int_equal(tulle_mesh_create((columns + 1) * (rows + 1), 2 * columns * rows, &mesh, NULL),
                     TULLE_OK);
    for (size_t i = 0; i < mesh.vertex_count; i++) {
        mesh.positions[3 * i] = (double)(i % (columns + 1)) / (double)columns;
        mesh.positions[3 * i + 1] = (double)(i / (columns + 1)) / (double)rows;
        mesh.positions[3 * i + 2] = 0.0;
    }
    for (size_t i = 0; i < columns * rows; i++) {
        uint32_t const a = (uint32_t)(i / columns * (columns + 1) + i % columns);
        uint32_t const c = a + (uint32_t)columns + 1;
        uint32_t const corners[6] = {a, a + 1, c + 1, a, c + 1, c};
        memcpy(mesh.triangles + 6 * i, corners, sizeof corners);
    }
    return mesh;
}

static const double no_scale[3] = {1, 1, 1}, no_move[3] = {0, 0, 0};

/* Largest difference between the length of an edge in space and in the coordinates. */
static double find_distortion(const tulle_mesh *mesh, const double *coordinates) {
    double worst = 0.0;
    for (size_t i = 0; i < 3 * mesh->triangle_count; i++) {
        uint32_t const a = mesh->triangles[i];
        uint32_t const b = mesh->triangles[i - i % 3 + (i + 1) % 3];
        double const length = measure(mesh->positions + 3 * a, mesh->positions + 3 * b, 3);
        double const flat = measure(coordinates + 2 * a, coordinates + 2 * b, 2);
        worst = fmax(worst, fabs(length - flat));
    }
    return worst;
}

static void test_flat_cloth(void **state) {
    (void)state;
    /* However it hangs in space: isometric, and its borders along the axes. */
    static const double turns[3][4] = {{1, 0, 0, 0}, {0.6, 0, 0, 0.8}, {0.5, 0.1, 0.7, 0.5}};
    for (int i = 0; i < 3; i++) {
        tulle_mesh mesh = make_grid(9, 7);
        tulle_mesh_transform(&mesh, no_scale, turns[i], no_move);
        double coordinates[160];
        memory heap = memory_default();
        assert_int_equal(
            render_make_rest_coordinates(&heap, tulle_mesh_get_view(&mesh), coordinates, NULL),
            TULLE_OK);
        assert_int_equal(heap.bytes_held, 0);
        assert_true(find_distortion(&mesh, coordinates) < 1e-12);
        double const across = fabs(coordinates[2] - coordinates[0]);
        double const along = fabs(coordinates[3] - coordinates[1]);
        assert_true(fmin(across, along) < 1e-12 && fabs(fmax(across, along) - 1.0 / 9) < 1e-12);
        /* Counter-clockwise stays so: diagonals tell a mirror image by the sign of the area. */
        const double *const c = coordinates;
        double const area = (c[2] - c[0]) * (c[21] - c[1]) - (c[3] - c[1]) * (c[20] - c[0]);
        assert_true(area > 0.0);
        tulle_mesh_destroy(&mesh);
    }
}

static void test_fine_irregular_cloth(void **state) {
    (void)state;
    /* Rounding does not grow from triangle to triangle. */
    tulle_mesh mesh = make_grid(150, 150);
    uint64_t seed = 5;
    for (size_t i = 0; i < mesh.vertex_count; i++)
        for (size_t k = 0; k < 2; k++)
            mesh.positions[3 * i + k] += 0.002 * (random_uniform(&seed) - 0.5);
    static const double turn[4] = {0.5, 0.1, 0.7, 0.5};
    tulle_mesh_transform(&mesh, no_scale, turn, no_move);
    double *const coordinates = calloc(2 * mesh.vertex_count, sizeof *coordinates);
    assert_non_null(coordinates);
    memory heap = memory_default();
    assert_int_equal(
        render_make_rest_coordinates(&heap, tulle_mesh_get_view(&mesh), coordinates, NULL),
        TULLE_OK);
    assert_true(find_distortion(&mesh, coordinates) < 1e-11);
    free(coordinates);
    tulle_mesh_destroy(&mesh);
}

static void test_rolled_cloth(void **state) {
    (void)state;
    /* Three quarters of a cylinder, a prism of flat strips: developable, so isometric all over. */
    tulle_mesh mesh = make_grid(30, 5);
    for (size_t i = 0; i < mesh.vertex_count; i++) {
        double const angle = 4.7 * mesh.positions[3 * i];
        mesh.positions[3 * i] = 0.3 * cos(angle);
        mesh.positions[3 * i + 2] = 0.3 * sin(angle);
    }
    double coordinates[2 * 31 * 6];
    memory heap = memory_default();
    assert_int_equal(
        render_make_rest_coordinates(&heap, tulle_mesh_get_view(&mesh), coordinates, NULL),
        TULLE_OK);
    assert_true(find_distortion(&mesh, coordinates) < 1e-12);
    tulle_mesh_destroy(&mesh);
}

static void test_bent_cloth(void **state) {
    (void)state;
    /* Waves that no plane can take without stretch, fine enough that errors could pile up: all
     * stays within the extent that the lengths allow. */
    tulle_mesh mesh = make_grid(120, 120);
    for (size_t i = 0; i < mesh.vertex_count; i++) {
        double *const x = mesh.positions + 3 * i;
        x[2] = 0.05 * sin(30.0 * x[0]) * cos(25.0 * x[1]);
    }
    double *const coordinates = calloc(2 * mesh.vertex_count, sizeof *coordinates);
    assert_non_null(coordinates);
    memory heap = memory_default();
    assert_int_equal(
        render_make_rest_coordinates(&heap, tulle_mesh_get_view(&mesh), coordinates, NULL),
        TULLE_OK);
    for (size_t i = 0; i < 2 * mesh.vertex_count; i++) assert_true(fabs(coordinates[i]) < 5.0);
    free(coordinates);
    tulle_mesh_destroy(&mesh);
}

static void test_pieces(void **state) {
    (void)state;
    tulle_mesh mesh = make_grid(3, 2); /* without its second column: two pieces */
    size_t kept = 0;
    for (size_t t = 0; t < 12; t++)
        if (t / 2 % 3 != 1) {
            memmove(mesh.triangles + 3 * kept++, mesh.triangles + 3 * t, 3 * sizeof(uint32_t));
        }
    mesh.triangle_count = kept;
    uint32_t pieces[12];
    size_t count = 0;
    memory heap = memory_default();
    assert_int_equal(render_find_pieces(&heap, tulle_mesh_get_view(&mesh), pieces, &count, NULL),
                     TULLE_OK);
    assert_int_equal(count, 2);
    for (size_t t = 0; t < kept; t++) assert_int_equal(pieces[t], t / 2 % 2);
    mesh.triangle_count = 12;
    tulle_mesh_destroy(&mesh);
    /* Memory that is short is told. */
    mesh = make_grid(3, 2);
    tulle_allocator small = {.byte_limit = 1};
    memory short_heap = {.allocator = small};
    double coordinates[24];
    assert_int_equal(
        render_make_rest_coordinates(&short_heap, tulle_mesh_get_view(&mesh), coordinates, NULL),
        TULLE_ERROR_OUT_OF_MEMORY);
    tulle_mesh_destroy(&mesh);
}

/* ---- strains ---- */

static void assert_stretches(const double now[9], double most, double least) {
    static const double rest[9] = {0, 0, 0, 2, 0, 0, 0.5, 1, 0};
    double stretches[2];
    render_get_stretches(rest, now, stretches);
    if (fabs(stretches[0] - most) > 1e-12 || fabs(stretches[1] - least) > 1e-12)
        fail_msg("stretches %.15g %.15g, not %.15g %.15g", stretches[0], stretches[1], most, least);
}

static void test_stretches(void **state) {
    (void)state;
    /* Moved and turned about x by 3-4-5: none. */
    assert_stretches((double[]){5, 1, 2, 7, 1, 2, 5.5, 1.6, 2.8}, 1.0, 1.0);
    /* A fifth longer along x. */
    assert_stretches((double[]){0, 0, 0, 2.4, 0, 0, 0.6, 1, 0}, 1.2, 1.0);
    /* Half as wide along y. */
    assert_stretches((double[]){0, 0, 0, 2, 0, 0, 0.5, 0, 0.5}, 1.0, 0.5);
    /* Simple shear by 1: (1 + sqrt 5) / 2 and its inverse. */
    double const golden = 0.5 * (1.0 + sqrt(5.0));
    assert_stretches((double[]){0, 0, 0, 2, 0, 0, 1.5, 1, 0}, golden, 1.0 / golden);
    /* Flattened to a line, and to a point. */
    assert_stretches((double[]){0, 0, 0, 2, 0, 0, 0.5, 0, 0}, 1.0, 0.0);
    assert_stretches((double[]){1, 1, 1, 1, 1, 1, 1, 1, 1}, 0.0, 0.0);
    /* No area at rest. */
    double stretches[2];
    render_get_stretches((double[]){0, 0, 0, 1, 0, 0, 2, 0, 0}, (double[9]){0}, stretches);
    assert_true(isnan(stretches[0]) && isnan(stretches[1]));
}

static void test_vertex_strains(void **state) {
    (void)state;
    /* x -> x + x^2 / 20: the strain is x / 10, that of a column's middle in each triangle. */
    tulle_mesh mesh = make_grid(40, 2);
    double now[3 * 41 * 3], strains[41 * 3], areas[41 * 3];
    memcpy(now, mesh.positions, sizeof now);
    for (size_t i = 0; i < mesh.vertex_count; i++) now[3 * i] += 0.05 * now[3 * i] * now[3 * i];
    render_get_vertex_strains(tulle_mesh_get_view(&mesh), now, strains, areas);
    for (size_t i = 42; i < 81; i++) /* the middle row without its ends */
        assert_true(fabs(strains[i] - 0.1 * mesh.positions[3 * i]) < 1e-12);
    /* Compression is negative. */
    for (size_t i = 0; i < mesh.vertex_count; i++) now[3 * i] = 0.75 * mesh.positions[3 * i];
    render_get_vertex_strains(tulle_mesh_get_view(&mesh), now, strains, areas);
    for (size_t i = 0; i < mesh.vertex_count; i++) assert_true(fabs(strains[i] + 0.25) < 1e-12);
    tulle_mesh_destroy(&mesh);
}

/* ---- gaps ---- */

/* All triangles, one after the other. */
static double find_gap_plainly(const render_gap_surface *surfaces, size_t count, size_t surface,
                               uint32_t vertex, uint32_t piece, double farthest) {
    const render_gap_surface *const own = &surfaces[surface];
    double best = farthest;
    for (size_t i = 0; i < count; i++) {
        for (size_t t = 0; t < surfaces[i].mesh.triangle_count; t++) {
            const uint32_t *const corners = surfaces[i].mesh.triangles + 3 * t;
            bool const is_own = i == surface && own->pieces[t] == piece;
            if (is_own && (corners[0] == vertex || corners[1] == vertex || corners[2] == vertex))
                continue;
            double now[9], weights[3], place[3] = {0};
            for (size_t k = 0; k < 9; k++)
                now[k] = surfaces[i].mesh.positions[3 * corners[k / 3] + k % 3];
            double const distance =
                render_get_triangle_distance(own->mesh.positions + 3 * vertex, now, weights);
            for (size_t k = 0; k < 9 && is_own; k++)
                place[k % 3] += weights[k / 3] * own->rest[3 * corners[k / 3] + k % 3];
            if (is_own && !(distance < 0.5 * measure(place, own->rest + 3 * vertex, 3))) continue;
            best = fmin(best, distance);
        }
    }
    return best;
}

static void crumple(tulle_mesh *mesh, uint64_t seed, double height) {
    for (size_t i = 0; i < mesh->vertex_count; i++) {
        double *const x = mesh->positions + 3 * i;
        double const u = x[0], v = x[1];
        x[0] = 0.15 * sin(9.0 * u) + 0.05 * u + 0.01 * random_uniform(&seed);
        x[1] = 0.4 * v + 0.1 * cos(7.0 * v) + 0.01 * random_uniform(&seed);
        x[2] = height + 0.1 * cos(9.0 * u + v) + 0.01 * random_uniform(&seed);
    }
}

static void test_gaps_against_all_pairs(void **state) {
    (void)state;
    tulle_mesh meshes[3] = {make_grid(23, 17), make_grid(11, 13), make_grid(4, 4)};
    double *rests[2];
    uint32_t *pieces[2];
    render_gap_surface surfaces[3];
    memory heap = memory_default();
    for (size_t i = 0; i < 3; i++) {
        if (i == 1) { /* two pieces */
            memmove(meshes[i].triangles + 66, meshes[i].triangles + 132,
                    (3 * meshes[i].triangle_count - 132) * sizeof(uint32_t));
            meshes[i].triangle_count -= 22;
        }
        surfaces[i] = (render_gap_surface){.mesh = tulle_mesh_get_view(&meshes[i])};
        if (i == 2) continue;
        size_t const bytes = 3 * meshes[i].vertex_count * sizeof(double);
        rests[i] = malloc(bytes);
        pieces[i] = calloc(meshes[i].triangle_count, sizeof(uint32_t));
        assert_true(rests[i] && pieces[i]);
        memcpy(rests[i], meshes[i].positions, bytes);
        assert_int_equal(
            render_find_pieces(&heap, surfaces[i].mesh, pieces[i], &surfaces[i].piece_count, NULL),
            TULLE_OK);
        surfaces[i].rest = rests[i];
        surfaces[i].pieces = pieces[i];
    }
    assert_int_equal(surfaces[0].piece_count, 1);
    assert_int_equal(surfaces[1].piece_count, 2);
    for (size_t i = 0; i < 2; i++) crumple(&meshes[i], i + 1, 0.06 * (double)i);
    double first[24 * 18], second[12 * 14], again[24 * 18];
    double *gaps[3] = {first, second, NULL}, *gaps_again[3] = {again, second, NULL};
    assert_int_equal(render_measure_gaps(&heap, &(render_gap_def){surfaces, 3, 0.1, 2}, gaps, NULL),
                     TULLE_OK);
    assert_int_equal(
        render_measure_gaps(&heap, &(render_gap_def){surfaces, 3, 0.1, 1}, gaps_again, NULL),
        TULLE_OK);
    assert_memory_equal(first, again, sizeof first);
    assert_int_equal(heap.bytes_held, 0);
    size_t far_count = 0, own_count = 0;
    for (size_t i = 0; i < 2; i++) {
        for (uint32_t vertex = 0; vertex < meshes[i].vertex_count; vertex++) {
            uint32_t piece = TULLE_NONE;
            for (size_t k = 0; k < 3 * meshes[i].triangle_count; k++)
                if (meshes[i].triangles[k] == vertex) piece = pieces[i][k / 3];
            double const wanted = find_gap_plainly(surfaces, 3, i, vertex, piece, 0.1);
            assert_true(gaps[i][vertex] == wanted);
            far_count += wanted == 0.1;
            own_count += find_gap_plainly(surfaces + i, 1, 0, vertex, piece, 0.1) == wanted;
        }
    }
    /* The scene tests what it should: some see nothing, some themselves, some others. */
    assert_true(own_count > 20 + far_count && own_count < 580);
    for (size_t i = 0; i < 2; i++) {
        free(rests[i]);
        free(pieces[i]);
    }
    meshes[1].triangle_count += 22;
    for (size_t i = 0; i < 3; i++) tulle_mesh_destroy(&meshes[i]);
}

static void test_flat_sheet_over_ground(void **state) {
    (void)state;
    /* A flat sheet does not see itself; over ground it sees its height. */
    tulle_mesh sheet = make_grid(10, 10), ground = make_grid(1, 1);
    for (size_t i = 0; i < sheet.vertex_count; i++) sheet.positions[3 * i + 2] = 0.007;
    uint32_t pieces[200] = {0};
    double gaps[121];
    double *all[2] = {gaps, NULL};
    render_gap_surface const surfaces[2] = {{.mesh = tulle_mesh_get_view(&sheet),
                                             .rest = sheet.positions,
                                             .pieces = pieces,
                                             .piece_count = 1},
                                            {.mesh = tulle_mesh_get_view(&ground)}};
    memory heap = memory_default();
    assert_int_equal(render_measure_gaps(&heap, &(render_gap_def){surfaces, 1, 0.1, 1}, all, NULL),
                     TULLE_OK);
    for (size_t i = 0; i < 121; i++) assert_true(gaps[i] == 0.1);
    assert_int_equal(render_measure_gaps(&heap, &(render_gap_def){surfaces, 2, 0.1, 1}, all, NULL),
                     TULLE_OK);
    for (size_t i = 0; i < 121; i++) assert_true(fabs(gaps[i] - 0.007) < 1e-15);
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&ground);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_flat_cloth),
        cmocka_unit_test(test_fine_irregular_cloth),
        cmocka_unit_test(test_rolled_cloth),
        cmocka_unit_test(test_bent_cloth),
        cmocka_unit_test(test_pieces),
        cmocka_unit_test(test_stretches),
        cmocka_unit_test(test_vertex_strains),
        cmocka_unit_test(test_gaps_against_all_pairs),
        cmocka_unit_test(test_flat_sheet_over_ground),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
