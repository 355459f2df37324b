/* detect/tree_boxes.c - boxes of moving vertices, edges, triangles, leaves and nodes.
 *
 * The box of a vertex holds its path widened by margin / 2; boxes of edges, triangles and nodes are
 * unions of those, so every method sees the same feature boxes bit for bit. Work is cut into tasks
 * of fixed size; each writes its own boxes only. */
#include "base/parallel.h"
#include "detect/broad_phase_parts.h"

#include <math.h>

enum {
    VERTICES_PER_TASK = 2048, /* some 20 microseconds */
    LEAVES_PER_TASK = 128     /* some 20 microseconds */
};

/* Rounding of (x - origin) * scale - margin / 2, relative to the magnitude of its parts: four
 * roundings of 2^-53 and some room. */
#define FRAME_ROUNDING 1e-15
/* Twice the rounding of a conversion to float, so that it ends outside; and where floats are
 * denormal. */
#define FLOAT_ROUNDING 0x1.0p-23
#define FLOAT_UNDERFLOW 0x1.0p-140
/* Box coordinates beyond this are moved to it, in order, so comparisons stay conservative. */
#define MOST_COORDINATE 3e38

bool choose_box_frame(broad_phase *broad, const double *rest) {
    double low[3] = {0.0, 0.0, 0.0}, high[3] = {0.0, 0.0, 0.0}, extent = 0.0;
    for (size_t i = 0; i < broad->vertex_count; i++)
        for (int k = 0; k < 3; k++) {
            double const x = rest[3 * i + (size_t)k];
            if (!isfinite(x)) return false;
            if (i == 0 || x < low[k]) low[k] = x;
            if (i == 0 || x > high[k]) high[k] = x;
        }
    for (int k = 0; k < 3; k++) {
        broad->origin[k] = 0.5 * low[k] + 0.5 * high[k];
        extent = fmax(extent, 0.5 * high[k] - 0.5 * low[k]);
    }
    int exponent = 0;
    if (extent > 0.0) frexp(extent, &exponent);
    if (exponent < -1000) exponent = -1000;
    broad->scale = ldexp(1.0, -exponent);
    return true;
}

static double clamp_coordinate(double x) {
    return x > MOST_COORDINATE ? MOST_COORDINATE : x < -MOST_COORDINATE ? -MOST_COORDINATE : x;
}

/* One axis of a vertex's box; half: half the margin in box coordinates. */
static void fit_interval(double a, double b, double half, float *low, float *high) {
    double const least = (a < b ? a : b) - half, most = (a < b ? b : a) + half;
    double const larger = fabs(a) > fabs(b) ? fabs(a) : fabs(b);
    double const rounding = FRAME_ROUNDING * (larger + half) + FLOAT_UNDERFLOW;
    *low = (float)clamp_coordinate(least - (FLOAT_ROUNDING * fabs(least) + rounding));
    *high = (float)clamp_coordinate(most + (FLOAT_ROUNDING * fabs(most) + rounding));
}

typedef struct fit_context {
    broad_phase *broad;
    const surface_set *set;
    const double *x0, *x1;
} fit_context;

static void fit_vertex_task(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)begin, (void)end, (void)worker;
    const fit_context *const fit = context;
    broad_phase *const broad = fit->broad;
    fit_task *const task = &broad->fit_tasks[chunk];
    double const half = 0.5 * broad->margin * broad->scale;
    double doubt = 0.0; /* becomes NaN with the first value that is not finite */
    for (size_t i = task->begin; i < task->end; i++) {
        tree_box *const box = &broad->vertex_boxes[i];
        vertex_record *const record = &broad->records[i];
        for (size_t k = 0; k < 3; k++) {
            record->start[k] = fit->x0[3 * i + k];
            record->end[k] = fit->x1[3 * i + k];
            double const a = (record->start[k] - broad->origin[k]) * broad->scale;
            double const b = (record->end[k] - broad->origin[k]) * broad->scale;
            doubt += (a - a) + (b - b);
            fit_interval(a, b, half, &box->low[k], &box->high[k]);
        }
        record->start[3] = record->end[3] = 0.0;
        box->low[3] = box->high[3] = 0.0F;
    }
    task->is_finite = doubt == 0.0;
}

