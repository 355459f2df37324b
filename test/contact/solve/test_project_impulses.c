/* Projected Gauss-Seidel against closed forms of one contact, momentum, and the conditions of
 * Coulomb contact at the fixed point of many. */
#include "base/hash.h"
#include "contact/solve/project_impulses.h"
#include "support/test_support.h"

#include <stdlib.h>
#include <string.h>

enum { VERTEX_COUNT = 40, ROW_COUNT = 60 };

typedef struct row_world {
    double inverse_mass[VERTEX_COUNT], u[3 * VERTEX_COUNT], x0[3 * VERTEX_COUNT];
    contact_row rows[ROW_COUNT];
    contact_scene scene;
    memory heap;
    arena scratch;
} row_world;

static double random_signed(uint64_t *state) { return 2.0 * random_uniform(state) - 1.0; }

static vec3 random_vector(uint64_t *state) {
    return vec3_make(random_signed(state), random_signed(state), random_signed(state));
}

static void set_row(row_world *world, contact_row *row, const uint32_t vertices[4],
                    const double weights[4], vec3 normal) {
    *row = (contact_row){.frame.normal = normal,
                         .solve.friction_cap = -1.0,
                         .law.friction_along = 1.0,
                         .law.friction_across = 1.0};
    memcpy(row->frame.vertices, vertices, sizeof row->frame.vertices);
    memcpy(row->frame.weights, weights, sizeof row->frame.weights);
    for (int k = 0; k < 4; k++)
        row->solve.inverse_mass += weights[k] * weights[k] * world->inverse_mass[vertices[k]];
}

static void start_world(row_world *world, int sweeps) {
    memset(world, 0, sizeof *world);
    world->scene.settings = default_contact_settings;
    world->scene.settings.impulse_sweeps = sweeps;
    world->scene.inverse_mass = world->inverse_mass;
    world->scene.vertex_count = VERTEX_COUNT;
    world->scene.x0 = world->x0;
    world->scene.time_step = 1.0;
    world->heap = memory_default();
    world->scratch = arena_make(&world->heap);
    world->scene.scratch = &world->scratch;
}

static void end_world(row_world *world) {
    arena_destroy(&world->scratch);
    assert_int_equal(world->heap.bytes_held, 0);
}

/* Projects the impulses of the first rows. */
static void project(row_world *world, contact_row *rows, size_t count) {
    assert_int_equal(project_impulses(&world->scene, world->scene.settings.impulse_sweeps, rows,
                                      count, world->u),
                     TULLE_OK);
}

/* A vertex of mass m meets a resting triangle with velocity v: the normal part of v that approaches
 * vanishes, the tangential part loses at most friction times as much. */
static void one_vertex_meets_a_plane(void **state) {
    (void)state;
    uint64_t random = 7;
    int sticks = 0, slides = 0, opens = 0;
    for (int i = 0; i < 1000; i++) {
        row_world world;
        start_world(&world, 1);
        double const mass = 0.01 + random_uniform(&random);
        world.inverse_mass[0] = 1.0 / mass;
        vec3 const v = random_vector(&random), n = vec3_normalize(random_vector(&random));
        vec3_store(world.u, 0, v);
        contact_row row;
        set_row(&world, &row, (uint32_t[4]){0, 1, 2, 3}, (double[4]){1.0, -0.5, -0.25, -0.25}, n);
        row.law.friction = 2.0 * random_uniform(&random);
        project(&world, &row, 1);
        double const approach = fmax(-vec3_dot(v, n), 0.0);
        vec3 const tangential = vec3_add_scaled(v, n, -vec3_dot(v, n));
        double const slip = vec3_norm(tangential);
        double const kept = fmax(0.0, 1.0 - row.law.friction * approach / slip);
        vec3 expected = vec3_add_scaled(v, n, approach);
        expected = vec3_add_scaled(expected, tangential, kept - 1.0);
        vec3 const difference = vec3_sub(vec3_load(world.u, 0), expected);
        assert_true(vec3_norm(difference) < 1e-14);
        vec3 const impulse = vec3_scale(vec3_sub(expected, v), mass);
        assert_true(vec3_norm(vec3_sub(impulse, row.solve.impulse)) < 1e-14);
        row_state const wanted = approach == 0.0 ? ROW_OPEN : kept > 0.0 ? ROW_SLIDES : ROW_STICKS;
        assert_int_equal(row.solve.state, wanted);
        end_world(&world);
        sticks += wanted == ROW_STICKS, slides += wanted == ROW_SLIDES, opens += wanted == ROW_OPEN;
    }
    assert_true(sticks > 50 && slides > 50 && opens > 50);
}

