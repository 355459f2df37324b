/* support/patch_judge.c - see patch_judge.h. */
#include "support/patch_judge.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

enum { INSTANTS = 5, EDGES = 3 * OPEN_TRIANGLES };

typedef struct swept_box {
    double low[3], high[3];
} swept_box;

/* A feature of the patch in question. */
typedef struct patch_feature {
    uint32_t index, corners[3];
    int corner_count;
    swept_box box;
} patch_feature;

typedef struct patch_features {
    const open_surface *of;
    double reach;
    uint32_t label;
    patch_feature vertices[OPEN_VERTICES], edges[EDGES], triangles[OPEN_TRIANGLES];
    size_t vertex_count, edge_count, triangle_count;
    patch_verdict *verdict;
} patch_features;

void load_moving_pair(const open_surface *of, const uint32_t vertices[4], moving_pair *pair) {
    for (int i = 0; i < 4; i++) {
        pair->start[i] = vec3_load(of->x0, vertices[i]);
        pair->end[i] = vec3_load(of->x1, vertices[i]);
    }
}

static void set_feature(patch_feature *feature, const open_surface *of, uint32_t index,
                        const uint32_t *corners, int corner_count) {
    feature->index = index;
    feature->corner_count = corner_count;
    for (size_t k = 0; k < 3; k++) feature->box.low[k] = 1e300, feature->box.high[k] = -1e300;
    for (int i = 0; i < corner_count; i++) {
        feature->corners[i] = corners[i];
        for (size_t k = 0; k < 3; k++) {
            double const a = of->x0[3 * (size_t)corners[i] + k];
            double const b = of->x1[3 * (size_t)corners[i] + k];
            feature->box.low[k] = fmin(feature->box.low[k], fmin(a, b));
            feature->box.high[k] = fmax(feature->box.high[k], fmax(a, b));
        }
    }
}

static void collect_patch(patch_features *patch, const uint32_t *labels) {
    static unsigned char has_vertex[OPEN_VERTICES], has_edge[EDGES];
    const open_surface *const of = patch->of;
    memset(has_vertex, 0, sizeof has_vertex);
    memset(has_edge, 0, sizeof has_edge);
    patch->vertex_count = patch->edge_count = patch->triangle_count = 0;
    for (uint32_t t = 0; t < of->triangle_count; t++) {
        if (labels[t] != patch->label) continue;
        const uint32_t *const corners = of->topo.triangles + 3 * (size_t)t;
        set_feature(&patch->triangles[patch->triangle_count++], of, t, corners, 3);
        for (size_t k = 0; k < 3; k++) {
            uint32_t const vertex = corners[k], edge = of->topo.triangle_edges[3 * (size_t)t + k];
            if (!has_vertex[vertex])
                set_feature(&patch->vertices[patch->vertex_count++], of, vertex, &vertex, 1);
            if (!has_edge[edge])
                set_feature(&patch->edges[patch->edge_count++], of, edge,
                            of->topo.edges + 2 * (size_t)edge, 2);
            has_vertex[vertex] = has_edge[edge] = 1;
        }
    }
}

/* Distance of the boxes along the axis where it is most; negative when they meet. */
static double find_box_gap(const swept_box *a, const swept_box *b) {
    double gap = -1e300;
    for (int k = 0; k < 3; k++)
        gap = fmax(gap, fmax(a->low[k] - b->high[k], b->low[k] - a->high[k]));
    return gap;
}

/* Whether `direction` keeps all corners of the first feature on one side of all of the second, by
 * `distance`, over [from, to]: gaps are linear in t. */
