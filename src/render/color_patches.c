/* render/color_patches.c - colors of patches so that neighbours differ: a greedy coloring of the
 * graph of patches that share an edge.
 *
 * In: triangles and a label each. Out: a color a triangle.
 *
 * The order is smallest last. The patch with the fewest neighbours left is taken off the graph, and
 * again, until none is left. Patches are colored in the opposite order. Each then has at most as
 * many colored neighbours as it had when it was taken off. In a planar graph these are five at
 * most. The graph of a disc or a sphere is planar when each patch is in one piece. Among the free
 * colors a patch takes the first from a place given by its label. So it keeps its color from frame
 * to frame.
 *
 * Based on: D. W. Matula, L. L. Beck, "Smallest-last ordering and clustering and graph coloring
 * algorithms", 1983. */
#include "render/color_map.h"

#include "base/error.h"
#include "base/sort.h"

#include <stdlib.h>
#include <string.h>

/* A triangle's edge with the triangle's patch. */
typedef struct edge_use {
    uint64_t edge; /* smaller vertex in the upper half */
    uint32_t patch;
} edge_use;

/* Memory of one call. */
typedef struct patch_work {
    size_t triangle_count, patch_count;
    uint32_t *labels;  /* of each patch, ascending */
    uint32_t *patches; /* of each triangle; TULLE_NONE: no patch */
    edge_use *uses;
    size_t use_count;
    ARRAY(uint64_t) pairs; /* neighbouring patches, both ways; the first in the upper half */
    size_t *begin;         /* patch_count + 1: where a patch's pairs begin */
    uint32_t *order;       /* patches, in the order in which they are taken off */
    uint32_t *place;       /* of each patch in `order` */
    uint32_t *degree;      /* neighbours left */
    size_t *bucket;        /* first place in `order` of each degree */
    uint8_t *colors;       /* of each patch */
} patch_work;

enum { NO_COLOR = 255 };

static int compare_u32(const void *a, const void *b) {
    uint32_t const x = *(const uint32_t *)a, y = *(const uint32_t *)b;
    return (x > y) - (x < y);
}

static int compare_uses(const void *a, const void *b) {
    const edge_use *const x = a, *const y = b;
    if (x->edge != y->edge) return x->edge < y->edge ? -1 : 1;
    return (x->patch > y->patch) - (x->patch < y->patch);
}

/* Numbers the labels 0, 1, 2, ... */
static void number_patches(patch_work *work, const uint32_t *labels) {
    size_t const count = work->triangle_count;
    memcpy(work->labels, labels, count * sizeof *labels);
    qsort(work->labels, count, sizeof *labels, compare_u32);
    size_t kept = 0;
    for (size_t i = 0; i < count; i++) {
        uint32_t const label = work->labels[i];
        if (label != 0 && (kept == 0 || work->labels[kept - 1] != label))
            work->labels[kept++] = label;
    }
    work->patch_count = kept;
    for (size_t i = 0; i < count; i++) {
        const uint32_t *const found =
            bsearch(&labels[i], work->labels, kept, sizeof *labels, compare_u32);
        work->patches[i] = found ? (uint32_t)(found - work->labels) : TULLE_NONE;
    }
}

/* Edges with the patches at them, each pair once, sorted. */
static void list_edges(patch_work *work, const uint32_t *triangles) {
    work->use_count = 0;
    for (size_t t = 0; t < work->triangle_count; t++) {
        if (work->patches[t] == TULLE_NONE) continue;
        for (size_t k = 0; k < 3; k++) {
            uint32_t const a = triangles[3 * t + k], b = triangles[3 * t + (k + 1) % 3];
            uint64_t const low = a < b ? a : b, high = a < b ? b : a;
            work->uses[work->use_count++] = (edge_use){low << 32 | high, work->patches[t]};
        }
    }
    qsort(work->uses, work->use_count, sizeof *work->uses, compare_uses);
    size_t kept = 0;
    for (size_t i = 0; i < work->use_count; i++)
        if (kept == 0 || compare_uses(&work->uses[kept - 1], &work->uses[i]) != 0)
            work->uses[kept++] = work->uses[i];
    work->use_count = kept;
}