/* A total impulse may shrink: a contact that is pulled apart gives back what it had. */
static void impulses_shrink_when_pulled_apart(void **state) {
    (void)state;
    row_world world;
    start_world(&world, 1);
    world.inverse_mass[0] = 2.0;
    contact_row row;
    set_row(&world, &row, (uint32_t[4]){0, 1, 2, 3}, (double[4]){1.0, -1.0, 0.0, 0.0},
            vec3_make(0.0, 0.0, 1.0));
    row.solve.impulse = vec3_make(0.0, 0.0, 0.5);
    world.u[2] = 0.25;
    project(&world, &row, 1);
    assert_true(fabs(row.solve.impulse.z - 0.375) < 1e-15 && fabs(world.u[2]) < 1e-15);
    world.u[2] = 10.0;
    project(&world, &row, 1);
    assert_true(row.solve.impulse.z == 0.0 && fabs(world.u[2] - 9.25) < 1e-14);
    end_world(&world);
}

/* Random rows between vertices with mass; normals along sum w x, as contacts have them. */
static void make_random_rows(row_world *world, uint64_t *random, double friction) {
    for (int i = 0; i < VERTEX_COUNT; i++) {
        world->inverse_mass[i] = 1.0 / (0.01 + random_uniform(random));
        vec3_store(world->x0, (size_t)i, random_vector(random));
        vec3_store(world->u, (size_t)i, random_vector(random));
    }
    for (int r = 0; r < ROW_COUNT; r++) {
        uint32_t vertices[4];
        for (int k = 0; k < 4; k++)
            vertices[k] = (uint32_t)(random_next(random) % (VERTEX_COUNT / 4)) * 4 + (uint32_t)k;
        double const s = random_uniform(random), t = random_uniform(random);
        double const weights[4] = {1.0 - s, s, -(1.0 - t), -t};
        vec3 sum = {0.0, 0.0, 0.0};
        for (int k = 0; k < 4; k++)
            sum = vec3_add_scaled(sum, vec3_load(world->x0, vertices[k]), weights[k]);
        set_row(world, &world->rows[r], vertices, weights, vec3_normalize(sum));
        world->rows[r].law.friction = friction;
        world->rows[r].law.bias = 0.1 * random_signed(random);
    }
}

static vec3 get_momentum(const row_world *world, bool is_angular) {
    vec3 sum = {0.0, 0.0, 0.0};
    for (size_t i = 0; i < VERTEX_COUNT; i++) {
        vec3 const p = vec3_scale(vec3_load(world->u, i), 1.0 / world->inverse_mass[i]);
        sum = vec3_add(sum, is_angular ? vec3_cross(vec3_load(world->x0, i), p) : p);
    }
    return sum;
}

static void momentum_is_kept_between_cloths(void **state) {
    (void)state;
    uint64_t random = 11;
    for (int i = 0; i < 50; i++) {
        row_world world;
        start_world(&world, 5);
        make_random_rows(&world, &random, i % 2 ? 0.5 : 0.0);
        vec3 const linear = get_momentum(&world, false), angular = get_momentum(&world, true);
        project(&world, world.rows, ROW_COUNT);
        vec3 const linear_change = vec3_sub(get_momentum(&world, false), linear);
        vec3 const angular_change = vec3_sub(get_momentum(&world, true), angular);
        assert_true(vec3_norm(linear_change) < 1e-12);
        /* Friction acts across the gap, which makes a couple; normal impulses make none. */
        if (i % 2 == 0) assert_true(vec3_norm(angular_change) < 1e-12);
        end_world(&world);
    }
}

