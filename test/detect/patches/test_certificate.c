/* What certificates prove must be so: contours that are proven simple stay so at sampled times for
 * random displacements within the reach, in exact arithmetic; contours that touch themselves are
 * never proven, those far from it are. */
#include "detect/patches/certificate.h"

#include "detect/patches/planar_contour.h"
#include "geom/exact_predicates.h"
#include "support/test_support.h"
#include "support/wide_normals.h"

#include <stdlib.h>
#include <string.h>

enum { MAX_POINTS = 400 };

/* A closed polygon in a tilted plane, with heights across it, that moves. */
typedef struct polygon {
    size_t count;
    vec3 across, along, axis;
    double start[2 * MAX_POINTS], end[2 * MAX_POINTS]; /* in the plane */
    double x0[3 * MAX_POINTS], x1[3 * MAX_POINTS];
    uint32_t vertices[MAX_POINTS];
} polygon;

static void tilt(polygon *of, uint64_t *seed) {
    of->axis = vec3_normalize(random_vector(seed, 1.0));
    of->across = vec3_normalize(vec3_cross(of->axis, random_vector(seed, 1.0)));
    of->along = vec3_cross(of->axis, of->across);
}

/* Fills the space coordinates from the plane's. */
static void place(polygon *of, vec3 offset, double scale, uint64_t *seed) {
    for (size_t i = 0; i < of->count; i++) {
        of->vertices[i] = (uint32_t)i;
        for (int k = 0; k < 2; k++) {
            const double *const p = (k ? of->end : of->start) + 2 * i;
            vec3 x = vec3_scale(of->axis, random_between(seed, -0.3, 0.3));
            x = vec3_add_scaled(vec3_add_scaled(x, of->across, p[0]), of->along, p[1]);
            vec3_store(k ? of->x1 : of->x0, i, vec3_add_scaled(offset, x, scale));
        }
    }
}

static contour_proof prove(const polygon *of, double reach) {
    contour const boundary = {of->vertices, of->count, of->x0, of->x1, of->axis, reach};
    void *const scratch = malloc(contour_scratch_size(of->count));
    assert_non_null(scratch);
    contour_proof const proof = prove_contour(&boundary, 1000000, scratch);
    free(scratch);
    return proof;
}

static int turn(const double *a, const double *b, const double *c) {
    return orient2d_sign(a, b, c, NULL);
}

/* Closed segments, both proper; in exact arithmetic. */
static bool segments_meet(const double *a, const double *b, const double *c, const double *d) {
    int const abc = turn(a, b, c), abd = turn(a, b, d), cda = turn(c, d, a), cdb = turn(c, d, b);
    if (abc == 0 && abd == 0 && cda == 0 && cdb == 0) {
        for (int k = 0; k < 2; k++) {
            if (fmax(a[k], b[k]) < fmin(c[k], d[k]) || fmax(c[k], d[k]) < fmin(a[k], b[k]))
                return false;
        }
        return true;
    }
    return abc * abd <= 0 && cda * cdb <= 0;
}

static bool polygon_is_simple(const double *p, size_t count) {
    for (size_t i = 0; i < count; i++) {
        const double *const a = p + 2 * i, *const b = p + 2 * ((i + 1) % count);
        const double *const next = p + 2 * ((i + 2) % count);
        bool const turns_back =
            (a[0] - b[0]) * (next[0] - b[0]) + (a[1] - b[1]) * (next[1] - b[1]) > 0.0;
        if (turn(a, b, next) == 0 && turns_back) return false;
        for (size_t j = i + 2; j < count; j++) {
            if ((j + 1) % count == i) continue;
            if (segments_meet(a, b, p + 2 * j, p + 2 * ((j + 1) % count))) return false;
        }
    }
    return true;
}

