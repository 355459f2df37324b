/* contact/solve/solve_motion.c - stage 7, see solve_motion.h.
 *
 * Each round solves  A u = b + J^T p  by conjugate gradients, with the impulses p of the round
 * before; the first round takes those of the step before. Rows that are violated become hard: with
 * penalties on their normal part and on their slip they join A while they carry load, and p is
 * their multiplier (hard_rows.c). So impulses act inside the implicit solve, in the metric of A.
 * After each solve the total impulses of other rows, and of rows between bodies alone, are
 * projected on the Coulomb cones in the metric of the true masses. At the fixed point neither
 * changes anything.
 *
 * Based on: Moreau 1988 and Jean 1999 as in project_impulses.c; for hard rows see there.
 * Departure: contact dynamics project every impulse in the metric of the masses. Where a tip or a
 * plane carries stiff cloth, that corrects too little in a round, by the ratio of A's diagonal to
 * the mass, and the last projection gives the springs energy. */
#include "contact/solve/solve_motion.h"

#include "base/parallel.h"
#include "contact/rows/row_motion.h"
#include "contact/solve/body_drives.h"
#include "contact/solve/end_round.h"
#include "contact/solve/hard_rows.h"
#include "contact/solve/project_impulses.h"
#include "contact/solve/solve_bodies.h"
#include "contact/solve/solve_in_phases.h"

#include <math.h>
#include <string.h>

/* The reference of residuals is at least this part of the momentum's norm: free flight has no force
 * to compare with. */
static const double LEAST_REFERENCE = 1e-12;

/* With bodies on cloth a solve must also get below this share of the net impulse at the velocities
 * of the start, J^T p included, which is what is about to change them. The force impulse of cloth
 * under a body at rest is that of the body's weight, however little the cloth moves. A residual of
 * 1e-4 of that feeds each step into the next, and over minutes makes a stack slip along. The net
 * impulse dies out with the motion. A smaller tolerance instead does not stop the slip for sure
 * (lab/bodies.md). */
static const double NET_SHARE = 0.01;
/* Where a solve of cloth alone may end above its tolerance, it must get below this share. Without
 * it cloth creeps down a slope that holds it. */
static const double LATE_NET_SHARE = 0.1;
/* It must also get below this tolerance, however large the given one is. */
static const double LATE_MOST = 0.01;
/* A rigid tie pulls so many times as hard as the matrix gives there. With more, conjugate gradients
 * take longer, and nobody sees the difference. */
static const double RIGID_PULL = 30.0;
/* A net impulse below this part of the force impulse counts as none. */
static const double LEAST_NET = 1e-9;
/* So does one below this part of all impulses, which is far over what rounding leaves of their sum.
 */
static const double LEAST_NET_OF_ALL = 1e-13;

/* Where A's diagonal is so many times the mass, the first solve of a substep begins with the best
 * translation. To begin with none is to have the weight of all cloth as residual, which the
 * diagonal divides unevenly: at borders, and where triangles differ. Conjugate gradients then take
 * hundreds of iterations, thousands for a centimetre of silk, to make a sheet fall. */
static const double VERY_STIFF = 1e6;
/* Scalars of the matrix whose sums are kept during a call. With the sums of more of them, solves of
 * large cloth would take more scratch than any other stage. */
enum { MOST_SUMMED = 4 << 20 };
/* Vertices of a chunk of a loop. */
enum { VERTICES_PER_CHUNK = 1024 };

typedef struct motion_solve {
    const contact_scene *scene;
    const motion_system *system;
    const solve_plan *plan;
    row_list *list;
    double *u;
    solve_report *report;
    double *right_hand_side, *diagonal; /* of the round */
    double *inverse;                    /* of its blocks, for conjugate gradients */
    uint8_t *has_rows; /* vertices whose blocks rows have changed in this round or before */
    uint8_t *is_fixed;
    double *start;         /* velocities of the start; of what is fixed, the prescribed ones */
    double *start_product; /* the system's matrix times these */
    double reference;      /* of residuals */
    double net_of_cloth, net_of_all; /* net impulses in solves of cloth alone, and of all; 0: not
                                        known yet */
    block_matrix without_rows;       /* the system's matrix with its scalars summed */
    /* The same. Where solves are in double precision, it has numbers of its own, and in them the
     * hard rows that lie in its pattern. Solves in single precision have them in their copy and
     * need few products with this one. */
    block_matrix matrix;
    contact_row **rows_apart; /* hard rows that do not */
    size_t apart_count;
    friction_sums *sums; /* of each surface */
    phased_solve phases;
    bool is_cloth_only; /* vectors of the system have no entries of slots */
    bool is_at_start;   /* u is `start` */
} motion_solve;

