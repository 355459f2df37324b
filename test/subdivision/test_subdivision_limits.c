/* Loop subdivision against closed forms: polynomials on regular triangles, B-splines on borders and
 * creases, Platonic solids, eigenvalues of every kind of fan; and limits against each other over
 * the levels. */
#include "subdivision/subdivision_support.h"

#include "math/vec3.h"

#include "tulle_io/subdivision.h"

enum { SIDE = 9 };

/* A regular net: lattice steps (1, 0), (0, 1) and the diagonal (1, 1). */
static void make_lattice(double *x, uint32_t *t) {
    for (uint32_t i = 0; i < SIDE * SIDE; i++) {
        x[3 * i] = i % SIDE;
        x[3 * i + 1] = i / SIDE;
        x[3 * i + 2] = 0.0;
        if (i % SIDE == SIDE - 1 || i / SIDE == SIDE - 1) continue;
        const uint32_t corners[6] = {i, i + 1, i + SIDE + 1, i, i + SIDE + 1, i + SIDE};
        memcpy(t, corners, sizeof corners);
        t += 6;
    }
}

/* The box spline of regular triangles has the moments E a^2 = E b^2 = 1/3, E a b = 1/6 and no third
 * ones, so control values p give the surface p + 1/2 sum E p''; the control net of level n lacks
 * 4^-n of that. */
static void regular_triangles_reproduce_cubics(void **state) {
    (void)state;
    double x[3 * SIDE * SIDE], values[7 * SIDE * SIDE];
    uint32_t t[6 * (SIDE - 1) * (SIDE - 1)];
    make_lattice(x, t);
    for (size_t v = 0; v < SIDE * SIDE; v++) {
        double const a = x[3 * v], b = x[3 * v + 1];
        double const row[7] = {a, b, a * a, a * b, b * b, a * a * a, a * b * b};
        memcpy(values + 7 * v, row, sizeof row);
    }
    tulle_mesh_view const mesh = {x, SIDE * SIDE, t, sizeof t / sizeof *t / 3};
    for (int round = 0; round < 8; round++) {
        tulle_subdivision_def def = tulle_subdivision_def_default();
        def.levels = 1 + round / 2;
        def.is_limit = round % 2;
        double const part = def.is_limit ? 1.0 : 1.0 - ldexp(1.0, -2 * def.levels);
        tulle_subdivision *const made = make_operator(mesh, &def);
        double *const result = apply(made, values, 7);
        size_t compared = 0;
        for (size_t v = 0; v < tulle_subdivision_get_vertex_count(made); v++) {
            const double *const r = result + 7 * v;
            double const a = r[0], b = r[1], c = part / 3.0;
            if (fmax(fabs(a - 4.0), fabs(b - 4.0)) > 2.0 + 1e-9) continue;
            double const expected[5] = {a * a + c, a * b + 0.5 * c, b * b + c,
                                        a * a * a + 3.0 * a * c, a * b * b + a * c + b * c};
            for (size_t k = 0; k < 5; k++) assert_true(fabs(r[2 + k] - expected[k]) < 1e-12);
            compared++;
        }
        size_t const across = ((size_t)(SIDE - 5) << def.levels) + 1;
        assert_int_equal(compared, across * across);
        free(result);
        tulle_subdivision_destroy(made);
    }
}

/* Every dyadic point of the uniform cubic B-spline over four control points is a vertex. */
static void expect_spline(const double *x, const uint32_t control[4], const tulle_mesh *result,
                          int levels) {
    int const parts = 1 << levels;
    for (int i = 0; i <= parts; i++) {
        double const u = (double)i / parts, w = 1.0 - u;
        double const basis[4] = {w * w * w, 3 * u * u * u - 6 * u * u + 4,
                                 3 * w * w * w - 6 * w * w + 4, u * u * u};
        vec3 point = {0};
        for (int k = 0; k < 4; k++)
            point = vec3_add_scaled(point, vec3_load(x, control[k]), basis[k] / 6.0);
        double nearest = (double)INFINITY;
        for (size_t v = 0; v < result->vertex_count; v++)
            nearest = fmin(nearest, vec3_norm(vec3_sub(vec3_load(result->positions, v), point)));
        assert_true(nearest < 1e-14);
    }
}

