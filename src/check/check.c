/* check/check.c - see tulle/check.h and check.h.
 *
 * All triangles of all bodies are numbered through, in the order of the bodies. Two trees are
 * built, over the cloth and over the obstacles. Each triangle asks for those of higher number whose
 * boxes meet its own; triangles of obstacles ask only the tree of the cloth. Boxes are exact, so
 * the pairs that come to the exact test include all that intersect.
 *
 * Threads work on chunks of a fixed number of triangles. The pairs of a chunk are those of its
 * triangles, so the chunks' sorted lists one after the other are sorted, however many threads there
 * are.
 */
#include "check/check.h"

#include "base/error.h"
#include "base/parallel.h"
#include "base/sort.h"
#include "check/triangle_pair.h"
#include "check/triangle_tree.h"

#include <math.h>
#include <stdatomic.h>
#include <string.h>

enum {
    CHUNK_SIZE = 64,   /* triangles; small enough to balance, large enough to hide the overhead */
    THREAD_LIMIT = 256 /* of the contract */
};
static const size_t PAIR_LIMIT = (size_t)1 << 26; /* pairs: 1 GiB of results */
/* pairs whose boxes overlap: minutes. Only triangles that lie in heaps have so many. */
static const size_t TEST_LIMIT = (size_t)1 << 31;
static const size_t TRIANGLE_LIMIT = INT32_MAX; /* triangle numbers are 32-bit */

enum { KIND_CLOTH, KIND_OBSTACLE };

typedef struct chunk_result {
    ARRAY(tulle_check_pair) pairs;
    size_t tested_pair_count, exact_count;
} chunk_result;

typedef struct judge {
    memory *heap;
    const tulle_check_body *bodies;
    size_t body_count, triangle_count, chunk_count;
    size_t *first_triangle; /* of each body, and the total */
    uint32_t *body_of;      /* for each triangle number */
    uint8_t *kinds;         /* for each triangle number */
    check_box *boxes;       /* for each triangle number */
    triangle_tree trees[2]; /* by kind */
    chunk_result *chunks;
    size_t pair_limit, test_limit;
    atomic_size_t pair_count, test_count;
    atomic_int status;      /* the first failure of a worker */
    atomic_flag heap_guard; /* one worker at a time allocates */
} judge;

static tulle_status validate(const tulle_check_body *bodies, size_t body_count, int threads,
                             tulle_error *error) {
    if (threads < 0 || threads > THREAD_LIMIT)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "%d threads asked for; give 1 to %d, or 0 for one per processor", threads,
                         (int)THREAD_LIMIT);
    if (body_count > 0 && !bodies)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "the array of bodies is null");
    size_t total = 0;
    for (size_t body = 0; body < body_count; body++) {
        const tulle_mesh_view *const mesh = &bodies[body].mesh;
        if (mesh->vertex_count > TRIANGLE_LIMIT || mesh->triangle_count > TRIANGLE_LIMIT - total)
            return error_set(error, TULLE_ERROR_LIMIT,
                             "more than %zu vertices in a body or triangles in all",
                             TRIANGLE_LIMIT);
        total += mesh->triangle_count;
        if ((mesh->vertex_count > 0 && !mesh->positions) ||
            (mesh->triangle_count > 0 && !mesh->triangles))
            return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                             "body %zu has a null array; give positions and triangles", body);
        for (size_t i = 0; i < 3 * mesh->vertex_count; i++)
            if (!isfinite(mesh->positions[i]))
                return error_set(error, TULLE_ERROR_INVALID_MESH,
                                 "body %zu: coordinate %c of vertex %zu is not finite; all "
                                 "coordinates must be finite numbers",
                                 body, "xyz"[i % 3], i / 3);
        for (size_t i = 0; i < 3 * mesh->triangle_count; i++)
            if (mesh->triangles[i] >= mesh->vertex_count)
                return error_set(error, TULLE_ERROR_INVALID_MESH,
                                 "body %zu: triangle %zu uses vertex %u, but there are only %zu "
                                 "vertices, numbered from 0",
                                 body, i / 3, (unsigned)mesh->triangles[i], mesh->vertex_count);
    }
    return TULLE_OK;
}

