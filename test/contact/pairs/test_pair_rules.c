/* Features of one cloth that rest next to nothing apart keep their rest distance where triangles
 * join them nearby: in a strip, around a fan, next to a fold. Layers that do not, or only far
 * away, are pattern pieces laid over one another, with distances of their own. */
#include "contact/pairs/pair_rules.h"
#include "support/contact_world.h"
#include "support/test_support.h"

#include <math.h>
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

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_folded_strip_is_joined_at_its_fold),
        cmocka_unit_test(a_fan_is_joined_to_itself_alone),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
