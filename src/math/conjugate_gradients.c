/* math/conjugate_gradients.c - preconditioned conjugate gradients, see conjugate_gradients.h.
 *
 * Based on: Hestenes, Stiefel, Methods of conjugate gradients for solving linear systems, 1952;
 * fixed vertices by filtering as in Baraff, Witkin, Large steps in cloth simulation, 1998, section
 * 5. Departures: the filter is a mask, which makes the iteration plain conjugate gradients on the
 * free vertices; the residual is measured in the preconditioner's norm.
 *
 * A dot is summed over chunks of a fixed number of vertices, and the sums of the chunks are added
 * in order, so the number of threads changes no bit. */
#include "math/conjugate_gradients.h"

#include "base/parallel.h"
#include "math/advance_kernel.h"
#include "math/vec3.h"

#include <math.h>
#include <string.h>

/* Vertices in a chunk. Each dot is made of sums over one chunk. */
enum { VERTICES_PER_CHUNK = 512 };

typedef struct solver {
    const conjugate_gradients_problem *problem;
    double *x, *residual, *direction, *product, *preconditioned;
    const double *of; /* what a measure measures */
    double *partials; /* one a chunk */
    size_t chunk_count;
    double step; /* alpha or beta of the pass */
} solver;

/* Runs a pass over all vertices and returns the sum of its partials. */
static double run_pass(solver *work, parallel_body body) {
    parallel_for(work->problem->vertex_count, VERTICES_PER_CHUNK, work->problem->threads, body,
                 work);
    return parallel_sum(work->partials, work->chunk_count);
}

/* The same without vertices that are idle, where the pass would add nothing. */
static double run_busy_pass(solver *work, parallel_body body) {
    memset(work->partials, 0, work->chunk_count * sizeof *work->partials);
    parallel_for_busy(work->problem->is_idle, work->problem->vertex_count, VERTICES_PER_CHUNK,
                      work->problem->threads, body, work);
    return parallel_sum(work->partials, work->chunk_count);
}

void invert_block_of(preconditioner_source source, size_t vertex, double inverse[BLOCK_NUMBERS]) {
    for (int i = 0; i < BLOCK_NUMBERS; i++) inverse[i] = 0.0;
    if (source.is_fixed && source.is_fixed[vertex]) return;
    const double *const a = source.diagonal + 9 * vertex;
    double const c0 = a[4] * a[8] - a[5] * a[5];
    double const c1 = a[5] * a[2] - a[1] * a[8];
    double const c2 = a[1] * a[5] - a[4] * a[2];
    double const minor = a[0] * a[4] - a[1] * a[1];
    double const determinant = a[0] * c0 + a[1] * c1 + a[2] * c2;
    /* Leading minors; the margins keep the inverse of a nearly singular block finite. */
    double const margin = 1e-14 * fabs(a[0] * a[4] * a[8]);
    if (a[0] > 0.0 && minor > 0.0 && determinant > margin && isfinite(1.0 / determinant)) {
        double const s = 1.0 / determinant;
        double const c4 = a[0] * a[8] - a[2] * a[2];
        double const c5 = a[1] * a[2] - a[0] * a[5];
        double const adjugate[BLOCK_NUMBERS] = {c0, c1, c2, c4, c5, minor};
        for (int i = 0; i < BLOCK_NUMBERS; i++) inverse[i] = s * adjugate[i];
        return;
    }
    static const size_t diagonal_places[3] = {0, 3, 5};
    for (size_t i = 0; i < 3; i++) {
        double const reciprocal = 1.0 / a[4 * i];
        bool const is_usable = a[4 * i] > 0.0 && isfinite(reciprocal);
        inverse[diagonal_places[i]] = is_usable ? reciprocal : 1.0;
    }
}

typedef struct invert_task {
    preconditioner_source source;
    double *inverse;
} invert_task;

static void invert_chunk(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    const invert_task *const task = context;
    for (size_t vertex = begin; vertex < end; vertex++)
        invert_block_of(task->source, vertex, task->inverse + BLOCK_NUMBERS * vertex);
}

void conjugate_gradients_invert(preconditioner_source source, size_t count, int threads,
                                double *inverse) {
    invert_task task = {source, inverse};
    parallel_for(count, VERTICES_PER_CHUNK, threads, invert_chunk, &task);
}

/* Sums r . P^-1 r. */
static void measure_chunk(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)worker;
    solver *const work = context;
    double sum = 0.0;
    for (size_t vertex = begin; vertex < end; vertex++) {
        vec3 const r = vec3_load(work->of, vertex);
        sum += vec3_dot(r, block_multiply(work->problem->inverse + BLOCK_NUMBERS * vertex, r));
    }
    work->partials[chunk] = sum;
}

/* r = b - r; sums r . P^-1 r */
static void leave_chunk(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)worker;
    solver *const work = context;
    double sum = 0.0;
    for (size_t vertex = begin; vertex < end; vertex++) {
        vec3 const r = vec3_sub(vec3_load(work->problem->right_hand_side, vertex),
                                vec3_load(work->residual, vertex));
        vec3_store(work->residual, vertex, r);
        sum += vec3_dot(r, block_multiply(work->problem->inverse + BLOCK_NUMBERS * vertex, r));
    }
    work->partials[chunk] = sum;
}

/* z = P^-1 r, p = z; sums r . z */
static void begin_iteration(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)worker;
    solver *const work = context;
    double sum = 0.0;
    for (size_t vertex = begin; vertex < end; vertex++) {
        vec3 const r = vec3_load(work->residual, vertex);
        vec3 const z = block_multiply(work->problem->inverse + BLOCK_NUMBERS * vertex, r);
        vec3_store(work->preconditioned, vertex, z);
        vec3_store(work->direction, vertex, z);
        sum += vec3_dot(r, z);
    }
    work->partials[chunk] = sum;
}

