/* contact/paper/paper_response.c - the table of the paper's response: stages 7 and 8 by the paper's
 * own rules. The safe commit guards the result.
 *
 * Before the solve, every vertex with an old contact: F is the sum of its forces at the start of
 * the step. If F lies inside the motion space Z, nothing changes. Else, with F_T = F . Z and
 * F_N = F - F_T:
 *      sticks, |F_T| <= mu_s |F_N|:       force 0
 *      sticks otherwise:                  starts with F_T - mu_d |F_N| F_T / |F_T|
 *      slides, v in Z, |F_T| > mu_d |F_N|:  F_T - mu_d |F_N| F_T / |F_T|
 *      slides otherwise, v_T = v . Z:     sticks when |F_T| <= mu_d |F_N| and friction stops v_T
 *                                         within the step, else F_T - mu_d |F_N| v_T / |v_T|.
 * What this takes from a vertex, or adds to it, goes to the right-hand side of the solve as an
 * impulse. After the solve, v -> v . Z. A vertex with a new contact gets
 *      v_T - mu_d |v_N| v_T / |v_T| - k_c v_N,   or -k_c v_N where |v_T| < mu_d |v_N|,
 * and keeps of v_N the part until the time at which the contact distance is reached.
 *
 * Everything is per vertex: what a vertex loses no other gains, and a load is not handed on.
 *
 * Based on: Wong, Baciu, Dynamic interaction between deformable surfaces and nonsmooth objects,
 * 2005, sections 4, 5 and 5.2. Departures: with polyhedral spaces forces and velocities are seen
 * from what is touched, and F is measured by the velocity v0 + h F / m that it leads to. A
 * sliding vertex with v in Z and |F_T| <= mu_d |F_N|, which the paper leaves open, is treated as if
 * v were not in Z. A vertex in contact has the law of the row that it presses most. */
#include "contact/response.h"

#include "base/parallel.h"
#include "contact/pairs/pair_rules.h"
#include "contact/paper/vertex_spaces.h"
#include "contact/solve/project_impulses.h"

#include <string.h>

enum { VERTEX_CHUNK = 128 };
/* A row is touched if its gap exceeds the contact distance by less than this part of it. */
static const double TOUCHING_PART = 1e-3;

typedef struct paper_work {
    const contact_scene *scene;
    const motion_system *system;
    const solve_plan *plan;
    row_list *list;
    double *u;
    solve_report *report;
    vertex_spaces spaces;
    size_t first_new; /* rows from here on are new whatever they say */
    double *seen;     /* [m/s] velocities that a pass reads while it writes u */
    double *force;    /* [N s] h F of each vertex */
    double *impulses; /* [N s] impulse of contact on each vertex */
    uint8_t *is_held; /* for the solve */
} paper_work;

static bool allocate_work(paper_work *work) {
    arena *const scratch = work->scene->scratch;
    size_t const cloth_count = work->scene->cloth_vertex_count;
    work->seen = ARENA_NEW(scratch, double, 3 * work->scene->vertex_count);
    work->force = ARENA_NEW_ZEROED(scratch, double, 3 * cloth_count);
    work->impulses = ARENA_NEW_ZEROED(scratch, double, 3 * cloth_count);
    work->is_held = ARENA_NEW_ZEROED(scratch, uint8_t, cloth_count);
    return work->seen && work->force && work->impulses && work->is_held;
}

/* ---- before the solve ---- */

/* Old contacts: rows that continue a contact, and rows of a vertex that was in contact. */
static bool is_old_contact(const void *context, uint32_t vertex, const contact_row *row) {
    const paper_work *const work = context;
    if (row->law.is_old) return true;
    const contact_law *const law = get_contact_law(work->scene, row->frame.vertices);
    double const excess = -row->law.bias * work->scene->time_step;
    return work->scene->paper->before[vertex] != PARTICLE_FREE &&
           excess <= TOUCHING_PART * law->contact_distance;
}

/* Force and velocity of a vertex as the analysis sees them, all in m/s: a force is the change of
 * velocity that it makes within the step. */