/* y += sum over hard rows apart of J^T K J x */
static void add_rows_apart(const motion_solve *solve, const double *x, double *y) {
    size_t const cloth_count = solve->scene->cloth_vertex_count;
    for (size_t i = 0; i < solve->apart_count; i++) {
        const contact_row *const row = solve->rows_apart[i];
        vec3 const velocity = get_solved_velocity(row, cloth_count, x);
        add_row_impulse(row, cloth_count, mat3_multiply_vec3(&row->solve.pull, velocity), y);
    }
}

/* y = A x + sum over hard rows of J^T K J x */
static void apply_with_hard_rows(void *context, const double *x, double *y) {
    const motion_solve *const solve = context;
    block_matrix_operator matrix = {&solve->matrix, solve->scene->threads};
    block_matrix_apply(&matrix, x, y);
    if (!solve->is_cloth_only) apply_bodies(solve->scene, x, y);
    add_rows_apart(solve, x, y);
    if (!solve->is_cloth_only) clear_locked(solve->scene, y);
}

/* Whether hard rows are added to numbers of its own. */
static bool has_own_numbers(const motion_solve *solve) {
    return solve->matrix.values != solve->system->matrix->values;
}

/* The matrix of the round, without numbers of its own, times the velocities of the start. */
static void multiply_start(const motion_solve *solve, double *product) {
    memcpy(product, solve->start_product, 3 * solve->scene->cloth_vertex_count * sizeof(double));
    add_rows_apart(solve, solve->start, product);
}

/* Adds a row to the diagonal blocks of its vertices. */
static void add_to_diagonal(motion_solve *solve, const contact_row *row) {
    size_t const cloth_count = solve->scene->cloth_vertex_count;
    add_row_blocks(row, cloth_count, &row->solve.pull, solve->diagonal);
    for (int k = 0; k < 4; k++)
        if (row->frame.vertices[k] < cloth_count) solve->has_rows[row->frame.vertices[k]] = 1;
}

/* Adds the springs of ties to the right-hand side and to the rows of the round. */
static void add_springs(motion_solve *solve) {
    const contact_scene *const scene = solve->scene;
    size_t const cloth_count = scene->cloth_vertex_count;
    for (size_t i = 0; i < solve->system->spring_count; i++) {
        tie_spring *const spring = &solve->system->springs[i];
        contact_row *const row = &spring->row;
        vec3 const led = vec3_sub(get_coupled_velocity(row, solve->u),
                                  get_solved_velocity(row, cloth_count, solve->u));
        vec3 const wanted = vec3_scale(spring->away, -1.0 / scene->time_step);
        vec3 const impulse = vec3_scale(vec3_sub(wanted, led), spring->pull);
        add_to_diagonal(solve, row);
        add_row_impulse(row, cloth_count, impulse, solve->right_hand_side);
        solve->rows_apart[solve->apart_count++] = row;
        solve->phases.hard_rows[solve->phases.hard_count++] = row;
    }
}

/* Sets how hard the springs of ties pull: as they are told, or so hard that the matrix, of which
 * these are the diagonal blocks, gives. */
