/* Mass properties against closed forms and against surface integrals of another kind; meshes that
 * are no bodies. */
#include "geom/mass_properties.h"

#include "base/hash.h"
#include "support/failing_heap.h"
#include "support/test_support.h"
#include "tulle/shapes.h"

#include <string.h>

static const double PI = 3.141592653589793;

static tulle_mesh generate(const tulle_shape_def *def) {
    tulle_error error = {0};
    tulle_mesh mesh = {0};
    if (tulle_shape_generate(def, &mesh, &error) != TULLE_OK) fail_msg("%s", error.message);
    return mesh;
}

static tulle_mesh make_box(double x, double y, double z) {
    tulle_shape_def def = tulle_shape_def_default(TULLE_SHAPE_BOX);
    def.size[0] = x, def.size[1] = y, def.size[2] = z;
    return generate(&def);
}

static mass_properties find(const tulle_mesh *mesh, mass_distribution where) {
    memory heap = memory_default();
    mass_properties found;
    tulle_error error = {0};
    tulle_mesh_view const view = tulle_mesh_get_view(mesh);
    if (mass_properties_compute(&heap, view, where, "body", &found, &error) != TULLE_OK)
        fail_msg("%s", error.message);
    assert_int_equal(heap.bytes_held, 0);
    return found;
}

static void expect_error(const tulle_mesh *mesh, mass_distribution where, const char *words) {
    memory heap = memory_default();
    mass_properties found;
    tulle_error error = {0};
    tulle_mesh_view const view = tulle_mesh_get_view(mesh);
    assert_int_equal(mass_properties_compute(&heap, view, where, "ball", &found, &error),
                     TULLE_ERROR_INVALID_MESH);
    if (!strstr(error.message, words) || !strstr(error.message, "ball: "))
        fail_msg("\"%s\" lacks \"%s\"", error.message, words);
    assert_int_equal(heap.bytes_held, 0);
}

static void expect_near(double value, double expected, double tolerance) {
    if (!(fabs(value - expected) <= tolerance * fabs(expected)))
        fail_msg("%.17g instead of %.17g", value, expected);
}

/* The inertia tensor in the mesh's axes. */
static void get_tensor(const mass_properties *body, double tensor[3][3]) {
    mat3 const r = quaternion_to_matrix(body->axes);
    const double moments[3] = {body->moments.x, body->moments.y, body->moments.z};
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            tensor[i][j] = 0.0;
            for (int k = 0; k < 3; k++)
                tensor[i][j] += r.m[3 * i + k] * moments[k] * r.m[3 * j + k];
        }
}

static void test_boxes_anywhere(void **state) {
    (void)state;
    uint64_t random = 5;
    for (int round = 0; round < 200; round++) {
        double const a = 0.1 + random_uniform(&random), b = 0.1 + random_uniform(&random),
                     c = 0.1 + random_uniform(&random);
        tulle_mesh mesh = make_box(a, b, c);
        quaternion const turn = quaternion_normalize(
            (quaternion){random_uniform(&random), random_uniform(&random),
                         random_uniform(&random) - 0.5, random_uniform(&random) - 0.5});
        const double one[3] = {1.0, 1.0, 1.0}, q[4] = {turn.w, turn.x, turn.y, turn.z};
        const double shift[3] = {10.0 * random_uniform(&random), -7.0, 3.0};
        tulle_mesh_transform(&mesh, one, q, shift);
        mass_properties const body = find(&mesh, MASS_IN_VOLUME);
        double const v = a * b * c;
        expect_near(body.measure, v, 1e-12);
        expect_near(body.centre.x, shift[0], 1e-13 * 10.0 / fmax(shift[0], 0.1));
        double const own[3] = {v / 12.0 * (b * b + c * c), v / 12.0 * (a * a + c * c),
                               v / 12.0 * (a * a + b * b)};
        assert_true(body.moments.x <= body.moments.y && body.moments.y <= body.moments.z);
        double tensor[3][3];
        get_tensor(&body, tensor);
        mat3 const r = quaternion_to_matrix(turn);
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++) {
                double expected = 0.0;
                for (int k = 0; k < 3; k++) expected += r.m[3 * i + k] * own[k] * r.m[3 * j + k];
                assert_true(fabs(tensor[i][j] - expected) <= 1e-11 * body.moments.z);
            }
        tulle_mesh_destroy(&mesh);
    }
}

/* Integrals of x^i over the body as flux through its triangles, by a quadrature of degree 3: its
 * points are the centroid (-27/48) and those with barycentric coordinates 0.6, 0.2, 0.2 (25/48). */
