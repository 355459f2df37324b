/* Vertices of a cloth by name, in a sphere, near an obstacle: for pins, attachments, regions and
 * creases, against the rows that a file was written with and distances found by brute force. */
#define _POSIX_C_SOURCE 200809L
#include "scene/scene_data.h"
#include "scene_text.h"

#include <math.h>

#define TIME "time: {frames: 3, step: 10 ms}\n"
#define TABLE "obstacles:\n  - {name: table, mesh: {shape: plane}, translate: [0, 0, -50]}\n"

enum { SIDE = 7, ROW = 2 * (SIDE - 1) /* triangles of a row of squares */ };

/* A sheet of 7 by 7 vertices. Rows 0 and 1 of squares are the group hem, row 1 also band, row 4 is
 * a material, rows 3 to 5 are an object; hem comes back in row 3, so that the corners of row 2 all
 * belong to it and its triangles do not. */
static void write_sheet(void) {
    char text[6000], *end = text;
    for (int y = 0; y < SIDE; y++)
        for (int x = 0; x < SIDE; x++) end += sprintf(end, "v %d %d 0\n", x, y);
    static const char *const before[SIDE - 1] = {
        "g hem\n", "g hem band\n", "g\n", "o upper part\ng hem\n", "g\nusemtl Blue\n", "usemtl\n"};
    for (int y = 0; y < SIDE - 1; y++) {
        end += sprintf(end, "%s", before[y]);
        for (int x = 0; x < SIDE - 1; x++) {
            int const a = y * SIDE + x + 1;
            end += sprintf(end, "f %d %d %d\nf %d %d %d\n", a, a + 1, a + SIDE + 1, a, a + SIDE + 1,
                           a + SIDE);
        }
    }
    write_text_file("sheet.obj", text);
}

typedef struct named_rows {
    const char *choice;
    unsigned rows; /* bit y: row y of squares */
} named_rows;
static const named_rows named[] = {{"group: hem", 1 << 0 | 1 << 1 | 1 << 3},
                                   {"group: band", 1 << 1},
                                   {"group: upper part", 7 << 3},
                                   {"material: Blue", 1 << 4}};
enum { NAMED_COUNT = sizeof named / sizeof named[0] };

static tulle_scene *load_sheet(const char *format, const char *choice) {
    char text[600];
    int used = snprintf(text, sizeof text, TIME "cloth:\n  - mesh: {file: sheet.obj}\n    ");
    used += snprintf(text + used, sizeof text - (size_t)used, format, choice);
    snprintf(text + used, sizeof text - (size_t)used, "\n" TABLE);
    return load_good(text);
}

static bool is_vertex_of(unsigned rows, uint32_t vertex) {
    unsigned const y = vertex / SIDE; /* of the squares below and above */
    return (rows >> y & 1) || (y > 0 && rows >> (y - 1) & 1);
}

static void expect_vertices(const uint32_t *vertices, size_t count, unsigned rows) {
    size_t next = 0;
    for (uint32_t v = 0; v < SIDE * SIDE; v++) {
        if (!is_vertex_of(rows, v)) continue;
        assert_true(next < count && vertices[next] == v);
        next++;
    }
    assert_int_equal(next, count);
}

static void test_names_choose_vertices(void **state) {
    (void)state;
    write_sheet();
    for (int i = 0; i < NAMED_COUNT; i++) {
        tulle_scene *loaded = load_sheet("pins: [{%s}]", named[i].choice);
        const tulle_pin *const pin = &loaded->cloths[0].pins[0];
        expect_vertices(pin->vertices, pin->vertex_count, named[i].rows);
        tulle_scene_destroy(loaded);
        loaded = load_sheet("attach: [{%s, to: table}]", named[i].choice);
        const scene_attachment *const made = &loaded->cloths[0].attachments[0];
        expect_vertices(made->vertices, made->vertex_count, named[i].rows);
        tulle_scene_destroy(loaded);
    }
}

/* The triangles of the part, and no others. */
static void test_names_choose_triangles(void **state) {
    (void)state;
    write_sheet();
    for (int i = 0; i < NAMED_COUNT; i++) {
        tulle_scene *const loaded =
            load_sheet("regions: [{%s, grain: [0, 1, 0]}]", named[i].choice);
        const scene_cloth *const cloth = &loaded->cloths[0];
        assert_non_null(cloth->warps);
        for (size_t t = 0; t < cloth->mesh.triangle_count; t++) {
            bool const is_in = named[i].rows >> t / ROW & 1;
            assert_true(fabs(cloth->warps[3 * t + is_in] - 1) < 1e-12);
        }
        tulle_scene_destroy(loaded);
    }
}

