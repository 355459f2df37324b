/* Loop subdivision: connections, one level against masks applied by search, rules of odd meshes,
 * errors and failing memory. Limits and eigenvalues have a program of their own. */
#include "subdivision/subdivision_support.h"

#include "tulle_io/subdivision.h"

static tulle_mesh_info get_info(tulle_mesh_view mesh) {
    tulle_mesh_info info;
    assert_int_equal(tulle_mesh_get_info(mesh, &info, NULL), TULLE_OK);
    return info;
}

/* Pieces, holes, handles and the number of edges on the border are those of the mesh. */
static void expect_same_topology(tulle_mesh_view mesh, const tulle_mesh *result, int levels) {
    tulle_mesh_info const before = get_info(mesh), after = get_info(tulle_mesh_get_view(result));
    assert_int_equal(after.triangle_count, before.triangle_count << (2 * levels));
    assert_int_equal(after.euler_characteristic, before.euler_characteristic);
    assert_int_equal(after.component_count, before.component_count);
    assert_int_equal(after.boundary_loop_count, before.boundary_loop_count);
    assert_int_equal(after.boundary_edge_count, before.boundary_edge_count << levels);
    assert_int_equal(after.nonmanifold_edge_count, before.nonmanifold_edge_count << levels);
    assert_int_equal(after.unreferenced_vertex_count, before.unreferenced_vertex_count);
    assert_int_equal(after.degenerate_triangle_count, 0);
}

/* Every shape, cloths (one with holes) also jittered: the result is a cloth as the shape was, so
 * its orientation is consistent too. */
static void topology_is_kept(void **state) {
    (void)state;
    for (int shape = 0; shape < 2 * TULLE_SHAPE_COUNT; shape++) {
        bool const is_irregular = shape >= TULLE_SHAPE_COUNT;
        if (is_irregular && shape % TULLE_SHAPE_COUNT > TULLE_SHAPE_NET) continue;
        tulle_mesh mesh = make_shape((tulle_shape)(shape % TULLE_SHAPE_COUNT), is_irregular);
        for (int levels = 1; levels <= 2; levels++) {
            tulle_subdivision_def def = tulle_subdivision_def_default();
            def.levels = levels;
            tulle_mesh result = subdivide(tulle_mesh_get_view(&mesh), &def);
            expect_same_topology(tulle_mesh_get_view(&mesh), &result, levels);
            tulle_error error = {0};
            if (tulle_mesh_validate(tulle_mesh_get_view(&result), TULLE_MESH_ROLE_CLOTH, &error) !=
                TULLE_OK)
                fail_msg("shape %d: %s", shape, error.message);
            tulle_mesh_destroy(&result);
        }
        tulle_mesh_destroy(&mesh);
    }
}

/* Two sheets in one mesh with a vertex of no triangle between them. */
static void pieces_and_lone_vertices_are_kept(void **state) {
    (void)state;
    double const x[27] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 7, 8,
                          9, 0, 0, 1, 1, 0, 1, 1, 1, 1, 0, 1, 1};
    const uint32_t t[12] = {0, 1, 2, 0, 2, 3, 5, 6, 7, 5, 7, 8};
    tulle_mesh_view const mesh = {x, 9, t, 4};
    tulle_subdivision_def def = tulle_subdivision_def_default();
    def.levels = 3;
    tulle_mesh result = subdivide(mesh, &def);
    expect_same_topology(mesh, &result, 3);
    for (size_t k = 0; k < 3; k++) assert_true(result.positions[12 + k] == x[12 + k]);
    /* Each piece stays in its own plane; the corners of both stay where they are. */
    for (size_t v = 0; v < 9; v++)
        for (size_t k = 0; k < 3; k++) assert_true(result.positions[3 * v + k] == x[3 * v + k]);
    for (size_t v = 9; v < result.vertex_count; v++) {
        double const z = result.positions[3 * v + 2];
        assert_true(fabs(z) < 1e-15 || fabs(z - 1.0) < 1e-15);
    }
    tulle_mesh_destroy(&result);
    /* Nothing at all is subdivided into nothing. */
    tulle_mesh_view const nothing = {NULL, 0, NULL, 0};
    result = subdivide(nothing, &def);
    assert_int_equal(result.vertex_count, 0);
    assert_int_equal(result.triangle_count, 0);
}