static void set_springs(motion_solve *solve) {
    const contact_scene *const scene = solve->scene;
    for (size_t i = 0; i < solve->system->spring_count; i++) {
        tie_spring *const spring = &solve->system->springs[i];
        double mobility = (double)INFINITY; /* [1/kg] least along the axes */
        for (int axis = 0; axis < 3 && !isfinite(spring->stiffness); axis++) {
            spring->row.frame.normal = vec3_make(axis == 0, axis == 1, axis == 2);
            mobility = fmin(mobility, measure_row_mobility(scene, &spring->row, solve->diagonal));
        }
        spring->pull = spring->stiffness * solve->system->force_time * scene->time_step;
        if (!isfinite(spring->stiffness))
            spring->pull = mobility > 0.0 ? RIGID_PULL / mobility : 0.0;
        spring->row.solve.pull = mat3_identity(spring->pull);
    }
}

/* Makes right-hand side, diagonal and hard rows of a round. A hard row takes part only while it
 * carries load or is violated; else it would pull. */
static void prepare_round(motion_solve *solve, bool is_first) {
    const contact_scene *const scene = solve->scene;
    const motion_system *const system = solve->system;
    size_t const cloth_count = scene->cloth_vertex_count;
    double *const right_hand_side = solve->right_hand_side;
    memcpy(right_hand_side, system->right_hand_side, 3 * cloth_count * sizeof(double));
    if (!is_first) /* before the first round the diagonal has no rows in it */
        block_matrix_get_diagonal(system->matrix, solve->diagonal, scene->threads);
    fill_body_system(scene, right_hand_side, solve->diagonal);
    solve->phases.hard_count = solve->apart_count = 0;
    add_springs(solve);
    if (has_own_numbers(solve))
        memcpy(solve->matrix.values, system->matrix->values,
               BLOCK_NUMBERS * system->matrix->block_count * sizeof(double));
    for (size_t i = 0; i < solve->list->rows.count; i++) {
        contact_row *const row = &solve->list->rows.data[i];
        const row_frame *const frame = &row->frame;
        bool takes_part = row->solve.is_hard;
        if (takes_part && !(get_normal_impulse(row) > 0.0))
            takes_part = vec3_dot(frame->normal, get_relative_velocity(row, solve->u)) <
                         get_wanted_speed(row);
        if (!takes_part) {
            add_row_impulse(row, cloth_count, row->solve.impulse, right_hand_side);
            row->solve.friction_cap = -1.0;
            row->solve.is_in_matrix = false;
            continue;
        }
        make_pull(&scene->settings, row, solve->u);
        add_to_diagonal(solve, row);
        matrix_term term = {.stiffness = row->solve.pull};
        for (int k = 0; k < 4; k++) {
            bool const is_cloth = frame->vertices[k] < cloth_count;
            term.vertices[k] = is_cloth ? frame->vertices[k] : TULLE_NONE;
            term.weights[k] = frame->weights[k];
        }
        if (!has_own_numbers(solve) || frame->has_body ||
            !block_matrix_add_term(&solve->matrix, &term))
            solve->rows_apart[solve->apart_count++] = row;
        /* w of the row, less the part of obstacles: the operator knows unknowns only */
        vec3 target = vec3_add_scaled(row->solve.slip_target, frame->normal, get_wanted_speed(row));
        target = vec3_add(target, frame->turning);
        for (int k = 0; k < 4; k++)
            if (frame->vertices[k] >= cloth_count && is_row_vertex(row, k))
                target = vec3_add_scaled(target, vec3_load(solve->u, frame->vertices[k]),
                                         -frame->weights[k]);
        vec3 const pulled = mat3_multiply_vec3(&row->solve.pull, target);
        add_row_impulse(row, cloth_count, vec3_add(row->solve.impulse, pulled), right_hand_side);
        row->solve.is_in_matrix = true;
        solve->phases.hard_rows[solve->phases.hard_count++] = row;
    }
    fix_locked(scene, right_hand_side, solve->diagonal);
    /* the blocks that are not what they were */
    preconditioner_source const source = {solve->diagonal, solve->is_fixed};
    for (size_t v = 0; v < get_solved_count(scene); v++)
        if (solve->has_rows[v]) invert_block_of(source, v, solve->inverse + BLOCK_NUMBERS * v);
}

/* Moves u along one direction of rigid translations, as far as is best: each free cloth and body by
 * its own residual, or all by the same velocity. `masses` [kg]: of each surface, infinite if
 * something holds it. */
