/* Polygons cut into triangles: those of the cut face the way of the polygon, and their sides are
 * the sides of the polygon and pairs of opposite diagonals. The winding number then says that they
 * cover the inside once and nothing else. */
#include "geom/cut_polygon.h"

#include "base/hash.h"
#include "math/vec3.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { CORNERS_MAX = 400 };

/* Corners in space, and the triangles that a cut makes of them. */
typedef struct sample {
    uint32_t count, corners[CORNERS_MAX];
    double positions[3 * CORNERS_MAX];
    uint32_t triangles[3 * CORNERS_MAX];
} sample;

static void add_corner(sample *s, double x, double y) {
    s->corners[s->count] = s->count;
    memcpy(s->positions + 3 * s->count++, (double[3]){x, y, 0.0}, 3 * sizeof(double));
}

static void make_fan(sample *s) {
    for (uint32_t i = 0; i + 2 < s->count; i++) {
        s->triangles[3 * i] = s->corners[0];
        s->triangles[3 * i + 1] = s->corners[i + 1];
        s->triangles[3 * i + 2] = s->corners[i + 2];
    }
}

/* Cuts, and gives the cutter. */
static polygon_cutter cut(sample *s) {
    static memory heap;
    heap = memory_default();
    polygon_cutter cutter = {.heap = &heap, .path = "a.obj", .place = "line", .number = 7};
    tulle_error error = {0};
    make_fan(s);
    assert_int_equal(polygon_cut(&cutter, s->positions, s->triangles, s->count - 2, &error), 0);
    for (uint32_t i = 0; cutter.corners && i < 3 * (s->count - 2); i++)
        assert_int_equal(s->corners[cutter.corners[i]], s->triangles[i]);
    return cutter;
}

static void finish(polygon_cutter cutter, size_t bent, size_t crossed) {
    assert_int_equal(cutter.bent_count, bent);
    assert_int_equal(cutter.crossed_count, crossed);
    polygon_cutter_destroy(&cutter);
}

/* Signed uses of the side between two vertices. */
static int count_uses(const sample *s, uint32_t a, uint32_t b, bool of_polygon) {
    int uses = 0;
    uint32_t const count = of_polygon ? s->count : 3 * (s->count - 2);
    for (uint32_t i = 0; i < count; i++) {
        uint32_t const from = of_polygon ? s->corners[i] : s->triangles[i];
        uint32_t const to =
            of_polygon ? s->corners[(i + 1) % count] : s->triangles[i / 3 * 3 + (i + 1) % 3];
        uses += (from == a && to == b) - (from == b && to == a);
    }
    return uses;
}

static double measure_area(const sample *s, uint32_t triangle, vec3 normal) {
    const uint32_t *const t = s->triangles + 3 * triangle;
    vec3 const a = vec3_load(s->positions, t[0]);
    return 0.5 * vec3_dot(normal, vec3_cross(vec3_sub(vec3_load(s->positions, t[1]), a),
                                             vec3_sub(vec3_load(s->positions, t[2]), a)));
}

/* normal: of length 1. Returns the area. */
static double expect_cover(const sample *s, vec3 normal, double least_area) {
    double sum = 0.0;
    for (uint32_t i = 0; i + 2 < s->count; i++) {
        double const area = measure_area(s, i, normal);
        assert_true(area > least_area);
        sum += area;
    }
    for (uint32_t i = 0; i < 3 * (s->count - 2); i++) {
        uint32_t const from = s->triangles[i], to = s->triangles[i / 3 * 3 + (i + 1) % 3];
        assert_int_equal(count_uses(s, from, to, false), count_uses(s, from, to, true));
    }
    for (uint32_t i = 0; i < s->count; i++) {
        uint32_t const from = s->corners[i], to = s->corners[(i + 1) % s->count];
        assert_int_equal(count_uses(s, from, to, false), count_uses(s, from, to, true));
    }
    return sum;
}

static const vec3 up = {0.0, 0.0, 1.0};

