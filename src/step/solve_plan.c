/* step/solve_plan.c - see solve_plan.h. */
#include "step/solve_plan.h"

#include <math.h>

/* Solves of motion and impulses while the impulses have not settled. */
enum { ROUNDS_MOST = 6 };
/* Solves that follow a gain of energy take so many rounds at least, then twice as many each time.
 */
enum { BALANCE_ROUNDS = 3 };

/* The next solve continues from a rough solve. So a rough solve ends at this part of its first
 * residual, but neither above so many times the tolerance nor above a hundredth. At rest the first
 * residual is small, and a rough solve is as exact as others. */
static const double ROUGH_SHARE = 0.01, ROUGH_TOLERANCES = 30.0, ROUGH_MOST = 0.01;

/* A rough solve takes so many iterations at most. Where that is not enough, it has not settled, and
 * others follow. */
enum { ROUGH_ITERATIONS = 1000 };

/* Where A's diagonal is so many times the mass on average, solves do not end late: penalties of
 * rows are ten times the diagonal. The error of a late end, times these, would exceed the weight of
 * the cloth, and grow from step to step until the cloth sticks. In single precision, directions
 * lose their conjugacy. Cotton of centimetres has 1e4, of two millimetres 6e5; sheets that slide
 * failed from 2e7 on. */
static const double STIFF_ON_AVERAGE = 5e6;

/* Solves of fine cloth, which has aggregates, have two thirds of the patience from the beginning:
 * each iteration goes farther. */
static const double FINE_PATIENCE = 2.0 / 3.0;
/* Iterations of earlier solves of a substep leave later ones of fine cloth less patience, down to a
 * third. With none, sliding layers are late by 1.5 %. Rough solves keep it: springs must be
 * linearised about a good enough solution, or a ribbon over an edge bears 3 % too much. */
enum { LATER_PATIENCE = 3 };

/* Whether the diagonal of the matrix is far larger than the masses, on average: very stiff cloth.
 */
static bool is_stiff(const step_model *model, const step_work *work) {
    const block_matrix *const matrix = &work->system.matrix;
    double held = 0.0, mass = 0.0;
    for (size_t v = 0; v < model->cloth_vertex_count; v++) {
        double const inverse_mass = work->active_inverse_masses[v];
        if (!(inverse_mass > 0.0)) continue;
        const double *const block =
            matrix->values + BLOCK_NUMBERS * (size_t)matrix->diagonal_positions[v];
        held += block[0] + block[3] + block[5];
        mass += 1.0 / inverse_mass;
    }
    return held > 3.0 * STIFF_ON_AVERAGE * mass;
}

solve_plan step_make_solve_plan(const step_model *model, const step_work *work, bool is_rough,
                                int balances) {
    const tulle_paper_options *const paper = &model->paper;
    int const rounds = balances > 0 ? BALANCE_ROUNDS << (balances - 1) : paper->solve_rounds;
    solve_plan plan = {.rounds_least = rounds,
                       .rounds_most = rounds > ROUNDS_MOST ? rounds : ROUNDS_MOST,
                       .rounds_settled = rounds,
                       .iterations_most = paper->cg_max_iterations,
                       /* The residual counts least where the matrix is stiff, and vertices of short
                        * edges would hang in the air as a pair. So solves end later there. */
                       .tolerance = model->height_share * paper->cg_tolerance,
                       .effort = &solve_efforts[model->def.quality]};
    if (is_rough) {
        plan.rounds_least = plan.rounds_most = 1;
        if (plan.iterations_most > ROUGH_ITERATIONS) plan.iterations_most = ROUGH_ITERATIONS;
        plan.early_share = ROUGH_SHARE;
        plan.early_tolerance = fmin(ROUGH_TOLERANCES * plan.tolerance, ROUGH_MOST);
    }
    /* bodies on small cloth creep where its solves end late */
    bool const is_small = !work->aggregates, has_stiff_cloth = is_stiff(model, work);
    if (model->body_count > 0 &&
        (is_small || has_stiff_cloth || has_tied_bodies(work->sub.springs, work->sub.spring_count)))
        plan.effort = &solve_efforts[TULLE_QUALITY_EXACT];
    else if (plan.effort->patience > 0 && has_stiff_cloth)
        plan.effort = &stiff_effort;
    plan.is_fine = !is_small;
    plan.patience = plan.patience_least = plan.effort->patience;
    if (plan.is_fine) {
        plan.patience = (int)(FINE_PATIENCE * plan.effort->patience);
        plan.patience_least = is_rough ? plan.patience : plan.patience / LATER_PATIENCE;
    }
    return plan;
}