typedef struct contact_motion {
    vec3 normal_force, tangential_force, velocity;
    bool is_in_space; /* v lies in Z */
} contact_motion;

/* |a| less `size`, along the direction of `against`. */
static vec3 reduce(vec3 a, double size, vec3 against) {
    return vec3_add_scaled(a, vec3_normalize(against), -size);
}

/* Returns the change of velocity that is left of F, and sets the state that follows. */
static vec3 analyse_friction(const contact_motion *motion, const contact_law *law, uint8_t *state) {
    vec3 const zero = {0.0, 0.0, 0.0}, tangential = motion->tangential_force;
    double const normal_size = vec3_norm(motion->normal_force), size = vec3_norm(tangential);
    double const limit = law->dynamic_friction * normal_size;
    double const static_limit = law->static_friction * normal_size;
    if (*state == PARTICLE_STICKS) {
        if (size <= static_limit) return zero;
        *state = PARTICLE_SLIDES;
        return reduce(tangential, limit, tangential);
    }
    if (motion->is_in_space && size > limit) return reduce(tangential, limit, tangential);
    double const speed = vec3_norm(motion->velocity);
    if (size <= limit && limit - size >= speed) {
        *state = PARTICLE_STICKS;
        return zero;
    }
    return reduce(tangential, limit, speed > 0.0 ? motion->velocity : tangential);
}

/* What contact changes of the force F of each vertex becomes an impulse for the right-hand side. */
static void analyse_chunk(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    paper_work *const work = context;
    const contact_scene *const scene = work->scene;
    space_choice const choice = {.filter = is_old_contact, .context = work};
    for (size_t i = begin; i < end; i++) {
        uint32_t const vertex = (uint32_t)i;
        uint8_t *const state = &scene->paper->after[vertex];
        vertex_space const at = make_vertex_space(&work->spaces, vertex, choice);
        const motion_space *const space = &at.space;
        *state = PARTICLE_FREE;
        if (space->count == 0) continue;
        bool const stuck = scene->paper->before[vertex] == PARTICLE_STICKS;
        *state = stuck ? PARTICLE_STICKS : PARTICLE_SLIDES;

        /* F and v as seen from the frame; polyhedral: F as the velocity v0 + h F / m */
        bool const is_relative = space->kind == TULLE_MOTION_SPACE_POLYHEDRAL;
        double const inverse_mass = scene->inverse_mass[vertex];
        vec3 const v0 = vec3_sub(vec3_load(work->u, vertex), at.reference);
        vec3 const force = vec3_scale(vec3_load(work->force, vertex), inverse_mass);
        vec3 const whole = is_relative ? vec3_add(v0, force) : force;
        contact_motion motion = {.is_in_space = motion_space_contains(space, v0)};
        if (!stuck) motion.velocity = motion.is_in_space ? v0 : motion_space_project(space, v0);
        vec3 const kept = motion_space_project(space, whole);
        motion.normal_force = vec3_sub(whole, kept);
        motion.tangential_force = is_relative ? vec3_sub(kept, motion.velocity) : kept;
        if (motion_space_contains(space, whole)) {
            *state = PARTICLE_SLIDES;
            continue;
        }
        const contact_row *const row = find_pressed_row(&work->spaces, vertex, &at, choice, whole);
        if (!row) continue;
        const contact_law *const law = get_contact_law(scene, row->frame.vertices);
        vec3 const left = analyse_friction(&motion, law, state);
        vec3 const last =
            *state == PARTICLE_STICKS ? vec3_make(0.0, 0.0, 0.0) : vec3_add(motion.velocity, left);
        vec3 const change = vec3_sub(last, vec3_add(v0, force));
        vec3 const given = vec3_load(work->impulses, vertex);
        vec3_store(work->impulses, vertex, vec3_add(given, vec3_scale(change, 1.0 / inverse_mass)));
    }
}

/* ---- the solve ---- */

