/* An impact zone moves as a rigid body: with the momentum of its vertices, whatever their masses.
 * What it does not hold, and what an obstacle or a pin holds, stays as it was. */
#include "contact/commit/impact_zones.h"

#include "base/hash.h"
#include "support/contact_world.h"
#include "support/test_support.h"

#include <stdlib.h>
#include <string.h>

#define TIME_STEP (1.0 / 90.0)

enum { SIDE = 5, COUNT = SIDE * SIDE };

/* Mass, centre, and momenta of some vertices; the angular one is about the centre at x0. */
typedef struct momenta {
    double mass;
    vec3 centre, linear, angular;
} momenta;

static momenta measure(const contact_world *world, const bool *is_in, const double *u) {
    momenta sum = {0};
    for (size_t v = 0; v < COUNT; v++) {
        if (!is_in[v]) continue;
        double const mass = 1.0 / world->inverse_mass[v];
        sum.mass += mass;
        sum.centre = vec3_add_scaled(sum.centre, vec3_load(world->x0, v), mass);
        sum.linear = vec3_add_scaled(sum.linear, vec3_load(u, v), mass);
    }
    sum.centre = vec3_scale(sum.centre, 1.0 / sum.mass);
    for (size_t v = 0; v < COUNT; v++) {
        if (!is_in[v]) continue;
        vec3 const arm = vec3_sub(vec3_load(world->x0, v), sum.centre);
        sum.angular = vec3_add_scaled(sum.angular, vec3_cross(arm, vec3_load(u, v)),
                                      1.0 / world->inverse_mass[v]);
    }
    return sum;
}

/* A crumpled sheet whose vertices have masses from m to 5 m and velocities at random. */
static void make_crumple(contact_world *world, uint64_t *random) {
    *world = contact_world_make();
    contact_grid sheet = make_contact_grid(SIDE, SIDE, vec3_make(0.3, -0.2, 0.1),
                                           vec3_make(0.1, 0.0, 0.0), vec3_make(0.0, 0.1, 0.0));
    for (size_t i = 0; i < 3 * COUNT; i++)
        sheet.positions[i] += 4e-3 * (random_uniform(random) - 0.5);
    add_contact_surface(world, sheet.mesh, false);
    start_contact_world(world);
    free_contact_grid(&sheet);
    for (size_t v = 0; v < COUNT; v++) world->inverse_mass[v] /= 1.0 + 4.0 * random_uniform(random);
    for (size_t i = 0; i < 3 * COUNT; i++) world->u[i] = 0.02 * (random_uniform(random) - 0.5);
    for (size_t i = 0; i < 3 * COUNT; i++) world->x1[i] = world->x0[i] + TIME_STEP * world->u[i];
}

/* Projects the hits of the vertex/triangle pairs {corner, triangle i} and marks their vertices. */
static uint64_t project(contact_world *world, bool is_in[COUNT]) {
    contact_scene const scene = get_contact_scene(world, TIME_STEP);
    impact_zones zones = {.is_held = calloc(COUNT, sizeof(bool))};
    pair_event events[3];
    for (uint32_t i = 0; i < 3; i++) {
        events[i] = (pair_event){.kind = FEATURE_VERTEX_TRIANGLE, .pair = {0, 3 + i}};
        is_in[0] = true;
        for (size_t k = 0; k < 3; k++) is_in[world->triangles[3 * (3 + i) + k]] = true;
    }
    pair_events const hits = {.events = events, .count = 3};
    uint64_t zone_count = 0;
    assert_true(zones.is_held && vertex_groups_make(&zones.groups, scene.scratch, COUNT));
    assert_int_equal(project_impact_zones(&scene, &zones, &hits, world->u, world->x1, &zone_count),
                     TULLE_OK);
    free(zones.is_held);
    return zone_count;
}

static void a_zone_keeps_its_momentum(void **state) {
    (void)state;
    uint64_t random = 3;
    for (int round = 0; round < 10; round++) {
        contact_world world;
        make_crumple(&world, &random);
        double before_u[3 * COUNT], before_x1[3 * COUNT];
        memcpy(before_u, world.u, sizeof before_u);
        memcpy(before_x1, world.x1, sizeof before_x1);
        bool is_in[COUNT] = {false};
        assert_int_equal(project(&world, is_in), 1);
        momenta const before = measure(&world, is_in, before_u),
                      after = measure(&world, is_in, world.u);
        double const size = before.mass * 0.01;
        assert_true(vec3_norm(vec3_sub(after.linear, before.linear)) < 1e-12 * size);
        /* the turn is below 0.02 rad, and the chords of its arcs are off by half its square */
        assert_true(vec3_norm(before.angular) > 0.0);
        assert_true(vec3_norm(vec3_sub(after.angular, before.angular)) <
                    0.02 * vec3_norm(before.angular));
        for (size_t v = 0; v < COUNT; v++) {
            if (!is_in[v]) {
                assert_memory_equal(world.x1 + 3 * v, before_x1 + 3 * v, 3 * sizeof(double));
                assert_memory_equal(world.u + 3 * v, before_u + 3 * v, 3 * sizeof(double));
                continue;
            }
            vec3 const end =
                vec3_add_scaled(vec3_load(world.x0, v), vec3_load(world.u, v), TIME_STEP);
            assert_true(vec3_norm(vec3_sub(end, vec3_load(world.x1, v))) < 1e-15);
            for (size_t w = 0; w < v; w++) {
                if (!is_in[w]) continue;
                double const then =
                    vec3_norm(vec3_sub(vec3_load(world.x0, v), vec3_load(world.x0, w)));
                double const now =
                    vec3_norm(vec3_sub(vec3_load(world.x1, v), vec3_load(world.x1, w)));
                assert_true(fabs(now - then) < 1e-14);
            }
        }
        contact_world_destroy(&world);
    }
}

static void a_zone_that_is_held_stays(void **state) {
    (void)state;
    uint64_t random = 4;
    contact_world world;
    make_crumple(&world, &random);
    world.inverse_mass[0] = 0.0;
    double before[3 * COUNT];
    memcpy(before, world.x1, sizeof before);
    bool is_in[COUNT] = {false};
    assert_int_equal(project(&world, is_in), 0);
    assert_memory_equal(world.x1, before, sizeof before);
    contact_world_destroy(&world);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_zone_keeps_its_momentum),
        cmocka_unit_test(a_zone_that_is_held_stays),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