/* Simple at some times, with points displaced by up to the reach, mostly by all of it. */
static void assert_stays_simple(const polygon *of, double reach, uint64_t *seed) {
    double p[2 * MAX_POINTS];
    for (int sample = 0; sample < 12; sample++) {
        double const t = sample < 2 ? sample : random_uniform(seed);
        for (size_t i = 0; i < of->count; i++) {
            double const angle = random_between(seed, -4.0, 4.0);
            double const far = sample % 2 ? reach : reach * random_uniform(seed);
            const double *const a = of->start + 2 * i, *const b = of->end + 2 * i;
            p[2 * i] = a[0] + t * (b[0] - a[0]) + far * cos(angle);
            p[2 * i + 1] = a[1] + t * (b[1] - a[1]) + far * sin(angle);
        }
        assert_true(polygon_is_simple(p, of->count));
    }
}

/* A jagged ring about the middle, wilder with the round; it moves, turns and shrinks. */
static void make_ring(polygon *of, size_t count, double wildness, uint64_t *seed) {
    of->count = count;
    double const turn_by = random_between(seed, -1.0, 1.0) * wildness;
    for (size_t i = 0; i < count; i++) {
        double const angle = 6.283185307179586 * (double)i / (double)count +
                             random_between(seed, -1.0, 1.0) * wildness;
        double const radius = 1.0 + random_between(seed, -1.0, 1.0) * wildness;
        of->start[2 * i] = radius * cos(angle), of->start[2 * i + 1] = radius * sin(angle);
        for (size_t k = 0; k < 2; k++)
            of->end[2 * i + k] = of->start[2 * i + k] + random_between(seed, -0.3, 0.3) * wildness;
        double const x = of->end[2 * i], y = of->end[2 * i + 1];
        of->end[2 * i] = x * cos(turn_by) - y * sin(turn_by);
        of->end[2 * i + 1] = x * sin(turn_by) + y * cos(turn_by);
    }
}

static void what_is_proven_is_so(void **state) {
    (void)state;
    uint64_t seed = 5;
    size_t counts[3] = {0, 0, 0};
    for (int round = 0; round < 6000; round++) {
        polygon ring;
        tilt(&ring, &seed);
        size_t const count = 3 + (size_t)(random_uniform(&seed) * 25.0);
        make_ring(&ring, count, random_uniform(&seed) * 6.0 / (double)count, &seed);
        place(&ring, vec3_make(0.0, 0.0, 0.0), 1.0, &seed);
        double const reach = round % 3 ? random_uniform(&seed) * 0.5 / (double)count : 0.0;
        contour_proof const proof = prove(&ring, reach);
        counts[proof]++;
        /* The test's coordinates are off by some 1e-15 */
        if (proof != CONTOUR_UNPROVEN) assert_stays_simple(&ring, fmax(reach - 1e-14, 0.0), &seed);
    }
    for (int k = 0; k < 3; k++) assert_true(counts[k] > 300);
}

/* A comb of thin teeth, far from star-shaped: proven while teeth keep apart, at any place and
 * size. */
static void make_comb(polygon *of, size_t teeth, double lean) {
    of->count = 4 * teeth;
    double p[2 * MAX_POINTS];
    size_t at = 0;
    for (size_t i = 0; i < teeth; i++) {
        double const left = (double)i, right = left + 0.5;
        double const corner[8] = {left, 1.0, left + lean, 20.0, right + lean, 20.0, right, 1.0};
        for (size_t k = 0; k < 4; k++, at++)
            p[2 * at] = corner[2 * k], p[2 * at + 1] = corner[2 * k + 1];
    }
    p[1] = p[2 * at - 1] = 0.0;
    memcpy(of->start, p, sizeof p);
    memcpy(of->end, p, sizeof p);
}