static check_triangle get_triangle(const judge *self, uint32_t number) {
    uint32_t const body = self->body_of[number];
    const tulle_mesh_view *const mesh = &self->bodies[body].mesh;
    const uint32_t *const vertices = mesh->triangles + 3 * (number - self->first_triangle[body]);
    check_triangle triangle;
    for (int i = 0; i < 3; i++) {
        triangle.vertices[i] = vertices[i];
        triangle.corners[i] = mesh->positions + 3 * (size_t)vertices[i];
    }
    return triangle;
}

/* False when memory is short; judge_close releases what there is either way. */
static bool judge_open(judge *self) {
    size_t const count = self->triangle_count;
    self->first_triangle =
        memory_allocate(self->heap, self->body_count * sizeof *self->first_triangle);
    self->body_of = memory_allocate(self->heap, count * sizeof *self->body_of);
    self->kinds = memory_allocate(self->heap, count * sizeof *self->kinds);
    self->boxes = memory_allocate(self->heap, count * sizeof *self->boxes);
    self->chunks = memory_allocate_zeroed(self->heap, self->chunk_count, sizeof *self->chunks);
    if (!self->first_triangle || !self->body_of || !self->kinds || !self->boxes || !self->chunks)
        return false;

    /* Number the triangles of all bodies through, and box them. */
    size_t number = 0;
    for (size_t body = 0; body < self->body_count; body++) {
        self->first_triangle[body] = number;
        for (size_t i = 0; i < self->bodies[body].mesh.triangle_count; i++, number++) {
            self->body_of[number] = (uint32_t)body;
            self->kinds[number] = self->bodies[body].is_obstacle ? KIND_OBSTACLE : KIND_CLOTH;
            check_triangle const triangle = get_triangle(self, (uint32_t)number);
            const double *const *const corners = triangle.corners;
            check_box *const box = &self->boxes[number];
            for (int axis = 0; axis < 3; axis++) {
                double const a = corners[0][axis], b = corners[1][axis], c = corners[2][axis];
                box->low[axis] = a < b ? (a < c ? a : c) : (b < c ? b : c);
                box->high[axis] = a > b ? (a > c ? a : c) : (b > c ? b : c);
            }
        }
    }
    for (uint8_t kind = KIND_CLOTH; kind <= KIND_OBSTACLE; kind++)
        if (!triangle_tree_build(self->heap, self->boxes, self->kinds, kind, count,
                                 &self->trees[kind]))
            return false;
    return true;
}

static void judge_close(judge *self) {
    size_t const count = self->triangle_count;
    for (size_t i = 0; self->chunks && i < self->chunk_count; i++)
        ARRAY_FREE(self->heap, &self->chunks[i].pairs);
    memory_release(self->heap, self->chunks, self->chunk_count * sizeof *self->chunks);
    for (int kind = KIND_CLOTH; kind <= KIND_OBSTACLE; kind++)
        triangle_tree_destroy(self->heap, &self->trees[kind]);
    memory_release(self->heap, self->boxes, count * sizeof *self->boxes);
    memory_release(self->heap, self->kinds, count * sizeof *self->kinds);
    memory_release(self->heap, self->body_of, count * sizeof *self->body_of);
    memory_release(self->heap, self->first_triangle,
                   self->body_count * sizeof *self->first_triangle);
}

/* The first failure stops all workers. */
static void stop_workers(judge *self, int failure) {
    int expected = TULLE_OK;
    atomic_compare_exchange_strong(&self->status, &expected, failure);
}

static void append_pair(judge *self, chunk_result *chunk, uint32_t a, uint32_t b) {
    if (chunk->pairs.count == chunk->pairs.capacity) {
        while (atomic_flag_test_and_set(&self->heap_guard)) continue;
        bool const has_room = ARRAY_RESERVE(self->heap, &chunk->pairs, 1);
        atomic_flag_clear(&self->heap_guard);
        if (!has_room) {
            stop_workers(self, TULLE_ERROR_OUT_OF_MEMORY);
            return;
        }
    }
    uint32_t const body_a = self->body_of[a], body_b = self->body_of[b];
    chunk->pairs.data[chunk->pairs.count++] =
        (tulle_check_pair){body_a, (uint32_t)(a - self->first_triangle[body_a]), body_b,
                           (uint32_t)(b - self->first_triangle[body_b])};
}