static void borders_and_creases_are_splines(void **state) {
    (void)state;
    /* A pyramid without a base: four triangles, a border of four edges; then the whole octahedron
     * with its equator a crease. Both poles are moved: they must not matter. */
    double x[18];
    memcpy(x, octahedron, sizeof x);
    x[2] = 0.3;
    x[14] = 2.0;
    x[15] = 0.4;
    const uint32_t equator[8] = {0, 1, 2, 1, 2, 3, 3, 0};
    for (int is_closed = 0; is_closed < 2; is_closed++) {
        tulle_mesh_view const mesh = {x, is_closed ? 6 : 5, octahedron_triangles,
                                      is_closed ? 8 : 4};
        tulle_subdivision_def def = tulle_subdivision_def_default();
        def.corner_angle = (double)INFINITY;
        def.crease_edges = equator;
        def.crease_edge_count = is_closed ? 4 : 0;
        for (def.levels = 1; def.levels <= 4; def.levels++) {
            tulle_mesh result = subdivide(mesh, &def);
            for (uint32_t e = 0; e < 4; e++) {
                const uint32_t control[4] = {(e + 3) % 4, e, (e + 1) % 4, (e + 2) % 4};
                expect_spline(x, control, &result, def.levels);
            }
            tulle_mesh_destroy(&result);
        }
    }
}

/* Vertices (0, +-1, +-golden ratio) and round; triangles are the triples with edges of length 2. */
static void make_icosahedron(double *x, uint32_t *t) {
    double const golden = 0.5 * (1.0 + sqrt(5.0));
    for (size_t v = 0; v < 12; v++) {
        x[3 * v + (v / 4 + 1) % 3] = v % 2 ? 1.0 : -1.0;
        x[3 * v + (v / 4 + 2) % 3] = v % 4 / 2 ? golden : -golden;
    }
    size_t count = 0;
    for (uint32_t i = 0; i < 12 * 12 * 12; i++) {
        uint32_t const a = i % 12, b = i / 12 % 12, c = i / 144;
        vec3 const u = vec3_load(x, a), v = vec3_load(x, b), w = vec3_load(x, c);
        double const lengths = fmax(vec3_norm(vec3_sub(u, v)),
                                    fmax(vec3_norm(vec3_sub(v, w)), vec3_norm(vec3_sub(w, u))));
        if (a >= b || a >= c || b == c || lengths > 2.1) continue;
        if (vec3_dot(vec3_cross(vec3_sub(v, u), vec3_sub(w, u)), u) < 0.0) continue;
        assert_true(count < 20);
        const uint32_t corners[3] = {a, b, c};
        memcpy(t + 3 * count++, corners, sizeof corners);
    }
    assert_int_equal(count, 20);
}

/* With n neighbours that sum to s times the vertex, the limit is 1 - n c + s c of it, c the limit
 * weight: tetrahedron n = 3, s = -1: 1/5; octahedron n = 4, s = 0: 24/55; icosahedron n = 5, s =
 * sqrt 5. */
static void platonic_limits_are_known(void **state) {
    (void)state;
    const double tetrahedron[12] = {1, 1, 1, 1, -1, -1, -1, 1, -1, -1, -1, 1};
    const uint32_t tetrahedron_triangles[12] = {0, 1, 2, 0, 2, 3, 0, 3, 1, 1, 3, 2};
    double icosahedron[36] = {0.0};
    uint32_t icosahedron_triangles[60];
    make_icosahedron(icosahedron, icosahedron_triangles);
    double const cosine = 0.25 * (sqrt(5.0) - 1.0), middle = 0.375 + 0.25 * cosine;
    double const weight = (0.625 - middle * middle) / 5.0;
    double const limit = 1.0 / (5.0 + 3.0 / (8.0 * weight));
    tulle_mesh_view const meshes[3] = {{tetrahedron, 4, tetrahedron_triangles, 4},
                                       view_octahedron(),
                                       {icosahedron, 12, icosahedron_triangles, 20}};
    double const factors[3] = {1.0 / 5.0, 24.0 / 55.0, 1.0 - 5.0 * limit + sqrt(5.0) * limit};
    for (int i = 0; i < 3; i++) {
        tulle_subdivision_def def = tulle_subdivision_def_default();
        for (def.levels = 1; def.levels <= 5; def.levels++) {
            tulle_mesh result = subdivide(meshes[i], &def);
            for (size_t v = 0; v < meshes[i].vertex_count; v++) {
                vec3 const before = vec3_load(meshes[i].positions, v);
                vec3 const after = vec3_load(result.positions, v);
                vec3 const expected = vec3_scale(before, factors[i]);
                assert_true(vec3_norm(vec3_sub(after, expected)) < 1e-14);
            }
            tulle_mesh_destroy(&result);
        }
    }
}