/* Cuts begin .. end - 1 into tasks. */
static size_t append_tasks(broad_phase *broad, size_t count, uint32_t surface, uint32_t begin,
                           uint32_t end, uint32_t size) {
    for (uint32_t at = begin; at<end; at = end - at> size ? at + size : end)
        broad->fit_tasks[count++] =
            (fit_task){.surface = surface, .begin = at, .end = end - at > size ? at + size : end};
    return count;
}

bool fit_vertex_boxes(broad_phase *broad, const surface_set *set, const double *x0,
                      const double *x1, int threads) {
    size_t task_count = 0;
    for (uint32_t s = 0; s < set->surface_count; s++) {
        const surface_range *const range = &set->surfaces[s];
        if (range->is_present && !broad->trees[s].is_fitted)
            task_count = append_tasks(broad, task_count, s, range->vertex_begin, range->vertex_end,
                                      VERTICES_PER_TASK);
    }
    fit_context context = {.broad = broad, .set = set, .x0 = x0, .x1 = x1};
    parallel_for(task_count, 1, threads, fit_vertex_task, &context);
    bool is_finite = true;
    for (size_t i = 0; i < task_count; i++) is_finite = is_finite && broad->fit_tasks[i].is_finite;
    return is_finite;
}

tree_box find_triangle_box(const broad_phase *broad, const topology *topo, uint32_t triangle) {
    const uint32_t *const corners = topo->triangles + 3 * (size_t)triangle;
    tree_box box = broad->vertex_boxes[corners[0]];
    box_include(&box, &broad->vertex_boxes[corners[1]]);
    box_include(&box, &broad->vertex_boxes[corners[2]]);
    return box;
}

static void assign_slot(slot_list *list, uint32_t slot, uint32_t feature, const uint32_t *corners) {
    list->features[slot] = feature;
    for (uint32_t k = 0; k < list->corner_count; k++)
        list->corners[list->corner_count * (size_t)slot + k] = corners[k];
}

/* A triangle brings the vertices and edges of which it is the lowest triangle. */
static void assign_triangle(broad_phase *broad, const topology *topo, uint32_t triangle,
                            tree_leaf *leaf) {
    const uint32_t *const corners = topo->triangles + 3 * (size_t)triangle;
    assign_slot(&broad->triangles, leaf->triangle_end++, triangle, corners);
    for (int k = 0; k < 3; k++) {
        uint32_t const vertex = corners[k];
        const adjacency *const triangles = &topo->vertex_triangles;
        if (triangles->items[triangles->begin[vertex]] == triangle)
            assign_slot(&broad->vertices, leaf->vertex_end++, vertex, &vertex);
        uint32_t const edge = topo->triangle_edges[3 * (size_t)triangle + (size_t)k];
        if (topo->edge_triangles[2 * (size_t)edge] == triangle)
            assign_slot(&broad->edges, leaf->edge_end++, edge, topo->edges + 2 * (size_t)edge);
    }
}

void assign_slots(broad_phase *broad, const surface_set *set, uint32_t surface) {
    const surface_range *const range = &set->surfaces[surface];
    const surface_tree *const tree = &broad->trees[surface];
    tree_leaf at = {.triangle_end = range->triangle_begin,
                    .vertex_end = range->vertex_begin,
                    .edge_end = range->edge_begin};
    for (uint32_t l = 0; l < tree->leaf_count; l++) {
        tree_leaf *const leaf = &broad->leaves[tree->leaf_begin + l];
        uint32_t const begin = leaf->triangle_begin, end = leaf->triangle_end;
        at.triangle_begin = at.triangle_end;
        at.vertex_begin = at.vertex_end;
        at.edge_begin = at.edge_end;
        for (uint32_t slot = begin; slot < end; slot++)
            assign_triangle(broad, set->topo, broad->triangles.features[slot], &at);
        *leaf = at;
    }
}