static void make(sample *s, const double (*points)[2], size_t count) {
    s->count = 0;
    for (size_t i = 0; i < count; i++) add_corner(s, points[i][0], points[i][1]);
}
#define MAKE(s, points) make(s, points, sizeof points / sizeof points[0])

static void convex_polygons_keep_their_fan(void **unused) {
    (void)unused;
    static const double points[][2] = {{0, 0}, {2, 0}, {3, 1}, {2, 3}, {0, 2}};
    for (size_t count = 3; count <= 5; count++) {
        sample s, fan;
        make(&s, points, count);
        fan = s;
        make_fan(&fan);
        polygon_cutter const cutter = cut(&s);
        assert_null(cutter.corners);
        assert_memory_equal(s.triangles, fan.triangles, 3 * (count - 2) * sizeof(uint32_t));
        finish(cutter, 0, 0);
    }
    sample s = {0};
    for (int i = 0; i < CORNERS_MAX; i++)
        add_corner(&s, cos(i * 6.283185307179586 / CORNERS_MAX),
                   sin(i * 6.283185307179586 / CORNERS_MAX));
    polygon_cutter const cutter = cut(&s);
    assert_null(cutter.corners);
    finish(cutter, 0, 0);
}

static void concave_polygons_are_cut_within(void **unused) {
    (void)unused;
    static const double l[][2] = {{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}};
    static const double arrow[][2] = {{-1, 0}, {0, 3}, {1, 0}, {0, 1}};
    for (uint32_t turn = 0; turn < 6; turn++) {
        sample s = {0};
        for (uint32_t i = 0; i < 6; i++) add_corner(&s, l[(i + turn) % 6][0], l[(i + turn) % 6][1]);
        finish(cut(&s), 0, 0);
        assert_true(expect_cover(&s, up, 0.1) == 3.0);
    }
    for (uint32_t turn = 0; turn < 4; turn++) {
        sample s = {0};
        for (uint32_t i = 0; i < 4; i++)
            add_corner(&s, arrow[(i + turn) % 4][0], arrow[(i + turn) % 4][1]);
        finish(cut(&s), 0, 0);
        assert_true(expect_cover(&s, vec3_neg(up), 0.1) == 2.0);
    }
}

static void straight_corners_make_no_sliver(void **unused) {
    (void)unused;
    static const double pentagon[][2] = {{0, 0}, {0.5, 0}, {1, 0}, {1, 1}, {0, 1}};
    static const double triangle[][2] = {{0, 0}, {1, 0}, {2, 0}, {1, 1}, {0, 2}, {0, 1}};
    for (uint32_t turn = 0; turn < 5; turn++)
        for (int k = -1; k <= 1; k++) { /* the corner lies off the side by what rounding leaves */
            sample s = {0};
            for (uint32_t i = 0; i < 5; i++) {
                uint32_t const n = (i + turn) % 5;
                add_corner(&s, pentagon[n][0], pentagon[n][1] + (n == 1 ? 1e-8 * k : 0.0));
            }
            finish(cut(&s), 0, 0);
            assert_true(fabs(expect_cover(&s, up, 0.2) - 1.0) < 1e-7);
        }
    sample s;
    MAKE(&s, triangle);
    finish(cut(&s), 0, 0);
    assert_true(expect_cover(&s, up, 0.1) == 2.0);
}

/* A square with a square hole, joined by a bridge: two corners come twice. */
static void holes_stay_open(void **unused) {
    (void)unused;
    static const double points[][2] = {{0, 0}, {4, 0}, {4, 4}, {0, 4},
                                       {1, 1}, {1, 3}, {3, 3}, {3, 1}};
    static const uint32_t around[] = {0, 1, 2, 3, 0, 4, 5, 6, 7, 4};
    for (uint32_t turn = 0; turn < 10; turn++) {
        sample s;
        MAKE(&s, points);
        s.count = 10;
        for (uint32_t i = 0; i < 10; i++) s.corners[i] = around[(i + turn) % 10];
        finish(cut(&s), 0, 0);
        assert_true(expect_cover(&s, up, 0.1) == 12.0);
    }
}