/* Sums p . A p; p is zero at fixed vertices, which filters the product. */
static void measure_curvature(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)worker;
    solver *const work = context;
    work->partials[chunk] =
        TULLE_PICK_KERNEL(measure_along)(work->direction, work->product, begin, end);
}

/* x += alpha p, r -= alpha A p, z = P^-1 r; sums r . z. The inverse is zero at fixed vertices, so
 * their residual takes no part. */
static void advance(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)worker;
    solver *const work = context;
    advance_vectors const vectors = {work->x,       work->residual,       work->direction,
                                     work->product, work->preconditioned, work->problem->inverse};
    work->partials[chunk] = TULLE_PICK_KERNEL(advance_along)(&vectors, work->step, begin, end);
}

/* p = z + beta p */
static void turn_direction(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    solver *const work = context;
    TULLE_PICK_KERNEL(turn_along)(work->direction, work->preconditioned, work->step, begin, end);
}

static conjugate_gradients_result end_at(conjugate_gradients_result result,
                                         conjugate_gradients_end end) {
    result.end = end;
    return result;
}

/* rho is r . P^-1 r at the start; the result has that of the end. */
static conjugate_gradients_result iterate(solver *work, double rho) {
    const conjugate_gradients_problem *const problem = work->problem;
    conjugate_gradients_result result = {CONJUGATE_GRADIENTS_CONVERGED, 0, sqrt(rho)};
    double descent = rho; /* r . z */
    for (;;) {
        bool const is_late = result.iterations >= problem->patience;
        result.norm = sqrt(rho);
        if (!isfinite(rho)) return end_at(result, CONJUGATE_GRADIENTS_NOT_FINITE);
        if (result.norm <= (is_late ? problem->late_target : problem->target)) return result;
        if (result.iterations >= problem->limit || stop_is_wanted(problem->stop, 0))
            return end_at(result, CONJUGATE_GRADIENTS_ITERATION_LIMIT);
        problem->apply(problem->apply_context, work->direction, work->product);
        double const curvature = run_busy_pass(work, measure_curvature);
        if (!isfinite(curvature)) return end_at(result, CONJUGATE_GRADIENTS_NOT_FINITE);
        if (!(curvature > 0.0 && descent > 0.0))
            return end_at(result, CONJUGATE_GRADIENTS_NOT_POSITIVE);
        double const alpha = descent / curvature;
        if (!isfinite(alpha)) return end_at(result, CONJUGATE_GRADIENTS_NOT_FINITE);
        work->step = alpha;
        rho = run_busy_pass(work, advance);
        result.iterations++;
        double const before = descent;
        descent = rho;
        if (problem->correct && result.iterations >= problem->plain_iterations)
            descent +=
                problem->correct(problem->correct_context, work->residual, work->preconditioned);
        /* with another preconditioner directions begin anew */
        bool const begins = problem->correct && result.iterations == problem->plain_iterations;
        work->step = begins ? 0.0 : descent / before;
        parallel_for_busy(problem->is_idle, problem->vertex_count, VERTICES_PER_CHUNK,
                          problem->threads, turn_direction, work);
    }
}

tulle_status conjugate_gradients_measure(const conjugate_gradients_problem *problem,
                                         const double *r, arena *scratch, double *norm) {
    arena_mark const mark = arena_get_mark(scratch);
    solver work = {.problem = problem,
                   .of = r,
                   .chunk_count = parallel_chunk_count(problem->vertex_count, VERTICES_PER_CHUNK)};
    work.partials = ARENA_NEW(scratch, double, work.chunk_count);
    if (work.partials) *norm = sqrt(run_pass(&work, measure_chunk));
    arena_release(scratch, mark);
    return work.partials ? TULLE_OK : TULLE_ERROR_OUT_OF_MEMORY;
}

tulle_status conjugate_gradients_leave(const conjugate_gradients_problem *problem, const double *x,
                                       arena *scratch, double *norm) {
    arena_mark const mark = arena_get_mark(scratch);
    solver work = {.problem = problem,
                   .residual = problem->residual,
                   .chunk_count = parallel_chunk_count(problem->vertex_count, VERTICES_PER_CHUNK)};
    work.partials = ARENA_NEW(scratch, double, work.chunk_count);
    if (work.partials && x) problem->apply(problem->apply_context, x, problem->residual);
    if (work.partials) *norm = sqrt(run_pass(&work, leave_chunk));
    arena_release(scratch, mark);
    return work.partials ? TULLE_OK : TULLE_ERROR_OUT_OF_MEMORY;
}

tulle_status conjugate_gradients_solve(const conjugate_gradients_problem *problem, double *x,
                                       arena *scratch, conjugate_gradients_result *result) {
    arena_mark const mark = arena_get_mark(scratch);
    size_t const count = problem->vertex_count;
    size_t const chunk_count = parallel_chunk_count(count, VERTICES_PER_CHUNK);
    solver work = {.problem = problem,
                   .x = x,
                   .residual = problem->residual,
                   .direction = ARENA_NEW(scratch, double, 3 * count),
                   .product = ARENA_NEW(scratch, double, 3 * count),
                   .preconditioned = ARENA_NEW(scratch, double, 3 * count),
                   .partials = ARENA_NEW(scratch, double, chunk_count),
                   .chunk_count = chunk_count};
    bool const has_memory = work.direction && work.product && work.preconditioned && work.partials;
    if (has_memory) *result = iterate(&work, run_pass(&work, begin_iteration));
    arena_release(scratch, mark);
    return has_memory ? TULLE_OK : TULLE_ERROR_OUT_OF_MEMORY;
}