/* Limits of the first level's vertices at any level, and the control points that go there. */
static void expect_same_limits(tulle_mesh_view mesh, const tulle_subdivision_def *given) {
    tulle_subdivision_def def = *given;
    double *const values = make_random_values(mesh.vertex_count, 11);
    def.levels = 1;
    tulle_subdivision *const first = make_operator(mesh, &def);
    size_t const count = tulle_subdivision_get_vertex_count(first);
    double *const limits = apply(first, values, 1);
    double distance_prev = (double)INFINITY;
    for (def.levels = 2; def.levels <= 5; def.levels++) {
        def.is_limit = 1;
        double *const again = subdivide_values(mesh, &def, values, 1);
        def.is_limit = 0;
        double *const control = subdivide_values(mesh, &def, values, 1);
        double distance = 0.0;
        for (size_t v = 0; v < count; v++) {
            assert_true(fabs(again[v] - limits[v]) < 1e-13);
            distance = fmax(distance, fabs(control[v] - limits[v]));
        }
        /* Each level shrinks what is left by 1/4, by (5/8)^2 in fans of many triangles, and by
         * 1/2 at darts, whose masks are not symmetric. */
        if (distance > 0.55 * distance_prev + 1e-15)
            fail_msg("%zu triangles, level %d: %g after %g", mesh.triangle_count, def.levels,
                     distance, distance_prev);
        distance_prev = distance;
        free(again);
        free(control);
    }
    assert_true(distance_prev < 0.01);
    free(limits);
    free(values);
    tulle_subdivision_destroy(first);
}

static void limits_do_not_depend_on_levels(void **state) {
    (void)state;
    tulle_subdivision_def def = tulle_subdivision_def_default();
    tulle_shape const shapes[] = {TULLE_SHAPE_RECTANGLE, TULLE_SHAPE_DISC, TULLE_SHAPE_CAPE,
                                  TULLE_SHAPE_NET,       TULLE_SHAPE_BOX,  TULLE_SHAPE_TETRAHEDRON,
                                  TULLE_SHAPE_NEEDLE,    TULLE_SHAPE_NAIL};
    for (size_t i = 0; i < sizeof shapes / sizeof *shapes; i++) {
        tulle_mesh mesh = make_shape(shapes[i], i < 3);
        def.crease_angle = i < 4 ? (double)INFINITY : 0.7;
        if (mesh.triangle_count < 1200) expect_same_limits(tulle_mesh_get_view(&mesh), &def);
        tulle_mesh_destroy(&mesh);
    }
    /* Darts at both ends of a crease, with a corner or a crease vertex between them. */
    const uint32_t crease[4] = {0, 1, 1, 2};
    def.crease_angle = (double)INFINITY;
    def.crease_edges = crease;
    for (def.crease_edge_count = 1; def.crease_edge_count <= 2; def.crease_edge_count++) {
        expect_same_limits(view_octahedron(), &def);
        def.corner_angle = (double)INFINITY;
        expect_same_limits(view_octahedron(), &def);
    }
}

enum { FAN_MAX = 40, FAN_VALUES = 1 + 2 * (FAN_MAX + 1) };

/* A fan of `count` triangles around vertex 0 with the ring 1 .. ring_count, and a strip of
 * triangles around it, so that the ring has no sharp edges but those of the fan's ends. */