/* The outline of squares of a grid that hang together, with a corner at each point of the grid on
 * it. False where it has a hole or meets itself. */
static bool make_outline(sample *s, uint64_t *state) {
    enum { SIDE = 7 };
    bool is_in[SIDE + 2][SIDE + 2] = {{false}};
    int x = SIDE / 2 + 1, y = x, cells = 0;
    for (int i = 0; i < 25; i++) {
        cells += !is_in[x][y];
        is_in[x][y] = true;
        double const way = random_uniform(state);
        x += (way < 0.25) - (way >= 0.25 && way < 0.5);
        y += (way >= 0.5 && way < 0.75) - (way >= 0.75);
        x = x < 1 ? 1 : x > SIDE ? SIDE : x;
        y = y < 1 ? 1 : y > SIDE ? SIDE : y;
    }
    int from_x = 1, from_y = 1, sides = 0;
    for (int i = 1; i <= SIDE; i++)
        for (int j = 1; j <= SIDE; j++) {
            if (is_in[i][j] && !is_in[i][j - 1]) from_x = i, from_y = j;
            sides += is_in[i][j] *
                     (!is_in[i + 1][j] + !is_in[i - 1][j] + !is_in[i][j + 1] + !is_in[i][j - 1]);
            bool const meets = is_in[i][j] == is_in[i + 1][j + 1] &&
                               is_in[i + 1][j] == is_in[i][j + 1] && is_in[i][j] != is_in[i + 1][j];
            if (meets) return false;
        }
    /* Point (x, y) is the low corner of the square (x, y), which lies to the left of the way. */
    int const turns[4][2] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}};
    int at_x = from_x, at_y = from_y, way = 0;
    s->count = 0;
    do {
        add_corner(s, at_x, at_y);
        at_x += turns[way][0];
        at_y += turns[way][1];
        for (int k = 3; k < 6; k++) { /* right, ahead, left */
            int const next = (way + k) % 4, dx = turns[next][0], dy = turns[next][1];
            int const left_x = at_x + (dx - dy - 1) / 2, left_y = at_y + (dx + dy - 1) / 2;
            int const right_x = at_x + (dx + dy - 1) / 2, right_y = at_y + (dy - dx - 1) / 2;
            if (is_in[left_x][left_y] && !is_in[right_x][right_y]) {
                way = next;
                break;
            }
        }
    } while (at_x != from_x || at_y != from_y);
    return (int)s->count == sides && cells > 1;
}

/* Turns a sample to a plane in space, where positions are rounded. Gives the normal. */
static vec3 turn_over(sample *s, uint64_t *state) {
    vec3 const normal = vec3_normalize(vec3_make(
        random_uniform(state) - 0.5, random_uniform(state) - 0.5, random_uniform(state) - 0.5));
    vec3 const u = vec3_normalize(vec3_cross(normal, vec3_make(1.0, 0.3, 0.2)));
    vec3 const v = vec3_cross(normal, u);
    for (uint32_t i = 0; i < s->count; i++) {
        vec3 const x = vec3_load(s->positions, i);
        vec3 const y = vec3_add(vec3_scale(u, x.x), vec3_scale(v, x.y));
        vec3_store(s->positions, i,
                   vec3_make((double)(float)y.x, (double)(float)y.y, (double)(float)(y.z + 9.0)));
    }
    return normal;
}

static void outlines_of_squares_are_cut_into_halves(void **unused) {
    (void)unused;
    uint64_t state = 3;
    int tried = 0;
    for (int i = 0; i < 2000 && tried < 300; i++) {
        sample s;
        if (!make_outline(&s, &state)) continue;
        tried++;
        sample turned = s;
        finish(cut(&s), 0, 0);
        expect_cover(&s, up, 0.49);
        vec3 const normal = turn_over(&turned, &state);
        finish(cut(&turned), 0, 0);
        expect_cover(&turned, normal, 0.49);
    }
    assert_int_equal(tried, 300);
}