static void descend_translations(motion_solve *solve, bool is_common, const double *masses,
                                 double *work[3]) {
    const contact_scene *const scene = solve->scene;
    const surface_set *const set = scene->set;
    size_t const size = 3 * get_solved_count(scene);
    double *const shift = work[1], *const image = work[2];
    /* b - A u: that of the last solve, where it left one */
    const double *residual = work[0];
    if (solve->phases.has_residual) {
        residual = solve->phases.residual;
    } else {
        apply_with_hard_rows(solve, solve->u, work[0]);
        for (size_t i = 0; i < size; i++) work[0][i] = solve->right_hand_side[i] - work[0][i];
    }
    /* the direction: residual over mass; bodies also turn, by their own inertia */
    vec3 total = {0.0, 0.0, 0.0};
    double total_mass = 0.0;
    memset(shift, 0, size * sizeof(double));
    for (size_t s = 0; s < set->surface_count; s++) {
        if (!isfinite(masses[s])) continue;
        vec3 sum = {0.0, 0.0, 0.0};
        for (uint32_t v = set->surfaces[s].vertex_begin; v < set->surfaces[s].vertex_end; v++)
            sum = vec3_add(sum, vec3_load(residual, v));
        for (uint32_t v = set->surfaces[s].vertex_begin; v < set->surfaces[s].vertex_end; v++)
            vec3_store(shift, v, vec3_scale(sum, 1.0 / masses[s]));
        total = vec3_add(total, sum);
        total_mass += masses[s];
    }
    for (size_t b = 0; b < scene->body_count; b++) {
        const contact_body *const body = &scene->bodies[b];
        size_t const slot = get_body_slot(scene, b);
        if (!body->is_free) continue;
        vec3 const sum = vec3_load(residual, slot), spin = vec3_load(residual, slot + 1);
        vec3 const a = body->inverse_mass;
        vec3_store(shift, slot, vec3_make(a.x * sum.x, a.y * sum.y, a.z * sum.z));
        vec3_store(shift, slot + 1, mat3_multiply_vec3(&body->inverse_inertia, spin));
        total = vec3_add(total, sum);
        total_mass += body->body->mass;
    }
    if (is_common) {
        vec3 const common = vec3_scale(total, total_mass > 0.0 ? 1.0 / total_mass : 0.0);
        for (size_t s = 0; s < set->surface_count; s++) {
            if (!isfinite(masses[s])) continue;
            for (uint32_t v = set->surfaces[s].vertex_begin; v < set->surfaces[s].vertex_end; v++)
                vec3_store(shift, v, common);
        }
        for (size_t b = 0; b < scene->body_count; b++) {
            if (!scene->bodies[b].is_free) continue;
            vec3_store(shift, get_body_slot(scene, b), common);
            vec3_store(shift, get_body_slot(scene, b) + 1, vec3_make(0.0, 0.0, 0.0));
        }
        clear_locked(scene, shift);
    }
    /* the way to the least of the quadratic form */
    double down = 0.0, curvature = 0.0;
    for (size_t i = 0; i < size; i++) down += shift[i] * residual[i];
    if (!(down > 0.0)) return;
    apply_with_hard_rows(solve, shift, image);
    for (size_t i = 0; i < size; i++) curvature += shift[i] * image[i];
    if (!(curvature > 0.0)) return;
    solve->phases.has_residual = false; /* u moves on */
    solve->is_at_start = false;
    for (size_t i = 0; i < size; i++) solve->u[i] += down / curvature * shift[i];
}

/* Improves u along the rigid translations of free cloths and bodies. A small force on all of a
 * cloth hardly shows in the residual, since its preconditioner divides by the stiffness: the pull
 * on cloth that just begins to slip is such a force. Without this step the tolerance would swallow
 * such forces, and linear momentum would be kept to the tolerance only. Hard rows couple cloths,
 * but all of them together still move freely. */