/* The triangles that name a triangle as their parent hold exactly its corners of the old vertices.
 */
static void parents_are_named(void **state) {
    (void)state;
    tulle_mesh mesh = make_shape(TULLE_SHAPE_TORUS, false);
    tulle_subdivision_def def = tulle_subdivision_def_default();
    def.levels = 3;
    tulle_subdivision *const made = make_operator(tulle_mesh_get_view(&mesh), &def);
    const uint32_t *const triangles = tulle_subdivision_get_triangles(made);
    uint32_t *const counts = calloc(4 * mesh.triangle_count, sizeof *counts);
    assert_non_null(counts);
    for (uint32_t t = 0; t < tulle_subdivision_get_triangle_count(made); t++) {
        uint32_t const parent = tulle_subdivision_get_parent_triangle(made, t);
        assert_true(parent < mesh.triangle_count);
        counts[4 * parent + 3]++;
        for (size_t k = 0; k < 3; k++) {
            uint32_t const vertex = triangles[3 * (size_t)t + k];
            if (vertex >= mesh.vertex_count) continue;
            size_t corner = 0;
            while (corner < 3 && mesh.triangles[3 * parent + corner] != vertex) corner++;
            assert_true(corner < 3);
            counts[4 * parent + corner]++;
        }
    }
    for (size_t i = 0; i < 4 * mesh.triangle_count; i++)
        assert_int_equal(counts[i], i % 4 == 3 ? 64 : 1);
    free(counts);
    tulle_subdivision_destroy(made);
    tulle_mesh_destroy(&mesh);
}

/* How many triangles have both vertices, for every pair; release with free. */
static uint32_t *count_shared(tulle_mesh_view mesh) {
    uint32_t *const shared = calloc(mesh.vertex_count * mesh.vertex_count, sizeof *shared);
    assert_non_null(shared);
    for (size_t t = 0; t < mesh.triangle_count; t++)
        for (size_t k = 0; k < 9; k++)
            shared[mesh.triangles[3 * t + k / 3] * mesh.vertex_count +
                   mesh.triangles[3 * t + k % 3]]++;
    return shared;
}

/* Value of a vertex by Loop's masks; shared: its row. Neighbours on a border come up once. */
static double refine_vertex_by_search(tulle_mesh_view mesh, const double *values, uint32_t vertex,
                                      const uint32_t *shared) {
    double sum = 0.0, border_sum = 0.0;
    uint32_t border_count = 0;
    uint32_t const n = shared[vertex];
    for (uint32_t other = 0; other < mesh.vertex_count; other++) {
        if (other == vertex || shared[other] == 0) continue;
        sum += values[other];
        if (shared[other] > 1) continue;
        border_sum += values[other];
        border_count++;
    }
    if (border_count > 0) return 0.75 * values[vertex] + 0.125 * border_sum;
    double const middle = 0.375 + 0.25 * cos(2.0 * PI / n);
    double const weight = (0.625 - middle * middle) / n;
    return (1.0 - n * weight) * values[vertex] + weight * sum;
}

static bool is_on_border(tulle_mesh_view mesh, uint32_t vertex, const uint32_t *shared) {
    for (uint32_t other = 0; other < mesh.vertex_count; other++)
        if (shared[vertex * mesh.vertex_count + other] == 1) return true;
    return false;
}

/* Value of the midpoint of edge k of a triangle by Loop's masks. */
static double refine_edge_by_search(tulle_mesh_view mesh, const double *values, size_t triangle,
                                    size_t k) {
    const uint32_t *const corners = mesh.triangles + 3 * triangle;
    uint32_t const a = corners[k], b = corners[(k + 1) % 3];
    double opposite = 0.0;
    size_t count = 0;
    for (size_t t = 0; t < mesh.triangle_count; t++) {
        const uint32_t *const c = mesh.triangles + 3 * t;
        for (size_t i = 0; i < 3; i++) {
            uint32_t const from = c[i], to = c[(i + 1) % 3];
            if ((from != a || to != b) && (from != b || to != a)) continue;
            opposite += values[c[(i + 2) % 3]];
            count++;
        }
    }
    if (count == 1) return 0.5 * (values[a] + values[b]);
    return 0.375 * (values[a] + values[b]) + 0.125 * opposite;
}

