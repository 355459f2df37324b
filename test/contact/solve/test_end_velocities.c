/* Velocities at the end of a step: random rows between vertices with mass against the laws of
 * impact, momentum and energy. */
#include "base/hash.h"
#include "contact/solve/end_velocities.h"
#include "contact/solve/project_impulses.h"
#include "support/test_support.h"

#include <math.h>
#include <string.h>

enum { VERTEX_COUNT = 40, ROW_COUNT = 10 };

typedef struct end_world {
    memory heap;
    arena scratch;
    double inverse_mass[VERTEX_COUNT], x0[3 * VERTEX_COUNT];
    double v0[3 * VERTEX_COUNT], u[3 * VERTEX_COUNT], v1[3 * VERTEX_COUNT];
    contact_row rows[ROW_COUNT];
    row_list list;
    contact_scene scene;
} end_world;

static vec3 random_vector(uint64_t *state) {
    double const x = random_uniform(state), y = random_uniform(state), z = random_uniform(state);
    return vec3_make(2.0 * x - 1.0, 2.0 * y - 1.0, 2.0 * z - 1.0);
}

/* Rows with one vertex for each side and one more for the triangle: 4 vertices of four groups. */
static void make_world(end_world *world, uint64_t *random, double restitution, double friction) {
    memset(world, 0, sizeof *world);
    world->heap = memory_default();
    world->scratch = arena_make(&world->heap);
    for (size_t i = 0; i < VERTEX_COUNT; i++) {
        world->inverse_mass[i] = 1.0 / (0.01 + random_uniform(random));
        vec3_store(world->v0, i, random_vector(random));
    }
    world->scene = (contact_scene){.vertex_count = VERTEX_COUNT,
                                   .cloth_vertex_count = VERTEX_COUNT,
                                   .inverse_mass = world->inverse_mass,
                                   .v0 = world->v0,
                                   .time_step = 0.01,
                                   .settings = default_contact_settings,
                                   .heap = &world->heap,
                                   .scratch = &world->scratch};
    world->scene.settings.impulse_sweeps = 2000;
    for (size_t r = 0; r < ROW_COUNT; r++) {
        contact_row *const row = &world->rows[r];
        *row = (contact_row){.frame.normal = vec3_normalize(random_vector(random)),
                             .solve.friction_cap = -1.0,
                             .law.friction = friction,
                             .law.restitution = restitution,
                             .law.friction_along = 1.0,
                             .law.friction_across = 1.0};
        double const s = random_uniform(random), t = random_uniform(random);
        double const weights[4] = {1.0 - s, s, -(1.0 - t), -t};
        for (int k = 0; k < 4; k++) {
            row->frame.vertices[k] =
                (uint32_t)(random_next(random) % (VERTEX_COUNT / 4)) * 4 + (uint32_t)k;
            row->frame.weights[k] = weights[k];
            row->solve.inverse_mass +=
                weights[k] * weights[k] * world->inverse_mass[row->frame.vertices[k]];
        }
        row->law.approach = vec3_dot(row->frame.normal, get_relative_velocity(row, world->v0));
    }
    world->list.rows.data = world->rows;
    world->list.rows.count = ROW_COUNT;
    memcpy(world->u, world->v0, sizeof world->u);
    project_impulses(&world->scene, world->scene.settings.impulse_sweeps, world->rows, ROW_COUNT,
                     world->u);
    memcpy(world->v1, world->u, sizeof world->u);
}

static double get_energy(const end_world *world, const double *v) {
    double sum = 0.0;
    for (size_t i = 0; i < VERTEX_COUNT; i++)
        sum += 0.5 * vec3_norm2(vec3_load(v, i)) / world->inverse_mass[i];
    return sum;
}

static vec3 get_momentum(const end_world *world, const double *v) {
    vec3 sum = {0.0, 0.0, 0.0};
    for (size_t i = 0; i < VERTEX_COUNT; i++)
        sum = vec3_add_scaled(sum, vec3_load(v, i), 1.0 / world->inverse_mass[i]);
    return sum;
}

