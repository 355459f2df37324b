/* fuzz/targets/check.c - the judge beside all pairs in rational arithmetic: some triangles of one
 * to three bodies, corners shared at random. */
#include "support/rational_oracle.h"
#include "support/soup.h"

#include "tulle/check.h"

#include <math.h>
#include <string.h>

enum {
    BODIES_MAX = 3,
    VERTICES_MAX = 12, /* of a body */
    TRIANGLES_MAX = 8,
    PAIRS_MAX = BODIES_MAX * BODIES_MAX * TRIANGLES_MAX * TRIANGLES_MAX
};

typedef struct soup_body {
    double positions[3 * VERTICES_MAX];
    uint32_t triangles[3 * TRIANGLES_MAX];
    size_t vertex_count, triangle_count;
    int is_obstacle;
} soup_body;

static void take_body(fuzz_bytes *bytes, soup_places places, soup_body *body) {
    body->is_obstacle = (int)fuzz_take_below(bytes, 4) == 0;
    body->vertex_count = 1 + fuzz_take_below(bytes, VERTICES_MAX);
    body->triangle_count = fuzz_take_below(bytes, TRIANGLES_MAX + 1);
    for (size_t i = 0; i < 3 * body->triangle_count; i++)
        body->triangles[i] = fuzz_take_below(bytes, (uint32_t)body->vertex_count);
    soup_take_points(bytes, places, body->vertex_count, body->positions);
}

static check_triangle get_triangle(const soup_body *body, size_t triangle) {
    check_triangle of;
    for (size_t k = 0; k < 3; k++) {
        of.vertices[k] = body->triangles[3 * triangle + k];
        of.corners[k] = &body->positions[3 * (size_t)of.vertices[k]];
    }
    return of;
}

/* All pairs, in the order of a result. */
static size_t find_pairs(const soup_body *bodies, uint32_t count, tulle_check_pair *pairs) {
    size_t found = 0;
    for (uint32_t i = 0; i < count; i++)
        for (uint32_t t = 0; t < bodies[i].triangle_count; t++)
            for (uint32_t j = i; j < count; j++)
                for (uint32_t w = i == j ? t + 1 : 0; w < bodies[j].triangle_count; w++) {
                    if (bodies[i].is_obstacle && bodies[j].is_obstacle) continue;
                    check_triangle const a = get_triangle(&bodies[i], t);
                    check_triangle const b = get_triangle(&bodies[j], w);
                    bool const intersect = oracle_triangles_intersect(&a, &b, i == j);
                    FUZZ_CHECK(triangles_intersect(&a, &b, i == j, NULL) == intersect);
                    FUZZ_CHECK(triangles_intersect(&b, &a, i == j, NULL) == intersect);
                    if (i == j)
                        FUZZ_CHECK(tulle_check_triangle_pair(bodies[i].positions, a.vertices,
                                                             b.vertices, 1) == intersect);
                    if (intersect) pairs[found++] = (tulle_check_pair){i, t, j, w};
                }
    return found;
}

/* A coordinate that is not finite, or an index out of range, is refused. */
static void check_refusal(tulle_check_body *judged, size_t count, soup_body *bodies) {
    tulle_check_result result;
    tulle_error error = {0};
    bodies[0].positions[0] = (double)NAN;
    FUZZ_CHECK(tulle_check_intersections(judged, count, 1, &result, &error) ==
               TULLE_ERROR_INVALID_MESH);
    fuzz_check_error(TULLE_ERROR_INVALID_MESH, &error);
    FUZZ_CHECK(!result.pairs && result.pair_count == 0);
    bodies[0].positions[0] = 0.0;
    if (bodies[0].triangle_count == 0) return;
    bodies[0].triangles[0] = (uint32_t)bodies[0].vertex_count;
    FUZZ_CHECK(tulle_check_intersections(judged, count, 1, &result, &error) ==
               TULLE_ERROR_INVALID_MESH);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static soup_body bodies[BODIES_MAX];
    static tulle_check_pair pairs[PAIRS_MAX];
    tulle_check_body judged[BODIES_MAX];
    fuzz_bytes bytes = {data, size, 0};
    soup_pool_numbers();
    soup_places const places = (soup_places)fuzz_take_below(&bytes, SOUP_PLACES_COUNT);
    uint32_t const count = 1 + fuzz_take_below(&bytes, BODIES_MAX);
    for (uint32_t i = 0; i < count; i++) {
        soup_body *const body = &bodies[i];
        take_body(&bytes, places, body);
        judged[i] = (tulle_check_body){
            .mesh = {body->positions, body->vertex_count, body->triangles, body->triangle_count},
            .is_obstacle = body->is_obstacle};
    }
    size_t const pair_count = find_pairs(bodies, count, pairs);
    for (int threads = 1; threads <= 2; threads++) {
        tulle_check_result result;
        tulle_error error = {0};
        FUZZ_CHECK_OK(tulle_check_intersections(judged, count, threads, &result, &error), &error);
        FUZZ_CHECK(result.pair_count == pair_count);
        FUZZ_CHECK(pair_count == 0 || memcmp(result.pairs, pairs, pair_count * sizeof *pairs) == 0);
        FUZZ_CHECK(result.tested_pair_count >= pair_count);
        tulle_check_result_destroy(&result);
    }
    check_refusal(judged, count, bodies);
    return 0;
}

void fuzz_make_seeds(void) { fuzz_put_random_seeds(16, 250); }