static bool add_pair(memory *heap, patch_work *work, uint32_t a, uint32_t b) {
    if (!ARRAY_RESERVE(heap, &work->pairs, 2)) return false;
    work->pairs.data[work->pairs.count++] = (uint64_t)a << 32 | b;
    work->pairs.data[work->pairs.count++] = (uint64_t)b << 32 | a;
    return true;
}

static bool find_neighbours(memory *heap, patch_work *work) {
    for (size_t from = 0, to; from < work->use_count; from = to) {
        for (to = from + 1; to < work->use_count && work->uses[to].edge == work->uses[from].edge;)
            to++;
        /* Pairs every patch with every other. Where more patches meet than there are colors, some
         * must look the same; pairs up to the number of colors show that as well. */
        for (size_t i = from; i < to; i++)
            for (size_t k = i + 1; k < to && k <= i + COLOR_PATCH_COUNT; k++)
                if (!add_pair(heap, work, work->uses[i].patch, work->uses[k].patch)) return false;
    }
    if (work->pairs.count == 0) return true;
    qsort(work->pairs.data, work->pairs.count, sizeof *work->pairs.data, compare_u64);
    size_t kept = 1;
    for (size_t i = 1; i < work->pairs.count; i++)
        if (work->pairs.data[i] != work->pairs.data[kept - 1])
            work->pairs.data[kept++] = work->pairs.data[i];
    work->pairs.count = kept;
    return true;
}

static uint32_t get_neighbour(const patch_work *work, size_t pair) {
    return (uint32_t)work->pairs.data[pair];
}

/* Fills begin and degree, and sorts `order` by degree. */
static void start_order(patch_work *work) {
    size_t const count = work->patch_count;
    for (size_t patch = 0, pair = 0; patch <= count; patch++) {
        while (pair < work->pairs.count && work->pairs.data[pair] >> 32 < patch) pair++;
        work->begin[patch] = pair;
    }
    memset(work->bucket, 0, (count + 1) * sizeof *work->bucket);
    for (size_t patch = 0; patch < count; patch++) {
        work->degree[patch] = (uint32_t)(work->begin[patch + 1] - work->begin[patch]);
        work->bucket[work->degree[patch] + 1]++;
    }
    for (size_t degree = 0; degree < count; degree++)
        work->bucket[degree + 1] += work->bucket[degree];
    for (size_t patch = 0; patch < count; patch++) {
        size_t const at = work->bucket[work->degree[patch]]++;
        work->order[at] = (uint32_t)patch;
        work->place[patch] = (uint32_t)at;
    }
    for (size_t degree = count; degree > 0; degree--)
        work->bucket[degree] = work->bucket[degree - 1];
    work->bucket[0] = 0;
}

/* Moves a patch to the group of one neighbour less: swaps it with the first of its own group. */
static void lower_degree(patch_work *work, uint32_t patch) {
    uint32_t const degree = work->degree[patch];
    size_t const first = work->bucket[degree]++, at = work->place[patch];
    uint32_t const other = work->order[first];
    work->order[first] = patch;
    work->order[at] = other;
    work->place[patch] = (uint32_t)first;
    work->place[other] = (uint32_t)at;
    work->degree[patch]--;
}

/* Smallest last: patches up to `at` are off the graph, the others follow in groups of rising
 * degree. A degree is not counted below that of the patch taken off last, which changes no order
 * that matters: such a patch may go next as well as any. */
static void compute_order(patch_work *work) {
    start_order(work);
    for (size_t at = 0; at < work->patch_count; at++) {
        uint32_t const patch = work->order[at];
        for (size_t pair = work->begin[patch]; pair < work->begin[patch + 1]; pair++) {
            uint32_t const other = get_neighbour(work, pair);
            if (work->degree[other] > work->degree[patch]) lower_degree(work, other);
        }
    }
}

/* Spreads consecutive labels over the palette: 7 steps of 12 visit every color. */
static uint32_t get_first_choice(uint32_t label) {
    return (uint32_t)((uint64_t)label * 7 % COLOR_PATCH_COUNT);
}

