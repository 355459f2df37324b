/* math/single_solve.c - see single_solve.h.
 *
 * A pass computes the residual r = b - A x in double precision. It solves A d = r by conjugate
 * gradients with matrix, preconditioner and vectors in single precision, and adds d to x. A pass
 * lowers the residual by at most five powers of ten, so one or two are enough.
 *
 * Based on: Golub, Van Loan, Matrix computations, 3.5.3 (iterative refinement); Hestenes, Stiefel,
 * 1952.
 *
 * A dot is summed over chunks of a fixed number of vertices. The sums of the chunks are added in
 * order and in double precision, so the number of threads changes no bit. */
#include "math/single_solve.h"

#include "base/parallel.h"
#include "math/vec3.h"

#include <math.h>
#include <string.h>

/* Vertices in a chunk. Each dot is made of sums over one chunk. */
enum { VERTICES_PER_CHUNK = 512 };
/* A second pass is rare. A matrix that needs more is beyond single precision. */
enum { MOST_PASSES = 4 };
/* A pass ends at this share of its first residual: single precision cannot gain more. */
static const double PASS_DEPTH = 1e-5;
/* A pass aims this much below the target, so that rounding does not call for another. */
static const double PASS_AIM = 0.9;
/* A pass that leaves more than this part of the residual is the last. */
static const double PASS_LEAST = 0.5;

/* ---- terms outside the pattern ---- */

/* What a term gives one of its vertices. */
typedef struct apart_share {
    uint32_t vertex, term;
    double weight;
} apart_share;

/* The terms apart and, by chunk of the vertices, their shares in the order of terms. Each sum has
 * one order, however many chunks are done at once: each term is pulled by itself, and a vertex adds
 * what it gets in the order of terms. */
typedef struct apart_terms {
    double *pulls;         /* 3 a term: its stiffness times the weighted sum of its vertices */
    double *curvatures;    /* of each term, once it is pulled: direction . term direction */
    uint32_t *share_begin; /* of each chunk */
    apart_share *shares;
} apart_terms;

/* Sorts the shares by chunk; those of one chunk keep the order of terms. False: no memory. */
static bool sort_apart_terms(const single_system *system, size_t chunk_count, arena *scratch,
                             apart_terms *apart) {
    const matrix_term *const *const terms = system->apart;
    size_t const count = system->apart_count;
    size_t share_count = 0;
    for (size_t t = 0; t < count; t++)
        for (size_t k = 0; k < 4; k++) share_count += terms[t]->vertices[k] != TULLE_NONE;
    *apart = (apart_terms){.pulls = ARENA_NEW(scratch, double, 3 * count),
                           .curvatures = ARENA_NEW(scratch, double, count),
                           .share_begin = ARENA_NEW_ZEROED(scratch, uint32_t, chunk_count + 1),
                           .shares = ARENA_NEW(scratch, apart_share, share_count)};
    if (!apart->pulls || !apart->curvatures || !apart->share_begin || !apart->shares) return false;
    uint32_t *const begin = apart->share_begin;
    for (size_t t = 0; t < count; t++)
        for (size_t k = 0; k < 4; k++) {
            uint32_t const vertex = terms[t]->vertices[k];
            if (vertex != TULLE_NONE) begin[vertex / VERTICES_PER_CHUNK + 1]++;
        }
    for (size_t chunk = 0; chunk < chunk_count; chunk++) begin[chunk + 1] += begin[chunk];
    for (size_t t = count; t-- > 0;)
        for (size_t k = 4; k-- > 0;) {
            uint32_t const vertex = terms[t]->vertices[k];
            if (vertex == TULLE_NONE) continue;
            apart->shares[--begin[vertex / VERTICES_PER_CHUNK + 1]] =
                (apart_share){vertex, (uint32_t)t, terms[t]->weights[k]};
        }
    /* Each entry has come down to the begin of the chunk before it. */
    for (size_t chunk = 0; chunk < chunk_count; chunk++) begin[chunk] = begin[chunk + 1];
    begin[chunk_count] = (uint32_t)share_count;
    return true;
}

/* ---- the solve ---- */

typedef struct single_solver {
    const conjugate_gradients_problem *problem;
    const single_system *system;
    const late_aggregates *late; /* null: none */
    apart_terms apart;
    single_vectors vectors;
    double *x;        /* in double precision */
    double *partials; /* one a chunk */
    size_t chunk_count;
    double scale;  /* of the residual in single precision */
    double norm;   /* of the residual in double precision */
    double target; /* norm at which it ends now */
    float step;    /* alpha or beta of the loop */
    int iterations;
    arena *scratch;
    bool has_memory;
} single_solver;

/* Runs a loop over all vertices; the sum of its partials. */
static double run_loop(single_solver *work, parallel_body body) {
    parallel_for(work->problem->vertex_count, VERTICES_PER_CHUNK, work->problem->threads, body,
                 work);
    return parallel_sum(work->partials, work->chunk_count);
}