static void combs_are_proven(void **state) {
    (void)state;
    uint64_t seed = 6;
    for (int round = 0; round < 200; round++) {
        polygon comb;
        tilt(&comb, &seed);
        make_comb(&comb, 60, 0.0);
        double const gap = 0.5, bend = random_between(&seed, -3.0, 3.0);
        for (size_t i = 0; i < comb.count; i++) { /* all teeth lean over */
            comb.end[2 * i] += bend * (comb.start[2 * i + 1] - 1.0) / 19.0 + 1.0;
        }
        double const scale = pow(10.0, random_between(&seed, -30.0, 30.0));
        vec3 const offset = random_vector(&seed, round % 2 ? 1e6 * scale : 0.0);
        place(&comb, offset, scale, &seed);
        assert_int_equal(prove(&comb, 0.0), CONTOUR_SWEPT);
        assert_int_equal(prove(&comb, 0.1 * gap * scale), CONTOUR_SWEPT);
        assert_int_equal(prove(&comb, 0.51 * gap * scale), CONTOUR_UNPROVEN);
        /* One tooth leans into others */
        comb.end[2] += 3.0, comb.end[4] += 3.0;
        place(&comb, offset, scale, &seed);
        assert_int_equal(prove(&comb, 0.0), CONTOUR_UNPROVEN);
    }
}

/* Never proven: a polygon that touches itself at a point of time, twice round, clockwise stars,
 * fewer than 3 points, what is not finite. */
static void contacts_are_not_proven(void **state) {
    (void)state;
    uint64_t seed = 7;
    for (int round = 0; round < 500; round++) {
        polygon of;
        tilt(&of, &seed);
        /* A notch whose tip meets the opposite side exactly at the end of the step */
        double const notched[12] = {0, 0, 4, 0, 4, 3, 2, 2, 0, 3, -1, 1};
        of.count = 6;
        memcpy(of.start, notched, sizeof notched);
        memcpy(of.end, notched, sizeof notched);
        of.end[7] = 0.0;
        place(&of, random_vector(&seed, 10.0), 1.0, &seed);
        assert_int_equal(prove(&of, 0.0), CONTOUR_UNPROVEN);
        of.end[7] = 0.1;
        place(&of, random_vector(&seed, 10.0), 1.0, &seed);
        assert_int_equal(prove(&of, 0.0), CONTOUR_SWEPT);
        assert_int_equal(prove(&of, 0.06), CONTOUR_UNPROVEN);
        of.x1[4] = round % 2 ? NAN : INFINITY;
        assert_int_equal(prove(&of, 0.0), CONTOUR_UNPROVEN);
        of.count = 2;
        assert_int_equal(prove(&of, 0.0), CONTOUR_UNPROVEN);
        /* Twice round */
        make_ring(&of, 40, 0.02, &seed);
        for (size_t i = 0; i < 40; i++) {
            double const angle = 4.0 * 3.141592653589793 * (double)i / 40.0,
                         far = i < 20 ? 1.0 : 2.0;
            of.start[2 * i] = of.end[2 * i] = far * cos(angle);
            of.start[2 * i + 1] = of.end[2 * i + 1] = far * sin(angle);
        }
        place(&of, random_vector(&seed, 10.0), 1.0, &seed);
        assert_int_equal(prove(&of, 0.0), CONTOUR_UNPROVEN);
    }
}

/* Fewer tests than it takes: no proof. */
static void tests_are_limited(void **state) {
    (void)state;
    uint64_t seed = 8;
    polygon comb;
    tilt(&comb, &seed);
    make_comb(&comb, 100, 0.0);
    place(&comb, vec3_make(0.0, 0.0, 0.0), 1.0, &seed);
    contour const boundary = {comb.vertices, comb.count, comb.x0, comb.x1, comb.axis, 0.0};
    void *const scratch = malloc(contour_scratch_size(comb.count));
    assert_non_null(scratch);
    assert_int_equal(prove_contour(&boundary, 100, scratch), CONTOUR_UNPROVEN);
    assert_int_equal(prove_contour(&boundary, 40 * comb.count, scratch), CONTOUR_SWEPT);
    free(scratch);
}