static void test_names_choose_creases(void **state) {
    (void)state;
    write_sheet();
    for (int i = 0; i < NAMED_COUNT; i++) {
        tulle_scene *const loaded =
            load_sheet("rest: {creases: [{%s, angle: 1}]}", named[i].choice);
        const scene_cloth *const cloth = &loaded->cloths[0];
        /* Every edge that two triangles share, once, where both ends belong to the part. */
        size_t expected = 0;
        for (uint32_t a = 0; a < SIDE * SIDE; a++)
            for (uint32_t step = 1; step <= SIDE + 1; step++) {
                uint32_t const x = a % SIDE, y = a / SIDE, b = a + step;
                bool const is_edge = step == 1          ? x < SIDE - 1
                                     : step == SIDE     ? y < SIDE - 1
                                     : step == SIDE + 1 ? x < SIDE - 1 && y < SIDE - 1
                                                        : false;
                /* Of the edges at the border the lower and the right ones run upwards in their
                 * one triangle; they are listed and nothing folds there. */
                bool const is_last = (step == 1 && y == SIDE - 1) || (step == SIDE && x == 0);
                if (is_edge && !is_last && is_vertex_of(named[i].rows, a) &&
                    is_vertex_of(named[i].rows, b))
                    expected++;
            }
        assert_int_equal(cloth->crease_count, expected);
        tulle_scene_destroy(loaded);
    }
}

static void test_sphere(void **state) {
    (void)state;
    write_sheet();
    tulle_scene *const loaded =
        load_sheet("pins: [{sphere: {%s}}]", "center: [2, 3, 1], radius: 2.3 m");
    const tulle_pin *const pin = &loaded->cloths[0].pins[0];
    size_t next = 0;
    for (int v = 0; v < SIDE * SIDE; v++) {
        int const x = v % SIDE - 2, y = v / SIDE - 3;
        if (x * x + y * y + 1 > 2.3 * 2.3) continue;
        assert_true(next < pin->vertex_count && pin->vertices[next++] == (uint32_t)v);
    }
    assert_int_equal(next, pin->vertex_count);
    tulle_scene_destroy(loaded);
}

/* At most the distance of `p` from the obstacle, and at least that less the sampling's step: the
 * distance from the nearest of points laid densely over all triangles. */
static double sample_distance(tulle_mesh_view mesh, const double *p, double *step) {
    enum { PARTS = 20 };
    double nearest = 1e300;
    *step = 0.0;
    for (size_t t = 0; t < mesh.triangle_count; t++) {
        const double *corners[3];
        for (size_t k = 0; k < 3; k++)
            corners[k] = mesh.positions + 3 * (size_t)mesh.triangles[3 * t + k];
        for (int k = 0; k < 3; k++) {
            const double *const a = corners[k], *const b = corners[(k + 1) % 3];
            *step = fmax(*step, hypot(hypot(a[0] - b[0], a[1] - b[1]), a[2] - b[2]) / PARTS);
        }
        for (int i = 0; i <= PARTS; i++)
            for (int j = 0; i + j <= PARTS; j++) {
                double squared = 0.0;
                for (int k = 0; k < 3; k++) {
                    double const d = corners[0][k] * (PARTS - i - j) + corners[1][k] * i +
                                     corners[2][k] * j - PARTS * p[k];
                    squared += d * d;
                }
                nearest = fmin(nearest, sqrt(squared) / PARTS);
            }
    }
    return nearest;
}

/* Vertices within a distance of an obstacle of all shapes and sizes against the grid. */
static void expect_near(const char *obstacle, const char *sheet, double within) {
    char text[700];
    snprintf(text, sizeof text,
             TIME "cloth:\n  - {%s, pins: [{near: {to: it, within: %g}}]}\n"
                  "obstacles:\n  - {name: other, mesh: {shape: box}, translate: [0, 0, 0.05]}\n"
                  "  - {name: it, %s}\n",
             sheet, within, obstacle);
    tulle_scene *const loaded = load_good(text);
    tulle_mesh_view const cloth = tulle_scene_get_cloth_mesh(loaded, 0);
    const tulle_pin *const pin = &loaded->cloths[0].pins[0];
    size_t next = 0, certain[2] = {0, 0};
    for (uint32_t v = 0; v < cloth.vertex_count; v++) {
        double distance = 1e300, step = 0.0;
        for (size_t i = 1; i < tulle_scene_get_obstacle_count(loaded); i++) {
            double one_step;
            distance = fmin(distance, sample_distance(tulle_scene_get_obstacle_mesh(loaded, i),
                                                      cloth.positions + 3 * v, &one_step));
            step = fmax(step, one_step);
        }
        bool const is_pinned = next < pin->vertex_count && pin->vertices[next] == v;
        next += is_pinned;
        if (distance <= within) assert_true(is_pinned);
        if (distance > within + step) assert_false(is_pinned);
        certain[0] += distance <= within;
        certain[1] += distance > within + step;
    }
    assert_int_equal(next, pin->vertex_count);
    if (certain[0] == 0 || certain[1] == 0) fail_msg("%s, %s: no test", obstacle, sheet);
    tulle_scene_destroy(loaded);
}