static tulle_status solve_system(paper_work *work) {
    const contact_scene *const scene = work->scene;
    const motion_system *const system = work->system;
    size_t const count = scene->cloth_vertex_count;
    double *const right_hand_side = ARENA_NEW(scene->scratch, double, 3 * count);
    double *const diagonal = ARENA_NEW(scene->scratch, double, 9 * count);
    double *const inverse = ARENA_NEW(scene->scratch, double, BLOCK_NUMBERS *count);
    double *const residual = ARENA_NEW(scene->scratch, double, 3 * count);
    if (!right_hand_side || !diagonal || !inverse || !residual) return TULLE_ERROR_OUT_OF_MEMORY;
    block_matrix_get_diagonal(system->matrix, diagonal, scene->threads);
    for (size_t i = 0; i < 3 * count; i++)
        right_hand_side[i] = system->right_hand_side[i] + work->impulses[i];
    for (size_t i = 0; i < count; i++) {
        if (!(scene->inverse_mass[i] > 0.0)) work->is_held[i] = 1;
    }
    block_matrix_operator matrix = {system->matrix, scene->threads};
    conjugate_gradients_problem problem = {.vertex_count = count,
                                           .apply = block_matrix_apply,
                                           .apply_context = &matrix,
                                           .right_hand_side = right_hand_side,
                                           .inverse = inverse,
                                           .limit = work->plan->iterations_most,
                                           .residual = residual,
                                           .threads = scene->threads,
                                           .stop = scene->stop};
    /* residuals are measured against the force impulse */
    double reference = 0.0, first = 0.0;
    preconditioner_source const source = {diagonal, work->is_held};
    conjugate_gradients_invert(source, count, scene->threads, inverse);
    tulle_status status =
        conjugate_gradients_measure(&problem, work->force, scene->scratch, &reference);
    if (status == TULLE_OK && !(reference > 0.0))
        status = conjugate_gradients_measure(&problem, right_hand_side, scene->scratch, &reference);
    if (status == TULLE_OK)
        status = conjugate_gradients_leave(&problem, work->u, scene->scratch, &first);
    if (!(reference > 0.0)) reference = first;
    problem.target = problem.late_target = work->plan->tolerance * reference;
    conjugate_gradients_result result;
    if (status == TULLE_OK)
        status = conjugate_gradients_solve(&problem, work->u, scene->scratch, &result);
    if (status != TULLE_OK) return status;
    if (stop_is_wanted(scene->stop, 0)) return TULLE_ERROR_INTERRUPTED;
    work->report->solve_count = 1;
    work->report->cg_iterations = (uint32_t)result.iterations;
    work->report->cg_residual = reference > 0.0 ? result.norm / reference : 0.0;
    work->report->has_converged = result.end == CONJUGATE_GRADIENTS_CONVERGED;
    return TULLE_OK;
}

/* ---- after the solve ---- */

/* Changes the velocity [m/s] of a vertex by the law of impact; false when it hits nothing. */
static bool collide_vertex(const paper_work *work, uint32_t vertex, double time, uint8_t *state,
                           vec3 *velocity) {
    space_choice const choice = {.is_closed = true};
    vertex_space const at = make_vertex_space(&work->spaces, vertex, choice);
    vec3 const before = vec3_sub(*velocity, at.reference);
    const contact_row *const row = find_pressed_row(&work->spaces, vertex, &at, choice, before);
    if (!row || motion_space_contains(&at.space, before)) return false;
    const contact_law *const law = get_contact_law(work->scene, row->frame.vertices);
    vec3 const tangential = motion_space_project(&at.space, before);
    vec3 const normal = vec3_sub(before, tangential);
    double const limit = law->dynamic_friction * vec3_norm(normal);
    vec3 end = vec3_scale(normal, law->restitution > 0.0 ? -law->restitution : time);
    *state = PARTICLE_STICKS;
    if (vec3_norm(tangential) >= limit) {
        *state = PARTICLE_SLIDES;
        end = vec3_add(end, reduce(tangential, limit, tangential));
    }
    *velocity = vec3_add(end, at.reference);
    return true;
}

/* Projects velocities on their motion spaces; applies the law of impact to vertices with new
 * contacts. Reads the velocities seen, and writes u. */