/* One level of random values. Smooth edges that end on the border have masks of their own, tested
 * by their eigenvalues. */
static void compare_one_level(tulle_mesh_view mesh) {
    tulle_subdivision_def def = tulle_subdivision_def_default();
    def.levels = 1;
    def.is_limit = 0;
    def.corner_angle = (double)INFINITY;
    tulle_subdivision *const made = make_operator(mesh, &def);
    uint32_t *const shared = count_shared(mesh);
    double *const values = make_random_values(mesh.vertex_count, 7);
    double *const result = apply(made, values, 1);
    const uint32_t *const fine = tulle_subdivision_get_triangles(made);
    size_t compared = 0;
    for (uint32_t v = 0; v < mesh.vertex_count; v++) {
        double const expected =
            refine_vertex_by_search(mesh, values, v, shared + v * mesh.vertex_count);
        assert_true(fabs(result[v] - expected) < 1e-14);
    }
    for (size_t i = 0; i < 3 * mesh.triangle_count; i++) {
        size_t const t = i / 3, k = i % 3;
        uint32_t const a = mesh.triangles[i], b = mesh.triangles[3 * t + (k + 1) % 3];
        bool const is_border_edge = shared[a * mesh.vertex_count + b] == 1;
        bool const is_inner = !is_on_border(mesh, a, shared) && !is_on_border(mesh, b, shared);
        if (!is_border_edge && !is_inner) continue;
        double const expected = refine_edge_by_search(mesh, values, t, k);
        assert_true(fabs(result[fine[3 * (4 * t + 3) + k]] - expected) < 1e-14);
        compared++;
    }
    assert_true(compared > mesh.triangle_count);
    free(shared);
    free(values);
    free(result);
    tulle_subdivision_destroy(made);
}

static void one_level_agrees_with_search(void **state) {
    (void)state;
    tulle_shape const shapes[] = {TULLE_SHAPE_DISC, TULLE_SHAPE_NEEDLE, TULLE_SHAPE_TUBE,
                                  TULLE_SHAPE_CONE};
    for (size_t i = 0; i < 4; i++) {
        tulle_shape_def shape = tulle_shape_def_default(shapes[i]);
        shape.resolution[0] = 9;
        shape.resolution[1] = shapes[i] == TULLE_SHAPE_DISC ? 20 : 5;
        shape.is_irregular = i == 0;
        tulle_mesh mesh;
        tulle_error error = {0};
        if (tulle_shape_generate(&shape, &mesh, &error) != TULLE_OK) fail_msg("%s", error.message);
        if (mesh.vertex_count > 1000) fail_msg("%zu vertices", mesh.vertex_count);
        compare_one_level(tulle_mesh_get_view(&mesh));
        tulle_mesh_destroy(&mesh);
    }
}

static const double book[18] = {0, 0, 0, 0, 1, 0, 1, 0.5, 0, -1, 0.5, 0, 0, 0.5, 1, 0, 0.5, -1};

/* Whether triangle `last` has the three vertices of an earlier one: their middle triangles would
 * share vertices too, so that connections found by vertices change. */
static bool is_repeated(const uint32_t *triangles, size_t last) {
    const uint32_t *const c = triangles + 3 * last;
    for (size_t i = 0; i < last; i++) {
        int common = 0;
        for (size_t k = 0; k < 9; k++) common += triangles[3 * i + k / 3] == c[k % 3];
        if (common == 3) return true;
    }
    return false;
}

