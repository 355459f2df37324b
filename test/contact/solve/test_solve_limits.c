/* The phases of a linear solve: the limit of iterations holds with the blocks of vertices alone and
 * with aggregates, and double precision takes over where single precision fails. */
#include "base/hash.h"
#include "contact/solve/solve_in_phases.h"
#include "support/contact_world.h"
#include "support/failing_heap.h"
#include "support/paper_options.h"
#include "support/test_support.h"

enum { SIDE = 33 };

/* A step of a sheet that hangs on two corners and is pulled by gravity. */
static tulle_step_report step_sheet(int limit, double tolerance) {
    contact_world world = contact_world_make();
    change_paper(&world.def)->cg_max_iterations = limit;
    change_paper(&world.def)->cg_tolerance = tolerance;
    world.def.quality = TULLE_QUALITY_EXACT;
    contact_grid sheet = make_contact_grid(SIDE, SIDE, vec3_make(0.0, 0.0, 0.0),
                                           vec3_make(0.5, 0.0, 0.0), vec3_make(0.0, 0.5, 0.0));
    add_contact_surface(&world, sheet.mesh, false);
    world.pinned[world.pin_count++] = 0;
    world.pinned[world.pin_count++] = SIDE - 1;
    start_contact_world(&world);
    assert_non_null(world.world->work.aggregates); /* else there is one phase */
    for (int i = 0; i < 2; i++) assert_int_equal(step_contact_world(&world, 1.0 / 30.0), TULLE_OK);
    tulle_step_report const report = world.report;
    contact_world_destroy(&world);
    free_contact_grid(&sheet);
    return report;
}

static void solves_end_at_their_limit(void **state) {
    (void)state;
    static const int limits[] = {1, 3, 8, 9, 11, 20};
    for (size_t i = 0; i < sizeof limits / sizeof *limits; i++) {
        tulle_step_report const report = step_sheet(limits[i], 1e-12);
        print_message("limit %d: %u iterations of %u solves, residual %g\n", limits[i],
                      report.cg_iterations, report.solve_count, report.cg_residual);
        assert_int_equal(report.cg_iterations, (uint32_t)limits[i] * report.solve_count);
        assert_false(report.cg_converged);
    }
}

/* A tolerance far below what single precision resolves. */
static void exact_solves_keep_the_limit_too(void **state) {
    (void)state;
    tulle_step_report const whole = step_sheet(5000, 1e-12);
    print_message("%u iterations of %u solves, residual %g\n", whole.cg_iterations,
                  whole.solve_count, whole.cg_residual);
    assert_true(whole.cg_converged && whole.cg_residual <= 1e-12);
    tulle_step_report const rough = step_sheet(5000, 1e-5);
    assert_true(rough.cg_converged && rough.cg_residual <= 1e-5);
    assert_true(rough.cg_iterations < whole.cg_iterations / 2);
    int const limit = (int)(0.9 * whole.cg_iterations / whole.solve_count);
    tulle_step_report const cut = step_sheet(limit, 1e-12);
    assert_int_equal(cut.cg_iterations, (uint32_t)limit * cut.solve_count);
    assert_false(cut.cg_converged);
    assert_true(cut.cg_residual > 1e-12 && cut.cg_residual < 1e-5);
}

/* A system whose numbers are far beyond single precision. */
typedef struct large_system {
    contact_world world;
    contact_grid sheet;
    size_t size; /* of arrays: 3 numbers a vertex */
    double *b, *u, *diagonal, *inverse, *residual;
} large_system;