static void project_chunk(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    paper_work *const work = context;
    const vertex_spaces *const spaces = &work->spaces;
    for (size_t i = begin; i < end; i++) {
        uint32_t const vertex = (uint32_t)i;
        uint8_t *const state = &work->scene->paper->after[vertex];
        if (spaces->begin[vertex] == spaces->begin[vertex + 1]) continue;
        /* the part of the step until a new contact reaches its contact distance; 1: none does */
        double time = 1.0;
        for (uint32_t k = spaces->begin[vertex]; k < spaces->begin[vertex + 1]; k++) {
            size_t const index = spaces->entries[k] / 4;
            const contact_row *const row = &work->list->rows.data[index];
            if (index < work->first_new && is_old_contact(work, vertex, row)) continue;
            double const speed =
                vec3_dot(row->frame.normal, get_relative_velocity(row, work->seen));
            double const bias = fmin(row->law.bias, 0.0);
            if (speed < bias) time = fmin(time, bias / speed);
        }
        vec3 const before = vec3_load(work->seen, vertex);
        vec3 last = before;
        if (*state == PARTICLE_FREE) *state = PARTICLE_SLIDES;
        if (!(time < 1.0) || !collide_vertex(work, vertex, time, state, &last)) {
            vertex_space const at = make_vertex_space(spaces, vertex, (space_choice){0});
            vec3 const seen = vec3_sub(before, at.reference);
            last = vec3_add(motion_space_project(&at.space, seen), at.reference);
        }
        vec3_store(work->u, vertex, last);
        vec3 const impulse =
            vec3_scale(vec3_sub(last, before), 1.0 / work->scene->inverse_mass[vertex]);
        vec3_store(work->impulses, vertex, vec3_add(vec3_load(work->impulses, vertex), impulse));
    }
}

/* Projects all velocities. Then each row gets its share of the impulses on its vertices, for
 * reports and for what is stored. */
static tulle_status project_velocities(paper_work *work) {
    const contact_scene *const scene = work->scene;
    const vertex_spaces *const spaces = &work->spaces;
    memcpy(work->seen, work->u, 3 * scene->vertex_count * sizeof(double));
    if (!vertex_spaces_make(&work->spaces, scene, work->list, work->seen))
        return TULLE_ERROR_OUT_OF_MEMORY;
    parallel_for(scene->cloth_vertex_count, VERTEX_CHUNK, scene->threads, project_chunk, work);
    for (size_t i = 0; i < work->list->rows.count; i++) {
        contact_row *const row = &work->list->rows.data[i];
        vec3 sum = {0.0, 0.0, 0.0};
        bool sticks = false;
        for (int k = 0; k < 4; k++) {
            uint32_t const vertex = row->frame.vertices[k];
            double const weight = row->frame.weights[k];
            if (vertex >= scene->cloth_vertex_count) continue;
            uint32_t const rows = spaces->begin[vertex + 1] - spaces->begin[vertex];
            if (rows == 0) continue;
            double const side = weight >= 0.0 ? 1.0 : -1.0;
            sum = vec3_add_scaled(sum, vec3_load(work->impulses, vertex), side / rows);
            sticks |= scene->paper->after[vertex] == PARTICLE_STICKS && weight != 0.0;
        }
        row->solve.impulse = vec3_add(row->solve.impulse, sum);
        bool const is_loaded = vec3_norm2(row->solve.impulse) > 0.0;
        row->solve.state = !is_loaded ? ROW_OPEN : sticks ? ROW_STICKS : ROW_SLIDES;
    }
    return TULLE_OK;
}

/* In: u as for solve_motion. Out: u, the rows and scene->paper->after. Rows that are no contact by
 * the paper's rule are dropped; the impulses of the others are shares of those on their vertices.
 */
