/* support/soup_scene.c - see soup_scene.h. */
#include "support/soup_scene.h"

#include "base/hash.h"

#include <setjmp.h>
#include <stdarg.h>

#include <cmocka.h>

static double signed_random(uint64_t *seed) { return 2.0 * random_uniform(seed) - 1.0; }

static double random_coordinate(soup_shape shape, size_t axis, uint64_t *seed) {
    double const x = signed_random(seed);
    switch (shape) {
    case SOUP_NEEDLES: return axis == 0 ? x : 0.2 * floor(5.0 * x) + 1e-3 * x;
    case SOUP_DUPLICATES: return floor(2.0 * x);
    case SOUP_POINTS: return floor(3.0 * x) * 0.1;
    case SOUP_CLUSTER: return 1e-3 * x * (random_uniform(seed) < 0.02 ? 100.0 : 1.0);
    default: return x;
    }
}

static void add_vertices(soup_scene *to, soup_shape shape, size_t count, size_t side, double motion,
                         uint64_t *seed) {
    double const shift = (double)to->surface_count;
    for (size_t i = 0; i < count; i++) {
        double *const x = to->x0 + 3 * to->vertex_count;
        for (size_t k = 0; k < 3; k++) x[k] = random_coordinate(shape, k, seed) + 0.1 * shift;
        if (shape == SOUP_SHEET) {
            x[0] = (double)(i % (side + 1)) / (double)side + 0.01 * shift;
            x[1] = (double)(i / (side + 1)) / (double)side;
            x[2] = 0.05 * shift;
        }
        for (size_t k = 0; k < 3; k++)
            to->x1[3 * to->vertex_count + k] = x[k] + motion * signed_random(seed);
        to->vertex_count++;
    }
}

static void add_sheet_triangles(soup_scene *to, uint32_t base, uint32_t side) {
    for (uint32_t i = 0; i < 2 * side * side; i++) {
        uint32_t *const corner = to->triangles + 3 * to->triangle_count++;
        uint32_t const row = side + 1, low = base + i / 2 % side + i / 2 / side * row;
        corner[0] = low + (i % 2 ? 1 : 0);
        corner[1] = low + (i % 2 ? row + 1 : 1);
        corner[2] = low + row;
    }
}

/* Puts two corners beside the first. */
static void make_small(soup_scene *to, const uint32_t corner[3], double motion, uint64_t *seed) {
    for (int k = 1; k < 3; k++)
        for (size_t c = 0; c < 3; c++) {
            size_t const at = 3 * (size_t)corner[k] + c;
            to->x0[at] = to->x0[3 * (size_t)corner[0] + c] + 0.05 * signed_random(seed);
            to->x1[at] = to->x0[at] + motion * signed_random(seed);
        }
}

static void add_random_triangle(soup_scene *to, soup_shape shape, uint32_t base, double motion,
                                uint64_t *seed) {
    uint32_t *const corner = to->triangles + 3 * to->triangle_count++;
    uint32_t const count = (uint32_t)to->vertex_count - base;
    uint32_t const choice = shape == SOUP_OVERLAPPING ? count / 4 + 3 : count;
    do
        for (int k = 0; k < 3; k++) corner[k] = base + (uint32_t)(random_next(seed) % choice);
    while (corner[0] == corner[1] || corner[1] == corner[2] || corner[0] == corner[2]);
    if (shape != SOUP_RANDOM) return;
    corner[1] = base + (corner[0] - base + 1) % count;
    corner[2] = base + (corner[0] - base + 2) % count;
    make_small(to, corner, motion, seed);
}

void soup_scene_add(soup_scene *to, soup_shape shape, size_t count, double motion, uint64_t *seed) {
    surface_range *const range = &to->surfaces[to->surface_count++];
    *range = (surface_range){.vertex_begin = (uint32_t)to->vertex_count,
                             .triangle_begin = (uint32_t)to->triangle_count,
                             .is_present = true};
    size_t const side = 1 + (size_t)sqrt((double)count / 2.0);
    size_t const vertex_count = shape == SOUP_SHEET ? (side + 1) * (side + 1) : 3 + 2 * count;
    add_vertices(to, shape, vertex_count, side, motion, seed);
    if (shape == SOUP_SHEET)
        add_sheet_triangles(to, range->vertex_begin, (uint32_t)side);
    else
        for (size_t i = 0; i < count; i++)
            add_random_triangle(to, shape, range->vertex_begin, motion, seed);
    range->vertex_end = (uint32_t)to->vertex_count;
    range->triangle_end = (uint32_t)to->triangle_count;
}

void soup_scene_finish(memory *heap, soup_scene *to) {
    assert_true(to->triangle_count <= MAX_TRIANGLES && to->vertex_count <= MAX_VERTICES);
    assert_int_equal(
        topology_build(heap, to->triangles, to->triangle_count, to->vertex_count, &to->topo),
        TULLE_OK);
    size_t edge = 0;
    for (size_t s = 0; s < to->surface_count; s++) {
        surface_range *const range = &to->surfaces[s];
        range->edge_begin = (uint32_t)edge;
        while (edge < to->topo.edge_count && to->topo.edges[2 * edge] < range->vertex_end) edge++;
        range->edge_end = (uint32_t)edge;
    }
    to->set = (surface_set){
        .topo = &to->topo, .surfaces = to->surfaces, .surface_count = to->surface_count};
}