/* The same without vertices that are idle, where the loop would add nothing. */
static double run_busy_loop(single_solver *work, parallel_body body) {
    memset(work->partials, 0, work->chunk_count * sizeof *work->partials);
    parallel_for_busy(work->problem->is_idle, work->problem->vertex_count, VERTICES_PER_CHUNK,
                      work->problem->threads, body, work);
    return parallel_sum(work->partials, work->chunk_count);
}

static void copy_inverse(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    const single_solver *const work = context;
    const single_vectors *const to = &work->vectors;
    for (size_t v = begin; v < end; v++)
        for (size_t i = 0; i < BLOCK_NUMBERS; i++)
            to->inverse[v * to->inverse_step + i * to->number_step] =
                (float)work->problem->inverse[BLOCK_NUMBERS * v + i];
}

/* Residual, preconditioned residual and direction of a pass, of norm one; x = 0. */
static void begin_pass(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)worker;
    single_solver *const work = context;
    single_vectors *const to = &work->vectors;
    double sum = 0.0;
    for (size_t v = begin; v < end; v++) {
        vec3 const r = vec3_scale(vec3_load(work->problem->residual, v), work->scale);
        vec3 const z = block_multiply(work->problem->inverse + BLOCK_NUMBERS * v, r);
        double const rs[3] = {r.x, r.y, r.z}, zs[3] = {z.x, z.y, z.z};
        for (size_t i = 0; i < 3; i++) {
            size_t const at = v * to->vertex_step + i * to->number_step;
            to->residual[at] = (float)rs[i];
            to->preconditioned[at] = to->direction[at] = (float)zs[i];
            to->x[at] = 0.0F;
        }
        sum += vec3_dot(r, z);
    }
    work->partials[chunk] = sum;
}

static void end_pass(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    single_solver *const work = context;
    const single_vectors *const from = &work->vectors;
    for (size_t v = begin; v < end; v++)
        for (size_t i = 0; i < 3; i++)
            work->x[3 * v + i] +=
                (double)from->x[v * from->vertex_step + i * from->number_step] / work->scale;
}

/* The product with the terms in the pattern. The terms outside it are pulled here, each chunk its
 * part of them; `advance` adds them. */
static void multiply(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)worker;
    single_solver *const work = context;
    const single_vectors *const from = &work->vectors;
    work->partials[chunk] =
        are_idle(work->problem->is_idle, begin, end)
            ? 0.0
            : (double)single_system_multiply(work->system, &work->vectors, begin, end);
    size_t const count = work->system->apart_count;
    for (size_t t = count * chunk / work->chunk_count; t < count * (chunk + 1) / work->chunk_count;
         t++) {
        const matrix_term *const term = work->system->apart[t];
        double way[3] = {0.0, 0.0, 0.0};
        for (size_t k = 0; k < 4; k++)
            for (size_t i = 0; i < 3 && term->vertices[k] != TULLE_NONE; i++)
                way[i] +=
                    term->weights[k] *
                    (double)from
                        ->direction[term->vertices[k] * from->vertex_step + i * from->number_step];
        vec3 const pull = mat3_multiply_vec3(&term->stiffness, vec3_load(way, 0));
        vec3_store(work->apart.pulls, t, pull);
        work->apart.curvatures[t] = vec3_dot(vec3_load(way, 0), pull);
    }
}

/* Lets outer unknowns follow; what that takes from the curvature. */
static double yield_outer(const single_solver *work) {
    const outer_unknowns *const outer = work->system->outer;
    return outer ? outer->yield(outer->context, work->apart.pulls) : 0.0;
}

/* Adds the pulls to the product of the chunk's vertices; then goes alpha along the direction. */
static void advance(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)worker;
    single_solver *const work = context;
    const apart_terms *const apart = &work->apart;
    const single_vectors *const to = &work->vectors;
    for (uint32_t s = apart->share_begin[chunk]; s < apart->share_begin[chunk + 1]; s++) {
        const apart_share *const share = &apart->shares[s];
        for (size_t i = 0; i < 3; i++)
            to->product[share->vertex * to->vertex_step + i * to->number_step] +=
                (float)(share->weight * apart->pulls[3 * (size_t)share->term + i]);
    }
    work->partials[chunk] = (double)single_system_advance(work->system, to, work->step, begin, end);
}

/* p = z + beta p. The aggregates' part of z is not in `preconditioned` and is added here. */
static void turn_direction(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    const single_solver *const work = context;
    single_system_turn(work->system, &work->vectors, work->step, begin, end);
}

/* Iterations of a pass; norm2 is r . P^-1 r of the start. With another preconditioner directions
 * begin anew. */