static bool separates(feature_kind kind, const moving_pair *pair, vec3 direction, double from,
                      double to, double distance) {
    int const first_count = kind == FEATURE_VERTEX_TRIANGLE ? 1 : 2;
    long double const d[3] = {direction.x, direction.y, direction.z};
    long double const length = sqrtl(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    for (int end = 0; end < 2; end++) {
        long double const t = end == 0 ? from : to;
        long double low = 1e4000L, high = -1e4000L, size = 0.0L;
        for (int i = 0; i < 4; i++) {
            const double *const a = &pair->start[i].x, *const b = &pair->end[i].x;
            long double along = 0.0L;
            for (int k = 0; k < 3; k++) {
                along += d[k] * ((1.0L - t) * a[k] + t * b[k]);
                size += fabsl(d[k]) * (fabsl((long double)a[k]) + fabsl((long double)b[k]));
            }
            if (i < first_count)
                low = fminl(low, along);
            else
                high = fmaxl(high, along);
        }
        if (!(low - high > distance * length * (1.0L + 1e-15L) + 1e-18L * size)) return false;
    }
    return true;
}

static vec3 find_closest_direction(feature_kind kind, const moving_pair *pair, double t,
                                   double *distance) {
    vec3 points[4];
    for (int i = 0; i < 4; i++) points[i] = vec3_lerp(pair->start[i], pair->end[i], t);
    closest_points const closest = closest_of_pair(kind, points);
    *distance = sqrt(closest.distance2);
    return closest.difference;
}

bool is_pair_surely_apart(feature_kind kind, const moving_pair *pair, double distance) {
    double unused;
    for (int part = 0; part < 4; part++) {
        double const from = 0.25 * part, to = from + 0.25;
        bool is_apart = false;
        for (int i = 0; i < 3 && !is_apart; i++) {
            vec3 const direction =
                find_closest_direction(kind, pair, from + 0.125 * (double)i, &unused);
            is_apart = separates(kind, pair, direction, from, to, distance);
        }
        if (!is_apart) return false;
    }
    return true;
}

static bool is_violation(const patch_features *patch, feature_kind kind, const moving_pair *pair) {
    patch->verdict->exact_count++;
    if (exact_pair_touches(kind, pair, 1.0)) return true;
    for (int i = 0; patch->reach > 0.0 && i <= 8; i++)
        if (!exact_pair_is_farther(kind, pair, 0.125 * i, 2.0 * patch->reach)) return true;
    return false;
}

static void judge_pair(const patch_features *patch, feature_kind kind, const patch_feature *a,
                       const patch_feature *b) {
    patch_verdict *const verdict = patch->verdict;
    size_t const count = patch->of->vertex_count;
    patch_pair found = {.kind = kind, .pair = {a->index, b->index}, .label = patch->label};
    int hops = 255;
    for (int i = 0; i < a->corner_count; i++)
        for (int j = 0; j < b->corner_count; j++) {
            int const between = patch->of->hops[a->corners[i] * count + b->corners[j]];
            if (between == 0) return;
            if (between < hops) hops = between;
        }
    verdict->pair_count++;
    for (int i = 0; i < a->corner_count; i++) found.vertices[i] = a->corners[i];
    for (int j = 0; j < b->corner_count; j++) found.vertices[a->corner_count + j] = b->corners[j];
    double const gap = find_box_gap(&a->box, &b->box);
    bool const may_be_near = gap <= 2.0 * patch->reach;
    bool const may_be_nearest = hops >= 3 && gap < verdict->nearest_distance;
    if (!may_be_near && !may_be_nearest) return;
    moving_pair pair;
    load_moving_pair(patch->of, found.vertices, &pair);
    for (int i = 0; may_be_nearest && i < INSTANTS; i++) {
        double const t = (double)i / (double)(INSTANTS - 1);
        double distance;
        (void)find_closest_direction(kind, &pair, t, &distance);
        if (!(distance < verdict->nearest_distance)) continue;
        verdict->nearest_distance = distance;
        verdict->nearest_time = t;
        verdict->nearest = found;
    }
    if (!may_be_near || is_pair_surely_apart(kind, &pair, 2.0 * patch->reach)) return;
    if (!is_violation(patch, kind, &pair)) return;
    if (verdict->violation_count++ == 0) verdict->violation = found;
}

patch_verdict judge_patches(const open_surface *of, const uint32_t *labels, uint32_t label_count,
                            double reach) {
    static patch_features patch;
    patch_verdict verdict = {.nearest_distance = 1e300};
    patch = (patch_features){.of = of, .reach = reach, .verdict = &verdict};
    for (patch.label = 1; patch.label <= label_count; patch.label++) {
        collect_patch(&patch, labels);
        for (size_t i = 0; i < patch.vertex_count; i++)
            for (size_t j = 0; j < patch.triangle_count; j++)
                judge_pair(&patch, FEATURE_VERTEX_TRIANGLE, &patch.vertices[i],
                           &patch.triangles[j]);
        for (size_t i = 0; i < patch.edge_count; i++)
            for (size_t j = i + 1; j < patch.edge_count; j++)
                judge_pair(&patch, FEATURE_EDGE_EDGE, &patch.edges[i], &patch.edges[j]);
    }
    return verdict;
}