typedef struct fan {
    uint32_t count, ring_count;
    double positions[3 * FAN_VALUES];
    uint32_t triangles[9 * FAN_MAX];
    tulle_mesh_view view;
} fan;

/* angle: [rad] of the whole fan; is_closed: its ends are one. */
static void make_fan(fan *f, uint32_t count, double angle, bool is_closed) {
    *f = (fan){.count = count, .ring_count = is_closed ? count : count + 1};
    for (uint32_t i = 0; i < f->ring_count; i++) {
        double const turn = angle * i / count;
        vec3 const x = vec3_make(cos(turn), sin(turn), 0.0);
        vec3_store(f->positions, 1 + i, x);
        vec3_store(f->positions, 1 + f->ring_count + i, vec3_scale(x, 2.0));
    }
    for (uint32_t i = 0; i < count; i++) {
        uint32_t const a = 1 + i, b = 1 + (i + 1) % f->ring_count, far = f->ring_count;
        const uint32_t corners[9] = {0, a, b, a, a + far, b + far, a, b + far, b};
        memcpy(f->triangles + 9 * i, corners, sizeof corners);
    }
    f->view = (tulle_mesh_view){f->positions, 1 + 2 * f->ring_count, f->triangles, 3 * count};
}

/* One level of the fan takes the ring's values to `factor` times them, and the centre from 0 to 0.
 * The next ring are the midpoints of the edges from the centre. */
static void expect_eigenvector(const fan *f, const double *ring, double factor,
                               const tulle_subdivision_def *def) {
    double values[FAN_VALUES] = {0.0};
    memcpy(values + 1, ring, f->ring_count * sizeof *ring);
    tulle_subdivision *const made = make_operator(f->view, def);
    const uint32_t *const fine = tulle_subdivision_get_triangles(made);
    double *const result = apply(made, values, 1);
    assert_true(fabs(result[0]) < 1e-14);
    for (uint32_t i = 0; i < f->count; i++) {
        const uint32_t *const part = fine + 3 * 4 * (3 * (size_t)i); /* at the centre */
        assert_int_equal(part[0], 0);
        assert_true(fabs(result[part[1]] - factor * ring[i]) < 1e-14);
        assert_true(fabs(result[part[2]] - factor * ring[(i + 1) % f->ring_count]) < 1e-14);
    }
    free(result);
    tulle_subdivision_destroy(made);
}

/* Closed fans: cos(2 pi j i / n) has 3/8 + cos(2 pi j / n) / 4; and Loop's weights give the even
 * part 5/8 - n w = (3/8 + cos(2 pi / n) / 4)^2, that of a paraboloid. */
static void closed_fans_have_loops_eigenvalues(void **state) {
    (void)state;
    tulle_subdivision_def def = tulle_subdivision_def_default();
    def.levels = 1;
    def.is_limit = 0;
    static fan f;
    double ring[FAN_MAX + 1];
    for (uint32_t n = 3; n <= FAN_MAX; n++) {
        make_fan(&f, n, 2.0 * PI, true);
        for (uint32_t j = 1; j <= n / 2; j++) {
            for (uint32_t i = 0; i < n; i++) ring[i] = cos(2.0 * PI * j * i / n);
            expect_eigenvector(&f, ring, 0.375 + 0.25 * cos(2.0 * PI * j / n), &def);
        }
        double const first = 0.375 + 0.25 * cos(2.0 * PI / n);
        double const weight = subdivision_get_neighbour_weight(n);
        assert_true(fabs(0.625 - n * weight - first * first) < 1e-15);
    }
}

/* A border or crease vertex of any number of triangles: the half circle is scaled by 1/2 as it is,
 * in both directions, and all else of the fan by less. */