static double find_difference(const double *a, const double *b, size_t count) {
    double largest = 0.0;
    for (size_t i = 0; i < count; i++) largest = fmax(largest, fabs(a[i] - b[i]));
    return largest;
}

/* Rows that no change has reached are passed over, but only these: sweeps in one call lead to the
 * same as one call a sweep, which knows of no change before it and looks at all rows; but for
 * changes so small that they end the sweeps of one call. */
static void passed_over_rows_would_not_change(void **state) {
    (void)state;
    enum { SWEEPS = 4 };
    uint64_t random = 17;
    size_t quiet = 0;
    for (int i = 0; i < 200; i++) {
        row_world world, single;
        start_world(&world, SWEEPS);
        start_world(&single, 1);
        make_random_rows(&world, &random, 0.3);
        for (int r = 0; r < ROW_COUNT; r++) {
            /* many are open, and some only until others push */
            world.rows[r].law.bias -= (double)(i % 5) * 0.2;
            world.rows[r].solve.is_in_matrix = r % 7 == 0;
        }
        memcpy(single.inverse_mass, world.inverse_mass, sizeof world.inverse_mass);
        memcpy(single.u, world.u, sizeof world.u);
        memcpy(single.rows, world.rows, sizeof world.rows);
        project(&world, world.rows, ROW_COUNT);
        for (int s = 0; s < SWEEPS; s++) project(&single, single.rows, ROW_COUNT);
        assert_true(find_difference(single.u, world.u, 3 * VERTEX_COUNT) < 1e-12);
        for (int r = 0; r < ROW_COUNT; r++) {
            vec3 const impulse = world.rows[r].solve.impulse;
            assert_true(vec3_norm(vec3_sub(single.rows[r].solve.impulse, impulse)) < 1e-12);
            assert_int_equal(single.rows[r].solve.state, world.rows[r].solve.state);
            quiet += vec3_norm2(world.rows[r].solve.impulse) == 0.0;
        }
        end_world(&world);
        end_world(&single);
    }
    assert_true(quiet > 2000 && quiet < 180 * ROW_COUNT);
}

/* Signorini and Coulomb at the fixed point. */
static void assert_coulomb(const row_world *world, const contact_row *row) {
    vec3 const velocity = get_relative_velocity(row, world->u);
    double const speed = vec3_dot(velocity, row->frame.normal) - row->law.bias;
    double const normal = vec3_dot(row->solve.impulse, row->frame.normal);
    vec3 const tangential = vec3_add_scaled(row->solve.impulse, row->frame.normal, -normal);
    vec3 const slip =
        vec3_add_scaled(velocity, row->frame.normal, -vec3_dot(velocity, row->frame.normal));
    assert_true(normal >= -1e-15 && speed > -1e-6);
    assert_true(normal < 1e-6 || speed < 1e-6);
    assert_true(vec3_norm(tangential) <= row->law.friction * normal * (1.0 + 1e-9) + 1e-15);
    /* Friction opposes slip, and is whole while there is slip. */
    double const power = vec3_dot(tangential, slip);
    assert_true(fabs(power + row->law.friction * normal * vec3_norm(slip)) < 1e-5);
}

static void fixed_point_is_coulomb(void **state) {
    (void)state;
    uint64_t random = 13;
    for (int i = 0; i < 20; i++) {
        row_world world;
        start_world(&world, 20000);
        make_random_rows(&world, &random, 0.3);
        /* Distinct contacts of a plausible kind: at most one row between two groups of four. */
        for (int r = 0; r < ROW_COUNT; r++) world.rows[r].law.bias = 0.0;
        project(&world, world.rows, 12);
        for (int r = 0; r < 12; r++) assert_coulomb(&world, &world.rows[r]);
        end_world(&world);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(one_vertex_meets_a_plane),
        cmocka_unit_test(impulses_shrink_when_pulled_apart),
        cmocka_unit_test(momentum_is_kept_between_cloths),
        cmocka_unit_test(passed_over_rows_would_not_change),
        cmocka_unit_test(fixed_point_is_coulomb),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