static tulle_status translate_cloths(motion_solve *solve) {
    const contact_scene *const scene = solve->scene;
    size_t const size = 3 * get_solved_count(scene), surface_count = scene->set->surface_count;
    arena_mark const mark = arena_get_mark(scene->scratch);
    double *const masses = ARENA_NEW(scene->scratch, double, surface_count);
    double *work[3];
    bool has_memory = masses != NULL;
    for (int i = 0; i < 3; i++) {
        work[i] = ARENA_NEW(scene->scratch, double, size);
        has_memory &= work[i] != NULL;
    }
    size_t free_count = 0; /* cloths and bodies that nothing holds */
    for (size_t s = 0; s < surface_count && has_memory; s++) {
        const surface_range *const range = &scene->set->surfaces[s];
        masses[s] = (double)INFINITY;
        if (range->is_obstacle) continue;
        masses[s] = 0.0;
        for (uint32_t v = range->vertex_begin; v < range->vertex_end; v++)
            masses[s] += 1.0 / scene->inverse_mass[v];
        if (isfinite(masses[s])) free_count++;
    }
    for (size_t b = 0; b < scene->body_count; b++) free_count += scene->bodies[b].is_free;
    if (has_memory && free_count > 0) descend_translations(solve, false, masses, work);
    if (has_memory && solve->phases.hard_count > 0 && free_count > 1)
        descend_translations(solve, true, masses, work);
    arena_release(scene->scratch, mark);
    return has_memory ? TULLE_OK : TULLE_ERROR_OUT_OF_MEMORY;
}

/* The norms of the right-hand side and of the net impulse at the velocities of the start. */
static tulle_status measure_net(const motion_solve *solve,
                                const conjugate_gradients_problem *problem, double *of_all,
                                double *net) {
    const contact_scene *const scene = solve->scene;
    arena_mark const mark = arena_get_mark(scene->scratch);
    conjugate_gradients_problem at_start = *problem;
    bool const is_known = solve->is_cloth_only && !has_own_numbers(solve);
    at_start.residual = ARENA_NEW(scene->scratch, double, 3 * problem->vertex_count);
    tulle_status status = at_start.residual ? TULLE_OK : TULLE_ERROR_OUT_OF_MEMORY;
    if (status == TULLE_OK && is_known) multiply_start(solve, at_start.residual);
    if (status == TULLE_OK)
        status =
            conjugate_gradients_measure(problem, problem->right_hand_side, scene->scratch, of_all);
    if (status == TULLE_OK)
        status = conjugate_gradients_leave(&at_start, is_known ? NULL : solve->start,
                                           scene->scratch, net);
    arena_release(scene->scratch, mark);
    return status;
}

/* Lowers a tolerance to this share of the net impulse. That of the first solve of its kind counts.
 */
static tulle_status bound_by_net(motion_solve *solve, const conjugate_gradients_problem *problem,
                                 double share, double *net, double *tolerance) {
    double *const reference = &solve->reference;
    if (!(*net > 0.0)) {
        double of_all = 0.0, measured = 0.0;
        tulle_status const status = measure_net(solve, problem, &of_all, &measured);
        if (status != TULLE_OK) return status;
        if (!(of_all > 0.0)) of_all = measured;
        if (!(*reference > 0.0)) *reference = of_all; /* no cloth can move */
        double const least = fmax(LEAST_NET * *reference, LEAST_NET_OF_ALL * of_all);
        *net = fmax(measured, least / NET_SHARE);
    }
    if (*reference > 0.0) *tolerance = fmin(*tolerance, share * *net / *reference);
    return TULLE_OK;
}

/* Iterations before a solve may end late. */
static int choose_patience(const motion_solve *solve) {
    int const most = solve->plan->patience, least = solve->plan->patience_least;
    uint32_t const spent = solve->system->history->iterations + solve->report->cg_iterations;
    return spent >= (uint32_t)(most - least) ? least : most - (int)spent;
}