static void impacts_follow_the_laws(void **state) {
    (void)state;
    uint64_t random = 5;
    uint64_t rebounds = 0, cut_count = 0;
    for (int i = 0; i < 200; i++) {
        double const k = 0.25 * (i % 5), friction = i % 3 == 0 ? 0.0 : 0.4;
        end_world world;
        make_world(&world, &random, k, friction);
        end_velocities ends = {.kinetic_limit = get_energy(&world, world.v0)};
        assert_int_equal(end_contacts(&world.scene, &world.list, world.u, world.v1, &ends),
                         TULLE_OK);
        rebounds += ends.rebound_count;
        assert_true(get_energy(&world, world.v1) <= get_energy(&world, world.v0) * (1.0 + 1e-9));
        vec3 const change =
            vec3_sub(get_momentum(&world, world.v1), get_momentum(&world, world.v0));
        assert_true(vec3_norm(change) < 1e-13);
        if (k == 0.0) assert_memory_equal(world.v1, world.u, sizeof world.u);
        /* the energy's limit may cut rebounds: rows that part at the start but carry load spend */
        bool const is_cut =
            get_energy(&world, world.v1) > get_energy(&world, world.v0) * (1.0 - 1e-9);
        cut_count += is_cut;
        for (size_t r = 0; r < ROW_COUNT && !is_cut; r++) {
            const contact_row *const row = &world.rows[r];
            if (row->law.rebound == 0.0) continue;
            double const end = vec3_dot(row->frame.normal, get_relative_velocity(row, world.v1));
            assert_true(row->law.rebound == -k * row->law.approach);
            assert_true(end > row->law.rebound - 1e-6);
        }
        arena_destroy(&world.scratch);
    }
    assert_true(rebounds > 300 && cut_count < 40);
    print_message("rebounds %llu, %llu of 200 worlds cut\n", (unsigned long long)rebounds,
                  (unsigned long long)cut_count);
}

/* A pair of equal masses swaps its normal velocities; a wall turns them around. */
static void two_bodies_part_as_known(void **state) {
    (void)state;
    uint64_t random = 9;
    for (int i = 0; i < 3; i++) {
        bool const is_wall = i == 2;
        end_world world;
        make_world(&world, &random, 1.0, 0.0);
        double const masses[2] = {1.0, is_wall ? 0.0 : 1.0};
        memset(world.v0, 0, sizeof world.v0);
        world.v0[2] = -1.5;
        world.v0[5] = is_wall ? 0.0 : 0.25;
        for (int k = 0; k < 2; k++) world.inverse_mass[k] = masses[k];
        world.rows[0] = (contact_row){.frame.vertices = {0, 1, 2, 3},
                                      .frame.weights = {1.0, -1.0, 0.0, 0.0},
                                      .frame.normal = {0.0, 0.0, 1.0},
                                      .solve.friction_cap = -1.0,
                                      .law.restitution = 1.0,
                                      .law.friction_along = 1.0,
                                      .law.friction_across = 1.0,
                                      .solve.inverse_mass = masses[0] + masses[1],
                                      .law.approach = world.v0[2] - world.v0[5]};
        world.list.rows.count = 1;
        memcpy(world.u, world.v0, sizeof world.u);
        project_impulses(&world.scene, world.scene.settings.impulse_sweeps, world.rows, 1, world.u);
        memcpy(world.v1, world.u, sizeof world.u);
        end_velocities ends = {.kinetic_limit = 10.0};
        assert_int_equal(end_contacts(&world.scene, &world.list, world.u, world.v1, &ends),
                         TULLE_OK);
        assert_int_equal(ends.rebound_count, 1);
        assert_true(fabs(world.v1[2] - (is_wall ? 1.5 : 0.25)) < 1e-14);
        assert_true(fabs(world.v1[5] - (is_wall ? 0.0 : -1.5)) < 1e-14);
        arena_destroy(&world.scratch);
    }
}

