/* Topology of random soups against brute force; every allocation failing in turn. */
#include "geom/topology.h"

#include "base/hash.h"
#include "support/failing_heap.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static void make_soup(uint64_t *random, size_t vertex_count, size_t triangle_count,
                      uint32_t *triangles) {
    for (size_t t = 0; t < triangle_count; t++) {
        uint32_t *const corner = triangles + 3 * t;
        do {
            for (int k = 0; k < 3; k++) corner[k] = (uint32_t)(random_next(random) % vertex_count);
        } while (corner[0] == corner[1] || corner[1] == corner[2] || corner[2] == corner[0]);
    }
}

static bool triangle_has(const uint32_t *corner, uint32_t vertex) {
    return corner[0] == vertex || corner[1] == vertex || corner[2] == vertex;
}

static void check_list(const adjacency *lists, size_t vertex, const uint32_t *expected,
                       size_t count) {
    assert_int_equal(lists->begin[vertex + 1] - lists->begin[vertex], count);
    if (count > 0)
        assert_memory_equal(lists->items + lists->begin[vertex], expected,
                            count * sizeof *expected);
}

/* Every pair of vertices in order is looked for in every triangle. */
static void check_edges(const topology *topo, const uint32_t *triangles) {
    size_t edge = 0;
    for (uint32_t a = 0; a < topo->vertex_count; a++) {
        for (uint32_t b = a + 1; b < topo->vertex_count; b++) {
            uint32_t owners[2] = {TULLE_NONE, TULLE_NONE}, opposites[2] = {TULLE_NONE, TULLE_NONE};
            size_t owner_count = 0;
            for (size_t t = 0; t < topo->triangle_count; t++) {
                const uint32_t *const corner = triangles + 3 * t;
                if (!triangle_has(corner, a) || !triangle_has(corner, b)) continue;
                if (owner_count < 2) {
                    owners[owner_count] = (uint32_t)t;
                    for (int k = 0; k < 3; k++)
                        if (corner[k] != a && corner[k] != b) opposites[owner_count] = corner[k];
                }
                owner_count++;
            }
            if (owner_count == 0) continue;
            assert_true(edge < topo->edge_count);
            assert_int_equal(topo->edges[2 * edge], a);
            assert_int_equal(topo->edges[2 * edge + 1], b);
            assert_memory_equal(topo->edge_triangles + 2 * edge, owners, sizeof owners);
            assert_memory_equal(topo->edge_opposites + 2 * edge, opposites, sizeof opposites);
            edge++;
        }
    }
    assert_int_equal(edge, topo->edge_count);
    for (size_t h = 0; h < 3 * topo->triangle_count; h++) {
        const uint32_t *const ends = topo->edges + 2 * (size_t)topo->triangle_edges[h];
        uint32_t const from = triangles[h], to = triangles[h / 3 * 3 + (h + 1) % 3];
        assert_int_equal(ends[0], from < to ? from : to);
        assert_int_equal(ends[1], from < to ? to : from);
    }
}

static void check_vertices(const topology *topo, const uint32_t *triangles) {
    uint32_t *const found = malloc((topo->triangle_count + topo->edge_count + 1) * sizeof *found);
    for (uint32_t v = 0; v < topo->vertex_count; v++) {
        size_t count = 0;
        for (size_t t = 0; t < topo->triangle_count; t++)
            if (triangle_has(triangles + 3 * t, v)) found[count++] = (uint32_t)t;
        check_list(&topo->vertex_triangles, v, found, count);
        count = 0;
        for (size_t e = 0; e < topo->edge_count; e++)
            if (topo->edges[2 * e] == v || topo->edges[2 * e + 1] == v)
                found[count++] = (uint32_t)e;
        check_list(&topo->vertex_edges, v, found, count);
        count = 0;
        for (uint32_t w = 0; w < topo->vertex_count; w++) {
            bool is_neighbour = false;
            for (size_t t = 0; t < topo->triangle_count; t++)
                is_neighbour |= v != w && triangle_has(triangles + 3 * t, v) &&
                                triangle_has(triangles + 3 * t, w);
            if (is_neighbour) found[count++] = w;
        }
        check_list(&topo->vertex_neighbours, v, found, count);
    }
    free(found);
}

static void soups_match_brute_force(void **state) {
    (void)state;
    uint64_t random = 3;
    uint32_t triangles[3 * 64];
    for (int round = 0; round < 300; round++) {
        size_t const vertex_count = 3 + random_next(&random) % 30;
        size_t const triangle_count = random_next(&random) % 64;
        make_soup(&random, vertex_count, triangle_count, triangles);
        memory heap = memory_default();
        topology topo;
        assert_int_equal(topology_build(&heap, triangles, triangle_count, vertex_count, &topo),
                         TULLE_OK);
        assert_int_equal(topo.vertex_count, vertex_count);
        assert_int_equal(topo.triangle_count, triangle_count);
        if (triangle_count > 0)
            assert_memory_equal(topo.triangles, triangles, 3 * triangle_count * sizeof *triangles);
        check_edges(&topo, triangles);
        check_vertices(&topo, triangles);
        topology_destroy(&heap, &topo);
        assert_int_equal(heap.bytes_held, 0);
        assert_null(topo.edges);
    }
}

static void nothing_is_fine(void **state) {
    (void)state;
    memory heap = memory_default();
    topology topo;
    assert_int_equal(topology_build(&heap, NULL, 0, 0, &topo), TULLE_OK);
    assert_int_equal(topo.edge_count, 0);
    assert_int_equal(topo.vertex_edges.begin[0], 0);
    topology_destroy(&heap, &topo);
    topology_destroy(&heap, &topo);
    assert_int_equal(heap.bytes_held, 0);
    assert_int_equal(topology_build(&heap, NULL, (size_t)1 << 40, 3, &topo), TULLE_ERROR_LIMIT);
}

static void every_allocation_may_fail(void **state) {
    (void)state;
    uint64_t random = 5;
    uint32_t triangles[3 * 20];
    make_soup(&random, 12, 20, triangles);
    for (int k = 0;; k++) {
        assert_true(k < 100);
        int left = k;
        memory heap = failing_heap_make(&left);
        topology topo;
        tulle_status const status = topology_build(&heap, triangles, 20, 12, &topo);
        if (status == TULLE_OK) {
            assert_true(k > 10);
            topology_destroy(&heap, &topo);
            assert_int_equal(heap.bytes_held, 0);
            break;
        }
        assert_int_equal(status, TULLE_ERROR_OUT_OF_MEMORY);
        assert_int_equal(heap.bytes_held, 0);
        assert_null(topo.triangles);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(soups_match_brute_force),
        cmocka_unit_test(nothing_is_fine),
        cmocka_unit_test(every_allocation_may_fail),
    };
    return cmocka_run_group_tests_name("geom.topology", tests, NULL, NULL);
}