/* Where a solve ends, and where it may end late. */
static tulle_status choose_goal(motion_solve *solve, const conjugate_gradients_problem *problem,
                                solve_goal *goal) {
    const solve_plan *const plan = solve->plan;
    bool const has_bodies = !solve->is_cloth_only;
    double *const net = has_bodies ? &solve->net_of_all : &solve->net_of_cloth;
    tulle_status status = TULLE_OK;
    *goal = (solve_goal){.tolerance = plan->tolerance,
                         .early_share = plan->early_share,
                         .early_tolerance = plan->early_tolerance};
    if (plan->patience > 0 && solve->reference > 0.0) {
        goal->patience = choose_patience(solve);
        goal->late_tolerance = fmin(plan->effort->late_factor * goal->tolerance, LATE_MOST);
        status = bound_by_net(solve, problem, has_bodies ? NET_SHARE : LATE_NET_SHARE, net,
                              &goal->late_tolerance);
    }
    if (status == TULLE_OK && has_bodies)
        status = bound_by_net(solve, problem, NET_SHARE, net, &goal->tolerance);
    goal->reference = solve->reference;
    return status;
}

/* Solves for u in one round. */
static tulle_status solve_linear(motion_solve *solve) {
    const contact_scene *const scene = solve->scene;
    const solve_plan *const plan = solve->plan;
    solve_history *const history = solve->system->history;
    bool const is_at_start = solve->is_at_start;
    solve->is_at_start = solve->phases.has_residual = false;
    conjugate_gradients_problem problem = {
        .vertex_count = get_solved_count(scene),
        .apply = apply_with_hard_rows,
        .apply_context = solve,
        .right_hand_side = solve->right_hand_side,
        .inverse = solve->inverse,
        .is_idle = solve->matrix.is_idle,
        .limit = plan->iterations_most,
        .threads = scene->threads,
        .stop = scene->stop,
    };
    conjugate_gradients_result result;
    bool has_hard_bodies = false, has_tilts = false;
    for (size_t i = 0; i < solve->phases.hard_count; i++) {
        has_hard_bodies |= solve->phases.hard_rows[i]->frame.has_body;
        has_tilts |= solve->phases.hard_rows[i]->frame.tilt != NULL;
    }
    bool const has_aggregates = solve->system->aggregates != NULL;
    bool const is_single = has_aggregates && !has_tilts &&
                           !has_tied_bodies(solve->system->springs, solve->system->spring_count);
    if (!has_hard_bodies) { /* no hard row joins bodies to cloth: they are solved by themselves */
        solve->is_cloth_only = true;
        problem.vertex_count = scene->cloth_vertex_count;
        precondition_bodies(scene, solve->diagonal, solve->right_hand_side, solve->u);
    }
    solve_goal goal;
    tulle_status status = choose_goal(solve, &problem, &goal);
    phased_solve *const phases = &solve->phases;
    phases->has_product = is_single && is_at_start && !has_hard_bodies && !has_own_numbers(solve);
    if (status == TULLE_OK && phases->has_product) multiply_start(solve, phases->residual);
    if (status == TULLE_OK)
        status = solve_in_phases(phases, &problem, &goal, is_single, solve->u, &result);
    solve->is_cloth_only = false;
    if (status != TULLE_OK) return status;
    double *const residual = solve->phases.residual;
    size_t const cloth_size = 3 * scene->cloth_vertex_count, size = 3 * get_solved_count(scene);
    if (!has_hard_bodies) { /* what rounding left of theirs is mended below */
        apply_bodies(scene, solve->u, residual);
        for (size_t i = cloth_size; i < size; i++)
            residual[i] = solve->right_hand_side[i] - residual[i];
        clear_locked(scene, residual);
    } else if (is_single) { /* they have followed */
        memset(residual + cloth_size, 0, (size - cloth_size) * sizeof(double));
    }
    if (stop_is_wanted(scene->stop, 0)) return TULLE_ERROR_INTERRUPTED;
    solve_report *const report = solve->report;
    double const left = goal.reference > 0.0 ? result.norm / goal.reference : 0.0;
    bool const outlasts = goal.patience > 0 && result.iterations >= goal.patience;
    history->is_costly |= outlasts && plan->is_fine;
    report->solve_count++;
    report->cg_iterations += (uint32_t)result.iterations;
    if (result.end != CONJUGATE_GRADIENTS_CONVERGED) report->has_converged = false;
    bool const is_late = outlasts && left <= goal.late_tolerance;
    if (result.end == CONJUGATE_GRADIENTS_CONVERGED && left > goal.tolerance && !is_late)
        report->is_early = true;
    else
        report->cg_residual = fmax(report->cg_residual, left);
    return translate_cloths(solve); /* the tolerance must not cost momentum */
}