/* Asked for an inelastic end, rows that carry load lose an approach that v1 had of its own. */
static void inelastic_ends_do_not_approach(void **state) {
    (void)state;
    uint64_t random = 17;
    for (int i = 0; i < 50; i++) {
        end_world world;
        make_world(&world, &random, 0.0, 0.3);
        for (size_t k = 0; k < 3 * VERTEX_COUNT; k++) world.v1[k] = 2.0 * world.u[k] - world.v0[k];
        end_velocities ends = {.is_inelastic = true};
        assert_int_equal(end_contacts(&world.scene, &world.list, world.u, world.v1, &ends),
                         TULLE_OK);
        assert_true(ends.approach < 1e-6);
        for (size_t r = 0; r < ROW_COUNT; r++) {
            const contact_row *const row = &world.rows[r];
            if (!(vec3_dot(row->frame.normal, row->solve.impulse) > 0.0)) continue;
            assert_true(vec3_dot(row->frame.normal, get_relative_velocity(row, world.v1)) > -1e-6);
        }
        arena_destroy(&world.scratch);
    }
}

/* A limit between the energies of the inelastic and of the elastic end is met, and momentum kept;
 * one under both leaves the inelastic end. */
static void limit_of_energy_is_met(void **state) {
    (void)state;
    uint64_t random = 23;
    int between = 0;
    for (int i = 0; i < 50; i++) {
        end_world free_world, world;
        uint64_t const seed = random;
        make_world(&free_world, &random, 0.8, 0.2);
        end_velocities ends = {.kinetic_limit = (double)INFINITY};
        assert_int_equal(
            end_contacts(&free_world.scene, &free_world.list, free_world.u, free_world.v1, &ends),
            TULLE_OK);
        double const low = get_energy(&free_world, free_world.u);
        double const high = get_energy(&free_world, free_world.v1);
        random = seed;
        make_world(&world, &random, 0.8, 0.2);
        ends.kinetic_limit = low + (0.1 * (i % 12) - 0.1) * (high - low);
        assert_int_equal(end_contacts(&world.scene, &world.list, world.u, world.v1, &ends),
                         TULLE_OK);
        double const end = get_energy(&world, world.v1);
        between += ends.kinetic_limit > low && ends.kinetic_limit < high;
        double const expected = high > low ? fmin(fmax(ends.kinetic_limit, low), high) : high;
        assert_true(fabs(end - expected) < 1e-12 * high);
        vec3 const change =
            vec3_sub(get_momentum(&world, world.v1), get_momentum(&world, world.v0));
        assert_true(vec3_norm(change) < 1e-13);
        arena_destroy(&world.scratch);
        arena_destroy(&free_world.scratch);
    }
    assert_true(between > 30);
}

/* What rows give to the free side is the work of the held side plus what both lose. */
static void work_of_what_is_held(void **state) {
    (void)state;
    uint64_t random = 31;
    end_world world;
    make_world(&world, &random, 0.0, 0.4);
    assert_true(compute_obstacle_work(&world.scene, world.rows, ROW_COUNT, world.v0) == 0.0);
    for (size_t v = 2; v < VERTEX_COUNT; v += 4) world.inverse_mass[v] = 0.0;
    double expected = 0.0;
    for (size_t r = 0; r < ROW_COUNT; r++)
        expected -= world.rows[r].frame.weights[2] *
                    vec3_dot(world.rows[r].solve.impulse,
                             vec3_load(world.v0, world.rows[r].frame.vertices[2]));
    double const work = compute_obstacle_work(&world.scene, world.rows, ROW_COUNT, world.v0);
    assert_true(fabs(expected) > 1e-3);
    assert_true(fabs(work - expected) < 1e-14);
    arena_destroy(&world.scratch);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(impacts_follow_the_laws),
        cmocka_unit_test(two_bodies_part_as_known),
        cmocka_unit_test(limit_of_energy_is_met),
        cmocka_unit_test(work_of_what_is_held),
        cmocka_unit_test(inelastic_ends_do_not_approach),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