/* Soups that are no manifold: they must be taken, keep their counts, stay in their box. */
static void odd_soups_are_safe(void **state) {
    (void)state;
    uint64_t seed = 5;
    for (int round = 0; round < 300; round++) {
        double x[30];
        uint32_t t[30];
        size_t const vertex_count = 4 + random_next(&seed) % 7;
        size_t const triangle_count = 1 + random_next(&seed) % (vertex_count == 4 ? 4 : 10);
        for (size_t i = 0; i < 3 * vertex_count; i++) x[i] = random_uniform(&seed);
        for (size_t i = 0; i < triangle_count; i++) {
            uint32_t *const c = t + 3 * i;
            do {
                for (int k = 0; k < 3; k++) c[k] = (uint32_t)(random_next(&seed) % vertex_count);
            } while (c[0] == c[1] || c[1] == c[2] || c[2] == c[0] || is_repeated(t, i));
        }
        tulle_mesh_view const mesh = {x, vertex_count, t, triangle_count};
        tulle_subdivision_def def = tulle_subdivision_def_default();
        def.levels = 1 + round % 3;
        def.is_limit = round % 2;
        if (round % 5 == 0) def.crease_angle = 1.0;
        tulle_mesh result = subdivide(mesh, &def);
        tulle_mesh_info const before = get_info(mesh);
        tulle_mesh_info const after = get_info(tulle_mesh_get_view(&result));
        assert_int_equal(after.euler_characteristic, before.euler_characteristic);
        assert_int_equal(after.component_count, before.component_count);
        assert_int_equal(after.nonmanifold_edge_count, before.nonmanifold_edge_count << def.levels);
        for (size_t i = 0; i < 3 * result.vertex_count; i++)
            assert_true(fabs(result.positions[i] - 0.5) < 1.0);
        tulle_mesh_destroy(&result);
    }
}

/* Three pages share a spine, which is a crease between two corners; where two closed fans meet in a
 * point it stays. */
static void spines_and_bow_ties_are_sharp(void **state) {
    (void)state;
    const uint32_t pages[9] = {0, 1, 2, 0, 1, 3, 0, 1, 4};
    tulle_mesh_view const mesh = {book, 6, pages, 3};
    tulle_subdivision_def def = tulle_subdivision_def_default();
    def.corner_angle = (double)INFINITY;
    tulle_mesh result = subdivide(mesh, &def);
    /* Both ends have four sharp edges; the spine is straight, so its points stay on it. */
    for (size_t i = 0; i < 6; i++) assert_true(result.positions[i] == book[i]);
    size_t on_spine = 0;
    for (size_t v = 0; v < result.vertex_count; v++)
        on_spine += result.positions[3 * v] == 0.0 && result.positions[3 * v + 2] == 0.0;
    assert_int_equal(on_spine, 5);
    tulle_mesh_destroy(&result);

    const double x[21] = {0, 0, 0, 1, 0, 1, -1, 1, 1, -1, -1, 1, 1, 0, -1, -1, 1, -1, -1, -1, -1};
    const uint32_t tetrahedra[24] = {0, 1, 2, 0, 2, 3, 0, 3, 1, 1, 3, 2,
                                     0, 5, 4, 0, 6, 5, 0, 4, 6, 4, 5, 6};
    tulle_mesh_view const bow_tie = {x, 7, tetrahedra, 8};
    result = subdivide(bow_tie, &def);
    for (size_t k = 0; k < 3; k++) assert_true(result.positions[k] == 0.0);
    for (size_t v = 1; v < 7; v++) assert_true(result.positions[3 * v + 2] != x[3 * v + 2]);
    expect_same_topology(bow_tie, &result, def.levels);
    tulle_mesh_destroy(&result);
}

/* A square whose second triangle is turned over: the diagonal is straight and sharp, nothing else
 * changes; and the same with the diagonal given. */