static tulle_status respond_by_paper(const contact_scene *scene, const motion_system *system,
                                     const solve_plan *plan, row_list *list, double *u,
                                     solve_report *report) {
    *report = (solve_report){.has_converged = true};
    arena_mark const mark = arena_get_mark(scene->scratch);
    paper_work work = {
        .scene = scene, .system = system, .plan = plan, .list = list, .u = u, .report = report};
    contact_row *const rows = list->rows.data;
    for (size_t i = 0; i < list->rows.count; i++) {
        rows[i].solve.impulse = vec3_make(0.0, 0.0, 0.0);
        rows[i].solve.is_hard = false;
    }
    bool has_memory = allocate_work(&work);
    if (has_memory) {
        /* h F, or the part of h that the integrator counts at once; and the velocities v0 + h F / m
         * that carry planes along */
        memcpy(work.seen, u, 3 * scene->vertex_count * sizeof(double));
        for (size_t i = 0; i < scene->cloth_vertex_count; i++) {
            vec3 const force = vec3_scale(vec3_load(system->forces, i), system->force_time);
            double const inverse_mass = scene->inverse_mass[i];
            vec3_store(work.force, i, force);
            if (inverse_mass > 0.0)
                vec3_store(work.seen, i, vec3_add_scaled(vec3_load(u, i), force, inverse_mass));
        }
        has_memory = vertex_spaces_make(&work.spaces, scene, list, work.seen);
    }
    tulle_status status = TULLE_ERROR_OUT_OF_MEMORY;
    if (has_memory) {
        parallel_for(scene->cloth_vertex_count, VERTEX_CHUNK, scene->threads, analyse_chunk, &work);
        status = solve_system(&work);
    }
    if (status == TULLE_OK) {
        /* a new pair that is apart and does not come nearer is no contact */
        size_t kept = 0;
        for (size_t i = 0; i < list->rows.count; i++) {
            double const speed = vec3_dot(rows[i].frame.normal, get_relative_velocity(&rows[i], u));
            const row_law *const law = &rows[i].law;
            if (law->is_old || law->bias >= 0.0 || speed < law->bias) rows[kept++] = rows[i];
        }
        list->rows.count = list->gathered_count = work.first_new = kept;
        status = project_velocities(&work);
    }
    for (size_t i = 0; i < list->rows.count && status == TULLE_OK; i++) {
        report->stick_count += rows[i].solve.state == ROW_STICKS;
        report->slip_count += rows[i].solve.state == ROW_SLIDES;
    }
    arena_release(scene->scratch, mark);
    return status;
}

static tulle_status answer_impacts(const contact_scene *scene, row_list *list, size_t first_new,
                                   double *u) {
    arena_mark const mark = arena_get_mark(scene->scratch);
    paper_work work = {.scene = scene, .list = list, .u = u, .first_new = first_new};
    tulle_status const status =
        allocate_work(&work) ? project_velocities(&work) : TULLE_ERROR_OUT_OF_MEMORY;
    arena_release(scene->scratch, mark);
    return status;
}

/* Vertices in contact end with u: it already lies in their motion spaces. */
static void mark_plain_ends(const contact_scene *scene, const row_list *list, uint8_t *is_plain) {
    for (size_t i = 0; i < list->rows.count; i++) {
        const contact_row *const row = &list->rows.data[i];
        if (vec3_norm2(row->solve.impulse) == 0.0) continue;
        for (int k = 0; k < 4; k++)
            if (row->frame.vertices[k] < scene->cloth_vertex_count)
                is_plain[row->frame.vertices[k]] = 1;
    }
}

/* u obeys the laws of impact already. */
static tulle_status end_with_mean(const contact_scene *scene, row_list *list, const double *u,
                                  double *v1, end_velocities *ends) {
    (void)scene, (void)list, (void)u, (void)v1, (void)ends;
    return TULLE_OK;
}

static void keep_particles(const contact_scene *scene, const double *x1, row_list *list) {
    (void)x1, (void)list;
    memcpy(scene->paper->before, scene->paper->after, scene->cloth_vertex_count);
}

const contact_response paper_response = {
    .solve_motion = respond_by_paper,
    .answer_impacts = answer_impacts,
    .mark_plain_ends = mark_plain_ends,
    .end_contacts = end_with_mean,
    .keep_contacts = keep_particles,
    .needs_forces = true,
    .has_linear_springs = true,
    .may_tear_cloth = true,
    .keeps_particles = true,
};