/* Boxes of slots begin .. end - 1, which `box` is widened to hold. */
static void fit_slots(const broad_phase *broad, slot_list *list, uint32_t begin, uint32_t end,
                      tree_box *box) {
    uint32_t const corner_count = list->corner_count;
    for (size_t slot = begin; slot < end; slot++) {
        const uint32_t *const corners = list->corners + corner_count * slot;
        tree_box slot_box = broad->vertex_boxes[corners[0]];
        for (uint32_t k = 1; k < corner_count; k++)
            box_include(&slot_box, &broad->vertex_boxes[corners[k]]);
        for (int k = 0; k < 3; k++) {
            list->sides[k][slot] = slot_box.low[k];
            list->sides[3 + k][slot] = slot_box.high[k];
        }
        box_include(box, &slot_box);
    }
}

/* Leaf nodes come first in a tree, in the order of its leaves. */
static void fit_leaf_task(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)begin, (void)end, (void)worker;
    const fit_context *const fit = context;
    broad_phase *const broad = fit->broad;
    const fit_task *const task = &broad->fit_tasks[chunk];
    surface_tree *const tree = &broad->trees[task->surface];
    for (uint32_t l = task->begin; l < task->end; l++) {
        const tree_leaf *const leaf = &broad->leaves[tree->leaf_begin + l];
        uint32_t const corner = broad->triangles.corners[3 * (size_t)leaf->triangle_begin];
        tree_box box = broad->vertex_boxes[corner];
        fit_slots(broad, &broad->triangles, leaf->triangle_begin, leaf->triangle_end, &box);
        fit_slots(broad, &broad->vertices, leaf->vertex_begin, leaf->vertex_end, &box);
        fit_slots(broad, &broad->edges, leaf->edge_begin, leaf->edge_end, &box);
        tree->nodes.data[l].box = box;
    }
}

static void fit_inner_nodes(surface_tree *tree) {
    for (size_t i = tree->leaf_count; i < tree->nodes.count; i++) {
        tree_node *const node = &tree->nodes.data[i];
        node->box = tree->nodes.data[node->first].box;
        for (uint32_t c = 1; c < node->child_count; c++)
            box_include(&node->box, &tree->nodes.data[node->first + c].box);
    }
}

static uint32_t find_leaf_label(const broad_phase *broad, const tree_leaf *leaf) {
    const uint32_t *const labels = broad->patches.labels;
    uint32_t const label = labels[broad->triangles.features[leaf->triangle_begin]];
    for (uint32_t slot = leaf->triangle_begin + 1; slot < leaf->triangle_end; slot++)
        if (labels[broad->triangles.features[slot]] != label) return 0;
    return label;
}

void label_trees(broad_phase *broad, const surface_set *set) {
    for (size_t s = 0; s < set->surface_count; s++) {
        surface_tree *const tree = &broad->trees[s];
        for (size_t i = 0; i < tree->nodes.count; i++) {
            tree_node *const node = &tree->nodes.data[i];
            node->label = 0;
            if (!broad->patches.labels) continue;
            if (node->child_count == 0) {
                node->label = find_leaf_label(broad, &broad->leaves[tree->leaf_begin + i]);
                continue;
            }
            uint32_t const label = tree->nodes.data[node->first].label;
            bool is_common = true;
            for (uint32_t c = 1; c < node->child_count; c++)
                is_common = is_common && tree->nodes.data[node->first + c].label == label;
            node->label = is_common ? label : 0;
        }
    }
}

void fit_trees(broad_phase *broad, const surface_set *set, int threads) {
    size_t task_count = 0;
    for (uint32_t s = 0; s < set->surface_count; s++)
        if (set->surfaces[s].is_present && !broad->trees[s].is_fitted)
            task_count =
                append_tasks(broad, task_count, s, 0, broad->trees[s].leaf_count, LEAVES_PER_TASK);
    fit_context context = {.broad = broad, .set = set};
    parallel_for(task_count, 1, threads, fit_leaf_task, &context);
    for (uint32_t s = 0; s < set->surface_count; s++)
        if (set->surfaces[s].is_present && !broad->trees[s].is_fitted) {
            fit_inner_nodes(&broad->trees[s]);
            broad->trees[s].is_fitted = true;
        }
}