static void make_large_system(large_system *large) {
    static const double factor = 1e45;
    large->world = contact_world_make();
    large->sheet = make_contact_grid(SIDE, SIDE, vec3_make(0.0, 0.0, 0.0), vec3_make(0.5, 0.0, 0.0),
                                     vec3_make(0.0, 0.5, 0.0));
    add_contact_surface(&large->world, large->sheet.mesh, false);
    start_contact_world(&large->world);
    assert_int_equal(step_contact_world(&large->world, 1.0 / 30.0), TULLE_OK);
    block_matrix *const matrix = &large->world.world->work.system.matrix;
    for (size_t i = 0; i < BLOCK_NUMBERS * matrix->block_count; i++) matrix->values[i] *= factor;
    for (int k = 0; k < 2; k++) matrix->scalar_factors[k] *= factor;
    large->size = 3 * large->world.cloth_vertex_count;
    large->b = malloc(large->size * sizeof(double));
    large->u = malloc(large->size * sizeof(double));
    large->residual = malloc(large->size * sizeof(double));
    large->diagonal = malloc(3 * large->size * sizeof(double));
    large->inverse = malloc(2 * large->size * sizeof(double));
    assert_true(large->b && large->u && large->residual && large->diagonal && large->inverse);
    uint64_t seed = 5;
    for (size_t i = 0; i < large->size; i++) large->b[i] = factor * (random_uniform(&seed) - 0.5);
    block_matrix_get_diagonal(matrix, large->diagonal, 1);
    conjugate_gradients_invert((preconditioner_source){.diagonal = large->diagonal},
                               large->size / 3, 1, large->inverse);
}

static void free_large_system(large_system *large) {
    free(large->b);
    free(large->u);
    free(large->residual);
    free(large->diagonal);
    free(large->inverse);
    contact_world_destroy(&large->world);
    free_contact_grid(&large->sheet);
}

/* From u = 0, with scratch of its own. */
static tulle_status solve_large(large_system *large, arena *scratch,
                                conjugate_gradients_result *result) {
    block_matrix_operator matrix = {&large->world.world->work.system.matrix, 1};
    contact_scene scene = get_contact_scene(&large->world, 1.0 / 30.0);
    scene.scratch = scratch;
    motion_system const system = {.right_hand_side = large->b,
                                  .matrix = matrix.matrix,
                                  .aggregates = large->world.world->work.aggregates};
    conjugate_gradients_problem const problem = {.vertex_count = large->size / 3,
                                                 .apply = block_matrix_apply,
                                                 .apply_context = &matrix,
                                                 .right_hand_side = large->b,
                                                 .inverse = large->inverse,
                                                 .limit = 2000,
                                                 .threads = 1};
    phased_solve phases = {.scene = &scene,
                           .system = &system,
                           .residual = large->residual,
                           .diagonal = large->diagonal};
    solve_goal goal = {.tolerance = 1e-9};
    memset(large->u, 0, large->size * sizeof(double));
    tulle_status status = TULLE_ERROR_OUT_OF_MEMORY;
    if (single_system_make(matrix.matrix, scratch, &phases.single))
        status = solve_in_phases(&phases, &problem, &goal, true, large->u, result);
    if (status == TULLE_OK) assert_false(phases.has_residual); /* single precision leaves one */
    if (status == TULLE_OK) result->norm /= goal.reference;
    return status;
}

static void double_precision_takes_over(void **state) {
    (void)state;
    large_system large;
    conjugate_gradients_result result;
    make_large_system(&large);
    tulle_status status = TULLE_ERROR_OUT_OF_MEMORY;
    for (int calls = 0; status != TULLE_OK; calls++) { /* the next one fails */
        int left = calls;
        memory heap = failing_heap_make(&left);
        arena scratch = arena_make(&heap);
        status = solve_large(&large, &scratch, &result);
        assert_true(status == TULLE_OK || status == TULLE_ERROR_OUT_OF_MEMORY);
        arena_destroy(&scratch);
        assert_int_equal(heap.bytes_held, 0);
    }
    assert_int_equal(result.end, CONJUGATE_GRADIENTS_CONVERGED);
    assert_true(result.norm <= 1e-9); /* of the reference */
    block_matrix_operator matrix = {&large.world.world->work.system.matrix, 1};
    block_matrix_apply(&matrix, large.u, large.residual);
    double off2 = 0.0, b2 = 0.0;
    for (size_t i = 0; i < large.size; i++) {
        double const off = large.residual[i] - large.b[i];
        off2 += off * off;
        b2 += large.b[i] * large.b[i];
    }
    print_message("%d iterations, residual %g\n", result.iterations, sqrt(off2 / b2));
    assert_true(off2 <= 1e-14 * b2);
    free_large_system(&large);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(solves_end_at_their_limit),
                                       cmocka_unit_test(exact_solves_keep_the_limit_too),
                                       cmocka_unit_test(double_precision_takes_over)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