static conjugate_gradients_end iterate(single_solver *work, double norm2) {
    const conjugate_gradients_problem *const problem = work->problem;
    const late_aggregates *const late = work->late;
    double descent = 0.0; /* z . r */
    for (bool is_first = true;; is_first = false) {
        if (late && !work->system->aggregates && work->iterations >= late->plain_iterations) {
            work->has_memory = late->add(late->context);
            if (!work->has_memory) return CONJUGATE_GRADIENTS_ITERATION_LIMIT;
            is_first = true;
        }
        /* The blocks of the diagonal give the norm of r squared, aggregates add the rest of z . r.
         */
        double const before = descent;
        descent = norm2;
        if (work->system->aggregates)
            descent += nested_aggregates_correct(work->system->aggregates, &work->vectors,
                                                 problem->threads);
        work->step = is_first ? 0.0F : (float)(descent / before);
        parallel_for_busy(problem->is_idle, problem->vertex_count, VERTICES_PER_CHUNK,
                          problem->threads, turn_direction, work);
        if (!isfinite(norm2) || !isfinite(descent)) return CONJUGATE_GRADIENTS_NOT_FINITE;
        if (work->iterations >= problem->limit || stop_is_wanted(problem->stop, 0))
            return CONJUGATE_GRADIENTS_ITERATION_LIMIT;
        double curvature = run_loop(work, multiply);
        curvature += parallel_sum(work->apart.curvatures, work->system->apart_count);
        curvature -= yield_outer(work);
        if (++work->iterations == problem->patience) work->target = problem->late_target;
        if (!isfinite(curvature)) return CONJUGATE_GRADIENTS_NOT_FINITE;
        if (!(curvature > 0.0 && descent > 0.0)) return CONJUGATE_GRADIENTS_NOT_POSITIVE;
        work->step = (float)(descent / curvature);
        norm2 = run_busy_loop(work, advance);
        if (sqrt(norm2) <= fmax(PASS_AIM * work->target / work->norm, PASS_DEPTH))
            return CONJUGATE_GRADIENTS_CONVERGED;
    }
}

/* Makes the residual in double precision. */
static void leave(single_solver *work) {
    const outer_unknowns *const outer = work->system->outer;
    if (outer) outer->settle(outer->context, work->x);
    work->has_memory &=
        conjugate_gradients_leave(work->problem, work->x, work->scratch, &work->norm) == TULLE_OK;
}

static conjugate_gradients_end run_passes(single_solver *work) {
    conjugate_gradients_end end = CONJUGATE_GRADIENTS_CONVERGED;
    for (int pass = 0; pass < MOST_PASSES && work->has_memory; pass++) {
        if (!isfinite(work->norm)) return CONJUGATE_GRADIENTS_NOT_FINITE;
        if (work->norm <= work->target) return CONJUGATE_GRADIENTS_CONVERGED;
        if (end == CONJUGATE_GRADIENTS_ITERATION_LIMIT) return end;
        work->scale = 1.0 / work->norm;
        double const norm2 = run_loop(work, begin_pass);
        end = iterate(work, norm2);
        if (end == CONJUGATE_GRADIENTS_NOT_FINITE || end == CONJUGATE_GRADIENTS_NOT_POSITIVE)
            return end;
        run_loop(work, end_pass);
        double const before = work->norm;
        leave(work);
        if (work->norm > work->target && !(work->norm < PASS_LEAST * before) &&
            end == CONJUGATE_GRADIENTS_CONVERGED)
            return CONJUGATE_GRADIENTS_STALLED;
    }
    return work->norm <= work->target ? CONJUGATE_GRADIENTS_CONVERGED : CONJUGATE_GRADIENTS_STALLED;
}

static void prepare(single_solver *work) {
    const conjugate_gradients_problem *const problem = work->problem;
    size_t const count = problem->vertex_count;
    work->chunk_count = parallel_chunk_count(count, VERTICES_PER_CHUNK);
    work->partials = ARENA_NEW(work->scratch, double, work->chunk_count);
    work->target = problem->patience > 0 ? problem->target : problem->late_target;
    work->has_memory =
        work->partials && single_vectors_make(work->system, work->scratch, &work->vectors) &&
        sort_apart_terms(work->system, work->chunk_count, work->scratch, &work->apart) &&
        conjugate_gradients_measure(problem, problem->residual, work->scratch, &work->norm) ==
            TULLE_OK;
    if (work->has_memory)
        parallel_for(count, VERTICES_PER_CHUNK, problem->threads, copy_inverse, work);
}

tulle_status single_solve(const conjugate_gradients_problem *problem, const single_system *system,
                          const late_aggregates *late, double *x, arena *scratch,
                          conjugate_gradients_result *result) {
    arena_mark const mark = arena_get_mark(scratch);
    single_solver work = {
        .problem = problem, .system = system, .late = late, .x = x, .scratch = scratch};
    prepare(&work);
    if (work.has_memory) {
        conjugate_gradients_end const end = run_passes(&work);
        *result = (conjugate_gradients_result){end, work.iterations, work.norm};
    }
    arena_release(scratch, mark);
    return work.has_memory ? TULLE_OK : TULLE_ERROR_OUT_OF_MEMORY;
}
