/* Bodies taken out of the linear system, against the system with them: random rows of cloth on
 * bodies, of which one has a locked axis and one is not free. */
#include "base/hash.h"
#include "contact/rows/row_motion.h"
#include "contact/solve/body_drives.h"
#include "contact/solve/eliminate_bodies.h"
#include "contact/solve/solve_bodies.h"
#include "support/test_support.h"
#include "support/wide_normals.h"

#include <math.h>
#include <string.h>

enum { CLOTH = 12, BODIES = 4, SOLVED = CLOTH + 2 * BODIES, OF_BODY = SOLVED, ROWS = 24 };
/* [kg] scale of what rows pull */
static const double PULL_MOST = 1000.0;
enum { LOCKED = 1, NOT_FREE = 2, LOCKED_AXIS = 4 };

typedef struct system_of_bodies {
    rigid_body shapes[BODIES];
    body_drive drive;
    contact_body bodies[BODIES];
    contact_row rows[ROWS];
    contact_row *all[ROWS];
    double right_hand_side[3 * SOLVED], diagonal[9 * SOLVED], u[3 * SOLVED];
    contact_scene scene;
    memory heap;
    arena scratch;
    eliminated_bodies eliminated;
} system_of_bodies;

/* A symmetric positive definite matrix. */
static mat3 random_stiffness(uint64_t *state, double most) {
    mat3 sum = mat3_identity(0.1 * most);
    for (int i = 0; i < 2; i++) {
        vec3 const a = random_vector(state, 1.0);
        mat3 const part = mat3_outer(a, a, most * random_uniform(state));
        mat3_add_scaled(&sum, &part, 1.0);
    }
    return sum;
}

/* A row of one cloth vertex on a body, or of a body on a triangle of cloth, or of cloth alone. */
static void make_row(const contact_scene *scene, contact_row *row, uint64_t *random, int number) {
    int const side = number % 3; /* that has the body; 2: none */
    double const s = random_uniform(random), t = random_uniform(random) * (1.0 - s);
    double const weights[4] = {1.0, -s, -t, s + t - 1.0};
    *row = (contact_row){.frame.kind = FEATURE_VERTEX_TRIANGLE,
                         .frame.normal = vec3_normalize(random_vector(random, 1.0)),
                         .frame.has_body = side < 2,
                         .frame.slots = {TULLE_NONE, TULLE_NONE},
                         .solve.pull = random_stiffness(random, PULL_MOST)};
    for (int k = 0; k < 4; k++) {
        row->frame.weights[k] = weights[k];
        row->frame.vertices[k] = get_row_side(row, k) == side
                                     ? OF_BODY
                                     : (uint32_t)(3 * k) + (uint32_t)(random_next(random) % 3);
    }
    if (side == 2) return;
    size_t const body = random_next(random) % BODIES;
    if (!scene->bodies[body].is_free) { /* held like an obstacle */
        row->frame.has_body = false;
        return;
    }
    row->frame.slots[side] = get_body_slot(scene, body);
    row->frame.arms[side] = random_vector(random, 0.2);
}

static void make_system(system_of_bodies *system, uint64_t seed) {
    uint64_t random = seed;
    memset(system, 0, sizeof *system);
    system->heap = memory_default();
    system->scratch = arena_make(&system->heap);
    system->scene = (contact_scene){.cloth_vertex_count = CLOTH,
                                    .body_count = BODIES,
                                    .bodies = system->bodies,
                                    .scratch = &system->scratch};
    for (int b = 0; b < BODIES; b++) {
        contact_body *const body = &system->bodies[b];
        system->shapes[b].mass = 0.1 + random_uniform(&random);
        body->body = &system->shapes[b];
        body->is_free = b != NOT_FREE;
        body->inertia = random_stiffness(&random, 0.01);
        body->mass_factor = 1.0 + 0.5 * b;
        body->inertia_factor = 1.0 + 0.25 * b;
        body->momentum = random_vector(&random, 1.0);
        body->spin = random_vector(&random, 1.0);
    }
    system->drive.is_locked[LOCKED_AXIS] = true;
    for (int k = 0; k < BODY_AXES; k++) {
        system->drive.states[k] = DRIVE_FOLLOWS;
        system->drive.gains[k] = 10.0 * k;
        system->drive.pushes[k] = 0.3 * k;
        system->drive.limits[k] = (double)INFINITY;
    }
    system->bodies[LOCKED].drive = &system->drive;
    for (int i = 0; i < 3 * SOLVED; i++) system->u[i] = 2.0 * random_uniform(&random) - 1.0;
    fill_body_system(&system->scene, system->right_hand_side, system->diagonal);
    for (int r = 0; r < ROWS; r++) {
        make_row(&system->scene, &system->rows[r], &random, r);
        system->all[r] = &system->rows[r];
        add_row_blocks(&system->rows[r], CLOTH, &system->rows[r].solve.pull, system->diagonal);
        add_row_impulse(&system->rows[r], CLOTH, random_vector(&random, 1.0),
                        system->right_hand_side);
    }
    fix_locked(&system->scene, system->right_hand_side, system->diagonal);
    system->eliminated = (eliminated_bodies){.scene = &system->scene,
                                             .rows = system->all,
                                             .row_count = ROWS,
                                             .right_hand_side = system->right_hand_side,
                                             .diagonal = system->diagonal};
    assert_true(factor_bodies(&system->eliminated, &system->scratch));
}

