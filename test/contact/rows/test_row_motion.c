/* The arms of a row with bodies: of the predicted end of the step where one side answers nothing,
 * else from one point, so that the pair of impulses has no moment. */
#include "contact/rows/row_motion.h"

#include "support/test_support.h"

#include <math.h>

enum { BODIES = 2, SLOTS = 2 * BODIES, OBSTACLE = 2 };

/* No cloth. Bodies 0 and 1 and an obstacle have four vertices each, one of which is above the
 * others. Body b has its centre at (b, 0, 0) and turns by a right angle about z. */
typedef struct bodies_scene {
    double x0[3 * (SLOTS + 12)];
    uint32_t vertex_surface[SLOTS + 12], surface_bodies[3];
    contact_body bodies[BODIES];
    contact_scene scene;
} bodies_scene;

static uint32_t get_vertex(int surface, int number) {
    return (uint32_t)(SLOTS + 4 * surface + number);
}

static void make_scene(bodies_scene *made) {
    static const double corners[4][3] = {
        {-0.5, -0.5, 0.0}, {0.5, -0.5, 0.0}, {0.0, 0.5, 0.0}, {0.1, 0.2, 0.7}};
    *made = (bodies_scene){0};
    for (int surface = 0; surface < 3; surface++) {
        made->surface_bodies[surface] = surface < BODIES ? (uint32_t)surface : TULLE_NONE;
        for (int k = 0; k < 4; k++) {
            uint32_t const vertex = get_vertex(surface, k);
            vec3_store(made->x0, vertex,
                       vec3_make(corners[k][0] + surface, corners[k][1], corners[k][2]));
            made->vertex_surface[vertex] = (uint32_t)surface;
        }
    }
    for (int b = 0; b < BODIES; b++)
        made->bodies[b] = (contact_body){.is_free = true,
                                         .mass_factor = 1.0,
                                         .inertia_factor = 1.0,
                                         .start.position = {(double)b, 0.0, 0.0},
                                         .turn = {{0, -1, 0, 1, 0, 0, 0, 0, 1}}};
    made->scene = (contact_scene){.x0 = made->x0,
                                  .vertex_surface = made->vertex_surface,
                                  .surface_bodies = made->surface_bodies,
                                  .bodies = made->bodies,
                                  .body_count = BODIES};
}

/* The row of a surface's upper vertex with the triangle of the lower ones of another surface. */
static row_frame make_row(const bodies_scene *made, int above, int below) {
    contact_row row = {.frame = {.kind = FEATURE_VERTEX_TRIANGLE,
                                 .weights = {1.0, -0.2, -0.3, -0.5},
                                 .vertices = {get_vertex(above, 3), get_vertex(below, 0),
                                              get_vertex(below, 1), get_vertex(below, 2)}}};
    set_row_bodies(&made->scene, &row);
    return row.frame;
}

/* sum w (x - c) over the vertices of a side. */
static vec3 sum_arms(const bodies_scene *made, const row_frame *frame, int side, int body) {
    vec3 sum = {0.0, 0.0, 0.0};
    for (int k = side == 0 ? 0 : 1; k < (side == 0 ? 1 : 4); k++)
        sum = vec3_add_scaled(
            sum,
            vec3_sub(vec3_load(made->x0, frame->vertices[k]), made->bodies[body].start.position),
            frame->weights[k]);
    return sum;
}

static void assert_same_vector(vec3 a, vec3 b) { assert_true(vec3_norm(vec3_sub(a, b)) < 1e-15); }

static void arms_against_what_answers_nothing_are_those_of_the_end(void **state) {
    (void)state;
    bodies_scene made;
    make_scene(&made);
    for (int side = 0; side < 2; side++) {
        int const body = 1 - side; /* any */
        row_frame const frame =
            make_row(&made, side == 0 ? body : OBSTACLE, side == 0 ? OBSTACLE : body);
        assert_true(frame.has_body && frame.has_end_arms && frame.is_without_cloth);
        assert_int_equal(frame.slots[side], get_body_slot(&made.scene, (size_t)body));
        assert_int_equal(frame.slots[1 - side], TULLE_NONE);
        vec3 const arm = sum_arms(&made, &frame, side, body);
        assert_same_vector(frame.arms[side], vec3_make(-arm.y, arm.x, arm.z));
        assert_same_vector(frame.arms[1 - side], vec3_make(0.0, 0.0, 0.0));
    }
}