static void turned_triangles_meet_in_a_crease(void **state) {
    (void)state;
    const double x[12] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 1};
    const uint32_t turned[6] = {0, 1, 2, 0, 3, 2}, sound[6] = {0, 1, 2, 0, 2, 3};
    const uint32_t diagonal[2] = {2, 0};
    tulle_subdivision_def def = tulle_subdivision_def_default();
    def.levels = 1; /* later levels number their edges by the order of a triangle's corners */
    def.corner_angle = (double)INFINITY;
    double *const by_turn = subdivide_values((tulle_mesh_view){x, 4, turned, 2}, &def, x, 3);
    double *const smooth = subdivide_values((tulle_mesh_view){x, 4, sound, 2}, &def, x, 3);
    def.crease_edges = diagonal;
    def.crease_edge_count = 1;
    tulle_subdivision *const made = make_operator((tulle_mesh_view){x, 4, sound, 2}, &def);
    double *const by_list = apply(made, x, 3);
    double difference = 0.0;
    for (size_t i = 0; i < 3 * tulle_subdivision_get_vertex_count(made); i++) {
        assert_true(fabs(by_turn[i] - by_list[i]) < 1e-15);
        difference = fmax(difference, fabs(smooth[i] - by_list[i]));
    }
    assert_true(difference > 0.01);
    for (size_t k = 0; k < 6; k++)
        assert_true(by_turn[k % 3 + 6 * (k / 3)] == x[k % 3 + 6 * (k / 3)]);
    tulle_subdivision_destroy(made);
    free(by_turn);
    free(by_list);
    free(smooth);
}

/* A cube keeps its twelve edges and eight corners with a crease angle, and is round without. */
static void crease_angle_keeps_a_box(void **state) {
    (void)state;
    tulle_mesh box = make_shape(TULLE_SHAPE_BOX, false);
    tulle_mesh_view const mesh = tulle_mesh_get_view(&box);
    tulle_subdivision_def def = tulle_subdivision_def_default();
    def.crease_angle = 1.0;
    tulle_mesh sharp = subdivide(mesh, &def);
    def.crease_angle = 1.6; /* over a right angle */
    tulle_mesh round = subdivide(mesh, &def);
    tulle_mesh_info const before = get_info(mesh), kept = get_info(tulle_mesh_get_view(&sharp)),
                          lost = get_info(tulle_mesh_get_view(&round));
    assert_true(fabs(kept.area - before.area) < 1e-12 * before.area);
    assert_true(lost.area < 0.99 * before.area);
    for (int k = 0; k < 3; k++) {
        assert_true(fabs(kept.bounds_max[k] - before.bounds_max[k]) < 1e-15);
        assert_true(lost.bounds_max[k] <= before.bounds_max[k]);
    }
    tulle_mesh_destroy(&sharp);
    tulle_mesh_destroy(&round);
    tulle_mesh_destroy(&box);
}

static void expect_refusal(tulle_mesh_view mesh, const tulle_subdivision_def *def,
                           tulle_status status, const char *word) {
    tulle_error error = {0};
    int mark;
    tulle_subdivision *made = (tulle_subdivision *)(void *)&mark;
    assert_int_equal(tulle_subdivision_create(mesh, def, &made, &error), status);
    assert_null(made);
    assert_int_equal(error.status, status);
    if (!strstr(error.message, word)) fail_msg("no '%s' in '%s'", word, error.message);
    assert_int_equal(tulle_subdivision_create(mesh, def, &made, NULL), status);
}

static void bad_defs_are_refused(void **state) {
    (void)state;
    tulle_mesh_view const mesh = view_octahedron();
    tulle_subdivision_def const sound = tulle_subdivision_def_default();
    tulle_subdivision_def def = sound;
    tulle_status const status = TULLE_ERROR_INVALID_ARGUMENT;
    expect_refusal(mesh, NULL, status, "tulle_subdivision_def_default");
    def.cookie = 0;
    expect_refusal(mesh, &def, status, "tulle_subdivision_def_default");
    int const bad_levels[3] = {0, -1, 7};
    for (int i = 0; i < 3; i++) {
        def = sound;
        def.levels = bad_levels[i];
        expect_refusal(mesh, &def, status, "1 to 6");
    }
    double const bad_angles[4] = {0.0, -1.0, (double)NAN, -(double)INFINITY};
    for (int i = 0; i < 8; i++) {
        def = sound;
        *(i % 2 ? &def.crease_angle : &def.corner_angle) = bad_angles[i / 2];
        expect_refusal(mesh, &def, status, "angle");
    }
    def = sound;
    def.crease_edge_count = 1;
    expect_refusal(mesh, &def, status, "null");
    const uint32_t no_edges[5][2] = {{0, 2}, {4, 5}, {1, 1}, {0, 6}, {TULLE_NONE, 0}};
    for (int i = 0; i < 5; i++) {
        def.crease_edges = no_edges[i];
        expect_refusal(mesh, &def, status, "crease edge 0");
    }
    assert_int_equal(tulle_subdivision_create(mesh, &sound, NULL, NULL), status);
}