static void set_start(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    const motion_solve *const solve = context;
    const contact_scene *const scene = solve->scene;
    const double *const cloth = solve->system->start ? solve->system->start : solve->u;
    for (size_t i = begin; i < end; i++) {
        bool const is_cloth = i < scene->cloth_vertex_count;
        solve->is_fixed[i] = is_cloth ? !(scene->inverse_mass[i] > 0.0)
                                      : !scene->bodies[(i - scene->cloth_vertex_count) / 2].is_free;
        const double *const free = is_cloth ? cloth : scene->v0;
        vec3_store(solve->start, i, vec3_load(solve->is_fixed[i] ? solve->u : free, i));
    }
}

/* Sets what is fixed, velocities of the start, the inverse blocks and the reference of residuals:
 * the norm of the force impulse b - A u at the velocities of the start, as conjugate gradients
 * measure it. */
static tulle_status prepare_start(motion_solve *solve) {
    const contact_scene *const scene = solve->scene;
    const motion_system *const system = solve->system;
    size_t const count = scene->cloth_vertex_count;
    parallel_for(get_solved_count(scene), VERTICES_PER_CHUNK, scene->threads, set_start, solve);
    conjugate_gradients_problem const problem = {
        .vertex_count = count,
        .right_hand_side = system->right_hand_side,
        .inverse = solve->inverse,
        .residual = solve->phases.residual,
        .threads = scene->threads,
    };
    preconditioner_source const source = {solve->diagonal, solve->is_fixed}; /* no row yet */
    conjugate_gradients_invert(source, count, scene->threads, solve->inverse);
    block_matrix_operator matrix = {&solve->without_rows, scene->threads};
    block_matrix_apply(&matrix, solve->start, solve->start_product);
    memcpy(problem.residual, solve->start_product, 3 * count * sizeof(double));
    double of_momentum = 0.0;
    tulle_status status =
        conjugate_gradients_leave(&problem, NULL, scene->scratch, &solve->reference);
    if (status == TULLE_OK)
        status = conjugate_gradients_measure(&problem, system->right_hand_side, scene->scratch,
                                             &of_momentum);
    solve->reference = fmax(solve->reference, LEAST_REFERENCE * of_momentum);
    return status;
}

/* Whether a vertex of the cloth is held by its neighbours as if by far more than its mass. */
static bool is_very_stiff(const motion_solve *solve) {
    const contact_scene *const scene = solve->scene;
    for (size_t v = 0; v < scene->cloth_vertex_count; v++)
        if (solve->diagonal[9 * v] * scene->inverse_mass[v] > VERY_STIFF) return true;
    return false;
}