static double find_flux(const tulle_mesh *mesh, int i, int j, int power) {
    static const double points[4][3] = {
        {1.0 / 3, 1.0 / 3, 1.0 / 3}, {0.6, 0.2, 0.2}, {0.2, 0.6, 0.2}, {0.2, 0.2, 0.6}};
    static const double weights[4] = {-27.0 / 48, 25.0 / 48, 25.0 / 48, 25.0 / 48};
    double sum = 0.0;
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        vec3 x[3];
        for (size_t k = 0; k < 3; k++)
            x[k] = vec3_load(mesh->positions, mesh->triangles[3 * t + k]);
        vec3 const area = vec3_scale(vec3_cross(vec3_sub(x[1], x[0]), vec3_sub(x[2], x[0])), 0.5);
        const double normal[3] = {area.x, area.y, area.z};
        for (int p = 0; p < 4; p++) {
            vec3 at = {0, 0, 0};
            for (int k = 0; k < 3; k++) at = vec3_add_scaled(at, x[k], points[p][k]);
            const double c[3] = {at.x, at.y, at.z};
            /* div of (x_i^(power + 1) / (power + 1)) e_i, or of x_j x_i^2 / 2 e_i for mixed ones */
            double value = power == 0 ? c[i] : power == 1 ? c[i] * c[i] / 2 : pow(c[i], 3) / 3;
            if (power == 2 && i != j) value = c[j] * c[i] * c[i] / 2;
            sum += weights[p] * value * normal[i];
        }
    }
    return sum;
}

static void test_solids_against_fluxes(void **state) {
    (void)state;
    static const tulle_shape shapes[] = {
        TULLE_SHAPE_SPHERE, TULLE_SHAPE_HEMISPHERE,  TULLE_SHAPE_CYLINDER, TULLE_SHAPE_CONE,
        TULLE_SHAPE_NEEDLE, TULLE_SHAPE_TETRAHEDRON, TULLE_SHAPE_TORUS,    TULLE_SHAPE_NAIL,
        TULLE_SHAPE_TILE,   TULLE_SHAPE_SCEPTRE};
    for (size_t s = 0; s < sizeof shapes / sizeof *shapes; s++) {
        tulle_shape_def const def = tulle_shape_def_default(shapes[s]);
        tulle_mesh mesh = generate(&def);
        const double scale[3] = {1.0, 0.8, 1.3}, q[4] = {0.5, 0.1, -0.7, 0.5};
        const double shift[3] = {0.3, -0.2, 0.1};
        tulle_mesh_transform(&mesh, scale, q, shift);
        mass_properties const body = find(&mesh, MASS_IN_VOLUME);
        double const volume = find_flux(&mesh, 0, 0, 0);
        expect_near(body.measure, volume, 1e-12);
        const double centre[3] = {body.centre.x, body.centre.y, body.centre.z};
        double second[3][3], tensor[3][3];
        for (int i = 0; i < 3; i++) {
            assert_true(fabs(centre[i] - find_flux(&mesh, i, i, 1) / volume) < 1e-12);
            for (int j = 0; j < 3; j++)
                second[i][j] = find_flux(&mesh, i, j, 2) - volume * centre[i] * centre[j];
        }
        get_tensor(&body, tensor);
        double const trace = second[0][0] + second[1][1] + second[2][2];
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++) {
                double const expected = (i == j ? trace : 0.0) - second[i][j];
                assert_true(fabs(tensor[i][j] - expected) < 1e-9 * body.moments.z);
            }
        tulle_mesh_destroy(&mesh);
    }
}

static void test_shells(void **state) {
    (void)state;
    /* a box of plates */
    double const a = 0.5, b = 0.7, c = 0.2;
    tulle_mesh box = make_box(a, b, c);
    mass_properties const plates = find(&box, MASS_ON_SURFACE);
    expect_near(plates.measure, 2 * (a * b + b * c + a * c), 1e-13);
    /* about the axis along c: plates a x b about their middles, the others at their distances */
    double const about_c = 2 * a * b * (a * a + b * b) / 12 + 2 * b * c * (b * b / 12 + a * a / 4) +
                           2 * a * c * (a * a / 12 + b * b / 4);
    expect_near(plates.moments.z, about_c, 1e-12);
    tulle_mesh_destroy(&box);
    /* a flat, open sheet has a surface, but no volume */
    tulle_shape_def def = tulle_shape_def_default(TULLE_SHAPE_RECTANGLE);
    def.size[0] = 2.0, def.size[1] = 1.0;
    tulle_mesh sheet = generate(&def);
    mass_properties const lamina = find(&sheet, MASS_ON_SURFACE);
    expect_near(lamina.moments.x, 2.0 / 12, 1e-12);
    expect_near(lamina.moments.y, 2.0 * 4.0 / 12, 1e-12);
    expect_near(lamina.moments.z, 2.0 * 5.0 / 12, 1e-12);
    expect_error(&sheet, MASS_IN_VOLUME, "open at the edge");
    tulle_mesh_destroy(&sheet);
    /* a thin ring: m R^2 about its axis, from inscribed polygons to within their sagitta */
    def = tulle_shape_def_default(TULLE_SHAPE_TORUS);
    def.radius = 0.1, def.inner_radius = 0.005;
    def.resolution[0] = 200, def.resolution[1] = 24;
    tulle_mesh ring = generate(&def);
    mass_properties const shell = find(&ring, MASS_ON_SURFACE);
    expect_near(shell.measure, 4 * PI * PI * 0.1 * 0.005, 5e-3);
    expect_near(shell.moments.z / shell.measure, 0.1 * 0.1 + 1.5 * 0.005 * 0.005, 2e-3);
    tulle_mesh_destroy(&ring);
}