static void bad_meshes_are_refused(void **state) {
    (void)state;
    tulle_subdivision_def def = tulle_subdivision_def_default();
    double x[18];
    uint32_t t[24];
    memcpy(x, octahedron, sizeof x);
    memcpy(t, octahedron_triangles, sizeof t);
    tulle_mesh_view mesh = {x, 6, t, 8};
    t[7] = 6;
    expect_refusal(mesh, &def, TULLE_ERROR_INVALID_MESH, "triangle 2 ");
    t[7] = t[6];
    expect_refusal(mesh, &def, TULLE_ERROR_INVALID_MESH, "triangle 2 ");
    t[7] = 3;
    x[4] = (double)NAN;
    expect_refusal(mesh, &def, TULLE_ERROR_INVALID_MESH, "vertex 1 ");
    x[4] = 1.0;
    mesh.positions = NULL;
    expect_refusal(mesh, &def, TULLE_ERROR_INVALID_ARGUMENT, "null");
    /* The limit is told before anything is read. */
    mesh = (tulle_mesh_view){x, 6, t, TULLE_SUBDIVISION_TRIANGLES_MAX / 16 + 1};
    expect_refusal(mesh, &def, TULLE_ERROR_LIMIT, "fewer levels");
    def.levels = 6;
    mesh.triangle_count = TULLE_SUBDIVISION_TRIANGLES_MAX / 4096 + 1;
    expect_refusal(mesh, &def, TULLE_ERROR_LIMIT, "fewer levels");
}

static void bad_values_are_refused(void **state) {
    (void)state;
    tulle_subdivision_def const def = tulle_subdivision_def_default();
    tulle_subdivision *const made = make_operator(view_octahedron(), &def);
    double *const result = malloc(17 * tulle_subdivision_get_vertex_count(made) * sizeof *result);
    assert_non_null(result);
    double const values[6 * 16] = {1.0};
    tulle_status const bad = TULLE_ERROR_INVALID_ARGUMENT;
    assert_int_equal(tulle_subdivision_apply(made, values, 0, result, NULL), bad);
    assert_int_equal(tulle_subdivision_apply(made, values, 17, result, NULL), bad);
    assert_int_equal(tulle_subdivision_apply(made, NULL, 3, result, NULL), bad);
    assert_int_equal(tulle_subdivision_apply(made, values, 3, NULL, NULL), bad);
    assert_int_equal(tulle_subdivision_apply(NULL, values, 3, result, NULL), bad);
    assert_int_equal(tulle_subdivision_apply(made, values, 16, result, NULL), TULLE_OK);
    tulle_mesh mesh;
    assert_int_equal(tulle_subdivision_make_mesh(made, NULL, &mesh, NULL), bad);
    assert_null(mesh.positions);
    assert_int_equal(tulle_subdivision_make_mesh(made, values, NULL, NULL), bad);
    assert_int_equal(tulle_subdivision_make_mesh(NULL, values, &mesh, NULL), bad);
    free(result);
    tulle_subdivision_destroy(made);
    tulle_subdivision_destroy(NULL);
}