/* Triangles that face the axis do so at all times, whatever displaces them within the reach. */
static void triangles_face_the_axis(void **state) {
    (void)state;
    uint64_t seed = 9;
    size_t proven = 0, with_reach = 0;
    for (int round = 0; round < 40000; round++) {
        vec3 start[3], end[3];
        vec3 const axis = vec3_normalize(random_vector(&seed, 1.0));
        double const motion = random_uniform(&seed),
                     reach = round % 2 ? random_uniform(&seed) * 0.2 : 0.0;
        for (int k = 0; k < 3; k++) {
            start[k] = random_vector(&seed, 1.0);
            end[k] = vec3_add(start[k], random_vector(&seed, motion));
        }
        double const max_angle = random_between(&seed, 10.0, 89.0) * DEGREE;
        if (!triangle_faces_axis(start, end, axis, max_angle, reach)) {
            assert_false(triangle_faces_axis(start, end, axis, max_angle, reach + 0.01));
            continue;
        }
        proven++, with_reach += reach > 0.0;
        assert_true(sample_angle(axis, start, end, 20) <= max_angle + 1e-12);
        for (int sample = 0; sample < 20; sample++) {
            for (int k = 0; k < 3; k++) {
                vec3 const by =
                    vec3_scale(vec3_normalize(random_vector(&seed, 1.0)), 0.999999 * reach);
                vec3 moved_start[3] = {start[0], start[1], start[2]};
                vec3 moved_end[3] = {end[0], end[1], end[2]};
                moved_start[k] = vec3_add(start[k], by), moved_end[k] = vec3_add(end[k], by);
                assert_true(sample_angle(axis, moved_start, moved_end, 20) < 90.0 * DEGREE);
            }
        }
    }
    assert_true(proven > 500 && with_reach > 50);
}

/* What is within rounding of the largest angle is refused. Rounding is that of the longest edges on
 * the way. */
static void triangles_at_the_largest_angle_are_refused(void **state) {
    (void)state;
    double const most = 1.0, lean[2] = {most - 2.5e-14, most - 1e-10};
    for (int i = 0; i < 2; i++)
        for (int grows = 0; grows < 2; grows++) /* either edge, from a thousandth on */
            for (int is_long = 0; is_long < 2; is_long++) {
                vec3 const u = {1.0, 0.0, 0.0}, v = {0.0, cos(lean[i]), sin(lean[i])};
                double const small = 1e-3;
                vec3 const large[3] = {{0.0, 0.0, 0.0}, u, v};
                vec3 const little[3] = {{0.0, 0.0, 0.0},
                                        vec3_scale(u, is_long ? small : 1.0),
                                        vec3_scale(v, is_long ? 1.0 : small)};
                assert_true(triangle_faces_axis(grows ? little : large, grows ? large : little,
                                                vec3_make(0.0, 0.0, 1.0), most, 0.0) == (i == 1));
            }
}

/* What lies behind the last point of a contour is not looked at. */
static void contours_end_with_their_last_point(void **state) {
    (void)state;
    enum { CORNERS = 7 };
    planar_path points[CORNERS + 1];
    for (int i = 0; i <= CORNERS; i++) {
        double const angle = 6.283185307179586 * i / CORNERS,
                     out = i == CORNERS ? (double)NAN : 1.0;
        points[i] = (planar_path){{out * cos(angle), out * cos(angle + 0.1)},
                                  {out * sin(angle), out * sin(angle + 0.1)}};
    }
    void *const scratch = malloc(contour_scratch_size(CORNERS));
    assert_non_null(scratch);
    assert_int_equal(prove_planar_contour(points, CORNERS, 1e-9, 1000, scratch), CONTOUR_STAR);
    free(scratch);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_proven_is_so),
        cmocka_unit_test(combs_are_proven),
        cmocka_unit_test(contacts_are_not_proven),
        cmocka_unit_test(tests_are_limited),
        cmocka_unit_test(triangles_face_the_axis),
        cmocka_unit_test(triangles_at_the_largest_angle_are_refused),
        cmocka_unit_test(contours_end_with_their_last_point),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