/* Gives colors from the last taken off to the first; returns the number of alike neighbours. */
static size_t give_colors(patch_work *work) {
    size_t alike = 0;
    memset(work->colors, NO_COLOR, work->patch_count);
    for (size_t at = work->patch_count; at-- > 0;) {
        uint32_t const patch = work->order[at];
        uint32_t uses[COLOR_PATCH_COUNT] = {0};
        for (size_t pair = work->begin[patch]; pair < work->begin[patch + 1]; pair++) {
            uint8_t const color = work->colors[get_neighbour(work, pair)];
            if (color != NO_COLOR) uses[color]++;
        }
        uint32_t const first = get_first_choice(work->labels[patch]);
        uint32_t best = first;
        for (uint32_t i = 1; i < COLOR_PATCH_COUNT && uses[best] > 0; i++) {
            uint32_t const color = (first + i) % COLOR_PATCH_COUNT;
            if (uses[color] < uses[best]) best = color;
        }
        alike += uses[best];
        work->colors[patch] = (uint8_t)best;
    }
    return alike;
}

static void release_work(memory *heap, patch_work *work) {
    size_t const count = work->triangle_count;
    memory_release(heap, work->labels, count * sizeof *work->labels);
    memory_release(heap, work->patches, count * sizeof *work->patches);
    memory_release(heap, work->uses, 3 * count * sizeof *work->uses);
    memory_release(heap, work->begin, (count + 1) * sizeof *work->begin);
    memory_release(heap, work->order, count * sizeof *work->order);
    memory_release(heap, work->place, count * sizeof *work->place);
    memory_release(heap, work->degree, count * sizeof *work->degree);
    memory_release(heap, work->bucket, (count + 2) * sizeof *work->bucket);
    memory_release(heap, work->colors, count * sizeof *work->colors);
    ARRAY_FREE(heap, &work->pairs);
}

static bool allocate_work(memory *heap, size_t count, patch_work *work) {
    *work = (patch_work){.triangle_count = count};
    work->labels = memory_allocate(heap, count * sizeof *work->labels);
    work->patches = memory_allocate(heap, count * sizeof *work->patches);
    work->uses = memory_allocate(heap, 3 * count * sizeof *work->uses);
    work->begin = memory_allocate(heap, (count + 1) * sizeof *work->begin);
    work->order = memory_allocate(heap, count * sizeof *work->order);
    work->place = memory_allocate(heap, count * sizeof *work->place);
    work->degree = memory_allocate(heap, count * sizeof *work->degree);
    work->bucket = memory_allocate(heap, (count + 2) * sizeof *work->bucket);
    work->colors = memory_allocate(heap, count * sizeof *work->colors);
    return work->labels && work->patches && work->uses && work->begin && work->order &&
           work->place && work->degree && work->bucket && work->colors;
}

tulle_status color_patches(memory *heap, tulle_mesh_view mesh, const uint32_t *labels,
                           float *triangle_colors, size_t *alike_count, tulle_error *error) {
    if (alike_count) *alike_count = 0;
    if (mesh.triangle_count == 0) return TULLE_OK;
    if (mesh.triangle_count > (size_t)1 << 30)
        return error_set(error, TULLE_ERROR_LIMIT, "%zu triangles are more than 2^30 to color",
                         mesh.triangle_count);
    patch_work work;
    bool is_fine = allocate_work(heap, mesh.triangle_count, &work);
    if (is_fine) {
        number_patches(&work, labels);
        list_edges(&work, mesh.triangles);
        is_fine = find_neighbours(heap, &work);
    }
    if (is_fine) {
        compute_order(&work);
        size_t const alike = give_colors(&work);
        if (alike_count) *alike_count = alike;
        for (size_t t = 0; t < mesh.triangle_count; t++) {
            uint32_t const patch = work.patches[t];
            color_map_patch(patch == TULLE_NONE ? TULLE_NONE : work.colors[patch],
                            triangle_colors + 3 * t);
        }
    }
    release_work(heap, &work);
    return is_fine
               ? TULLE_OK
               : error_set(error, TULLE_ERROR_OUT_OF_MEMORY,
                           "out of memory for the colors of %zu triangles", mesh.triangle_count);
}