static void sectors_of_borders_halve(void **state) {
    (void)state;
    tulle_subdivision_def def = tulle_subdivision_def_default();
    def.levels = 1;
    def.is_limit = 0;
    static fan f;
    double ring[FAN_MAX + 1];
    for (uint32_t k = 2; k <= FAN_MAX; k++) {
        make_fan(&f, k, PI, false);
        for (uint32_t i = 0; i <= k; i++) ring[i] = cos(PI * i / k);
        expect_eigenvector(&f, ring, 0.5, &def);
        for (uint32_t j = 1; j < k; j++) {
            for (uint32_t i = 1; i < k; i++) ring[i] = sin(PI * j * i / k);
            ring[0] = ring[k] = 0.0;
            double const factor = 0.5 - 0.25 * (cos(PI / k) - cos(PI * j / k));
            expect_eigenvector(&f, ring, factor, &def);
            assert_true(j == 1 ? fabs(factor - 0.5) < 1e-15 : factor < 0.5);
        }
    }
}

/* Corners: the sector's own circle is scaled by 1/2 in both directions, and what vanishes at its
 * sides by less than 1/2, if concave by 3/8 at most; so the surface keeps the corner's angle. */
static void corners_keep_their_angle(void **state) {
    (void)state;
    tulle_subdivision_def def = tulle_subdivision_def_default();
    def.levels = 1;
    def.is_limit = 0;
    def.corner_angle = 0.5;
    static fan f;
    double ring[2][FAN_MAX + 1];
    double const angles[5] = {PI / 4.0, PI / 2.0, 0.8 * PI, 1.25 * PI, 1.5 * PI};
    for (uint32_t i = 0; i < 5 * 12; i++) {
        double const angle = angles[i % 5], share = angle / (2 + i / 5);
        uint32_t const k = 2 + i / 5;
        if (share > 0.8 * PI) continue;
        make_fan(&f, k, angle, false);
        for (uint32_t j = 0; j <= k; j++) {
            ring[0][j] = cos(share * j);
            ring[1][j] = sin(share * j);
        }
        expect_eigenvector(&f, ring[0], 0.5, &def);
        expect_eigenvector(&f, ring[1], 0.5, &def);
        for (uint32_t j = 1; j < k; j++) {
            for (uint32_t spoke = 1; spoke < k; spoke++) ring[0][spoke] = sin(PI * j * spoke / k);
            ring[0][0] = ring[0][k] = 0.0;
            double const plain = 0.5 - 0.25 * cos(share) + 0.25 * cos(PI / k);
            double const factor = 0.5 - 0.25 * cos(share) + 0.25 * cos(PI * j / k);
            if (angle < PI) assert_true(factor < 0.5);
            expect_eigenvector(&f, ring[0], angle < PI ? factor : factor * fmin(1.0, 0.375 / plain),
                               &def);
        }
    }
}

/* Flat cloth stays flat, keeps straight borders, right-angled corners (also concave ones, of holes)
 * and its area, and no triangle is turned over. */
static void flat_cloth_keeps_its_outline(void **state) {
    (void)state;
    tulle_shape const shapes[4] = {TULLE_SHAPE_RECTANGLE, TULLE_SHAPE_RECTANGLE, TULLE_SHAPE_NET,
                                   TULLE_SHAPE_RIBBON};
    for (int i = 0; i < 8; i++) {
        tulle_shape_def shape = tulle_shape_def_default(shapes[i / 2]);
        shape.is_irregular = i % 2;
        shape.resolution[0] = shape.resolution[1] = shapes[i / 2] == TULLE_SHAPE_NET ? 0 : 7;
        if (i / 2 == 1) shape.size[1] = 0.2 * shape.size[0];
        if (shapes[i / 2] == TULLE_SHAPE_NET) {
            shape.cells[0] = shape.cells[1] = 1;
            shape.strand_resolution = 1 + (uint32_t)(i % 3);
        }
        tulle_mesh mesh;
        tulle_error error = {0};
        if (tulle_shape_generate(&shape, &mesh, &error) != TULLE_OK) fail_msg("%s", error.message);
        tulle_subdivision_def def = tulle_subdivision_def_default();
        def.levels = i == 5 ? 6 : 4; /* concave corners turn triangles over level by level */
        tulle_mesh result = subdivide(tulle_mesh_get_view(&mesh), &def);
        tulle_mesh_info before, after;
        assert_int_equal(tulle_mesh_get_info(tulle_mesh_get_view(&mesh), &before, NULL), TULLE_OK);
        assert_int_equal(tulle_mesh_get_info(tulle_mesh_get_view(&result), &after, NULL), TULLE_OK);
        if (fabs(after.area - before.area) > 1e-12 * before.area)
            fail_msg("case %d: area %.17g of %.17g", i, after.area, before.area);
        size_t turned = 0;
        for (size_t t = 0; t < result.triangle_count; t++) {
            const uint32_t *const c = result.triangles + 3 * t;
            vec3 const a = vec3_load(result.positions, c[0]);
            vec3 const u = vec3_sub(vec3_load(result.positions, c[1]), a);
            turned += vec3_cross(u, vec3_sub(vec3_load(result.positions, c[2]), a)).z <= 0.0;
        }
        if (turned > 0) fail_msg("case %d: %zu triangles turned over", i, turned);
        tulle_mesh_destroy(&result);
        tulle_mesh_destroy(&mesh);
    }
}

