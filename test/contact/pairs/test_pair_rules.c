/* Features of one cloth that rest next to nothing apart keep their rest distance where triangles
 * join them nearby: in a strip, around a fan or a hole, next to a fold. Layers that do not, or only
 * far away, are pattern pieces laid over one another, with distances of their own. */
#include "contact/pairs/pair_rules.h"
#include "support/contact_world.h"
#include "support/test_support.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define CONTACT 3e-3
#define NEAR 1e-6

static contact_world start_cloth(const double *positions, size_t vertex_count,
                                 const uint32_t *triangles, size_t triangle_count) {
    contact_world world = contact_world_make();
    world.def.contact_distance = CONTACT;
    add_contact_surface(&world, (contact_mesh){positions, vertex_count, triangles, triangle_count},
                        false);
    return world;
}

static double find_contact(contact_world *world, feature_kind kind, uint32_t a, uint32_t b,
                           uint32_t c, uint32_t d) {
    contact_scene const scene = get_contact_scene(world, 0.01);
    uint32_t const vertices[4] = {a, b, c, d};
    pair_distances const found = compute_pair_distances(&scene, kind, vertices, NULL);
    assert_true(found.minimum < found.contact);
    return found.contact;
}

/* rest [m]: how far from each other the features rest */
static void check_joined(double contact, double rest) {
    assert_true(fabs(contact - 0.5 * rest) < 1e-12);
}

/* A strip two rows wide that goes 2 cm away, turns over an edge of NEAR and comes back. Vertices
 * 2 c and 2 c + 1 are column c. */
static void a_folded_strip_is_joined_at_its_fold(void **state) {
    (void)state;
    enum { COLUMNS = 6 };
    static const double path[COLUMNS][2] = {{0.0, 0.0},   {0.01, 0.0},  {0.02, 0.0},
                                            {0.02, NEAR}, {0.01, NEAR}, {0.0, NEAR}};
    double positions[6 * COLUMNS];
    uint32_t triangles[6 * (COLUMNS - 1)];
    for (size_t i = 0; i < 2 * COLUMNS; i++) {
        double const p[3] = {path[i / 2][0], i % 2 ? 0.01 : 0.0, path[i / 2][1]};
        memcpy(positions + 3 * i, p, sizeof p);
    }
    for (uint32_t c = 0; c + 1 < COLUMNS; c++) {
        uint32_t const a = 2 * c;
        uint32_t const pair[6] = {a, a + 2, a + 3, a, a + 3, a + 1};
        memcpy(triangles + 6 * (size_t)c, pair, sizeof pair);
    }
    contact_world world = start_cloth(positions, 2 * COLUMNS, triangles, 2 * (COLUMNS - 1));
    start_contact_world(&world);
    /* over the short edges of the fold */
    check_joined(find_contact(&world, FEATURE_VERTEX_TRIANGLE, 4, 6, 8, 9), NEAR);
    check_joined(find_contact(&world, FEATURE_VERTEX_TRIANGLE, 6, 2, 4, 5), NEAR);
    check_joined(find_contact(&world, FEATURE_EDGE_EDGE, 4, 5, 6, 7), NEAR);
    /* over the other end, 4 cm away along the strip; and half-way */
    double const far_off[] = {find_contact(&world, FEATURE_VERTEX_TRIANGLE, 0, 8, 10, 11),
                              find_contact(&world, FEATURE_EDGE_EDGE, 0, 1, 10, 11),
                              find_contact(&world, FEATURE_VERTEX_TRIANGLE, 2, 8, 10, 11),
                              find_contact(&world, FEATURE_EDGE_EDGE, 2, 3, 8, 9)};
    for (size_t i = 0; i < sizeof far_off / sizeof *far_off; i++)
        assert_true(far_off[i] == CONTACT);
    contact_world_destroy(&world);
}

/* Two fans of radius NEAR, one over the other by as much: the middle is vertex 0, the ring 1 .. 6;
 * those of the upper fan are 7 more. */
static void a_fan_is_joined_to_itself_alone(void **state) {
    (void)state;
    enum { RING = 6, FAN = RING + 1 };
    double positions[2 * 3 * FAN] = {0.0};
    uint32_t triangles[2 * 3 * RING];
    for (uint32_t fan = 0; fan < 2; fan++) {
        for (uint32_t i = 0; i < FAN; i++) {
            double *const p = positions + 3 * (FAN * fan + i);
            double const angle = 6.283185307179586 * i / RING;
            if (i > 0) p[0] = NEAR * cos(angle), p[1] = NEAR * sin(angle);
            p[2] = NEAR * fan;
        }
        for (uint32_t i = 0; i < RING; i++) {
            uint32_t *const t = triangles + 3 * (RING * fan + i);
            t[0] = FAN * fan, t[1] = t[0] + 1 + i, t[2] = t[0] + 1 + (i + 1) % RING;
        }
    }
    contact_world world = start_cloth(positions, 2 * FAN, triangles, 2 * RING);
    start_contact_world(&world);
    check_joined(find_contact(&world, FEATURE_VERTEX_TRIANGLE, 1, 0, 3, 4), NEAR);
    check_joined(find_contact(&world, FEATURE_EDGE_EDGE, 1, 2, 0, 4), NEAR * sqrt(0.75));
    assert_true(find_contact(&world, FEATURE_VERTEX_TRIANGLE, 0, 7, 8, 9) == CONTACT);
    assert_true(find_contact(&world, FEATURE_EDGE_EDGE, 0, 1, 7, 8) == CONTACT);
    contact_world_destroy(&world);
}

