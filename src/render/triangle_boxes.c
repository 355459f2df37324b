/* render/triangle_boxes.c - see triangle_boxes.h. Triangles are sorted along a Morton curve through
 * their middles; every box halves its stretch of the curve. */
#include "render/triangle_boxes.h"

#include <stdlib.h>

enum {
    LEAF_SIZE = 4,   /* triangles at most */
    MORTON_BITS = 20 /* of each axis: a millionth of the extent apart */
};

typedef struct sorted_triangle {
    uint64_t key;
    uint32_t triangle;
} sorted_triangle;

static int compare_triangles(const void *left, const void *right) {
    const sorted_triangle *const a = left, *const b = right;
    if (a->key != b->key) return a->key < b->key ? -1 : 1;
    return a->triangle < b->triangle ? -1 : a->triangle > b->triangle;
}

static vec3 fill_all(double value) { return (vec3){value, value, value}; }
static vec3 get_minimum(vec3 a, vec3 b) {
    return (vec3){fmin(a.x, b.x), fmin(a.y, b.y), fmin(a.z, b.z)};
}
static vec3 get_maximum(vec3 a, vec3 b) {
    return (vec3){fmax(a.x, b.x), fmax(a.y, b.y), fmax(a.z, b.z)};
}

static vec3 get_middle(const triangle_source *source, uint32_t triangle) {
    const uint32_t *const corners = source->mesh.triangles + 3 * (size_t)triangle;
    vec3 sum = {0.0, 0.0, 0.0};
    for (size_t k = 0; k < 3; k++)
        sum = vec3_add(sum, vec3_load(source->mesh.positions, corners[k]));
    return vec3_scale(sum, 1.0 / 3.0);
}

/* Bits of a coordinate, 0 .. 1, two places apart. */
static uint64_t spread_bits(double share) {
    uint64_t const value = (uint64_t)(share * (double)((1 << MORTON_BITS) - 1));
    uint64_t spread = 0;
    for (int bit = 0; bit < MORTON_BITS; bit++) spread |= (value >> bit & 1) << 3 * bit;
    return spread;
}

static double get_share(double value, double low, double high) {
    return high > low ? fmin(fmax((value - low) / (high - low), 0.0), 1.0) : 0.0;
}

static void sort_triangles(const triangle_source *source, sorted_triangle *sorted) {
    vec3 low = fill_all((double)INFINITY), high = fill_all(-(double)INFINITY);
    for (size_t i = 0; i < source->count; i++) {
        sorted[i].triangle = source->triangles ? source->triangles[i] : (uint32_t)i;
        vec3 const middle = get_middle(source, sorted[i].triangle);
        low = get_minimum(low, middle);
        high = get_maximum(high, middle);
    }
    for (size_t i = 0; i < source->count; i++) {
        vec3 const middle = get_middle(source, sorted[i].triangle);
        sorted[i].key = spread_bits(get_share(middle.x, low.x, high.x)) |
                        spread_bits(get_share(middle.y, low.y, high.y)) << 1 |
                        spread_bits(get_share(middle.z, low.z, high.z)) << 2;
    }
    qsort(sorted, source->count, sizeof *sorted, compare_triangles);
}

static void fill_leaf(const triangle_source *source, const triangle_boxes *tree,
                      triangle_box *box) {
    box->low = box->rest_low = fill_all((double)INFINITY);
    box->high = box->rest_high = fill_all(-(double)INFINITY);
    const double *const rest = source->rest ? source->rest : source->mesh.positions;
    for (size_t i = 0; i < 3 * (size_t)box->count; i++) {
        uint32_t const triangle = tree->triangles[box->first + i / 3];
        uint32_t const vertex = source->mesh.triangles[3 * (size_t)triangle + i % 3];
        vec3 const now = vec3_load(source->mesh.positions, vertex);
        vec3 const then = vec3_load(rest, vertex);
        box->low = get_minimum(box->low, now);
        box->high = get_maximum(box->high, now);
        box->rest_low = get_minimum(box->rest_low, then);
        box->rest_high = get_maximum(box->rest_high, then);
    }
}

/* Builds the box of the stretch and all below it from *next on; gives its index. */
static uint32_t build_box(const triangle_source *source, const triangle_boxes *tree, uint32_t first,
                          uint32_t count, uint32_t *next) {
    uint32_t const index = (*next)++;
    triangle_box *const box = &tree->boxes[index];
    *box = (triangle_box){.first = first, .count = count};
    if (count <= LEAF_SIZE) {
        fill_leaf(source, tree, box);
        return index;
    }
    uint32_t const left = build_box(source, tree, first, count / 2, next);
    box->right = build_box(source, tree, first + count / 2, count - count / 2, next);
    const triangle_box *const a = &tree->boxes[left], *const b = &tree->boxes[box->right];
    box->low = get_minimum(a->low, b->low);
    box->high = get_maximum(a->high, b->high);
    box->rest_low = get_minimum(a->rest_low, b->rest_low);
    box->rest_high = get_maximum(a->rest_high, b->rest_high);
    return index;
}

bool triangle_boxes_build(arena *scratch, const triangle_source *source, triangle_boxes *tree) {
    tree->triangles = ARENA_NEW(scratch, uint32_t, source->count);
    tree->boxes = ARENA_NEW(scratch, triangle_box, 2 * source->count);
    sorted_triangle *const sorted = ARENA_NEW(scratch, sorted_triangle, source->count);
    if (!tree->triangles || !tree->boxes || !sorted) return false;
    sort_triangles(source, sorted);
    for (size_t i = 0; i < source->count; i++) tree->triangles[i] = sorted[i].triangle;
    uint32_t next = 0;
    build_box(source, tree, 0, (uint32_t)source->count, &next);
    return true;
}

double triangle_box_get_least_distance(vec3 low, vec3 high, vec3 p) {
    double const x = fmax(fmax(low.x - p.x, p.x - high.x), 0.0);
    double const y = fmax(fmax(low.y - p.y, p.y - high.y), 0.0);
    double const z = fmax(fmax(low.z - p.z, p.z - high.z), 0.0);
    return sqrt(x * x + y * y + z * z);
}

double triangle_box_get_most_distance(vec3 low, vec3 high, vec3 p) {
    double const x = fmax(p.x - low.x, high.x - p.x);
    double const y = fmax(p.y - low.y, high.y - p.y);
    double const z = fmax(p.z - low.z, high.z - p.z);
    return sqrt(x * x + y * y + z * z);
}