static void test_near(void **state) {
    (void)state;
    static const char *const sheets[] = {
        "mesh: {shape: rectangle, size: [1, 1], resolution: [17, 13]}",
        "mesh: {shape: ribbon, size: [2, 0.05], resolution: [101, 2]}, rotate: [0.5, 0.4, 0.3]",
        "mesh: {shape: tube, radius: 0.3, height: 1, resolution: [20, 15]}, rotate: [1, 0, 0]"};
    static const char *const obstacles[] = {
        "mesh: {shape: sphere, radius: 0.1, resolution: [6]}, translate: [0.2, 0, 0]",
        "mesh: {shape: tetrahedron, radius: 1, height: 0.2}, translate: [0.6, 0, -0.19]",
        ("mesh: {shape: needle, radius: 0.01, height: 0.5, resolution: [3]}, rotate: [0, 1, 0], "
         "copies: {ring: {count: 3, radius: 0.05}}")};
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++) expect_near(obstacles[k], sheets[i], 0.08);
    expect_near(obstacles[0], sheets[0], 0.5);
}

static void refuse(const char *entry, const char *words) {
    char text[900];
    tulle_scene_problems *const problems = calloc(1, sizeof *problems);
    assert_non_null(problems);
    snprintf(text, sizeof text, TIME "cloth:\n  - mesh: {file: sheet.obj}\n    %s\n" TABLE, entry);
    assert_null(load_text(text, problems));
    if (problems->total_count != 1 || problems->list[0].line != 4 || problems->list[0].column < 1 ||
        !strstr(problems->list[0].message, words))
        fail_msg("%zu problems, line %d: %s", problems->total_count, problems->list[0].line,
                 problems->list[0].message);
    free(problems);
}

static void test_problems_have_a_place(void **state) {
    (void)state;
    write_sheet();
    refuse("pins: [{group: hen}]",
           "cloth[0].pins[0].group: the mesh file has no 'hen'; it has hem, "
           "band, upper part; did you mean 'hem'?");
    refuse("pins: [{group: Blue}]", "the mesh file has no 'Blue'; it has hem, band, upper part");
    refuse("attach: [{material: blue, to: table}]",
           "cloth[0].attach[0].material: the mesh file has no 'blue'; it has Blue; did you mean "
           "'Blue'?");
    refuse("regions: [{group: hen, shrink: 0.9}]", "cloth[0].regions[0].group: the mesh file has");
    refuse("rest: {creases: [{material: x, angle: 1}]}",
           "cloth[0].rest.creases[0].material: the mesh file has no 'x'; it has Blue");
    refuse("pins: [{near: {to: tabel, within: 1}}]",
           "cloth[0].pins[0].near.to: no obstacle is called 'tabel'; did you mean 'table'?");
    refuse("pins: [{near: {to: cloth0, within: 1}}]", "no obstacle is called 'cloth0'");
    refuse("pins: [{near: {to: table, within: 1 cm}}]", "pins no vertex");
    refuse("pins: [{near: {to: table}}]", "within");
    refuse("pins: [{sphere: {center: [90, 0, 0], radius: 1}}]", "pins no vertex");
    refuse("pins: [{sphere: {center: [0, 0, 0], radius: 0}}]", "radius");
    refuse("pins: [{group: hem, material: Blue}]", "only one of the keys");
    /* Meshes without names. */
    write_text_file("sheet.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n");
    refuse("pins: [{group: hem}]", "the mesh has no groups; only OBJ files have them");
    refuse("pins: [{material: hem}]", "the mesh has no materials; only OBJ files have them");
    /* A message lists a few of many names, and finds the one that was meant among all. */
    char many[9000], *end = many;
    end += sprintf(end, "v 0 0 0\nv 1 0 0\nv 1 1 0\ng");
    for (int i = 0; i < 500; i++) end += sprintf(end, " name%d", i);
    sprintf(end, " zebra\nf 1 2 3\n");
    write_text_file("sheet.obj", many);
    refuse("pins: [{group: zebr}]", "name18, name19, ...; did you mean 'zebra'?");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_names_choose_vertices),
        cmocka_unit_test(test_names_choose_triangles),
        cmocka_unit_test(test_names_choose_creases),
        cmocka_unit_test(test_sphere),
        cmocka_unit_test(test_near),
        cmocka_unit_test(test_problems_have_a_place),
    };
    return cmocka_run_group_tests(tests, NULL, remove_folder);
}