static void arms_of_two_bodies_meet_in_one_point(void **state) {
    (void)state;
    bodies_scene made;
    make_scene(&made);
    row_frame const frame = make_row(&made, 0, 1);
    assert_true(frame.has_body && !frame.has_end_arms);
    vec3 const above = vec3_add(frame.arms[0], made.bodies[0].start.position);
    vec3 const below = vec3_sub(made.bodies[1].start.position, frame.arms[1]);
    assert_same_vector(above, below);
    vec3 const first = vec3_load(made.x0, frame.vertices[0]);
    vec3 const second = vec3_sub(made.bodies[1].start.position, sum_arms(&made, &frame, 1, 1));
    assert_same_vector(above, vec3_lerp(first, second, 0.5));
}

static void what_has_no_body_has_no_arms(void **state) {
    (void)state;
    bodies_scene made;
    make_scene(&made);
    assert_false(make_row(&made, OBSTACLE, OBSTACLE).has_body);
    made.bodies[0].is_free = false; /* as long as it sleeps */
    assert_false(make_row(&made, 0, OBSTACLE).has_body);
    assert_true(make_row(&made, 0, 1).has_end_arms);
}

/* A row adds K to the block of its body's slot, and [a]x K [a]x^T to that of the turn. */
static void blocks_of_the_turn_are_those_of_the_arm(void **state) {
    (void)state;
    bodies_scene made;
    make_scene(&made);
    contact_row row = {.frame = make_row(&made, 0, OBSTACLE)};
    mat3 const stiffness = {{3.0, 0.5, 0.2, 0.5, 2.0, -0.4, 0.2, -0.4, 1.0}};
    double blocks[9 * (SLOTS + 12)] = {0.0};
    add_row_blocks(&row, 0, &stiffness, blocks);
    size_t const slot = row.frame.slots[0];
    vec3 const arm = row.frame.arms[0];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            vec3 const axes[3] = {{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}};
            /* e_i . [a]x K [a]x^T e_j = (e_i x a) . K (e_j x a) */
            vec3 const left = vec3_cross(axes[i], arm), right = vec3_cross(axes[j], arm);
            double const expected = vec3_dot(left, mat3_multiply_vec3(&stiffness, right));
            assert_true(fabs(blocks[9 * (slot + 1) + (size_t)(3 * i + j)] - expected) < 1e-14);
            assert_true(blocks[9 * slot + (size_t)(3 * i + j)] == stiffness.m[3 * i + j]);
        }
}

/* The blocks of vertices are those of J^T K J, also where a tie stands at a height over its
 * triangle; the last vertex is none of the solve. */
static void blocks_of_vertices_are_those_of_the_products(void **state) {
    (void)state;
    enum { SOLVED = 3 };
    row_tilt const tilt = {{0.0, 0.6, 0.8}, {{0.1, -0.2, 0.3}, {0.4, 0.1, -0.5}, {-0.5, 0.1, 0.2}}};
    mat3 const stiffness = {{3.0, 0.5, 0.2, 0.5, 2.0, -0.4, 0.2, -0.4, 1.0}};
    for (int is_tilted = 0; is_tilted < 2; is_tilted++) {
        contact_row const row = {.frame = {.kind = FEATURE_VERTEX_TRIANGLE,
                                           .weights = {1.0, -0.2, -0.3, -0.5},
                                           .vertices = {0, 1, 2, SOLVED},
                                           .tilt = is_tilted ? &tilt : NULL}};
        double blocks[9 * SOLVED] = {0.0};
        add_row_blocks(&row, SOLVED, &stiffness, blocks);
        for (size_t i = 0; i < 3 * (size_t)SOLVED; i++) {
            double u[3 * SOLVED] = {0.0}, sum[3 * SOLVED] = {0.0};
            u[i] = 1.0;
            vec3 const velocity = get_solved_velocity(&row, SOLVED, u);
            add_row_impulse(&row, SOLVED, mat3_multiply_vec3(&stiffness, velocity), sum);
            size_t const vertex = i / 3;
            for (size_t k = 0; k < 3; k++)
                assert_true(fabs(blocks[9 * vertex + 3 * k + i % 3] - sum[3 * vertex + k]) < 1e-15);
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(arms_against_what_answers_nothing_are_those_of_the_end),
        cmocka_unit_test(arms_of_two_bodies_meet_in_one_point),
        cmocka_unit_test(what_has_no_body_has_no_arms),
        cmocka_unit_test(blocks_of_the_turn_are_those_of_the_arm),
        cmocka_unit_test(blocks_of_vertices_are_those_of_the_products),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