/* Values beside each other are subdivided as each alone, with the same bits. */
static void components_do_not_mix(void **state) {
    (void)state;
    tulle_mesh mesh = make_shape(TULLE_SHAPE_CAPE, true);
    tulle_subdivision_def const def = tulle_subdivision_def_default();
    tulle_subdivision *const made = make_operator(tulle_mesh_get_view(&mesh), &def);
    double *const values = make_random_values(5 * mesh.vertex_count, 3);
    double *const column = malloc(3 * mesh.vertex_count * sizeof *column);
    assert_non_null(column);
    double *const together = apply(made, values, 5);
    for (size_t k = 0; k < 5; k++) {
        for (size_t v = 0; v < mesh.vertex_count; v++)
            for (size_t i = 0; i < 3; i++) column[3 * v + i] = values[5 * v + k];
        double *const alone = apply(made, column, 3);
        for (size_t v = 0; v < tulle_subdivision_get_vertex_count(made); v++)
            assert_true(alone[3 * v + k % 3] == together[5 * v + k]);
        free(alone);
    }
    free(values);
    free(column);
    free(together);
    tulle_subdivision_destroy(made);
    tulle_mesh_destroy(&mesh);
}

typedef struct counted_heap {
    int left;
    size_t bytes_held;
} counted_heap;

static void *allocate_until(void *context, size_t byte_count) {
    counted_heap *const heap = context;
    if (heap->left-- <= 0) return NULL;
    heap->bytes_held += byte_count;
    return malloc(byte_count);
}

static void release_counted(void *context, void *pointer, size_t byte_count) {
    counted_heap *const heap = context;
    heap->bytes_held -= byte_count;
    free(pointer);
}

static void every_allocation_may_fail(void **state) {
    (void)state;
    tulle_mesh mesh = make_shape(TULLE_SHAPE_NET, false);
    tulle_subdivision_def const def = tulle_subdivision_def_default();
    counted_heap counted = {0};
    memory const heap = {.allocator = {allocate_until, release_counted, &counted, 0}};
    tulle_subdivision *made = NULL;
    tulle_error error;
    for (int k = 0; !made; k++) {
        assert_true(k < 200);
        counted.left = k;
        error = (tulle_error){0};
        tulle_status const status =
            subdivision_create(heap, tulle_mesh_get_view(&mesh), &def, &made, &error);
        if (status == TULLE_OK) break;
        assert_int_equal(status, TULLE_ERROR_OUT_OF_MEMORY);
        assert_int_equal(error.status, TULLE_ERROR_OUT_OF_MEMORY);
        assert_null(made);
        assert_int_equal(counted.bytes_held, 0);
    }
    size_t const held = counted.bytes_held;
    double *const result = malloc(3 * tulle_subdivision_get_vertex_count(made) * sizeof *result);
    assert_non_null(result);
    for (int k = 0; k < 2; k++) {
        counted.left = k;
        assert_int_equal(tulle_subdivision_apply(made, mesh.positions, 3, result, &error),
                         TULLE_ERROR_OUT_OF_MEMORY);
        assert_int_equal(counted.bytes_held, held);
    }
    counted.left = 2;
    assert_int_equal(tulle_subdivision_apply(made, mesh.positions, 3, result, &error), TULLE_OK);
    assert_int_equal(counted.bytes_held, held);
    tulle_subdivision_destroy(made);
    assert_int_equal(counted.bytes_held, 0);
    free(result);
    tulle_mesh_destroy(&mesh);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(topology_is_kept),
        cmocka_unit_test(pieces_and_lone_vertices_are_kept),
        cmocka_unit_test(parents_are_named),
        cmocka_unit_test(one_level_agrees_with_search),
        cmocka_unit_test(odd_soups_are_safe),
        cmocka_unit_test(spines_and_bow_ties_are_sharp),
        cmocka_unit_test(turned_triangles_meet_in_a_crease),
        cmocka_unit_test(crease_angle_keeps_a_box),
        cmocka_unit_test(bad_defs_are_refused),
        cmocka_unit_test(bad_meshes_are_refused),
        cmocka_unit_test(bad_values_are_refused),
        cmocka_unit_test(components_do_not_mix),
        cmocka_unit_test(every_allocation_may_fail),
    };
    return cmocka_run_group_tests_name("geom.subdivision", tests, NULL, NULL);
}