tulle_status solve_motion(const contact_scene *scene, const motion_system *system,
                          const solve_plan *plan, row_list *list, double *u, solve_report *report) {
    *report = (solve_report){.has_converged = true, .has_settled = true};
    arena *const scratch = scene->scratch;
    arena_mark const mark = arena_get_mark(scratch);
    size_t const cloth_count = scene->cloth_vertex_count, count = get_solved_count(scene);
    size_t const row_most = list->rows.count + system->spring_count;
    size_t const inverse_size = BLOCK_NUMBERS * count;
    motion_solve solve = {.scene = scene,
                          .system = system,
                          .plan = plan,
                          .list = list,
                          .u = u,
                          .report = report,
                          .right_hand_side = ARENA_NEW(scratch, double, 3 * count),
                          .diagonal = ARENA_NEW(scratch, double, 9 * count),
                          .inverse = ARENA_NEW(scratch, double, inverse_size),
                          .has_rows = ARENA_NEW_ZEROED(scratch, uint8_t, count),
                          .is_fixed = ARENA_NEW(scratch, uint8_t, count),
                          .start = ARENA_NEW(scratch, double, 3 * count),
                          .start_product = ARENA_NEW(scratch, double, 3 * cloth_count),
                          .without_rows = *system->matrix,
                          .is_at_start = !system->start,
                          .rows_apart = ARENA_NEW(scratch, contact_row *, row_most),
                          .sums = ARENA_NEW(scratch, friction_sums, scene->set->surface_count),
                          .phases = {.scene = scene,
                                     .system = system,
                                     .residual = ARENA_NEW(scratch, double, 3 * count)}};
    bool const has_sums = system->matrix->scalar_count <= MOST_SUMMED;
    double *const scalars = ARENA_NEW(scratch, double, has_sums ? system->matrix->scalar_count : 0);
    solve.without_rows.scalar_sums = has_sums ? scalars : NULL;
    solve.matrix = solve.without_rows;
    if (!system->aggregates || (scene->body_count > 0 && system->spring_count > 0))
        solve.matrix.values =
            ARENA_NEW(scratch, double, BLOCK_NUMBERS * system->matrix->block_count + BLOCK_PADDING);
    bool const has_single = !system->aggregates ||
                            single_system_make(&solve.without_rows, scratch, &solve.phases.single);
    tulle_status status = TULLE_ERROR_OUT_OF_MEMORY;
    solve.phases.hard_rows = ARENA_NEW(scratch, contact_row *, row_most);
    solve.phases.is_fixed = solve.is_fixed;
    solve.phases.diagonal = solve.diagonal;
    if (solve.right_hand_side && solve.diagonal && solve.inverse && solve.has_rows &&
        solve.is_fixed && solve.start && solve.start_product && solve.phases.hard_rows &&
        solve.rows_apart && solve.sums && solve.phases.residual && scalars && solve.matrix.values &&
        has_single) {
        for (size_t i = cloth_count; i < count; i++) solve.has_rows[i] = 1; /* bodies */
        if (has_sums) block_matrix_sum_scalars(system->matrix, scalars, scene->threads);
        block_matrix_get_diagonal(system->matrix, solve.diagonal, scene->threads);
        status = prepare_start(&solve);
    }
    contact_row *const rows = list->rows.data;
    size_t const row_count = list->rows.count;
    bool const moves_first = status == TULLE_OK && !system->start && is_very_stiff(&solve);
    if (status == TULLE_OK) set_springs(&solve);
    update_body_rows(scene, rows, row_count);
    if (status == TULLE_OK) prepare_hard_rows(scene, solve.diagonal, rows, row_count, u);
    for (int round = 0; round < plan->rounds_most && status == TULLE_OK; round++) {
        uint32_t const before = report->cg_iterations;
        prepare_round(&solve, round == 0);
        if (moves_first && round == 0) status = translate_cloths(&solve);
        if (status == TULLE_OK) status = solve_linear(&solve);
        if (status != TULLE_OK) break;
        if (row_count == 0) { /* ties alone may answer what a drive does now */
            if (settle_drives(scene, rows, row_count, u) && system->spring_count > 0) continue;
            break;
        }
        round_result result;
        uint32_t const spent = report->cg_iterations - before;
        status = end_round(scene,
                           system->history->is_costly ? plan->effort
                                                      : get_round_effort(plan->effort, spent),
                           list, solve.sums, u, &result);
        if (status != TULLE_OK) break;
        report->violation = result.largest_violation;
        report->has_settled = !settle_drives(scene, rows, row_count, u) && result.has_settled;
        if (round + 1 >= plan->rounds_least && report->has_settled) break;
    }
    if (status == TULLE_OK && row_count > 0) {
        /* after a solve that ended early another one follows */
        if (!report->is_early) give_missed_friction(scene, list, solve.sums, u);
        for (size_t i = 0; i < row_count; i++) rows[i].solve.is_in_matrix = false;
        /* mends what the tolerance of the solve left; larger changes would give springs energy */
        if (report->violation <= LEAST_VIOLATION)
            status = project_driven_impulses(scene, rows, row_count, u);
    }
    for (size_t i = 0; i < row_count; i++) {
        report->stick_count += rows[i].solve.state == ROW_STICKS;
        report->slip_count += rows[i].solve.state == ROW_SLIDES;
        report->hard_count += rows[i].solve.is_hard;
    }
    arena_release(scratch, mark);
    return status;
}