static void stars_and_spirals_are_cut_within(void **unused) {
    (void)unused;
    uint64_t state = 8;
    for (int i = 0; i < 300; i++) {
        sample s = {0};
        uint32_t const count = 4 + (uint32_t)(60.0 * random_uniform(&state));
        for (uint32_t k = 0; k < count; k++) {
            double const angle = 6.283185307179586 * (k + 0.9 * random_uniform(&state)) / count;
            double const radius = 0.05 + random_uniform(&state);
            add_corner(&s, radius * cos(angle), radius * sin(angle));
        }
        vec3 const normal = turn_over(&s, &state);
        polygon_cutter cutter = cut(&s);
        finish(cutter, 0, 0);
        expect_cover(&s, normal, 0.0);
    }
    sample s = {0};
    for (int side = 0; side < 2; side++)
        for (int i = 0; i < 150; i++) {
            double const angle = 0.1 * (side ? 149 - i : i), radius = 1.0 + 0.5 * angle;
            add_corner(&s, (radius + side) * cos(angle), (radius + side) * sin(angle));
        }
    finish(cut(&s), 0, 0);
    expect_cover(&s, vec3_neg(up), 1e-4);
}

static void faults_are_told(void **unused) {
    (void)unused;
    static const double bow_tie[][2] = {{0, 0}, {2, 2}, {2, 0}, {0, 1}};
    static const double even_bow_tie[][2] = {{0, 0}, {1, 1}, {1, 0}, {0, 1}};
    static const double twice_around[][2] = {{0, 0}, {4, 0}, {2, 4}, {0.5, 1}, {3, 1}, {2, 3}};
    static const double line[][2] = {{0, 0}, {1, 0}, {3, 0}, {2, 0}};
    sample s;
    MAKE(&s, bow_tie), finish(cut(&s), 0, 1);
    MAKE(&s, even_bow_tie), finish(cut(&s), 0, 1);
    MAKE(&s, twice_around), finish(cut(&s), 0, 1);
    MAKE(&s, line), finish(cut(&s), 0, 1);
    static const double square[][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    MAKE(&s, square);
    s.positions[5] = 0.005;
    finish(cut(&s), 0, 0);
    s.positions[5] = 0.1;
    polygon_cutter const cutter = cut(&s);
    assert_null(cutter.corners);
    char text[200];
    polygon_cutter_describe(&cutter, text, sizeof text);
    assert_string_equal(text, "1 polygon is not flat (line 7)");
    finish(cutter, 1, 0);
}

static void repeated_corners_take_a_triangle_each(void **unused) {
    (void)unused;
    static const double points[][2] = {{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}};
    sample s;
    MAKE(&s, points);
    s.count = 7;
    memcpy(s.corners, (uint32_t[]){0, 1, 2, 2, 3, 4, 5}, 7 * sizeof(uint32_t));
    finish(cut(&s), 0, 0);
    int without_area = 0;
    double area = 0.0;
    for (uint32_t i = 0; i < 5; i++) {
        without_area += measure_area(&s, i, up) == 0.0;
        area += measure_area(&s, i, up);
    }
    assert_int_equal(without_area, 1);
    assert_true(area == 3.0);
}

static void too_many_corners_are_refused(void **unused) {
    (void)unused;
    size_t const count = POLYGON_CORNER_LIMIT + 2;
    memory heap = memory_default();
    double *const positions = calloc(3 * count, sizeof *positions);
    uint32_t *const triangles = calloc(3 * count, sizeof *triangles);
    for (size_t i = 0; i < count; i++) {
        double const angle = 6.283185307179586 * (double)i / (double)count;
        positions[3 * i] = (i % 2 ? 1.0 : 1.5) * cos(angle);
        positions[3 * i + 1] = (i % 2 ? 1.0 : 1.5) * sin(angle);
    }
    for (size_t i = 0; i + 2 < count; i++) {
        triangles[3 * i + 1] = (uint32_t)i + 1;
        triangles[3 * i + 2] = (uint32_t)i + 2;
    }
    polygon_cutter cutter = {.heap = &heap, .path = "a.obj", .place = "line", .number = 7};
    tulle_error error = {0};
    assert_int_equal(polygon_cut(&cutter, positions, triangles, count - 2, &error),
                     TULLE_ERROR_LIMIT);
    assert_non_null(strstr(error.message, "line 7"));
    assert_int_equal(polygon_cut(&cutter, positions, triangles, count - 4, &error), TULLE_OK);
    assert_non_null(cutter.corners);
    polygon_cutter_destroy(&cutter);
    free(positions);
    free(triangles);
}

/* A polygon, and twice more the same: its corners from `start` on, backwards, as vertices of their
 * own; and from the second one on, forwards. Texture coordinates are the vertices. */
static void expect_doubles(const double (*points)[2], uint32_t count, uint32_t start) {
    memory heap = memory_default();
    sample s[3];
    double positions[6 * CORNERS_MAX];
    uint32_t triangles[9 * CORNERS_MAX], uvs[9 * CORNERS_MAX];
    polygon_fan fans[3];
    uint32_t const third = 3 * (count - 2);
    for (uint32_t k = 0; k < 3; k++) {
        make(&s[k], points, count);
        for (uint32_t i = 0; i < count; i++)
            s[k].corners[i] = k == 0   ? i
                              : k == 1 ? count + (start + count - i) % count
                                       : (i + 1) % count;
        make_fan(&s[k]);
        memcpy(triangles + k * third, s[k].triangles, third * sizeof(uint32_t));
        fans[k] = (polygon_fan){k * (count - 2), count - 2, k, true};
    }
    for (size_t k = 0; k < 2; k++)
        memcpy(positions + 3 * k * count, s[0].positions, 3 * count * sizeof(double));
    memcpy(uvs, triangles, 3 * third * sizeof(uint32_t));
    polygon_cutter alone = cut(&s[0]), cutter = {.heap = &heap, .path = "a.obj", .place = "line"};
    polygon_list const list = {positions, triangles, uvs, fans, 3};
    tulle_error error;
    assert_int_equal(polygons_cut(&cutter, &list, &error), TULLE_OK);
    assert_memory_equal(triangles, uvs, 3 * third * sizeof(uint32_t));
    assert_memory_equal(triangles, s[0].triangles, third * sizeof(uint32_t));
    assert_memory_equal(triangles, triangles + 2 * third, third * sizeof(uint32_t));
    static const uint32_t turned[3] = {0, 2, 1};
    for (uint32_t i = 0; i < third; i++)
        assert_int_equal(triangles[third + i], count + triangles[i / 3 * 3 + turned[i % 3]]);
    finish(cutter, 0, 0);
    finish(alone, 0, 0);
}

static void doubles_are_cut_alike(void **unused) {
    (void)unused;
    static const double square[][2] = {{-0.0, 0}, {1, 0}, {1, 1}, {0, 1}},
                        pentagon[][2] = {{0, 0}, {2, 0}, {3, 1}, {2, 3}, {0, 2}},
                        corner[][2] = {{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}},
                        frame[][2] = {{0, 0}, {3, 0}, {3, 3}, {0, 3}, {0, 0},
                                      {1, 1}, {1, 2}, {2, 2}, {2, 1}, {1, 1}};
    for (uint32_t start = 0; start < 4; start++) expect_doubles(square, 4, start);
    for (uint32_t start = 0; start < 5; start++) expect_doubles(pentagon, 5, start);
    for (uint32_t start = 0; start < 6; start++) expect_doubles(corner, 6, start);
    for (uint32_t start = 0; start < 10; start++) expect_doubles(frame, 10, start);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(convex_polygons_keep_their_fan),
        cmocka_unit_test(concave_polygons_are_cut_within),
        cmocka_unit_test(straight_corners_make_no_sliver),
        cmocka_unit_test(holes_stay_open),
        cmocka_unit_test(outlines_of_squares_are_cut_into_halves),
        cmocka_unit_test(stars_and_spirals_are_cut_within),
        cmocka_unit_test(faults_are_told),
        cmocka_unit_test(repeated_corners_take_a_triangle_each),
        cmocka_unit_test(too_many_corners_are_refused),
        cmocka_unit_test(doubles_are_cut_alike),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