/* A fan of radius NEAR and very many triangles, and a ring of the same vertices without the fan, so
 * with a hole. Over each lies another, by as much. Vertices: the middle (of the hole, one beside
 * it), RING of the inner ring, RING of the outer one. */
static void features_are_joined_round_any_fan_and_hole(void **state) {
    (void)state;
    enum { RING = 400, PIECE = 1 + 2 * RING, MOST = 3 * RING + 1 };
    for (int has_hole = 0; has_hole < 2; has_hole++) {
        double *const positions = calloc(2 * 3 * PIECE, sizeof *positions);
        uint32_t *const triangles = calloc(2 * 3 * MOST, sizeof *triangles);
        assert_true(positions && triangles);
        size_t count = 0;
        for (uint32_t piece = 0; piece < 2; piece++) {
            uint32_t const middle = PIECE * piece, inner = middle + 1, outer = inner + RING;
            for (uint32_t i = 0; i < PIECE; i++) {
                double *const p = positions + 3 * (middle + i);
                double const angle = 6.283185307179586 * (double)((i + RING - 1) % RING) / RING;
                double const radius = i <= RING ? NEAR : 1e-2;
                if (i > 0) p[0] = radius * cos(angle), p[1] = radius * sin(angle);
                p[2] = NEAR * piece;
            }
            if (has_hole) { /* the middle lies outside, at a triangle of its own */
                positions[3 * middle] = 2e-2;
                uint32_t const corners[3] = {middle, outer + 1, outer};
                memcpy(triangles + 3 * count++, corners, sizeof corners);
            }
            for (uint32_t i = 0; i < RING; i++) {
                uint32_t const next = (i + 1) % RING;
                uint32_t const corners[3][3] = {{inner + i, outer + i, outer + next},
                                                {inner + i, outer + next, inner + next},
                                                {middle, inner + i, inner + next}};
                size_t const used = has_hole ? 2 : 3;
                memcpy(triangles + 3 * count, corners, used * sizeof corners[0]);
                count += used;
            }
        }
        contact_world world = start_cloth(positions, 2 * PIECE, triangles, count);
        start_contact_world(&world);
        enum { OPPOSITE = RING / 2, FAR_RING = 1 + RING };
        double const across = has_hole ? 2.0 * NEAR : NEAR;
        /* a vertex of the ring, and a triangle and an edge on the other side */
        if (has_hole)
            check_joined(find_contact(&world, FEATURE_VERTEX_TRIANGLE, 1, 1 + OPPOSITE,
                                      FAR_RING + OPPOSITE, FAR_RING + OPPOSITE + 1),
                         across);
        else
            check_joined(
                find_contact(&world, FEATURE_VERTEX_TRIANGLE, 1, 0, 1 + OPPOSITE, 2 + OPPOSITE),
                across);
        /* a spoke of the ring and each other one: the nearest is a 64th of NEAR away */
        for (uint32_t i = 1; i < RING; i++)
            check_joined(find_contact(&world, FEATURE_EDGE_EDGE, 1, FAR_RING, 1 + i, FAR_RING + i),
                         2.0 * NEAR * sin(3.141592653589793 * i / RING));
        check_joined(find_contact(&world, FEATURE_EDGE_EDGE, 1, 2, 1 + OPPOSITE, 2 + OPPOSITE),
                     2.0 * NEAR * cos(3.141592653589793 / RING));
        /* the other piece */
        assert_true(find_contact(&world, FEATURE_EDGE_EDGE, 1, 2, PIECE + 1, PIECE + 2) == CONTACT);
        assert_true(find_contact(&world, FEATURE_VERTEX_TRIANGLE, 1, PIECE + 1, PIECE + FAR_RING,
                                 PIECE + FAR_RING + 1) == CONTACT);
        contact_world_destroy(&world);
        free(positions);
        free(triangles);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_folded_strip_is_joined_at_its_fold),
        cmocka_unit_test(a_fan_is_joined_to_itself_alone),
        cmocka_unit_test(features_are_joined_round_any_fan_and_hole),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