static void destroy_system(system_of_bodies *system) { arena_destroy(&system->scratch); }

static double get_largest(const double *numbers, size_t count) {
    double largest = 0.0;
    for (size_t i = 0; i < count; i++) largest = fmax(largest, fabs(numbers[i]));
    return largest;
}

static void bodies_follow_the_cloth(void **state) {
    (void)state;
    double worst = 0.0;
    for (uint64_t seed = 1; seed <= 50; seed++) {
        system_of_bodies system;
        make_system(&system, seed);
        double before[3 * CLOTH];
        memcpy(before, system.u, sizeof before);
        settle_bodies(&system.eliminated, system.u);
        assert_memory_equal(before, system.u, sizeof before);
        /* b - A u has no slots left */
        double product[3 * SOLVED] = {0.0};
        apply_bodies(&system.scene, system.u, product);
        for (int r = 0; r < ROWS; r++) {
            vec3 const velocity = get_solved_velocity(&system.rows[r], CLOTH, system.u);
            vec3 const impulse = mat3_multiply_vec3(&system.rows[r].solve.pull, velocity);
            add_row_impulse(&system.rows[r], CLOTH, impulse, product);
        }
        clear_locked(&system.scene, product);
        double left[6 * BODIES];
        for (size_t i = 0; i < 6 * BODIES; i++)
            left[i] = system.bodies[i / 6].is_free
                          ? system.right_hand_side[3 * CLOTH + i] - product[3 * CLOTH + i]
                          : system.u[3 * CLOTH + i];
        assert_true(get_largest(product + 3 * CLOTH, 6 * BODIES) > 0.1);
        /* rounding of B V, whose rows pull by PULL_MOST at most each */
        double const size = ROWS * PULL_MOST * get_largest(system.u, 3 * SOLVED);
        worst = fmax(worst, get_largest(left, 6 * BODIES) / size);
        assert_true(system.u[3 * (CLOTH + 2 * LOCKED) + LOCKED_AXIS] == 0.0);
        destroy_system(&system);
    }
    print_message("slots are left with %.2g of their impulses\n", worst);
    assert_true(worst < 1e-16); /* one rounding of them all */
}

static void rows_pull_less_as_bodies_follow(void **state) {
    (void)state;
    for (uint64_t seed = 1; seed <= 50; seed++) {
        system_of_bodies system;
        make_system(&system, seed);
        double *const slots = system.u + 3 * CLOTH;
        memset(slots, 0, 6 * BODIES * sizeof(double));
        double impulses[3 * ROWS], held_work = 0.0, less, work = 0.0, wanted = 0.0;
        vec3 velocities[ROWS];
        for (size_t r = 0; r < ROWS; r++) {
            velocities[r] = get_solved_velocity(&system.rows[r], CLOTH, system.u);
            vec3 const impulse = mat3_multiply_vec3(&system.rows[r].solve.pull, velocities[r]);
            vec3_store(impulses, r, impulse);
            held_work += vec3_dot(velocities[r], impulse);
        }
        less = yield_bodies(&system.eliminated, impulses);
        /* where nothing but the cloth moves the bodies */
        memset(system.right_hand_side, 0, sizeof system.right_hand_side);
        settle_bodies(&system.eliminated, system.u);
        double worst = 0.0;
        for (size_t r = 0; r < ROWS; r++) {
            vec3 const velocity = get_solved_velocity(&system.rows[r], CLOTH, system.u);
            vec3 const impulse = mat3_multiply_vec3(&system.rows[r].solve.pull, velocity);
            worst = fmax(worst, vec3_norm(vec3_sub(impulse, vec3_load(impulses, r))));
            work += vec3_dot(velocities[r], vec3_load(impulses, r));
            wanted += vec3_dot(velocities[r], impulse);
        }
        assert_true(less > 0.01 * held_work); /* they do follow */
        assert_true(worst < 1e-10);
        assert_true(fabs(held_work - less - work) < 1e-12 * held_work);
        assert_true(fabs(wanted - work) < 1e-12 * held_work && work > 0.0);
        destroy_system(&system);
    }
}

/* Beside a row that pulls so hard the mass of its body is lost: the body must stay. */
static void mass_that_is_lost_is_told(void **state) {
    (void)state;
    system_of_bodies system;
    make_system(&system, 3);
    assert_true(system.eliminated.is_definite);
    assert_true(system.rows[0].frame.has_body);
    system.eliminated.row_count = 1;
    for (int i = 0; i < 2; i++) {
        system.rows[0].solve.pull = mat3_identity(i == 0 ? 1e10 : 1e18);
        fill_body_system(&system.scene, system.right_hand_side, system.diagonal);
        add_row_blocks(&system.rows[0], CLOTH, &system.rows[0].solve.pull, system.diagonal);
        fix_locked(&system.scene, system.right_hand_side, system.diagonal);
        assert_true(factor_bodies(&system.eliminated, &system.scratch));
        assert_true(system.eliminated.is_definite == (i == 0));
    }
    destroy_system(&system);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bodies_follow_the_cloth),
        cmocka_unit_test(rows_pull_less_as_bodies_follow),
        cmocka_unit_test(mass_that_is_lost_is_told),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