/* Tests a triangle against those of higher number in a tree whose boxes meet its own. */
static void query_tree(judge *self, chunk_result *chunk, uint32_t number,
                       const triangle_tree *tree) {
    check_triangle const triangle = get_triangle(self, number);
    const check_box *const box = &self->boxes[number];
    uint32_t stack[TREE_DEPTH_LIMIT];
    int depth = 0;
    size_t const tests_before = chunk->tested_pair_count;
    if (tree->node_count > 0) stack[depth++] = 0;
    while (depth > 0 && atomic_load_explicit(&self->status, memory_order_relaxed) == TULLE_OK) {
        uint32_t const index = stack[--depth];
        const tree_node *const node = &tree->nodes[index];
        if (node->highest_item <= number || !check_boxes_meet(box, &node->box)) continue;
        if (node->leaf_count == 0) {
            stack[depth++] = node->right;
            stack[depth++] = index + 1;
            continue;
        }
        size_t const count_before = chunk->pairs.count;
        for (uint32_t i = 0; i < node->leaf_count; i++) {
            uint32_t const other = tree->items[node->right + i];
            if (other <= number || !check_boxes_meet(box, &self->boxes[other])) continue;
            check_triangle const candidate = get_triangle(self, other);
            bool const is_one_body = self->body_of[number] == self->body_of[other];
            chunk->tested_pair_count++;
            if (triangles_intersect(&triangle, &candidate, is_one_body, &chunk->exact_count))
                append_pair(self, chunk, number, other);
        }
        size_t const found = chunk->pairs.count - count_before;
        if (found > 0 && atomic_fetch_add(&self->pair_count, found) + found > self->pair_limit)
            stop_workers(self, TULLE_ERROR_LIMIT);
    }
    size_t const tested = chunk->tested_pair_count - tests_before;
    if (atomic_fetch_add(&self->test_count, tested) + tested > self->test_limit)
        stop_workers(self, TULLE_ERROR_LIMIT);
}

/* Pairs of one triangle, by the other one. */
static int compare_pairs(const void *one, const void *two) {
    const tulle_check_pair *const a = one, *const b = two;
    if (a->body_b != b->body_b) return a->body_b < b->body_b ? -1 : 1;
    return (a->triangle_b > b->triangle_b) - (a->triangle_b < b->triangle_b);
}

static void judge_chunk(void *context, size_t begin, size_t end, size_t chunk_index, int worker) {
    (void)worker;
    judge *const self = context;
    chunk_result *const chunk = &self->chunks[chunk_index];
    for (size_t number = begin; number < end; number++) {
        query_tree(self, chunk, (uint32_t)number, &self->trees[KIND_CLOTH]);
        if (self->kinds[number] == KIND_CLOTH)
            query_tree(self, chunk, (uint32_t)number, &self->trees[KIND_OBSTACLE]);
    }
}

/* Sorts the pairs of each triangle of a chunk. Only once all pairs are found: sorting is most of
 * the work where triangles have very many pairs, and is lost where these go over the limit. */
static void sort_chunk(void *context, size_t begin, size_t end, size_t chunk_index, int worker) {
    (void)begin, (void)end, (void)worker;
    const judge *const self = context;
    tulle_check_pair *const pairs = self->chunks[chunk_index].pairs.data;
    size_t const count = self->chunks[chunk_index].pairs.count;
    for (size_t first = 0, next = 0; first < count; first = next) {
        while (next < count && pairs[next].body_a == pairs[first].body_a &&
               pairs[next].triangle_a == pairs[first].triangle_a)
            next++;
        size_t place = first + 1;
        while (place < next && compare_pairs(&pairs[place - 1], &pairs[place]) < 0) place++;
        if (place < next) sort_in_place(pairs + first, next - first, sizeof *pairs, compare_pairs);
    }
}