/* Both meshes in one. */
static tulle_mesh join(const tulle_mesh *a, const tulle_mesh *b) {
    tulle_mesh both = {0};
    tulle_status const status = tulle_mesh_create(
        a->vertex_count + b->vertex_count, a->triangle_count + b->triangle_count, &both, NULL);
    assert_int_equal(status, TULLE_OK);
    memcpy(both.positions, a->positions, 3 * a->vertex_count * sizeof(double));
    memcpy(both.positions + 3 * a->vertex_count, b->positions,
           3 * b->vertex_count * sizeof(double));
    memcpy(both.triangles, a->triangles, 3 * a->triangle_count * sizeof(uint32_t));
    for (size_t i = 0; i < 3 * b->triangle_count; i++)
        both.triangles[3 * a->triangle_count + i] = b->triangles[i] + (uint32_t)a->vertex_count;
    return both;
}

static void flip(tulle_mesh *mesh) {
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        uint32_t const kept = mesh->triangles[3 * t];
        mesh->triangles[3 * t] = mesh->triangles[3 * t + 1];
        mesh->triangles[3 * t + 1] = kept;
    }
}

static void test_cavities_and_errors(void **state) {
    (void)state;
    tulle_mesh outer = make_box(1.0, 1.0, 1.0), inner = make_box(0.5, 0.5, 0.5);
    tulle_mesh twice = join(&outer, &inner);
    expect_error(&twice, MASS_IN_VOLUME, "lies inside it");
    flip(&inner);
    tulle_mesh hollow = join(&outer, &inner);
    mass_properties const body = find(&hollow, MASS_IN_VOLUME);
    expect_near(body.measure, 1.0 - 0.125, 1e-13);
    expect_near(body.moments.x, (1.0 - 0.03125) / 6.0, 1e-12);
    expect_error(&inner, MASS_IN_VOLUME, "inside out");
    const double one[3] = {1, 1, 1}, none[4] = {1, 0, 0, 0}, aside[3] = {3, 0, 0};
    tulle_mesh_transform(&inner, one, none, aside);
    tulle_mesh pair = join(&outer, &inner);
    expect_error(&pair, MASS_IN_VOLUME, "inside out");
    /* one triangle turned; one taken away */
    uint32_t const corner = outer.triangles[0];
    outer.triangles[0] = outer.triangles[1];
    outer.triangles[1] = corner;
    expect_error(&outer, MASS_IN_VOLUME, "opposite ways");
    outer.triangle_count--;
    outer.triangles[1] = outer.triangles[0];
    outer.triangles[0] = corner;
    expect_error(&outer, MASS_IN_VOLUME, "open at the edge");
    tulle_mesh_view const nothing = {0};
    memory heap = memory_default();
    mass_properties found;
    assert_int_equal(mass_properties_compute(&heap, nothing, MASS_ON_SURFACE, "none", &found, NULL),
                     TULLE_ERROR_INVALID_MESH);
    /* all on a line: a surface without area */
    double line[9] = {0, 0, 0, 1, 0, 0, 2, 0, 0};
    uint32_t corners[3] = {0, 1, 2};
    tulle_mesh const thread = {line, 3, corners, 1};
    expect_error(&thread, MASS_ON_SURFACE, "extent");
    outer.triangle_count++;
    tulle_mesh *const made[] = {&outer, &inner, &twice, &hollow, &pair};
    for (size_t i = 0; i < sizeof made / sizeof *made; i++) tulle_mesh_destroy(made[i]);
}

static void test_no_memory(void **state) {
    (void)state;
    tulle_mesh mesh = make_box(1.0, 1.0, 1.0);
    tulle_status status = TULLE_ERROR_OUT_OF_MEMORY;
    int failures = 0;
    for (; status != TULLE_OK; failures++) {
        int left = failures;
        memory heap = failing_heap_make(&left);
        mass_properties found;
        status = mass_properties_compute(&heap, tulle_mesh_get_view(&mesh), MASS_IN_VOLUME, "box",
                                         &found, NULL);
        assert_true(status == TULLE_OK || status == TULLE_ERROR_OUT_OF_MEMORY);
        assert_int_equal(heap.bytes_held, 0);
    }
    assert_true(failures > 5);
    tulle_mesh_destroy(&mesh);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_boxes_anywhere), cmocka_unit_test(test_solids_against_fluxes),
        cmocka_unit_test(test_shells), cmocka_unit_test(test_cavities_and_errors),
        cmocka_unit_test(test_no_memory)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