/* Every row of every step sums to one, so that moving, turning and stretching the mesh and
 * subdividing it may be swapped. */
static void rows_sum_to_one(void **state) {
    (void)state;
    for (int shape = 0; shape < TULLE_SHAPE_COUNT; shape++) {
        tulle_mesh mesh = make_shape((tulle_shape)shape, shape % 2);
        tulle_subdivision_def def = tulle_subdivision_def_default();
        def.crease_angle = 0.6;
        tulle_subdivision *const made = make_operator(tulle_mesh_get_view(&mesh), &def);
        assert_int_equal(made->step_count, 3);
        for (size_t step = 0; step < made->step_count; step++) {
            const subdivision_rows *const rows = &made->steps[step];
            for (size_t r = 0; r < rows->row_count; r++) {
                double sum = 0.0;
                for (uint32_t i = rows->begin[r]; i < rows->begin[r + 1]; i++) {
                    assert_true(rows->columns[i] < rows->column_count);
                    sum += rows->weights[i];
                }
                assert_true(fabs(sum - 1.0) < 1e-13);
            }
        }
        tulle_subdivision_destroy(made);
        tulle_mesh_destroy(&mesh);
    }
}

static void affine_maps_may_be_swapped(void **state) {
    (void)state;
    tulle_mesh mesh = make_shape(TULLE_SHAPE_NAIL, false);
    tulle_subdivision_def def = tulle_subdivision_def_default();
    def.crease_angle = 0.6;
    tulle_subdivision *const made = make_operator(tulle_mesh_get_view(&mesh), &def);
    double const scale[3] = {1.5, 0.5, 2.0}, turn[4] = {0.5, 0.5, -0.5, 0.5}, move[3] = {3, 4, 5};
    tulle_mesh before, after;
    assert_int_equal(tulle_subdivision_make_mesh(made, mesh.positions, &before, NULL), TULLE_OK);
    tulle_mesh_transform(&before, scale, turn, move);
    tulle_mesh_transform(&mesh, scale, turn, move);
    assert_int_equal(tulle_subdivision_make_mesh(made, mesh.positions, &after, NULL), TULLE_OK);
    for (size_t i = 0; i < 3 * after.vertex_count; i++)
        assert_true(fabs(after.positions[i] - before.positions[i]) < 1e-13);
    tulle_mesh_destroy(&before);
    tulle_mesh_destroy(&after);
    tulle_mesh_destroy(&mesh);
    tulle_subdivision_destroy(made);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(regular_triangles_reproduce_cubics),
        cmocka_unit_test(borders_and_creases_are_splines),
        cmocka_unit_test(platonic_limits_are_known),
        cmocka_unit_test(limits_do_not_depend_on_levels),
        cmocka_unit_test(closed_fans_have_loops_eigenvalues),
        cmocka_unit_test(sectors_of_borders_halve),
        cmocka_unit_test(corners_keep_their_angle),
        cmocka_unit_test(flat_cloth_keeps_its_outline),
        cmocka_unit_test(rows_sum_to_one),
        cmocka_unit_test(affine_maps_may_be_swapped),
    };
    return cmocka_run_group_tests_name("geom.subdivision_limits", tests, NULL, NULL);
}