tulle_status check_intersections(const check_settings *settings, const tulle_check_body *bodies,
                                 size_t body_count, tulle_check_result *result,
                                 tulle_error *error) {
    if (!result)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "the result pointer is null");
    *result = (tulle_check_result){0};
    tulle_status status = validate(bodies, body_count, settings->threads, error);
    if (status != TULLE_OK) return status;

    judge self = {.heap = settings->heap,
                  .bodies = bodies,
                  .body_count = body_count,
                  .pair_limit = settings->pair_limit,
                  .test_limit = settings->test_limit,
                  .heap_guard = ATOMIC_FLAG_INIT};
    for (size_t i = 0; i < body_count; i++) self.triangle_count += bodies[i].mesh.triangle_count;
    self.chunk_count = parallel_chunk_count(self.triangle_count, CHUNK_SIZE);
    atomic_init(&self.pair_count, 0);
    atomic_init(&self.test_count, 0);
    atomic_init(&self.status, TULLE_OK);
    status = TULLE_ERROR_OUT_OF_MEMORY;
    if (judge_open(&self)) {
        int const threads = parallel_resolve_threads(settings->threads);
        parallel_for(self.triangle_count, CHUNK_SIZE, threads, judge_chunk, &self);
        status = (tulle_status)atomic_load(&self.status);
        if (status == TULLE_OK)
            parallel_for(self.triangle_count, CHUNK_SIZE, threads, sort_chunk, &self);
    }
    if (status == TULLE_OK) { /* the chunks' lists one after the other */
        tulle_check_result gathered = {0};
        for (size_t i = 0; i < self.chunk_count; i++) {
            gathered.pair_count += self.chunks[i].pairs.count;
            gathered.tested_pair_count += self.chunks[i].tested_pair_count;
            gathered.exact_count += self.chunks[i].exact_count;
        }
        size_t const bytes = gathered.pair_count * sizeof *gathered.pairs;
        if (bytes > 0) gathered.pairs = memory_allocate(self.heap, bytes);
        if (bytes > 0 && !gathered.pairs) status = TULLE_ERROR_OUT_OF_MEMORY;
        for (size_t i = 0, next = 0; gathered.pairs && i < self.chunk_count; i++) {
            size_t const count = self.chunks[i].pairs.count;
            if (count > 0)
                memcpy(gathered.pairs + next, self.chunks[i].pairs.data,
                       count * sizeof *gathered.pairs);
            next += count;
        }
        if (status == TULLE_OK) *result = gathered;
    }
    judge_close(&self);
    bool const has_many_pairs = atomic_load(&self.pair_count) > settings->pair_limit;
    if (status == TULLE_ERROR_LIMIT)
        return error_set(error, status,
                         has_many_pairs
                             ? "more than %zu pairs of triangles intersect; judge smaller parts"
                             : "more than %zu pairs of triangles lie in each other's boxes, as "
                               "where many copies or triangles without area are in one place; "
                               "remove these, or judge smaller parts",
                         has_many_pairs ? settings->pair_limit : settings->test_limit);
    if (status != TULLE_OK)
        return error_set(error, status, "no memory to judge %zu triangles", self.triangle_count);
    return TULLE_OK;
}

tulle_status tulle_check_intersections(const tulle_check_body *bodies, size_t body_count,
                                       int threads, tulle_check_result *result,
                                       tulle_error *error) {
    memory heap = memory_default();
    check_settings const settings = {&heap, threads, PAIR_LIMIT, TEST_LIMIT};
    return check_intersections(&settings, bodies, body_count, result, error);
}

void tulle_check_result_destroy(tulle_check_result *result) {
    if (!result) return;
    memory heap = memory_default();
    memory_release(&heap, result->pairs, result->pair_count * sizeof *result->pairs);
    *result = (tulle_check_result){0};
}

int tulle_check_triangle_pair(const double *positions, const uint32_t first[3],
                              const uint32_t second[3], int is_one_body) {
    check_triangle triangles[2];
    if (!positions || !first || !second) return 1;
    for (int k = 0; k < 6; k++) {
        uint32_t const vertex = k < 3 ? first[k] : second[k - 3];
        const double *const corner = positions + 3 * (size_t)vertex;
        if (!isfinite(corner[0]) || !isfinite(corner[1]) || !isfinite(corner[2])) return 1;
        triangles[k / 3].vertices[k % 3] = vertex;
        triangles[k / 3].corners[k % 3] = corner;
    }
    size_t exact_count = 0;
    return triangles_intersect(&triangles[0], &triangles[1], is_one_body != 0, &exact_count);
}
